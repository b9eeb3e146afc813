"""`tracerisk robots`: the shipped robots, and what one of them has."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from tracerisk.cli.shared import options as shared
from tracerisk.cli.shared.output import print_json, show, terminal_width
from tracerisk.cli.shared.sources import named_robot
from tracerisk.common.text.plain_data import picked
from tracerisk.twin.robots.index import shipped_grippers, shipped_names
from tracerisk.twin.robots.robot_parts import OFFERED

if TYPE_CHECKING:
    from tracerisk.twin.robots.index import RobotNames
    from tracerisk.twin.robots.robot import Robot
    from tracerisk.twin.robots.robot_parts import Joint

_LEAST = 2  # columns of the list: name and title

# What every robot is asked for by its own name.
_ALWAYS = (
    ("action", "move_group", "moveit_msgs/MoveGroup"),
    ("action", "execute_trajectory", "moveit_msgs/ExecuteTrajectory"),
    ("topic", "/joint_states", "sensor_msgs/JointState"),
    ("topic", "/tf", "tf2_msgs/TFMessage"),
    ("service", "compute_ik", "moveit_msgs/GetPositionIK"),
    ("service", "compute_fk", "moveit_msgs/GetPositionFK"),
    ("service", "list_controllers", "controller_manager_msgs/ListControllers"),
    ("service", "switch_controller", "controller_manager_msgs/SwitchController"),
)


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument(
        "robot", metavar="NAME|FILE", nargs="?", help="robot to show (default: list all)"
    )
    shared.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the verb and return its exit code."""
    if options.robot is not None:
        robot = named_robot(options.robot)
        if options.json:
            print_json("robots", robot=_as_json(robot))
        else:
            show(*_described(robot))
        return 0

    names = shipped_names()
    if options.json:
        print_json("robots", robots=[_listed_as_json(name) for name in names])
    else:
        show(*_listed(names))
    return 0


def interfaces(robot: Robot) -> list[dict[str, str]]:
    """Return what the twin serves for a robot by name; other names of these types are served too.

    Each has its `kind` (action, topic or service), `name` and `type`.
    """
    rows = [
        (kind, f"{controller.name}{suffix}", message)
        for controller in robot.controllers
        for kind, suffix, message in OFFERED[controller.type]
    ]
    return [
        {"kind": kind, "name": name, "type": message} for kind, name, message in (*rows, *_ALWAYS)
    ]


# The list


def _listed_as_json(names: RobotNames) -> dict[str, Any]:
    return {
        **picked(names, "name", "title", "grippers", "source"),
        "joints": len(names.arm_joints),
        "payload_kg": names.payload,
    }


def _listed(robots: Iterable[RobotNames]) -> list[str]:
    rows = [
        (
            robot.name,
            robot.title,
            str(len(robot.arm_joints)),
            ", ".join(robot.grippers) or "-",
            "-" if robot.payload is None else f"{robot.payload:g} kg",
            _public_source(robot.source),
        )
        for robot in robots
    ]
    heads = ("name", "robot", "joints", "gripper", "payload", "figures from")
    return [
        *_table(_fitting((heads, *rows))),
        "",
        "`tracerisk robots NAME` shows one of them.",
        "`ARM+GRIPPER` is an arm that is given one of these grippers: "
        f"{', '.join(shipped_grippers())}.",
    ]


def _fitting(rows: Sequence[Sequence[str]]) -> list[Sequence[str]]:
    """Return rows without the last columns for which a terminal has no room."""
    kept = list(rows)
    if sys.stdout.isatty():
        while len(kept[0]) > _LEAST and max(map(len, _table(kept))) > terminal_width():
            kept = [row[:-1] for row in kept]
    return kept


def _public_source(source: str) -> str:
    """Return the repository that a source names first."""
    words = (word.strip(",;:()") for word in source.split())
    return next((word for word in words if word.count("/") == 1), source)


# One robot


def _as_json(robot: Robot) -> dict[str, Any]:
    return {
        **picked(robot, "name", "title", "aliases", "source", "default_scene"),
        "payload_kg": robot.payload,
        "joints": [_joint_as_json(joint) for joint in robot.joints],
        "groups": {
            name: picked(group, "joints", "tip_link") for name, group in robot.groups.items()
        },
        "named_states": {
            group: {state: dict(positions) for state, positions in states.items()}
            for group, states in robot.named_states.items()
        },
        "grippers": [
            {
                **picked(gripper, "name", "group", "joints", "pads", "effort"),
                "range": [gripper.least, gripper.opening],
            }
            for gripper in robot.grippers
        ],
        "controllers": [
            picked(controller, "name", "type", "joints") for controller in robot.controllers
        ],
        "interfaces": interfaces(robot),
        "actuators": dict(robot.actuators),
        "sensors": [picked(sensor, "name", "kind", "part", "topics") for sensor in robot.sensors],
        "measured": _measured(robot),
    }


