"""The stages joined: run a controller, annotate it, build its model, solve it.

This is the public Python API; `tracerisk` re-exports it.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tracerisk.adder.annotate import Annotation, Changed, EditsInTheWay, SourceBlocks
from tracerisk.adder.blocks.block import RiskBlock
from tracerisk.adder.blocks.model_names import model_names
from tracerisk.adder.figures.computed import ComputedBlocks, ProfileText, compute_blocks
from tracerisk.adder.lock.lock import LOCK_NAME, ControllerLock, Lock, lock_key
from tracerisk.adder.merge.merge import MergePolicy
from tracerisk.adder.sources.line_map import line_maps
from tracerisk.adder.sources.published import read_c_blocks, read_plain_blocks
from tracerisk.adder.sources.read import read_blocks
from tracerisk.adder.sources.renames import base_with_names, follow_renames
from tracerisk.common.dependencies import require_simulator
from tracerisk.common.hardware.formats import load_hardware as load_hardware
from tracerisk.common.hardware.model import Hardware
from tracerisk.common.outcome.changes import Tolerances
from tracerisk.common.worlds.world_run import WorldRun, kept_worlds
from tracerisk.config import Settings
from tracerisk.errors import InputError, Location, TraceRiskError
from tracerisk.instrument.source.language import is_c_like
from tracerisk.pipeline.freshness.freshness import run_inputs
from tracerisk.pipeline.freshness.known_controllers import with_moved
from tracerisk.pipeline.freshness.known_functions import check_named_functions, check_steps
from tracerisk.pipeline.freshness.used_evidence import used_evidence
from tracerisk.pipeline.history.file_lock import one_writer
from tracerisk.pipeline.trace.summary import trace_summary
from tracerisk.pipeline.workspace.controller import Controller, lines_since, load_controller
from tracerisk.pipeline.workspace.project import Project
from tracerisk.trace import FunctionRef, QualifiedName, Trace

if TYPE_CHECKING:
    from tracerisk.pipeline.run.ended_run import Progress
    from tracerisk.prm.hybrid.assessment import Assessment
    from tracerisk.prm.hybrid.hybrid import HybridModel
    from tracerisk.twin.robots.robot import Robot


@dataclass(frozen=True, slots=True)
class Annotated:
    """A controller with its blocks, not yet written.

    `sources` are the files with risk blocks, the script among them, by their names below the
    root: what each is to hold; `before` what each holds. `change` is what there is to write,
    `None` for nothing.
    """

    controller: Controller
    sources: Mapping[str, bytes]
    before: Mapping[str, bytes]
    change: Changed | None
    lock_path: Path
    computed: ComputedBlocks
    trace: Trace
    fingerprint: str

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
        from tracerisk.adder.sources.write import write_all

        self._keep_trace()
        if self.change is None:
            return
        with one_writer(self.lock_path.parent):
            write_all(self._as_things_stand(self.change).writes(self.lock_path))

    def _keep_trace(self) -> None:
        """Keep the trace for a refresh; a folder that cannot be written costs that a run."""
        from tracerisk.pipeline.freshness.trace_cache import TraceCache

        with contextlib.suppress(OSError, InputError):
            # With the lines that the source has from now on.
            kept = at_annotated_lines(self.trace, self)
            TraceCache(self.controller.root).write(self.fingerprint, kept)

    def _as_things_stand(self, change: Changed) -> Changed:
        """Put the change on top of what the lock and the source hold by now."""
        key = lock_key(self.controller.path, self.controller.root)
        lock = Project(self.lock_path.parent).lock
        # A second run of the same controller may have written the very same.
        left = tuple(
            each
            for each in change.sources
            if (self.lock_path.parent / each.file).read_bytes() != each.after
        )
        return Changed(
            left,
            lock.with_controller(key, change.lock.controllers[key]),
            lock.with_controller(key, change.pending.controllers[key]),
        )


def load_settings(controller: Controller, options: Mapping[str, Any] | None = None) -> Settings:
    """Return the settings of a controller's root, overridden by the options that are given."""
    return controller.settings.with_options(options or {})


