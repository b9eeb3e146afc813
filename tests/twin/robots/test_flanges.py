"""No shape of an arm reaches beyond the plane in which its tool is mounted.

A shape that does presses on what a real flange does not touch.
"""

import numpy as np
import pytest
from numpy.typing import NDArray

from tracerisk.common.geometry.frames import rotation
from tracerisk.common.geometry.shapes import Shape
from tracerisk.twin.robots.robot import Robot, load_robot, robot_names
from tracerisk.twin.robots.robot_parts import Attachment, Link

BEYOND = 0.002
"""By how much a shape may reach beyond the flange [m]."""
HANDS = frozenset({"crane_x7", "open_manipulator_x", "so100"})
"""Whose last link is the hand itself, so that there is no flange."""
RADII = {"ur10": 0.045, "ur10e": 0.045}
"""Of the last link, where the maker's description gives it [m]:

UniversalRobots/Universal_Robots_ROS2_Description config/ur10e/physical_parameters.yaml.
"""
ARMS = [name for name in robot_names() if name not in HANDS]


def _matrix(xyz: tuple[float, float, float], rpy: tuple[float, float, float]) -> NDArray:
    found = np.eye(4)
    found[:3, :3], found[:3, 3] = rotation(rpy), xyz
    return found


def _reach(shape: Shape, normal: NDArray, frame: NDArray) -> float:
    """Return how far a shape reaches along `normal` [m]."""
    at = frame @ _matrix(shape.xyz, shape.rpy)
    across = at[:3, :3].T @ normal
    size = shape.size
    if shape.kind == "box":
        extent = float(np.abs(across) @ np.array(size))
    elif shape.kind == "cylinder":
        extent = size[0] * float(np.hypot(*across[:2])) + size[1] * abs(across[2])
    else:
        extent = size[0] + (size[1] * abs(across[2]) if shape.kind == "capsule" else 0.0)
    return float(at[:3, 3] @ normal) + extent


def _last(robot: Robot) -> tuple[Attachment, Link, Link]:
    """Return the last joint of the arm, the link that it moves and the one before."""
    held = {joint for gripper in robot.grippers for joint in gripper.joints}
    arm = next(
        group
        for name, group in robot.groups.items()
        if name != "head" and not held.intersection(group.joints)
    )
    joint = next(one for one in robot.attachments if one.name == arm.joints[-1])
    links = {link.name: link for link in robot.links}
    return joint, links[joint.child], links[joint.parent]


def _flange(robot: Robot, joint: Attachment) -> tuple[NDArray, float]:
    """Return where the flange points in the frame of the last link, and its height there [m].

    It is the first frame that is fixed to the last link away from its origin; else the origin.
    """
    axis = np.array(joint.axis)
    fixed = [
        np.array(one.xyz)
        for one in robot.attachments
        if one.parent == joint.child and one.type == "fixed" and np.linalg.norm(one.xyz) > 1e-6
    ]
    if not fixed or robot.name == "mycobot_280":
        # The joint may turn about the axis that leads back into the arm: the tool's frame says.
        tools = [one for one in robot.attachments if one.child == "tool0" and any(one.rpy)]
        out = rotation(tools[0].rpy) @ np.array([0.0, 0.0, 1.0]) if tools else axis
        return (-axis if out @ axis < -0.9 else axis), 0.0
    normal = fixed[0] / np.linalg.norm(fixed[0])
    return normal, float(fixed[0] @ normal)


def _beyond(robot: Robot) -> dict[str, float]:
    joint, last, before = _last(robot)
    normal, height = _flange(robot, joint)
    # A turn of the last joint changes nothing: its axis is the normal, or it stands at zero.
    behind = np.linalg.inv(_matrix(joint.xyz, joint.rpy))
    return {
        f"{link.name} {shape.kind}": _reach(shape, normal, frame) - height
        for link, frame in ((last, np.eye(4)), (before, behind))
        for shape in link.shapes
        if shape.contact
    }


@pytest.mark.parametrize("name", ARMS)
def test_no_shape_reaches_beyond_the_flange(name: str):
    assert {link: by for link, by in _beyond(load_robot(name)).items() if by > BEYOND} == {}


@pytest.mark.parametrize("name", RADII)
def test_the_last_link_is_no_fatter_than_the_makers(name: str):
    _, last, _ = _last(load_robot(name))
    assert all(shape.size[0] <= RADII[name] for shape in last.shapes)
