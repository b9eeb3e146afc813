"""Both engines compute the same physics, and the one that can be imported serves."""

import os
import subprocess
import sys

import numpy as np
import pytest

from tracerisk.twin.physics.builder import compile_model
from tracerisk.twin.physics.motion import STEP_S
from tracerisk.twin.physics.physics import (
    DmControlPhysics,
    MujocoPhysics,
    begin_physics,
    divergence,
    engine,
)
from tracerisk.twin.physics.scene import Scene
from tracerisk.twin.robots.robot import Robot

import mujoco  # isort: skip


def test_both_engines_give_the_same_state_to_the_bit(panda: Robot, tube_racks: Scene):
    pytest.importorskip("dm_control.mujoco")
    states = []
    for kind in (DmControlPhysics, MujocoPhysics):
        physics = kind(compile_model(panda, tube_racks))
        size = mujoco.mj_stateSize(physics.model, mujoco.mjtState.mjSTATE_INTEGRATION)
        for count in (0, 200):
            for _ in range(count):
                mujoco.mj_step(physics.model, physics.data)
            state = np.zeros(size)
            mujoco.mj_getState(
                physics.model, physics.data, state, mujoco.mjtState.mjSTATE_INTEGRATION
            )
            states.append(state.tobytes())
        assert physics.data.time == pytest.approx(200 * STEP_S)
    assert states[0] == states[2]
    assert states[1] == states[3]
    assert states[0] != states[1]


def test_dm_control_serves_where_it_can_be_imported(panda: Robot, tube_racks: Scene):
    pytest.importorskip("dm_control.mujoco")
    assert isinstance(begin_physics(panda, tube_racks), DmControlPhysics)
    assert engine().startswith("dm-control 1.0.")


def test_mujoco_serves_where_dm_control_cannot_be_imported(
    panda: Robot, tube_racks: Scene, monkeypatch
):
    monkeypatch.setitem(sys.modules, "dm_control.mujoco", None)
    physics = begin_physics(panda, tube_racks)
    assert isinstance(physics, MujocoPhysics)
    assert engine().startswith(("mujoco 3.", "mujoco 4."))
    assert "alone (" in engine()
    # Only the first moment is without controls.
    before = physics.model.opt.disableflags
    assert not before & int(mujoco.mjtDisableBit.mjDSBL_ACTUATION)


def test_a_state_that_diverged_is_unstable(panda: Robot, tube_racks: Scene):
    physics = begin_physics(panda, tube_racks)
    assert not divergence(physics.data).any()
    physics.data.qvel[:] = np.nan
    mujoco.mj_step(physics.model, physics.data)
    assert divergence(physics.data).any()


def test_what_a_process_starts_later_finds_no_backend_that_nobody_has_named():
    """Importing MuJoCo without a display changes the environment for that time only."""
    program = (
        "import os; before = dict(os.environ)\n"
        "from tracerisk.twin.physics.physics import engine\n"
        "print(engine(), before == dict(os.environ))"
    )
    environment = {name: text for name, text in os.environ.items() if name != "MUJOCO_GL"}
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, env=environment, check=True
    )
    assert done.stdout.endswith(" True\n"), done.stdout
