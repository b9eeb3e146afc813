"""Which launch file a controller is run with, and what is said of it."""

import re

import pytest

from tracerisk.errors import InputError
from tracerisk.pipeline.launch_files.records import LaunchSetup

ROS1 = """\
import rospy
rospy.init_node("pick")
speed = rospy.get_param("~speed")
arm = rospy.get_param("/arm", "left")
"""
ROS2 = """\
import rclpy
from rclpy.node import Node


class Pick(Node):
    def __init__(self):
        super().__init__("pick")
        self.declare_parameter("speed", 1.0)
        self.declare_parameters("", [("side", "left"), ("goal", 0.0)])


def main():
    rclpy.init()
    rclpy.spin(Pick())
"""
SETUP = 'setup(entry_points={"console_scripts": ["picker = arm_task.pick:main"]})\n'
NODE1 = '<launch><node pkg="arm_task" type="pick.py" name="{}">{}</node></launch>'
SPEED1 = '<param name="speed" value="{}"/>'
LAUNCH2 = """\
from launch import LaunchDescription
from launch_ros.actions import Node

def generate_launch_description():
    return LaunchDescription([Node(package="arm_task", executable="{}", name="{}", {})])
"""


@pytest.fixture
def ros2(workspace):
    workspace.write("setup.py", SETUP)
    workspace.write("arm_task/__init__.py", "")
    workspace.write("arm_task/pick.py", ROS2)
    return workspace


def test_the_one_launch_file_that_starts_it_is_taken_and_reported(workspace, given):
    workspace.write("scripts/pick.py", ROS1)
    workspace.write("launch/a.launch", NODE1.format("p", SPEED1.format(0.5)))
    workspace.write("launch/other.launch", NODE1.replace("pick.py", "place.py").format("p", ""))
    choice = workspace.choose("scripts/pick.py")
    assert given(choice) == {"/p/speed": 0.5}
    assert choice.setup.argv(()) == ("__name:=p",)
    assert choice.setup.sources == ("launch/a.launch",)
    assert choice.notes == (
        "launch: parameters, arguments and remaps from launch/a.launch (1 parameter); "
        "--no-launch leaves them out",
    )


def test_a_file_that_it_loads_and_that_is_not_there_is_named_with_the_place(workspace, given):
    workspace.write("scripts/pick.py", ROS1)
    load = '<rosparam command="load" file="$(find arm_task)/config/poses.yaml"/>'
    workspace.write("launch/a.launch", NODE1.format("p", load))
    choice = workspace.choose("scripts/pick.py")
    assert (
        "launch: launch/a.launch:1 loads config/poses.yaml, which is not there" in choice.notes[1]
    )
    # When it comes, the run is another one.
    assert "config/poses.yaml" in choice.setup.sources
    workspace.write("config/poses.yaml", "speed: 0.5\n")
    choice = workspace.choose("scripts/pick.py")
    assert given(choice) == {"/p/speed": 0.5}
    assert len(choice.notes) == 1


def test_no_launch_leaves_it_as_it_is(workspace):
    workspace.write("scripts/pick.py", ROS1)
    workspace.write("launch/a.launch", NODE1.format("p", SPEED1.format(0.5)))
    choice = workspace.choose("scripts/pick.py", launch=False)
    assert choice.setup is None
    assert choice.notes == ()


def test_several_that_give_the_same_are_one(workspace, given):
    workspace.write("scripts/pick.py", ROS1)
    for name in ("b", "a"):
        workspace.write(f"launch/{name}.launch", NODE1.format("p", SPEED1.format(0.5)))
    choice = workspace.choose("scripts/pick.py")
    assert choice.setup.file == "launch/a.launch"
    assert choice.notes[1:] == ("launch: launch/b.launch would give the same",)


