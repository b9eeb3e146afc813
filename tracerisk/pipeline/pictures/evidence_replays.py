"""Pages that show the failures of a campaign that matter, each with its replay."""

from __future__ import annotations

import re
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from markupsafe import Markup

from tracerisk.adder.sources.write import atomic_write
from tracerisk.common.evidence.cells import EFFECTS, Cell, Evidence
from tracerisk.common.hardware.formats import load_hardware
from tracerisk.common.hardware.model import Hardware
from tracerisk.common.sandbox.scratch import scratch
from tracerisk.errors import InputError, LogError
from tracerisk.pipeline.evidence.cell_runs import Nominal, fault_of, nominal_of
from tracerisk.pipeline.evidence.workers import CellProgress
from tracerisk.pipeline.freshness.run_inputs import stated
from tracerisk.pipeline.pictures.run_section import recorded_run, run_section
from tracerisk.pipeline.run.branching.branches import Branch, run_branches
from tracerisk.report.fmea import FATE_WORDS, all_effects, end_effect, fmea_rows, unnoticed_for
from tracerisk.report.html.evidence import render_beside, render_evidence
from tracerisk.report.html.fault_report import render_fault_report
from tracerisk.trace import Trace
from tracerisk.twin.faults.fault import Fault

INDEX, WITHOUT, BESIDE = "index.html", "without.html", "beside.html"
_BATCH = 16


def write_replays(
    controller: Path,
    found: Evidence,
    folder: Path,
    options: Mapping[str, Any] | None = None,
    *,
    progress: CellProgress | None = None,
) -> int:
    """Run the failures that matter again, and write a page with the replay of each.

    Those are, for each component, mode and function, the worst one that ended the mission.
    `index.html` in the folder leads to them, `without.html` is the run without a failure, and
    `beside.html` shows both side by side. Files that are there are replaced. Returns how many
    failures have a page.
    Raises InputError where the folder is a file, and as `plan_campaign`.
    """
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder} is a file; name a folder for the pages")
    given = tuple(stated(options).items())
    nominal = nominal_of(str(controller), given)
    hardware = load_hardware(nominal.settings, nominal.trace.robot)
    folder.mkdir(parents=True, exist_ok=True)
    page = _page(nominal.trace, None, ["nothing failed"], hardware, nominal.folder)
    atomic_write(folder / WITHOUT, page.encode())
    cells = cells_that_matter(found)
    pages: dict[tuple[str, str, float], str] = {}
    began = time.monotonic()
    for at in range(0, len(cells), _BATCH):
        for cell, text in _replayed(nominal, hardware, cells[at : at + _BATCH]):
            name = _name(cell)
            atomic_write(folder / name, text.encode())
            pages[cell.key] = name
            if progress is not None:
                each_s = (time.monotonic() - began) / len(pages)
                progress(len(pages), len(cells), each_s * (len(cells) - len(pages)))
    index = render_evidence(found, Path(controller).name, pages, WITHOUT)
    atomic_write(folder / INDEX, index.encode())
    beside = render_beside(Path(controller).name, pages, WITHOUT)
    atomic_write(folder / BESIDE, beside.encode())
    return len(pages)


def cells_that_matter(found: Evidence) -> list[Cell]:
    """Return the worst failure of each row of the table that ended the mission."""
    worst = []
    for row in fmea_rows(found):
        failed = [cell for cell in row.cells if cell.fails]
        if failed:
            worst.append(min(failed, key=lambda cell: (EFFECTS.index(cell.effect), cell.time_s)))
    return worst


def _replayed(nominal: Nominal, hardware: Hardware, cells: list[Cell]) -> list[tuple[Cell, str]]:
    branches = [Branch(n, (fault_of(item),), item.time_s) for n, item in enumerate(cells)]
    pages = []
    with scratch("replays-") as kept:
        for result in run_branches(
            nominal.controller, nominal.settings, nominal.run, branches, keep=kept
        ):
            cell = cells[result.branch.index]
            if result.done is None:
                continue
            folder = kept / str(result.branch.index)
            fault = fault_of(cell)
            beside = Markup('<a href="{}#{}">beside the run without a failure</a>')
            lines = [beside.format(BESIDE, _name(cell)), *_lines(cell)]
            pages.append((cell, _page(result.run.trace, fault, lines, hardware, folder)))
    return pages


def _page(
    trace: Trace, fault: Fault | None, lines: list[str], hardware: Hardware, recording: Path
) -> str:
    try:
        recorded = recorded_run(recording) or ""
    except LogError:
        recorded = ""
    faults = () if fault is None else (fault,)
    section = run_section(trace, hardware, recorded, faults)
    words = None if fault is None else fault.words
    ways = Markup('<a href="{}">all failures</a>, <a href="{}">the run without a failure</a>')
    return render_fault_report(
        trace, words, [*lines, ways.format(INDEX, WITHOUT)], () if section is None else (section,)
    )


def _lines(cell: Cell) -> list[str]:
    """Return what became of a failure, a line each."""
    unnoticed_s = unnoticed_for((cell,))
    text = "the controller never noticed"
    if unnoticed_s is not None:
        text = f"the controller did not notice within {unnoticed_s} s"
    if cell.noticed_s is not None and cell.noticed_by is not None:
        by = cell.noticed_by.replace("_", " ")
        text = f"the controller noticed after {cell.noticed_s:.2f} s, by {by}"
        text += f", and went on with {cell.next_function}" if cell.next_function else ""
    more = all_effects(cell)
    return [
        f"{cell.component}: {end_effect((cell,))}{f', {more}' if more else ''}",
        *([f"the mission: {FATE_WORDS[cell.fate]}"] if cell.fate is not None else []),
        *([f"the unit itself: {cell.local}"] if cell.local else []),
        text,
        *(f"lost: {name}" for name in cell.lost),
        *([f"hardest touch: {cell.contact}"] if cell.contact else []),
    ]


def _name(cell: Cell) -> str:
    unit = re.sub(r"[^A-Za-z0-9_.-]+", "-", cell.unit)
    return f"{unit}-{cell.mode}-{cell.time_s:.3f}s.html"
