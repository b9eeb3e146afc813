"""Put a risk block into every function of every Python file, take it out, and compare bytes.

Without DIR: the standard library of the running interpreter, its tests included, and the
site-packages of its environment. Nothing is written.

    python benchmarks/lossless.py [DIR...] [--jobs N]

For each file that `ast.parse` accepts: the annotated source has the same syntax tree, every
block reads back as it was meant, a second insertion changes nothing, and removal gives back
every byte. A refusal is an error that says why; wrong is whatever else differs.
"""

from __future__ import annotations

import argparse
import ast
import os
import sys
import sysconfig
import time
import warnings
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from tracerisk.adder.blocks.block import ComponentEntry, RiskBlock
from tracerisk.adder.blocks.values import (
    computed_count,
    computed_next,
    computed_probability,
    computed_redundancy,
)
from tracerisk.adder.sources.definitions import MODULE, definitions, module_line, parse_python
from tracerisk.adder.sources.insert import insert_everywhere, strip_blocks
from tracerisk.adder.sources.read import scan_blocks
from tracerisk.errors import TraceRiskError
from tracerisk.hardware.redundancy import Redundancy
from tracerisk.trace import QualifiedName

VERDICTS = ("exact", "refused", "wrong")
_DEEPEST = 20_000


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of one file; `verdict` is exact, refused, wrong or no Python."""

    path: Path
    verdict: str
    functions: int = 0
    reason: str = ""


def check(path: Path) -> Outcome:
    """Insert, insert again and strip in memory, and say whether all bytes came back."""
    sys.setrecursionlimit(_DEEPEST)
    warnings.simplefilter("ignore")
    try:
        source = path.read_bytes()
        tree = ast.parse(source)
    except (OSError, SyntaxError, ValueError, RecursionError, MemoryError):
        return Outcome(path, "no Python")
    count = 0
    try:
        parsed = parse_python(source, str(path))
        sites = [(each.name, each.line) for each in definitions(parsed.tree)]
        count = len(sites)
        if parsed.tree.body:
            sites.append((MODULE, module_line(parsed)))
        after = insert_everywhere(source, {site: _block(site[0]) for site in sites}, str(path))
        placed = scan_blocks(parse_python(after, str(path)))
        again = {(each.function, each.line): each.block for each in placed}
        twice = insert_everywhere(after, again, str(path))
        stripped = strip_blocks(after, str(path))
    except TraceRiskError as error:
        return Outcome(path, "refused", count, error.message)
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
    return Outcome(path, "wrong" if wrong else "exact", count, "; ".join(wrong))


def _block(name: QualifiedName) -> RiskBlock:
    power = ComponentEntry(
        "power",
        computed_probability(6.674e-08),
        computed_count(2),
        computed_redundancy(Redundancy(True)),
    )
    return RiskBlock(name, computed_count(1), computed_next({"a": 9, "done": 1}), (power,))


def _same_tree(tree: ast.AST, after: bytes) -> bool:
    return ast.dump(tree) == ast.dump(ast.parse(after))


def python_files(folders: list[Path]) -> list[Path]:
    """Return every Python file below the folders, sorted, links not followed."""
    found = {
        Path(folder, name)
        for top in folders
        for folder, _, names in os.walk(top)
        for name in names
        if name.endswith(".py")
    }
    return sorted(found)


def report(title: str, outcomes: list[Outcome], seconds: float) -> int:
    """Print one line of figures and every refusal and wrong file; return how many are wrong."""
    counted = [each for each in outcomes if each.verdict != "no Python"]
    by = {verdict: [e for e in counted if e.verdict == verdict] for verdict in VERDICTS}
    functions = sum(each.functions for each in counted)
    print(
        f"{title}: {len(counted)} files that Python accepts ({len(outcomes) - len(counted)} not), "
        f"{functions} functions; exact {len(by['exact'])}, refused {len(by['refused'])}, "
        f"wrong {len(by['wrong'])}; {seconds:.0f} s"
    )
    for each in (*by["refused"], *by["wrong"]):
        print(f"  {each.verdict}: {each.path}: {each.reason}")
    return len(by["wrong"])


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folders", nargs="*", type=Path, metavar="DIR")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    options = parser.parse_args()
    stdlib, site = (Path(sysconfig.get_path(name)) for name in ("stdlib", "purelib"))
    suites: list[tuple[str, list[Path]]]
    if options.folders:
        suites = [(str(folder), python_files([folder])) for folder in options.folders]
    else:
        library = [path for path in python_files([stdlib]) if "site-packages" not in path.parts]
        suites = [("standard library", library), ("site-packages", python_files([site]))]
    wrong = 0
    for title, files in suites:
        began = time.monotonic()
        with ProcessPoolExecutor(options.jobs) as pool:
            outcomes = list(pool.map(check, files, chunksize=16))
        wrong += report(title, outcomes, time.monotonic() - began)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
