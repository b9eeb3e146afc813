"""The process in which a controller runs: the twin, the stand-ins, the tracer and its end.

Started by `tracerisk.pipeline` with the name of a file, the request; what it finds it
writes into the folder of the recording at once, so that a sudden death loses nothing seen.
"""

from __future__ import annotations

import contextlib
import faulthandler
import gc
import os
import resource
import signal
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path

from tracerisk.common.sandbox.limited_process import lower_limit, mark_start
from tracerisk.common.sandbox.moved_files import MovedFiles
from tracerisk.common.sandbox.noted_reads import NotedReads
from tracerisk.common.sandbox.overlay import Overlay
from tracerisk.common.worlds.world import NOMINAL, world_named
from tracerisk.errors import ExitCode, Location, TraceRiskError
from tracerisk.instrument.import_finder import ControllerFinder, controller_imports
from tracerisk.instrument.loader import prepared_controller
from tracerisk.instrument.marks.call_log import CALLS
from tracerisk.instrument.marks.caught_exceptions import REFUSED, CaughtFailure
from tracerisk.instrument.recording import CELL, Recorder
from tracerisk.instrument.tracer import Tracer
from tracerisk.pipeline.launch.bringup_parameters import ParametersAround
from tracerisk.pipeline.launch.left_open import filled
from tracerisk.pipeline.launch_files.records import NOTHING_LAUNCHED
from tracerisk.pipeline.mission.asked_calls import AskedCalls
from tracerisk.pipeline.mission.named_objects import check_names
from tracerisk.pipeline.run.branching.fate import FateWatch
from tracerisk.pipeline.run.branching.points import BranchPoints
from tracerisk.pipeline.run.companions.companion_run import Companions
from tracerisk.pipeline.run.controller_end import ControllerEnd
from tracerisk.pipeline.run.missing_modules import MissingModules
from tracerisk.pipeline.run.preparation import prepare
from tracerisk.pipeline.run.run_watch import RunWatch
from tracerisk.pipeline.run.scripted_input import Answers, scripted_input
from tracerisk.pipeline.run.stall_watch import StallWatch
from tracerisk.pipeline.run.unmet_needs import UnmetNeeds
from tracerisk.pipeline.trace.run_files import (
    AROUND,
    DISTRO,
    ELSEWHERE,
    ENTRY,
    EVENTS,
    GIVEN,
    GRAPH_USE,
    INSTALLED,
    JOINTS_ASKED,
    LOST_ON_THE_WAY,
    ROBOT,
    STACKS,
    STARTED,
    RunRequest,
    WallTime,
)
from tracerisk.pipeline.workspace.entry_point import find_entry_point
from tracerisk.pipeline.workspace.libraries import Libraries
from tracerisk.pipeline.workspace.needs_in_source import asked_in_file
from tracerisk.pipeline.workspace.prefixes import python_folders, readable_of, with_interfaces
from tracerisk.pipeline.workspace.project import Project
from tracerisk.pipeline.workspace.workspace import Workspace
from tracerisk.ros.controller.needs import asking_place
from tracerisk.ros.distributions.in_run import DistroRules
from tracerisk.ros.drafts.known_answers import known_answers
from tracerisk.ros.drafts.usable_values import UsableValues
from tracerisk.ros.graph.graph import Graph
from tracerisk.ros.graph.parameter_files import read_parameters
from tracerisk.ros.graph.runtime import Runtime, activate
from tracerisk.ros.graph.sensor_reading import SensorReading
from tracerisk.ros.imports.finder import StandInFinder
from tracerisk.ros.imports.installed_libraries import InstalledLibraries
from tracerisk.ros.imports.numpy_names import removed_numpy_names
from tracerisk.ros.imports.opencv_names import served_opencv_names
from tracerisk.ros.imports.placeholder_modules import PlaceholderFinder, PlaceholderValues
from tracerisk.ros.imports.python_names import removed_python_names
from tracerisk.ros.imports.vendor_libraries import VENDOR_LIBRARIES, giving_way
from tracerisk.ros.messages.interface_texts import ENDINGS as INTERFACE_ENDINGS
from tracerisk.ros.messages.interface_texts import InterfaceText
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.messages.ros2 import Interfaces2
from tracerisk.ros.moveit.move_group import MoveGroupServer
from tracerisk.ros.readings.stale_messages import StaleMessages
from tracerisk.ros.robot.bring_up.xacro_command import answered_xacro
from tracerisk.ros.robot.commands import TwinCommands
from tracerisk.ros.robot.frames import TwinFrames
from tracerisk.ros.robot.set_points import JOINT_STATE_TYPE
from tracerisk.ros.robot.state_topics import TwinTopics
from tracerisk.ros.scenario.cell_log import CellLog
from tracerisk.ros.scenario.objects import with_objects, with_start
from tracerisk.ros.scenario.scenario import Scenario, read_scenario
from tracerisk.ros.scenario.world import ScenarioWorld
from tracerisk.ros.time.greenlet_baton import GreenletBaton
from tracerisk.ros.time.patches import virtual_time
from tracerisk.ros.time.scheduler import Scheduler
from tracerisk.ros.twin_interfaces import TwinInterfaces
from tracerisk.ros.vendors.description import Driver
from tracerisk.ros.vendors.description_reader import driver_of
from tracerisk.ros.vendors.driver_search import definitions_of, read_drivers, shipped_drivers
from tracerisk.ros.vendors.serving import serve_vendors
from tracerisk.ros.world.connecting import ConnectionTimes
from tracerisk.ros.world.start import started_in
from tracerisk.ros.world.state_reads import StateReads
from tracerisk.trace import EndCause
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.recording.samples import SampleWriter
from tracerisk.twin.robots.assumed_names import with_assumed_names
from tracerisk.twin.robots.file import read_dumped_robot
from tracerisk.twin.simulation.twin import Twin

