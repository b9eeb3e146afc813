"""JSON Schemas of the files that users write, by which editors complete and check them.

They are in draft 7, which catalogues of schemas and language servers for TOML and YAML take; those
of models are in 2020-12. Those of the settings are made of `config.Settings`, so that nothing is
said twice.
"""

from __future__ import annotations

import ast
import inspect
import json
from dataclasses import fields
from importlib.resources import files
from types import UnionType
from typing import Any, Literal, get_args, get_origin, get_type_hints

from tracerisk.common.acceptances import KEYS
from tracerisk.common.settings.settings_file import FRACTIONS, FROM_ONE, GREATEST_TOLERANCE
from tracerisk.common.verdict_codes import ACCEPTABLE
from tracerisk.common.worlds.world import ALL, WORLDS, group_names
from tracerisk.config import Settings

SchemaName = Literal["settings", "pyproject", "hardware", "scenario", "driver", "model", "linked"]
"""The kinds of files: `settings` is the table `[tool.tracerisk]` alone, `pyproject` a whole
`pyproject.toml` with it; `model` and `linked` are models, which programs write."""

_DRAFT = "http://json-schema.org/draft-07/schema#"
_SHIPPED: dict[str, tuple[str, str]] = {
    "hardware": ("tracerisk.common.hardware", "hardware.schema.json"),
    "scenario": ("tracerisk.ros.scenario", "scenario.schema.json"),
    "driver": ("tracerisk.ros.vendors", "driver.schema.json"),
    "model": ("tracerisk.prm.formats", "schemas/hybrid-model-1.json"),
    "linked": ("tracerisk.prm.formats", "schemas/linked-model-1.json"),
}
"""The package and the file of each schema that is kept as a file."""
_PYTHON_WORDS = {"`None`:": "if it is not set:", "`True`:": "`true`:", "`False`:": "`false`:"}


def schema_text(name: SchemaName) -> str:
    """Return a schema as the text of a file."""
    if name in _SHIPPED:
        package, file = _SHIPPED[name]
        return files(package).joinpath(file).read_text(encoding="utf-8")
    schema = settings_schema() if name == "settings" else _pyproject_schema()
    return json.dumps(schema, indent=2, ensure_ascii=False) + "\n"


def settings_schema() -> dict[str, Any]:
    """Return the schema of the table `[tool.tracerisk]`."""
    return {
        "$schema": _DRAFT,
        "$id": "https://json.schemastore.org/partial-tracerisk.json",
        "title": "tracerisk",
        "description": "Settings of tracerisk, which assesses the risk of robot controllers.",
        **_table(),
        "definitions": _definitions(),
    }


def _pyproject_schema() -> dict[str, Any]:
    tool = {"type": "object", "properties": {"tracerisk": _table()}}
    return {
        "$schema": _DRAFT,
        "title": "pyproject.toml with settings of tracerisk",
        "description": "What [tool.tracerisk] holds; other tables are taken as they are.",
        "type": "object",
        "properties": {"tool": tool},
        "definitions": _definitions(),
    }


def _table() -> dict[str, Any]:
    """Return the schema of the settings of all controllers, with the tables of single ones."""
    properties = {entry.name: _reference(entry.name) for entry in fields(Settings)}
    own = {"type": "object", "additionalProperties": False, "properties": properties}
    controllers = {
        "type": "object",
        "description": "Settings of single controllers, by the path from this file.",
        "additionalProperties": own,
    }
    return {**own, "properties": {**properties, "controllers": controllers}}


def _reference(setting: str) -> dict[str, str]:
    return {"$ref": f"#/definitions/{setting}"}


def _definitions() -> dict[str, Any]:
    hints, descriptions = get_type_hints(Settings), _descriptions()
    definitions = {}
    for entry in fields(Settings):
        name, default = entry.name, getattr(Settings(), entry.name)
        schema = {"description": descriptions[name], **_values(name, hints[name])}
        if default is not None:
            schema["default"] = list(default) if isinstance(default, tuple) else default
        definitions[name] = schema
    return definitions


def _values(name: str, hint: Any) -> dict[str, Any]:
    """Return the schema of the values that a setting takes, by its name and type."""
    if name in FRACTIONS:
        return {"type": "number", "minimum": 0, "maximum": 1}
    if name == "tolerance":
        return {"type": "number", "minimum": 0, "maximum": GREATEST_TOLERANCE}
    if name in FROM_ONE:
        return {"type": "integer", "minimum": 1}
    if name == "accept":
        return {"type": "array", "items": _acceptance()}
    if name == "require_worlds":
        names = [ALL, *group_names(), *(world.name for world in WORLDS)]
        return {"anyOf": [{"type": "boolean"}, {"type": "array", "items": {"enum": names}}]}
    return _values_of_type(hint)


def _values_of_type(hint: Any) -> dict[str, Any]:
    if get_origin(hint) is Literal:
        return {"enum": list(get_args(hint))}
    if get_origin(hint) is tuple:
        return {"type": "array", "items": {"type": "string"}}
    if get_origin(hint) is UnionType or type(None) in get_args(hint):
        kinds = [_values_of_type(kind) for kind in get_args(hint) if kind is not type(None)]
        return kinds[0] if len(kinds) == 1 else {"anyOf": kinds}
    kinds_of_numbers: dict[Any, dict[str, Any]] = {
        bool: {"type": "boolean"},
        int: {"type": "integer", "minimum": 0},
        float: {"type": "number", "exclusiveMinimum": 0},
        str: {"type": "string"},
    }
    return kinds_of_numbers[hint]


def _acceptance() -> dict[str, Any]:
    words = {
        "code": "The code of the reason.",
        "function": "The function in which it happened, by qualified name.",
        "object": "The frame, service, joint, gripper or other thing.",
        "words": "Why it is accepted.",
    }
    properties: dict[str, Any] = {
        key: {"type": "string", "description": words[key]} for key in KEYS
    }
    properties["code"]["enum"] = sorted(ACCEPTABLE)
    return {
        "type": "object",
        "additionalProperties": False,
        "required": ["code", "words"],
        "properties": properties,
    }


def _descriptions() -> dict[str, str]:
    """Return what the text below each field of the settings says of it."""
    body = ast.parse(inspect.getsource(Settings)).body[0]
    assert isinstance(body, ast.ClassDef)
    descriptions = {}
    for field, text in zip(body.body, body.body[1:], strict=False):
        if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name):
            assert isinstance(text, ast.Expr)
            assert isinstance(text.value, ast.Constant)
            words = " ".join(str(text.value.value).split())
            for python, toml in _PYTHON_WORDS.items():
                words = words.replace(python, toml)
            descriptions[field.target.id] = words
    return descriptions
