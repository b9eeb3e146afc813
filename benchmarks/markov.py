"""Solve absorbing Markov chains, beside Storm: seconds, memory and errors of each chain.

    python benchmarks/markov.py [--peer stormpy] [--chains banded,cycle] [--most-states N]

Times. Each chain is made anew in a process of its own for each tool, which first solves a small
chain, so that what is compiled or loaded once is not counted.

- build: CPU seconds from arrays to the tool's own model, ours with all checks.
- solve: CPU seconds (user and system) to the failure probability from the entry, the least of
  some runs. Ours: visits of all states and absorption in each end, refined and certified. Storm's:
  the failure probability from each state, by `environments.exact()` on the
  double model, its direct solver; by `environments.default()`, its sound iteration, where
  elimination fills in.
- each: CPU seconds more to our failure probability from each state, refined and certified.
- MB: greatest memory of that process above what it had before the chain was made.
- bound: the relative error that ours is proven to have at most.
- apart: relative difference of the two tools' failure probability.

Accuracy: the relative error of the failure probability against exact rationals of the same rows,
each divided by its sum.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import math
import os
import resource
import subprocess
import sys
import time
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import quick
from scipy.sparse import csr_array

from tracerisk.prm import MarkovChain
from tracerisk.prm.other_models.markov.large.factors import Budget

Array = np.ndarray[Any, Any]

TIMES = 3
"""How often a run is repeated; the least counts."""
LONG_S = 5.0
"""A run that takes longer is not repeated."""
PATIENCE_S = 600.0
PATIENCE_ACCURACY_S = 20.0


def rows_to_chain(state: Array, targets: Array, weights: Array, rng: Any) -> csr_array:
    """Return a chain of n states with the ways given, a failure of 1e-8 to 1e-6 each.

    State n is the good end, n + 1 the failure.
    """
    n = int(state.max()) + 1
    failure = 10.0 ** rng.uniform(-8.0, -6.0, n)
    sums = np.bincount(state, weights, n)
    weights = weights * ((1.0 - failure) / sums)[state]
    rows = np.concatenate((state, np.arange(n)))
    columns = np.concatenate((targets, np.full(n, n + 1)))
    values = np.concatenate((weights, failure))
    chain = csr_array((values, (rows, columns)), shape=(n + 2, n + 2))
    chain.sum_duplicates()
    return chain


def banded(n: int, rng: Any) -> csr_array:
    """Mostly onwards, at times one back, and two random branches of up to 20 states each way."""
    state = np.arange(n)
    jumps = np.clip(state + rng.integers(-20, 21, (2, n)), 0, n - 1)
    targets = np.concatenate((state + 1, np.maximum(state - 1, 0), *jumps))
    weights = rng.random((4, n)) * [[3.0], [1.0], [0.5], [0.5]]
    return rows_to_chain(np.tile(state, 4), targets, weights.ravel(), rng)


def cycle(n: int, rng: Any) -> csr_array:
    """A ring; every hundredth state ends with 1e-4, the last one with 1/10."""
    state = np.arange(n)
    early = np.arange(99, n, 100)
    rows = np.concatenate((state, early, [n - 1]))
    targets = np.concatenate(((state + 1) % n, np.full(len(early), n), [n]))
    weights = np.concatenate((np.full(n, 0.9), np.full(len(early), 1e-4), [0.1]))
    return rows_to_chain(rows, targets, weights, rng)


def star(n: int, rng: Any) -> csr_array:
    """A hub that leads to all others, which lead back."""
    leaf = np.arange(1, n)
    rows = np.concatenate((np.zeros(n - 1, int), [0], leaf))
    targets = np.concatenate((leaf, [n], np.zeros(n - 1, int)))
    weights = np.concatenate((rng.random(n - 1) / n, [0.01], np.ones(n - 1)))
    return rows_to_chain(rows, targets, weights, rng)


def grid(n: int, rng: Any) -> csr_array:
    """Four neighbours each on a square; the last state ends well."""
    side = int(n**0.5)
    n = side * side
    state = np.arange(n)
    x, y = state % side, state // side
    targets = np.concatenate(
        (
            np.where(x + 1 < side, state + 1, state),
            np.where(x > 0, state - 1, state),
            np.where(y + 1 < side, state + side, state),
            np.where(y > 0, state - side, state),
        )
    )
    targets[n - 1] = n
    return rows_to_chain(np.tile(state, 4), targets, rng.random(4 * n) + 0.1, rng)


def scattered(n: int, rng: Any) -> csr_array:
    """Four ways to anywhere each, and a good end with 1/1000: elimination fills it in."""
    state = np.arange(n)
    targets = np.concatenate((rng.integers(0, n, 4 * n), np.full(n, n)))
    weights = np.concatenate((rng.random(4 * n) + 0.05, np.full(n, 0.0023)))
    return rows_to_chain(np.tile(state, 5), targets, weights, rng)


CHAINS: dict[str, Callable[[int, Any], csr_array]] = {
    "banded": banded,
    "cycle": cycle,
    "star": star,
    "grid": grid,
    "scattered": scattered,
}
SIZES = {
    "banded": (10**3, 10**4, 10**5, 10**6),
    "cycle": (10**3, 10**4, 10**5, 10**6),
    "star": (10**3, 10**4, 10**5, 10**6),
    "grid": (10**3, 10**4, 10**5),
    "scattered": (10**3, 10**4, 10**5),
}
DIRECT_SCATTERED = 10**4
"""Beyond it a direct solver would need tens of gigabytes."""


def cpu() -> float:
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


def least(run: Callable[[], Any]) -> tuple[float, float, Any]:
    """Return the least CPU seconds and wall seconds of some runs, and the last answer."""
    best_cpu = best_wall = float("inf")
    answer = None
    for _ in range(TIMES):
        # What the last run holds is no memory of the next.
        answer = None
        began, began_wall = cpu(), time.perf_counter()
        answer = run()
        best_cpu = min(best_cpu, cpu() - began)
        best_wall = min(best_wall, time.perf_counter() - began_wall)
        if best_cpu > LONG_S:
            break
    return best_cpu, best_wall, answer


def resident_mb() -> float:
    with open("/proc/self/statm", encoding="ascii") as file:  # noqa: PTH123
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20


def solve_ours(matrix: csr_array, budget: Budget | None) -> dict[str, Any]:
    n = matrix.shape[0] - 2
    built, _, chain = least(lambda: MarkovChain.from_matrix(matrix, [n, n + 1]))

    def run() -> tuple[Any, float]:
        solution = chain.solve(0, budget)
        return solution, float(solution.absorption()[n + 1])

    solved, wall, (solution, value) = least(run)
    each, _, result = least(lambda: solution.certified_absorption_from_each([n + 1]))
    bound, method = max(result.bound, solution.error_bound), solution.method
    return {
        "build": built,
        "solve": solved,
        "each": each,
        "wall": wall,
        "value": value,
        "bound": bound,
        "method": method,
    }


def storm_model(matrix: csr_array) -> Any:
    import stormpy
    from stormpy import datastructures, models

    n = matrix.shape[0] - 2
    entries = matrix.tocoo()
    order = np.lexsort((entries.col, entries.row))
    rows = [*entries.row[order].tolist(), n, n + 1]
    columns = [*entries.col[order].tolist(), n, n + 1]
    values = [*entries.data[order].tolist(), 1.0, 1.0]
    builder = datastructures.SparseMatrixBuilder[float](
        rows=n + 2, columns=n + 2, entries=len(rows)
    )
    builder.add_next_values(rows, columns, values, [])
    labels = models.StateLabeling(n + 2)
    for label, state in (("init", 0), ("failed", n + 1)):
        labels.add_label(label)
        labels.add_label_to_state(label, state)
    parts = models.SparseModelComponents(transition_matrix=builder.build(), state_labeling=labels)
    (question,) = stormpy.parse_properties('P=? [F "failed"]')
    return models.SparseDtmc(parts), question


def solve_storm(matrix: csr_array, *, direct: bool) -> dict[str, Any]:
    import stormpy

    built, _, (model, question) = least(lambda: storm_model(matrix))
    environment = stormpy.environments.exact() if direct else stormpy.environments.default(model)
    solved, wall, answer = least(
        lambda: stormpy.model_checking(model, question, environment=environment)
    )
    return {
        "build": built,
        "solve": solved,
        "wall": wall,
        "value": float(answer.get_value(0)),
        "method": "exact()" if direct else "sound iteration",
    }


def child(tool: str, kind: str, size: int, how: str) -> None:
    """Solve one chain in this process, and print what was measured."""
    if kind == "accuracy":
        rows = list(accuracy_cases().values())[size]
        print(json.dumps(solve_storm(as_matrix(rows), direct=how == "direct")))
        return
    budget = Budget(iterate_first=float("inf")) if how == "direct" else None

    def measure(matrix: csr_array) -> dict[str, Any]:
        if tool == "ours":
            return solve_ours(matrix, budget)
        return solve_storm(matrix, direct=how == "direct")

    measure(CHAINS[kind](400, np.random.default_rng(0)))
    if tool == "ours":
        # The other way too: what it needs is compiled before the clock starts.
        solve_ours(scattered(400, np.random.default_rng(0)), Budget(entries=0))
    before = resident_mb()
    table = measure(CHAINS[kind](size, np.random.default_rng(1)))
    table["MB"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0 - before
    print(json.dumps(table))


def measured(tool: str, kind: str, size: int, how: str) -> dict[str, Any] | None:
    patience = PATIENCE_ACCURACY_S if kind == "accuracy" else PATIENCE_S
    command = [sys.executable, __file__, "--child", tool, kind, str(size), how]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=patience, check=True)
    except (subprocess.TimeoutExpired, subprocess.CalledProcessError):
        return None
    loads: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return loads


def time_table(kinds: list[str], most: int, *, peer: bool) -> None:
    heads = ("states", "ours build", "solve", "MB", "Storm build", "solve", "MB", "ratio", "each")
    print(f"{'chain':<10}" + "".join(f"{head:>12}" for head in heads) + "   bound    apart  ways")
    for kind in kinds:
        for size in SIZES[kind]:
            if size > most:
                continue
            hows = ["default"]
            if kind != "scattered":
                hows = ["direct"]
            elif size <= DIRECT_SCATTERED:
                hows = ["direct", "default"]
            for how in hows:
                ours = measured("ours", kind, size, how)
                theirs = measured("storm", kind, size, how) if peer else None
                print(line(kind, size, ours, theirs), flush=True)


def line(kind: str, size: int, ours: dict[str, Any] | None, theirs: dict[str, Any] | None) -> str:
    cells = [f"{kind:<10}{size:>12,}"]
    for table in (ours, theirs):
        if table is None:
            cells.append(f"{'-':>12}" * 3)
        else:
            cells.append(f"{table['build']:>12.4f}{table['solve']:>12.4f}{table['MB']:>12.0f}")
    if ours is None:
        return "".join(cells)
    if theirs is None:
        cells.append(f"{'-':>12}{ours['each']:>12.4f}{ours['bound']:>8.0e}{'-':>9}")
        cells.append(f"  {ours['method']}")
        return "".join(cells)
    apart = abs(theirs["value"] / ours["value"] - 1.0)
    cells.append(f"{theirs['solve'] / ours['solve']:>12.1f}{ours['each']:>12.4f}")
    cells.append(f"{ours['bound']:>8.0e}{apart:>9.0e}")
    cells.append(f"  {ours['method']} / {theirs['method']}")
    return "".join(cells)


Rows = dict[str, dict[str, float]]


def accuracy_cases() -> dict[str, Rows]:
    cases: dict[str, Rows] = {}
    for fail in (1e-7, 1e-17):
        states = 20
        rows: Rows = {f"s{i}": {f"s{i + 1}": 1.0 - fail, "failed": fail} for i in range(states - 1)}
        rows[f"s{states - 1}"] = {"s0": 0.9, "done": 0.1 - fail, "failed": fail}
        cases[f"rare {fail:.0e}"] = rows
    for step, rungs in ((1e-4, 4), (1e-4, 5), (1e-4, 7)):
        cases[f"ladder {step**rungs:.0e}"] = {
            f"s{i}": {
                (f"s{i + 1}" if i < rungs - 1 else "failed"): step,
                "done": 0.5,
                **({"s0": 0.5 - step} if i else {"wait": 0.5 - step}),
            }
            for i in range(rungs)
        } | {"wait": {"s0": 1.0}}
    leave, fail = 1e-9, 1e-14
    cases["nearly recurrent 1e-09/1e-14"] = {
        "s0": {"b": 1.0 - fail, "failed": fail},
        "b": {"c": 1.0 - fail, "failed": fail},
        "c": {"s0": 1.0 - leave - fail, "done": leave, "failed": fail},
    }
    return cases


def exact_failure(rows: Rows) -> Fraction:
    """Return the failure probability from s0 by Gauss-Jordan elimination in rationals."""
    names = list(rows)
    table = []
    for i in names:
        total = sum(map(Fraction, rows[i].values()))
        q = [Fraction(int(i == j)) - Fraction(rows[i].get(j, 0.0)) / total for j in names]
        table.append([*q, Fraction(rows[i].get("failed", 0.0)) / total])
    for k in range(len(names)):
        pivot = next(r for r in range(k, len(names)) if table[r][k])
        table[k], table[pivot] = table[pivot], table[k]
        lead = table[k][k]
        table[k] = [value / lead for value in table[k]]
        for r in range(len(names)):
            factor = table[r][k]
            if r != k and factor:
                table[r] = [a - factor * b for a, b in zip(table[r], table[k], strict=True)]
    return table[names.index("s0")][-1]


def as_matrix(rows: Rows) -> csr_array:
    names = ["s0", *(name for name in rows if name != "s0"), "done", "failed"]
    index = {name: number for number, name in enumerate(names)}
    entries = [(index[s], index[t], p) for s, row in rows.items() for t, p in row.items()]
    sources, targets, values = zip(*entries, strict=True)
    return csr_array((values, (sources, targets)), shape=(len(names), len(names)))


def error_of(value: float, exact: Fraction) -> str:
    if math.isnan(value):
        return f"{'no answer':>15}"
    return f"{float(abs(Fraction(value) / exact - 1)):>15.1e}"


def accuracy_table(*, peer: bool) -> bool:
    heads = ("failure", "by names", "by arrays", "Storm exact()", "Storm sound")
    print(f"\n{'relative error':<30}" + "".join(f"{head:>15}" for head in heads))
    good = True
    for name, rows in accuracy_cases().items():
        exact = exact_failure(rows)
        matrix = as_matrix(rows)
        n = matrix.shape[0] - 2
        values = [
            MarkovChain(rows, ("failed", "done")).solve("s0").absorption()["failed"],
            float(MarkovChain.from_matrix(matrix, [n, n + 1]).solve(0).absorption()[n + 1]),
        ]
        good &= all(abs(Fraction(value) / exact - 1) < Fraction(1, 10**12) for value in values)
        if peer:
            for how in ("direct", "default"):
                # Storm's iteration does not come to an end on each of these.
                theirs = measured("storm", "accuracy", list(accuracy_cases()).index(name), how)
                values.append(theirs["value"] if theirs else math.nan)
        cells = [error_of(value, exact) for value in values] + [f"{'-':>15}"] * (4 - len(values))
        print(f"{name:<30}{float(exact):>15.6e}" + "".join(cells), flush=True)
    return good


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--peer", choices=["stormpy"], help="solve with Storm beside")
    parser.add_argument("--chains", default=",".join(CHAINS), help="some of these, by commas")
    parser.add_argument("--most-states", type=int, default=10**6)
    parser.add_argument("--child", nargs=4, help=argparse.SUPPRESS)
    options = quick.parsed(parser, chains=lambda: "banded", most_states=lambda: 1000)
    if options.child:
        tool, kind, size, how = options.child
        child(tool, kind, int(size), how)
        return 0
    peer = options.peer is not None
    if peer and importlib.util.find_spec("stormpy") is None:
        parser.error("stormpy is not installed; install it with: pip install 'tracerisk[peers]'")
    kinds = options.chains.split(",")
    for kind in kinds:
        if kind not in CHAINS:
            parser.error(f"no chain '{kind}'; allowed: {', '.join(CHAINS)}")
    print(f"{os.cpu_count()} CPUs, load {os.getloadavg()[0]:.1f} at the start")
    time_table(kinds, options.most_states, peer=peer)
    return 0 if accuracy_table(peer=peer) else 1


if __name__ == "__main__":
    sys.exit(main())
