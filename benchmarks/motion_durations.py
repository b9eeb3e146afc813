"""How long motions last beside an independent solution of the same problem.

    python benchmarks/motion_durations.py [--robots NAME...] [--motions N]

Random motions of each robot within its limits, at 0.1, 0.5 and 1 of its rated figures: straight,
and through three via points whose corners are blended within 0.1 rad. Each is timed by the twin's
planner and by a linear program. Along the path the squared speed x of a time-optimal trajectory is
at every place the highest that any trajectory within the limits has there, so it maximises the sum
of x under |q' u + q'' x| <= a, x <= (v / |q'|)^2 and u = dx/ds / 2, all linear in x at the points
of a fine grid. That path and this program share no code with the planner.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import quick
from numpy.typing import NDArray
from scipy.optimize import linprog
from scipy.sparse import csr_array, vstack

from tracerisk.twin.motion.timing import PATH_TOLERANCE, along_path
from tracerisk.twin.robots.robot import Robot, load_robot

Array = NDArray[np.float64]
Piece = tuple[float, Array, Array]  # length of a cell, tangents and curvatures there

ROBOTS = ("panda", "ur5e", "iiwa14", "gen3")
SCALINGS = (0.1, 0.5, 1.0)
_LINE_CELLS, _ARC_STEP = 80, 0.02


@dataclass(frozen=True)
class Motion:
    """One motion: its waypoints (n, n_joints) and the scaled limits (n_joints,)."""

    kind: str
    scaling: float
    waypoints: Array
    velocity: Array
    acceleration: Array


def optimal_duration(motion: Motion, tolerance: float = PATH_TOLERANCE) -> float:
    """Return the shortest duration of a motion along its blended path [s], by linear program."""
    width, first, second = _discretised(motion.waypoints, tolerance)
    cells = len(width)
    # x at the ends of the cells; those of the whole path are 0. A cell's u = (x1 - x0) / 2 width
    # and its x in the middle are linear in both.
    rows, columns = (
        np.repeat(np.arange(cells), 2),
        np.stack((np.arange(cells), np.arange(cells) + 1)),
    )
    shape = (cells, cells + 1)
    slope = np.stack((-0.5 / width, 0.5 / width), axis=1).ravel()
    rise = csr_array((slope, (rows, columns.T.ravel())), shape=shape)
    middle = csr_array((np.full(2 * cells, 0.5), (rows, columns.T.ravel())), shape=shape)
    bound: list[csr_array] = []
    for tangent, curvature in zip(first.T, second.T, strict=True):
        joint = rise.multiply(tangent[:, None]) + middle.multiply(curvature[:, None])
        bound += [csr_array(joint), csr_array(-joint)]
    limit = np.repeat(motion.acceleration, 2 * cells)
    highest = np.square(motion.velocity / np.maximum(np.abs(first), 1e-12)).min(axis=1)
    top = np.minimum(np.append(highest, np.inf), np.insert(highest, 0, np.inf))
    top[0] = top[-1] = 0.0
    result = linprog(
        -np.ones(cells + 1),
        A_ub=vstack(bound),
        b_ub=limit,
        bounds=np.column_stack((np.zeros(cells + 1), top)),
        method="highs",
    )
    if result.status != 0:
        raise RuntimeError(f"the linear program has no solution: {result.message}")
    speed = np.sqrt(np.maximum(result.x, 0.0))
    return float((2 * width / (speed[:-1] + speed[1:])).sum())


def _discretised(waypoints: Array, tolerance: float) -> tuple[Array, Array, Array]:
    """Return width, tangent and curvature of each cell of the blended path."""
    pieces: list[Piece] = []
    at = waypoints[0]
    for before, corner, after in zip(waypoints, waypoints[1:], waypoints[2:], strict=False):
        arrive, leave = corner - before, after - corner
        reach = min(float(np.linalg.norm(arrive)), float(np.linalg.norm(leave))) / 2
        arrive, leave = arrive / np.linalg.norm(arrive), leave / np.linalg.norm(leave)
        turn = math.acos(float(np.clip(arrive @ leave, -1.0, 1.0)))
        # A circle tangent to both legs that misses the corner by the tolerance at most.
        radius = min(reach / math.tan(turn / 2), tolerance / (1 / math.cos(turn / 2) - 1))
        entry = corner - radius * math.tan(turn / 2) * arrive
        pieces += _straight(at, entry)
        inward = leave - (leave @ arrive) * arrive
        inward /= np.linalg.norm(inward)
        count = max(4, math.ceil(turn / _ARC_STEP))
        for k in range(count):
            angle = (k + 0.5) * turn / count
            tangent = math.cos(angle) * arrive + math.sin(angle) * inward
            normal = math.cos(angle) * inward - math.sin(angle) * arrive
            pieces.append((radius * turn / count, tangent, normal / radius))
        at = corner + radius * math.tan(turn / 2) * leave
    pieces += _straight(at, waypoints[-1])
    width, first, second = zip(*pieces, strict=True)
    return np.array(width), np.array(first), np.array(second)


def _straight(begin: Array, end: Array) -> list[Piece]:
    length = float(np.linalg.norm(end - begin))
    if length < 1e-9:
        return []
    # Denser towards both ends, where the speed changes most along the way.
    place = (1 - np.cos(np.linspace(0.0, math.pi, _LINE_CELLS + 1))) / 2
    direction = (end - begin) / length
    return [(float(step), direction, np.zeros_like(direction)) for step in np.diff(place) * length]


def motions_of(robot: Robot, count: int, seed: int) -> list[Motion]:
    """Return random motions of an arm within its limits, half of them with three via points."""
    generator = np.random.default_rng(seed)
    arm = robot.arm_joints
    lower = np.array([max(joint.lower, -math.pi) for joint in arm])
    upper = np.array([min(joint.upper, math.pi) for joint in arm])
    velocity = np.array([joint.velocity_limit for joint in arm])
    acceleration = np.array([joint.acceleration_limit for joint in arm])
    motions = []
    for number in range(count):
        kind, points = ("straight", 2) if number % 2 == 0 else ("three via points", 5)
        scaling = SCALINGS[number // 2 % len(SCALINGS)]
        waypoints = generator.uniform(lower, upper, (points, len(arm)))
        motions.append(Motion(kind, scaling, waypoints, velocity * scaling, acceleration * scaling))
    return motions


def main(arguments: Sequence[str] | None = None) -> None:
    """Time the motions by both and print how far they differ."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("--robots", nargs="+", default=ROBOTS, help="names of shipped robots")
    parser.add_argument("--motions", type=int, default=50, help="motions of each robot")
    options = quick.parsed(parser, arguments, robots=lambda: ["panda"], motions=lambda: 1)
    print("| robot | motions | scaling | mean duration | mean difference | greatest | planner |")
    print("|---|---|---|---|---|---|---|")
    for seed, name in enumerate(options.robots):
        rows: dict[tuple[str, float], list[tuple[float, float, float]]] = {}
        for motion in motions_of(load_robot(name), options.motions, seed):
            begin = time.perf_counter()
            ours = float(along_path(motion.waypoints, motion.velocity, motion.acceleration)[0][-1])
            spent = time.perf_counter() - begin
            entry = (ours, optimal_duration(motion), spent)
            rows.setdefault((motion.kind, motion.scaling), []).append(entry)
        for (kind, scaling), item in sorted(rows.items()):
            ours_s, optimal_s, spent_s = np.array(item).T
            error = ours_s / optimal_s - 1.0
            differs = f"{error.mean():+.2%} | {np.abs(error).max():.2%}"
            print(
                f"| {name} | {len(item)} {kind} | {scaling:g} | {ours_s.mean():.2f} s "
                f"| {differs} | {spent_s.mean() * 1e3:.1f} ms |"
            )


if __name__ == "__main__":
    main()
