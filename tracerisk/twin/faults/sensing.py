"""The readings of faulty sensors of a robot whose true state is known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tracerisk.common.hardware.model import FaultMode
from tracerisk.twin.faults.armed import encoder_noise, encoder_offset, noise
from tracerisk.twin.faults.fault import Fault
from tracerisk.twin.physics.motion import JointState
from tracerisk.twin.physics.wrench import Wrench
from tracerisk.twin.robots.robot import Robot

TORQUE_OFFSET = 0.1
"""What a torque sensor with an offset reads too much, as a fraction of the motor's limit."""
FORCE_OFFSET_N = 10.0
"""What a wrist sensor with an offset reads too much along its z axis [N].

These are the standard deviations of what a noisy one reads, too."""

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class _Reading:
    """What a sensor read when its fault began: of a joint, or a wrench."""

    fault: Fault
    """The fault of the sensor."""
    position: float = 0.0
    """The joint position read last [rad or m]; 0 for a sensor of forces."""
    velocity: float = 0.0
    """The joint velocity read last [rad/s or m/s]; 0 for a sensor of forces."""
    effort: float = 0.0
    """The joint effort read last [N m or N]; 0 for a sensor of forces."""
    wrench: Wrench | None = None
    """The wrench read last; `None` for the sensor of a joint."""

    @property
    def mode(self) -> FaultMode:
        """How the sensor fails."""
        return self.fault.mode


class SensorFaults:
    """The faults of a robot's sensors that have begun; without one every reading is true."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._sensors = {sensor.name: sensor for sensor in robot.sensors}
        self._places = {joint.name: at for at, joint in enumerate(robot.joints)}
        self._faulty: dict[str, _Reading] = {}
        self._lost: JointState | None = None
        self._step = 0

    def begin(self, fault: Fault, last: JointState, wrench: Wrench | None) -> None:
        """Begin the fault of a sensor.

        `last` are the last readings of the joints, `wrench` is that of a sensor of forces.
        """
        if fault.mode == "link_lost":
            self._lost = last
        sensor = self._sensors.get(fault.unit)
        if sensor is None:
            return
        if sensor.kind == "wrench":
            self._faulty[fault.unit] = _Reading(fault, wrench=wrench)
            return
        at = self._places[sensor.part]
        self._faulty[fault.unit] = _Reading(
            fault, last.position[at], last.velocity[at], last.effort[at]
        )

    def clear(self, fault: Fault) -> None:
        """Clear the fault of a sensor, which works again."""
        self._faulty.pop(fault.unit, None)
        if fault.mode == "link_lost":
            self._lost = None

    def look(self, step: int) -> None:
        """Note that this is the step that is about to be made."""
        self._step = step

    def position(self, true: Array, joints: Sequence[int] | None = None) -> Array:
        """Return the encoder readings of some joints, by their index (of all) [rad or m].

        `true`: (n_joints,), which may be changed. An encoder that reports nothing is read as it
        was last.
        """
        if self._lost is not None:
            return _picked(self._lost.position, joints)
        for row, reading, joint in self._encoders(joints):
            kind = self._robot.joints[joint].type
            if reading.mode == "offset":
                true[row] += encoder_offset(kind)
            elif reading.mode == "noisy":
                true[row] += encoder_noise(reading.fault.unit, kind, self._step)
            else:
                true[row] = reading.position
        return true

    def velocity(self, true: Array, joints: Sequence[int] | None = None) -> Array:
        """Return the velocities as `position` [rad/s or m/s]."""
        if self._lost is not None:
            return _picked(self._lost.velocity, joints)
        for row, reading, _ in self._encoders(joints):
            if reading.mode in ("frozen", "absent"):
                true[row] = reading.velocity
        return true

    def effort(self, true: Array) -> Array:
        """Return what the torque sensors read, (n_joints,) [N m or N]; 0 of one that is absent."""
        if self._lost is not None:
            return np.array(self._lost.effort)
        for name, reading in self._faulty.items():
            sensor = self._sensors[name]
            if sensor.kind == "torque":
                at = self._places[sensor.part]
                off = TORQUE_OFFSET * self._robot.joints[at].torque_limit
                if reading.mode == "offset":
                    true[at] += off
                elif reading.mode == "noisy":
                    true[at] += off * noise(name, self._step)
                else:
                    true[at] = reading.effort if reading.mode == "frozen" else 0.0
        return true

    @property
    def absent(self) -> frozenset[str]:
        """The joints whose encoder reports nothing any more."""
        if self._lost is not None:
            return frozenset(self._lost.names)
        return frozenset(
            self._sensors[name].part
            for name, reading in self._faulty.items()
            if self._sensors[name].kind == "encoder" and reading.mode == "absent"
        )

    def wrench(self, sensor: str, true: Wrench) -> Wrench | None:
        """Return what a sensor of forces reads; `None` where it is absent."""
        reading = self._faulty.get(sensor)
        if self._lost is not None:
            return None
        if reading is None or self._sensors[sensor].kind != "wrench":
            return true
        if reading.mode in ("offset", "noisy"):
            x, y, z = true.force
            share = 1.0 if reading.mode == "offset" else noise(sensor, self._step)
            return replace(true, force=(x, y, z + share * FORCE_OFFSET_N))
        return reading.wrench if reading.mode == "frozen" else None

    def _encoders(self, joints: Sequence[int] | None) -> list[tuple[int, _Reading, int]]:
        """Return the row, the reading and the joint of each faulty encoder among some joints."""
        if not self._faulty:
            return []
        rows = {joint: row for row, joint in enumerate(joints)} if joints is not None else None
        encoders = []
        for name, reading in self._faulty.items():
            sensor = self._sensors[name]
            joint = self._places.get(sensor.part, -1)
            if sensor.kind == "encoder" and (rows is None or joint in rows):
                encoders.append((joint if rows is None else rows[joint], reading, joint))
        return encoders


def _picked(values: Sequence[float], joints: Sequence[int] | None) -> Array:
    """Return the values of some joints, by their index; all for `None`."""
    return np.array(values if joints is None else [values[joint] for joint in joints])
