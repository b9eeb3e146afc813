"""The activity of whole programs, beside what was commanded and what inverse dynamics need."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from activity_programs import PROGRAMS, Bench, Program, fly, line
from activity_truth import FAR_ENOUGH, score

from tracerisk.common.geometry.shapes import Shape
from tracerisk.twin.physics.scene import GraspableObject, load_scene
from tracerisk.twin.recording.activity import element_activity
from tracerisk.twin.recording.samples import SampleWriter, read_samples
from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.simulation.twin import Twin


@pytest.mark.parametrize("program", PROGRAMS, ids=lambda program: program.name)
def test_what_is_found_is_what_was_commanded(program: Program):
    found = score(program)
    assert found.is_good, found


def seconds_moving(robot: Robot, folder: Path, by: dict[str, float], duration_s: float) -> dict:
    twin = Twin.build(robot, load_scene("empty"), samples=SampleWriter(folder))
    bench = Bench(robot, twin)
    bench.rest(0.5)
    bench.move(by, duration_s)
    bench.rest(0.5)
    twin.close()
    samples = read_samples(folder)
    found = element_activity(samples, robot)
    return {name: np.count_nonzero(each.moving) * samples.step_s for name, each in found.items()}


def test_a_rated_speed_that_is_far_too_high_hides_no_motion(panda: Robot, tmp_path: Path):
    # The joint 6 of a public OpenArm has 20.9 rad/s in its URDF.
    joints = tuple(
        replace(joint, velocity_limit=20.9) if joint.name == "panda_joint6" else joint
        for joint in panda.joints
    )
    moving = seconds_moving(replace(panda, joints=joints), tmp_path, {"panda_joint6": 0.2}, 2.0)
    assert moving.pop("panda_joint6") == pytest.approx(2.0, abs=0.02)
    assert set(moving.values()) == {0.0}


@pytest.mark.parametrize(("times", "expected"), [(0.9, 0.0), (1.2, 4.0)])
def test_a_joint_moves_from_1_mrad_on(panda: Robot, tmp_path: Path, times: float, expected: float):
    moving = seconds_moving(panda, tmp_path, {"panda_joint1": times * FAR_ENOUGH}, 4.0)
    assert moving["panda_joint1"] == pytest.approx(expected, abs=0.05)


def test_a_closed_hand_that_is_pressed_on_a_loose_box_grasps_nothing(panda: Robot, tmp_path: Path):
    flat = (0.0, 0.0, 0.0)
    shape = Shape("box", (0.05, 0.05, 0.03))
    box = GraspableObject("box", (0.5, 0.0, 0.03), flat, 0.3, 0.3, (shape,))
    scene = replace(load_scene("tube_racks"), objects=(box,))
    twin = Twin.build(panda, scene, samples=SampleWriter(tmp_path))
    bench = Bench(panda, twin)
    fly(bench, 0.5, 0.0, 0.12)
    bench.gripper("panda_hand", 0.0)
    # The pads end 8 mm below the tool centre point.
    line(bench, 0.06 + 0.006)
    bench.rest(1.0)
    twin.close()
    samples = read_samples(tmp_path)
    assert samples.pad_force[-1].min() > 5.0
    assert not element_activity(samples, panda)["panda_hand"].grasping.any()
