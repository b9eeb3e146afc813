"""The verbs and stages that compute one controller's risk, as functions that print nothing.

The package itself offers them, so that each imports what it needs when it is called: whoever
imports the package, as the command does before it knows its verb, waits for no stage.
"""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence
    from fractions import Fraction
    from pathlib import Path
    from typing import Any

    from tracerisk.adder.blocks.override import Override
    from tracerisk.adder.figures.computed import ProfileText
    from tracerisk.adder.merge.merge import MergePolicy
    from tracerisk.common.hardware.model import Hardware
    from tracerisk.config import SandboxMode, Settings
    from tracerisk.errors import TraceRiskError
    from tracerisk.pipeline.annotate import Annotated
    from tracerisk.pipeline.assessed import Assessed
    from tracerisk.pipeline.check.finding import Checked
    from tracerisk.pipeline.check.refresh import Refreshed
    from tracerisk.pipeline.run.ended_run import Progress
    from tracerisk.pipeline.workspace.controller import Controller
    from tracerisk.prm.hybrid.assessment import Assessment
    from tracerisk.prm.hybrid.hybrid import HybridModel
    from tracerisk.prm.review.risk_change import RiskDiff
    from tracerisk.trace import Trace


# The stages, one after the other


def load_controller(path: str | Path) -> Controller:
    """Read the controller at `path`, and make the project around it.

    Raises InputError when there is no such file, or its name is not that of a program.
    """
    from tracerisk.pipeline.workspace.controller import load_controller

    return load_controller(path)


def load_settings(controller: Controller, options: Mapping[str, Any] | None = None) -> Settings:
    """Return the settings of a controller, overridden by the options that are given.

    Raises SettingsError with file and line at an unknown key or a bad value.
    """
    return controller.settings_with(options)


def load_hardware(settings: Settings, robot: str) -> Hardware:
    """Return the hardware description of the settings, else the shipped one of the robot.

    Raises HardwareError where it is malformed, or there is none.
    """
    from tracerisk.common.hardware.formats import load_hardware

    return load_hardware(settings, robot)


