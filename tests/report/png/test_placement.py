"""Bodies are where the simulation has them."""

import math

import numpy as np
import pytest

from tracerisk.common.geometry.rotation import rotated
from tracerisk.common.geometry.shapes import Shape
from tracerisk.report.html.run.replay_model import Body, scene_bodies
from tracerisk.report.png.placement import WORLD, corners, placed_bodies
from tracerisk.twin.physics.builder import compile_model
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.robots.robot import load_robot


@pytest.mark.parametrize(("robot", "scene"), [("panda", "tube_racks"), ("ur5e", "empty")])
def test_links_and_objects_are_where_mujoco_has_them(robot, scene):
    import mujoco

    arm, place = load_robot(robot), load_scene(scene)
    model = compile_model(arm, place)
    data = mujoco.MjData(model)
    random = np.random.default_rng(7)
    columns = []
    for joint in arm.joints:
        value = random.uniform(joint.lower, joint.upper)
        data.qpos[model.joint(joint.name).qposadr[0]] = value
        columns.append(value)
    for thing in place.objects:
        at = model.joint(thing.name).qposadr[0]
        turn = random.normal(size=4)
        data.qpos[at : at + 7] = [*random.normal(size=3), *turn / np.linalg.norm(turn)]
        columns += data.qpos[at : at + 7].tolist()
    mujoco.mj_kinematics(model, data)
    bodies = scene_bodies(arm, place)
    assert len(bodies) >= len(arm.links)
    for body, found in zip(bodies, placed_bodies(bodies, columns), strict=True):
        there = data.body(body.name)
        assert found.xyz == pytest.approx(there.xpos, abs=1e-9)
        # A quaternion and its negative turn alike.
        assert abs(np.dot(found.quaternion, there.xquat)) == pytest.approx(1.0, abs=1e-9)


def test_a_slide_shifts_along_its_axis_in_its_own_frame():
    quarter = (math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))
    base = Body("base", "robot", -1, (1.0, 0.0, 0.0), quarter, ())
    slide = Body("s", "robot", 0, (0.0, 0.0, 0.5), (1.0, 0.0, 0.0, 0.0), (), "slide", (1, 0, 0), 0)
    assert placed_bodies([base, slide], [0.25])[1].xyz == pytest.approx((1.0, 0.25, 0.5))
    assert rotated(quarter, (1.0, 0.0, 2.0)) == pytest.approx((0.0, 1.0, 2.0))


@pytest.mark.parametrize(
    ("kind", "size", "reach"),
    [
        ("box", (0.1, 0.2, 0.3), (0.1, 0.2, 0.3)),
        ("sphere", (0.1,), (0.1, 0.1, 0.1)),
        ("capsule", (0.1, 0.3), (0.1, 0.1, 0.4)),
        ("cylinder", (0.1, 0.3), (0.1, 0.1, 0.3)),
    ],
)
def test_corners_enclose_the_shape(kind, size, reach):
    found = list(corners(WORLD, Shape(kind, size, xyz=(1.0, 0.0, 0.0))))
    assert len(set(found)) == 8
    assert max(found) == pytest.approx((1.0 + reach[0], reach[1], reach[2]))
