"""The robot that the packages and launch files around a controller describe."""

import math

import numpy as np
import pytest

from tests.slow import slow_but
from tracerisk import api
from tracerisk.config import Settings
from tracerisk.pipeline.launch.choose import choose_launch
from tracerisk.pipeline.robot.choice import choose_launched_robot
from tracerisk.twin.motion.kinematics import Kinematics

XACRO = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
# Of each joint: origin [m], roll-pitch-yaw [rad], axis. An arm of seven joints, made for this.
CHAIN = (
    ((0.0, 0.0, 0.12), (0.0, 0.0, 0.0), (0, 0, 1)),
    ((0.03, 0.0, 0.06), (math.pi / 2, 0.1, 0.0), (-1, 0, 0)),
    ((0.0, 0.07, 0.0), (0.0, -0.3, 0.2), (0, 0, 1)),
    ((-0.03, 0.0, 0.154), (0.0, 0.0, 0.4), (0, 1, 0)),
    ((0.03, 0.03, 0.096), (0.7, 0.0, 0.0), (0, 0, 1)),
    ((0.04, 0.0, 0.12), (0.0, 1.2, -0.5), (1, 0, 0)),
    ((-0.04, 0.01, 0.05), (0.0, 0.0, 0.9), (0, 1, 0)),
)
TOOL = ((0.0, 0.002, 0.18), (0.0, 0.0, 0.3))


def triple(values):
    return " ".join(map(repr, values))


def segments():
    """Macro calls that make `<prefix>joint1` and so on; numbers stand in a file of their own."""
    lines = [
        f'<xacro:segment n="{n}" parent="{n - 1}" xyz="{triple(xyz)}" rpy="{triple(rpy)}" '
        f'axis="{triple(axis)}"/>'
        for n, (xyz, rpy, axis) in enumerate(CHAIN, 1)
    ]
    return "\n".join(lines)


MACROS = f"""\
<robot {XACRO}>
  <xacro:macro name="segment" params="n parent xyz rpy axis">
    <link name="${{prefix}}link${{n}}"><inertial><mass value="0.5"/>
      <inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <joint name="${{prefix}}joint${{n}}" type="revolute">
      <parent link="${{prefix}}link${{parent}}"/><child link="${{prefix}}link${{n}}"/>
      <origin xyz="${{xyz}}" rpy="${{rpy}}"/><axis xyz="${{axis}}"/>
      <limit lower="-2.5" upper="2.5" effort="40" velocity="2"/>
    </joint>
  </xacro:macro>
</robot>
"""


def arm(package="feeder_description", default="feeder_"):
    return f"""\
<robot name="feeder" {XACRO}>
  <xacro:arg name="prefix" default="{default}"/>
  <xacro:property name="prefix" value="$(arg prefix)"/>
  <xacro:include filename="$(find {package})/urdf/parts/segment.xacro"/>
  <link name="${{prefix}}link0"/>
  {segments()}
  <link name="${{prefix}}tcp"/>
  <joint name="${{prefix}}tcp_joint" type="fixed">
    <parent link="${{prefix}}link7"/><child link="${{prefix}}tcp"/>
    <origin xyz="{triple(TOOL[0])}" rpy="{triple(TOOL[1])}"/>
  </joint>
</robot>
"""


def package(folder, name, *needs):
    folder.mkdir(parents=True)
    depends = "".join(f"<exec_depend>{each}</exec_depend>" for each in needs)
    (folder / "package.xml").write_text(f"<package><name>{name}</name>{depends}</package>")
    return folder


def described(top, name="feeder_description", default="feeder_"):
    """The package of the arm, whose names a prefix makes in a file that is included."""
    parts = package(top / name, name) / "urdf" / "parts"
    parts.mkdir(parents=True)
    (parts / "segment.xacro").write_text(MACROS)
    (parts.parent / "feeder.urdf.xacro").write_text(arm(name, default))
    return top / name


def joints(prefix="feeder_"):
    return [f"{prefix}joint{number}" for number in range(1, 8)]


