"""Frames for which a repository starts a static publisher."""

import pytest

from tracerisk.pipeline.launch.program import Program
from tracerisk.pipeline.scenarios.written_frames import static_frame
from tracerisk.pipeline.scenarios.written_values import WrittenValues
from tracerisk.ros.controller.needs import Need

ARGUMENTS = {
    "turns in the order yaw, pitch, roll": (
        "0.1 0.2 0.3 1.5 0.5 0.25 base camera",
        {"frame": "camera", "parent": "base", "xyz": [0.1, 0.2, 0.3], "rpy": [0.25, 0.5, 1.5]},
    ),
    "a quaternion": (
        "0 0 1 1 0 0 0 base camera",
        {"frame": "camera", "parent": "base", "xyz": [0.0, 0.0, 1.0], "rpy": [3.14159, 0.0, 0.0]},
    ),
    "turns with the period of tf": (
        "0 0 1 0 0 0 /base /camera 100",
        {"frame": "/camera", "parent": "/base", "xyz": [0.0, 0.0, 1.0], "rpy": [0.0, 0.0, 0.0]},
    ),
    "a quaternion with the period of tf": (
        "0 0 1 0 0 0 1 base camera 100",
        {"frame": "camera", "parent": "base", "xyz": [0.0, 0.0, 1.0], "rpy": [0.0, 0.0, 0.0]},
    ),
    "options of ROS 2, some of them": (
        "--z 0.5 --yaw -1.0 --frame-id base --child-frame-id camera --ros-args -r a:=b",
        {"frame": "camera", "parent": "base", "xyz": [0.0, 0.0, 0.5], "rpy": [0.0, 0.0, -1.0]},
    ),
    "options with an equals sign": (
        "--x=0.5 --frame-id=base --child-frame-id=camera",
        {"frame": "camera", "parent": "base", "xyz": [0.5, 0.0, 0.0], "rpy": [0.0, 0.0, 0.0]},
    ),
}


@pytest.mark.parametrize(("words", "entry"), ARGUMENTS.values(), ids=ARGUMENTS)
def test_the_arguments_of_a_static_publisher_are_a_frame(words, entry):
    assert static_frame(words.split()) == entry


@pytest.mark.parametrize(
    "words",
    [
        "0 0 0 0 0 base camera",
        "0 0 0 0 0 0 base",
        "$(arg x) 0 0 0 0 0 base camera",
        "0 0 0 0 0 0 0 base camera",
        "--x 1 --frame-id base",
        "--x one --frame-id base --child-frame-id camera",
        "",
    ],
)
def test_arguments_that_are_incomplete_or_computed_are_none(words):
    assert static_frame(words.split()) is None


SOURCES = {
    "a launch file of ROS 1": (
        "launch/cell.launch",
        '<launch>\n  <node pkg="tf" type="static_transform_publisher" name="c"\n'
        '        args="0.4 0 0.6 0 0 0 base camera 100"/>\n</launch>\n',
        "launch/cell.launch:3",
    ),
    "an XML launch file of ROS 2": (
        "launch/cell.launch.xml",
        '<launch>\n  <node pkg="tf2_ros" exec="static_transform_publisher"\n'
        '        args="--x 0.4 --z 0.6 --frame-id base --child-frame-id camera"/>\n</launch>\n',
        "launch/cell.launch.xml:3",
    ),
    "a Python launch file": (
        "launch/cell.launch.py",
        "def generate_launch_description():\n    return LaunchDescription([Node(\n"
        "        package='tf2_ros', executable='static_transform_publisher',\n"
        "        arguments=['0.4', '0', str(0.6), '0', '0', '0', 'base', 'camera'])])\n",
        "launch/cell.launch.py:2",
    ),
    "a command of the readme": (
        "README.md",
        "# Cell\n\n    ros2 run tf2_ros static_transform_publisher 0.4 0 0.6 0 0 0 base camera\n",
        "README.md:3",
    ),
}


@pytest.mark.parametrize(("name", "text", "place"), SOURCES.values(), ids=SOURCES)
def test_a_frame_is_where_the_repository_publishes_it(tmp_path, name, text, place):
    path = tmp_path / name
    path.parent.mkdir(exist_ok=True)
    path.write_text(text)
    script = tmp_path / "pick.py"
    script.write_text("")
    written = WrittenValues(tmp_path, Program(script, "cell", frozenset({"pick.py"})))
    found = written.of(Need("frame", "camera"))
    assert found.place == place
    assert found.value == {
        "frame": "camera",
        "parent": "base",
        "xyz": [0.4, 0.0, 0.6],
        "rpy": [0.0, 0.0, 0.0],
    }
    assert written.of(Need("frame", "other")) is None


LOOKING = """\
import moveit_commander
import rospy
import tf2_ros

rospy.init_node("pick")
arm = moveit_commander.MoveGroupCommander("panda_arm")
buffer = tf2_ros.Buffer()
listener = tf2_ros.TransformListener(buffer)


def look():
    seen = buffer.lookup_transform("panda_link0", "optical", rospy.Time(0), rospy.Duration(2.0))
    assert abs(seen.transform.translation.z - 0.7) < 1e-9, seen
    arm.set_named_target("extended")
    arm.go()


look()
"""
LAUNCH = """\
<launch>
  <node pkg="tf" type="static_transform_publisher" name="a" args="0.4 0 0.6 0 0 0 panda_link0 rack 9"/>
  <node pkg="tf" type="static_transform_publisher" name="b" args="0 0 0.1 0 0 0 rack optical 9"/>
</launch>
"""


def test_a_run_looks_up_a_chain_of_frames_that_a_launch_file_publishes(example):
    example.write("src/cell/package.xml", "<package format='2'><name>cell</name></package>\n")
    example.write("src/cell/launch/camera.launch", LAUNCH)
    example.write("src/cell/pick.py", LOOKING)
    outcome = example.run("trace", "src/cell/pick.py", "--json")
    assert outcome.code == 0, outcome.err
    words = [each["words"] for each in outcome.json["verdict"]["reasons"]]
    assert any("camera.launch:3" in each for each in words), words
