"""Descriptions that need packages or arguments that are not there are read all the same."""

from pathlib import Path

import pytest

from tests.slow import slow_but_every
from tracerisk import api
from tracerisk.config import Settings
from tracerisk.pipeline.launch.choose import choose_launch
from tracerisk.pipeline.robot.choice import choose_launched_robot
from tracerisk.twin.motion.kinematics import Kinematics
from tracerisk.twin.physics.builder import compile_model
from tracerisk.twin.robots.robot import Robot

TOP = '<robot name="cell" xmlns:xacro="http://www.ros.org/wiki/xacro"><link name="world"/>'
INCLUDE = '<xacro:include filename="$(find {})/urdf/macros.xacro"/>'
ORIGIN = '<origin xyz="0 0 0.2" rpy="0 0 0"/>'
JOINTS = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")


def cell(top: Path, body: str, source: str = "import rospy\n", **files: str) -> Robot:
    """Return the robot of a controller beside a description that is one xacro file."""
    app, description = top / "app", top / "desc"
    for folder, name in ((app, "app"), (description, "desc")):
        folder.mkdir()
        needs = "<depend>desc</depend>" if folder == app else ""
        (folder / "package.xml").write_text(f"<package><name>{name}</name>{needs}</package>")
    (top / ".git").mkdir()
    (description / "cell.urdf.xacro").write_text(f"{TOP}{body}</robot>")
    for name, text in files.items():
        path = top / name.replace("__", "/").replace("_DOT_", ".")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    (app / "go.py").write_text(source)
    controller = api.load_controller(app / "go.py")
    launch = choose_launch(controller, Settings())
    return choose_launched_robot(controller, Settings(), launch).robot


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("package", "call", "joint", "shipped", "doubt"),
    [
        (
            "ur_description",
            f'<xacro:ur_robot name="ur5e" tf_prefix="left_" parent="world">{ORIGIN}</xacro:ur_robot>',
            "left_elbow_joint",
            "ur5e",
            "",
        ),
        (
            "ur_description",
            '<xacro:arg name="ur_type" default="ur10e"/><xacro:ur_robot name="ur" tf_prefix="" '
            'parent="world" kinematics="$(find ur_description)/config/$(arg ur_type)/k.yaml">'
            f"{ORIGIN}</xacro:ur_robot>",
            "elbow_joint",
            "ur10e",
            "",
        ),
        (
            "ur_description",
            '<xacro:arg name="ur_type" default="ur5"/><xacro:ur_robot name="ur" tf_prefix="" '
            'parent="world" kinematics="$(find ur_description)/config/$(arg ur_type)/k.yaml" '
            'safety_limits="true" safety_pos_margin="0.15" safety_k_position="20" '
            f'script_sender_port="50002" tool_baud_rate="115200">{ORIGIN}</xacro:ur_robot>',
            "elbow_joint",
            "ur5",
            "",
        ),
        (
            "ur_description",
            f'<xacro:ur_robot name="arm" tf_prefix="" parent="world">{ORIGIN}</xacro:ur_robot>',
            "elbow_joint",
            "ur5e",
            "the absent macro 'ur_robot' may be ur5",
        ),
        (
            "franka_description",
            '<xacro:franka_arm arm_id="fr3" limits="${xacro.load_yaml(\'$(find '
            'franka_description)/limits.yaml\')}"/><xacro:hand arm_id="fr3"/>',
            "fr3_joint1",
            "fr3",
            "",
        ),
        (
            "xarm_description",
            '<xacro:xarm_device prefix="a_" attach_to="world" xyz="0 0 0.2" dof="7" '
            'robot_type="xarm"/>',
            "a_joint7",
            "xarm7",
            "",
        ),
        (
            "kortex_description",
            '<xacro:load_robot parent="world" arm="gen3" dof="6" prefix="">'
            f"{ORIGIN}</xacro:load_robot>",
            "joint_6",
            "gen3_6dof",
            "",
        ),
        (
            "kortex_description",
            '<xacro:load_robot parent="world" arm="gen3_lite" dof="6" prefix="">'
            f"{ORIGIN}</xacro:load_robot>",
            "joint_6",
            "gen3_lite",
            "",
        ),
        (
            "iiwa_description",
            f'<xacro:iiwa7 robot_name="lwr" parent="world">{ORIGIN}</xacro:iiwa7>',
            "lwr_joint_1",
            "iiwa7_stack",
            "",
        ),
    ],
    ids=[
        *("name", "type", "gains and ports", "any of a maker", "its own name", "parts of a name"),
        *("number of joints", "variant", "prefix"),
    ],
)
def test_a_macro_of_an_absent_package_is_the_shipped_robot(
    tmp_path, package, call, joint, shipped, doubt
):
    robot = cell(tmp_path, INCLUDE.format(package) + call)
    assert robot.name == "cell"
    assert joint in {each.name for each in robot.arm_joints}
    assert f"is the shipped robot '{shipped}'" in " ".join(robot.assumed_figures)
    assert robot.doubt.startswith(doubt) if doubt else not robot.doubt
    compile_model(robot)


