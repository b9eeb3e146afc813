"""Imports point one way, between the rooms and between the sub-rooms of a room.

Nothing below knows what stands above it. An import within a function counts as any other.
"""

import ast
import re
from functools import cache
from pathlib import Path

import pytest

from tracerisk.common.strong_components import strong_components

PACKAGE = Path(__file__).parents[1] / "tracerisk"

ROOMS = (
    "cli",
    "editor",
    "api",
    "pipeline",
    "report",
    "prm",
    "adder",
    "ros",
    "twin",
    "instrument",
)
"""From the top down."""
BELOW = ("trace", "config", "errors", "common")
"""What every room may import, and what imports no room."""
RANK = {room: rank for rank, room in enumerate(ROOMS)} | dict.fromkeys(BELOW, len(ROOMS))
REST = "the other files"
"""Of a room whose files work on each other, above its folders."""
SUB_ROOMS = {
    "adder": ("annotate", "figures", "sources", "merge", "lock", "blocks", "quantify"),
    "pipeline": (
        *(
            "dossier",
            "recordings",
            "pictures",
            "start",
            "failure_data",
            "review",
            "check",
            "mutation",
            "worlds",
            "evidence",
            "assessed",
            "annotate",
            "model",
            "scenarios",
            "freshness",
        ),
        *("run", "trace", "mission"),
        *("history", "robot", "launch", "launch_files", "workspace"),
    ),
    "ros": (
        *(
            "vendors",
            "twin_interfaces",
            "live",
            "stand_ins",
            "scenario",
            "imports",
            "keyboard",
            "gazebo",
            "moveit",
            "robot",
        ),
        *(
            "readings",
            "drafts",
            "transforms",
            "messages",
            "graph",
            "world",
            "time",
            "controller",
            "homogeneous",
        ),
        "distributions",
    ),
    "cli": (
        *(REST, "authors", "reviewers", "safety_engineers", "set_up", "parser", "verbs"),
        *("running", "serving", "reporting", "solving", "shared"),
    ),
    "report": (
        *(
            "png",
            "html",
            "model_files",
            "linked",
            "cut_sets",
            "model_answers",
            "mutants",
            "terminal",
        ),
        *("ci", "explain", "hardware_table", "functions_table", "run_figures", "assumed"),
        *("instances", "fmea", "worlds", "series", "diff", "tables"),
    ),
    "instrument": (
        *(REST, "native", "python_2", "marks", "source", "hidden_frames", "code_positions"),
    ),
    "prm": (
        *("notebook", "other_models", "formats", "review", "drawing", "questions", "hybrid"),
        *("trees", "numbers", "compiled", "display"),
    ),
    "prm/other_models": (
        *("properties", "formats", "logic", "linked", "event_trees", "bayes", "dynamic"),
        *("expressions", "markov", "cut_sets"),
    ),
    "common": (
        *(
            "settings",
            "field",
            "evidence",
            "hardware",
            "sandbox",
            "outcome",
            "worlds",
            "record",
            "acceptances",
            "verdict_codes",
            "version",
        ),
        *(
            "trace_json",
            "trace_log",
            "trace_display",
            "traced",
            "instance_name",
            "dependencies",
            "geometry",
            "limits",
        ),
        *("strong_components", "text", "campaign", "verdict", "function_ref"),
        "replaced_names",
    ),
    "twin": (
        *("workspace", "simulation", "recording", "motion", "faults", "physics"),
        *("looks", "model_files", "urdf", "robots"),
    ),
}
"""The parts of a room, from the top down."""
MOST_FILES = 15
"""In a folder, beside `__init__`: more hide what is there."""
FILES = sorted(
    path
    for path in PACKAGE.rglob("*.py")
    if path.relative_to(PACKAGE).as_posix() not in ("__init__.py", "__main__.py")
)
STATEMENTS = (ast.stmt, ast.excepthandler, ast.match_case)
OURS, TYPES = "tracerisk.", "TYPE_CHECKING"


def parts_of(path: Path) -> tuple[str, ...]:
    return path.relative_to(PACKAGE).with_suffix("").parts


@cache
def imports_in(path: Path) -> list[tuple[str, int, bool]]:
    """What a file imports of tracerisk: module and name, the line, and whether for types alone."""
    found: list[tuple[str, int, bool]] = []
    waiting: list[tuple[ast.AST, bool]] = [(ast.parse(path.read_bytes()), False)]
    while waiting:
        above, for_types = waiting.pop()
        for node in ast.iter_child_nodes(above):
            names: list[str] = []
            if isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom) and node.level:
                # A stand-in is a package of its own, and a relative import stays in it.
                assert "stand_ins" in path.parts, f"{path}:{node.lineno}: relative import"
            elif isinstance(node, ast.ImportFrom):
                names = [f"{node.module}.{alias.name}" for alias in node.names]
            elif isinstance(node, STATEMENTS):
                is_types = isinstance(node, ast.If) and getattr(node.test, "id", "") == TYPES
                waiting.append((node, for_types or is_types))
            found += [(each, node.lineno, for_types) for each in names if each.startswith(OURS)]
    return found


def imported(path: Path) -> dict[tuple[str, ...], int]:
    """What a file imports of tracerisk: the parts of each name, with the line."""
    return {tuple(name.split(".")[1:]): line for name, line, _ in imports_in(path)}


@pytest.mark.parametrize("room", RANK)
def test_a_room_imports_from_itself_and_from_below(room):
    upwards = {
        f"{path.relative_to(PACKAGE)}:{line}": ".".join(name)
        for path in FILES
        if parts_of(path)[0] == room
        for name, line in imported(path).items()
        if name[0] in RANK and RANK[name[0]] < RANK[room]
    }
    assert upwards == {}


