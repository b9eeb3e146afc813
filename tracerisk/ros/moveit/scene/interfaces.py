"""The planning scene on the graph: who changes it, who asks for it, and who follows it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from tracerisk.ros.graph.graph import Change
from tracerisk.ros.moveit.messages import attached_messages, object_message
from tracerisk.ros.moveit.move_group import MoveGroupServer
from tracerisk.ros.moveit.scene.topics import MONITORED, SceneTopics
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.robot.twin_node import TwinNode

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

# moveit_msgs/PlanningSceneComponents.
_STATE, _ATTACHED, _NAMES, _GEOMETRY = 2, 4, 8, 16


class SceneInterfaces(TwinNode):
    """Takes changes of the planning scene from topics and a service, and reports what is in it."""

    node = "/move_group"

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        super().__init__(runtime, messages)
        self._server = runtime.client(MoveGroupServer)
        changes = self._server.changes
        self._takers = {
            "moveit_msgs/CollisionObject": changes.apply,
            "moveit_msgs/AttachedCollisionObject": changes.apply_attached,
            "moveit_msgs/PlanningScene": changes.apply_scene,
        }
        self._offer("apply_planning_scene", "moveit_msgs/ApplyPlanningScene", self._apply)
        self._offer("get_planning_scene", "moveit_msgs/GetPlanningScene", self._get)
        self._graph.watch(self._on_change)
        SceneTopics(runtime, messages, self._fill)

    def _on_change(self, change: Change, name: str, type_name: str) -> None:
        if name.endswith(f"/{MONITORED}"):
            return  # it says what the scene is
        if change == "advertised" and type_name in self._takers:
            take = self._takers[type_name]
            self._hear(name, type_name, lambda message, _: self._take(take, message))

    def _take(self, take: Callable[[Any], bool], message: Any) -> None:
        with self._server.by_topic():
            take(message)

    def _apply(self, request: Any, answer: Any) -> None:
        answer.success = self._server.changes.apply_scene(request.scene)

    def _get(self, request: Any, answer: Any) -> None:
        # No bits ask for everything.
        self._fill(answer.scene, request.components.components or 0xFFFF)

    def _fill(self, scene: Any, wanted: int) -> None:
        """Write the planning scene into a message, of its components those of the bits."""
        kept = self._server.seen()
        scene.name, scene.robot_model_name = "(noname)", self._server.robot.name
        frame = self._server.planning_frame
        if wanted & (_STATE | _ATTACHED):
            positions = self._server.positions()
            state = scene.robot_state.joint_state
            state.header.frame_id = frame
            state.name, state.position = list(positions), list(positions.values())
        if wanted & _ATTACHED:
            attached = attached_messages(self._messages.new, kept)
            scene.robot_state.attached_collision_objects = attached
        if wanted & (_NAMES | _GEOMETRY):
            new = self._messages.new
            scene.world.collision_objects = [
                object_message(new, item, frame, with_shapes=bool(wanted & _GEOMETRY))
                for _, item in sorted(kept.world.items())
            ]
