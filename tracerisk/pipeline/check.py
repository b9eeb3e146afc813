"""Whether the blocks of controllers can be trusted as they stand, told without a simulation."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import lru_cache
from pathlib import Path
from typing import Literal

from tracerisk.adder.annotate import SourceEvidence, bases_of, merge_with_bases
from tracerisk.adder.block import RiskBlock
from tracerisk.adder.block_digest import is_as_written
from tracerisk.adder.definitions import MODULE, definitions, parse_python
from tracerisk.adder.instance_values import kept_values
from tracerisk.adder.lock import (
    LOCK_NAME,
    ControllerLock,
    Lock,
    as_written,
    lock_key,
    read_lock,
)
from tracerisk.adder.merge import MergePolicy, PersonEdit
from tracerisk.adder.model_names import model_names
from tracerisk.adder.pinned_redundancy import unfounded_redundancies
from tracerisk.adder.read import PlacedBlock, read_blocks
from tracerisk.adder.renames import base_with_names, follow_renames
from tracerisk.adder.values import component_fields
from tracerisk.config import Settings, controller_root, read_settings
from tracerisk.errors import ExitCode, InputError, Location, TraceRiskError
from tracerisk.pipeline.controller import Controller, load_controller
from tracerisk.pipeline.freshness import RunInputs, stale_reasons, values_reasons
from tracerisk.pipeline.kept_verdict import block_lines, kept_verdict
from tracerisk.pipeline.known_functions import check_steps
from tracerisk.pipeline.last_run import kept_contacts
from tracerisk.pipeline.one_writer import one_writer
from tracerisk.pipeline.who_wrote import evidence_for
from tracerisk.trace import (
    GAPS,
    NEVER_RAN,
    FunctionRef,
    QualifiedName,
    Reason,
    Verdict,
    VerdictKind,
)

_OF_ALL = ("pyproject.toml", LOCK_NAME)  # what every controller of a root depends on
_WORTH_A_PROCESS = 20  # files that take as long to check as a process takes to start

FindingKind = Literal[
    "stale",
    "edited",
    "undecided",
    "missing",
    "orphaned",
    "over_threshold",
    "unjustified",
    "unequal",
    "unknown",
    "contact",
    "faulted",
    "stuck",
    "partial",
    "coverage",
]
"""Why blocks are not to be trusted: what they depend on has changed; a person changed a value
that is the tool's; nobody can tell who changed one; a block is gone; its function is gone or
renamed; the mission's failure probability is above `max_risk`; a value is set by hand without a
reason; a redundancy is set by hand over units that differed in the last run; the lock knows
nothing; in the last run something touched that should not, and `fail_on` says that this is to
fail; the last run went wrong, did not come to an end, or rests on needs that nothing met or on
assumptions that nobody accepted; of the functions that can command hardware too few ran."""


_OF_VERDICT: Mapping[VerdictKind, FindingKind] = {
    "complete": "partial",
    "partial": "partial",
    "faulted": "faulted",
    "stuck": "stuck",
}
_OF_LOCK_AND_SOURCE = frozenset({"edited", "undecided", "missing", "orphaned"})


@dataclass(frozen=True, slots=True)
class CheckFinding:
    """One thing that `check` does not let pass, with its place.

    `subject` is the dotted path of what it is about, such as `place.gripper.probability` or
    `place`; empty where it is the whole controller.
    """

    kind: FindingKind
    message: str
    location: Location
    subject: str = ""

    @property
    def exit_code(self) -> ExitCode:
        """What the finding makes of the command's exit code."""
        is_edit = self.kind in ("edited", "undecided")
        return ExitCode.EDIT_IN_THE_WAY if is_edit else ExitCode.WOULD_CHANGE

    def __str__(self) -> str:
        return f"{self.location}: {self.kind.replace('_', ' ')}: {self.message}"


@dataclass(frozen=True, slots=True)
class Checked:
    """A controller, by its path, and what was found; nothing if it may be trusted."""

    path: Path
    findings: tuple[CheckFinding, ...]
    verdict: Verdict | None = None
    """The verdict of the last run; `None` where the lock keeps none."""


