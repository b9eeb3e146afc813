"""Imports between the rooms point one way: nothing below knows what stands above it."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "tracerisk"

ROOMS = (
    "cli",
    "pipeline",
    "report",
    "prm",
    "adder",
    "vendors",
    "ros",
    "twin",
    "instrument",
    "hardware",
)
"""From the top down."""
BELOW = (
    *("trace", "trace_display", "trace_json", "trace_log"),
    *("acceptances", "bounded", "config", "contained", "dependencies", "errors", "instance_name"),
    *("limited_process", "limits", "printable"),
    *("yaml_bounds", "yaml_nodes", "yaml_reader"),
)
"""Modules that every room may import, and that import no room."""
RANK = {room: rank for rank, room in enumerate(ROOMS)} | dict.fromkeys(BELOW, len(ROOMS))


def room_of(path: Path) -> str:
    return path.relative_to(PACKAGE).with_suffix("").parts[0]


def imported_rooms(path: Path) -> dict[str, int]:
    """The rooms that a file imports anything from, with the line of one such import."""
    found: dict[str, int] = {}
    for node in ast.walk(ast.parse(path.read_bytes())):
        names: list[str] = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.level:
            # A stand-in is a package of its own, and a relative import stays in it.
            assert "stand_ins" in path.parts, f"{path}:{node.lineno}: relative import"
        elif isinstance(node, ast.ImportFrom):
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        for name in names:
            parts = name.split(".")
            if parts[0] == "tracerisk" and len(parts) > 1 and parts[1] in RANK:
                found.setdefault(parts[1], node.lineno)
    return found


FILES = sorted(
    path
    for path in PACKAGE.rglob("*.py")
    if path.relative_to(PACKAGE).as_posix() not in ("__init__.py", "__main__.py")
)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.relative_to(PACKAGE).as_posix())
def test_a_file_imports_from_its_own_room_and_from_below(path):
    here = RANK[room_of(path)]
    upwards = {name: line for name, line in imported_rooms(path).items() if RANK[name] < here}
    assert not upwards, f"{path.name} imports from a room above its own: {upwards}"


def test_every_room_and_module_has_its_place():
    here = {
        path.stem
        for path in PACKAGE.iterdir()
        if (path.suffix == ".py" and not path.stem.startswith("__"))
        or (path / "__init__.py").is_file()
    }
    assert here == set(RANK)
