"""Run a program of a test on the twin, traced and in virtual time, as the command does."""

import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

from tests.ran import Ran
from tracerisk.config import RosDistro
from tracerisk.instrument.loader import prepared_controller
from tracerisk.instrument.recorder import Recorder
from tracerisk.instrument.recording import read_recording
from tracerisk.instrument.tracer import Tracer
from tracerisk.ros.distributions.in_run import DistroRules
from tracerisk.ros.graph.graph import Graph
from tracerisk.ros.graph.runtime import Runtime, activate
from tracerisk.ros.imports.finder import StandInFinder
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.readings.stale_messages import StaleMessages
from tracerisk.ros.robot.frames import TwinFrames
from tracerisk.ros.robot.state_topics import TwinTopics
from tracerisk.ros.time.patches import virtual_time
from tracerisk.ros.time.scheduler import RunOver, Scheduler
from tracerisk.ros.twin_interfaces import TwinInterfaces
from tracerisk.ros.vendors.serving import serve_vendors
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.robots.robot import load_robot
from tracerisk.twin.simulation.twin import Twin


def run_traced(
    script: Path,
    interfaces: Any,
    *,
    robot: str = "panda",
    scene: str = "tube_racks",
    duration_s: float,
    drivers: Sequence[Any] = (),
    packages: Mapping[str, Path] = MappingProxyType({}),
    has_topics: bool = True,
    has_frames: bool = False,
    distro: RosDistro | None = None,
    on_decided: Callable[..., None] = lambda *_: None,
) -> tuple[Ran, RunOver | None]:
    """What the script left, and how the run was over where the script did not end by itself.

    Without `distro` it is assumed to follow noetic or jazzy, by the ROS that `interfaces` is of;
    `on_decided` is then called where a rule that differs decided something.
    """
    follows = distro or ("noetic" if isinstance(interfaces, Interfaces) else "jazzy")
    twin = Twin.build(load_robot(robot), load_scene(scene))
    events = script.with_name("events.jsonl")
    over = None
    with events.open("wb", buffering=0) as stream:
        recorder = Recorder(stream, clock=lambda: scheduler.now_ns)
        tracer = Tracer(recorder.function_ran)
        scheduler = Scheduler(twin, duration_ns=round(duration_s * 1e9), tracer=tracer)
        graph = Graph(scheduler, tracer)
        runtime = Runtime(
            scheduler,
            graph,
            twin,
            tracer,
            recorder,
            argv=(str(script),),
            packages=packages,
            distro=DistroRules(follows, None if distro else on_decided),
        )
        if has_topics:
            TwinTopics(runtime, interfaces)
        if has_frames:
            TwinFrames(runtime, interfaces)
        serve_vendors(runtime, TwinInterfaces(runtime, interfaces), drivers)
        with (
            activate(runtime),
            StandInFinder(interfaces),
            virtual_time(scheduler),
            prepared_controller(script, tracer, (), root=script.parent) as run,
        ):
            namespace = sys.modules["__main__"].__dict__
            try:
                scheduler.run_main(run)
            except RunOver as ended:
                over = ended
            runtime.client(StaleMessages).report()
        return Ran(dict(namespace), read_recording(events), twin), over


def quiet_end(ran: Ran, over: RunOver | None) -> Ran:
    """What was left; raises the end of a run that went wrong."""
    if over is not None and over.cause not in ("quiescent", "duration"):
        raise over
    return ran
