"""Time that passes without physics while everything is at rest."""

import numpy as np
import pytest

from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.recording.samples import SampleWriter, read_samples
from tracerisk.twin.robots.robot import load_robot
from tracerisk.twin.simulation import simulation
from tracerisk.twin.simulation.twin import Twin

SECOND = 1_000_000_000


def moved(folder, *, passes_over):
    """Turn a joint, rest for two seconds, turn it back; return the samples."""
    folder.mkdir()
    with SampleWriter(folder) as writer:
        twin = Twin.build(load_robot("panda"), load_scene("empty"), samples=writer)
        if passes_over:
            twin.pass_over_rest()
        for turn in (0.3, 0.0):
            twin.follow(twin.plan_joints("panda_arm", {"panda_joint1": turn}))
            while twin.busy:
                twin.advance(twin.time_ns + SECOND)
            twin.advance(twin.time_ns + 2 * SECOND)
        twin.close()
    return read_samples(folder)


def test_what_rests_stays_where_it_is_and_moves_on_as_ever(tmp_path, monkeypatch):
    steps = []
    real = simulation._stand
    monkeypatch.setattr(
        simulation, "_stand", lambda model, data: (steps.append(1), real(model, data))
    )
    whole = moved(tmp_path / "whole", passes_over=False)
    assert steps == []
    short = moved(tmp_path / "short", passes_over=True)
    assert len(steps) > 1000
    assert short.n_steps == whole.n_steps
    assert short.position == pytest.approx(whole.position, abs=1e-4)
    assert np.abs(short.torque - whole.torque).max() < 0.1
