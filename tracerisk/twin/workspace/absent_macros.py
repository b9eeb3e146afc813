"""Put shipped robots where a description calls macros of a package that is not there.

Most workspaces of a maker's arm include its description package, which is installed on the robot's
computer and is no part of the repository. Which arm is meant is in the arguments of the call, else
in the name of the macro or of the package.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from tracerisk.twin.robots.index import shipped_names
from tracerisk.twin.robots.robot import Robot, load_robot
from tracerisk.twin.robots.robot_names import mentioned
from tracerisk.twin.urdf.text import urdf_text
from tracerisk.twin.urdf.xacro_child import ABSENT_MACRO, MACRO_NAME

ARMS: Mapping[str, tuple[str, ...]] = {
    "franka_description": ("panda", "fr3"),
    "iiwa_description": ("iiwa7_stack", "iiwa14_stack"),
    "interbotix_xsarm_descriptions": ("wx250s", "vx300s", "wx200", "rx200", "px100"),
    "kinova_description": ("j2n6s300", "j2s7s300", "j2s6s300"),
    "kortex_description": ("gen3", "gen3_lite", "gen3_6dof"),
    "lbr_description": ("iiwa7", "iiwa14"),
    "moveit_resources_panda_description": ("panda",),
    "dsr_description2": ("m1013", "m0609", "a0509"),
    "ur_description": (
        "ur5e", "ur5", "ur10e", "ur10", "ur3e", "ur3", "ur16e", "ur20", "ur30",
    ),
    "tm_description": ("tm5_900", "tm5_700", "tm12"),
    "widowx_arm_description": ("widowx",),
    "xarm_description": ("xarm7", "xarm6", "lite6"),
}  # fmt: skip
"""The arms of a maker's description package, the most usual one first."""
# Parameters of the macros: UniversalRobots/Universal_Robots_ROS2_Description urdf/ur_macro.xacro,
# xArm-Developer/xarm_ros2 xarm_description/urdf/xarm_device_macro.xacro, frankaemika/franka_ros
# franka_description/robots/common/franka_arm.xacro, Kinovarobotics/ros2_kortex
# kortex_description/robots/kortex_robot.xacro, IFL-CAMP/iiwa_stack
# iiwa_description/urdf/iiwa7.xacro.
_TOOL = re.compile(r"gripper|hand|finger|camera|sensor|tool|mount|table|stand", re.IGNORECASE)
_MOVING = ("revolute", "continuous", "prismatic")
_PREFIXES = ("tf_prefix", "prefix", "arm_prefix", "robot_prefix")
_IDS = ("arm_id", "robot_name")  # what stands in the place of an arm's own name
_PARENTS = ("parent", "parent_link", "connected_to", "attach_to", "base")
_TELLING = ("ur_type", "robot_type", "model", "type", "arm", "name", "arm_id", "robot_name")
_COUNTS = ("dof", "arm_dof", "robot_dof")
"""The arguments that are the number of an arm's joints; other numbers are gains and rates."""


@dataclass(frozen=True, slots=True)
class Completed:
    """A description without calls of absent macros."""

    text: bytes
    """The URDF."""
    notes: tuple[str, ...]
    """What was put in, and what was left out, as sentences."""
    doubts: tuple[str, ...]
    """Why what was put in may be another arm."""


def with_shipped_robots(
    text: bytes, packages: Sequence[str], includes: Sequence[str] = ()
) -> Completed:
    """Return a description with shipped robots in place of the macros of absent `packages`.

    A macro that is no shipped robot's is left out: what it would describe is no part of the arm.
    Where nothing moves then, `includes`, the files of these packages, name the robot: a MoveIt
    configuration includes the whole robot by its file.
    """
    root = ET.fromstring(text)
    drawing = _Drawing(root, packages)
    drawing.replace_calls()
    if not any(element.get("type") in _MOVING for element in root.iter("joint")):
        drawing.replace_includes(includes)
    drawing.hang_loose_links()
    return Completed(ET.tostring(root), tuple(drawing.notes), tuple(drawing.doubts))


