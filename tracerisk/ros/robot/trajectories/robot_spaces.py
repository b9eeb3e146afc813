"""Which robots of the same joints a controller drives, each in a namespace of its own."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

_LEAST = 3  # parts of a name: the namespace, a controller, and what it takes


class RobotSpaces:
    """Looks for joints that are commanded by one controller's name in several namespaces.

    They are joints of several robots, and the twin is one.
    """

    def __init__(self, runtime: Runtime | None = None) -> None:
        del runtime
        self._spaces: dict[tuple[str, frozenset[str]], str] = {}
        self._noted: set[str] = set()

    def other(self, name: str, joints: Iterable[str]) -> str:
        """Return words for the first command in one more namespace, empty for none."""
        space, *rest = name.strip("/").split("/")
        if 1 + len(rest) < _LEAST:
            return ""
        first = self._spaces.setdefault(("/".join(rest), frozenset(joints)), space)
        if first == space or space in self._noted:
            return ""
        self._noted.add(space)
        return (
            f"the controller commands the same joints in the namespaces '/{first}' and '/{space}': "
            "the twin is one robot, which both move"
        )
