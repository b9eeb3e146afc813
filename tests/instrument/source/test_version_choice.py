"""Which ROS a controller is of is told by what its own sources import."""

import pytest

from tracerisk.instrument.source.ros_version import ros_version


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ("import rospy\n", 1),
        ("import rclpy\nfrom rclpy.node import Node\n", 2),
        ("from control_msgs.action import GripperCommand\n", 2),
        ("from control_msgs import action\n", 2),
        ("from moveit.planning import MoveItPy\n", 2),
        ("import moveit_commander\nfrom robot.action import grasp\n", 1),
        ("from std_msgs.msg import String\n", 1),
        ("import rospy\nprint 'python 2'\n", 1),
        ("import os, rclpy\nprint 'python 2'\n", 2),
        ("def main():\n    import rclpy\n", 2),
    ],
)
def test_the_imports_decide(tmp_path, source, expected):
    script = tmp_path / "arm.py"
    script.write_text(source)
    assert ros_version(script, tmp_path) == expected


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ("#include <rclcpp/rclcpp.hpp>\n", 2),
        ('#include "rclcpp_action/client.hpp"\n', 2),
        ("#include <trajectory_msgs/msg/joint_trajectory.hpp>\n", 2),
        (
            "#include <ros/ros.h>\n#include <moveit/move_group_interface/move_group_interface.h>\n",
            1,
        ),
        ("#include <trajectory_msgs/JointTrajectory.h>\n", 1),
        ("// #include <rclcpp/rclcpp.hpp>\n#include <vector>\n", 1),
    ],
)
def test_the_headers_of_a_compiled_node_decide(tmp_path, source, expected):
    script = tmp_path / "arm.cpp"
    script.write_text(source)
    assert ros_version(script, tmp_path) == expected


def test_the_build_of_a_compiled_node_decides_where_its_headers_do_not(tmp_path):
    script = tmp_path / "arm.cpp"
    script.write_text('#include "arm.hpp"\n')
    manifest = tmp_path / "package.xml"
    manifest.write_text("<package><buildtool_depend>ament_cmake</buildtool_depend></package>\n")
    assert ros_version(script, tmp_path) == 2


def test_modules_of_the_workspace_decide_where_the_script_does_not(tmp_path):
    package = tmp_path / "arm" / "arm"
    package.mkdir(parents=True)
    (package / "__init__.py").write_text("")
    (package / "node.py").write_text("from . import wrapper\n")
    (package / "wrapper.py").write_text("import rclpy\n")
    script = tmp_path / "main.py"
    script.write_text("from arm.node import Arm\n")
    assert ros_version(script, tmp_path) == 2