def test_the_shipped_robot_stands_where_the_call_puts_it(tmp_path):
    table = (
        '<link name="table"/><joint name="legs" type="fixed"><parent link="world"/>'
        '<child link="table"/><origin xyz="0 0 1"/></joint>'
    )
    call = f'<xacro:ur_robot name="ur5e" tf_prefix="" parent="table">{ORIGIN}</xacro:ur_robot>'
    robot = cell(tmp_path, INCLUDE.format("ur_description") + table + call)
    assert Kinematics(robot).forward({}, "base_link").position[2] == pytest.approx(1.2)


def test_what_is_no_arm_is_left_out_and_what_hangs_on_it_hangs_on_its_parent(tmp_path):
    body = (
        INCLUDE.format("ur_description")
        + INCLUDE.format("robotiq_description")
        + f'<xacro:ur_robot name="ur5e" tf_prefix="" parent="world">{ORIGIN}</xacro:ur_robot>'
        '<xacro:robotiq_gripper name="G" parent="tool0" prefix=""/><link name="tcp"/>'
        '<joint name="end" type="fixed"><parent link="robotiq_base"/><child link="tcp"/></joint>'
    )
    robot = cell(tmp_path, body)
    assert "macro 'robotiq_gripper'" in " ".join(robot.assumed_figures)
    assert "left out" in " ".join(robot.assumed_figures)
    frames = Kinematics(robot)
    assert frames.forward({}, "tcp").position == frames.forward({}, "tool0").position


def test_the_groups_of_an_srdf_are_those_of_the_shipped_robot_in_its_place(tmp_path):
    call = f'<xacro:ur_robot name="ur5e" tf_prefix="b_" parent="world">{ORIGIN}</xacro:ur_robot>'
    states = "".join(f'<joint name="b_{name}_joint" value="0.3"/>' for name in JOINTS)
    srdf = (
        '<robot name="cell"><group name="lifter"><chain base_link="b_base_link" '
        f'tip_link="b_tool0"/></group><group_state name="ready" group="lifter">{states}'
        "</group_state></robot>"
    )
    robot = cell(
        tmp_path,
        INCLUDE.format("ur_description") + call,
        'group = "lifter"\n',
        desc__cell_DOT_srdf=srdf,
    )
    assert robot.groups["lifter"].tip_link == "b_tool0"
    assert robot.named_states["lifter"]["ready"]["b_elbow_joint"] == 0.3


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("prefix", ["b_", ""])
def test_an_srdf_without_a_description_names_the_shipped_robot_by_its_joints(tmp_path, prefix):
    listed = "".join(f'<joint name="{prefix}{name}_joint"/>' for name in JOINTS)
    srdf = f'<robot name="ur5e_cell"><group name="lifter">{listed}</group></robot>'
    robot = cell(tmp_path, "", 'group = "lifter"\n', desc__cell_DOT_srdf=srdf)
    assert robot.name == "ur5e"
    assert robot.groups["lifter"].joints[0] == f"{prefix}shoulder_pan_joint"
    assert robot.doubt == ""


