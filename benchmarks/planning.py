"""Plans among obstacles beside OMPL's, and whether what was timed stays clear.

    python benchmarks/planning.py [--robots NAME...] [--goals N] [--plans N]

Goals are poses that an arm reaches clear of itself and of boxes around it, each planned to from
the one before. Both planners get the same solutions of the inverse kinematics as goals and the same
collision model; OMPL's is RRTConnect with its simplification, where `ompl` (BSD) is installed:

    pip install ompl

It looks for collisions as often along a way as ours, at least. Processor times are those of the
search and the simplification. Then plans to random joint positions, timed with their corners
blended, are looked at in steps of a fifth of what the planner looks at.
"""

from __future__ import annotations

import argparse
import importlib
import importlib.util
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import quick
from numpy.typing import NDArray

from tracerisk.common.geometry.shapes import Shape
from tracerisk.twin.motion.clearance import Clearance
from tracerisk.twin.motion.kinematics import Kinematics
from tracerisk.twin.motion.planning import Planner
from tracerisk.twin.motion.rrt_connect import RESOLUTION, segment_is_free
from tracerisk.twin.physics.motion import JointTrajectory, LinkTarget, PlanningError, Pose
from tracerisk.twin.physics.scene_body import SceneBody
from tracerisk.twin.robots.robot import Robot, load_robot
from tracerisk.twin.robots.robot_parts import Scaling

Array = NDArray[np.float64]

ARMS = {"ur5e": "ur_manipulator", "ur10e": "ur_manipulator", "xarm6": "xarm6", "panda": "panda_arm"}
_UPRIGHT = (0.0, 0.0, 0.0, 1.0)
_LIMIT_S = 5.0  # of OMPL for one goal, as MoveIt gives it
_BOXES = (  # place and half lengths, times the reach of the arm: two shelves, pillars, a beam
    ((0.6, 0.0, 0.1), (0.2, 0.3, 0.01)),
    ((0.6, 0.0, 0.4), (0.2, 0.3, 0.01)),
    ((0.6, -0.3, 0.25), (0.2, 0.01, 0.25)),
    ((-0.1, 0.6, 0.3), (0.3, 0.2, 0.01)),
    ((0.38, 0.38, 0.35), (0.03, 0.03, 0.4)),
    ((-0.5, 0.1, 0.3), (0.03, 0.03, 0.4)),
    ((-0.3, -0.45, 0.3), (0.03, 0.03, 0.4)),
    ((0.15, -0.55, 0.6), (0.5, 0.03, 0.03)),
    ((0.0, 0.0, -0.12), (2.0, 2.0, 0.1)),
)


@dataclass(frozen=True)
class Query:
    """Where a plan begins, and the goals that will do: (n_joints,) each."""

    begin: Array
    goals: list[Array]


