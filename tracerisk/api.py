"""The public Python API: the work of the verbs as functions, without printing.

Each takes paths and settings, and returns frozen data; nothing is written unless the function is
named so. `docs/python.md` shows them at work. All that a function needs is imported when it is
called: whoever imports the package, as the command does before it knows its verb, waits for none.
"""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence
    from fractions import Fraction
    from pathlib import Path
    from typing import Any

    from tracerisk.adder.blocks.override import Override
    from tracerisk.adder.figures.following import ProfileText
    from tracerisk.adder.merge.edits_found import MergePolicy
    from tracerisk.common.campaign import CampaignOptions
    from tracerisk.common.evidence.cells import Evidence
    from tracerisk.common.hardware.model import Hardware
    from tracerisk.config import SandboxMode, Settings
    from tracerisk.errors import TraceRiskError
    from tracerisk.pipeline.annotate import Annotated
    from tracerisk.pipeline.assessed import Assessed
    from tracerisk.pipeline.check.finding import Checked
    from tracerisk.pipeline.check.refresh import Refreshed
    from tracerisk.pipeline.evidence.sweep import SweepPoint
    from tracerisk.pipeline.run.ended_run import Progress
    from tracerisk.pipeline.run.fault_run import FaultRun
    from tracerisk.pipeline.workspace.controller import Controller
    from tracerisk.prm.hybrid.assessment import Assessment
    from tracerisk.prm.hybrid.hybrid import HybridModel
    from tracerisk.prm.review.risk_diff import RiskDiff
    from tracerisk.report.mutants import MutantRuns
    from tracerisk.trace import Trace
    from tracerisk.twin.robots.robot import Robot


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


