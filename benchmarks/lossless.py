"""Put a risk block into every function of every source, take it out, and compare bytes.

Without DIR: the standard library of the running interpreter, its tests included, and the
site-packages of its environment. Nothing is written.

    python benchmarks/lossless.py [DIR...] [--jobs N]

For each file of C and C++, and each of Python, 2 or 3, that can be read: the annotated source has
the same syntax tree, every block reads back as it was meant, a second insertion changes nothing,
and removal gives back every byte. A refusal is an error that says why; wrong is whatever else
differs. Of C and C++ functions whose names a block cannot hold (`operator!=`) and those that begin
behind other code on their line are left out, and counted.
"""

from __future__ import annotations

import argparse
import ast
import os
import sys
import sysconfig
import time
import warnings
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import quick

from tracerisk.adder.blocks.block import ComponentEntry, RiskBlock
from tracerisk.adder.blocks.values import (
    computed_count,
    computed_next,
    computed_probability,
    computed_redundancy,
    is_function_name,
)
from tracerisk.adder.sources.c_blocks import insert_c_at, scan_c_blocks
from tracerisk.adder.sources.c_source import parse_c
from tracerisk.adder.sources.insert import insert_at, strip_blocks
from tracerisk.adder.sources.python_lines import module_line, parse_python
from tracerisk.adder.sources.read import scan_blocks
from tracerisk.common.function_ref import QualifiedName
from tracerisk.common.hardware.redundancy import Redundancy
from tracerisk.errors import TraceRiskError
from tracerisk.instrument.source.function_definitions import MODULE, definitions
from tracerisk.instrument.source.language import is_c, is_c_like
from tracerisk.instrument.source.python_source import parsed as parsed_python

QUICK_SOURCES = {
    "plain.py": "def one():\n    return 1\n\n\nclass Two:\n    def three(self): return 3\n"
}

