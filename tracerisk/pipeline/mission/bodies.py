"""Where objects and links were, against where a condition wants them: flags, and words."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tracerisk.common.geometry.frames import rotation
from tracerisk.pipeline.mission.facts import MissionFacts, Track, on_axes
from tracerisk.ros.scenario.success import Condition
from tracerisk.twin.physics.scene import Goal
from tracerisk.twin.recording.contact_log import LOOK_EVERY
from tracerisk.twin.recording.joint_motion import distinct
from tracerisk.twin.recording.tool_way import arm_to, tool_places

UPRIGHT_RAD = math.radians(5.0)
"""An object at a goal of the scene leans by less [rad]."""
GOAL_HEIGHT_M = 0.005
"""An object is no further above or below its goal [m]."""
_HELD_S = 0.1  # a hold that lasted until so shortly before the end lasts [s]

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Clause:
    """One part of a condition at some times: whether it holds at each, and what to say if not."""

    is_met: Flags
    """Whether it holds, one flag a time."""
    words: Callable[[int], str]
    """Returns what the run shows at the time of an index, and what the condition allows."""


def object_clauses(condition: Condition, facts: MissionFacts, times: Array) -> Iterator[Clause]:
    """Yield what a condition asks of an object, at each of some times (n,) [s]."""
    track = facts.tracks[condition.name]
    poses = track.at(times)
    goals = facts.scene.goals if condition.is_at_goal else ()
    if isinstance(condition.at, str):
        goals = tuple(goal for goal in facts.scene.goals if goal.name == condition.at)
    if goals:
        yield _at_goal(condition, goals, track, poses)
    elif condition.at is not None:
        yield _at_place(condition, facts, poses[:, :3], times)
    if condition.moved is not None:
        yield _moved(condition, track, poses)
    if condition.tilt is not None:
        yield _tilted(condition, condition.tilt, poses)
    if condition.rests_on:
        yield _on(condition, facts, times)
    if condition.held_by:
        yield _held(condition, facts, times)


def link_clause(condition: Condition, facts: MissionFacts, times: Array) -> Clause:
    """Return where a condition wants a link, at each of some times (n,) [s]."""
    return _at_place(condition, facts, link_places(facts, condition.name, times), times)


def link_places(facts: MissionFacts, link: str, times: Array) -> Array:
    """Return where a link was at some times, in the scene, (n, 3) [m]."""
    samples = facts.samples
    assert samples is not None
    steps = np.clip(np.round(times / samples.step_s).astype(int), 0, samples.n_steps - 1)
    arm = arm_to(facts.robot, link)
    columns = [samples.header.joints.index(name) for name in arm.joints]
    points = tool_places(arm, samples.position[steps][:, columns])
    scene = facts.scene
    placed: Array = points @ rotation(scene.robot_rpy).T + np.asarray(scene.robot_xyz)
    return placed


def leaning(track: Track, poses: Array) -> Array:
    """Return by how much a body's z axis has left its first direction, (n,) [rad]."""
    first = on_axes(track.poses[:1], (0.0, 0.0, 1.0)) - track.poses[:1, :3]
    now = on_axes(poses, (0.0, 0.0, 1.0)) - poses[:, :3]
    angles: Array = np.arccos(np.clip(now @ first[0], -1.0, 1.0))
    return angles


def at_goals(goals: Sequence[Goal], track: Track, poses: Array) -> tuple[Array, Flags, Array]:
    """Return how far from the nearest goal a body is, (n,) [m], whether it stands in it, and which.

    The distance is the horizontal one; what stands in a goal is upright and at its height.
    """
    places = np.array([goal.xyz for goal in goals])
    off = np.hypot(poses[:, None, 0] - places[None, :, 0], poses[:, None, 1] - places[None, :, 1])
    nearest = off.argmin(axis=1)
    heights = np.abs(poses[:, 2] - places[nearest, 2])
    stands = (leaning(track, poses) < UPRIGHT_RAD) & (heights < GOAL_HEIGHT_M)
    return off[np.arange(len(poses)), nearest], stands, nearest


def length_words(metres: float) -> str:
    """Return a length in words, in millimetres."""
    return f"{1000.0 * metres:.3g} mm" if metres < 1.0 else f"{metres:.3g} m"


def _at_goal(condition: Condition, goals: Sequence[Goal], track: Track, poses: Array) -> Clause:
    off, stands, nearest = at_goals(goals, track, poses)
    lean = leaning(track, poses)

    def words(index: int) -> str:
        goal = goals[nearest[index]]
        what = goal.name if len(goals) == 1 else f"{goal.name}, the nearest goal"
        if off[index] > condition.within:
            return _off(condition, float(off[index]), what)
        if lean[index] >= UPRIGHT_RAD:
            return (
                f"{condition.name} leans {math.degrees(lean[index]):.3g} degrees at {what} (at "
                f"most {math.degrees(UPRIGHT_RAD):.0f} allowed)"
            )
        height = float(poses[index, 2] - goal.xyz[2])
        side = "above" if height > 0.0 else "below"
        return (
            f"{condition.name} ends {length_words(abs(height))} {side} {what} (at most "
            f"{length_words(GOAL_HEIGHT_M)} allowed)"
        )

    return Clause((off <= condition.within) & stands, words)


