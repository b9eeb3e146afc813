"""The quick scan of the shipped robots tells what reading them tells."""

import pytest

from tracerisk.twin.robots.index import RobotNames, shipped_names
from tracerisk.twin.robots.robot import Robot, load_robot, robot_names


def names_in(robot: Robot) -> RobotNames:
    return RobotNames(
        name=robot.name,
        title=robot.title,
        aliases=robot.aliases,
        other_models=robot.other_models,
        source=robot.source,
        payload=robot.payload,
        links=robot.link_names,
        joints=tuple(joint.name for joint in robot.joints),
        arm_joints=tuple(joint.name for joint in robot.arm_joints),
        groups={name: group.joints for name, group in robot.groups.items()},
        grippers=tuple(gripper.name for gripper in robot.grippers),
        controllers=tuple(controller.name for controller in robot.controllers),
    )


def test_every_shipped_robot_is_there_once_and_in_order():
    assert tuple(each.name for each in shipped_names()) == robot_names()


@pytest.mark.parametrize("found", shipped_names(), ids=lambda found: found.name)
def test_scanning_a_file_says_what_reading_it_says(found: RobotNames):
    expected = names_in(load_robot(found.name))
    assert found == expected, "write the file as the other robots' files are written"
