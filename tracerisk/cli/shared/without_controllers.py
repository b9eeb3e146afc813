"""Report files that were named and that have to do with no controller."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tracerisk.cli.shared.output import note

if TYPE_CHECKING:
    import argparse

_SHOWN = 5


def note_without_controllers(options: argparse.Namespace) -> None:
    """Print a line for each named file without risk blocks on which no controller depends."""
    from tracerisk.pipeline.freshness.known_controllers import without_controllers

    found = without_controllers(options.files)
    for name in found[:_SHOWN]:
        message = "no risk blocks, and no controller depends on it"
        note(f"{name}: {message}; `tracerisk run {name}` writes blocks", quiet=options.quiet)
    if len(found) > _SHOWN:
        note(f"and {len(found) - _SHOWN} more files without blocks", quiet=options.quiet)
