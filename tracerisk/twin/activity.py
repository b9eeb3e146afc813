"""Say at each step what each element of the robot does: moving, holding, grasping.

A state begins above one threshold and ends below a lower one, and short flickers of either kind
are smoothed away: an interval counts from its first step once it has lasted long enough.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tracerisk.errors import LogError
from tracerisk.trace import Element
from tracerisk.twin.robot import Gripper, Joint, Robot
from tracerisk.twin.samples import Samples

Flags = NDArray[np.bool_]
Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Thresholds:
    """When a state begins and ends.

    Speeds are fractions of the rated speed, torques of the torque limit, pad forces in [N],
    times in [s]: an interval counts if it lasts `debounce_on`, a gap in it if it lasts
    `debounce_off`.
    """

    moving_on: float = 0.01
    moving_off: float = 0.005
    holding_on: float = 0.02
    holding_off: float = 0.015
    grasping_on: float = 0.5
    grasping_off: float = 0.2
    debounce_on: float = 0.02
    debounce_off: float = 0.05


@dataclass(frozen=True, slots=True, eq=False)
class ElementActivity:
    """What one element does at each step; every array is (n_steps,).

    `moving` and `holding` exclude each other; `grasping` may overlap either.
    speed: |velocity| over the rated one; torque: |torque| over the limit; grip: the lesser force
    of the pads [N], 0 for a joint.
    """

    element: Element
    moving: Flags
    holding: Flags
    grasping: Flags
    speed: Array
    torque: Array
    grip: Array
    thresholds: Thresholds

    @property
    def active(self) -> Flags:
        """Whether the element is in any of its states."""
        return self.moving | self.holding | self.grasping


def element_activity(
    samples: Samples, robot: Robot, thresholds: Thresholds | None = None
) -> Mapping[str, ElementActivity]:
    """Return the activity of each element of the robot, by its name.

    Raises LogError when the samples are of another robot.
    """
    limits = Thresholds() if thresholds is None else thresholds
    index = {name: i for i, name in enumerate(samples.header.joints)}
    pad_index = {name: i for i, name in enumerate(samples.header.pads)}
    missing = [joint.name for joint in robot.joints if joint.name not in index]
    missing += [p for gripper in robot.grippers for p in gripper.pads if p not in pad_index]
    if missing:
        raise LogError(
            f"the samples are of robot '{samples.header.robot}' and lack '{missing[0]}' of robot "
            f"'{robot.name}'; read them with the robot that was simulated"
        )
    found = {
        joint.name: _joint_activity(samples, joint, index[joint.name], limits)
        for joint in robot.arm_joints
    }
    for gripper in robot.grippers:
        fingers = [robot.joint(name) for name in gripper.joints]
        columns = [index[name] for name in gripper.joints]
        pads = [pad_index[name] for name in gripper.pads]
        found[gripper.name] = _gripper_activity(samples, gripper, fingers, columns, pads, limits)
    return found


def hysteresis(values: Array, on: float, off: float) -> Flags:
    """Return where `values` (n,) have risen above `on` and not yet fallen below `off`."""
    return _latch((values > on).astype(np.int8) - (values < off).astype(np.int8))


def debounce(flags: Flags, n_on: int, n_off: int) -> Flags:
    """Return `flags` (n,) without intervals shorter than `n_on` and gaps shorter than `n_off`.

    An interval that is long enough begins with its first step, and so does a gap.
    """
    if not len(flags):
        return flags.copy()
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


def _joint_activity(
    samples: Samples, joint: Joint, column: int, limits: Thresholds
) -> ElementActivity:
    return _classify(
        Element(joint.name, "joint"),
        speed=np.abs(samples.velocity[:, column]) / joint.velocity_limit,
        torque=np.abs(samples.torque[:, column]) / joint.torque_limit,
        grip=np.zeros(samples.n_steps),
        step_s=samples.step_s,
        limits=limits,
    )


def _gripper_activity(
    samples: Samples,
    gripper: Gripper,
    fingers: list[Joint],
    columns: list[int],
    pads: list[int],
    limits: Thresholds,
) -> ElementActivity:
    rated = np.array([finger.velocity_limit for finger in fingers])
    return _classify(
        Element(gripper.name, "gripper"),
        speed=(np.abs(samples.velocity[:, columns]) / rated).max(axis=1),
        torque=np.abs(samples.torque[:, columns]).max(axis=1) / gripper.effort,
        grip=samples.pad_force[:, pads].min(axis=1),
        step_s=samples.step_s,
        limits=limits,
    )


def _classify(
    element: Element,
    *,
    speed: Array,
    torque: Array,
    grip: Array,
    step_s: float,
    limits: Thresholds,
) -> ElementActivity:
    n_on = round(limits.debounce_on / step_s)
    n_off = round(limits.debounce_off / step_s)
    moving = debounce(hysteresis(speed, limits.moving_on, limits.moving_off), n_on, n_off)
    loaded = hysteresis(torque, limits.holding_on, limits.holding_off)
    grasped = hysteresis(grip, limits.grasping_on, limits.grasping_off)
    return ElementActivity(
        element=element,
        moving=moving,
        holding=debounce(loaded & ~moving, n_on, n_off) & ~moving,
        grasping=debounce(grasped, n_on, n_off),
        speed=speed,
        torque=torque,
        grip=grip,
        thresholds=limits,
    )
