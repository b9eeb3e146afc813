"""What a robot's driver serves, as data: its interfaces, what they move, and what they answer.

The terms are those of ROS: services, actions, subscribed and published topics, parameters. A value
that comes in is a `Value`, one that goes out is an `Output`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from tracerisk.errors import Location
from tracerisk.ros.graph.joint_names import JointName

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
    length: str = "m"
    time: str = "s"


@dataclass(frozen=True, slots=True)
class Value:
    """A value that an interface is given: a field of the message, several, or a constant.

    `paths` are fields (none for a constant). `map` translates what a field holds; `default` is
    taken where a number is 0 or less, or nothing is given. `key` is its dotted path in the file.
    """

    key: str
    location: Location
    paths: tuple[str, ...] = ()
    is_list: bool = False
    constant: Any = None
    unit: str = ""
    default: Any = None
    map: Mapping[Any, Any] | None = None

    @property
    def is_drivers(self) -> bool:
        """Whether the driver gives it, and no field of the message."""
        return all(path.startswith("$") for path in self.paths)


@dataclass(frozen=True, slots=True)
class Output:
    """A value that goes into a field of an answer: a constant, or what a name refers to.

    `first` and `last` are the part of a list that is meant, `map` translates it.
    """

    key: str
    location: Location
    constant: Any = None
    reference: str = ""
    first: int | None = None
    last: int | None = None
    unit: str = ""
    map: Mapping[Any, Any] | None = None


@dataclass(frozen=True, slots=True)
class Condition:
    """A field of the message, or `$state`, that must hold one of some values."""

    key: str
    location: Location
    path: str
    values: tuple[Any, ...]


@dataclass(frozen=True, slots=True)
class Case:
    """What an interface does where its conditions hold, all of them.

    `effect` is one of `EFFECTS` with its `roles`; `set` gives values to the driver's state;
    `note` is said where what is asked changes nothing on the twin, `need` where the twin lacks what
    it would change, `refuse` where it cannot be, `ignore` where the driver answers as if it did
    what it does not. What is moved by `stream` are set-points, of which each leads on from the one
    before.
    """

    location: Location
    when: tuple[Condition, ...] = ()
    effect: str = ""
    roles: Mapping[str, Value] = field(default_factory=dict)
    stop: bool = False
    clear: bool = False
    set: Mapping[str, Value] = field(default_factory=dict)
    note: str = ""
    need: str = ""
    refuse: str = ""
    ignore: str = ""
    stream: bool = False
    while_moving: WhileMoving | None = None
    wait: Value | None = None
    timeout: Value | None = None
    response: Mapping[str, Output] | None = None


@dataclass(frozen=True, slots=True)
class NamedJoints:
    """What a name of a driver's own stands for."""

    meaning: JointName
    location: Location


@dataclass(frozen=True, slots=True)
class Interface:
    """A service, an action or a topic; `types` are its types, of which one is in use.

    `response` is the answer of a service, the result of an action or the message of a published
    topic; `rate` [Hz] is that of a published topic or of an action's feedback.
    """

    kind: InterfaceKind
    name: str
    types: tuple[str, ...]
    location: Location
    cases: tuple[Case, ...] = ()
    response: Mapping[str, Output] | None = None
    feedback: Mapping[str, Output] = field(default_factory=dict)
    rate: float = 10.0
    latch: bool = False
    while_moving: WhileMoving | None = None
    group: str | None = None
    gripper: str | None = None


@dataclass(frozen=True, slots=True)
class Driver:
    """The description of one driver; `file` is where it stands.

    `packages` are those of its messages; it is there where the controller uses one of them.
    `closed` and `opened` are the gripper's numbers at its ends. `codes` are the numbers of
    outcomes; `errors` those of outcomes after which nothing moves until the error is cleared, and
    which also set `enabled` to false with `error_disables`. `definitions` are texts of messages
    that the workspace lacks, by `package/srv/Name`. `frames` are those of tf that it
    publishes, each with the link where it is. One of whose messages a user's workspace has none is
    a mistake; a shipped or an installed one is not meant then. `robot` is the one that who uses
    its messages drives, where nothing names another. `joints` are names that it has beside those
    of the joints. With `of_joints` it is that of robots which have these. `stop_at_limits` and
    `ignore_tolerances` are what it does with trajectories; where the program has set what
    `trajectories_need` names to another value than one of these, it carries out none. `on_error`
    are values that its state takes with an error, `remedies` what to do where it refuses motions,
    by the outcome.
    """

    name: str
    file: str
    packages: tuple[str, ...] = ()
    robot: str | None = None
    node: str = "/robot_driver"
    group: str | None = None
    tool: tuple[str, ...] = ()
    frame: str | None = None
    gripper: str | None = None
    closed: float = 0.0
    opened: float = 1.0
    units: Units = field(default_factory=Units)
    rotation: Rotation = "rpy"
    while_moving: WhileMoving = "replace"
    codes: Mapping[str, Any] = field(default_factory=dict)
    errors: Mapping[str, int] = field(default_factory=dict)
    error_disables: bool = False
    on_error: Mapping[str, Any] = field(default_factory=dict)
    remedies: Mapping[str, str] = field(default_factory=dict)
    state: Mapping[str, Any] = field(default_factory=dict)
    parameters: Mapping[str, Output] = field(default_factory=dict)
    interfaces: tuple[Interface, ...] = ()
    definitions: Mapping[str, str] = field(default_factory=dict)
    frames: Mapping[str, str] = field(default_factory=dict)
    joints: Mapping[str, NamedJoints] = field(default_factory=dict)
    of_joints: tuple[str, ...] = ()
    stop_at_limits: bool = False
    ignore_tolerances: bool = False
    trajectories_need: Mapping[str, tuple[Any, ...]] = field(default_factory=dict)
    origin: Origin = "user"


def is_share(unit: str) -> bool:
    """Return whether a unit is a share of what the robot is rated for."""
    return unit in ("fraction", "percent")
