"""A command line of a controller, and whether a run ended for want of one."""

from __future__ import annotations

import ast
import re
from dataclasses import dataclass
from typing import Any

from tracerisk.errors import TraceRiskError
from tracerisk.instrument.source.literals.named_literals import literal_value
from tracerisk.pipeline.workspace.controller import Controller
from tracerisk.trace import RunEnd

NUMBERS = ("float", "int")
"""The types of words that are numbers."""
_OF_ARGUMENTS = re.compile(r"arg")


@dataclass(frozen=True, slots=True)
class CommandLine:
    """Arguments with which a controller may be started."""

    words: tuple[str, ...]
    """The arguments, without the program."""
    remark: str
    """Where they are from, in words."""


def reads_arguments(controller: Controller, end: RunEnd) -> bool:
    """Return whether a run was ended by an exception for want of arguments.

    It is at a line that reads the command line, or of None in a source that reads options.
    """
    place = end.location
    if end.cause != "raised" or place is None or place.line is None:
        return False
    if not place.file.endswith(".py"):
        return False
    try:
        text = controller.source_of(place.file).decode(errors="replace")
    except TraceRiskError:
        return False
    if "NoneType" in end.message and "add_argument" in text:
        # An option of argparse that is not given is None, wherever that is used.
        return True
    lines = text.splitlines()
    return any(_OF_ARGUMENTS.search(line) for line in lines[place.line - 1 : place.line])


def number_word(number: float, cast: str) -> str:
    """Return a number as a word that `cast`, one of NUMBERS, reads."""
    return str(round(number)) if cast == "int" else f"{number + 0.0:.4g}"


def value_of(node: ast.expr | None) -> Any:
    """Return the value of a literal; None for any other expression, and for none."""
    return None if node is None else literal_value(node)
