import textwrap
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.ran import Ran
from tests.traced_run import quiet_end, run_traced
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.messages.ros2 import Interfaces2
from tracerisk.ros.vendors.description_reader import read_driver
from tracerisk.ros.vendors.driver_search import definitions_of, shipped_drivers
from tracerisk.twin.robots.robot import load_robot

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
        drivers = []
        if driver is not None:
            (tmp_path / "arm.driver.yaml").write_text(textwrap.dedent(driver))
            drivers = [read_driver(tmp_path / "arm.driver.yaml")]
        more = definitions_of([*shipped_drivers(), *drivers])
        ran, over = run_traced(
            script,
            Interfaces2(more=more) if ros == 2 else Interfaces(more=more),
            robot=robot_name,
            scene=scene or load_robot(robot_name).default_scene,
            duration_s=duration_s,
            drivers=drivers,
        )
        return RanOnArm(**vars(quiet_end(ran, over)))

    return run_program
