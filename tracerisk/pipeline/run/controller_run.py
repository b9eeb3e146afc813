"""Run a controller in a child process under limits, and make a trace of what it left."""

from __future__ import annotations

import contextlib
import os
import re
import signal
import subprocess
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tracerisk import dependencies, errors
from tracerisk.config import Settings
from tracerisk.errors import Location, TraceRiskError
from tracerisk.instrument.recording import Note, Recording, read_recording
from tracerisk.limits import Limit, Sandbox
from tracerisk.pipeline.launch.program import shown
from tracerisk.pipeline.run.child_output import PassingOn
from tracerisk.pipeline.run.run_folders import check_left, run_folders
from tracerisk.pipeline.trace.run_files import (
    AROUND,
    DRAFTS,
    EVENTS,
    JOINTS_ASKED,
    LAUNCH,
    MISSION_END,
    MOST_TEXT,
    NEEDS,
    ROBOT,
    SCENARIO,
    STACKS,
    STARTED,
    TEMPORARY,
    Companion,
    DraftsNoted,
    RunRequest,
    WallTime,
)
from tracerisk.pipeline.trace.run_trace import make_trace
from tracerisk.pipeline.workspace.controller import lines_since
from tracerisk.pipeline.workspace.workspace import find_workspace, project_top
from tracerisk.ros.controller.needs import Need
from tracerisk.ros.drafts.draft import Draft, drafts_of
from tracerisk.sandbox.limited_process import POLL_S, OwnTime, StartMark
from tracerisk.sandbox.process import (
    OF_FORKED,
    end,
    is_contained,
    passed_environment,
    read_regular,
    regular_within,
)
from tracerisk.sandbox.process import start as start_process
from tracerisk.trace import RunEnd, Trace

if TYPE_CHECKING:
    from tracerisk.pipeline.launch.choose import LaunchChoice
    from tracerisk.pipeline.workspace.controller import Controller
    from tracerisk.twin.faults.fault import Fault
    from tracerisk.twin.robots.robot import Robot

Progress = Callable[[str, float], None]
"""Called with the phase and the simulated time [s]."""

_STARTING = "starting the twin"
_LIVE = "tracerisk.pipeline.run.live.child"
_GRACE_S = 2.0
_STACK_LINE = re.compile(r'  File "(?P<file>.*)", line (?P<line>\d+) in ')


@dataclass(frozen=True, slots=True)
class ProcessEnd:
    """How the process ended: its return code, or the limit that was reached and where.

    `has_begun`: the controller's first line was reached. `last_line` is what it printed last.
    """

    code: int
    limit: str | None = None
    location: Location | None = None
    has_begun: bool = False
    last_line: str = ""


Watch = Callable[
    ["subprocess.Popen[bytes]", StartMark, RunRequest, Settings, "Progress | None"], ProcessEnd
]
"""Waits for the end of the process of a run, whose work begins at a mark."""


@dataclass(frozen=True, slots=True)
class ControllerRun:
    """What one run showed: its trace, joints that it moved and the robot lacks, unmet `needs`.

    `drafts` are what a scenario could say for each need, where that was asked for. `robot` and
    `request` are what it ran with: enough to run it once more.
    """

    trace: Trace
    robot: Robot
    request: RunRequest
    joints_asked: tuple[str, ...] = ()
    needs: tuple[Need, ...] = ()
    drafts: tuple[Draft, ...] = ()


