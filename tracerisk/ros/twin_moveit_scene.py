"""The planning scene on the graph: its two services, and the topics by which objects are told."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from tracerisk.errors import RobotError, one_of
from tracerisk.ros.graph import Change, Publication
from tracerisk.ros.move_group import MoveGroupServer
from tracerisk.ros.path_constraints import message_pose
from tracerisk.ros.planning_scene import SceneObject
from tracerisk.ros.poses import compose
from tracerisk.ros.twin_messages import TwinMessages
from tracerisk.twin.motion import Pose

if TYPE_CHECKING:
    from tracerisk.ros.runtime import Runtime

_NODE = "/move_group"
# moveit_msgs/CollisionObject; the constants are bytes in one ROS and numbers in the other.
_REMOVE, _APPEND, _MOVE = 1, 2, 3
# moveit_msgs/PlanningSceneComponents.
_STATE, _ATTACHED, _NAMES, _GEOMETRY = 2, 4, 8, 16
_SHAPES = ("primitives", "primitive_poses", "meshes", "mesh_poses", "planes", "plane_poses")


class SceneInterfaces:
    """Keeps the planning scene that every client shares by what comes over the graph."""

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        self._server = runtime.client(MoveGroupServer)
        self._graph = runtime.graph
        self._messages = messages
        self._subscribed: set[str] = set()
        self._takers = {
            "moveit_msgs/CollisionObject": self._change,
            "moveit_msgs/AttachedCollisionObject": self._change_attached,
            "moveit_msgs/PlanningScene": self._apply_scene,
        }
        self._graph.offer(
            "apply_planning_scene", "moveit_msgs/ApplyPlanningScene", self._apply, node=_NODE
        )
        self._graph.offer(
            "get_planning_scene", "moveit_msgs/GetPlanningScene", self._get, node=_NODE
        )
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
        answer.success = self._apply_scene(request.scene)
        return answer

    def _apply_scene(self, message: Any) -> bool:
        if not message.is_diff:
            self._server.scene.clear()
        done = [self._change(item) for item in message.world.collision_objects]
        attached = message.robot_state.attached_collision_objects
        done += [self._change_attached(item) for item in attached]
        for color in message.object_colors:
            self._server.scene.colors[color.id] = color
        return all(done)

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
            attached = []
            for _, one in sorted(kept.attached.items()):
                message = self._messages.new("moveit_msgs/AttachedCollisionObject")
                message.link_name, message.touch_links = one.link, list(one.touch_links)
                message.object = self._described(one.object, one.link, with_shapes=True)
                attached.append(message)
            scene.robot_state.attached_collision_objects = attached
        if wanted & (_NAMES | _GEOMETRY):
            scene.world.collision_objects = [
                self._described(item, frame, with_shapes=bool(wanted & _GEOMETRY))
                for _, item in sorted(kept.world.items())
            ]
        return answer

    def _described(self, item: SceneObject, frame: str, *, with_shapes: bool) -> Any:
        message = self._messages.new("moveit_msgs/CollisionObject")
        message.id = item.name
        message.header.frame_id = frame
        p, q = message.pose.position, message.pose.orientation
        p.x, p.y, p.z = item.pose.position
        q.x, q.y, q.z, q.w = item.pose.orientation
        for field in _SHAPES if with_shapes else ():
            setattr(message, field, list(getattr(item.message, field)))
        return message

    def _change(self, message: Any) -> bool:
        scene, operation = self._server.scene, _number(message.operation)
        if operation == _REMOVE:
            return scene.remove(message.id) or self._unknown(message.id, "removed")
        place = self._placed(message)
        if place is None:
            return False
        if operation == _MOVE:
            return scene.move(message.id, place) or self._unknown(message.id, "moved")
        if operation == _APPEND and message.id in scene.world:
            known = scene.world[message.id]
            for field in _SHAPES:
                merged = [*getattr(known.message, field), *getattr(message, field)]
                setattr(known.message, field, merged)
            scene.add(replace(known))
            return True
        scene.add(SceneObject(message.id, place, message))
        return True

    def _change_attached(self, message: Any) -> bool:
        item, scene = message.object, self._server.scene
        if _number(item.operation) == _REMOVE:
            for name, attached in list(scene.attached.items()):
                if item.id in ("", name) and message.link_name in ("", attached.link):
                    self._server.detach(name)
            return True
        if item.primitives or item.meshes or item.planes:
            if not self._change(item):
                return False
        elif item.id in scene.attached:
            self._server.detach(item.id)
        try:
            found = self._server.attach(item.id, message.link_name, list(message.touch_links))
        except RobotError as error:
            self._server.execution.tell("planning_scene", error.message)
            return False
        return found or self._unknown(item.id, "attached")

    def _placed(self, message: Any) -> Pose | None:
        name = message.header.frame_id
        frame = self._server.frame(name)
        if frame is None:
            self._server.execution.tell(
                "planning_scene",
                f"object '{message.id}' is given in the unknown frame '{name}'; "
                f"{one_of(self._server.robot.link_names, name)}",
            )
            return None
        # Objects of the older form have no pose of their own, only their shapes do.
        poses = [*message.primitive_poses, *message.mesh_poses, *message.plane_poses]
        own = message_pose(message.pose)
        is_empty = own == message_pose(type(message.pose)())
        return compose(frame, message_pose(poses[0]) if is_empty and poses else own)

    def _unknown(self, name: str, what: str) -> bool:
        self._server.execution.tell(
            "planning_scene",
            f"object '{name}' cannot be {what}: the planning scene has no such object; "
            f"{one_of(self._server.scene.world, name)}",
        )
        return False


def _number(value: Any) -> int:
    return value[0] if isinstance(value, bytes) else int(value)