def test_of_several_that_differ_the_one_that_gives_most_is_taken(workspace, given):
    workspace.write("scripts/pick.py", ROS1)
    workspace.write("launch/a.launch", NODE1.format("p", '<param name="idle" value="1"/>'))
    workspace.write("launch/b.launch", NODE1.format("p", SPEED1.format(0.5)))
    workspace.write("launch/c.launch", NODE1.format("p", SPEED1.format(0.7)))
    choice = workspace.choose("scripts/pick.py")
    assert choice.setup.file == "launch/b.launch"
    assert choice.notes[1] == (
        "launch: launch/a.launch, launch/c.launch would give other values; "
        "--launch FILE takes another"
    )


def test_one_of_a_test_comes_last_wherever_the_workspace_stands(workspace, tmp_path):
    workspace = type(workspace)(tmp_path / "tests")
    workspace.write("scripts/pick.py", ROS1)
    workspace.write("a/test/pick.launch", NODE1.format("p", SPEED1.format(0.5)))
    workspace.write("launch/pick.launch", NODE1.format("p", SPEED1.format(0.7)))
    choice = workspace.choose("scripts/pick.py")
    assert choice.setup.file == "launch/pick.launch"


def test_a_file_that_includes_it_is_taken_where_that_alone_lacks_what_is_required(workspace, given):
    workspace.write("scripts/pick.py", ROS1)
    workspace.write("launch/include/pick.xml", NODE1.format("p", ""))
    include = '<include file="$(find arm_task)/launch/include/pick.xml" ns="left"/>'
    workspace.write(
        "launch/all.launch",
        f'<launch><param name="/left/p/speed" value="2"/>{include}</launch>',
    )
    choice = workspace.choose("scripts/pick.py")
    assert given(choice) == {"/left/p/speed": 2}
    assert choice.setup.argv(()) == ("__name:=p", "__ns:=/left")
    assert choice.setup.sources == ("launch/all.launch", "launch/include/pick.xml")


def test_the_parameters_that_imported_modules_ask_for_count_too(workspace, given):
    workspace.write("scripts/pick.py", "import rospy\nfrom arm_task.speeds import SPEED\n")
    workspace.write("src/arm_task/__init__.py", "")
    workspace.write("src/arm_task/speeds.py", 'import rospy\nSPEED = rospy.get_param("~speed")\n')
    workspace.write("launch/a.launch", NODE1.format("p", '<param name="idle" value="1"/>'))
    workspace.write("launch/b.launch", NODE1.format("p", SPEED1.format(0.5)))
    assert workspace.choose("scripts/pick.py").setup.file == "launch/b.launch"


def test_a_launch_file_of_the_other_ros_is_not_his(workspace):
    workspace.write("scripts/pick.py", ROS1)
    workspace.write("launch/a.launch.py", LAUNCH2.format("pick.py", "p", ""))
    assert workspace.choose("scripts/pick.py").setup is None


def test_a_console_script_is_known_by_its_name(ros2, given):
    ros2.write(
        "launch/a.launch.py",
        LAUNCH2.format("picker", "p", 'parameters=[{"speed": 2.0}], remappings=[("a", "b")]'),
    )
    choice = ros2.choose("arm_task/pick.py")
    assert given(choice) == {"speed": 2.0}
    assert choice.setup.argv(()) == ("--ros-args", "-r", "__node:=p", "-r", "a:=b")


def test_a_name_under_which_cmake_installs_it(workspace, given):
    workspace.write("scripts/pick.py", ROS2)
    workspace.write(
        "CMakeLists.txt",
        "install(PROGRAMS scripts/pick.py DESTINATION lib/${PROJECT_NAME} RENAME go)\n",
    )
    workspace.write("launch/a.launch.py", LAUNCH2.format("go", "p", 'parameters=[{"speed": 2.0}]'))
    assert given(workspace.choose("scripts/pick.py")) == {"speed": 2.0}


