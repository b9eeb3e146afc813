"""Replay the recorded controls of a run with nothing but `mj_step`.

The measure of what motion and sampling cost, and the proof that a run holds nothing hidden: the
same model, state and controls end in the same bits.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from tracerisk.errors import LogError
from tracerisk.twin.physics.builder import compile_model, place_robot
from tracerisk.twin.physics.scene import Scene
from tracerisk.twin.recording.samples import Samples
from tracerisk.twin.robots.robot import Robot

import mujoco  # isort: skip


@dataclass(frozen=True, slots=True)
class Replay:
    """The duration and the end of a replay."""

    n_steps: int
    """The number of steps that were replayed."""
    seconds: float
    """The wall time of the plain loop [s]."""
    same_end: bool
    """Whether the last pose has the same bits as the recorded one."""


def replay(samples: Samples, robot: Robot, scene: Scene) -> Replay:
    """Step the model of `robot` in `scene` under the recorded controls, in a plain loop.

    Raises LogError when the samples are of another robot or scene, of a run cut short, whose end
    is not among its poses, or of one that put bodies into the scene.
    """
    header = samples.header
    if (header.robot, header.scene) != (robot.name, scene.name):
        raise LogError(
            f"the samples are of robot '{header.robot}' in scene '{header.scene}', "
            f"not of '{robot.name}' in '{scene.name}'"
        )
    if samples.changed_at is not None:
        raise LogError(
            f"the controller put objects of its planning scene into the simulation at "
            f"{samples.changed_at * samples.step_s:.3f} s, which the samples do not hold; replay "
            "a run without planning-scene objects"
        )
    if samples.end_pose is None:
        raise LogError("the samples end without a last pose; replay a run that came to its end")
    model = compile_model(robot, scene)
    data = mujoco.MjData(model)
    place_robot(model, data, robot)
    controls = np.array(samples.control)
    began = time.perf_counter()
    for control in controls:
        data.ctrl[:] = control
        mujoco.mj_step(model, data)
    seconds = time.perf_counter() - began
    return Replay(len(controls), seconds, data.qpos.tobytes() == samples.end_pose.tobytes())
