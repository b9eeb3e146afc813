"""Things that fall or tip, told from recorded poses: no simulation."""

import math

import numpy as np
import pytest

from tracerisk.pipeline.trace.falls import falls
from tracerisk.pipeline.trace.recorded_run import Fall
from tracerisk.twin.recording.contact_log import ROW, ContactLog, LoggedBody, Weld
from tracerisk.twin.recording.contact_pairs import Hold
from tracerisk.twin.recording.contacts import RunContacts
from tracerisk.twin.recording.samples import POSE_EVERY, SampleHeader, Samples
from tracerisk.twin.robots.robot import load_robot

N = 10
CLOSED, WIDE = 0.012, 0.035
"""Where the set-point of the hand is that holds a tube, and that lets it go [m]."""
HAND = "panda_hand"
TURNS = "panda_joint7"
"""The joint that turns the hand about its own axis: it is level where the run begins."""


def recorded(height, tilt=None, *, fingers=None, turns=None, lifts=None, balls=()):
    """Poses of a tube: its heights [m], and the tilt of its axis about x [rad].

    `fingers` are set-points of the hand [m], `turns` angles of its last joint [rad], `lifts`
    positions of the joint that lifts the arm [rad]; one a pose.
    """
    tilt = np.zeros(N) if tilt is None else np.asarray(tilt)
    poses = np.zeros((N, 7))
    poses[:, 2], poses[:, 3], poses[:, 4] = height, np.cos(tilt / 2), np.sin(tilt / 2)
    robot = load_robot("panda")
    joints = {each.name: np.full(N, robot.initial_state[each.name]) for each in robot.joints}
    for finger in robot.grippers[0].joints:
        joints[finger] = np.full(N, CLOSED + 0.003)
    if turns is not None:
        joints[TURNS] = np.asarray(turns)
    if lifts is not None:
        joints["panda_joint2"] = np.asarray(lifts)
    header = SampleHeader(
        robot="panda",
        scene="cell",
        step_ns=2_000_000,
        controls=(HAND,),
        joints=tuple(joints),
        pads=(),
        n_pose=7,
        free_bodies=("tube",),
        free_at=(0,),
        balls=balls,
    )
    empty = np.zeros((N * POSE_EVERY, 0))
    asked = np.full(N, CLOSED) if fingers is None else np.asarray(fingers)
    control = np.repeat(asked, POSE_EVERY)[:, None]
    position = np.repeat(np.array([*joints.values()]).T, POSE_EVERY, axis=0)
    return Samples(header, control, position, empty, empty, empty, poses)


def held(*spans, welded=()):
    log = ContactLog(
        (LoggedBody("tube", "free", 0.025),),
        tuple(Weld(0, "panda_hand", a * POSE_EVERY, b * POSE_EVERY) for a, b in welded),
        np.zeros(0, dtype=ROW),
    )
    holds = tuple(Hold(HAND, 0, a * POSE_EVERY, b * POSE_EVERY) for a, b in spans)
    return RunContacts(load_robot("panda"), log, (), holds, N * POSE_EVERY, 0.002)


def fallen(samples, contacts):
    return falls(samples, contacts)


OPENS = [*[CLOSED] * 4, *[WIDE] * 6]
"""The hand opens in the pose before the hold from 1 to 5 ends."""


def test_a_thing_let_go_in_the_air_fell():
    height = [0.0, 0.1, 0.2, 0.2, 0.2, 0.1, 0.05, 0.05, 0.05, 0.05]
    (fall,) = fallen(recorded(height, fingers=OPENS), held((1, 5)))
    assert fall == Fall("tube", pytest.approx(0.2), pytest.approx(0.15), was_held=True)


@pytest.mark.parametrize("down", [0.0, 0.01, 0.04])
def test_a_thing_that_is_set_down_did_not(down):
    height = [0.0, 0.1, 0.2, 0.2, 0.2, 0.2 - down, *[0.2 - down] * 4]
    assert fallen(recorded(height, fingers=OPENS), held((1, 5))) == ()


def test_a_thing_that_topples_when_it_is_let_go_tipped_over():
    tilt = [0.0] * 6 + [math.pi / 2] * 4
    (fall,) = fallen(recorded(np.full(N, 0.1), tilt, fingers=OPENS), held((1, 5)))
    assert fall.is_tipped
    assert not fall.slipped_from


