"""What moves in a compiled MJCF, and what drives it: limits, servos, fingers, followers."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from tracerisk.twin.model_files.mjcf_model import Data, MjcfModel
from tracerisk.twin.robots.outline import derived_servo
from tracerisk.twin.robots.robot_parts import Servo
from tracerisk.twin.urdf.assembly import ASSUMED_VELOCITY

FREE, BALL, SLIDE, HINGE = 0, 1, 2, 3
_GRIPS = re.compile(r"finger|gripper|hand|jaw|knuckle|claw|thumb|grasp|pinch", re.IGNORECASE)
_TURNS = re.compile(r"roll|pitch|yaw|rot|wrist|lift|slide|flex", re.IGNORECASE)
_SLOWEST_S = 0.5  # damping by stiffness: how far a servo may be behind


@dataclass(frozen=True, slots=True)
class Drives:
    """What drives the joints of a model; joints are given by their index."""

    efforts: Mapping[int, float] = field(default_factory=dict)
    """The effort limits of joints [N m or N]; a joint without a limit is left out."""
    servos: Mapping[int, Servo] = field(default_factory=dict)
    """The position servos that the file gives."""
    ranges: Mapping[int, tuple[float, float]] = field(default_factory=dict)
    """The least and greatest set-point of a servo with a control range [rad or m]."""
    follows: Mapping[int, tuple[int, float, float]] = field(default_factory=dict)
    """The leader, factor and offset [rad or m] of each joint that follows another."""
    passive: frozenset[int] = frozenset()
    """The joints with neither motor nor leader: springs, and links of closed loops."""
    driven: frozenset[int] = frozenset()
    """The joints that an actuator moves."""
    fingers: frozenset[int] = frozenset()
    """The joints that one actuator moves together, or an actuator named like a gripper."""
    actuators: Mapping[str, tuple[int, ...]] = field(default_factory=dict)
    """The joints that each named actuator moves."""


def drives_of(model: MjcfModel) -> Drives:
    """Return what drives the joints."""
    efforts: dict[int, float] = {}
    servos: dict[int, Servo] = {}
    ranges: dict[int, tuple[float, float]] = {}
    fingers: set[int] = set()
    driven: set[int] = set()
    follows = _coupled(model)
    for actuator in model.actuators:
        joints = [(int(joint), share) for joint, share in actuator["joints"] if share]
        is_hand = bool(_GRIPS.search(actuator["name"])) and not _TURNS.search(actuator["name"])
        if len(joints) > 1 or is_hand:
            fingers |= {joint for joint, _ in joints}
        driven |= {joint for joint, _ in joints}
        for joint, share in joints:
            limit = _force(actuator) * abs(share)
            if limit > 0.0:
                efforts[joint] = max(efforts.get(joint, 0.0), limit)
        for joint, share in joints[1:]:
            leader, first = joints[0]
            if joint not in follows and leader not in follows:
                # A tendon fixes only the mean; fingers of one tendon are taken as geared.
                follows[joint] = (leader, 1.0 if share * first > 0.0 else -1.0, 0.0)
        if len(joints) == 1:
            joint, gear = joints[0]
            servo = _servo(actuator, gear, model.joints[joint], efforts.get(joint, 0.0))
            if servo is not None:
                servos[joint] = servo
                if actuator["control"] is not None:
                    ends = sorted(item / gear for item in actuator["control"])
                    ranges[joint] = (ends[0], ends[1])
    for index, joint_data in enumerate(model.joints):
        if joint_data["force"] is not None:
            own = max(abs(data) for data in joint_data["force"])
            efforts[index] = min(efforts.get(index, own), own)
    return Drives(
        efforts,
        servos,
        ranges,
        follows,
        _passive(model, driven, follows),
        frozenset(driven),
        frozenset(fingers),
        {
            fields["name"]: _moved(fields)
            for fields in model.actuators
            if fields["name"] and _moved(fields)
        },
    )


def _moved(actuator: Data) -> tuple[int, ...]:
    return tuple(int(joint) for joint, share in actuator["joints"] if share)


def _coupled(model: MjcfModel) -> dict[int, tuple[int, float, float]]:
    """Return who follows whom by an equality; the one that has an actuator leads."""
    has_own = {int(actuator["joints"][0][0]) for actuator in model.actuators if actuator["joints"]}
    row: dict[int, tuple[int, float, float]] = {}
    for coupling in model.couplings:
        one, other = int(coupling["joint"]), int(coupling["leader"])
        factor, offset = float(coupling["factor"]), float(coupling["offset"])
        # MuJoCo counts both from where they are at rest.
        offset += model.joints[one]["ref"] - factor * model.joints[other]["ref"]
        if one in has_own and other not in has_own and factor:
            one, other, factor, offset = other, one, 1.0 / factor, -offset / factor
        leads = other
        while leads in row and leads != one:
            leads = row[leads][0]
        if one != leads and one not in row:
            row[one] = (other, factor, offset)
    return row


def _force(actuator: Data) -> float:
    """Return the greatest force of an actuator on its transmission, 0 where none is given."""
    if actuator["force"] is not None:
        return max(abs(float(item)) for item in actuator["force"])
    if actuator["control"] is not None and actuator["gain"] > 0.0 and not any(actuator["bias"]):
        return float(actuator["gain"]) * max(abs(float(item)) for item in actuator["control"])
    return 0.0


def _servo(actuator: Data, gear: float, joint: Data, effort: float) -> Servo | None:
    """Return the position servo that an actuator is; `effort` is its limit, 0 for none.

    `None` for one of another kind, and for a placeholder that is so slow that it never arrives.
    What a model gives its joints of damping beyond the friction of a drive is the servo's: the
    motion is the same, and no motor is loaded by what no real joint has.
    """
    stiffness = -float(actuator["bias"][1]) * gear * gear
    if actuator["gain"] <= 0.0 or stiffness <= 0.0:
        return None
    damping = max(0.0, -float(actuator["bias"][2]) * gear * gear)
    passive = float(joint["damping"])
    if damping + passive > _SLOWEST_S * stiffness:
        return None
    kind = "prismatic" if joint["type"] == SLIDE else "revolute"
    drive = derived_servo(effort or math.inf, ASSUMED_VELOCITY[kind]).friction
    friction = min(passive, drive)
    return Servo(stiffness, damping + passive - friction, float(joint["armature"]), friction)


def _passive(
    model: MjcfModel, driven: set[int], follows: Mapping[int, tuple[int, float, float]]
) -> frozenset[int]:
    return frozenset(
        index
        for index, joint in enumerate(model.joints)
        if index not in driven
        and index not in follows
        and (joint["stiffness"] > 0.0 or joint["body"] in model.closed)
    )