def _joint_as_json(joint: Joint) -> dict[str, Any]:
    endless = joint.type == "continuous"
    return {
        **picked(joint, "name", "type"),
        "lower": None if endless else joint.lower,
        "upper": None if endless else joint.upper,
        "velocity": joint.velocity_limit,
        "acceleration": joint.acceleration_limit,
        "torque": joint.torque_limit,
        "units": "m, N" if joint.type == "prismatic" else "rad, N m",
    }


def _measured(robot: Robot) -> list[dict[str, str]]:
    """Return what the twin samples, whichever sensors the robot itself has."""
    joints = [
        {"of": joint.name, "measures": what}
        for joint in robot.joints
        for what in ("position", "velocity", "torque")
    ]
    pads = [
        {"of": pad, "measures": "contact force"}
        for gripper in robot.grippers
        for pad in gripper.pads
    ]
    return joints + pads


def _described(robot: Robot) -> list[str]:
    from tracerisk.twin.robots.gripper_ends import gripper_ends

    lines = [f"{robot.name}: {robot.title}"]
    if robot.aliases:
        lines.append(f"also called: {', '.join(robot.aliases)}")
    if robot.payload is not None:
        lines.append(f"payload: {robot.payload:g} kg")
    lines += ["", "joints, in rad, s and N m; prismatic ones in m, s and N:"]
    lines += _indented(_table(_joint_rows(robot)))
    for gripper in robot.grippers:
        unit = robot.joint(gripper.joints[0]).unit
        force = "N" if unit == "m" else "N m"
        lines += [
            "",
            f"gripper {gripper.name} (group {gripper.group}):",
            f"  joints: {', '.join(gripper.joints)}",
            f"  from {gripper.least:g} to {gripper.opening:g} {unit}, "
            f"open at {gripper_ends(robot, gripper).opened:g}, "
            f"at most {gripper.effort:g} {force} a finger; it holds with {', '.join(gripper.pads)}",
        ]
    if robot.actuators:
        moved = [(name, ", ".join(joints)) for name, joints in robot.actuators.items()]
        lines += ["", "actuators:", *_indented(_table(moved))]
    lines += ["", "groups:"]
    for name, group in robot.groups.items():
        tip = "" if group.tip_link is None else f"; tip {group.tip_link}"
        lines.append(f"  {name}: {', '.join(group.joints)}{tip}{_grasps(robot, name)}")
    lines += ["", "named states:"]
    lines += [f"  {group}: {', '.join(states)}" for group, states in robot.named_states.items()]
    if not robot.named_states:
        lines.append("  none")
    served = [
        (interface["kind"], interface["name"], interface["type"]) for interface in interfaces(robot)
    ]
    lines += ["", "served, under these and other names:", *_indented(_table(served))]
    touch = ", ".join(pad for gripper in robot.grippers for pad in gripper.pads)
    rows = [
        (sensor.name, sensor.kind, sensor.part, ", ".join(sensor.topics))
        for sensor in robot.sensors
    ]
    lines += ["", "sensors:", *_indented(_table(rows) if rows else ["none"])]
    lines += ["", "measured by the twin:", "  position, velocity and torque of every joint"]
    if touch:
        lines.append(f"  contact force on {touch}")
    return [*lines, "", f"source: {robot.source}"]


def _grasps(robot: Robot, group: str) -> str:
    """Return where grippers close, as the tip of an arm sees it: a pose goal is that of the tip."""
    from tracerisk.twin.robots.gripper_ends import grasp_from

    tip, joints = robot.groups[group].tip_link, set(robot.groups[group].joints)
    if tip is None or any(joints & set(gripper.joints) for gripper in robot.grippers):
        return ""
    places = []
    for gripper in robot.grippers:
        if gripper.pads and joints & {joint.name for joint in robot.above(gripper.pads[0])}:
            x, y, z = (round(value, 3) + 0.0 for value in grasp_from(robot, gripper, tip))
            places.append(f"{gripper.name} closes at ({x:.3f}, {y:.3f}, {z:.3f}) m from it")
    return "".join(f", {place}" for place in places)


def _joint_rows(robot: Robot) -> list[tuple[str, str, str, str, str, str, str]]:
    rows = [("name", "type", "from", "to", "speed", "acceleration", "torque")]
    for joint in robot.joints:
        limits = (joint.velocity_limit, joint.acceleration_limit, joint.torque_limit)
        lower, upper = f"{joint.lower:.4g}", f"{joint.upper:.4g}"
        ends = ("-", "-") if joint.type == "continuous" else (lower, upper)
        speed, acceleration, torque = (f"{limit:.4g}" for limit in limits)
        rows.append((joint.name, joint.type, *ends, speed, acceleration, torque))
    return rows


def _table(rows: Iterable[Sequence[str]]) -> list[str]:
    """Return rows as lines whose columns stand under one another."""
    rows = [tuple(row) for row in rows]
    widths = [max(len(cell) for cell in column) for column in zip(*rows, strict=True)]
    return [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]


def _indented(lines: Iterable[str]) -> list[str]:
    return [f"  {line}" for line in lines]
