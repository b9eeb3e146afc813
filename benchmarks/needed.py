"""Active against needed: fail every unit of the sample controllers, and count what mattered.

    python benchmarks/needed.py [--cells 200] [--jobs N] [--samples NAME ...] [--folder DIR]
        [--csv benchmarks/needed.csv]

Prints for each component and mode in how many tries it was in use and needed, in use and harmless,
idle and needed, idle and harmless; the mission is what the run without a failure reached. With
`--folder` the evidence stays there, and a later call goes on from it. `--csv` writes the same for
each sample, with how many failures were reported to the controller; docs/theory.md has the table
of `needed.csv`.
"""

from __future__ import annotations

import argparse
import csv
import shutil
import tempfile
import time
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

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
    parser.add_argument("--csv", type=Path)
    options = quick.parsed(parser, cells=lambda: 2, jobs=lambda: 1, samples=lambda: ["turn"])
    folder = options.folder or Path(tempfile.mkdtemp())
    scripts = {path.stem: path for path in sorted(SAMPLES.glob("*.py"))}
    scripts["part_sorting"] = SAMPLES / "part_sorting/src/part_sorting/scripts/sort_parts.py"
    names = options.samples or sorted(scripts)
    scripts["turn"] = quick.controller()
    rows: list[Row] = []
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
        rows += rows_of(name, evidence.cells)
    print("", *table_of(rows), sep="\n")
    if options.csv is not None:
        with options.csv.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(Row._fields)
            writer.writerows(rows)


class Row(NamedTuple):
    """What the failures of one kind did to one sample, in tries."""

    sample: str
    """The name of the sample."""
    component: str
    """What the hardware description calls the unit."""
    mode: str
    """How it failed."""
    needed: int
    """In how many tries it was in use, and the mission failed."""
    harmless: int
    """In how many it was in use, and the mission did not."""
    idle_needed: int
    """In how many it was idle, and the mission failed."""
    idle_harmless: int
    """In how many it was idle, and the mission did not."""
    reported: int
    """In how many an interface reported a failure to the controller."""


def rows_of(sample: str, cells: Sequence[Cell]) -> list[Row]:
    """Return a row for each kind of failure of a sample."""
    kinds: dict[tuple[str, str], list[Cell]] = {}
    for cell in cells:
        kinds.setdefault((cell.component, cell.mode), []).append(cell)
    return [
        Row(sample, *kind, *confusion(mine), sum(1 for cell in mine if cell.told_by))
        for kind, mine in sorted(kinds.items())
    ]


def table_of(rows: Iterable[Row]) -> list[str]:
    """Return the lines of the table over all samples."""
    sums: dict[tuple[str, str], list[int]] = {}
    for row in rows:
        for kind in ((row.component, row.mode), ("all", "")):
            counts = sums.setdefault(kind, [0, 0, 0, 0])
            for place, count in enumerate(row[3:7]):
                counts[place] += count
    heads = ("component", "mode", "in use, needed", "in use, harmless", "idle, needed")
    whole = sums.pop(("all", ""), [0, 0, 0, 0])
    return [
        f"| {' | '.join((*heads, 'idle, harmless'))} |",
        "|---|---|---|---|---|---|",
        *(
            f"| {component} | {mode.replace('_', ' ')} | {' | '.join(map(str, counts))} |"
            for (component, mode), counts in sorted(sums.items())
        ),
        f"| all | | {' | '.join(map(str, whole))} |",
    ]


if __name__ == "__main__":
    main()