class _Drawing:
    def __init__(self, root: ET.Element, packages: Sequence[str]) -> None:
        self._root = root
        self._packages = packages
        self._robots = {shipped_name.name: shipped_name for shipped_name in shipped_names()}
        self._called = {
            word
            for shipped_name in shipped_names()
            for word in (shipped_name.name, *shipped_name.aliases)
        }
        self._anchor = ""
        """The link on which what is loose hangs: the last tip or parent."""
        self.notes: list[str] = []
        self.doubts: list[str] = []

    def _links(self) -> set[str]:
        return {element.get("name", "") for element in self._root.iter("link")}

    def replace_calls(self) -> None:
        for above in list(self._root.iter()):
            for call in [element for element in above if element.tag == ABSENT_MACRO]:
                above.remove(call)
                macro = call.get(MACRO_NAME, "")
                arms = self._arms_of(call, macro)
                if not arms or not self._put(call, macro, arms):
                    self._anchor = self._parent(call) or self._anchor
                    self.notes.append(
                        f"macro '{macro}' of {self._shown()} is left out: the package is absent"
                    )

    def replace_includes(self, files: Sequence[str]) -> None:
        """Put the robot that the first of some files of absent packages names."""
        for file in files:
            package, _, name = file.partition("/")
            stem = name.rpartition("/")[2].partition(".")[0]
            family = ARMS.get(package, ())
            named = mentioned(stem, self._robots) or mentioned(package, self._robots)
            alike = [text for text in family if text in named] or sorted(named) or list(family)
            if not alike:
                continue
            robot = load_robot(alike[0])
            links = self._links()
            base = robot.base_link
            if (links - {base}) & set(robot.link_names):
                continue
            hung = {element.get("link", "") for element in self._root.iter("child")}
            parent = next((link for link in sorted(links) if link not in hung), "")
            own = [text for text in self._root.findall("link") if text.get("name") == base]
            for element in own:
                self._root.remove(element)
            self._root.extend(ET.fromstring(urdf_text(robot, with_shapes=True)))
            if parent and parent != base and base not in hung:
                self._root.append(_fixed(parent, base, None))
            self._anchor = base
            self.notes.append(
                f"'{name}' of '{package}', which is absent, is the shipped robot '{alike[0]}'"
            )
            if len(alike) > 1:
                others = ", ".join(alike[1:])
                self.doubts.append(
                    f"the absent file '{name}' may be {others} as well as {alike[0]}"
                )
            return

    def _shown(self) -> str:
        return ", ".join(f"'{name}'" for name in self._packages)

    def _arms_of(self, call: ET.Element, macro: str) -> tuple[str, ...]:
        """Return the shipped robots that a call may mean, the most usual first."""
        family = tuple(name for package in self._packages for name in ARMS.get(package, ()))
        for text in self._texts(call, macro):
            named = mentioned(text, self._robots)
            narrowed = [name for name in family if name in named] or sorted(named)
            if narrowed:
                return tuple(narrowed)
        # A gripper or a camera of an absent package is no arm.
        is_arm = any(word in macro for word in ("robot", "arm", "device"))
        return family if is_arm and not self._is_placed(family) else ()

    def _is_placed(self, names: Iterable[str]) -> bool:
        return any(f"'{name}'" in note for name in names for note in self.notes)

    def _texts(self, call: ET.Element, macro: str) -> Iterator[str]:
        """Yield what may name the robot, the most telling first."""
        given = {name: value for name, value in call.attrib.items() if name != MACRO_NAME}
        digits = [given[name] for name in _COUNTS if given.get(name, "").isdigit()]
        for name in _TELLING:
            if name in given:
                # With the number of its joints first: `gen3` of 6 is no `gen3` of 7.
                numbered = {f"{given[name]}{digit}" for digit in digits}
                yield "\n".join(sorted(numbered & self._called))
                yield given[name]
                yield "\n".join(sorted(numbered))
        yield macro
        yield "\n".join(given.values())
        # A maker's package has grippers and cameras as well.
        if not _TOOL.search(macro):
            yield "\n".join(self._packages)

    def _put(self, call: ET.Element, macro: str, names: Sequence[str]) -> bool:
        """Put the first of some robots in the place of a call; not if its links are there."""
        name = names[0]
        robot = load_robot(name)
        rename = _renaming(robot, call.attrib)
        drawn = ET.fromstring(urdf_text(robot, with_shapes=True))
        for node in drawn.iter():
            for key in ("name", "link"):
                if key in node.attrib and node is not drawn:
                    node.set(key, rename(node.attrib[key]))
        links = {element.get("name", "") for element in drawn.iter("link")}
        if links & self._links():
            return False
        parent = self._parent(call)
        self._root.extend(drawn)
        if parent:
            self._root.append(_fixed(parent, rename(robot.base_link), _origin(call)))
        tips = [group.tip_link for group in robot.groups.values() if group.tip_link]
        self._anchor = rename(tips[0]) if tips else rename(robot.base_link)
        note = f"macro '{macro}' of {self._shown()}, which is absent, is the shipped robot '{name}'"
        self.notes.append(note)
        if len(names) > 1:
            self.doubts.append(
                f"the absent macro '{macro}' may be {', '.join(names[1:])} as well as {name}"
            )
        return True

    def _parent(self, call: ET.Element) -> str:
        """Return the link that a call hangs its parts on, the first one where it names none."""
        links = self._links()
        named = next((call.attrib[key] for key in _PARENTS if call.attrib.get(key) in links), "")
        if named or not links:
            return named
        hanging = {element.get("link", "") for element in self._root.iter("child")}
        return next((link for link in sorted(links) if link not in hanging), "")

    def hang_loose_links(self) -> None:
        """Add the links that joints name and that were left out."""
        links = self._links()
        for joint in list(self._root.findall("joint")):
            for end in ("parent", "child"):
                node = joint.find(end)
                name = "" if node is None else node.get("link", "")
                if not name or name in links:
                    continue
                links.add(name)
                ET.SubElement(self._root, "link", name=name)
                if end == "parent" and self._anchor in links - {name}:
                    self._root.append(_fixed(self._anchor, name, None))


