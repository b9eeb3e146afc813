"""Solve Open-PSA fault trees exactly, beside SCRAM: seconds, memory and errors of each model.

    python benchmarks/fault_trees.py --models DIR [--peer scram] [--models-only a,b] [--cut-sets]
        [--python INSTALLED]

DIR holds Open-PSA XML files and `expected.csv` with the columns model and p_top: the figure that
is known, in as many digits as are known, or nothing.
Like is compared with like, process with process and analysis with analysis:

- cold: processor seconds (user and system) of a process that reads the file, solves it, prints the
  figure and does nothing else, its start included; its bytecode was written by one before it.
- command: the same of `tracerisk solve FILE`, which prints a table. What users have is a wheel in
  an environment of its own, whose Python `--python` names; by default it is this environment.
- peer cold: the same of SCRAM's fastest exact run, a diagram with products of one event only.
- warm: wall seconds in this process from the tree that was read to the probability.
- peer warm: what SCRAM's report says that its own analysis of the tree took.
- read: our wall seconds from the file to the tree, which is no part of warm.
- peak: the greatest memory of the process of cold, [MB].
- to expected, to order: relative errors, against `expected.csv` (no more digits than that has)
  and against a diagram whose events are in another order.
- cut sets: our warm seconds for the probability and all minimal cut sets, and the peer's.

Each time is the least of some runs; on a machine that is busy processor seconds vary less.
"""

from __future__ import annotations

import argparse
import csv
import gc
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
from xml.etree import ElementTree as ET

import quick

from tracerisk.errors import TooLargeError
from tracerisk.prm.numbers.probability import Probability
from tracerisk.prm.other_models.formats.open_psa import read_open_psa
from tracerisk.prm.trees.bdd import SharedTree
from tracerisk.prm.trees.bdd.diagram import Limits
from tracerisk.prm.trees.fault_tree import FaultTree

QUICK_MODELS = {
    "expected.csv": "model,p_top\none,0.136\n",
    "one.xml": """\
<opsa-mef>
 <define-fault-tree name="one">
  <define-gate name="top">
   <or><basic-event name="a"/><and><basic-event name="b"/><basic-event name="c"/></and></or>
  </define-gate>
 </define-fault-tree>
 <model-data>
  <define-basic-event name="a"><float value="0.1"/></define-basic-event>
  <define-basic-event name="b"><float value="0.2"/></define-basic-event>
  <define-basic-event name="c"><float value="0.2"/></define-basic-event>
 </model-data>
</opsa-mef>
""",
}

TIMES, MOST_TIMES = 3, 10
"""How often each run is repeated, and how often a short one; the least counts."""

SHORT_S, LONG_S = 0.05, 2.0
"""A run that takes less is a short one; one that takes more is not repeated."""

MOST_ERROR = 1e-12

PROGRAM = """
import sys
from tracerisk.prm.other_models.formats.open_psa import read_open_psa
model = read_open_psa(sys.argv[1])
tree = model.fault_tree(model.tops[0])
print(repr(tree.probability(tree.values_at(0.0)).p))
for line in open("/proc/self/status"):
    if line.startswith("VmHWM"):
        print(int(line.split()[1]) / 1024)
"""
"""What a process of `cold` does; the last line is its greatest memory, [MB]."""


@dataclass(frozen=True)
class Row:
    """What was measured of one model; None where it was not, or where time or nodes ran out."""

    model: str
    p_top: float | None
    cold_s: float | None
    command_s: float | None
    peer_cold_s: float | None
    read_s: float | None
    warm_s: float | None
    peer_warm_s: float | None
    peak_mb: float | None
    to_expected: float | None
    to_order: float | None
    cut_sets_s: float | None
    peer_cut_sets_s: float | None

    @property
    def cold_ratio(self) -> float | None:
        """How many times the processor seconds that the peer's process takes."""
        return self.peer_cold_s / self.cold_s if self.peer_cold_s and self.cold_s else None

    @property
    def command_ratio(self) -> float | None:
        """The same of the command."""
        return self.peer_cold_s / self.command_s if self.peer_cold_s and self.command_s else None

    @property
    def warm_ratio(self) -> float | None:
        """How many times the seconds that the peer's own analysis takes."""
        return self.peer_warm_s / self.warm_s if self.peer_warm_s and self.warm_s else None


def read(path: Path) -> tuple[FaultTree, dict[str, float]]:
    """Return a model's only tree and the values of its parameters."""
    model = read_open_psa(path)
    if len(model.tops) != 1:
        raise SystemExit(f"{path}: {len(model.tops)} tops ({', '.join(model.tops)}); one is needed")
    tree = model.fault_tree(model.tops[0])
    return tree, tree.values_at(0.0)


