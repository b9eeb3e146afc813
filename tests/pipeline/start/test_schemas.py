"""The schemas by which editors complete settings take what is read, and nothing else."""

import json
import re
from dataclasses import fields
from pathlib import Path
from typing import get_args

import jsonschema
import pytest

from tests.common.settings.test_project_settings import BAD
from tracerisk.common.settings.project_settings import ProjectSettings
from tracerisk.common.settings.settings_file import loads_toml
from tracerisk.config import Settings
from tracerisk.errors import SettingsError
from tracerisk.pipeline.start.schemas import SchemaName, schema_text, settings_schema

ROOT = Path(__file__).parents[3]
TABLE = jsonschema.Draft7Validator(settings_schema())
WHOLE = jsonschema.Draft7Validator(json.loads(schema_text("pyproject")))
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
EXAMPLES = [
    block
    for page in PAGES
    for block in re.findall(r"```toml[^\n]*\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
    if "[tool.tracerisk" in block
]
VALUES = """
[tool.tracerisk]
robot = "cell.yaml"
ros_distro = "jazzy"
moveit_release = "1.1.14"
active = "moving"
duration_s = 12
launch = false
require_worlds = true
fail_on = "unexpected_contact"
max_failure_probability = 1e-5
min_coverage = 0
evidence = true
[[tool.tracerisk.accept]]
code = "never-grasped"
words = "the gripper is a dummy"
[tool.tracerisk.controllers."src/pick.py"]
launch = "cell.launch"
require_worlds = ["gripper", "latency"]
"""
WRONG = [
    'launch = ["a"]',
    "min_coverage = 1.5",
    "max_failure_probability = -1",
    "mission_cycles = 0",
    "memory_limit_mb = -1",
    "evidence = 1",
    'require_worlds = ["moon"]',
    'accept = [{code = "stopped", words = "x"}]',
    'accept = [{code = "never-grasped"}]',
    'controllers = {"pick.py" = {sede = 3}}',
]


@pytest.mark.parametrize("name", get_args(SchemaName))
def test_each_is_one_of_its_draft_and_says_what_it_is_for(name):
    schema = json.loads(schema_text(name))
    assert schema["title"]
    assert schema["description"]
    if name in ("model", "linked"):
        jsonschema.Draft202012Validator.check_schema(schema)
        assert schema["$id"].startswith("urn:tracerisk:")
        return
    jsonschema.Draft7Validator.check_schema(schema)
    assert schema["$schema"] == "http://json-schema.org/draft-07/schema#"
    if name != "pyproject":  # which is for no catalogue
        assert schema["$id"].endswith(
            f"{'partial-' * (name == 'settings')}tracerisk{schema_end(name)}"
        )


def schema_end(name: str) -> str:
    return ".json" if name == "settings" else f"-{name}.json"


def test_the_settings_are_those_of_the_dataclass_each_with_its_words_and_default():
    schema = settings_schema()
    names = [entry.name for entry in fields(Settings)]
    assert list(schema["definitions"]) == names
    assert list(schema["properties"]) == [*names, "controllers"]
    own = schema["properties"]["controllers"]["additionalProperties"]
    assert list(own["properties"]) == names
    for name, definition in schema["definitions"].items():
        assert len(definition["description"]) > 10, name
        default = getattr(Settings(), name)
        stated = definition.get("default")
        assert (tuple(stated) if isinstance(stated, list) else stated) == default, name
        if default is not None:
            jsonschema.Draft7Validator(definition).validate(stated)


@pytest.mark.parametrize("text", [VALUES, *EXAMPLES])
def test_settings_that_are_read_fit(text):
    document = loads_toml(text)
    WHOLE.validate(document)
    TABLE.validate(document["tool"]["tracerisk"])


def test_the_values_are_read(tmp_path):
    (tmp_path / "src").mkdir()
    (tmp_path / "src/pick.py").touch()
    (tmp_path / "pyproject.toml").write_text(VALUES)
    assert ProjectSettings(tmp_path).of("src/pick.py").require_worlds


@pytest.mark.parametrize("body", [*BAD, *WRONG])
def test_what_is_refused_when_read_does_not_fit(tmp_path, body):
    (tmp_path / "pick.py").touch()
    (tmp_path / "pyproject.toml").write_text(f"[tool.tracerisk]\n{body}\n")
    with pytest.raises(SettingsError):
        ProjectSettings(tmp_path).of()
    if body == "seed = " or "stands in `states` too" in BAD.get(body, ""):
        return  # no TOML, and what two keys say together
    assert not WHOLE.is_valid(loads_toml(f"[tool.tracerisk]\n{body}\n"))
