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

    One with options or behind a pipe of the shell is another command, as is one of the ROS that
    the run is not of.
    """
    is_ros2 = words[:1] == ["ros2"]
    names_of = _LISTS.get(tuple(words))
    if names_of is None or is_ros2 != runtime.distro.is_ros2:
        return None

    def answer() -> str:
        runtime.scheduler.touch()
        names = names_of(runtime.client(SystemState))
        return "".join(f"{name}\n" for name in names if not (is_ros2 and _is_hidden(name)))

    return answer


def _is_hidden(name: str) -> bool:
    """Return whether ROS 2 lists a name only where it is asked for hidden ones.

    Source: ros2/ros2cli ros2node/ros2node/api and ros2/rclpy rclpy/topic_or_service_is_hidden.py.
    """
    return "/_" in name
