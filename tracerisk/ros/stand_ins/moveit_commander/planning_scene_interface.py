"""PlanningSceneInterface: the objects of the planning scene."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import Any

from geometry_msgs.msg import Point, Pose
from moveit_msgs.msg import (
    AllowedCollisionEntry,
    AllowedCollisionMatrix,
    AttachedCollisionObject,
    CollisionObject,
    PlanningScene,
    PlanningSceneComponents,
)
from shape_msgs.msg import Mesh, MeshTriangle, Plane, SolidPrimitive

from tracerisk.common.geometry.triangle_mesh import read_triangles
from tracerisk.ros.graph.runtime import current
from tracerisk.ros.moveit.messages import fill_poses
from tracerisk.ros.moveit.scene.planning_scene import SceneObject

from . import conversions
from ._server import report_unknown, server
from .exception import MoveItCommanderException


class PlanningSceneInterface:
    """Add, remove, attach and ask for objects; every client sees the same scene.

    The objects are bodies of the twin, which planning avoids.
    `ns` is taken and changes nothing. A change is in force when the call returns; if `synchronous`
    is False, it is a message on a topic, which who asks at once does not see yet, and which is lost
    right after the interface was made. Earlier releases did so by default: worlds with a discovery
    do, too.
    """

    def __init__(
        self, ns: str = "", synchronous: bool | None = None, service_timeout: float = 5.0
    ) -> None:
        self._server = server()
        self._changing = self._server.by_topic if synchronous is False else nullcontext
        carrier = current().graph.carrier
        is_default = synchronous is None
        self._is_by_topic = synchronous is False or (is_default and carrier.world.has_discovery)
        self._made_ns = carrier.made_ns(by_controller=True)
        carrier.expect(carrier.connected_ns("/collision_object", self._made_ns, "planning scene"))

    # Add

    def add_object(self, collision_object: Any) -> None:
        """Apply a CollisionObject: add, move or remove."""
        self._apply(collision_object)

    def add_box(self, name: str, pose: Any, size: Sequence[float] = (1, 1, 1)) -> None:
        """Add a box with full side lengths [m] at a PoseStamped."""
        self._apply(self.make_box(name, pose, size))

    def add_sphere(self, name: str, pose: Any, radius: float = 1) -> None:
        """Add a sphere."""
        self._apply(self.make_sphere(name, pose, radius))

    def add_cylinder(self, name: str, pose: Any, height: float, radius: float) -> None:
        """Add a cylinder about z."""
        self._apply(self.make_cylinder(name, pose, height, radius))

    def add_cone(self, name: str, pose: Any, height: float, radius: float) -> None:
        """Add a cone about z."""
        self._apply(self.make_cone(name, pose, height, radius))

    def add_plane(
        self, name: str, pose: Any, normal: Sequence[float] = (0, 0, 1), offset: float = 0
    ) -> None:
        """Add a plane."""
        self._apply(self.make_plane(name, pose, normal, offset))

    def add_mesh(
        self, name: str, pose: Any, filename: str, size: Sequence[float] = (1, 1, 1)
    ) -> None:
        """Add a mesh from an STL or OBJ file, scaled by `size`."""
        self._apply(self.make_mesh(name, pose, filename, size))

    # Attach

    def attach_object(
        self, object: Any, link: str | None = None, touch_links: Sequence[str] | None = None
    ) -> None:
        """Attach an object, by name, as CollisionObject or as AttachedCollisionObject."""
        if isinstance(object, str):
            object = CollisionObject(id=object)
        if isinstance(object, CollisionObject):
            object = AttachedCollisionObject(object=object)
        if link is not None:
            object.link_name = link
        object.touch_links = list(touch_links) if touch_links is not None else [object.link_name]
        self._apply_attached(object)

    def attach_box(
        self,
        link: str,
        name: str,
        pose: Any = None,
        size: Sequence[float] = (1, 1, 1),
        touch_links: Sequence[str] = (),
    ) -> None:
        """Attach a known object, or a box that is made at a PoseStamped."""
        item = CollisionObject(id=name) if pose is None else self.make_box(name, pose, size)
        self.attach_object(item, link, touch_links)

    def attach_sphere(
        self,
        link: str,
        name: str,
        pose: Any = None,
        radius: float = 1,
        touch_links: Sequence[str] = (),
    ) -> None:
        """Attach a known object, or a sphere that is made at a PoseStamped."""
        item = CollisionObject(id=name) if pose is None else self.make_sphere(name, pose, radius)
        self.attach_object(item, link, touch_links)

    def attach_cylinder(
        self,
        link: str,
        name: str,
        pose: Any = None,
        height: float = 1,
        radius: float = 1,
        touch_links: Sequence[str] = (),
    ) -> None:
        """Attach a known object, or a cylinder that is made at a PoseStamped."""
        made = None if pose is None else self.make_cylinder(name, pose, height, radius)
        self.attach_object(CollisionObject(id=name) if made is None else made, link, touch_links)

    def attach_mesh(
        self,
        link: str,
        name: str,
        pose: Any = None,
        filename: str = "",
        size: Sequence[float] = (1, 1, 1),
        touch_links: Sequence[str] = (),
    ) -> None:
        """Attach a known object, or a mesh that is read and placed at a PoseStamped."""
        made = None if pose is None or not filename else self.make_mesh(name, pose, filename, size)
        self.attach_object(CollisionObject(id=name) if made is None else made, link, touch_links)

    # Remove

    def clear(self) -> None:
        """Remove every object from the world and from the robot."""
        self._server.scene.clear()

    def remove_world_object(self, name: str | None = None) -> None:
        """Remove an object from the world, or all."""
        self._apply(CollisionObject(id=name or "", operation=CollisionObject.REMOVE))

    def remove_attached_object(self, link: str | None = None, name: str | None = None) -> None:
        """Detach an object, all those of a link, or all; they stay in the world."""
        removed = CollisionObject(id=name or "", operation=CollisionObject.REMOVE)
        self._apply_attached(AttachedCollisionObject(link_name=link or "", object=removed))

    # Ask

    def get_known_object_names(self, with_type: bool = False) -> list[str]:
        """Return the names of the objects in the world, sorted."""
        self._server.positions()
        return [item.name for item in self._world() if not with_type or item.message.type.key]

    def get_known_object_names_in_roi(
        self,
        minx: float,
        miny: float,
        minz: float,
        maxx: float,
        maxy: float,
        maxz: float,
        with_type: bool = False,
    ) -> list[str]:
        """Return the names of the objects whose origin lies within a box of the planning frame."""
        low, high = (minx, miny, minz), (maxx, maxy, maxz)
        return [
            item.name
            for item in self._world()
            if (not with_type or item.message.type.key)
            and all(a <= p <= b for a, p, b in zip(low, item.pose.position, high, strict=True))
        ]

    def get_object_poses(self, object_ids: Sequence[str]) -> dict[str, Any]:
        """Return the poses of objects in the planning frame, as Pose, by name."""
        self._seek(object_ids, self._server.scene.world)
        return {
            item.name: _pose_message(item.pose)
            for item in self._world()
            if not object_ids or item.name in object_ids
        }

    def get_objects(self, object_ids: Sequence[str] = ()) -> dict[str, Any]:
        """Return objects of the world, or all, as CollisionObject by name."""
        self._seek(object_ids, self._server.scene.world)
        return {
            item.name: self._described(item, self._server.planning_frame)
            for item in self._world()
            if not object_ids or item.name in object_ids
        }

    def get_attached_objects(self, object_ids: Sequence[str] = ()) -> dict[str, Any]:
        """Return attached objects, or all, as AttachedCollisionObject by name."""
        self._seek(object_ids, self._server.scene.attached, "attached")
        return {
            name: AttachedCollisionObject(
                link_name=item.link,
                object=self._described(item.object, item.link),
                touch_links=list(item.touch_links),
            )
            for name, item in sorted(self._server.seen().attached.items())
            if not object_ids or name in object_ids
        }

    def get_planning_scene(self, components: int) -> Any:
        """Return the parts of the scene that the bits of PlanningSceneComponents ask for."""
        scene = PlanningScene(name="(noname)", robot_model_name=self._server.robot.name)
        wanted = PlanningSceneComponents
        if components & (wanted.ROBOT_STATE | wanted.ROBOT_STATE_ATTACHED_OBJECTS):
            scene.robot_state = conversions._state_message(
                self._server.positions(), self._server.planning_frame
            )
        if components & wanted.ROBOT_STATE_ATTACHED_OBJECTS:
            attached = self.get_attached_objects()
            scene.robot_state.attached_collision_objects = list(attached.values())
        if components & (wanted.WORLD_OBJECT_NAMES | wanted.WORLD_OBJECT_GEOMETRY):
            scene.world.collision_objects = list(self.get_objects().values())
        if components & wanted.OBJECT_COLORS:
            scene.object_colors = list(self._server.scene.colors.values())
        if components & wanted.ALLOWED_COLLISION_MATRIX:
            scene.allowed_collision_matrix = _allowed_matrix(self._server.scene.allowed)
        return scene

    def apply_planning_scene(self, planning_scene_message: Any) -> bool:
        """Apply a PlanningScene: its objects and their colours; True where all were applied."""
        message = planning_scene_message
        if not message.is_diff:
            self._server.scene.clear()
        for item in message.world.collision_objects:
            self._change(item)
        for item in message.robot_state.attached_collision_objects:
            self._change_attached(item)
        for color in message.object_colors:
            self._server.scene.colors[color.id] = color
        matrix = message.allowed_collision_matrix
        if matrix.entry_names or matrix.default_entry_names:
            self._server.scene.allow(_allowed_pairs(matrix))
        return True

    # Make

    @staticmethod
    def make_box(name: str, pose: Any, size: Sequence[float]) -> Any:
        """Return a box as CollisionObject."""
        return _primitive(name, pose, SolidPrimitive.BOX, size)

    @staticmethod
    def make_sphere(name: str, pose: Any, radius: float) -> Any:
        """Return a sphere as CollisionObject."""
        return _primitive(name, pose, SolidPrimitive.SPHERE, [radius])

    @staticmethod
    def make_cylinder(name: str, pose: Any, height: float, radius: float) -> Any:
        """Return a cylinder as CollisionObject."""
        return _primitive(name, pose, SolidPrimitive.CYLINDER, [height, radius])

    @staticmethod
    def make_cone(name: str, pose: Any, height: float, radius: float) -> Any:
        """Return a cone as CollisionObject."""
        return _primitive(name, pose, SolidPrimitive.CONE, [height, radius])

    @staticmethod
    def make_plane(
        name: str, pose: Any, normal: Sequence[float] = (0, 0, 1), offset: float = 0
    ) -> Any:
        """Return a plane as CollisionObject."""
        item = CollisionObject(id=name, header=pose.header, operation=CollisionObject.ADD)
        item.planes = [Plane(coef=[*map(float, normal), float(offset)])]
        item.plane_poses = [pose.pose]
        return item

    @staticmethod
    def make_mesh(name: str, pose: Any, filename: str, scale: Sequence[float] = (1, 1, 1)) -> Any:
        """Return a mesh from an STL or OBJ file as CollisionObject.

        Raises:
            MoveItCommanderException: the file cannot be read as a mesh.
        """
        try:
            vertices, triangles = read_triangles(Path(filename))
        except (OSError, ValueError) as error:
            raise MoveItCommanderException(f"There are no meshes in the file: {error}") from error
        sx, sy, sz = scale
        mesh = Mesh(
            vertices=[Point(x * sx, y * sy, z * sz) for x, y, z in vertices],
            triangles=[MeshTriangle(vertex_indices=list(corners)) for corners in triangles],
        )
        item = CollisionObject(id=name, header=pose.header, pose=pose.pose)
        item.operation, item.meshes = CollisionObject.ADD, [mesh]
        return item

    # How

    def _world(self) -> list[SceneObject]:
        return [item for _, item in sorted(self._server.seen().world.items())]

    def _seek(self, names: Sequence[str], known: Mapping[str, Any], how: str = "") -> None:
        """Note the objects that are looked for by name and not there."""
        for name in names:
            if name not in known:
                self._server.seek(name, how)

    def _described(self, item: SceneObject, frame: str) -> Any:
        described = CollisionObject()
        for name in described.__slots__:
            setattr(described, name, getattr(item.message, name))
        described.header = type(described.header)(frame_id=frame)
        described.pose = _pose_message(item.pose)
        fill_poses(described, Pose)
        return described

    def _send(self, topic: str, change: Callable[[], None]) -> None:
        """Change the scene; a message is lost before move_group is connected."""
        carrier, now_ns = current().graph.carrier, current().scheduler.now_ns
        if (
            self._is_by_topic
            and carrier.connected_ns(topic, self._made_ns, "planning scene") > now_ns
        ):
            carrier.note_early(f"a message on {topic}", topic, "planning scene", change)
            return
        carrier.note_in_time(topic, change)
        with self._changing():
            change()

    def _apply(self, message: Any) -> None:
        self._send("/collision_object", partial(self._change, message))

    def _apply_attached(self, message: Any) -> None:
        self._send("/attached_collision_object", partial(self._change_attached, message))

    def _change(self, message: Any) -> None:
        scene = self._server.scene
        if message.operation == CollisionObject.REMOVE:
            refusal = scene.cannot_remove(message.id)
            if refusal is not None:
                self._server.execution.report("planning_scene", refusal, object_name=message.id)
            scene.remove(message.id)
            return
        place = self._server.changes.placed(message)
        if place is None:
            return
        if message.operation == CollisionObject.MOVE:
            if not scene.move(message.id, place):
                self._server.lack(message.id, report_unknown(message.id, "moved"))
        elif message.operation == CollisionObject.APPEND and message.id in scene.world:
            scene.append(message.id, message)
        else:
            scene.add(SceneObject(message.id, place, message))

    def _change_attached(self, message: Any) -> None:
        item, scene = message.object, self._server.scene
        if item.operation == CollisionObject.REMOVE:
            for name, attached in list(scene.attached.items()):
                if item.id in ("", name) and message.link_name in ("", attached.link):
                    self._server.detach(name)
            return
        if item.primitives or item.meshes or item.planes:
            self._change(item)
        elif item.id in scene.attached:
            self._server.detach(item.id)
        if not self._server.attach(item.id, message.link_name, message.touch_links):
            self._server.lack(item.id, report_unknown(item.id, "attached"))


def _primitive(name: str, pose: Any, kind: int, dimensions: Sequence[float]) -> Any:
    shape = SolidPrimitive(type=kind, dimensions=[float(value) for value in dimensions])
    item = CollisionObject(id=name, header=pose.header, pose=pose.pose, primitives=[shape])
    item.operation = CollisionObject.ADD
    return item


def _allowed_pairs(matrix: Any) -> set[frozenset[str]]:
    pairs = {
        frozenset((matrix.entry_names[i], matrix.entry_names[j]))
        for i, entry in enumerate(matrix.entry_values)
        for j, enabled in enumerate(entry.enabled)
        if enabled and i != j
    }
    defaults = zip(matrix.default_entry_names, matrix.default_entry_values, strict=True)
    return pairs | {frozenset((name,)) for name, enabled in defaults if enabled}


def _allowed_matrix(allowed: frozenset[frozenset[str]]) -> Any:
    names = sorted({name for pair in allowed if len(pair) == 2 for name in pair})
    matrix = AllowedCollisionMatrix(entry_names=names)
    matrix.entry_values = [
        AllowedCollisionEntry(enabled=[frozenset((one, two)) in allowed for two in names])
        for one in names
    ]
    matrix.default_entry_names = sorted(name for pair in allowed if len(pair) == 1 for name in pair)
    matrix.default_entry_values = [True] * len(matrix.default_entry_names)
    return matrix


def _pose_message(pose: Any) -> Any:
    return conversions.list_to_pose([*pose.position, *pose.orientation])


def acm_set_default(acm: Any, obj: str, allow: bool) -> None:
    """Set whether collisions with an object are allowed where nothing else is said."""
    if obj in acm.default_entry_names:
        acm.default_entry_values[acm.default_entry_names.index(obj)] = allow
    else:
        acm.default_entry_names.append(obj)
        acm.default_entry_values.append(allow)


def acm_set_allowed(acm: Any, obj: str, other: str | None = None, allow: bool = True) -> None:
    """Set whether collisions between two objects are allowed, or between one and all.

    Raises:
        ValueError: `other` is not in the matrix.
    """
    if other is None:
        acm_set_default(acm, obj, allow)
        return
    column = acm.entry_names.index(other)
    if obj not in acm.entry_names:
        defaults = dict(zip(acm.default_entry_names, acm.default_entry_values, strict=True))
        row = [defaults.get(obj, defaults.get(name, False)) for name in acm.entry_names]
        for entry, value in zip(acm.entry_values, row, strict=True):
            entry.enabled.append(value)
        acm.entry_names.append(obj)
        acm.entry_values.append(AllowedCollisionEntry(enabled=[*row, False]))
    line = acm.entry_names.index(obj)
    acm.entry_values[line].enabled[column] = allow
    acm.entry_values[column].enabled[line] = allow


AllowedCollisionMatrix.set_default = acm_set_default
AllowedCollisionMatrix.set_allowed = acm_set_allowed
