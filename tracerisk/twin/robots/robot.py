"""A robot as data: links, joints with their limits, planning groups, named states, grippers.

Nothing here knows a physics engine; `builder` turns a `Robot` into a model of one.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from tracerisk.common.geometry.shapes import Shape
from tracerisk.errors import RobotError, one_of
from tracerisk.trace import Element
from tracerisk.twin.robots.sensors import Sensor, joint_sensor

JointType = Literal["revolute", "continuous", "prismatic", "fixed"]
ControllerType = Literal["follow_joint_trajectory", "gripper_command"]

SHIPPED_ROBOTS = Path(__file__).parent / "shipped"
"""Where the files of the shipped robots are."""


@dataclass(frozen=True, slots=True)
class Link:
    """A rigid body of the robot."""

    name: str
    """The name of the link."""
    mass: float
    """The mass [kg]; 0 for a frame without a body."""
    centre_of_mass: tuple[float, float, float]
    """The centre of mass in the link's frame [m]."""
    inertia: tuple[float, float, float, float, float, float] | None
    """(xx, yy, zz, xy, xz, yz) about the centre of mass, in the link's axes [kg m^2]; `None`
    assumes a small one in proportion to the mass."""
    shapes: tuple[Shape, ...]
    """The primitives that collide or are drawn, in the link's frame."""
    drawn: tuple[Shape, ...] = field(default=(), compare=False)
    """The bounds of the meshes that are seen of it, each with its mesh; never simulated."""


@dataclass(frozen=True, slots=True)
class Servo:
    """The position servo of a joint."""

    stiffness: float
    """Torque per position error [N m/rad or N/m]; 0 where a gripper's servo drives the joint."""
    damping: float
    """Torque per velocity of the servo [N m s/rad or N s/m]."""
    armature: float
    """The inertia of the motor at the joint [kg m^2 or kg]."""
    friction: float = 1.0
    """The passive damping of the joint itself [N m s/rad or N s/m]."""


@dataclass(frozen=True, slots=True)
class Joint:
    """A movable joint with its limits; all rated figures are positive."""

    name: str
    """The name of the joint."""
    type: JointType
    """`revolute`, `continuous` or `prismatic`."""
    lower: float
    """The least position [rad or m]."""
    upper: float
    """The greatest position [rad or m]."""
    velocity_limit: float
    """The rated velocity [rad/s or m/s]."""
    acceleration_limit: float
    """The rated acceleration [rad/s^2 or m/s^2]."""
    torque_limit: float
    """The rated torque or force [N m or N]."""
    servo: Servo
    """The position servo that drives the joint."""
    plan_velocity: float | None = None
    """The velocity that MoveIt plans with [rad/s or m/s]; `None` for the rated one."""
    plan_acceleration: float | None = None
    """The acceleration that MoveIt plans with [rad/s^2 or m/s^2]; `None` for the rated one."""

    @property
    def unit(self) -> Literal["rad", "m"]:
        """The unit of its position."""
        return "m" if self.type == "prismatic" else "rad"

    @property
    def planned_velocity(self) -> float:
        """The greatest speed of a plan at scaling 1 [rad/s or m/s]."""
        return self.velocity_limit if self.plan_velocity is None else self.plan_velocity

    @property
    def planned_acceleration(self) -> float:
        """The greatest acceleration of a plan at scaling 1 [rad/s^2 or m/s^2]."""
        if self.plan_acceleration is None:
            return self.acceleration_limit
        return self.plan_acceleration


@dataclass(frozen=True, slots=True)
class Attachment:
    """How a link hangs on its parent."""

    name: str
    """The name of the joint between them."""
    type: JointType
    """The kind of the joint, `fixed` for a rigid attachment."""
    parent: str
    """The name of the parent link."""
    child: str
    """The name of the link that hangs on it."""
    xyz: tuple[float, float, float]
    """The place of the child's frame in the parent's [m]."""
    rpy: tuple[float, float, float]
    """Roll, pitch and yaw of the child's frame in the parent's [rad]."""
    axis: tuple[float, float, float]
    """The joint's axis of rotation or sliding, in the child's frame."""


@dataclass(frozen=True, slots=True)
class Group:
    """A planning group."""

    joints: tuple[str, ...]
    """The names of its movable joints, in order."""
    tip_link: str | None
    """The link whose pose a goal gives; `None` where the group has none."""
    turns_freely: bool = False
    """Whether its solver reaches positions only, with the nearest possible orientation."""
    members: tuple[str, ...] = ()
    """All its joints in order, also fixed, passive and following ones; empty where unknown."""


