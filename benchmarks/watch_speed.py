"""Time from a save to the figure under `tracerisk run --watch`, beside the run itself.

Each save changes a position by a millimetre, so that nothing is taken from an earlier run.

    python benchmarks/watch_speed.py [CONTROLLER] [--saves N] [--python PYTHON]
"""

from __future__ import annotations

import argparse
import re
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

import quick

SAMPLE = Path(__file__).parents[1] / "sample_controllers" / "pick_and_place.py"
_TIMES = re.compile(r"([\d.]+) s, of which the run ([\d.]+) s")
_PLACE = re.compile(r"(TRAVEL_HEIGHT = |ANGLE = )([\d.]+)")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("controller", nargs="?", type=Path, default=SAMPLE)
    parser.add_argument("--saves", type=int, default=8)
    parser.add_argument("--python", default=sys.executable)
    options = quick.parsed(parser, controller=quick.controller, saves=lambda: 1)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "cell.py")
        text = options.controller.read_text(encoding="utf-8")
        path.write_text(text, encoding="utf-8")
        command = [options.python, "-u", "-m", "tracerisk", "run", path.name, "--watch"]
        process = subprocess.Popen(
            command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )
        pairs: list[tuple[float, float]] = []
        assert process.stdout is not None
        for line in process.stdout:
            times = _TIMES.search(line)
            if times is None:
                continue
            pairs.append((float(times[1]), float(times[2])))
            if len(pairs) > options.saves:
                break
            place = _PLACE.search(text)
            assert place is not None
            higher = float(place[2]) + 0.001 * len(pairs)
            path.write_text(_PLACE.sub(f"{place[1]}{higher:.3f}", text), encoding="utf-8")
        process.terminate()
        process.wait()
    # The first one starts the server that later runs are forked by.
    warm = pairs[1:]
    ratios = [whole / run for whole, run in warm]
    print(f"first: {pairs[0][0]:.2f} s, of which the run {pairs[0][1]:.2f} s")
    print(
        f"{len(warm)} saves: {statistics.median(w for w, _ in warm):.2f} s, of which the run "
        f"{statistics.median(r for _, r in warm):.2f} s; ratio {statistics.median(ratios):.3f} "
        f"({min(ratios):.3f} to {max(ratios):.3f})"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