def run_controller(
    controller: Controller,
    robot: Robot,
    settings: Settings,
    choice: LaunchChoice,
    *,
    companions: tuple[Companion, ...] = (),
    keep: Path | None = None,
    progress: Progress | None = None,
    drafts: DraftsNoted = "never",
    live_speed: float | None = None,
) -> ControllerRun:
    """Run the controller on the twin of `robot`, and return what the run showed.

    `choice` is what a launch file gives it, `companions` are started beside it. `drafts` says
    when what a scenario could say is noted. With `live_speed` it runs on real rospy.
    Where there is a `progress`, what they print goes through `sys.stderr`, of which that may have
    taken hold, and else to the standard error of this process.
    Raises SourceError, RobotError or another error of the input when nothing could run.
    """
    from tracerisk.pipeline.workspace.driver_files import driver_files

    scene = settings.scene or robot.default_scene
    if scene is None:
        raise errors.RobotError(f"robot '{robot.name}' has no scene of its own; give --scene")
    launch = choice.setup
    workspace = find_workspace(controller.root)
    with run_folders(keep) as (folder, written):
        request = RunRequest(
            controller=str(controller.path.resolve()),
            root=str(controller.root.resolve()),
            folder=str(folder),
            argv=settings.args if launch is None else launch.argv(settings.args),
            states=settings.states,
            answers=settings.answers,
            scene=scene,
            scenario=settings.scenario,
            params=settings.params,
            drivers=tuple(map(str, driver_files(controller.root.resolve(), settings))),
            launch=launch,
            launch_notes=choice.notes,
            reads_around=settings.launch is not False,
            companions=companions,
            duration_s=settings.run_duration_s,
            memory_limit_mb=settings.memory_limit_mb,
            seed=settings.seed,
            drafts=drafts,
            packages={name: str(each) for name, each in workspace.packages.items()},
            live_speed=live_speed,
        )
        return run_request(controller, robot, settings, request, written, progress)


def run_again(
    controller: Controller,
    before: ControllerRun,
    settings: Settings,
    faults: tuple[Fault, ...],
    *,
    keep: Path | None = None,
    progress: Progress | None = None,
    quiet: bool = False,
    greenlets: bool = False,
    beside: Recording | None = None,
) -> ControllerRun:
    """Run the controller once more as `before`, on a robot in which units fail.

    What it prints is dropped where the run is `quiet`. With `greenlets` these are what the
    controller's threads are, in the place of real ones. The trace is to be judged `beside`
    another run, as `make_trace` says. Raises as `run_controller`.
    """
    with run_folders(keep) as (folder, written):
        asked = before.request
        request = replace(asked, folder=str(folder), faults=faults, greenlets=greenlets)
        return run_request(
            controller,
            before.robot,
            settings,
            request,
            written,
            progress,
            quiet=quiet,
            beside=beside,
        )


def run_request(
    controller: Controller,
    robot: Robot,
    settings: Settings,
    request: RunRequest,
    written: Path,
    progress: Progress | None = None,
    *,
    quiet: bool = False,
    watch: Watch | None = None,
    beside: Recording | None = None,
) -> ControllerRun:
    """Run the controller as the request says, whose folder is that of the recording.

    `watch` waits for the end of the process, in the place of what ends it at its limits.
    """
    from tracerisk.twin.robots.file import dump_robot

    folder, asked_for = Path(request.folder), request
    if request.live_speed is None and is_contained(settings.limits.sandbox):
        reads = (*_workspace(request), *settings.readable, *settings.writable)
        branches = () if request.plan is None else request.plan.writable
        writes = (str(folder), str(written), *branches, *settings.writable)
        request = replace(request, written=str(written), readable=reads, writable=writes)
    (folder / ROBOT).write_text(dump_robot(robot), encoding="utf-8")
    if progress is not None:
        progress(_STARTING, 0.0)
    process_end = _run_child(request, folder, settings, progress, watch or _watch, quiet=quiet)
    done = ended_run(controller, robot, settings, request, process_end, progress, beside=beside)
    return replace(done, request=asked_for)


def ended_run(
    controller: Controller,
    robot: Robot,
    settings: Settings,
    request: RunRequest,
    process_end: ProcessEnd,
    progress: Progress | None = None,
    *,
    beside: Recording | None = None,
) -> ControllerRun:
    """Return what a run showed whose process has ended, by what it left in its folder.

    Its trace is to be judged `beside` another run, as `make_trace` says.

    Raises LogError or LimitError at what is no recording, and the error with which it refused.
    """
    folder = Path(request.folder)
    recording = _recording(folder, request)
    _raise_failure(recording)
    _raise_unstarted(recording, process_end, settings)
    ran = controller.as_ran(recording.sources)
    end = _run_end(recording, process_end, ran)
    if progress is not None:
        progress("attributing", end.simulated_s or 0.0)
    trace = make_trace(
        ran,
        robot,
        request.scene,
        settings,
        recording,
        folder,
        end,
        beside=beside,
    )
    trace = trace.with_lines(lines_since(recording.sources, controller))
    asked = [
        name for note in recording.notes if note.kind == JOINTS_ASKED for name in note.data["names"]
    ]
    unmet = recording.note(NEEDS) or {"needs": ()}
    needs = tuple(Need(kind, name, type_name) for kind, name, type_name in unmet["needs"])
    drafted = tuple(drafts_of((recording.note(DRAFTS) or {"drafts": ()})["drafts"]))
    return ControllerRun(trace, robot, request, tuple(dict.fromkeys(asked)), needs, drafted)