TWO_JOINTS = (
    '<link name="{0}a"/><joint name="{0}j1" type="revolute"><parent link="world"/>'
    '<child link="{0}a"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="9" velocity="1"/>'
    '</joint><link name="{0}b"/><joint name="{0}j2" type="revolute"><parent link="{0}a"/>'
    '<child link="{0}b"/><origin xyz="0 0 .3"/><axis xyz="0 1 0"/>'
    '<limit lower="-1" upper="1" effort="9" velocity="1"/></joint>'
).format("$(arg side)")
ROS1 = '<launch><param name="robot_description" command="xacro {} side:=left_"/></launch>'
ROS2 = """\
from launch import LaunchDescription
from launch.substitutions import Command
from launch_ros.actions import Node
from ament_index_python.packages import get_package_share_directory

def generate_launch_description():
    file = get_package_share_directory("desc") + "/{}"
    return LaunchDescription([Node(package="robot_state_publisher",
        executable="robot_state_publisher",
        parameters=[{{"robot_description": Command(["xacro ", file, " side:=left_"])}}])])
"""


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("source", "files", "joint", "doubt"),
    [
        ("import rospy\n", {}, "j1", "gives cell.urdf.xacro its side: taken for empty, or for 0"),
        (
            "import rospy\n",
            {"app__launch__a_DOT_launch": ROS1.format("$(find desc)/cell.urdf.xacro")},
            "left_j1",
            "",
        ),
        pytest.param(
            "import rclpy\n",
            {"app__launch__a_DOT_launch_DOT_py": ROS2.format("cell.urdf.xacro")},
            "left_j1",
            "",
            marks=pytest.mark.slow,
        ),
        # What a launch file gives another file of the robot.
        (
            "import rospy\n",
            {
                "app__launch__a_DOT_launch": ROS1.format("$(find desc)/other.urdf.xacro"),
                "desc__other_DOT_urdf_DOT_xacro": f"{TOP}</robot>",
            },
            "left_j1",
            "",
        ),
    ],
    ids=["none", "roslaunch", "launch of ROS 2", "another file"],
)
def test_an_argument_that_only_a_launch_file_gives_is_taken_from_it(
    tmp_path, source, files, joint, doubt
):
    robot = cell(tmp_path, TWO_JOINTS, source, **files)
    assert robot.arm_joints[0].name == joint
    assert doubt in robot.doubt if doubt else not robot.doubt


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(
    ("file", "joint", "shipped"),
    slow_but_every(
        3,
        [
            ("dobot_rviz)/urdf/nova5_robot.urdf", "joint6", "nova5"),
            ("moveit_resources_panda_description)/urdf/panda.urdf", "panda_joint7", "panda"),
            ("motoman_hc10_support)/urdf/hc10.xacro", "joint_6_t", "hc10"),
            ("my_cell)/urdf/ur10e.urdf.xacro", "elbow_joint", "ur10e"),
            ("tm_description)/xacro/robot.urdf.xacro", "joint_6", "tm5_900"),
        ],
    ),
)
def test_a_whole_robot_of_an_absent_package_is_the_shipped_one_that_its_file_names(
    tmp_path, file, joint, shipped
):
    robot = cell(tmp_path, f'<xacro:include filename="$(find {file}"/>')
    assert joint in {each.name for each in robot.arm_joints}
    assert f"is the shipped robot '{shipped}'" in " ".join(robot.assumed_figures)
    compile_model(robot)


@pytest.mark.slow
def test_a_whole_robot_hangs_where_a_joint_of_the_description_puts_it(tmp_path):
    body = (
        '<xacro:include filename="$(find ur_description)/urdf/ur5e.urdf.xacro"/>'
        '<joint name="stand" type="fixed"><parent link="world"/><child link="base_link"/>'
        '<origin xyz="0 0 0.7"/></joint>'
    )
    robot = cell(tmp_path, body)
    assert Kinematics(robot).forward({}, "base_link").position[2] == pytest.approx(0.7)


def test_a_file_of_an_absent_package_that_names_no_robot_is_no_robot(tmp_path):
    robot = cell(tmp_path, '<xacro:include filename="$(find a_cell)/urdf/my_arm.urdf"/>')
    assert robot.name == "generic"


def test_a_tool_of_a_makers_package_is_no_second_arm(tmp_path):
    own = TWO_JOINTS.replace("$(arg side)", "")
    tools = ("niryo_gripper_1", "niryo_camera", "tool_mount")
    calls = "".join(f'<xacro:{tool} prefix="{tool}_" parent="b"/>' for tool in tools)
    robot = cell(tmp_path, INCLUDE.format("niryo_one_description") + own + calls)
    assert [each.name for each in robot.arm_joints] == ["j1", "j2"]


def test_what_is_asked_of_an_argument_that_nothing_gives_is_answered_with_no(tmp_path):
    body = TWO_JOINTS.replace("$(arg side)", "")
    conditions = ("$(arg sim)", "${'$(arg sim)'}", "$(arg sim)  ")
    for number, condition in enumerate(conditions):
        body += f'<xacro:if value="{condition}"><link name="plugin_{number}"/></xacro:if>'
    robot = cell(tmp_path, body)
    assert not [name for name in robot.link_names if name.startswith("plugin")]
    assert "nothing here gives cell.urdf.xacro its sim" in robot.doubt


