"""Imports point one way, between the rooms and between the sub-rooms of a room.

Nothing below knows what stands above it. An import within a function counts as any other.
"""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "tracerisk"

ROOMS = (
    "cli",
    "editor",
    "api",
    "pipeline",
    "report",
    "prm",
    "adder",
    "vendors",
    "ros",
    "twin",
    "instrument",
    "quantify",
    "hardware",
    "source",
)
"""From the top down."""
BELOW = (
    *("trace", "trace_display", "trace_json", "trace_log"),
    *("acceptances", "config", "dependencies", "errors", "evidence", "field", "geometry"),
    *("instance_name", "limits", "records", "sandbox", "strong_components", "text"),
)
"""What every room may import, and what imports no room."""
RANK = {room: rank for rank, room in enumerate(ROOMS)} | dict.fromkeys(BELOW, len(ROOMS))
SUB_ROOMS = {
    "adder": ("annotate", "figures", "sources", "merge", "lock", "blocks"),
    "pipeline": (
        *(
            "recordings",
            "results",
            "review",
            "check",
            "evidence",
            "stages",
            "scenarios",
            "freshness",
        ),
        *("run", "trace"),
        *("history", "robot", "launch", "launch_files", "workspace"),
    ),
    "ros": (
        *(
            "twin_interfaces",
            "live",
            "stand_ins",
            "scenario",
            "imports",
            "gazebo",
            "moveit",
            "robot",
        ),
        *("drafts", "transforms", "messages", "graph", "time", "controller", "homogeneous"),
    ),
    "twin": (
        *("workspace", "simulation", "recording", "motion", "faults", "physics"),
        *("model_files", "urdf", "robots"),
    ),
}
"""The parts of a room, from the top down."""
MOST_FILES = 15
"""In a folder, beside `__init__`: more hide what is there."""
VERBS = 35


def parts_of(path: Path) -> tuple[str, ...]:
    return path.relative_to(PACKAGE).with_suffix("").parts


def imported(path: Path) -> dict[tuple[str, ...], int]:
    """What a file imports of tracerisk: the parts of each name, with the line."""
    found: dict[tuple[str, ...], int] = {}
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
            first, *parts = name.split(".")
            if first == "tracerisk" and parts:
                found.setdefault(tuple(parts), node.lineno)
    return found


FILES = sorted(
    path
    for path in PACKAGE.rglob("*.py")
    if path.relative_to(PACKAGE).as_posix() not in ("__init__.py", "__main__.py")
)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.relative_to(PACKAGE).as_posix())
def test_a_file_imports_from_its_own_room_and_from_below(path):
    room, *inside = parts_of(path)
    upwards = {
        name: line
        for name, line in imported(path).items()
        if name[0] in RANK and RANK[name[0]] < RANK[room]
    }
    assert not upwards, f"{path.name} imports from a room above its own: {upwards}"
    ranks = {name: rank for rank, name in enumerate(SUB_ROOMS.get(room, ()))}
    if inside == ["__init__"] or not ranks:
        return
    upwards = {
        name: line
        for name, line in imported(path).items()
        if name[0] == room and len(name) > 1 and ranks.get(name[1], 99) < ranks[inside[0]]
    }
    assert not upwards, f"{path.name} imports from a part above its own: {upwards}"


def test_every_room_and_module_has_its_place():
    here = {
        path.stem
        for path in PACKAGE.iterdir()
        if (path.suffix == ".py" and not path.stem.startswith("__"))
        or (path / "__init__.py").is_file()
    }
    assert here == set(RANK)


@pytest.mark.parametrize("room", SUB_ROOMS)
def test_every_part_of_a_room_has_its_place(room):
    here = {
        path.stem
        for path in (PACKAGE / room).iterdir()
        if (path.suffix == ".py" and path.stem != "__init__") or (path / "__init__.py").is_file()
    }
    # Stand-ins are packages of their own.
    assert here | {"stand_ins"} == set(SUB_ROOMS[room]) | {"stand_ins"}


def test_no_folder_hides_what_is_in_it():
    """What mirrors a public package has as many files as that."""
    crowded = {
        folder.relative_to(PACKAGE).as_posix(): count
        for folder in (PACKAGE, *PACKAGE.rglob("*"))
        if folder.is_dir() and "stand_ins" not in folder.parts
        for count in [sum(1 for each in folder.glob("*.py") if each.stem != "__init__")]
        if count > (VERBS if folder.name == "cli" else MOST_FILES)
    }
    assert crowded == {}


def test_no_circle_of_imports_has_more_than_three_files():
    modules = {
        ".".join(("tracerisk", *parts_of(path))).removesuffix(".__init__"): path
        for path in PACKAGE.rglob("*.py")
        if "stand_ins" not in path.parts  # these follow the libraries that they stand for
    }
    circles = circles_of({name: imports_of(name, modules) for name in modules})
    assert [each for each in circles if len(each) > 3] == []


def imports_of(name: str, modules: dict[str, Path]) -> set[str]:
    """The modules that one imports, within functions too, but not for its types alone."""
    found = set()
    waiting: list[ast.AST] = [ast.parse(modules[name].read_text(encoding="utf-8"))]
    while waiting:
        for node in ast.iter_child_nodes(waiting.pop()):
            if isinstance(node, ast.If) and getattr(node.test, "id", "") == "TYPE_CHECKING":
                continue
            if isinstance(node, ast.ImportFrom) and node.module is not None:
                names = [f"{node.module}.{each.name}" for each in node.names]
                found |= {each if each in modules else node.module for each in names}
            waiting.append(node)
    return found & modules.keys()


def circles_of(imports: dict[str, set[str]]) -> list[set[str]]:
    """The sets of modules each of which leads to every other."""
    leads_to = {name: reached(name, imports) for name in imports}
    found: list[set[str]] = []
    for name in sorted(imports):
        if not any(name in each for each in found):
            circle = {each for each in leads_to[name] if name in leads_to[each]}
            found += [circle] if len(circle) > 1 else []
    return found


def reached(name: str, imports: dict[str, set[str]]) -> set[str]:
    found: set[str] = set()
    waiting = [name]
    while waiting:
        new = imports[waiting.pop()] - found
        found |= new
        waiting += new
    return found
