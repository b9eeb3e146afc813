"""Whether the objects, links and frames exist that conditions of `success` name."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import NoReturn

from tracerisk.common.outcome.outcome import FLOOR
from tracerisk.errors import ScenarioError, one_of
from tracerisk.ros.scenario.scenario import Frame, Scenario
from tracerisk.ros.scenario.success import Condition
from tracerisk.twin.physics.scene import Scene
from tracerisk.twin.robots.robot import WORLD, Robot


def check_names(scenario: Scenario, robot: Robot, scene: Scene) -> None:
    """Check what can be known before a run: all but the objects that a controller declares.

    Raises ScenarioError with the valid names.
    """
    for condition in parts_of(scenario.success):
        if condition.joints:
            joints = [joint.name for joint in robot.joints]
            for name in condition.joints:
                _check(condition, "joint", name, joints, f"of robot '{robot.name}'")
        for name in (*condition.links, *([condition.name] if condition.kind == "link" else [])):
            _check(condition, "link", name, robot.link_names, f"of robot '{robot.name}'")
        if condition.held_by:
            holders = [*(gripper.name for gripper in robot.grippers), *robot.link_names]
            _check(condition, "gripper or link", condition.held_by, holders, "of the robot")
        if condition.is_at_goal and not scene.goals:
            _fail(
                condition,
                f"scene '{scene.name}' has no goals; say where {condition.name} is to end: "
                "at, rests_on, held_by, tilt or moved",
            )
        for frame in scenario.frames:
            if frame.frame in (condition.at, condition.of):
                _check_frame(condition, frame, scenario.frames, robot)


def check_objects(
    conditions: Iterable[Condition], scene: Scene, frames: Collection[str], objects: Collection[str]
) -> None:
    """Check the objects, goals and frames that conditions name; `objects` are those of a run.

    Raises ScenarioError with the valid names.
    """
    goals = [goal.name for goal in scene.goals]
    for condition in parts_of(conditions):
        if condition.kind == "object":
            _check(condition, "object", condition.name, objects, "of the run")
        if isinstance(condition.at, str):
            known = [*goals, *objects, *frames]
            _check(condition, "goal, object or frame", condition.at, known, "of the run")
        if condition.of:
            _check(condition, "object or frame", condition.of, [*objects, *frames], "of the run")
        if condition.rests_on:
            bearing = [*objects, FLOOR]
            _check(condition, "object", condition.rests_on, bearing, "of the run")


def parts_of(conditions: Iterable[Condition]) -> Iterator[Condition]:
    """Yield the conditions, and the steps of each."""
    for condition in conditions:
        yield condition
        yield from condition.steps


def _check(condition: Condition, what: str, name: str, known: Collection[str], of: str) -> None:
    if name not in known:
        _fail(condition, f"unknown {what} '{name}' {of}; {one_of(sorted(set(known)), name)}")


def _check_frame(condition: Condition, frame: Frame, frames: Iterable[Frame], robot: Robot) -> None:
    parents: Mapping[str, str] = {known.frame: known.parent for known in frames}
    top, seen = frame.parent, {frame.frame}
    while top in parents and top not in seen:
        seen.add(top)
        top = parents[top]
    if top not in (WORLD, robot.base_link):
        _fail(
            condition,
            f"frame '{frame.frame}' hangs on '{top}', whose place in the scene is not fixed; name "
            f"a frame below '{WORLD}' or '{robot.base_link}'",
        )


def _fail(condition: Condition, message: str) -> NoReturn:
    raise ScenarioError(f"success: {message}", condition.location)
