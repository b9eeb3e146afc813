"""What files of a MoveIt package beside an SRDF change of its robot: limits, solvers, starts."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

from tracerisk.common.text.yaml_reader import YamlMap, read_yaml
from tracerisk.errors import RobotError
from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.robots.robot_parts import Group, Joint, Scaling
from tracerisk.twin.urdf.assembly import ASSUMED_ACCELERATION

_UNBOUNDED = 1.0  # what MoveIt's time parameterization takes where a joint has no limit
_ALL_AXES = 6  # joints that it takes to bring a link to any pose
_OF_ITS_ARM = "ikfast"  # such a solver is made for what its arm can reach


def changed_as_beside(
    robot: Robot, srdf: Path, name: str, *, shown: str
) -> tuple[Robot, Path | None]:
    """Return the robot as one of `PACKAGE_FILES` beside its SRDF changes it, and that file.

    It stands in the folder of the SRDF or in `config` beside that; `None` where there is none, or
    nothing in it changes the robot. `shown` is the SRDF's name for messages.
    Raises RobotError with file and line for what it must not say, or a file that is not YAML.
    """
    beside = (
        (item.with_name(name), item.parent.parent / "config" / name) for item in (srdf, Path(shown))
    )
    for path, place in zip(*beside, strict=True):
        if path.is_file():
            top = read_yaml(path, RobotError, shown=str(place), version=(1, 1))
            changed = PACKAGE_FILES[name](robot, top)
            return (robot, None) if changed == robot else (changed, path)
    return robot, None


def _limited_robot(robot: Robot, top: YamlMap) -> Robot:
    """Return the robot with a default scaling and limits of joints.

    A joint's limits are those of plans: never above the rated ones, but for an acceleration that
    was assumed. A joint that is said to have no limit is planned with 1 rad/s and 1 rad/s^2 (or
    m/s, m/s^2), as MoveIt does. A factor is in (0, 1], a limit is a positive number.
    """
    has_limits = top.get("joint_limits") is not None
    given = dict(top.map("joint_limits").items_as_maps()) if has_limits else {}
    return replace(
        robot,
        default_scaling=_scaling(top, robot.default_scaling),
        joints=tuple(
            _limited(joint, given[joint.name]) if joint.name in given else joint
            for joint in robot.joints
        ),
    )


def _scaling(top: YamlMap, default: Scaling) -> Scaling:
    values = []
    for kind, value in (("velocity", default.velocity), ("acceleration", default.acceleration)):
        key = f"default_{kind}_scaling_factor"
        factor = top.number(key, default=value, minimum=0.0, maximum=1.0)
        if factor == 0.0:
            top.fail(key, "0 is not allowed; give a fraction of the limits above 0, at most 1")
        values.append(factor)
    return Scaling(*values)


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


def _solved_robot(robot: Robot, top: YamlMap) -> Robot:
    """Return the robot with groups that turn freely: their solver is for positions only.

    A group does where `position_only_ik` is set, and where an arm of fewer than six joints has a
    solver made for it (IKFast): it does what it can.
    """
    groups = {
        name: replace(group, turns_freely=True)
        if isinstance(top.get(name), dict) and _is_of_positions(top.map(name), group)
        else group
        for name, group in robot.groups.items()
    }
    return replace(robot, groups=groups)


def _is_of_positions(entry: YamlMap, group: Group) -> bool:
    if entry.get("position_only_ik") is True:
        return True
    solver = str(entry.get("kinematics_solver") or "")
    return len(group.joints) < _ALL_AXES and _OF_ITS_ARM in solver.lower()


def _placed_robot(robot: Robot, top: YamlMap) -> Robot:
    """Return the robot where a file says that its simulated controllers begin.

    `initial_positions` maps joints to positions, as for ros2_control; `initial` lists groups with
    a named state each, as for MoveIt's fake controllers. What the robot lacks is passed over.
    """
    begun = dict(robot.initial_state)
    positions = top.get("initial_positions")
    for name, value in positions.items() if isinstance(positions, dict) else ():
        if name in begun and isinstance(value, int | float) and not isinstance(value, bool):
            begun[str(name)] = float(value)
    for entry in top.get("initial") or ():
        if isinstance(entry, dict):
            states = robot.named_states.get(str(entry.get("group")), {})
            begun.update(states.get(str(entry.get("pose")), {}))
    return replace(robot, initial_state=MappingProxyType(_within_limits(robot, begun)))


def _within_limits(robot: Robot, positions: Mapping[str, float]) -> dict[str, float]:
    limits = {joint.name: (joint.lower, joint.upper) for joint in robot.joints}
    return {name: min(max(at, limits[name][0]), limits[name][1]) for name, at in positions.items()}


PACKAGE_FILES: Mapping[str, Callable[[Robot, YamlMap], Robot]] = {
    "joint_limits.yaml": _limited_robot,
    "kinematics.yaml": _solved_robot,
    "fake_controllers.yaml": _placed_robot,
    "initial_positions.yaml": _placed_robot,
}
"""The files that are read, and what each changes."""