__all__ = ["main", "prepare"]
_MB = 1024 * 1024
_MOST_DENIED = 50


def main() -> int:
    """Run the request named on the command line; the exit code says how the run ended."""
    request = RunRequest.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    lower_limit(resource.RLIMIT_AS, request.memory_limit_mb * _MB)
    folder = Path(request.folder)
    with (folder / STACKS).open("w") as stacks:
        # The parent asks where an endless loop stands before it ends the process.
        faulthandler.register(signal.SIGUSR1, file=stacks, all_threads=True)
        return recorded(request, _run)


def recorded(
    request: RunRequest,
    run: Callable[[RunRequest, SampleWriter, Recorder, list[Callable[[], int]]], None],
) -> int:
    """Carry out a run that leaves a recording; return the code with which its process ends.

    The run gives the recorder's clock, the only one of its list.
    """
    folder = Path(request.folder)
    # What is imported by now stays; what a controller makes is collected as ever.
    gc.freeze()
    gc.enable()
    with (folder / EVENTS).open("wb", buffering=0) as stream, SampleWriter(folder) as samples:
        # The recorder's clock and the tracer know each other only through the scheduler.
        clock: list[Callable[[], int]] = [lambda: 0]
        recorder = Recorder(stream, clock=lambda: clock[0]())
        try:
            run(request, samples, recorder, clock)
        except TraceRiskError as error:
            # Nothing has run: the source, the robot or the scene is at fault.
            _refuse(recorder, error)
            return int(error.exit_code)
    return 0


