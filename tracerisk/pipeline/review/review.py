"""Review a change: build and solve both versions of each controller from their blocks alone."""

from __future__ import annotations

import os
import posixpath
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, NamedTuple

from tracerisk.adder.lock.kept import as_computed, as_repeated
from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.errors import InputError, Location, TraceRiskError
from tracerisk.instrument.source.answers.changed_checks import ChangedCheck, changed_checks
from tracerisk.instrument.source.language import is_c
from tracerisk.pipeline.history.many_at_once import shared_out
from tracerisk.pipeline.history.repository import Repository
from tracerisk.pipeline.model import blocks_of
from tracerisk.pipeline.review.annotated_files import annotated_files
from tracerisk.pipeline.review.causes import cause_finder, evidence_change, input_changes
from tracerisk.pipeline.review.controllers import (
    NOT_RUN,
    ControllerVersion,
    Locks,
    ReviewedController,
    reviewed_controllers,
    version_of,
)
from tracerisk.pipeline.review.git_versions import GitVersion, compared, in_version
from tracerisk.pipeline.review.lost_blocks import with_lost_blocks, written_blocks
from tracerisk.pipeline.review.renamed_functions import (
    FunctionSource,
    renamed_functions,
    renamed_without_block,
    without_step,
)
from tracerisk.pipeline.review.run_changes import (
    evidence_changes,
    newly_moved,
    not_asked,
    outcome_changes,
    outcome_gaps,
    run_changes,
)
from tracerisk.pipeline.review.run_verdicts import refused_line, version_verdict
from tracerisk.pipeline.trace.last_run import kept_repeats, kept_uncovered
from tracerisk.prm.review.change_records import RunVerdicts
from tracerisk.prm.review.model_parts import RiskVersion
from tracerisk.prm.review.risk_change import compare
from tracerisk.prm.review.risk_diff import Review, RiskDiff

if TYPE_CHECKING:
    from tracerisk.adder.blocks.block import RiskBlock
    from tracerisk.common.hardware.model import Hardware


def review(
    words: Sequence[str] = (), folder: Path | None = None, *, with_others: bool = False
) -> Review:
    """Return what changed in risk between two versions that git knows.

    `words` are `[REV[..REV]] [FILE...]`, as `tracerisk diff` takes them; without a revision HEAD
    is compared with the working tree. `folder` is where they are meant, else the current one.
    If asked, the controllers that the change leaves alone are in `others`. Nothing is written.
    Raises InputError for what git does not know, and, naming the version, where blocks are
    malformed or make no model.
    """
    here = Path.cwd() if folder is None else folder
    with Repository.opened(here) as repository:
        what = compared(repository, here, words)
        files = annotated_files(repository, what, with_others=with_others)
        shown = _Shown(repository.top, here)
        controllers = reviewed_controllers(files, what, shown.name, with_others=with_others)
        moved_on = () if what.tip is None else tuple(_moved_on(controllers, what.tip, shown))
    names = _VersionName.of(what.before), _VersionName.of(what.after)
    risk_diffs = shared_out(partial(_reviews, versions=names, shown=shown), controllers)
    for trace_risk_error in risk_diffs:
        if isinstance(trace_risk_error, TraceRiskError):
            raise trace_risk_error
    diffs: dict[bool, list[RiskDiff]] = {True: [], False: []}
    for controller, risk_diff in zip(controllers, risk_diffs, strict=True):
        # A source may speak of blocks and have none.
        if isinstance(risk_diff, RiskDiff) and (risk_diff.before or risk_diff.after):
            diffs[controller.is_changed].append(risk_diff)
    return Review(
        before=what.before.name,
        after=what.after.name,
        controllers=tuple(sorted(diffs[True], key=lambda diff: (-abs(diff.increase), diff.name))),
        others=tuple(diffs[False]),
        notes=files.notes,
        prefixes=(what.before.prefix, what.after.prefix),
        commits=(what.before.commit, what.after.commit),
        folder=shown.folder,
        moved_on=moved_on,
    )


