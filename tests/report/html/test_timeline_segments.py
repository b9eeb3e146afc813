"""What the rows of the timeline show, against what the trace says."""

import itertools
import time
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.common.traced.elements import Element, Exposure
from tracerisk.report.html.run.timeline_segments import (
    BORDERLINE,
    GRASPING,
    HOLDING,
    MOVING,
    SOMEWHEN,
    Segment,
    segments_data,
    timeline_rows,
    visit_spans,
)
from tracerisk.trace import RunEnd, Trace, TracedFunction, Visit
from tracerisk.twin.recording.activity import ElementActivity

PICK = FunctionRef("cell.py", QualifiedName("pick"))
STEP = 0.002


def visit(start_s, duration_s, **exposures):
    return Visit(PICK, start_s, duration_s, "succeeded", exposures)


def trace_of(*visits, elements=("a", "b"), end_s=1.0):
    return Trace(
        controller="cell.py",
        robot="panda",
        scene="empty",
        end=RunEnd("ended", "it ended", end_s),
        elements=tuple(Element(name, "joint") for name in elements),
        functions=(TracedFunction(PICK, 1, 1),),
        visits=visits,
    )


def activity_of(name, **spans):
    """Of 500 steps, those in which each state holds, as (first, last) pairs."""

    def flags(state):
        found = np.zeros(500, dtype=np.bool_)
        for first, last in spans.get(state, ()):
            found[first:last] = True
        return found

    zeros = np.zeros(500)
    return ElementActivity(
        Element(name, "joint"),
        flags("moving"),
        flags("holding"),
        flags("grasping"),
        zeros,
        zeros,
        zeros,
        zeros,
    )


def test_a_visit_is_current_again_when_the_one_within_it_is_over():
    spans = visit_spans([visit(0.0, 0.7), visit(0.2, 0.1), visit(0.9, 0.1)], 1.0)
    assert [len(each) for each in spans] == [2, 1, 1]
    assert spans[0] == (pytest.approx((0.0, 0.2)), pytest.approx((0.3, 0.8)))


def test_a_visit_without_a_duration_lasts_until_the_next():
    assert visit_spans([visit(0.0, None), visit(0.4, None)], 1.0) == (((0.0, 0.4),), ((0.4, 1.0),))


def test_the_spans_of_very_many_visits_take_time_in_proportion():
    began = time.process_time()
    spans = visit_spans([visit(i * 1e-3, 1e-3) for i in range(20_000)], 20.0)
    assert [len(own) for own in spans] == [1] * 20_000
    assert time.process_time() - began < 3.0


@given(st.lists(st.integers(1, 40), min_size=1, max_size=8), st.data())
def test_the_spans_of_a_visit_sum_to_its_duration(gaps, data):
    """Of a run whose time is dealt out to visits as the trace deals it: the latest live one."""
    starts = np.cumsum([0, *gaps[:-1]])
    end = int(starts[-1]) + gaps[-1]
    lives = [data.draw(st.integers(1, end - int(start) + 1)) for start in starts]
    owner = np.full(end, -1)
    for index, (start, live) in enumerate(zip(starts, lives, strict=True)):
        owner[start : start + live] = index
    counts = [int(np.count_nonzero(owner == index)) for index in range(len(starts))]
    visits = [visit(s / 100, n / 100) for s, n in zip(starts, counts, strict=True)]
    spans = visit_spans(visits, end / 100)
    flat = sorted(span for own in spans for span in own)
    assert all(stop <= begin + 1e-9 for (_, stop), (begin, _) in itertools.pairwise(flat))
    for own, count in zip(spans, counts, strict=True):
        assert sum(stop - start for start, stop in own) == pytest.approx(count / 100, abs=1e-9)


