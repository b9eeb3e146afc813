"""Values that a repository writes: commands, configuration, launch files, other programs."""

from pathlib import Path

import pytest

from tracerisk.pipeline.launch.program import Program
from tracerisk.pipeline.scenarios import shell_words
from tracerisk.pipeline.scenarios.written_values import WrittenValues
from tracerisk.ros.controller.needs import Need

README = """\
# Cell

Start it with `rosrun cell pick.py --side left`, or:

    ros2 run cell pick.py --parts 3 \\
        --fast

    ros2 topic pub --once /part geometry_msgs/msg/PointStamped \\
      "{header: {frame_id: base}, point: {x: 0.4, y: 0.1}}"
    rostopic pub -1 /task std_msgs/String "data: 'pick'" && echo done
    ros2 action send_goal -f /sort cell/action/Sort "{number: 2}"
    rosservice call /place "x: 0.2
    y: -0.1"
    rosparam set /cell/side right
    ros2 topic pub /wrong std_msgs/msg/Int32 "data: 1"
    rosrun cell pick.py <side>
"""
FILES = {
    "README.md": README,
    "config/arm.yaml": "arm_controller:\n  type: t\n  joints: [a, b]\nother: {speed: 3}\n",
    "config/ros2.yaml": "/**:\n  ros__parameters:\n    picker:\n      rate: 20.0\n    group: arm\n",
    "launch/cell.launch": (
        '<launch>\n  <arg name="robot_name" default="px100"/>\n'
        '  <node name="n" pkg="cell" type="pick.py">\n'
        '    <param name="depth" value="0.25"/>\n    <param name="file" value="$(find cell)/x"/>\n'
        '    <remap from="joint_states" to="sliders"/>\n  </node>\n'
        '  <node name="gui" pkg="joint_state_publisher_gui" type="joint_state_publisher_gui"/>\n'
        "</launch>\n"
    ),
    "scripts/other.py": (
        "import rospy\nfrom cell.msg import Order\n"
        "pub = rospy.Publisher('/orders', Order, queue_size=1)\n"
        "order = Order()\norder.item.name = 'tube'\norder.count = 2\npub.publish(order)\n"
    ),
    "build/README.md": "rostopic pub /built std_msgs/String 'data: x'\n",
    "broken.yaml": "a: [1\n",
    "broken.launch": "<launch",
    "broken.py": "def (\n",
}


@pytest.fixture
def written(tmp_path):
    for name, text in FILES.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    script = tmp_path / "scripts" / "pick.py"
    script.write_text("")
    return WrittenValues(tmp_path, Program(script, "cell", frozenset({"pick.py", "pick"})))


def of(written: WrittenValues, *need: str):
    found = written.of(Need(*need))
    return None if found is None else (found.value, found.place)


def test_lines_that_are_data_are_not_read_as_commands(monkeypatch):
    read = []
    monkeypatch.setattr(shell_words, "_read", lambda text: read.append(text) or ([], "'"))
    assert shell_words.command_words(["python3 pick.py " + "x" * 100_000] * 9, 0, 0) == ()
    assert read == []
    # A quote that no line closes is looked for in them, and they are not read again.
    assert shell_words.command_words(["python3 pick.py don't"] + ["word"] * 90, 0, 0) == ()
    assert len(read) == 1


def test_messages_of_commands(written):
    point = {"header": {"frame_id": "base"}, "point": {"x": 0.4, "y": 0.1}}
    assert of(written, "topic", "/part", "geometry_msgs/PointStamped") == (point, "README.md:8")
    assert of(written, "topic", "/task", "std_msgs/String") == ({"data": "pick"}, "README.md:10")
    assert of(written, "goal", "/sort", "cell/Sort") == ({"number": 2}, "README.md:11")
    assert of(written, "call", "/place", "cell/Place") == ({"x": 0.2, "y": -0.1}, "README.md:12")


SHOWN = {
    "numbers": ("Task", "command", [3, 1, 2], [3, 1, 2]),
    "one twice": ("Task", "command", [1, 2, 1], [1, 2]),
    "words": ("String", "data", ["stop", "home", "pick"], ["home", "pick", "stop"]),
    "an emergency": ("String", "data", ["estop", "home", "pick"], ["home", "pick"]),
    "one alone": ("Task", "command", [1], []),
}


@pytest.mark.parametrize("kind", SHOWN)
def test_all_messages_that_one_file_shows_come_in_turn(tmp_path, kind):
    short, field, shown, wanted = SHOWN[kind]
    lines = [
        f'ros2 topic pub --once /task cell/msg/{short} "{{{field}: {each}}}"' for each in shown
    ]
    (tmp_path / "README.md").write_text("\n".join(lines))
    (tmp_path / "TESTS.md").write_text(lines[0].replace(str(shown[0]), "9"))
    script = tmp_path / "pick.py"
    script.write_text("")
    written = WrittenValues(tmp_path, Program(script, "cell", frozenset({"pick.py"})))
    found = written.of(Need("topic", "/task", f"cell/{short}"))
    assert found is not None
    assert found.place == "README.md:1"
    assert [each[field] for each in found.in_turn] == wanted


