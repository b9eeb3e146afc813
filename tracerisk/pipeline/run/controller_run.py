"""Run a controller in a child process under limits, and make a trace of what it left."""

from __future__ import annotations

import contextlib
import json
import math
import os
import signal
import subprocess
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from tracerisk import errors
from tracerisk.common.dependencies import require_linux
from tracerisk.common.limits import Limit, Sandbox
from tracerisk.common.sandbox.limited_process import POLL_S, OwnTime, StartMark
from tracerisk.common.sandbox.process import (
    OF_FORKED,
    end,
    is_contained,
    passed_environment,
)
from tracerisk.common.sandbox.process import start as start_process
from tracerisk.config import Settings
from tracerisk.errors import TraceRiskError
from tracerisk.instrument.loader import file_below, source_key
from tracerisk.instrument.marks.decorators import instrument_source
from tracerisk.pipeline.run.child_output import PassingOn, stopped_at
from tracerisk.pipeline.run.ended_run import (
    PLAIN,
    ControllerRun,
    ProcessEnd,
    RunOptions,
    ended_run,
)
from tracerisk.pipeline.run.run_folders import run_folders, simulated_so_far, size_of
from tracerisk.pipeline.trace.run_files import (
    COMMAND_ENVIRONMENT,
    EVENTS,
    ROBOT,
    STACKS,
    TEMPORARY,
    Companion,
    RunRequest,
    WallTime,
)
from tracerisk.pipeline.workspace.driver_files import driver_files
from tracerisk.pipeline.workspace.own_modules import own_modules, source_bytes
from tracerisk.pipeline.workspace.prefixes import readable_of
from tracerisk.pipeline.workspace.project import Project
from tracerisk.pipeline.workspace.ros_distro import choose_distro
from tracerisk.pipeline.workspace.workspace import workspace_of
from tracerisk.twin.robots.file import dump_robot

if TYPE_CHECKING:
    from tracerisk.pipeline.launch.choose import LaunchChoice
    from tracerisk.pipeline.workspace.controller import Controller
    from tracerisk.twin.faults.fault import Fault
    from tracerisk.twin.robots.robot import Robot

_STARTING = "starting the twin"
_MB = 1024 * 1024
_LIVE = "tracerisk.pipeline.run.live.child"
_FIGURES = "module://tracerisk.ros.controller.unseen_windows"
"""The backend of matplotlib in a run, which has no screen."""
_GRACE_S = 2.0
_MOST_AHEAD = 200_000
"""How much of a controller's sources is instrumented before its run [bytes]."""
_MOST_OF_FILE = 50_000
"""How long each of them may be [bytes]: some of that length take seconds."""


@dataclass(frozen=True, slots=True)
class RunningChild:
    """The process of a run, whose work begins at a mark."""

    process: subprocess.Popen[bytes]
    """The child process."""
    start: StartMark
    """The mark at which the controller's work begins; limits count from it."""
    request: RunRequest
    """What the child was asked to run."""
    settings: Settings
    """The settings with the limits of the run."""
    options: RunOptions
    """What is asked of the run beside its settings."""

    def own_time(self, cpu_s: float) -> OwnTime:
        """Return the time of the process from its start mark on, at which it had used `cpu_s`."""
        keeper = self.process.pid
        return OwnTime(self.start.pid or keeper, cpu_s, keeper=keeper)

    def show(self, phase: str, simulated_ns: int) -> None:
        """Show how far the run has come."""
        if self.options.progress is not None:
            self.options.progress(phase, max(simulated_ns, 0) / 1e9)


Watch = Callable[[RunningChild], ProcessEnd]
"""Waits for the end of the process of a run."""


def run_controller(
    controller: Controller,
    robot: Robot,
    settings: Settings,
    choice: LaunchChoice,
    options: RunOptions = PLAIN,
    companions: tuple[Companion, ...] = (),
) -> ControllerRun:
    """Run the controller on the twin of `robot`, and return what the run showed.

    `choice` is what a launch file gives it, `companions` are started beside it.
    Where there is a `progress`, what they print goes through `sys.stderr`, of which that may have
    taken hold, and else to the standard error of this process.
    Raises SourceError, RobotError or another error of the input when nothing could run.
    """
    require_linux("running a controller")
    scene = settings.scene or robot.default_scene
    if scene is None:
        raise errors.RobotError(f"robot '{robot.name}' has no scene of its own; give --scene")
    launch = choice.setup
    workspace = workspace_of(controller, settings)
    with run_folders(options.keep) as (folder, written):
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
            drivers=tuple(map(str, driver_files(controller.project, settings))),
            launch=launch,
            launch_notes=choice.notes,
            reads_around=settings.launch is not False,
            companions=companions,
            duration_s=settings.run_duration_s,
            is_duration_given=settings.duration_s is not None,
            memory_limit_mb=settings.memory_limit_mb,
            seed=settings.seed,
            distro=choose_distro(controller, settings),
            moveit_release=settings.moveit_release,
            drafts=options.drafts,
            idle_s=options.idle_s,
            packages={name: str(package) for name, package in workspace.packages.items()},
            prefixes=workspace.prefixes,
            live_speed=options.live_speed,
        )
        return run_request(controller, robot, settings, request, written, options)


