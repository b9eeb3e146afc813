"""What the controller asks of its cell: calls, messages and goals to anything but the arm.

The robot's own interfaces are left out, for what they bring about is seen in the arm; so is what a
controller sends to itself, what is only shown, and what a node started beside it sends.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from statistics import median
from typing import Any

from tracerisk.ros.graph.action_goal import ActionGoal, GoalState
from tracerisk.ros.graph.graph import Graph
from tracerisk.ros.graph.services import ServiceServer
from tracerisk.ros.graph.topic_ends import Publication, Subscription
from tracerisk.ros.messages.fields import fields_of

_SHOWN = re.compile(
    r"(visualization_msgs|rosgraph_msgs|rcl_interfaces|diagnostic_msgs|tf2_msgs|bond)/"
    r"|moveit_msgs/Display|rviz"
)
# Services of a robot's driver that switch something other than the arm.
_SWITCHES = re.compile(
    r"(^|[/_])(io|ios|digital|analog|gpio|outputs?|relay|vacuum|suction)([/_]|$)"
)
_MOST_KEPT = 200
"""Messages of one topic that are kept one by one; more of them are a stream."""
_LEAST_OF_STREAM = 8
_SLOWEST_NS = 1_050_000_000
"""The period of a stream at most: what comes more slowly may come once a cycle of the mission."""
_SAME_PERIOD, _MOST_OF_PERIODS = 0.2, 0.8
_MOST_TEXT = 120
_FIGURE = re.compile(r"-?\d+\.\d+")


@dataclass(slots=True, eq=False)
class _Use:
    """One call, message or goal to the cell."""

    time_ns: int
    """The simulated time at which it was sent [ns]."""
    kind: str
    """`call`, `message` or `goal`."""
    interface: str
    """The full name of the service, topic or action."""
    content: str
    """The content as short text."""
    succeeded: bool = True
    """Whether a call succeeded; True for all others."""
    goal: ActionGoal | None = None
    """The goal, whose state is read at the end; `None` for all others."""

    @property
    def went_well(self) -> bool:
        return self.succeeded if self.goal is None else self.goal.state is GoalState.SUCCEEDED


@dataclass(slots=True, eq=False)
class CellLog:
    """Collects what is sent to the cell: the `cell` of a `Graph`."""

    graph: Graph
    """The graph whose messages, calls and goals are logged."""
    take: Callable[[str, Any], None] | None = None
    """Called with the name and content of each message, call and goal, the robot's own too."""
    _uses: list[_Use] = field(default_factory=list)
    """The logged uses, in order."""
    _times: dict[str, list[int]] = field(default_factory=dict)
    """The times of the messages on a topic [ns], by topic."""

    def __post_init__(self) -> None:
        self.graph.cell = self

    def published(
        self, publication: Publication, receivers: Sequence[Subscription], message: Any
    ) -> None:
        """Take a message of the controller."""
        self._ask(publication.topic, message)
        if _SHOWN.search(publication.type_name):
            return
        receivers = [receiver for receiver in receivers if not receiver.is_assumed]
        if any(not receiver.by_controller for receiver in receivers):
            return  # the arm's own
        if receivers and all(receiver.process is None for receiver in receivers):
            return  # it hears itself
        self._add("message", publication.topic, message)

    def called(self, server: ServiceServer, request: Any) -> Callable[[Any], None] | None:
        """Take a call; return what is to be called with the response, or with None for none."""
        self._ask(server.name, request)
        is_driver = not server.is_callback and not server.is_scenario
        if is_driver and not _SWITCHES.search(server.name):
            return None
        if server.is_callback and server.process is None:
            return None
        use = self._add("call", server.name, request)
        return None if use is None else lambda response: _answered(use, response)

    def sent(self, goal: ActionGoal) -> None:
        """Take a goal of the controller."""
        self._ask(goal.client.name, goal.message)
        server = goal.server
        if server is not None and not server.is_scenario and not server.is_companions:
            return
        use = self._add("goal", goal.client.name, goal.message)
        if use is not None:
            use.goal = goal

    def note(self) -> dict[str, Any]:
        """Return the uses in order, each as a list, and the topics that had a steady stream."""
        streams = {name for name, times in self._times.items() if _is_stream(times)}
        uses = [
            [use.time_ns, use.kind, use.interface, use.content, use.went_well]
            for use in self._uses
            if use.interface not in streams
        ]
        return {"uses": uses, "streams": sorted(streams)}

    def _ask(self, name: str, message: Any) -> None:
        if self.take is not None:
            self.take(name, message)

    def _add(self, kind: str, interface: str, message: Any) -> _Use | None:
        now_ns = self.graph.scheduler.now_ns
        times = self._times.setdefault(interface, [])
        if kind == "message":
            times.append(now_ns)
        if kind == "message" and len(times) > _MOST_KEPT:
            return None
        use = _Use(now_ns, kind, interface, content_text(message))
        self._uses.append(use)
        return use


def _answered(use: _Use, response: Any) -> None:
    use.succeeded = response is not None and getattr(response, "success", True) is not False


def _is_stream(times: Sequence[int]) -> bool:
    """Return whether messages came at a steady rate, so that their number is only their time."""
    if len(times) > _MOST_KEPT:
        return True
    gaps = [later - earlier for earlier, later in pairwise(times)]
    if len(times) < _LEAST_OF_STREAM or not 0 < (period := median(gaps)) <= _SLOWEST_NS:
        return False
    steady = sum(1 for gap in gaps if abs(gap - period) <= _SAME_PERIOD * period)
    return steady >= _MOST_OF_PERIODS * len(gaps)


def content_text(message: Any) -> str:
    """Return the fields of a message that differ from 0, false and empty, as short text.

    Stamps and headers are left out, whole numbers are exact, others have 4 significant digits, and
    figures with a decimal point within text, which are mostly measured, become `#`.
    """
    text = " ".join(_parts(message, ""))
    return text if len(text) <= _MOST_TEXT else text[: _MOST_TEXT - 3] + "..."


def _parts(value: Any, name: str) -> Iterator[str]:
    if name.rpartition(".")[2] in ("header", "stamp"):
        return
    if hasattr(type(value), "_fields") or hasattr(type(value), "_ros_fields"):
        for part in fields_of(type(value)):
            inner = f"{name}.{part.name}" if name else part.name
            yield from _parts(getattr(value, part.name), inner)
        return
    text = _plain(value)
    if text:
        yield f"{name}={text}"


def _plain(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else ""
    if isinstance(value, int):
        return str(value) if value else ""
    if isinstance(value, float):
        return _figure(value) if value else ""
    if isinstance(value, str):
        return repr(_FIGURE.sub("#", value)) if value else ""
    if isinstance(value, bytes | bytearray):
        return f"{len(value)} bytes" if value else ""
    if hasattr(value, "__iter__"):
        return _listed(value)
    return ""


def _figure(value: float) -> str:
    """Return a number so that it is seen not to be a whole one: `2.0`."""
    text = f"{value:.4g}"
    return text if any(sign in text for sign in ".en") else f"{text}.0"


def _listed(values: Iterable[Any]) -> str:
    shown = []
    for number, value in enumerate(values):
        if number >= _LISTED:
            shown.append("...")
            break
        shown.append(_plain(value) or "{" + " ".join(_parts(value, "")) + "}")
    return f"[{', '.join(text if text != '{}' else '0' for text in shown)}]" if shown else ""


_LISTED = 8
