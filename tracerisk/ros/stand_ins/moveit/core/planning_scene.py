"""The robot among the objects that planning knows of."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracerisk.ros.moveit.scene.changes import SceneChanges
from tracerisk.ros.moveit.scene.planning_scene import PlanningScene as Objects
from tracerisk.ros.transforms.poses import ORIGIN
from tracerisk.twin.physics.motion import Pose

from .._library import library
from ._geometry_file import read_geometry, write_geometry
from ._matrices import matrix
from ._scene_checks import SceneChecks
from ._scene_message import scene_message
from ._world import World
from .collision_detection import AllowedCollisionMatrix
from .robot_model import RobotModel
from .robot_state import RobotState
from .transforms import Transforms

__all__ = ["PlanningScene"]

Pairs = list[tuple[str, str]]


class PlanningScene(SceneChecks):
    """A robot's state and the objects around it.

    One made by itself, or copied, is for planning and checks alone; the objects of the one that
    the monitor gives are bodies of the twin.
    """

    def __init__(self, robot_model: RobotModel, world: World | None = None) -> None:
        if not isinstance(robot_model, RobotModel):
            raise TypeError(f"PlanningScene takes a RobotModel, not {type(robot_model).__name__}")
        self._model = robot_model
        self.name = "(noname)"
        self._take(Objects())
        self._state = RobotState(robot_model)
        self._state.set_to_default_values()
        self._state.update()
        self._state._objects = self._objects

    def _take(self, objects: Objects) -> None:
        self._server = library().server
        self._objects = objects
        self._forbidden: set[frozenset[str]] = set()
        self._acm = AllowedCollisionMatrix()
        self._acm._changed = self._follow_matrix
        self._changes = SceneChanges(objects, self._server.robot, self._link_pose, _report)

    def _monitored(self) -> PlanningScene:
        """Become the scene of the monitor: its objects are the twin's."""
        self._take(self._server.scene)
        self._changes = self._server.changes
        self._state._objects = self._objects
        return self

    def __copy__(self) -> PlanningScene:
        made = PlanningScene(self._model)
        made.name = f"{self.name}+"
        made._objects.world.update(self._objects.world)
        made._objects.attached.update(self._objects.attached)
        made._objects.colors.update(self._objects.colors)
        made._objects.allowed = self._objects.allowed
        made._forbidden = set(self._forbidden)
        made._state = copy.copy(self._state)
        made._state._objects = made._objects
        return made

    def __deepcopy__(self, memo: dict[int, Any]) -> PlanningScene:
        return self.__copy__()

    @property
    def robot_model(self) -> RobotModel:
        """The robot's model."""
        return self._model

    @property
    def planning_frame(self) -> str:
        """The frame in which plans are made."""
        return self._model.model_frame

    @property
    def current_state(self) -> RobotState:
        """The robot's state in the scene; it can be changed, until the robot's own comes in."""
        return self._state

    @current_state.setter
    def current_state(self, robot_state: RobotState) -> None:
        self.set_current_state(robot_state)

    def set_current_state(self, robot_state: Any) -> None:
        """Set the robot's state by a RobotState, of this library or as a message."""
        if isinstance(robot_state, RobotState):
            self._state._take(robot_state.joint_positions)
            return
        given = robot_state.joint_state
        self._state.joint_positions = dict(zip(given.name, given.position, strict=True))
        self._state.update()

    @property
    def planning_scene_message(self) -> Any:
        """The scene as a PlanningScene message."""
        return scene_message(self)

    @property
    def transforms(self) -> Transforms:
        """The fixed frames: the planning frame, and nothing else."""
        return Transforms(self.planning_frame)

    # What may touch

    @property
    def allowed_collision_matrix(self) -> AllowedCollisionMatrix:
        """What may touch; a change of it is in force at once."""
        entries = dict.fromkeys(self._forbidden, False)
        entries.update(dict.fromkeys(self._by_build(), True))
        entries.update(dict.fromkeys(self._objects.allowed, True))
        self._acm._entries = entries
        return self._acm

    @allowed_collision_matrix.setter
    def allowed_collision_matrix(self, acm: AllowedCollisionMatrix) -> None:
        self._acm._entries = dict(acm._entries)
        self._follow_matrix()

    def _follow_matrix(self) -> None:
        self._forbidden = {pair for pair, may in self._acm._entries.items() if not may}
        self._objects.allow(self._acm._allowed() - self._by_build())

    def _by_build(self) -> frozenset[frozenset[str]]:
        return frozenset(map(frozenset, self._server.robot.disabled_collisions))

    # Frames

    def knows_frame_transform(self, robot_state: Any = None, frame_id: str | None = None) -> bool:
        """Return whether a frame is known: a link, or an object of the scene.

        It may be called with the name alone, or with a state before it.
        """
        if isinstance(robot_state, str):
            robot_state, frame_id = None, robot_state
        if frame_id is None:
            raise TypeError("knows_frame_transform() needs a frame_id")
        return self._frame(frame_id, robot_state) is not None

    def get_frame_transform(self, frame_id: str) -> NDArray[np.float64]:
        """Return the transform (4, 4) of a link or object; identity if unknown."""
        return matrix(self._frame(frame_id, None) or ORIGIN)

    def _frame(self, name: str, state: RobotState | None) -> Pose | None:
        pose = (state or self._state)._pose
        return SceneChanges(self._objects, self._server.robot, pose, _report).frame(name)

    def _link_pose(self, link: str) -> Pose:
        return self._state._pose(link)

    # Objects

    def apply_collision_object(self, collision_object_msg: Any, color_msg: Any = None) -> None:
        """Apply a CollisionObject: add, append, move or remove; with an ObjectColor."""
        self._changes.apply(collision_object_msg)
        if color_msg is not None:
            self._objects.colors[color_msg.id] = color_msg

    def process_attached_collision_object(self, object: Any) -> bool:
        """Apply an AttachedCollisionObject: attach or detach."""
        return self._changes.apply_attached(object)

    def process_planning_scene_world(self, msg: Any) -> bool:
        """Apply the objects of a PlanningSceneWorld."""
        if len(msg.octomap.octomap.data):
            self.process_octomap(msg.octomap)
        done = [self._changes.apply(item) for item in msg.collision_objects]
        return all(done)

    def process_octomap(self, msg: Any) -> None:
        """Apply an octomap.

        Raises:
            NotImplementedError: always; the twin has no octomap.
        """
        raise NotImplementedError(
            "PlanningScene.process_octomap is not provided: the twin has no sensors that see an "
            "octomap; add what is in the way as CollisionObjects"
        )

    def remove_all_collision_objects(self) -> None:
        """Remove every object from the world; attached ones stay."""
        self._objects.remove()

    def set_object_color(self, object_id: str, color_msg: Any) -> None:
        """Set the colour of an object by an ObjectColor or a ColorRGBA."""
        self._objects.colors[object_id] = color_msg

    def save_geometry_to_file(self, file_path_and_name: str) -> bool:
        """Write the objects of the world as a .scene file; return whether it could be written."""
        return write_geometry(file_path_and_name, self.name, self._objects)

    def load_geometry_from_file(self, file_path_and_name: str) -> bool:
        """Add the objects of a .scene file; True in any case, as in the real library."""
        for message in read_geometry(file_path_and_name, self.planning_frame):
            self._changes.apply(message)
        return True


def _report(message: str, not_attached: str) -> None:
    kind = "attach_failure" if not_attached else "planning_scene"
    library().server.execution.report(kind, message, object_name=not_attached)
