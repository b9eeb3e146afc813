"""Solve Open-PSA fault trees exactly, beside SCRAM: seconds, memory and errors of each model.

    python benchmarks/fault_trees.py --models DIR [--peer scram] [--models-only a,b] [--cut-sets]

DIR holds Open-PSA XML files and `expected.csv` with the columns model and p_top: the figure that
is known, in as many digits as are known, or nothing.

- warm: our seconds in this process, from the file to the probability, the least of some runs.
- cold: wall seconds of a process that does the same and nothing else, its start included.
- peak: that process's greatest memory, [MB].
- peer: wall seconds of SCRAM's fastest exact run, a diagram with products of one event only.
- ratio: the peer's wall seconds to ours, warm.
- to expected, to order: relative errors, against `expected.csv` (no more digits than that has)
  and against a diagram whose events are in another order.
- cut sets: our warm seconds for the probability and all minimal cut sets, and the peer's.
"""

from __future__ import annotations

import argparse
import csv
import gc
import resource
import shutil
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path

from tracerisk.errors import TooLargeError
from tracerisk.prm.bdd import SharedTree
from tracerisk.prm.bdd.diagram import Limits
from tracerisk.prm.formats.open_psa import read_open_psa
from tracerisk.prm.numbers.probability import Probability
from tracerisk.prm.trees.fault_tree import FaultTree

TIMES = 3
"""How often each of our warm runs is repeated; the least counts."""

LONG_S = 2.0
"""A run that takes longer is not repeated."""

MOST_ERROR = 1e-12


@dataclass(frozen=True)
class Row:
    """What was measured of one model; None where it was not, or where time or nodes ran out."""

    model: str
    p_top: float | None
    warm_s: float | None
    cold_s: float | None
    peak_mb: float | None
    peer_s: float | None
    to_expected: float | None
    to_order: float | None
    cut_sets_s: float | None
    peer_cut_sets_s: float | None

    @property
    def ratio(self) -> float | None:
        """How many times longer the peer takes."""
        return self.peer_s / self.warm_s if self.peer_s and self.warm_s else None


def read(path: Path) -> tuple[FaultTree, dict[str, float]]:
    """Return a model's only tree and the values of its parameters."""
    model = read_open_psa(path)
    if len(model.tops) != 1:
        raise SystemExit(f"{path}: {len(model.tops)} tops ({', '.join(model.tops)}); one is needed")
    tree = model.fault_tree(model.tops[0])
    return tree, tree.values_at(0.0)


def top_of(path: Path) -> float:
    """Return a model's probability, from its file."""
    tree, values = read(path)
    return tree.probability(values).p


def top_by_other_order(path: Path) -> float:
    """Return the probability by a diagram with the neighbours of the order swapped."""
    tree, values = read(path)
    pairs = {event.name: Probability.of(values[event.parameter]) for event in tree.events}
    return SharedTree(tree, Limits(swapped=True)).probability(pairs).p


def with_cut_sets(path: Path) -> float:
    """Return the probability, after finding all minimal cut sets too."""
    from tracerisk.prm.cut_sets import minimal_cut_sets

    tree, values = read(path)
    minimal_cut_sets(tree)
    return tree.probability(values).p


def least_seconds(run: Callable[[Path], float], path: Path) -> tuple[float | None, float | None]:
    """Return what a run gives and its least seconds; nothing when it outgrows its budgets."""
    least: float | None = None
    found: float | None = None
    for _ in range(TIMES):
        gc.collect()
        began = time.perf_counter()
        try:
            found = run(path)
        except TooLargeError as error:
            print(f"  {path.stem}: {error}", file=sys.stderr)
            return None, None
        taken = time.perf_counter() - began
        least = taken if least is None else min(least, taken)
        if taken > LONG_S:
            break
    return found, least


def in_a_process(command: list[str], limit_s: float) -> float | None:
    """Return the wall seconds of a process; nothing when it fails or takes too long."""
    began = time.perf_counter()
    try:
        done = subprocess.run(command, capture_output=True, timeout=limit_s, check=False)
    except subprocess.TimeoutExpired:
        return None
    return time.perf_counter() - began if done.returncode == 0 else None


def cold(path: Path, limit_s: float) -> tuple[float | None, float | None]:
    """Return the wall seconds and the peak memory, [MB], of a process that solves a model."""
    began = time.perf_counter()
    try:
        done = subprocess.run(
            [sys.executable, __file__, "--solve", str(path)],
            capture_output=True,
            timeout=limit_s,
            check=False,
            text=True,
        )
    except subprocess.TimeoutExpired:
        return None, None
    taken = time.perf_counter() - began
    return (taken, float(done.stdout)) if done.returncode == 0 else (None, None)


