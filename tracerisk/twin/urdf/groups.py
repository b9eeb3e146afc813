"""The planning groups, named states and controllers of a robot that comes as URDF and SRDF."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from itertools import takewhile
from types import MappingProxyType

from tracerisk.twin.robots.robot_parts import Controller, Gripper, Group, Joint
from tracerisk.twin.urdf.grippers import is_finger
from tracerisk.twin.urdf.srdf import Srdf, SrdfGroup
from tracerisk.twin.urdf.tree import Tree

# What a tool is mounted on is the tip of an arm, rather than a camera beside it.
_TOOL = re.compile(r"tool|tcp|flange|effector|^ee|_ee|gripper|hand", re.IGNORECASE)


def groups_of(tree: Tree, srdf: Srdf | None) -> dict[str, Group]:
    """Return the groups of the SRDF, resolved on the tree; else one group an arm.

    Parts that the robot lacks are left out, and so are groups in which nothing moves.
    """
    if srdf is None:
        return _plain_groups(tree)
    written = {group.name: group for group in srdf.groups}
    order = {joint.name: index for index, joint in enumerate(tree.joints)}
    in_moveit = tree.names_as_in_moveit()
    passive = srdf.passive_joints | {joint.name for joint in tree.moving if joint.mimic}
    groups = {}
    for name, group in written.items():
        joints = _members(group, written, tree, frozenset())
        moving = {joint.name for joint in tree.moving}
        driven = sorted((joints & moving) - passive, key=lambda key: order[key])
        # Fingers that follow another one are in the group if it is theirs alone.
        names = driven or sorted(joints & moving, key=lambda key: order[key])
        if names:
            members = tuple(joint for joint in in_moveit if joint in joints)
            groups[name] = Group(tuple(names), _tip(group, names, tree), members=members)
    return groups


def _plain_groups(tree: Tree) -> dict[str, Group]:
    """Return each way to a tip as a group, but for what is a finger; the longest is `arm`."""
    ways: list[tuple[str, ...]] = []
    tips: dict[tuple[str, ...], str] = {}
    parents = {joint.parent for joint in tree.joints}
    for joint in tree.joints:
        if joint.child in parents:
            continue
        way = [
            urdf_joint
            for urdf_joint in tree.way(joint.child)
            if urdf_joint.moves and not urdf_joint.mimic
        ]
        arm = [urdf_joint for urdf_joint in way if not is_finger(urdf_joint, tree)]
        names = tuple(urdf_joint.name for urdf_joint in arm)
        if not names:
            continue
        on_the_way = tree.way(joint.child)
        last = max(i for i, urdf_joint in enumerate(on_the_way) if urdf_joint.name == names[-1])
        rigid = takewhile(lambda urdf_joint: not urdf_joint.moves, on_the_way[last + 1 :])
        *_, end = (on_the_way[last].child, *(urdf_joint.child for urdf_joint in rigid))
        ways.append(names)
        if names not in tips or (_TOOL.search(end) and not _TOOL.search(tips[names])):
            tips[names] = end
    kept = sorted(
        {w for w in ways if not any(w != o and w == o[: len(w)] for o in ways)},
        key=lambda names: (-len(names), names),
    )
    return {
        "arm" if index == 0 else f"arm_{index + 1}": Group(names, tips[names])
        for index, names in enumerate(kept)
    }


def _members(
    group: SrdfGroup, groups: Mapping[str, SrdfGroup], tree: Tree, above: frozenset[str]
) -> set[str]:
    members = set(group.joints)
    for link in group.links:
        joint = tree.joint_to(link)
        if joint is not None:
            members.add(joint.name)
    for base, tip in group.chains:
        members.update(joint.name for joint in tree.way(tip, tree.place_of(base)))
    for name in group.subgroups:
        # A group that contains itself is cut, as it would be endless.
        if name in groups and name not in above and name != group.name:
            members |= _members(groups[name], groups, tree, above | {group.name})
    return members


def _tip(group: SrdfGroup, joints: Iterable[str], tree: Tree) -> str | None:
    known = {tree.root, *(joint.child for joint in tree.joints)}
    if group.chains and group.chains[-1][1] in known:
        return group.chains[-1][1]
    names = list(joints)
    if all(is_finger(joint, tree) for joint in tree.joints if joint.name in names):
        return tree.parent_link(names[0])
    last = tree.joint(names[-1])
    assert last is not None
    on_the_way = {joint.name for joint in tree.way(last.child)}
    if not set(names) <= on_the_way:
        return None
    # What is listed behind the last joint and hangs rigidly on it belongs to the group.
    tip = last.child
    listed = {*group.links, *group.joints}
    while True:
        rigid = [
            urdf_joint
            for urdf_joint in tree.below(tip)
            if not urdf_joint.moves and ({urdf_joint.child, urdf_joint.name} & listed)
        ]
        if not rigid:
            return tip
        tip = rigid[0].child


def states_of(
    srdf: Srdf | None, groups: Mapping[str, Group], joints: Mapping[str, Joint]
) -> dict[str, Mapping[str, Mapping[str, float]]]:
    """Return the named states of the groups, within the limits of the joints."""
    s: dict[str, Mapping[str, Mapping[str, float]]] = {}
    for group, states in (srdf.states if srdf is not None else {}).items():
        if group not in groups:
            continue
        members = groups[group].joints
        kept = {}
        for name, values in states.items():
            inside = {
                joint: min(max(value, joints[joint].lower), joints[joint].upper)
                for joint, value in values.items()
                if joint in members
            }
            if inside:
                kept[name] = MappingProxyType(inside)
        s[group] = MappingProxyType(kept)
    return s


def controllers_of(
    groups: Mapping[str, Group], grippers: Iterable[Gripper]
) -> tuple[Controller, ...]:
    """Return one controller a group: of trajectories for arms, of one command for grippers."""
    held = list(grippers)
    fingers = {name for gripper in held for name in gripper.joints}
    controllers = [
        Controller(f"{name}_controller", "follow_joint_trajectory", group.joints)
        for name, group in groups.items()
        if not fingers & set(group.joints)
    ]
    names = {controller.name for controller in controllers}
    controllers += [
        Controller(f"{gripper.name}_controller", "gripper_command", gripper.joints)
        for gripper in held
        if f"{gripper.name}_controller" not in names
    ]
    return tuple(controllers)