FEEDER = """\
import rclpy
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectoryPoint


class Feeder(Node):
    def __init__(self):
        super().__init__("feeder")
        self.joints = self.declare_parameter("joints", [""]).value
        self.arm = ActionClient(self, FollowJointTrajectory, "arm/follow_joint_trajectory")

    def feed(self):
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = self.joints
        point = JointTrajectoryPoint(positions=[0.3] * len(self.joints))
        point.time_from_start.sec = 2
        goal.trajectory.points = [point]
        self.arm.wait_for_server()
        sent = self.arm.send_goal_async(goal)
        rclpy.spin_until_future_complete(self, sent)
        rclpy.spin_until_future_complete(self, sent.result().get_result_async())


def main():
    rclpy.init()
    Feeder().feed()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
"""
LAUNCH = """\
import os
from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch_ros.actions import Node

def generate_launch_description():
    params = os.path.join(get_package_share_directory("cell"), "config", "cell.yaml")
    return LaunchDescription([Node(package="cell", executable="feeder.py", parameters=[params])])
"""


def cell(top, source=FEEDER, *needs, name="feeder.py"):
    """A package whose launch file gives the joints of a description that its manifest names."""
    folder = package(top / "cell", "cell", *needs)
    (top / ".git").mkdir(exist_ok=True)
    for each in ("config", "launch"):
        (folder / each).mkdir()
    script = folder / name
    script.write_text(source)
    return script


def with_joints(script, names):
    listed = ", ".join(names)
    (script.parent / "config" / "cell.yaml").write_text(
        f"feeder:\n  ros__parameters:\n    joints: [{listed}]\n"
    )
    (script.parent / "launch" / "cell.launch.py").write_text(LAUNCH)


def chosen(script):
    controller = api.load_controller(script)
    launch = choose_launch(controller, Settings())
    return choose_launched_robot(controller, Settings(), launch)


def turned(axis, angle):
    """Return the rotation about an axis, by Rodrigues' formula."""
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross


def rolled(rpy):
    return turned((0, 0, 1), rpy[2]) @ turned((0, 1, 0), rpy[1]) @ turned((1, 0, 0), rpy[0])


def tool_at(angles):
    """Return where the tool of the chain is, computed from the figures alone."""
    place, turn = np.zeros(3), np.eye(3)
    for (xyz, rpy, axis), angle in zip(CHAIN, angles, strict=True):
        place, turn = place + turn @ xyz, turn @ rolled(rpy) @ turned(axis, angle)
    return place + turn @ TOOL[0]


def test_an_arm_of_prefix_made_names_is_the_right_one_to_a_tenth_of_a_millimetre(tmp_path):
    described(tmp_path)
    script = cell(tmp_path, FEEDER, "feeder_description")
    with_joints(script, joints())
    choice = chosen(script)
    assert [joint.name for joint in choice.robot.arm_joints] == joints()
    assert "feeder.urdf.xacro in the workspace" in choice.robot.chosen_by
    assert {path.name for path in choice.files} == {"feeder.urdf.xacro", "segment.xacro"}
    kinematics = Kinematics(choice.robot)
    for angles in np.random.default_rng(7).uniform(-2.4, 2.4, (60, 7)):
        found = kinematics.forward(dict(zip(joints(), angles, strict=True)), "feeder_tcp")
        assert np.linalg.norm(np.array(found.position) - tool_at(angles)) < 1e-4  # [m]


@pytest.mark.slow
def test_the_arm_of_prefix_made_names_runs(tmp_path):
    """Slow: it runs below as well, where the prefix is left out and where it is run alone."""
    described(tmp_path)
    script = cell(tmp_path, FEEDER, "feeder_description")
    with_joints(script, joints())
    trace = api.trace_controller(api.load_controller(script), Settings())
    assert [function.ref.name for function in trace.functions] == ["Feeder.feed"]
    moved = {
        name
        for name, exposure in trace.active.items()
        if exposure.moving_s > 0.5 and "/" not in name
    }
    assert moved == set(joints())