class Cell:
    """An arm among boxes."""

    def __init__(self, name: str) -> None:
        self.robot: Robot = load_robot(name)
        self.group = ARMS[name]
        self.joints = [self.robot.joint(text) for text in self.robot.group(self.group).joints]
        self.kinematics, self.clearance = Kinematics(self.robot), Clearance(self.robot)
        self.planner = Planner(self.robot, self.kinematics, self.clearance, self.state)
        self.lower = np.array([joint.lower for joint in self.joints])
        self.upper = np.array([joint.upper for joint in self.joints])
        tip = self.robot.group(self.group).tip_link or ""
        drawn = np.random.default_rng(1)
        states = [self.state(self._named(self._drawn(drawn))) for _ in range(40)]
        reach = max(math.hypot(*self.kinematics.forward(state, tip).position) for state in states)
        bodies = []
        for number, (place, size) in enumerate(_BOXES):
            x, y, z = (value * reach for value in place)
            a, b, c = (value * reach for value in size)
            shape = Shape("box", (a, b, c))
            bodies.append(SceneBody(f"box {number}", Pose((x, y, z), _UPRIGHT), (shape,)))
        base = self.robot.base_link
        links = {
            base,
            *(
                attachment.child
                for attachment in self.robot.attachments
                if attachment.parent == base
            ),
        }
        self.clearance.declare(
            bodies, [frozenset((f"box {len(_BOXES) - 1}", link)) for link in links]
        )
        self._generator = np.random.default_rng(2)

    def state(self, given: Any) -> dict[str, float]:
        """Return positions of all joints with some as given."""
        return {**self.robot.initial_state, **given}

    def _named(self, values: Array) -> dict[str, float]:
        return dict(zip((joint.name for joint in self.joints), values.tolist(), strict=True))

    def _drawn(self, generator: np.random.Generator) -> Array:
        low, high = np.maximum(self.lower, -np.pi), np.minimum(self.upper, np.pi)
        drawn: Array = generator.uniform(low, high)
        return drawn

    def is_free(self) -> Callable[[Array], bool]:
        """Return what says whether positions are clear."""
        return self.clearance.judge(self.joints, self.robot.initial_state)

    def free_position(self) -> Array:
        """Return positions that are clear."""
        is_free = self.is_free()
        while True:
            drawn = self._drawn(self._generator)
            if is_free(drawn):
                return drawn

    def queries(self, count: int) -> list[Query]:
        """Return goals that are reached clear, each from the one before."""
        result: list[Query] = []
        begin = self.free_position()
        while len(result) < count:
            there = self.state(self._named(self.free_position()))
            tip = self.robot.group(self.group).tip_link or ""
            target = LinkTarget(tip, self.kinematics.forward(there, tip))
            seed = self.state(self._named(begin))
            try:
                solutions = list(self.planner.reach_each(self.group, [target], seed=seed))
            except PlanningError:
                continue
            goals = [
                np.array([solution[joint.name] for joint in self.joints]) for solution in solutions
            ]
            result.append(Query(begin, goals))
            begin = goals[0]
        return result

    def way(self, query: Query) -> list[Array] | None:
        """Return the twin's way, None where it finds none."""
        start = self.state(self._named(query.begin))
        try:
            return self.clearance.way(self.joints, start, query.begin, query.goals)
        except PlanningError:
            return None

    def plan(self) -> tuple[JointTrajectory | None, bool]:
        """Return a timed plan between random positions, and whether it is no straight one."""
        start, goal = self._named(self.free_position()), self._named(self.free_position())
        try:
            plan = self.planner.joints(self.group, goal, start, scaling=Scaling(1.0, 1.0))
        except PlanningError:
            return None, False
        return plan, len(plan.time) > 20


def ompl_way(cell: Cell, query: Query) -> list[Array] | None:
    """Return the way of OMPL's RRTConnect, simplified, None where it finds none."""
    ob: Any = importlib.import_module("ompl.base")
    og: Any = importlib.import_module("ompl.geometric")
    importlib.import_module("ompl.util").noOutputHandler()
    count, is_free = len(cell.joints), cell.is_free()
    space = ob.RealVectorStateSpace(count)
    bounds = ob.RealVectorBounds(count)
    for i in range(count):
        bounds.setLow(i, float(cell.lower[i]))
        bounds.setHigh(i, float(cell.upper[i]))
    space.setBounds(bounds)
    setup = og.SimpleSetup(space)
    setup.setStateValidityChecker(lambda state: is_free(np.array([state[i] for i in range(count)])))
    information = setup.getSpaceInformation()
    information.setStateValidityCheckingResolution(RESOLUTION / space.getMaximumExtent())

    def state(values: Array) -> Any:
        made = space.allocState()
        for i, value in enumerate(values.tolist()):
            made[i] = value
        return made

    setup.setStartState(state(query.begin))
    goals = ob.GoalStates(information)
    for goal in query.goals:
        goals.addState(state(goal))
    setup.setGoal(goals)
    setup.setPlanner(og.RRTConnect(information))
    if not setup.solve(_LIMIT_S) or not setup.haveExactSolutionPath():
        return None
    setup.simplifySolution()
    path = setup.getSolutionPath()
    points = [path.getState(k) for k in range(path.getStateCount())]
    return [np.array([point[i] for i in range(count)]) for point in points]


