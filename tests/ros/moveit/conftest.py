import textwrap
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from tests.ran import Ran
from tracerisk.instrument.recorder import Recorder
from tracerisk.instrument.recording import read_recording
from tracerisk.instrument.tracer import Tracer
from tracerisk.ros.distributions.in_run import DistroRules
from tracerisk.ros.graph.graph import Graph
from tracerisk.ros.graph.runtime import Runtime, activate
from tracerisk.ros.imports.finder import StandInFinder
from tracerisk.ros.time.scheduler import Scheduler
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.robots.robot import Robot, load_robot
from tracerisk.twin.simulation.twin import Twin

SECOND = 1_000_000_000
PREAMBLE = """\
import copy, math, rospy, sys
import geometry_msgs.msg, moveit_commander, moveit_msgs.msg, sensor_msgs.msg
from moveit_commander import MoveGroupCommander, MoveItCommanderException
"""


@pytest.fixture(scope="session")
def panda() -> Robot:
    return load_robot("panda")


@pytest.fixture
def cell(panda: Robot) -> tuple[Robot, str]:
    """Return the robot of the program and its scene; a module may have its own."""
    return panda, "tube_racks"


@pytest.fixture
def run(cell: tuple[Robot, str], tmp_path: Path) -> Iterator[Callable[[str], Ran]]:
    """Run a program of moveit_commander on the robot in virtual time; at full speed.

    That it is for Noetic is assumed, unless `is_known`. `moveit` is the version of the
    moveit_commander in its workspace.
    """
    with _runs(*cell, tmp_path) as run_program:
        yield run_program


@pytest.fixture(scope="module")
def outcomes_of(
    panda: Robot, tmp_path_factory: pytest.TempPathFactory
) -> Callable[[str, Iterable[str]], dict[str, Any]]:
    """Run a program that ends with the name `outcome_of` of a function, and ask it of each call.

    All calls are made in one run, one after the other, and what came of each is returned by it.
    """

    def run_calls(program: str, calls: Iterable[str]) -> dict[str, Any]:
        asked = "".join(f"outcomes[{each!r}] = outcome_of(lambda: {each})\n" for each in calls)
        with _runs(panda, "tube_racks", tmp_path_factory.mktemp("calls")) as run_program:
            ran = run_program(f"{program}\noutcomes = {{}}\n{asked}")
            found: dict[str, Any] = ran["outcomes"]
            return found

    return run_calls


@contextmanager
def _runs(robot: Robot, scene: str, folder: Path) -> Iterator[Callable[..., Ran]]:
    twin = Twin.build(robot, load_scene(scene))
    tracer = Tracer()
    scheduler = Scheduler(twin, duration_ns=100 * SECOND, tracer=tracer)
    events = folder / "events.jsonl"
    with events.open("wb", buffering=0) as stream, StandInFinder():
        recorder = Recorder(stream, clock=lambda: scheduler.now_ns)
        graph = Graph(scheduler, tracer)

        def run_program(program: str, *, is_known: bool = False, moveit: str = "") -> Ran:
            rules = DistroRules("noetic", None if is_known else lambda *_: None)
            packages = {}
            if moveit:
                packages["moveit_commander"] = folder / "moveit_commander"
                packages["moveit_commander"].mkdir(exist_ok=True)
                manifest = packages["moveit_commander"] / "package.xml"
                manifest.write_text(f"<package><version>{moveit}</version></package>")
            runtime = Runtime(
                scheduler, graph, twin, tracer, recorder, distro=rules, packages=packages
            )
            source = PREAMBLE + textwrap.dedent(program)
            code = compile(source, str(folder / "program.py"), "exec")
            names: dict[str, Any] = {"__name__": "__main__"}
            with activate(runtime):
                scheduler.run_main(lambda: tracer.run_module(code, names, "program.py"))
            return Ran(names, read_recording(events), twin)

        yield run_program
