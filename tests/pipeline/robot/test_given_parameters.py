"""Parameter files among a controller's own arguments say which robot it drives."""

from pathlib import Path

import pytest

from tracerisk import api
from tracerisk.config import Settings
from tracerisk.pipeline.launch.choose import choose_launch
from tracerisk.pipeline.robot.choice import choose_launched_robot

MOVER = """\
import rclpy
from rclpy.node import Node


class Mover(Node):
    def __init__(self):
        super().__init__("mover")
        self.declare_parameter("joints", [""])
"""
OF_AN_ARM = """\
import os
from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.substitutions import Command
from launch_ros.actions import Node

def generate_launch_description():
    here = get_package_share_directory("cell")
    config = os.path.join(here, "config", "{arm}")
    text = Command(["xacro ", os.path.join(here, "urdf", "{arm}.urdf.xacro")])
    return LaunchDescription([
        Node(package="controller_manager", executable="ros2_control_node",
             parameters=[{{"robot_description": text}}, os.path.join(config, "rates.yaml")]),
        {starts}
    ])
"""
STARTS = """Node(package="cell", executable="mover.py",
             parameters=[os.path.join(config, "start.yaml")]),"""


def arm_of(name: str, joints: int) -> str:
    parts = "".join(
        f'<link name="link{number}"/><joint name="joint{number}" type="revolute">'
        f'<parent link="link{number - 1}"/><child link="link{number}"/><axis xyz="0 0 1"/>'
        '<origin xyz="0 0 0.2"/><limit lower="-2" upper="2" velocity="1" effort="9"/></joint>'
        for number in range(1, joints + 1)
    )
    return f'<robot name="{name}"><link name="link0"/>{parts}</robot>'


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("args", "robot"),
    [
        ((), "short"),
        (("--ros-args", "--params-file", "config/long/pack.yaml"), "long"),
        (("--ros-args", "--params-file", "config/short/start.yaml"), "short"),
    ],
)
def test_a_parameter_file_of_the_arguments_says_which_launch_file_describes_the_robot(
    tmp_path, monkeypatch, args, robot
):
    (tmp_path / ".git").mkdir()
    files = {"package.xml": "<package><name>cell</name></package>", "mover.py": MOVER}
    for arm, joints, last in (("short", 5, STARTS), ("long", 6, "")):
        listed = ", ".join(f"joint{number}" for number in range(1, joints + 1))
        mine = f"mover:\n  ros__parameters:\n    joints: [{listed}]\n"
        files[f"urdf/{arm}.urdf.xacro"] = arm_of(arm, joints)
        files[f"launch/{arm}.launch.py"] = OF_AN_ARM.format(arm=arm, starts=last)
        files[f"config/{arm}/rates.yaml"] = "/**:\n  ros__parameters:\n    update_rate: 100\n"
        files[f"config/{arm}/start.yaml"] = files[f"config/{arm}/pack.yaml"] = mine
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    monkeypatch.chdir(tmp_path)
    controller, settings = api.load_controller(Path("mover.py")), Settings(args=args)
    launch = choose_launch(controller, settings)
    assert choose_launched_robot(controller, settings, launch).robot.name == robot