def _run(
    request: RunRequest,
    samples: SampleWriter,
    recorder: Recorder,
    clock: list[Callable[[], int]],
) -> None:
    script, root = Path(request.controller), Path(request.root)
    project = Project(root)
    launch = request.launch or NOTHING_LAUNCHED
    # Bound before virtual time takes the place of the machine's.
    wall_clock = time.perf_counter
    twin, scenario = twin_of(request, samples, recorder)
    robot = twin.robot
    for fault in request.faults:
        twin.arm(fault)
    tracer = Tracer(recorder.function_ran)
    tracer.on_source = recorder.source_compiled
    tracer.on_caught = refusals_noted(recorder)
    world = _Metered(twin, wall_clock)
    scheduler = Scheduler(
        world,
        duration_ns=round(request.duration_s * 1e9),
        tracer=tracer,
        on_stuck=lambda over: end.kill(over),
        baton=GreenletBaton() if request.greenlets else None,
    )
    clock[0] = lambda: scheduler.now_ns
    workspace = workspace_asked(request)
    runtime = runtime_of(request, scenario, scheduler, tracer, twin, recorder, workspace)
    cell = CellLog(runtime.graph, AskedCalls(recorder, scheduler, scenario.success).take)
    companions = Companions(request.companions, runtime, recorder)
    watch = RunWatch(scheduler, recorder, request.idle_s)
    note_given(recorder, scenario)
    recorder.watch, tracer.on_iteration = watch, watch.looped
    ros = project.ros_version(script)
    is_ros2 = ros == 2
    own = workspace.interfaces
    drivers, more = drivers_of(request, scenario)
    reads = NotedReads(readable_of(workspace.prefixes), INTERFACE_ENDINGS)
    there = with_interfaces(runtime.installed)
    interfaces = (
        Interfaces2(own, more, runtime.distro, there, reads.add)
        if is_ros2
        else Interfaces(own, more, there, reads.add)
    )
    serve_twin(runtime, interfaces, drivers)
    state_reads = (
        StateReads(interfaces.message(JOINT_STATE_TYPE))
        if world_named(request.world).joint_order != NOMINAL.joint_order
        else None
    )
    scenario_world = ScenarioWorld(runtime, interfaces, scenario)
    schedule = watch.schedule = scenario_world.schedule
    values = UsableValues(
        robot,
        twin.forward_kinematics,
        lambda group, pose: twin.inverse_kinematics(group, pose, avoid_collisions=True),
        alone=lambda: twin.planning_among(()),
    )
    needs = UnmetNeeds(
        runtime,
        interfaces,
        root,
        lambda: watch.has_commanded,
        scenario_world.unused,
        scenario_world.unanswered,
        values,
        script=script,
        in_source=lambda source: asked_in_file(source, ros, project),
        drafts=request.drafts,
        shift=lambda: (
            runtime.client(MoveGroupServer).shift_to_reach() if scenario.unconfirmed else None
        ),
    )
    fate: FateWatch | None = None
    if request.beside is not None:
        fate = FateWatch(request.beside, robot, scheduler, twin, recorder)
        if request.faults:
            fate.begin(request.faults)
    stall = StallWatch(scheduler, watch, needs, lambda: schedule.is_pending)
    world.time_passed = [watch.time_passed, stall.time_passed]

    def run_over(cause: EndCause) -> None:
        recorder.note(CALLS, **tracer.executed_calls())
        runtime.client(TwinCommands).finish(cause)
        runtime.client(SensorReading).finish()
        recorder.note(CELL, **cell.note())
        recorder.note(INSTALLED, files=reads.files())
        carrier = runtime.graph.carrier
        for early in carrier.lost:
            words, place = early.words(carrier.times), early.place
            recorder.finding(
                "sent_early", words, place, object_name=early.name, time_ns=early.time_ns
            )
        runtime.client(StaleMessages).report()
        if request.world != NOMINAL.name:
            read = [] if state_reads is None else state_reads.places_in(root)
            recorder.note(LOST_ON_THE_WAY, lost=[*carrier.lost_in(root), *read])
        watch.run_over(cause)
        if fate is not None:
            fate.note_end()

    ways = giving_way(workspace.python_packages)
    for name, folder in ways.python_2.items():
        words = f"{name} of the workspace is for Python 2; tracerisk's stand-in for it runs instead"
        recorder.finding("removed_name", words, Location(str(folder)), object_name=name)
    stand_ins = StandInFinder(interfaces, ways.names)
    missing = MissingModules(script, root, stand_ins.provides)
    end = ControllerEnd(
        recorder,
        twin,
        root,
        request.memory_limit_mb,
        run_over,
        needs.judge,
        missing,
        scheduler.outlast,
        on_missing=needs.modules_missing,
    )
    scheduler.on_abort = end.abort
    replaced = request.replaced_bytes
    kinds = stand_ins.provides.items()
    libraries = {name for name, kind in kinds if kind.startswith("library")} - ways.names
    installed, beside = (
        InstalledLibraries(
            python_folders(prefix for prefix in workspace.prefixes if prefix.fills_in == fills_in),
            libraries | (VENDOR_LIBRARIES if fills_in else set()),
            interfaces.packages,
        )
        for fills_in in (False, True)
    )
    imports = ControllerFinder(
        tracer,
        root,
        packages=workspace.python_packages,
        reserved=libraries,
        shared=set(stand_ins.provides) - libraries - ways.names,
        elsewhere=lambda name: _found_elsewhere(name, workspace, root, recorder),
        is_library=Libraries(script, project, request.states).holds,
        replaced=replaced,
    )
    placeholders = PlaceholderFinder(
        [name for name, _ in scenario.modules],
        PlaceholderValues(lambda: values.posture, lambda: scheduler.now_ns),
    )
    entry = find_entry_point(script, script.read_bytes(), root)
    with (
        _files(request, recorder) as overlay,
        moved_files(script, project, workspace, recorder).active(),
        activate(runtime),
        stand_ins,
        beside.active(),
        installed.active(),
        placeholders,
        answered_xacro(runtime),
        removed_numpy_names(),
        removed_python_names(request.distro.name),
        served_opencv_names(),
        virtual_time(scheduler, seed=request.seed, note=partial(recorder.finding, "not_simulated")),
        scripted_input(
            Answers(
                (*request.answers, *scenario.answers),
                recorder,
                scheduler,
                str(script),
                assume=lambda: known_answers(asking_place(), values),
                progress=lambda: watch.last_command_ns,
            )
        ),
        prepared_controller(
            script,
            tracer,
            request.argv,
            root=root,
            entry=entry.function if entry else None,
            replaced=replaced,
        ) as run,
        controller_imports(imports),
    ):
        # Behind what is installed: a build puts no file before another package's.
        sys.path += [str(folder) for folder in workspace.import_paths]

        # The controller's own modules leave no `__pycache__` in its folder.
        sys.dont_write_bytecode = True
        recorder.note(STARTED)
        if not is_ros2 and request.reads_around:
            runtime.graph.parameters.fall_back_on(
                ParametersAround(
                    script,
                    root,
                    workspace,
                    lambda name, files: recorder.note(
                        AROUND, name=name, files=[str(file) for file in files]
                    ),
                )
            )
        os.environ.update(
            {"ROS_DISTRO": request.distro.name, "ROS_VERSION": "2" if is_ros2 else "1"}
        )
        os.environ.update(launch.environment)
        if entry is not None:
            recorder.note(ENTRY, function=entry.function, named_in=entry.named_in)

        def begin() -> None:
            companions.start()
            run()

        points = BranchPoints(request, twin, samples, end, overlay, fate)
        reads.watch()
        mark_start()
        points.begin()
        began = wall_clock()
        end.run(lambda: scheduler.run_main(begin))
        recorder.note(GRAPH_USE, counts=dict(sorted(runtime.graph.counts.items())))
        twin.close()
        WallTime(wall_clock() - began, world.seconds).write(points.folder)
        points.finish()


