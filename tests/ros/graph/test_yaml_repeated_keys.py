"""Keys that come twice in a file of parameters: ROS 2 joins them, for ROS 1 the later counts.

Sources: ros2/rcl `rcl_yaml_param_parser/src/parse.c` (`find_node`, `find_parameter`), yaml/pyyaml
`lib/yaml/constructor.py` (`construct_mapping`).
"""

import pytest

from tracerisk.common.text.yaml_reader import read_yaml
from tracerisk.errors import InputError, ScenarioError
from tracerisk.ros.graph.parameter_files import read_parameters
from tracerisk.ros.graph.yaml_text import load_yaml

EVERYBODYS = """\
/**:
  ros__parameters: {speed: 0.5, gain: {p: 1.0, i: 2.0}}
arm:
  ros__parameters: {speed: 0.7}
/**:
  ros__parameters: {speed: 0.6, gain: {p: 3.0}}
"""
"""The same node twice, with another between."""
WITHIN = """\
arm:
  ros__parameters: {speed: 0.5, joints: [a, b]}
  ros__parameters: {joints: [c]}
"""
"""The parameters of a node twice below it."""
DEEP = """\
left: {arm: {ros__parameters: {speed: 0.5}}}
left: {hand: {ros__parameters: {speed: 0.1}}}
"""
"""A namespace twice, with another node each time."""
GROUPS = """\
arm:
  ros__parameters:
    limits: {low: -1.0}
    speed: 0.5
    limits: {high: 1.0}
"""
"""A group of parameters twice."""


def read(tmp_path, text):
    path = tmp_path / "arm.yaml"
    path.write_text(text)
    return {(each.node, each.name): each.value for each in read_parameters(path)}


@pytest.mark.parametrize(
    ("text", "found"),
    [
        (
            EVERYBODYS,
            {("/**", "speed"): 0.6, ("/**", "gain.p"): 3.0, ("/**", "gain.i"): 2.0}
            | {("/arm", "speed"): 0.7},
        ),
        (WITHIN, {("/arm", "speed"): 0.5, ("/arm", "joints"): ["c"]}),
        (DEEP, {("/left/arm", "speed"): 0.5, ("/left/hand", "speed"): 0.1}),
        (
            GROUPS,
            {("/arm", "limits.low"): -1.0, ("/arm", "limits.high"): 1.0, ("/arm", "speed"): 0.5},
        ),
    ],
)
def test_a_parameter_file_of_ros_2_joins_what_comes_twice(tmp_path, text, found):
    assert read(tmp_path, text) == found


def test_a_parameter_file_of_ros_1_keeps_the_later(tmp_path):
    text = "arm: {speed: 0.5, joints: [a]}\nname: b\narm: {speed: 0.6}\n"
    assert read(tmp_path, text) == {(None, "arm"): {"speed": 0.6}, (None, "name"): "b"}


def test_texts_of_parameters_are_read_alike():
    assert load_yaml(DEEP)["left"] == {
        "arm": {"ros__parameters": {"speed": 0.5}},
        "hand": {"ros__parameters": {"speed": 0.1}},
    }
    assert load_yaml("arm: {a: 1}\narm: {b: 2}\n") == {"arm": {"b": 2}}


def test_a_mapping_behind_an_alias_keeps_what_it_holds():
    text = "common: &all {ros__parameters: {a: 1}}\narm: *all\narm: {ros__parameters: {b: 2}}\n"
    found = load_yaml(text)
    assert found["common"] == {"ros__parameters": {"a": 1}}
    assert found["arm"] == {"ros__parameters": {"a": 1, "b": 2}}


def test_an_error_names_the_place_of_the_later(tmp_path):
    with pytest.raises(ScenarioError, match=r"arm\.yaml:4:27: .*31"):
        read(
            tmp_path,
            "arm:\n  ros__parameters: {a: 1}\narm:\n  ros__parameters: {b: 1, a: 2026-01-31}\n",
        )


def test_the_node_that_comes_first_keeps_its_place(run_ros2, tmp_path):
    """What is given for every node does not win over a node's own because it comes again."""
    file = tmp_path / "arm.yaml"
    file.write_text(EVERYBODYS)

    def main():
        import rclpy

        rclpy.init()
        node = rclpy.create_node(
            "arm",
            cli_args=["--ros-args", "--params-file", str(file)],
            automatically_declare_parameters_from_overrides=True,
        )
        return [node.get_parameter(name).value for name in ("speed", "gain.p", "gain.i")]

    assert run_ros2(main) == [0.7, 3.0, 2.0]


def test_our_own_files_refuse_a_key_that_comes_twice(tmp_path):
    path = tmp_path / "cell.yaml"
    path.write_text("frames: {a: 1}\nframes: {b: 2}\n")
    with pytest.raises(InputError, match=r"cell\.yaml:2:1: .*duplicate key"):
        read_yaml(path)