def test_an_element_has_a_segment_for_each_stretch_of_one_state():
    activity = {"a": activity_of("a", moving=[(10, 50)], holding=[(50, 60)], grasping=[(55, 70)])}
    (row,) = timeline_rows(trace_of(elements=("a",)), {"motor": ["a"]}, activity, STEP)
    assert [(round(s.start_s / STEP), round(s.stop_s / STEP), s.state) for s in row.segments] == [
        (10, 50, MOVING),
        (50, 55, HOLDING),
        (55, 60, HOLDING | GRASPING),
        (60, 70, GRASPING),
    ]
    assert row.elements["a"] == row.segments


def test_a_component_is_in_every_state_that_an_element_of_it_is_in():
    activity = {
        "a": activity_of("a", moving=[(0, 20)]),
        "b": activity_of("b", holding=[(10, 30)]),
    }
    (row,) = timeline_rows(trace_of(), {"motor": ["a", "b"]}, activity, STEP)
    assert [each.state for each in row.segments] == [MOVING, MOVING | HOLDING, HOLDING]


def test_a_visit_that_is_borderline_marks_what_the_element_does_in_it():
    near = Exposure(moving_s=0.04, active_s=0.04, borderline=True)
    clear = Exposure(moving_s=0.04, active_s=0.04)
    trace = trace_of(visit(0.0, 0.5, a=clear), visit(0.5, 0.5, a=near), elements=("a",))
    activity = {"a": activity_of("a", moving=[(100, 120), (300, 320)])}
    (row,) = timeline_rows(trace, {"motor": ["a"]}, activity, STEP)
    assert [each.state for each in row.segments] == [MOVING, MOVING | BORDERLINE]


def test_a_sensor_in_a_joint_is_in_use_when_the_joint_is_and_in_visits_in_which_it_is_read():
    read = Exposure(moving_s=0.04, active_s=0.3, reading_s=0.3)
    moved = Exposure(moving_s=0.04, active_s=0.04)
    trace = trace_of(visit(0.0, 0.5, **{"a/torque": read}), visit(0.5, 0.5, **{"a/torque": moved}))
    sensors = (
        Element("a/torque", "sensor", sensor="torque", part="a"),
        Element("eye", "sensor", sensor="camera", part="a"),
    )
    trace = replace(trace, elements=(*trace.elements, *sensors))
    activity = {"a": activity_of("a", moving=[(100, 120), (300, 320)], grasping=[(0, 500)])}
    (row, _) = timeline_rows(trace, {"sensor": ["a/torque", "eye"]}, activity, STEP)
    assert row.elements["eye"] == ()
    found = [(round(s.start_s / STEP), round(s.stop_s / STEP), s.state) for s in row.segments]
    assert found == [
        (0, 100, SOMEWHEN),
        (100, 120, MOVING),
        (120, 250, SOMEWHEN),
        (300, 320, MOVING),
    ]


def test_without_samples_an_element_is_in_use_some_time_in_a_visit():
    held = Exposure(holding_s=0.1, active_s=0.1)
    trace = trace_of(visit(0.0, 0.4, a=held), visit(0.4, 0.6, a=None, b=held))
    (row,) = timeline_rows(trace, {"motor": ["a", "b"]})
    assert row.elements["a"] == (
        Segment(0.0, 0.4, HOLDING | SOMEWHEN),
        Segment(0.4, 1.0, SOMEWHEN),
    )
    assert row.segments == (Segment(0.0, 1.0, HOLDING | SOMEWHEN),)


def test_rows_of_what_is_always_in_use_and_of_what_no_component_has():
    trace = trace_of(visit(0.0, 1.0, b=Exposure(moving_s=0.1, active_s=0.1)))
    always, motor, loose = timeline_rows(trace, {"power": [], "motor": ["a"]})
    assert (always.component, always.is_always, len(always.segments)) == ("power", True, 1)
    assert (motor.component, motor.segments) == ("motor", ())
    assert (loose.component, list(loose.elements)) == ("", ["b"])


def test_segments_are_reported_in_whole_milliseconds_where_they_are():
    found = segments_data([Segment(0.002, 0.01, MOVING), Segment(0.0125, 0.0131, HOLDING)])
    assert found == [2, 8, MOVING, 12.5, 0.6, HOLDING]
    assert [type(each) for each in found[:3]] == [int, int, int]