def run_again(
    controller: Controller,
    before: ControllerRun,
    settings: Settings,
    faults: tuple[Fault, ...],
    options: RunOptions = PLAIN,
    *,
    greenlets: bool = False,
) -> ControllerRun:
    """Run the controller once more as `before`, on a robot in which units fail.

    With `greenlets` these are what the controller's threads are, in the place of real ones.
    Raises as `run_controller`.
    """
    with run_folders(options.keep) as (folder, written):
        asked = before.request
        request = replace(asked, folder=str(folder), faults=faults, greenlets=greenlets)
        return run_request(controller, before.robot, settings, request, written, options)


def run_in_world(
    controller: Controller,
    before: ControllerRun,
    settings: Settings,
    world: str,
    options: RunOptions = PLAIN,
    *,
    duration_s: float,
) -> ControllerRun:
    """Run the controller once more as `before`, in another world, by its name.

    After `duration_s` of simulated time the run is over [s]. Raises as `run_controller`.
    """
    with run_folders(options.keep) as (folder, written):
        request = replace(before.request, folder=str(folder), world=world, duration_s=duration_s)
        return run_request(controller, before.robot, settings, request, written, options)


def run_with_sources(
    before: ControllerRun,
    ran: Controller,
    settings: Settings,
    sources: Mapping[str, bytes],
    options: RunOptions = PLAIN,
    *,
    duration_s: float,
) -> ControllerRun:
    """Run the controller once more as `before`, with some of its files replaced in memory.

    `sources` are the bytes of those, by their names below the root; what is on disk stays as it
    is. `ran` is the controller with the sources that the run `before` compiled. After
    `duration_s` of simulated time the run is over [s].
    Raises as `run_controller`.
    """
    with run_folders(options.keep) as (folder, written):
        texts = {file: source.decode("latin-1") for file, source in sources.items()}
        request = replace(before.request, folder=str(folder), replaced=texts, duration_s=duration_s)
        changed = ran.as_ran({**ran.others, **sources})
        return run_request(changed, before.robot, settings, request, written, options)


def run_request(
    controller: Controller,
    robot: Robot,
    settings: Settings,
    request: RunRequest,
    written: Path,
    options: RunOptions,
    watch: Watch | None = None,
) -> ControllerRun:
    """Run the controller as the request says, whose folder is that of the recording.

    `watch` waits for the end of the process, in the place of what ends it at its limits.
    """
    folder, asked_for = Path(request.folder), request
    reads = (*_workspace(request), *settings.readable, *settings.writable)
    request = replace(request, readable=reads)
    if request.live_speed is None and is_contained(settings.limits.sandbox):
        branches = () if request.plan is None else request.plan.writable
        writes = (str(folder), str(written), *branches, *settings.writable)
        request = replace(request, written=str(written), writable=writes)
    if request.live_speed is None:
        request = replace(request, instrumented=instrumented_ahead(controller))
    if request.scenario is not None:
        from tracerisk.ros.scenario.file.scenario_reader import read_scenario
        from tracerisk.ros.scenario.objects import with_mount

        robot = with_mount(robot, read_scenario(Path(request.scenario)))
    (folder / ROBOT).write_text(dump_robot(robot), encoding="utf-8")
    if options.progress is not None:
        options.progress(_STARTING, 0.0)
    process_end = _run_child(request, settings, options, watch or _watch)
    done = ended_run(controller, robot, settings, request, process_end, options)
    return replace(done, request=asked_for)


def instrumented_ahead(controller: Controller) -> dict[str, str]:
    """Return the instrumented texts of what the run may compile, so that it needs no libcst.

    What cannot be instrumented is left to the run, which fails where it is imported. So is a long
    file, and a large project, of which a run may import a small part.
    """
    root = controller.root.resolve()
    modules = (path for path in own_modules(controller) if path.is_relative_to(root))
    sources = {file_below(path, root): source_bytes(path) for path in modules}
    sources.update({**controller.others, controller.file: controller.source})
    if sum(map(len, sources.values())) > _MOST_AHEAD:
        return {}
    texts = {}
    for file, source in sources.items():
        if len(source) > _MOST_OF_FILE:
            continue
        with contextlib.suppress(TraceRiskError):
            texts[source_key(file, source)] = instrument_source(source, file).text
    return texts


def _font_lists() -> list[Path]:
    """Return the lists of fonts that matplotlib keeps; to make one takes seconds in each run."""
    caches = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")  # noqa: PTH111
    return sorted(Path(caches, "matplotlib").glob("fontlist-*.json"))


