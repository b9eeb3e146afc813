"""Run a controller in a child process under limits, and make a trace of what it left."""

from __future__ import annotations

import contextlib
import os
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from tracerisk import dependencies, errors
from tracerisk.config import Settings
from tracerisk.errors import Location, TraceRiskError
from tracerisk.instrument.recording import Recording, read_recording
from tracerisk.limited_process import POLL_S, Limit, OwnTime, StartMark
from tracerisk.pipeline.left_running import RUN_MARK, end_left_running
from tracerisk.pipeline.run_files import (
    EVENTS,
    JOINTS_ASKED,
    NEEDS,
    ROBOT,
    SCENARIO,
    STACKS,
    STARTED,
    Companion,
    RunRequest,
    WallTime,
)
from tracerisk.pipeline.run_trace import make_trace
from tracerisk.pipeline.run_watch import MISSION_END
from tracerisk.ros.needs import Need
from tracerisk.trace import RunEnd, Trace

if TYPE_CHECKING:
    from tracerisk.pipeline.controller import Controller
    from tracerisk.pipeline.launch.choose import LaunchChoice
    from tracerisk.pipeline.stages import Progress
    from tracerisk.twin.robot import Robot

_STARTING = "starting the twin"
_GRACE_S = 2.0
_STACK_LINE = re.compile(r'  File "(?P<file>.*)", line (?P<line>\d+) in ')


@dataclass(frozen=True, slots=True)
class ControllerRun:
    """What one run showed: its trace, joints that it moved and the robot lacks, unmet `needs`."""

    trace: Trace
    joints_asked: tuple[str, ...] = ()
    needs: tuple[Need, ...] = ()


def run_controller(
    controller: Controller,
    robot: Robot,
    settings: Settings,
    choice: LaunchChoice,
    *,
    companions: tuple[Companion, ...] = (),
    keep: Path | None = None,
    progress: Progress | None = None,
) -> ControllerRun:
    """Run the controller on the twin of `robot`, and return what the run showed.

    `choice` is what a launch file gives it, `companions` are started beside it.
    Where `progress` is told, what they print goes through `sys.stderr`, of which that may have
    taken hold, and else to the standard error of this process.
    Raises SourceError, RobotError or another error of the input when nothing could run.
    """
    from tracerisk.twin.robot_file import dump_robot

    scene = settings.scene or robot.default_scene
    if scene is None:
        raise errors.RobotError(f"robot '{robot.name}' has no scene of its own; give --scene")
    launch = choice.setup
    with _folder(keep) as folder:
        request = RunRequest(
            controller=str(controller.path.resolve()),
            root=str(controller.root.resolve()),
            folder=str(folder),
            argv=settings.args if launch is None else launch.argv(settings.args),
            answers=settings.answers,
            scene=scene,
            scenario=settings.scenario,
            params=settings.params,
            launch=launch,
            launch_notes=choice.notes,
            companions=companions,
            duration_s=settings.run_duration_s,
            memory_limit_mb=settings.memory_limit_mb,
            seed=settings.seed,
            parent=os.getpid(),
        )
        (folder / ROBOT).write_text(dump_robot(robot), encoding="utf-8")
        if progress is not None:
            progress(_STARTING, 0.0)
        process_end = _run_child(request, folder, settings, progress)
        recording = _recording(folder)
        _raise_failure(recording)
        _raise_unstarted(recording, process_end, settings)
        end = _run_end(recording, process_end, controller)
        if progress is not None:
            progress("attributing", end.simulated_s or 0.0)
        trace = make_trace(controller, robot, scene, settings, recording, folder, end)
        asked = [
            name
            for note in recording.notes
            if note.kind == JOINTS_ASKED
            for name in note.data["names"]
        ]
        told = recording.note(NEEDS) or {"needs": ()}
        needs = tuple(Need(kind, name, type_name) for kind, name, type_name in told["needs"])
        return ControllerRun(trace, tuple(dict.fromkeys(asked)), needs)


@dataclass(frozen=True, slots=True)
class _ProcessEnd:
    """How the process ended: its return code, or the limit that was reached and where."""

    code: int
    limit: str | None = None
    location: Location | None = None


