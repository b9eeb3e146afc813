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
    joints: tuple[str, ...]
    links: tuple[str, ...]
    chains: tuple[tuple[str, str], ...]
    subgroups: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class EndEffector:
    """An end effector: the group of its fingers, and the link that it is mounted on."""

    name: str
    group: str
    parent_link: str


@dataclass(frozen=True, slots=True)
class Srdf:
    """What an SRDF says; `states` are group, state, joint, position [rad or m]."""

    name: str
    file: str
    groups: tuple[SrdfGroup, ...]
    states: Mapping[str, Mapping[str, Mapping[str, float]]]
    end_effectors: tuple[EndEffector, ...]
    disabled_collisions: frozenset[tuple[str, str]]
    passive_joints: frozenset[str]

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
        joints=tuple(each.string("name") for each in entry.all("joint")),
        links=tuple(each.string("name") for each in entry.all("link")),
        chains=tuple(
            (each.string("base_link"), each.string("tip_link")) for each in entry.all("chain")
        ),
        subgroups=tuple(each.string("name") for each in entry.all("group")),
    )


def _state(entry: XmlElement) -> dict[str, float]:
    values: dict[str, float] = {}
    for joint in entry.all("joint"):
        # Joints of several degrees of freedom have several numbers here; the twin has none.
        with contextlib.suppress(RobotError):
            values[joint.string("name")] = joint.number("value")
    return values
