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
    """A rigid body of the robot; masses in [kg], lengths in [m].

    `inertia` is (xx, yy, zz, xy, xz, yz) about the centre of mass, in the link's axes [kg m^2].
    """

    name: str
    mass: float
    centre_of_mass: tuple[float, float, float]
    inertia: tuple[float, float, float, float, float, float] | None
    shapes: tuple[Shape, ...]


@dataclass(frozen=True, slots=True)
class Servo:
    """The position servo of a joint: stiffness [N m/rad] and damping [N m s/rad] (or [N/m]...).

    `friction` is the passive damping of the joint itself, in the unit of `damping`.
    """

    stiffness: float
    damping: float
    armature: float
    friction: float = 1.0


@dataclass(frozen=True, slots=True)
class Joint:
    """A movable joint: position limits [rad or m] and rated figures, all positive.

    `velocity_limit` [rad/s or m/s], `acceleration_limit` [rad/s^2 or m/s^2], `torque_limit`
    [N m or N].
    `plan_velocity` and `plan_acceleration` are what MoveIt plans with where that differs from
    the rated figures, in the same units.
    """

    name: str
    type: JointType
    lower: float
    upper: float
    velocity_limit: float
    acceleration_limit: float
    torque_limit: float
    servo: Servo
    plan_velocity: float | None = None
    plan_acceleration: float | None = None

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
    """How a link hangs on its parent: a frame (`xyz` [m], `rpy` [rad]) and a joint about `axis`."""

    name: str
    type: JointType
    parent: str
    child: str
    xyz: tuple[float, float, float]
    rpy: tuple[float, float, float]
    axis: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Group:
    """A planning group: its joints in order, and the link whose pose a goal speaks of.

    `turns_freely` says that its solver brings the link to positions, turned as near as it may be.
    `members` are all its joints in order, with those that are fixed, passive or follow another;
    empty where nobody says which those are.
    """

    joints: tuple[str, ...]
    tip_link: str | None
    turns_freely: bool = False
    members: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Gripper:
    """A gripper whose fingers move together, driven by one servo.

    Its position is that of the first joint, from `least` to `opening` [m or rad], the greatest;
    which of the two is open, `gripper_ends` knows. The other joints follow with their sign in
    `signs`. `effort` is the greatest force of one finger
    [N or N m], `velocity_limit` the rated speed of one finger, `speed` the one it is driven at
    [m/s or rad/s].
    `pads` are the links that touch what is held.
    """

    name: str
    group: str
    joints: tuple[str, ...]
    pads: tuple[str, ...]
    opening: float
    effort: float
    velocity_limit: float
    speed: float
    stiffness: float
    damping: float
    least: float = 0.0
    signs: tuple[int, ...] = ()

    def sign(self, joint: str) -> int:
        """Return 1 for a joint that moves as the first one, -1 for one that moves against it."""
        return self.signs[self.joints.index(joint)] if self.signs else 1

    def position(self, joints: Mapping[str, float]) -> float:
        """Return the position of the gripper for those of its joints that are given."""
        found = [self.sign(name) * joints[name] for name in self.joints if name in joints]
        return sum(found) / len(found)

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
    type: ControllerType
    joints: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Scaling:
    """The fractions of the rated velocity and acceleration that a plan uses by default."""

    velocity: float
    acceleration: float


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
        return max((max(each, 1.0 / each) for each in self.gravity.values()), default=1.0)

    @property
    def sentence(self) -> str:
        """What an output says of them."""
        apart = ", ".join(f"{name} {each - 1.0:+.0%}" for name, each in self.gravity.items())
        return (
            f"masses are those of {self.source}; by {self.other} the gravity torque is another "
            f"({apart})"
        )


DEFAULT_SCALING = Scaling(0.1, 0.1)
"""What MoveGroupInterface takes where `default_velocity_scaling_factor` and
`default_acceleration_scaling_factor` of the robot's joint_limits.yaml are not set."""


@dataclass(frozen=True, slots=True)
class Robot:
    """A robot; `joints` are all that move, those of the grippers included, in the file's order.

    `named_states` maps group, then state, then joint to a position.
    `initial_state` gives the position of every joint when the run begins.
    `approximate` says that figures are assumed; `assumes_names` that groups and states which the
    controller asks for are assumed as well. `chosen_by` says why it is this robot, `doubt` why
    another one may be meant; it is empty where none may.
    `disabled_collisions` are pairs of links that may touch, each pair in order.
    `payload` is rated, in [kg], `None` where it is not known.
    `own_sensors` are those beside the encoders, `without_encoder` the arm joints that have none.
    `actuators` maps those that the model names to the joints that each moves.
    `effort_unit` is what its driver gives as the effort of a joint, as `--effort-unit` takes it;
    empty where it is not known.
    `following` is how its driver follows a stream of set-points.
    `assumed_figures` are sentences on what is another robot's, or left out.
    `weighed` is what spoke for it and for others, in one line; empty where nothing was weighed.
    `masses` is how far public sources of the masses differ, `None` where one alone is known.
    """

    name: str
    title: str
    source: str
    base_link: str
    links: tuple[Link, ...]
    attachments: tuple[Attachment, ...]
    joints: tuple[Joint, ...]
    groups: Mapping[str, Group]
    named_states: Mapping[str, Mapping[str, Mapping[str, float]]]
    initial_state: Mapping[str, float]
    grippers: tuple[Gripper, ...]
    controllers: tuple[Controller, ...]
    default_scaling: Scaling
    default_scene: str | None
    file: str
    approximate: bool = False
    aliases: tuple[str, ...] = field(default=())
    other_models: tuple[str, ...] = ()
    disabled_collisions: frozenset[tuple[str, str]] = frozenset()
    assumes_names: bool = False
    chosen_by: str = ""
    doubt: str = ""
    payload: float | None = None
    own_sensors: tuple[Sensor, ...] = ()
    without_encoder: tuple[str, ...] = ()
    actuators: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    effort_unit: str = ""
    following: Following = Following()
    assumed_figures: tuple[str, ...] = ()
    weighed: str = field(default="", compare=False)
    masses: Masses | None = None

    @property
    def is_described(self) -> bool:
        """Whether it is read from a description of its own, not shipped or generic."""
        shipped = self.file.startswith("robots/") and self.file[7:-5] in robot_names()
        return not shipped and not self.file.endswith("robots/generic.py")

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
        touching = [link.name for link in self.links if any(each.contact for each in link.shapes)]
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
        hangs = {each.child: each for each in self.attachments}
        while link in hangs:
            yield hangs[link]
            link = hangs[link].parent

    def with_followers(self, target: Mapping[str, float]) -> dict[str, float]:
        """Return joint positions with those of the fingers that follow the ones it names."""
        found = dict(target)
        for gripper in self.grippers:
            lead = next((name for name in gripper.joints if name in target), None)
            for name in gripper.joints:
                if lead is not None and name not in target:
                    own = self.joint(name)
                    wanted = gripper.sign(lead) * gripper.sign(name) * target[lead]
                    found[name] = min(max(wanted, own.lower), own.upper)
        return found

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
        f"unknown robot '{text}'; {one_of(robot_names(), text)}; or give a robot file "
        f"(.yaml, {', '.join(MODEL_SUFFIXES)})"
    )


@functools.cache  # robots are frozen, and each is read several times to find the one that is meant
def _shipped(name: str) -> Robot:
    from tracerisk.twin.robots.robot_reader import read_robot

    path = SHIPPED_ROBOTS / f"{name}.yaml"
    return read_robot(path, shown=f"robots/{path.name}")
