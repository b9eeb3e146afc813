"""`launch_ros.event_handlers`."""

from __future__ import annotations

from typing import Any

from tracerisk.pipeline.launch_files.stand_ins.launch.event_handlers import EventHandler


class OnStateTransition(EventHandler):
    """When a node with a life cycle has changed its state."""

    def __init__(self, *, entities: Any, target_lifecycle_node: Any = None, **_: Any) -> None:
        super().__init__(entities=entities)
        self.target = target_lifecycle_node
