"""The parts of a robot as data: links, joints, drives, groups, grippers, controllers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from tracerisk.common.geometry.shapes import Shape

JointType = Literal["revolute", "continuous", "prismatic", "fixed"]
ControllerType = Literal["follow_joint_trajectory", "gripper_command"]

OFFERED: Mapping[ControllerType, tuple[tuple[str, str, str], ...]] = {
    "follow_joint_trajectory": (
        ("action", "/follow_joint_trajectory", "control_msgs/FollowJointTrajectory"),
        ("topic", "/command", "trajectory_msgs/JointTrajectory"),
        ("topic", "/joint_trajectory", "trajectory_msgs/JointTrajectory"),
    ),
    "gripper_command": (("action", "/gripper_cmd", "control_msgs/GripperCommand"),),
}
"""What a robot's driver offers under the name of a controller of a type: whether it is an action or
a topic, what follows the name, and the ROS type."""


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
