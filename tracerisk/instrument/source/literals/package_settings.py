"""What the YAML files of a source's package hold, as literals by their keys."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from tracerisk.common.text.bounded import file_text, files_below
from tracerisk.common.text.yaml_reader import plain_yaml
from tracerisk.config import PACKAGE_FILE

_UPWARDS = 4
_MOST_FILES = 40
_MOST_BYTES = 32 * 1024  # of one file
_LONGEST = 200  # entries of one mapping or list


def package_settings(file: Path) -> Mapping[str, ast.expr]:
    """Return mappings, lists and plain values by the key that each has in the package of a file.

    A key that means different things at different places is left out.
    """
    folder = file.resolve().parent
    for above in (folder, *folder.parents[:_UPWARDS]):
        if (above / PACKAGE_FILE).is_file():
            return _settings_in(above)
    return _settings_in(folder)


@lru_cache(maxsize=8)
def _settings_in(folder: Path) -> Mapping[str, ast.expr]:
    table: dict[str, ast.expr | None] = {}
    for path in files_below(folder, ".yaml", ".yml")[:_MOST_FILES]:
        for key, value in _entries(_read(path)):
            literal = _literal(value)
            if key in table and not _are_same(table[key], literal):
                literal = None
            table[key] = literal
    return {key: literal for key, literal in table.items() if literal is not None}


def _read(path: Path) -> Any:
    try:
        return plain_yaml(file_text(path, most=_MOST_BYTES))
    except (OSError, UnicodeDecodeError):
        return None


def _entries(value: Any) -> Iterator[tuple[str, Any]]:
    """Yield each key with its value, however deep it lies."""
    if not isinstance(value, dict):
        return
    for key, inner in value.items():
        if isinstance(key, str):
            yield key, inner
        yield from _entries(inner)


def _literal(value: Any) -> ast.expr | None:
    """Return a value as code: of a mapping its keys, of a list its plain entries."""
    if isinstance(value, str | int | float):
        return ast.Constant(value)
    if isinstance(value, list) and len(value) <= _LONGEST:
        plain = [item for item in value if isinstance(item, str | int | float)]
        return ast.List([ast.Constant(item) for item in plain], ast.Load())
    if isinstance(value, dict) and len(value) <= _LONGEST:
        keys = [item for item in value if isinstance(item, str | int | float)]
        return ast.Dict([ast.Constant(key) for key in keys], [ast.Constant(None) for _ in keys])
    return None


def _are_same(one: ast.expr | None, other: ast.expr | None) -> bool:
    return one is not None and other is not None and ast.dump(one) == ast.dump(other)
