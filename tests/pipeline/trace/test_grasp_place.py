"""Where a gripper closed on nothing, and what stood nearest."""

import math

import mujoco
import numpy as np
import pytest

from tracerisk.pipeline.trace.grasp_place import between_pads, grasp_place
from tracerisk.twin.physics.physics import begin_physics
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.recording.samples import SampleHeader, Samples
from tracerisk.twin.robots.robot import load_robot


@pytest.mark.parametrize(
    ("robot_name", "scene_name"),
    [("panda", "tube_racks"), ("crane_x7", "empty"), ("baxter", "pedestal"), ("so100", "empty")],
)
def test_the_middle_between_the_pads_is_where_the_twin_has_it(robot_name, scene_name):
    robot, scene = load_robot(robot_name), load_scene(scene_name)
    physics = begin_physics(robot, scene)
    draw = np.random.default_rng(1)
    at = {each.name: draw.uniform(-0.5, 0.5) for each in robot.joints}
    for name, position in at.items():
        physics.data.joint(name).qpos[0] = position
    mujoco.mj_kinematics(getattr(physics.model, "ptr", physics.model), physics.data)
    header = SampleHeader(
        robot_name,
        scene_name,
        step_ns=2_000_000,
        controls=(),
        joints=(),
        pads=(),
        n_pose=0,
        base_xyz=scene.robot_xyz,
        base_rpy=scene.robot_rpy,
    )
    for gripper in robot.grippers:
        pads = [physics.data.site(f"{pad}/pad").xpos for pad in gripper.pads]
        assert between_pads(robot, gripper, at, header) == pytest.approx(np.mean(pads, axis=0))


@pytest.mark.parametrize(("base_z", "told"), [(0.0, ""), (-0.5, ", which is below the floor")])
def test_the_words_name_the_place_the_opening_and_the_nearest_thing(base_z, told):
    robot = load_robot("panda")
    joints = [each.name for each in robot.joints]
    at = [robot.initial_state[name] for name in joints]
    header = SampleHeader(
        robot="panda",
        scene="empty",
        step_ns=2_000_000,
        controls=(),
        joints=tuple(joints),
        pads=(),
        n_pose=len(at) + 14,
        free_bodies=("cube", "ball"),
        free_at=(len(at), len(at) + 7),
        base_xyz=(0.0, 0.0, base_z),
    )
    x, y, z = between_pads(robot, robot.grippers[0], robot.initial_state, header)
    thing = [1.0, 0.0, 0.0, 0.0]
    pose = [*at, x + 0.03, y, z + 0.04, *thing, x - 1.0, y, z, *thing]
    fingers = np.array(["finger" in name for name in joints])
    positions = np.array([at, np.where(fingers, 0.01, at), np.where(fingers, 0.0, at)])
    none = np.empty((len(positions), 0))
    samples = Samples(header, none, positions, none, none, none, np.array([pose]))
    step = header.step_ns
    words = grasp_place(robot, robot.grippers[0], samples, 0, step)
    assert abs(y) < 1e-6, "it would be shown with a sign"
    where = f"at ({x:.3f}, 0.000, {z:.3f}) m{told}"
    nearest = "0.050 m from the origin of cube, the nearest object"
    assert words == f"{where}, its pads 20 mm apart in the end, {nearest}"
    shut = grasp_place(robot, robot.grippers[0], samples, 0, 2 * step)
    assert shut == grasp_place(robot, robot.grippers[0], samples, 0) == f"{where}, {nearest}"
    assert math.dist((x, y, z), pose[len(at) : len(at) + 3]) == pytest.approx(0.05)
    assert grasp_place(robot, robot.grippers[0], samples, 10**9) == ""
