"""What code scanning should show of controllers: from checks, reviews and runs."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from tracerisk.adder.blocks.model_names import model_names
from tracerisk.adder.blocks.values import COMPONENT_KINDS
from tracerisk.adder.lock.lock import ControllerLock, lock_key
from tracerisk.adder.sources.placed import PlacedBlock
from tracerisk.adder.sources.read import read_blocks
from tracerisk.common.evidence.advice import advice_of
from tracerisk.common.function_ref import FunctionRef
from tracerisk.common.verdict import NEVER_RAN, Reason
from tracerisk.common.worlds.world_run import WorldRun, dependence_line, depending
from tracerisk.config import controller_root, repository_above
from tracerisk.errors import Location, TraceRiskError
from tracerisk.pipeline.check.finding import Checked, CheckFinding, FindingKind
from tracerisk.pipeline.check.metrics import annotated_sources
from tracerisk.pipeline.check.reasons import without_reason
from tracerisk.pipeline.check.run import function_place
from tracerisk.pipeline.freshness.known_controllers import is_gone
from tracerisk.pipeline.freshness.used_evidence import evidence_of_last_run
from tracerisk.pipeline.model import build
from tracerisk.pipeline.trace.last_run import (
    UnexpectedContact,
    contact_text,
    kept_contacts,
    kept_uncovered,
    unexpected_contacts,
)
from tracerisk.pipeline.workspace.controller import Controller, function_of, load_controller
from tracerisk.pipeline.workspace.project import Projects
from tracerisk.prm.review.model_parts import single_points
from tracerisk.prm.review.risk_diff import Review, RiskDiff
from tracerisk.report.ci.sarif import Alert, alert_at
from tracerisk.report.diff.titled_lists import of_checks
from tracerisk.report.diff.wording import some
from tracerisk.trace import Trace

_RULES: dict[FindingKind, str] = {
    "stale": "stale-block",
    "edited": "edited-block",
    "undecided": "undecided-block",
    "missing": "missing-block",
    "orphaned": "missing-block",
    "over_threshold": "over-threshold",
    "unjustified": "unjustified-pin",
    "unequal": "unequal-units",
    "moved": "moved-use",
    "unknown": "unknown-blocks",
    "gone": "unknown-blocks",
    "unsolvable": "unreadable",
    "contact": "unexpected-contact",
    "faulted": "faulted-run",
    "stuck": "faulted-run",
    "partial": "partial-run",
    "coverage": "partial-run",
    "world": "world-dependence",
    "untracked": "unknown-blocks",
}
_FIGURE = re.compile(r"-?\d+(\.\d+)?")
_CONTACT = "unexpected_contact"


def repository_root(path: Path) -> Path:
    """Return the folder that holds the `.git` above a file, else that of its controller."""
    return repository_above(path) or controller_root(path)


def check_alerts(
    paths: Sequence[Path], found: Sequence[Checked | TraceRiskError], projects: Projects
) -> tuple[Alert, ...]:
    """Return the alerts of checked controllers: what `check_controllers` found for `paths`.

    Beside what a check does not let pass they name single points of failure, values set by
    hand without a reason, whether or not the settings demand one, and what the lock keeps of
    the last run: motions that never ran, and unexpected contacts.
    """
    alerts: list[Alert] = []
    for path, check_finding in zip(paths, found, strict=True):
        if isinstance(check_finding, TraceRiskError):
            place = check_finding.location or Location(str(path))
            alerts.append(_alert("unreadable", check_finding.message, place))
            continue
        if is_gone(path, projects):
            alerts += [_of_check(one, ()) for one in check_finding.findings]
            continue
        project = projects.of(path)
        entry = project.lock.controllers.get(lock_key(path, project.root))
        held = annotated_sources(path, projects)
        sources = {file: read_blocks(text, str(file)) for file, text in held.items()}
        placed = [block for blocks in sources.values() for block in blocks]
        pins = [one for file, here in sources.items() for one in without_reason(here, str(file))]
        found_here = [one for one in check_finding.findings if one.kind != "contact"]
        alerts += [_of_check(one, placed) for one in (*found_here, *pins)]
        controller = load_controller(path, project)
        alerts += _of_last_run(controller, entry, sources)
        # Where the sources have changed since the evidence, its lines may be wrong.
        if not any(one.kind in ("stale", "unknown") for one in check_finding.findings):
            alerts += _of_evidence(controller)
        if not any(
            finding.kind in ("missing", "orphaned", "unsolvable")
            for finding in check_finding.findings
        ):
            alerts += _single_points(path.name, held, sources)
    return tuple(dict.fromkeys(alerts))


def review_alerts(review: Review) -> tuple[Alert, ...]:
    """Return the alerts of a change: a run that went wrong, what the mission brings about
    otherwise, redundancy that it took, single points that it made, and components that it leaves
    out by hand.
    """
    alerts: list[Alert] = []
    for diff in review.controllers:
        alerts += _faults(diff)
        first_line = Location(diff.name, 1)
        declared = diff.success_place or first_line
        lines = [(f"`success` no longer asks {asked}", declared) for asked in diff.asked_less]
        outcome = () if diff.outcome is None else diff.outcome.of_mission
        lines += [(line, first_line) for line in outcome]
        alerts += [
            _alert("changed-outcome", line, place, subject=_FIGURE.sub("#", line))
            for line, place in lines
        ]
        for check in diff.lost_checks:
            (line,) = of_checks(review, [check])
            subject = f"{check.function} {check.answer}"
            alerts.append(_alert("lost-check", line, first_line, subject=subject))
        for change in diff.changes:
            field = next(
                (changed_field for changed_field in change.fields if not changed_field.is_gone),
                None,
            )
            place = None if field is None else field.location
            if field is None or place is None:
                continue
            names = {"function": field.function, "component": change.component or ""}
            if change.kind == "component_omitted":
                alerts.append(_alert("omitted-component", change.summary, place, **names))
            for mark, rule in (
                ("lost_redundancy", "lost-redundancy"),
                ("single_point_of_failure", "single-point-of-failure"),
            ):
                if mark in change.marks:
                    alerts.append(_alert(rule, change.summary, place, **names))
    return tuple(alerts)


def _faults(diff: RiskDiff) -> Iterator[Alert]:
    """Yield why the later run went wrong, at their places or else at the first line."""
    verdict = diff.verdicts.after if diff.verdicts is not None and diff.verdicts.in_after else None
    if verdict is None or not verdict.is_bad:
        return
    for reason in verdict.open_reasons:
        if reason.verdict in ("faulted", "stuck"):
            place = reason.location or Location(diff.name, 1)
            # Known by the same as that of a check: both may be handed to one report.
            yield _alert("faulted-run", reason.message_with_caller, place, function=reason.function)


def run_alerts(trace: Trace, root: Path) -> tuple[Alert, ...]:
    """Return the alerts of a run: its findings, and motions of which it shows nothing.

    `root` is the controller's root, from which the trace names files.
    """
    alerts: list[Alert] = []
    if trace.verdict is not None:
        reasons = [
            open_reason
            for open_reason in trace.verdict.open_reasons
            if open_reason.code != NEVER_RAN
        ]
        alerts += [_of_reason(reason, trace, root) for reason in reasons]
    known_messages = {alert.message for alert in alerts}
    for finding in trace.findings:
        if finding.kind != _CONTACT and finding.message not in known_messages:
            place = finding.location or Location(trace.controller)
            subject = f"{finding.kind} {finding.message}"
            alerts.append(_alert("run-finding", finding.message, place, root, subject=subject))
    alerts += [_of_world(run, trace, root) for run in depending(trace.worlds)]
    lines = {function.ref: function.line for function in trace.functions}
    links = {
        element.part or element.name for element in trace.elements if element.kind == "contact"
    }
    for contact, touches in unexpected_contacts(trace.visits).items():
        place = Location(str(root / contact.function.file), lines[contact.function])
        alerts.append(_touched(contact, contact_text(contact, touches, links), place))
    names = model_names([uncovered.ref for uncovered in trace.uncovered])
    alerts += [
        _uncovered(uncovered.ref, names[uncovered.ref], uncovered.line, root)
        for uncovered in trace.uncovered
    ]
    return tuple(alerts)


def _of_reason(reason: Reason, trace: Trace, root: Path) -> Alert:
    """Return the alert of a reason for which a run is not complete."""
    place = reason.location or Location(trace.controller)
    rule = "partial-run" if reason.verdict == "partial" else "faulted-run"
    subject = f"{reason.code} {reason.object}"
    message = reason.message_with_caller
    return _alert(rule, message, place, root, function=reason.function, subject=subject)


def _of_world(run: WorldRun, trace: Trace, root: Path) -> Alert:
    """Return the alert of a world that verdict or outcome depend on."""
    place = run.location or Location(trace.controller)
    return _alert("world-dependence", dependence_line(run), place, root, subject=run.world)


def _of_last_run(
    controller: Controller,
    entry: ControllerLock | None,
    sources: Mapping[Path, Sequence[PlacedBlock]],
) -> Iterator[Alert]:
    """Yield what the lock keeps of the last run, for the functions that are there.

    One with a block by hand has risk data.
    """
    if entry is None:
        return
    root = controller.root
    given = {
        FunctionRef(lock_key(file, root), placed.function)
        for file, blocks in sources.items()
        for placed in blocks
    }
    uncovered = [ref for ref in kept_uncovered(entry.trace) if ref not in given]
    names = model_names(uncovered)
    for ref in uncovered:
        place = function_place(controller, ref)
        if place is not None and place.line is not None:
            yield _uncovered(ref, names[ref], place.line, root)
    for contact in kept_contacts(entry.trace):
        place = function_place(controller, contact.function)
        if place is not None:
            yield _touched(contact, str(contact), place)


def _of_evidence(controller: Controller) -> Iterator[Alert]:
    """Yield where a check would show failures that end the mission undetected."""
    evidence = evidence_of_last_run(controller)
    if evidence is None:
        return

    for advice in advice_of(evidence.cells):
        place = advice.location
        names = {"function": function_of(controller, place), "subject": advice.check}
        yield _alert("undetected-failure", advice.words, place, controller.root, **names)


def _touched(contact: UnexpectedContact, message: str, place: Location) -> Alert:
    function, bodies = contact.function.name, contact.bodies
    return _alert("unexpected-contact", message, place, function=function, subject=bodies)


def _uncovered(ref: FunctionRef, name: str, line: int, root: Path) -> Alert:
    message = f"{name} can move the arm and never ran: no risk data, which is not no risk"
    return _alert("uncovered-motion", message, Location(ref.file, line), root, function=ref.name)


def _alert(
    rule: str, message: str, place: Location, folder: Path = Path(), /, **names: str
) -> Alert:
    """Return the alert at a place, whose file is named from `folder`."""
    return alert_at(rule, message, place, name_in_repository(str(folder / place.file)), **names)


def name_in_repository(shown: str) -> str:
    """Return a file's name from the root of its repository, with `/`."""
    path = Path(shown)
    resolved = path.resolve()
    root = repository_root(path)
    return (resolved.relative_to(root) if resolved.is_relative_to(root) else path).as_posix()


