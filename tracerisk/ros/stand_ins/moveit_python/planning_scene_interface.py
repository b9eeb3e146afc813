"""Objects of the planning scene by its services."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import rospy
from geometry_msgs.msg import Point, Pose, Quaternion
from moveit_msgs.msg import (
    AttachedCollisionObject,
    CollisionObject,
    ObjectColor,
    PlanningScene,
    PlanningSceneComponents,
)
from moveit_msgs.srv import ApplyPlanningScene, GetPlanningScene
from shape_msgs.msg import Mesh, MeshTriangle, SolidPrimitive

from tracerisk.common.geometry.triangle_mesh import read_triangles

__all__ = ["PlanningSceneInterface"]


class PlanningSceneInterface:
    """Adds, attaches and removes objects; poses are in a frame."""

    def __init__(self, frame: str, ns: str = "", init_from_service: bool = True) -> None:
        space = ns if not ns or ns.endswith("/") else ns + "/"
        self._fixed_frame = frame
        self._scene_pub = rospy.Publisher(space + "planning_scene", PlanningScene, queue_size=10)
        self._apply_service = rospy.ServiceProxy(space + "apply_planning_scene", ApplyPlanningScene)
        self._service = rospy.ServiceProxy(space + "get_planning_scene", GetPlanningScene)
        self._colors: dict[str, Any] = {}
        if init_from_service:
            rospy.loginfo("Waiting for get_planning_scene")
            rospy.wait_for_service(space + "get_planning_scene")

    def sendUpdate(
        self, collision_object: Any, attached_collision_object: Any, use_service: bool = True
    ) -> None:
        """Send a change of the scene, by the service or by the topic."""
        scene = PlanningScene(is_diff=True)
        scene.robot_state.is_diff = True
        if collision_object:
            scene.world.collision_objects.append(collision_object)
        if attached_collision_object:
            scene.robot_state.attached_collision_objects.append(attached_collision_object)
        if not use_service:
            self._scene_pub.publish(scene)
        elif not self._apply_service.call(scene).success:
            rospy.logerr("Could not apply planning scene diff.")

    def clear(self) -> None:
        """Remove every object."""
        for name in self.getKnownCollisionObjects():
            self.removeCollisionObject(name, True)
        for name in self.getKnownAttachedObjects():
            self.removeAttachedObject(name, True)
        self.waitForSync()

    # Messages

    def makeMesh(self, name: str, pose: Any, filename: str) -> Any:
        """Return the object of a mesh file."""
        corners, faces = read_triangles(Path(filename))
        mesh = Mesh()
        mesh.vertices = [Point(*corner) for corner in corners]
        mesh.triangles = [MeshTriangle(vertex_indices=list(face)) for face in faces]
        made = self._object(name, None)
        made.meshes.append(mesh)
        made.mesh_poses.append(pose)
        return made

    def makeSolidPrimitive(
        self, name: str, solid: Any, pose: Any, frame_id: str | None = None
    ) -> Any:
        """Return the object of a primitive."""
        made = self._object(name, frame_id)
        made.primitives.append(solid)
        made.primitive_poses.append(pose)
        return made

    def _object(self, name: str, frame_id: str | None) -> Any:
        made = CollisionObject(id=name, operation=CollisionObject.ADD)
        made.header.stamp = rospy.Time.now()
        made.header.frame_id = frame_id or self._fixed_frame
        return made

    def makeAttached(
        self, link_name: str, obj: Any, touch_links: Any, detach_posture: Any, weight: float
    ) -> Any:
        """Return an object attached to a link."""
        made = AttachedCollisionObject(link_name=link_name, object=obj, weight=weight)
        if touch_links:
            made.touch_links = touch_links
        if detach_posture:
            made.detach_posture = detach_posture
        return made

    # Objects

    def addMesh(self, name: str, pose: Any, filename: str, use_service: bool = True) -> None:
        """Add a mesh."""
        self.sendUpdate(self.makeMesh(name, pose, filename), None, use_service)

    def attachMesh(
        self,
        name: str,
        pose: Any,
        filename: str,
        link_name: str,
        touch_links: Sequence[str] | None = None,
        detach_posture: Any = None,
        weight: float = 0.0,
        use_service: bool = True,
    ) -> None:
        """Attach a mesh to a link, in whose frame its pose is."""
        made = self.makeMesh(name, pose, filename)
        made.header.frame_id = link_name
        attached = self.makeAttached(link_name, made, touch_links, detach_posture, weight)
        self.sendUpdate(None, attached, use_service)

    def addSolidPrimitive(
        self,
        name: str,
        solid: Any,
        pose: Any,
        use_service: bool = True,
        frame_id: str | None = None,
    ) -> None:
        """Add a primitive."""
        self.sendUpdate(self.makeSolidPrimitive(name, solid, pose, frame_id), None, use_service)

    def addCylinder(
        self,
        name: str,
        height: float,
        radius: float,
        x: float,
        y: float,
        z: float,
        use_service: bool = True,
        frame_id: str | None = None,
    ) -> None:
        """Add a cylinder along z."""
        placed = _placed(SolidPrimitive.CYLINDER, (height, radius), (x, y, z))
        self.addSolidPrimitive(name, *placed, use_service, frame_id)

    def addSphere(
        self,
        name: str,
        radius: float,
        x: float,
        y: float,
        z: float,
        use_service: bool = True,
        frame_id: str | None = None,
    ) -> None:
        """Add a sphere."""
        placed = _placed(SolidPrimitive.SPHERE, (radius,), (x, y, z))
        self.addSolidPrimitive(name, *placed, use_service, frame_id)

    def addCone(
        self,
        name: str,
        height: float,
        radius: float,
        x: float,
        y: float,
        z: float,
        use_service: bool = True,
        frame_id: str | None = None,
    ) -> None:
        """Add a cone along z."""
        placed = _placed(SolidPrimitive.CONE, (height, radius), (x, y, z))
        self.addSolidPrimitive(name, *placed, use_service, frame_id)

    def addBox(
        self,
        name: str,
        size_x: float,
        size_y: float,
        size_z: float,
        x: float,
        y: float,
        z: float,
        use_service: bool = True,
        frame_id: str | None = None,
    ) -> None:
        """Add a box."""
        placed = _placed(SolidPrimitive.BOX, (size_x, size_y, size_z), (x, y, z))
        self.addSolidPrimitive(name, *placed, use_service, frame_id)

    def addCube(
        self,
        name: str,
        size: float,
        x: float,
        y: float,
        z: float,
        use_service: bool = True,
        frame_id: str | None = None,
    ) -> None:
        """Add a cube."""
        self.addBox(name, size, size, size, x, y, z, use_service, frame_id)

    def attachBox(
        self,
        name: str,
        size_x: float,
        size_y: float,
        size_z: float,
        x: float,
        y: float,
        z: float,
        link_name: str,
        touch_links: Sequence[str] | None = None,
        detach_posture: Any = None,
        weight: float = 0.0,
        use_service: bool = True,
    ) -> None:
        """Attach a box to a link, in whose frame its place is."""
        solid, pose = _placed(SolidPrimitive.BOX, (size_x, size_y, size_z), (x, y, z))
        made = self.makeSolidPrimitive(name, solid, pose, link_name)
        attached = self.makeAttached(link_name, made, touch_links, detach_posture, weight)
        self.sendUpdate(None, attached, use_service)

    def removeCollisionObject(self, name: str, use_service: bool = True) -> None:
        """Remove an object."""
        gone = self._object(name, None)
        gone.operation = CollisionObject.REMOVE
        self.sendUpdate(gone, None, use_service)

    def removeAttachedObject(self, name: str, use_service: bool = True) -> None:
        """Detach an object; it stays in the world."""
        gone = AttachedCollisionObject()
        gone.object.id, gone.object.operation = name, CollisionObject.REMOVE
        self.sendUpdate(None, gone, use_service)

    # What there is

    def _scene(self) -> Any:
        asked = PlanningSceneComponents(
            components=PlanningSceneComponents.WORLD_OBJECT_NAMES
            | PlanningSceneComponents.ROBOT_STATE_ATTACHED_OBJECTS
        )
        return self._service(asked).scene

    def getKnownCollisionObjects(self) -> list[str]:
        """Return the names of the objects of the world."""
        return [collision_object.id for collision_object in self._scene().world.collision_objects]

    def getKnownAttachedObjects(self) -> list[str]:
        """Return the names of the attached objects."""
        return [
            collision_object.object.id
            for collision_object in self._scene().robot_state.attached_collision_objects
        ]

    def waitForSync(self, max_time: float = 2.0) -> None:
        """Wait until the scene is as it was set: the twin's is as soon as a service answers."""
        rospy.sleep(0.1)

    def setColor(self, name: str, r: float, g: float, b: float, a: float = 0.9) -> None:
        """Set the colour of an object; `sendColors` sends it."""
        color = ObjectColor(id=name)
        color.color.r, color.color.g, color.color.b, color.color.a = r, g, b, a
        self._colors[name] = color

    def sendColors(self) -> None:
        """Send the colours."""
        scene = PlanningScene(is_diff=True, object_colors=list(self._colors.values()))
        scene.robot_state.is_diff = True
        if not self._apply_service.call(scene).success:
            rospy.logerr("Could not update colors through service, using topic instead.")
            self._scene_pub.publish(scene)


def _placed(kind: int, sizes: Sequence[float], place: Sequence[float]) -> tuple[Any, Any]:
    """Return a primitive, and the pose of one that is not turned."""
    solid = SolidPrimitive(type=kind, dimensions=list(sizes))
    return solid, Pose(Point(*place), Quaternion(0.0, 0.0, 0.0, 1.0))
