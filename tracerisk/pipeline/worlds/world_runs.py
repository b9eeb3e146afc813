"""Run a controller again in other worlds, from warm processes, and compare each run with it."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from tracerisk.common.outcome.tolerances import Tolerances
from tracerisk.common.sandbox.scratch import scratch
from tracerisk.common.worlds.world import World, world_named, worlds_named
from tracerisk.common.worlds.world_run import WorldRun
from tracerisk.errors import MachineError, TraceRiskError
from tracerisk.instrument.recording import Recording, read_recording
from tracerisk.pipeline.evidence.cell_runs import Nominal, longest_s, nominal_again, nominal_mission
from tracerisk.pipeline.evidence.workers import CellProgress, Workers
from tracerisk.pipeline.freshness.run_inputs import stated
from tracerisk.pipeline.robot.scenario_settings import with_scenario
from tracerisk.pipeline.run.controller_run import run_in_world
from tracerisk.pipeline.run.ended_run import Progress, RunOptions
from tracerisk.pipeline.scenarios.rounds import draft_scenario
from tracerisk.pipeline.trace.run_files import EVENTS, LOST_ON_THE_WAY
from tracerisk.pipeline.workspace.controller import load_controller
from tracerisk.pipeline.worlds.comparison import Lost, compared, is_endless
from tracerisk.trace import Trace

_MORE, _MORE_S = 1.1, 3.0
"""A loop without an end goes on for so many times as long as in the run itself, and more [s]."""


@dataclass(frozen=True, slots=True)
class WorldJob:
    """A world to run a controller in, with all that a process needs for it."""

    controller: str
    """The path of the controller."""
    options: tuple[tuple[str, Any], ...]
    """The settings that go before those of `pyproject.toml`, as (name, plain value)."""
    digest: str
    """The digest of the run itself, which the machine must reproduce."""
    folder: str
    """The folder on this machine with the run itself; empty where each process makes it."""
    world: str
    """The name of the world."""


def run_worlds(
    controller: Path,
    options: Mapping[str, Any] | None,
    worlds: Sequence[World],
    *,
    trace: Trace | None = None,
    workers: Workers | None = None,
    progress: CellProgress | None = None,
) -> tuple[WorldRun, ...]:
    """Run a controller in worlds, and return how each run differs, in the order of the worlds.

    `options` go before the settings of `pyproject.toml`. `trace` is that of the run itself: where
    it was given drafted values, the runs in worlds are given such, too. Worlds that cannot differ
    for want of a gripper are left out. Nothing is written.
    Raises ControllerFailedError where the run itself came to a bad end or commanded nothing.
    """
    given = stated(options)
    with _drafted(controller, given, trace) as drafted:
        return _run(controller, tuple(drafted.items()), worlds, workers or Workers(), progress)


@contextmanager
def _drafted(
    controller: Path, given: Mapping[str, Any], trace: Trace | None
) -> Iterator[dict[str, Any]]:
    """Yield the options of a run that gets a draft as a scenario, if the run itself got one."""
    if trace is None or not trace.drafted:
        yield dict(given)
        return
    loaded = load_controller(controller)
    settings = loaded.settings_with(dict(given))
    base = None if settings.scenario is None else Path(settings.scenario)
    with tempfile.TemporaryDirectory(prefix="tracerisk-worlds-") as folder:
        path = Path(folder, "drafted.scenario.yaml")
        path.write_text(draft_scenario(loaded, settings, base).text, encoding="utf-8")
        yield {**given, "scenario": str(path)}


def _run(
    controller: Path,
    given: tuple[tuple[str, Any], ...],
    worlds: Sequence[World],
    workers: Workers,
    progress: CellProgress | None,
) -> tuple[WorldRun, ...]:
    nominal = nominal_mission(str(controller), given, "run in other worlds")
    asked = [world for world in worlds if may_differ(world, nominal)]
    folder = str(nominal.folder) if workers.executor is None else ""
    jobs = [WorldJob(str(controller), given, nominal.digest, folder, world.name) for world in asked]
    world_runs = {}
    workers = replace(workers, folder=nominal.folder)
    for job, run in workers.run(run_world, jobs, progress):
        world_runs[job.world] = run
    return tuple(world_runs[world.name] for world in asked if world.name in world_runs)


def may_differ(world: World, nominal: Nominal) -> bool:
    """Return whether a world can differ from the run itself: one of grippers needs a gripper."""
    return world.gripper is None or bool(nominal.run.robot.grippers)


def run_world(job: WorldJob) -> WorldRun:
    """Run a controller in a world, and compare the run with the run itself.

    Raises InputError where the run itself is another one here.
    """
    nominal = nominal_again(job.controller, job.options, job.digest, job.folder)
    return in_world(nominal, world_named(job.world))


def in_world(nominal: Nominal, world: World) -> WorldRun:
    """Run a controller in a world, and compare the run with the run itself."""
    with scratch("world-") as folder:
        try:
            done = run_in_world(
                nominal.controller,
                nominal.run,
                with_scenario(nominal.settings),
                world.name,
                RunOptions(folder, quiet=True, beside=nominal.recording),
                duration_s=_longest_s(nominal),
            )
        except MachineError:
            raise
        except TraceRiskError as error:
            return WorldRun(world.name, "", error.message)
        events = folder / EVENTS
        recording = read_recording(events) if events.exists() else Recording()
        tolerances = Tolerances.of(nominal.settings)
        return compared(world, nominal.trace, done.trace, tolerances, _lost(recording))


def _longest_s(nominal: Nominal) -> float:
    """Return how long a run in a world may take [s]; a loop without an end as long as the run."""
    if not is_endless(nominal.trace):
        return longest_s(nominal)
    simulated_s = nominal.trace.end.simulated_s or nominal.run.request.duration_s
    return min(nominal.run.request.duration_s, _MORE * simulated_s + _MORE_S)


def _lost(recording: Recording) -> tuple[Lost, ...]:
    note = recording.note(LOST_ON_THE_WAY)
    if not isinstance(note, dict):
        return ()
    lost = []
    for entry in note.get("lost", ()):
        match entry:
            case [str(words), str(file), int(line)] | (str(words), str(file), int(line)):
                lost.append((words, file, line))
    return tuple(lost)


def with_worlds(
    trace: Trace,
    path: str | Path,
    settings: Mapping[str, Any] | None,
    names: str,
    progress: Progress | None,
) -> Trace:
    """Return the trace with the runs of its controller in other worlds.

    `names` are those of the worlds between commas, or `all`.
    """

    def notify(done: int, of: int, left_s: float) -> None:
        if progress is not None:
            progress(f"world {done} of {of}, {left_s:.0f} s left", trace.end.simulated_s or 0.0)

    asked = worlds_named(names)
    notify(0, len(asked), 0.0)
    runs = run_worlds(Path(path), settings, asked, trace=trace, progress=notify)
    return replace(trace, worlds=runs)
