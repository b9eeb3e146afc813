"""What a check finds in the last run of a controller: its contacts, verdict and coverage."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from tracerisk.adder.lock.lock import ControllerLock
from tracerisk.adder.sources.functions import functions_in
from tracerisk.common.function_ref import FunctionRef
from tracerisk.common.instance_name import places
from tracerisk.common.verdict import GAPS, NEVER_RAN, Reason, Verdict, VerdictKind, verdict_line
from tracerisk.common.verdict_codes import ACCEPTABLE
from tracerisk.config import Settings, from_here
from tracerisk.errors import Location, TraceRiskError
from tracerisk.instrument.source.language import is_c
from tracerisk.pipeline.check.finding import CheckFinding, FindingKind
from tracerisk.pipeline.check.remedies import as_typed
from tracerisk.pipeline.freshness.freshness import stale_reasons
from tracerisk.pipeline.freshness.run_inputs import RunInputs
from tracerisk.pipeline.trace.kept_verdict import refused_run
from tracerisk.pipeline.workspace.controller import Controller

if TYPE_CHECKING:
    from tracerisk.common.worlds.world_run import WorldRun

OF_VERDICT: Mapping[VerdictKind, FindingKind] = {
    "complete": "partial",
    "partial": "partial",
    "faulted": "faulted",
    "stuck": "stuck",
}
"""The kind of the finding on a reason, by what the reason makes of a run."""
ACCEPTED_BY = ", or in [tool.tracerisk] accept = "
"""Between how a reason is mended and the entry that accepts it."""

_MEND = "mend it, then `{run}`"
_SCENARIO = "`tracerisk scenario {file} --write` drafts what provides it"
_REMEDIES = {
    "unmet-need": _SCENARIO,
    "input-assumed": _SCENARIO,
    "robot-assumed": "`{run} --robot NAME`",
}
"""What to do about the reasons of a verdict, by code; about all others `_MEND`."""
_REMEDIES_OF_COMPILED = {
    "input-assumed": "give what a user types by --answer TEXT, or mend it, then `{run}`",
    "robot-assumed": "`tracerisk run {file} --robot NAME --live -- COMMAND`",
}
"""The same for compiled nodes, for which no scenario is drafted."""


class CoverageLimits(NamedTuple):
    """How much of what can command hardware must have run."""

    least: float | None = None
    """The least covered fraction, from 0 to 1; `None` for the setting `min_coverage`."""
    base: Verdict | None = None
    """The verdict of the version that a change is made to; `None` for no comparison."""


def _remedy(code: str, controller: Path) -> str:
    file = as_typed(controller)
    if is_c(controller.name):
        known, run = _REMEDIES_OF_COMPILED, f"tracerisk run {file} --live -- COMMAND"
    else:
        known, run = _REMEDIES, f"tracerisk run {file}"
    return known.get(code, _MEND).format(file=file, run=run)


def contact_findings(controller: Controller, entry: ControllerLock) -> Iterable[CheckFinding]:
    """Yield what touched in the last run, in the functions that are there."""
    from tracerisk.pipeline.trace.last_run import kept_contacts

    for contact in kept_contacts(entry.trace):
        place = function_place(controller, contact.function)
        if place is not None:
            yield CheckFinding("contact", str(contact), place, contact.function.name)


def verdict_findings(controller: Controller, verdict: Verdict) -> Iterable[CheckFinding]:
    """Yield the reasons for which a run does not pass: not what never ran."""
    for open_reason in verdict.open_reasons:
        if open_reason.code in GAPS:
            continue
        place = _place(controller, open_reason)
        where = f" (in {open_reason.function})" if open_reason.function else ""
        message = f"{open_reason.words}{where}"
        remedy = _remedy(open_reason.code, controller.path)
        if open_reason.code in ACCEPTABLE:
            remedy += f"{ACCEPTED_BY}[{open_reason.accept_entry}]"
        kind = OF_VERDICT[open_reason.verdict]
        yield CheckFinding(kind, message, place, open_reason.function, remedy)


def _place(controller: Controller, reason: Reason) -> Location:
    if reason.location is None:
        return Location(str(controller.path), 1)
    file = str(controller.path_of(reason.location.file))
    return Location(file, reason.location.line, reason.location.column)


def coverage_findings(
    controller: Controller, verdict: Verdict, least: float | None, base: Verdict | None
) -> Iterable[CheckFinding]:
    """Yield a finding where too little ran: fewer functions than the limit, or than in the base."""
    coverage = verdict.coverage
    ran, number = coverage.ran, coverage.all
    text = f"{ran} of {number} functions with commands ran"
    place = Location(str(controller.path), 1)
    if coverage.never_ran:
        first = coverage.never_ran[0]
        place = Location(str(controller.path_of(first.ref.file)), first.line)
        names = ", ".join(str(uncovered.ref.name) for uncovered in coverage.never_ran)
        text += f", not {names}"
    if least is not None and ran < least * number:
        message = f"{text}; the min_coverage is {least:g}"
        yield CheckFinding("coverage", message, place)
    if base is None:
        return
    before = base.coverage
    if ran * before.all < before.ran * number:
        message = f"{text}; before the change {before.ran} of {before.all} did"
        yield CheckFinding("coverage", message, place)
    known = Counter(reason.key for reason in base.reasons)
    for open_reason in verdict.open_reasons:
        known[open_reason.key] -= 1
        if open_reason.code in GAPS - {NEVER_RAN} and known[open_reason.key] < 0:
            where = f" (in {open_reason.function})" if open_reason.function else ""
            message = f"{open_reason.words}{where}; before the change that was not so"
            yield CheckFinding(
                "coverage", message, _place(controller, open_reason), open_reason.function
            )


def world_findings(
    controller: Controller, runs: Iterable[WorldRun], required: Iterable[str]
) -> Iterable[CheckFinding]:
    """Yield the required worlds in which the last run was not repeated, or on which it depends."""
    known = {run.world: run for run in runs}
    first_line = Location(str(controller.path), 1)
    missing = [name for name in required if name not in known]
    if missing:
        names = ",".join(missing)
        yield CheckFinding(
            "world",
            f"require_worlds names {', '.join(missing)}, and the last run was not repeated there",
            first_line,
            remedy=f"`tracerisk run {as_typed(controller.path)} --worlds {names}`",
        )
    for name in required:
        run = known.get(name)
        if run is not None and run.depends:
            place = run.location
            at = first_line
            if place is not None:
                at = Location(str(controller.path_of(place.file)), place.line)
            why = f" ({run.cause})" if run.cause else ""
            yield CheckFinding(
                "world", f"the run depends on world {name}: {run.words}{why}", at, name
            )


def function_place(controller: Controller, function: FunctionRef) -> Location | None:
    """Return where a function stands now; `None` if it is gone, or its file cannot be read."""
    shown = str(controller.path_of(function.file))
    try:
        lines = functions_in(controller.source_of(function.file), shown)
    except TraceRiskError:
        return None
    numbers = places(function.name, lines)
    return Location(shown, numbers[-1]) if numbers else None


def refused_finding(
    controller: Controller, entry: ControllerLock, settings: Settings
) -> CheckFinding | None:
    """Return that the last run wrote no blocks, as it went wrong; `None` if of other code."""
    refused = refused_run(entry)
    if refused is None or stale_reasons(RunInputs.from_data(refused[1]), controller, settings):
        return None
    verdict = refused[0].with_files(from_here(controller.root))
    message = f"its last run wrote no blocks: {verdict_line(verdict)}; those here are older"
    remedy = f"mend it, then `tracerisk refresh {as_typed(controller.path)}`"
    return CheckFinding("stale", message, Location(str(controller.path), 1), remedy=remedy)
