"""The control flow of a run: what stands for a command, whatever functions the code has."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence

from tracerisk.instrument.commands import Command

_LENGTH = 12


def key_of(command: Command) -> str:
    """Return what stands for a command of a recording."""
    return flow_key(command.kind, command.elements, [frame.site for frame in command.stack])


def flow_key(kind: str, elements: Sequence[str], sites: Iterable[Sequence[int]]) -> str:
    """Return what stands for a command: its kind, what it addresses, and who issued it.

    `sites` are the line and column of each call on its stack, outermost first.
    """
    text = repr((kind, tuple(elements), [tuple(site) for site in sites]))
    return hashlib.sha256(text.encode()).hexdigest()[:_LENGTH]
