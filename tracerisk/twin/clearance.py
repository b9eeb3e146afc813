"""Judge paths against what can collide: straight where that is free, else a way around."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from tracerisk.twin.collision import CollisionWorld, Pair
from tracerisk.twin.motion import PlanningError
from tracerisk.twin.robot import Joint, Robot
from tracerisk.twin.rrt_connect import connect, segment_is_free
from tracerisk.twin.scene_body import SceneBody

Array = NDArray[np.float64]


class Clearance:
    """What a controller has declared, and whether the arm is clear of it and of itself.

    Links that touch one another where a plan begins may go on to: the shapes of links are
    primitives that overstate them, and an arm cannot stand inside itself.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._world = self._alone = CollisionWorld(robot)
        self._columns = self._alone.columns([joint.name for joint in robot.joints])

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
        where no way was found.
        """
        collides = self._judge(members, start)
        if pair := collides(begin):
            raise PlanningError(
                "start_in_collision",
                f"the arm begins in collision: {_touching(pair)}; move or remove the object, or "
                "allow the collision",
            )
        if pair := collides(goal):
            raise PlanningError("collision", f"the goal is in collision: {_touching(pair)}")

        def is_free(values: Array) -> bool:
            return collides(values) is None

        if segment_is_free(begin, goal, is_free):
            return None
        lower = np.array([joint.lower for joint in members])
        upper = np.array([joint.upper for joint in members])
        path = connect(begin, goal, np.minimum(lower, begin), np.maximum(upper, begin), is_free)
        if path is None:
            raise PlanningError(
                "no_plan",
                "no way to the goal clear of the planning scene and of the arm itself was found",
            )
        return path

    def free_share(
        self, members: Sequence[Joint], start: Mapping[str, float], path: Sequence[Array]
    ) -> int:
        """Return how many points of a path come before the first collision, the first included."""
        collides = self._judge(members, start)

        def is_free(values: Array) -> bool:
            return collides(values) is None

        if not is_free(path[0]):
            return 1
        for count in range(1, len(path)):
            if not segment_is_free(path[count - 1], path[count], is_free):
                return count
        return len(path)

    def _judge(
        self, members: Sequence[Joint], start: Mapping[str, float]
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
                    for pair in world.pairs(configuration)
                    if frozenset(pair) not in from_the_start
                ),
                None,
            )

        return collides


def _touching(pair: tuple[str, str]) -> str:
    return f"'{pair[0]}' touches '{pair[1]}'"
