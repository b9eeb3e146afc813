"""What the preloaded probe adds to a publish of a compiled node, beside the bare publish.

    python benchmarks/native_probe_cost.py [--rounds N]

Both are measured in the same run: the node is started with the probe and without it, turn by turn.
Times are CPU seconds of the thread that publishes, the least of all rounds of 500.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import quick

from tracerisk.instrument.native.calls import read_calls
from tracerisk.instrument.native.library import build_probe

SOURCES = Path(__file__).parents[1] / "tests/probe/native"
LIMIT_US = 5.0
LIMITED_DEPTH = 20
"""How deep the stack may be for the limit to hold; a function of the node and its caller are 2."""
STARTS = 3


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--rounds", type=int, default=40)
    options = quick.parsed(parser, rounds=lambda: 1)
    if shutil.which("g++") is None:
        print("no g++")
        sys.exit(quick.SKIPPED)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        probe = build_probe(folder)
        ros, node = folder / "libroscpp.so", folder / "cost"
        compile_cpp(["-fPIC", "-shared", str(SOURCES / "ros.cpp"), "-o", str(ros)])
        flags = [f"-Wl,-rpath,{folder}", "-fno-optimize-sibling-calls", "-g"]
        compile_cpp([str(SOURCES / "cost.cpp"), str(ros), *flags, "-o", str(node)])
        file = folder / "calls.jsonl"
        with_probe = {"LD_PRELOAD": str(probe), "TRACERISK_CALLS": str(file)}
        bare: dict[int, float] = {}
        recorded: dict[int, float] = {}
        for _ in range(STARTS):
            file.unlink(missing_ok=True)
            least(bare, node, options.rounds, {})
            least(recorded, node, options.rounds, with_probe)
        calls = read_calls(file).calls
        assert len(calls) == 4 * 500 * options.rounds, "commands are missing"
    print("functions  bare [us]  recorded [us]  ratio")
    for depth, cost in recorded.items():
        print(f"{depth:9} {bare[depth]:10.3f} {cost:14.3f} {cost / bare[depth]:6.0f}")
    is_slow = recorded[LIMITED_DEPTH] - bare[LIMITED_DEPTH] > LIMIT_US
    if is_slow and not options.quick:
        sys.exit(f"more than {LIMIT_US} us at {LIMITED_DEPTH} functions")


def compile_cpp(arguments: list[str]) -> None:
    subprocess.run(["g++", "-O2", "-I", str(SOURCES), *arguments], check=True)


def least(costs: dict[int, float], node: Path, rounds: int, changed: dict[str, str]) -> None:
    """Run the node, and keep the least cost of each depth [us]."""
    out = subprocess.run(
        [str(node), str(rounds)],
        env={**os.environ, **changed},
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    ).stdout
    for line in out.splitlines():
        depth, cost = line.split()
        costs[int(depth)] = min(float(cost), costs.get(int(depth), float("inf")))


if __name__ == "__main__":
    main()
