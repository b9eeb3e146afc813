"""Which topics command joints, by name and type, and which joints of the arm they command."""

from __future__ import annotations

import re
from collections.abc import Collection
from typing import TYPE_CHECKING

from tracerisk.ros.robot.grippers import gripper_of

if TYPE_CHECKING:
    from tracerisk.twin.robots.robot import Robot


TRAJECTORY = "trajectory_msgs/JointTrajectory"
GROUP = "std_msgs/Float64MultiArray"
SINGLE = "std_msgs/Float64"
JOINT_STATE_TYPE = "sensor_msgs/JointState"
_COMMANDS = ("command", "commands")
_NUMBER = re.compile(r"\d+")
SAYS_COMMANDS = re.compile(r"^(joints?|arm|positions?|joint_positions?)_(commands?|cmd)$")
_TAKES_STATES = re.compile(r"(^|_)(commands?|cmd)$|^fake_controller_joint_states$")


def is_command_topic(name: str, type_name: str) -> bool:
    """Return whether a robot's driver takes what is published on a topic for a command."""
    last = name.rsplit("/", 1)[-1]
    if type_name == JOINT_STATE_TYPE:
        return _TAKES_STATES.search(last) is not None
    if type_name == GROUP and SAYS_COMMANDS.match(last):
        return True
    return type_name == TRAJECTORY or (type_name in (GROUP, SINGLE) and last in _COMMANDS)


def group_joints(robot: Robot, topic: str, count: int) -> tuple[str, ...] | None:
    """Return the joints that `count` values on a topic are for, None where nothing fits.

    They are those of the controller that the topic names, of a gripper where it speaks of one,
    of the first planning group with as many joints, or all. On a robot that stands in for one
    that is not known they are the first joints of its arm.
    """
    parts = topic.strip("/").split("/")
    for controller in robot.controllers:
        if controller.name in parts and len(controller.joints) == count:
            return controller.joints
    if re.search(r"gripper|hand|finger", topic):
        gripper = gripper_of(robot, topic)
        if gripper is not None and count <= len(gripper.joints):
            return gripper.joints[:count]
    arm = {joint.name for joint in robot.arm_joints}
    groups = [group.joints for group in robot.groups.values()]
    for joints in sorted(groups, key=lambda joints: not set(joints) <= arm):
        if len(joints) == count:
            return joints
    everything = tuple(joint.name for joint in robot.joints)
    if len(everything) == count:
        return everything
    in_order = tuple(joint.name for joint in robot.arm_joints)
    return in_order[:count] if robot.assumes_names and 0 < count <= len(in_order) else None


def single_joint(robot: Robot, topic: str) -> str | None:
    """Return the joint that a topic of one value is for, None where none is meant.

    It is the one whose name the topic contains, else the only one of its number: the joint
    `panda_joint3` for `/arm/joint3_position_controller/command`.
    """
    names = [joint.name for joint in robot.joints]
    parts = topic.strip("/").split("/")[:-1]
    for part in reversed(parts):
        contained = [name for name in names if name in part]
        if contained:
            return max(contained, key=len)
    for part in reversed(parts):
        matched = re.search(r"joint_?(\d+)", part)
        if matched is not None:
            numbered = [name for name in names if re.search(rf"joint_?{matched.group(1)}$", name)]
            arm = [name for name in numbered if "finger" not in name and "gripper" not in name]
            if len(arm) == 1:
                return arm[0]
    if re.search(r"gripper|hand|finger", topic):
        gripper = gripper_of(robot, topic)
        if gripper is not None:
            return gripper.joints[0]
    return None


def joint_by_number(robot: Robot, topic: str, topics: Collection[str]) -> str | None:
    """Return the joint of the arm at the place that a topic's number gives it among its kind.

    `topics` are all topics of one value that are commanded. Those of one kind differ in a number
    alone, which counts from 0 or from 1; the robot has no joint that any of them names.
    """
    arm = [joint.name for joint in robot.arm_joints]
    for match in reversed(list(_NUMBER.finditer(topic))):
        kind = re.compile(
            rf"{re.escape(topic[: match.start()])}(\d+){re.escape(topic[match.end() :])}"
        )
        alike = {name: int(same[1]) for name in topics if (same := kind.fullmatch(name))}
        if len(alike) < 2 or any(single_joint(robot, name) for name in alike):
            continue
        first = min(alike.values())
        place = alike.get(topic, len(arm)) - min(first, 1)
        return arm[place] if place < len(arm) else None
    return None
