"""Put the risk blocks of a trace into the sources of its controller, and write them."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from tracerisk.adder.annotate import (
    AnnotatedSource,
    Annotation,
    Changed,
    EditsInTheWay,
    SourceBlocks,
    annotate_sources,
)
from tracerisk.adder.figures.computed import ComputedBlocks, compute_blocks
from tracerisk.adder.figures.following import ProfileText
from tracerisk.adder.lock.digest import block_digests
from tracerisk.adder.lock.lock import LOCK_NAME, Behind, ControllerLock, Lock, lock_key
from tracerisk.adder.merge.edits_found import MergePolicy
from tracerisk.adder.merge.owned import MovedUse, moved_uses
from tracerisk.adder.merge.steady import is_same_run
from tracerisk.adder.sources.functions import digests_behind
from tracerisk.adder.sources.insert import in_form as blocks_in_form
from tracerisk.adder.sources.line_map import line_maps
from tracerisk.adder.sources.write import FileWrite, write_all
from tracerisk.common.dependencies import require_simulator
from tracerisk.common.function_ref import QualifiedName
from tracerisk.common.hardware.model import Hardware
from tracerisk.common.outcome.tolerances import Tolerances
from tracerisk.common.text.bounded import file_bytes
from tracerisk.common.text.digests import short_digest
from tracerisk.common.worlds.world_run import WorldRun, kept_worlds
from tracerisk.config import BlockForm, Settings
from tracerisk.errors import InputError, Location
from tracerisk.pipeline.freshness.known_controllers import with_moved
from tracerisk.pipeline.freshness.known_functions import check_named_functions
from tracerisk.pipeline.freshness.run_inputs import RunInputs, run_inputs
from tracerisk.pipeline.freshness.trace_cache import TraceCache
from tracerisk.pipeline.freshness.used_evidence import used_evidence
from tracerisk.pipeline.freshness.who_wrote import evidence_for
from tracerisk.pipeline.history.file_lock import one_writer
from tracerisk.pipeline.trace.c_scopes import with_scopes
from tracerisk.pipeline.trace.kept_verdict import bare_lines
from tracerisk.pipeline.trace.summary import trace_summary
from tracerisk.pipeline.workspace.controller import Controller, lines_since, load_controller
from tracerisk.pipeline.workspace.project import Project
from tracerisk.trace import Trace


@dataclass(frozen=True, slots=True)
class Annotated:
    """A controller with its blocks, not yet written."""

    controller: Controller
    """The controller, as it was read for its blocks."""
    sources: Mapping[str, bytes]
    """What each file with risk blocks, the script among them, is to hold, by its name from root."""
    before: Mapping[str, bytes]
    """What each of these files holds until then."""
    change: Changed | None
    """What there is to write; `None` for nothing."""
    lock_path: Path
    """The lock that is written with them."""
    computed: ComputedBlocks
    """The blocks, as they follow from the trace and the hardware description."""
    trace: Trace
    """The run that they are of."""
    fingerprint: str
    """The digest of what that run depended on."""
    moved: tuple[MovedUse, ...] = ()
    """Values set by hand for what their function does no more, or not alone."""

    @property
    def source(self) -> bytes:
        """What the script is to hold."""
        return self.sources[self.controller.file]

    @property
    def is_changed(self) -> bool:
        """Whether writing would change the source or the lock."""
        return self.change is not None

    def write(self) -> None:
        """Write the lock and the source, so that a kill between them does no harm.

        What other runs wrote into the lock meanwhile stays.
        Raises InputError when a file cannot be written, or the source was changed meanwhile.
        """
        self._keep_trace()
        if self.change is None:
            return
        with one_writer(self.lock_path.parent):
            write_all(self._as_things_stand(self.change).writes(self.lock_path))

    def _keep_trace(self) -> None:
        """Keep the trace for a refresh; a folder that cannot be written costs that a run."""
        with contextlib.suppress(OSError, InputError):
            # With the lines that the source has from now on.
            kept = at_annotated_lines(self.trace, self)
            TraceCache(self.controller.root).write(self.fingerprint, kept)

    def _as_things_stand(self, change: Changed) -> Changed:
        """Put the change on top of what the lock and the source hold by now."""
        key = lock_key(self.controller.path, self.controller.root)
        lock = with_moved(Project(self.lock_path.parent).lock, self.controller)
        # A second run of the same controller may have written the very same.
        left = tuple(
            source
            for source in change.sources
            if file_bytes(self.lock_path.parent / source.file) != source.after
        )
        return Changed(
            left,
            lock.with_controller(key, change.lock.controllers[key]),
            lock.with_controller(key, change.pending.controllers[key]),
        )


def annotate(
    controller: Controller,
    trace: Trace,
    hardware: Hardware,
    settings: Settings,
    *,
    policy: MergePolicy | None = None,
    profile: ProfileText | None = None,
    given: Mapping[str, Any] | None = None,
) -> Annotated:
    """Put the blocks of a trace into the controller's source; nothing is written yet.

    `given` are those of the settings that came from the command line: a refresh uses them again.
    Raises EditInTheWayError when a user edited a computed value and the policy says to stop,
    HardwareError when the description does not fit, SettingsError when `states` or `helpers` name
    what is not a function, BlockError or UnsafeRewriteError when the source cannot be annotated, or
    holds a redundancy set by hand over units that differ.
    """
    if controller.is_python:
        require_simulator("writing risk blocks")
    else:
        trace = with_scopes(controller, trace)
    check_named_functions(controller, settings, trace)
    key = lock_key(controller.path, controller.root)
    # Another run of tracerisk writes lock and sources in turn; both are read between its writes.
    with one_writer(controller.root):
        now = load_controller(controller.path)
        lock = with_moved(now.project.lock, controller)
        files = _annotated_files(controller, trace, lock)
        # Only its blocks may have changed since it was loaded: the trace is of this program.
        trace = trace.with_lines(lines_since({controller.file: controller.source}, now))
        controller = now
        before = {file: controller.source_of(file) for file in files}
    inputs = run_inputs(controller, trace, settings, given=given)
    computed = compute_blocks(
        trace,
        hardware,
        active=settings.active,
        profile=profile,
        evidence=used_evidence(controller, settings, inputs.fingerprint),
    )
    _forbid_shared(key, files, lock, controller)
    policy = replace(policy or MergePolicy(), tolerance=settings.tolerance)
    entry = lock.controllers.get(key)
    behind = _behind(controller, trace, hardware, computed, inputs)
    is_same = is_same_run(entry, inputs.fingerprint, behind, policy)
    summary = trace_summary(
        _at_bare_lines(trace, before, controller),
        computed.instances,
        kept=entry.trace if entry is not None and not policy.fresh else None,
        noise=policy.tolerance if is_same else 0.0,
        tolerances=Tolerances.of(settings),
        worlds=_same_worlds(entry, inputs.fingerprint),
    )
    form = settings.blocks
    outcome: Annotation = annotate_sources(
        key,
        [_source_blocks(controller, file, before[file], trace, computed, form) for file in files],
        lock,
        fingerprint=inputs.fingerprint,
        trace=summary,
        inputs=inputs.data(),
        policy=policy,
        evidence=evidence_for(controller, entry, settings),
        behind=behind,
    )
    if isinstance(outcome, EditsInTheWay):
        raise outcome.error()
    change = outcome if isinstance(outcome, Changed) else None
    changed = () if change is None else change.sources
    return Annotated(
        controller,
        {**before, **{source.file: source.after for source in changed}},
        before,
        change,
        controller.root / LOCK_NAME,
        computed,
        trace,
        inputs.fingerprint,
        tuple(moved_uses(outcome.lock.controllers[key])),
    )


def _behind(
    controller: Controller,
    trace: Trace,
    hardware: Hardware,
    computed: ComputedBlocks,
    inputs: RunInputs,
) -> Behind:
    """Return what the computed values rest on, as digests."""
    functions: dict[str, set[QualifiedName]] = {}
    for ref in computed.blocks:
        functions.setdefault(ref.file, set()).add(ref.name)
    sources = {file: controller.source_of(file) for file in inputs.sources}
    run = [inputs.settings, inputs.files, inputs.libraries, inputs.evidence]
    run += [inputs.variables] if inputs.variables else []
    return Behind(
        short_digest(json.dumps([*run, trace.robot, trace.scene], sort_keys=True)),
        digests_behind(sources, functions),
        {
            component.name: short_digest(repr(replace(component, location=None)))
            for component in hardware.components
        },
    )


def _same_worlds(entry: ControllerLock | None, fingerprint: str) -> tuple[WorldRun, ...]:
    """Return the runs in other worlds that the lock keeps, if they had the same inputs."""
    if entry is None or entry.fingerprint != fingerprint:
        return ()
    return kept_worlds(entry.trace)


def _at_bare_lines(trace: Trace, sources: Mapping[str, bytes], controller: Controller) -> Trace:
    """Return the trace whose verdict has the lines that the sources have without their blocks.

    So what the lock keeps does not change when blocks come into a source.
    """
    if trace.verdict is None:
        return trace
    shown = {file: str(controller.path_of(file)) for file in sources}
    line_of = bare_lines(sources, shown)
    worlds = tuple(run.with_line(line_of) for run in trace.worlds)
    return replace(trace, verdict=trace.verdict.with_lines(line_of), worlds=worlds)


def _annotated_files(controller: Controller, trace: Trace, lock: Lock) -> tuple[str, ...]:
    """Return the files that hold, held or will hold blocks of the controller, its script first."""
    files = {function.ref.file for function in trace.functions}
    entry = lock.controllers.get(lock_key(controller.path, controller.root))
    for blocks in entry.all_blocks if entry is not None else ():
        files |= {file for file in blocks if blocks[file] and controller.path_of(file).is_file()}
    gone: list[bytes] = []
    if entry is not None:
        gone = _digests_gone(entry, [controller.source_of(file) for file in files])
    if gone:
        of_others = {
            file
            for key, other in lock.controllers.items()
            if key != controller.file
            for file, held in other.blocks.items()
            if held
        }
        for file in set(trace.files) - files - of_others:
            source = controller.source_of(file)
            # As of a function that moved there.
            if any(digest in source for digest in gone):
                files.add(file)
    return (controller.file, *sorted(files - {controller.file}))


def _digests_gone(entry: ControllerLock, sources: Sequence[bytes]) -> list[bytes]:
    """Return the digests of the blocks of a controller that stand in none of its sources."""
    digests = {digest.encode() for digest in block_digests(entry)}
    return sorted(digest for digest in digests if not any(digest in source for source in sources))


def _source_blocks(
    controller: Controller,
    file: str,
    source: bytes,
    trace: Trace,
    computed: ComputedBlocks,
    form: BlockForm,
) -> SourceBlocks:
    blocks = {
        ref.name: replace(block, form=form)
        for ref, block in computed.blocks.items()
        if ref.file == file
    }
    lines = {
        function.ref.name: function.line
        for function in trace.functions
        if function.line > 0 and function.ref.file == file
    }
    instances = {
        ref.name: {
            instance.component.name: instance.in_function(ref) for instance in computed.instances
        }
        for ref in computed.blocks
        if ref.file == file
    }
    shown = str(controller.path_of(file))
    return SourceBlocks(file, source, blocks, lines, shown, instances=instances)


def _forbid_shared(key: str, files: Sequence[str], lock: Lock, controller: Controller) -> None:
    """Raise InputError where another controller has its blocks in a file of this one."""
    for other, entry in sorted(lock.controllers.items()):
        if other == key or not (controller.root / other).is_file():
            continue
        for file in files:
            if shared := sorted(entry.blocks.get(file, ())):
                raise InputError(
                    f"holds the risk blocks of two controllers, {other} ({', '.join(shared)}) and "
                    f"{key}, whose figures differ; name its functions in `helpers` of "
                    "[tool.tracerisk], so that their callers get the blocks, or give each "
                    "controller a root of its own",
                    Location(str(controller.path_of(file))),
                )


@dataclass(frozen=True, slots=True)
class InForm:
    """A controller whose blocks are in one form, not yet written."""

    controller: Controller
    """The controller as it is."""
    sources: tuple[AnnotatedSource, ...]
    """The sources that change."""

    def write(self) -> None:
        """Write the sources; the lock says the same of either form.

        Raises InputError when a file cannot be written, or was changed meanwhile.
        """
        root = self.controller.root
        write_all(
            FileWrite(root / source.file, source.after, expected=source.before)
            for source in self.sources
        )
        entry = self.controller.project.lock.controllers.get(self.controller.file)
        cache = TraceCache(root)
        trace = None if entry is None else cache.read(entry.fingerprint, self.controller.file)
        if entry is not None and trace is not None:
            before = {source.file: source.before for source in self.sources}
            after = {source.file: source.after for source in self.sources}
            shown = {file: str(self.controller.path_of(file)) for file in before}
            with contextlib.suppress(OSError, InputError):
                cache.write(entry.fingerprint, trace.with_lines(line_maps(before, after, shown)))


def in_form(controller: Controller, form: BlockForm) -> InForm:
    """Return a controller with all its blocks in one form, in each of its files.

    Raises BlockError, SourceError or UnsafeRewriteError where a file cannot be read or rewritten.
    """
    entry = controller.project.lock.controllers.get(controller.file)
    others = set() if entry is None else {file for file, held in entry.blocks.items() if held}
    others = {file for file in others if controller.path_of(file).is_file()}
    changed = []
    for file in (controller.file, *sorted(others - {controller.file})):
        before = controller.source_of(file)
        after = blocks_in_form(before, str(controller.path_of(file)), form)
        if after != before:
            changed.append(AnnotatedSource(file, before, after))
    return InForm(controller, tuple(changed))


def at_annotated_lines(trace: Trace, annotated: Annotated) -> Trace:
    """Return the trace with the lines of the annotated source: those the file has once written.

    So a second run, of the annotated source, reports the same lines.
    """
    shown = {file: str(annotated.controller.path_of(file)) for file in annotated.before}
    return trace.with_lines(line_maps(annotated.before, annotated.sources, shown))
