"""Completion in blocks, and in files that a JSON Schema describes."""

import json
import re
from pathlib import Path

import pytest
from jsonschema import Draft7Validator
from lsprotocol import types as lsp
from ruamel.yaml import YAML

import tracerisk
from tracerisk.ros.scenario.file.scenario_reader import read_scenario

ROOT = Path(__file__).parents[2]
SCHEMA = json.loads(
    (Path(tracerisk.__file__).parent / "ros/scenario/scenario.schema.json").read_text()
)


def completed(editor, path, text, mark="|>"):
    """What is offered at the mark, with the text that each would make."""
    before = text[: text.index(mark)]
    line = before.count("\n")
    character = len(before.rpartition("\n")[2].encode("utf-16-le")) // 2
    whole = text.replace(mark, "", 1)
    if path.as_uri() in editor.versions:
        editor.change(path, whole)
    else:
        editor.open(path, whole)
    found = editor.ask(
        "text_document_completion",
        lsp.CompletionParams(
            lsp.TextDocumentIdentifier(path.as_uri()), lsp.Position(line, character)
        ),
    )
    lines = whole.split("\n")
    made = {}
    for each in found.items:
        edit = each.text_edit
        start, end = edit.range.start.character, edit.range.end.character
        made[each.label] = lines[line][:start] + edit.new_text + lines[line][end:]
    return made, {each.label: each.documentation for each in found.items}


def test_a_component_is_offered_from_the_hardware_description(editor, cell):
    text = cell.read_text()
    end = text.index("# | }\n    arm.set_named") + len("# | }\n")
    head = "    # | @Component := {\n    # |   name = |>\n    # | }\n"
    made, about = completed(editor, cell, text[:end] + head + text[end:])
    assert set(made) == {"gripper"}
    assert made["gripper"] == "    # |   name = gripper"
    assert "7.344e-08 per minute" in about["gripper"]
    assert "case study" in about["gripper"]


def test_a_half_typed_name_is_replaced(editor, cell):
    text = cell.read_text().replace("name = control_system", "name = con|>", 1)
    made, _ = completed(editor, cell, text)
    assert made["control_system"] == "    # |   name = control_system"


def test_sections_and_keys_are_offered_where_they_may_stand(editor, cell):
    text = cell.read_text()
    at = text.index("    # | @Component {")
    made, _ = completed(editor, cell, text[:at] + "    # | |>\n" + text[at:])
    assert list(made) == ["@Component := {", "@Component := omit {", "@Component {", "@Function {"]
    made, _ = completed(editor, cell, text[:at] + "    # | @Component := o|>\n" + text[at:])
    assert list(made.values()) == ["    # | @Component := omit {"]
    made, _ = completed(editor, cell, text.replace("redundancy = true", "re|>", 1))
    assert list(made) == ["redundancy ="]
    made, _ = completed(editor, cell, text.replace("quantity = 2", "|>", 1))
    assert list(made) == ["quantity ="]
    made, _ = completed(editor, cell, text.replace("callSequence = 1", "|>", 1))
    assert list(made) == ["callSequence =", "next ="]


def test_values_are_offered_by_their_key(editor, cell):
    text = cell.read_text()
    made, _ = completed(editor, cell, text.replace("next = act 1", "next = |>", 1))
    assert {"home 1", "act 1", "done 1"} == set(made)
    made, _ = completed(editor, cell, text.replace("redundancy = true", "redundancy := |>", 1))
    assert {"true", "false", "required 2"} < set(made)
    made, _ = completed(editor, cell, text.replace("name = home", "name = |>", 1))
    assert next(iter(made)) == "home"
    made, _ = completed(editor, cell, text.replace("quantity = 7", "quantity = |>", 1))
    assert list(made) == ["7"]
    made, _ = completed(editor, cell, text.replace("quantity = 7", "quantity := 6 ! |>", 1))
    assert made == {}


def test_a_whole_block_is_offered_and_can_be_read(editor, cell, example_in):
    text = cell.read_text().replace("def never(arm):\n", "def never(arm):\n    # | R|>\n", 1)
    made, _ = completed(editor, cell, text)
    (block,) = made.values()
    block = block.replace("COMPONENT", "gripper").replace("callSequence = 1", "callSequence = 3")
    whole = text.replace("    # | R|>", block, 1)
    assert "name = never\n" in block
    cell.write_text(whole)
    assert example_in(cell.parent).run("overrides", cell.name).code == 0


def test_code_and_words_have_no_offers(editor, cell):
    text = cell.read_text()
    for place in ("import os", "joints[0]"):
        made, _ = completed(editor, cell, text.replace(place, f"|>{place}", 1))
        assert made == {}
    made, _ = completed(editor, cell, text.replace("import os", "# just words |>\nimport os", 1))
    assert made == {}


def test_blocks_of_cpp_are_completed(editor, tmp_path):
    path = tmp_path / "arm.cpp"
    text = "void pick() {\n  /***\n   * RiskAnnotation\n   * @Function {\n   *   ca|>\n   * }\n   ***/\n}\n"
    made, _ = completed(editor, path, text)
    assert made == {"callSequence =": "   *   callSequence = "}


HARDWARE = "robot: panda\ncomponents:\n  motor:\n    quantity: 7\n    redundancy: false\n"


