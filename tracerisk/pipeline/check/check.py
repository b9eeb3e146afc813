"""Whether the blocks of controllers can be trusted as they stand, without a simulation."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from tracerisk.adder.blocks.block import RiskBlock
from tracerisk.adder.blocks.values import has_pins
from tracerisk.adder.lock.digest import is_as_written
from tracerisk.adder.lock.lock import LOCK_NAME, ControllerLock
from tracerisk.adder.sources.renames import follow_renames, followed_sources
from tracerisk.common.evidence import EVIDENCE_NAME
from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.common.settings.settings_file import names_file
from tracerisk.common.verdict import Verdict
from tracerisk.config import Settings, controller_root
from tracerisk.errors import Location, TraceRiskError
from tracerisk.pipeline.check.against_lock import CheckedSource, blocks_against_lock
from tracerisk.pipeline.check.finding import Checked, CheckFinding
from tracerisk.pipeline.check.not_in_git import untracked_findings
from tracerisk.pipeline.check.reasons import set_by_hand, without_reason
from tracerisk.pipeline.check.remedies import as_typed, with_remedy
from tracerisk.pipeline.check.run import (
    CoverageLimits,
    contact_findings,
    coverage_findings,
    refused_finding,
    verdict_findings,
    world_findings,
)
from tracerisk.pipeline.freshness.freshness import (
    check_changed_hardware,
    stale_reasons,
    tolerance_reasons,
    values_reasons,
)
from tracerisk.pipeline.freshness.known_controllers import (
    is_gone,
    moved_from,
    sources_with_blocks,
    with_moved,
)
from tracerisk.pipeline.freshness.known_functions import check_named_functions, check_steps
from tracerisk.pipeline.freshness.run_inputs import RunInputs
from tracerisk.pipeline.freshness.used_evidence import evidence_gap, kept_evidence
from tracerisk.pipeline.freshness.who_wrote import evidence_for
from tracerisk.pipeline.history.many_at_once import shared_out
from tracerisk.pipeline.trace.kept_verdict import block_lines, kept_verdict
from tracerisk.pipeline.workspace.controller import Controller, load_controller
from tracerisk.pipeline.workspace.project import Projects

if TYPE_CHECKING:
    from tracerisk.common.worlds.world_run import WorldRun

_OF_LOCK_AND_SOURCE = frozenset({"edited", "undecided", "missing", "orphaned"})
_NO_LIMITS = CoverageLimits()


def check_controller(
    path: Path, projects: Projects, limits: CoverageLimits = _NO_LIMITS
) -> Checked:
    """Return what keeps the blocks of the controller at `path` from being trusted.

    Raises BlockError, SourceError or InputError where a block, a source or the lock is malformed,
    HardwareError where the hardware description has changed and is.
    """
    check_once = _check_once(path, projects, limits)
    if not any(map(_sets_source_against_lock, check_once.findings)):
        return check_once
    from tracerisk.pipeline.history.file_lock import one_writer

    # Another run may have written between our looks at lock and source; it may not now.
    with one_writer(controller_root(check_once.path)):
        return _check_once(path, projects, limits)


def _sets_source_against_lock(finding: CheckFinding) -> bool:
    of_a_block = finding.kind == "stale" and bool(finding.subject)
    return of_a_block or finding.kind in _OF_LOCK_AND_SOURCE


def _check_once(path: Path, projects: Projects, limits: CoverageLimits) -> Checked:
    if is_gone(path, projects):
        message = f"{LOCK_NAME} knows this controller, which is gone"
        finding = CheckFinding("gone", message, Location(str(path)))
        return Checked(path, (with_remedy(finding, path),))
    return check_loaded(load_controller(path, projects.of(path)), limits)


def check_loaded(controller: Controller, limits: CoverageLimits = _NO_LIMITS) -> Checked:
    """Return what `check_controller` does of a controller whose files count as they are here.

    So an editor asks, whose texts nobody has saved. What another run writes meanwhile is not
    waited for.
    Raises as `check_controller`.
    """
    place = Location(str(controller.path), 1)
    lock = controller.project.lock
    was = moved_from(lock, controller)
    entry = with_moved(lock, controller).controllers.get(controller.file)
    if entry is None:
        blocks = follow_renames(controller.source, str(controller.path), ()).placed
        check_steps(controller, [(placed.block, {}) for placed in blocks], (), before_run=False)
        number = "risk block" if len(blocks) == 1 else f"{len(blocks)} risk blocks"
        finding = CheckFinding("unknown", f"{LOCK_NAME} knows nothing of its {number}", place)
        return Checked(controller.path, (with_remedy(finding, controller.path),))
    recorded = RunInputs.from_data(entry.inputs)
    settings = controller.settings
    check_named_functions(controller, settings, files=tuple(recorded.sources))
    effective = settings.with_options(given_options(recorded, controller))
    sources = _sources(controller, entry)
    _check_steps(controller, entry, sources)
    check_changed_hardware(effective, recorded)
    findings = [
        *_stale(controller, entry, recorded, effective),
        *blocks_against_lock(
            controller, entry, sources, evidence_for(controller, entry, effective)
        ),
        *_set_by_hand(settings, entry, sources),
    ]
    if was is not None:
        message = f"{LOCK_NAME} knows this controller as {was}"
        findings.append(CheckFinding("gone", message, place))
    is_whole = all(finding.kind not in ("missing", "orphaned") for finding in findings)
    if is_whole:
        limits_of_model = {} if findings else _limits_of_model(settings)
        known = {
            finding.subject.rpartition(".")[0] for finding in findings if finding.kind == "moved"
        }
        findings += (
            finding
            for finding in _of_model(controller, entry, _blocks(sources), limits_of_model)
            if finding.kind != "moved" or finding.subject not in known
        )
    if settings.fail_on in ("finding", "unexpected_contact"):
        findings += contact_findings(controller, entry)
    verdict = _verdict(entry, sources)
    if verdict is not None:
        findings += verdict_findings(controller, verdict)
        least = settings.min_coverage if limits.least is None else limits.least
        findings += coverage_findings(controller, verdict, least, limits.base)
    if settings.require_worlds:
        findings += world_findings(controller, _worlds(entry, sources), settings.require_worlds)
    findings = [with_remedy(finding, controller.path) for finding in findings]
    notes = (*_by_hand(sources), *_given(recorded))
    found = tuple(sorted(findings, key=_order))
    # What stands in a lock that is not as it was written is nobody's verdict.
    return Checked(controller.path, found, None if entry.is_mixed else verdict, notes)


def check_controllers(
    paths: Sequence[Path],
    projects: Projects,
    limits: Sequence[CoverageLimits] = (),
    *,
    jobs: int | None = None,
) -> tuple[Checked | TraceRiskError, ...]:
    """Return for each controller what `check_controller` returns or raises, in their order.

    `limits` are those of each; none for all of them where it is empty. What git lacks is found
    here alone, for all of a repository at once.
    Many are shared out among as many processes as there are cores, or `jobs`.
    """
    asked = zip(paths, limits or [_NO_LIMITS] * len(paths), strict=True)
    results = shared_out(partial(_checked, projects), list(asked), jobs=jobs)
    untracked = untracked_findings(paths, projects)
    return tuple(
        result._replace(findings=(*untracked.get(result.path, ()), *result.findings))
        if isinstance(result, Checked)
        else result
        for result in results
    )


def _checked(
    projects: Projects, asked: Sequence[tuple[Path, CoverageLimits]]
) -> list[Checked | TraceRiskError]:
    return [_checked_or_error(path, projects, limits) for path, limits in asked]


def _checked_or_error(
    path: Path, projects: Projects, limits: CoverageLimits
) -> Checked | TraceRiskError:
    try:
        return check_controller(path, projects, limits)
    except TraceRiskError as error:
        return error


def given_options(recorded: RunInputs, controller: Controller) -> dict[str, object]:
    """Return the options with which a controller was last run, for `Settings.with_options`.

    A setting that only another version of tracerisk knows is left out.
    """
    root = controller.root.resolve()
    known = {entry.name for entry in fields(Settings)}
    options: dict[str, object] = {}
    for name, value in recorded.given.items():
        if name not in known:
            continue
        if name in ("params", "drivers"):
            options[name] = tuple(str(root / file) for file in value)
        elif isinstance(value, list):
            options[name] = tuple(value)
        elif names_file(name, value, root):
            options[name] = str(root / value)
        else:
            options[name] = value
    return options


def _sources(controller: Controller, entry: ControllerLock) -> list[CheckedSource]:
    sources, shown = sources_with_blocks(controller, entry)
    followed = followed_sources(sources, entry, shown)
    return [CheckedSource(file, shown[file], sources[file], one) for file, one in followed.items()]


def _check_steps(
    controller: Controller, entry: ControllerLock, sources: Sequence[CheckedSource]
) -> None:
    placed = [
        (block.block, source.followed.bases[0]) for source in sources for block in source.placed
    ]
    others = {name for base in entry.blocks.values() for name in base}
    check_steps(controller, placed, others, before_run=False)


def _stale(
    controller: Controller, entry: ControllerLock, recorded: RunInputs, settings: Settings
) -> Iterable[CheckFinding]:
    reasons = (
        *stale_reasons(recorded, controller, settings),
        *values_reasons(recorded, controller, settings),
        *tolerance_reasons(entry, settings),
    )
    place = Location(str(controller.path), 1)
    if reasons:
        changed = CheckFinding("stale", f"{'; '.join(reasons)} since the last run", place)
        yield refused_finding(controller, entry, settings) or changed
    if entry.others and not reasons:
        message = f"{LOCK_NAME} holds the last runs of several branches"
        yield CheckFinding("stale", message, place)
    elif entry.is_mixed:
        message = (
            f"the entry of {controller.file} in {LOCK_NAME} is not as tracerisk wrote it: it was "
            "changed by hand, or a merge mixed the lines of two branches"
        )
        yield CheckFinding("stale", message, place)
    evidence = kept_evidence(controller)
    again = f"`tracerisk evidence {as_typed(controller.path)}`"
    if evidence is not None and evidence.edited is not None:
        place = Location(str(controller.root / EVIDENCE_NAME))
        remedy = f"{again} tries it again, or restore the file from git"
        yield CheckFinding("edited", evidence.edited.words, place, remedy=remedy)
    elif gap := evidence_gap(controller, settings, recorded.fingerprint):
        message = f"the settings ask for evidence, but {gap}"
        remedy = f"{again}, then `tracerisk refresh {as_typed(controller.path)}`"
        yield CheckFinding("stale", message, place, remedy=remedy)


def _set_by_hand(
    settings: Settings, entry: ControllerLock, sources: Sequence[CheckedSource]
) -> Iterable[CheckFinding]:
    """Yield what keeps values that users set by hand from being trusted."""
    if settings.require_reason:
        for source in sources:
            yield from without_reason(source.placed, source.shown)
    has_some = any(has_pins(placed.block) for source in sources for placed in source.placed)
    if not has_some and not entry.owned:
        return
    from tracerisk.pipeline.check.set_by_hand import moved_values, unequal_units

    if has_some:
        yield from unequal_units(entry, sources)
    if entry.owned:
        yield from moved_values(entry, sources, _blocks(sources))


def _by_hand(sources: Sequence[CheckedSource]) -> Iterable[str]:
    """Yield how many values of the blocks are a user's, and where they are listed."""
    by_hand = [
        value for source in sources for one in source.placed for value in set_by_hand(one.block)
    ]
    if by_hand:
        bare = sum(reason is None for _, _, reason in by_hand)
        files = " ".join(
            as_typed(Path(source.shown))
            for source in sources
            if any(has_pins(one.block) for one in source.placed)
        )
        number = "1 value is" if len(by_hand) == 1 else f"{len(by_hand)} values are"
        yield (
            f"{number} set by hand, {bare or 'none'} without a reason; "
            f"`tracerisk overrides {files}` lists them"
        )