def test_a_thing_that_fell_and_lies_on_its_side_did_both():
    tilt = [0.0] * 6 + [math.pi / 2] * 4
    height = [0.0, 0.1, 0.2, 0.2, 0.2, 0.1, 0.05, 0.05, 0.05, 0.05]
    (fall,) = fallen(recorded(height, tilt, fingers=OPENS), held((1, 5)))
    assert (fall.is_tipped, fall.height_m) == (True, pytest.approx(0.15))


def test_a_ball_that_rolls_did_not_tip():
    tilt = [0.0] * 6 + [math.pi / 2] * 4
    samples = recorded(np.full(N, 0.1), tilt, fingers=OPENS, balls=("tube",))
    assert fallen(samples, held((1, 5))) == ()


QUARTER = math.pi / 2
TILTED = [0.0, 0.0, 0.5 * QUARTER, *[QUARTER] * 7]


def level_hand(turns):
    """A run in which the hand points forwards, so that its last joint lays down what it holds."""
    samples = recorded(np.full(N, 0.1), TILTED, fingers=OPENS, turns=turns)
    names = samples.header.joints
    for joint, position in LEVEL.items():
        samples.position[:, names.index(joint)] = position
    return samples


LEVEL = {"panda_joint2": 0.0, "panda_joint4": -QUARTER, "panda_joint6": 2 * QUARTER}
"""The upper arm stands, the forearm and the hand point forwards, along x [rad]."""


def test_a_thing_that_its_hand_lays_down_did_not_tip():
    turned = np.asarray(TILTED)
    assert fallen(level_hand(turned), held((1, 5))) == ()


def test_a_thing_that_is_turned_in_a_hand_that_does_not_turn_tipped():
    (fall,) = fallen(level_hand(np.zeros(N)), held((1, 5)))
    assert fall.is_tipped


def test_a_thing_that_stands_although_its_hand_turned_it_tipped():
    samples = level_hand(np.asarray(TILTED))
    samples.poses[6:, 3:5] = (1.0, 0.0)
    (fall,) = fallen(samples, held((1, 5)))
    assert fall.is_tipped


AWAY = [-0.785] * 5 + [-0.9] * 5
"""The arm lifts its hand by some centimetres once the hold from 1 to 5 has ended [rad]."""


@pytest.mark.parametrize("down", [0.0, 0.004, 0.04])
def test_a_thing_that_stays_behind_when_the_closed_hand_goes_slipped_out_of_it(down):
    height = np.concatenate((np.full(5, 0.04), np.full(5, 0.04 - down)))
    (fall,) = fallen(recorded(height, lifts=AWAY), held((1, 5)))
    assert (fall.slipped_from, fall.time_s) == (HAND, pytest.approx(0.2))


def test_a_thing_that_falls_out_of_a_hand_at_rest_slipped():
    height = [0.0, 0.1, 0.2, 0.2, 0.2, 0.19, 0.15, 0.1, 0.05, 0.05]
    (fall,) = fallen(recorded(height), held((1, 5)))
    assert (fall.slipped_from, fall.height_m) == (HAND, pytest.approx(0.15))


@pytest.mark.parametrize(
    ("contacts", "fingers", "lifts"),
    [
        (held((1, 5)), OPENS, AWAY),  # released
        (held((1, 5)), [*[CLOSED] * 6, *[WIDE] * 4], [*AWAY[:5], *[-0.785] * 2, *AWAY[7:]]),
        (held((1, 5)), None, None),  # nothing moves
        (held((1, 5), (6, N)), None, [*AWAY[:5], *[-0.785] * 2, *AWAY[7:]]),  # lost for a moment
        (held((1, 5), welded=((2, 5),)), None, AWAY),  # detached
        (held((1, N)), None, None),  # held to the end
    ],
)
def test_what_is_released_set_down_or_held_on_did_not_slip(contacts, fingers, lifts):
    assert fallen(recorded(np.full(N, 0.04), fingers=fingers, lifts=lifts), contacts) == ()


def test_what_a_scene_lets_settle_before_the_robot_touches_it_is_left_out():
    height = [0.5, 0.2, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    fingers = [*[CLOSED] * 6, *[WIDE] * 4]
    assert fallen(recorded(height, fingers=fingers), held()) == ()
    assert fallen(recorded(height, fingers=fingers), held((5, 7))) == ()
