"""Read a URDF, with its SRDF where there is one, as a robot of the twin.

Meshes are not read: a link without primitive shapes is drawn by capsules between its joints.
Wheels and mobile bases stand still. What the file leaves out is assumed as the constants below
say, and the robot is then marked approximate.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from tracerisk.errors import Location, RobotError
from tracerisk.twin.outline import derived_servo, outlined
from tracerisk.twin.robot import (
    Attachment,
    Gripper,
    Group,
    Joint,
    JointType,
    Link,
    Robot,
    Scaling,
)
from tracerisk.twin.shapes import Shape
from tracerisk.twin.srdf import Srdf
from tracerisk.twin.urdf_grippers import GripperParts, built_gripper, grippers_of, padded
from tracerisk.twin.urdf_groups import controllers_of, groups_of, states_of
from tracerisk.twin.urdf_tree import Tree, UrdfJoint, read_tree
from tracerisk.twin.xml_reader import XmlElement, read_xml

Triple = tuple[float, float, float]

# Assumed where a file says nothing, or 0. Velocities are those of a slow industrial arm; the
# acceleration is what MoveIt plans with when nobody gives it one.
ASSUMED_VELOCITY = {"revolute": 1.57, "continuous": 1.57, "prismatic": 0.1}  # [rad/s or m/s]
ASSUMED_ACCELERATION = 1.0  # [rad/s^2 or m/s^2]
ASSUMED_RANGE = {"revolute": math.pi, "continuous": 2 * math.pi, "prismatic": 0.5}  # [rad or m]
ASSUMED_MASS = 0.3  # of a link that moves [kg]
_LEAST_TORQUE = 1.0  # of a joint whose file gives none [N m or N]
_MARGIN = 2.0  # how much more than its own weight an arm is assumed to hold
_GRAVITY = 9.81
_LIGHTEST = 1e-3  # what moves and weighs less cannot be simulated with steps of 2 ms [kg]
# MoveIt plans with a tenth of the rated figures when nobody says otherwise.
_SCALING = Scaling(0.1, 0.1)
_RADIUS = (0.008, 0.05)  # of the capsules that stand for meshes, least and greatest [m]


@dataclass(frozen=True, slots=True)
class _Read:
    """A part that was read, and whether some of it is assumed."""

    links: tuple[Link, ...]
    assumed: bool


def read_urdf(text: str | bytes, file: str, *, srdf: Srdf | None = None) -> Robot:
    """Return the robot of a URDF; groups, states and end effectors are those of the SRDF.

    Without an SRDF each arm is a group named `arm` (`arm_2` and so on), each gripper one named
    `gripper`. Raises RobotError with file and line when it is no URDF, has no joint that moves,
    or is no tree.
    """
    root = read_xml(text, file)
    tree = read_tree(root, file)
    names = [joint.name for joint in tree.moving]
    if not names:
        raise RobotError(
            "has no joint that moves an arm; name the file of the whole robot", Location(file)
        )
    groups = groups_of(tree, srdf)
    parts = _links(root, tree)
    gripping = grippers_of(tree, srdf, groups)
    fingers = {name for one in gripping for name in one.joints}
    # A joint that follows another one outside a gripper has no motor of its own.
    still = {joint.name for joint in tree.moving if joint.mimic and joint.name not in fingers}
    assumed = parts.assumed or bool(still)
    joints: list[Joint] = []
    for each in tree.moving:
        if each.name in still:
            continue
        joint, guessed = _joint(each, tree, parts.links)
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
    states = states_of(srdf, groups, by_name)
    return Robot(
        name=root.attributes.get("name", "") or "robot",
        title=f"robot of {file}",
        source=file if srdf is None else f"{file}, {srdf.file}",
        base_link=tree.root,
        links=links,
        attachments=tuple(_attachment(joint, by_name) for joint in tree.joints),
        joints=tuple(by_name.values()),
        groups=MappingProxyType(groups),
        named_states=MappingProxyType(states),
        initial_state=MappingProxyType(_initial(states, by_name)),
        grippers=grippers,
        controllers=controllers_of(groups, grippers),
        default_scaling=_SCALING,
        default_scene="empty",
        file=file,
        approximate=assumed,
        disabled_collisions=srdf.disabled_collisions if srdf else frozenset(),
    )


def _attachment(joint: UrdfJoint, moving: Mapping[str, Joint]) -> Attachment:
    kind: JointType = moving[joint.name].type if joint.name in moving else "fixed"
    return Attachment(joint.name, kind, joint.parent, joint.child, joint.xyz, joint.rpy, joint.axis)


def _links(root: XmlElement, tree: Tree) -> _Read:
    attachments = [_attachment(joint, {}) for joint in tree.joints]
    moved = {joint.child for joint in tree.moving}
    assumed = False
    links = []
    for entry in root.all("link"):
        name = tree.place_of(entry.string("name"))
        if name is None:
            continue
        mass, centre, inertia = _inertial(entry)
        if name in moved and mass < _LIGHTEST:
            # A frame between two joints, or a link of unknown mass.
            mass, inertia, assumed = ASSUMED_MASS, None, True
        shapes = _primitives(entry)
        link = Link(name, mass, centre, inertia, shapes)
        drawn = any(True for kind in ("collision", "visual") for _ in entry.all(kind))
        if not shapes and drawn:
            link = outlined(link, _radius(name, tree), attachments)
        links.append(link)
    return _Read(tuple(links), assumed)


def _radius(link: str, tree: Tree) -> float:
    """Return the radius of what stands for a mesh: an eighth of the longest way to a joint."""
    spans = [math.hypot(*joint.xyz) for joint in tree.joints if joint.parent == link]
    return min(max(max(spans, default=0.0) / 8, _RADIUS[0]), _RADIUS[1])


def _inertial(
    entry: XmlElement,
) -> tuple[float, Triple, tuple[float, float, float, float, float, float] | None]:
    """Return mass, centre of mass and inertia in the link's axes; the latter may be missing."""
    zero = (0.0, 0.0, 0.0)
    inertial = entry.first("inertial")
    mass_entry = inertial.first("mass") if inertial is not None else None
    if inertial is None or mass_entry is None:
        return 0.0, zero, None
    mass = max(mass_entry.number("value"), 0.0)
    origin = inertial.first("origin")
    centre = zero if origin is None else origin.triple("xyz", zero)
    rpy = zero if origin is None else origin.triple("rpy", zero)
    tensor = inertial.first("inertia")
    if tensor is None:
        return mass, centre, None
    xx, yy, zz, xy, xz, yz = (
        tensor.number(key, 0.0) for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    )
    turn = rotation(rpy)
    full = turn @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ turn.T
    if np.linalg.eigvalsh(full).min() <= 1e-9:
        # Placeholders and slips of the sign: no body turns like that.
        return mass, centre, None
    found = (full[0, 0], full[1, 1], full[2, 2], full[0, 1], full[0, 2], full[1, 2])
    a, b, c, d, e, f = (float(value) for value in found)
    return mass, centre, (a, b, c, d, e, f)