XACRO_LAUNCHES = {
    "robot.launch.py": """\
import os
from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import Command, LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

def generate_launch_description():
    file = os.path.join(
        get_package_share_directory("feeder_description"), "urdf", "feeder.urdf.xacro")
    text = Command(["xacro ", file, " prefix:=", LaunchConfiguration("arm"), "_"])
    return LaunchDescription([
        DeclareLaunchArgument("arm", default_value="west"),
        Node(package="robot_state_publisher", executable="robot_state_publisher",
             parameters=[{"robot_description": ParameterValue(text, value_type=str)}]),
        Node(package="cell", executable="feeder.py"),
    ])
""",
    "process.launch.py": """\
import os
import xacro
from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch_ros.actions import Node

def generate_launch_description():
    folder = get_package_share_directory("feeder_description")
    file = os.path.join(folder, "urdf", "feeder.urdf.xacro")
    text = xacro.process_file(file, mappings={"prefix": "west_"}).toxml()
    return LaunchDescription([
        Node(package="robot_state_publisher", executable="robot_state_publisher",
             parameters=[{"robot_description": text}]),
        Node(package="cell", executable="feeder.py"),
    ])
""",
    "robot.launch.xml": """\
<launch>
  <arg name="arm" default="west"/>
  <node pkg="robot_state_publisher" exec="robot_state_publisher">
    <param name="robot_description" value="$(command 'xacro
      $(find-pkg-share feeder_description)/urdf/feeder.urdf.xacro prefix:=$(var arm)_')"/>
  </node>
  <node pkg="cell" exec="feeder.py"/>
</launch>
""",
    "robot.launch": """\
<launch>
  <arg name="arm" default="west"/>
  <param name="robot_description" command="$(find xacro)/xacro --inorder
    '$(find feeder_description)/urdf/feeder.urdf.xacro' prefix:=$(arg arm)_"/>
  <node pkg="cell" type="feeder.py" name="feeder"/>
</launch>
""",
}
XACRO_LAUNCHES["moveit.launch.py"] = """\
import os
from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from moveit_configs_utils import MoveItConfigsBuilder

def generate_launch_description():
    file = os.path.join(
        get_package_share_directory("feeder_description"), "urdf", "feeder.urdf.xacro")
    configs = MoveItConfigsBuilder("feeder").robot_description(
        file, mappings={"prefix": LaunchConfiguration("prefix")})
    return LaunchDescription([
        DeclareLaunchArgument("prefix", default_value="west_"),
        Node(package="cell", executable="feeder.py", parameters=[configs.to_dict()]),
    ])
"""
WITHOUT_NAMES = {
    True: "import rospy\nrospy.init_node('feeder')\n",
    False: "import rclpy\nrclpy.init()\nrclpy.create_node('feeder')\n",
}


# What a launch file of ROS 1 says is the choice between several arms below, too; that XML has all
# that Python has, `launch/test_launch_child.py` shows.
@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    "file",
    slow_but(["robot.launch.py", "moveit.launch.py"], [*XACRO_LAUNCHES]),
)
def test_the_launch_file_that_starts_it_says_the_robot_and_its_arguments(tmp_path, file):
    described(tmp_path)
    described(tmp_path, "another_description", "other_")
    script = cell(tmp_path, WITHOUT_NAMES[file == "robot.launch"])
    (script.parent / "launch" / file).write_text(XACRO_LAUNCHES[file])
    robot = chosen(script).robot
    assert [joint.name for joint in robot.arm_joints] == joints("west_")
    assert f"by launch/{file}" in robot.chosen_by


def test_a_package_that_its_launch_file_names_and_is_not_there_is_reported(tmp_path):
    script = cell(tmp_path, WITHOUT_NAMES[True])
    (script.parent / "launch" / "robot.launch").write_text(XACRO_LAUNCHES["robot.launch"])
    robot = chosen(script).robot
    assert robot.name == "generic"
    assert "launch/robot.launch: package 'feeder_description' is not here" in robot.chosen_by
    assert "put what is missing into the workspace" in robot.chosen_by


def test_a_package_that_a_xacro_file_needs_and_is_not_there_is_reported(tmp_path):
    folder = described(tmp_path)
    (folder / "urdf" / "feeder.urdf.xacro").write_text(arm("common_parts"))
    script = cell(tmp_path, f"joints = {joints()}\n", "feeder_description")
    robot = chosen(script).robot
    assert "'common_parts' is neither in the workspace nor installed" in robot.chosen_by
    assert [joint.name for joint in robot.arm_joints] == joints()


def test_a_robot_whose_macros_want_its_name_is_read(tmp_path):
    folder = described(tmp_path)
    text = arm().replace('name="feeder"', 'name="$(arg name)"')
    (folder / "urdf" / "feeder.urdf.xacro").write_text(text)
    script = cell(tmp_path, f"joints = {joints()}\n", "feeder_description")
    robot = chosen(script).robot
    assert robot.name == "feeder"
    assert [joint.name for joint in robot.arm_joints] == joints()


SRDF = """\
<robot name="{name}">
  <group name="arm">{joints}</group>
</robot>
"""


