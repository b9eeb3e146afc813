"""Compare the simulation of a traced run with a plain loop over `mj_step`.

The loop replays the recorded controls on the same model from the same state, so both do the
same physics: the ratio is what following motions and sampling at every step cost. The whole
time of the controller, with its imports, planning and inverse kinematics, stands beside it.
Last comes what `tracerisk run --record` costs at 500 Hz, in processor time of the whole command;
asked of it are at most 5 %.

    python benchmarks/run_overhead.py [CONTROLLER] [--repeat N]
"""

from __future__ import annotations

import argparse
import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

import quick

from tracerisk import api
from tracerisk.pipeline.trace.run_files import WallTime
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.recording.replay import Replay, replay
from tracerisk.twin.recording.samples import read_samples
from tracerisk.twin.robots.robot import load_robot

SAMPLE = Path(__file__).parent.parent / "sample_controllers" / "pick_and_place.py"


def measure(script: Path) -> tuple[WallTime, Replay]:
    """Run the controller once, and replay its controls."""
    controller = api.load_controller(script)
    settings = api.load_settings(controller)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        trace = api.trace_controller(controller, settings, keep=folder)
        if not trace.end.is_good:
            raise SystemExit(f"the run failed: {trace.end.message}")
        samples = read_samples(folder)
        plain = replay(samples, load_robot(trace.robot), load_scene(trace.scene))
        return WallTime.read(folder), plain


def processor_s(script: Path, *options: str) -> float:
    """Return the processor time of `tracerisk run --check` and all its processes [s]."""
    command = [sys.executable, "-m", "tracerisk", "run", str(script), "--check", "-q", *options]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, check=False, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def recording_cost(script: Path, repeat: int) -> str:
    """Return what a recording costs, in words; runs with and without one take turns."""
    without, recorded = [], []
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(repeat):
            without.append(processor_s(script))
            recorded.append(processor_s(script, "--record", f"{folder}/run.mcap"))
    # The least of several: what else the machine does only ever adds.
    plain, more = min(without), min(recorded)
    return f"--record: {more:.2f} s of {plain:.2f} s without it, {more / plain - 1.0:+.1%}"


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("controller", nargs="?", type=Path, default=SAMPLE)
    parser.add_argument("--repeat", type=int, default=5)
    options = quick.parsed(parser, controller=quick.controller, repeat=lambda: 1)
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
    print(recording_cost(options.controller, options.repeat))


if __name__ == "__main__":
    main()