def trace_controller(
    controller: Controller,
    settings: Settings,
    *,
    keep: Path | None = None,
    progress: Progress | None = None,
    live_speed: float | None = None,
) -> Trace:
    """Run a controller on the twin and return what the run showed.

    `keep` is a folder in which the recording stays. `progress` is called with each phase and the
    simulated time [s]. With `live_speed` it runs once on real rospy, at most so many times as fast
    as the wall clock. A run that ends badly gives a trace too, as far as it came: see `Trace.end`.
    Raises SourceError, RobotError, HardwareError before anything runs, DependencyError where the
    simulator is not installed.
    """
    from tracerisk.pipeline.scenarios.trace_controller import trace_controller

    return trace_controller(
        controller, settings, keep=keep, progress=progress, live_speed=live_speed
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
    """Put the blocks of a trace into the sources of its controller; nothing is written yet.

    `policy` says what becomes of values edited by hand, `profile` how often each function follows
    another, as text. `given` are those of the settings that came from the command line: a refresh
    uses them again. Raises as `tracerisk.pipeline.annotate.annotate`.
    """
    from tracerisk.pipeline.annotate import annotate

    return annotate(
        controller, trace, hardware, settings, policy=policy, profile=profile, given=given
    )


def build(
    sources: Mapping[str, bytes],
    *,
    name: str,
    profile: Mapping[str, Mapping[str, Fraction]] | None = None,
) -> HybridModel:
    """Build the hybrid risk model from the blocks in sources, and from nothing else.

    `sources` maps the names of files, for messages, to their bytes; by its ending a file is one of
    C, C++ or Java, else of Python.
    Raises BlockError or ModelError where the blocks are malformed or contradict each other.
    """
    from tracerisk.pipeline.model import build

    return build(sources, name=name, profile=profile)


def solve(model: HybridModel) -> Assessment:
    """Solve a model exactly. Raises ModelError when it has no solution."""
    from tracerisk.prm.hybrid.solve import solve

    return solve(model)


def strip(controller: Controller) -> bytes:
    """Return the source of a controller without its risk blocks, every other byte kept."""
    from tracerisk.adder.sources.insert import strip_blocks

    return strip_blocks(controller.source, str(controller.path))


def diff(
    before_sources: Mapping[str, bytes],
    after_sources: Mapping[str, bytes],
    *,
    name: str = "",
) -> RiskDiff:
    """Return the difference in risk between two versions of one controller's annotated sources.

    Both map the names of files to their bytes, as `build` takes them; a version without blocks
    has no risk to report.
    Raises BlockError, SourceError or ModelError where the blocks are malformed or make no model.
    """
    from tracerisk.pipeline.review.review import diff

    return diff(before_sources, after_sources, name=name)


# The verbs


def assess(
    path: str | Path,
    settings: Mapping[str, Any] | None = None,
    *,
    policy: MergePolicy | None = None,
    profile: Mapping[str, Mapping[str, str]] | None = None,
    keep: Path | None = None,
    progress: Progress | None = None,
    known: Assessed | None = None,
    live_speed: float | None = None,
    worlds: str = "",
) -> Assessed:
    """Run a controller on the twin, compute its blocks, build its risk model and solve it.

    `settings` go before those of `pyproject.toml`; `policy` says what becomes of values edited by
    hand, `profile` how often each function follows another, as text. `keep` is a folder for the
    recording. `progress` is called with each phase and the simulated time [s].
    `known` is what an earlier call gave: where nothing has changed that its run depended on, its
    trace is taken, and nothing is simulated. With `live_speed` the controller runs on real rospy,
    at most so many times as fast as the wall clock. `worlds` are names of worlds between commas,
    or `all`, in which it is run again: see `Trace.worlds`.
    Raises RunFailedError when the run came to a bad end, ControllerFailedError when it commanded
    no hardware, and TraceRiskError for input that a stage refuses. Writes nothing but `keep`.
    """
    from tracerisk.pipeline.assessed import Assessed
    from tracerisk.pipeline.freshness.known_functions import check_blocks
    from tracerisk.pipeline.scenarios.run_failed import RunFailedError
    from tracerisk.pipeline.scenarios.trace_controller import nothing_commanded

    controller = load_controller(path)
    loaded = load_settings(controller, settings)
    check_blocks(controller)
    trace = None if known is None else _trace_of(known, controller, loaded)
    if trace is None:
        trace = trace_controller(
            controller, loaded, keep=keep, progress=progress, live_speed=live_speed
        )
    if not trace.is_usable:
        raise RunFailedError(trace)
    if not trace.functions:
        raise nothing_commanded(trace, controller)
    if worlds:
        from tracerisk.pipeline.worlds.world_runs import with_worlds

        trace = with_worlds(trace, path, settings, worlds, progress)
    simulated_s = trace.end.simulated_s or 0.0
    if progress is not None:
        progress("annotating", simulated_s)
    hardware = load_hardware(loaded, trace.robot)
    annotated = annotate(
        controller,
        trace,
        hardware,
        loaded,
        policy=policy,
        profile=profile or {},
        given=settings or {},
    )
    if progress is not None:
        progress("solving", simulated_s)
    sources = {str(controller.path_of(file)): text for file, text in annotated.sources.items()}
    model = build(sources, name=controller.path.name)
    assessment = solve(model)
    return Assessed(controller, loaded, hardware, trace, annotated, sources, model, assessment)


def _trace_of(known: Assessed, controller: Controller, settings: Settings) -> Trace | None:
    """Return the trace of an earlier run where this one would give the same; else `None`."""
    from tracerisk.pipeline.freshness.freshness import run_inputs

    inputs = run_inputs(controller, known.trace, settings)
    return known.trace if inputs.fingerprint == known.annotated.fingerprint else None


def write_blocks(assessed: Assessed) -> Assessed:
    """Write the blocks into the sources, and the lock; return it with the lines of today."""
    from dataclasses import replace

    from tracerisk.pipeline.annotate import at_annotated_lines

    assessed.annotated.write()
    return replace(assessed, trace=at_annotated_lines(assessed.trace, assessed.annotated))


def check(
    paths: Iterable[str | Path] = (), *, min_coverage: float | None = None, base: str | None = None
) -> tuple[Sequence[Path], Sequence[Checked | TraceRiskError]]:
    """Return the controllers that depend on files, and for each whether its blocks can be trusted.

    Without files these are all of the lock in the current folder. `min_coverage` is the least
    fraction of the functions that can command hardware; `base` a git revision, whose lock says
    how many ran. Raises InputError when no controller is known.
    """
    from pathlib import Path

    from tracerisk.pipeline.check.check import check_controllers
    from tracerisk.pipeline.check.run import CoverageLimits
    from tracerisk.pipeline.freshness.known_controllers import named_or_all
    from tracerisk.pipeline.workspace.project import Projects

    projects = Projects()
    found = named_or_all(list(map(Path, paths)), projects)
    verdicts: Sequence[Any] = [None] * len(found)
    if base is not None:
        from tracerisk.pipeline.review.run_verdicts import base_verdicts

        verdicts = list(base_verdicts(list(found), base))
    limits = [CoverageLimits(min_coverage, verdict) for verdict in verdicts]
    return found, check_controllers(found, projects, limits)


def refresh(
    path: str | Path,
    *,
    policy: MergePolicy | None = None,
    sandbox: SandboxMode | None = None,
    progress: Progress | None = None,
) -> Refreshed:
    """Return the blocks of a controller as of now, simulated only if they are stale.

    Write them with `refreshed.annotated.write()`. Raises as `assess`.
    """
    from pathlib import Path

    from tracerisk.adder.merge.merge import MergePolicy
    from tracerisk.pipeline.check.refresh import refresh_controller
    from tracerisk.pipeline.workspace.project import Projects

    return refresh_controller(
        Path(path), Projects(), policy=policy or MergePolicy(), sandbox=sandbox, progress=progress
    )


def overrides(paths: Iterable[str | Path] = ()) -> Sequence[Override]:
    """Return the values set by hand in sources; without files, in all that locks know.

    Those are the locks in and below this folder. Raises InputError where there is none.
    """
    from pathlib import Path

    from tracerisk.pipeline.check.overrides import files_of_locks, overrides_in

    return overrides_in(list(map(Path, paths)) or files_of_locks(Path()))