def load_robot(controller: Controller, settings: Settings) -> Robot:
    """Return the robot that the controller drives; `Robot.chosen_by` says why it is this one.

    It is that of the settings, else that of the controller's workspace, else the shipped one of
    which the controller's strings speak, with those of its launch file, else a generic arm.
    Raises RobotError when it is unknown, or several fit.
    """
    require_simulator("what reads a robot")
    from tracerisk.pipeline.launch.choose import NOTHING_CHOSEN, choose_launch
    from tracerisk.pipeline.robot.choice import choose_launched_robot
    from tracerisk.pipeline.robot.scenario_settings import with_scenario

    settings = with_scenario(settings)
    launch = choose_launch(controller, settings) if settings.robot is None else NOTHING_CHOSEN
    return choose_launched_robot(controller, settings, launch).robot


def check_blocks(controller: Controller) -> None:
    """Read what is there of blocks and lock, so that a fault in them is reported before a run.

    Raises BlockError, SourceError or InputError at what is malformed.
    """
    lock = with_moved(controller.project.lock, controller)
    entry = lock.controllers.get(lock_key(controller.path, controller.root))
    written = {} if entry is None else dict(entry.blocks)
    found = []
    for file in (controller.file, *sorted(set(written) - {controller.file})):
        if file == controller.file or controller.path_of(file).is_file():
            base = written.get(file, {})
            known = {QualifiedName(name) for name in base}
            shown = str(controller.path_of(file))
            followed = follow_renames(controller.source_of(file), shown, known)
            base = base_with_names(base, followed.renamed)
            found += [(placed.block, base) for placed in followed.placed]
    others = {name for base in written.values() for name in base}
    check_steps(controller, found, others, before_run=True)
    check_named_functions(controller, controller.settings)


def trace_controller(
    controller: Controller,
    settings: Settings,
    *,
    keep: Path | None = None,
    progress: Progress | None = None,
    live_speed: float | None = None,
) -> Trace:
    """Run the controller on the twin and return what the run showed.

    With `live_speed` it runs once on real rospy, at most so many times as fast as the wall clock.
    A run that ends badly gives a trace too, as far as it came: see `Trace.end`.
    `keep` is a folder in which the recording stays.
    What is assumed of its robot and its launch file is tried again where the run shows that it
    does not fit: see `Trace.assumptions`. What it asks its world for in vain is drafted where it
    would show no risk without, and the settings do not say otherwise: see `Trace.drafted`.
    Raises SourceError, RobotError, HardwareError before anything runs, DependencyError where the
    simulator is not installed.
    """
    if not controller.is_python:
        raise InputError(
            "is C or C++, which is not run on the twin; give the log or trace of its own run: "
            "`tracerisk annotate FILE --log LOG` or `--trace TRACE`",
            Location(str(controller.path)),
        )
    require_simulator("running a controller")
    from tracerisk.pipeline.run.ended_run import RunOptions

    options = RunOptions(
        keep, progress, live_speed=live_speed, meanwhile=lambda: _read_ahead(controller)
    )
    if live_speed is not None:
        from tracerisk.pipeline.run.live.live_trace import trace_live

        return trace_live(controller, settings, options)
    from tracerisk.pipeline.scenarios.drafted_run import trace_with_draft

    return trace_with_draft(controller, settings, options)