def moveit(top, names, name="feeder"):
    own = f"{name}_moveit_config"
    folder = package(top / own, own, f"{name}_description") / "config"
    folder.mkdir()
    listed = "".join(f'<joint name="{each}"/>' for each in names)
    (folder / f"{name}.srdf").write_text(SRDF.format(name=name, joints=listed))
    return folder


def test_an_srdf_whose_robot_is_not_there_gives_a_stand_in_its_names(tmp_path):
    config = moveit(tmp_path, joints())
    script = cell(tmp_path, 'group = "arm"\n')
    robot = chosen(script).robot
    assert "feeder.srdf: no URDF or known robot has its joints" in robot.chosen_by
    assert [joint.name for joint in robot.arm_joints] == joints()
    (config.parent / ".setup_assistant").write_text(
        "moveit_setup_assistant_config:\n  URDF:\n    package: feeder_description\n"
        "    relative_path: urdf/feeder.urdf.xacro\n"
    )
    assert "package 'feeder_description', which describes them" in chosen(script).robot.chosen_by


def test_joints_speak_louder_than_the_groups_of_another_robot(tmp_path):
    described(tmp_path)
    described(tmp_path, "another_description", "other_")
    moveit(tmp_path, joints("other_"))
    script = cell(tmp_path, f'group = "arm"\njoints = {joints()}\n', "feeder_description")
    robot = chosen(script).robot
    assert [joint.name for joint in robot.arm_joints] == joints()


def test_a_prefix_before_all_joints_of_the_workspaces_robot_is_its_prefix(tmp_path):
    described(tmp_path)
    script = cell(tmp_path, f"joints = {joints('cell2_feeder_')}\n", "feeder_description")
    robot = chosen(script).robot
    assert [joint.name for joint in robot.arm_joints] == joints("cell2_feeder_")
    assert "all with the prefix 'cell2_'" in robot.chosen_by


@pytest.mark.slow
def test_programs_of_one_folder_drive_one_robot(tmp_path):
    described(tmp_path)
    described(tmp_path, "another_description", "other_")
    script = cell(tmp_path, "import rospy\nrospy.init_node('rest')\n", "feeder_description")
    (script.parent / "work.py").write_text(f"joints = {joints()}\n")
    robot = chosen(script).robot
    assert [joint.name for joint in robot.arm_joints] == joints()
    assert "as programs beside it do" in robot.chosen_by
    # Where these drive several, none of them is meant.
    (script.parent / "work.py").write_text(f"joints = {joints()[:3]}\n")
    (script.parent / "other.py").write_text('names = ["panda_joint1", "panda_joint2"]\n')
    (script.parent / "third.py").write_text(
        'names = ["shoulder_pan_joint", "elbow_joint", "wrist_1_joint"]  # ur5e\n'
    )
    (script.parent / "work.py").unlink()
    assert chosen(script).robot.name == "generic"


# The one of which the name comes later: without a word of it, the first would be chosen.
@pytest.mark.parametrize("word", ["feeder", pytest.param("another", marks=pytest.mark.slow)])
def test_of_robots_with_the_same_groups_the_files_name_says_one(tmp_path, word):
    for name in ("another", "feeder"):
        described(tmp_path, f"{name}_description", f"{name}_")
        moveit(tmp_path, joints(f"{name}_"), name)
    script = cell(tmp_path, 'group = "arm"\n', name=f"move_{word}_up.py")
    found = [joint.name for joint in chosen(script).robot.arm_joints]
    assert found == joints(f"{word}_")


THING = '<robot name="table"><link name="top"/></robot>'


def test_a_thing_that_its_launch_file_loads_is_no_robot_that_cannot_be_read(tmp_path):
    folder = package(tmp_path / "things", "things")
    (folder / "table.urdf").write_text(THING)
    (folder / "legs.urdf").write_text(THING.replace('<link name="top"/>', ""))
    script = cell(tmp_path, WITHOUT_NAMES[True])
    (script.parent / "launch" / "robot.launch").write_text(
        '<launch><param name="table" textfile="$(find things)/table.urdf"/>'
        '<param name="legs" textfile="$(find things)/legs.urdf"/>'
        '<node pkg="cell" type="feeder.py" name="feeder"/></launch>'
    )
    choice = chosen(script)
    assert choice.robot.name == "generic"
    assert any("table.urdf: has no joint that moves" in each for each in choice.skipped)
    assert any("has no link" in each for each in choice.skipped)


