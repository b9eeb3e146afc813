"""What the columns of a simulation's samples mean."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tracerisk.common.geometry.shapes import is_round
from tracerisk.twin.physics.motion import STEP_NS
from tracerisk.twin.physics.scene import Scene
from tracerisk.twin.recording.samples import SampleHeader
from tracerisk.twin.robots.robot import Robot


def sample_header(
    robot: Robot, scene: Scene, model: Any, actuator: Mapping[str, int]
) -> SampleHeader:
    """Return the header of a robot in its scene.

    `model` is MuJoCo's model of both, and `actuator` has the column of the controls of each arm
    joint and gripper.
    """
    return SampleHeader(
        robot=robot.name,
        scene=scene.name,
        step_ns=STEP_NS,
        controls=tuple(sorted(actuator, key=actuator.__getitem__)),
        joints=tuple(joint.name for joint in robot.joints),
        pads=tuple(pad for gripper in robot.grippers for pad in gripper.pads),
        n_pose=int(model.nq),
        free_bodies=tuple(thing.name for thing in scene.objects),
        free_at=tuple(
            int(model.jnt_qposadr[model.body(thing.name).jntadr[0]]) for thing in scene.objects
        ),
        round_bodies=tuple(
            thing.name for thing in scene.objects if all(map(is_round, thing.shapes))
        ),
        balls=tuple(
            thing.name
            for thing in scene.objects
            if all(shape.kind == "sphere" for shape in thing.shapes)
        ),
        base_xyz=scene.robot_xyz,
        base_rpy=scene.robot_rpy,
    )