def test_a_command_of_another_type_or_in_what_was_built_says_nothing(written):
    assert of(written, "topic", "/wrong", "std_msgs/String") is None
    assert of(written, "topic", "/built", "std_msgs/String") is None


def test_parameters_of_commands_yaml_and_launch_files(written):
    assert of(written, "parameter", "/cell/side") == ("right", "README.md:14")
    assert of(written, "parameter", "/arm_controller/joints") == (["a", "b"], "config/arm.yaml:3")
    assert of(written, "parameter", "/picker/rate", "double") == (20.0, "config/ros2.yaml:4")
    assert of(written, "parameter", "~robot_name") == ("px100", "launch/cell.launch:2")
    assert of(written, "parameter", "~depth", "double") == (0.25, "launch/cell.launch:4")


def test_a_value_of_another_thing_or_type_is_none(written):
    assert of(written, "parameter", "/wrist/speed") is None
    assert of(written, "parameter", "~depth", "string") is None
    assert of(written, "parameter", "~file") is None
    assert of(written, "parameter", "/nowhere") is None


def test_literals_of_another_program(written):
    fields = {"item": {"name": "tube"}, "count": 2}
    assert of(written, "topic", "/orders", "cell/Order") == (fields, "scripts/other.py:5")


def test_command_lines_of_the_controller_without_placeholders(written):
    assert written.arguments == (
        (("--side", "left"), "README.md:3"),
        (("--parts", "3", "--fast"), "README.md:5"),
    )


def test_the_launch_file_that_starts_a_publisher(written):
    names = ("joint_state_publisher_gui",)
    reported = written.started_with("/sliders", names)
    assert reported == "joint_state_publisher_gui in launch/cell.launch:8"
    assert written.started_with("/nothing", names) is None


def test_the_nearest_file_comes_first(tmp_path):
    near, far = tmp_path / "near", tmp_path / "far"
    for folder, value in ((far, 1), (near, 2)):
        folder.mkdir()
        (folder / "p.yaml").write_text(f"speed: {value}\n")
    program = Program(near / "c.py", "near", frozenset({"c.py"}))
    assert of(WrittenValues(tmp_path, program), "parameter", "/speed") == (2, "near/p.yaml:1")


def test_a_folder_that_is_gone_writes_nothing():
    gone = Path("/nowhere/at/all")
    program = Program(gone / "c.py", "c", frozenset({"c.py"}))
    assert WrittenValues(gone, program).arguments == ()


@pytest.mark.parametrize(
    ("file", "text"),
    [
        ("README.md", "Run `./pick.py 0.4 0.1` in the folder.\n"),
        ("README.md", "    python3 -m cell.pick 0.4 0.1\n"),
        ("run.sh", "python3.10 scripts/pick.py 0.4 0.1\n"),
        ("scripts/pick.py", "'''Usage: pick.py 0.4 0.1'''\n"),
        ("scripts/pick.py", "print('example: rosrun cell pick.py 0.4 0.1')\n"),
        ("scripts/pick.py", "# e.g.: ./scripts/pick.py 0.4 0.1\n"),
    ],
)
def test_a_command_of_a_banner_or_a_script_is_one_of_the_controller(tmp_path, file, text):
    (tmp_path / "scripts").mkdir()
    script = tmp_path / "scripts" / "pick.py"
    script.write_text("")
    (tmp_path / file).write_text(text)
    program = Program(script, "cell", frozenset({"pick.py", "pick"}))
    (found,) = WrittenValues(tmp_path, program).arguments
    assert found == (("0.4", "0.1"), f"{file}:1")


@pytest.mark.parametrize(
    ("value", "here"),
    [
        ("src/cell/config/arm.yaml", "config/arm.yaml"),
        ("config/arm.yaml", "config/arm.yaml"),
        ("src/cell/config/none.yaml", "src/cell/config/none.yaml"),
        ("package://cell/config/arm.yaml", "package://cell/config/arm.yaml"),
        (f"a/{'x' * 300}", f"a/{'x' * 300}"),
    ],
)
def test_a_path_that_is_not_there_is_the_file_of_the_repository_in_which_it_ends(
    written, tmp_path, value, here
):
    (tmp_path / "setup.sh").write_text(f"rosparam set /cell/table '{value}'\n")
    assert of(written, "parameter", "/cell/table", "string")[0] == here
