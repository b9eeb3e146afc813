"""What compiled nodes of ROS 2 publish, subscribe to, serve and ask for, as the probe saw it made.

ROS 2 has no master to ask. The frames are those that nodes in Python report
(`ros/live/ros2/hooks.py`).
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator
from typing import Any

_SEND_GOAL = "/_action/send_goal"
_OF_ACTIONS = "/_action/"
_OF_LIBRARY = "/parameter_events"
_SEPARATOR = re.compile(r"::|__")
_TOPICS = {"publisher": "publisher", "subscription": "subscriber"}
"""The ends of topics, by what rcl calls them: what they are to the twin's side."""


class CompiledEnds:
    """Makes frames for the twin's side of the probe's lines; several ends of a name count once."""

    def __init__(self) -> None:
        self._counts: Counter[tuple[str, str, str]] = Counter()
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

    def _of_topic(self, what: str, entry: dict[str, Any]) -> Iterator[dict[str, Any]]:
        name, node = entry["name"], entry["node"]
        if _OF_ACTIONS in name or name == _OF_LIBRARY:
            return
        key = (what, name, node)
        frame: dict[str, Any] = {"name": name, "caller": node}
        if "gone" in entry:
            if self._counts[key] == 0:
                return  # no type was known of it
            self._counts[key] -= 1
            if self._counts[key] == 0:
                yield {"is": f"no_{what}", **frame}
            return
        self._counts[key] += 1
        if self._counts[key] > 1:
            return
        quality: dict[str, Any] = {"takes_latched": bool(entry["kept"])}
        if what == "publisher":
            quality = {
                "quality": {"reliable": bool(entry["reliable"]), "latch": bool(entry["kept"])}
            }
        yield {"is": what, **frame, "type": _type_name(*entry["type"]), **quality}


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
