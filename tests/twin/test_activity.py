"""Activity of crafted samples, with the intervals computed by hand."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tracerisk.errors import LogError
from tracerisk.trace import WEAR_EXPONENTS, Element
from tracerisk.twin.activity import (
    ElementActivity,
    Thresholds,
    debounce,
    element_activity,
    hysteresis,
)
from tracerisk.twin.exposure import exposure
from tracerisk.twin.robot import Robot
from tracerisk.twin.samples import SampleHeader, Samples

STEP = 0.002
N = 1000


def crafted(panda: Robot, **columns: np.ndarray) -> Samples:
    """Samples of a robot at rest, but for the columns given as `velocity_<joint>` and so on."""
    joints = tuple(joint.name for joint in panda.joints)
    pads = tuple(pad for gripper in panda.grippers for pad in gripper.pads)
    header = SampleHeader("panda", "crafted", 2_000_000, (), joints, pads, 0)
    arrays = {
        "velocity": np.zeros((N, len(joints))),
        "torque": np.zeros((N, len(joints))),
        "force": np.zeros((N, len(pads))),
    }
    for name, values in columns.items():
        kind, _, what = name.partition("_")
        index = pads.index(what) if kind == "force" else joints.index(what)
        arrays[kind][:, index] = values
    return Samples(
        header,
        np.zeros((N, 0)),
        np.zeros((N, len(joints))),
        arrays["velocity"],
        arrays["torque"],
        arrays["force"],
        np.zeros((0, 0)),
    )


def steps(*intervals: tuple[int, int, float], base: float = 0.0) -> np.ndarray:
    values = np.full(N, base)
    for begin, end, value in intervals:
        values[begin:end] = value
    return values


def intervals(flags: np.ndarray) -> list[tuple[int, int]]:
    edges = np.flatnonzero(np.diff(np.concatenate(([False], flags, [False]))))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def test_moving_begins_above_one_percent_and_ends_below_half(panda: Robot):
    rated = 2.175
    speed = steps((100, 200, 0.011 * rated), (200, 300, 0.006 * rated), (300, 400, 0.004 * rated))
    found = element_activity(crafted(panda, velocity_panda_joint1=-speed), panda)["panda_joint1"]
    assert intervals(found.moving) == [(100, 300)]
    assert intervals(found.holding) == []


def test_a_joint_below_the_upper_threshold_never_moves(panda: Robot):
    speed = steps((100, 900, 0.009 * 2.175))
    found = element_activity(crafted(panda, velocity_panda_joint1=speed), panda)["panda_joint1"]
    assert not found.moving.any()


def test_a_flicker_of_18_ms_is_no_motion_and_one_of_20_ms_is(panda: Robot):
    speed = steps((100, 109, 1.0), (500, 510, 1.0))
    found = element_activity(crafted(panda, velocity_panda_joint1=speed), panda)["panda_joint1"]
    assert intervals(found.moving) == [(500, 510)]


def test_a_gap_of_48_ms_is_bridged_and_one_of_50_ms_is_not(panda: Robot):
    speed = steps((100, 200, 1.0), (224, 300, 1.0), (325, 400, 1.0))
    found = element_activity(crafted(panda, velocity_panda_joint1=speed), panda)["panda_joint1"]
    assert intervals(found.moving) == [(100, 300), (325, 400)]


def test_holding_is_torque_without_motion(panda: Robot):
    limit = 87.0
    torque = steps((0, 600, 0.021 * limit), (600, 700, 0.016 * limit), (700, 1000, 0.01 * limit))
    speed = steps((200, 300, 1.0))
    samples = crafted(panda, torque_panda_joint2=torque, velocity_panda_joint2=speed)
    found = element_activity(samples, panda)["panda_joint2"]
    assert intervals(found.moving) == [(200, 300)]
    assert intervals(found.holding) == [(0, 200), (300, 700)]
    assert intervals(found.active) == [(0, 700)]


def test_grasping_needs_both_pads(panda: Robot):
    samples = crafted(
        panda,
        force_panda_leftfinger=steps((100, 500, 0.6), (500, 600, 0.3)),
        force_panda_rightfinger=steps((200, 800, 0.6)),
    )
    found = element_activity(samples, panda)["panda_hand"]
    assert intervals(found.grasping) == [(200, 600)]
    assert intervals(found.active) == [(200, 600)]


def test_a_gripper_moves_when_one_finger_does(panda: Robot):
    samples = crafted(panda, velocity_panda_finger_joint2=steps((100, 200, 0.0021)))
    assert intervals(element_activity(samples, panda)["panda_hand"].moving) == [(100, 200)]


def test_samples_of_another_robot_are_refused(panda: Robot):
    samples = crafted(panda)
    other = SampleHeader("ur5", "crafted", 2_000_000, (), ("elbow",), (), 0)
    wrong = Samples(other, *(np.zeros((0, 1)) for _ in range(6)))
    with pytest.raises(LogError, match="of robot 'ur5' and lack 'panda_joint1'"):
        element_activity(wrong, panda)
    assert element_activity(samples, panda)


def test_exposure_of_a_crafted_visit(panda: Robot):
    limit, rated = 87.0, 2.175
    samples = crafted(
        panda,
        torque_panda_joint1=steps((100, 200, 0.2 * limit), (200, 300, 0.4 * limit)),
        velocity_panda_joint1=steps((200, 250, 0.5 * rated), (250, 300, 0.25 * rated)),
    )
    found = element_activity(samples, panda)["panda_joint1"]
    got = exposure(found, steps((150, 1000, 1.0)).astype(bool), STEP)
    assert (got.moving_s, got.holding_s, got.active_s) == pytest.approx((0.2, 0.1, 0.3))
    assert (got.longest_moving_s, got.longest_active_s) == pytest.approx((0.2, 0.3))
    assert (got.starts, got.grasps) == (1, 0)
    assert got.torque_rms == pytest.approx(np.sqrt((50 * 0.2**2 + 100 * 0.4**2) / 150))
    assert got.torque_cubic == pytest.approx(0.4)
    assert not got.borderline


def test_a_state_that_fills_many_short_spans_keeps_its_length_in_each(panda: Robot):
    samples = crafted(panda, velocity_panda_joint1=steps((100, 500, 0.5)))
    found = element_activity(samples, panda)["panda_joint1"]
    every_other_10_steps = np.arange(N) // 10 % 2 == 0
    assert exposure(found, every_other_10_steps, STEP).longest_moving_s == pytest.approx(0.8)


def test_a_state_that_only_reaches_into_a_span_counts_there_for_what_lies_in_it(panda: Robot):
    samples = crafted(panda, velocity_panda_joint1=steps((100, 500, 0.5)))
    found = element_activity(samples, panda)["panda_joint1"]
    got = exposure(found, steps((490, 600, 1.0)).astype(bool), STEP)
    assert got.longest_moving_s == pytest.approx(0.02)


def test_the_cubic_mean_weighs_by_speed(panda: Robot):
    samples = crafted(
        panda,
        torque_panda_joint1=steps((0, 500, 8.7), (500, 1000, 43.5)),
        velocity_panda_joint1=steps((0, 500, 0.6), (500, 1000, 0.2)),
    )
    found = element_activity(samples, panda)["panda_joint1"]
    got = exposure(found, np.ones(N, dtype=bool), STEP)
    assert got.torque_cubic == pytest.approx(((0.6 * 0.1**3 + 0.2 * 0.5**3) / 0.8) ** (1 / 3))


@pytest.mark.parametrize(
    ("speed", "torque", "borderline"),
    [
        (0.004, 0.0, False),
        (0.006, 0.0, True),
        (0.019, 0.0, True),
        (0.021, 0.03, False),
        (0.0, 0.009, False),
        (0.0, 0.011, True),
        (0.0, 0.039, True),
        (0.0, 0.041, False),
    ],
)
def test_a_value_near_its_threshold_is_borderline(
    panda: Robot, speed: float, torque: float, borderline: bool
):
    samples = crafted(
        panda,
        velocity_panda_joint1=steps((100, 300, speed * 2.175)),
        torque_panda_joint1=steps((100, 300, torque * 87.0)),
    )
    found = element_activity(samples, panda)["panda_joint1"]
    assert exposure(found, np.ones(N, dtype=bool), STEP).borderline is borderline


def machine(values: list[float], on: float, off: float) -> list[bool]:
    state, states = False, []
    for value in values:
        if value > on:
            state = True
        elif value < off:
            state = False
        states.append(state)
    return states


@settings(deadline=None)
@given(st.lists(st.floats(0.0, 1.0), max_size=60))
def test_hysteresis_is_that_of_a_state_machine(values: list[float]):
    found = hysteresis(np.array(values, dtype=float), 0.6, 0.4)
    assert found.tolist() == machine(values, 0.6, 0.4)


@settings(deadline=None)
@given(st.lists(st.booleans(), max_size=80), st.integers(1, 6), st.integers(1, 6))
def test_debounced_intervals_are_long_enough_and_stay_so(flags, n_on: int, n_off: int):
    once = debounce(np.array(flags, dtype=bool), n_on, n_off)
    ends = intervals(once)
    assert all(end - begin >= n_on for begin, end in ends)
    assert all(b - a >= n_off for (_, a), (b, _) in pairwise(ends))
    assert debounce(once, n_on, n_off).tolist() == once.tolist()


@settings(deadline=None)
@given(
    st.integers(0, 2**32 - 1),
    st.lists(st.integers(0, 400), max_size=6),
)
def test_exposures_partition_the_run(seed: int, cuts: list[int]):
    generator = np.random.default_rng(seed)
    n = 400
    moving = debounce(generator.random(n) < 0.5, 3, 3)
    holding = (generator.random(n) < 0.5) & ~moving
    grasping = generator.random(n) < 0.3
    activity = ElementActivity(
        Element("j", "joint"), moving, holding, grasping,
        generator.random(n), generator.random(n), np.zeros(n), Thresholds(),
    )  # fmt: skip
    edges = [0, *sorted(cuts), n]
    whole = exposure(activity, np.ones(n, dtype=bool), STEP)
    parts = []
    for begin, end in pairwise(edges):
        mask = np.zeros(n, dtype=bool)
        mask[begin:end] = True
        parts.append(exposure(activity, mask, STEP))
    for field in (
        "moving_s", "holding_s", "grasping_s", "active_s", "grasping_moving_s", "travel_s",
    ):  # fmt: skip
        total = sum(getattr(part, field) for part in parts)
        assert total == pytest.approx(getattr(whole, field), abs=1e-9)
    for field in ("starts", "grasps", "releases"):
        assert sum(getattr(part, field) for part in parts) == getattr(whole, field)
    for i, wear in enumerate(whole.wear):
        assert math.fsum(part.wear[i] for part in parts if part.wear) == pytest.approx(
            wear, rel=1e-12
        )


def test_travel_and_wear_are_integrals_over_the_moving_time(panda: Robot):
    limit, rated = 87.0, 2.175
    samples = crafted(
        panda,
        torque_panda_joint1=steps((0, 500, 0.25 * limit), (500, 1000, 0.5 * limit)),
        velocity_panda_joint1=steps((100, 500, 0.5 * rated), (500, 600, 0.125 * rated)),
    )
    found = element_activity(samples, panda)
    got = exposure(found["panda_joint1"], np.ones(N, dtype=bool), STEP)
    assert got.travel_s == pytest.approx(0.8 * 0.5 + 0.2 * 0.125)
    expected = [0.4 * 0.25**k + 0.025 * 0.5**k for k in WEAR_EXPONENTS]
    assert got.wear == pytest.approx(expected)
    cubic = got.wear[WEAR_EXPONENTS.index(3.0)] / got.travel_s
    assert got.torque_cubic == pytest.approx(cubic ** (1 / 3))
    assert exposure(found["panda_joint2"], np.ones(N, dtype=bool), STEP).wear == ()


def test_a_release_belongs_to_the_span_in_which_the_grasp_ends(panda: Robot):
    left, right = panda.grippers[0].pads
    samples = crafted(
        panda,
        **{f"force_{left}": steps((200, 500, 5.0)), f"force_{right}": steps((200, 500, 5.0))},
        **{f"velocity_{panda.grippers[0].joints[0]}": steps((450, 600, 0.1))},
    )
    found = element_activity(samples, panda)[panda.grippers[0].name]
    first = exposure(found, steps((0, 500, 1.0)).astype(bool), STEP)
    second = exposure(found, steps((500, 1000, 1.0)).astype(bool), STEP)
    assert (first.grasps, first.releases) == (1, 0)
    assert (second.grasps, second.releases) == (0, 1)
    assert first.grasping_moving_s == pytest.approx(0.1)
    assert second.grasping_moving_s == 0.0
