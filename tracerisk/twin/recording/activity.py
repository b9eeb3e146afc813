"""Classify at each step what each element of the robot does: moving, holding, grasping.

`joint_motion` finds when it moves, and `grasp` what is between the pads of a gripper. Short
flickers of the other states are smoothed away: an interval counts from its first step once it has
lasted long enough.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tracerisk.common.traced.elements import Element
from tracerisk.errors import LogError
from tracerisk.twin.motion.execution import servo_lead
from tracerisk.twin.motion.gripper_track import FINGER_LENGTH_M
from tracerisk.twin.recording.contact_pairs import between_pads, borne_by
from tracerisk.twin.recording.joint_motion import LEVER_M, SetPoint, motion_steps
from tracerisk.twin.recording.samples import Samples
from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.robots.robot_parts import Gripper, Joint

Flags = NDArray[np.bool_]
Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Thresholds:
    """When a state begins and ends."""

    holding: float = 0.02
    """The torque above which a joint at rest holds, of its torque limit."""
    mean_s: float = 0.05
    """The time over which that torque is the mean: a load that trembles counts as it is borne."""
    grasping_on: float = 0.5
    """The force above which a grasp begins, on the lesser of the pads and of the drive [N]."""
    grasping_off: float = 0.2
    """The force below which it ends [N]."""
    debounce_on: float = 0.02
    """How long an interval of holding or grasping lasts at least [s]."""
    debounce_off: float = 0.05
    """How long a gap in one lasts at least [s]."""

    def debounced(self, flags: Flags, step_s: float) -> Flags:
        """Return `flags` (n,) without intervals and gaps that are too short."""
        n_on, n_off = (round(span / step_s) for span in (self.debounce_on, self.debounce_off))
        return debounce(flags, n_on, n_off)


LIMITS = Thresholds()
"""Those of every run."""


@dataclass(frozen=True, slots=True, eq=False)
class ElementActivity:
    """What one element does at each step; every array is (n_steps,).

    `moving` and `holding` exclude each other; `grasping` may overlap either.
    """

    element: Element
    """The joint, gripper or contact link."""
    moving: Flags
    """Whether the element moves."""
    holding: Flags
    """Whether the element stands still under load."""
    grasping: Flags
    """Whether a gripper grasps, or a contact link touches something."""
    speed: Array
    """The absolute velocity over the rated one [1]."""
    torque: Array
    """The absolute torque over the limit [1]."""
    grip: Array
    """The lesser force of the pads on what is between them [N]; 0 for a joint."""
    travel: Array
    """The travel in the stretch of motion around the step, over the least that counts [1]; 0 at
    rest."""

    @property
    def active(self) -> Flags:
        """Whether the element is in any of its states."""
        return self.moving | self.holding | self.grasping


def element_activity(
    samples: Samples,
    robot: Robot,
    *,
    only: Collection[str] = (),
) -> Mapping[str, ElementActivity]:
    """Return the activity of each element of the robot, by its name; of some where these are given.

    Raises LogError when the samples are of another robot.
    """
    index = {name: i for i, name in enumerate(samples.header.joints)}
    pad_index = {name: i for i, name in enumerate(samples.header.pads)}
    missing = [joint.name for joint in robot.joints if joint.name not in index]
    missing += [p for gripper in robot.grippers for p in gripper.pads if p not in pad_index]
    if missing:
        raise LogError(
            f"the samples are of robot '{samples.header.robot}' and lack '{missing[0]}' of robot "
            f"'{robot.name}'; read them with the robot that was simulated"
        )
    element_activities = {
        joint.name: joint_activity(samples, joint, index[joint.name])
        for joint in robot.arm_joints
        if not only or joint.name in only
    }
    for gripper in robot.grippers:
        if only and gripper.name not in only:
            continue
        fingers = [robot.joint(name) for name in gripper.joints]
        columns = [index[name] for name in gripper.joints]
        pads = [pad_index[name] for name in gripper.pads]
        borne = np.zeros(samples.n_steps, dtype=np.bool_)
        if samples.contacts is not None:
            borne = borne_by(samples.contacts, robot, gripper.name, samples.n_steps)
        element_activities[gripper.name] = _gripper_activity(
            samples, gripper, fingers, columns, pads, borne
        )
    return element_activities


def hysteresis(values: Array, on: float, off: float) -> Flags:
    """Return where `values` (n,) have risen above `on` and not yet fallen below `off`."""
    return _latch((values > on).astype(np.int8) - (values < off).astype(np.int8))


def debounce(flags: Flags, n_on: int, n_off: int) -> Flags:
    """Return `flags` (n,) without intervals shorter than `n_on` and gaps shorter than `n_off`.

    An interval that is long enough begins with its first step, and so does a gap.
    """
    if not len(flags):
        return flags
    edges = np.flatnonzero(np.diff(flags)) + 1
    starts = np.concatenate(([0], edges))
    lengths = np.diff(np.concatenate((starts, [len(flags)])))
    value = flags[starts]
    decided = np.where(value, lengths >= n_on, lengths >= n_off)
    signs = np.where(decided, np.where(value, 1, -1), 0).astype(np.int8)
    return np.repeat(_latch(signs), lengths)


def _latch(signs: NDArray[np.int8]) -> Flags:
    """Return at each entry whether the last sign that is not 0 was positive."""
    at = np.where(signs != 0, np.arange(len(signs)), -1)
    last = np.maximum.accumulate(at) if len(at) else at
    return (last >= 0) & (signs[last] > 0)


def joint_activity(samples: Samples, joint: Joint, column: int) -> ElementActivity:
    """Return the activity of a joint, whose samples are in a column."""
    stiffness = joint.servo.stiffness
    set_point = _set_point(
        samples,
        joint.name,
        samples.position[:, column],
        servo_lead(joint) if stiffness > 0.0 else None,
    )
    unit = _unit(joint)
    velocity = samples.velocity[:, column]
    moving, travel = motion_steps(velocity, set_point, unit, samples.step_s)
    torque = samples.torque[:, column] / joint.torque_limit
    return ElementActivity(
        element=Element(joint.name, "joint"),
        moving=moving,
        holding=_holding(torque[:, None], moving, samples.step_s),
        grasping=np.zeros(samples.n_steps, dtype=np.bool_),
        speed=np.abs(velocity) / joint.velocity_limit,
        torque=np.abs(torque),
        grip=np.zeros(samples.n_steps),
        travel=travel,
    )


def _gripper_activity(
    samples: Samples,
    gripper: Gripper,
    fingers: list[Joint],
    columns: list[int],
    pads: list[int],
    borne: Flags,
) -> ElementActivity:
    n_steps, step_s = samples.n_steps, samples.step_s
    signs = np.array([gripper.sign(name) for name in gripper.joints], dtype=np.float64)
    friction = sum(finger.servo.friction for finger in fingers)
    lag_s = (gripper.damping + friction) / gripper.stiffness if gripper.stiffness > 0.0 else None
    position = (samples.position[:, columns] * signs).mean(axis=1)
    set_point = _set_point(samples, gripper.name, position, lag_s)
    moving, travel = np.zeros(n_steps, dtype=np.bool_), np.zeros(n_steps)
    for finger, column in zip(fingers, columns, strict=True):
        velocity = samples.velocity[:, column]
        steps, far = motion_steps(velocity, set_point, _unit(finger), step_s)
        moving |= steps
        travel = np.maximum(travel, far)
    torques = samples.torque[:, columns]
    rated = np.array([finger.velocity_limit for finger in fingers])
    # A gripper whose file has no fingers that close on something presses nothing.
    grip = samples.pad_force[:, pads].min(axis=1) if pads else np.zeros(n_steps)
    # What the drive presses with: a hand that is pressed on something needs none. The weight of
    # fingers that move against one another cancels.
    drive = np.abs((torques * signs).mean(axis=1))
    drive /= np.array([1.0 if f.type == "prismatic" else FINGER_LENGTH_M for f in fingers]).mean()
    if samples.contacts is not None:
        grip = np.where(between_pads(samples.contacts, gripper, n_steps), grip, 0.0)
    pressed = np.minimum(grip, drive)
    grasped = hysteresis(pressed, LIMITS.grasping_on, LIMITS.grasping_off)
    return ElementActivity(
        element=Element(gripper.name, "gripper"),
        moving=moving,
        holding=_holding(torques / gripper.effort, moving, step_s),
        grasping=LIMITS.debounced(grasped | borne, step_s),
        speed=(np.abs(samples.velocity[:, columns]) / rated).max(axis=1),
        torque=np.abs(torques).max(axis=1) / gripper.effort,
        grip=np.where(borne & ~grasped, 0.0, grip),
        travel=travel,
    )


def _unit(joint: Joint) -> float:
    return LEVER_M if joint.type == "prismatic" else 1.0


def _set_point(
    samples: Samples, actuator: str, position: Array, lag_s: float | None
) -> SetPoint | None:
    """Return the set-point of an actuator, None where there is none that says where it leads."""
    if lag_s is None or actuator not in samples.header.controls:
        return None
    column = samples.header.controls.index(actuator)
    return SetPoint(samples.control[:, column], position, lag_s)


def _holding(torque: Array, moving: Flags, step_s: float) -> Flags:
    """Return where a joint at rest holds; torque: (n_steps, n_joints), of the limit."""
    # Without hysteresis: what a joint bore before does not decide on what it bears now.
    loaded = _mean_load(torque, ~moving, round(LIMITS.mean_s / step_s)) > LIMITS.holding
    return LIMITS.debounced(loaded & ~moving, step_s) & ~moving


def _mean_load(torque: Array, rest: Flags, size: int) -> Array:
    """Return the greatest |mean| of the columns of torque (n, m) at rest, `size` steps about each.

    What is borne in motion is no part of the mean.
    """
    count = np.maximum(_sums_around(rest, size), 1)
    means = [_sums_around(column * rest, size) / count for column in torque.T]
    array: Array = np.abs(means).max(axis=0)
    return array


def _sums_around(values: Array | Flags, size: int) -> Array:
    """Return the sum of `values` (n,) over `size` steps about each, of fewer at the ends."""
    half = size // 2
    total = np.cumsum(values, dtype=np.float64)
    last = total[-1:].repeat(half)
    total = np.concatenate((np.zeros(half + 1), total, last))
    sums: Array = total[2 * half + 1 :] - total[: len(values)]
    return sums
