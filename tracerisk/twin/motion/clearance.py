"""Judge paths against what can collide: straight where that is free, else a way around."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import chain, pairwise
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from tracerisk.twin.motion.rrt_connect import (
    FINE,
    ITERATIONS,
    RESOLUTION,
    connect,
    segment_is_free,
)
from tracerisk.twin.physics.collision import CLEAR, CollisionWorld, Pair
from tracerisk.twin.physics.motion import PlanningError
from tracerisk.twin.physics.scene_body import SceneBody
from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.robots.robot_parts import Joint

Array = NDArray[np.float64]

_MOST_GOALS = 12  # that a way is looked for to at once
_CLEAR_ITERATIONS = 1500  # of the search for a way that keeps away from bodies


class PathRule(Protocol):
    """What a path must keep to besides being clear, such as a tool that stays upright."""

    def breach(self, positions: Mapping[str, float]) -> str | None:
        """Return in words what joint positions [rad or m] break, None for nothing."""

    def excess(self, positions: Mapping[str, float]) -> Array:
        """Return how far each part of the rule is broken [rad or m]: (n_parts,), 0 for kept."""


class Clearance:
    """What a controller has declared, and whether the arm is clear of it and of itself.

    Links that touch one another where a plan begins may go on to: the shapes of links are
    primitives that overstate them, and an arm cannot stand inside itself.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._world = self._alone = CollisionWorld(robot)
        self._columns = self._alone.columns([joint.name for joint in robot.joints])
        self._rule: PathRule | None = None

    def declare(self, bodies: Sequence[SceneBody], allowed: Iterable[Pair] = ()) -> None:
        """Take `bodies` for all that is declared; `allowed` pairs of names may touch.

        Raises RobotError for a body that cannot be built, and then keeps those before.
        """
        allowed = frozenset(allowed)
        if self._world.declared == (tuple(bodies), allowed):
            return  # as from a loop that declares the same table all the time
        self._world = CollisionWorld(self._robot, bodies, allowed, by_build=self._world.by_build)

    @contextmanager
    def among(self, bodies: Sequence[SceneBody], allowed: Iterable[Pair] = ()) -> Iterator[None]:
        """Take `bodies` for all that is declared within the block; raise as `declare`."""
        before = self._world
        self.declare(bodies, allowed)
        try:
            yield
        finally:
            self._world = before

    @contextmanager
    def keeping(self, rule: PathRule) -> Iterator[None]:
        """Apply a rule to every path and goal within the block."""
        before, self._rule = self._rule, rule
        try:
            yield
        finally:
            self._rule = before

    @property
    def has_rule(self) -> bool:
        """Whether paths must keep to a rule."""
        return self._rule is not None

    def breach(self, positions: Mapping[str, float]) -> str | None:
        """Return what of the rule joint positions break, in words; None for nothing."""
        return None if self._rule is None else self._rule.breach(positions)

    def of_itself(self, positions: Array) -> list[tuple[str, str]]:
        """Return the pairs of links that collide; positions: (n_joints,), of the robot's joints."""
        configuration = np.empty(len(positions))
        configuration[self._columns] = positions
        return self._alone.pairs(configuration)

    def collisions(self, positions: Mapping[str, float]) -> list[tuple[str, str]]:
        """Return the names of what collides at joint positions, pair by pair."""
        return self._world.pairs(self._world.configuration(positions))

    def collision(self, positions: Mapping[str, float]) -> tuple[str, str] | None:
        """Return the names of a pair that collides at joint positions, None where all is clear."""
        collisions = self.collisions(positions)
        return collisions[0] if collisions else None

    def way(
        self,
        members: Sequence[Joint],
        start: Mapping[str, float],
        begin: Array,
        goals: Iterable[Array],
    ) -> list[Array]:
        """Return a free path from `begin` to one of `goals`: straight to the first where that is.

        begin, goals: (n_members,) of the joints `members`; the others stay where `start` has them.
        Goals are taken from `goals` until one is found that the straight line to it is free.

        Raises PlanningError("start_in_collision"), ("collision") for the goals, and ("no_plan")
        where no way was found, or where an end breaks the rule of `keeping`.
        """
        breach, excess = self._rule_of(members, start)
        touches = self._judge(members, start)
        goals = iter(goals)
        first = next(goals)  # a goal that is none is refused before a start in collision
        if touches(begin):
            raise PlanningError(
                "start_in_collision",
                f"the arm begins in collision: {self._touching(members, start, begin)}; move or "
                "remove the object, or allow the collision",
            )
        broken = breach(begin)

        def is_free(values: Array) -> bool:
            return breach(values) is None and not touches(values)

        failure: PlanningError | None = None
        free: list[Array] = []
        for goal in chain([first], goals):
            if touches(goal):
                pair = self._touching(members, start, goal)
                failure = failure or PlanningError("collision", f"the goal is in collision: {pair}")
                continue
            if reason := broken or breach(goal):
                end = "start" if broken else "goal"
                message = f"the {end} breaks the path constraints: {reason}"
                failure = failure or PlanningError("no_plan", message)
                continue
            if segment_is_free(begin, goal, is_free, self._resolutions[-1]):
                return [begin, goal]
            free.append(goal)
            if len(free) == _MOST_GOALS:
                break
        if not free:
            raise failure or PlanningError("no_plan", "there is no goal")
        room = _room(members, [begin, *free])
        ruled = None if self._rule is None else excess
        # A way that grazes a body would rub on it or hook into its edge: rather one further off.
        nears = self._judge(members, start, clear=CLEAR)

        def is_clear(values: Array) -> bool:
            return breach(values) is None and not nears(values)

        path: list[Array] | None = None
        clear = [goal for goal in free if not nears(goal)]
        if clear and not nears(begin):
            path = self._connected(begin, clear, room, is_clear, ruled, _CLEAR_ITERATIONS)
        path = path or self._connected(begin, free, room, is_free, ruled, ITERATIONS)
        if path is None:
            within = " that keeps to the path constraints" if self._rule is not None else ""
            raise PlanningError(
                "no_plan",
                f"no way to the goal{within} clear of the planning scene and of the arm itself "
                "was found",
            )
        return path

    def _connected(
        self,
        begin: Array,
        goals: Sequence[Array],
        room: tuple[Array, Array],
        is_free: Callable[[Array], bool],
        excess: Callable[[Array], Array] | None,
        iterations: int,
    ) -> list[Array] | None:
        """Return a path that is free at the finest resolution, None where none was found."""
        finest = self._resolutions[-1]
        path: list[Array] | None = None
        for resolution in self._resolutions:
            path = connect(
                begin, goals, *room, is_free, excess, iterations=iterations, resolution=resolution
            )
            if path is None or all(
                segment_is_free(a, b, is_free, finest) for a, b in pairwise(path)
            ):
                break
        return path

    @property
    def _resolutions(self) -> tuple[float, ...]:
        """How closely a path is looked at: that of its search, and that of what was found.

        Bodies and rules may be thinner than the steps of a search; links are not, and MoveIt looks
        no closer.
        """
        is_thin = self._world.has_bodies or self._rule is not None
        return (RESOLUTION, FINE) if is_thin else (RESOLUTION,)

    def free_share(
        self,
        members: Sequence[Joint],
        start: Mapping[str, float],
        path: Sequence[Array],
        *,
        avoid_collisions: bool = True,
    ) -> int:
        """Return how many points of a path come before the first that is not free.

        The first point is always counted. What breaks the rule of `keeping` is not free; what
        collides where `avoid_collisions`.
        """
        is_free = self.judge(members, start, avoid_collisions=avoid_collisions)
        if not is_free(path[0]):
            return 1
        for count in range(1, len(path)):
            if not segment_is_free(path[count - 1], path[count], is_free):
                return count
        return len(path)

    def judge(
        self,
        members: Sequence[Joint],
        start: Mapping[str, float],
        *,
        avoid_collisions: bool = True,
    ) -> Callable[[Array], bool]:
        """Return what says of positions of `members` whether they are free.

        What breaks the rule of `keeping` is not free; what collides where `avoid_collisions`.
        """
        touches = self._judge(members, start)
        breach, _ = self._rule_of(members, start)

        def is_free(values: Array) -> bool:
            if breach(values) is not None:
                return False
            return not (avoid_collisions and touches(values))

        return is_free

    def _judge(
        self, members: Sequence[Joint], start: Mapping[str, float], *, clear: float = 0.0
    ) -> Callable[[Array], bool]:
        world = self._world
        configuration = world.configuration(start)
        columns = world.columns([joint.name for joint in members])
        depths = world.depths(clear=clear, passing=world.touching_links(configuration))

        def touches(values: Array) -> bool:
            configuration[columns] = values
            return world.touches(configuration, depths)

        return touches

    def _touching(self, members: Sequence[Joint], start: Mapping[str, float], values: Array) -> str:
        """Return in words the first pair that collides, but for links that do at the start."""
        configuration = self._world.configuration(start)
        passing = self._world.touching_links(configuration)
        configuration[self._world.columns([joint.name for joint in members])] = values
        pairs = self._world.pairs(configuration)
        one, two = next(pair for pair in pairs if frozenset(pair) not in passing)
        return f"'{one}' touches '{two}'"

    def _rule_of(
        self, members: Sequence[Joint], start: Mapping[str, float]
    ) -> tuple[Callable[[Array], str | None], Callable[[Array], Array]]:
        """Return the breach and the excess of the rule at positions of the joints `members`."""
        names = [joint.name for joint in members]

        def whole(values: Array) -> dict[str, float]:
            return {**start, **dict(zip(names, values.tolist(), strict=True))}

        rule = self._rule
        if rule is None:
            return lambda _: None, lambda _: np.zeros(0)
        return lambda values: rule.breach(whole(values)), lambda values: rule.excess(whole(values))


def _room(members: Sequence[Joint], ends: Sequence[Array]) -> tuple[Array, Array]:
    """Return within which positions a way is looked for: within limits, and a turn of its ends."""
    lower = np.array([joint.lower for joint in members])
    upper = np.array([joint.upper for joint in members])
    least, greatest = np.min(ends, axis=0), np.max(ends, axis=0)
    endless = np.array([joint.type == "continuous" for joint in members])
    turns = np.array([joint.type != "prismatic" for joint in members])
    lower[endless], upper[endless] = -np.inf, np.inf
    lower = np.where(turns, np.maximum(lower, least - np.pi), lower)
    upper = np.where(turns, np.minimum(upper, greatest + np.pi), upper)
    return np.minimum(lower, least), np.maximum(upper, greatest)
