"""What compiled nodes of ROS 2 publish, subscribe to, serve and ask for, as the probe saw it made.

ROS 2 has no master to ask. The frames are those that nodes in Python report
(`ros/live/ros2/hooks.py`).
"""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator
from typing import Any

_SEND_GOAL = "/_action/send_goal"
_OF_ACTIONS = "/_action/"
_OF_LIBRARY = "/parameter_events"
_SEPARATOR = re.compile(r"::|__")
_TOPICS = {"publisher": "publisher", "subscription": "subscriber"}
"""The ends of topics, by what rcl calls them: what they are to the twin's side."""
_End = tuple[str, str, str]
"""What an end is to the twin's side, its topic and its node."""


class CompiledEnds:
    """Makes frames for the twin's side of the probe's lines; several ends of a name count once."""

    def __init__(self) -> None:
        # How many ends of a topic and node each process has.
        self._counts: defaultdict[_End, Counter[int]] = defaultdict(Counter)
        self.untyped: dict[str, str] = {}
        """The topics, services and actions of which no type is known, and the node of each."""

    def frames(self, entries: Iterable[dict[str, Any]]) -> Iterator[dict[str, Any]]:
        """Yield a frame for each end that a node made first or gave up last."""
        for entry in entries:
            what = entry.get("made") or entry["gone"]
            if entry.get("type") == ["", ""]:
                self.untyped.setdefault(entry["name"].partition(_OF_ACTIONS)[0], entry["node"])
            elif what in _TOPICS:
                yield from self._of_topic(_TOPICS[what], entry)
            elif "made" in entry:
                yield from _of_service(what, entry)

    @property
    def processes(self) -> frozenset[int]:
        """The processes that publish or hear anything."""
        return frozenset(pid for counts in self._counts.values() for pid in +counts)

    def without(self, pids: Iterable[int]) -> Iterator[dict[str, Any]]:
        """Yield a frame for each end that is no more, now that processes have ended.

        One that has crashed, or that its code ends by `_exit`, gives up nothing.
        """
        for pid in pids:
            for end, counts in self._counts.items():
                if counts.pop(pid, 0) and not +counts:
                    yield _given_up(*end)

    def _of_topic(self, what: str, entry: dict[str, Any]) -> Iterator[dict[str, Any]]:
        name, node = entry["name"], entry["node"]
        if _OF_ACTIONS in name or name == _OF_LIBRARY:
            return
        counts = self._counts[what, name, node]
        if "gone" in entry:
            if counts[entry["pid"]] == 0:
                return  # no type was known of it
            counts[entry["pid"]] -= 1
            if not +counts:
                yield _given_up(what, name, node)
            return
        counts[entry["pid"]] += 1
        if counts.total() > 1:
            return
        frame: dict[str, Any] = {"name": name, "caller": node}
        quality: dict[str, Any] = {"takes_latched": bool(entry["kept"])}
        if what == "publisher":
            quality = {
                "quality": {"reliable": bool(entry["reliable"]), "latch": bool(entry["kept"])}
            }
        yield {"is": what, **frame, "type": _type_name(*entry["type"]), **quality}


def _given_up(what: str, name: str, node: str) -> dict[str, Any]:
    return {"is": f"no_{what}", "name": name, "caller": node}


def _of_service(what: str, entry: dict[str, Any]) -> Iterator[dict[str, Any]]:
    name = entry["name"]
    action = name.removesuffix(_SEND_GOAL)
    is_action = action != name
    if _OF_ACTIONS in name and not is_action:
        return
    type_name = _type_name(*entry["type"])
    if is_action and what == "client":
        of = type_name.removesuffix("_SendGoal")
        yield {"is": "action_client", "name": action, "type": of, "caller": entry["node"]}
    elif is_action:
        yield {"is": "acts", "name": action}
    elif what == "client":
        yield {"is": "service_client", "name": name, "type": type_name}
    else:
        yield {"is": "serves", "name": name}


def _type_name(space: str, name: str) -> str:
    """Return `sensor_msgs/JointState` for `sensor_msgs::msg`, or in C `sensor_msgs__msg`."""
    return f"{_SEPARATOR.split(space)[0]}/{name}"
