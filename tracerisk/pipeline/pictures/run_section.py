"""The section of a report that shows a run: its timeline, and its replay where it was recorded."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from tracerisk.common.dependencies import install_command, is_installed
from tracerisk.common.hardware.binding import elements_by_component
from tracerisk.common.text.bounded import MOST_WRITTEN, file_bytes, file_text
from tracerisk.errors import Location, LogError, readable
from tracerisk.pipeline.freshness.trace_cache import MOST_REPLAY_BYTES, TraceCache
from tracerisk.pipeline.scenarios.trace_controller import trace_controller
from tracerisk.pipeline.trace.run_files import ROBOT, RunRequest
from tracerisk.report.html.run.replay import RecordedRun
from tracerisk.ros.scenario.objects import simulated_scene
from tracerisk.twin.robots.file import read_dumped_robot

if TYPE_CHECKING:
    from tracerisk.common.hardware.model import Hardware
    from tracerisk.config import Settings
    from tracerisk.pipeline.check.cached_run import KeptRun
    from tracerisk.pipeline.run.ended_run import Progress
    from tracerisk.pipeline.workspace.controller import Controller
    from tracerisk.report.html.section import Section
    from tracerisk.trace import Trace
    from tracerisk.twin.faults.fault import Fault


def run_section(
    trace: Trace,
    hardware: Hardware,
    run: RecordedRun | str = "",
    faults: Sequence[Fault] = (),
) -> Section | None:
    """Return the section of a run; `None` for one of which no visit has a time.

    `run` is what was recorded of it, or why there is no replay. `faults` are marked on it.
    Raises HardwareError where the hardware description does not fit the trace.
    """
    from tracerisk.report.html.run.timeline import timeline_section

    if not trace.end.simulated_s or all(visit.duration_s is None for visit in trace.visits):
        return None
    components = elements_by_component(hardware, trace.elements)
    if isinstance(run, str):
        return timeline_section(trace, components, no_replay=run, faults=faults)
    from tracerisk.report.html.run.recorded_replay import make_replay  # needs NumPy

    replay = make_replay(run, trace.end.simulated_s)
    return timeline_section(trace, components, replay=replay, faults=faults)


def replay_of(trace: Trace) -> RecordedRun | None:
    """Return what can be seen of a run that has just ended; `None` where nothing was simulated."""
    if trace.replay is None:
        return None
    return _unpacked(trace.replay, trace.controller)


def kept_replay(kept: KeptRun) -> RecordedRun | str:
    """Return what can be seen of the run whose trace is kept, or why that is not kept."""
    path = TraceCache(kept.controller.root).replay_path(kept.fingerprint, kept.controller.file)
    if not path.is_file():
        return "The replay of its last run is not kept on this machine."
    if not is_installed("numpy"):
        return f"The replay of its last run needs NumPy: `{install_command('large')}` brings it."
    try:
        return packed_recording(path)
    except LogError as error:
        return f"The replay of its last run cannot be read: {error}."


def given_recording(path: Path) -> RecordedRun:
    """Return what can be seen of a run: a folder of `run --keep`, or a file of the cache.

    Raises LogError where it holds none.
    """
    if path.is_file():
        return packed_recording(path)
    with readable(path, LogError):
        run = recorded_run(path)
    if run is None:
        raise LogError(
            "holds no recording of a run; `tracerisk run --keep DIR` leaves one",
            Location(str(path)),
        )
    return run


def packed_recording(path: Path) -> RecordedRun:
    """Return what a file of the cache holds of a run.

    Raises LogError for another file, and one that cannot be read.
    """
    with readable(path, LogError):
        size = path.stat().st_size
        data = file_bytes(path, MOST_REPLAY_BYTES) if size <= MOST_REPLAY_BYTES else b""
    if not data:
        raise LogError(
            f"has {size} bytes; a replay has some, and at most {MOST_REPLAY_BYTES}",
            Location(str(path)),
        )
    return _unpacked(data, str(path))


def _unpacked(data: bytes, name: str) -> RecordedRun:
    from tracerisk.twin.recording.packed_run import unpacked_run  # needs NumPy

    return RecordedRun(*unpacked_run(data, name))


def recorded_run(recording: Path) -> RecordedRun | None:
    """Return what was simulated, from the folder that keeps it; `None` where nothing was.

    What is returned needs the folder no longer.
    Raises LogError where the recording is damaged.
    """
    from tracerisk.twin.physics.declared_log import read_declared
    from tracerisk.twin.recording.samples import has_samples, read_samples

    if not has_samples(recording):
        return None
    request = RunRequest.loads(file_text(recording / "request.json", most=MOST_WRITTEN))
    robot = read_dumped_robot(recording / ROBOT)
    scene = simulated_scene(request.scene, request.scenario)
    return RecordedRun(read_samples(recording), robot, scene, read_declared(recording))


def run_again(
    controller: Controller, settings: Settings, progress: Progress | None = None
) -> tuple[Trace, RecordedRun | None]:
    """Run a controller and return its trace and what was recorded; no file is written.

    The same sources and settings make the same run. The recording is `None` where nothing was
    simulated. Raises as `trace_controller`.
    """
    trace = trace_controller(controller, settings, progress=progress)
    return trace, replay_of(trace)