def _moved_on(
    controllers: Sequence[ReviewedController], tip: GitVersion, shown: _Shown
) -> Iterator[str]:
    """Yield what the branch that is merged into has for a controller and its merge base has not."""
    locks = Locks(tip, shown.name)
    for controller in controllers:
        if not controller.is_changed:
            continue
        base, now = controller.before, version_of(locks, controller.was or controller.name)
        is_same = base.sources == now.sources and base.entry == now.entry
        if not now.sources or is_same:
            continue
        name = shown.name(controller.name)
        model, _ = _built(shown.version(now), name, _VersionName.of(tip))
        mission = None if model is None else model.figures.mission
        figure = "" if mission is None else f", and gives {mission.failure_probability:.3e}"
        yield (
            f"{tip.name} has moved on since: {name} is another one there{figure}; what stands here "
            "holds only until they are merged and refreshed"
        )


def diff(
    before_sources: Mapping[str, bytes], after_sources: Mapping[str, bytes], *, name: str = ""
) -> RiskDiff:
    """Return the difference in risk between two versions of one controller's annotated sources.

    Both map the names of files to their bytes, as `build` takes them; a version without blocks
    has no risk to report.
    Raises BlockError, SourceError or ModelError where the blocks are malformed or make no model.
    """
    before = ControllerVersion(before_sources, None, ".")
    after = ControllerVersion(after_sources, None, ".")
    first = next(iter([*after_sources, *before_sources]), "")
    return difference(ReviewedController(name or first, None, before, after), None)


class _VersionName(NamedTuple):
    """A version without its repository, as another process can be given it."""

    name: str
    """The name of the version in messages."""
    prefix: str
    """What stands before its files in places, such as `main:`."""

    @classmethod
    def of(cls, version: GitVersion) -> _VersionName:
        return cls(version.name, version.prefix)


class _Shown:
    """How messages call files: by the path from where the user stands."""

    def __init__(self, top: Path, folder: Path) -> None:
        self._top = top.resolve()
        self._folder = folder.resolve()

    @property
    def folder(self) -> str:
        """The path from the top to where the user stands; empty for the top."""
        if not self._folder.is_relative_to(self._top):
            return ""
        path = self._folder.relative_to(self._top).as_posix()
        return "" if path == "." else path

    def name(self, path: str) -> str:
        shown = os.path.relpath(self._top / path, self._folder)
        # A name that is not UTF-8 has no characters; it is shown as nearly as can be.
        return shown.encode(errors="surrogateescape").decode(errors="replace")

    def version(self, version: ControllerVersion) -> ControllerVersion:
        sources = {self.name(file): source for file, source in version.sources.items()}
        return version._replace(
            sources=sources,
            modules={self.name(file): source for file, source in version.modules.items()},
            folder=self.name(version.folder),
            hardware=None if version.hardware is None else self._hardware(version.hardware),
            success_place=self._place(version.success_place),
        )

    def _place(self, place: Location | None) -> Location | None:
        return None if place is None else replace(place, file=self.name(place.file))

    def _hardware(self, hardware: Hardware) -> Hardware:
        """Return a description with places as they are shown."""
        components = (
            replace(component, location=self._place(component.location))
            for component in hardware.components
        )
        return replace(hardware, file=self.name(hardware.file), components=tuple(components))


def _reviews(
    controllers: Sequence[ReviewedController],
    versions: tuple[_VersionName, _VersionName],
    shown: _Shown,
) -> list[RiskDiff | TraceRiskError]:
    return [_reviewed(controller, versions, shown) for controller in controllers]


def _reviewed(
    controller: ReviewedController, versions: tuple[_VersionName, _VersionName], shown: _Shown
) -> RiskDiff | TraceRiskError:
    named = ReviewedController(
        shown.name(controller.name),
        None if controller.was is None else shown.name(controller.was),
        shown.version(controller.before),
        shown.version(controller.after),
    )
    try:
        return difference(named, versions)
    except TraceRiskError as error:
        return error


