"""Compare the processor time of a campaign's cells: as branches, and as runs from the beginning.

The cells are a seeded sample of those that a campaign tries. As branches they are run as the
campaign runs them, which ends a run once its fate is decided; from the beginning each is run on
threads to its end. Compared is whether the mission failed. Processor time counts that of all
processes, the making of the traces and the judgement included; for branches also that of the run
which they leave. The run without a failure, made once in each process, is printed apart.

    python benchmarks/branches.py [CONTROLLER] [--cells N] [--of N] [--seed N]
"""

from __future__ import annotations

import argparse
import os
import random
import tempfile
import time
from pathlib import Path

import quick

from tracerisk.common.sandbox import fork_server
from tracerisk.pipeline.evidence.campaign import plan_campaign
from tracerisk.pipeline.evidence.cell_runs import CellBatch, run_batch, whole_run

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
    """Run the cells both ways and print what they cost."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("controller", nargs="?", type=Path, default=SAMPLE)
    parser.add_argument("--cells", type=int, default=32, help="how many are run")
    parser.add_argument("--of", type=int, default=400, help="of a campaign of so many drawn cells")
    parser.add_argument("--seed", type=int, default=0)
    options = quick.parsed(parser, controller=quick.controller, cells=lambda: 2, of=lambda: 4)
    fork_server.several_come()
    before, began = cpu_s(), time.perf_counter()
    plan = plan_campaign(options.controller, cells=options.of)
    nominal = plan.nominal
    print(
        f"{len(plan.cells)} cells in the campaign; without a failure: "
        f"{nominal.trace.end.simulated_s or 0.0:.1f} s simulated, {cpu_s() - before:.2f} s of "
        f"processor time, {time.perf_counter() - began:.1f} s"
    )
    chance = random.Random(options.seed)
    cells = tuple(chance.sample(plan.cells, min(options.cells, len(plan.cells))))
    before, began = cpu_s(), time.perf_counter()
    done = run_batch(CellBatch(plan.controller, plan.options, nominal.digest, cells))
    branched_s, branched_wall_s = cpu_s() - before, time.perf_counter() - began
    before, began = cpu_s(), time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        whole = [
            whole_run(nominal, cell, Path(folder, str(number))) for number, cell in enumerate(cells)
        ]
    whole_s, whole_wall_s = cpu_s() - before, time.perf_counter() - began
    same = sum(one.fails == other.fails for one, other in zip(done.cells, whole, strict=True))
    count = len(cells)
    print(f"{count} cells, {len(done.whole_runs)} reasons not to branch, {same} with the same fate")
    for name, used_s, wall_s in (
        ("branches", branched_s, branched_wall_s),
        ("from the beginning", whole_s, whole_wall_s),
    ):
        print(f"{name}: {used_s / count:.2f} s of processor time a cell, {wall_s / count:.2f} s")
    print(f"ratio {whole_s / branched_s:.2f}")


if __name__ == "__main__":
    main()
