"""Whether a controller's threads as greenlets leave the same run as real threads.

    python benchmarks/greenlets.py [--list controllers.csv --sources DIR] [--jobs N]

Without a list these are the sample controllers; with one, the rows of it that give a trace. The
list and its sources are those of `corpus.py`. Failures branch off a run on greenlets, which counts
only where its trace is that of the run on threads; else each failure is run from the beginning.
What is asked: the same trace for every sample, and for 20 controllers of the lists.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import quick
from sandbox import listed

_MOST_S = 600


def one(path: Path) -> str:
    """Run a controller on threads and on greenlets; return what came of it, in a word or more."""
    from tracerisk import api
    from tracerisk.common import trace_json
    from tracerisk.errors import TraceRiskError
    from tracerisk.pipeline.robot.scenario_settings import with_scenario
    from tracerisk.pipeline.run.controller_run import run_again
    from tracerisk.pipeline.run.ended_run import RunOptions
    from tracerisk.pipeline.run.fault_run import nominal_run

    controller = api.load_controller(path)
    settings = with_scenario(api.load_settings(controller))
    try:
        nominal = nominal_run(controller, settings)
    except TraceRiskError:
        return "no trace"
    if not nominal.trace.functions:
        return "no trace"
    try:
        again = run_again(controller, nominal, settings, (), RunOptions(quiet=True), greenlets=True)
    except (TraceRiskError, RuntimeError) as error:
        return f"nothing to read: {error}"
    threads, greenlets = (
        trace_json.dumps(replace(controller_run.trace, inputs=()))
        for controller_run in (nominal, again)
    )
    return "same" if threads == greenlets else f"differs: {again.trace.end.message}"


def shown(folder: Path, path: str) -> str:
    """Return the same of a controller in a process of its own."""
    try:
        completed_process = subprocess.run(
            [sys.executable, str(Path(__file__).resolve()), "--one", path],
            cwd=folder,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"},
            timeout=_MOST_S,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return "takes too long"
    lines = [line for line in completed_process.stdout.splitlines() if line.startswith("found: ")]
    return lines[-1].removeprefix("found: ") if lines else "no trace"


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--list", type=Path)
    parser.add_argument("--sources", type=Path)
    parser.add_argument("--only", default="", help="only rows whose name holds this text")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--one", type=Path, help=argparse.SUPPRESS)
    options = quick.parsed(parser, sources=quick.checkouts)
    if options.quick and options.list is None:
        options.list = options.sources / "controllers.csv"
    if options.one is not None:
        print(f"found: {one(options.one)}")
        return
    wanted = listed(options)
    with ThreadPoolExecutor(options.jobs) as pool:
        results = list(pool.map(lambda item: shown(item[0], item[1]), wanted))
    rows = [
        (name, result)
        for (_, _, name), result in zip(wanted, results, strict=True)
        if result != "no trace"
    ]
    print("| controller | on greenlets |\n|---|---|")
    for name, result in rows:
        print(f"| {name} | {result} |")
    same = sum(result == "same" for _, result in rows)
    print(f"\n{same} of {len(rows)} leave the same trace")


if __name__ == "__main__":
    main()