def twin_of(
    request: RunRequest, samples: SampleWriter, recorder: Recorder
) -> tuple[Twin, Scenario]:
    """Return the twin of a request, whose robot lies in `folder`, and its scenario."""
    robot = with_assumed_names(
        read_dumped_robot(Path(request.folder, ROBOT)),
        lambda message: recorder.finding("assumed_name", message),
    )
    scenario = Scenario() if request.scenario is None else read_scenario(Path(request.scenario))
    robot = with_start(robot, scenario.start)
    world = world_named(request.world)
    robot = started_in(world, robot, {name for name, _, _ in scenario.start})
    scene = with_objects(load_scene(request.scene), scenario.objects)
    check_names(scenario, robot, scene)
    twin = Twin.build(robot, scene, samples=samples)
    if world.takes_other_solution:
        twin.take_other_solutions()
    if world is not NOMINAL:
        twin.pass_over_rest()
    twin.on_unknown_joints = lambda names: recorder.note(JOINTS_ASKED, names=names)
    return twin, scenario


def workspace_asked(request: RunRequest) -> Workspace:
    """Return the packages of a request."""
    packages = {name: Path(each) for name, each in request.packages.items()}
    return Workspace(packages, request.prefixes)


def runtime_of(
    request: RunRequest,
    scenario: Scenario,
    scheduler: Scheduler,
    tracer: Tracer,
    twin: Twin,
    recorder: Recorder,
    workspace: Workspace,
    *,
    is_live: bool = False,
) -> Runtime:
    """Return the runtime of a request, with the parameters that are given for the controller.

    In a live run real ROS connects the ends.
    """
    launch = request.launch or NOTHING_LAUNCHED
    distro = _distro_of(request, recorder)
    times = ConnectionTimes() if is_live else ConnectionTimes.of(distro)
    return Runtime(
        scheduler,
        Graph(scheduler, tracer, world=world_named(request.world), times=times),
        twin=twin,
        tracer=tracer,
        recorder=recorder,
        argv=(str(Path(request.controller)), *request.argv),
        seed=request.seed,
        parameters=(
            *filled(
                launch.parameters,
                twin.robot.name,
                lambda name, words: recorder.finding("answer_assumed", words, object_name=name),
            ),
            *scenario.parameters,
            *(each for file in request.params for each in read_parameters(Path(file))),
        ),
        packages=workspace.packages,
        installed=workspace.installed,
        distro=distro,
    )


