"""Activity of crafted samples, with the intervals computed by hand."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tracerisk.common.traced.elements import WEAR_EXPONENTS, Element
from tracerisk.errors import LogError
from tracerisk.twin.recording.activity import (
    ElementActivity,
    debounce,
    element_activity,
    hysteresis,
)
from tracerisk.twin.recording.contact_log import ROW, BodyKind, ContactLog, LoggedBody, Weld
from tracerisk.twin.recording.contact_pairs import between_pads
from tracerisk.twin.recording.exposure import exposure
from tracerisk.twin.recording.samples import SampleHeader, Samples
from tracerisk.twin.robots.robot import Robot

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


def test_a_motion_is_one_however_slow_beside_the_rated_speed(panda: Robot):
    rated = 2.175
    speed = steps((100, 900, 0.005 * rated))
    found = element_activity(crafted(panda, velocity_panda_joint1=-speed), panda)["panda_joint1"]
    assert intervals(found.moving) == [(100, 900)]
    assert intervals(found.holding) == []


def test_a_joint_without_a_set_point_that_turns_by_less_than_5_mrad_does_not_move(panda: Robot):
    for turned, expected in ((0.0049, []), (0.0051, [(400, 500)])):
        samples = crafted(panda, velocity_panda_joint1=steps((400, 500, turned / 0.2)))
        found = element_activity(samples, panda)["panda_joint1"]
        assert intervals(found.moving) == expected


def test_a_jerk_of_18_ms_is_no_motion_and_one_of_20_ms_is(panda: Robot):
    speed = steps((100, 109, 1.0), (500, 510, 1.0))
    found = element_activity(crafted(panda, velocity_panda_joint1=speed), panda)["panda_joint1"]
    assert intervals(found.moving) == [(500, 510)]


@pytest.mark.parametrize(
    ("rest", "whole"),
    # At most 5 % of the motion that it parts, and less than 20 ms.
    [(9, 181), (9, 179), (10, 800)],
)
def test_a_rest_ends_a_motion_unless_it_is_short_beside_it(panda: Robot, rest: int, whole: int):
    begin, stop = 100 + (whole - rest) // 2, 100 + (whole + rest) // 2
    speed = steps((100, begin, 1.0), (stop, 100 + whole, 1.0))
    found = element_activity(crafted(panda, velocity_panda_joint1=speed), panda)["panda_joint1"]
    is_one = stop - begin <= 0.05 * whole and stop - begin < 10
    both = [(100, begin), (stop, 100 + whole)]
    assert intervals(found.moving) == ([(100, 100 + whole)] if is_one else both)


def test_holding_is_torque_without_motion(panda: Robot):
    limit = 87.0
    torque = steps((0, 600, 0.021 * limit), (600, 700, 0.019 * limit), (700, 1000, 0.021 * limit))
    speed = steps((200, 300, 1.0))
    samples = crafted(panda, torque_panda_joint2=torque, velocity_panda_joint2=speed)
    found = element_activity(samples, panda)["panda_joint2"]
    assert intervals(found.moving) == [(200, 300)]
    # The torque is the mean over 25 steps about each.
    assert intervals(found.holding) == [(0, 200), (300, 600), (700, 1000)]
    assert intervals(found.active) == [(0, 600), (700, 1000)]


def test_a_load_that_trembles_about_its_mean_is_held_all_the_time(panda: Robot):
    trembling = 87.0 * (0.03 + 0.05 * np.sign(np.sin(np.arange(N) * 2 * np.pi / 5 + 0.1)))
    found = element_activity(crafted(panda, torque_panda_joint2=trembling), panda)
    assert found["panda_joint2"].holding.all()


def pressing(panda: Robot, *intervals: tuple[int, int, float]) -> dict[str, np.ndarray]:
    """What the drive of the hand gives to press its fingers together."""
    gripper = panda.grippers[0]
    return {f"torque_{name}": -gripper.sign(name) * steps(*intervals) for name in gripper.joints}


def test_grasping_needs_both_pads(panda: Robot):
    samples = crafted(
        panda,
        force_panda_leftfinger=steps((100, 500, 0.6), (500, 600, 0.3)),
        force_panda_rightfinger=steps((200, 800, 0.6)),
        **pressing(panda, (100, 800, 0.6)),
    )
    found = element_activity(samples, panda)["panda_hand"]
    assert intervals(found.grasping) == [(200, 600)]


def test_a_gripper_without_pads_moves_and_grasps_nothing(panda: Robot):
    (hand,) = panda.grippers
    bare = replace(panda, grippers=(replace(hand, pads=()),))
    samples = crafted(panda, **pressing(panda, (1000, 2000, 20.0)))
    assert not element_activity(samples, bare)["panda_hand"].grasping.any()


def test_pads_that_are_pressed_from_outside_grasp_nothing(panda: Robot):
    forces = {f"force_{pad}": steps((100, 500, 30.0)) for pad in panda.grippers[0].pads}
    found = element_activity(crafted(panda, **forces), panda)["panda_hand"]
    assert not found.grasping.any()


def touching(body: LoggedBody, pads: tuple[str, ...], start: int, stop: int) -> ContactLog:
    """A body that all pads touch at every step from one to another."""
    bodies = (*(LoggedBody(pad, "link") for pad in pads), body)
    rows = [(step, pad, len(pads), 5.0) for step in range(start, stop) for pad in range(len(pads))]
    return ContactLog(bodies, (), np.array(rows, dtype=ROW))


@pytest.mark.parametrize(("kind", "expected"), [("free", [(100, 500)]), ("fixed", [])])
def test_what_cannot_be_moved_is_not_grasped(panda: Robot, kind: BodyKind, expected: list):
    pads = panda.grippers[0].pads
    samples = replace(
        crafted(
            panda,
            **{f"force_{pad}": steps((100, 500, 5.0)) for pad in pads},
            **pressing(panda, (100, 500, 5.0)),
        ),
        contacts=touching(LoggedBody("box", kind), pads, 100, 500),
    )
    found = element_activity(samples, panda)["panda_hand"]
    assert intervals(found.grasping) == expected


def test_what_is_declared_and_attached_later_is_grasped_before(panda: Robot):
    pads = panda.grippers[0].pads
    log = touching(LoggedBody("box", "fixed"), pads, 100, 500)
    log = replace(
        log, bodies=(*log.bodies, LoggedBody("box", "free", 0.1)), welds=(Weld(3, pads[0], 500, N),)
    )
    assert intervals(between_pads(log, panda.grippers[0], N)) == [(100, 500)]
    assert not between_pads(replace(log, welds=()), panda.grippers[0], N).any()


def test_two_things_on_a_pad_each_are_not_between_them(panda: Robot):
    pads = panda.grippers[0].pads
    bodies = (*(LoggedBody(pad, "link") for pad in pads), *(LoggedBody(n, "free") for n in "ab"))
    rows = [(step, pad, 2 + pad, 5.0) for step in range(100, 500) for pad in (0, 1)]
    log = ContactLog(bodies, (), np.array(rows, dtype=ROW))
    assert not between_pads(log, panda.grippers[0], N).any()


def test_a_gripper_moves_when_one_finger_does(panda: Robot):
    samples = crafted(panda, velocity_panda_finger_joint2=steps((100, 400, 0.0021)))
    assert intervals(element_activity(samples, panda)["panda_hand"].moving) == [(100, 400)]


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
    ("turned", "torque", "borderline"),
    # A joint without a set-point has to turn by 5 mrad.
    [
        (0.0024, 0.0, False),
        (0.0026, 0.0, True),
        (0.0099, 0.0, True),
        (0.0101, 0.03, False),
        (0.0, 0.009, False),
        (0.0, 0.011, True),
        (0.0, 0.039, True),
        (0.0, 0.041, False),
    ],
)
def test_a_value_near_its_threshold_is_borderline(
    panda: Robot, turned: float, torque: float, borderline: bool
):
    samples = crafted(
        panda,
        velocity_panda_joint1=steps((100, 300, turned / 0.4)),
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
        generator.random(n), generator.random(n), np.zeros(n), np.zeros(n),
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
        **pressing(panda, (200, 500, 5.0)),
    )
    found = element_activity(samples, panda)[panda.grippers[0].name]
    first = exposure(found, steps((0, 500, 1.0)).astype(bool), STEP)
    second = exposure(found, steps((500, 1000, 1.0)).astype(bool), STEP)
    assert (first.grasps, first.releases) == (1, 0)
    assert (second.grasps, second.releases) == (0, 1)
    assert first.grasping_moving_s == pytest.approx(0.1)
    assert second.grasping_moving_s == 0.0


@pytest.mark.parametrize("touched", [(), ("panda_leftfinger",)])
@pytest.mark.parametrize(
    ("link", "expected"),
    [("panda_hand", [(300, 700)]), ("panda_link8", [(300, 700)]), ("panda_link3", [])],
)
def test_what_is_attached_to_the_hand_is_grasped_whichever_pad_touches_it(
    panda: Robot, link: str, expected: list, touched: tuple[str, ...]
):
    log = touching(LoggedBody("box", "free", 0.1), panda.grippers[0].pads, 300, 700)
    log = replace(log, welds=(Weld(2, link, 300, 700),))
    forces = {f"force_{pad}": steps((400, 500, 30.0)) for pad in touched}
    samples = replace(crafted(panda, **forces), contacts=log)
    found = element_activity(samples, panda)["panda_hand"]
    assert intervals(found.grasping) == expected
    over = exposure(found, np.ones(N, dtype=bool), STEP)
    assert (over.grasps, over.borderline) == (len(expected), False)


def test_a_grasp_by_the_pads_and_one_by_attaching_are_one(panda: Robot):
    pads = panda.grippers[0].pads
    log = touching(LoggedBody("box", "free", 0.1), pads, 100, 400)
    samples = replace(
        crafted(
            panda,
            **{f"force_{pad}": steps((100, 400, 5.0)) for pad in pads},
            **pressing(panda, (100, 400, 5.0)),
        ),
        contacts=replace(log, welds=(Weld(2, "panda_hand", 350, 600),)),
    )
    found = element_activity(samples, panda)["panda_hand"]
    assert intervals(found.grasping) == [(100, 600)]
