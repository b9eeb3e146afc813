"""What a described driver answers: positions, poses, states and codes in the fields of messages."""

# ruff: noqa: ARG002 - what a name refers to is called with the command's outcome
from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from tracerisk.errors import DriverError
from tracerisk.ros.graph.sensor_reading import SensorReading
from tracerisk.ros.messages.fields import fields_of
from tracerisk.ros.robot.arm_motion import ArmMotion
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.transforms.poses import compose, inverse, rotate, rpy_from_quaternion
from tracerisk.ros.vendors.conventions import Conventions, Dimension, Quantity
from tracerisk.ros.vendors.described.motion_queue import MotionQueue
from tracerisk.ros.vendors.description import Driver, Output
from tracerisk.ros.vendors.message_paths import FieldError, read, write
from tracerisk.twin.physics.motion import Pose

_OF_JOINTS = frozenset(
    {
        "joints",
        "velocities",
        "pose",
        "position",
        "orientation",
        "rpy",
        "rotation",
        "transform",
        "gripper",
        "gripper_width",
    }
)
_MOVING = 1e-3
"""Fingers are moving from this speed up [rad/s or m/s]."""
_CONVENTIONAL = {"success": "$success", "message": "$message"}


@dataclass(frozen=True, slots=True)
class Result:
    """The result of a command."""

    outcome: str = "succeeded"
    """One of `OUTCOMES`."""
    message: str = ""
    """Why it failed, in words; empty where it succeeded."""
    joints: tuple[float, ...] | None = None
    """The joint positions that kinematics returned [rad or m], (n_joints,); else `None`."""
    pose: Pose | None = None
    """The pose that kinematics returned; else `None`."""


