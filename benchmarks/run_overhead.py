"""Compare the simulation of a traced run with a plain loop over `mj_step`.

The loop replays the recorded controls on the same model from the same state, so both do the
same physics; the ratio is what motion, sampling and the virtual time of the controller cost.

    python benchmarks/run_overhead.py [CONTROLLER] [--repeat N]
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
from pathlib import Path

from tracerisk import pipeline
from tracerisk.pipeline.controller_run import simulation_seconds
from tracerisk.twin.replay import replay
from tracerisk.twin.robot import load_robot
from tracerisk.twin.samples import read_samples
from tracerisk.twin.scene import load_scene

SAMPLE = Path(__file__).parent.parent / "sample_controllers" / "pick_and_place.py"


def measure(script: Path) -> tuple[float, float, int, bool]:
    """Return the seconds of the run's simulation and of the loop, the steps, and bit equality."""
    controller = pipeline.load_controller(script)
    settings = pipeline.load_settings(controller)
    with tempfile.TemporaryDirectory() as folder:
        trace = pipeline.trace_controller(controller, settings, keep=Path(folder))
        if not trace.end.is_good:
            raise SystemExit(f"the run failed: {trace.end.message}")
        samples = read_samples(Path(folder))
        plain = replay(samples, load_robot(trace.robot), load_scene(trace.scene))
        seconds = simulation_seconds(Path(folder))
        return seconds, plain.seconds, plain.n_steps, plain.same_end


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("controller", nargs="?", type=Path, default=SAMPLE)
    parser.add_argument("--repeat", type=int, default=3)
    options = parser.parse_args()
    rows = []
    for number in range(1, options.repeat + 1):
        traced, plain, steps, same = measure(options.controller)
        rows.append((traced, plain))
        print(
            f"{number}: {steps} steps; simulation in the run {traced:.2f} s, "
            f"plain mj_step loop {plain:.2f} s, ratio {traced / plain:.2f}; "
            f"end states {'equal to the bit' if same else 'DIFFER'}"
        )
    traced = statistics.median(row[0] for row in rows)
    plain = statistics.median(row[1] for row in rows)
    ratio = statistics.median(row[0] / row[1] for row in rows)
    print(f"median: {traced:.2f} s, {plain:.2f} s, ratio {ratio:.2f}")


if __name__ == "__main__":
    main()
