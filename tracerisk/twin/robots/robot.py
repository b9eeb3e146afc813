"""A robot as data: links, joints with their limits, planning groups, named states, grippers.

Nothing here knows a physics engine; `builder` turns a `Robot` into a model of one.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from tracerisk.common.traced.elements import Element
from tracerisk.errors import RobotError, one_of
from tracerisk.twin.robots.robot_parts import (
    Attachment,
    Controller,
    Drives,
    Following,
    Gripper,
    Group,
    Joint,
    Link,
    Masses,
    Scaling,
)
from tracerisk.twin.robots.sensors import Sensor, joint_sensor

SHIPPED_ROBOTS = Path(__file__).parent / "shipped"
"""Where the files of the shipped robots are."""
WORLD = "world"
"""The frame in which a robot stands."""
WORLD_LINK = "world_link"
"""What the link `world` of a robot's file is called in the twin, where it is the root."""


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
    unpublished: frozenset[str] = frozenset()
    """The joints whose states no driver publishes: those of an assumed gripper that the controller
    does not name."""
    actuators: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    """The joints that each named actuator of the model moves."""
    effort_unit: str = ""
    """The unit of a joint's effort from its driver, as `--effort-unit` takes it; empty where
    unknown."""
    following: Following = field(default_factory=Following)
    """How its driver follows a stream of set-points."""
    drives: Drives = field(default_factory=Drives)
    """What its drives do where an encoder fails."""
    assumed_figures: tuple[str, ...] = ()
    """Sentences on what is taken from another robot, or left out."""
    weighed: str = field(default="", compare=False)
    """The evidence for this robot and for others, in one line; empty where none was weighed."""
    masses: Masses | None = None
    """How far public sources of the masses differ; `None` where only one source is known."""

    def __hash__(self) -> int:
        # Of one field that is compared: what follows from a robot can be kept by it.
        return hash(self.name)

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
    text = str(name_or_path)
    if text in robot_names():
        return _shipped(text)
    path = Path(name_or_path)
    if path.suffix in (".yaml", ".yml"):
        return _read(path)
    raise RobotError(
        f"unknown robot '{text}'; {one_of(robot_names(), text)}; or an arm with a gripper "
        f"(ur5e+robotiq_2f_85), or a robot file (.yaml, {', '.join(MODEL_SUFFIXES)})"
    )


@functools.cache  # robots are frozen, and each is read several times to find the one that is meant
def _shipped(name: str) -> Robot:
    path = SHIPPED_ROBOTS / f"{name}.yaml"
    return _read(path, f"robots/{path.name}")


def _read(path: Path, shown: str | None = None) -> Robot:
    # Imported here, for the reader builds on the classes above.
    from tracerisk.twin.robots.robot_reader import read_robot

    return read_robot(path, shown=shown)
