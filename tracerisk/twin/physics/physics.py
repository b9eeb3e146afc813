"""The engine that computes the twin's physics: dm-control's `Physics`, or MuJoCo alone.

dm-control needs labmaze, which has no wheel for Python 3.13 and later; with
`pip install --no-deps dm-control` it serves there too.
Both engines step the same MuJoCo model in C and give the same numbers to the last bit.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from tracerisk.twin.physics.builder import compile_model, place_robot
from tracerisk.twin.physics.no_display import no_display
from tracerisk.twin.physics.scene import Scene
from tracerisk.twin.robots.robot import Robot

# After the builder, which says that no window is needed.
import mujoco  # isort: skip

_DIVERGED = slice(
    int(mujoco.mjtWarning.mjWARN_BADQPOS), int(mujoco.mjtWarning.mjWARN_BADQACC) + 1
)  # of the warnings: bad positions, velocities and accelerations


class Physics(Protocol):
    """A compiled model with its state; both are MuJoCo's own, with their access by name."""

    @property
    def model(self) -> Any:
        """The `mujoco.MjModel`."""

    @property
    def data(self) -> Any:
        """The `mujoco.MjData`: the state and all that is computed from it."""


class MujocoPhysics:
    """MuJoCo alone; begins as dm-control's `Physics` does, with the controls switched off."""

    def __init__(self, model: Any) -> None:
        self.model = model
        self.data = mujoco.MjData(model)
        flags = model.opt.disableflags
        model.opt.disableflags = flags | int(mujoco.mjtDisableBit.mjDSBL_ACTUATION)
        mujoco.mj_forward(model, self.data)
        model.opt.disableflags = flags


class DmControlPhysics:
    """dm-control's `Physics`; kept alive, for it owns the state.

    Raises ImportError where dm-control, or a module that it needs, is not installed.
    """

    def __init__(self, model: Any) -> None:
        with no_display():
            from dm_control.mujoco import Physics, wrapper

        self.physics = Physics.from_model(wrapper.MjModel(model))
        self.model = self.physics.model.ptr
        self.data = self.physics.data.ptr


def begin_physics(robot: Robot, scene: Scene) -> Physics:
    """Return the physics of a robot in its scene as a run begins, by dm-control where it serves.

    Raises RobotError with MuJoCo's reason when the model is refused.
    """
    model = compile_model(robot, scene)
    physics: Physics
    try:
        physics = DmControlPhysics(model)
    except ImportError:
        physics = MujocoPhysics(model)
    place_robot(physics.model, physics.data, robot)
    return physics


def engine() -> str:
    """Return which engine serves, with its version and why it is not the other one."""
    # Here, for a run asks no package for its version.
    from importlib import metadata

    name = f"mujoco {metadata.version('mujoco')}"
    try:
        with no_display():
            import dm_control.mujoco  # noqa: F401
    except ImportError as error:
        return f"{name} alone ({error})"
    return f"dm-control {metadata.version('dm-control')} on {name}"


def divergence(data: Any) -> NDArray[np.int32]:
    """Return how often MuJoCo has warned of positions, velocities and accelerations: a live view.

    Where any of the three is not 0, the simulation has become unstable.
    """
    counts: NDArray[np.int32] = data.warning.number[_DIVERGED]
    return counts
