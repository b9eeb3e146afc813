"""How the package is built: files and lines by room, cycles of imports, what a verb loads.

    python benchmarks/structure.py [PACKAGE]

PACKAGE is the folder of another checkout's package, to compare two of them. Lines are lines of
code: neither comments, docstrings nor blank ones count. An import within a function counts as an
import, and is counted apart; one under TYPE_CHECKING does not count, for nothing is loaded by it.
"""

from __future__ import annotations

import argparse
import ast
import io
import os
import shutil
import subprocess
import sys
import tempfile
import tokenize
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path

import networkx as nx
import quick

SKIPPED = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT}
VERBS = ("check", "solve", "run")
PROJECT = "tracerisk.pipeline.workspace.project"
PARTS_OF_PROJECT = frozenset(
    {"find_prefixes", "find_workspace", "project_top", "read_lock", "read_settings"}
)
QUICK_PACKAGE = {"cell/__init__.py": "", "cell/pick.py": "import cell.place"}
CONTROLLER = Path(__file__).parents[1] / "sample_controllers" / "pick_and_place.py"


def docstring_lines(tree: ast.Module) -> set[int]:
    """Return the lines of all docstrings, and of texts that stand below a name."""
    lines: set[int] = set()
    for node in ast.walk(tree):
        for item in (
            getattr(node, "body", ()) if isinstance(getattr(node, "body", ()), list) else ()
        ):
            if isinstance(item, ast.Expr) and isinstance(item.value, ast.Constant):
                lines |= set(range(item.lineno, (item.end_lineno or item.lineno) + 1))
    return lines


def code_lines(source: str) -> int:
    """Return how many lines hold code."""
    lines: set[int] = set()
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type not in SKIPPED and token.string:
            lines |= set(range(token.start[0], token.end[0] + 1))
    return len(lines - docstring_lines(ast.parse(source)))


def imports(tree: ast.Module) -> Iterator[tuple[str, bool]]:
    """Yield the names that a module imports of tracerisk, and whether within a function.

    What it imports for its types alone is left out.
    """
    for_types = {
        id(item)
        for node in ast.walk(tree)
        if isinstance(node, ast.If) and getattr(node.test, "id", "") == "TYPE_CHECKING"
        for item in ast.walk(node)
    }
    inside = {
        id(item)
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
        for item in ast.walk(node)
    }
    for node in ast.walk(tree):
        if id(node) in for_types:
            continue
        if isinstance(node, ast.ImportFrom) and node.module and not node.level:
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        elif isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        else:
            continue
        yield from ((name, id(node) in inside) for name in names if name.startswith("tracerisk."))


def serves_names(name: str, tree: ast.Module) -> bool:
    """Return whether a module serves names that it does not define; those of others must."""
    own = [getattr(node, "name", "") for node in tree.body]
    own += [
        getattr(target, "id", "")
        for node in tree.body
        if isinstance(node, ast.Assign)
        for target in node.targets
    ]
    return "__getattr__" in own and ".stand_ins." not in name


def read_anew(tree: ast.Module) -> Iterator[str]:
    """Yield the calls of what reads a part of a project that a `Project` has read already."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            called = getattr(node.func, "id", "")
            if called in PARTS_OF_PROJECT:
                yield called


def loaded_lines(verb: str, package: Path, lines: Mapping[str, int]) -> int:
    """Return how many lines of the package a verb loads, or has loaded when it fails."""
    code = (
        # With words of ours `main` returns: the process is not its own to end.
        "import sys\nfrom tracerisk.cli import main\n"
        f"try: main(['{verb}', '{CONTROLLER.name}'])\nexcept SystemExit: pass\n"
        "print('loaded:', *(name for name in sys.modules if name.startswith('tracerisk')))"
    )
    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(CONTROLLER, folder)  # a run writes into it
        done = subprocess.run(
            [sys.executable, "-c", code],
            cwd=folder,
            env={**os.environ, "PYTHONPATH": str(package.parent)},
            capture_output=True,
            text=True,
            check=False,
        )
    names = done.stdout.rpartition("loaded:")[2].split()
    return sum(lines.get(name, 0) for name in names)


def main() -> None:
    """Print the figures of one package."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("package", nargs="?", type=Path, default=Path("tracerisk"))
    options = quick.parsed(parser, package=lambda: quick.folder(QUICK_PACKAGE) / "cell")
    package = options.package.resolve()
    graph = nx.DiGraph()
    trees, lines = {}, {}
    for path in sorted(package.rglob("*.py")):
        parts = path.relative_to(package.parent).with_suffix("").parts
        name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
        source = path.read_text(encoding="utf-8")
        trees[name], lines[name] = ast.parse(source), code_lines(source)
        graph.add_node(name)
    within = 0
    for name, tree in trees.items():
        for text, is_inside in imports(tree):
            target = text if text in trees else text.rpartition(".")[0]
            within += is_inside
            if target in trees and target != name:
                graph.add_edge(name, target)
    rooms: Counter[str] = Counter()
    files: Counter[str] = Counter()
    for name, count in lines.items():
        room = ".".join(name.split(".")[1:2]) or "(top)"
        rooms[room] += count
        files[room] += 1
    print("| room | files | lines of code |\n|---|---|---|")
    for room, count in sorted(rooms.items()):
        print(f"| {room} | {files[room]} | {count} |")
    print(f"| all | {len(lines)} | {sum(lines.values())} |")
    folders = Counter(
        path.parent.relative_to(package).as_posix()
        for path in package.rglob("*.py")
        if path.stem != "__init__" and "stand_ins" not in path.parts
    )
    crowded = [f"{folder} {count}" for folder, count in folders.most_common() if count > 15]
    print(f"\nfolders with more than 15 files: {len(crowded)} ({', '.join(crowded)})")
    cycles = sorted(
        (
            len(component)
            for component in nx.strongly_connected_components(graph)
            if len(component) > 1
        ),
        reverse=True,
    )
    print(f"cycles of imports: {len(cycles)}, of {', '.join(map(str, cycles))} modules")
    print(f"imports within functions: {within}")
    served = [name for name, tree in trees.items() if serves_names(name, tree)]
    print(f"packages that serve names by __getattr__: {len(served)} ({', '.join(served)})")
    readers = Counter(
        called for name, tree in trees.items() if name != PROJECT for called in read_anew(tree)
    )
    shown = ", ".join(f"{called} {count}" for called, count in sorted(readers.items()))
    print(f"parts of a project read past it: {readers.total()} ({shown})")
    for verb in VERBS[: 1 if options.quick else None]:
        print(f"lines loaded by {verb}: {loaded_lines(verb, package, lines)}")


if __name__ == "__main__":
    main()
