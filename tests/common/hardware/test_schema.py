"""The published JSON Schema: it takes what the reader takes, and refuses what has no such form."""

import json
from importlib.resources import files
from pathlib import Path

import jsonschema
import pytest
from hypothesis import given, settings
from ruamel.yaml import YAML

from tests.common.hardware.broken import BROKEN
from tests.common.hardware.strategies import hardware_descriptions
from tracerisk.common.hardware.description_data import description_data
from tracerisk.common.hardware.shipped import shipped_names
from tracerisk.common.hardware.yaml.hardware_reader import read_hardware
from tracerisk.common.hardware.yaml.writer import write_hardware

SCHEMA = json.loads(files("tracerisk.common.hardware").joinpath("hardware.schema.json").read_text())
VALIDATOR = jsonschema.Draft7Validator(SCHEMA)
SHIPPED = Path(str(files("tracerisk.common.hardware"))) / "robots"


def plain(text: str):
    return YAML(typ="safe", pure=True).load(text)


def test_the_schema_is_one_of_its_draft():
    jsonschema.Draft7Validator.check_schema(SCHEMA)


@settings(max_examples=20, deadline=None)
@given(hardware=hardware_descriptions())
def test_it_takes_whatever_the_reader_takes(hardware):
    data = description_data(hardware)
    VALIDATOR.validate(data)
    assert plain(write_hardware(hardware)) == data


@pytest.mark.slow(but=20)
@pytest.mark.parametrize("robot", shipped_names())
def test_it_takes_the_shipped_files(robot):
    VALIDATOR.validate(plain((SHIPPED / f"{robot}.yaml").read_text(encoding="utf-8")))


@pytest.mark.parametrize("broken", BROKEN)
def test_it_refuses_what_is_wrong_in_structure_and_nothing_else(broken):
    assert VALIDATOR.is_valid(plain(broken.text)) is not broken.structural


def test_every_key_says_what_it_is():
    def walk(node, path):
        if isinstance(node, dict):
            for name, each in node.get("properties", {}).items():
                text = "description" in each or "$ref" in each if isinstance(each, dict) else True
                is_condition = any(part in ("if", "then", "anyOf", "allOf") for part in path)
                assert text or is_condition, f"{'.'.join(path)}.{name} says nothing"
            for key, each in node.items():
                walk(each, [*path, key])
        elif isinstance(node, list):
            for each in node:
                walk(each, path)

    walk(SCHEMA, [])


@pytest.mark.parametrize("key", ["exponent", "per", "when", "detected", "spare", "sensors"])
def test_words_that_the_schema_completes_are_those_that_the_reader_takes(tmp_path, key):
    """Each word of the schema is read where it stands for itself."""
    examples = {
        "exponent": "failure_rate: {value: 1, per: hour}, twin: {joints: [j]}, "
        "load_law: {reference_load: 1, wearing_share: 1, exponent: WORD}",
        "per": "probability: {value: 1, per: WORD}",
        "when": "probability: {value: 1, per: demand}, failure_rate: {value: 1, per: hour}, "
        "twin: {gripper: true}, modes: {a: {fraction: 1, when: [WORD, moving, start]}}",
        "detected": "probability: 1, quantity: 2, redundancy: true, detected: WORD",
        "spare": "probability: 1, quantity: 2, spare: WORD",
        "sensors": "probability: 1, twin: {sensors: WORD}",
    }
    defs = SCHEMA["definitions"]
    words = {
        "exponent": defs["load_law"]["properties"]["exponent"]["enum"],
        "per": defs["probability"]["properties"]["per"]["enum"],
        "when": defs["mode"]["properties"]["when"]["items"]["enum"],
        "detected": defs["component"]["properties"]["detected"]["anyOf"][0]["enum"],
        "spare": defs["component"]["properties"]["spare"]["enum"],
        "sensors": defs["twin"]["properties"]["sensors"]["anyOf"][0]["enum"],
    }[key]
    assert len(words) > 1
    for word in words:
        text = examples[key].replace("WORD", str(word))
        if key == "when":
            text = text.replace("moving, moving", "moving").replace(
                "start, moving, start", "start, moving"
            )
        if word == "warm":
            text += ", dormancy: 0.5"
        path = tmp_path / "h.yaml"
        path.write_text(f"components: {{a: {{{text}}}}}\n")
        assert read_hardware(path).components
