"""The keys that the description of a driver may have."""

from __future__ import annotations

from collections.abc import Mapping

from tracerisk.ros.vendors.description import EFFECTS, InterfaceKind

TOP = (
    *("driver", "source", "packages", "robot", "node", "group", "tool", "frame", "gripper"),
    "units",
    *("rotation", "while_moving", "codes", "errors", "error_disables", "state", "parameters"),
    *(
        "services",
        "actions",
        "subscribed_topics",
        "published_topics",
        "definitions",
        "frames",
        "joints",
        "of_joints",
        "trajectories",
        "on_error",
        "remedies",
        "common",
    ),
)
"""The keys of a description; `common` holds what its parts share by YAML's anchors."""
GRIPPER = ("name", "closed", "open")
TRAJECTORIES: Mapping[str, tuple[str, str]] = {
    "past_limit": ("missed", "stop"),
    "tolerances": ("kept", "ignored"),
}
"""What a driver may do with trajectories; the first is the default."""
NEEDS = "needs"
"""What of a driver's state must be so for it to carry out trajectories."""
ALONE = ("parameters", "joints", "trajectories")
"""The keys of which one is enough where a driver serves nothing of its own."""
NAMED_JOINTS = ("moves", "note")
CASE = (
    *(*EFFECTS, "when", "stop", "clear", "set", "note", "need", "refuse"),
    *("ignore", "stream", "plan", "execute", "wait", "timeout"),
)
REMEDIES = ("disabled", "in_error", "busy")
"""The outcomes of a motion that is refused, for which a description may say what to do."""
OF_KIND: Mapping[InterfaceKind, tuple[str, ...]] = {
    "services": ("type", "name", "cases", "response", "while_moving", "group", "gripper"),
    "actions": (
        *("type", "name", "cases", "result", "feedback", "rate", "while_moving"),
        *("group", "gripper"),
    ),
    "subscribed_topics": ("type", "name", "cases", "while_moving", "group", "gripper"),
    "published_topics": ("type", "name", "message", "rate", "latch", "group", "gripper"),
}
"""The keys of an interface of each kind, beside those of its only case."""
ANSWER: Mapping[InterfaceKind, str] = {
    "services": "response",
    "actions": "result",
    "published_topics": "message",
}
"""Where an interface of each kind says what it answers."""
