"""Python libraries of robot makers: those with a stand-in, and those that need real hardware.

One rule says whose source of a library runs. ROS itself is always the stand-in, so that a run does
not depend on an installed ROS. A library that is written on ROS is its author's own source, of the
workspace, a prefix or the environment. Where none has it, the package index's release runs if
tracerisk requires it, otherwise the stand-in.
"""

from __future__ import annotations

import ast
import csv
import re
import sys
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from functools import lru_cache
from importlib.machinery import PathFinder
from pathlib import Path

from tracerisk.common.text.bounded import file_bytes
from tracerisk.instrument.source.python_source import parsed
from tracerisk.ros.controller.needs import WINDOW_MODULES
from tracerisk.ros.controller.removed_names import REMOVED_MODULES
from tracerisk.ros.imports.panels.window_names import no_screen

VENDOR_LIBRARIES = frozenset(
    {
        "DRFC",
        "DR_common",
        "DR_common2",
        "DR_error",
        "DR_error2",
        "DR_init",
        "DSR_ROBOT",
        "DSR_ROBOT2",
        "baxter_dataflow",
        "baxter_interface",
        "intera_dataflow",
        "intera_interface",
        "intera_motion_interface",
        "interactive_markers",
        "interbotix_common_modules",
        "interbotix_perception_modules",
        "interbotix_xs_modules",
        "moveit_python",
        "ros",
        "ros2_numpy",
        "ros_numpy",
        "rospy_message_converter",
        "smach",
        "smach_ros",
    }
)
"""The stand-ins that give way to a module of the same name, by their top names."""

FROM_INDEX = frozenset({"pymoveit2"})
"""The libraries for controllers that tracerisk requires: their releases give way as stand-ins."""

# What each speaks to, after its own documentation; none of them goes through ROS.
_ROBOTS = {
    "bosdyn": "the robot over the network",
    "cri_lib": "the robot over the network",
    "dobot_api": "the robot over the network",
    "dynamixel_sdk": "servos on a serial port",
    "feetech_servo_sdk": "servos on a serial port",
    "frankx": "the robot over the network",
    "jkrc": "the robot over the network",
    "kortex_api": "the robot over the network",
    "lerobot": "motors on a serial port",
    "panda_py": "the robot over the network",
    "pyfranka": "the robot over the network",
    "pyniryo": "the robot over the network",
    "pyniryo2": "the robot over the network",
    "pydobot": "the robot on a serial port",
    "pymycobot": "the robot on a serial port",
    "robodk": "the robot over the network",
    "rtde_control": "the robot over the network",
    "rtde_io": "the robot over the network",
    "rtde_receive": "the robot over the network",
    "scservo_sdk": "servos on a serial port",
    "urx": "the robot over the network",
    "xarm": "the robot over the network",
}

# Devices beside a robot, or in it: what commands the arm through one of them moves nothing.
_DEVICES = {
    "RPi": "the pins of a Raspberry Pi",
    "bluetooth": "a Bluetooth device",
    "can": "a CAN bus",
    "pyrealsense2": "a camera",
    "serial": "a serial port",
    "smbus": "an I2C bus",
    "smbus2": "an I2C bus",
    "spidev": "an SPI bus",
    "usb": "a USB device",
}

# Libraries that no package index has, and where their sources are.
_REPOSITORIES = {
    "arc_utilities": "UM-ARM-Lab/arc_utilities",
    "arm_robots": "UM-ARM-Lab/arm_robots",
    "franka_interface": "justagist/franka_ros_interface",
    "franka_tools": "justagist/franka_ros_interface",
    "frankapy": "iamlab-cmu/frankapy",
    "interbotix_descriptions": "Interbotix/interbotix_ros_arms",
    "interbotix_sdk": "Interbotix/interbotix_ros_arms",
    "intera_external_devices": "RethinkRobotics/intera_sdk",
    "locobot_control": "facebookresearch/pyrobot",
    "niryo_one_python_api": "NiryoRobotics/niryo_one_ros",
    "niryo_robot_python_ros_wrapper": "NiryoRobotics/ned_ros",
    "panda_robot": "justagist/panda_robot",
    "simulation_and_control": "VModugno/simulation_and_control",
    "ur_control": "cambel/ur3",
}

_ROS_LIKE = re.compile(
    r"\w+_(msgs|srvs|interfaces|actions)"
    r"|(ros|rcl|tf2_|moveit|ament|catkin|actionlib|action_|gazebo_|controller_manager|rosidl)\w*"
    r"|genpy|genmsg|launch(_ros)?|tf|tf2_ros|tf_conversions|tf_transformations|cv_bridge"
    r"|image_geometry|laser_geometry|message_filters|dynamic_reconfigure|pluginlib|rospkg|std_srvs"
    r"|smach(_ros)?|py_trees(_ros)?|urdf_parser_py|kdl_parser_py|sensor_msgs_py|pymoveit2"
)
_MODULES = Path(__file__).parent / "data" / "modules.csv"
_MESSAGES = re.compile(r"\w+_(msgs|srvs|interfaces|actions)")


def is_installed(name: str) -> bool:
    """Return whether the import path has a module `name`, which tracerisk does not bring."""
    if name in FROM_INDEX:
        return False
    try:
        spec = PathFinder.find_spec(name, sys.path)
    except (ImportError, ValueError):
        return False
    # A folder without a source of its own is a part of a workspace, not a module.
    return spec is not None and spec.origin is not None


