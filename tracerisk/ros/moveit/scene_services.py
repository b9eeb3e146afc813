"""The planning scene on the graph: its services, and the topics that bring objects."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tracerisk.ros.graph.graph import Change, Publication
from tracerisk.ros.moveit.messages import attached_messages, object_message
from tracerisk.ros.moveit.move_group import MoveGroupServer
from tracerisk.ros.robot.messages import TwinMessages

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

_NODE = "/move_group"
# moveit_msgs/PlanningSceneComponents.
_STATE, _ATTACHED, _NAMES, _GEOMETRY = 2, 4, 8, 16


class SceneInterfaces:
    """Keeps the planning scene that every client shares by what comes over the graph."""

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        self._server = runtime.client(MoveGroupServer)
        self._graph = runtime.graph
        self._messages = messages
        self._subscribed: set[str] = set()
        changes = self._server.changes
        self._takers = {
            "moveit_msgs/CollisionObject": changes.apply,
            "moveit_msgs/AttachedCollisionObject": changes.apply_attached,
            "moveit_msgs/PlanningScene": changes.apply_scene,
        }
        self._graph.offer(
            "apply_planning_scene", "moveit_msgs/ApplyPlanningScene", self._apply, node=_NODE
        )
        self._graph.offer(
            "get_planning_scene", "moveit_msgs/GetPlanningScene", self._get, node=_NODE
        )
        self._graph.offer("clear_octomap", "std_srvs/Empty", self._clear_octomap, node=_NODE)
        self._graph.watch(self._on_change)

    def _on_change(self, change: Change, name: str, type_name: str) -> None:
        if change != "advertised" or type_name not in self._takers or name in self._subscribed:
            return
        self._subscribed.add(name)
        take = self._takers[type_name]

        def deliver(message: Any, publication: Publication) -> None:
            del publication
            take(message)

        self._graph.subscribe(name, type_name, deliver, node=_NODE, by_controller=False)

    def _apply(self, request: Any) -> Any:
        answer = self._messages.response("moveit_msgs/ApplyPlanningScene")
        answer.success = self._server.changes.apply_scene(request.scene)
        return answer

    def _clear_octomap(self, request: Any) -> Any:
        """Answer as a move_group whose map is empty, for no camera fills it."""
        del request
        return self._messages.response("std_srvs/Empty")

    def _get(self, request: Any) -> Any:
        answer = self._messages.response("moveit_msgs/GetPlanningScene")
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
        return answer
