"""The display of a bring-up, RViz: it listens to what is published only to be shown.

Programs wait for it before they send their markers.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from tracerisk.ros.robot.bring_up.system import DISPLAY
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.robot.twin_node import TwinNode

if TYPE_CHECKING:
    from tracerisk.ros.graph.graph import Change
    from tracerisk.ros.graph.runtime import Runtime

_SHOWN = re.compile(r"visualization_msgs/(Interactive)?Marker|moveit_msgs/Display")


class Display(TwinNode):
    """Subscribes to each topic on which the controller publishes something to be shown."""

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        super().__init__(runtime, messages)
        self.node = DISPLAY[messages.is_ros2]
        self._graph.watch(self._on_change)

    def _on_change(self, change: Change, name: str, type_name: str) -> None:
        if change == "advertised" and _SHOWN.match(type_name):
            self._hear(name, type_name, lambda *_: None)