@dataclass(frozen=True, slots=True)
class Gripper:
    """A gripper whose fingers move together, driven by one servo.

    Its position is the one of the first joint, from `least` to `opening`; which of the two is
    open, `gripper_ends` knows.
    """

    name: str
    """The name of the gripper and of its actuator."""
    group: str
    """The planning group that moves the fingers."""
    joints: tuple[str, ...]
    """The joints of the fingers; the first gives the gripper's position."""
    pads: tuple[str, ...]
    """The links that touch what is held."""
    opening: float
    """The greatest position of the first joint [m or rad]."""
    effort: float
    """The greatest force of one finger [N or N m]."""
    velocity_limit: float
    """The rated speed of one finger [m/s or rad/s]."""
    speed: float
    """The speed at which the fingers are driven [m/s or rad/s]."""
    stiffness: float
    """The servo's force per position error, all fingers together [N/m or N m/rad]."""
    damping: float
    """The servo's force per velocity, all fingers together [N s/m or N m s/rad]."""
    least: float = 0.0
    """The least position of the first joint [m or rad]."""
    signs: tuple[int, ...] = ()
    """1 for a joint that moves as the first one, -1 for one that moves against it, (n_joints,);
    empty where all are 1."""

    def sign(self, joint: str) -> int:
        """Return 1 for a joint that moves as the first one, -1 for one that moves against it."""
        return self.signs[self.joints.index(joint)] if self.signs else 1

    def position(self, joints: Mapping[str, float]) -> float:
        """Return the position of the gripper for those of its joints that are given."""
        values = [self.sign(name) * joints[name] for name in self.joints if name in joints]
        return sum(values) / len(values)

    def leader(self, goal: Mapping[str, float], here: float) -> str:
        """Return the joint whose goal the gripper goes to: that furthest from where it is.

        A command to one of the joints is a command to the gripper; what a plan says of the others
        is where they were.
        """
        given = [name for name in self.joints if name in goal]
        return max(given, key=lambda name: abs(self.sign(name) * goal[name] - here))


@dataclass(frozen=True, slots=True)
class Controller:
    """A controller of the robot's driver, as MoveIt and the action clients name it."""

    name: str
    """The name of the controller, and of its action's namespace."""
    type: ControllerType
    """The action that it serves: `follow_joint_trajectory` or `gripper_command`."""
    joints: tuple[str, ...]
    """The names of the joints that it moves."""


@dataclass(frozen=True, slots=True)
class Scaling:
    """How fast a plan is, as fractions of the rated figures."""

    velocity: float
    """The fraction of the rated velocity, from 0 to 1."""
    acceleration: float
    """The fraction of the rated acceleration, from 0 to 1."""


@dataclass(frozen=True, slots=True)
class Following:
    """How the robot's driver follows set-points that come in a stream."""

    period_s: float = 0.0
    """The period of its control: of set-points that come sooner the last one counts [s]."""
    look_ahead_s: float = 0.0
    """The time over which it smooths them, at least one period of the stream [s]."""
    acceleration: tuple[float, ...] = ()
    """How fast it changes the speed of each arm joint; empty: as they are rated [rad/s^2]."""
    source: str = ""
    """Where the figures are from; empty where none are known."""


EncoderFault = Literal["stops", "runs_away"]
"""What the drives do where an encoder does not say where its joint is."""


@dataclass(frozen=True, slots=True)
class Drives:
    """How the robot's drives take the readings of their encoders."""

    encoder_fault: EncoderFault = "runs_away"
    """Whether a drive stops the arm once a reading is missing or too far off, or goes by it."""
    following_error: float = 0.1
    """How far a reading may be from its set-point before the drives stop the arm [rad]."""
    source: str = ""
    """Where this is from; empty where it is assumed."""


@dataclass(frozen=True, slots=True)
class Masses:
    """Where the masses of an arm are from, and how far another public source is off."""

    source: str
    """Where they are from."""
    other: str
    """The other public source."""
    gravity: Mapping[str, float]
    """The root mean square of its gravity torque over ours, of each joint with a load [1]."""

    @property
    def error_factor(self) -> float:
        """How far the torque of a loaded joint may be off, the widest of them: a factor above 1."""
        return max((max(value, 1.0 / value) for value in self.gravity.values()), default=1.0)

    @property
    def sentence(self) -> str:
        """What an output says of them."""
        apart = ", ".join(f"{name} {value - 1.0:+.0%}" for name, value in self.gravity.items())
        return (
            f"masses are those of {self.source}; by {self.other} the gravity torque is another "
            f"({apart})"
        )


DEFAULT_SCALING = Scaling(0.1, 0.1)
"""What MoveGroupInterface takes where `default_velocity_scaling_factor` and
`default_acceleration_scaling_factor` of the robot's joint_limits.yaml are not set."""


