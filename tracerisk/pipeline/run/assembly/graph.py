"""The ROS graph of a run: what twin, scenario and drivers serve to the controller."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from tracerisk.common.sandbox.files.noted_reads import NotedReads
from tracerisk.common.settings.python_here import foreign_folders
from tracerisk.common.worlds.world import NOMINAL, world_named
from tracerisk.errors import Location
from tracerisk.instrument.recorder import Recorder
from tracerisk.instrument.source.definitions.used_interfaces import used_definitions
from tracerisk.instrument.source.python_source import parsed
from tracerisk.instrument.source.ros_version import RosVersion
from tracerisk.pipeline.launch.left_open import filled
from tracerisk.pipeline.launch_files.records import NOTHING_LAUNCHED
from tracerisk.pipeline.mission.asked_calls import AskedCalls
from tracerisk.pipeline.run.assembly.world import SimulatedWorld
from tracerisk.pipeline.run.companions.companion_run import Companions
from tracerisk.pipeline.run.missing_modules import program_files
from tracerisk.pipeline.trace.run_files import DISTRO, GIVEN, RunRequest
from tracerisk.pipeline.workspace.own_modules import source_bytes
from tracerisk.pipeline.workspace.prefixes import readable_of, with_interfaces
from tracerisk.pipeline.workspace.project import Project
from tracerisk.pipeline.workspace.workspace import Workspace
from tracerisk.ros.distributions.in_run import DistroRules
from tracerisk.ros.graph.graph import Graph
from tracerisk.ros.graph.parameter_files import read_parameters
from tracerisk.ros.graph.runtime import Runtime
from tracerisk.ros.messages.interface_texts import ENDINGS, InterfaceText
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.messages.ros2 import Interfaces2
from tracerisk.ros.robot.frames import TwinFrames
from tracerisk.ros.robot.state_topics import TwinTopics
from tracerisk.ros.robot.streams.command_topics import JOINT_STATE_TYPE
from tracerisk.ros.scenario.cell_log import CellLog
from tracerisk.ros.scenario.scenario import Scenario
from tracerisk.ros.scenario.world import ScenarioWorld
from tracerisk.ros.twin_interfaces import TwinInterfaces
from tracerisk.ros.vendors.description import Driver
from tracerisk.ros.vendors.description_reader import driver_of
from tracerisk.ros.vendors.driver_search import definitions_of, read_drivers, shipped_drivers
from tracerisk.ros.vendors.serving import serve_vendors
from tracerisk.ros.world.connecting import ConnectionTimes
from tracerisk.ros.world.state_reads import StateReads


@dataclass(frozen=True, slots=True)
class ServedGraph:
    """The graph as the controller finds it, and who serves it."""

    ros: RosVersion
    """The version of ROS that the controller is written for."""
    workspace: Workspace
    """The packages around the controller."""
    runtime: Runtime
    """The parts of the run that the client libraries use, the graph among them."""
    interfaces: Interfaces | Interfaces2
    """The messages, services and actions that are defined."""
    drivers: tuple[Driver, ...]
    """The drivers that are described: those that users gave, then the shipped ones."""
    reads: NotedReads
    """Which files of installed packages, which data, and which code besides, were read."""
    state_reads: StateReads | None
    """Where joint states are read by index; `None` where the world sends them in order."""
    scenario: ScenarioWorld
    """What the scenario sends and answers."""
    companions: Companions
    """The nodes of the workspace that run beside the controller."""
    cell: CellLog
    """What the controller asks of its cell."""


def build_graph(request: RunRequest, project: Project, world: SimulatedWorld) -> ServedGraph:
    """Build the graph of a request, and serve all that its controller can ask for."""
    recorder, scenario = world.recorder, world.scenario
    packages = {name: Path(folder) for name, folder in request.packages.items()}
    workspace = Workspace(packages, request.prefixes)
    runtime = _runtime_of(request, world, workspace)
    cell = CellLog(runtime.graph, AskedCalls(recorder, world.scheduler, scenario.success).take)
    # What is served behaves otherwise where companions may ask for it.
    companions = Companions(request.companions, runtime, recorder)
    _note_given(recorder, scenario)
    ros = project.ros_version(Path(request.controller))
    drivers, more = _drivers_of(request, scenario)
    reads = _reads_of(request, project, workspace)
    own, installed = workspace.interfaces, with_interfaces(runtime.installed)
    interfaces = (
        Interfaces2(own, more, runtime.distro, installed, reads.add)
        if ros == 2
        else Interfaces(own, more, installed, reads.add)
    )
    _define_from_use(Path(request.controller), ros, scenario, interfaces)
    _serve_twin(runtime, interfaces, drivers)
    state_reads = (
        StateReads(interfaces.message(JOINT_STATE_TYPE))
        if world_named(request.world).joint_order != NOMINAL.joint_order
        else None
    )
    served = ScenarioWorld(runtime, interfaces, scenario)
    return ServedGraph(
        ros,
        workspace,
        runtime,
        interfaces,
        (*drivers, *shipped_drivers()),
        reads,
        state_reads,
        served,
        companions,
        cell,
    )


def _define_from_use(
    script: Path, ros: RosVersion, scenario: Scenario, interfaces: Interfaces | Interfaces2
) -> None:
    """Define what the program uses of packages that the scenario names and nobody has."""
    absent = [name for name, _ in scenario.modules if name not in interfaces.packages]
    if not absent:
        return
    trees = [tree for path in program_files(script) if (tree := parsed(source_bytes(path)))]

    def known_names(package: str, kind: str) -> Sequence[str]:
        is_known = package in interfaces.packages and kind in interfaces.kinds
        return interfaces.module_names(package, kind) if is_known else ()

    interfaces.also(
        InterfaceText(name, kind, stem, text)
        for name in absent
        for (kind, stem), text in used_definitions(
            trees, name, known_names, is_ros1=ros == 1
        ).items()
    )


def _reads_of(request: RunRequest, project: Project, workspace: Workspace) -> NotedReads:
    """Return what notes the files of installed packages, data that may be read, and code."""
    own = (Path(request.root), project.top, Path(request.controller).parent)
    readable = map(Path, request.readable)
    left = [name for name in (request.folder, request.written) if name is not None]
    return NotedReads(
        readable_of(workspace.prefixes),
        ENDINGS,
        data=(*own, *workspace.packages.values(), *readable),
        apart=(*foreign_folders(), *map(Path, left)),
    )


def _runtime_of(request: RunRequest, world: SimulatedWorld, workspace: Workspace) -> Runtime:
    """Return the runtime of a request, with the parameters that are given for the controller."""
    recorder, scheduler, tracer = world.recorder, world.scheduler, world.tracer
    launch = request.launch or NOTHING_LAUNCHED
    distro = _distro_of(request, recorder)
    # In a live run real ROS connects the ends.
    times = ConnectionTimes.of(distro) if request.live_speed is None else ConnectionTimes()
    return Runtime(
        scheduler,
        Graph(scheduler, tracer, world=world_named(request.world), times=times),
        twin=world.twin,
        tracer=tracer,
        recorder=recorder,
        argv=(str(Path(request.controller)), *request.argv),
        seed=request.seed,
        parameters=(
            *filled(
                launch.parameters,
                world.twin.robot.name,
                lambda name, words: recorder.finding("answer_assumed", words, object_name=name),
            ),
            *world.scenario.parameters,
            *(value for file in request.params for value in read_parameters(Path(file))),
        ),
        packages=workspace.packages,
        installed=workspace.installed,
        distro=distro,
        moveit_release=request.moveit_release,
    )


def _distro_of(request: RunRequest, recorder: Recorder) -> DistroRules:
    """Return the rules of the distribution; where it is assumed, what they decide is recorded."""
    if not request.distro.is_assumed:
        return DistroRules(request.distro.name)
    recorder.note(DISTRO, line=request.distro.assumption)

    def report(words: str, location: Location | None, rule: str) -> None:
        recorder.finding("distro_assumed", words, location, object_name=rule)

    return DistroRules(
        request.distro.name,
        report,
        precedes_noetic=request.distro.precedes_noetic,
        follows_jazzy=request.distro.follows_jazzy,
    )


def _note_given(recorder: Recorder, scenario: Scenario) -> None:
    """Note what a scenario gives, for whoever judges the run."""
    recorder.note(
        GIVEN,
        bodies=[body.string("name") for body in scenario.objects],
        objects=[
            body.string("name")
            for body in scenario.objects
            if body.boolean("graspable", default="mass" in body)
        ],
        accept=[asdict(accepted) for accepted in scenario.accept],
        unconfirmed=[asdict(entry) for entry in scenario.unconfirmed],
        modules=[name for name, _ in scenario.modules],
    )


def _drivers_of(
    request: RunRequest, scenario: Scenario
) -> tuple[tuple[Driver, ...], tuple[InterfaceText, ...]]:
    """Return the drivers of scenario and request, and the messages that they and ours define."""
    described = (driver_of(entry, scenario.file) for entry in scenario.drivers)
    drivers = (*described, *read_drivers(map(Path, request.drivers), Path(request.root)))
    return drivers, definitions_of((*shipped_drivers(), *drivers))


def _serve_twin(
    runtime: Runtime, interfaces: Interfaces | Interfaces2, drivers: Sequence[Driver]
) -> None:
    """Serve what the twin serves, and what makers' drivers and the given ones do."""
    TwinTopics(runtime, interfaces)
    serve_vendors(runtime, TwinInterfaces(runtime, interfaces), drivers)
    frames = TwinFrames(runtime, interfaces)
    for driver in (*drivers, *shipped_drivers()):
        frames.also(driver.frames)
