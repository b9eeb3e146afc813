"""A stand-in for a robot of which a workspace has the SRDF alone: nobody knows its lengths.

It has the joints, links, groups and named states that the SRDF names. Lengths, axes and rated
figures are those of the generic arm, once for each arm. Nothing is known of its shape, so that
it touches nothing but what its fingers close on.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from tracerisk.errors import RobotError
from tracerisk.twin.robots.generic import NAME, TITLE, NamesAsked, axis_figures, is_finger_name
from tracerisk.twin.robots.names_in_source import Spoken
from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.urdf.srdf import Srdf, SrdfGroup, read_srdf
from tracerisk.twin.urdf.urdf import read_urdf
from tracerisk.twin.workspace.description_files import description_files, distance

_FEWEST = 3  # joints of a group that stand for an arm of their own
_APART = (0.0, 0.2, -0.2)  # from its body to the side, of the first and each further arm [m]
_SLIDES = 0.1  # fingers whose states are all smaller slide [m], others turn [rad]
_TURN = 1.2  # of a finger to either side [rad]
_FINGER = (0.03, 0.01)  # from the hand to a finger: onwards, and to its side [m]


def spoken_srdf(roots: Sequence[Path], spoken: Spoken, script: Path) -> tuple[Srdf, Path] | None:
    """Return the SRDF below the roots of whose robot the controller names most, and its file.

    One of which it names nothing is taken only if no other is there. Macros are not expanded.
    """
    files = [
        description_file
        for description_file in description_files(tuple(roots))
        if description_file.is_srdf and not description_file.is_macro
    ]
    read: list[tuple[int, int, str, Srdf, Path]] = []
    for file in files:
        try:
            srdf = read_srdf(file.text, file.shown)
        except RobotError:
            continue
        named = len(spoken.exactly(srdf.words))
        if named or len(files) == 1:
            read.append(
                (-named, distance(script.resolve(), file.path), file.shown, srdf, file.path)
            )
    if not read:
        return None
    best = min(read, key=lambda row: row[:3])
    return best[3], best[4]


def srdf_stand_in(srdf: Srdf, asked: NamesAsked) -> Robot | None:
    """Return the generic robot with the parts that an SRDF names; `None` if it names no joint.

    Joints that are asked for, and that it does not name, are an arm beside. Frames that are asked
    for are at the tip of the first arm. It is marked approximate.
    """
    drawing = _Drawing(srdf)
    if not drawing.joints:
        return None
    drawing.add_asked(asked)
    robot = read_urdf(drawing.urdf(), srdf.file, srdf=srdf)
    return replace(
        robot,
        name=NAME,
        title=TITLE,
        source=f"assumed: no figure is that of a robot; names of {srdf.file}",
        approximate=True,
        assumes_names=True,
    )


@dataclass(frozen=True, slots=True)
class _Drawn:
    """A joint of the stand-in."""

    parent: str
    """The name of the parent link."""
    child: str
    """The name of the child link."""
    place: int
    """The index of the joint in its arm, or of the finger in its hand."""
    xyz: tuple[float, float, float]
    """The place of the child's frame in the parent's [m]."""
    slides: bool = False
    """Whether a finger slides rather than turns."""
    is_finger: bool = False
    """Whether the joint moves a finger."""
    follows: str = ""
    """The finger joint that it follows; empty for none."""


class _Drawing:
    def __init__(self, srdf: Srdf) -> None:
        self._srdf = srdf
        self.joints: dict[str, _Drawn] = {}
        self._frames: dict[str, str] = {}
        """What hangs rigidly on a link."""
        hands = {end_effector.group for end_effector in srdf.end_effectors}
        # Some authors declare the arm itself as an end effector.
        if all(group.name in hands for group in srdf.groups if self._named(group)):
            hands = set()
        self._hands = [srdf_group for srdf_group in srdf.groups if self._is_hand(srdf_group, hands)]
        arms = [srdf_group for srdf_group in srdf.groups if srdf_group not in self._hands]
        members = {arm.name: self._members(arm) for arm in arms}
        self._starts = {names[0] for names in members.values() if len(names) >= _FEWEST}
        self._tips = self._child_names(arms, members)
        self._base = self._base_of(arms, members)
        for group in sorted(arms, key=lambda arm: -len(members[arm.name])):
            if members[group.name] and not _is_union(group.name, members):
                self._add_chain(members[group.name])
        for group in arms:
            self._add_links(group, members[group.name])
        for group in self._hands:
            self._add_hand(group)

    def _is_hand(self, group: SrdfGroup, hands: set[str]) -> bool:
        names = self._named(group)
        return group.name in hands or (bool(names) and all(map(is_finger_name, names)))

    def _named(self, group: SrdfGroup) -> tuple[str, ...]:
        """Return a group's joints: those that are listed, else those of its states."""
        states = self._srdf.states.get(group.name, {}).values()
        return group.joints or tuple(dict.fromkeys(name for state in states for name in state))

    def _members(self, group: SrdfGroup) -> tuple[str, ...]:
        held = {name for hand in self._hands for name in self._named(hand)}
        still = held | self._srdf.passive_joints
        return tuple(name for name in self._named(group) if name not in still)

    def _child_names(
        self, arms: Iterable[SrdfGroup], members: Mapping[str, tuple[str, ...]]
    ) -> dict[str, str]:
        """Return what the links behind joints are called, by chains and links of groups."""
        children: dict[str, str] = {}
        for group in arms:
            names = members[group.name]
            if names and group.chains:
                children.setdefault(names[-1], group.chains[-1][1])
            for joint, link in zip(names, group.links, strict=False):
                if len(names) == len(group.links):
                    children.setdefault(joint, link)
            for other in members.values():
                # The link behind the joint before an arm is the one that its chain begins at.
                before = other.index(names[0]) if names and names[0] in other else 0
                if before and group.chains:
                    children.setdefault(other[before - 1], group.chains[0][0])
        taken: set[str] = set()
        kept = {}
        for joint, link in children.items():
            if link not in taken:
                kept[joint] = link
                taken.add(link)
        return kept

    def _base_of(self, arms: Iterable[SrdfGroup], members: Mapping[str, tuple[str, ...]]) -> str:
        chains = [(len(members[arm.name]), arm.chains[0][0]) for arm in arms if arm.chains]
        base = max(chains, key=lambda chain: chain[0])[1] if chains else "base_link"
        return "base_link" if base in self._tips.values() else base

    def _add_chain(self, names: Iterable[str]) -> None:
        parent, place = self._base, 0
        for name in names:
            if name in self.joints:
                parent, place = self.joints[name].child, self.joints[name].place + 1
                continue
            xyz = axis_figures(place).xyz
            if name in self._starts:
                beside = sum(
                    joint.parent == parent and not joint.place for joint in self.joints.values()
                )
                side = _APART[min(beside, 1)] if beside < _FEWEST - 1 else _APART[2] * beside
                place, xyz = 0, (0.0, side, axis_figures(0).xyz[2])
            child = self._tips.get(name, f"{name}_link")
            self.joints[name] = _Drawn(parent, child, place, xyz)
            parent, place = child, place + 1

    def _links(self) -> set[str]:
        drawn = {link for joint in self.joints.values() for link in (joint.parent, joint.child)}
        return {self._base, *drawn, *self._frames}

    def _add_frame(self, name: str, parent: str) -> None:
        if name not in self._links():
            self._frames[name] = parent

    def _add_links(self, group: SrdfGroup, names: Sequence[str]) -> None:
        last = self.joints[names[-1]].child if names else self._base
        first = self.joints[names[0]].parent if names else self._base
        for base, tip in group.chains:
            self._add_frame(base, first)
            self._add_frame(tip, last)
        for link in group.links:
            self._add_frame(link, last)

    def _add_hand(self, group: SrdfGroup) -> None:
        names = [text for text in self._named(group) if text not in self.joints]
        names.sort(key=lambda text: text in self._srdf.passive_joints)
        carriers = [
            end_effector.parent_link
            for end_effector in self._srdf.end_effectors
            if end_effector.group == group.name
        ]
        parent = next(
            (carrier for carrier in carriers if carrier in self._links()), self._first_tip()
        )
        states = [state for fields in self._srdf.states.values() for state in fields.values()]
        values = [abs(state[name]) for state in states for name in names if name in state]
        slides = bool(values) and max(values) <= _SLIDES
        links = [text for text in group.links if text not in self._links()]
        for index, name in enumerate(names[:2]):
            child = links[index] if len(links) == len(names) else f"{name}_link"
            onwards, side = _FINGER
            xyz = (onwards, side * (1 - 2 * index), 0.0)
            follows = names[0] if name in self._srdf.passive_joints and index else ""
            self.joints[name] = _Drawn(parent, child, index, xyz, slides, True, follows)
        for link in links:
            self._add_frame(link, parent)

    def _first_tip(self) -> str:
        arms = [joint for joint in self.joints.values() if not joint.is_finger]
        parents = {arm.parent for arm in arms}
        return next((arm.child for arm in arms if arm.child not in parents), self._base)

    def add_asked(self, asked: NamesAsked) -> None:
        """Add what the controller names and the SRDF does not."""
        known = {*self.joints, *self._srdf.passive_joints}
        tip = self._first_tip()
        self._add_chain(
            name for name in asked.joints if name not in known and not is_finger_name(name)
        )
        for name in asked.frames:
            self._add_frame(name, tip)

    def urdf(self) -> bytes:
        """Return the description of what is drawn."""
        lines = [f'<robot name="{NAME}">', f'<link name="{self._base}"/>']
        for name, joint in self.joints.items():
            lines += _joint_lines(name, joint)
        for name, parent in self._frames.items():
            lines += [
                f'<link name="{name}"/>',
                f'<joint name="{name}_fixed" type="fixed">',
                f'<parent link="{parent}"/><child link="{name}"/></joint>',
            ]
        return "\n".join([*lines, "</robot>"]).encode()


