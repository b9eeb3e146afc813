"""Measure how long the command takes to start, against an import of argparse.

    python benchmarks/start_up.py [--times N]

`tracerisk --help` may take at most 2.5 times as long as `python -c "import argparse"`.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import quick

MOST_FOR_HELP = 2.5

SOURCE = """\
def place():
    # | RiskAnnotation
    # | @Function {
    # |   name = place
    # |   callSequence = 1
    # |   next = done 1
    # | }
    # | @Component {
    # |   name = gripper
    # |   probability = 7.344e-08
    # |   quantity = 1
    # |   redundancy = false
    # | }
    pass
"""


def seconds(command: list[str], folder: Path) -> float:
    began = time.perf_counter()
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    return time.perf_counter() - began


def medians(commands: dict[str, list[str]], folder: Path, times: int) -> dict[str, float]:
    """Return the median of each command; they take turns, so that all see the same machine."""
    taken: dict[str, list[float]] = {name: [] for name in commands}
    for command in commands.values():
        seconds(command, folder)
    for _ in range(times):
        for name, command in commands.items():
            taken[name].append(seconds(command, folder))
    return {name: statistics.median(values) for name, values in taken.items()}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--times", type=int, default=10)
    options = quick.parsed(parser, times=lambda: 1)
    command = str(Path(sys.executable).with_name("tracerisk"))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "place.py").write_text(SOURCE, encoding="utf-8")
        built = subprocess.run(
            [command, "build", "place.py", "-q"], cwd=folder, check=True, capture_output=True
        )
        json.loads(built.stdout)
        (folder / "model.json").write_bytes(built.stdout)
        commands = {
            'python -c "import argparse"': [sys.executable, "-c", "import argparse"],
            "tracerisk --help": [command, "--help"],
            "tracerisk solve model.json": [command, "solve", "model.json"],
            "tracerisk solve model.json --json": [command, "solve", "model.json", "--json"],
        }
        values = medians(commands, folder, options.times)
    base, *_ = values.values()
    for name, median in values.items():
        print(f"{name:34}  {1000 * median:6.1f} ms  {median / base:5.2f} x")
    ratio = values["tracerisk --help"] / base
    print(f"help: {ratio:.2f} times argparse, at most {MOST_FOR_HELP:g} allowed")
    return 0 if options.quick or ratio <= MOST_FOR_HELP else 1


if __name__ == "__main__":
    sys.exit(main())
