"""Objects of the planning scene."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from geometry_msgs.msg import Point, Pose
from moveit_msgs.msg import AllowedCollisionEntry, AttachedCollisionObject, CollisionObject
from moveit_msgs.srv import ApplyPlanningScene, GetPlanningScene
from shape_msgs.msg import Mesh, MeshTriangle, SolidPrimitive

from tracerisk.common.geometry.triangle_mesh import read_triangles

from ._goals import Goals
from ._messages import point, quaternion


class Scene(Goals):
    """Adds objects to the planning scene, attaches and removes them."""

    def _begin_scene(self) -> None:
        self._objects = self._node.create_publisher(CollisionObject, "/collision_object", 10)
        self._attached = self._node.create_publisher(
            AttachedCollisionObject, "/attached_collision_object", 10
        )
        self._get_planning_scene_service = self._client(GetPlanningScene, "get_planning_scene")
        self._apply_planning_scene_service = self._client(
            ApplyPlanningScene, "apply_planning_scene"
        )
        self._scene: Any = None
        self._scene_before: Any = None
        self._matrix_before: Any = None

    @property
    def planning_scene(self) -> Any:
        """The planning scene as last asked for, None before."""
        return self._scene

    def add_collision_primitive(
        self,
        id: str,
        primitive_type: int,
        dimensions: Sequence[float],
        pose: Any = None,
        position: Any = None,
        quat_xyzw: Any = None,
        frame_id: str | None = None,
        operation: Any = CollisionObject.ADD,
    ) -> None:
        """Add a box, sphere, cylinder or cone.

        Raises:
            ValueError: there is neither a pose nor both a position and a quaternion.
        """
        message = self._object(id, pose, position, quat_xyzw, frame_id, operation)
        sizes = [float(size) for size in dimensions]
        message.primitives.append(SolidPrimitive(type=primitive_type, dimensions=sizes))
        self._objects.publish(message)

    def _object(
        self, id: str, pose: Any, position: Any, quat_xyzw: Any, frame_id: Any, operation: Any
    ) -> Any:
        if pose is None and (position is None or quat_xyzw is None):
            raise ValueError("Either `pose` or `position` and `quat_xyzw` must be specified!")
        placed = self._stamped(pose, position, quat_xyzw, frame_id)
        return CollisionObject(header=placed.header, id=id, operation=operation, pose=placed.pose)

    def add_collision_box(
        self,
        id: str,
        size: Sequence[float],
        pose: Any = None,
        position: Any = None,
        quat_xyzw: Any = None,
        frame_id: str | None = None,
        operation: Any = CollisionObject.ADD,
    ) -> None:
        """Add a box of three lengths [m]."""
        assert len(size) == 3, "Invalid size of the box!"
        kind = SolidPrimitive.BOX
        self.add_collision_primitive(id, kind, size, pose, position, quat_xyzw, frame_id, operation)

    def add_collision_sphere(
        self,
        id: str,
        radius: float,
        pose: Any = None,
        position: Any = None,
        quat_xyzw: Any = None,
        frame_id: str | None = None,
        operation: Any = CollisionObject.ADD,
    ) -> None:
        """Add a sphere."""
        turn = (0.0, 0.0, 0.0, 1.0) if quat_xyzw is None else quat_xyzw
        kind = SolidPrimitive.SPHERE
        self.add_collision_primitive(id, kind, [radius], pose, position, turn, frame_id, operation)

    def add_collision_cylinder(
        self,
        id: str,
        height: float,
        radius: float,
        pose: Any = None,
        position: Any = None,
        quat_xyzw: Any = None,
        frame_id: str | None = None,
        operation: Any = CollisionObject.ADD,
    ) -> None:
        """Add a cylinder along z."""
        kind = SolidPrimitive.CYLINDER
        self.add_collision_primitive(
            id, kind, [height, radius], pose, position, quat_xyzw, frame_id, operation
        )

    def add_collision_cone(
        self,
        id: str,
        height: float,
        radius: float,
        pose: Any = None,
        position: Any = None,
        quat_xyzw: Any = None,
        frame_id: str | None = None,
        operation: Any = CollisionObject.ADD,
    ) -> None:
        """Add a cone along z."""
        kind = SolidPrimitive.CONE
        self.add_collision_primitive(
            id, kind, [height, radius], pose, position, quat_xyzw, frame_id, operation
        )

    def add_collision_mesh(
        self,
        filepath: str | None,
        id: str,
        pose: Any = None,
        position: Any = None,
        quat_xyzw: Any = None,
        frame_id: str | None = None,
        operation: Any = CollisionObject.ADD,
        scale: Any = 1.0,
        mesh: Any = None,
    ) -> None:
        """Add a mesh of a file, or one with `vertices` and `faces`.

        Raises:
            ValueError: there are both or neither, or no pose.
        """
        if (filepath is None) == (mesh is None):
            raise ValueError("Exactly one of `filepath` or `mesh` must be specified!")
        message = self._object(id, pose, position, quat_xyzw, frame_id, operation)
        if filepath is not None:
            corners, faces = read_triangles(Path(filepath))
        else:
            corners, faces = mesh.vertices, mesh.faces
        sizes = (scale,) * 3 if isinstance(scale, float | int) else tuple(scale)
        made = Mesh()
        made.vertices = [
            Point(**{axis: float(v) * s for axis, v, s in zip("xyz", corner, sizes, strict=True)})
            for corner in corners
        ]
        made.triangles = [
            MeshTriangle(vertex_indices=[int(each) for each in face]) for face in faces
        ]
        message.meshes.append(made)
        self._objects.publish(message)

    def remove_collision_object(self, id: str) -> None:
        """Remove an object."""
        message = CollisionObject(id=id, operation=CollisionObject.REMOVE)
        message.header.stamp = self._node.get_clock().now().to_msg()
        self._objects.publish(message)

    def remove_collision_mesh(self, id: str) -> None:
        """Remove an object."""
        self.remove_collision_object(id)

    def attach_collision_object(
        self,
        id: str,
        link_name: str | None = None,
        touch_links: Sequence[str] = (),
        weight: float = 0.0,
    ) -> None:
        """Attach an object to a link, by default the end effector."""
        message = AttachedCollisionObject(
            object=CollisionObject(id=id, operation=CollisionObject.ADD)
        )
        message.link_name = self._end_effector if link_name is None else link_name
        message.touch_links, message.weight = list(touch_links), weight
        self._attached.publish(message)

    def detach_collision_object(self, id: str) -> None:
        """Detach an object."""
        removed = CollisionObject(id=id, operation=CollisionObject.REMOVE)
        self._attached.publish(AttachedCollisionObject(object=removed))

    def detach_all_collision_objects(self) -> None:
        """Detach every object."""
        self.detach_collision_object("")

    def move_collision(
        self, id: str, position: Any, quat_xyzw: Any, frame_id: str | None = None
    ) -> None:
        """Move an object."""
        pose = Pose(position=point(position), orientation=quaternion(quat_xyzw))
        message = CollisionObject(id=id, pose=pose, operation=CollisionObject.MOVE)
        message.header.frame_id = self._base_link if frame_id is None else frame_id
        message.header.stamp = self._node.get_clock().now().to_msg()
        self._objects.publish(message)

    def update_planning_scene(self) -> bool:
        """Ask for the planning scene; return whether it came."""
        if not self._is_ready(self._get_planning_scene_service):
            return False
        future = self._get_planning_scene_service.call_async(GetPlanningScene.Request())
        self._scene = self._wait(future).scene
        return True

    def allow_collisions(self, id: str, allow: bool) -> Any:
        """Allow or forbid an object to touch everything; return the future of the service."""
        if not self.update_planning_scene():
            return None
        matrix = self._scene.allowed_collision_matrix
        self._matrix_before = copy.deepcopy(matrix)
        if id not in matrix.entry_names:
            matrix.entry_names.append(id)
            for entry in matrix.entry_values:
                entry.enabled.append(allow)
            matrix.entry_values.append(AllowedCollisionEntry())
        place = list(matrix.entry_names).index(id)
        for index, entry in enumerate(matrix.entry_values):
            if index != place:
                entry.enabled[place] = allow
        matrix.entry_values[place].enabled = [allow] * len(matrix.entry_names)
        return self._apply()

    def process_allow_collision_future(self, future: Any) -> bool:
        """Return whether collisions were allowed; where not, remember the matrix of before."""
        if not future.done():
            return False
        if not future.result().success:
            self._scene.allowed_collision_matrix = self._matrix_before
        return bool(future.result().success)

    def clear_all_collision_objects(self) -> Any:
        """Remove all objects, attached ones too; return the future of the service."""
        if not self.update_planning_scene():
            return None
        self._scene_before = copy.deepcopy(self._scene)
        self._scene.world.collision_objects = []
        self._scene.robot_state.attached_collision_objects = []
        return self._apply()

    def cancel_clear_all_collision_objects_future(self, future: Any) -> None:
        """Wait no more for the objects to be removed."""
        self._apply_planning_scene_service.remove_pending_request(future)

    def process_clear_all_collision_objects_future(self, future: Any) -> bool:
        """Return whether the objects were removed; where not, remember the scene of before."""
        if not future.done():
            return False
        if not future.result().success:
            self._scene = self._scene_before
        return bool(future.result().success)

    def _apply(self) -> Any:
        if not self._is_ready(self._apply_planning_scene_service):
            return None
        request = ApplyPlanningScene.Request(scene=self._scene)
        return self._apply_planning_scene_service.call_async(request)
