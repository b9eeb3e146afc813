"""ROS 1 launch files: what they start and give, as roslaunch has it (wiki.ros.org/roslaunch/XML)."""

import pytest

from tracerisk.pipeline.launch_files.roslaunch_xml import read_roslaunch


@pytest.fixture
def read(tmp_path):
    def read_text(text, **files):
        (tmp_path / "arm.launch").write_text(f"<launch>{text}</launch>")
        for name, content in files.items():
            (tmp_path / name.replace("__", ".")).write_text(content)
        return read_roslaunch(tmp_path / "arm.launch", {"arm_task": tmp_path})

    return read_text


def parameters(reading):
    return {each.name: each.value for each in reading.parameters}


def test_parameters_of_a_node_are_private_and_those_outside_global(read):
    reading = read(
        '<param name="speed" value="0.5"/>'
        '<node pkg="arm_task" type="pick.py" name="pick"><param name="speed" value="2"/></node>'
    )
    assert parameters(reading) == {"/speed": 0.5, "/pick/speed": 2}
    assert reading.nodes[0].executable == "pick.py"


@pytest.mark.parametrize(
    ("attributes", "value"),
    [
        ('value="3"', 3),
        ('value="3.0"', 3.0),
        ('value="true"', True),
        ('value="tool0"', "tool0"),
        ('value="3" type="str"', "3"),
        ('value="3" type="double"', 3.0),
        ('value="1" type="bool"', True),
        ('value="[1, 2]" type="yaml"', [1, 2]),
    ],
)
def test_the_type_of_a_parameter_is_reported_or_seen(read, attributes, value):
    found = parameters(read(f'<param name="a" {attributes}/>'))
    assert found == {"/a": value}
    assert type(found["/a"]) is type(value)


def test_rosparam_merges_trees_and_reads_angles(read):
    reading = read(
        "<rosparam>{arm: {joints: [a, b], home: deg(90)}}</rosparam>"
        '<rosparam file="$(find arm_task)/more.yaml" ns="arm"/>'
        '<rosparam param="grip">[0.1, 0.2]</rosparam>'
        '<rosparam command="delete" param="arm/speed"/>',
        more__yaml="home: 1.0\nspeed: 0.1\nspeeds: {slow: 1}\n",
    )
    assert parameters(reading) == {
        "/arm/joints": ["a", "b"],
        "/arm/home": 1.0,
        "/arm/speeds/slow": 1,
        "/grip": [0.1, 0.2],
    }
    assert [path.name for path in reading.sources] == ["arm.launch", "more.yaml"]
    assert parameters(read("<rosparam>half: deg(180)</rosparam>"))["/half"] == pytest.approx(
        3.14159
    )


def test_the_server_holds_lists_of_dictionaries_and_no_long_integers(read):
    reading = read(
        "<rosparam>{tools: [{id: 1, at: [0.5]}], none: null, long: 4294967296}</rosparam>"
    )
    assert parameters(reading) == {"/tools": [{"id": 1, "at": [0.5]}]}
    assert dict(reading.left_out) == {
        "/none": "the parameter server holds no None",
        "/long": "the parameter server holds no 4294967296",
    }


def test_arguments_conditions_and_expressions(read, monkeypatch):
    monkeypatch.setenv("SIDE", "left")
    reading = read(
        '<arg name="arm" default="ur5"/><arg name="fast" default="true"/>'
        '<arg name="twice" value="$(eval 2 * 1.5 if fast else 0)"/>'
        '<param name="arm" value="$(arg arm)_arm"/>'
        '<param name="twice" value="$(arg twice)"/>'
        '<param name="side" value="$(env SIDE)"/>'
        '<param name="none" value="$(optenv NOT_THERE_AT_ALL right)"/>'
        '<param name="slow" value="1" unless="$(arg fast)"/>'
        '<param name="big" value="1" if="$(eval arg(\'arm\') == \'ur10\')"/>'
    )
    assert parameters(reading) == {
        "/arm": "ur5_arm",
        "/twice": 3.0,
        "/side": "left",
        "/none": "right",
    }


