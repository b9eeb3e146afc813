"""Make a robot of what a model file gives: a tree of joints, links, groups and states.

What the file leaves out is assumed as the constants below say, and the robot is then marked
approximate.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from tracerisk.errors import Location
from tracerisk.twin.robots.gripper_ends import gripper_ends
from tracerisk.twin.robots.outline import derived_servo, weight_behind
from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.robots.robot_parts import (
    DEFAULT_SCALING,
    Attachment,
    Gripper,
    Group,
    Joint,
    JointType,
    Link,
    Servo,
)
from tracerisk.twin.urdf.grippers import GripperParts, built_gripper, grippers_of, padded
from tracerisk.twin.urdf.groups import controllers_of, groups_of, states_of
from tracerisk.twin.urdf.srdf import Srdf
from tracerisk.twin.urdf.tree import NoWholeRobotError, Tree, UrdfJoint

# Assumed where a file says nothing, or 0. Velocities are those of a slow industrial arm; the
# acceleration is what MoveIt plans with when nobody gives it one.
ASSUMED_VELOCITY = {"revolute": 1.57, "continuous": 1.57, "prismatic": 0.1}  # [rad/s or m/s]
ASSUMED_ACCELERATION = 1.0  # [rad/s^2 or m/s^2]
ASSUMED_RANGE = {"revolute": math.pi, "continuous": 2 * math.pi, "prismatic": 0.5}  # [rad or m]
ASSUMED_MASS = 0.3  # of a link that moves [kg]
LIGHTEST = 1e-3  # what moves and weighs less cannot be simulated with steps of 2 ms [kg]
_LEAST_TORQUE = 1.0  # of a joint whose file gives none [N m or N]
_MARGIN = 2.0  # how much more than its own weight an arm is assumed to hold


@dataclass(frozen=True, slots=True)
class RobotParts:
    """What was read of a robot."""

    name: str
    """The name of the robot."""
    file: str
    """The model file, for messages."""
    tree: Tree
    """The links and joints of the file."""
    links: tuple[Link, ...]
    """The rigid bodies, in the order of the file."""
    assumed: bool
    """Whether some figure of the links is assumed."""
    srdf: Srdf | None = None
    """The groups, states and end effectors of the robot; `None` without an SRDF."""
    servos: Mapping[str, Servo] = field(default_factory=dict)
    """The position servos that the file gives, by joint."""
    fingers: frozenset[str] = frozenset()
    """The joints that the file's actuators show to be a gripper's."""
    states: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    """Named joint positions [rad or m] that belong to no group."""
    begins: Mapping[str, float] = field(default_factory=dict)
    """The positions of joints when the run begins [rad or m]."""
    disabled_collisions: frozenset[tuple[str, str]] = frozenset()
    """Pairs of links that do not collide by the model file, each pair sorted."""


def assembled_robot(parts: RobotParts) -> Robot:
    """Return the robot; groups, states and end effectors are those of the SRDF.

    Without an SRDF each arm is a group named `arm` (`arm_2` and so on), each gripper one named
    `gripper`. Raises RobotError when no joint moves.
    """
    tree, srdf = parts.tree, parts.srdf
    if not tree.moving:
        raise NoWholeRobotError(
            "has no joint that moves an arm; name the file of the whole robot",
            Location(parts.file),
        )
    groups = groups_of(tree, srdf)
    gripping = grippers_of(tree, srdf, groups, parts.fingers)
    fingers = {name for one in gripping for name in one.joints}
    # A joint that follows another one outside a gripper has no motor of its own.
    still = {joint.name for joint in tree.moving if joint.mimic and joint.name not in fingers}
    assumed = parts.assumed or bool(still)
    joints: list[Joint] = []
    for urdf_joint in tree.moving:
        if urdf_joint.name in still:
            continue
        joint, guessed = _joint(urdf_joint, tree, parts.links, parts.servos.get(urdf_joint.name))
        joints.append(joint)
        assumed |= guessed
    by_name = {joint.name: joint for joint in joints}
    grippers, by_name, links = _with_grippers(gripping, by_name, parts.links, tree)
    groups = {
        name: replace(group, joints=tuple(j for j in group.joints if j in by_name))
        for name, group in groups.items()
    }
    groups = {name: group for name, group in groups.items() if group.joints}
    for gripper in grippers:
        if gripper.group not in groups:
            groups[gripper.group] = Group(gripper.joints, tree.parent_link(gripper.joints[0]))
    states = _with_states(states_of(srdf, groups, by_name), parts.states, groups, by_name)
    disabled = parts.disabled_collisions | (srdf.disabled_collisions if srdf else frozenset())
    robot = Robot(
        name=parts.name,
        title=f"robot of {parts.file}",
        source=parts.file if srdf is None else f"{parts.file}, {srdf.file}",
        base_link=tree.root,
        links=links,
        attachments=tuple(attachment_of(joint, by_name) for joint in tree.joints),
        joints=tuple(by_name.values()),
        groups=MappingProxyType(groups),
        named_states=MappingProxyType(states),
        initial_state=MappingProxyType(_initial(states, by_name, parts.begins)),
        grippers=grippers,
        controllers=controllers_of(groups, grippers),
        default_scaling=DEFAULT_SCALING,
        default_scene="empty",
        file=parts.file,
        approximate=assumed,
        disabled_collisions=disabled,
        assumed_figures=_stiff(tree, still),
    )
    return _with_open_hands(robot, {*_at_rest(states), *parts.begins})


def _with_open_hands(robot: Robot, placed: Collection[str]) -> Robot:
    """Return the robot with open grippers, but for those of which the file says where they begin.

    With closed ones, a first approach to a part would strike it.
    """
    begun = dict(robot.initial_state)
    for gripper in robot.grippers:
        if set(placed).isdisjoint(gripper.joints):
            opened = gripper_ends(robot, gripper).opened
            begun.update({name: gripper.sign(name) * opened for name in gripper.joints})
    return replace(robot, initial_state=MappingProxyType(begun))


def _stiff(tree: Tree, still: Collection[str]) -> tuple[str, ...]:
    """Return what the twin leaves out of joints that follow others outside a gripper."""
    followers = [joint.name for joint in tree.moving if joint.name in still]
    if not followers:
        return ()
    return (
        f"{', '.join(followers)} of its description follow another joint; they have no motor, and "
        "stand still on the twin",
    )


def attachment_of(joint: UrdfJoint, moving: Mapping[str, Joint]) -> Attachment:
    """Return how the child of a joint hangs on its parent; fixed if the joint does not move."""
    kind: JointType = moving[joint.name].type if joint.name in moving else "fixed"
    return Attachment(joint.name, kind, joint.parent, joint.child, joint.xyz, joint.rpy, joint.axis)


def hanging(tree: Tree) -> list[Attachment]:
    """Return how each link of a tree hangs on its parent, by the joint that the file gives it."""
    return [
        replace(attachment_of(joint, {}), type=joint.type if joint.moves else "fixed")
        for joint in tree.joints
    ]


def _joint(
    each: UrdfJoint, tree: Tree, links: Iterable[Link], servo: Servo | None
) -> tuple[Joint, bool]:
    """Return a joint that moves, and whether one of its figures is assumed."""
    kind: JointType = each.type
    assumed = False
    reach = ASSUMED_RANGE[kind]
    lower, upper = each.lower, each.upper
    if kind == "continuous":
        lower, upper = -reach, reach
    elif lower >= upper:
        lower, upper, assumed = -reach, reach, True
    velocity, torque = each.velocity, each.effort
    if velocity <= 0.0:
        velocity, assumed = ASSUMED_VELOCITY[kind], True
    weight = weight_behind(each.child, kind, links, tree.joints)
    if torque <= 0.0:
        torque, assumed = max(_MARGIN * weight, _LEAST_TORQUE), True
    elif torque < weight and each.mimic is None:
        # A placeholder: no arm is built that cannot lift itself.
        torque, assumed = _MARGIN * weight, True
    joint = Joint(
        name=each.name,
        type=kind,
        lower=lower,
        upper=upper,
        velocity_limit=velocity,
        acceleration_limit=ASSUMED_ACCELERATION,
        torque_limit=torque,
        servo=servo or derived_servo(torque, velocity),
    )
    return joint, assumed


def _with_grippers(
    gripping: Iterable[GripperParts],
    joints: Mapping[str, Joint],
    links: Iterable[Link],
    tree: Tree,
) -> tuple[tuple[Gripper, ...], dict[str, Joint], tuple[Link, ...]]:
    grippers, by_name = [], dict(joints)
    by_link = {link.name: link for link in links}
    for parts in gripping:
        gripper, fingers = built_gripper(parts, by_name, tree)
        grippers.append(gripper)
        by_name.update(fingers)
        for pad in gripper.pads:
            by_link[pad] = padded(by_link[pad])
    return tuple(grippers), by_name, tuple(by_link.values())


def _with_states(
    states: Mapping[str, Mapping[str, Mapping[str, float]]],
    named: Mapping[str, Mapping[str, float]],
    groups: Mapping[str, Group],
    joints: Mapping[str, Joint],
) -> dict[str, Mapping[str, Mapping[str, float]]]:
    """Return the states of the groups, and those of the whole robot where a group has no such."""
    completed = dict(states)
    for name, group in groups.items():
        inside = {
            state: MappingProxyType(
                {
                    joint: min(max(values[joint], joints[joint].lower), joints[joint].upper)
                    for joint in group.joints
                }
            )
            for state, values in named.items()
            if all(joint in values for joint in group.joints)
        }
        if inside:
            completed[name] = MappingProxyType({**inside, **completed.get(name, {})})
    return completed


def _initial(
    states: Mapping[str, Mapping[str, Mapping[str, float]]],
    joints: Mapping[str, Joint],
    begins: Mapping[str, float],
) -> dict[str, float]:
    """Return where the run begins: as the file says, at rest as the SRDF names it, else at zero."""
    initial = {name: min(max(0.0, j.lower), j.upper) for name, j in joints.items()}
    initial.update(_at_rest(states))
    for name in begins.keys() & joints.keys():
        initial[name] = min(max(begins[name], joints[name].lower), joints[name].upper)
    return initial


def _at_rest(states: Mapping[str, Mapping[str, Mapping[str, float]]]) -> dict[str, float]:
    """Return where joints are at rest, as the groups of the SRDF call it."""
    at_rest: dict[str, float] = {}
    for group in sorted(states, key=lambda name: (sum(map(len, states[name].values())), name)):
        for name in _RESTS:
            if name in states[group]:
                at_rest.update(states[group][name])
                break
    return at_rest


# Names under which a file says where the arm rests.
_RESTS = ("home", "Home", "rest", "ready", "resting", "sleep", "stow", "tuck", "up")
