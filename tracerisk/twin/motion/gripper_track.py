"""The set-points of a gripper on its way, and when it has ended."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tracerisk.twin.motion.execution import (
    LOOK_STEPS,
    SETTLE_S,
    STALL_S,
    Array,
    Measured,
    Motion,
    TimedWay,
    Way,
)
from tracerisk.twin.motion.interpolation import resample
from tracerisk.twin.motion.timing import along_path
from tracerisk.twin.physics.motion import STEP_S
from tracerisk.twin.robots.robot_parts import Gripper, Joint

_FINGER_TOLERANCE = 0.0005  # of a pad [m]
_FINGER_STILL = 0.001  # of a pad [m/s]
FINGER_LENGTH_M = 0.05  # assumed, from the hinge of a finger to its pad [m]


class GripperTrack:
    """Fingers on their way to a position, with no more than a given force."""

    def __init__(
        self,
        motion: Motion,
        gripper: Gripper,
        members: Sequence[Joint],
        actuator: int,
        joints: Sequence[int],
        begin: float,
        target: float,
        max_effort: float,
        timed: TimedWay | None = None,
    ) -> None:
        self.motion: Motion | None = motion
        self.actuators: Sequence[int] = (actuator,)
        self.joints = joints
        self._gripper = gripper
        self._begin, self._target = begin, target
        if timed is not None and len(timed[0]) > 1:
            way = _no_faster(timed, gripper.velocity_limit)
        else:
            speed = np.array([gripper.speed])
            rise = np.array([min(joint.acceleration_limit for joint in members)])
            way = along_path(np.array([[begin], [target]]), speed, rise)
        path, slope = resample(*way, STEP_S)
        share = 1.0 / len(joints)
        friction = sum(joint.servo.friction for joint in members)
        lead = (gripper.damping + friction) / gripper.stiffness
        self._signs = np.array([gripper.sign(name) for name in gripper.joints], dtype=np.float64)
        self._reference = (path + lead * slope)[:, 0]
        # The servo's force on one finger is share * stiffness * (set-point - position).
        self._slack = max_effort / (share * gripper.stiffness)
        self._is_soft = self._slack < gripper.opening
        hinged = members[0].type != "prismatic"
        self._unit = "rad" if hinged else "m"
        lever = FINGER_LENGTH_M if hinged else 1.0
        self._still, self._tolerance = _FINGER_STILL / lever, _FINGER_TOLERANCE / lever
        self._at = 0
        self._waited = 0
        self._moved_at = 0

    def way(self, measured: Measured) -> Way:
        """Return the way of a finger from where it began to where it is to be."""
        whole = abs(self._target - self._begin)
        return Way(whole, abs(self._target - self._here(measured)))

    def steps_ahead(self) -> int:
        """Return how many set-points are left; a few where they depend on the fingers."""
        left = len(self._reference) - self._at
        return left if left > 0 and not self._is_soft else LOOK_STEPS

    def fill(self, block: Array, measured: Measured) -> None:
        """Write the next set-points, no further from the fingers than the effort allows."""
        count = len(block)
        wanted = self._reference[self._at : self._at + count]
        if len(wanted) < count:
            wanted = np.append(wanted, np.repeat(self._reference[-1], count - len(wanted)))
        if self._is_soft:
            here = self._here(measured)
            wanted = np.clip(wanted, here - self._slack, here + self._slack)
        block[:, self.actuators[0]] = wanted
        self._waited += max(0, min(count, self._at + count - len(self._reference)))
        self._at += count

    def finished(self, measured: Measured, time_ns: int) -> bool:
        """Return whether the fingers are there, or stand still on something."""
        if self._at < len(self._reference) or self.motion is None:
            return False
        here = self._here(measured)
        speed = float(np.abs(measured.velocity(self.joints)).max())
        still = speed < self._still
        if still and abs(here - self._target) <= self._tolerance:
            self.motion.end_part("succeeded", "", time_ns, self.way(measured))
            return True
        if not still:
            self._moved_at = self._waited
        name, unit = self._gripper.name, self._unit
        if (self._waited - self._moved_at) * STEP_S >= STALL_S:
            short = f"{self._target:.4f} {unit}"
            note = f"gripper '{name}' stalled at {here:.4f} {unit}, short of {short}"
            self.motion.end_part("succeeded", note, time_ns, self.way(measured), stalled=True)
            return True
        if self._waited * STEP_S >= SETTLE_S:
            note = f"gripper '{name}' does not come to rest at {self._target:.4f} {unit}"
            self.motion.end_part("aborted", note, time_ns, self.way(measured))
            return True
        return False

    def _here(self, measured: Measured) -> float:
        return float((self._signs * measured.position(self.joints)).mean())


def _no_faster(asked: TimedWay, speed: float) -> TimedWay:
    """Return the way of fingers as asked, slower where they cannot go so fast."""
    time, position, velocity = asked
    mean = np.abs(np.diff(position[:, 0])) / np.diff(time)
    # From rest to rest the middle of the way is half as fast again as its mean.
    slower = max(1.0, 1.5 * float(mean.max()) / speed)
    return time * slower, position, velocity / slower