def _workspace(request: RunRequest) -> tuple[str, ...]:
    """Return what a controller's process may read besides Python and the system."""
    root = Path(request.root)
    named = [request.controller, request.scene, request.scenario, *request.params]
    companions = [path for each in request.companions for path in (each.script, each.root)]
    files = [] if request.launch is None else [str(root / each) for each in request.launch.sources]
    around = (root, project_top(root), Path(request.controller).parent, Path(os.curdir).absolute())
    found = (*map(str, around), *request.packages.values(), *named, *companions, *files)
    return tuple(dict.fromkeys(each for each in found if each is not None))


def _run_child(
    request: RunRequest,
    folder: Path,
    settings: Settings,
    progress: Progress | None,
    watch: Watch,
    *,
    quiet: bool = False,
) -> ProcessEnd:
    request_path = folder / "request.json"
    request_path.write_text(request.dumps(), encoding="utf-8")
    is_live = request.live_speed is not None
    # Its network has loopback alone; processes of a ROS that is installed are not contained.
    sandbox = Sandbox(mode="off") if is_live else settings.limits.sandbox
    start = StartMark()
    own = start.environment(Limit("cpu_limit_s", settings.cpu_limit_s))
    if request.written is not None:
        temporary = Path(request.written, TEMPORARY)
        temporary.mkdir()
        own["TMPDIR"] = str(temporary)
    child = start_process(
        _LIVE if is_live else "tracerisk.pipeline.run.child",
        str(request_path),
        sandbox=sandbox,
        reads=map(Path, request.readable),
        writes=map(Path, request.writable),
        environment={
            **passed_environment(sandbox),
            "MUJOCO_GL": "disable",
            # The host's time zone must not show in what a controller sees.
            "TZ": "UTC",
            **(own if is_live else {}),
        },
        options=("-u",),
        pass_fds=(start.descriptor,),
        own=None if is_live else own,
        **OF_FORKED,
    )
    assert child.stdout is not None
    # A controller that is run again and again for its drafts prints the same each time.
    shown = request.drafts != "always" and not quiet
    passing = PassingOn(child.stdout, is_drawn=progress is not None, is_shown=shown)
    passing.start()
    try:
        start.handed_over()
        ended = watch(child, start, request, settings, progress)
        has_begun = start.pid is not None
    finally:
        # Whatever the controller started goes with it.
        end(child)
        start.close()
        passing.join(_GRACE_S)
    return replace(ended, has_begun=has_begun, last_line=passing.last_line)


def _watch(
    child: subprocess.Popen[bytes],
    start: StartMark,
    request: RunRequest,
    settings: Settings,
    progress: Progress | None,
) -> ProcessEnd:
    """Wait for the end of the child, or for a limit; these count from its start mark."""
    folder = Path(request.folder)
    began = time.monotonic()
    own: OwnTime | None = None
    changed_s = 0.0
    seen = (-1, -1)
    while True:
        with contextlib.suppress(subprocess.TimeoutExpired):
            return ProcessEnd(child.wait(timeout=POLL_S))
        if own is None and (cpu_s := start.cpu_s) is not None:
            own, began = OwnTime(start.pid or child.pid, cpu_s), time.monotonic()
        if own is not None:
            own.look()
        grown = (size_of(folder / EVENTS), simulated_so_far(folder))
        if grown != seen:
            seen, changed_s = grown, 0.0 if own is None else own.seconds
            if progress is not None:
                progress("simulating" if grown[1] > 0 else _STARTING, max(grown[1], 0) / 1e9)
        reached = reached_limit(own, changed_s, time.monotonic() - began, settings)
        if reached is not None and WallTime.is_in(folder):
            # All of the run is recorded, and what is left of the process does not matter.
            return ProcessEnd(0)
        if reached is not None:
            return _stop(child, start.pid, request, reached)


