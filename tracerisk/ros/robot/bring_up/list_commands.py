"""The commands that list the running system: `rosnode list`, `ros2 topic list` and their like."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from tracerisk.ros.graph.runtime import Runtime
from tracerisk.ros.robot.bring_up.system import SystemState


def _nodes(system: SystemState) -> list[str]:
    return list(system.nodes())


def _topics(system: SystemState) -> list[str]:
    return list(system.topic_names())


def _services(system: SystemState) -> list[str]:
    return [end.topic for end in system.services()]


def _actions(system: SystemState) -> list[str]:
    return [name for name, _ in system.action_names_and_types()]


_LISTS: dict[tuple[str, ...], Callable[[SystemState], list[str]]] = {
    ("rosnode", "list"): _nodes,
    ("rosservice", "list"): _services,
    ("rostopic", "list"): _topics,
    ("ros2", "action", "list"): _actions,
    ("ros2", "node", "list"): _nodes,
    ("ros2", "service", "list"): _services,
    ("ros2", "topic", "list"): _topics,
}


def listing(words: Sequence[str], runtime: Runtime) -> Callable[[], str] | None:
    """Return what makes the lines of a command that lists; `None` for any other command.

    One with options or behind a pipe of the shell is another command.
    """
    names = _LISTS.get(tuple(words))
    if names is None:
        return None
    system = runtime.client(SystemState)
    return lambda: "".join(f"{name}\n" for name in names(system))
