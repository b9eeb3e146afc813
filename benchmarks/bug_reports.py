"""Run small controllers made after public bug reports, and compare with what should happen.

    python benchmarks/bug_reports.py [--jobs 2] [--only TEXT] [--quick]

Each folder of `benchmarks/bug_reports` is a program with the defect of a public report, or its
repaired form; `reports.jsonl` has the address, what should happen, written down before any run, and
what an independent reader judged of the first run. Prints each verdict, and counts the defective
programs whose verdict is complete and the sound ones whose verdict is faulted or stuck: candidates
to read, for a verdict alone does not say whether it names the defect.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import quick
from independent_missions import Mission, Ran, lay_out, run

REPORTS = Path(__file__).parent / "bug_reports"


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--only", default="", help="only reports whose defect holds this text")
    if not REPORTS.is_dir():
        quick.skip(f"{REPORTS} is not there: the reports are no part of this checkout")
    # Two programs.
    options = quick.parsed(parser)
    text = (REPORTS / "reports.jsonl").read_text(encoding="utf-8")
    reports: list[dict[str, Any]] = [json.loads(line) for line in text.splitlines()]
    chosen = [report for report in reports if options.only in report["defect"]]
    chosen = chosen[:2] if options.quick else chosen
    with tempfile.TemporaryDirectory() as where, ThreadPoolExecutor(options.jobs) as pool:

        def one(report: dict[str, Any]) -> Ran:
            folder = REPORTS / report["id"]
            (script,) = folder.rglob("controller.py")
            name = script.relative_to(folder).as_posix()
            mission, place = Mission(report["id"], name, (), folder), Path(where, report["id"])
            lay_out(mission, place)
            return run(mission, place)

        rans = list(pool.map(one, chosen))
    print("| report | program | verdict | first reason |\n|---|---|---|---|")
    for report, ran in zip(chosen, rans, strict=True):
        kind = "defective" if report["defective"] else "sound"
        print(f"| {report['id']} | {kind} | {ran.verdict} | {ran.words[:100]} |")
    pairs = [(report["defective"], ran.verdict) for report, ran in zip(chosen, rans, strict=True)]
    silent = sum(is_defective and verdict == "complete" for is_defective, verdict in pairs)
    blamed = sum(not bad and verdict in ("faulted", "stuck") for bad, verdict in pairs)
    print(f"\n{silent} defective programs are complete, {blamed} sound ones faulted or stuck")
    return 0


if __name__ == "__main__":
    sys.exit(main())
