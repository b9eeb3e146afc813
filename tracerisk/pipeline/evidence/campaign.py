"""A campaign of failures: draw its cells, run what is missing, keep each as it comes."""

from __future__ import annotations

import contextlib
import hashlib
import itertools
import os
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from tracerisk.adder.sources.write import atomic_write
from tracerisk.common.campaign import CampaignOptions
from tracerisk.common.evidence import EVIDENCE_NAME
from tracerisk.common.evidence.cells import Cell, Evidence, Stratum
from tracerisk.common.evidence.file import cell_line, dump_evidence, parse_cell, read_evidence
from tracerisk.common.evidence.share_interval import weighted_interval
from tracerisk.common.hardware.formats import load_hardware
from tracerisk.common.hardware.model import CONTROL, POWER
from tracerisk.common.text.bounded import MOST_WRITTEN, file_bytes
from tracerisk.config import Settings
from tracerisk.errors import InputError, Location
from tracerisk.pipeline.evidence.cell_runs import (
    BatchDone,
    CellBatch,
    Nominal,
    nominal_mission,
    run_batch,
)
from tracerisk.pipeline.evidence.draw import LEAST_DRAWN, Target, draw_cells
from tracerisk.pipeline.evidence.journal import journal, journaled
from tracerisk.pipeline.evidence.targets import targets_of
from tracerisk.pipeline.evidence.unit_use import UnitUse, unit_uses
from tracerisk.pipeline.evidence.workers import Workers
from tracerisk.pipeline.freshness.run_inputs import run_inputs, stated
from tracerisk.pipeline.freshness.trace_cache import FOLDER
from tracerisk.pipeline.history.file_lock import one_writer

MOST_IN_BATCH = 48
"""How many cells a worker has at a time: they branch off one run, and go with a dead one."""
LEAST_IN_BATCH = 8
"""How many a worker of an executor has at least, as long as all workers have some."""
_MOST_CELLS = 20_000


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """What a campaign tries."""

    nominal: Nominal
    """The run without a failure."""
    controller: str
    """The path of the controller, as it was given."""
    options: tuple[tuple[str, Any], ...]
    """The settings that go before those of `pyproject.toml`, as (name, value)."""
    fingerprint: str
    """The fingerprint of the run without a failure."""
    targets: tuple[Target, ...]
    """The modes of units that the campaign fails."""
    uses: Mapping[str, UnitUse]
    """The use of each unit at each step, by unit."""
    cells: tuple[Cell, ...]
    """The failures to try, the drawn ones first, then those of the table."""
    declared: int
    """The number of cells asked for; the table adds more."""

    @property
    def settings(self) -> Settings:
        """The settings of the campaign."""
        return self.nominal.settings

    @property
    def evidence_path(self) -> Path:
        """The file into which the evidence goes."""
        return self.nominal.controller.root / EVIDENCE_NAME

    @property
    def journal(self) -> Path:
        """The file in which cells are kept as they come, until the campaign is over."""
        name = hashlib.sha256(self.nominal.controller.file.encode()).hexdigest()[:16]
        kept = self.nominal.controller.root / FOLDER
        return kept / f"evidence-{name}-{self.fingerprint[:16]}-{self.settings.seed}.jsonl"

    def evidence(
        self, cells: Sequence[Cell] = (), before: Mapping[Stratum, float] | None = None
    ) -> Evidence:
        """Return the evidence of these cells of the campaign, after that `before`."""
        return Evidence(
            fingerprint=self.fingerprint,
            robot=self.nominal.trace.robot,
            seed=self.settings.seed,
            declared=self.declared,
            success=tuple(condition.words for condition in self.nominal.success),
            cells=tuple(sorted(cells, key=lambda cell: cell.key)),
            before=before or {},
        )

    def is_of(self, found: Evidence) -> bool:
        """Whether evidence is that of this campaign, or of one with other cells of it."""
        ours = self.evidence()
        return (found.fingerprint, found.seed, found.success) == (
            ours.fingerprint,
            ours.seed,
            ours.success,
        )


def plan_campaign(
    controller: Path, options: Mapping[str, Any] | None = None, *, cells: int | None = None
) -> Plan:
    """Run a controller without a failure, and draw what is to be tried.

    `options` go before the settings of `pyproject.toml`; `cells` is how many are drawn, those of
    the settings by default. Raises ControllerFailedError where the run came to a bad end or
    commanded nothing, InputError where there is nothing to fail.
    """
    _check_cells(1 if cells is None else cells)
    given = tuple(stated(options).items())
    nominal = nominal_mission(str(controller), given, "fail")
    declared = nominal.settings.evidence_cells if cells is None else cells
    _check_cells(declared)
    trace, robot = nominal.trace, nominal.run.robot
    hardware = load_hardware(nominal.settings, trace.robot)
    targets = targets_of(trace, robot, hardware, nominal.settings)
    uses = unit_uses(nominal.folder, trace, robot, nominal.settings, (POWER, CONTROL))
    targets = tuple(target for target in targets if target.unit in uses)
    if not targets:
        raise InputError(
            "the hardware description has no unit that the twin can fail; `tracerisk run --fault` "
            "lists those of the robot"
        )
    inputs = run_inputs(nominal.controller, trace, nominal.settings, given=dict(given))
    drawn = draw_cells(targets, uses, trace, cells=declared, seed=nominal.settings.seed)
    return Plan(nominal, str(controller), given, inputs.fingerprint, targets, uses, drawn, declared)