@contextlib.contextmanager
def _folder(keep: Path | None) -> Iterator[Path]:
    if keep is not None:
        try:
            keep.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            told = f"is no folder that a recording can be kept in: {error.strerror}"
            raise errors.InputError(told, Location(str(keep))) from error
        yield keep.resolve()
        return
    with tempfile.TemporaryDirectory(prefix="tracerisk-") as name:
        yield Path(name)


def _run_child(
    request: RunRequest, folder: Path, settings: Settings, progress: Progress | None
) -> _ProcessEnd:
    request_path = folder / "request.json"
    request_path.write_text(request.dumps(), encoding="utf-8")
    # A fixed hash seed keeps what a controller iterates over, sets say, in the same order.
    mark = f"{os.getpid()}-{time.monotonic_ns()}"
    # Nor may the host's time zone or a sourced ROS set-up show in what it sees.
    environment = {
        **{name: value for name, value in os.environ.items() if not name.startswith("ROS_")},
        "MUJOCO_GL": "disable",
        "PYTHONHASHSEED": "0",
        "TZ": "UTC",
        RUN_MARK: mark,
    }
    start = StartMark()
    child = subprocess.Popen(
        [sys.executable, "-u", "-m", "tracerisk.pipeline.child", str(request_path)],
        stdin=subprocess.DEVNULL,
        stdout=_output(progress),
        stderr=None if progress is None else subprocess.STDOUT,
        env={**environment, **start.environment(Limit("cpu_limit_s", settings.cpu_limit_s))},
        pass_fds=(start.descriptor,),
        start_new_session=True,
    )
    passing: threading.Thread | None = None
    try:
        passing = None if child.stdout is None else _pass_on(child.stdout)
        start.handed_over()
        return _watch(child, start, folder, settings, progress)
    finally:
        start.close()
        # Whatever the controller started goes with it.
        end_left_running(child.pid, mark)
        child.wait()
        if passing is not None:
            passing.join(_GRACE_S)


def _output(progress: Progress | None) -> int:
    """Return where a controller's output goes: to us while progress is drawn on the terminal."""
    if progress is not None:
        return subprocess.PIPE
    return sys.stderr.fileno() if _has_descriptor(sys.stderr) else subprocess.DEVNULL


def _pass_on(output: IO[bytes]) -> threading.Thread:
    """Print what a controller prints, line by line, where progress does not draw over it."""

    def pass_on() -> None:
        with output:
            for line in output:
                # Looked up each time: what draws the progress takes its place while it draws.
                sys.stderr.write(line.decode("utf-8", "replace"))
                sys.stderr.flush()

    thread = threading.Thread(target=pass_on, daemon=True)
    thread.start()
    return thread


def _has_descriptor(stream: Any) -> bool:
    try:
        stream.fileno()
    except (AttributeError, OSError, ValueError):
        return False
    return True


def _watch(
    child: subprocess.Popen[bytes],
    start: StartMark,
    folder: Path,
    settings: Settings,
    progress: Progress | None,
) -> _ProcessEnd:
    """Wait for the end of the child, or for a limit; these count from its start mark."""
    began = time.monotonic()
    own: OwnTime | None = None
    changed_s = 0.0
    seen = (-1, -1)
    while True:
        with contextlib.suppress(subprocess.TimeoutExpired):
            return _ProcessEnd(child.wait(timeout=POLL_S))
        if own is None and (cpu_s := start.cpu_s) is not None:
            own, began = OwnTime(child.pid, cpu_s), time.monotonic()
        if own is not None:
            own.look()
        grown = (_size(folder / EVENTS), _simulated_ns(folder))
        if grown != seen:
            seen, changed_s = grown, 0.0 if own is None else own.seconds
            if progress is not None:
                progress("simulating" if grown[1] > 0 else _STARTING, max(grown[1], 0) / 1e9)
        reached = _reached(own, changed_s, time.monotonic() - began, settings)
        if reached is not None and WallTime.is_in(folder):
            # All of the run is recorded, and what is left of the process does not matter.
            return _ProcessEnd(0)
        if reached is not None:
            return _stop(child, folder, reached)


