import textwrap
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

# The process of a run has it before time is simulated: what it imports of `time` is real.
import tracerisk.common.sandbox.limited_process  # noqa: F401
from tests.ran import Ran
from tracerisk.config import RosDistro
from tracerisk.ros.distributions.in_run import DistroRules
from tracerisk.ros.graph.graph import Graph
from tracerisk.ros.graph.runtime import Runtime, activate
from tracerisk.ros.imports.finder import StandInFinder
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.messages.ros2 import Interfaces2
from tracerisk.ros.time.baton import Baton, ThreadBaton
from tracerisk.ros.time.greenlet_baton import GreenletBaton
from tracerisk.ros.time.patches import virtual_time
from tracerisk.ros.time.scheduler import Scheduler

SECOND = 1_000_000_000
ON_BOTH = ("test_actionlib", "test_patches_asyncio", "test_patches_threads", "test_virtual_time")
"""The files whose tests run on threads and on greenlets."""


class ClockWorld:
    """A world in which nothing is but time, and motions that end at given times."""

    step_ns = 2_000_000

    def __init__(self) -> None:
        self.time_ns = 0
        self.motion_ends: list[int] = []

    @property
    def busy(self) -> bool:
        return bool(self.motion_ends)

    def move(self, duration_s: float) -> None:
        self.motion_ends.append(self.time_ns + round(duration_s * SECOND))

    def advance(self, until_ns: int) -> int:
        while self.time_ns < until_ns:
            self.time_ns += self.step_ns
            ended = [end for end in self.motion_ends if end <= self.time_ns]
            if ended:
                self.motion_ends = [end for end in self.motion_ends if end not in ended]
                break
        return self.time_ns


@pytest.fixture
def world() -> ClockWorld:
    return ClockWorld()


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    file = metafunc.module.__name__.rpartition(".")[2]
    if file in ON_BOTH and "baton" in metafunc.fixturenames:
        metafunc.parametrize("baton", [ThreadBaton, GreenletBaton], indirect=True)


@pytest.fixture
def baton(request: pytest.FixtureRequest) -> Baton:
    """What the controller's threads are made of: real threads, where a file does not say."""
    made: Baton = getattr(request, "param", ThreadBaton)()
    return made


@pytest.fixture
def scheduler(world: ClockWorld, baton: Baton) -> Scheduler:
    return Scheduler(world, duration_ns=300 * SECOND, baton=baton)


@pytest.fixture
def run(scheduler: Scheduler) -> Callable[[Callable[[], Any]], Any]:
    """Run a function as the controller's main program, in virtual time."""

    def run_controller(main: Callable[[], Any]) -> Any:
        with virtual_time(scheduler):
            return scheduler.run_main(main)

    return run_controller


@pytest.fixture
def graph(scheduler: Scheduler) -> Graph:
    return Graph(scheduler)


@pytest.fixture
def run_node(scheduler: Scheduler, graph: Graph) -> Callable[..., Any]:
    """Run a function that imports ROS stand-ins as the controller's main program."""

    def run_controller(main: Callable[[], Any], *arguments: str) -> Any:
        runtime = Runtime(scheduler, graph, argv=("controller.py", *arguments))
        with activate(runtime), StandInFinder(), virtual_time(scheduler):
            return scheduler.run_main(main)

    return run_controller


@pytest.fixture
def run_on_twin(tmp_path: Path) -> Callable[..., Ran]:
    """Run a program of ROS 1 on the Panda, traced and in virtual time, as the command does."""
    from tests.traced_run import quiet_end, run_traced

    def run_program(program: str, *, duration_s: float = 60.0) -> Ran:
        script = tmp_path / "program.py"
        script.write_text(textwrap.dedent(program))
        return quiet_end(*run_traced(script, Interfaces(), duration_s=duration_s))

    return run_program


@pytest.fixture
def run_ros2() -> Callable[..., Any]:
    """Run a function that imports the stand-ins of ROS 2 as a controller; each run is a new one."""

    def run_controller(
        main: Callable[[], Any], *arguments: str, distro: RosDistro = "jazzy"
    ) -> Any:
        scheduler = Scheduler(ClockWorld(), duration_ns=300 * SECOND)
        rules = DistroRules(distro)
        argv = ("controller.py", *arguments)
        runtime = Runtime(scheduler, Graph(scheduler), argv=argv, distro=rules)
        interfaces = Interfaces2(rules=rules)
        with activate(runtime), StandInFinder(interfaces), virtual_time(scheduler):
            return scheduler.run_main(main)

    return run_controller