def _at_place(condition: Condition, facts: MissionFacts, places: Array, times: Array) -> Clause:
    at, of = condition.at, condition.of
    if isinstance(at, str):
        wanted, what = _track(facts, at).at(times)[:, :3], at
    elif at is not None and of:
        wanted, what = on_axes(_track(facts, of).at(times), at), f"its place on {of}"
    else:
        assert at is not None
        wanted, what = (
            np.broadcast_to(np.asarray(at), places.shape),
            "({:g}, {:g}, {:g})".format(*at),
        )
    off = np.linalg.norm(places - wanted, axis=1)
    return Clause(off <= condition.within, lambda index: _off(condition, float(off[index]), what))


def _off(condition: Condition, off: float, what: str) -> str:
    allowed = length_words(condition.within)
    return f"{condition.name} ends {length_words(off)} from {what} (at most {allowed} allowed)"


def _track(facts: MissionFacts, name: str) -> Track:
    return facts.tracks[name] if name in facts.tracks else facts.frames[name]


def _moved(condition: Condition, track: Track, poses: Array) -> Clause:
    off = np.linalg.norm(poses[:, :3] - track.poses[0, :3], axis=1)
    limit = length_words(condition.within)

    def words(index: int) -> str:
        far = length_words(float(off[index]))
        if condition.moved:
            return f"{condition.name} ends {far} from where it began (more than {limit} asked)"
        return f"{condition.name} ends {far} from where it began (at most {limit} allowed)"

    return Clause((off > condition.within) == condition.moved, words)


def _tilted(condition: Condition, most: float, poses: Array) -> Clause:
    axis = on_axes(poses, (0.0, 0.0, 1.0)) - poses[:, :3]
    lean = np.arccos(np.clip(axis[:, 2], -1.0, 1.0))
    return Clause(
        lean <= most,
        lambda index: (
            f"{condition.name} ends leaning {math.degrees(lean[index]):.3g} degrees (at most "
            f"{math.degrees(most):.3g} allowed)"
        ),
    )


def _held(condition: Condition, facts: MissionFacts, times: Array) -> Clause:
    step_s = 1.0 if facts.samples is None else facts.samples.step_s
    spans = [
        (hold.holder, hold.start * step_s, hold.stop * step_s)
        for hold in facts.holds
        if facts.log is not None and facts.log.bodies[hold.body].name == condition.name
    ]
    held = np.zeros(len(times), dtype=np.bool_)
    for holder, start, stop in spans:
        if holder == condition.held_by:
            held |= (times >= start) & (times <= stop + _HELD_S)

    def words(index: int) -> str:
        now = [name for name, start, stop in spans if start <= times[index] <= stop + _HELD_S]
        where = f"is held by {now[0]}, not" if now else "is not held"
        return f"{condition.name} {where} by {condition.held_by} at the end"

    return Clause(held, words)


def resting_on(facts: MissionFacts, name: str, times: Array) -> dict[str, Flags]:
    """Return what an object touches at each of some times (n,) [s], by the names of bodies.

    At the end that is known. Before it, contacts are logged while something touches the robot and
    shortly after: what an object then touched, it touches until the next look.
    """
    is_end = times >= facts.end_s
    table = {other: is_end.copy() for other in facts.bearing.get(name, ())}
    log, samples = facts.log, facts.samples
    places = [] if log is None else [i for i, b in enumerate(log.bodies) if b.name == name]
    if log is None or samples is None or not places:
        return table
    rows = log.rows[log.rows["force"] > 0.0]
    own = rows[np.isin(rows["one"], places) | np.isin(rows["two"], places)]
    now = np.round(times / samples.step_s).astype(np.int64)
    last = _last_before(distinct(own["step"]), now)
    others = np.where(np.isin(own["one"], places), own["two"], own["one"])
    is_logged = ~is_end if name in facts.bearing else np.ones(len(times), dtype=np.bool_)
    for place in distinct(others).tolist():
        body = log.bodies[place]
        if body.kind != "link":
            touched = _last_before(distinct(own["step"][others == place]), now)
            touches = is_logged & (touched >= 0) & (touched >= last - 2 * LOOK_EVERY)
            table[body.name] = table.get(body.name, ~is_logged & is_logged) | touches
    return table


def _last_before(steps: NDArray[np.int32], now: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the last of some steps up to each of others; -1 where there is none."""
    if not len(steps):
        return np.full(len(now), -1, dtype=np.int64)
    places = np.searchsorted(steps, now, side="right") - 1
    return np.where(places >= 0, steps[np.clip(places, 0, None)], -1).astype(np.int64)


def _on(condition: Condition, facts: MissionFacts, times: Array) -> Clause:
    bearing = resting_on(facts, condition.name, times)
    never = np.zeros(len(times), dtype=np.bool_)

    def words(index: int) -> str:
        now = sorted(name for name, flags in bearing.items() if flags[index])
        text = f"rests on {', '.join(now)}" if now else "touches nothing"
        return f"{condition.name} {text} at the end, not on {condition.rests_on}"

    return Clause(bearing.get(condition.rests_on, never), words)