def _workspace(request: RunRequest) -> tuple[str, ...]:
    """Return what a controller's process may read besides Python and the system."""
    root = Path(request.root)
    named = [request.controller, request.scene, request.scenario, *request.params]
    companions = [
        path for companion in request.companions for path in (companion.script, companion.root)
    ]
    files = (
        [] if request.launch is None else [str(root / source) for source in request.launch.sources]
    )
    around = (root, Project(root).top, Path(request.controller).parent, Path(os.curdir).absolute())
    installed = map(str, readable_of(request.prefixes))
    packages = request.packages.values()
    read = (*map(str, around), *packages, *installed, *named, *companions, *files)
    return tuple(dict.fromkeys(name for name in read if name is not None))


def _run_child(
    request: RunRequest, settings: Settings, options: RunOptions, watch: Watch
) -> ProcessEnd:
    request_path = Path(request.folder) / "request.json"
    request_path.write_text(request.dumps(), encoding="utf-8")
    is_live = request.live_speed is not None
    # Its network has loopback alone; processes of a ROS that is installed are not contained.
    sandbox = Sandbox(mode="off") if is_live else settings.limits.sandbox
    start = StartMark()
    if is_live:
        # It looks at other processes until they rest, the longer the busier the machine is.
        settings = replace(settings, cpu_limit_s=math.inf)
    own = start.environment(Limit("cpu_limit_s", settings.cpu_limit_s))
    if is_live:
        # Compiled nodes, and those of ROS 2, find packages where the user's own do.
        own[COMMAND_ENVIRONMENT] = json.dumps(dict(os.environ))
    if request.written is not None:
        temporary = Path(request.written, TEMPORARY)
        temporary.mkdir()
        own["TMPDIR"] = str(temporary)
    child = start_process(
        _LIVE if is_live else "tracerisk.pipeline.run.child",
        str(request_path),
        sandbox=sandbox,
        reads=(*map(Path, request.readable), *_font_lists()),
        writes=map(Path, request.writable),
        environment={
            **({} if is_live else {"MPLBACKEND": _FIGURES}),
            **passed_environment(sandbox),
            "MUJOCO_GL": "disable",
            # The host's time zone must not show in what a controller sees.
            "TZ": "UTC",
            **own,
        },
        options=("-u",),
        pass_fds=(start.descriptor,),
        is_repeated=not is_live,
        speaks=True,
        memory_bytes=settings.memory_limit_mb * _MB,
        **OF_FORKED,
    )
    assert child.stdout is not None
    # A controller that is run again and again for its drafts prints the same each time.
    shown = request.drafts != "always" and not options.quiet
    passing = PassingOn(child.stdout, is_drawn=options.progress is not None, is_shown=shown)
    passing.start()
    try:
        start.handed_over()
        if options.meanwhile is not None:
            options.meanwhile()
        ended = watch(RunningChild(child, start, request, settings, options))
        has_begun, start_s = start.pid is not None, start.cpu_s or 0.0
    finally:
        # Whatever the controller started goes with it.
        end(child)
        start.close()
        passing.join(_GRACE_S)
    last_line = passing.last_line
    return replace(ended, has_begun=has_begun, last_line=last_line, start_s=start_s)


def _watch(child: RunningChild) -> ProcessEnd:
    """Wait for the end of the child, or for a limit; these count from its start mark."""
    start, folder = child.start, Path(child.request.folder)
    began = time.monotonic()
    own: OwnTime | None = None
    own_s = changed_s = 0.0
    seen = (-1, -1)
    while True:
        with contextlib.suppress(subprocess.TimeoutExpired):
            return ProcessEnd(child.process.wait(timeout=POLL_S), own_s=own_s)
        if own is None and (cpu_s := start.cpu_s) is not None:
            own, began = child.own_time(cpu_s), time.monotonic()
        if own is not None:
            own.look()
            own_s = own.seconds
        grown = (size_of(folder / EVENTS), simulated_so_far(folder))
        if grown != seen:
            seen, changed_s = grown, own_s
            child.show("simulating" if grown[1] > 0 else _STARTING, grown[1])
        reached = reached_limit(own, changed_s, time.monotonic() - began, child.settings)
        if reached is not None and WallTime.is_in(folder):
            # All of the run is recorded, and what is left of the process does not matter.
            return ProcessEnd(0, own_s=own_s)
        if reached is not None:
            return replace(_stop(child.process, start.pid, child.request, reached), own_s=own_s)


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
    if own is not None and own.held_bytes > limits.memory.value * _MB:
        return (
            f"the processes of the run take more than {limits.memory.value:g} MB of memory "
            f"together; {limits.memory.advice}"
        )
    if wall_s > limits.wall.value:
        what = "the process did not start in" if own is None else "the run is over after"
        return f"{what} {limits.wall.value:g} s of wall time; {limits.wall.advice}"
    return None


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
    return ProcessEnd(child.returncode, *stopped_at(stacks, Path(request.root), limit))
