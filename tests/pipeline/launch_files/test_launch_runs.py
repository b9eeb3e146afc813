"""Controllers that need what their launch file gives them, run end to end."""

from dataclasses import replace

import pytest

from tracerisk.common import trace_json
from tracerisk.common.settings.project_settings import ProjectSettings
from tracerisk.config import Settings
from tracerisk.errors import SettingsError
from tracerisk.pipeline.freshness.run_inputs import run_inputs
from tracerisk.pipeline.workspace.controller import load_controller

PACKAGE = "<package><name>arm_task</name></package>\n"
ROS1 = """\
import os, sys
import moveit_commander, rospy

moveit_commander.roscpp_initialize(sys.argv)
rospy.init_node("turner")
arm = moveit_commander.MoveGroupCommander("panda_arm")
arm.set_max_velocity_scaling_factor(1.0)

def turn(angle):
    joints = arm.get_current_joint_values()
    joints[0] += angle
    arm.go(joints, wait=True)

turn(rospy.get_param("~angle"))
print(rospy.get_name(), rospy.myargv()[1:], rospy.get_param("/limits/speed"), os.environ["SIDE"])
print(rospy.resolve_name("goal"), rospy.get_param("~angle"), file=sys.stderr)
"""
LAUNCH1 = """\
<launch>
  <rosparam file="$(find arm_task)/config/limits.yaml" ns="limits"/>
  <node pkg="arm_task" type="turn.py" name="left_turner" args="--fast">
    <param name="angle" value="0.2"/>
    <remap from="goal" to="/left/goal"/>
    <env name="SIDE" value="left"/>
  </node>
</launch>
"""
ROS2 = """\
import rclpy
from builtin_interfaces.msg import Duration
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint


class Turner(Node):
    def __init__(self):
        super().__init__("turner")
        self.declare_parameter("joints", rclpy.Parameter.Type.STRING_ARRAY)
        self.declare_parameter("angle", 0.0)
        self.out = self.create_publisher(JointTrajectory, "goals", 1)
        self.create_timer(1.0, self.turn)

    def turn(self):
        joints = self.get_parameter("joints").value
        angle = self.get_parameter("angle").value
        self.get_logger().info(f"{self.get_fully_qualified_name()} turns by {angle}")
        others = [f"panda_joint{n}" for n in range(2, 8)]
        point = JointTrajectoryPoint(
            positions=[angle, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785],
            time_from_start=Duration(sec=1))
        self.out.publish(JointTrajectory(joint_names=[*joints, *others], points=[point]))
        self.destroy_timer(next(self.timers))


def main():
    rclpy.init()
    rclpy.spin(Turner())
"""
LAUNCH2 = """\
import os
from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def generate_launch_description():
    file = os.path.join(get_package_share_directory("arm_task"), "config", "turn.yaml")
    return LaunchDescription([
        DeclareLaunchArgument("angle", default_value="0.3"),
        Node(package="arm_task", executable="turn", namespace="left",
             parameters=[file, {"angle": LaunchConfiguration("angle")}],
             remappings=[("goals", "/panda_arm_controller/joint_trajectory")]),
    ])
"""
SETUP = 'setup(entry_points={"console_scripts": ["turn = arm_task.turn:main"]})\n'


@pytest.fixture
def ros1(example):
    example.write("package.xml", PACKAGE)
    example.write("scripts/turn.py", ROS1)
    example.write("config/limits.yaml", "speed: 1.5\n")
    example.write("launch/turn.launch", LAUNCH1)
    return example


def trace(example, script, *options, argv=()):
    run = ("trace", "-o", "trace.json", "--robot", "panda", *options, script)
    outcome = example.run(*run, *(["--", *argv] if argv else []))
    return outcome, trace_json.loads(example.read("trace.json").decode(), "trace.json")


def test_a_node_of_ros_1_has_all_that_its_launch_file_gives_it(ros1, capfd):
    outcome, found = trace(ros1, "scripts/turn.py")
    assert outcome.code == 0, outcome.err
    text = outcome.err + capfd.readouterr().err
    assert "/left_turner ['--fast'] 1.5 left" in text
    assert "/left/goal 0.2" in text
    assert found.inputs == ("config/limits.yaml", "launch/turn.launch")
    assert (
        "launch: parameters, arguments and remaps from launch/turn.launch (2 parameters, "
        "1 argument, 1 remap); --no-launch leaves them out"
    ) in found.assumptions


def test_the_users_own_parameters_go_before_those_of_the_launch_file(ros1, capfd):
    ros1.write("mine.yaml", "limits: {speed: 0.5}\n")
    outcome, _ = trace(
        ros1, "scripts/turn.py", "--params", "mine.yaml", argv=("_angle:=0.1", "--slow")
    )
    assert outcome.code == 0, outcome.err
    text = outcome.err + capfd.readouterr().err
    assert "['--slow'] 0.5 left" in text
    assert "/left/goal 0.1" in text


def test_without_the_launch_file_it_is_as_if_there_were_none(ros1):
    outcome, found = trace(ros1, "scripts/turn.py", "--no-launch", "--no-draft")
    assert outcome.code == 4
    assert "KeyError: '~angle'" in found.end.message
    assert found.inputs == ()
    assert not [line for line in found.assumptions if line.startswith("launch")]


def fingerprint(controller, trace, settings):
    return run_inputs(controller, trace, settings).fingerprint


