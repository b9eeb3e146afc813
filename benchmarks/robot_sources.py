"""Compare the shipped robots with public URDF, xacro and MoveIt files in a folder of checkouts.

    python benchmarks/robot_sources.py FOLDER [--robot NAME ...] [--percent 1]

FOLDER holds one checkout per repository, under any name. Printed is each figure that differs by
more than `--percent` (limits of joints, speed, acceleration, effort, masses of links) and each
frame that differs by more than 1 mm or 10 mrad, with the file that says so; then what of the list
below was not found. A difference is no error: the robot's file says which source it follows and
why. The exit code is 0.
"""

from __future__ import annotations

import argparse
import math
import sys
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import quick
import yaml
from numpy.typing import NDArray

from tracerisk.common.geometry.frames import rotation
from tracerisk.errors import RobotError
from tracerisk.twin.robots.robot import Robot, load_robot, robot_names
from tracerisk.twin.urdf.tree import Tree, read_tree, tree_of
from tracerisk.twin.urdf.xacro_files import expand_xacro
from tracerisk.twin.urdf.xml_reader import read_xml

QUICK_CHECKOUTS = {
    "panda_moveit_config/config/joint_limits.yaml": """\
joint_limits:
  panda_joint1: {has_velocity_limits: true, max_velocity: 9.0}
"""
}

# What MoveIt 1 plans with where no acceleration is given [rad/s^2]: moveit/moveit
# moveit_core/trajectory_processing/src/time_optimal_trajectory_generation.cpp.
PLANNED_WITHOUT = 1.0
FARTHEST_M = 0.001
FARTHEST_RAD = 0.01

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Source:
    """A public file about a robot."""

    path: str
    """How the file's path ends, within the checkout of its repository."""

    arguments: Mapping[str, str] = field(default_factory=dict)
    """What the xacro is expanded with."""

    prefix: tuple[str, str] = ("", "")
    """What names begin with in the file, and here."""


@dataclass(frozen=True, slots=True)
class Difference:
    """A figure that a public file gives otherwise."""

    robot: str
    what: str
    ours: float
    theirs: float
    unit: str
    file: str


XARM = "xarm_description/urdf/xarm_device.urdf.xacro"
INTERBOTIX = "interbotix_ros_xsarms/interbotix_xsarm_descriptions/urdf"
KINOVA = "kinova_moveit/robot_configs"
NIRYO = "niryo_robot_moveit_config/niryo_moveit_config_standalone/config"


def _xarm(dof: str, gripper: bool, name: str) -> tuple[Source, ...]:
    kind = "lite" if name == "lite6" else "xarm"
    arguments = {"dof": dof, "robot_type": kind, "add_gripper": str(gripper).lower()}
    config = f"config/{name}/joint_limits.yaml"
    return (
        Source(f"xarm_ros2/{XARM}", arguments),
        Source(f"xarm_ros/{XARM}", arguments),
        Source(f"xarm_ros2/xarm_moveit_config/{config}"),
        Source(f"xarm_ros/uf_robot_moveit_config/{config}"),
    )


def _universal(name: str) -> tuple[Source, ...]:
    return (
        Source(
            "Universal_Robots_ROS2_Description/urdf/ur.urdf.xacro", {"ur_type": name, "name": name}
        ),
        Source(f"universal_robot/ur_description/urdf/{name}.xacro"),
        Source("Universal_Robots_ROS2_Driver/ur_moveit_config/config/joint_limits.yaml"),
        Source(f"universal_robot/{name}_moveit_config/config/joint_limits.yaml"),
    )


def _interbotix(name: str) -> tuple[Source, ...]:
    four = name == "px100"
    six = name.endswith("s")
    limits = f"{4 if four else 6 if six else 5}dof_joint_limits.yaml"
    return (
        Source(f"{INTERBOTIX}/{name}.urdf.xacro", {"robot_name": name}),
        Source(f"interbotix_xsarm_moveit/config/joint_limits/{limits}"),
    )


def _motoman(name: str) -> tuple[Source, ...]:
    return (Source(f"motoman_{name}_support/urdf/{name}.xacro"),)


