"""Every message, service and action of the vendors' packages can be made."""

from __future__ import annotations

import pytest

from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.messages.ros2 import Interfaces2

ROS1 = [
    "baxter_core_msgs",
    "baxter_maintenance_msgs",
    "franka_control",
    "gazebo_msgs",
    "gazebo_ros_link_attacher",
    "grasping_msgs",
    "interbotix_perception_modules",
    "interbotix_xs_msgs",
    "intera_core_msgs",
    "intera_motion_msgs",
    "kortex_driver",
    "niryo_robot_arm_commander",
    "niryo_robot_msgs",
    "niryo_robot_poses_handlers",
    "niryo_robot_rpi",
    "niryo_robot_tools_commander",
    "ur_msgs",
    "xarm_msgs",
]
ROS2 = [
    "dobot_msgs_v4",
    "dsr_msgs2",
    "gazebo_msgs",
    "gazebo_ros_link_attacher",
    "interbotix_perception_msgs",
    "interbotix_xs_msgs",
    "linkattacher_msgs",
    "ros_gz_interfaces",
    "ur_msgs",
    "xarm_msgs",
]


@pytest.mark.parametrize("package", ROS1)
def test_messages_of_ros_1(package):
    interfaces = Interfaces()
    messages, services = interfaces.message_names(package), interfaces.service_names(package)
    assert messages or services
    for name in messages:
        assert interfaces.message(f"{package}/{name}")()._type == f"{package}/{name}"
    for name in services:
        assert interfaces.service(f"{package}/{name}")._request_class()


@pytest.mark.parametrize("package", ROS2)
def test_messages_of_ros_2(package):
    interfaces = Interfaces2()
    messages, services = interfaces.message_names(package), interfaces.service_names(package)
    assert messages or services
    for name in messages:
        assert interfaces.message(f"{package}/{name}")()
    for name in services:
        kind = interfaces.service(f"{package}/{name}")
        assert kind.Request() is not kind.Response()


def test_fields_have_the_defaults_that_their_definition_gives():
    request = Interfaces2().service("xarm_msgs/MoveJoint").Request()
    assert (request.wait, request.timeout, request.radius) == (False, -1.0, -1.0)
