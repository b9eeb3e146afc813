"""Contacts of crafted logs: what is held, what is expected, and which visit it belongs to."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracerisk.common.traced.elements import GENTLE_N
from tracerisk.twin.recording.activity import ElementActivity
from tracerisk.twin.recording.contact_log import (
    LOOK_EVERY,
    OVERLAP,
    POSTURE_EVERY,
    ROW,
    ContactLog,
    LoggedBody,
    Weld,
)
from tracerisk.twin.recording.contact_pairs import Hold, hand_links, moved_by, pair_touches
from tracerisk.twin.recording.contacts import (
    RunContacts,
    contact_activity,
    run_contacts,
    visit_contacts,
    visit_payloads,
)
from tracerisk.twin.robots.robot import Robot, load_robot

N = 4000
STEP = 0.002
BODIES = (
    "table",
    "rack",
    "tube",
    "panda_link5",
    "panda_leftfinger",
    "panda_rightfinger",
    "panda_hand",
)
LOGGED = tuple(
    LoggedBody(name, "link" if name.startswith("panda") else "fixed" if i < 2 else "free", 0.1)
    for i, name in enumerate(BODIES)
)  # fmt: skip
LEFT, RIGHT = ("panda_leftfinger", "tube"), ("panda_rightfinger", "tube")
GRASP = (1000, 2000)
Pair = tuple[str, str]


@pytest.fixture(scope="module")
def panda() -> Robot:
    return load_robot("panda")


def log(*touches: tuple[Pair, int, int, float], welds: tuple[Weld, ...] = ()) -> ContactLog:
    """A log in which each pair touches from a step up to another with a force."""
    rows = [
        (step, BODIES.index(one), BODIES.index(two), force)
        for (one, two), start, stop, force in touches
        for step in range(start, stop)
    ]
    return ContactLog(LOGGED, welds, np.array(sorted(rows), dtype=ROW))


def flags(*spans: tuple[int, int]) -> np.ndarray:
    found = np.zeros(N, dtype=bool)
    for start, stop in spans:
        found[start:stop] = True
    return found


def activity(panda: Robot, *grasps: tuple[int, int]) -> dict[str, ElementActivity]:
    rest, none = np.zeros(N), np.zeros(N, dtype=bool)
    return {
        element.name: ElementActivity(
            element,
            none,
            none,
            flags(*grasps) if element.kind == "gripper" else none,
            rest,
            rest,
            np.where(flags(*grasps), 7.0, 0.0) if element.kind == "gripper" else rest,
            rest,
        )
        for element in panda.elements
        if element.kind in ("joint", "gripper")
    }


def contacts(
    panda: Robot,
    given: ContactLog,
    grasps: tuple[tuple[int, int], ...] = (GRASP,),
    commanded: tuple[tuple[int, int], ...] = (),
) -> RunContacts:
    return run_contacts(
        panda, given, activity(panda, *grasps), {"panda_hand": flags(*commanded)}, STEP
    )


def expected(run: RunContacts) -> list[tuple[str, str, bool]]:
    return [(touch.link, touch.other, touch.expected) for touch in run.touches]


GRASPED = ((LEFT, 990, 2010, 4.0), (RIGHT, 990, 2010, 4.0))


def test_what_all_pads_touch_in_a_grasp_is_held_from_the_first_touch_to_the_last(panda: Robot):
    run = contacts(panda, log(*GRASPED))
    assert run.holds == (Hold("panda_hand", BODIES.index("tube"), 1000, 2000),)
    assert expected(run) == [(*LEFT, True), (*RIGHT, True)]


def test_what_one_pad_touches_is_not_held_and_is_struck(panda: Robot):
    run = contacts(panda, log(GRASPED[0]))
    assert run.holds == ()
    assert expected(run) == [(*LEFT, False)]


def test_a_finger_may_touch_what_its_gripper_closes_on(panda: Robot):
    assert expected(contacts(panda, log(GRASPED[0]), commanded=((900, 1000),))) == [(*LEFT, True)]
    late = contacts(panda, log(GRASPED[0]), commanded=((1200, 1300),))
    assert expected(late) == [(*LEFT, False)]


def test_a_link_that_is_no_finger_may_touch_nothing(panda: Robot):
    run = contacts(
        panda, log((("panda_link5", "tube"), 1200, 1210, 0.6), *GRASPED), commanded=((0, N),)
    )
    assert ("panda_link5", "tube", False) in expected(run)


def test_the_hand_may_touch_what_its_fingers_hold(panda: Robot):
    touch = (("panda_hand", "tube"), 1200, 1210, 0.6)
    assert ("panda_hand", "tube", True) in expected(contacts(panda, log(touch, *GRASPED)))
    assert expected(contacts(panda, log(touch))) == [("panda_hand", "tube", False)]


@pytest.mark.parametrize(
    ("other", "start", "stop", "force", "fine"),
    [
        ("rack", 1000, 1300, 2.0, True),  # what it was lifted from
        ("table", 1990, 2040, 2.0, True),  # what it was put on
        ("table", 2100, 2140, 2.0, None),  # when it is held no more
        ("table", 1990, 2040, GENTLE_N + 2.0 * 9.81 * 0.1 - 0.1, True),
        ("table", 1990, 2040, GENTLE_N + 2.0 * 9.81 * 0.1 + 0.1, False),  # too hard
        ("table", 1400, 1500, 2.0, False),  # on the way
    ],
)
def test_a_held_thing_may_touch_gently_what_bears_it(
    panda: Robot, other: str, start: int, stop: int, force: float, fine: bool | None
):
    run = contacts(panda, log(*GRASPED, (("tube", other), start, stop, force)))
    found = [touch for touch in run.touches if touch.link == "tube"]
    assert [touch.expected for touch in found] == ([] if fine is None else [fine])


def test_what_is_welded_is_held_without_pads(panda: Robot):
    tube = BODIES.index("tube")
    run = contacts(panda, log(welds=(Weld(tube, "panda_hand", 500, 900),)), grasps=())
    assert run.holds == (Hold("panda_hand", tube, 500, 900),)
    both = contacts(panda, log(*GRASPED, welds=(Weld(tube, "panda_hand", 1500, 2500),)))
    assert both.holds == (Hold("panda_hand", tube, 1000, 2500),)


def test_forces_sum_over_the_points_of_a_pair_and_short_gaps_do_not_part_a_touch(panda: Robot):
    pair = ("panda_link5", "table")
    run = contacts(
        panda,
        log((pair, 100, 110, 30.0), (pair, 105, 106, 12.0), (pair, 150, 160, 5.0), (pair, 300, 301, 9.0)),
        grasps=(),
    )  # fmt: skip
    first, second = run.touches
    assert first.force is not None
    assert first.force.max() == pytest.approx(42.0)
    assert (len(first.steps), second.steps.tolist()) == (20, [300])


def test_steps_between_two_looks_touch_as_at_the_look_before(panda: Robot):
    pair = ("panda_link5", "table")
    looks = [(pair, step, step + 1, float(step)) for step in (100, 101, 101 + LOOK_EVERY, 200)]
    (found,) = pair_touches(log(*looks), N)
    assert found.force is not None
    assert found.steps.tolist() == [100, *range(101, 102 + LOOK_EVERY), 200]
    assert found.force.tolist() == [100.0, *[101.0] * LOOK_EVERY, 101.0 + LOOK_EVERY, 200.0]


def test_links_that_overlap_are_reported_without_a_force(panda: Robot):
    pair, second = ("panda_link5", "panda_hand"), 80 + POSTURE_EVERY
    run = contacts(
        panda, log((pair, 80, 81, OVERLAP), (pair, second, second + 1, OVERLAP)), grasps=()
    )
    (touch,) = run.touches
    assert (touch.expected, touch.force, len(touch.steps)) == (False, None, 2 * POSTURE_EVERY)
    assert visit_contacts(run, owners(panda, [0, N]))[0][0].force_n == 0.0


def test_what_moves_a_link_is_the_next_joint_towards_the_base(panda: Robot):
    assert moved_by(panda, "panda_link5") == "panda_joint5"
    assert moved_by(panda, "panda_hand") == "panda_joint7"
    assert moved_by(panda, "panda_leftfinger") == "panda_hand"
    assert moved_by(panda, "panda_link0") is None


def test_the_hand_is_the_fingers_and_what_bears_them(panda: Robot):
    fingers, hand = hand_links(panda, "panda_hand")
    assert fingers == {"panda_leftfinger", "panda_rightfinger"}
    assert hand == fingers | {"panda_hand"}


def owners(panda: Robot, edges: list[int]) -> dict[str | None, np.ndarray]:
    visit = np.searchsorted(edges, np.arange(N), side="right") - 1
    names = [element.name for element in panda.elements if element.kind in ("joint", "gripper")]
    return {None: visit, **dict.fromkeys(names, visit)}


def test_each_touch_belongs_to_the_visit_that_moves_the_link(panda: Robot):
    run = contacts(panda, log((("panda_link5", "table"), 100, 200, 50.0)), grasps=())
    split = owners(panda, [0])
    split["panda_joint5"] = np.where(np.arange(N) < 150, 2, 3)
    found = visit_contacts(run, split)
    assert {visit: [c.touching_s for c in each] for visit, each in found.items()} == {
        2: [pytest.approx(0.1)],
        3: [pytest.approx(0.1)],
    }


@given(st.lists(st.integers(1, N - 1), max_size=5, unique=True))
def test_contacts_and_payloads_of_all_visits_sum_to_those_of_the_run(cuts: list[int]):
    panda = load_robot("panda")
    run = contacts(
        panda, log(*GRASPED, (("tube", "table"), 1400, 1500, 2.0), (("tube", "rack"), 900, 1100, 1.0))
    )  # fmt: skip
    split = owners(panda, [0, *sorted(cuts)])
    whole = visit_contacts(run, owners(panda, [0]))[0]
    parts = [c for each in visit_contacts(run, split).values() for c in each]
    for contact in whole:
        own = [c for c in parts if (c.link, c.other) == (contact.link, contact.other)]
        assert sum(c.touching_s for c in own) == pytest.approx(contact.touching_s)
        assert max(c.force_n for c in own) == contact.force_n
        assert min(c.start_s for c in own) == contact.start_s
        assert {c.expected for c in own} == {contact.expected}
    doing = activity(panda, GRASP)
    payloads = [p for each in visit_payloads(run, doing, split).values() for p in each]
    assert sum(p.held_s for p in payloads) == pytest.approx(2.0)
    assert {(p.gripper, p.object, p.mass_kg) for p in payloads} == {("panda_hand", "tube", 0.1)}
    assert {(p.pad_force_n, p.most_pad_force_n) for p in payloads} == {(7.0, 7.0)}


def test_a_contact_element_is_active_while_its_link_touches_anything(panda: Robot):
    run = contacts(panda, log(*GRASPED, (("panda_link5", "table"), 100, 200, 0.3)))
    found = contact_activity(run, panda.elements)
    assert set(found) == {"panda_leftfinger", "panda_rightfinger", "panda_link5"}
    assert np.flatnonzero(found["panda_leftfinger"].grasping)[[0, -1]].tolist() == [990, 2009]
    assert not found["panda_link5"].grasping.any(), "0.3 N is below the threshold"
