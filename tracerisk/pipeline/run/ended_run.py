"""What a run showed: the recording that its process left, read and judged."""

from __future__ import annotations

import errno
import os
import re
import resource
import shutil
import signal
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tracerisk import errors
from tracerisk.common import dependencies
from tracerisk.common.worlds.world import NOMINAL
from tracerisk.config import Settings
from tracerisk.errors import Location, TraceRiskError
from tracerisk.instrument.recording import Recording
from tracerisk.pipeline.run.left_recording import left_recording
from tracerisk.pipeline.trace.recorded_run import Ran
from tracerisk.pipeline.trace.run_files import (
    DRAFTS,
    IDLE_S,
    JOINTS_ASKED,
    MISSION_END,
    NEEDS,
    SCENARIO,
    STARTED,
    DraftsNoted,
    RunRequest,
)
from tracerisk.pipeline.trace.run_trace import make_trace
from tracerisk.pipeline.workspace.controller import lines_since
from tracerisk.ros.controller.needs import Need
from tracerisk.ros.drafts.draft import Draft, drafts_of
from tracerisk.ros.drafts.named_numbers import Reach
from tracerisk.ros.drafts.shifted_poses import PlaceAndShift
from tracerisk.trace import RunEnd, Trace

if TYPE_CHECKING:
    from tracerisk.pipeline.workspace.controller import Controller
    from tracerisk.twin.robots.robot import Robot


Progress = Callable[[str, float], None]
"""Called with the phase and the simulated time [s]."""

_LEAST_FREE = 4 * 1024**2
"""A disk with less is full for a recording, which is written in larger pieces [bytes]."""


@dataclass(frozen=True, slots=True)
class ProcessEnd:
    """How the process of a run ended."""

    code: int
    """The return code; negative for a signal."""
    limit: str | None = None
    """The limit that was reached, in words; `None` for none."""
    location: Location | None = None
    """The innermost place of the controller at the limit; `None` where not known."""
    has_begun: bool = False
    """Whether the controller's first line was reached."""
    last_line: str = ""
    """The last line that it printed; empty for none."""
    own_s: float = 0.0
    """The time that it computed or slept from the controller's first line on [s]; 0 where not
    measured."""
    start_s: float = 0.0
    """The processor time before the controller's first line [s]."""


@dataclass(frozen=True, slots=True)
class ControllerRun:
    """What one run showed."""

    trace: Trace
    """The trace of the run."""
    robot: Robot
    """The robot that it ran with."""
    request: RunRequest
    """What its process was asked; with `robot` enough to run it once more."""
    joints_asked: tuple[str, ...] = ()
    """The joints that it moved and the robot lacks."""
    needs: tuple[Need, ...] = ()
    """What the controller lacked, where that may be why it ended."""
    drafts: tuple[Draft, ...] = ()
    """What a scenario could provide for each need, where that was asked for."""
    own_s: float = 0.0
    """The time that its process computed or slept from the controller's first line on [s]."""
    shift: PlaceAndShift | None = None
    """A place that was not reached, and by how much to move it; `None` for none."""
    start_s: float = 0.0
    """The processor time of its process before the controller's first line [s]."""
    reach: Reach | None = None
    """What the arm reaches, for arguments of the command line; `None` where not needed."""


@dataclass(frozen=True, slots=True)
class RunOptions:
    """What is asked of a run beside its settings."""

    keep: Path | None = None
    """The folder for its recording; `None` to drop it."""
    progress: Progress | None = None
    """Called with the phase and the simulated time [s]; `None` for no progress."""
    drafts: DraftsNoted = "never"
    """When the run notes what a scenario could provide for its needs."""
    live_speed: float | None = None
    """The greatest speed of a run on real ROS, as a factor of the wall clock; `None` for a run
    on the stand-ins."""
    on_run: Callable[[ControllerRun], None] | None = None
    """Called with each run that is tried."""
    quiet: bool = False
    """Whether the controller's output is dropped."""
    beside: Recording | None = None
    """The recording of the run that the trace is judged beside, as in `make_trace`; `None` for
    none."""
    meanwhile: Callable[[], None] | None = None
    """Called once the process of the run computes."""
    idle_s: float = IDLE_S
    """The simulated time without a command after which a loop is idle [s]."""
    is_replayed: bool = False
    """Whether its trace holds what a replay of the run shows."""


