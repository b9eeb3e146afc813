"""The faults of one simulation: when each begins, and what it does to the model.

A fault changes parameters of the model and nothing else of the physics, so that the same model,
state and controls go on from there to the same bits. Without a fault the model is not touched.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracerisk.common.hardware.model import CONTROL, POWER
from tracerisk.twin.faults.fault import Fault
from tracerisk.twin.physics.motion import STEP_NS
from tracerisk.twin.robots.gripper_ends import gripper_ends
from tracerisk.twin.robots.robot import Gripper, Robot

ENCODER_OFFSET = 0.05
"""By how much an encoder with an offset reads too much: of a joint that turns [rad]."""
SLIDE_OFFSET = 0.01
"""The same of a joint that slides [m]."""

# Friction would be a soft constraint, through which a joint still creeps its whole way.
_JAM = 1e7  # [N m s/rad or N s/m]
_JAM_PER_TORQUE = 1e6  # a strong motor must not push through: at most 1e-6 rad/s [s]
_CHANGED = (
    "jnt_actfrcrange",
    "dof_damping",
    "actuator_gainprm",
    "actuator_biasprm",
    "actuator_forcerange",
)

Array = NDArray[np.float64]


@dataclass(slots=True)
class _Live:
    """A fault that has begun."""

    fault: Fault
    """The fault in effect."""
    controls: Array
    """The controls at the instant of the fault [rad or m], shape (n_actuators,)."""


def first_step(fault: Fault) -> int:
    """Return the first physics step that a fault changes."""
    return step_at(fault.time_s)


def step_at(time_s: float) -> int:
    """Return the first physics step that does not begin before a time [s]."""
    return -(-round(time_s * 1e9) // STEP_NS)


def encoder_offset(joint_type: str) -> float:
    """Return what an encoder with an offset adds to the position [rad or m]."""
    return SLIDE_OFFSET if joint_type == "prismatic" else ENCODER_OFFSET


class ArmedFaults:
    """The faults of a simulated robot; `live` are those that have begun."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._pending: list[Fault] = []
        self._live: list[_Live] = []
        self._sound: dict[str, Array] | None = None

    @property
    def live(self) -> tuple[Fault, ...]:
        """The faults that have begun, in the order of their instants."""
        return tuple(item.fault for item in self._live)

    def arm(self, fault: Fault) -> None:
        """Make a unit fail at the fault's instant, or with the next step if that is past."""
        self._pending = sorted([*self._pending, fault], key=first_step)

    def clear(self, fault: Fault, model: Any) -> None:
        """Clear a fault: the unit works again from the next step on."""
        self._pending = [item for item in self._pending if item != fault]
        self._live = [live for live in self._live if live.fault != fault]
        self._apply(model)

    def steps_before(self, step: int, wanted: int) -> int:
        """Return how many of the `wanted` steps come before a fault that has not begun."""
        if not self._pending:
            return wanted
        return min(wanted, max(1, first_step(self._pending[0]) - step))

    def is_due(self, step: int) -> bool:
        """Return whether the instant of a fault has come that has not begun."""
        return bool(self._pending) and first_step(self._pending[0]) <= step

    def begin(self, step: int, model: Any, data: Any) -> tuple[Fault, ...]:
        """Begin the faults whose instant has come, and return them."""
        due = [item for item in self._pending if first_step(item) <= step]
        self._pending = self._pending[len(due) :]
        self._live += [_Live(item, np.array(data.ctrl)) for item in due]
        self._apply(model)
        for fault in due:
            # What jams stops at once: through damping alone it would first throw what it carries.
            for name in _jammed(fault, self._robot):
                data.qvel[model.joint(name).dofadr[0]] = 0.0
        return tuple(due)

    def rebuilt(self, model: Any) -> None:
        """Arm the faults that have begun on a model that was built anew."""
        self._sound = None
        self._apply(model)

    def _apply(self, model: Any) -> None:
        """Give the model its sound parameters, then those of each fault that has begun."""
        if self._sound is None:
            if not self._live:
                return
            self._sound = {name: np.array(getattr(model, name)) for name in _CHANGED}
        for name, values in self._sound.items():
            getattr(model, name)[:] = values
        for live in self._live:
            self._one(model, live)

    def _one(self, model: Any, live: _Live) -> None:
        fault, robot = live.fault, self._robot
        for name in _jammed(fault, robot):
            limit = _JAM_PER_TORQUE * robot.joint(name).torque_limit
            model.dof_damping[model.joint(name).dofadr[0]] = max(_JAM, limit)
        if fault.mode == "dead":
            model.jnt_actfrcrange[model.joint(fault.unit).id] = 0.0
        elif fault.unit == POWER and fault.mode.startswith("lost"):
            for joint in robot.joints:
                model.jnt_actfrcrange[model.joint(joint.name).id] = 0.0
            for gripper in robot.grippers:
                model.actuator_forcerange[model.actuator(gripper.name).id] = 0.0
        elif fault.mode == "no_force":
            model.actuator_forcerange[model.actuator(fault.unit).id] = 0.0
        elif fault.mode == "opens":
            ends = gripper_ends(robot, robot.gripper(fault.unit))
            self._keep_to(model, fault.unit, ends.opened)
        elif fault.unit == CONTROL and fault.mode == "frozen":
            for at in range(model.nu):
                self._keep_to(model, model.actuator(at).name, float(live.controls[at]))
        elif fault.mode == "offset":
            self._shift_servo(model, fault.unit)

    def _keep_to(self, model: Any, actuator: str, position: float) -> None:
        """Make a servo keep to a position [rad or m], whatever the command."""
        at = model.actuator(actuator).id
        model.actuator_biasprm[at, 0] += model.actuator_gainprm[at, 0] * position
        model.actuator_gainprm[at, 0] = 0.0

    def _shift_servo(self, model: Any, sensor: str) -> None:
        """Make the servo of an encoder's joint regulate what the encoder reads."""
        result = next(item for item in self._robot.sensors if item.name == sensor)
        if result.kind == "encoder":
            at = model.actuator(result.part).id
            offset = encoder_offset(self._robot.joint(result.part).type)
            model.actuator_biasprm[at, 0] += model.actuator_biasprm[at, 1] * offset


def _jammed(fault: Fault, robot: Robot) -> tuple[str, ...]:
    """Return the joints that a fault holds fast."""
    if fault.mode == "jam":
        return (fault.unit,)
    if fault.mode == "stuck":
        gripper: Gripper = robot.gripper(fault.unit)
        return gripper.joints
    if fault.mode == "lost_with_brakes":
        return tuple(joint.name for joint in robot.arm_joints)
    return ()