def controllers_of(files: Sequence[Path | str]) -> tuple[Path, ...]:
    """Return the controllers whose blocks or traces depend on any of the files, sorted.

    That are the files themselves where the lock knows them or they have blocks, and the
    controllers that import them; all of the lock for the settings, the lock itself or its folder.
    A file that has to do with no controller adds none.
    Raises InputError for a file that is not there, or a lock that cannot be read.
    """
    found: dict[Path, Path] = {}
    users_of: dict[Path, Mapping[str, Sequence[str]]] = {}
    for each in files:
        path = Path(each)
        if path.is_dir():
            inside = controllers_in(path)
            if not inside:
                message = f"no {LOCK_NAME} in this folder knows a controller; name a controller"
                raise InputError(message, Location(str(path)))
            found.update({controller.resolve(): controller for controller in inside})
            continue
        if not path.is_file():
            raise InputError("there is no such file; name a controller", Location(str(path)))
        root = controller_root(path)
        if root not in users_of:
            users_of[root] = _users(lock_of(root))
        key = lock_key(path, root)
        users = users_of[root].get(key, ())
        if key in _OF_ALL:
            users = sorted(lock_of(root).controllers)
        for name in users:
            controller = path if name == key else _shown(root / name, path)
            if controller.is_file():
                found.setdefault(controller.resolve(), controller)
        if not users and path.suffix == ".py" and b"RiskAnnotation" in path.read_bytes():
            found.setdefault(path.resolve(), path)
    return tuple(found[each] for each in sorted(found))


def controllers_in(root: Path) -> tuple[Path, ...]:
    """Return every controller that the lock in a folder knows and that is there, sorted."""
    keys = sorted(lock_of(root).controllers)
    return tuple(root / key for key in keys if (root / key).is_file())


def _users(lock: Lock) -> dict[str, list[str]]:
    """Return, for each file, the controllers that it is, or that depend on it."""
    users: dict[str, list[str]] = {}
    for name, entry in lock.controllers.items():
        inputs = RunInputs.from_data(entry.inputs)
        hardware = inputs.settings.get("hardware", name)
        for file in {name, hardware, *entry.blocks, *inputs.sources, *inputs.files}:
            users.setdefault(file, []).append(name)
    return users


def lock_of(root: Path) -> Lock:
    """Return the lock of a folder, an empty one where there is none; each version is read once."""
    path = root / LOCK_NAME
    try:
        status = path.stat()
    except FileNotFoundError:
        return Lock()
    return _read_once(path, status.st_mtime_ns, status.st_size)


@lru_cache(maxsize=8)
def _read_once(path: Path, mtime_ns: int, size: int) -> Lock:  # noqa: ARG001 - they tell versions
    return read_lock(path)


def _shown(path: Path, like: Path) -> Path:
    return path if like.is_absolute() else Path(os.path.relpath(path))


@dataclass(frozen=True, slots=True)
class CoverageLimits:
    """How much of what can command hardware must have run.

    `least` is a fraction, in place of the setting `min_coverage`; `base` the verdict of the
    version that a change is made to.
    """

    least: float | None = None
    base: Verdict | None = None


_NO_LIMITS = CoverageLimits()


def check_controller(path: Path | str, limits: CoverageLimits = _NO_LIMITS) -> Checked:
    """Return what keeps the blocks of the controller at `path` from being trusted.

    Raises BlockError, SourceError or InputError where a block, a source or the lock is malformed.
    """
    found = _check_once(path, limits)
    if not any(map(_sets_source_against_lock, found.findings)):
        return found
    # Another run may have written between our looks at lock and source; it may not now.
    with one_writer(controller_root(found.path)):
        return _check_once(path, limits)


def _sets_source_against_lock(finding: CheckFinding) -> bool:
    of_a_block = finding.kind == "stale" and bool(finding.subject)
    return of_a_block or finding.kind in _OF_LOCK_AND_SOURCE


def _check_once(path: Path | str, limits: CoverageLimits) -> Checked:
    controller = load_controller(path)
    lock = lock_of(controller.root)
    entry = lock.controllers.get(lock_key(controller.path, controller.root))
    if entry is None:
        place = Location(str(controller.path), 1)
        blocks = read_blocks(controller.source, str(controller.path))
        check_steps(controller, [(placed.block, {}) for placed in blocks], (), before_run=False)
        what = f"{LOCK_NAME} knows nothing of its {len(blocks)} risk blocks"
        message = f"{what}; `tracerisk run {controller.path}`"
        return Checked(controller.path, (CheckFinding("unknown", message, place),))
    recorded = RunInputs.from_data(entry.inputs)
    settings = read_settings(controller.root, controller.file)
    effective = settings.with_options(given_options(recorded, controller))
    sources = _sources(controller, entry)
    _check_steps(controller, entry, sources)
    findings = [
        *_stale(controller, entry, recorded, effective),
        *_of_blocks(controller, entry, sources, evidence_for(controller, entry, effective)),
        *_unjustified(settings, sources),
        *_unequal(entry, sources),
    ]
    if settings.max_risk is not None and not findings:
        findings += _over_threshold(controller, sources, settings.max_risk)
    if settings.fail_on in ("finding", "unexpected_contact"):
        findings += _contacts(controller, entry)
    verdict = _verdict(entry, sources)
    if verdict is not None:
        findings += _of_verdict(controller, verdict)
        least = settings.min_coverage if limits.least is None else limits.least
        findings += _of_coverage(controller, verdict, least, limits.base)
    return Checked(controller.path, tuple(sorted(findings, key=_order)), verdict)


