"""Compare the simulation of a traced run with a plain loop over `mj_step`.

The loop replays the recorded controls on the same model from the same state, so both do the
same physics: the ratio is what following motions and sampling at every step cost. The whole
time of the controller, with its imports, planning and inverse kinematics, stands beside it.

    python benchmarks/run_overhead.py [CONTROLLER] [--repeat N]
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
from pathlib import Path

from tracerisk import pipeline
from tracerisk.pipeline.trace.run_files import WallTime
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.recording.replay import Replay, replay
from tracerisk.twin.recording.samples import read_samples
from tracerisk.twin.robots.robot import load_robot

SAMPLE = Path(__file__).parent.parent / "sample_controllers" / "pick_and_place.py"


def measure(script: Path) -> tuple[WallTime, Replay]:
    """Run the controller once, and replay its controls."""
    controller = pipeline.load_controller(script)
    settings = pipeline.load_settings(controller)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        trace = pipeline.trace_controller(controller, settings, keep=folder)
        if not trace.end.is_good:
            raise SystemExit(f"the run failed: {trace.end.message}")
        samples = read_samples(folder)
        plain = replay(samples, load_robot(trace.robot), load_scene(trace.scene))
        return WallTime.read(folder), plain


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("controller", nargs="?", type=Path, default=SAMPLE)
    parser.add_argument("--repeat", type=int, default=5)
    options = parser.parse_args()
    ratios = []
    for number in range(1, options.repeat + 1):
        took, plain = measure(options.controller)
        ratios.append((took.simulation_s / plain.seconds, took.controller_s / plain.seconds))
        print(
            f"{number}: {plain.n_steps} steps, plain mj_step loop {plain.seconds:.2f} s; "
            f"simulation in the run {took.simulation_s:.2f} s, ratio {ratios[-1][0]:.2f}; "
            f"whole controller {took.controller_s:.2f} s, ratio {ratios[-1][1]:.2f}; "
            f"end states {'equal to the bit' if plain.same_end else 'DIFFER'}"
        )
    simulation = statistics.median(ratio for ratio, _ in ratios)
    whole = statistics.median(ratio for _, ratio in ratios)
    print(f"median ratios: simulation {simulation:.2f}, whole controller {whole:.2f}")


if __name__ == "__main__":
    main()
