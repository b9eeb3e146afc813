"""Verbs with several actions, and what actions write or print."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from pathlib import Path

from tracerisk.adder.sources.write import FileWrite, write_all
from tracerisk.cli.shared.output import is_shown, note
from tracerisk.common.text.printable import escaped
from tracerisk.errors import InputError, Location


def add_actions(
    parser: argparse.ArgumentParser, summaries: Mapping[str, str]
) -> Iterator[tuple[str, argparse.ArgumentParser]]:
    """Add the actions of a verb; yield the name and the parser of each."""
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)
    for name, summary in summaries.items():
        action = actions.add_parser(
            name, help=summary, description=f"{summary[0].upper()}{summary[1:]}."
        )
        # Usage errors are JSON too where that was asked for.
        action.verb = getattr(parser, "verb", None)  # type: ignore[attr-defined]
        yield name, action


def add_output(parser: argparse.ArgumentParser) -> None:
    """Add where the action writes."""
    parser.add_argument(
        "-o", "--output", metavar="FILE", help="output file (default: standard output)"
    )


def deliver(options: argparse.Namespace, text: str, *, is_new: bool = False) -> None:
    """Write a file, or print what would be in it; one that `is_new` takes no other's place."""
    if options.output is not None:
        write(options.output, text, is_new=is_new)
        note(f"{options.output}: written", quiet=options.quiet)
    elif not options.json:
        print(escaped(text) if is_shown() else text, end="")


def write(name: str, text: str, *, is_new: bool = False) -> None:
    """Write a file; raise InputError where one that `is_new` is there already."""
    path = Path(name)
    if is_new and path.exists():
        raise InputError("is there already; give another name, or move it away", Location(name))
    write_all([FileWrite(path, text.encode(errors="backslashreplace"))])
