"""Compare the processor time of runs with faults: as branches of one run, and from the beginning.

The faults are drawn uniformly over units, modes and time. Every result is compared, byte for byte.
Processor time counts that of all processes, the making of the traces included; for branches also
that of the run which they leave.

    python benchmarks/branches.py [CONTROLLER] [--cells N] [--seed N]
"""

from __future__ import annotations

import argparse
import os
import random
import time
from pathlib import Path

from tracerisk import pipeline, trace_json
from tracerisk.pipeline.run.branching.branches import Branch, run_branches
from tracerisk.pipeline.run.fault_run import nominal_run, run_with_faults
from tracerisk.pipeline.stages import load_hardware
from tracerisk.sandbox import fork_server
from tracerisk.twin.faults.fault import Fault, modes_of

SAMPLE = Path(__file__).parent.parent / "sample_controllers" / "pick_and_place.py"
_TICK_S = 1.0 / os.sysconf("SC_CLK_TCK")


def cpu_s() -> float:
    """Return the processor time of this process, and of all that it has started and that ended."""
    own = os.times()
    used = own.user + own.system + own.children_user + own.children_system
    server = fork_server._KEPT.server
    if server is not None:
        # Runs are children of the server, which counts them when they have ended.
        stat = Path(f"/proc/{server._process.pid}/stat").read_text().rpartition(")")[2].split()
        used += sum(map(int, stat[11:15])) * _TICK_S
    return used


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("controller", nargs="?", type=Path, default=SAMPLE)
    parser.add_argument("--cells", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    fork_server.several_come()
    controller = pipeline.load_controller(options.controller)
    settings = pipeline.load_settings(controller)
    before, began = cpu_s(), time.perf_counter()
    nominal = nominal_run(controller, settings, hardware_of=load_hardware)
    end_s = nominal.trace.end.simulated_s or 0.0
    print(
        f"without a fault: {end_s:.1f} s simulated, {cpu_s() - before:.2f} s of processor time, "
        f"{time.perf_counter() - began:.1f} s"
    )
    chance = random.Random(options.seed)
    units = [(unit, mode) for unit, modes in modes_of(nominal.robot).items() for mode in modes]
    branches = []
    for index in range(options.cells):
        unit, mode = chance.choice(units)
        fault = Fault(unit, mode, round(chance.uniform(0.0, end_s - 0.1), 3))
        branches.append(Branch(index, (fault,)))
    before, began = cpu_s(), time.perf_counter()
    results = list(run_branches(controller, settings, nominal, branches))
    branched_s, branched_wall_s = cpu_s() - before, time.perf_counter() - began
    before, began = cpu_s(), time.perf_counter()
    full = [run_with_faults(controller, settings, nominal, each.faults) for each in branches]
    full_s, full_wall_s = cpu_s() - before, time.perf_counter() - began
    same = sum(
        trace_json.dumps(one.run.trace) == trace_json.dumps(other.trace)
        for one, other in zip(results, full, strict=True)
    )
    count = len(branches)
    print(f"{sum(each.is_branched for each in results)} of {count} branched, {same} equal")
    for name, used_s, wall_s in (
        ("branches", branched_s, branched_wall_s),
        ("from the beginning", full_s, full_wall_s),
    ):
        print(f"{name}: {used_s / count:.2f} s of processor time a cell, {wall_s / count:.2f} s")
    print(f"ratio {full_s / branched_s:.2f}")


if __name__ == "__main__":
    main()