def measured(
    cell: Cell, queries: Sequence[Query], planner: Callable[[Cell, Query], list[Array] | None]
) -> tuple[int, int, float, float]:
    """Return goals solved, ways that are not clear, their length [rad] and processor time [s]."""
    is_free = cell.is_free()
    solved = unclear = 0
    length = spent = 0.0
    for query in queries:
        begin = time.process_time()
        way = planner(cell, query)
        spent += time.process_time() - begin
        if way is None:
            continue
        solved += 1
        pairs = list(pairwise(way))
        length += sum(float(np.linalg.norm(b - a)) for a, b in pairs)
        unclear += not all(segment_is_free(a, b, is_free) for a, b in pairs)
    return solved, unclear, length, spent


def colliding(cell: Cell, plan: JointTrajectory) -> int:
    """Return how many points of a timed plan collide, looked at closely."""
    is_free, count = cell.is_free(), 0
    for k in range(len(plan.time) - 1):
        width = float(plan.time[k + 1] - plan.time[k])
        p0, p1 = plan.position[k], plan.position[k + 1]
        v0, v1 = plan.velocity[k] * width, plan.velocity[k + 1] * width
        steps = max(1, math.ceil(float(np.abs(p1 - p0).max()) / (RESOLUTION / 5)))
        for u in np.linspace(0.0, 1.0, steps, endpoint=False).tolist():
            cubic = (2 * u**3 - 3 * u**2 + 1) * p0 + (u**3 - 2 * u**2 + u) * v0
            cubic = cubic + (3 * u**2 - 2 * u**3) * p1 + (u**3 - u**2) * v1
            count += not is_free(cubic)
    return count


def main(arguments: Sequence[str] | None = None) -> None:
    """Plan by both and print how they compare."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("--robots", nargs="+", default=list(ARMS), choices=ARMS, metavar="NAME")
    parser.add_argument("--goals", type=int, default=30, help="goals of each arm")
    parser.add_argument("--plans", type=int, default=50, help="timed plans of each arm")
    options = quick.parsed(
        parser, arguments, robots=lambda: ["ur5e"], goals=lambda: 2, plans=lambda: 1
    )
    is_there = importlib.util.find_spec("ompl") is not None
    print("| robot | planner | solved | not clear | length | processor time | ratio |")
    print("|---|---|---|---|---|---|---|")
    cells = {name: Cell(name) for name in options.robots}
    for name, cell in cells.items():
        queries = cell.queries(options.goals)
        ours = measured(cell, queries, Cell.way)
        rows = {"tracerisk": ours}
        if is_there:
            rows["OMPL"] = measured(cell, queries, ompl_way)
        for planner, (solved, unclear, length, spent) in rows.items():
            ratio = f"{ours[3] / spent:.2f}" if planner == "OMPL" else ""
            print(
                f"| {name} | {planner} | {solved} of {len(queries)} | {unclear} "
                f"| {length:.0f} rad | {spent:.2f} s | {ratio} |",
                flush=True,
            )
    if not is_there:
        print("OMPL is not installed: pip install ompl")
    print("| robot | timed plans | of them not straight | colliding points |")
    print("|---|---|---|---|")
    for name, cell in cells.items():
        made: list[JointTrajectory] = []
        bent = 0
        while len(made) < options.plans:
            plan, is_bent = cell.plan()
            if plan is not None:
                made.append(plan)
                bent += is_bent
        print(
            f"| {name} | {len(made)} | {bent} | "
            f"{sum(colliding(cell, joint_trajectory) for joint_trajectory in made)} |"
        )


if __name__ == "__main__":
    main()
