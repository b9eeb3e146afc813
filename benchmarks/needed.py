"""Active against needed: fail every unit of the sample controllers, and count what mattered.

    python benchmarks/needed.py [--cells 200] [--jobs N] [--samples NAME ...] [--folder DIR]

Prints for each component and mode in how many tries it was in use and needed, in use and harmless,
idle and needed, idle and harmless; the mission is what the run without a failure reached. With
`--folder` the evidence stays there, and a later call goes on from it.
"""

from __future__ import annotations

import argparse
import shutil
import tempfile
import time
from collections import Counter
from pathlib import Path

import quick

from tracerisk.api import gather_evidence
from tracerisk.common.campaign import CampaignOptions
from tracerisk.common.evidence.cells import Cell
from tracerisk.report.fmea import confusion

SAMPLES = Path(__file__).resolve().parents[1] / "sample_controllers"


def main() -> None:
    """Run the campaigns and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cells", type=int, default=200)
    parser.add_argument("--jobs", type=int)
    parser.add_argument("--samples", nargs="*")
    parser.add_argument("--folder", type=Path)
    options = quick.parsed(parser, cells=lambda: 2, jobs=lambda: 1, samples=lambda: ["turn"])
    folder = options.folder or Path(tempfile.mkdtemp())
    scripts = {path.stem: path for path in sorted(SAMPLES.glob("*.py"))}
    scripts["part_sorting"] = SAMPLES / "part_sorting/src/part_sorting/scripts/sort_parts.py"
    names = options.samples or sorted(scripts)
    scripts["turn"] = quick.controller()
    cells: list[Cell] = []
    print(f"{'sample':<18}{'robot':<8}{'tries':>6}{'failed':>8}{'told':>6}{'seconds':>9}")
    for name in names:
        place = folder / name
        place.mkdir(parents=True, exist_ok=True)
        script = Path(scripts[name].name)
        if scripts[name].parent != SAMPLES and scripts[name].is_relative_to(SAMPLES):
            # A workspace of its own, with its package.
            script = scripts[name].relative_to(SAMPLES)
            shutil.copytree(SAMPLES / script.parts[0], place / script.parts[0], dirs_exist_ok=True)
        else:
            shutil.copy(scripts[name], place)
        began = time.monotonic()
        evidence = gather_evidence(
            place / script, options=CampaignOptions(jobs=options.jobs), cells=options.cells
        )
        seconds = time.monotonic() - began
        failed = sum(1 for cell in evidence.cells if cell.fails)
        notified = sum(1 for cell in evidence.cells if cell.told_by)
        print(
            f"{name:<18}{evidence.robot:<8}{len(evidence.cells):>6}{failed:>8}{notified:>6}{seconds:>9.1f}",
            flush=True,
        )
        cells += evidence.cells
    _print_matrix(cells)


def _print_matrix(cells: list[Cell]) -> None:
    print()
    heads = ("component", "mode", "in use, needed", "in use, harmless", "idle, needed")
    print(f"| {' | '.join((*heads, 'idle, harmless'))} |")
    print("|---|---|---|---|---|---|")
    kinds = Counter((cell.component, cell.mode) for cell in cells)
    for component, mode in sorted(kinds):
        mine = [cell for cell in cells if (cell.component, cell.mode) == (component, mode)]
        counts = " | ".join(map(str, confusion(mine)))
        print(f"| {component} | {mode.replace('_', ' ')} | {counts} |")
    counts = " | ".join(map(str, confusion(cells)))
    print(f"| all | | {counts} |")


if __name__ == "__main__":
    main()