def _of_check(finding: CheckFinding, placed: Sequence[PlacedBlock]) -> Alert:
    function, component, rest = _names(finding.subject, placed)
    rule, place = _RULES[finding.kind], finding.location
    names = {"function": function, "component": component, "subject": rest}
    return _alert(rule, finding.text, place, Path(), **names)


def _names(path: str, placed: Sequence[PlacedBlock]) -> tuple[str, str, str]:
    """Return the function, the component and the key of a dotted path into a block."""
    names = [placed_block.block.name for placed_block in placed]
    inside = [name for name in names if path == name or path.startswith(f"{name}.")]
    if not inside:
        return path, "", ""
    function = max(inside, key=len)
    rest = path[len(function) + 1 :]
    component, _, key = rest.rpartition(".")
    if key in {kind.key for kind in COMPONENT_KINDS}:
        return function, component, key
    return (function, "", rest) if rest in ("callSequence", "next", "") else (function, rest, "")


def _single_points(
    name: str, held: Mapping[Path, bytes], sources: Mapping[Path, Sequence[PlacedBlock]]
) -> Iterator[Alert]:
    annotated = {str(file): held[file] for file, blocks in sources.items() if blocks}
    if not annotated:
        return
    points = single_points(build(annotated, name=name))
    for component, functions in points.items():
        places = [
            (placed_block.block, entry.location)
            for blocks in sources.values()
            for placed_block in blocks
            for entry in placed_block.block.components
            if entry.name == component and not entry.omitted and entry.location is not None
        ]
        if not places:
            continue
        block, place = places[0]
        assert place is not None
        message = f"one failed unit of {component} fails the mission: in {some(functions)}"
        names = {"function": block.name, "component": component}
        yield _alert("single-point-of-failure", message, place, Path(), **names)
