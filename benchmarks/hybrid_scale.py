"""Measure how long hybrid models of many functions take, and how much memory.

    python benchmarks/hybrid_scale.py [--cases own,shared,wide,pairs,many,dense,uncertainty,inputs]

Each case is built and solved in a process of its own; what is imported counts too.

- build: CPU seconds (user and system) from risk blocks to the model, with all checks.
- figure: CPU seconds more to the mission's figures, those of each function included.
- solve: CPU seconds more to the whole assessment, with importances, and its table as text.
- MB: greatest memory of the process.

Functions follow each other, 9 of 10 times; else the mission goes back three functions.
own: each component is that of one function. shared: all functions have the same components.
wide: 100 components of its own in each function, the figure alone. pairs, many, dense: redundant
pairs whose failures stay hidden, each in one function; 6 in 50, exactly, 200 in 50 and 200 in 10,
each by itself with a bound, `width` times its lower one. uncertainty: shared, with error factors 3
for all, 100,000 samples. inputs: the same of own components, 10,000 uncertain figures.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from fractions import Fraction

import quick

from tracerisk.adder.blocks.block import ComponentEntry, Field, RiskBlock, Transition
from tracerisk.adder.blocks.values import read_redundancy


@dataclass(frozen=True)
class Case:
    """A model's size, and what is asked of it."""

    functions: int
    components: int
    is_shared: bool = False
    pairs: int = 0
    solve: bool = True
    samples: int = 0


CASES = {
    "own": Case(5_000, 10),
    "shared": Case(5_000, 10, is_shared=True),
    "wide": Case(5_000, 100, solve=False),
    "pairs": Case(50, 2, pairs=6),
    "many": Case(50, 2, pairs=200),
    "dense": Case(10, 2, pairs=200),
    "uncertainty": Case(1_000, 10, is_shared=True, solve=False, samples=100_000),
    "inputs": Case(1_000, 10, solve=False, samples=100_000),
}

SMALL = {"small": Case(20, 3), "small pairs": Case(5, 2, pairs=4)}


def blocks_of(case: Case) -> list[RiskBlock]:
    blocks = []
    for function in range(case.functions):
        onward = f"f{function + 1}" if function + 1 < case.functions else "done"
        steps = (
            Transition(onward, Fraction(9, 10)),
            Transition(f"f{max(0, function - 3)}", Fraction(1, 10)),
        )
        parts = []
        for number in range(case.components):
            name = f"c{number}" if case.is_shared else f"c{function}_{number}"
            parts.append(component(name, 1e-7 * (1 + (7 * function + number) % 13), 1, "false"))
        parts += [
            component(f"pair{pair}", 1e-4 * (1 + pair % 7), 2, "true")
            for pair in range(function, case.pairs, case.functions)
        ]
        text = ", ".join(f"{step.target} {float(step.weight):g}" for step in steps)
        sequence = Field(function + 1, str(function + 1))
        blocks.append(RiskBlock(f"f{function}", sequence, Field(steps, text), tuple(parts)))
    return blocks


def component(name: str, probability: float, quantity: int, redundancy: str) -> ComponentEntry:
    return ComponentEntry(
        name,
        Field(probability, repr(probability)),
        Field(quantity, str(quantity)),
        Field(read_redundancy(redundancy), redundancy),
    )


def measure(case: Case) -> dict[str, float]:
    """Return what one case takes; run in a process of its own."""
    from tracerisk.prm import build_model, solve
    from tracerisk.prm.hybrid.chain_solver import solve_mission
    from tracerisk.prm.hybrid.solve import solve_figures
    from tracerisk.prm.numbers.distributions import Lognormal
    from tracerisk.prm.questions.uncertainty import propagate

    blocks = blocks_of(case)
    taken: dict[str, float] = {}

    def timed(name: str, work: Callable[[], object]) -> None:
        began = time.process_time()
        work()
        taken[name] = time.process_time() - began

    built = []
    timed("build", lambda: built.append(build_model(blocks, name="scale")))
    model = built[0]
    timed("figure", lambda: solve_figures(model))
    if case.pairs:
        solved = solve_mission(model)
        taken["width"] = solved.failure.p / solved.least - 1.0
    if case.solve:
        timed("solve", lambda: str(solve(model).importance()))
    if case.samples:
        law = Lognormal(3.0)
        given = {parameter.name: law for parameter in model.parameters}
        timed("sample", lambda: propagate(model, samples=case.samples, distributions=given))
    taken["MB"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return taken


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--cases", default=",".join(CASES))
    parser.add_argument("--one", help=argparse.SUPPRESS)
    options = quick.parsed(parser, cases=lambda: ",".join(SMALL))
    if options.one:
        print(json.dumps(measure(Case(**json.loads(options.one)))))
        return 0
    for name in options.cases.split(","):
        case = {**CASES, **SMALL}[name]
        command = [sys.executable, __file__, "--one", json.dumps(asdict(case))]
        done = subprocess.run(command, check=True, capture_output=True, text=True)
        taken = json.loads(done.stdout)
        lines = [f"{key} {value:.3g}" for key, value in taken.items()]
        print(
            f"{name} ({case.functions} functions x {case.components}): {', '.join(lines)}",
            flush=True,
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