@dataclass(frozen=True, slots=True)
class Robot:
    """A robot with its parts, its names and what is assumed of it."""

    name: str
    """The name by which a run chooses the robot."""
    title: str
    """The maker's name of the robot, for outputs."""
    source: str
    """Where the figures are from."""
    base_link: str
    """The link at the root of the tree."""
    links: tuple[Link, ...]
    """All links, in the order of the file."""
    attachments: tuple[Attachment, ...]
    """How each link but the base hangs on its parent, fixed ones included."""
    joints: tuple[Joint, ...]
    """All joints that move, fingers included, in the order of the file."""
    groups: Mapping[str, Group]
    """The planning groups by name."""
    named_states: Mapping[str, Mapping[str, Mapping[str, float]]]
    """The joint positions [rad or m] of each named state, by group and state."""
    initial_state: Mapping[str, float]
    """The position of every joint when the run begins [rad or m]."""
    grippers: tuple[Gripper, ...]
    """The grippers; empty for a bare arm."""
    controllers: tuple[Controller, ...]
    """The controllers of the robot's driver."""
    default_scaling: Scaling
    """How fast plans are where the controller sets no scaling."""
    default_scene: str | None
    """The scene of a run that names none; `None` where there is no default."""
    file: str
    """The file that describes the robot, for messages."""
    approximate: bool = False
    """Whether some figures are assumed."""
    aliases: tuple[str, ...] = field(default=())
    """Other names by which a controller may mean the robot."""
    other_models: tuple[str, ...] = ()
    """Words that make it another model where they stand behind the robot's name."""
    disabled_collisions: frozenset[tuple[str, str]] = frozenset()
    """Pairs of links that may touch, each pair sorted."""
    assumes_names: bool = False
    """Whether groups and states that the controller asks for are assumed as well."""
    chosen_by: str = ""
    """Why this robot was chosen; empty where it was not chosen by evidence."""
    doubt: str = ""
    """Why another robot may be meant; empty where none may."""
    payload: float | None = None
    """The rated payload [kg]; `None` where it is not known."""
    own_sensors: tuple[Sensor, ...] = ()
    """The sensors beside the encoders."""
    without_encoder: tuple[str, ...] = ()
    """The arm joints that have no encoder."""
    actuators: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    """The joints that each named actuator of the model moves."""
    effort_unit: str = ""
    """The unit of a joint's effort from its driver, as `--effort-unit` takes it; empty where
    unknown."""
    following: Following = Following()
    """How its driver follows a stream of set-points."""
    drives: Drives = Drives()
    """What its drives do where an encoder fails."""
    assumed_figures: tuple[str, ...] = ()
    """Sentences on what is taken from another robot, or left out."""
    weighed: str = field(default="", compare=False)
    """The evidence for this robot and for others, in one line; empty where none was weighed."""
    masses: Masses | None = None
    """How far public sources of the masses differ; `None` where only one source is known."""

    @property
    def is_described(self) -> bool:
        """Whether it is read from a description of its own, not shipped or generic."""
        shipped = self.file.startswith("robots/") and self.file[7:-5] in robot_names()
        return not shipped and not self.file.endswith("robots/generic.py")

    @property
    def encoders(self) -> Mapping[str, str]:
        """The joint of each encoder."""
        return {sensor.name: sensor.part for sensor in self.sensors if sensor.kind == "encoder"}

    @property
    def arm_joints(self) -> tuple[Joint, ...]:
        """The joints that belong to no gripper."""
        held = {name for gripper in self.grippers for name in gripper.joints}
        return tuple(joint for joint in self.joints if joint.name not in held)

    @property
    def elements(self) -> tuple[Element, ...]:
        """What the twin watches: each arm joint, gripper, link that can touch, and sensor.

        A link has its own name there, unless another element is called so too.
        """
        own = (
            *(
                Element(joint.name, "joint", actuators=self._actuators_of((joint.name,)))
                for joint in self.arm_joints
            ),
            *(
                Element(gripper.name, "gripper", actuators=self._actuators_of(gripper.joints))
                for gripper in self.grippers
            ),
        )
        sensors = tuple(sensor.element for sensor in self.sensors)
        taken = {element.name for element in own + sensors}
        touching = [link.name for link in self.links if any(shape.contact for shape in link.shapes)]
        contacts = tuple(
            Element(f"{name}/contact" if name in taken else name, "contact", part=name)
            for name in touching
        )
        return own + contacts + sensors

    def _actuators_of(self, joints: tuple[str, ...]) -> tuple[str, ...]:
        return tuple(name for name, moves in self.actuators.items() if set(moves) & set(joints))

    @property
    def sensors(self) -> tuple[Sensor, ...]:
        """The sensors: an encoder in each arm joint, unless it has none, then the others."""
        encoders = tuple(
            joint_sensor("encoder", joint.name)
            for joint in self.arm_joints
            if joint.name not in self.without_encoder
        )
        return encoders + self.own_sensors

    @property
    def link_names(self) -> tuple[str, ...]:
        """The links, in the file's order."""
        return tuple(link.name for link in self.links)

    def above(self, link: str) -> Iterator[Attachment]:
        """Yield how a link hangs on its parent, then how that does on its own, up to the base."""
        hangs = {attachment.child: attachment for attachment in self.attachments}
        while link in hangs:
            yield hangs[link]
            link = hangs[link].parent

    def with_followers(self, target: Mapping[str, float]) -> dict[str, float]:
        """Return joint positions with those of the fingers that follow the ones it names."""
        followers = dict(target)
        for gripper in self.grippers:
            lead = next((name for name in gripper.joints if name in target), None)
            for name in gripper.joints:
                if lead is not None and name not in target:
                    own = self.joint(name)
                    wanted = gripper.sign(lead) * gripper.sign(name) * target[lead]
                    followers[name] = min(max(wanted, own.lower), own.upper)
        return followers

    def joint(self, name: str) -> Joint:
        """Return the joint called `name`; raise RobotError listing those there are."""
        for joint in self.joints:
            if joint.name == name:
                return joint
        raise RobotError(
            f"robot '{self.name}' has no joint '{name}'; "
            f"{one_of((joint.name for joint in self.joints), name)}"
        )

    def group(self, name: str) -> Group:
        """Return the planning group called `name`; raise RobotError listing those there are."""
        if name not in self.groups:
            raise RobotError(
                f"robot '{self.name}' has no planning group '{name}'; {one_of(self.groups, name)}"
            )
        return self.groups[name]

    def followed_rise(self, name: str) -> float:
        """Return how fast the driver changes a joint's speed in a stream [rad/s^2 or m/s^2]."""
        known = zip(self.arm_joints, self.following.acceleration, strict=False)
        given = next((rise for joint, rise in known if joint.name == name), None)
        return self.joint(name).acceleration_limit if given is None else given

    def gripper(self, name: str) -> Gripper:
        """Return the gripper called `name`, or moved by the group `name`."""
        for gripper in self.grippers:
            if name in (gripper.name, gripper.group):
                return gripper
        raise RobotError(
            f"robot '{self.name}' has no gripper '{name}'; "
            f"{one_of((gripper.name for gripper in self.grippers), name)}"
        )


