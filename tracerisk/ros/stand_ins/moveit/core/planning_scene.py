"""The robot among the objects that planning knows of."""

from __future__ import annotations

import copy
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracerisk.ros.path_constraints import violation
from tracerisk.ros.planning_scene import PlanningScene as Objects
from tracerisk.ros.poses import ORIGIN
from tracerisk.ros.scene_changes import SceneChanges
from tracerisk.twin.motion import JointTrajectory, Pose

from .._library import library, log_error
from ._geometry_file import read_geometry, write_geometry
from ._matrices import matrix
from ._scene_message import scene_message
from ._world import World
from .collision_detection import AllowedCollisionMatrix, CollisionRequest, CollisionResult
from .robot_model import RobotModel
from .robot_state import RobotState
from .robot_trajectory import RobotTrajectory
from .transforms import Transforms

__all__ = ["PlanningScene"]

Pairs = list[tuple[str, str]]


class PlanningScene:
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
        self._changes = SceneChanges(objects, self._server.robot, self._link_pose, _tell)

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
        matrix_ = self.allowed_collision_matrix
        return scene_message(self.name, self._model, self._state, self._objects, matrix_)

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
        """Tell whether a frame is known: a link, or an object of the scene.

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
        return SceneChanges(self._objects, self._server.robot, pose, _tell).frame(name)

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
        """Write the objects of the world as a .scene file; tell whether it could be written."""
        return write_geometry(file_path_and_name, self.name, self._objects)

    def load_geometry_from_file(self, file_path_and_name: str) -> bool:
        """Add the objects of a .scene file; True in any case, as in the real library."""
        for message in read_geometry(file_path_and_name, self.planning_frame):
            self._changes.apply(message)
        return True

    # Checks

    def is_state_colliding(self, *args: Any, **kwargs: Any) -> bool:
        """Tell whether a state collides: ([robot_state,] joint_model_group_name, verbose=False).

        The state is the current one by default; pairs count of which a link moves with the group.
        """
        state, group, verbose = self._of_state("is_state_colliding", args, kwargs)
        return bool(self._colliding(state, group, verbose=verbose))

    def is_state_valid(
        self, robot_state: RobotState, joint_model_group_name: str, verbose: bool = False
    ) -> bool:
        """Tell whether a state is clear of collisions."""
        return not self._colliding(robot_state, joint_model_group_name, verbose=verbose)

    def is_state_constrained(
        self, state: RobotState, constraints: Any, verbose: bool = False
    ) -> bool:
        """Tell whether a state keeps to Constraints."""
        positions = state.joint_positions
        values = np.array([list(positions.values())])
        point = JointTrajectory(tuple(positions), np.zeros(1), values, np.zeros_like(values))
        broken = violation(
            constraints, point, self._server.forward, lambda name: self._frame(name, state)
        )
        if broken is not None and verbose:
            log_error(broken)
        return broken is None

    def is_path_valid(
        self,
        trajectory: RobotTrajectory,
        joint_model_group_name: str,
        verbose: bool = False,
        invalid_index: Any = None,
    ) -> bool:
        """Tell whether every waypoint is clear of collisions; `invalid_index` stays as it is."""
        with self._in_force(None):
            return not any(
                self._pairs(waypoint, joint_model_group_name, verbose=verbose)
                for waypoint, _ in trajectory
            )

    def check_collision(
        self,
        collision_request: CollisionRequest,
        collision_result: CollisionResult,
        state: RobotState | None = None,
        acm: AllowedCollisionMatrix | None = None,
    ) -> None:
        """Look for collisions as asked for, and fill in the result."""
        self._check(collision_request, collision_result, state, acm)

    def check_collision_unpadded(
        self,
        collision_request: CollisionRequest | None = None,
        collision_result: CollisionResult | None = None,
        state: RobotState | None = None,
        acm: AllowedCollisionMatrix | None = None,
        *,
        req: CollisionRequest | None = None,
        result: CollisionResult | None = None,
    ) -> None:
        """Look for collisions; the twin pads no links, so that it is check_collision."""
        request, found = collision_request or req, collision_result or result
        if request is None or found is None:
            raise TypeError("check_collision_unpadded() needs a request and a result")
        self._check(request, found, state, acm)

    def check_self_collision(
        self,
        collision_request: CollisionRequest,
        collision_result: CollisionResult,
        state: RobotState | None = None,
        acm: AllowedCollisionMatrix | None = None,
    ) -> None:
        """Look for collisions of the robot, and what it holds, with itself."""
        own = {*self._server.robot.link_names, *self._objects.attached}
        self._check(collision_request, collision_result, state, acm, among=own)

    # How

    def _check(
        self,
        request: CollisionRequest,
        result: CollisionResult,
        state: RobotState | None,
        acm: AllowedCollisionMatrix | None,
        among: Iterable[str] | None = None,
    ) -> None:
        for wanted, what in ((request.distance, "distance"), (request.cost, "cost")):
            if wanted:
                raise NotImplementedError(
                    f"CollisionRequest.{what} is not provided: the twin answers whether bodies "
                    f"collide, and counts them; leave '{what}' False"
                )
        group, verbose = request.joint_model_group_name, request.verbose
        found = self._colliding(state or self._state, group, acm, verbose=verbose)
        if among is not None:
            found = [pair for pair in found if set(pair) <= set(among)]
        if found:
            result.collision = True
        if request.contacts:
            result.contact_count = min(len(found), request.max_contacts)

    def _colliding(
        self,
        state: RobotState,
        group: str,
        acm: AllowedCollisionMatrix | None = None,
        *,
        verbose: bool = False,
    ) -> Pairs:
        with self._in_force(acm):
            return self._pairs(state, group, verbose=verbose)

    def _pairs(self, state: RobotState, group: str, *, verbose: bool) -> Pairs:
        found = self._server.collisions(state.joint_positions)
        if group:
            links = self._model._group(group)._moved_links()
            moved = links | {n for n, one in self._objects.attached.items() if one.link in links}
            found = [pair for pair in found if moved.intersection(pair)]
        if verbose:
            for one, two in found:
                log_error(f"Found a contact between '{one}' and '{two}'")
        return found

    @contextmanager
    def _in_force(self, acm: AllowedCollisionMatrix | None) -> Iterator[None]:
        """Let the twin check, and plan, among the objects of this scene."""
        if acm is None and self._objects is self._server.scene:
            yield
            return
        objects = self._objects
        if acm is not None:
            objects = Objects()
            objects.world.update(self._objects.world)
            objects.attached.update(self._objects.attached)
            objects.allowed = acm._allowed()
        with self._server.planning_in(objects):
            yield

    def _of_state(
        self, method: str, args: tuple[Any, ...], kwargs: dict[str, Any]
    ) -> tuple[RobotState, str, bool]:
        names = ["robot_state", "joint_model_group_name", "verbose"]
        if args and isinstance(args[0], str):
            names = names[1:]
        given = {**dict(zip(names, args, strict=False)), **kwargs}
        state = given.pop("robot_state", self._state)
        group = given.pop("joint_model_group_name", None)
        verbose = given.pop("verbose", False)
        if given or len(args) > len(names) or group is None or not isinstance(state, RobotState):
            raise TypeError(
                f"{method}(): incompatible function arguments. It takes "
                "(joint_model_group_name: str, verbose: bool = False) or "
                "(robot_state: RobotState, joint_model_group_name: str, verbose: bool = False)"
            )
        return state, group, bool(verbose)


def _tell(message: str) -> None:
    library().server.execution.tell("planning_scene", message)
