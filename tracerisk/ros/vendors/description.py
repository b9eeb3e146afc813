"""What a robot's driver serves, as data: its interfaces, what they move, and what they answer.

The terms are those of ROS: services, actions, subscribed and published topics, parameters. A value
that comes in is a `Value`, one that goes out is an `Output`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from tracerisk.errors import Location
from tracerisk.ros.robot.trajectories.joint_names import JointName

InterfaceKind = Literal["services", "actions", "subscribed_topics", "published_topics"]
Rotation = Literal["rpy", "quaternion", "rotation_vector", "euler_xyz", "euler_zyz"]
Origin = Literal["shipped", "installed", "user"]
WhileMoving = Literal["replace", "queue", "wait", "reject"]

EFFECTS: Mapping[str, tuple[str, ...]] = {
    "move": (
        *("joints", "joint_names", "pose", "position", "orientation", "named", "trajectory"),
        *("line", "relative", "frame", "speed", "acceleration", "duration"),
    ),
    "velocity": ("joints", "joint_names", "twist", "frame", "duration"),
    "grip": ("position", "width", "open", "effort"),
    "solve": ("joints", "pose", "seed"),
    "set_tool": ("pose", "transform"),
}
"""What an interface can do that needs values, and the roles that its values play."""

TARGETS: Mapping[str, tuple[str, ...]] = {
    "move": ("joints", "pose", "position", "orientation", "named", "trajectory"),
    "velocity": ("joints", "twist"),
    "grip": ("position", "width", "open"),
    "solve": ("joints", "pose"),
    "set_tool": ("pose", "transform"),
}
"""The roles of which an effect needs one."""

WORDS = frozenset({"frame", "named"})
"""The roles of which a plain string is the word itself, and no field."""

OUTCOMES = (
    *("succeeded", "failed", "bad_request", "wrong_count", "invalid_goal"),
    *("no_ik_solution", "no_plan"),
    *("collision", "start_in_collision", "aborted", "preempted", "timeout"),
    *("busy", "disabled", "in_error", "not_simulated"),
)
"""What a command can come to; `failed` stands for each failure that has no code of its own, and
`invalid_goal` for `wrong_count`: other numbers of values than there are joints."""

REFERENCES = (
    *("joints", "joint_names", "velocities", "efforts", "pose", "position", "orientation"),
    *("rpy", "rotation", "transform"),
    *("gripper", "gripper_width", "gripper_moving", "has_gripper", "moving", "queued", "status"),
    *("success", "code", "message", "error", "stamp", "robot"),
)
"""What an answer can refer to as `$name`, beside the driver's own state and `$request.FIELD`."""

UNITS: Mapping[str, float] = {
    "rad": 1.0,
    "deg": 0.017453292519943295,
    "m": 1.0,
    "cm": 0.01,
    "mm": 0.001,
    "s": 1.0,
    "ms": 1e-3,
    "us": 1e-6,
    "ns": 1e-9,
    "N": 1.0,
    "Nm": 1.0,
    "rad/s": 1.0,
    "deg/s": 0.017453292519943295,
    "m/s": 1.0,
    "cm/s": 0.01,
    "mm/s": 0.001,
    "rad/s^2": 1.0,
    "deg/s^2": 0.017453292519943295,
    "m/s^2": 1.0,
    "mm/s^2": 0.001,
    "fraction": 1.0,
    "percent": 0.01,
}
"""Each unit in SI units; `fraction` and `percent` are of what the robot is rated for."""

OF_ALL = ("enabled", "error", "moving")
"""What each driver has of a state, beside its own."""


@dataclass(frozen=True, slots=True)
class Units:
    """The units of a driver's own messages; those of ROS's packages are in SI units (REP 103)."""

    angle: str = "rad"
    """The unit of angles: `rad` or `deg`."""
    length: str = "m"
    """The unit of lengths: `m`, `cm` or `mm`."""
    time: str = "s"
    """The unit of times: `s`, `ms`, `us` or `ns`."""


