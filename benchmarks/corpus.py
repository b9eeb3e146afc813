"""Run real public controllers, each in a process of its own and with no hint, and tabulate them.

The list is a CSV file with the columns `repo` (owner/name), `path`, `commit`. The sources are
checkouts below a folder: DIR/owner/name, or DIR/owner/name@commit where a list names several.
Nothing is written into them.

Controllers import third-party packages of their own (`pyquaternion`, `pin`, `transforms3d`,
`opencv-python-headless`, `trimesh`, `scikit-image`, ...): install them beside tracerisk, as their
users do. Those that a row missed are listed below the table; compiled parts of a controller's own
workspace, and libraries that speak to hardware past ROS, cannot be installed so.

    python benchmarks/corpus.py --list controllers.csv --sources DIR [--jobs N] [--only TEXT]

`corpus_classes.csv` beside this program lists rows with a class and the reason for it. Class `a`
cannot give a trace by what it is: another language version, hardware past ROS, no arm commanded,
a defect of its own that raises on a real ROS too. Of the other rows those count whose verdict is
`complete` or `partial` with a command carried out, within the time allowed; one that ends `faulted`
counts only in class `f`: the same fails on a real ROS.

With `--scenarios DIR` each runs with the file that `tracerisk scenario --write` makes of it, as it
is; the files stay in that folder. Its seconds are those of the run with the file.

`corpus_truth.csv` beside it is the judgement by hand of 40 rows that give a trace, the first by
the SHA-256 of `repo:path`: whether the robot is the author's or an assumption that is reported,
whether the steps are the author's functions, and whether all motions are made or reported.
"""

from __future__ import annotations

import argparse
import contextlib
import csv
import json
import os
import re
import subprocess
import sys
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import quick

TIMEOUT_S = 240.0
ALLOWED_S = 120.0
CLASSES = Path(__file__).with_name("corpus_classes.csv")
DRAFTING_S = 1200.0  # a scenario is found by several runs
RULES = {"quiescent", "duration", "cycles"}
_MISSED = re.compile(r"No module named '([\w.]+)'")


@dataclass(frozen=True)
class Row:
    """What became of one controller."""

    name: str
    outcome: str
    seconds: float
    functions: int
    components: tuple[str, ...]
    cause: str
    verdict: str = ""
    """What the run says of itself; empty where it says nothing."""
    is_traced: bool = False
    """Whether the run came to a good end, with a relevant function."""

    def counts(self, kind: str) -> bool:
        """Whether a row of this class (`a`, `f` or none) gave what was wanted of it in time."""
        wanted = {"complete", "partial", "faulted"} if kind == "f" else {"complete", "partial"}
        return self.is_traced and self.verdict in wanted and self.seconds <= ALLOWED_S


def run(repo: str, commit: str, path: str, sources: Path, scenarios: Path | None) -> Row:
    """Run one controller, with a scenario below `scenarios` if that is one, and say what became."""
    name = f"{repo}:{path}"
    checkout = sources / f"{repo}@{commit}"
    if not (checkout / path).is_file():
        checkout = sources / repo
    if not (checkout / path).is_file():
        return Row(name, "absent", 0.0, 0, (), "the file is not in the checkout")
    given: list[str] = []
    if scenarios is not None:
        file = (scenarios / f"{repo}-{path}.yaml".replace("/", "_")).resolve()
        file.unlink(missing_ok=True)
        with contextlib.suppress(subprocess.TimeoutExpired):
            _tracerisk(["scenario", path, "--write", "-o", str(file)], checkout, DRAFTING_S)
        given = ["--scenario", str(file)] if file.exists() else []
    began = time.monotonic()
    try:
        done = _tracerisk(["run", path, "--check", *given], checkout, TIMEOUT_S)
    except subprocess.TimeoutExpired:
        return Row(name, "HANGS", TIMEOUT_S, 0, (), f"no end within {TIMEOUT_S:g} s")
    seconds = time.monotonic() - began
    try:
        loads = json.loads(done.stdout)
    except json.JSONDecodeError:
        last = done.stderr.decode(errors="replace").strip().splitlines()[-1:]
        return Row(name, "FAULT", seconds, 0, (), " ".join(last)[:200])
    return _row(name, seconds, loads)


def _tracerisk(words: list[str], folder: Path, most_s: float) -> subprocess.CompletedProcess[bytes]:
    return subprocess.run(
        [sys.executable, "-m", "tracerisk", *words, "--json", "--quiet"],
        cwd=folder,
        capture_output=True,
        stdin=subprocess.DEVNULL,
        env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"},
        timeout=most_s,
        check=False,
    )