def check_controllers(
    paths: Sequence[Path],
    limits: Sequence[CoverageLimits] = (),
    *,
    jobs: int | None = None,
) -> tuple[Checked | TraceRiskError, ...]:
    """Return for each controller what `check_controller` returns or raises, in their order.

    `limits` are those of each; none for all of them where it is empty.
    Many are shared out among as many processes as there are cores, or `jobs`.
    """
    count = min(jobs or os.cpu_count() or 1, len(paths) // _WORTH_A_PROCESS)
    if count < 2:
        return tuple(map(_checked, paths, limits or [_NO_LIMITS] * len(paths)))
    # Not needed for a few files, where a hundredth of a second is felt.
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import get_context

    with ProcessPoolExecutor(count, mp_context=get_context("fork")) as pool:
        each = limits or [_NO_LIMITS] * len(paths)
        return tuple(pool.map(_checked, paths, each, chunksize=_WORTH_A_PROCESS // 2))


def _checked(path: Path, limits: CoverageLimits) -> Checked | TraceRiskError:
    try:
        return check_controller(path, limits)
    except TraceRiskError as error:
        return error


def given_options(recorded: RunInputs, controller: Controller) -> dict[str, object]:
    """Return the options with which a controller was last run, for `Settings.with_options`.

    A setting that only another version of tracerisk knows is left out.
    """
    root = controller.root.resolve()
    known = {each.name for each in fields(Settings)}
    options: dict[str, object] = {}
    for name, value in recorded.given.items():
        if name not in known:
            continue
        if name == "params":
            options[name] = tuple(str(root / file) for file in value)
        elif isinstance(value, list):
            options[name] = tuple(value)
        elif isinstance(value, str) and Path(value).suffix and name != "active":
            options[name] = str(root / value)
        else:
            options[name] = value
    return options


@dataclass(frozen=True, slots=True)
class _Source:
    """A file with blocks: the name it has in messages and the lock, and what it holds."""

    file: str
    shown: str
    source: bytes
    placed: tuple[PlacedBlock, ...]
    renamed: Mapping[QualifiedName, QualifiedName]


def _sources(controller: Controller, entry: ControllerLock) -> list[_Source]:
    found = []
    for file in (controller.file, *sorted(set(entry.blocks) - {controller.file})):
        if file != controller.file and not controller.path_of(file).is_file():
            continue
        source, shown = controller.source_of(file), str(controller.path_of(file))
        known = {QualifiedName(name) for base in bases_of(file, entry) for name in base}
        followed = follow_renames(source, shown, known)
        found.append(_Source(file, shown, source, followed.placed, followed.renamed))
    return found


def _check_steps(controller: Controller, entry: ControllerLock, sources: Sequence[_Source]) -> None:
    placed = [
        (block.block, base_with_names(entry.blocks.get(each.file, {}), each.renamed))
        for each in sources
        for block in each.placed
    ]
    others = {name for base in entry.blocks.values() for name in base}
    check_steps(controller, placed, others, before_run=False)


def _stale(
    controller: Controller, entry: ControllerLock, recorded: RunInputs, settings: Settings
) -> Iterable[CheckFinding]:
    reasons = (
        *stale_reasons(recorded, controller, settings),
        *values_reasons(recorded, settings),
    )
    place = Location(str(controller.path), 1)
    if reasons:
        yield CheckFinding("stale", f"{'; '.join(reasons)} since the last run", place)
    elif entry.others or entry.is_mixed:
        message = f"{LOCK_NAME} holds the last runs of several branches; `tracerisk refresh`"
        yield CheckFinding("stale", message, place)


def _of_blocks(
    controller: Controller,
    entry: ControllerLock,
    sources: Sequence[_Source],
    evidence: SourceEvidence,
) -> Iterable[CheckFinding]:
    for each in sources:
        for old, new in each.renamed.items():
            line = next(b.first_line for b in each.placed if b.function == new)
            yield CheckFinding(
                "orphaned",
                f"the function of the block `{old}` is called `{new}` now",
                Location(each.shown, line),
                old,
            )
        current = {block.function: block for block in each.placed}
        yield from _edits(entry, each, current, evidence)
        yield from _missing(entry, each, current)
    gone = set(entry.blocks) - {each.file for each in sources}
    for file in sorted(file for file in gone if entry.blocks[file]):
        shown = str(controller.path_of(file))
        names = ", ".join(sorted(entry.blocks[file]))
        yield CheckFinding(
            "missing", f"the file is gone, and with it the blocks of {names}", Location(shown)
        )


def _edits(
    entry: ControllerLock,
    source: _Source,
    current: Mapping[QualifiedName, PlacedBlock],
    evidence: SourceEvidence,
) -> Iterable[CheckFinding]:
    """Yield what is not as the lock says it was written, and whose work that is."""
    bases = [base_with_names(base, source.renamed) for base in bases_of(source.file, entry)]
    for name, placed in current.items():
        written = bases[0].get(name)
        is_settled = written is not None and is_as_written(placed.block, written)
        if is_settled or placed.block.added:
            continue
        outcome = merge_with_bases(
            name,
            bases,
            placed.block,
            None if written is None else as_written(name, written),
            MergePolicy(),
            lambda: evidence(source.file),
            source.renamed,
        )
        place = Location(source.shown, placed.first_line)
        for edit in outcome.edits:
            yield _edit_finding(edit, edit.location or place)
        if not outcome.edits:
            message = f"the risk block of {name} {_behind(placed.block, outcome.block)}"
            yield CheckFinding("stale", f"{message}; `tracerisk refresh` mends it", place, name)


def _edit_finding(edit: PersonEdit, place: Location) -> CheckFinding:
    what = (
        f"{edit.field} is {edit.found}, was written as {edit.written or 'nothing'}"
        if edit.kind == "changed"
        else f"{edit.field} was {edit.kind}{' by hand' if edit.is_certain else ''}"
    )
    if edit.is_certain:
        advice = "write `:=` to keep it, or refresh with --accept-edits or --discard-edits"
        return CheckFinding("edited", f"{what}; {advice}", place, edit.field)
    advice = (
        "nobody can tell whether a person did that or another branch: refresh with "
        "--discard-edits, or take the block from a version that you trust"
    )
    return CheckFinding("undecided", f"{what}; {advice}", place, edit.field)


def _behind(found: RiskBlock, due: RiskBlock | None) -> str:
    """Return in what a block is not as it was last written, by no one's edit."""
    if due is None:
        return "is not of the last run"
    if found.digest is None:
        return "was written by an earlier version of tracerisk, without a digest"
    return "holds values of another run or another branch"


def _missing(
    entry: ControllerLock, source: _Source, current: Mapping[QualifiedName, PlacedBlock]
) -> Iterable[CheckFinding]:
    written = set(entry.blocks.get(source.file, {})) - set(source.renamed)
    lost = sorted(written - set(current))
    if not lost:
        return
    tree = parse_python(source.source, source.shown).tree
    lines = {each.name: each.line for each in definitions(tree)}
    for name in lost:
        if name in lines or name == "<module>":
            place = Location(source.shown, lines.get(QualifiedName(name), 1))
            yield CheckFinding("missing", f"the risk block of {name} is gone", place, name)


def _unjustified(settings: Settings, sources: Sequence[_Source]) -> Iterable[CheckFinding]:
    if not settings.require_reason:
        return
    for each in sources:
        yield from without_reason(each.placed, each.shown)


def without_reason(blocks: Iterable[PlacedBlock], shown: str) -> Iterable[CheckFinding]:
    """Yield a finding for each thing that a person set without a reason in a file's blocks."""
    for placed in blocks:
        for path, place in _values_without_reason(placed.block):
            message = f"{path} is set by hand without a reason; write `; why` behind it"
            yield CheckFinding("unjustified", message, place or Location(shown), path)


def _values_without_reason(block: RiskBlock) -> Iterable[tuple[str, Location | None]]:
    if block.added and block.reason is None:
        yield block.name, block.location
    for key, value in (("callSequence", block.call_sequence), ("next", block.next)):
        if value is not None and value.pinned and value.reason is None:
            yield f"{block.name}.{key}", value.location
    for component in block.components:
        path = f"{block.name}.{component.name}"
        if (component.added or component.omitted) and component.reason is None:
            yield path, component.location
        for kind, value in component_fields(component):
            if value.pinned and value.reason is None:
                yield f"{path}.{kind.key}", value.location


def _unequal(entry: ControllerLock, sources: Sequence[_Source]) -> Iterable[CheckFinding]:
    """Yield the redundancies set by hand over units that differed when it was last run."""
    names = model_names(
        [FunctionRef(each.file, placed.function) for each in sources for placed in each.placed]
    )
    for each in sources:
        for placed in each.placed:
            name = names[FunctionRef(each.file, placed.function)]
            instances = kept_values(entry.trace, name)
            for found in unfounded_redundancies(placed.block, instances):
                place = found.location or Location(each.shown, placed.first_line)
                yield CheckFinding("unequal", found.message, place, found.path)


def _contacts(controller: Controller, entry: ControllerLock) -> Iterable[CheckFinding]:
    """Yield what touched in the last run, in the functions that are there."""
    for each in kept_contacts(entry.trace):
        place = function_place(controller, each.function)
        if place is not None:
            yield CheckFinding("contact", str(each), place, each.function.name)


def _verdict(entry: ControllerLock, sources: Sequence[_Source]) -> Verdict | None:
    """Return the verdict that the lock keeps, with the lines that the sources have now."""
    verdict = kept_verdict(entry)
    if verdict is None:
        return None
    held = {each.file: each.source for each in sources}
    return verdict.with_lines(block_lines(held, {each.file: each.shown for each in sources}))


def _of_verdict(controller: Controller, verdict: Verdict) -> Iterable[CheckFinding]:
    """Yield the reasons for which a run does not pass: not what never ran."""
    for each in verdict.open_reasons:
        if each.code in GAPS:
            continue
        place = _place(controller, each)
        where = f" (in {each.function})" if each.function else ""
        advice = "" if each.verdict == "stuck" else f"; {each.code} may be accepted, with words"
        message = f"{each.words}{where}{advice}"
        yield CheckFinding(_OF_VERDICT[each.verdict], message, place, each.function)


def _place(controller: Controller, reason: Reason) -> Location:
    if reason.location is None:
        return Location(str(controller.path), 1)
    file = str(controller.path_of(reason.location.file))
    return Location(file, reason.location.line, reason.location.column)


def _of_coverage(
    controller: Controller, verdict: Verdict, least: float | None, base: Verdict | None
) -> Iterable[CheckFinding]:
    """Yield a finding where too little ran: fewer functions than the limit, or than in the base."""
    coverage = verdict.coverage
    ran, number = coverage.ran, coverage.all
    told = f"{ran} of {number} functions with commands ran"
    place = Location(str(controller.path), 1)
    if coverage.never_ran:
        first = coverage.never_ran[0]
        place = Location(str(controller.path_of(first.ref.file)), first.line)
        names = ", ".join(str(each.ref.name) for each in coverage.never_ran)
        told += f", not {names}"
    if least is not None and ran < least * number:
        message = f"{told}; the min_coverage is {least:g}"
        yield CheckFinding("coverage", message, place)
    if base is None:
        return
    before = base.coverage
    if ran * before.all < before.ran * number:
        message = f"{told}; before the change {before.ran} of {before.all} did"
        yield CheckFinding("coverage", message, place)
    known = Counter(each.key for each in base.reasons)
    for each in verdict.open_reasons:
        known[each.key] -= 1
        if each.code in GAPS - {NEVER_RAN} and known[each.key] < 0:
            where = f" (in {each.function})" if each.function else ""
            message = f"{each.words}{where}; before the change that was not so"
            yield CheckFinding("coverage", message, _place(controller, each), each.function)


def function_place(controller: Controller, function: FunctionRef) -> Location | None:
    """Return where a function stands now; `None` if it is gone, or its file cannot be read."""
    shown = str(controller.path_of(function.file))
    try:
        tree = parse_python(controller.source_of(function.file), shown).tree
    except TraceRiskError:
        return None
    lines = {MODULE: 1, **{each.name: each.line for each in definitions(tree)}}
    line = lines.get(function.name)
    return None if line is None else Location(shown, line)


def _over_threshold(
    controller: Controller, sources: Sequence[_Source], max_risk: float
) -> Iterable[CheckFinding]:
    from tracerisk.pipeline.stages import build, solve

    held = {each.shown: each.source for each in sources if each.placed}
    if not held:
        return
    mission = solve(build(held, name=controller.path.name)).mission
    if mission.failure_probability > max_risk:
        yield CheckFinding(
            "over_threshold",
            f"the mission fails with probability {mission.failure_probability:.4g}, above the "
            f"max_risk of {max_risk:g}",
            Location(str(controller.path), 1),
        )


def _order(finding: CheckFinding) -> tuple[str, int, str, str]:
    return (
        finding.location.file,
        finding.location.line or 0,
        finding.kind,
        finding.message,
    )