def top_of(path: Path) -> tuple[float, float]:
    """Return a model's probability, and the seconds from its tree on."""
    tree, values = read(path)
    began = time.perf_counter()
    p_top = tree.probability(values).p
    return p_top, time.perf_counter() - began


def top_by_other_order(path: Path) -> float:
    """Return the probability by a diagram with the neighbours of the order swapped."""
    tree, values = read(path)
    pairs = {event.name: Probability.of(values[event.parameter]) for event in tree.events}
    return SharedTree(tree, Limits(swapped=True)).probability(pairs).p


def with_cut_sets(path: Path) -> tuple[float, float]:
    """Return the probability, and the seconds that it and all minimal cut sets take."""
    from tracerisk.prm.other_models.cut_sets import minimal_cut_sets

    tree, values = read(path)
    began = time.perf_counter()
    minimal_cut_sets(tree)
    p_top = tree.probability(values).p
    return p_top, time.perf_counter() - began


def least_seconds(
    run: Callable[[Path], tuple[float, float]], path: Path
) -> tuple[float | None, float | None, float | None]:
    """Return what a run gives, its least seconds, and the least seconds of reading the file.

    Nothing where it outgrows its budgets.
    """
    least = least_read = float("inf")
    value: float | None = None
    for number in range(MOST_TIMES):
        gc.collect()
        began = time.perf_counter()
        try:
            value, taken = run(path)
        except TooLargeError as error:
            print(f"  {path.stem}: {error}", file=sys.stderr)
            return None, None, None
        least_read = min(least_read, time.perf_counter() - began - taken)
        least = min(least, taken)
        if is_enough(number, least):
            break
    return value, least, least_read


def is_enough(number: int, least_s: float) -> bool:
    """Whether a run is the last of its kind, by its number from 0 and the least seconds."""
    return least_s > LONG_S or (number + 1 >= TIMES and least_s > SHORT_S)


def in_a_process(
    command: list[str], limit_s: float, environment: dict[str, str] | None = None
) -> tuple[float | None, str]:
    """Return the least processor seconds of a process, and what it printed.

    Nothing when it fails or takes too long.
    """
    least: float | None = None
    for _ in range(TIMES):
        with tempfile.TemporaryFile() as output:
            process = subprocess.Popen(
                command, stdout=output, stderr=subprocess.DEVNULL, env=environment
            )
            until = time.monotonic() + limit_s
            while True:
                ended, status, usage = os.wait4(process.pid, os.WNOHANG)
                if ended:
                    break
                if time.monotonic() > until:
                    process.kill()
                time.sleep(0.005)
            process.returncode = os.waitstatus_to_exitcode(status)
            output.seek(0)
            printed = output.read().decode()
        if process.returncode:
            return None, printed
        taken = usage.ru_utime + usage.ru_stime
        least = taken if least is None else min(least, taken)
        if taken > LONG_S:
            break
    return least, printed


def cold(
    path: Path, limit_s: float, python: Path, environment: dict[str, str]
) -> tuple[float | None, float | None]:
    """Return the processor seconds and the peak memory, [MB], of a process that solves a model."""
    command = [str(python), "-c", PROGRAM, str(path)]
    taken, printed = in_a_process(command, limit_s, environment)
    return (taken, float(printed.split()[-1])) if taken is not None else (None, None)


def with_bytecode(folder: str) -> dict[str, str]:
    """Return the environment in which Python keeps what it has compiled, as installed it does."""
    left = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    return left | {"PYTHONPYCACHEPREFIX": folder}


def peer_times(peer: str, path: Path, limit_s: float) -> tuple[float | None, float | None]:
    """Return the peer's processor seconds, and the seconds that it says its analysis took."""
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "report.xml"
        run = [peer, "--probability", "1", "--bdd", str(path), "--limit-order", "1"]
        taken, _ = in_a_process([*run, "-o", str(report)], limit_s)
        if taken is None:
            return None, None
        analysis = float("inf")
        for number in range(MOST_TIMES):
            if number:
                subprocess.run([*run, "-o", str(report)], capture_output=True, check=True)
            times = ET.parse(report).findall(".//calculation-time/*")
            analysis = min(analysis, sum(float(time.text or "0") for time in times))
            if is_enough(number, analysis):
                break
    return taken, analysis


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