def _read_ahead(controller: Controller) -> None:
    """Read of the source what coverage and blocks need of it, for which the run need not end."""
    from tracerisk.adder.sources.positions import function_sites
    from tracerisk.instrument.source.call_graph import call_graph

    with contextlib.suppress(TraceRiskError):
        call_graph(controller.source, controller.file)
    function_sites(controller.source)


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
        from tracerisk.pipeline.trace.c_scopes import with_scopes

        trace = with_scopes(controller, trace)
    from tracerisk.adder.annotate import annotate_sources
    from tracerisk.pipeline.freshness.who_wrote import evidence_for

    check_named_functions(controller, settings, trace)
    lock_path = controller.root / LOCK_NAME
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
    policy = policy or MergePolicy()
    entry = lock.controllers.get(key)
    kept = entry.trace if entry is not None and not policy.fresh else None
    outcome: Annotation = annotate_sources(
        key,
        [_source_blocks(controller, file, before[file], trace, computed) for file in files],
        lock,
        fingerprint=inputs.fingerprint,
        trace=trace_summary(
            _at_bare_lines(trace, before, controller),
            computed.instances,
            kept=kept,
            tolerances=Tolerances.of(settings),
            worlds=_same_worlds(entry, inputs.fingerprint),
        ),
        inputs=inputs.data(),
        policy=policy,
        evidence=evidence_for(controller, entry, settings),
    )
    if isinstance(outcome, EditsInTheWay):
        raise outcome.error()
    change = outcome if isinstance(outcome, Changed) else None
    after = {each.file: each.after for each in change.sources} if change is not None else {}
    sources = {**before, **after}
    return Annotated(
        controller, sources, before, change, lock_path, computed, trace, inputs.fingerprint
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
    from tracerisk.pipeline.trace.kept_verdict import bare_lines

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
    return (controller.file, *sorted(files - {controller.file}))


def _source_blocks(
    controller: Controller, file: str, source: bytes, trace: Trace, computed: ComputedBlocks
) -> SourceBlocks:
    blocks = {ref.name: block for ref, block in computed.blocks.items() if ref.file == file}
    lines = {
        function.ref.name: function.line
        for function in trace.functions
        if function.line > 0 and function.ref.file == file
    }
    instances = {
        ref.name: {each.component.name: each.in_function(ref) for each in computed.instances}
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


def build(
    sources: Mapping[str, bytes],
    *,
    name: str,
    profile: Mapping[str, Mapping[str, Fraction]] | None = None,
) -> HybridModel:
    """Build the hybrid risk model from the blocks in the sources, and from nothing else.

    `sources` maps the names of files, for messages, to their bytes; by its ending a file is one of
    C, C++ or Java, else of Python.
    Raises BlockError or ModelError where the blocks are malformed or contradict each other.
    """
    from tracerisk.prm.hybrid.from_blocks import build_model

    blocks = [block for _, block in blocks_of(sources)]
    if not blocks:
        raise InputError(
            f"no risk block in {', '.join(sources)}; `tracerisk run` or `annotate` writes them"
        )
    return build_model(blocks, profile=profile, name=name)


def blocks_of(sources: Mapping[str, bytes]) -> list[tuple[FunctionRef, RiskBlock]]:
    """Return the blocks in the sources, each under the name that its function has in the model.

    Beside each stands its function: the file and the qualified name within it.
    Raises BlockError or SourceError where a block or a source is malformed.
    """
    found = [
        (FunctionRef(file, name), block)
        for file, source in sources.items()
        for name, block in _blocks_in(source, file)
    ]
    names = model_names([ref for ref, _ in found])
    return [(ref, replace(block, name=QualifiedName(names[ref]))) for ref, block in found]


def _blocks_in(source: bytes, file: str) -> Iterator[tuple[QualifiedName, RiskBlock]]:
    if is_c_like(file):
        yield from ((QualifiedName(block.name), block) for block in read_c_blocks(source, file))
        return
    yield from ((placed.function, placed.block) for placed in read_blocks(source, file))
    yield from ((QualifiedName(block.name), block) for block in read_plain_blocks(source, file))


def solve(model: HybridModel) -> Assessment:
    """Solve a model exactly.

    Raises ModelError when it has no solution.
    """
    from tracerisk.prm.hybrid.solve import solve as solve_model

    return solve_model(model)


def strip(controller: Controller) -> bytes:
    """Return the controller's source without its risk blocks, every other byte kept."""
    from tracerisk.adder.sources.insert import strip_blocks

    return strip_blocks(controller.source, str(controller.path))


def hand_set(controller: Controller) -> tuple[str, ...]:
    """Return what a user set in the blocks of a source, each with its place.

    Raises BlockError when a block cannot be read.
    """
    from tracerisk.adder.blocks.values import component_fields

    found = []
    for placed in read_blocks(controller.source, str(controller.path)):
        block = placed.block
        if block.added:
            found.append(f"{block.location}: the block of {block.name}")
        fields = [("callSequence", block.call_sequence), ("next", block.next)]
        for component in block.components:
            if component.added or component.omitted:
                found.append(f"{component.location}: {block.name}.{component.name}")
            fields += [
                (f"{component.name}.{kind.key}", value)
                for kind, value in component_fields(component)
            ]
        found += [
            f"{value.location}: {block.name}.{key}"
            for key, value in fields
            if value is not None and value.pinned
        ]
    return tuple(found)


def at_annotated_lines(trace: Trace, annotated: Annotated) -> Trace:
    """Return the trace with the lines of the annotated source: those the file has once written.

    So a second run, of the annotated source, reports the same lines.
    """
    shown = {file: str(annotated.controller.path_of(file)) for file in annotated.before}
    return trace.with_lines(line_maps(annotated.before, annotated.sources, shown))
