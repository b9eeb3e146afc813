"""The tree of links and joints in a URDF, before anything is said about motors."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal, get_args

from tracerisk.errors import Location, RobotError, one_of
from tracerisk.twin.robots.robot import WORLD, WORLD_LINK, Robot
from tracerisk.twin.urdf.xml_reader import XmlElement

MovingType = Literal["revolute", "continuous", "prismatic"]
_MOVING: dict[str, MovingType] = {kind: kind for kind in get_args(MovingType)}
_TYPES = (*_MOVING, "fixed", "floating", "planar")
_MOST_LINKS = 500
_ROLLS = re.compile(r"wheel|caster|castor|roller|track|steer", re.IGNORECASE)


class NoWholeRobotError(RobotError):
    """The file holds a part of a robot, or a thing that does not move."""


@dataclass(frozen=True, slots=True)
class UrdfJoint:
    """A joint as a URDF gives it; a figure that is missing is 0."""

    name: str
    """The name of the joint."""
    type: MovingType
    """The kind of motion; `revolute` also for a joint that never moves."""
    moves: bool
    """Whether the joint moves in the twin."""
    parent: str
    """The name of the parent link."""
    child: str
    """The name of the child link."""
    xyz: tuple[float, float, float]
    """The place of the child's frame in the parent's [m]."""
    rpy: tuple[float, float, float]
    """Roll, pitch and yaw of the child's frame in the parent's [rad]."""
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    """The axis of rotation or sliding, in the child's frame."""
    lower: float = 0.0
    """The least position [rad or m]."""
    upper: float = 0.0
    """The greatest position [rad or m]."""
    velocity: float = 0.0
    """The velocity limit [rad/s or m/s]."""
    effort: float = 0.0
    """The effort limit [N m or N]."""
    mimic: tuple[str, float, float] | None = None
    """The joint that it follows, with factor and offset [rad or m]; `None` for none."""


@dataclass(frozen=True, slots=True)
class Tree:
    """The links and joints of a robot."""

    root: str
    """The name of the root link."""
    joints: tuple[UrdfJoint, ...]
    """The joints from the root outwards, depth first."""

    @property
    def moving(self) -> tuple[UrdfJoint, ...]:
        """The joints that move."""
        return tuple(joint for joint in self.joints if joint.moves)

    def place_of(self, link: str) -> str | None:
        """Return what a link of the file is called here; `None` for one that is left out."""
        if link != WORLD:
            return link
        return self.root if self.root == WORLD_LINK else None

    def below(self, link: str) -> Iterator[UrdfJoint]:
        """Yield the joints that hang on a link."""
        return (joint for joint in self.joints if joint.parent == link)

    def joint_to(self, link: str) -> UrdfJoint | None:
        """Return the joint on which a link hangs, `None` for the root."""
        return next((joint for joint in self.joints if joint.child == link), None)

    def joint(self, name: str) -> UrdfJoint | None:
        """Return the joint of a name."""
        return next((joint for joint in self.joints if joint.name == name), None)

    def parent_link(self, joint: str) -> str | None:
        """Return the link on which a joint sits."""
        urdf_joint = self.joint(joint)
        return None if urdf_joint is None else urdf_joint.parent

    def way(self, tip: str, base: str | None = None) -> tuple[UrdfJoint, ...]:
        """Return the joints from `base` (the root by default) to a link, in this order.

        Empty where `base` is not on the way.
        """
        urdf_joints: list[UrdfJoint] = []
        at = tip
        while at != base:
            joint = self.joint_to(at)
            if joint is None:
                return tuple(reversed(urdf_joints)) if base in (None, at) else ()
            urdf_joints.append(joint)
            at = joint.parent
        return tuple(reversed(urdf_joints))

    def names_as_in_moveit(self) -> tuple[str, ...]:
        """Return the joints in the order that MoveIt's groups have: depth first, then by name.

        It is the order of `child_links` in ros/urdfdom urdf_parser/include/urdf_model/model.h.
        """
        by_name = sorted(self.joints, key=lambda joint: joint.name)
        return tuple(joint.name for joint in _ordered(self.root, by_name))

    def movers_below(self, link: str) -> Iterator[UrdfJoint]:
        """Yield every joint that moves behind a link."""
        for joint in self.below(link):
            if joint.moves:
                yield joint
            yield from self.movers_below(joint.child)


