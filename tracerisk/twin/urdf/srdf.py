"""Read an SRDF: the groups, named states and end effectors that MoveIt knows a robot by.

Other files of its package stand beside it.
"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from dataclasses import dataclass

from tracerisk.errors import RobotError
from tracerisk.twin.urdf.xml_reader import XmlElement, read_xml


@dataclass(frozen=True, slots=True)
class SrdfGroup:
    """A planning group as it is written: its parts, to be resolved with the robot's tree."""

    name: str
    """The name of the group."""
    joints: tuple[str, ...]
    """The joints that it lists."""
    links: tuple[str, ...]
    """The links whose joints belong to it."""
    chains: tuple[tuple[str, str], ...]
    """Base and tip link of each chain."""
    subgroups: tuple[str, ...]
    """The groups that it includes."""


@dataclass(frozen=True, slots=True)
class EndEffector:
    """An end effector."""

    name: str
    """The name of the end effector."""
    group: str
    """The group of its fingers."""
    parent_link: str
    """The link that it is mounted on; empty where the file names none."""


@dataclass(frozen=True, slots=True)
class Srdf:
    """What an SRDF contains."""

    name: str
    """The name of the robot; empty where the file gives none."""
    file: str
    """The path of the SRDF, for messages."""
    groups: tuple[SrdfGroup, ...]
    """The planning groups, in the order of the file."""
    states: Mapping[str, Mapping[str, Mapping[str, float]]]
    """The joint positions [rad or m] of each named state, by group and state."""
    end_effectors: tuple[EndEffector, ...]
    """The end effectors, in the order of the file."""
    disabled_collisions: frozenset[tuple[str, str]]
    """Pairs of links that may touch, each pair sorted."""
    passive_joints: frozenset[str]
    """The joints without a motor of their own."""

    @property
    def words(self) -> frozenset[str]:
        """The names by which a controller may speak of this robot."""
        names = {group.name for group in self.groups}
        for group in self.groups:
            names.update(group.joints, *group.chains)
        for states in self.states.values():
            names.update(*(values for values in states.values()))
        return frozenset(names)


def read_srdf(text: str | bytes, file: str) -> Srdf:
    """Return what an SRDF says.

    Raises RobotError with file and line when it is no SRDF.
    """
    root = read_xml(text, file)
    if root.tag != "robot":
        root.fail("is not the element <robot> of an SRDF")
    groups = {group.name: group for group in map(_group, root.all("group"))}
    states: dict[str, dict[str, dict[str, float]]] = {}
    for entry in root.all("group_state"):
        values = states.setdefault(entry.string("group"), {})
        values[entry.string("name")] = _state(entry)
    pairs = (
        sorted((entry.string("link1"), entry.string("link2")))
        for entry in root.all("disable_collisions")
    )
    return Srdf(
        name=root.attributes.get("name", ""),
        file=file,
        groups=tuple(groups.values()),
        states=states,
        end_effectors=tuple(
            EndEffector(
                entry.string("name"), entry.string("group"), entry.attributes.get("parent_link", "")
            )
            for entry in root.all("end_effector")
        ),
        disabled_collisions=frozenset((one, other) for one, other in pairs),
        passive_joints=frozenset(entry.string("name") for entry in root.all("passive_joint")),
    )


def _group(entry: XmlElement) -> SrdfGroup:
    return SrdfGroup(
        name=entry.string("name"),
        joints=tuple(xml_element.string("name") for xml_element in entry.all("joint")),
        links=tuple(xml_element.string("name") for xml_element in entry.all("link")),
        chains=tuple(
            (xml_element.string("base_link"), xml_element.string("tip_link"))
            for xml_element in entry.all("chain")
        ),
        subgroups=tuple(xml_element.string("name") for xml_element in entry.all("group")),
    )


def _state(entry: XmlElement) -> dict[str, float]:
    values: dict[str, float] = {}
    for joint in entry.all("joint"):
        # Joints of several degrees of freedom have several numbers here; the twin has none.
        with contextlib.suppress(RobotError):
            values[joint.string("name")] = joint.number("value")
    return values
