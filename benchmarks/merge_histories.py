"""Live through random histories of branches, and compare each refresh with what users typed.

A history is a git repository with a controller whose functions, classes and files are renamed,
moved, put into another order and reformatted on several branches, which are merged, rebased,
cherry-picked, reverted and squashed; figures are set by hand, edited and taken out meanwhile. The
controller is of Python, in one file or in several, or of C++. After each refresh: nothing that was
set by hand is lost, nothing is set by hand that nobody typed, a second refresh changes nothing, and
where `check` is silent, no value is stale.

Each FORMATTER is a command that takes a file's name, for Python or for C++ by its name
(`clang-format`); by default those of a few that are installed. Printed are the seeds that fail.

    python benchmarks/merge_histories.py [--histories N] [--first SEED] [--jobs N] [--formatter ...]
"""

from __future__ import annotations

import argparse
import os
import shlex
import shutil
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import quick

sys.path.insert(0, str(Path(__file__).parents[1]))

from tests.pipeline.history.merge_histories import run_history
from tests.pipeline.history.renaming_histories import run_renaming_history

KINDS = ("one file", "python", "cpp")
FORMATTERS = (
    *("black -q", "ruff format -q", "yapf -i", "autopep8 -i -a", "pyink -q", "isort -q"),
    *(f"clang-format -i --style={name}" for name in ("LLVM", "GNU", "Mozilla")),
)
_SEEDS_OF_QUICK = 3


def lived_through(formatters: Sequence[str], seed: int) -> tuple[int, str]:
    """Return how often the tool stopped in the history of a seed, and what was wrong in it."""
    kind = KINDS[seed % len(KINDS)]
    commands = [
        shlex.split(command)
        for command in formatters
        if ("clang-format" in command) == (kind == "cpp")
    ]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "r")
        try:
            if kind == "one file":
                return run_history(path, seed), ""
            return run_renaming_history(path, seed, kind, commands), ""
        except Exception as error:  # noqa: BLE001 - of whatever kind, it is looked for
            return 0, f"{type(error).__name__}: {error}"


def main() -> int:
    """Live through all histories and print what they say."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--histories", type=int, default=600, help="how many")
    parser.add_argument("--first", type=int, default=0, help="the seed of the first")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--formatter", action="append", help="a command; may be repeated")
    options = quick.parsed(
        parser, histories=lambda: _SEEDS_OF_QUICK, jobs=lambda: 1, formatter=lambda: ["true"]
    )
    given = options.formatter or [one for one in FORMATTERS if shutil.which(one.split()[0])]
    seeds = range(options.first, options.first + options.histories)
    began, stops, wrong = time.monotonic(), 0, Counter[str]()
    with ProcessPoolExecutor(options.jobs) as pool:
        done = pool.map(partial(lived_through, given), seeds)
        for seed, (count, reason) in zip(seeds, done, strict=True):
            stops += count
            if reason:
                kind = KINDS[seed % len(KINDS)]
                wrong[kind] += 1
                print(f"  seed {seed}, {kind}: {reason}", flush=True)
    each = ", ".join(f"{kind}: {wrong[kind]}" for kind in KINDS)
    print(
        f"{len(seeds)} histories, {len(given)} formatters; the tool stopped at an edit {stops} "
        f"times; wrong {sum(wrong.values())} ({each}); {time.monotonic() - began:.0f} s"
    )
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
