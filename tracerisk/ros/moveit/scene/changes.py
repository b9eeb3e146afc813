"""What messages of moveit_msgs change in a planning scene, and where its frames are."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from tracerisk.errors import RobotError, one_of
from tracerisk.ros.moveit.path_constraints import message_pose
from tracerisk.ros.moveit.scene.planning_scene import PlanningScene, SceneObject
from tracerisk.ros.moveit.scene.shapes import first_pose
from tracerisk.ros.transforms.poses import ORIGIN, compose, inverse
from tracerisk.twin.physics.motion import Pose
from tracerisk.twin.robots.robot import Robot

_WORLD_FRAMES = frozenset({"", "world", "map", "odom"})
_BASE_FRAMES = frozenset({"base", "base_link", "base_footprint", "base_frame", "robot_base"})
# moveit_msgs/CollisionObject; the constants are bytes in one ROS and numbers in the other.
_REMOVE, _APPEND, _MOVE = 1, 2, 3


@dataclass(eq=False)
class SceneChanges:
    """Changes one planning scene of a robot."""

    scene: PlanningScene
    """The planning scene that is changed."""
    _robot: Robot
    """The robot that objects are attached to."""
    _link_pose: Callable[[str], Pose]
    """The function that returns the pose of a link in the planning frame."""
    _report: Callable[[str, str], None]
    """The function for what could not be done: the reason, and the object not attached."""
    _attached: Callable[[str], None] = lambda name: None  # noqa: ARG005
    """The function for the name of each object that was attached."""
    _assumed: Callable[[str, str], None] = lambda words, name: None  # noqa: ARG005
    """The function for an assumption on a frame: a sentence, and the frame's name."""

    # Where frames are

    def frame(self, name: str) -> Pose | None:
        """Return the pose of a frame (a link, the world, an object of the scene), else None."""
        name = name.lstrip("/")
        if name in _WORLD_FRAMES or name == self._robot.base_link:
            return ORIGIN
        if name in self._robot.link_names:
            return self._link_pose(name)
        return self.object_pose(name)

    def assumed_base(self, name: str) -> Pose | None:
        """Return where the base is for a plain name of a base that the robot's has not, else None.

        It is that of another description of the robot than the author's.
        """
        plain = name.lstrip("/")
        if plain not in _BASE_FRAMES or self._robot.is_described:
            return None
        self._assumed(
            f"frame '{plain}' is taken for the base of robot '{self._robot.name}', which is called "
            f"'{self._robot.base_link}' there: the controller was written for another description "
            "of it; name the robot with --robot",
            plain,
        )
        return ORIGIN

    def object_pose(self, name: str) -> Pose | None:
        """Return the pose of an object of the scene in the planning frame, else None."""
        if name in self.scene.world:
            return self.scene.world[name].pose
        attached = self.scene.attached.get(name)
        if attached is None:
            return None
        return compose(self._link_pose(attached.link), attached.object.pose)

    # Attach and detach

    def attach(self, name: str, link: str, touch_links: Sequence[str]) -> bool:
        """Attach a known object of the world to a link; False where there is none.

        Raises:
            RobotError: the robot has no such link; lists those it has.
        """
        if name not in self.scene.world:
            return False
        if link not in self._robot.link_names:
            raise RobotError(
                f"robot '{self._robot.name}' has no link '{link}'; "
                f"{one_of(self._robot.link_names, link)}"
            )
        self.scene.attach(name, link, inverse(self._link_pose(link)), touch_links)
        self._attached(name)
        return True

    def detach(self, name: str) -> bool:
        """Leave an attached object in the world where it now is; False where there is none."""
        attached = self.scene.attached.get(name)
        if attached is None:
            return False
        self.scene.detach(name, self._link_pose(attached.link))
        return True

    # Messages

    def apply_scene(self, message: Any) -> bool:
        """Apply a PlanningScene, whole or a difference; return whether all of it could be done."""
        if not message.is_diff:
            self.scene.clear()
        done = [self.apply(item) for item in message.world.collision_objects]
        attached = message.robot_state.attached_collision_objects
        done += [self.apply_attached(item) for item in attached]
        for color in message.object_colors:
            self.scene.colors[color.id] = color
        return all(done)

    def apply(self, message: Any) -> bool:
        """Apply a CollisionObject: add, append, move or remove; return whether it was done."""
        scene, operation = self.scene, _number(message.operation)
        if operation == _REMOVE:
            refusal = scene.cannot_remove(message.id)
            if refusal is not None:
                self._report(refusal, "")
            return scene.remove(message.id)
        place = self.placed(message)
        if place is None:
            return False
        if operation == _MOVE:
            return scene.move(message.id, place) or self._unknown(message.id, "moved")
        if operation == _APPEND and message.id in scene.world:
            scene.append(message.id, message)
            return True
        scene.add(SceneObject(message.id, place, message))
        return True

    def placed(self, message: Any) -> Pose | None:
        """Return where a CollisionObject is in the planning frame; None in an unknown frame.

        What is given in one is left out, as by move_group, and whoever sent it goes on.
        """
        name = message.header.frame_id
        frame = self.frame(name) or self.assumed_base(name)
        if frame is None:
            self._report(
                f"object '{message.id}' is given in the unknown frame '{name}'; "
                f"{one_of(self._robot.link_names, name)}",
                "",
            )
            return None
        # Objects of the older form have no pose of their own, only their shapes do.
        own = message_pose(message.pose)
        return compose(frame, first_pose(message) or own)

    def apply_attached(self, message: Any) -> bool:
        """Apply an AttachedCollisionObject: attach or detach; return whether it was done."""
        item, scene = message.object, self.scene
        if _number(item.operation) == _REMOVE:
            for name, attached in list(scene.attached.items()):
                if item.id in ("", name) and message.link_name in ("", attached.link):
                    self.detach(name)
            return True
        if item.primitives or item.meshes or item.planes:
            if not self.apply(item):
                return False
        elif item.id in scene.attached:
            self.detach(item.id)
        try:
            attach = self.attach(item.id, message.link_name, list(message.touch_links))
        except RobotError as error:
            self._report(error.message, item.id)
            return False
        return attach or self._unknown(item.id, "attached")

    def _unknown(self, name: str, what: str) -> bool:
        self._report(
            f"object '{name}' cannot be {what}: the planning scene has no such object; "
            f"{one_of(self.scene.world, name)}",
            name if what == "attached" else "",
        )
        return False


def _number(value: Any) -> int:
    return value[0] if isinstance(value, bytes) else int(value)