def test_a_node_of_another_package_is_another(ros2):
    text = LAUNCH2.replace("arm_task", "other").format("picker", "p", 'parameters=[{"speed": 2.0}]')
    ros2.write("launch/a.launch.py", text + "# arm_task\n")
    choice = ros2.choose("arm_task/pick.py")
    assert choice.setup is None
    assert choice.notes == (
        "launch: launch/a.launch.py does not start it with the defaults of its arguments",
    )


def test_a_file_that_cannot_be_read_is_reported_and_harms_nothing(ros2):
    ros2.write(
        "launch/a.launch.py",
        LAUNCH2.format("picker", "p", "") + "# arm_task\nraise OSError('no')\n",
    )
    choice = ros2.choose("arm_task/pick.py")
    assert choice.setup is None
    assert choice.notes == (
        "launch: launch/a.launch.py does not start it: a.launch.py: OSError: no",
    )


def test_what_was_left_out_is_reported_where_the_source_asks_for_it(ros2):
    ros2.write("arm_task/pick.py", ROS2.replace('"side"', '"robot_description"'))
    ros2.write(
        "launch/a.launch.py",
        LAUNCH2.format(
            "picker",
            "p",
            'parameters=[{"robot_description": Command(["xacro a"]), "x": Command(["y"])}]',
        )
        + "from launch.substitutions import Command\n",
    )
    choice = ros2.choose("arm_task/pick.py")
    assert choice.notes[1:] == (
        "launch: parameter robot_description is left out: the output of xacro is not here",
    )


def test_a_program_started_twice_is_reported(workspace, given):
    workspace.write("scripts/pick.py", ROS1)
    node = '<node pkg="arm_task" type="pick.py" name="{}">{}</node>'
    text = node.format("left", "") + node.format("right", SPEED1.format(1))
    workspace.write("launch/a.launch", f"<launch>{text}</launch>")
    choice = workspace.choose("scripts/pick.py")
    assert choice.setup.name == "right"
    assert "launch: launch/a.launch starts it 2 times; one of them is run" in choice.notes


def test_a_parameter_file_with_the_nodes_name_stands_in_for_a_launch_file(ros2, given):
    ros2.write("config/a.yaml", "other:\n  ros__parameters: {speed: 9.0}\n")
    ros2.write("config/b.yaml", "pick:\n  ros__parameters: {speed: 3.0}\n")
    choice = ros2.choose("arm_task/pick.py")
    assert given(choice) == {"speed": 3.0}
    assert choice.setup.kind == "parameters"
    assert choice.setup.argv(("--n",)) == ("--n",)
    assert choice.notes == (
        "launch: parameters of node pick from config/b.yaml (1), for no launch file gives it any; "
        "--no-launch leaves them out",
    )


@pytest.mark.parametrize(
    ("key", "rules", "within"),
    [
        ("/cell/pick", ("--ros-args", "-r", "__ns:=/cell"), ", in the namespace /cell"),
        ("/**/pick", (), ""),
        ("/pick", (), ""),
    ],
)
def test_a_node_runs_in_the_namespace_in_which_its_parameter_file_is_for_it(
    ros2, given, key, rules, within
):
    ros2.write("config/b.yaml", f"{key}:\n  ros__parameters: {{speed: 3.0}}\n")
    choice = ros2.choose("arm_task/pick.py")
    assert given(choice) == {"speed": 3.0}
    assert choice.setup.argv(()) == rules
    assert choice.notes[0].startswith(
        f"launch: parameters of node pick from config/b.yaml (1){within}, for no launch file"
    )


def test_the_parameters_of_another_namespace_are_not_for_a_node_that_has_one_itself(ros2, given):
    ros2.write("arm_task/pick.py", f"{ROS2}\nother = Node('pick', namespace='left')\n")
    ros2.write("config/b.yaml", "/cell/pick:\n  ros__parameters: {speed: 3.0}\n")
    assert ros2.choose("arm_task/pick.py").setup is None
    ros2.write("config/b.yaml", "/left/pick:\n  ros__parameters: {speed: 3.0}\n")
    assert given(ros2.choose("arm_task/pick.py")) == {"speed": 3.0}


