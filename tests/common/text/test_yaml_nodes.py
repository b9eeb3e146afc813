"""YAML read by libyaml: the values of the core schema, the place of each key, what is refused."""

import json
import math
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st
from ruamel.yaml import YAML

from tracerisk.common.text.yaml_nodes import PlacedYamlError, load_placed
from tracerisk.common.text.yaml_reader import read_large_yaml, read_yaml
from tracerisk.errors import InputError

# What both JSON and YAML may hold in a string without an escape of more than four digits.
TEXTS = st.text(st.characters(max_codepoint=0xD7FF, exclude_categories=["Cc", "Zl", "Zp"]))
VALUES = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats(allow_nan=False, allow_infinity=False)
    | TEXTS,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(TEXTS, inner, max_size=4),
    max_leaves=12,
)


@given(value=st.dictionaries(TEXTS, VALUES, max_size=4))
def test_json_is_read_as_what_it_holds(value):
    found = load_placed(json.dumps(value, ensure_ascii=False))
    assert found == value
    assert json.dumps(found) == json.dumps(value)


@pytest.mark.parametrize(
    "scalar",
    [
        "1",
        "-5",
        "+5",
        "017",
        "0x1F",
        "0o17",
        ".5",
        "1.",
        "1e3",
        "-1.5E-7",
        ".inf",
        "-.inf",
        "~",
        "null",
        "NULL",
        "true",
        "True",
        "FALSE",
        "yes",
        "no",
        "on",
        "'1'",
        '"1"',
        "1.2.3",
        "1e",
        "abc",
        "a:b",
        "-x",
        "+",
    ],
)
def test_scalars_are_those_of_the_other_reader(scalar):
    expected = YAML(typ="safe", pure=True).load(f"a: {scalar}\n")["a"]
    found = load_placed(f"a: {scalar}\n")["a"]
    assert (found, type(found)) == (expected, type(expected))


def test_what_is_no_scalar_of_the_core_schema_is_a_string():
    assert load_placed("[2026-11-21, 1_000, 190:20:30, '', !!str 5]") == [
        "2026-11-21",
        "1_000",
        "190:20:30",
        "",
        "5",
    ]
    assert math.isnan(load_placed("a: .nan")["a"])
    assert load_placed("[!!float 1, !!int 2, !!null '', !!bool true]") == [1.0, 2, None, True]


def test_keys_and_entries_have_the_places_that_the_other_reader_says(tmp_path):
    text = "a:\n  b: {c: 1, 'd': [2, é, {e: 3}]}\n  f:\n    - x\n    -   - y\n"
    path = tmp_path / "a.yaml"
    path.write_text(text, encoding="utf-8")
    one, other = read_large_yaml(path), read_yaml(path)
    for keys in (["a"], ["a", "b"], ["a", "f"]):
        assert one.nested_location(keys) == other.nested_location(keys)
    for key in ("c", "d"):
        place = one.map("a").map("b").key_location(key)
        assert place == other.map("a").map("b").key_location(key)
    for index in range(3):
        place = one.map("a").map("b").entry_location("d", index)
        assert place == other.map("a").map("b").entry_location("d", index)
    assert one.map("a").entry_location("f", 1) == other.map("a").entry_location("f", 1)


def test_merged_keys_follow_own_ones_and_the_first_merge_counts():
    text = "a: &a {x: 1, y: 2}\nb: &b {x: 3, z: 4}\nc: {<<: [*a, *b], y: 5}\nd: {'<<': 1}\n"
    found = load_placed(text)
    assert found["c"] == {"y": 5, "x": 1, "z": 4}
    assert list(found["c"].lc.data) == ["y"]
    assert found["d"] == {"<<": 1}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("a: [1\n", "2:1: is not valid YAML: while parsing a flow sequence, did not find expected"),
        ("a: [", "1:5: is not valid YAML: while parsing a flow node, did not find"),
        ("a: b: c\n", "1:5: is not valid YAML: mapping values are not allowed in this context"),
        ("a: 1\na: 2\n", "2:1: is not valid YAML: holds the key 'a' twice"),
        ("? [b]\n: 1\n", "1:3: is not valid YAML: a key is not a string"),
        ("1: 2\n", "1:1: key 1 is not a string; put it in quotes"),
        ("a: &x {b: *x}\n", "1:11: is not valid YAML: unknown anchor '*x'"),
        ("a: 1\n---\na: 2\n", "2:1: is not valid YAML: holds a second document; give one"),
        ("a: !thing 1\n", "1:4: is not valid YAML: unknown type !thing"),
        ("a: !!set {b}\n", "1:4: is not valid YAML: unknown type tag:yaml.org,2002:set"),
        ("a: !!int x\n", "1:4: is not valid YAML: 'x' is not of the type tag:yaml.org,2002:int"),
        ("<<: 3\n", "1:1: is not valid YAML: '<<' must refer to a mapping"),
        ("a: " + "[" * 500, "1:103: is not valid YAML: is nested deeper than 100 levels"),
        ("- 1\n", "1: expected a mapping at the top, found a list"),
        ("", "1: expected a mapping at the top, found nothing"),
    ],
)
def test_what_is_no_mapping_of_yaml_is_an_error_with_its_place(tmp_path, text, expected):
    file = tmp_path / "a.yaml"
    file.write_text(text)
    with pytest.raises(InputError) as found:
        read_large_yaml(file, shown="a.yaml")
    assert str(found.value).startswith(f"a.yaml:{expected}")


@pytest.mark.parametrize("deep", ["a: " + "[" * 100_000, "a: " + "{b: " * 20_000])
def test_what_the_parser_itself_finds_too_deep_has_the_same_message(tmp_path, deep):
    file = tmp_path / "a.yaml"
    file.write_text(deep)
    with pytest.raises(InputError, match=r"^a\.yaml:1:\d+: .*: is nested deeper than 100 levels"):
        read_large_yaml(file, shown="a.yaml")


def test_characters_that_yaml_forbids_are_an_error(tmp_path):
    file = tmp_path / "a.yaml"
    file.write_bytes(b"a: \x00\n")
    with pytest.raises(InputError, match=r"a\.yaml: is not valid YAML: control characters"):
        read_large_yaml(file, shown="a.yaml")
    with pytest.raises(PlacedYamlError):
        load_placed('a: "\\ud800"')


@pytest.mark.parametrize("read", [read_yaml, read_large_yaml])
def test_anchors_that_grow_by_powers_are_read_at_once(tmp_path, read):
    lines = ["a0: &a0 [x]"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]" for i in range(1, 30)]
    file = tmp_path / "a.yaml"
    file.write_text("\n".join(lines))
    begin = time.process_time()
    assert "a29" in read(file)
    assert time.process_time() - begin < 5.0


def test_a_number_of_any_length_is_read_in_no_time():
    assert load_placed("a: " + "9" * 100_000)["a"] == math.inf
