"""What docs/hardware.md shows is what happens, and it names every key."""

import json
import re
import shlex
from importlib.resources import files
from pathlib import Path

import jsonschema
import pytest
from ruamel.yaml import YAML

from tracerisk.common.hardware.binding import bind
from tracerisk.common.hardware.yaml.hardware_reader import read_hardware
from tracerisk.twin.robots.robot import load_robot

TEXT = (Path(__file__).parents[1] / "docs" / "hardware.md").read_text(encoding="utf-8")
SCHEMA = json.loads(files("tracerisk.common.hardware").joinpath("hardware.schema.json").read_text())


def fenced(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", TEXT, re.MULTILINE | re.DOTALL)


def test_every_command_does_what_it_says(example):
    commands = [line for block in fenced("sh") for line in block.splitlines()]
    assert len(commands) >= 4
    for command in commands:
        outcome = example.run(*shlex.split(command)[1:])
        assert outcome.code == 0, f"{command}: {outcome.err}"
    assert sorted(example.files()) == ["again.yaml", "cell.yaml", "hardware.schema.json"]


@pytest.mark.parametrize("text", fenced("yaml"), ids=range(len(fenced("yaml"))))
def test_every_description_is_read_and_fits_the_schema_and_a_robot(tmp_path, text):
    path = tmp_path / "h.yaml"
    path.write_text(text, encoding="utf-8")
    hardware = read_hardware(path)
    jsonschema.Draft7Validator(SCHEMA).validate(YAML(typ="safe", pure=True).load(text))
    robot = load_robot("ur5e" if "wrist_1_joint" in text or "ur5e" in text else "panda")
    assert bind(hardware, robot.elements)


def test_every_key_is_explained():
    def keys(node) -> set[str]:
        if isinstance(node, list):
            return set().union(*map(keys, node))
        if not isinstance(node, dict):
            return set()
        return set(node.get("properties", ())).union(*map(keys, node.values()))

    prose = re.sub(r"^```.*?^```$", "", TEXT, flags=re.MULTILINE | re.DOTALL)
    text = set(re.findall(r"\b[a-z_0-9]+\b", " ".join(re.findall(r"`([^`]+)`", prose))))
    assert keys(SCHEMA) - text == set()


def test_every_word_that_is_allowed_is_reported():
    def words(node) -> set[str]:
        if isinstance(node, list):
            return set().union(*map(words, node))
        if not isinstance(node, dict):
            return set()
        own = {str(word) for word in node.get("enum", ())} if "enum" in node else set()
        return own.union(*map(words, node.values()))

    reported = set(re.findall(r"[\w/.]+", TEXT))
    assert words(SCHEMA) - {repr(10 / 3), "second"} <= reported