def test_a_parameter_file_beside_the_tests_is_taken_if_no_other_is_for_the_node(ros2, given):
    ros2.write("test/a.yaml", "pick:\n  ros__parameters: {colour: red}\n")
    assert ros2.choose("arm_task/pick.py").setup is None
    ros2.write("test/b.yaml", "pick:\n  ros__parameters: {speed: 3.0}\n")
    assert given(ros2.choose("arm_task/pick.py")) == {"speed": 3.0}
    ros2.write("config/b.yaml", "pick:\n  ros__parameters: {speed: 2.0}\n")
    assert given(ros2.choose("arm_task/pick.py")) == {"speed": 2.0}


def test_a_parameter_file_of_another_package_is_taken_if_it_gives_what_is_asked(ros2, given):
    ros2.write("package.xml", "<package><name>arm_task</name></package>")
    for name, text in {
        "setups/far/b": "pick:\n  ros__parameters: {speed: 1.0}\n",
        "setups/near/a": "pick:\n  ros__parameters: {colour: red}\n",
        "setups/near/b": "cell/pick:\n  ros__parameters: {speed: 3.0}\n",
    }.items():
        top, _, file = name.rpartition("/")
        ros2.write(f"../{top}/config/{file}.yaml", text)
        folder = top.rpartition("/")[2]
        ros2.write(f"../{top}/package.xml", f"<package><name>{folder}</name></package>")
    choice = ros2.choose("arm_task/pick.py")
    assert given(choice) == {"speed": 1.0}
    assert "../setups/near/config/b.yaml would give others" in choice.notes[1]


def test_a_parameter_file_for_every_node_is_taken_if_it_gives_what_is_asked(ros2, given):
    ros2.write("config/a.yaml", "/**:\n  ros__parameters: {colour: red}\n")
    assert ros2.choose("arm_task/pick.py").setup is None
    ros2.write("config/b.yaml", "/**:\n  ros__parameters: {goal: 0.5, colour: red}\n")
    choice = ros2.choose("arm_task/pick.py")
    assert given(choice)["goal"] == 0.5
    assert choice.notes[0].startswith("launch: parameters of every node from config/b.yaml (2)")
    ros2.write("config/c.yaml", "pick:\n  ros__parameters: {speed: 3.0}\n")
    assert given(ros2.choose("arm_task/pick.py")) == {"speed": 3.0}


def test_a_launch_file_that_is_named_is_taken(workspace, given):
    workspace.write("scripts/pick.py", ROS1)
    workspace.write("launch/a.launch", NODE1.format("p", SPEED1.format(1)))
    other = workspace.write("launch/b.launch", NODE1.format("q", SPEED1.format(2)))
    assert given(workspace.choose("scripts/pick.py", launch=str(other))) == {"/q/speed": 2}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (None, "the launch file cannot be read: No such file or directory"),
        (
            '<launch><node pkg="arm_task" exec="pick.py"/></launch>',
            "is a launch file of ROS 2, but the controller is of ROS 1; name one of ROS 1, or none "
            "with --no-launch",
        ),
        (
            "<robot/>",
            "is not a launch file; allowed: one of XML, YAML or Python, of ROS 1 or ROS 2",
        ),
        (
            NODE1.replace("pick.py", "place.py").format("p", ""),
            "does not start arm_task/pick.py; it starts: arm_task/place.py",
        ),
    ],
)
def test_a_named_launch_file_that_does_not_start_it_is_an_error(workspace, text, expected):
    workspace.write("scripts/pick.py", ROS1)
    path = workspace.package / "launch/a.launch"
    if text is not None:
        workspace.write("launch/a.launch", text)
    with pytest.raises(InputError, match=re.escape(f"{path}: {expected}")):
        workspace.choose("scripts/pick.py", launch=str(path))


