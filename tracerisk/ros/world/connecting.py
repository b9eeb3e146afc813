"""How long two ends of a name need to find each other, and what was sent before they had."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from tracerisk.errors import Location
from tracerisk.ros.distributions.in_run import DistroRules

EndKind = Literal["publisher", "subscriber", "service client", "action client", "planning scene"]
"""What the controller has made, and what it sends or hears by it."""

Work = Literal["import", "end", "action client"]
"""What a program does between its first node and what it sends: the import of a message package,
the making of a publisher, subscription or service client, and of an action client."""

_TAKES_S: dict[Work, float] = {"import": 0.004, "end": 0.001, "action client": 0.013}
"""How long it takes where the code of its message types is loaded, [s]: the processor time of rclpy
7.1.3 on Cyclone DDS, of four runs the middle one, or the least of an action client. rospy 1.15
needs less than 0.002 s for any of them, which is nothing beside its connections."""


@dataclass(frozen=True, slots=True)
class ConnectionTimes:
    """How long the ends of a controller need to find the others, in one distribution of ROS.

    Without a value all ends are connected at once.
    """

    publisher_s: float = 0.0
    """From the making of a publisher or action client to its connection with the cell, [s]."""
    subscriber_s: float = 0.0
    """The same of a subscriber, and of two ends of the controller's own, [s]."""
    is_by_process: bool = False
    """Whether the time counts from the first node of a process, and within one is none at all:
    processes find each other, and know each other's ends from then on (ROS 2)."""

    @classmethod
    def of(cls, distro: DistroRules) -> ConnectionTimes:
        """Return the times of a distribution."""
        return cls(
            _seconds(distro, "publisher-connects-after"),
            _seconds(distro, "subscriber-connects-after"),
            distro.value("connection-counts-from") == "the first node of the process",
        )

    def seconds(self, kind: EndKind) -> float:
        """Return how long an end of a kind needs, [s]."""
        if kind == "service client" and not self.is_by_process:
            return 0.0  # the master knows every service
        return self.subscriber_s if kind == "subscriber" else self.publisher_s

    def takes_s(self, work: Work) -> float:
        """Return how long a program needs for some work, as far as that matters, [s]."""
        return _TAKES_S[work] if self.is_by_process else 0.0

    def remedy(self, kind: EndKind) -> str:
        """Return what a program does that sends nothing too early."""
        if kind == "publisher" and self.is_by_process:
            return "wait until get_subscription_count() is not 0, or make it TRANSIENT_LOCAL"
        return {
            "publisher": "wait until get_num_connections() is not 0, or latch it",
            "subscriber": "wait for its first message",
            "service client": "call wait_for_service() first",
            "action client": "call wait_for_server() first",
            "planning scene": "make the PlanningSceneInterface with synchronous=True",
        }[kind]


def _seconds(distro: DistroRules, rule: str) -> float:
    value = distro.value(rule)
    assert isinstance(value, float)
    return value


@dataclass(slots=True, eq=False)
class Early:
    """What of the controller's went to an end that it was not connected to yet."""

    what: str
    """What was sent, in words: `a message on /t`, `a goal of /a`."""
    name: str
    """The topic, service or action."""
    place: Location | None
    """Where the controller sent it."""
    time_ns: int
    """When, [ns]."""
    last_ns: int
    """When the last time at this place, [ns]."""
    kind: EndKind
    """By what kind of end."""
    is_kept: bool = False
    """Whether it waits for the connection: latched, transient local."""
    content: object = None
    """What was sent last; None for a question whether somebody serves."""
    is_made_good: bool = False
    """Whether it, or what followed it at once, was sent again in time."""

    def words(self, times: ConnectionTimes) -> str:
        """Return in a sentence what happened to it, and what helps."""
        why = "no subscriber was connected yet"
        if self.is_kept:
            return f"{self.what} reached nobody: the run ended before a subscriber was connected"
        if self.kind.endswith("client"):
            why = "the client had not found its server yet"
        return f"{self.what} reached nobody: {why}; {times.remedy(self.kind)}"
