"""Try the changes of a controller: plan them, run those that are missing, keep each as it comes."""

from __future__ import annotations

import contextlib
import hashlib
import json
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from tracerisk.common.campaign import DEFAULT_CAMPAIGN, CampaignOptions
from tracerisk.common.text.read_back import read_back
from tracerisk.errors import InputError, TraceRiskError
from tracerisk.instrument.source.python_source import is_python_2
from tracerisk.pipeline.evidence.cell_runs import Nominal, nominal_mission
from tracerisk.pipeline.evidence.journal import journal, journaled
from tracerisk.pipeline.evidence.workers import Workers
from tracerisk.pipeline.freshness.run_inputs import run_inputs, stated
from tracerisk.pipeline.freshness.trace_cache import FOLDER
from tracerisk.pipeline.mutation.change import Change
from tracerisk.pipeline.mutation.mutant_run import MutantJob, run_mutant
from tracerisk.pipeline.mutation.plan import changes_of, drawn
from tracerisk.report.mutants import MutantRun, MutantRuns, ordered

MOST = 60
"""How many changes are tried where nobody says how many."""
_MOST_CHANGES = 10_000
_KEPT = "mutate-"
"""How the names of files begin in which runs are kept."""


@dataclass(frozen=True, slots=True, eq=False)
class MutationPlan:
    """The changes of a controller that are to be tried, in the order in which they are."""

    nominal: Nominal
    """The run without a change."""
    changes: tuple[Change, ...]
    """Those that were drawn."""
    places: int
    """How many there are to draw from."""
    journal: Path
    """The file in which runs are kept as they come."""


def mutate(
    controller: Path,
    settings: Mapping[str, Any] | None = None,
    options: CampaignOptions = DEFAULT_CAMPAIGN,
    *,
    most: int = MOST,
) -> MutantRuns:
    """Change a controller at one place at a time, run each, and return what is noticed.

    `settings` go before those of `pyproject.toml`. At most `most` changes are tried, drawn by the
    seed of the settings. Runs that are kept of an earlier call with the same inputs are taken from
    there, unless the options say otherwise. Nothing but the cache is written.
    Raises ControllerFailedError where the run without a change came to a bad end or commanded
    nothing, InputError where there is nothing to change.
    """
    given = tuple(stated(settings).items())
    plan = plan_mutation(controller, given, most=most)
    mine = [change for number, change in enumerate(plan.changes) if options.has(number)]
    if options.fresh:
        plan.journal.unlink(missing_ok=True)
    mutant_runs = _kept(plan.journal, mine)
    nominal = plan.nominal
    workers = Workers.of(options, nominal.folder)
    # Workers of an executor may be on other machines.
    folder = str(nominal.folder) if workers.executor is None else ""
    todo = [
        MutantJob(str(controller), given, nominal.digest, folder, change)
        for change in mine
        if change not in mutant_runs
    ]
    if todo:
        _remove_older(plan.journal)
        with journal(plan.journal) as keep:
            for job, done in workers.run(run_mutant, todo, options.progress):
                mutant_runs[job.change] = done
                keep([json.dumps({"of": _key(job.change), "run": asdict(done)})])
    verdict = nominal.trace.verdict
    return MutantRuns(
        ordered([*mutant_runs.values()]),
        len(mine),
        plan.places,
        tuple(condition.words for condition in nominal.success),
        "" if verdict is None or verdict.kind == "complete" else str(verdict),
    )


def plan_mutation(
    controller: Path, given: tuple[tuple[str, Any], ...], *, most: int
) -> MutationPlan:
    """Run a controller without a change, and draw what is to be tried. Raises as `mutate`."""
    if not 1 <= most <= _MOST_CHANGES:
        raise InputError(f"{most} changes; allowed: 1 to {_MOST_CHANGES}")
    nominal = nominal_mission(str(controller), given, "change")
    sources = nominal.recording.sources
    changes = [change for file in sorted(sources) for change in _of_file(nominal, file)]
    chosen = drawn(changes, sources, most=most, seed=nominal.settings.seed)
    if not chosen:
        converted = [file for file in sorted(sources) if is_python_2(sources[file])]
        hint = ""
        if converted:
            hint = (
                f": {', '.join(converted)} is Python 2, of which no part is changed for a trial; "
                f"convert it first, e.g. with `2to3 -w {' '.join(converted)}`"
            )
        raise InputError(f"the functions that ran have no place that could be changed{hint}")
    inputs = run_inputs(nominal.controller, nominal.trace, nominal.settings, given=dict(given))
    parts = [inputs.fingerprint, nominal.digest]
    parts += [f"{file} {hashlib.sha256(sources[file]).hexdigest()}" for file in sorted(sources)]
    kept = nominal.controller.root / FOLDER
    kept /= f"{_KEPT}{_digest(nominal.controller.file)}-{_digest(*parts)}.jsonl"
    return MutationPlan(nominal, chosen, len(changes), kept)


def _digest(*parts: str) -> str:
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:16]


def _of_file(nominal: Nominal, file: str) -> Sequence[Change]:
    ran = {site.ref.name for site in nominal.recording.functions_ran if site.ref.file == file}
    # A file that libcst cannot read was not instrumented either.
    with contextlib.suppress(TraceRiskError):
        source = nominal.recording.sources[file]
        return changes_of(source, file, ran, [*_names_alike(nominal)])
    return ()


def _names_alike(nominal: Nominal) -> Iterator[Collection[str]]:
    """Yield the names of the robot and its scene, those of each kind."""
    robot = nominal.run.robot
    yield [joint.name for joint in robot.joints]
    yield [link.name for link in robot.links]
    yield [*robot.groups]
    for states in robot.named_states.values():
        yield [*states]
    if nominal.trace.outcome is not None:
        yield [thing.name for thing in nominal.trace.outcome.objects]


def _key(change: Change) -> list[Any]:
    """Return what says which change it is, of the same sources."""
    return [change.file, change.start, change.end, change.new.decode("latin-1")]


def _remove_older(path: Path) -> None:
    """Remove what is kept of a controller's runs with other inputs."""
    for older in path.parent.glob(f"{path.name.rpartition('-')[0]}-*.jsonl"):
        if older != path:
            older.unlink(missing_ok=True)


def _kept(path: Path, wanted: Sequence[Change]) -> dict[Change, MutantRun]:
    """Return the runs of changes that are kept of an earlier call."""
    by_key = {json.dumps(_key(change)): change for change in wanted}
    mutant_runs = {}
    for line in journaled(path):
        with contextlib.suppress(ValueError, TypeError, KeyError, AttributeError):
            data = json.loads(line)
            change = by_key.get(json.dumps(data["of"]))
            if change is not None:
                mutant_runs[change] = read_back(MutantRun, data["run"])
    return mutant_runs