def _reached(
    own: OwnTime | None, changed_s: float, wall_s: float, settings: Settings
) -> str | None:
    """Return the limit that a child has reached, in words; None for none.

    `changed_s` is its own time at the last progress of the simulation, `wall_s` the wall time
    since the start mark, or since the start of the process where there is none yet [s].
    """
    limits = settings.limits
    if own is not None and own.seconds - changed_s > limits.own.value:
        return (
            "nothing has moved and no time has passed in the simulation for "
            f"{limits.own.value:g} s of computing or sleeping; {limits.own.told}"
        )
    cpu = Limit("cpu_limit_s", settings.cpu_limit_s)
    if own is not None and own.cpu_s > cpu.value:
        return f"{cpu.value:g} s of processor time are over; {cpu.told}"
    if wall_s > limits.wall.value:
        what = "the process did not start in" if own is None else "the run is over after"
        return f"{what} {limits.wall.value:g} s of wall time; {limits.wall.told}"
    return None


def _size(path: Path) -> int:
    try:
        return path.stat().st_size
    except OSError:
        return -1


def _simulated_ns(folder: Path) -> int:
    from tracerisk.twin.samples import simulated_ns

    return simulated_ns(folder)


def _stop(child: subprocess.Popen[bytes], folder: Path, limit: str) -> _ProcessEnd:
    """End the child, having asked where it stands."""
    stacks = folder / STACKS
    before = _size(stacks)
    with contextlib.suppress(ProcessLookupError):
        child.send_signal(signal.SIGUSR1)
    deadline = time.monotonic() + _GRACE_S
    while _size(stacks) == before and child.poll() is None and time.monotonic() < deadline:
        time.sleep(POLL_S)
    time.sleep(POLL_S)
    with contextlib.suppress(ProcessLookupError):
        os.killpg(child.pid, signal.SIGKILL)
    child.wait()
    return _ProcessEnd(child.returncode, limit, _place_in(stacks, folder))


def _place_in(stacks: Path, folder: Path) -> Location | None:
    """Return the innermost place of the controller among the stacks that the child told."""
    root = Path(RunRequest.loads((folder / "request.json").read_text(encoding="utf-8")).root)
    try:
        text = stacks.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return None
    threads = text.split("\n\n")
    current = [each for each in threads if each.startswith("Current thread")]
    for thread in [*current, *threads]:
        for line in thread.splitlines():
            found = _STACK_LINE.match(line)
            if found is not None and Path(found["file"]).is_relative_to(root):
                file = Path(found["file"]).relative_to(root).as_posix()
                return Location(file, int(found["line"]))
    return None


def _recording(folder: Path) -> Recording:
    events = folder / EVENTS
    return read_recording(events) if events.exists() else Recording()


def _raise_failure(recording: Recording) -> None:
    """Raise the error with which the child refused to run anything."""
    failed = recording.note("failed")
    if failed is None:
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


def _raise_unstarted(recording: Recording, process: _ProcessEnd, settings: Settings) -> None:
    """Raise what kept the process from reaching the controller's first line."""
    if recording.note(STARTED) is not None or process.limit is not None:
        return
    if settings.memory_limit_mb < Settings().memory_limit_mb:
        raise errors.InputError(
            f"{settings.memory_limit_mb} MB are too little to start the simulation; give it more "
            f"with --memory-limit (default: {Settings().memory_limit_mb})"
        )
    if process.code == -signal.SIGKILL:
        raise errors.LimitError(
            "the process of the run was ended by SIGKILL before it began: the system may be short "
            "of memory; free some"
        )
    dependencies.check(dependencies.SIMULATION)
    raise RuntimeError(f"the process of the run ended with code {process.code} before it began")


def _run_end(recording: Recording, process: _ProcessEnd, controller: Controller) -> RunEnd:
    # What comes after a limit, while the process is being ended, is no end of its own.
    told = recording.end if process.limit is None else None
    mission_end = recording.note(MISSION_END)
    simulated_s = (told.time_ns if told else recording.last_ns) / 1e9
    if mission_end is not None:
        simulated_s = mission_end["ns"] / 1e9
    if told is not None:
        end = RunEnd(told.cause, told.message, simulated_s, told.location)
    elif process.limit is not None:
        end = RunEnd("wall_limit", process.limit, simulated_s, process.location)
    elif process.code < 0:
        name = signal.Signals(-process.code).name
        end = RunEnd("died", f"the controller's process was ended by {name}", simulated_s)
    else:
        end = RunEnd(
            "died",
            f"the controller's process ended with code {process.code} and told no reason",
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