def peak_mb() -> float:
    """Return the greatest memory of this process, [MB]; that of `getrusage` is its parent's too."""
    status = Path("/proc/self/status")
    if status.exists():
        fields = dict(line.split(":", 1) for line in status.read_text().splitlines())
        return float(fields["VmHWM"].split()[0]) / 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def error_to(expected: str, found: float | None) -> float | None:
    """Return the relative error to a figure in text, less what its digits leave open."""
    if not expected or found is None:
        return None
    known = Decimal(expected)
    exponent = known.as_tuple().exponent
    digits = len(known.as_tuple().digits)
    apart = abs(Decimal(found) - known)
    if digits < 15 and isinstance(exponent, int):
        apart = max(Decimal(0), apart - Decimal(10) ** exponent / 2)
    return float(apart / abs(known))


def measure(path: Path, expected: str, options: argparse.Namespace) -> Row:
    p_top, warm_s = least_seconds(top_of, path)
    cold_s, peak_mb = cold(path, options.time_limit) if p_top is not None else (None, None)
    other = top_by_other_order(path) if p_top is not None else None
    to_order = abs(other / p_top - 1.0) if other is not None and p_top else None
    peer_s = peer_cut_sets_s = cut_sets_s = None
    if options.cut_sets and p_top is not None:
        cut_sets_s = least_seconds(with_cut_sets, path)[1]
    if options.peer:
        run = [options.peer, "--probability", "1", "--bdd", str(path), "-o", "/dev/null"]
        peer_s = in_a_process([*run, "--limit-order", "1"], options.time_limit)
        if options.cut_sets:
            peer_cut_sets_s = in_a_process(run, options.time_limit)
    to_expected = error_to(expected, p_top)
    return Row(
        path.stem,
        p_top,
        warm_s,
        cold_s,
        peak_mb,
        peer_s,
        to_expected,
        to_order,
        cut_sets_s,
        peer_cut_sets_s,
    )


def told(value: float | None, form: str) -> str:
    return "-" if value is None else format(value, form)


def tell(row: Row, options: argparse.Namespace) -> None:
    parts = [
        f"{row.model:10}",
        f"{told(row.p_top, '.17g'):>23}",
        f"{told(row.warm_s, '.4f'):>8}",
        f"{told(row.cold_s, '.2f'):>6}",
        f"{told(row.peak_mb, '.0f'):>6}",
        f"{told(row.peer_s, '.3f'):>8}",
        f"{told(row.ratio, '.1f'):>7}",
        f"{told(row.to_expected, '.1e'):>11}",
        f"{told(row.to_order, '.1e'):>8}",
    ]
    if options.cut_sets:
        parts += [f"{told(row.cut_sets_s, '.3f'):>10}", f"{told(row.peer_cut_sets_s, '.3f'):>9}"]
    print(*parts, flush=True)


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--models", type=Path, help="folder of Open-PSA files and expected.csv")
    parser.add_argument("--models-only", default="", help="names of some models: a,b")
    parser.add_argument("--peer", choices=["scram"], help="solve with this one too")
    parser.add_argument("--cut-sets", action="store_true", help="time all minimal cut sets too")
    parser.add_argument("--time-limit", type=float, default=120.0, help="of a process, [s]")
    parser.add_argument("--solve", type=Path, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if not options.solve and not options.models:
        parser.error("give --models DIR")
    return options


def main() -> int:
    options = arguments()
    if options.solve:
        top_of(options.solve)
        print(peak_mb())
        return 0
    if options.peer and not shutil.which(options.peer):
        raise SystemExit(f"{options.peer} is not on the PATH; install it, or leave out --peer")
    expected = {}
    table = options.models / "expected.csv"
    if table.exists():
        with table.open(encoding="utf-8", newline="") as file:
            expected = {row["model"]: row["p_top"] for row in csv.DictReader(file)}
    paths = sorted(options.models.glob("*.xml"))
    if options.models_only:
        wanted = options.models_only.split(",")
        paths = [path for path in paths if path.stem in wanted]
    if not paths:
        raise SystemExit(f"no model in {options.models}; give a folder of .xml files")
    warm_up(paths)
    print(
        "model                        p_top   warm s cold s   peak   peer s   ratio to expected "
        "to order" + ("   cut sets  peer's" if options.cut_sets else "")
    )
    rows = []
    for path in paths:
        rows.append(measure(path, expected.get(path.stem, ""), options))
        tell(rows[-1], options)
    ratios = [row.ratio for row in rows if row.ratio is not None]
    if ratios:
        print(f"ratio: median {statistics.median(ratios):.1f}, least {min(ratios):.1f}")
    wrong = [
        row.model for row in rows if max(row.to_expected or 0.0, row.to_order or 0.0) > MOST_ERROR
    ]
    print(f"solved {sum(row.p_top is not None for row in rows)} of {len(rows)}")
    if wrong:
        print(f"relative error above {MOST_ERROR}: {', '.join(wrong)}")
    return 1 if wrong else 0


def warm_up(paths: list[Path]) -> None:
    """Load the compiled loops, as a process that has solved a tree before has them."""
    tree, values = read(paths[0])
    pairs = {event.name: Probability.of(values[event.parameter]) for event in tree.events}
    SharedTree(tree, Limits(small_nodes=0)).probability(pairs)


if __name__ == "__main__":
    sys.exit(main())
