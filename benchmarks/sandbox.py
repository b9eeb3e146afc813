"""What the sandbox changes and costs: each controller traced with it and without it.

    python benchmarks/sandbox.py [--list controllers.csv --sources DIR] [--jobs N] [--repeat N]

Without a list these are the sample controllers; with one, the rows of it that give a trace. The
list and its sources are those of `corpus.py`. Each is traced in turn with `--sandbox require` and
`--sandbox off`, as often as `--repeat` says; their JSON is compared byte by byte. The cost is the
processor time of the whole command and all its processes, the median of the runs of each kind.
What is asked: the same bytes for every sample and for 98 % of the rows, and a cost of at most 10 %
and 0.05 s.
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
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

SAMPLES = Path(__file__).parents[1] / "sample_controllers"


@dataclass(frozen=True)
class Compared:
    """One controller, traced with the sandbox and without it."""

    name: str
    is_traced: bool
    """Whether the run without a sandbox gave a relevant function."""
    is_same: bool
    """Whether all runs gave the same bytes."""
    contained_s: float
    """Processor time with the sandbox [s], the median."""
    free_s: float
    """Processor time without it [s], the median."""


def traced(folder: Path, path: str, sandbox: str) -> tuple[bytes, float]:
    """Trace one controller; return its JSON, and the processor time that it took [s]."""
    with tempfile.TemporaryFile() as out:
        words = ["trace", path, "--sandbox", sandbox, "--json", "--quiet"]
        process = subprocess.Popen(
            [sys.executable, "-m", "tracerisk", *words],
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=out,
            stderr=subprocess.DEVNULL,
            env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"},
        )
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0)
        return out.read(), used.ru_utime + used.ru_stime


def compared(folder: Path, path: str, name: str, repeat: int) -> Compared:
    outputs: set[bytes] = set()
    seconds: dict[str, list[float]] = {"require": [], "off": []}
    is_traced = True
    for _ in range(repeat):
        for sandbox, kept in seconds.items():
            out, took_s = traced(folder, path, sandbox)
            outputs.add(out)
            kept.append(took_s)
            try:
                is_traced = bool((json.loads(out).get("trace") or {}).get("functions"))
            except json.JSONDecodeError:
                is_traced = False
            if not is_traced and sandbox == "off":
                return Compared(name, False, len(outputs) == 1, 0.0, 0.0)
    medians = [statistics.median(seconds[sandbox]) for sandbox in ("require", "off")]
    return Compared(name, is_traced, len(outputs) == 1, *medians)


def listed(options: argparse.Namespace) -> list[tuple[Path, str, str]]:
    """Return folder, path and name of each controller of a list; of the samples without one."""
    wanted = [(SAMPLES, path.name, path.name) for path in sorted(SAMPLES.glob("*.py"))]
    if options.list is not None:
        with options.list.open(encoding="utf-8") as stream:
            rows = list(csv.DictReader(line for line in stream if not line.startswith("#")))
        wanted = []
        for each in rows:
            folder = options.sources / f"{each['repo']}@{each['commit']}"
            folder = folder if (folder / each["path"]).is_file() else options.sources / each["repo"]
            wanted.append((folder, each["path"], f"{each['repo']}:{each['path']}"))
    return [each for each in wanted if options.only in each[2]]


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--list", type=Path)
    parser.add_argument("--sources", type=Path)
    parser.add_argument("--only", default="", help="only rows whose name holds this text")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--repeat", type=int, default=1)
    options = parser.parse_args()
    wanted = listed(options)
    with ThreadPoolExecutor(options.jobs) as pool:
        rows = [
            row
            for row in pool.map(
                lambda each: compared(each[0], each[1], each[2], options.repeat), wanted
            )
            if row.is_traced
        ]
    print("| controller | same bytes | with [s] | without [s] | ratio |")
    print("|---|---|---|---|---|")
    for row in rows:
        same = "yes" if row.is_same else "NO"
        ratio = row.contained_s / row.free_s
        print(f"| {row.name} | {same} | {row.contained_s:.2f} | {row.free_s:.2f} | {ratio:.2f} |")
    same_rows = sum(row.is_same for row in rows)
    added = [row.contained_s - row.free_s for row in rows]
    ratios = [row.contained_s / row.free_s for row in rows]
    print(f"\n{same_rows} of {len(rows)} give the same bytes ({same_rows / len(rows):.1%})")
    print(
        f"the sandbox adds {statistics.median(added):.3f} s of processor time, "
        f"{statistics.median(ratios) - 1:.1%} (medians)"
    )


if __name__ == "__main__":
    main()