def test_a_run_is_stale_when_a_file_that_gave_it_something_changes(ros1):
    _, found = trace(ros1, "scripts/turn.py")
    controller = load_controller(ros1.folder / "scripts/turn.py")
    before = fingerprint(controller, found, Settings())
    assert fingerprint(controller, found, Settings(launch=False)) != before
    ros1.write("config/limits.yaml", "speed: 1.6\n")
    after = fingerprint(controller, found, Settings())
    assert after != before
    ros1.write("launch/turn.launch", LAUNCH1.replace("0.2", "0.25"))
    assert fingerprint(controller, found, Settings()) not in (before, after)
    (ros1.folder / "launch/turn.launch").unlink()
    assert fingerprint(controller, found, Settings()) not in (before, after)
    assert fingerprint(controller, replace(found, inputs=()), Settings()) != before


def test_a_node_of_ros_2_has_all_that_its_launch_file_gives_it(example, capfd):
    example.write("package.xml", PACKAGE)
    example.write("setup.py", SETUP)
    example.write("arm_task/__init__.py", "")
    example.write("arm_task/turn.py", ROS2)
    example.write(
        "config/turn.yaml", "/**/turner:\n  ros__parameters: {joints: [panda_joint1], angle: 0.9}\n"
    )
    example.write("launch/turn.launch.py", LAUNCH2)
    outcome, found = trace(example, "arm_task/turn.py")
    assert outcome.code == 0, outcome.err
    assert "/left/turner turns by 0.3" in outcome.err + capfd.readouterr().err
    assert [function.ref.name for function in found.functions] == ["Turner.turn"]
    assert found.inputs == ("config/turn.yaml", "launch/turn.launch.py")


def test_a_launch_file_that_keeps_it_from_running_is_left_out(example):
    example.write("package.xml", PACKAGE)
    script = ROS1.replace('rospy.get_param("~angle")', '1 / rospy.get_param("~share", 5)')
    example.write("scripts/turn.py", "\n".join(script.splitlines()[:-2]) + "\n")
    node = '<node pkg="arm_task" type="turn.py" name="t"><param name="share" value="0"/></node>'
    example.write("launch/turn.launch", f"<launch>{node}</launch>")
    outcome, found = trace(example, "scripts/turn.py")
    assert outcome.code == 0, outcome.err
    assert found.inputs == ()
    assert (
        "launch: nothing is taken from launch/turn.launch: with it the run shows no risk (the "
        "controller raised ZeroDivisionError: division by zero); --launch FILE takes it"
    ) in found.assumptions
    launch = ("--launch", "launch/turn.launch", "--no-draft")
    outcome, found = trace(example, "scripts/turn.py", *launch)
    assert outcome.code == 4
    assert "ZeroDivisionError" in found.end.message


@pytest.mark.parametrize(
    ("line", "value"), [("false", False), ("true", True), ('"launch/a.launch"', "launch/a.launch")]
)
def test_the_project_can_settle_it(tmp_path, line, value):
    (tmp_path / "pyproject.toml").write_text(f"[tool.tracerisk]\nlaunch = {line}\n")
    settled = ProjectSettings(tmp_path).of().launch
    assert settled == (str(tmp_path / value) if isinstance(value, str) else value)


@pytest.mark.parametrize("line", ["3", '""', "[1]"])
def test_another_setting_is_an_error(tmp_path, line):
    (tmp_path / "pyproject.toml").write_text(f"[tool.tracerisk]\nlaunch = {line}\n")
    with pytest.raises(SettingsError, match="launch: expected a launch file, true or false, found"):
        ProjectSettings(tmp_path).of()


def test_one_may_not_name_a_launch_file_and_want_none(example):
    example.write("turn.py", "")
    outcome = example.run("trace", "turn.py", "--launch", "a", "--no-launch")
    assert outcome.code == 2
    assert "not allowed with argument" in outcome.err


def test_a_file_of_parameters_that_is_not_there_is_named_by_a_run_that_fails(ros1):
    load = '<rosparam command="load" file="$(find arm_task)/config/angles.yaml"/>'
    node = f'<node pkg="arm_task" type="turn.py" name="turner">{load}</node>'
    ros1.write("launch/turn.launch", f"<launch>{node}</launch>")
    outcome = ros1.run("run", "scripts/turn.py", "--no-draft")
    assert outcome.code == 4
    assert "launch/turn.launch:1 loads config/angles.yaml, which is not there" in outcome.err
    # The run without the launch file, which came to no more, prints nothing of its own.
    assert outcome.err.count("Traceback") == 1


def test_doctor_reports_the_launch_file_before_a_run(ros1):
    outcome = ros1.run("doctor", "scripts/turn.py", "--robot", "panda")
    assert (
        "launch: parameters, arguments and remaps from launch/turn.launch (2 param" in outcome.out
    )
    ros1.write("pyproject.toml", '[tool.tracerisk]\nlaunch = "launch/none.launch"\n')
    (ros1.folder / "package.xml").unlink()
    outcome = ros1.run("doctor", "scripts/turn.py", "--robot", "panda")
    assert "launch: not known: " in outcome.out
    assert "none.launch: the launch file cannot be read: No such file" in outcome.out
    ros1.write("pyproject.toml", "[tool.tracerisk]\nlaunch = false\n")
    outcome = ros1.run("doctor", "scripts/turn.py", "--robot", "panda")
    assert "launch: nothing from a launch file" in outcome.out