def gather(
    controller: Path,
    settings: Mapping[str, Any] | None,
    options: CampaignOptions,
    *,
    cells: int | None = None,
    until: float | None = None,
) -> Evidence:
    """Plan a campaign and run it; with `until`, draw twice as many cells until the 90 % interval
    of the mission's factor is no wider.

    Raises as `plan_campaign`; see `run_campaign`.
    """
    began, most_s = time.monotonic(), options.most_s
    while True:
        plan = plan_campaign(controller, settings, cells=cells)
        left = None if most_s is None else most_s - (time.monotonic() - began)
        options = replace(options, most_s=left)
        evidence = run_campaign(plan, options)
        low, high = mission_factor(plan, evidence)[1]
        if until is None or high - low <= until or not evidence.is_complete:
            return evidence
        cells, options = min(2 * plan.declared, _MOST_CELLS), replace(options, fresh=False)
        if cells == plan.declared:
            return evidence


def _check_cells(cells: int) -> None:
    if not 1 <= cells <= _MOST_CELLS:
        raise InputError(f"{cells} cells; allowed: 1 to {_MOST_CELLS}")


def run_campaign(plan: Plan, options: CampaignOptions) -> Evidence:
    """Run the cells of a plan that nobody has run yet, and return the evidence there is.

    It is written into `plan.evidence_path` whatever ends the campaign; a killed one goes on from
    its journal.
    """
    noted = options.noted or (lambda _: None)
    last = None if options.fresh else _last(plan)
    if last is not None:
        _note_edits(last, noted)
    known = {} if options.fresh else _known(plan, last)
    before = {} if last is None else _shares_before(plan, last)
    todo = [
        cell
        for number, cell in enumerate(plan.cells)
        if options.has(number) and cell.key not in known
    ]
    if options.fresh:
        plan.journal.unlink(missing_ok=True)
    if todo and len(plan.cells) > plan.declared:
        noted(_size(plan, len(todo)))
    began = time.monotonic()
    try:
        with journal(plan.journal) as keep:
            for done in _batches_done(plan, todo, Workers.of(options)):
                known.update((cell.key, cell) for cell in done.cells)
                if options.executor is not None:
                    keep(map(cell_line, done.cells))
                if options.progress is not None and done.cells:
                    number = sum(1 for cell in todo if cell.key in known)
                    spent_s = time.monotonic() - began
                    options.progress(number, len(todo), spent_s / number * (len(todo) - number))
                if done.whole_runs:
                    noted(f"not branched off one run, but run whole: {done.whole_runs[0]}")
    finally:
        if options.executor is None:
            # Those of workers that ended in the middle of a batch too.
            known.update(_of_plan(plan, _journaled(plan.journal)))
        cells = [known[cell.key] for cell in plan.cells if cell.key in known]
        evidence = plan.evidence(cells, before)
        write_evidence(plan.evidence_path, plan.nominal.controller.file, evidence)
    plan.journal.unlink(missing_ok=True)
    tried = sum(1 for cell in todo if cell.key in known)
    if options.most_s is not None and tried < len(todo):
        noted(f"the time is over: {tried} of {len(todo)} failures were tried in it")
    return evidence


def _size(plan: Plan, todo: int) -> str:
    """Return how many failures a plan has, of which so many are to be tried now, and why."""
    drawn = sum(1 for cell in plan.cells if cell.drawn)
    here = "" if todo == len(plan.cells) else f", {todo} of them now"
    asked = "as asked"
    if drawn > plan.declared:
        asked = f"{plan.declared} were asked for, and each unit and mode has {LEAST_DRAWN} at least"
    return (
        f"{len(plan.cells)} failures to try{here}: {drawn} are drawn ({asked}), and the table of "
        f"units, modes and functions needs {len(plan.cells) - drawn} more; --time limits them"
    )


def write_evidence(path: Path, controller: str, found: Evidence) -> None:
    """Put the evidence of one controller into the file; that of others stays."""
    with one_writer(path.parent):
        everything = read_evidence(path)
        everything[controller] = found
        text = dump_evidence(everything).encode()
        if not path.exists() or file_bytes(path, MOST_WRITTEN) != text:
            atomic_write(path, text)