def test_what_the_user_gives_goes_before_what_the_launch_file_gives():
    setup = LaunchSetup("a", "launch", 1, name="p", arguments=("--fast",), remaps=(("a", "b"),))
    assert setup.argv(()) == ("--fast", "a:=b", "__name:=p")
    assert setup.argv(("--slow", "_speed:=1", "a:=c")) == (
        "--slow", "a:=b", "__name:=p", "_speed:=1", "a:=c",
    )  # fmt: skip
    setup = LaunchSetup("a", "launch", 2, arguments=("--fast",), remaps=(("a", "b"),))
    assert setup.argv(()) == ("--fast", "--ros-args", "-r", "a:=b")
    assert setup.argv(("--slow", "--ros-args", "-r", "a:=c")) == (
        "--slow", "--ros-args", "-r", "a:=c", "-r", "a:=b",
    )  # fmt: skip


WITH_ARGUMENT1 = (
    '<launch><arg name="speed" default="1"/><node pkg="arm_task" type="pick.py" name="p">'
    '<param name="speed" value="$(arg speed)"/></node></launch>'
)
WITH_ARGUMENT2 = LAUNCH2.replace(
    "LaunchDescription([",
    'LaunchDescription([DeclareLaunchArgument("speed", default_value="1"), ',
).replace(
    "from launch import",
    "from launch.actions import DeclareLaunchArgument\n"
    "from launch.substitutions import LaunchConfiguration\nfrom launch import",
)
COMMANDS = {
    "a block": ("```bash\nFIRST a.launch speed:=0.5\n```\n", "0.5"),
    "in a sentence": ("Start it by `FIRST a.launch speed:=0.5`, then wait.\n", "0.5"),
    "over lines": ("    FIRST \\\n  a.launch \\\n  side:=left \\\n  speed:='0.5'\n", "0.5"),
    "the first that gives any": (
        "FIRST a.launch\nFIRST a.launch speed:=0.5 && FIRST a.launch speed:=2\n",
        "0.5",
    ),
    "a placeholder": ("FIRST a.launch speed:=<speed> side:=[left|right]\n", "1"),
    "another file": ("FIRST b.launch speed:=0.5\n", "1"),
    "another package": ("FIRST a.launch speed:=0.5\n".replace("FIRST", "OTHER"), "1"),
}


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(("text", "speed"), COMMANDS.values(), ids=COMMANDS)
@pytest.mark.parametrize("ros", [1, 2])
def test_a_command_of_a_readme_gives_a_launch_file_its_arguments(
    workspace, ros2, given, text, speed, ros
):
    start = "roslaunch" if ros == 1 else "ros2 launch"
    name = "a.launch" if ros == 1 else "a.launch.py"
    text = text.replace("FIRST", f"{start} arm_task").replace("OTHER", f"{start} other_task")
    workspace.write("README.md", f"# Pick\n{text}".replace("a.launch", name))
    other = workspace.folder / "src/other_task"
    other.mkdir()
    (other / "package.xml").write_text("<package><name>other_task</name></package>")
    (workspace.folder / ".git").mkdir()
    if ros == 1:
        workspace.write("scripts/pick.py", ROS1)
        workspace.write("launch/a.launch", WITH_ARGUMENT1)
        choice = workspace.choose("scripts/pick.py")
        found = given(choice)["/p/speed"]
    else:
        parameters = 'parameters=[{"speed": LaunchConfiguration("speed")}]'
        workspace.write("launch/a.launch.py", WITH_ARGUMENT2.format("picker", "p", parameters))
        choice = workspace.choose("arm_task/pick.py")
        found = given(choice)["speed"]
    assert str(found) == speed
    said = [each for each in choice.notes if "its arguments are" in each]
    if speed == "1":
        assert not said
        assert "README.md" not in choice.setup.sources
    else:
        (line,) = said
        assert "speed:=0.5" in line
        assert "of README.md:" in line
        assert "README.md" in choice.setup.sources