VERDICTS = ("exact", "refused", "wrong")
_DEEPEST = 20_000


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of one file; `verdict` is exact, refused, wrong or no Python."""

    path: Path
    verdict: str
    functions: int = 0
    left_out: int = 0
    reason: str = ""


def insert_everywhere(
    source: bytes, blocks: Mapping[tuple[QualifiedName, int], RiskBlock], file: str
) -> bytes:
    """Return the source with a block at each definition, given by its name and its line."""
    if is_c_like(file):
        return insert_c_at(parse_c(source, file), scan_c_blocks(source, file), blocks)
    parsed = parse_python(source, file)
    return insert_at(source, parsed, scan_blocks(parsed), blocks)


def check(path: Path) -> Outcome:
    """Insert, insert again and strip in memory, and say whether all bytes came back."""
    sys.setrecursionlimit(_DEEPEST)
    warnings.simplefilter("ignore")
    try:
        source = path.read_bytes()
        if is_c(path.name):
            return check_c(path, source)
        tree = parsed_python(source)
    except (OSError, MemoryError):
        return Outcome(path, "no Python")
    if tree is None:
        return Outcome(path, "no Python")
    count = 0
    try:
        parsed = parse_python(source, str(path))
        sites = [(definition.name, definition.line) for definition in definitions(parsed.tree)]
        count = len(sites)
        if parsed.tree.body:
            sites.append((MODULE, module_line(parsed)))
        after = insert_everywhere(source, {site: _block(site[0]) for site in sites}, str(path))
        placed = scan_blocks(parse_python(after, str(path)))
        again = {
            (placed_block.function, placed_block.line): placed_block.block
            for placed_block in placed
        }
        twice = insert_everywhere(after, again, str(path))
        stripped = strip_blocks(after, str(path))
    except TraceRiskError as error:
        return Outcome(path, "refused", count, reason=error.message)
    wrong = [
        reason
        for reason, holds in (
            ("removal gives other bytes", stripped == source),
            ("a second insertion changes something", twice == after),
            ("the syntax tree differs", _same_tree(tree, after)),
            (
                "blocks are missing",
                sorted(b.function for b in placed) == sorted(s[0] for s in sites),
            ),
            ("a block reads back as another", all(b.block == _block(b.function) for b in placed)),
        )
        if not holds
    ]
    return Outcome(path, "wrong" if wrong else "exact", count, reason="; ".join(wrong))


def check_c(path: Path, source: bytes) -> Outcome:
    """Do the same with a file of C or C++."""
    count = left_out = 0
    try:
        parsed = parse_c(source, str(path))
        sites = {
            (function.name, function.line): _block(function.name)
            for function in parsed.functions
            if function.site is not None and is_function_name(function.name)
        }
        count = len(sites)
        left_out = len({(function.name, function.line) for function in parsed.functions}) - count
        after = insert_everywhere(source, sites, str(path))
        placed = scan_c_blocks(after, str(path))
        again = {
            (placed_block.function, placed_block.line): placed_block.block
            for placed_block in placed
        }
        twice = insert_everywhere(after, again, str(path))
        stripped = strip_blocks(after, str(path))
        same = list(parsed.leaves()) == list(parse_c(after, str(path)).leaves())
    except TraceRiskError as error:
        return Outcome(path, "refused", count, left_out, error.message)
    wrong = [
        reason
        for reason, holds in (
            ("removal gives other bytes", stripped == source),
            ("a second insertion changes something", twice == after),
            ("the syntax tree differs", same),
            (
                "blocks are missing",
                sorted(b.function for b in placed) == sorted(s[0] for s in sites),
            ),
        )
        if not holds
    ]
    return Outcome(path, "wrong" if wrong else "exact", count, left_out, "; ".join(wrong))


def _block(name: QualifiedName) -> RiskBlock:
    power = ComponentEntry(
        "power",
        computed_probability(6.674e-08),
        computed_count(2),
        computed_redundancy(Redundancy(True)),
    )
    return RiskBlock(name, computed_count(1), computed_next({"a": 9, "done": 1}), (power,))


def _same_tree(tree: ast.AST, after: bytes) -> bool:
    tree_after = parsed_python(after)
    return tree_after is not None and ast.dump(tree) == ast.dump(tree_after)


def files_below(folders: list[Path]) -> list[Path]:
    """Return every Python, C and C++ file below the folders, sorted, links not followed."""
    files = {
        Path(folder, name)
        for top in folders
        for folder, _, names in os.walk(top)
        for name in names
        if name.endswith(".py") or is_c(name)
    }
    return sorted(files)


def report(title: str, outcomes: list[Outcome], seconds: float) -> int:
    """Print one line of figures and every refusal and wrong file; return how many are wrong."""
    counted = [outcome for outcome in outcomes if outcome.verdict != "no Python"]
    by = {verdict: [e for e in counted if e.verdict == verdict] for verdict in VERDICTS}
    functions = sum(outcome.functions for outcome in counted)
    left_out = sum(outcome.left_out for outcome in counted)
    print(
        f"{title}: {len(counted)} files that are read ({len(outcomes) - len(counted)} not), "
        f"{functions} functions and {left_out} left out; exact {len(by['exact'])}, "
        f"refused {len(by['refused'])}, wrong {len(by['wrong'])}; {seconds:.0f} s"
    )
    for outcome in (*by["refused"], *by["wrong"]):
        print(f"  {outcome.verdict}: {outcome.path}: {outcome.reason}")
    return len(by["wrong"])


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folders", nargs="*", type=Path, metavar="DIR")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    options = quick.parsed(parser, folders=lambda: [quick.folder(QUICK_SOURCES)], jobs=lambda: 1)
    stdlib, site = (Path(sysconfig.get_path(name)) for name in ("stdlib", "purelib"))
    suites: list[tuple[str, list[Path]]]
    if options.folders:
        suites = [(str(folder), files_below([folder])) for folder in options.folders]
    else:
        library = [path for path in files_below([stdlib]) if "site-packages" not in path.parts]
        suites = [("standard library", library), ("site-packages", files_below([site]))]
    wrong = 0
    for title, files in suites:
        began = time.monotonic()
        with ProcessPoolExecutor(options.jobs) as pool:
            outcomes = list(pool.map(check, files, chunksize=16))
        wrong += report(title, outcomes, time.monotonic() - began)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