def mission_factor(plan: Plan, found: Evidence) -> tuple[float, tuple[float, float]]:
    """Return the share of the hazard in use that ends the mission, with its 90 % interval."""
    return weighted_interval(
        [
            (target.hazard, sum(1 for cell in cells if cell.fails), len(cells))
            for target in plan.targets
            if (
                cells := [
                    cell
                    for cell in found.cells
                    if cell.drawn
                    and not cell.is_idle
                    and (cell.unit, cell.mode) == (target.unit, target.mode)
                ]
            )
        ]
    )


def batch_sizes(number: int, workers: int) -> list[int]:
    """Return how many cells a worker of an executor runs together, batch by batch.

    They are fewer towards the end, so that no worker waits long for the last one.
    """
    sizes, left = [], number
    while left:
        share = -(-left // (2 * workers))
        least = min(LEAST_IN_BATCH, -(-left // workers))
        sizes.append(max(least, min(MOST_IN_BATCH, share)))
        left -= sizes[-1]
    return sizes


def _batches_done(plan: Plan, todo: Sequence[Cell], workers: Workers) -> Iterator[BatchDone]:
    """Run cells and yield them as batches of them are done.

    Local workers share the cells of a batch: each has a run of its own and takes from it the next
    cell that nobody has, so that all end at the same time. What a worker had that died is run once
    more.
    """
    left = {cell.key: cell for cell in todo}
    began = time.monotonic()
    jobs = workers.jobs or os.cpu_count() or 1
    # Workers of an executor may be on other machines.
    is_local = workers.executor is None
    batch = partial(
        CellBatch,
        plan.controller,
        plan.options,
        plan.nominal.digest,
        folder=str(plan.nominal.folder) if is_local else "",
        journal=str(plan.journal) if is_local else "",
    )
    for is_shared in (True, False) if is_local else (False,):
        if is_shared:
            parts = [
                batch(cells=cells, claims=tempfile.mkdtemp(dir=plan.nominal.folder))
                for cells in _split(todo, shared_sizes(len(todo), jobs))
            ]
            parts = [part for part in parts for _ in range(min(jobs, len(part.cells)))]
        else:
            parts = [
                batch(cells=cells)
                for cells in _split([*left.values()], batch_sizes(len(left), jobs))
            ]
        spent_s = time.monotonic() - began
        left_s = None if workers.most_s is None else workers.most_s - spent_s
        these = replace(workers, jobs=jobs, most_s=left_s, folder=plan.nominal.folder)
        for _, done in these.run(run_batch, parts):
            for cell in done.cells:
                left.pop(cell.key, None)
            yield done


def _split(cells: Sequence[Cell], sizes: Sequence[int]) -> Iterator[tuple[Cell, ...]]:
    rest = iter(cells)
    return (tuple(itertools.islice(rest, size)) for size in sizes)


def shared_sizes(number: int, workers: int) -> list[int]:
    """Return how many cells all workers share at a time, in parts as equal as can be."""
    parts = -(-number // (MOST_IN_BATCH * workers))
    return [number // parts + (index < number % parts) for index in range(parts)]


# Cells that are there already


def _last(plan: Plan) -> Evidence | None:
    """Return the evidence that the campaign goes on from, or replaces."""
    return read_evidence(plan.evidence_path).get(plan.nominal.controller.file)


def _note_edits(last: Evidence, noted: Callable[[str], None]) -> None:
    if last.edited is not None:
        noted(
            f"{EVIDENCE_NAME} was edited: {last.edited.words}; what does not fit its digest was "
            "left out and tried again"
        )
    if not last.has_digest:
        noted(
            f"{EVIDENCE_NAME} was of an earlier version, which shows no edits; from now on it does"
        )


def _shares_before(plan: Plan, last: Evidence) -> Mapping[Stratum, float]:
    """Return the shares that figures took before the campaign."""
    return last.before if plan.is_of(last) or not last.counts else last.shares()


def _known(plan: Plan, last: Evidence | None) -> dict[tuple[str, str, float], Cell]:
    """Return the cells of the plan that were run before, from the file and the journal."""
    cells: list[Cell] = []
    if last is not None and plan.is_of(last):
        cells += last.cells
    return _of_plan(plan, [*cells, *_journaled(plan.journal)])


def _of_plan(plan: Plan, cells: Sequence[Cell]) -> dict[tuple[str, str, float], Cell]:
    """Return those cells that a plan has, by their keys; what each stands for the plan says."""
    wanted = {cell.key: cell for cell in plan.cells}
    return {cell.key: wanted[cell.key].with_outcome(cell) for cell in cells if cell.key in wanted}


def _journaled(path: Path) -> list[Cell]:
    cells = []
    for number, line in enumerate(journaled(path), start=1):
        # The last line may have been cut by a kill.
        with contextlib.suppress(InputError):
            cells.append(parse_cell(line, Location(str(path), number)))
    return cells
