"""`launch_ros.events`: launch files only name them."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from tracerisk.pipeline.launch_files.stand_ins.launch.events import Event


class ChangeState(Event):
    """A node with a life cycle is to change its state."""

    def __init__(self, *, lifecycle_node_matcher: Any, transition_id: int) -> None:
        self.lifecycle_node_matcher, self.transition_id = lifecycle_node_matcher, transition_id


class StateTransition(Event):
    """A node with a life cycle has changed its state."""

    def __init__(self, *, action: Any = None, msg: Any = None) -> None:
        self.action, self.msg = action, msg


def matches_node_name(node_name: str) -> Any:
    """Return a matcher for the nodes of a name."""
    return lambda action: getattr(action, "node_name", None) == node_name


lifecycle = SimpleNamespace(ChangeState=ChangeState, StateTransition=StateTransition)
matchers = SimpleNamespace(matches_node_name=matches_node_name)