@dataclass(frozen=True, slots=True)
class Value:
    """A value that an interface is given: a field of the message, several, or a constant."""

    key: str
    """Its dotted path in the description, for messages."""
    location: Location
    """The line of the description."""
    paths: tuple[str, ...] = ()
    """The fields that it is read from; empty for a constant."""
    is_list: bool = False
    """Whether the fields form a list, also a single one."""
    constant: Any = None
    """The constant; `None` where it is read from fields."""
    unit: str = ""
    """The unit of the number; empty: the driver's."""
    default: Any = None
    """The value where a number is 0 or less, or where none is given; `None`: none."""
    map: Mapping[Any, Any] | None = None
    """The translation of what a field holds; `None`: as it is."""

    @property
    def is_drivers(self) -> bool:
        """Whether the driver gives it, and no field of the message."""
        return all(path.startswith("$") for path in self.paths)


@dataclass(frozen=True, slots=True)
class Output:
    """A value that goes into a field of an answer: a constant, or what a name refers to."""

    key: str
    """Its dotted path in the description, for messages."""
    location: Location
    """The line of the description."""
    constant: Any = None
    """The constant; used where `reference` is empty."""
    reference: str = ""
    """The name that it refers to, without `$`; empty for a constant."""
    first: int | None = None
    """The index of the first element of a list to take, from 0; `None`: the whole list."""
    last: int | None = None
    """The index of the last element to take, from 0; `None`: up to the end."""
    unit: str = ""
    """The unit of the number; empty: the driver's."""
    map: Mapping[Any, Any] | None = None
    """The translation of the value; `None`: as it is."""


@dataclass(frozen=True, slots=True)
class Condition:
    """A field of the message, or a value of the driver's state, and the values that it may hold."""

    key: str
    """Its dotted path in the description, for messages."""
    location: Location
    """The line of the description."""
    path: str
    """The path of the field; `$name` for a value of the state."""
    values: tuple[Any, ...]
    """The allowed values."""


@dataclass(frozen=True, slots=True)
class Case:
    """What an interface does where its conditions hold, all of them."""

    location: Location
    """The line of the description."""
    when: tuple[Condition, ...] = ()
    """The conditions; empty: always."""
    effect: str = ""
    """One of `EFFECTS`; empty where nothing moves."""
    roles: Mapping[str, Value] = field(default_factory=dict)
    """The values of the effect, by role."""
    stop: bool = False
    """Whether everything comes to rest."""
    clear: bool = False
    """Whether the error is cleared."""
    set: Mapping[str, Value] = field(default_factory=dict)
    """The values that the driver's state takes, by name."""
    note: str = ""
    """The remark where a request is accepted and changes nothing on the twin; else empty."""
    need: str = ""
    """What the twin lacks to do what is asked; else empty."""
    refuse: str = ""
    """Why the request is refused; else empty."""
    ignore: str = ""
    """Why the driver reports success and does nothing; else empty."""
    stream: bool = False
    """Whether the targets are set-points, each continuing from the one before."""
    plan: bool = False
    """Whether the motion is only planned, for what executes it."""
    execute: bool = False
    """Whether the motion that was planned last is carried out."""
    while_moving: WhileMoving | None = None
    """The effect of a new motion during another; `None`: the interface's."""
    wait: Value | None = None
    """Whether the answer comes after the motion; `None`: yes."""
    timeout: Value | None = None
    """The longest wait for the motion; `None`: any."""
    response: Mapping[str, Output] | None = None
    """The outputs of the answer, by field; `None`: the interface's."""


@dataclass(frozen=True, slots=True)
class NamedJoints:
    """The meaning of a driver's own name of joints."""

    meaning: JointName
    """The joints that it moves, or why it moves none."""
    location: Location
    """The line of the description."""


