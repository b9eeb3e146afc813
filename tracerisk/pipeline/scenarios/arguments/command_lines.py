"""The command lines that a controller's source takes, as far as it can be read without running it.

A number is one that the arm reaches where its name says that it is a place, in the units that the
source says.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from tracerisk.pipeline.scenarios.arguments.argparse_lines import argparse_lines
from tracerisk.pipeline.scenarios.arguments.argv_lines import argv_lines, words_read
from tracerisk.pipeline.scenarios.arguments.command_line import CommandLine
from tracerisk.pipeline.scenarios.arguments.handed_arguments import with_plain_argv
from tracerisk.pipeline.workspace.controller import Controller
from tracerisk.pipeline.workspace.own_modules import own_modules, source_bytes
from tracerisk.ros.drafts.named_numbers import Reach

_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?", re.IGNORECASE)


def command_lines(
    controller: Controller,
    written: Iterable[tuple[tuple[str, ...], str]] = (),
    reach: Reach | None = None,
) -> tuple[CommandLine, ...]:
    """Return command lines that the source takes, the likeliest first.

    Those that the repository writes (`written`, each with its place), then what `argparse` demands,
    a file to read being one of the repository's that fits, then this with each of its switches,
    then the words with which `sys.argv` is compared, and numbers within `reach`.
    """
    lines: list[CommandLine] = []
    numbers: set[int] = set()
    for path in (controller.path.resolve(), *own_modules(controller)):
        source = source_bytes(path)
        tree = controller.project.tree(source)
        if tree is not None:
            tree = with_plain_argv(tree)
            text = source.decode(errors="replace")
            lines += argparse_lines(tree, text, controller.project.top, reach)
            lines += argv_lines(tree, text, reach)
            numbers |= {index for index, word in words_read(tree).items() if word.cast}
    lines = [
        *(CommandLine(words, f"as in {place}") for words, place in written if _has(words, numbers)),
        *lines,
    ]
    return tuple(
        {
            command_line.words: command_line
            for command_line in reversed(lines)
            if command_line.words
        }.values()
    )[::-1]


def _has(words: Sequence[str], numbers: Iterable[int]) -> bool:
    """Return whether a written command line has numbers where the source makes some of its words.

    `move.py X Y Z` names them alone.
    """
    at = [words[index - 1] for index in numbers if index <= len(words)]
    return all(_NUMBER.fullmatch(name) for name in at)