_TOGETHER = {
    "interbotix_common_modules": "interbotix_xs_modules",
    "interbotix_perception_modules": "interbotix_xs_modules",
}
"""Libraries of one release with the one that uses them, whose stand-in uses their stand-ins."""


@dataclass(frozen=True, slots=True)
class GivingWay:
    """Which stand-ins give way to the author's own source."""

    names: frozenset[str]
    """The top names of those that do."""
    unusable: Mapping[str, Path]
    """The folders of the workspace's copies that cannot run here, by their top names."""
    why: Mapping[str, str]
    """Why each of these cannot: it is no Python, or needs a library that nobody has."""


NO_PYTHON = "is no Python"
"""Why a copy cannot run that nothing reads; another copy needs a library that nobody has."""


def giving_way(packages: Mapping[str, Path]) -> GivingWay:
    """Return which stand-ins give way in a workspace.

    `packages` maps its Python packages to the folders that hold them.
    """
    copies = VENDOR_LIBRARIES & packages.keys()
    why = {name: _why_not(packages[name] / name, packages) for name in sorted(copies)}
    why = {name: words for name, words in why.items() if words}
    unusable = {name: packages[name] / name for name in why}
    without_their_users = {
        name
        for name, user in _TOGETHER.items()
        if name in copies and user not in copies and not is_installed(user)
    }
    return GivingWay(VENDOR_LIBRARIES - unusable.keys() - without_their_users, unusable, why)


def _why_not(package: Path, packages: Collection[str]) -> str:
    """Return why a copy of a library cannot run; empty where nothing speaks against it.

    Whoever drives the robot has what its library needs; who only assesses the program may not.
    """
    trees = [parsed(file_bytes(file)) for file in sorted(package.glob("*.py"))]
    if None in trees:
        return NO_PYTHON
    tops = {name.partition(".")[0] for tree in trees if tree is not None for name in _needs(tree)}
    absent = sorted(
        name
        for name in tops & distributions().keys() - set(packages)
        if name not in sys.stdlib_module_names and not is_installed(name)
    )
    return f"needs {' and '.join(absent)}, not installed here" if absent else ""


def _needs(tree: ast.Module) -> Iterator[str]:
    """Yield the modules that a file imports whatever it goes on to do."""
    for statement in tree.body:
        if isinstance(statement, ast.Import):
            yield from (alias.name for alias in statement.names)
        elif isinstance(statement, ast.ImportFrom) and not statement.level and statement.module:
            yield statement.module


@dataclass(frozen=True, slots=True)
class Remedy:
    """What to do about a module that is not available."""

    words: str
    """The remedy in words."""
    distribution: str | None = None
    """The package to install; `None` where no index has one."""


def remedy(name: str, provided: Collection[str]) -> Remedy:
    """Return what to do about a top-level module that nobody has.

    `provided` are the names that have stand-ins.
    """
    if name in _ROBOTS:
        return Remedy(
            f"it speaks to {_ROBOTS[name]}, past ROS, and tracerisk simulates robots behind "
            "ROS only; command the arm through its ROS driver"
        )
    if name in _DEVICES:
        return Remedy(
            f"it speaks to {_DEVICES[name]}, past ROS; nothing that the program sends or reads "
            "there is simulated"
        )
    if name in WINDOW_MODULES:
        return Remedy(no_screen(name))
    if name in REMOVED_MODULES:
        return Remedy(REMOVED_MODULES[name])
    if name in _REPOSITORIES:
        return Remedy(
            f"it is in https://github.com/{_REPOSITORIES[name]}; clone it into the workspace, or "
            "install it in the environment in which tracerisk runs"
        )
    distribution = distributions().get(name)
    if distribution is not None:
        return Remedy("", distribution)
    if _ROS_LIKE.fullmatch(name):
        near = get_close_matches(name, provided, n=1)
        hint = f"(did you mean '{near[0]}'?) " if near else ""
        wanted = "its definitions" if _MESSAGES.fullmatch(name) else "its sources"
        return Remedy(
            f"{hint}it looks like a ROS package, which is neither found in the controller's "
            f"workspace nor served by tracerisk; put {wanted} into the workspace, in a folder with "
            "a package.xml"
        )
    return Remedy(
        "put it beside the controller, or install it in the environment in which tracerisk runs"
    )


def may_stand_in(name: str, provided: Collection[str]) -> bool:
    """Return whether a placeholder may stand for a top-level module that nobody has.

    None does for what commands the robot, past ROS or in its own way, and for what is ROS's. One
    may for a device, such as the serial port of a gripper: nothing moves by it.
    """
    known = {*_ROBOTS, *_REPOSITORIES, *REMOVED_MODULES, *provided}
    return name not in known and missing_module(name, provided) is None


@lru_cache(maxsize=1)
def distributions() -> Mapping[str, str]:
    """Return the distribution on the package index that provides each module, where it is known.

    The table is made of the distributions' own metadata, by `benchmarks/module_table.py`.
    """
    with _MODULES.open(encoding="utf-8", newline="") as stream:
        return {row["module"]: row["distribution"] for row in csv.DictReader(stream)}


def missing_module(name: str, provided: Collection[str]) -> str | None:
    """Return what to say of a missing top-level module; None if it has to do with no robot.

    `provided` are the names that have stand-ins.
    """
    is_known = name in _ROBOTS or name in _REPOSITORIES
    if not is_known and (_ROS_LIKE.fullmatch(name) is None or name in distributions()):
        return None
    return f"No module named '{name}': {remedy(name, provided).words}"