def difference(
    controller: ReviewedController, versions: tuple[_VersionName, _VersionName] | None
) -> RiskDiff:
    """Return what became of a controller's risk between two versions.

    Raises where the blocks of one are malformed; `versions` are named in it.
    """
    before, old = _built(controller.before, controller.name, versions and versions[0])
    after, new = _built(controller.after, controller.name, versions and versions[1])
    written = after
    after, repeats = _repeated(before, after, controller)
    functions = {} if after is None else _functions(after, new)
    renamed: dict[str, str] = {}
    without: tuple[str, ...] = ()
    if before is not None and after is not None:
        earlier, sources = _functions(before, old), controller.after.sources
        renamed = renamed_functions(earlier, functions, (controller.before.sources, sources))
        without = without_step(earlier, functions, {**controller.after.modules, **sources})
    moved, rated = _in_descriptions(controller)
    diff = compare(
        before,
        after,
        name=controller.name,
        was=controller.was,
        renamed=renamed,
        cause_of=cause_finder(controller.before, controller.after, functions),
        inputs=input_changes(controller.before, controller.after),
        moved=moved,
        rated=rated,
    )
    verdicts = None
    names = {**_renamed_without_block(controller, renamed), **renamed}
    has_lock = controller.before.entry is not None or controller.after.entry is not None
    was, now = version_verdict(controller.before), version_verdict(controller.after)
    # A log of C or C++ has no verdict; a live run of its node has one.
    if has_lock and (was or now or not is_c(controller.name)):
        verdicts = RunVerdicts(was, now, before is not None, after is not None, names)
    asked = _asked(controller)
    outcome = outcome_changes(controller, before is not None and after is not None)
    changes_of_run = run_changes(controller.before, controller.after, names)
    diff = replace(
        diff,
        within_noise=diff.within_noise + len(repeats),
        noise=max(diff.noise, *repeats, 0.0),
        stated=written.figures.mission if repeats and written is not None else None,
        of_run=changes_of_run,
        of_comparison=tuple(outcome_gaps(controller)) if old and new else (),
        of_evidence=evidence_changes(controller.before, controller.after),
        verdicts=verdicts,
        hardware=_hardware_changes(controller),
        hardware_file=controller.after.hardware.file if controller.after.hardware else "",
        stale=_stale(controller, diff),
        refused=refused_line(controller.after),
        outcome=outcome,
        checks=_checks(controller, names),
        not_asked=not_asked(controller, outcome),
        evidence_change=(
            ""
            if before is None or after is None
            else evidence_change(controller.before, controller.after)
        ),
        asked_less=asked[0],
        success_place=controller.after.success_place,
        without_step=without,
        asked_otherwise=asked[1],
        asked_newly=asked[2],
        moved=newly_moved(controller, functions),
    )
    # Where a run went wrong, no cause of a difference is one.
    return diff if diff.is_comparable else replace(diff, causes=())


def _hardware_changes(controller: ReviewedController) -> tuple[str, ...]:
    """Return what differs in the hardware description between two versions."""
    old, new = controller.before.hardware, controller.after.hardware
    if old is None or new is None:
        return ()
    from tracerisk.common.hardware.changes import description_changes  # few changes touch it

    return description_changes(old, new)


def _in_descriptions(
    controller: ReviewedController,
) -> tuple[dict[str, tuple[str, ...]], dict[str, float]]:
    """Return what two hardware descriptions say of one component in another way.

    The other components of the units of each that only one version has, and the ratio of later to
    earlier figures of each that has one.
    """
    old, new = controller.before.hardware, controller.after.hardware
    if old is None or new is None:
        return {}, {}
    from tracerisk.common.hardware.changes import figure_ratios, moved_units  # few changes touch it

    return {**moved_units(new, old), **moved_units(old, new)}, figure_ratios(old, new)


def _renamed_without_block(
    controller: ReviewedController, renamed: Mapping[str, str]
) -> dict[str, str]:
    before, after = (_never_ran(version) for version in (controller.before, controller.after))
    sources = controller.before.sources, controller.after.sources
    return renamed_without_block(before, after, sources, renamed)


