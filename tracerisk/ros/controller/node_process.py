"""A program beside the controller in one run, and what its code sees as its own process."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(slots=True, eq=False)
class NodeProcess:
    """A companion: a node of the workspace that runs in the controller's process, for its sake.

    `runtime` (a `Runtime`) holds its own states of the client libraries, `argv` its command line.
    `asked_by` is the stack of the controller's code that last asked it for something, by a call,
    a goal or a message: whoever asked owns what the companion commands. Empty: nobody has.
    """

    name: str
    runtime: Any
    argv: list[str]
    asked_by: tuple[Any, ...] = ()
