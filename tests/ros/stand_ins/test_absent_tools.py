"""What a program asks of an installed ROS: its commands xacro and those that list, packages."""

import pytest

MANIFEST = "<package><name>cell</name></package>"
JOINT = (
    '<joint name="{}" type="revolute"><parent link="base"/><child link="arm"/>'
    '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
)
XACRO = (
    '<robot name="$(arg name)" xmlns:xacro="http://www.ros.org/wiki/xacro">'
    '<xacro:arg name="more" default="1"/><link name="base"/><link name="arm"/>{}</robot>'
)
PROGRAM = """\
import os, subprocess, sys
import moveit_commander, rospy
PATH = os.path.join(os.path.dirname(__file__), "cell.xacro")
moveit_commander.roscpp_initialize(sys.argv)
rospy.init_node("go")
ASKED
arm = moveit_commander.MoveGroupCommander("panda_arm")
arm.go([0.1, -0.785, 0, -2.356, 0, 1.571, 0.785], wait=True)
"""
STARTS = {
    "check_output": 'text = subprocess.check_output(["xacro", PATH, "name:=cell"], text=True)',
    "bytes": 'text = subprocess.check_output(["xacro", PATH, "name:=cell"]).decode()',
    "run": (
        'text = subprocess.run(f"ros2 run xacro xacro {PATH} name:=cell", shell=True, '
        "capture_output=True, text=True, check=True).stdout"
    ),
    "Popen": (
        'text = subprocess.Popen(["/opt/ros/noetic/bin/xacro", "--inorder", PATH, "name:=cell"], '
        "stdout=subprocess.PIPE).communicate()[0].decode()"
    ),
    "popen": 'text = os.popen(f"rosrun xacro xacro {PATH} name:=cell").read()',
    "a file": (
        'subprocess.check_call(["xacro", PATH, "name:=cell", "-o", "made.urdf"]); '
        'text = open("made.urdf").read()'
    ),
}


@pytest.fixture
def traced(example):
    def traced(*lines: str, joints: str = "", description: str = XACRO):
        example.write("cell/package.xml", MANIFEST)
        example.write("cell/cell.xacro", description.replace("{}", joints))
        example.write("cell/go.py", PROGRAM.replace("ASKED", "\n".join(lines)))
        ran = example.run("trace", "cell/go.py", "--robot", "panda", "--json", "--no-draft")
        verdict = ran.json["verdict"]
        return verdict["kind"], [each["words"] for each in verdict["reasons"]], ran.err

    return traced


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("start", STARTS.values(), ids=STARTS)
def test_the_command_xacro_is_answered_however_it_is_started(traced, start):
    check = "assert '<robot' in text and 'name=\"cell\"' in text, text"
    kind, reasons, said = traced(start, check, joints=JOINT.format("panda_joint1"))
    assert (kind, reasons) == ("complete", []), said


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    "lines",
    [
        'names = subprocess.check_output("rosnode list", shell=True).decode().split()\n'
        'assert "/move_group" in names, names',
        'names = os.popen("rostopic list").read().split()\nassert "/joint_states" in names, names',
        'names = subprocess.check_output(["rosservice", "list"], text=True).split()\n'
        'assert "/compute_ik" in names, names',
        "try:\n"
        '    subprocess.check_output("rosnode list --nope", shell=True)\n'
        "except subprocess.CalledProcessError as error:\n"
        "    assert error.returncode == 127, error\n"
        "else:\n"
        "    raise SystemExit(1)",
        'assert subprocess.call("ros2 node list", shell=True) == 127, "ROS 1 alone is installed"',
        "names, began = [], rospy.get_time()\n"
        'rospy.Timer(rospy.Duration(0.5), lambda _: names.append("/late"), oneshot=True)\n'
        'while "/late" not in names:\n'
        '    os.popen("rosnode list").read()\n'
        "assert 0.5 <= rospy.get_time() - began < 0.6",
    ],
    ids=["nodes", "topics", "services", "another", "of_ros_2", "again_and_again"],
)
def test_a_command_that_lists_the_running_system_is_answered(traced, lines):
    kind, reasons, said = traced(lines)
    assert (kind, reasons) == ("complete", []), said


def test_another_robot_that_xacro_makes_is_a_reason(traced):
    kind, reasons, _ = traced(STARTS["check_output"], joints=JOINT.format("gantry_x"))
    assert kind == "partial"
    assert reasons == [
        "xacro makes a robot of cell.xacro with gantry_x, and panda is simulated, which has no such "
        "joint"
    ]


@pytest.mark.slow
def test_a_file_that_cannot_be_expanded_is_answered_with_the_robot_that_is_simulated(traced):
    broken = XACRO.replace("{}", '<xacro:include filename="$(find ur_description)/ur.xacro"/>')
    check = "assert 'panda_joint1' in text, text"
    kind, reasons, said = traced(STARTS["run"], check, description=broken)
    assert kind == "partial", said
    assert "xacro cell.xacro is answered with panda, which is simulated" in reasons[0]


def test_other_commands_are_started_as_ever(traced):
    echo = 'text = subprocess.run(["echo", "xacro"], capture_output=True, text=True).stdout'
    assert traced(echo, "assert text == 'xacro\\n'")[0] == "complete"


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    "asked",
    [
        "from ament_index_python.packages import get_package_share_directory as of",
        "from ament_index_python import get_package_share_path as of",
        "import rospkg; of = rospkg.RosPack().get_path",
        "import roslib.packages; of = roslib.packages.get_pkg_dir",
    ],
)
def test_the_folder_of_a_makers_description_is_given_where_it_would_be(traced, asked):
    line = 'assert str(of("ur_description")) == "/absent/share/ur_description"'
    kind, reasons, said = traced(asked, line)
    assert kind == "partial", said
    assert reasons == [
        "package 'ur_description' is not here, and panda is simulated: its folder is given as "
        "/absent/share/ur_description, which holds no file"
    ]


def test_the_folder_of_any_other_package_that_is_not_here_is_not_given(traced):
    line = "from ament_index_python import get_package_share_path; get_package_share_path('mine')"
    assert traced(line)[0] == "faulted"


def test_an_argument_that_is_asked_for_in_an_expression_is_one_that_nothing_gives(tmp_path):
    from tracerisk.twin.urdf.xacro_files import LackingError, expanded_xacro

    path = tmp_path / "arm.xacro"
    path.write_text(XACRO.replace("$(arg name)", "${xacro.arg('name')}").replace("{}", ""))
    with pytest.raises(LackingError, match="nothing gives its argument name"):
        expanded_xacro(path, {})
    assert expanded_xacro(path, {}, may_lack=True).arguments == ("name",)
    assert b'name="cell"' in expanded_xacro(path, {}, arguments={"name": "cell"}).text
