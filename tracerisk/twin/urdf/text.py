"""A robot as a URDF text: its links and their masses, its joints and their limits; no shapes."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable

from tracerisk.twin.robots.robot import Robot

_MOMENTS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


def urdf_text(robot: Robot) -> str:
    """Return the robot's description: frames [m, rad], limits [rad or m, and per s], masses [kg].

    Shapes are left out: a reader of it plans with the joints.
    """
    top = ET.Element("robot", name=robot.name)
    joints = {joint.name: joint for joint in robot.joints}
    for link in robot.links:
        node = ET.SubElement(top, "link", name=link.name)
        if link.mass > 0.0:
            body = ET.SubElement(node, "inertial")
            ET.SubElement(body, "origin", xyz=_numbers(link.centre_of_mass), rpy="0 0 0")
            ET.SubElement(body, "mass", value=f"{link.mass:.6g}")
            moments = zip(_MOMENTS, link.inertia or [0.0] * 6, strict=True)
            ET.SubElement(body, "inertia", {name: f"{each:.6g}" for name, each in moments})
    for each in robot.attachments:
        node = ET.SubElement(top, "joint", name=each.name, type=each.type)
        ET.SubElement(node, "origin", xyz=_numbers(each.xyz), rpy=_numbers(each.rpy))
        ET.SubElement(node, "parent", link=each.parent)
        ET.SubElement(node, "child", link=each.child)
        joint = joints.get(each.name)
        if joint is None:
            continue
        ET.SubElement(node, "axis", xyz=_numbers(each.axis))
        limits = {"effort": joint.torque_limit, "velocity": joint.velocity_limit}
        if each.type != "continuous":
            limits |= {"lower": joint.lower, "upper": joint.upper}
        ET.SubElement(node, "limit", {name: f"{value:.9g}" for name, value in limits.items()})
    return ET.tostring(top, encoding="unicode")


def _numbers(values: Iterable[float]) -> str:
    return " ".join(f"{each + 0.0:.9g}" for each in values)
