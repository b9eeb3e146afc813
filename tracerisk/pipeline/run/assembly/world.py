"""The simulated world of a run: the twin, its scenario, and the time that passes in it."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from tracerisk.common.worlds.world import NOMINAL, world_named
from tracerisk.instrument.marks.caught_exceptions import REFUSED, CaughtFailure
from tracerisk.instrument.recorder import Recorder
from tracerisk.instrument.tracer import Tracer
from tracerisk.pipeline.mission.named_objects import check_names
from tracerisk.pipeline.trace.run_files import JOINTS_ASKED, ROBOT, RunRequest
from tracerisk.pipeline.workspace.workspace import Workspace
from tracerisk.ros.graph.declared_controllers import DeclaredControllers
from tracerisk.ros.scenario.file.scenario_reader import read_scenario
from tracerisk.ros.scenario.objects import with_objects, with_start
from tracerisk.ros.scenario.scenario import Scenario
from tracerisk.ros.time.greenlet_baton import GreenletBaton
from tracerisk.ros.time.scheduler import Scheduler
from tracerisk.ros.world.start import started_in
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.recording.samples import SampleWriter
from tracerisk.twin.robots.assumed_names import with_assumed_names
from tracerisk.twin.robots.file import read_dumped_robot
from tracerisk.twin.simulation.twin import Twin

# Bound before virtual time takes the place of the machine's.
wall_clock: Callable[[], float] = time.perf_counter


class MeteredTwin:
    """The twin as the scheduler's world, with the wall time that its steps take."""

    def __init__(self, twin: Twin) -> None:
        self._twin = twin
        self.seconds = 0.0
        """The wall time of all steps so far [s]."""
        self.time_passed: list[Callable[[], None]] = []
        """What is called whenever the world has moved."""

    @property
    def time_ns(self) -> int:
        """The simulated time [ns]."""
        return self._twin.time_ns

    @property
    def busy(self) -> bool:
        """Whether anything of the robot is under way."""
        return self._twin.busy

    def advance(self, until_ns: int) -> int:
        """Move the world, at most until then [ns], and return the time that it reached [ns]."""
        began = wall_clock()
        try:
            reached_ns = self._twin.advance(until_ns)
        finally:
            self.seconds += wall_clock() - began
        for notify in self.time_passed:
            notify()
        return reached_ns


@dataclass(frozen=True, slots=True)
class SimulatedWorld:
    """What moves while the controller waits, and what records it."""

    recorder: Recorder
    """The recorder of events, whose clock is the simulated time."""
    scenario: Scenario
    """What surrounds the controller; empty where none is given."""
    twin: Twin
    """The robot and its scene on MuJoCo."""
    metered: MeteredTwin
    """The twin as the scheduler moves it."""
    tracer: Tracer
    """The tracer of the controller's functions."""
    scheduler: Scheduler
    """The scheduler of threads and simulated time."""


def build_world(request: RunRequest, samples: SampleWriter, recorder: Recorder) -> SimulatedWorld:
    """Build the twin of a request, with its faults, and the time that passes in it."""
    twin, scenario = _twin_of(request, samples, recorder)
    for fault in request.faults:
        twin.arm(fault)
    tracer = Tracer(recorder.function_ran)
    tracer.on_source = recorder.source_compiled
    tracer.on_caught = _refusals_noted(recorder)
    metered = MeteredTwin(twin)
    scheduler = Scheduler(
        metered,
        duration_ns=round(request.duration_s * 1e9),
        tracer=tracer,
        baton=GreenletBaton() if request.greenlets else None,
    )
    recorder.clock = tracer.calls.clock = lambda: scheduler.now_ns
    return SimulatedWorld(recorder, scenario, twin, metered, tracer, scheduler)


def _twin_of(
    request: RunRequest, samples: SampleWriter, recorder: Recorder
) -> tuple[Twin, Scenario]:
    """Return the twin of a request, whose robot lies in `folder`, and its scenario."""
    robot = with_assumed_names(
        read_dumped_robot(Path(request.folder, ROBOT)),
        lambda message: recorder.finding("assumed_name", message),
        partial(_joints_of_controllers, request),
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


def _joints_of_controllers(request: RunRequest) -> Mapping[str, tuple[str, ...]]:
    """Return the joints of each controller that the workspace of a request declares."""
    packages = {name: Path(folder) for name, folder in request.packages.items()}
    declared = DeclaredControllers(Workspace(packages, request.prefixes))
    return {name: controller.joints for name, controller in declared.all.items()}


def _refusals_noted(recorder: Recorder) -> Callable[[CaughtFailure], None]:
    """Return what records the calls that stand-ins refused, each once."""
    noted: set[CaughtFailure] = set()

    def caught(failure: CaughtFailure) -> None:
        if failure not in noted:
            noted.add(failure)
            recorder.finding(REFUSED, failure.words, failure.location, object_name=failure.call)

    return caught
