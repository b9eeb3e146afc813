"""When sensors are in use, against the plain counting of steps."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracerisk.common.traced.elements import Element, Exposure
from tracerisk.twin.recording.activity import ElementActivity
from tracerisk.twin.recording.exposure import exposure
from tracerisk.twin.recording.sensor_activity import ReadingSpan, sensor_activity, sensor_exposures

STEP_NS = 2_000_000
STEP_S = 2e-3
JOINT = Element("elbow", "joint")
ENCODER = Element("elbow/encoder", "sensor", sensor="encoder", part="elbow")
CAMERA = Element("camera", "sensor", sensor="camera")


def joint_activity(moving: list[bool]) -> ElementActivity:
    n = len(moving)
    nothing = np.zeros(n, dtype=np.bool_)
    return ElementActivity(
        JOINT, np.array(moving, dtype=np.bool_), nothing, nothing, np.zeros(n), np.zeros(n),
        np.zeros(n), np.zeros(n),
    )  # fmt: skip


def as_joint(flags: np.ndarray) -> ElementActivity:
    """A joint that moves where the flags say, whose exposure is what is counted elsewhere."""
    return joint_activity(flags.tolist())


runs = st.lists(st.tuples(st.booleans(), st.integers(1, 9)), min_size=1, max_size=12).map(
    lambda parts: [value for value, count in parts for _ in range(count)]
)


@st.composite
def cases(draw):
    moving = draw(runs)
    n = len(moving)
    spans = draw(
        st.lists(st.tuples(st.integers(0, n * STEP_NS), st.integers(1, 40_000_000)), max_size=5)
    )
    owners = draw(st.lists(st.tuples(st.integers(0, 3), st.integers(1, 9)), min_size=1, max_size=n))
    owned = np.resize(np.array([who for who, count in owners for _ in range(count)]), n)
    return moving, [(start, start + length) for start, length in spans], owned


@given(cases(), st.sampled_from([ENCODER, CAMERA]))
def test_a_sensor_is_counted_as_a_joint_with_the_same_flags_is(case, element):
    moving, spans, owners = case
    n = len(moving)
    joint = joint_activity(moving)
    readings = [ReadingSpan((element.name,), start, stop) for start, stop in spans]
    found = sensor_activity([JOINT, element], {"elbow": joint}, readings, n, STEP_NS)
    sensor = found[element.name]
    read = np.array(
        [any(a // STEP_NS <= i and i * STEP_NS < b for a, b in spans) for i in range(n)]
    )
    active = read | (joint.moving if element is ENCODER else False)
    in_visits = [exposure(joint, owners == visit, STEP_S) for visit in range(4)]
    shares = sensor_exposures(sensor, in_visits if element is ENCODER else None, owners, 4, STEP_S)
    for visit, share in enumerate(shares):
        mask = owners == visit
        expected = exposure(as_joint(active), mask, STEP_S)
        assert share.active_s == pytest.approx(expected.moving_s)
        assert share.longest_active_s == pytest.approx(expected.longest_moving_s)
        assert share.reading_s == pytest.approx(np.count_nonzero(read & mask) * STEP_S)
        if element is ENCODER:
            assert share.moving_s == in_visits[visit].moving_s
            assert share.starts == in_visits[visit].starts
        else:
            assert share.moving_s == 0.0
    everywhere = np.zeros(n, dtype=np.int64)
    whole_joint = [exposure(joint, everywhere == 0, STEP_S)] if element is ENCODER else None
    (whole,) = sensor_exposures(sensor, whole_joint, everywhere, 1, STEP_S)
    assert sum(each.active_s for each in shares) == pytest.approx(whole.active_s)
    assert sum(each.reading_s for each in shares) == pytest.approx(whole.reading_s)


def test_what_belongs_to_no_visit_is_in_none():
    found = sensor_activity([CAMERA], {}, [ReadingSpan(("camera",), 0, 8 * STEP_NS)], 10, STEP_NS)
    owners = np.array([-1, -1, 0, 0, 1, 1, 1, -1, -1, -1])
    shares = sensor_exposures(found["camera"], None, owners, 2, STEP_S)
    assert [share.reading_s for share in shares] == [2 * STEP_S, 3 * STEP_S]


def test_a_span_past_the_end_is_cut():
    found = sensor_activity([CAMERA], {}, [ReadingSpan(("camera",), 0, 10**12)], 10, STEP_NS)
    (whole,) = sensor_exposures(found["camera"], None, np.zeros(10, dtype=np.int64), 1, STEP_S)
    assert whole == Exposure(
        active_s=10 * STEP_S, longest_active_s=10 * STEP_S, reading_s=10 * STEP_S
    )


def test_an_unread_sensor_is_in_use_with_its_joint_alone():
    joint = joint_activity([True] * 6 + [False] * 4)
    found = sensor_activity([JOINT, ENCODER, CAMERA], {"elbow": joint}, [], 10, STEP_NS)
    assert list(found) == ["elbow/encoder", "camera"]
    of_joint = [Exposure(moving_s=1.0, holding_s=2.0, active_s=3.0, starts=2, travel_s=0.5)]
    owners = np.zeros(10, dtype=np.int64)
    assert sensor_exposures(found["elbow/encoder"], of_joint, owners, 1, STEP_S) == [
        Exposure(moving_s=1.0, holding_s=2.0, active_s=3.0, starts=2)
    ]
    assert sensor_exposures(found["camera"], None, owners, 1, STEP_S) == [Exposure()]