def _joint_lines(name: str, each: _Drawn) -> Iterator[str]:
    figures = axis_figures(each.place)
    lower, upper, axis = -figures.range_rad, figures.range_rad, figures.axis
    mass, torque, speed = figures.mass_kg, figures.torque_nm, figures.speed
    kind = "revolute"
    if each.is_finger:
        side = 1.0 - 2.0 * each.place
        mass, torque, speed = 0.05, 10.0, 1.0
        lower, upper, axis = -_TURN, _TURN, (0.0, 0.0, side)
        if each.slides:
            kind, torque, speed = "prismatic", 20.0, 0.2
            lower, upper, axis = 0.0, 0.04, (0.0, side, 0.0)
    yield f'<link name="{each.child}"><inertial><mass value="{mass}"/></inertial></link>'
    yield f'<joint name="{name}" type="{kind}">'
    yield f'<parent link="{each.parent}"/><child link="{each.child}"/>'
    yield f'<origin xyz="{_numbers(each.xyz)}"/><axis xyz="{_numbers(axis)}"/>'
    yield f'<limit lower="{lower}" upper="{upper}" velocity="{speed}" effort="{torque}"/>'
    yield f'<mimic joint="{each.follows}"/></joint>' if each.follows else "</joint>"


def _numbers(values: Iterable[float]) -> str:
    return " ".join(map(str, values))


def _is_union(name: str, members: Mapping[str, tuple[str, ...]]) -> bool:
    """Return whether a group is others together that share no joint: no chain of its own."""
    whole = set(members[name])
    parts = [set(member) for member in members.values() if member and set(member) < whole]
    return any(
        not one & other and one | other == whole
        for index, one in enumerate(parts)
        for other in parts[index + 1 :]
        if len(one) >= _FEWEST and len(other) >= _FEWEST
    )