@pytest.mark.parametrize("is_known", [True, False])
def test_a_program_beside_it_says_the_shipped_robot(tmp_path, is_known):
    script = cell(tmp_path, 'group = "nothing"\n')
    (script.parent / "other.py").write_text(
        'names = ["panda_joint1", "panda_joint2"]\n' if is_known else "def broken(:\n"
    )
    assert chosen(script).robot.name == ("panda" if is_known else "generic")


def test_a_robot_that_cannot_be_read_gives_way_to_none_of_which_only_the_name_is_named(tmp_path):
    moveit(tmp_path, joints())
    script = cell(tmp_path, 'group = "arm"\nname = "the panda of hall 3"\n')
    robot = chosen(script).robot
    assert robot.name == "generic"
    assert "no URDF or known robot has its joints" in robot.chosen_by


TWO = f"""\
<robot name="pair" {XACRO}>
  <link name="torso"/>
  <xacro:macro name="limb" params="side reflect">
    <link name="${{side}}_upper"/><link name="${{side}}_lower"/>
    <joint name="${{side}}_shoulder" type="revolute">
      <parent link="torso"/><child link="${{side}}_upper"/>
      <origin xyz="0 ${{reflect * 0.2}} 0.5"/><axis xyz="0 1 0"/>
      <limit lower="-2" upper="2" effort="60" velocity="2"/>
    </joint>
    <joint name="${{side}}_elbow" type="revolute">
      <parent link="${{side}}_upper"/><child link="${{side}}_lower"/>
      <origin xyz="0 0 0.3"/><axis xyz="0 1 0"/>
      <limit lower="-2" upper="2" effort="30" velocity="2"/>
    </joint>
  </xacro:macro>
  <xacro:limb side="left" reflect="1"/>
  <xacro:limb side="right" reflect="-1"/>
</robot>
"""
TWO_SRDF = """\
<robot name="pair">
  <group name="left_limb"><chain base_link="torso" tip_link="left_lower"/></group>
  <group name="right_limb"><chain base_link="torso" tip_link="right_lower"/></group>
  <group name="both"><group name="left_limb"/><group name="right_limb"/></group>
</robot>
"""


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("has_groups", [True, False])
def test_two_arms_of_one_macro_are_one_robot_with_a_group_each(tmp_path, has_groups):
    folder = package(tmp_path / "pair_description", "pair_description")
    (folder / "pair.urdf.xacro").write_text(TWO)
    if has_groups:
        (folder / "pair.srdf").write_text(TWO_SRDF)
    script = cell(
        tmp_path,
        'sides = ["left_shoulder", "left_elbow", "right_shoulder", "right_elbow"]\n',
        "pair_description",
    )
    robot = chosen(script).robot
    left, right = ("left_limb", "right_limb") if has_groups else ("arm", "arm_2")
    assert robot.groups[left].joints == ("left_shoulder", "left_elbow")
    assert robot.groups[right].joints == ("right_shoulder", "right_elbow")
    straight = Kinematics(robot).forward({}, "right_lower").position
    assert straight == pytest.approx((0.0, -0.2, 0.8), abs=1e-6)
    if has_groups:
        assert len(robot.groups["both"].joints) == 4


ALONE = """\
import rospy
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

rospy.init_node("wave")
name = "arm"
joints = rospy.get_param("/%s_controller/joints" % name)
topic = rospy.Publisher(f"/{name}_controller/command", JointTrajectory, queue_size=1)
rospy.sleep(0.5)


def wave():
    goal = JointTrajectory(joint_names=joints)
    goal.points = [JointTrajectoryPoint(positions=[0.4] * len(joints))]
    goal.points[0].time_from_start = rospy.Duration(1.0)
    topic.publish(goal)
    rospy.sleep(2.0)


wave()
"""
CONTROLLERS = "arm_controller:\n  type: position_controllers/JointTrajectoryController\n"


def bringup(top, names, ways):
    folder = package(top / "bringup", "bringup", "feeder_description")
    listed = "\n".join(f"    - {each}" for each in names)
    (folder / "config").mkdir()
    (folder / "config" / "arm.yaml").write_text(f"{CONTROLLERS}  joints:\n{listed}\n")
    if ways == "launch":
        (folder / "launch").mkdir()
        (folder / "launch" / "robot.launch").write_text(
            '<launch><rosparam file="$(find bringup)/config/arm.yaml" command="load"/>\n'
            '<node pkg="controller_manager" type="spawner" name="s" args="arm_controller"/></launch>'
        )
    return folder