def _distro_of(request: RunRequest, recorder: Recorder) -> DistroRules:
    """Return the rules of the distribution; where it is assumed, what they decide is recorded."""
    if not request.distro.is_assumed:
        return DistroRules(request.distro.name)
    recorder.note(DISTRO, line=request.distro.assumption)

    def report(words: str, location: Location | None, rule: str) -> None:
        recorder.finding("distro_assumed", words, location, object_name=rule)

    return DistroRules(request.distro.name, report)


def note_given(recorder: Recorder, scenario: Scenario) -> None:
    """Note what a scenario gives, for whoever judges the run."""
    recorder.note(
        GIVEN,
        bodies=[each.string("name") for each in scenario.objects],
        objects=[
            each.string("name")
            for each in scenario.objects
            if each.boolean("graspable", default="mass" in each)
        ],
        accept=[asdict(each) for each in scenario.accept],
        unconfirmed=[asdict(each) for each in scenario.unconfirmed],
        modules=[name for name, _ in scenario.modules],
    )


def refusals_noted(recorder: Recorder) -> Callable[[CaughtFailure], None]:
    """Return what records the calls that stand-ins refused, each once."""
    noted: set[CaughtFailure] = set()

    def caught(failure: CaughtFailure) -> None:
        if failure not in noted:
            noted.add(failure)
            recorder.finding(REFUSED, failure.words, failure.location, object_name=failure.call)

    return caught


def drivers_of(
    request: RunRequest, scenario: Scenario
) -> tuple[tuple[Driver, ...], tuple[InterfaceText, ...]]:
    """Return the drivers of scenario and request, and the messages that they and ours define."""
    described = (driver_of(each, scenario.file) for each in scenario.drivers)
    drivers = (*described, *read_drivers(map(Path, request.drivers), Path(request.root)))
    return drivers, definitions_of((*shipped_drivers(), *drivers))