def rotation(rpy: Triple) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """Return the rotation matrix of roll, pitch, yaw about fixed axes [rad]."""
    (sr, sp, sy), (cr, cp, cy) = np.sin(rpy), np.cos(rpy)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def _primitives(entry: XmlElement) -> tuple[Shape, ...]:
    """Return the primitives of the collision geometry, else of the visual one."""
    for kind in ("collision", "visual"):
        found = [shape for each in entry.all(kind) if (shape := _shape(each)) is not None]
        if found:
            return tuple(found)
    return ()


def _shape(entry: XmlElement) -> Shape | None:
    geometry = entry.first("geometry")
    if geometry is None:
        return None
    zero = (0.0, 0.0, 0.0)
    origin = entry.first("origin")
    xyz = zero if origin is None else origin.triple("xyz", zero)
    rpy = zero if origin is None else origin.triple("rpy", zero)
    for solid in geometry.children:
        if solid.tag == "box":
            x, y, z = (max(abs(length) / 2, 1e-4) for length in solid.triple("size", zero))
            return Shape("box", (x, y, z), xyz, rpy)
        if solid.tag == "sphere":
            return Shape("sphere", (max(solid.number("radius"), 1e-4),), xyz, rpy)
        if solid.tag in ("cylinder", "capsule"):
            size = (max(solid.number("radius"), 1e-4), max(solid.number("length") / 2, 1e-4))
            return Shape("cylinder" if solid.tag == "cylinder" else "capsule", size, xyz, rpy)
    return None


def _joint(each: UrdfJoint, tree: Tree, links: Iterable[Link]) -> tuple[Joint, bool]:
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
    weight = _weight(each, tree, links)
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
        servo=derived_servo(torque, velocity),
    )
    return joint, assumed


def _weight(each: UrdfJoint, tree: Tree, links: Iterable[Link]) -> float:
    """Return the most that the weight behind a joint can ask of it: stretched, axis level.

    In [N m], for a joint that slides in [N].
    """
    by_name = {link.name: link for link in links}
    total = 0.0
    waiting = [(each.child, 0.0)]
    while waiting:
        link, away = waiting.pop()
        body = by_name[link]
        lever = 1.0 if each.type == "prismatic" else away + math.hypot(*body.centre_of_mass)
        total += body.mass * _GRAVITY * lever
        waiting += [(one.child, away + math.hypot(*one.xyz)) for one in tree.below(link)]
    return total


def _with_grippers(
    gripping: Iterable[GripperParts],
    joints: Mapping[str, Joint],
    links: Iterable[Link],
    tree: Tree,
) -> tuple[tuple[Gripper, ...], dict[str, Joint], tuple[Link, ...]]:
    found, by_name = [], dict(joints)
    by_link = {link.name: link for link in links}
    for parts in gripping:
        gripper, fingers = built_gripper(parts, by_name, tree)
        found.append(gripper)
        by_name.update(fingers)
        for pad in gripper.pads:
            by_link[pad] = padded(by_link[pad])
    return tuple(found), by_name, tuple(by_link.values())


def _initial(
    states: Mapping[str, Mapping[str, Mapping[str, float]]], joints: Mapping[str, Joint]
) -> dict[str, float]:
    """Return where the run begins: at rest as the SRDF names it, else at zero."""
    initial = {name: min(max(0.0, j.lower), j.upper) for name, j in joints.items()}
    for group in sorted(states, key=lambda name: (sum(map(len, states[name].values())), name)):
        for name in _RESTS:
            if name in states[group]:
                initial.update(states[group][name])
                break
    return initial


# Names under which an SRDF tells where the arm rests.
_RESTS = ("home", "Home", "rest", "ready", "resting", "sleep", "stow", "tuck", "up")
