"""Who watches a run: when it is over, what it lacked, and what is noted at its end."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from tracerisk.common.worlds.world import NOMINAL
from tracerisk.instrument.marks.call_log import CALLS
from tracerisk.instrument.recording import CELL
from tracerisk.pipeline.run.assembly.graph import ServedGraph
from tracerisk.pipeline.run.assembly.world import SimulatedWorld
from tracerisk.pipeline.run.branching.fate import FateWatch
from tracerisk.pipeline.run.needs.unmet_needs import UnmetNeeds
from tracerisk.pipeline.run.watching.run_watch import RunWatch
from tracerisk.pipeline.run.watching.stall_watch import StallWatch
from tracerisk.pipeline.trace.run_files import LOST_ON_THE_WAY, READ, RunRequest
from tracerisk.pipeline.workspace.needs_in_source import asked_in_file
from tracerisk.pipeline.workspace.project import Project
from tracerisk.ros.drafts.named_numbers import Units
from tracerisk.ros.drafts.usable_values import UsableValues
from tracerisk.ros.drafts.user_input.dragged_markers import ShownMarkers
from tracerisk.ros.graph.sensor_reading import SensorReading
from tracerisk.ros.moveit.move_group import MoveGroupServer
from tracerisk.ros.readings.stale_messages import StaleMessages
from tracerisk.ros.robot.commands import TwinCommands
from tracerisk.ros.vendors.description import UNITS, Driver
from tracerisk.trace import EndCause


@dataclass(frozen=True, slots=True)
class Watches:
    """Who watches one run."""

    run: RunWatch
    """Ends a run that repeats itself or only idles."""
    needs: UnmetNeeds
    """What the controller asked for in vain."""
    values: UsableValues
    """Values that the robot can use, for what is assumed or drafted."""
    fate: FateWatch | None
    """Ends a run with a failure once its fate is decided; `None` without a run beside it."""


def build_watches(
    request: RunRequest, project: Project, world: SimulatedWorld, graph: ServedGraph
) -> Watches:
    """Build who watches a run, and have the world call them."""
    twin, scheduler, recorder = world.twin, world.scheduler, world.recorder
    watch = RunWatch(
        scheduler, recorder, request.idle_s, cuts_streams=not request.is_duration_given
    )
    recorder.watch, world.tracer.on_iteration = watch, watch.looped
    world.tracer.on_turns = scheduler.count_call
    schedule = watch.schedule = graph.scenario.schedule
    values = UsableValues(
        twin.robot,
        twin.forward_kinematics,
        lambda group, pose: twin.inverse_kinematics(group, pose, avoid_collisions=True),
        alone=lambda: twin.planning_among(()),
    )
    values.units_of_packages = _units_of_packages(graph.drivers)
    values.served = _served(graph.drivers)
    values.mount = cache(lambda: graph.runtime.client(MoveGroupServer).mount_to_reach())
    values.shown_markers = graph.runtime.client(ShownMarkers).at
    needs = UnmetNeeds(
        graph.runtime,
        graph.interfaces,
        project.root,
        lambda: watch.has_commanded,
        graph.scenario.unused,
        graph.scenario.unanswered,
        values,
        script=Path(request.controller),
        in_source=lambda source: asked_in_file(source, graph.ros, project),
        drafts=request.drafts,
        shift=lambda: (
            graph.runtime.client(MoveGroupServer).shift_to_reach()
            if world.scenario.unconfirmed
            else None
        ),
    )
    fate = _fate_watch(request, world)
    stall = StallWatch(scheduler, watch, needs, lambda: schedule.is_pending)
    world.metered.time_passed = [watch.time_passed, stall.time_passed]
    return Watches(watch, needs, values, fate)


def _units_of_packages(drivers: Iterable[Driver]) -> dict[str, Units]:
    """Return the units of the messages of drivers' packages; the first driver's count."""
    units: dict[str, Units] = {}
    for driver in drivers:
        of_driver = Units(1.0 / UNITS[driver.units.angle], 1.0 / UNITS[driver.units.length])
        for package in driver.packages:
            units.setdefault(package, of_driver)
    return units


def _served(drivers: Iterable[Driver]) -> dict[tuple[str, str], list[str]]:
    """Return the names of the services and actions of drivers, by kind and type."""
    names: dict[tuple[str, str], list[str]] = {}
    for driver in drivers:
        for interface in driver.interfaces:
            for type_name in interface.types:
                key = (interface.kind.removesuffix("s"), type_name)
                names.setdefault(key, []).append(interface.name.strip("/"))
    return names


def _fate_watch(request: RunRequest, world: SimulatedWorld) -> FateWatch | None:
    """Return who ends a run whose mission has failed for certain, beside a run without faults."""
    if request.beside is None:
        return None
    twin = world.twin
    fate = FateWatch(request.beside, twin.robot, world.scheduler, twin, world.recorder)
    if request.faults:
        fate.begin(request.faults)
    return fate


def note_run_over(
    cause: EndCause,
    request: RunRequest,
    world: SimulatedWorld,
    graph: ServedGraph,
    watches: Watches,
) -> None:
    """Note what is known once a run is over, before its end is recorded."""
    recorder, runtime = world.recorder, graph.runtime
    recorder.note(CALLS, **world.tracer.executed_calls())
    runtime.client(TwinCommands).finish(cause)
    runtime.client(SensorReading).finish()
    recorder.note(CELL, **graph.cell.note())
    recorder.note(READ, files=graph.reads.files())
    carrier = runtime.graph.carrier
    for early in carrier.lost:
        recorder.finding(
            "sent_early",
            early.words(carrier.times),
            early.place,
            object_name=early.name,
            time_ns=early.time_ns,
        )
    runtime.client(StaleMessages).report()
    if request.world != NOMINAL.name:
        root = Path(request.root)
        read = [] if graph.state_reads is None else graph.state_reads.places_in(root)
        recorder.note(LOST_ON_THE_WAY, lost=[*carrier.lost_in(root), *read])
    watches.run.run_over(cause)
    if watches.fate is not None:
        watches.fate.note_end()