def _never_ran(version: ControllerVersion) -> list[FunctionRef]:
    if version.entry is None:
        return []

    def path(file: str) -> str:
        return posixpath.normpath(posixpath.join(version.folder, file))

    return [ref.with_file(path) for ref in kept_uncovered(version.entry.trace)]


def _stale(controller: ReviewedController, diff: RiskDiff) -> tuple[str, ...]:
    """Return why the later blocks are not those of a run; nothing of blocks that never were."""
    if diff.after is None or (diff.before is not None and NOT_RUN in controller.before.stale):
        return ()
    return controller.after.stale


def _asked(controller: ReviewedController) -> tuple[tuple[str, ...], ...]:
    """Return what `success` of the later version asks less, otherwise, and newly."""
    old, new = controller.before.success, controller.after.success
    if old is None or new is None:
        which = "earlier" if old is None else "later"
        why = f"the scenario of the {which} version cannot be read"
        return (f"what it asked, as far as is known: {why}",), (), ()
    if old == new:
        return (), (), ()
    from tracerisk.pipeline.mission.asked import asked_change  # few changes touch it

    return asked_change(old, new)


def _checks(controller: ReviewedController, renamed: Mapping[str, str]) -> tuple[ChangedCheck, ...]:
    """Return which answers only one version looks at, whether or not evidence credits it."""
    old, new = (
        {**version.modules, **version.sources} for version in (controller.before, controller.after)
    )
    if old == new or not old or not new or is_c(controller.name):
        return ()
    return changed_checks(old, new, renamed)


def _built(
    version: ControllerVersion, name: str, of: _VersionName | None
) -> tuple[RiskVersion | None, dict[str, FunctionRef]]:
    """Return a version's model, `None` without blocks, and its functions by their names in it."""
    try:
        placed = with_lost_blocks(blocks_of(version.sources, _known(version)), version)
        blocks = [
            (ref, as_computed(block, version.entry, _from_lock(ref.file, version), ref.name))
            for ref, block in placed
        ]
        model = RiskVersion.of_blocks([block for _, block in blocks], name) if blocks else None
    except TraceRiskError as error:
        if of is None or not isinstance(error, InputError):
            raise
        raise in_version(error, of) from error
    return model, {block.name: ref for ref, block in blocks}


def _repeated(
    before: RiskVersion | None, after: RiskVersion | None, controller: ReviewedController
) -> tuple[RiskVersion | None, list[float]]:
    """Return the later version with the earlier values of which its live run is a repetition.

    For each comes how far, relatively, such runs repeat. Where the hardware differs, or one run
    was not live, there is none.
    """
    entries = controller.before.entry, controller.after.entry
    traces = [{} if entry is None else entry.trace for entry in entries]
    repeats: list[float] = []
    blocks: list[RiskBlock] = []
    is_same_hardware = controller.before.hardware == controller.after.hardware
    if before is None or after is None or not is_same_hardware:
        return after, repeats
    for name, block in after.blocks.items():
        far = min(kept_repeats(trace, name) for trace in traces)
        same = as_repeated(block, before.blocks.get(name), far)
        pairs = zip(block.components, same.components, strict=True)
        repeats += [far for own, other in pairs if own.probability != other.probability]
        blocks.append(same)
    if not repeats:
        return after, repeats
    return RiskVersion.of_blocks(blocks, after.model.name), repeats


def _from_lock(file: str, version: ControllerVersion) -> str:
    """Return how the lock of a version names one of its sources."""
    return PurePath(os.path.relpath(file, version.folder)).as_posix()


def _known(version: ControllerVersion) -> dict[str, set[QualifiedName]]:
    """Return the names under which the last run wrote blocks, by file."""
    known: dict[str, set[QualifiedName]] = {}
    for ref in written_blocks(version):
        known.setdefault(ref.file, set()).add(ref.name)
    return known


def _functions(version: RiskVersion, refs: Mapping[str, FunctionRef]) -> dict[str, FunctionSource]:
    return {
        name: FunctionSource(block, refs[name].file, refs[name].name)
        for name, block in version.blocks.items()
    }