@pytest.mark.parametrize(
    ("text", "offered", "line"),
    [
        ("|>\ncomponents:\n  a: {}\n", {"robot", "source"}, "robot: "),
        (HARDWARE + "    red|>\n", set(), None),
        (HARDWARE + "    prob|>\n", {"probability"}, "    probability: "),
        (HARDWARE + "    probability: {value: 1e-9, |>}\n", {"per"}, None),
        (HARDWARE + "    probability: {value: 1e-9, per: |>}\n", {"minute", "hour", "visit"}, None),
        (
            HARDWARE + "    probability:\n      value: 1e-9\n      per: mi|>\n",
            {"minute"},
            "      per: minute",
        ),
        (HARDWARE + "    spare: |>\n", {"hot", "warm", "cold"}, None),
        (HARDWARE + "    twin:\n      |>\n", {"joints", "gripper"}, None),
        (HARDWARE + "    common_cause: {|>}\n", {"beta"}, None),
        (HARDWARE + "    # pro|>\n", set(), None),
        (
            "components:\n  # \N{GRINNING FACE}\n  m: {source: '\N{GRINNING FACE}', quan|>}\n",
            {"quantity"},
            None,
        ),
    ],
)
def test_hardware_descriptions_are_completed(editor, tmp_path, text, offered, line):
    made, about = completed(editor, tmp_path / "cell.yaml", text)
    labels = {label.rstrip(":") for label in made}
    assert offered <= labels
    assert offered or not labels
    assert not offered or all(about[label] for label in made if label.endswith(":"))
    if line is not None:
        assert line in made.values()


SCENARIO = "actions:\n  - name: /move_base\n    type: move_base_msgs/MoveBase\n"


@pytest.mark.parametrize(
    ("text", "offered"),
    [
        ("|>\n" + SCENARIO, {"publish", "services", "success", "frames"}),
        (SCENARIO + "    sta|>\n", {"status"}),
        (SCENARIO + "    status: |>\n", {"succeeded", "aborted"}),
        (SCENARIO + "    goals:\n      - status: succeeded\n        |>\n", {"after", "text"}),
        (SCENARIO + "    goals: [{status: succeeded}, {|>}]\n", {"status", "after"}),
        (SCENARIO + "  - |>\n", {"name", "type", "goals"}),
        ("success:\n- |>\n", {"object", "visited"}),
        ("objects:\n- {name: a, |>}\n", {"box", "mass"}),
        ("frames:\n  - frame: a\n    path:\n      - {at: 0}\n      - |>\n", {"at", "xyz"}),
    ],
)
def test_scenarios_are_completed(editor, tmp_path, text, offered):
    made, about = completed(editor, tmp_path / "world.yaml", text)
    labels = {label.rstrip(":") for label in made}
    assert offered <= labels
    assert "name" not in labels or "- name" not in text.partition("|>")[0].rpartition("\n  - ")[2]
    assert all(about[label] for label in made if label.endswith(":"))


def test_drivers_are_completed(editor, tmp_path):
    made, _ = completed(editor, tmp_path / "d.yaml", "driver: x\nservices: []\nacti|>\n")
    assert made


def test_other_yaml_is_left_alone(editor, tmp_path):
    made, _ = completed(editor, tmp_path / "ci.yaml", "on: push\njobs:\n  |>\n")
    assert made == {}
    made, _ = completed(editor, tmp_path / "empty.yaml", "|>")
    assert made == {}


@pytest.mark.parametrize(
    "text",
    [
        "components: {",
        "components:\n\t- |>",
        "components: [[[{{",
        "components:\n" + " " * 900 + "x: |>",
    ],
)
def test_broken_yaml_breaks_nothing(editor, tmp_path, text):
    text = text if "|>" in text else text + "|>"
    assert completed(editor, tmp_path / "b.yaml", text) is not None


def scenarios():
    found = re.findall(r"```yaml\n(.*?)```", (ROOT / "docs/scenario.md").read_text(), re.DOTALL)
    return [each for each in found if "..." not in each]


@pytest.mark.parametrize("text", scenarios())
def test_the_schema_of_scenarios_takes_those_of_the_docs(text):
    Draft7Validator.check_schema(SCHEMA)
    data = YAML(typ="safe").load(text)
    assert not [str(each) for each in Draft7Validator(SCHEMA).iter_errors(data)]


def test_the_schema_of_scenarios_has_the_keys_that_are_read(tmp_path):
    """What the reader allows at each place is what its errors list."""
    assert scenarios()
    allowed = {}
    path = tmp_path / "s.yaml"
    for text, place in (
        ("zzz: 1\n", ()),
        ("publish: [{zzz: 1}]\n", ("publish",)),
        ("services: [{zzz: 1}]\n", ("services",)),
        ("actions: [{zzz: 1}]\n", ("actions",)),
        ("frames: [{zzz: 1}]\n", ("frames",)),
    ):
        path.write_text(text)
        with pytest.raises(ValueError, match="allowed: ") as error:
            read_scenario(path)
        allowed[place] = set(str(error.value).partition("allowed: ")[2].split(", "))
    for place, keys in allowed.items():
        node = SCHEMA
        for step in place:
            node = node["properties"][step]["anyOf"][0]["items"]
        assert set(node["properties"]) == keys


def test_a_line_of_the_compact_form_is_offered_the_components_that_it_lacks(
    editor, cell, example_in
):
    assert example_in(cell.parent).run("annotate", cell.name, "--form", "compact").code == 0
    text = cell.read_text()
    end = text.index("    # | electric_motor")
    made, about = completed(editor, cell, text[:end] + "    # | gri|>\n" + text[end:])
    assert set(made.values()) == {
        "    # | gripper  := omit  ! ",
        "    # | gripper  := add  1e-9  1  ! ",
    }
    assert any("7.344e-08 per minute" in words for words in about.values())
    made, _ = completed(editor, cell, text[:end] + "    # | elec|>\n" + text[end:])
    assert made == {}
