from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from tracerisk.ros.finder import StandInFinder
from tracerisk.ros.graph import Graph
from tracerisk.ros.patches import virtual_time
from tracerisk.ros.runtime import Runtime, activate
from tracerisk.ros.virtual_time import Scheduler

SECOND = 1_000_000_000


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


@pytest.fixture
def scheduler(world: ClockWorld) -> Scheduler:
    return Scheduler(world, duration_ns=300 * SECOND)


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
