"""The way along set-points that come in a stream."""

import numpy as np
import pytest

from tracerisk.twin.motion.streams import SetPointStream
from tracerisk.twin.robots.robot import load_robot

STEP_S = 0.002
JOINT = "shoulder_pan_joint"
ROBOT = load_robot("ur5e")


def followed(
    samples, came_s, *, robot=ROBOT, joint=JOINT, due_s=0.0, rest_s=2.0, look_ahead_s=None
):
    """Return times, positions and velocities of a joint that follows samples from 0 on."""
    stream = SetPointStream(robot, (joint,), look_ahead_s=look_ahead_s)
    reference = (np.zeros(1), np.zeros(1))
    track = [(0.0, 0.0, 0.0)]
    for number, (sample, came) in enumerate(zip(samples, came_s, strict=True)):
        now = len(track) * STEP_S - STEP_S
        stream.take(came, np.array([sample]), reference, now, due_s)
        _, position, velocity = stream.way(now, STEP_S)
        last = number + 1 == len(samples)
        until = came + rest_s if last else came_s[number + 1]
        for row in range(max(round((until - now) / STEP_S), 0)):
            at = min(row, len(position) - 1)
            reference = (position[at], velocity[at])
            track.append((now + (row + 1) * STEP_S, position[at][0], velocity[at][0]))
    return tuple(np.array(column) for column in zip(*track, strict=True))


def wave(time):
    return 0.25 * (1.0 - np.cos(np.pi * time))


@pytest.mark.parametrize("rate_hz", [20, 50, 125, 500])
def test_the_acceleration_of_a_sampled_motion_is_that_of_the_motion(rate_hz):
    came = np.arange(2 * rate_hz + 1) / rate_hz
    _, _, velocity = followed(wave(came), came)
    acceleration = np.diff(velocity) / STEP_S
    assert np.abs(acceleration).max() == pytest.approx(0.25 * np.pi**2, rel=0.02)


def test_messages_that_come_unevenly_are_of_one_even_motion():
    sent = np.arange(201) / 50
    late = np.random.default_rng(3).uniform(0.0, 0.006, len(sent))
    _, _, velocity = followed(wave(sent), np.round((sent + late) / STEP_S) * STEP_S)
    acceleration = np.diff(velocity)[500:1800] / STEP_S
    assert np.sqrt((acceleration**2).mean()) == pytest.approx(0.25 * np.pi**2 / 2**0.5, rel=0.1)


def test_a_stream_is_followed_late_by_no_more_than_three_periods():
    came = np.arange(101) / 50
    time, position, _ = followed(wave(came), came)
    late = min(range(60), key=lambda n: np.abs(position[n : n + 900] - wave(time[:900])).max())
    assert late * STEP_S <= 3 / 50


@pytest.mark.parametrize("look_ahead_s", [0.03, 0.1, 0.2])
def test_a_sender_may_have_its_stream_smoothed_over_a_time_of_its_own(look_ahead_s):
    came = np.arange(501) / 125
    time, position, _ = followed(wave(came), came, look_ahead_s=look_ahead_s)
    late = min(range(120), key=lambda n: np.abs(position[n : n + 1500] - wave(time[:1500])).max())
    # The mean over a window is late by half of it, the set-points by one and a half periods.
    assert late * STEP_S == pytest.approx(look_ahead_s / 2 + 1.5 / 125, abs=0.006)


def test_a_single_set_point_is_gone_to_within_the_limits_of_the_joint():
    _, position, velocity = followed([1.0], [0.0])
    joint = ROBOT.joint(JOINT)
    assert position[-1] == pytest.approx(1.0)
    assert velocity[-1] == 0.0
    assert np.abs(velocity).max() <= joint.velocity_limit * 1.001
    assert np.abs(np.diff(velocity)).max() / STEP_S <= ROBOT.followed_rise(JOINT) * 1.05


def test_a_jump_in_a_stream_is_no_blow():
    came = np.arange(50) / 50
    samples = np.where(np.arange(50) < 25, 0.1 * came, 1.5)
    _, position, velocity = followed(samples, came)
    assert position[-1] == pytest.approx(1.5)
    assert np.abs(np.diff(velocity)).max() / STEP_S <= ROBOT.followed_rise(JOINT) * 1.1


@pytest.mark.parametrize("rate_hz", [20, 100, 500])
@pytest.mark.parametrize("name", ["panda", "gen3"])
def test_a_stream_that_begins_in_full_motion_is_joined_within_the_limits(name, rate_hz):
    robot = load_robot(name)
    joint = robot.arm_joints[0].name
    came = np.arange(rate_hz + 1) / rate_hz
    _, position, velocity = followed(1.0 * came, came, robot=robot, joint=joint)
    assert position[-1] == pytest.approx(1.0)
    assert np.abs(np.diff(velocity)).max() / STEP_S <= robot.followed_rise(joint) * 1.25


def test_a_stream_that_ends_in_full_motion_brakes_within_the_limits():
    robot = load_robot("gen3")
    name = robot.arm_joints[0].name
    came = np.arange(101) / 100
    _, position, velocity = followed(0.8 * came, came, robot=robot, joint=name)
    assert position[-1] == pytest.approx(0.8)
    assert np.abs(np.diff(velocity)).max() / STEP_S <= robot.followed_rise(name) * 1.25


def test_a_first_set_point_that_is_due_later_is_reached_then():
    time, position, _ = followed([0.05], [0.0], due_s=0.2)
    assert position[round(0.1 / STEP_S)] == pytest.approx(0.025, abs=0.002)
    assert position[round(0.2 / STEP_S)] == pytest.approx(0.05, abs=1e-6)
    assert time[-1] >= 1.0


def test_of_set_points_that_come_sooner_than_the_control_period_none_is_waited_for():
    robot = load_robot("xarm7")
    name = robot.arm_joints[0].name
    assert robot.following.period_s == 0.02
    came = np.arange(501) / 250
    time, position, _ = followed(wave(came), came, robot=robot, joint=name)
    assert np.abs(position - wave(np.clip(time, 0.0, 2.0))).max() < 0.04


@pytest.mark.parametrize("name", ["ur5e", "ur3", "panda", "xarm6", "gen3"])
def test_how_a_driver_follows_streams_has_a_source(name):
    following = load_robot(name).following
    assert following.period_s > 0.0
    assert "/" in following.source
