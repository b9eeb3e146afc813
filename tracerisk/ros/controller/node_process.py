"""A program beside the controller in one run, and what its code sees as its own process."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(slots=True, eq=False)
class NodeProcess:
    """A companion: a node of the workspace that runs in the controller's process, for its sake."""

    name: str
    """The name by which messages and threads refer to the companion."""
    runtime: Any
    """Its own `Runtime`, with the state of its client libraries."""
    argv: list[str]
    """Its command line."""
    asked_by: tuple[Any, ...] = ()
    """The stack of the controller's code that last asked it for something and so owns what the
    companion commands; empty before."""
