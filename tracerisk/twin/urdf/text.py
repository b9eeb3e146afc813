"""A robot as a URDF text: its links, its joints and their limits, without shapes."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable

from tracerisk.twin.robots.robot import Robot


def urdf_text(robot: Robot) -> str:
    """Return the robot's description: frames [m, rad], limits [rad or m, and per s].

    Shapes, masses and inertia are left out: a reader of it plans with the joints.
    """
    top = ET.Element("robot", name=robot.name)
    joints = {joint.name: joint for joint in robot.joints}
    for link in robot.links:
        ET.SubElement(top, "link", name=link.name)
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
        ET.SubElement(node, "limit", {name: f"{value:.6g}" for name, value in limits.items()})
    return ET.tostring(top, encoding="unicode")


def _numbers(values: Iterable[float]) -> str:
    return " ".join(f"{each + 0.0:.6g}" for each in values)