OLD = {
    "property": '<property name="up" value="0.3"/>',
    "macro": '<macro name="leg" params="to"><link name="${to}"/></macro><leg to="foot"/>',
    "condition": '<if value="1"><link name="foot"/></if>',
    "include": '<include filename="$(find desc)/legs.xacro"/>',
    "underscores": (
        '<xacro:property name="__up" value="0.3"/>'
        '<xacro:macro name="leg" params="to"><link name="${to}"/></xacro:macro>'
        "<xacro:leg to=\"${'foot' if __up else 1}\"/>"
    ),
    "block": (
        '<macro name="leg" params="*at"><link name="foot"/><joint name="f" type="fixed">'
        '<insert_block name="at"/><parent link="b"/><child link="foot"/></joint></macro>'
        '<leg><origin xyz="0 0 1"/></leg>'
    ),
}


@pytest.mark.slow(but=2)
@pytest.mark.parametrize("form", OLD)
def test_tags_of_xacro_without_their_prefix_are_read_as_up_to_melodic(tmp_path, form):
    own = TWO_JOINTS.replace("$(arg side)", "")
    foot = '<joint name="f" type="fixed"><parent link="b"/><child link="foot"/></joint>'
    is_placed = form in ("property", "block")
    used = own.replace("0 0 .3", "0 0 ${up}") if form == "property" else own
    legs = f'{TOP.partition("<link")[0]}<link name="foot"/></robot>'
    files = {"desc__legs_DOT_xacro": legs} if form == "include" else {}
    body = OLD[form] + used + ("" if is_placed else foot)
    robot = cell(tmp_path, body, **files)
    assert [each.name for each in robot.arm_joints] == ["j1", "j2"]
    assert ("foot" in robot.link_names) is (form != "property")
    assert any("forms of older releases" in each for each in robot.assumed_figures)


def test_an_srdf_goes_with_a_urdf_whose_gripper_is_of_an_absent_package(tmp_path):
    own = TWO_JOINTS.replace("$(arg side)", "")
    knuckles = "".join(f'<joint name="robotiq_{number}"/>' for number in range(9))
    srdf = (
        '<robot name="cell"><group name="reach"><joint name="j1"/><joint name="j2"/></group>'
        f'<group name="hand">{knuckles}</group></robot>'
    )
    call = '<xacro:robotiq_gripper parent="b"/>'
    robot = cell(
        tmp_path, INCLUDE.format("robotiq_description") + own + call, desc__cell_DOT_srdf=srdf
    )
    assert [each.name for each in robot.arm_joints] == ["j1", "j2"]
    assert "reach" in robot.groups
    assert "macro 'robotiq_gripper'" in " ".join(robot.assumed_figures)


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("command", "shipped"),
    [
        ("ros2 launch app cell.launch.py ur_type:=ur10e robot_ip:=<ip>", "ur10e"),
        ("ros2 launch app cell.launch.py \\\n  ur_type:=ur16e", "ur16e"),
        ("ros2 launch app cell.launch.py", "ur3e"),
        ("ros2 launch app other.launch.py ur_type:=ur10e", "ur3e"),
    ],
)
def test_the_command_of_a_readme_says_which_robot_a_launch_file_describes(
    tmp_path, command, shipped
):
    launch = """
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import Command, FindPackageShare, LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

def generate_launch_description():
    kind = LaunchConfiguration("ur_type")
    text = Command(["xacro ", FindPackageShare("desc"), "/cell.urdf.xacro ur_type:=", kind])
    publisher = Node(
        package="robot_state_publisher", executable="robot_state_publisher",
        parameters=[{"robot_description": text}],
    )
    return LaunchDescription([DeclareLaunchArgument("ur_type", default_value="ur3e"), publisher])
"""
    body = (
        f'<xacro:arg name="ur_type" default="ur5e"/>{INCLUDE.format("ur_description")}'
        '<xacro:ur_robot name="ur" tf_prefix="" parent="world" '
        f'model="$(arg ur_type)">{ORIGIN}</xacro:ur_robot>'
    )
    launch = launch.replace("Command, FindPackageShare, Launch", "Command, Launch")
    files = {"app__launch__cell_DOT_launch_DOT_py": launch, "README_DOT_md": f"{command}\n"}
    found = cell(tmp_path, body, "import rclpy\n", **files)
    assert f"is the shipped robot '{shipped}'" in " ".join(found.assumed_figures)