def robot_names() -> tuple[str, ...]:
    """Return the names of the shipped robots, sorted."""
    return tuple(sorted(path.stem for path in SHIPPED_ROBOTS.glob("*.yaml")))


MODEL_SUFFIXES = (".xml", ".mjcf", ".urdf", ".xacro")
"""How the names of model files end."""


def is_model_file(name: str) -> bool:
    """Return whether a name is that of a model file (MJCF, URDF, xacro), there or not."""
    return name.lower().endswith(MODEL_SUFFIXES)


def without_stiffness(joint: str) -> str:
    """Return the message on an arm joint that no servo can move."""
    return (
        f"the servo of joint '{joint}' has stiffness 0 and cannot move it; the twin drives each "
        "joint of an arm by a position servo: give it a stiffness above 0 in N m/rad (N/m), or "
        "leave the servo out to have it derived from the rated torque"
    )


def load_robot(name_or_path: str | Path) -> Robot:
    """Read a shipped robot by its name, or a robot file by its path.

    Raises RobotError with file and line when the file is malformed, or with the names of the
    shipped robots when there is no such robot.
    """
    # Imported here, for the reader builds on the classes above.
    from tracerisk.twin.robots.robot_reader import read_robot

    text = str(name_or_path)
    if text in robot_names():
        return _shipped(text)
    path = Path(name_or_path)
    if path.suffix in (".yaml", ".yml"):
        return read_robot(path)
    raise RobotError(
        f"unknown robot '{text}'; {one_of(robot_names(), text)}; or an arm with a gripper "
        f"(ur5e+robotiq_2f_85), or a robot file (.yaml, {', '.join(MODEL_SUFFIXES)})"
    )


@functools.cache  # robots are frozen, and each is read several times to find the one that is meant
def _shipped(name: str) -> Robot:
    from tracerisk.twin.robots.robot_reader import read_robot

    path = SHIPPED_ROBOTS / f"{name}.yaml"
    return read_robot(path, shown=f"robots/{path.name}")