def _iiwa(name: str) -> tuple[Source, ...]:
    return (
        Source(f"lbr_description/urdf/{name}/{name}.xacro", {"mode": "mock"}),
        Source(f"lbr_moveit_config/{name}_moveit_config/config/joint_limits.yaml"),
    )


def _iiwa_stack(name: str) -> tuple[Source, ...]:
    return (
        Source(f"iiwa_stack/iiwa_description/urdf/{name}.urdf.xacro"),
        Source(f"iiwa_ros/iiwa_description/urdf/{name}.urdf.xacro", prefix=("iiwa_", "iiwa_")),
        Source("iiwa_stack/iiwa_moveit/config/joint_limits.yaml"),
        Source("iiwa_ros/iiwa_moveit/config/joint_limits.yaml"),
    )


def _kinova(name: str) -> tuple[Source, ...]:
    return (
        Source(f"kinova_description/urdf/{name}_standalone.xacro"),
        Source(f"{KINOVA}/{name}_moveit_config/config/joint_limits.yaml"),
    )


def _niryo(name: str) -> tuple[Source, ...]:
    file = f"niryo_{name}_gripper1_n_camera.urdf.xacro"
    return (
        Source(f"niryo_robot_description/urdf/{name}/{file}"),
        Source(f"{NIRYO}/{name}/joint_limits.yaml"),
    )


