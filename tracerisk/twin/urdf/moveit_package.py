"""Read the limits of a MoveIt package: the scaling and the joints of its joint_limits.yaml."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from tracerisk.text.yaml_reader import YamlMap
from tracerisk.twin.robots.robot import Joint, Robot, Scaling
from tracerisk.twin.urdf.assembly import ASSUMED_ACCELERATION
from tracerisk.twin.urdf.srdf import yaml_beside

NAME = "joint_limits.yaml"
_UNBOUNDED = 1.0  # what MoveIt's time parameterization takes where a joint has no limit


def limited_as_beside(robot: Robot, srdf: Path, *, shown: str) -> tuple[Robot, Path | None]:
    """Return the robot with the limits of the joint_limits.yaml beside its SRDF, and that file.

    It stands in the folder of the SRDF or in `config` beside that; `None` where there is none, or
    nothing in it changes the robot. A joint's limits are those of plans: never above the rated
    ones, but for an acceleration that was assumed. A joint that is said to have no limit is
    planned with 1 rad/s and 1 rad/s^2 (or m/s, m/s^2), as MoveIt does.
    `shown` is the SRDF's name for messages.
    Raises RobotError with file and line for a factor outside (0, 1], a limit that is not a positive
    number, or a file that is not YAML.
    """
    found = yaml_beside(srdf, NAME, shown=shown)
    if found is None:
        return robot, None
    top, path = found
    has_limits = top.get("joint_limits") is not None
    given = dict(top.map("joint_limits").items_as_maps()) if has_limits else {}
    limited = replace(
        robot,
        default_scaling=_scaling(top, robot.default_scaling),
        joints=tuple(
            _limited(joint, given[joint.name]) if joint.name in given else joint
            for joint in robot.joints
        ),
    )
    return (robot, None) if limited == robot else (limited, path)


def _scaling(top: YamlMap, default: Scaling) -> Scaling:
    found = []
    for kind, value in (("velocity", default.velocity), ("acceleration", default.acceleration)):
        key = f"default_{kind}_scaling_factor"
        factor = top.number(key, default=value, minimum=0.0, maximum=1.0)
        if factor == 0.0:
            top.fail(key, "0 is not allowed; give a fraction of the limits above 0, at most 1")
        found.append(factor)
    return Scaling(*found)


def _limited(joint: Joint, entry: YamlMap) -> Joint:
    velocity = _limit(entry, "velocity")
    if velocity is not None:
        joint = replace(joint, plan_velocity=min(velocity, joint.velocity_limit))
    acceleration = _limit(entry, "acceleration")
    if acceleration is None:
        return joint
    rated = joint.acceleration_limit
    if rated == ASSUMED_ACCELERATION:
        rated = max(rated, acceleration)
    return replace(joint, acceleration_limit=rated, plan_acceleration=min(acceleration, rated))


def _limit(entry: YamlMap, kind: str) -> float | None:
    """Return a joint's limit of plans, `None` where the file says nothing of it."""
    has, most = f"has_{kind}_limits", f"max_{kind}"
    if has in entry and not entry.boolean(has):
        return _UNBOUNDED
    if most not in entry:
        return None
    value = entry.number(most, minimum=0.0)
    if value == 0.0:
        # MoveIt's assistant writes it with `has_..._limits: false`, and plans without a limit.
        if has in entry:
            entry.fail(most, f"0 is not allowed; give a positive number, or {has}: false")
        return _UNBOUNDED
    return value
