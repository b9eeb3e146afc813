"""Judge paths against what can collide: straight where that is free, else a way around."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from tracerisk.twin.motion.rrt_connect import connect, segment_is_free
from tracerisk.twin.physics.collision import CLEAR, CollisionWorld, Pair
from tracerisk.twin.physics.motion import PlanningError
from tracerisk.twin.physics.scene_body import SceneBody
from tracerisk.twin.robots.robot import Joint, Robot

Array = NDArray[np.float64]


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
        found = self.collisions(positions)
        return found[0] if found else None

    def way(
        self, members: Sequence[Joint], start: Mapping[str, float], begin: Array, goal: Array
    ) -> list[Array] | None:
        """Return the free path from `begin` to `goal`, None where the straight line is free.

        begin, goal: (n_members,) of the joints `members`; the others stay where `start` has them.

        Raises PlanningError("start_in_collision"), ("collision") for the goal, and ("no_plan")
        where no way was found, or where an end breaks the rule of `keeping`.
        """
        collides = self._judge(members, start)
        breach, excess = self._rule_of(members, start)
        if pair := collides(begin):
            raise PlanningError(
                "start_in_collision",
                f"the arm begins in collision: {_touching(pair)}; move or remove the object, or "
                "allow the collision",
            )
        if pair := collides(goal):
            raise PlanningError("collision", f"the goal is in collision: {_touching(pair)}")

        for what, values in (("start", begin), ("goal", goal)):
            if broken := breach(values):
                raise PlanningError("no_plan", f"the {what} breaks the path constraints: {broken}")

        def is_free(values: Array) -> bool:
            return breach(values) is None and collides(values) is None

        if segment_is_free(begin, goal, is_free):
            return None
        lower = np.minimum([joint.lower for joint in members], begin)
        upper = np.maximum([joint.upper for joint in members], begin)
        ruled = None if self._rule is None else excess
        path = connect(begin, goal, lower, upper, is_free, ruled)
        if path is None:
            within = " that keeps to the path constraints" if self._rule is not None else ""
            raise PlanningError(
                "no_plan",
                f"no way to the goal{within} clear of the planning scene and of the arm itself "
                "was found",
            )
        # A way that grazes a body would rub on it or hook into its edge: rather one further off.
        nears = self._judge(members, start, clear=CLEAR)
        if nears(begin) or nears(goal):
            return path

        def is_clear(values: Array) -> bool:
            return breach(values) is None and nears(values) is None

        return connect(begin, goal, lower, upper, is_clear, ruled) or path

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
        collides = self._judge(members, start)
        breach, _ = self._rule_of(members, start)

        def is_free(values: Array) -> bool:
            if breach(values) is not None:
                return False
            return not avoid_collisions or collides(values) is None

        if not is_free(path[0]):
            return 1
        for count in range(1, len(path)):
            if not segment_is_free(path[count - 1], path[count], is_free):
                return count
        return len(path)

    def _judge(
        self, members: Sequence[Joint], start: Mapping[str, float], *, clear: float = 0.0
    ) -> Callable[[Array], tuple[str, str] | None]:
        world = self._world
        configuration = world.configuration(start)
        columns = world.columns([joint.name for joint in members])
        from_the_start = world.touching_links(configuration)

        def collides(values: Array) -> tuple[str, str] | None:
            configuration[columns] = values
            return next(
                (
                    pair
                    for pair in world.pairs(configuration, clear=clear)
                    if frozenset(pair) not in from_the_start
                ),
                None,
            )

        return collides

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


def _touching(pair: tuple[str, str]) -> str:
    return f"'{pair[0]}' touches '{pair[1]}'"