def reached_limit(
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
            f"{limits.own.value:g} s of computing or sleeping; {limits.own.advice}"
        )
    cpu = Limit("cpu_limit_s", settings.cpu_limit_s)
    if own is not None and own.cpu_s > cpu.value:
        return f"{cpu.value:g} s of processor time are over; {cpu.advice}"
    if wall_s > limits.wall.value:
        what = "the process did not start in" if own is None else "the run is over after"
        return f"{what} {limits.wall.value:g} s of wall time; {limits.wall.advice}"
    return None


def size_of(path: Path) -> int:
    """Return the size of a file [bytes], -1 of one that is not there."""
    try:
        return path.stat().st_size
    except OSError:
        return -1


def simulated_so_far(folder: Path) -> int:
    """Return how far a run has come that is being recorded [ns], -1 where its folder is gone."""
    from tracerisk.twin.recording.samples import simulated_ns

    try:
        return simulated_ns(folder)
    except OSError:  # removed while it was looked at
        return -1


def _stop(
    child: subprocess.Popen[bytes], pid: int | None, request: RunRequest, limit: str
) -> ProcessEnd:
    """End the child, having asked its process `pid` where it stands, if that has begun."""
    stacks = Path(request.folder) / STACKS
    before = size_of(stacks)
    deadline = time.monotonic() + _GRACE_S
    if pid is None:
        deadline = 0.0
    elif child.poll() is None:
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.kill(pid, signal.SIGUSR1)
    while size_of(stacks) == before and child.poll() is None and time.monotonic() < deadline:
        time.sleep(POLL_S)
    time.sleep(POLL_S)
    end(child)
    return ProcessEnd(child.returncode, limit, place_in(stacks, Path(request.root)))


def place_in(stacks: Path, root: Path) -> Location | None:
    """Return the innermost place of the controller among the stacks that the child sent."""
    try:
        text = read_regular(stacks, MOST_TEXT).decode(errors="replace")
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


def _recording(folder: Path, request: RunRequest) -> Recording:
    """Read what the child has left; it was able to put anything there.

    Raises LimitError where a file is too large, LogError where one is malformed, or speaks of
    sources outside of the workspace.
    """
    check_left(folder)
    events = folder / EVENTS
    found = read_recording(events) if events.exists() else Recording()
    files = {site.ref.file for site in found.functions_ran}
    files |= {frame.function.file for each in found.commands for frame in each.stack}
    root = Path(request.root)
    within = list(map(Path, request.readable)) or [root, *map(Path, request.packages.values())]
    known = regular_within((str(root / each) for each in files), within)
    if request.written is not None and len(known) < len(files):
        strange = sorted(each for each in files if root / each not in known)
        raise errors.LogError(
            f"speaks of {strange[0]}, which is not a file of the workspace", Location(EVENTS)
        )
    # What it was given is not for it to say.
    notes = tuple(note for note in found.notes if note.kind != LAUNCH)
    lines = [*request.launch_notes, *(each.line for each in request.companions)]
    files_read = [] if request.launch is None else list(request.launch.sources)
    files_read += [file for each in request.companions for file in each.files]
    for each in found.notes:
        if each.kind == AROUND and (read := regular_within(map(str, each.data["files"]), within)):
            given = shown(read, root)
            line = (
                f"launch: parameter {each.data['name']} from {given[0]}, which starts other "
                "nodes; --no-launch leaves it out"
            )
            lines += [] if line in lines else [line]
            files_read += given
    if lines and found.note(STARTED) is not None:
        inputs = tuple(dict.fromkeys(files_read))
        notes += (Note(LAUNCH, {"notes": tuple(lines), "inputs": inputs}),)
    return replace(found, notes=notes)


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


def _raise_unstarted(recording: Recording, process: ProcessEnd, settings: Settings) -> None:
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
        raise errors.LimitError(
            "the process of the run was ended by SIGKILL before it began: the system may be short "
            "of memory; free some"
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
        name = signal.Signals(-process.code).name
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