def serve_twin(
    runtime: Runtime, interfaces: Interfaces | Interfaces2, drivers: Sequence[Driver]
) -> None:
    """Serve what the twin serves, and what makers' drivers and the given ones do."""
    TwinTopics(runtime, interfaces)
    serve_vendors(runtime, TwinInterfaces(runtime, interfaces), drivers)
    frames = TwinFrames(runtime, interfaces)
    for driver in (*drivers, *shipped_drivers()):
        frames.also(driver.frames)


def _found_elsewhere(
    name: str, workspace: Workspace, root: Path, recorder: Recorder
) -> Path | None:
    """Return the folder of a module that stands off the import path, and say so."""
    folder = workspace.folder_of_module(name, root)
    if folder is not None:
        recorder.note(ELSEWHERE, module=name, folder=os.path.relpath(folder, root))
    return folder


def moved_files(
    script: Path, project: Project, workspace: Workspace, recorder: Recorder
) -> MovedFiles:
    """Return where files are that the author names by another machine's paths, or from elsewhere.

    Those that are found are noted.
    """

    def found(path: str, here: str) -> None:
        place = os.path.relpath(here, root)
        recorder.finding(
            "file_elsewhere",
            f"{path} is not here: {place} of the workspace is taken for it",
            asking_place(),
            object_name=path,
        )

    root, top = project.root, project.top
    folders = {**workspace.installed, root.name: root, **workspace.packages}
    return MovedFiles(folders, top, found, (script.parent, root, top))


@contextlib.contextmanager
def _files(request: RunRequest, recorder: Recorder) -> Iterator[Overlay | None]:
    """Redirect writes of a contained controller; report once what it is refused."""
    if request.written is None:
        yield None
        return
    reported: set[tuple[str, str]] = set()

    def denied(verb: str, what: str) -> None:
        if (verb, what) in reported or len(reported) >= _MOST_DENIED:
            return
        reported.add((verb, what))
        advice = "nothing leaves the process of a run"
        if verb == "read":
            advice = f'readable = ["{what}"] in [tool.tracerisk] allows it'
        recorder.finding(
            "denied", f"{what} was not {verb}: the run is contained; {advice}", object_name=what
        )

    def absent_home(home: str) -> None:
        recorder.finding(
            "file_elsewhere",
            f"{home} is not here: what is written below it goes into a folder of the run",
            asking_place(),
            object_name=home,
        )

    overlay = Overlay(request.written, request.writable, denied, absent_home)
    with overlay.active():
        yield overlay


def _refuse(recorder: Recorder, error: TraceRiskError) -> None:
    """Note why a run could not begin."""
    place = error.location
    recorder.note(
        "failed",
        error=type(error).__name__,
        message=error.message,
        location=None if place is None else [place.file, place.line, place.column],
    )


class _Metered:
    """The twin as the scheduler's world, with the wall time that its steps take [s]."""

    def __init__(self, twin: Twin, wall_clock: Callable[[], float]) -> None:
        self._twin = twin
        self._wall_clock = wall_clock
        self.seconds = 0.0
        self.time_passed: list[Callable[[], None]] = []

    @property
    def time_ns(self) -> int:
        return self._twin.time_ns

    @property
    def busy(self) -> bool:
        return self._twin.busy

    def advance(self, until_ns: int) -> int:
        began = self._wall_clock()
        try:
            reached_ns = self._twin.advance(until_ns)
        finally:
            self.seconds += self._wall_clock() - began
        for notify in self.time_passed:
            notify()
        return reached_ns


if __name__ == "__main__":
    try:
        code = main()
    except TraceRiskError as problem:
        print(problem, file=sys.stderr)  # noqa: T201 - it has no other mouth
        code = int(problem.exit_code)
    except MemoryError:
        code = int(ExitCode.CONTROLLER_FAILED)
    sys.stdout.flush()
    sys.exit(code)
