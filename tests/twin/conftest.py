"""One run of the whole errand, which many tests look at from different sides."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from tracerisk.trace import ObjectOffset
from tracerisk.twin.motion.execution import Motion
from tracerisk.twin.physics.motion import JointTrajectory, Pose
from tracerisk.twin.physics.scene import Scene, load_scene
from tracerisk.twin.recording.samples import Samples, SampleWriter, read_samples
from tracerisk.twin.robots.robot import Robot, load_robot
from tracerisk.twin.robots.robot_parts import Scaling
from tracerisk.twin.simulation.twin import Twin

DOWN = (1.0, 0.0, 0.0, 0.0)
SCALING = 0.4
GRASP_Z, RELEASE_Z, TRAVEL_Z = 0.085, 0.087, 0.235
FOREVER_NS = 10**12


class Operator:
    """Drives a twin as a controller would, one motion after the other."""

    def __init__(self, twin: Twin) -> None:
        self.twin = twin
        self.spans: list[tuple[str, int, int]] = []

    def wait(self, motion: Motion) -> Motion:
        while motion.outcome == "active":
            self.twin.advance(FOREVER_NS)
        assert motion.outcome == "succeeded", motion.message
        return motion

    def follow(self, trajectory: JointTrajectory) -> Motion:
        return self.wait(self.twin.follow(trajectory))

    def state(self, name: str) -> Motion:
        target = self.twin.robot.named_states["panda_arm"][name]
        return self.follow(
            self.twin.plan_joints("panda_arm", target, scaling=Scaling(SCALING, SCALING))
        )

    def fly(self, x: float, y: float, z: float) -> Motion:
        return self.follow(
            self.twin.plan_pose(
                "panda_manipulator",
                Pose((x, y, z), DOWN),
                scaling=Scaling(SCALING, SCALING),
            )
        )

    def line(self, x: float, y: float, z: float) -> Motion:
        trajectory, fraction = self.twin.plan_cartesian(
            "panda_manipulator",
            [Pose((x, y, z), DOWN)],
            scaling=Scaling(SCALING, SCALING),
        )
        assert fraction == 1.0
        return self.follow(trajectory)

    def fingers(self, position: float) -> Motion:
        return self.wait(self.twin.move_gripper("panda_hand", position))

    def move_tube(self, slot: int) -> None:
        x = 0.30 + 0.04 * (slot - 1)
        acts = [
            ("init", lambda: (self.state("ready"), self.fingers(0.035))),
            ("pick_position", lambda: self.fly(x, 0.2, TRAVEL_Z)),
            (
                "pick",
                lambda: (
                    self.line(x, 0.2, GRASP_Z),
                    self.fingers(0.0),
                    self.line(x, 0.2, TRAVEL_Z),
                ),
            ),
            (
                "place_position",
                lambda: (self.fly(x, -0.2, TRAVEL_Z), self.line(x, -0.2, RELEASE_Z)),
            ),
            ("place", lambda: self.fingers(0.035)),
            ("retreat", lambda: self.line(x, -0.2, TRAVEL_Z)),
        ]
        for name, act in acts:
            begin = self.twin.time_ns
            act()
            self.spans.append((name, begin, self.twin.time_ns))


@dataclass(frozen=True)
class Errand:
    robot: Robot
    scene: Scene
    samples: Samples
    directory: Path
    offsets: tuple[ObjectOffset, ...]
    spans: list[tuple[str, int, int]]
    time_ns: int


def _run_errand(robot: Robot, scene: Scene, directory: Path, slots: range) -> Errand:
    twin = Twin.build(robot, scene, samples=SampleWriter(directory))
    operator = Operator(twin)
    for slot in slots:
        operator.move_tube(slot)
    twin.close()
    return Errand(
        robot,
        scene,
        read_samples(directory),
        directory,
        twin.object_offsets(),
        operator.spans,
        twin.time_ns,
    )


@pytest.fixture(scope="session")
def panda() -> Robot:
    return load_robot("panda")


@pytest.fixture(scope="session")
def tube_racks() -> Scene:
    return load_scene("tube_racks")


@pytest.fixture(scope="session", params=[4, pytest.param(10, marks=pytest.mark.slow)])
def tubes(request: pytest.FixtureRequest) -> int:
    """How many tubes are carried: as few as show the law, and in a slow test all."""
    return request.param


@pytest.fixture(scope="session")
def errand(
    tubes: int, panda: Robot, tube_racks: Scene, tmp_path_factory: pytest.TempPathFactory
) -> Errand:
    folder = tmp_path_factory.mktemp("errand")
    return _run_errand(panda, tube_racks, folder, range(1, tubes + 1))


@pytest.fixture(scope="session")
def one_tube(panda: Robot, tube_racks: Scene, tmp_path_factory: pytest.TempPathFactory) -> Errand:
    """The errand with the first tube alone."""
    return _run_errand(panda, tube_racks, tmp_path_factory.mktemp("one_tube"), range(1, 2))


@pytest.fixture(scope="session")
def run_errand() -> Callable[[Robot, Scene, Path, range], Errand]:
    return _run_errand


@pytest.fixture
def twin(panda: Robot, tube_racks: Scene) -> Iterator[Twin]:
    twin = Twin.build(panda, tube_racks)
    yield twin
    twin.close()


@pytest.fixture
def operator(twin: Twin) -> Operator:
    return Operator(twin)
