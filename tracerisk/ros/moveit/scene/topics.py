"""What move_group publishes besides answers: the planning scene, and in ROS 2 the robot's SRDF.

Sources: moveit/moveit and moveit/moveit2 moveit_ros/planning/planning_scene_monitor/src/
planning_scene_monitor.cpp (updates of the state, at most 4 a second); moveit/moveit2
moveit_ros/planning/rdf_loader/src/synchronized_string_parameter.cpp (the SRDF, transient local).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from tracerisk.ros.graph.topic_ends import Subscription
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.robot.twin_node import JOINTS, TwinNode
from tracerisk.twin.urdf.semantic_text import srdf_text

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

_SCENE = "moveit_msgs/PlanningScene"
MONITORED = "monitored_planning_scene"
"""The topic on which move_group says what the scene is, below its name in ROS 1."""
_SCENE_HZ = 4.0
_SEMANTIC = "/robot_description_semantic"
_ALL = 0xFFFF


class SceneTopics(TwinNode):
    """Publishes them; `fill` writes the scene into a message, of its components those of bits."""

    node = "/move_group"

    def __init__(
        self, runtime: Runtime, messages: TwinMessages, fill: Callable[[Any, int], None]
    ) -> None:
        super().__init__(runtime, messages)
        self._fill = fill
        space = "" if messages.is_ros2 else self.node
        sensors = self._reading.named(*JOINTS)
        self._stream(f"{space}/{MONITORED}", _SCENE, _SCENE_HZ, self._scene, sensors, yields=True)
        if messages.is_ros2:
            self._semantic = self._graph.advertise(
                _SEMANTIC,
                "std_msgs/String",
                node=self.node,
                latch=True,
                on_connect=self._on_reader,
                by_controller=False,
            )

    def _scene(self) -> Any:
        message = self._messages.new(_SCENE)
        self._fill(message, _ALL)
        return message

    def _on_reader(self, subscription: Subscription) -> None:
        del subscription
        if self._semantic.latched is None:
            message = self._messages.new("std_msgs/String")
            message.data = srdf_text(self._twin.robot)
            self._semantic.latched = message
