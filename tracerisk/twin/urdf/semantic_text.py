"""What MoveIt knows a robot by, as an SRDF text: its groups, named states and end effectors."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from itertools import takewhile

from tracerisk.twin.robots.robot import Robot


def srdf_text(robot: Robot) -> str:
    """Return the semantic description of a robot, states in [rad or m]."""
    top = ET.Element("robot", name=robot.name)
    for name, group in robot.groups.items():
        node = ET.SubElement(top, "group", name=name)
        for joint in group.members or group.joints:
            ET.SubElement(node, "joint", name=joint)
        # Fixed joints behind the last one that moves: the tip is the link that they carry.
        fixed = takewhile(lambda one: one.type == "fixed", robot.above(group.tip_link or ""))
        for attachment in reversed([*fixed]):
            ET.SubElement(node, "joint", name=attachment.name)
    for group_name, states in robot.named_states.items():
        for name, positions in states.items():
            node = ET.SubElement(top, "group_state", name=name, group=group_name)
            for joint, value in positions.items():
                ET.SubElement(node, "joint", name=joint, value=f"{value:.9g}")
    hangs = {attachment.child: attachment.parent for attachment in robot.attachments}
    for gripper in robot.grippers:
        if gripper.group in robot.groups and gripper.pads:
            parent = hangs.get(gripper.pads[0], robot.base_link)
            ET.SubElement(
                top, "end_effector", name=gripper.name, group=gripper.group, parent_link=parent
            )
    for one, other in sorted(robot.disabled_collisions):
        ET.SubElement(top, "disable_collisions", link1=one, link2=other, reason="Never")
    return ET.tostring(top, encoding="unicode")
