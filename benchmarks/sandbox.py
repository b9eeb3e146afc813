"""What the sandbox changes and costs: each controller traced with it and without it.

    python benchmarks/sandbox.py [--list controllers.csv --sources DIR] [--jobs N] [--repeat N]
                                 [--python ENV/bin/python]

Without a list these are the sample controllers; with one, the rows of it that give a trace. The
list and its sources are those of `corpus.py`. Each is traced in pairs, with `--sandbox require` and
`--sandbox off`, as often as `--repeat` says, either first in turn; their JSON is compared byte by
byte. The cost is that of the whole command and all its processes, in processor and in wall time:
the median of each kind, and the mean of the differences of the pairs with its standard error, for
one pair differs by more than the sandbox costs. `--python` is that of another environment, such as
one with a wheel: of an editable installation each command first looks whether our modules are
compiled. What is asked: the same bytes for every sample and for 98 % of the rows, and a cost of at
most 10 % and 0.05 s.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import quick

SAMPLES = Path(__file__).parents[1] / "sample_controllers"


@dataclass(frozen=True)
class Compared:
    """One controller, traced with the sandbox and without it."""

    name: str
    is_traced: bool
    """Whether the run without a sandbox gave a relevant function."""
    is_same: bool
    """Whether all runs gave the same bytes."""
    contained: tuple[Cost, ...] = ()
    """The runs with the sandbox."""
    free: tuple[Cost, ...] = ()
    """The runs without it, each beside the one with it."""


@dataclass(frozen=True)
class Cost:
    """What one command took, with all its processes."""

    processor_s: float
    """Processor time [s]."""
    wall_s: float
    """Wall time [s]."""


def traced(python: Path, folder: Path, path: str, sandbox: str) -> tuple[bytes, Cost]:
    """Trace one controller; return its JSON, and what it took."""
    with tempfile.TemporaryFile() as out:
        words = ["trace", path, "--sandbox", sandbox, "--json", "--quiet"]
        began = time.perf_counter()
        process = subprocess.Popen(
            [python, "-m", "tracerisk", *words],
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=out,
            stderr=subprocess.DEVNULL,
            env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"},
        )
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0)
        took_s = time.perf_counter() - began
        return out.read(), Cost(used.ru_utime + used.ru_stime, took_s)


def compared(python: Path, folder: Path, path: str, name: str, repeat: int) -> Compared:
    outputs: set[bytes] = set()
    costs: dict[str, list[Cost]] = {"require": [], "off": []}
    is_traced = True
    for turn in range(repeat):
        for sandbox in sorted(costs, reverse=turn % 2 == 0):
            out, cost = traced(python, folder, path, sandbox)
            outputs.add(out)
            costs[sandbox].append(cost)
            try:
                is_traced = bool((json.loads(out).get("trace") or {}).get("functions"))
            except json.JSONDecodeError:
                is_traced = False
            if not is_traced and sandbox == "off":
                return Compared(name, False, len(outputs) == 1)
    is_same = len(outputs) == 1
    return Compared(name, is_traced, is_same, tuple(costs["require"]), tuple(costs["off"]))


def added(rows: Sequence[Compared], kind: str) -> str:
    """Return what the sandbox adds to a kind of time, in words."""
    pairs = [
        (getattr(contained, kind), getattr(free, kind))
        for row in rows
        for contained, free in zip(row.contained, row.free, strict=True)
    ]
    differences = [contained - free for contained, free in pairs]
    error_s = statistics.stdev(differences) / len(pairs) ** 0.5 if len(pairs) > 1 else float("nan")
    return (
        f"{1e3 * statistics.fmean(differences):+.0f} ms with a standard error of "
        f"{1e3 * error_s:.0f} ms, the median {1e3 * statistics.median(differences):+.0f} ms; "
        f"{sum(differences) / sum(free for _, free in pairs):+.1%} of all"
    )


def listed(options: argparse.Namespace) -> list[tuple[Path, str, str]]:
    """Return folder, path and name of each controller of a list; of the samples without one."""
    wanted = [(SAMPLES, path.name, path.name) for path in sorted(SAMPLES.glob("*.py"))]
    if options.list is not None:
        with options.list.open(encoding="utf-8") as stream:
            rows = list(csv.DictReader(line for line in stream if not line.startswith("#")))
        wanted = []
        for row in rows:
            folder = options.sources / f"{row['repo']}@{row['commit']}"
            folder = folder if (folder / row["path"]).is_file() else options.sources / row["repo"]
            wanted.append((folder, row["path"], f"{row['repo']}:{row['path']}"))
    return [row for row in wanted if options.only in row[2]]


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--list", type=Path)
    parser.add_argument("--sources", type=Path)
    parser.add_argument("--only", default="", help="only rows whose name holds this text")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--repeat", type=int, default=1)
    parser.add_argument("--python", type=Path, default=Path(sys.executable))
    options = quick.parsed(parser, sources=quick.checkouts)
    if options.quick and options.list is None:
        options.list = options.sources / "controllers.csv"
    wanted = listed(options)

    def measure(controller: tuple[Path, str, str]) -> Compared:
        return compared(options.python.absolute(), *controller, repeat=options.repeat)

    with ThreadPoolExecutor(options.jobs) as pool:
        rows = [row for row in pool.map(measure, wanted) if row.is_traced]
    print("| controller | same bytes | with [s] | without [s] | ratio |")
    print("|---|---|---|---|---|")
    for row in rows:
        with_s, without_s = (
            statistics.median(run.processor_s for run in runs) for runs in (row.contained, row.free)
        )
        print(
            f"| {row.name} | {'yes' if row.is_same else 'NO'} | {with_s:.2f} | {without_s:.2f} "
            f"| {with_s / without_s:.2f} |"
        )
    same_rows = sum(row.is_same for row in rows)
    print(f"\n{same_rows} of {len(rows)} give the same bytes ({same_rows / len(rows):.1%})")
    for kind, name in (("processor_s", "processor"), ("wall_s", "wall")):
        print(f"the sandbox adds to the {name} time of a run: {added(rows, kind)}")


if __name__ == "__main__":
    main()
