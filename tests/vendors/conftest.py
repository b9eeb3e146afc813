from __future__ import annotations

import sys
import textwrap
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.ran import Ran
from tracerisk.instrument.loader import prepared_controller
from tracerisk.instrument.recording import Recorder, read_recording
from tracerisk.instrument.tracer import Tracer
from tracerisk.ros.graph.graph import Graph
from tracerisk.ros.graph.runtime import Runtime, activate
from tracerisk.ros.imports.finder import StandInFinder
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.messages.ros2 import Interfaces2
from tracerisk.ros.robot.state_topics import TwinTopics
from tracerisk.ros.time.patches import virtual_time
from tracerisk.ros.time.scheduler import RunOver, Scheduler
from tracerisk.ros.twin_interfaces import TwinInterfaces
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.robots.robot import load_robot
from tracerisk.twin.simulation.twin import Twin
from tracerisk.vendors.description_reader import read_driver
from tracerisk.vendors.driver_search import shipped_drivers, write_definitions
from tracerisk.vendors.serving import serve_vendors

SECOND = 1_000_000_000


class RanOnArm(Ran):
    """A program that moves a maker's arm."""

    @property
    def commands(self) -> list[str]:
        return [command.kind for command in self.recording.commands]

    def position(self, joint: str) -> float:
        state = self.twin.joint_state()
        return state.position[state.names.index(joint)]


@pytest.fixture
def run_on(tmp_path: Path) -> Callable[..., RanOnArm]:
    """Run a program of either ROS on a robot, traced and in virtual time, as the command does."""

    def run_program(
        robot_name: str,
        program: str,
        *,
        ros: int = 1,
        scene: str | None = None,
        duration_s: float = 120.0,
        driver: str | None = None,
    ) -> RanOnArm:
        script = tmp_path / "program.py"
        script.write_text(textwrap.dedent(program))
        robot = load_robot(robot_name)
        twin = Twin.build(robot, load_scene(scene or robot.default_scene))
        events = tmp_path / "events.jsonl"
        with events.open("wb", buffering=0) as stream:
            recorder = Recorder(stream, clock=lambda: scheduler.now_ns)
            tracer = Tracer(recorder.function_ran)
            scheduler = Scheduler(twin, duration_ns=round(duration_s * SECOND), tracer=tracer)
            graph = Graph(scheduler, tracer)
            runtime = Runtime(scheduler, graph, twin, tracer, recorder, argv=(str(script),))
            drivers = []
            if driver is not None:
                (tmp_path / "arm.driver.yaml").write_text(textwrap.dedent(driver))
                drivers = [read_driver(tmp_path / "arm.driver.yaml")]
            more = write_definitions([*shipped_drivers(), *drivers], tmp_path / "definitions")
            interfaces = Interfaces2(more=more) if ros == 2 else Interfaces(more=more)
            TwinTopics(runtime, interfaces)
            serve_vendors(runtime, TwinInterfaces(runtime, interfaces), drivers)
            with (
                activate(runtime),
                StandInFinder(interfaces),
                virtual_time(scheduler),
                prepared_controller(script, tracer, (), root=tmp_path) as run,
            ):
                namespace = sys.modules["__main__"].__dict__
                try:
                    scheduler.run_main(run)
                except RunOver as over:
                    if over.cause not in ("quiescent", "duration"):
                        raise
            return RanOnArm(dict(namespace), read_recording(events), twin)

    return run_program
