"""Read and solve SCRAM's own inputs, beside SCRAM: what both accept, and whether digits agree.

    python benchmarks/scram_inputs.py --inputs scram/input scram/tests/input [--time-limit 60]

The folders are those of github.com/rakhimov/scram; they are not part of this repository. Each file
is taken by itself: SCRAM validates it and solves it by diagrams for a mission of a year, without
common causes, and tops and sequences are compared to the six digits that it prints. Models with
alignments are left to the tests: SCRAM's report has a top once for each phase.
Printed is each file where the two are apart, or that one of them does not take, with the reason.
"""

from __future__ import annotations

import argparse
import math
import shutil
import subprocess
import sys
from collections import Counter
from pathlib import Path
from xml.etree import ElementTree as ET

import quick
from fault_trees import QUICK_MODELS

from tracerisk.errors import TraceRiskError
from tracerisk.prm.other_models.formats.open_psa import read_open_psa
from tracerisk.prm.other_models.logic.event_trees import solved_event_trees
from tracerisk.prm.other_models.logic.model import LogicModel

MISSION_H = 8760.0
SOLVE = ("--bdd", "--probability", "1", "--limit-order", "1", "--mission-time", str(MISSION_H))


def scram(arguments: tuple[str, ...], path: Path, limit_s: float) -> tuple[str, str]:
    """Return SCRAM's report, and its reason where there is none."""
    try:
        done = subprocess.run(
            ["scram", *arguments, str(path)], capture_output=True, text=True, timeout=limit_s
        )
    except subprocess.TimeoutExpired:
        return "", f"takes more than {limit_s:g} s"
    if done.returncode == 0:
        return done.stdout or " ", ""
    return "", " ".join(done.stderr.replace(str(path), "").split())[-100:] or "no reason"


def figures_of(report: str) -> dict[str, float]:
    """Return the tops and the sequences of a report."""
    root = ET.fromstring(report)
    tops = {
        element.get("name"): element.get("probability") for element in root.iter("sum-of-products")
    }
    sequences = {element.get("name"): element.get("value") for element in root.iter("sequence")}
    # The parts of event trees are listed as tops as well, by the names of their sequences.
    return {str(name): float(value) for name, value in {**tops, **sequences}.items() if value}


def ours(model: LogicModel) -> dict[str, float]:
    """Return the same of a model that was read here."""
    values = {}
    for top in model.tops:
        tree = model.fault_tree(top, mission_time_h=MISSION_H, common_cause=False)
        values[top] = tree.probability(tree.values_at(MISSION_H)).p
    if any(event_tree.tree.initiating is not None for event_tree in model.event_trees):
        for solution in solved_event_trees(model, MISSION_H, common_cause=False):
            values |= {sequence.name: sequence.value for sequence in solution.sequences}
    return values


def compared(path: Path, limit_s: float) -> tuple[str, str]:
    """Return what becomes of a file, and more of it where the two are apart."""
    valid, reason = scram(("--validate",), path, limit_s)
    try:
        model = read_open_psa(path)
    except TraceRiskError as error:
        return ("refused by both", "") if not valid else ("refused here alone", error.message)
    if not valid:
        return "read here alone", reason
    if model.alignments:
        return "with alignments, not compared", ""
    report, reason = scram(SOLVE, path, limit_s)
    if not report:
        return "not solved by SCRAM", reason
    try:
        values = ours(model)
    except TraceRiskError as error:
        return "not solved here", error.message
    printed = figures_of(report)
    apart = {
        name: (values.get(name), value)
        for name, value in printed.items()
        if name in values and not math.isclose(values[name], value, rel_tol=6e-6, abs_tol=1e-30)
    }
    if apart:
        return "apart", str(apart)
    return "alike", " ".join(printed.keys() & values.keys())


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--inputs", type=Path, nargs="+", help="folders of files")
    parser.add_argument("--time-limit", type=float, default=60.0, help="of SCRAM, [s]")
    options = quick.parsed(parser, inputs=lambda: [quick.folder(QUICK_MODELS)])
    if not options.inputs:
        parser.error("give --inputs DIR...")
    if shutil.which("scram") is None:
        quick.skip("scram is not on the PATH; https://github.com/rakhimov/scram")
    counts: Counter[str] = Counter()
    for folder in options.inputs:
        for path in sorted(folder.rglob("*.xml")):
            outcome, more = compared(path, options.time_limit)
            counts[outcome] += 1
            if outcome == "alike":
                counts["figures that are alike"] += len(more.split())
            elif outcome not in ("refused by both", "read here alone"):
                print(f"{path.relative_to(folder)}: {outcome}{more and f': {more}'}", flush=True)
    for outcome, count in counts.most_common():
        print(f"{count:4} {outcome}")
    return 1 if counts["apart"] or counts["refused here alone"] else 0


if __name__ == "__main__":
    sys.exit(main())