@dataclass(eq=False)
class Answers:
    """Fills messages with what outputs refer to."""

    _driver: Driver
    """The description of the driver."""
    _arm: ArmMotion
    """The arm that the values are read from."""
    _queue: MotionQueue
    """The motions of the arm."""
    _grips: MotionQueue
    """The motions of the gripper."""
    _state: Mapping[str, Any]
    """The present values of the driver's state and parameters, by name."""
    _messages: TwinMessages
    """The factory of messages and stamps."""
    _reading: SensorReading
    """The record of the sensors that the controller reads."""

    def __post_init__(self) -> None:
        self._scheduler = self._arm.scheduler
        self.conventions = Conventions(self._driver.units, self._driver.rotation)
        # What a name refers to whatever came of the command; of the others there are methods.
        self._plain: Mapping[str, Callable[[], Any]] = {
            "enabled": lambda: self._queue.is_enabled,
            "error": lambda: self._queue.error,
            "gripper_moving": lambda: self._grips.is_busy,
            "has_gripper": lambda: self._arm.gripper is not None,
            "joint_names": lambda: list(self._arm.joints),
            "moving": lambda: self._queue.is_busy,
            "queued": lambda: self._queue.waiting,
            "robot": lambda: self._arm.twin.robot.name,
            "stamp": lambda: self._scheduler.now_ns * 1e-9,
        }

    def fill(
        self,
        message: Any,
        outputs: Mapping[str, Output] | None,
        result: Result,
        request: Any = None,
    ) -> Any:
        """Fill a message and return it; fields that are not described keep their defaults.

        Without `outputs`, `success` and `message` are what came of it, as in std_srvs/Trigger.
        A header is stamped.

        Raises:
            DriverError: a value does not fit its field, with the place of the description.
        """
        fields = {field.name: field for field in fields_of(type(message))}
        header = fields.get("header")
        if header is not None and header.base == "std_msgs/Header":
            self._messages.stamp(message.header, self._scheduler.now_ns)
            message.header.frame_id = self._driver.frame or self._arm.twin.robot.base_link
        if outputs is None:
            outputs = {}
            for name, reference in _CONVENTIONAL.items():
                if name in fields and fields[name].base in ("bool", "string"):
                    setattr(message, name, self._referred(reference[1:], result, request))
        for path, output in outputs.items():
            try:
                value = self.value(output, result, request)
                write(message, path, value, self.conventions, output.unit)
            except FieldError as error:
                raise DriverError(f"{output.key}: {error}", output.location) from error
        return message

    def value(self, output: Output, result: Result, request: Any = None) -> Any:
        """Return what an output stands for.

        Raises:
            FieldError: a list is shorter than what is asked of it.
        """
        if not output.reference:
            return output.constant
        value = self._referred(output.reference, result, request)
        if output.first is not None:
            value = _part(value, output)
        if output.map is not None:
            text = str(value).lower() if isinstance(value, bool) else str(value)
            value = output.map.get(text, output.map.get("else", value))
        return value

    def plain(self, output: Output) -> Any:
        """Return what an output stands for as a parameter holds it."""
        value = self.value(output, Result())
        if isinstance(value, Quantity):
            numbers = self.conventions.numbers(value, output.unit)
            return numbers[0] if value.is_scalar else numbers
        if isinstance(value, Pose):
            return self.conventions.pose_numbers(value)
        return list(value) if isinstance(value, tuple) else value

    def asks_sensors(self, outputs: Mapping[str, Output] | None) -> bool:
        """Return whether outputs hold what encoders measure."""
        return any(output.reference in _OF_JOINTS for output in (outputs or {}).values())

    def note_reading(self, outputs: Mapping[str, Output] | None, result: Result) -> None:
        """Note that the controller asks now for what sensors of the joints measure."""
        if any(output.reference == "efforts" for output in (outputs or {}).values()):
            self._reading.asked("torque")
        if result.pose is None and result.joints is None and self.asks_sensors(outputs):
            self._reading.asked("encoder")

    def _referred(self, name: str, result: Result, request: Any) -> Any:
        if name.startswith("request."):
            return None if request is None else read(request, name.removeprefix("request."))
        if name in self._state or name in self._driver.parameters:
            return self._state[name]
        plain = self._plain.get(name)
        return getattr(self, f"_{name}")(result) if plain is None else plain()

    # What a name refers to

    def _joints(self, result: Result) -> Quantity:
        positions = self._arm.positions() if result.joints is None else result.joints
        return Quantity(tuple(positions), self._dimensions())

    def _velocities(self, result: Result) -> Quantity:
        return Quantity(tuple(self._arm.velocities()), self._dimensions())

    def _efforts(self, result: Result) -> Quantity:
        efforts = tuple(self._arm.efforts())
        plain: Dimension = "plain"
        return Quantity(efforts, (plain,) * len(efforts))

    def _dimensions(self) -> tuple[Dimension, ...]:
        sliding = (joint.type == "prismatic" for joint in self._arm.arm)
        dimensions: list[Dimension] = ["length" if flag else "angle" for flag in sliding]
        return tuple(dimensions)

    def _pose(self, result: Result) -> Pose:
        pose = self._arm.tool_pose() if result.pose is None else result.pose
        frame = self._driver.frame
        if frame is None or frame not in self._arm.twin.robot.link_names:
            return pose
        return compose(inverse(self._arm.twin.link_pose(frame)), pose)

    def _position(self, result: Result) -> Quantity:
        return Quantity(self._pose(result).position, ("length",) * 3)

    def _orientation(self, result: Result) -> Quantity:
        return Quantity(self._pose(result).orientation, ("plain",) * 4)

    def _rpy(self, result: Result) -> Quantity:
        return Quantity(rpy_from_quaternion(self._pose(result).orientation), ("angle",) * 3)

    def _rotation(self, result: Result) -> Quantity:
        turn = self._pose(result).orientation
        if self._driver.rotation == "quaternion":
            return Quantity(turn, ("plain",) * 4)
        in_radians = Conventions(rotation=self._driver.rotation)
        return Quantity(tuple(in_radians.turn_numbers(turn)), ("angle",) * 3)

    def _transform(self, result: Result) -> Quantity:
        x, y, z = self._pose(result).position
        turn = self._pose(result).orientation
        columns = (rotate(turn, axis) for axis in ((1, 0, 0), (0, 1, 0), (0, 0, 1)))
        plain: list[Dimension] = ["plain", "plain", "plain", "plain"]
        numbers = [value for column in columns for value in (*column, 0.0)]
        place: list[Dimension] = ["length", "length", "length", "plain"]
        return Quantity((*numbers, x, y, z, 1.0), (*plain * 3, *place))

    def _gripper(self, result: Result) -> float:
        closed, opened = self._driver.closed, self._driver.opened
        return closed + self._arm.grip() * (opened - closed)

    def _gripper_width(self, result: Result) -> Quantity:
        return Quantity((self._arm.grip_width(),), ("length",), is_scalar=True)

    def _status(self, result: Result) -> str:
        if self._queue.is_busy:
            return "moving"
        if not self._queue.is_enabled:
            return "disabled"
        return "error" if self._queue.error else "idle"

    def _success(self, result: Result) -> bool:
        return result.outcome == "succeeded"

    def _code(self, result: Result) -> Any:
        codes, outcome = self._driver.codes, result.outcome
        if outcome == "wrong_count" and outcome not in codes:
            outcome = "invalid_goal"
        if outcome in codes:
            return codes[outcome]
        return codes.get("succeeded", 0) if self._success(result) else codes.get("failed", -1)

    def _message(self, result: Result) -> str:
        return result.message or result.outcome


def _part(value: Any, output: Output) -> Any:
    first = output.first or 0
    last = None if output.last is None else output.last + 1
    is_one = last == first + 1
    length = len(value.values) if isinstance(value, Quantity) else len(value)
    if is_one and first >= length:
        raise FieldError(f"${output.reference} has {length} entries, and [{first}] is asked for")
    if isinstance(value, Quantity):
        return Quantity(value.values[first:last], value.dimensions[first:last], is_scalar=is_one)
    return value[first] if is_one else value[first:last]
