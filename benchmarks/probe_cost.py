"""What the probe costs: a traced call, a command, and a command's way to the file.

    python benchmarks/probe_cost.py [--calls N] [--commands N]

Times are CPU seconds of the thread that calls; the writing thread's are printed beside them.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from types import CodeType
from typing import Any

import quick

sys.path.insert(0, str(Path(__file__).parents[1] / "probe"))

from tracerisk_probe import recording, stacks
from tracerisk_probe.rewriting import compile_traced
from tracerisk_probe.writing import Output

LIMIT_US = 10.0
SOURCE = """
def empty():
    pass
def generated():
    yield
def deep(count, act):
    if count:
        deep(count - 1, act)
    else:
        act()
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--calls", type=int, default=200_000)
    parser.add_argument("--commands", type=int, default=20_000)
    options = quick.parsed(parser, calls=lambda: 200, commands=lambda: 20)
    calls, commands = options.calls, options.commands
    plain = functions(compile(SOURCE, "plain.py", "exec"))
    traced = functions(compile_traced(SOURCE.encode(), "cost.py", "cost.py"))
    with tempfile.TemporaryDirectory() as folder:
        output = Output(str(Path(folder) / "commands.jsonl"), None)
        recording.record_to(output, "cost.py")

        def act() -> int:
            return recording.command("topic", "/arm/command", "trajectory_msgs/JointTrajectory")

        rows = {
            "a traced call": cost(plain["empty"], traced["empty"], calls),
            "a traced generator": cost(
                lambda: list(plain["generated"]()), lambda: list(traced["generated"]()), calls
            ),
            "5 traced calls and a command in the last": cost(
                lambda: plain["deep"](4, int), lambda: traced["deep"](4, act), commands
            ),
            "the end of a command": cost(
                lambda: None, lambda: recording.ended(1, "succeeded"), commands
            ),
        }
        output.flush(60.0)
        whole = time.process_time() - time.thread_time()
    for name, seconds in rows.items():
        sys.stdout.write(f"{name}: {1e6 * seconds:.2f} us\n")
    per_command = 1e6 * whole / (6 * commands)
    sys.stdout.write(f"each command or end in the thread that writes: {per_command:.2f} us\n")
    if not options.quick and max(rows.values()) * 1e6 > LIMIT_US:
        sys.exit(f"a call costs more than {LIMIT_US:g} us")


def functions(code: CodeType) -> dict[str, Any]:
    names: dict[str, Any] = {}
    stacks.know(code, "cost.py")
    exec(code, names)
    return names


def cost(plain: Callable[[], Any], traced: Callable[[], Any], times: int) -> float:
    """Return by how much a call is dearer [s]; the least of three."""
    return min(cpu(traced, times) - cpu(plain, times) for _ in range(3)) / times


def cpu(call: Callable[[], Any], times: int) -> float:
    began = time.thread_time()
    for _ in range(times):
        call()
    return time.thread_time() - began


if __name__ == "__main__":
    main()
