"""Solve trees of a million independent events, once built, beside NumPy on the same numbers.

    python benchmarks/independent_trees.py [--events N]

Three shapes: one OR over all events, gates of two inputs each in a balanced tree, and 3-of-4
voting gates in a balanced tree. The peer's figure is what NumPy takes for the product of the
complements of as many events: a physical limit, one pass over the memory.
"""

from __future__ import annotations

import argparse
import gc
import time
from collections.abc import Callable

import numpy as np
import quick

from tracerisk.prm.trees.events import BasicEvent
from tracerisk.prm.trees.fault_tree import FaultTree
from tracerisk.prm.trees.gates import Gate, GateKind


def one_or(count: int) -> FaultTree:
    events = tuple(BasicEvent(f"e{i}") for i in range(count))
    return FaultTree("top", (Gate("top", GateKind.OR, tuple(e.name for e in events)),), events)


def balanced(count: int, width: int, kind: GateKind, k: int | None = None) -> FaultTree:
    """Return a balanced tree of gates of `width` inputs."""
    events = tuple(BasicEvent(f"e{i}") for i in range(count))
    level = [event.name for event in events]
    gates: list[Gate] = []
    while len(level) > 1:
        above = []
        for start in range(0, len(level), width):
            inputs = tuple(level[start : start + width])
            name = f"g{len(gates)}"
            whole = len(inputs) == width
            gates.append(Gate(name, kind if whole else GateKind.OR, inputs, k if whole else None))
            above.append(name)
        level = above
    return FaultTree(level[0], tuple(gates), events)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--events", type=int, default=1_000_000)
    count = quick.parsed(parser, events=lambda: 1000).events
    given = np.full(count, 1e-9)
    start = time.perf_counter()
    -np.expm1(np.log1p(-given).sum())
    limit = time.perf_counter() - start
    shapes: tuple[tuple[str, Callable[[], FaultTree], float], ...] = (
        ("one OR", lambda: one_or(count), 1e-9),
        ("ORs of two", lambda: balanced(count, 2, GateKind.OR), 1e-9),
        ("3 of 4", lambda: balanced(count, 4, GateKind.ATLEAST, 3), 0.75),
    )
    print(f"{count} events  built s  solved s  to NumPy   top")
    for name, make, p in shapes:
        start = time.perf_counter()
        tree = make()
        built = time.perf_counter() - start
        values = dict.fromkeys((event.name for event in tree.events), p)
        seconds = []
        for _ in range(3):
            gc.collect()
            start = time.perf_counter()
            top = tree.probability(values)
            seconds.append(time.perf_counter() - start)
        solved = min(seconds)
        print(f"{name:14} {built:8.2f} {solved:9.2f} {solved / limit:9.0f} {top.p:12.6e}")
        del tree


if __name__ == "__main__":
    main()