PLAIN = RunOptions()


def ended_run(
    controller: Controller,
    robot: Robot,
    settings: Settings,
    request: RunRequest,
    process_end: ProcessEnd,
    options: RunOptions = PLAIN,
) -> ControllerRun:
    """Return what a run showed whose process has ended, by what it left in its folder.

    Raises LogError or LimitError at what is no recording, the error with which it refused, and
    MachineError where it ended badly and the disk is full: nobody knows whose doing that was; also
    where a file of it would have grown past the limit of this process.
    """
    folder = Path(request.folder)
    if _is_at_limit(folder, process_end.last_line):
        raise errors.file_limited()
    try:
        done = _read(controller, robot, settings, request, process_end, options)
    except (TraceRiskError, RuntimeError) as error:
        if _is_full(folder):
            raise errors.disk_full(str(folder.parent)) from error
        raise
    if not done.trace.end.is_good and _is_full(folder):
        raise errors.disk_full(str(folder.parent))
    return done


def _is_at_limit(folder: Path, last_line: str) -> bool:
    limit, _ = resource.getrlimit(resource.RLIMIT_FSIZE)
    if limit == resource.RLIM_INFINITY or not folder.is_dir():
        return False
    sizes = [entry.stat(follow_symlinks=False).st_size for entry in os.scandir(folder)]
    # A file that is made larger as a whole is not made at all.
    return max(sizes, default=0) >= limit or os.strerror(errno.EFBIG) in last_line


def _is_full(folder: Path) -> bool:
    return folder.is_dir() and shutil.disk_usage(folder).free < _LEAST_FREE


def _read(
    controller: Controller,
    robot: Robot,
    settings: Settings,
    request: RunRequest,
    process_end: ProcessEnd,
    options: RunOptions,
) -> ControllerRun:
    folder = Path(request.folder)
    recording = left_recording(folder, request)
    _raise_failure(recording)
    _raise_unstarted(recording, process_end, settings, Path(request.root))
    ran = controller.as_ran(recording.sources)
    end = _run_end(recording, process_end, ran)
    if options.progress is not None:
        options.progress("attributing", end.simulated_s or 0.0)
    is_cell = options.beside is not None and request.world == NOMINAL.name
    has_faults = bool(request.faults) or is_cell
    left = Ran(ran, robot, request.scene, settings, recording, folder, end, has_faults)
    trace = make_trace(left, beside=options.beside, is_replayed=options.is_replayed)
    trace = trace.with_lines(lines_since(recording.sources, controller))
    asked = [
        name for note in recording.notes if note.kind == JOINTS_ASKED for name in note.data["names"]
    ]
    unmet = recording.note(NEEDS) or {"needs": ()}
    needs = tuple(Need(kind, name, type_name) for kind, name, type_name in unmet["needs"])
    noted = recording.note(DRAFTS) or {"drafts": (), "shift": None}
    drafted, shift = tuple(drafts_of(noted["drafts"])), noted["shift"]
    joints = tuple(dict.fromkeys(asked))
    return ControllerRun(
        trace,
        robot,
        request,
        joints,
        needs,
        drafted,
        process_end.own_s,
        shift,
        process_end.start_s,
        None
        if noted.get("reach") is None
        else Reach(**{name: tuple(item) for name, item in noted["reach"].items()}),
    )


