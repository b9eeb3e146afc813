"""Solve Storm's Galileo files, beside Storm: how many are solved, and whether figures agree.

    python benchmarks/storm_trees.py --inputs DIR [--peer stormpy]

DIR is resources/examples/testfiles/dft of github.com/moves-rwth/storm; it is not part of this
repository. Each file is solved for a mission of an hour, with 0.5 for each parameter that it
declares. Storm observes all elements, else it ignores that gates that no longer make a difference
still take spares; where that takes it more than a minute, none.
Printed is each file that is refused, by whom and why, and each where the two are apart.
"""

from __future__ import annotations

import argparse
import math
import multiprocessing
import sys
from collections import Counter
from contextlib import suppress
from pathlib import Path

import quick

from tracerisk.errors import TraceRiskError
from tracerisk.prm.other_models.formats import galileo

QUICK_TREES = {
    "either.dft": """\
toplevel "top";
"top" or "a" "b";
"a" lambda=0.1 dorm=0;
"b" lambda=0.2 dorm=0;
"""
}

MISSION_H = 1.0
VALUE = 0.5
"""What each parameter is."""
PATIENCE_S = 60.0


def storm_bounds(path: str, names: list[str]) -> tuple[float, float] | str:
    """Return the least and the greatest probability that Storm finds, or its reason for none."""
    import stormpy
    import stormpy.dft as dft

    figures = []
    try:
        loaded = dft.prepare_for_analysis(dft.load_dft_galileo_file(path))
        for measure in ("Pmin", "Pmax"):
            properties = stormpy.parse_properties(f'{measure}=? [F<={MISSION_H} "failed"]')
            observed = dft.compute_relevant_events(properties, additional_relevant_names=names)
            figures += dft.analyze_dft(loaded, properties, relevant_events=observed)
    except Exception as error:  # noqa: BLE001 - Storm's own are of many kinds
        return str(error).strip().splitlines()[0]
    return figures[0], figures[1]


def peer(path: Path, names: list[str]) -> tuple[float, float] | str:
    """Return what Storm finds, or why it finds nothing; some files end its process."""
    late = multiprocessing.TimeoutError
    for observed in (names, []):
        with multiprocessing.get_context("spawn").Pool(1) as pool, suppress(late):
            return pool.apply_async(storm_bounds, (str(path), observed)).get(PATIENCE_S)
    return f"nothing in {PATIENCE_S:g} s"


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--inputs", type=Path, help="folder of the files")
    parser.add_argument("--peer", choices=["stormpy"], help="solve with this one too")
    options = quick.parsed(parser, inputs=lambda: quick.folder(QUICK_TREES))
    if options.inputs is None:
        parser.error("give --inputs DIR")
    counts: Counter[str] = Counter()
    for path in sorted(options.inputs.rglob("*.dft")):
        name, text = str(path.relative_to(options.inputs)), path.read_text(encoding="utf-8")
        names: list[str] = []
        try:
            open_ones = galileo.parameter_names(text, name)
            tree = galileo.loads(text, name, dict.fromkeys(open_ones, VALUE))
            names = [element.name for element in (*tree.gates, *tree.events)]
            message: float | str = tree.solve(mission_time_h=MISSION_H).top.p
        except TraceRiskError as error:
            message = error.message
        if isinstance(message, str):
            outcome = "refused here"
        else:
            outcome = "solved, with values for parameters" if open_ones else "solved"
        counts[outcome] += 1
        other = peer(path, names) if options.peer else None
        if isinstance(message, str):
            print(f"{name}: {message}", flush=True)
        if isinstance(other, str):
            counts["refused by Storm"] += 1
            print(f"{name}: Storm: {other}", flush=True)
        elif other is not None and not isinstance(message, str):
            alike = all(
                math.isclose(message, value, rel_tol=1e-13, abs_tol=1e-15) for value in other
            )
            counts["alike" if alike else "apart"] += 1
            if not alike:
                print(f"{name}: {message!r}, Storm {other[0]!r} to {other[1]!r}", flush=True)
    for outcome, count in counts.most_common():
        print(f"{count:4} {outcome}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
