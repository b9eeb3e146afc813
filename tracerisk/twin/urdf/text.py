"""A robot as a URDF text: its links and their masses, its joints and their limits."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable
from dataclasses import replace

from tracerisk.common.geometry.frames import rotation
from tracerisk.common.geometry.shapes import Shape
from tracerisk.twin.robots.robot import Robot

_MOMENTS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


def urdf_text(robot: Robot, *, with_shapes: bool = False) -> str:
    """Return the robot's description: frames [m, rad], limits [rad or m, and per s], masses [kg].

    Shapes are left out but for who shows the robot: other readers plan with the joints.
    """
    top = ET.Element("robot", name=robot.name)
    joints = {joint.name: joint for joint in robot.joints}
    followed = _followed(robot)
    for link in robot.links:
        node = ET.SubElement(top, "link", name=link.name)
        if link.mass > 0.0:
            body = ET.SubElement(node, "inertial")
            ET.SubElement(body, "origin", xyz=_numbers(link.centre_of_mass), rpy="0 0 0")
            ET.SubElement(body, "mass", value=f"{link.mass:.6g}")
            moments = zip(_MOMENTS, link.inertia or [0.0] * 6, strict=True)
            ET.SubElement(body, "inertia", {name: f"{moment:.6g}" for name, moment in moments})
        for shape in link.shapes if with_shapes else ():
            _add_shape(node, shape)
    for attachment in robot.attachments:
        node = ET.SubElement(top, "joint", name=attachment.name, type=attachment.type)
        ET.SubElement(node, "origin", xyz=_numbers(attachment.xyz), rpy=_numbers(attachment.rpy))
        ET.SubElement(node, "parent", link=attachment.parent)
        ET.SubElement(node, "child", link=attachment.child)
        joint = joints.get(attachment.name)
        if joint is None:
            continue
        ET.SubElement(node, "axis", xyz=_numbers(attachment.axis))
        limits = {"effort": joint.torque_limit, "velocity": joint.velocity_limit}
        if attachment.type != "continuous":
            limits |= {"lower": joint.lower, "upper": joint.upper}
        ET.SubElement(node, "limit", {name: f"{value:.9g}" for name, value in limits.items()})
        if attachment.name in followed:
            lead, sign = followed[attachment.name]
            ET.SubElement(node, "mimic", joint=lead, multiplier=str(sign), offset="0")
    return ET.tostring(top, encoding="unicode")


def _followed(robot: Robot) -> dict[str, tuple[str, int]]:
    """Return whom each finger follows that no group plans for, and in which direction."""
    planned = {name for group in robot.groups.values() for name in group.joints}
    return {
        name: (gripper.joints[0], gripper.sign(name) * gripper.sign(gripper.joints[0]))
        for gripper in robot.grippers
        for name in gripper.joints[1:]
        if name not in planned
    }


def _add_shape(link: ET.Element, shape: Shape) -> None:
    """Add a shape to be seen; a capsule as its cylinder and a ball at each end."""
    if shape.kind == "box":
        _add_visual(link, shape, "box", size=_numbers(2.0 * value for value in shape.size))
        return
    radius = f"{shape.size[0]:.9g}"
    if shape.kind == "sphere":
        _add_visual(link, shape, "sphere", radius=radius)
        return
    half = shape.size[1]
    _add_visual(link, shape, "cylinder", radius=radius, length=f"{2.0 * half:.9g}")
    if shape.kind == "capsule":
        along = rotation(shape.rpy)[:, 2] * half
        for end in (along, -along):
            ball = replace(shape, xyz=tuple((shape.xyz + end).tolist()))
            _add_visual(link, ball, "sphere", radius=radius)


def _add_visual(link: ET.Element, shape: Shape, kind: str, **size: str) -> None:
    node = ET.SubElement(link, "visual")
    ET.SubElement(node, "origin", xyz=_numbers(shape.xyz), rpy=_numbers(shape.rpy))
    ET.SubElement(ET.SubElement(node, "geometry"), kind, size)


def _numbers(values: Iterable[float]) -> str:
    return " ".join(f"{value + 0.0:.9g}" for value in values)
