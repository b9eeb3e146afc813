"""The planning scene on the graph: its services, and the topics that bring objects."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tracerisk.ros.graph.graph import Change
from tracerisk.ros.moveit.messages import attached_messages, object_message
from tracerisk.ros.moveit.move_group import MoveGroupServer
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.robot.twin_node import TwinNode

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

# moveit_msgs/PlanningSceneComponents.
_STATE, _ATTACHED, _NAMES, _GEOMETRY = 2, 4, 8, 16


class SceneInterfaces(TwinNode):
    """Keeps the planning scene that every client shares by what comes over the graph."""

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
        # As a move_group whose map is empty, for no camera fills it.
        self._offer("clear_octomap", "std_srvs/Empty", lambda *_: None)
        self._graph.watch(self._on_change)

    def _on_change(self, change: Change, name: str, type_name: str) -> None:
        if change == "advertised" and type_name in self._takers:
            take = self._takers[type_name]
            self._hear(name, type_name, lambda message, _: take(message))

    def _apply(self, request: Any, answer: Any) -> None:
        answer.success = self._server.changes.apply_scene(request.scene)

    def _get(self, request: Any, answer: Any) -> None:
        # No bits ask for everything.
        wanted = request.components.components or 0xFFFF
        scene, kept = answer.scene, self._server.scene
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