@dataclass(frozen=True, slots=True)
class Interface:
    """A service, an action or a topic."""

    kind: InterfaceKind
    """What it is, from the driver's side."""
    name: str
    """Its name; `*` is any name of its type."""
    types: tuple[str, ...]
    """The possible types, `package/Name`, of which one is in use."""
    location: Location
    """The line of the description."""
    cases: tuple[Case, ...] = ()
    """What it does; the first case that matches applies. Empty for a published topic."""
    response: Mapping[str, Output] | None = None
    """The outputs of a response, result or published message, by field; `None`: the default
    ones."""
    feedback: Mapping[str, Output] = field(default_factory=dict)
    """The outputs of an action's feedback, by field; empty: none is sent."""
    rate: float = 10.0
    """The rate of a published topic or of an action's feedback [Hz]."""
    latch: bool = False
    """Whether a published topic keeps its last message for later subscriptions."""
    while_moving: WhileMoving | None = None
    """The effect of a new motion during another; `None`: the driver's."""
    group: str | None = None
    """The planning group that it moves; `None`: the driver's."""
    gripper: str | None = None
    """The gripper that it moves; `None`: the driver's."""


@dataclass(frozen=True, slots=True)
class Driver:
    """The description of one driver.

    A driver is there where the controller uses one of its packages. If the workspace has none of
    its messages, this is an error in a user's description; a shipped or an installed one is then
    not in use.
    """

    name: str
    """The name of the driver."""
    file: str
    """The path of the description."""
    packages: tuple[str, ...] = ()
    """The packages of its messages."""
    robot: str | None = None
    """The robot that is assumed where nothing names one; `None`: none."""
    node: str = "/robot_driver"
    """The full name of its node."""
    group: str | None = None
    """The planning group that it moves; `None`: the only one."""
    tool: tuple[str, ...] = ()
    """The endings of link names, of which the first that fits gives the link that poses describe;
    empty: the tip of the group."""
    frame: str | None = None
    """The link that poses are relative to; `None`: the base."""
    gripper: str | None = None
    """The gripper that it moves; `None`: the only one."""
    closed: float = 0.0
    """The number of the closed gripper."""
    opened: float = 1.0
    """The number of the open gripper."""
    units: Units = field(default_factory=Units)
    """The units of its own messages."""
    rotation: Rotation = "rpy"
    """The form of rotations in its messages."""
    while_moving: WhileMoving = "replace"
    """The effect of a new motion during another."""
    codes: Mapping[str, Any] = field(default_factory=dict)
    """The value of `$code` for an outcome, by outcome."""
    errors: Mapping[str, int] = field(default_factory=dict)
    """The value of `$error` for the outcomes that stop all motion until cleared, by outcome."""
    error_disables: bool = False
    """Whether an error also sets `enabled` to false."""
    on_error: Mapping[str, Any] = field(default_factory=dict)
    """The values that the state takes with an error, by name."""
    remedies: Mapping[str, str] = field(default_factory=dict)
    """What to do where a motion is refused, by outcome."""
    state: Mapping[str, Any] = field(default_factory=dict)
    """The initial values of the state, by name."""
    parameters: Mapping[str, Output] = field(default_factory=dict)
    """The parameters that it sets, by name."""
    interfaces: tuple[Interface, ...] = ()
    """The services, actions and topics."""
    definitions: Mapping[str, str] = field(default_factory=dict)
    """The texts of messages that the workspace lacks, by `package/srv/Name`."""
    frames: Mapping[str, str] = field(default_factory=dict)
    """The tf frames that it publishes, each with the link at that place."""
    joints: Mapping[str, NamedJoints] = field(default_factory=dict)
    """The names that it has beside those of the joints."""
    of_joints: tuple[str, ...] = ()
    """The joints without which it is not in use; empty: it fits any robot."""
    stop_at_limits: bool = False
    """Whether a trajectory stops a joint at its limit and succeeds."""
    ignore_tolerances: bool = False
    """Whether the tolerances of trajectories are ignored."""
    trajectories_need: Mapping[str, tuple[Any, ...]] = field(default_factory=dict)
    """The values of the state that allow trajectories, by name, once the program has set it."""
    origin: Origin = "user"
    """Where the description comes from."""


def is_share(unit: str) -> bool:
    """Return whether a unit is a share of what the robot is rated for."""
    return unit in ("fraction", "percent")