def _renaming(robot: Robot, given: Mapping[str, str]) -> _Renaming:
    prefix = next((given[name] for name in _PREFIXES if given.get(name)), "")
    own = _own_prefix(robot)
    identity = next((given[name] for name in _IDS if given.get(name)), "")
    return _Renaming(own, f"{identity}_" if own and identity else own, prefix)


@dataclass(frozen=True, slots=True)
class _Renaming:
    own: str
    """The prefix of the shipped robot's own names; empty for none."""
    instead: str
    """What replaces `own`, from the arm's identity in the call."""
    prefix: str
    """What the call puts before every name; empty for none."""

    def __call__(self, name: str) -> str:
        if self.own and name.startswith(self.own):
            name = f"{self.instead}{name.removeprefix(self.own)}"
        return f"{self.prefix}{name}"


def _own_prefix(robot: Robot) -> str:
    """Return the arm's own name where it is before all of its joints: `panda_`."""
    first, *others = [joint.name for joint in robot.arm_joints]
    prefix = f"{first.partition('_')[0]}_"
    is_own = robot.name.startswith(prefix.rstrip("_")[:3]) and prefix != "joint_"
    return prefix if is_own and all(name.startswith(prefix) for name in others) else ""


def _origin(call: ET.Element) -> dict[str, str] | None:
    """Return where a call puts its parts: its element `<origin>`, or arguments of that kind."""
    node = call.find("origin")
    if node is not None:
        return {key: node.attrib[key] for key in ("xyz", "rpy") if key in node.attrib}
    given = {
        key: call.attrib[name]
        for key in ("xyz", "rpy")
        for name in (key, f"attach_{key}")
        if call.attrib.get(name)
    }
    return given or None


def _fixed(parent: str, child: str, origin: Mapping[str, str] | None) -> ET.Element:
    joint = ET.Element("joint", name=f"{parent}-{child}", type="fixed")
    ET.SubElement(joint, "parent", link=parent)
    ET.SubElement(joint, "child", link=child)
    if origin:
        ET.SubElement(joint, "origin", dict(origin))
    return joint