def _replaced_file(process: ProcessEnd, root: Path) -> Path | None:
    """Return the file that came while a run started, which then did not begin; else `None`.

    The sandbox lets a process read what was there when it began.
    """
    found = re.fullmatch(r"PermissionError: \[Errno 13\] [^']*'([^']+)'", process.last_line)
    path = None if found is None else Path(found[1])
    is_ours = path is not None and path.is_relative_to(root.resolve()) and os.access(path, os.R_OK)
    return path if is_ours else None


def _raise_failure(recording: Recording) -> None:
    """Raise the error with which the child refused to run anything."""
    failed = recording.note("failed")
    if failed is None or recording.note(STARTED) is not None:
        return
    if not isinstance(failed, dict):
        failed = {}
    # The recording is the controller's to write as well: it names an error, and makes none.
    kind = getattr(errors, str(failed.get("error")), None)
    if not isinstance(kind, type) or not issubclass(kind, TraceRiskError):
        kind = errors.InputError
    message = str(failed.get("message", "the controller's process refused to run"))
    match failed.get("location"):
        case [str(file), int() | None as line, int() | None as column]:
            raise kind(message, Location(file, line, column))
    raise kind(message)


def _raise_unstarted(
    recording: Recording, process: ProcessEnd, settings: Settings, root: Path
) -> None:
    """Raise what kept the process from reaching the controller's first line."""
    if recording.note(STARTED) is not None or process.limit is not None:
        return
    if process.has_begun:
        raise errors.LogError(
            "the recording of the run is gone: the controller's process has removed it"
        )
    if settings.memory_limit_mb < Settings().memory_limit_mb:
        raise errors.InputError(
            f"{settings.memory_limit_mb} MB are too little to start the simulation; give it more "
            f"with --memory-limit (default: {Settings().memory_limit_mb})"
        )
    if process.code == -signal.SIGKILL:
        raise errors.MachineError(
            "the process of the run was ended by SIGKILL before it began: the system may be short "
            "of memory; free some"
        )
    if file := _replaced_file(process, root):
        raise errors.InputError(
            "was put there while the run started; run the same command again",
            Location(os.path.relpath(file)),
        )
    dependencies.check(dependencies.SIMULATION)
    said = f": {process.last_line}" if process.last_line else ""
    raise RuntimeError(
        f"the process of the run ended with code {process.code} before it began{said}"
    )


def _run_end(recording: Recording, process: ProcessEnd, controller: Controller) -> RunEnd:
    # What comes after a limit, while the process is being ended, is no end of its own.
    recorded = recording.end if process.limit is None else None
    mission_end = recording.note(MISSION_END)
    simulated_s = (recorded.time_ns if recorded else recording.last_ns) / 1e9
    if mission_end is not None:
        simulated_s = mission_end["ns"] / 1e9
    if recorded is not None:
        end = RunEnd(recorded.cause, recorded.message, simulated_s, recorded.location)
    elif process.limit is not None:
        end = RunEnd("wall_limit", process.limit, simulated_s, process.location)
    elif process.code < 0:
        name = errors.signal_name(-process.code)
        end = RunEnd("died", f"the controller's process was ended by {name}", simulated_s)
    else:
        end = RunEnd(
            "died",
            f"the controller's process ended with code {process.code} and gave no reason",
            simulated_s,
        )
    if end.location is None and not end.is_good:
        end = RunEnd(end.cause, end.message, simulated_s, _last_place(recording, controller))
    if end.cause == "duration" and not recording.commands:
        end = replace(end, cause="no_motion", message=f"nothing was commanded, and {end.message}")
    scenario = recording.note(SCENARIO)
    return end if scenario is None else replace(end, scenario=scenario["lines"])


def _last_place(recording: Recording, controller: Controller) -> Location:
    """Return where the last command was issued: the nearest thing to where a dead child stood."""
    frames: Sequence[Any] = recording.commands[-1].stack if recording.commands else ()
    if not frames:
        return Location(controller.file, 1)
    return Location(frames[-1].function.file, frames[-1].site[0])
