"""Things that fall or tip, told from recorded poses: no simulation."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tracerisk.pipeline.trace.falls import falls
from tracerisk.twin.recording.contact_log import ROW, ContactLog, LoggedBody
from tracerisk.twin.recording.contact_pairs import Hold
from tracerisk.twin.recording.contacts import RunContacts
from tracerisk.twin.recording.samples import POSE_EVERY, SampleHeader, Samples
from tracerisk.twin.robots.robot import load_robot

N = 10


def recorded(height, tilt=None):
    """Poses of a tube: its heights [m], and the tilt of its axis about x [rad]."""
    tilt = np.zeros(N) if tilt is None else np.asarray(tilt)
    poses = np.zeros((N, 7))
    poses[:, 2], poses[:, 3], poses[:, 4] = height, np.cos(tilt / 2), np.sin(tilt / 2)
    header = SampleHeader("panda", "cell", 2_000_000, (), (), (), 7, ("tube",), (0,))
    empty = np.zeros((N * POSE_EVERY, 0))
    return Samples(header, empty, empty, empty, empty, empty, poses)


def held(*spans):
    log = ContactLog((LoggedBody("tube", "free", 0.025),), (), np.zeros(0, dtype=ROW))
    holds = tuple(Hold("hand", 0, a * POSE_EVERY, b * POSE_EVERY) for a, b in spans)
    return RunContacts(load_robot("panda"), log, (), holds, N * POSE_EVERY, 0.002)


def test_a_thing_let_go_in_the_air_fell():
    (fall,) = falls(recorded([0.0, 0.1, 0.2, 0.2, 0.2, 0.1, 0.05, 0.05, 0.05, 0.05]), held((1, 5)))
    assert (fall.object, fall.was_held, fall.is_tipped) == ("tube", True, False)
    assert fall.height_m == pytest.approx(0.15)


@pytest.mark.parametrize("down", [0.0, 0.01, 0.04])
def test_a_thing_that_is_set_down_did_not(down):
    height = [0.0, 0.1, 0.2, 0.2, 0.2, 0.2 - down, *[0.2 - down] * 4]
    assert falls(recorded(height), held((1, 5))) == ()


def test_a_thing_that_topples_when_it_is_let_go_tipped_over():
    (fall,) = falls(recorded(np.full(N, 0.1), [0.0] * 6 + [math.pi / 2] * 4), held((1, 5)))
    assert fall.is_tipped


def test_what_a_scene_lets_settle_before_the_robot_touches_it_is_left_out():
    height = [0.5, 0.2, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    assert falls(recorded(height), held()) == ()
    assert falls(recorded(height), held((5, 7))) == ()