SOURCES: dict[str, tuple[Source, ...]] = {
    "baxter": (
        Source("baxter_description/urdf/baxter.urdf"),
        Source("baxter_description/urdf/baxter.urdf.xacro", {"gazebo": "false"}),
        Source("baxter/baxter_moveit_config/config/joint_limits.yaml"),
    ),
    "cr5": (
        Source("cra_description/urdf/cr5_robot.xacro"),
        Source("dobot_rviz/urdf/cr5_robot.urdf"),
        Source("cr5_moveit/config/joint_limits.yaml"),
    ),
    "crane_x7": (
        Source("crane_x7_description/urdf/crane_x7.urdf.xacro"),
        Source("crane_x7_moveit_config/config/joint_limits.yaml"),
    ),
    "fetch": (
        Source("fetch_description/robots/fetch.urdf"),
        Source("fetch_moveit_config/config/joint_limits.yaml"),
    ),
    "fr3": (
        Source("franka_description/robots/fr3/fr3.urdf.xacro", {"hand": "true"}),
        Source("franka_ros/franka_description/robots/fr3/fr3.urdf.xacro", {"hand": "true"}),
    ),
    **{
        name: (Source(f"DOBOT_6Axis_ROS2_V4/cra_description/urdf/{name}_robot.xacro"),)
        for name in ("cr10", "cr3", "nova5")
    },
    "crx10ia": (Source("fanuc_crx_description/robot/crx10ia.urdf.xacro"),),
    "gen3_6dof": (
        Source(
            "ros2_kortex/kortex_description/robots/gen3.xacro",
            {"arm": "gen3", "dof": "6", "gripper": "", "use_fake_hardware": "true"},
        ),
        Source("kinova_gen3_6dof_robotiq_2f_85_moveit_config/config/joint_limits.yaml"),
    ),
    **{name: _motoman(name) for name in ("gp7", "gp8", "hc10")},
    "irb120": (
        Source("abb_irb120_support/urdf/irb120_3_58.xacro"),
        Source("abb_irb120_moveit_config/config/joint_limits.yaml"),
    ),
    "lrmate200id": (
        Source("fanuc_lrmate200id_support/urdf/lrmate200id.xacro"),
        Source("fanuc_lrmate200id_moveit_config/config/joint_limits.yaml"),
    ),
    "mycobot_320": (
        Source("mycobot_320_m5_2022/new_mycobot_pro_320_m5_2022.urdf"),
    ),
    **{
        name: (Source(f"tmr_ros2/tm_description/urdf/{name.replace('_', '-')}-nominal.urdf"),)
        for name in ("tm12", "tm5_700", "tm5_900")
    },
    "tm5_900_tmr": (Source("tmr_ros1/tm_description/urdf/tm5-900-nominal.urdf"),),
    "widowx": (Source("widowx_arm_description/robots/widowx_arm.urdf.xacro"),),
    "gen3": (
        Source("kortex_description/robots/gen3_2f85.urdf", prefix=("gen3_", "")),
        Source(
            "ros_kortex/kortex_description/arms/gen3/7dof/urdf/"
            "GEN3-7DOF-NOVISION_FOR_URDF_ARM_V12.urdf"
        ),
        Source(
            "kortex_description/robots/gen3_robotiq_2f_85.xacro", {"dof": "7", "vision": "false"}
        ),
        Source("kinova_gen3_7dof_robotiq_2f_85_moveit_config/config/joint_limits.yaml"),
        Source("gen3_robotiq_2f_85_move_it_config/config/7dof/default_joint_limits.yaml"),
        Source("gen3_robotiq_2f_85_move_it_config/config/7dof/hard_joint_limits.yaml"),
    ),
    "iiwa14": _iiwa("iiwa14"),
    "iiwa14_stack": _iiwa_stack("iiwa14"),
    "iiwa7": _iiwa("iiwa7"),
    "iiwa7_stack": _iiwa_stack("iiwa7"),
    "j2n6s300": _kinova("j2n6s300"),
    "j2s6s300": _kinova("j2s6s300"),
    "j2s7s300": _kinova("j2s7s300"),
    "lite6": _xarm("6", False, "lite6"),
    "m1013": (
        Source("dsr_description2/urdf/m1013.urdf"),
        Source("dsr_moveit_config_m1013/config/joint_limits.yaml"),
    ),
    "mycobot_280": (
        Source("mycobot_description/urdf/mycobot_280_m5/mycobot_280_m5.urdf"),
        Source(
            "mycobot_ros2/mycobot_description/urdf/robots/mycobot_280.urdf.xacro",
            {"use_gripper": "true"},
        ),
        Source("mycobot_moveit_config/config/mycobot_280/joint_limits.yaml"),
    ),
    "niryo_ned": _niryo("ned"),
    "niryo_ned2": _niryo("ned2"),
    "niryo_one": _niryo("one"),
    "open_manipulator_x": (
        Source("open_manipulator_x/open_manipulator_x.urdf.xacro"),
        Source("open_manipulator_moveit_config/config/open_manipulator_x/joint_limits.yaml"),
    ),
    "panda": (
        Source(
            "franka_description/robots/fer/fer.urdf.xacro",
            {"hand": "true"},
            prefix=("fer_", "panda_"),
        ),
        Source(
            "franka_ros/franka_description/robots/panda/panda.urdf.xacro", {"hand": "true"}
        ),
        Source("panda_description/urdf/panda.urdf"),
        Source("panda_moveit_config/config/joint_limits.yaml"),
        Source("panda_moveit_config/config/hard_joint_limits.yaml"),
    ),
    **{
        name: _interbotix(name)
        for name in (
            "px100", "px150", "rx150", "rx200", "vx250", "vx300", "vx300s", "wx200", "wx250",
            "wx250s",
        )
    },
    "sawyer": (
        Source("sawyer_description/urdf/sawyer.urdf.xacro", {"electric_gripper": "true"}),
        Source("sawyer_moveit_config/config/joint_limits.yaml"),
    ),
    "so100": (
        Source("so_arm_description/urdf/so100/so100.urdf"),
        Source("SO-ARM100/Simulation/SO100/so100.urdf"),
    ),
    "tiago": (
        Source(
            "tiago_description/robots/tiago.urdf.xacro",
            {"arm": "true", "end_effector": "pal-gripper", "ft_sensor": "false"},
        ),
        Source("tiago_moveit_config/config/joint_limits.yaml"),
    ),
    **{name: _universal(name) for name in ("ur10", "ur10e", "ur3", "ur3e", "ur5", "ur5e")},
    "xarm6": _xarm("6", True, "xarm6"),
    "xarm7": _xarm("7", True, "xarm7"),
}  # fmt: skip