def _given(recorded: RunInputs) -> Iterable[str]:
    """Yield the options that the last run had from its command line, and a refresh has again."""
    if recorded.given:
        listed = ", ".join(f"{name} = {value}" for name, value in recorded.given.items())
        yield f"its last run was given on the command line, beside the settings: {listed}"


def _blocks(sources: Sequence[CheckedSource]) -> dict[FunctionRef, RiskBlock]:
    return {
        FunctionRef(source.file, placed.function): placed.block
        for source in sources
        for placed in source.placed
    }


def _verdict(entry: ControllerLock, sources: Sequence[CheckedSource]) -> Verdict | None:
    """Return the verdict that the lock keeps, with the lines that the sources have now."""
    verdict = kept_verdict(entry)
    if verdict is None:
        return None
    return verdict.with_lines(_lines_now(sources))


def _worlds(entry: ControllerLock, sources: Sequence[CheckedSource]) -> list[WorldRun]:
    """Return the runs in worlds that the lock keeps, with the lines that the sources have now."""
    from tracerisk.common.worlds.world_run import kept_worlds

    line_of = _lines_now(sources)
    return [run.with_line(line_of) for run in kept_worlds(entry.trace)]


def _lines_now(sources: Sequence[CheckedSource]) -> Callable[[str, int], int]:
    """Return what gives a place of the lock the line that it has in the sources now."""
    texts = {source.file: source.source for source in sources}
    return block_lines(texts, {source.file: source.shown for source in sources})


