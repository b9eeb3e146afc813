from __future__ import annotations

import sys
import textwrap
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import pytest

from tests.ran import Ran
from tracerisk.instrument.loader import prepared_controller
from tracerisk.instrument.recording import Recorder, read_recording
from tracerisk.instrument.tracer import Tracer
from tracerisk.ros.graph.graph import Graph
from tracerisk.ros.graph.runtime import Runtime, activate
from tracerisk.ros.imports.finder import StandInFinder
from tracerisk.ros.messages.ros2 import Interfaces2
from tracerisk.ros.time.patches import virtual_time
from tracerisk.ros.time.scheduler import RunOver, Scheduler
from tracerisk.ros.twin_interfaces import TwinInterfaces
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.robots.robot import load_robot
from tracerisk.twin.simulation.twin import Twin
from tracerisk.vendors.serving import serve_vendors

SECOND = 1_000_000_000
PREAMBLE = """\
import copy, time
import numpy as np
from geometry_msgs.msg import Pose, PoseStamped
from moveit_msgs.msg import AttachedCollisionObject, CollisionObject, Constraints
from shape_msgs.msg import SolidPrimitive
from moveit.core.robot_state import RobotState
from moveit.planning import MoveItPy, MultiPipelinePlanRequestParameters, PlanRequestParameters
READY = [0.0, -0.7853981633974483, 0.0, -2.356194490192345, 0.0, 1.5707963267948966, 0.7853981633974483]
panda = MoveItPy()
arm = panda.get_planning_component("panda_arm")
monitor = panda.get_planning_scene_monitor()
def go(name):
    arm.set_start_state_to_current_state()
    arm.set_goal_state(configuration_name=name)
    return panda.execute(arm.plan().trajectory, controllers=[])
def box(name, position, size, frame="panda_link0"):
    made = CollisionObject(id=name, operation=CollisionObject.ADD)
    made.header.frame_id = frame
    pose = Pose()
    pose.position.x, pose.position.y, pose.position.z = position
    made.primitives.append(SolidPrimitive(type=SolidPrimitive.BOX, dimensions=list(size)))
    made.primitive_poses.append(pose)
    return made
"""
PREAMBLE_LINES = PREAMBLE.count("\n")


@dataclass
class RanAndOver(Ran):
    """How it ended, too."""

    over: RunOver | None


@pytest.fixture
def run(tmp_path: Path) -> Callable[..., RanAndOver]:
    """Run a program of MoveItPy on the Panda, traced and in virtual time, as the command does."""

    def run_program(
        program: str, packages: Mapping[str, Path] = MappingProxyType({})
    ) -> RanAndOver:
        script = tmp_path / "program.py"
        script.write_text(PREAMBLE + textwrap.dedent(program))
        robot = load_robot("panda")
        twin = Twin.build(robot, load_scene("tube_racks"))
        events = tmp_path / "events.jsonl"
        over = None
        with events.open("wb", buffering=0) as stream:
            recorder = Recorder(stream, clock=lambda: scheduler.now_ns)
            tracer = Tracer(recorder.function_ran)
            scheduler = Scheduler(twin, duration_ns=100 * SECOND, tracer=tracer)
            graph = Graph(scheduler, tracer)
            runtime = Runtime(
                scheduler, graph, twin, tracer, recorder, argv=(str(script),), packages=packages
            )
            interfaces = Interfaces2()
            serve_vendors(runtime, TwinInterfaces(runtime, interfaces))
            with (
                activate(runtime),
                StandInFinder(interfaces),
                virtual_time(scheduler),
                prepared_controller(script, tracer, (), root=tmp_path) as main,
            ):
                namespace = sys.modules["__main__"].__dict__
                try:
                    scheduler.run_main(main)
                except RunOver as ended:
                    over = ended
            return RanAndOver(dict(namespace), read_recording(events), twin, over)

    return run_program