def load_robot(controller: Controller, settings: Settings) -> Robot:
    """Return the robot that a controller drives; `Robot.chosen_by` says why it is this one.

    Raises RobotError when it is unknown, or several fit.
    """
    from tracerisk.pipeline.robot.choice import driven_robot

    return driven_robot(controller, settings)


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
    simulated time [s]. With `live_speed` it runs once on real ROS, at most so many times as fast
    as the wall clock. A run that ends badly gives a trace too, as far as it came: see `Trace.end`.
    Raises SourceError, RobotError, HardwareError before anything runs, and as `require_runs`.
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
    trace is taken, and nothing is simulated. With `live_speed` the controller runs on real ROS,
    at most so many times as fast as the wall clock. `worlds` are names of worlds between commas,
    or `all`, in which it is run again: see `Trace.worlds`.
    Raises RunFailedError when the run came to a bad end, ControllerFailedError when it commanded
    no hardware, and TraceRiskError for input that a stage refuses. Writes nothing but `keep`.
    """
    from tracerisk.pipeline.assessed import Assessed
    from tracerisk.pipeline.freshness.known_functions import check_blocks
    from tracerisk.pipeline.scenarios.trace_controller import nothing_commanded
    from tracerisk.trace import RunFailedError

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
    from tracerisk.pipeline.freshness.run_inputs import run_inputs

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
    result = named_or_all(list(map(Path, paths)), projects)
    verdicts: Sequence[Any] = [None] * len(result)
    if base is not None:
        from tracerisk.pipeline.review.run_verdicts import base_verdicts

        verdicts = list(base_verdicts(list(result), base))
    limits = [CoverageLimits(min_coverage, verdict) for verdict in verdicts]
    return result, check_controllers(result, projects, limits)


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

    from tracerisk.adder.merge.edits_found import MergePolicy
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


# Campaigns of runs


def gather_evidence(
    path: str | Path,
    settings: Mapping[str, Any] | None = None,
    options: CampaignOptions | None = None,
    *,
    cells: int | None = None,
    until: float | None = None,
) -> Evidence:
    """Fail each unit of the robot at drawn instants, and write what became of the mission.

    `cells` is how many are drawn; `until` goes on until the 90 % interval of the mission's factor
    is no wider. The file is `tracerisk.evidence` in the controller's root; what it holds already
    is not tried again, unless the options say otherwise.
    Raises ControllerFailedError where the run without a failure came to a bad end.
    """
    from pathlib import Path

    from tracerisk.common.campaign import DEFAULT_CAMPAIGN
    from tracerisk.pipeline.evidence.campaign import gather

    _require_repeated_runs(path, "trying failures")
    return gather(Path(path), settings, options or DEFAULT_CAMPAIGN, cells=cells, until=until)


def _require_repeated_runs(path: Path | str, purpose: str) -> None:
    """Raise as `require_runs`, and InputError for C or C++, no run of which can be repeated."""
    from tracerisk.common.dependencies import require_runs
    from tracerisk.pipeline.workspace.controller import forbid_compiled

    require_runs(purpose)
    forbid_compiled(path, purpose)


def sweep(
    path: str | Path,
    over: Sequence[str] | Mapping[str, Sequence[Any]],
    settings: Mapping[str, Any] | None = None,
    options: CampaignOptions | None = None,
) -> tuple[SweepPoint, ...]:
    """Run a controller at every combination of values, and return the figure of each.

    `over` names what to vary with its values: a setting, `param:/NAME` or `scenario:PATH`, as a
    mapping or as texts NAME=VALUE,VALUE. Nothing but the cache is written.
    Raises InputError for what cannot be varied.
    """
    from collections.abc import Mapping
    from pathlib import Path

    from tracerisk.common.campaign import DEFAULT_CAMPAIGN
    from tracerisk.pipeline.evidence.sweep import Factor, parse_factor, sweep

    _require_repeated_runs(path, "sweeping over runs")
    if isinstance(over, Mapping):
        factors = [Factor(name, tuple(values)) for name, values in over.items()]
    else:
        factors = [parse_factor(text) for text in over]
    return sweep(Path(path), factors, settings, options or DEFAULT_CAMPAIGN)


def mutate(
    path: str | Path,
    settings: Mapping[str, Any] | None = None,
    options: CampaignOptions | None = None,
    *,
    most: int | None = None,
) -> MutantRuns:
    """Change a controller at one place at a time, run each, and return what is noticed.

    At most `most` changes are tried, 60 by default, drawn by the seed of the settings. Nothing but
    the cache is written: files are changed in memory. Raises ControllerFailedError where the run
    without a change came to a bad end, and InputError where there is nothing to change.
    """
    from pathlib import Path

    from tracerisk.common.campaign import DEFAULT_CAMPAIGN
    from tracerisk.pipeline.mutation.campaign import MOST, mutate

    _require_repeated_runs(path, "running changes of a controller")
    most = MOST if most is None else most
    return mutate(Path(path), settings, options or DEFAULT_CAMPAIGN, most=most)


def evidence(path: str | Path) -> Evidence:
    """Return the evidence that is kept of a controller, whether it is stale or not.

    Raises InputError where there is none.
    """
    from tracerisk.pipeline.freshness.used_evidence import needed_evidence

    return needed_evidence(load_controller(path))


def evidence_replays(
    path: str | Path,
    found: Evidence,
    folder: str | Path,
    settings: Mapping[str, Any] | None = None,
    *,
    progress: Callable[[int, int, float], None] | None = None,
) -> int:
    """Write a page with the replay of each failure that matters; return how many.

    They are the worst of each component, mode and function that ended the mission; `index.html`
    leads to them. `progress` as in `gather_evidence`. Raises as that, and InputError where the
    folder is a file.
    """
    from pathlib import Path

    from tracerisk.pipeline.pictures.evidence_replays import write_replays

    _require_repeated_runs(path, "replaying failures")
    return write_replays(Path(path), found, Path(folder), settings, progress=progress)


def run_with_faults(
    path: str | Path,
    faults: Sequence[str],
    settings: Mapping[str, Any] | None = None,
    *,
    keep: Path | None = None,
    progress: Progress | None = None,
    on_nominal: Callable[[Trace], None] | None = None,
) -> FaultRun:
    """Run a controller on the twin, and once more with `faults`, each as UNIT:MODE@SECONDS.

    `keep` is a folder for the recording of the run with the faults. `on_nominal` takes the
    trace of the run without, as soon as it is over. Writes nothing but `keep`: no blocks, no
    lock, no trace.
    Raises InputError for a fault that is none or that the robot cannot have, RunFailedError when
    the run without a fault came to a bad end, and ControllerFailedError when it commanded nothing.
    """
    from tracerisk.common.dependencies import require_runs
    from tracerisk.twin.faults.fault import parse_fault

    for fault in faults:
        # What is wrong with one is said before what is missing here.
        parse_fault(fault)
    require_runs("running a controller")
    from tracerisk.pipeline.scenarios.fault_effect import run_with_faults

    return run_with_faults(
        path, faults, settings, keep=keep, progress=progress, on_nominal=on_nominal
    )