def test_groups_and_remaps_hold_for_what_stands_in_them(read):
    node = '<node pkg="arm_task" type="pick.py" name="pick" args="--fast $(arg n)">{}</node>'
    reading = read(
        '<arg name="n" default="2"/><remap from="a" to="b"/>'
        '<group ns="left"><remap from="c" to="d"/><param name="k" value="1"/>'
        + node.format('<remap from="~e" to="f"/><env name="SIDE" value="left"/>')
        + "</group>"
        + node.format("")
    )
    left, plain = reading.nodes
    assert left.namespace == "/left"
    assert left.remaps == (("a", "b"), ("c", "d"), ("~e", "f"))
    assert left.environment == (("SIDE", "left"),)
    assert plain.namespace == ""
    assert plain.remaps == (("a", "b"),)
    assert plain.arguments == ("--fast", "2")
    assert parameters(reading) == {"/left/k": 1}


def test_an_included_file_sees_what_it_is_passed_and_nothing_else(read):
    reading = read(
        '<arg name="speed" default="1"/><arg name="side" default="left"/>'
        '<include file="$(dirname)/inner.xml" ns="in"><arg name="speed" value="$(arg speed)5"/>'
        "</include>"
        '<include file="$(dirname)/inner.xml" ns="all" pass_all_args="true"/>',
        inner__xml='<launch><arg name="speed" default="0"/><arg name="side" default="none"/>'
        '<param name="speed" value="$(arg speed)"/><param name="side" value="$(arg side)"/></launch>',
    )
    assert parameters(reading) == {
        "/in/speed": 15,
        "/in/side": "none",
        "/all/speed": 1,
        "/all/side": "left",
    }


def test_what_cannot_be_read_spoils_nothing_else(read):
    reading = read(
        '<include file="$(find not_here)/x.launch"/>'
        '<param name="robot_description" command="xacro x"/>'
        '<param name="n" value="$(arg nobody)"/>'
        '<rosparam file="none.yaml"/>'
        '<param name="good" value="1"/>'
    )
    assert parameters(reading) == {"/good": 1}
    assert dict(reading.left_out)["/robot_description"] == "the output of a command is not here"
    assert dict(reading.left_out)["/n"] == "argument 'nobody' has no value"
    assert "arm.launch:1: <include>: package 'not_here' is not here" in reading.problems
    assert any("none.yaml" in each or "cannot be read" in each for each in reading.problems)


def test_a_file_that_includes_itself_comes_to_an_end(read):
    reading = read('<include file="$(dirname)/arm.launch"/><param name="a" value="1"/>')
    assert any("without end" in each for each in reading.problems)


def test_files_that_include_each_other_twice_come_to_an_end_soon(read):
    inner = '<include file="$(dirname)/arm.launch"/>'
    reading = read(inner * 2)
    assert any("more than 500 files" in each for each in reading.problems)


def test_parameters_that_refer_to_each_other_do_not_grow_without_bound(read):
    rows = "".join(f"k{i}: &k{i} [{', '.join([f'*k{i - 1}'] * 10)}]\n" for i in range(1, 9))
    reading = read('<rosparam file="$(dirname)/bomb.yaml"/>', bomb__yaml=f"k0: &k0 [1]\n{rows}")
    assert any("holds more than 50000 values" in each for each in reading.problems)
    reading = read('<rosparam file="$(dirname)/big.yaml"/>', big__yaml="a: 1\n" * 200_000)
    assert any("has more than 262144 characters" in each for each in reading.problems)


def test_what_the_host_has_sourced_decides_nothing(read, monkeypatch):
    monkeypatch.setenv("ROS_DISTRO", "noetic")
    assert parameters(read('<param name="d" value="$(optenv ROS_DISTRO none)"/>')) == {"/d": "none"}


@pytest.mark.parametrize("text", ["<launch>", "<robot/>", "<!DOCTYPE a><launch/>"])
def test_what_is_no_launch_file_is_a_problem(tmp_path, text):
    (tmp_path / "bad.launch").write_text(text)
    reading = read_roslaunch(tmp_path / "bad.launch", {})
    assert reading.nodes == ()
    assert reading.problems
