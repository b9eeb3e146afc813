"""The checks of a planning scene: collisions, constraints, paths."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any

from tracerisk.ros.moveit.move_group import MoveGroupServer
from tracerisk.ros.moveit.path_constraints import PathRule
from tracerisk.ros.moveit.scene.planning_scene import PlanningScene as Objects
from tracerisk.twin.physics.motion import Pose

from .._library import log_error
from .collision_detection import AllowedCollisionMatrix, CollisionRequest, CollisionResult
from .robot_model import RobotModel
from .robot_state import RobotState
from .robot_trajectory import RobotTrajectory

Pairs = list[tuple[str, str]]


class SceneChecks:
    """What a scene is asked of its own robot among its own objects."""

    _server: MoveGroupServer
    _model: RobotModel
    _objects: Objects
    _state: RobotState

    def _frame(self, name: str, state: RobotState | None) -> Pose | None:
        """Return the pose of a frame in the scene."""
        raise NotImplementedError

    # Checks

    def is_state_colliding(self, *args: Any, **kwargs: Any) -> bool:
        """Return whether a state collides: ([robot_state,] joint_model_group_name, verbose=False).

        The state is the current one by default; pairs count of which a link moves with the group.
        """
        state, group, verbose = self._of_state("is_state_colliding", args, kwargs)
        return bool(self._colliding(state, group, verbose=verbose))

    def is_state_valid(
        self, robot_state: RobotState, joint_model_group_name: str, verbose: bool = False
    ) -> bool:
        """Return whether a state is clear of collisions."""
        return not self._colliding(robot_state, joint_model_group_name, verbose=verbose)

    def is_state_constrained(
        self, state: RobotState, constraints: Any, verbose: bool = False
    ) -> bool:
        """Return whether a state keeps to Constraints."""
        rule = PathRule(constraints, self._server.forward, lambda name: self._frame(name, state))
        broken = rule.breach(state.joint_positions)
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
        """Return whether every waypoint is clear of collisions; `invalid_index` stays as it is."""
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
        request, results = collision_request or req, collision_result or result
        if request is None or results is None:
            raise TypeError("check_collision_unpadded() needs a request and a result")
        self._check(request, results, state, acm)

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
        pairs = self._colliding(state or self._state, group, acm, verbose=verbose)
        if among is not None:
            pairs = [pair for pair in pairs if set(pair) <= set(among)]
        if pairs:
            result.collision = True
        if request.contacts:
            result.contact_count = min(len(pairs), request.max_contacts)

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
        pairs = self._server.collisions(state.joint_positions)
        if group:
            links = self._model._group(group)._moved_links()
            moved = links | {n for n, one in self._objects.attached.items() if one.link in links}
            pairs = [pair for pair in pairs if moved.intersection(pair)]
        if verbose:
            for one, two in pairs:
                log_error(f"Found a contact between '{one}' and '{two}'")
        return pairs

    @contextmanager
    def _in_force(self, acm: AllowedCollisionMatrix | None) -> Iterator[None]:
        """Make the twin check, and plan, among the objects of this scene."""
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