class Checkouts:
    """The files of a folder of checkouts."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        wanted = (".urdf", ".xacro", ".yaml")
        self._files = sorted(
            path for path in folder.rglob("*") if path.suffix in wanted and path.is_file()
        )
        self._packages: dict[Path, dict[str, Path]] = {}
        for result in sorted(folder.rglob("package.xml")):
            try:
                name = ET.parse(result).findtext("name", "").strip()
            except ET.ParseError:
                continue
            self._packages.setdefault(self._checkout(result), {})[name] = result.parent

    def _checkout(self, path: Path) -> Path:
        return self._folder / path.relative_to(self._folder).parts[0]

    def find(self, source: Source) -> Iterator[Path]:
        """Yield the files of a source; a checkout may be called `owner+name` or `name`."""
        for path in self._files:
            text = path.relative_to(self._folder).as_posix()
            if f"/{text}".replace("+", "/").endswith(f"/{source.path}"):
                yield path

    def packages(self, path: Path) -> dict[str, Path]:
        """Return the packages that a file sees: those of its own checkout first."""
        paths: dict[str, Path] = {}
        for packages in self._packages.values():
            paths.update(packages)
        return {**paths, **self._packages.get(self._checkout(path), {})}

    def shown(self, path: Path) -> str:
        return path.relative_to(self._folder).as_posix()


def renamed(name: str, source: Source) -> str:
    old, new = source.prefix
    name = name.removeprefix("$(arg prefix)")
    return new + name.removeprefix(old) if old and name.startswith(old) else name


def from_limits(robot: Robot, text: str, source: Source) -> Iterator[tuple[str, float, float, str]]:
    """Yield name, our figure, theirs and the unit of what a joint_limits.yaml says."""
    limits = (yaml.safe_load(text) or {}).get("joint_limits") or {}
    joints = {joint.name: joint for joint in robot.joints}
    for key, entry in limits.items():
        name = renamed(key, source)
        # Those of Interbotix arms name joints without the robot's prefix.
        joint = joints.get(name) or joints.get(f"{robot.name}/{name}")
        if joint is None or not isinstance(entry, dict):
            continue
        if entry.get("has_velocity_limits"):
            theirs = float(entry["max_velocity"])
            yield f"{name} velocity of plans", joint.planned_velocity, theirs, "1/s"
        if entry.get("has_acceleration_limits"):
            theirs = float(entry["max_acceleration"])
        else:
            theirs = PLANNED_WITHOUT
        yield f"{name} acceleration of plans", joint.planned_acceleration, theirs, "1/s^2"


def from_urdf(robot: Robot, text: bytes, source: Source) -> Iterator[tuple[str, float, float, str]]:
    """Yield name, our figure, theirs and the unit of what a URDF says."""
    root = read_xml(text, source.path)
    tree = read_tree(root, source.path)
    joints = {joint.name: joint for joint in robot.joints}
    for urdf_joint in tree.moving:
        joint = joints.get(renamed(urdf_joint.name, source))
        if joint is None:
            continue
        if urdf_joint.type != "continuous" and joint.type != "continuous":
            yield f"{joint.name} lower", joint.lower, urdf_joint.lower, ""
            yield f"{joint.name} upper", joint.upper, urdf_joint.upper, ""
        yield f"{joint.name} velocity", joint.velocity_limit, urdf_joint.velocity, "1/s"
        yield f"{joint.name} effort", joint.torque_limit, urdf_joint.effort, "N m"
    masses = {}
    for entry in root.all("link"):
        inertial = entry.first("inertial")
        mass = inertial.first("mass") if inertial is not None else None
        if mass is not None:
            masses[renamed(entry.string("name"), source)] = mass.number("value")
    moved = behind_joints(tree_of(robot))
    both = [link for link in robot.links if link.name in masses and link.name in moved]
    for link in both:
        yield f"{link.name} mass", link.mass, masses[link.name], "kg"
    here, there = sum(link.mass for link in both), sum(masses[link.name] for link in both)
    yield "mass of these links", here, there, "kg"
    ours = frames(tree_of(robot), Source(""))
    theirs = frames(tree, source)
    for name in sorted(ours.keys() & theirs.keys()):
        (anchor, mine), (their_anchor, yours) = ours[name], theirs[name]
        if anchor != their_anchor:
            continue
        apart = float(np.linalg.norm(mine[:3, 3] - yours[:3, 3]))
        turn = (np.trace(mine[:3, :3].T @ yours[:3, :3]) - 1) / 2
        angle = math.acos(min(1.0, max(-1.0, float(turn))))
        if apart > FARTHEST_M:
            yield f"{name} frame, apart", 0.0, apart * 1000, "mm"
        if angle > FARTHEST_RAD:
            yield f"{name} frame, turned", 0.0, angle, "rad"


def behind_joints(tree: Tree) -> set[str]:
    """Return the links that a joint moves."""
    names: set[str] = set()
    for joint in tree.joints:
        if joint.moves or joint.parent in names:
            names.add(joint.child)
    return names


def frames(tree: Tree, source: Source) -> dict[str, tuple[str, Array]]:
    """Return each link's frame in that of the last link before it that a joint moves.

    All joints are at 0. The anchor is named by its joint; links before the first joint have none.
    """
    pair: dict[str, tuple[str, Array]] = {}
    anchored: dict[str, tuple[str, Array]] = {}
    for joint in tree.joints:
        step = np.eye(4)
        step[:3, :3] = rotation(joint.rpy)
        step[:3, 3] = joint.xyz
        anchor, above = anchored.get(joint.parent, ("", np.eye(4)))
        here = above @ step
        if anchor:
            pair[renamed(joint.child, source)] = (anchor, here)
        if joint.moves:
            anchored[joint.child] = (renamed(joint.name, source), np.eye(4))
        elif anchor:
            anchored[joint.child] = (anchor, here)
    return pair


def differences(
    robot: Robot, path: Path, source: Source, checkouts: Checkouts, percent: float
) -> Iterator[Difference]:
    """Yield what one file says otherwise. Raises RobotError for a file that cannot be read."""
    shown = checkouts.shown(path)
    if path.suffix == ".yaml":
        rows = from_limits(robot, path.read_text(encoding="utf-8"), source)
    elif path.suffix == ".xacro":
        text = expand_xacro(path, checkouts.packages(path), arguments=source.arguments, shown=shown)
        rows = from_urdf(robot, text, source)
    else:
        rows = from_urdf(robot, path.read_bytes(), source)
    for what, ours, theirs, unit in rows:
        least = percent / 100 * max(abs(ours), abs(theirs), 0.1)
        if " frame, " in what or abs(ours - theirs) > least:
            yield Difference(robot.name, what, ours, theirs, unit, shown)


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folder", type=Path, nargs="?")
    parser.add_argument("--robot", action="append", choices=robot_names())
    parser.add_argument("--percent", type=float, default=1.0)
    options = quick.parsed(
        parser, folder=lambda: quick.folder(QUICK_CHECKOUTS), robot=lambda: ["panda"]
    )
    if options.folder is None or not options.folder.is_dir():
        parser.error(f"{options.folder or ''} is no folder; give one that holds the checkouts")
    checkouts = Checkouts(options.folder)
    missing = []
    for name in options.robot or robot_names():
        robot = load_robot(name)
        seen: set[Path] = set()
        for source in SOURCES[name]:
            found_here = list(checkouts.find(source))
            paths = [path for path in found_here if path not in seen]
            seen.update(paths)
            if not found_here:
                missing.append(f"{name}: {source.path}")
            for path in paths:
                try:
                    result = list(differences(robot, path, source, checkouts, options.percent))
                except RobotError as error:
                    missing.append(f"{name}: {checkouts.shown(path)}: {error}")
                    continue
                print(f"{name}: {checkouts.shown(path)}: {len(result)} differences")
                for difference in result:
                    figures = (
                        f"{difference.ours:.6g}, there {difference.theirs:.6g} {difference.unit}"
                    )
                    print(f"    {difference.what:48} {figures}")
    for line in missing:
        print(f"not compared: {line}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