def read_tree(root: XmlElement, file: str) -> Tree:
    """Return the tree of a URDF.

    Raises RobotError with file and line for what is not a URDF, or no tree.
    """
    if root.tag != "robot":
        root.fail("is not the element <robot> of a URDF")
    links = {}
    for entry in root.all("link"):
        name = entry.string("name")
        if name in links:
            entry.fail(f"link '{name}' is defined twice")
        links[name] = entry
        if len(links) > _MOST_LINKS:
            entry.fail(f"is one too many: at most {_MOST_LINKS} links are simulated")
    if not links:
        raise NoWholeRobotError(
            "<robot>: has no link; name the file of the whole robot", root.location
        )
    joints = {}
    hangs: dict[str, str] = {}
    for entry in root.all("joint"):
        joint = _joint(entry, links)
        if joint.name in joints:
            entry.fail(f"joint '{joint.name}' is defined twice")
        if joint.child in hangs:
            entry.fail(
                f"link '{joint.child}' hangs on '{hangs[joint.child]}' and on '{joint.name}'"
            )
        joints[joint.name] = joint
        hangs[joint.child] = joint.name
    tops = [name for name in links if name not in hangs]
    if len(tops) != 1:
        raise RobotError(
            f"is not a tree: {len(tops)} links have no parent ({', '.join(tops[:6]) or 'none'}); "
            "one must be the root",
            Location(file),
        )
    ordered = _ordered(tops[0], list(joints.values()))
    if len(ordered) != len(joints):
        lost = sorted(joints.keys() - {joint.name for joint in ordered})
        raise RobotError(f"is not a tree: joint '{lost[0]}' is its own ancestor", Location(file))
    return _without_world(Tree(tops[0], tuple(on_a_moving_base(joint) for joint in ordered)))


def _without_world(tree: Tree) -> Tree:
    """Return the tree without a link `world` whose frame is that of the base.

    Where the base has a place of its own in the world, the root is a link `world_link`: poses
    that a controller names in the frame `world` count from there.
    """
    if tree.root != WORLD:
        return tree
    below = list(tree.below(WORLD))
    if len(below) == 1 and not below[0].moves and not any((*below[0].xyz, *below[0].rpy)):
        return Tree(below[0].child, tuple(joint for joint in tree.joints if joint != below[0]))
    return Tree(
        WORLD_LINK,
        tuple(
            replace(joint, parent=WORLD_LINK) if joint.parent == WORLD else joint
            for joint in tree.joints
        ),
    )


def _ordered(root: str, joints: list[UrdfJoint]) -> list[UrdfJoint]:
    below: dict[str, list[UrdfJoint]] = {}
    for joint in joints:
        below.setdefault(joint.parent, []).append(joint)
    urdf_joints, waiting = [], list(reversed(below.get(root, [])))
    while waiting:
        joint = waiting.pop()
        urdf_joints.append(joint)
        waiting += reversed(below.get(joint.child, []))
    return urdf_joints


def on_a_moving_base(joint: UrdfJoint) -> UrdfJoint:
    """Wheels stand still, steered ones too: the twin has no floor to roll on."""
    if joint.moves and (_ROLLS.search(joint.name) or _ROLLS.search(joint.child)):
        return replace(joint, moves=False)
    return joint


def _joint(entry: XmlElement, links: dict[str, XmlElement]) -> UrdfJoint:
    kind = entry.string("type")
    if kind not in _TYPES:
        entry.fail(f"unknown joint type '{kind}'; {one_of(_TYPES, kind)}")
    (xyz, rpy), axis, limit = entry.placing(), entry.first("axis"), entry.first("limit")
    along = (1.0, 0.0, 0.0) if axis is None else axis.triple("xyz", (1.0, 0.0, 0.0))
    moves = kind in _MOVING and any(along)
    mimic = entry.first("mimic")
    figures = {
        key: 0.0 if limit is None else limit.number(key, 0.0)
        for key in ("lower", "upper", "velocity", "effort")
    }
    return UrdfJoint(
        name=entry.string("name"),
        type=_MOVING.get(kind, "revolute"),
        moves=moves,
        parent=_link(entry, "parent", links),
        child=_link(entry, "child", links),
        xyz=xyz,
        rpy=rpy,
        axis=along if any(along) else (0.0, 0.0, 1.0),
        lower=figures["lower"],
        upper=figures["upper"],
        velocity=abs(figures["velocity"]),
        effort=abs(figures["effort"]),
        mimic=None
        if mimic is None
        else (mimic.string("joint"), mimic.number("multiplier", 1.0), mimic.number("offset", 0.0)),
    )


def _link(entry: XmlElement, tag: str, links: dict[str, XmlElement]) -> str:
    child = entry.first(tag)
    if child is None:
        entry.fail(f"has no <{tag} link=.../>")
    name = child.string("link")
    if name not in links:
        child.fail(f"there is no link '{name}'; {one_of(links, name)}")
    return name


def tree_of(robot: Robot) -> Tree:
    """Return the tree of a robot that is known already."""
    joints = {joint.name: joint for joint in robot.joints}
    urdf_joints = []
    for attachment in robot.attachments:
        joint = joints.get(attachment.name)
        figures = (0.0, 0.0, 0.0, 0.0)
        if joint is not None:
            figures = (joint.lower, joint.upper, joint.velocity_limit, joint.torque_limit)
        kind: MovingType = "revolute" if joint is None or joint.type == "fixed" else joint.type
        placing = (
            attachment.parent,
            attachment.child,
            attachment.xyz,
            attachment.rpy,
            attachment.axis,
        )
        urdf_joints.append(UrdfJoint(attachment.name, kind, joint is not None, *placing, *figures))
    return Tree(robot.base_link, tuple(_ordered(robot.base_link, urdf_joints)))
