"""Which ROS a controller is written for, by what its own sources import."""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Literal

from tracerisk.common.text.bounded import file_bytes, file_text
from tracerisk.config import PACKAGE_FILE
from tracerisk.instrument.source.c_tokens import names_included
from tracerisk.instrument.source.dotted_names import imports_in
from tracerisk.instrument.source.language import is_c
from tracerisk.instrument.source.python_source import parsed

RosVersion = Literal[1, 2]

_ROS2 = re.compile(
    r"(rclpy|rclcpp|rcl_interfaces|builtin_interfaces|action_msgs|unique_identifier_msgs"
    r"|lifecycle_msgs|ament_index_python|launch|launch_ros|rosidl_runtime_py|rosbag2_py|moveit|pymoveit2"
    r"|moveit_configs_utils|tf_transformations|composition_interfaces|ros2cli|ros2_numpy"
    r"|interbotix_xs_modules\.xs_robot|interbotix_common_modules\.common_robot)(\..*)?"
)
_ROS1 = re.compile(
    r"(rospy|roslib|rospkg|roscpp|actionlib|actionlib_msgs|moveit_commander|tf|tf_conversions"
    r"|dynamic_reconfigure|genpy|rosbag|roslaunch|smach|smach_ros|ros_numpy"
    r"|baxter_interface|baxter_dataflow|intera_interface"
    r"|interbotix_xs_modules\.(arm|core|gripper|turret|mr_descriptions|locobot))(\..*)?"
)
# `from control_msgs.action import ...`: ROS 1 has actions in `msg`. A folder of a ROS 1 program
# may have that name too, so that it decides only where nothing else does.
_ACTIONS = re.compile(r"\w+\.action(\..*)?")
_ROS2_HEADER = re.compile(rb"rclc(?:pp)?(?:_\w+)?/|\w+/(?:msg|srv|action)/")
_BUILT_BY = re.compile(r"<(?:build_type|buildtool_depend)\b[^>]*>\s*(ament|catkin)\w*\s*<")
_IMPORT = re.compile(r"\s*(?:from\s+([\w.]+)\s+import|import\s+([\w., ]+))")


def ros_version(script: Path, root: Path) -> RosVersion:
    """Return the ROS of a script: that of the first module which imports what only one of them has.

    The script comes first, then the modules below `root` that it imports, the nearest first.
    If it imports neither, the build tool of its package decides; without one it is of ROS 1, whose
    message packages take more forms of call. A source in C or C++ says it by its headers.
    """
    if is_c(script.name):
        return _version_of_headers(names_included(file_bytes(script)), root)
    waiting, seen = deque([script]), {script}
    while waiting:
        path = waiting.popleft()
        names = list(_imported(path))
        for name in names:
            if _ROS2.fullmatch(name):
                return 2
            if _ROS1.fullmatch(name):
                return 1
        if any(_ACTIONS.fullmatch(name) for name in names):
            return 2
        for name in names:
            for result in _own(name, path.parent, root):
                if result not in seen:
                    seen.add(result)
                    waiting.append(result)
    return 2 if _is_built_by_ament(root) else 1


def _version_of_headers(names: Sequence[bytes], root: Path) -> RosVersion:
    if any(_ROS2_HEADER.match(name) for name in names):
        return 2
    is_ros1 = any(name.startswith(b"ros/") for name in names)
    return 2 if not is_ros1 and _is_built_by_ament(root) else 1


def _is_built_by_ament(root: Path) -> bool:
    try:
        manifest = file_text(root / PACKAGE_FILE, errors="replace")
    except OSError:
        return False
    return "ament" in build_tools(manifest)


def build_tools(manifest: str) -> frozenset[str]:
    """Return the build tools that a `package.xml` asks for: `ament` (ROS 2), `catkin` (ROS 1)."""
    return frozenset(_BUILT_BY.findall(manifest))


def _imported(path: Path) -> Iterator[str]:
    try:
        text = file_bytes(path)
    except OSError:
        return
    tree = parsed(text)
    if tree is None:
        yield from _imported_by_lines(text.decode("utf-8", "replace"))
        return
    yield from ("." * level + ".".join(parts) for level, parts in imports_in(tree))


def _imported_by_lines(text: str) -> Iterator[str]:
    # A source that cannot be parsed still says what it imports.
    for line in text.splitlines():
        match = _IMPORT.match(line)
        if match is not None:
            for name in (match[1] or match[2]).split(","):
                yield name.split()[0] if name.split() else ""


def _own(name: str, folder: Path, root: Path) -> Iterator[Path]:
    """Find the file of an imported module beside the importing one, or below the root."""
    dots = len(name) - len(name.lstrip("."))
    parts = [part for part in name.split(".") if part]
    if not parts:
        return
    bases = [folder, root, root / parts[0], root / "src", root / "scripts"]
    if dots:
        bases = [folder.joinpath(*[".."] * (dots - 1)).resolve()]
    for base in bases:
        target = base.joinpath(*parts)
        for file in (target.with_suffix(".py"), target / "__init__.py"):
            if file.is_file():
                yield file
                return