@pytest.mark.parametrize("room", SUB_ROOMS)
def test_a_part_of_a_room_imports_from_itself_and_from_below(room):
    parts = SUB_ROOMS[room]
    ranks = {name: rank for rank, name in enumerate(parts)}
    above = tuple(room.split("/"))
    depth = len(above)
    upwards = {
        f"{path.relative_to(PACKAGE)}:{line}": ".".join(name)
        for path in FILES
        if parts_of(path)[:depth] == above and parts_of(path)[depth:] != ("__init__",)
        for name, line in imported(path).items()
        if name[:depth] == above and len(name) > depth
        if ranks.get(name[depth], 0 if REST in parts else 99)
        < ranks.get(parts_of(path)[depth], 0 if REST in parts else -1)
    }
    assert upwards == {}


FOR_MODELS = {
    *(
        "cli/safety_engineers/convert",
        "cli/safety_engineers/cut_sets",
        "cli/solving/figure_options",
        "cli/solving",
        "cli/shared/model_files",
    ),
    *("pipeline/dossier/dossier", "report/model_files", "report/linked", "report/cut_sets"),
    *("prm/__init__", "prm/notebook", "prm/other_models"),
}
"""What is for models of any tool, and not for controllers alone."""


def test_only_what_is_for_models_of_any_tool_knows_those_of_other_tools():
    users = {
        "/".join(parts_of(path))
        for path in FILES
        if any(name[:2] == ("prm", "other_models") for name in imported(path))
    }
    assert {
        user
        for user in users
        if not any(user == place or user.startswith(f"{place}/") for place in FOR_MODELS)
    } == set()


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
    parts = set(SUB_ROOMS[room])
    if REST in parts:
        here = {part for part in here if (PACKAGE / room / part).is_dir() or part in parts} | {REST}
    # Stand-ins are packages of their own.
    assert here | {"stand_ins"} == parts | {"stand_ins"}


def test_no_folder_hides_what_is_in_it():
    """What mirrors a public package has as many files as that."""
    crowded = {
        folder.relative_to(PACKAGE).as_posix(): count
        for folder in (PACKAGE, *PACKAGE.rglob("*"))
        if folder.is_dir() and "stand_ins" not in folder.parts
        for count in [sum(1 for each in folder.glob("*.py") if each.stem != "__init__")]
        if count > MOST_FILES
    }
    assert crowded == {}


def test_each_folder_of_tests_is_named_after_the_folder_that_it_tests():
    tests = Path(__file__).parent
    folders = {path.parent.relative_to(tests) for path in tests.rglob("test_*.py")}
    apart = ("fuzz", "probe")  # the readers of every room, and a distribution of its own
    missing = {folder for folder in folders if not (PACKAGE / folder).is_dir()}
    assert sorted(str(folder) for folder in missing if folder.parts[0] not in apart) == []


READERS = re.compile(
    r"(?<!def )\b(find_prefixes|find_workspace|project_top|read_lock|ProjectSettings)\("
)
SERVING = re.compile(r"^(def )?__getattr__\b", re.MULTILINE)


def test_only_a_project_reads_what_belongs_to_a_root():
    """Who reads the lock or looks for packages anew does what the controller's project has done."""
    assert files_with(READERS) == {"pipeline/workspace/project"}


def test_a_package_names_what_it_offers_in_plain_imports():
    """A name that `__getattr__` serves has no definition that a reader finds.

    `prm` alone does so: its public names are those of every kind of model, and who imports one of
    its modules waits for no other.
    """
    assert {file for file in files_with(SERVING) if "stand_ins" not in file} == {"prm/__init__"}


def files_with(pattern: re.Pattern[str]) -> set[str]:
    """The files in whose text a pattern is."""
    return {
        "/".join(parts_of(path))
        for path in FILES
        if pattern.search(path.read_text(encoding="utf-8"))
    }


def test_no_circle_of_imports_has_more_than_three_files_and_prm_has_none():
    modules = {
        ".".join(("tracerisk", *parts_of(path))).removesuffix(".__init__"): path
        for path in PACKAGE.rglob("*.py")
    }

    def leads_to(path: Path) -> set[str]:
        names = {name for name, _, for_types in imports_in(path) if not for_types}
        found = {name if name in modules else name.rpartition(".")[0] for name in names}
        return found & modules.keys()

    circles = [
        circle
        for circle in strong_components({name: leads_to(path) for name, path in modules.items()})
        if len(circle) > 1
    ]
    assert [circle for circle in circles if len(circle) > 3] == []
    # A model is solved by files that know it for its type alone.
    assert [circle for circle in circles if circle[0].startswith("tracerisk.prm.")] == []


def test_every_file_that_the_page_on_architecture_names_is_there():
    page = (PACKAGE.parent / "docs" / "architecture.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`([\w/]+\.py)`", page))
    root = PACKAGE.parent
    there = [
        "/" + path.relative_to(root).as_posix()
        for folder in (PACKAGE, root / "tests", root / "benchmarks")
        for path in folder.rglob("*.py")
    ]
    assert len(named) > 40
    assert not {each for each in named if not any(path.endswith(f"/{each}") for path in there)}


def test_the_walk_of_a_value_passes_no_file_twice():
    page = (PACKAGE.parent / "docs" / "architecture.md").read_text(encoding="utf-8")
    text = page.partition("## The walk of one value")[2].partition("\n## ")[0]
    walks = [re.findall(r"`([\w/]+\.py)`", walk) for walk in text.split("\n\n") if "→" in walk]
    assert len(walks) == 2
    for walk in walks:
        assert len(set(walk)) == len(walk) > 8
        assert all((PACKAGE / file).is_file() for file in walk)