@pytest.mark.parametrize("ways", slow_but(("launch",), ("launch", "yaml")))
def test_a_controller_run_alone_finds_the_parameters_of_the_controllers(tmp_path, ways):
    described(tmp_path)
    bringup(tmp_path, joints(), ways)
    script = cell(tmp_path, ALONE, "feeder_description", name="wave.py")
    controller = api.load_controller(script)
    trace = api.trace_controller(controller, Settings(robot=None))
    assert trace.end.cause == "ended"
    assert [function.ref.name for function in trace.functions] == ["wave"]
    file = "../bringup/launch/robot.launch" if ways == "launch" else "../bringup/config/arm.yaml"
    assert any(
        f"launch: parameter /arm_controller/joints from {file}" in line
        for line in trace.assumptions
    )
    assert "../bringup/config/arm.yaml" in trace.inputs


# Without launch files nothing is chosen: `launch/test_choose.py`.
@pytest.mark.slow
def test_without_launch_files_a_controller_run_alone_finds_no_parameters(tmp_path):
    described(tmp_path)
    bringup(tmp_path, joints(), "launch")
    script = cell(tmp_path, ALONE, "feeder_description", name="wave.py")
    trace = api.trace_controller(
        api.load_controller(script), Settings(launch=False, robot="generic")
    )
    assert trace.end.cause == "raised"
    assert "/arm_controller/joints" in trace.end.message


def test_a_prefix_that_the_controller_leaves_out_makes_no_other_robot_of_it(tmp_path):
    """Its description gives a prefix by default, and no launch file says that there is none."""
    described(tmp_path)
    script = cell(tmp_path, f"joints = {joints('')}\n", "feeder_description")
    choice = chosen(script)
    assert [joint.name for joint in choice.robot.arm_joints] == joints("")
    assert "tcp" in choice.robot.link_names
    assert "feeder.urdf.xacro in the workspace" in choice.robot.chosen_by
    assert choice.robot.doubt == "the controller names its joints without the prefix 'feeder_'"


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("names", [joints("")[:6], [*joints("")[:6], "joint9"]])
def test_an_arm_of_other_joints_is_not_that_of_the_workspace(tmp_path, names):
    described(tmp_path)
    script = cell(tmp_path, f"joints = {names}\n", "feeder_description")
    assert chosen(script).robot.name == "generic"


@pytest.mark.slow
def test_a_robot_whose_prefix_is_left_out_is_assumed_and_moves(tmp_path):
    described(tmp_path)
    # The names are made in the run: it shows them.
    source = FEEDER.replace(
        'self.declare_parameter("joints", [""]).value', '[f"joint{n}" for n in range(1, 8)]'
    )
    script = cell(tmp_path, source, "feeder_description")
    trace = api.trace_controller(api.load_controller(script), Settings())
    assert trace.verdict.kind == "partial"
    (reason,) = [each for each in trace.verdict.reasons if each.code == "robot-assumed"]
    assert "without the prefix 'feeder_'" in reason.words
    moved = {name for name, each in trace.active.items() if each.moving_s > 0.5 and "/" not in name}
    assert moved == set(joints(""))


@pytest.mark.slow
@pytest.mark.parametrize(
    "others",
    [pytest.param(("long",), marks=pytest.mark.slow), ("copy",), ("long", "copy")],
)
def test_of_several_arms_that_fit_as_well_the_choice_is_reported(tmp_path, others):
    urdf = described(tmp_path, default="") / "urdf"
    for name in others:
        text = arm(default="")
        longer = text.replace('xyz="0.0 0.07 0.0"', 'xyz="0.0 0.09 0.0"')
        (urdf / f"{name}.urdf.xacro").write_text(longer if name == "long" else text)
    script = cell(tmp_path, f"joints = {joints('')}\n", "feeder_description")
    doubt = chosen(script).robot.doubt
    assert ("would fit as well" in doubt) == ("long" in others)
    # A launch file says which it is.
    launch = XACRO_LAUNCHES["robot.launch"].replace("prefix:=$(arg arm)_", "prefix:=")
    (script.parent / "launch" / "robot.launch").write_text(launch)
    script.write_text(f"import rospy\njoints = {joints('')}\n")
    assert chosen(script).robot.doubt == ""