def measure(
    path: Path, expected: str, options: argparse.Namespace, environment: dict[str, str]
) -> Row:
    p_top, warm_s, read_s = least_seconds(top_of, path)
    cold_s = command_s = peak_mb = to_order = cut_sets_s = None
    peer_cold_s = peer_warm_s = peer_cut_sets_s = None
    if p_top is not None:
        cold_s, peak_mb = cold(path, options.time_limit, options.python, environment)
        command = [str(options.python.with_name("tracerisk")), "solve", str(path)]
        command_s, _ = in_a_process(command, options.time_limit, environment)
        other = top_by_other_order(path)
        to_order = abs(other / p_top - 1.0) if p_top else None
        if options.cut_sets:
            cut_sets_s = least_seconds(with_cut_sets, path)[1]
    if options.peer:
        peer_cold_s, peer_warm_s = peer_times(options.peer, path, options.time_limit)
        if options.cut_sets:
            run = [options.peer, "--probability", "1", "--bdd", str(path), "-o", "/dev/null"]
            peer_cut_sets_s, _ = in_a_process(run, options.time_limit)
    return Row(
        path.stem,
        p_top,
        cold_s,
        command_s,
        peer_cold_s,
        read_s,
        warm_s,
        peer_warm_s,
        peak_mb,
        error_to(expected, p_top),
        to_order,
        cut_sets_s,
        peer_cut_sets_s,
    )


def shown(value: float | None, form: str) -> str:
    return "-" if value is None else format(value, form)


def print_row(row: Row, options: argparse.Namespace) -> None:
    parts = [
        f"{row.model:10}",
        f"{shown(row.p_top, '.17g'):>23}",
        f"{shown(row.cold_s, '.3f'):>7}",
        f"{shown(row.command_s, '.3f'):>8}",
        f"{shown(row.peer_cold_s, '.3f'):>10}",
        f"{shown(row.cold_ratio, '.2f'):>6}",
        f"{shown(row.read_s, '.4f'):>7}",
        f"{shown(row.warm_s, '.4f'):>7}",
        f"{shown(row.peer_warm_s, '.4f'):>10}",
        f"{shown(row.warm_ratio, '.1f'):>6}",
        f"{shown(row.peak_mb, '.0f'):>5}",
        f"{shown(row.to_expected, '.1e'):>11}",
        f"{shown(row.to_order, '.1e'):>8}",
    ]
    if options.cut_sets:
        parts += [f"{shown(row.cut_sets_s, '.3f'):>10}", f"{shown(row.peer_cut_sets_s, '.3f'):>9}"]
    print(*parts, flush=True)


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--models", type=Path, help="folder of Open-PSA files and expected.csv")
    parser.add_argument("--models-only", default="", help="names of some models: a,b")
    parser.add_argument("--peer", choices=["scram"], help="solve with this one too")
    parser.add_argument("--cut-sets", action="store_true", help="time all minimal cut sets too")
    parser.add_argument(
        "--python",
        type=Path,
        default=Path(sys.executable),
        help="of the environment whose tracerisk is measured cold (this one)",
    )
    parser.add_argument("--time-limit", type=float, default=120.0, help="of a process, [s]")
    options = quick.parsed(parser, models=lambda: quick.folder(QUICK_MODELS))
    if not options.models:
        parser.error("give --models DIR")
    return options


def main() -> int:
    options = arguments()
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
        "model                        p_top  cold s command s peer cold s ratio  read s  warm s"
        " peer warm s ratio  peak to expected to order"
        + ("   cut sets  peer's" if options.cut_sets else "")
    )
    rows = []
    with tempfile.TemporaryDirectory() as bytecode:
        environment = with_bytecode(bytecode)
        cold(paths[0], options.time_limit, options.python, environment)
        for path in paths:
            rows.append(measure(path, expected.get(path.stem, ""), options, environment))
            print_row(rows[-1], options)
    report_ratios("cold", [row.cold_ratio for row in rows])
    report_ratios("command", [row.command_ratio for row in rows])
    report_ratios("warm", [row.warm_ratio for row in rows])
    wrong = [
        row.model for row in rows if max(row.to_expected or 0.0, row.to_order or 0.0) > MOST_ERROR
    ]
    print(f"solved {sum(row.p_top is not None for row in rows)} of {len(rows)}")
    if wrong:
        print(f"relative error above {MOST_ERROR}: {', '.join(wrong)}")
    return 1 if wrong else 0


def report_ratios(name: str, found: list[float | None]) -> None:
    ratios = [ratio for ratio in found if ratio is not None]
    if ratios:
        print(
            f"{name}: the peer takes {statistics.median(ratios):.2f} times as long in the median, "
            f"{min(ratios):.2f} at least"
        )


def warm_up(paths: list[Path]) -> None:
    """Load what a process that has solved a tree before has."""
    tree, values = read(paths[0])
    pairs = {event.name: Probability.of(values[event.parameter]) for event in tree.events}
    SharedTree(tree, Limits()).probability(pairs)


if __name__ == "__main__":
    sys.exit(main())