def _of_model(
    controller: Controller,
    entry: ControllerLock,
    placed: Mapping[FunctionRef, RiskBlock],
    limits: Mapping[str, float],
) -> Iterable[CheckFinding]:
    """Yield why the blocks make no model that can be solved, or one above one of the limits.

    Blocks that are the tool's word alone were a model when they were written; they need no solving
    again.
    """
    if not placed or (not limits and _are_as_written(entry, placed)):
        return ()
    from tracerisk.pipeline.check.model_findings import model_findings

    return model_findings(controller, entry, placed, limits)


def _limits_of_model(settings: Settings) -> dict[str, float]:
    limits = {
        name: getattr(settings, name)
        for name in ("max_failure_probability", "max_undetected_probability")
    }
    return {name: limit for name, limit in limits.items() if limit is not None}


def _are_as_written(entry: ControllerLock, placed: Mapping[FunctionRef, RiskBlock]) -> bool:
    """Return whether all blocks of a controller state what the lock says, and nothing else."""
    written = {
        FunctionRef(file, QualifiedName(name)): block
        for file, blocks in entry.blocks.items()
        for name, block in blocks.items()
    }
    ranks = {block.call_sequence.value for block in placed.values()}
    return (
        written.keys() == placed.keys()
        and len(ranks) == len(placed)
        and not any(map(has_pins, placed.values()))
        and all(is_as_written(block, written[ref]) for ref, block in placed.items())
    )


def _order(finding: CheckFinding) -> tuple[str, int, str, str]:
    return (
        finding.location.file,
        finding.location.line or 0,
        finding.kind,
        finding.message,
    )
