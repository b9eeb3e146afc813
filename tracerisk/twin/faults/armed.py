"""The faults of one simulation: when each begins, and what it does to the model.

A fault changes parameters of the model and nothing else of the physics, so that the same model,
state and controls go on from there to the same bits. Without a fault the model is not touched.
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracerisk.common.hardware.model import CONTROL, POWER
from tracerisk.twin.faults.fault import Fault
from tracerisk.twin.physics.motion import STEP_NS
from tracerisk.twin.robots.gripper_ends import gripper_ends
from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.robots.robot_parts import Gripper

ENCODER_OFFSET = 0.05
"""By how much an encoder with an offset reads too much: of a joint that turns [rad]."""
SLIDE_OFFSET = 0.01
"""The same of a joint that slides [m]."""
ENCODER_NOISE = 0.01
"""The standard deviation of a noisy encoder: of a joint that turns [rad]."""
SLIDE_NOISE = 0.002
"""The same of a joint that slides [m]."""
LOOK_EVERY = 10
"""After how many steps drives look at their encoders, and noise changes."""

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
    position: float = 0.0
    """Where the joint of an encoder was then [rad or m]; 0 for all else."""
    velocity: float = 0.0
    """How fast that joint was then [rad/s or m/s]; 0 for all else."""
    has_stopped: bool = False
    """Whether the drives have stopped the arm because of it."""
    noise: float = 0.0
    """By how much a noisy encoder reads too much now [rad or m]."""


def first_step(fault: Fault) -> int:
    """Return the first physics step that a fault changes."""
    return step_at(fault.time_s)


def step_at(time_s: float) -> int:
    """Return the first physics step that does not begin before a time [s]."""
    return -(-round(time_s * 1e9) // STEP_NS)


def last_step(fault: Fault) -> float:
    """Return the first physics step that a fault changes no more; infinite for one that stays."""
    return math.inf if fault.lasts_s is None else step_at(fault.time_s + fault.lasts_s)


def noise(sensor: str, step: int) -> float:
    """Return the noise of a sensor in a step, of standard deviation 1: the same for the same."""
    return random.Random(f"{sensor} {step // LOOK_EVERY}").gauss(0.0, 1.0)


def encoder_noise(sensor: str, joint_type: str, step: int) -> float:
    """Return what a noisy encoder adds to the position in a step [rad or m]."""
    most = SLIDE_NOISE if joint_type == "prismatic" else ENCODER_NOISE
    return most * noise(sensor, step)


def encoder_offset(joint_type: str) -> float:
    """Return what an encoder with an offset adds to the position [rad or m]."""
    return SLIDE_OFFSET if joint_type == "prismatic" else ENCODER_OFFSET


class ArmedFaults:
    """The faults of a simulated robot; `live` are those that have begun."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._pending: list[Fault] = []
        self._live: list[_Live] = []
        self._encoders = robot.encoders
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
        """Return how many of the `wanted` steps come before a fault begins, ends or changes."""
        next_steps: list[float] = [last_step(live.fault) for live in self._live]
        if self._pending:
            next_steps.append(first_step(self._pending[0]))
        if any(live.fault.unit in self._encoders for live in self._live):
            next_steps.append((step // LOOK_EVERY + 1) * LOOK_EVERY)
        return int(min(wanted, max(1, min(next_steps, default=wanted + step) - step)))

    def is_due(self, step: int) -> bool:
        """Return whether the instant of a fault has come that has not begun."""
        return bool(self._pending) and first_step(self._pending[0]) <= step

    def ended(self, step: int) -> tuple[Fault, ...]:
        """Return the faults that have lasted as long as they do."""
        return tuple(live.fault for live in self._live if last_step(live.fault) <= step)

    @property
    def has_lost_link(self) -> bool:
        """Whether the controller and the arm hear nothing of each other."""
        return any(live.fault.mode == "link_lost" for live in self._live)

    def begin(self, step: int, model: Any, data: Any) -> tuple[Fault, ...]:
        """Begin the faults whose instant has come, and return them."""
        due = [item for item in self._pending if first_step(item) <= step]
        self._pending = self._pending[len(due) :]
        self._live += [self._begun(item, model, data) for item in due]
        self._apply(model)
        for fault in due:
            # What jams stops at once: through damping alone it would first throw what it carries.
            for name in _jammed(fault, self._robot):
                data.qvel[model.joint(name).dofadr[0]] = 0.0
        return tuple(due)

    def _begun(self, fault: Fault, model: Any, data: Any) -> _Live:
        live = _Live(fault, np.array(data.ctrl))
        part = self._encoders.get(fault.unit)
        if part is not None:
            joint = model.joint(part)
            live.position = float(data.qpos[joint.qposadr[0]])
            live.velocity = float(data.qvel[joint.dofadr[0]])
            # What reads nothing is seen at once.
            is_seen = fault.mode == "absent"
            live.has_stopped = is_seen and self._robot.drives.encoder_fault == "stops"
        return live

    def look(self, step: int, model: Any, data: Any) -> None:
        """Compare encoders with their set-points, and stop the arm where its drives would."""
        if step % LOOK_EVERY or not self._live:
            return
        for live in self._live:
            part = self._encoders.get(live.fault.unit)
            if part is None:
                continue
            if live.fault.mode == "noisy":
                kind = self._robot.joint(part).type
                live.noise = encoder_noise(live.fault.unit, kind, step)
                self._apply(model)
            elif live.fault.mode == "frozen" and not live.has_stopped:
                drives = self._robot.drives
                at = model.actuator(part).id
                off = abs(float(data.ctrl[at]) - live.position)
                if drives.encoder_fault == "stops" and off > drives.following_error:
                    live.has_stopped = True
                    self._apply(model)
            if live.has_stopped:
                for joint in self._robot.arm_joints:
                    data.qvel[model.joint(joint.name).dofadr[0]] = 0.0

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
        for name in _jammed(fault, robot) if not live.has_stopped else _arm(robot):
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
        elif fault.unit == CONTROL:
            # Of a link that is lost too: drives that hear nothing keep to what they heard last.
            for at in range(model.nu):
                self._keep_to(model, model.actuator(at).name, float(live.controls[at]))
        elif fault.unit in self._encoders:
            self._change_servo(model, live)

    def _keep_to(self, model: Any, actuator: str, position: float) -> None:
        """Make a servo keep to a position [rad or m], whatever the command."""
        at = model.actuator(actuator).id
        model.actuator_biasprm[at, 0] += model.actuator_gainprm[at, 0] * position
        model.actuator_gainprm[at, 0] = 0.0

    def _change_servo(self, model: Any, live: _Live) -> None:
        """Make the servo of an encoder's joint regulate what the encoder reads."""
        part = self._encoders[live.fault.unit]
        bias = model.actuator_biasprm[model.actuator(part).id]
        if live.fault.mode in ("frozen", "absent"):
            bias[0] += bias[1] * live.position + bias[2] * live.velocity
            bias[1] = bias[2] = 0.0
            return
        off = live.noise
        if live.fault.mode == "offset":
            off = encoder_offset(self._robot.joint(part).type)
        bias[0] += bias[1] * off


def _jammed(fault: Fault, robot: Robot) -> tuple[str, ...]:
    """Return the joints that a fault holds fast."""
    if fault.mode == "jam":
        return (fault.unit,)
    if fault.mode == "stuck":
        gripper: Gripper = robot.gripper(fault.unit)
        return gripper.joints
    return _arm(robot) if fault.mode == "lost_with_brakes" else ()


def _arm(robot: Robot) -> tuple[str, ...]:
    return tuple(joint.name for joint in robot.arm_joints)
