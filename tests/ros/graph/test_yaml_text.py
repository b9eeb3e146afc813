"""YAML as ROS reads it.

Source: yaml/pyyaml `lib/yaml/resolver.py` (the truth values of its safe loader, without y and n).
"""

import warnings

import pytest
from ruamel.yaml.error import YAMLError

from tracerisk.ros.graph.yaml_text import load_yaml


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("", None),
        ("yes", True),
        ("off", False),
        ("y", "y"),
        ("010", 8),
        ("1.0e3", 1000.0),
        ("[1, 2.5, no, n]", [1, 2.5, False, "n"]),
        ("{x: 0.1, y: 0.2, n: 3, on: 1}", {"x": 0.1, "y": 0.2, "n": 3, "on": 1}),
        ("a: &a {y: 1}\nb: {<<: *a, z: 2}\nc: *a", {"a": {"y": 1}, "b": {"y": 1, "z": 2}, "c": {"y": 1}}),
        ("a: 1\na: 2", {"a": 2}),
    ],
)  # fmt: skip
def test_values_are_those_of_yaml_1_1(text, value):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert load_yaml(text) == value


@pytest.mark.parametrize("text", ["[1, 2", "? [a: b]\n: c", "a: 2026-13-01"])
def test_what_is_no_yaml_is_an_error(text):
    with pytest.raises(YAMLError):
        load_yaml(text)


def test_a_value_that_is_changed_stays_as_written_for_who_reads_the_text_again():
    text = "joints: [a, b]"
    load_yaml(text)["joints"].append("c")
    assert load_yaml(text) == {"joints": ["a", "b"]}