def _row(name: str, seconds: float, found: dict[str, Any]) -> Row:
    trace = found.get("trace") or {}
    functions = len(trace.get("functions", ()))
    active = sorted(
        element
        for element, exposure in trace.get("active", {}).items()
        if exposure["active_s"] > 0.05
    )
    end = trace.get("end", {}).get("cause")
    error = found.get("error") or {}
    cause = " ".join(str(error.get("message") or "").split())[:160]
    if error.get("line"):
        cause = f"{error['file']}:{error['line']}: {cause}"
    is_traced = functions > 0 and found["exit_code"] in (0, 1)
    outcome = _outcome(found, error, end)
    verdict = str((found.get("verdict") or {}).get("kind", ""))
    return Row(name, outcome, seconds, functions, tuple(active), cause, verdict, is_traced)


def _outcome(found: dict[str, Any], error: dict[str, Any], end: str | None) -> str:
    if found["exit_code"] == 5:
        return "FAULT"
    if error.get("kind") == "SourceError":
        return "bad source"
    if end == "not_importable":
        return "unsupported"
    if end == "deadlock":
        return "waits"
    if found["exit_code"] in (0, 1):
        return "stopped by rule" if end in RULES else "ended"
    if end is None:
        return "refused"
    return end


def classes(path: Path = CLASSES) -> dict[str, str]:
    """The class of each row that has one, by `repo:path`.

    Raises:
        ValueError: A class that is neither `a` nor `f`, or a row without a reason.
    """
    with path.open(encoding="utf-8") as stream:
        tables = list(csv.DictReader(stream))
    for fields in tables:
        if fields["class"] not in ("a", "f") or not fields["reason"]:
            raise ValueError(
                f"{path.name}: {fields['repo']}:{fields['path']}: no class or no reason"
            )
    return {f"{fields['repo']}:{fields['path']}": fields["class"] for fields in tables}


def shares(rows: list[Row], kinds: dict[str, str]) -> str:
    """How many of the rows that can give a trace did so in time, and which took too long."""
    able = [row for row in rows if kinds.get(row.name) != "a"]
    good = sum(row.counts(kinds.get(row.name, "")) for row in able)
    share = f" ({good / len(able):.1%})" if able else ""
    late = [row.name for row in rows if row.seconds > ALLOWED_S]
    text = f"took longer: {', '.join(late)}" if late else "none took longer"
    return (
        f"{good} of {len(able)} rows outside class a{share} are complete or partial "
        f"within {ALLOWED_S:g} s; {text}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--list", type=Path)
    parser.add_argument("--sources", type=Path)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--only", default="", help="only rows whose name holds this text")
    parser.add_argument("--scenarios", type=Path, help="a folder for a scenario of each row")
    options = quick.parsed(parser, sources=quick.checkouts)
    if options.quick and options.list is None:
        options.list = options.sources / "controllers.csv"
    if options.list is None or options.sources is None:
        parser.error("give --list controllers.csv and --sources DIR")
    if options.scenarios is not None:
        options.scenarios.mkdir(parents=True, exist_ok=True)
    with options.list.open(encoding="utf-8") as stream:
        listed = list(csv.DictReader(line for line in stream if not line.startswith("#")))
    wanted = [fields for fields in listed if options.only in f"{fields['repo']}:{fields['path']}"]
    with ThreadPoolExecutor(options.jobs) as pool:
        rows = list(
            pool.map(
                lambda item: run(
                    item["repo"],
                    item["commit"],
                    item["path"],
                    options.sources,
                    options.scenarios,
                ),
                wanted,
            )
        )
    kinds = classes()
    print("| controller | class | outcome | verdict | s | functions | active | cause |")
    print("|---|---|---|---|---|---|---|---|")
    for row in rows:
        active = ", ".join(row.components)
        print(
            f"| {row.name} | {kinds.get(row.name, '')} | {row.outcome} | {row.verdict} "
            f"| {row.seconds:.1f} | {row.functions} | {active} | {row.cause.replace('|', '/')} |"
        )
    traced = sum(row.is_traced for row in rows)
    counts = ", ".join(
        f"{n} {outcome}" for outcome, n in Counter(r.outcome for r in rows).most_common()
    )
    print(f"\n{traced} of {len(rows)} gave a trace with a relevant function; {counts}")
    print(f"\n{shares(rows, kinds)}")
    missed = Counter(matched[1] for row in rows if (matched := _MISSED.search(row.cause)))
    if missed:
        text = ", ".join(f"{name} ({n})" for name, n in sorted(missed.items()))
        print(f"\nModules that rows missed: {text}")


if __name__ == "__main__":
    main()
