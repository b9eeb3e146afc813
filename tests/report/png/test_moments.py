"""The moment that stands for a function is the one that the rule names."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tracerisk.common.traced.elements import Element
from tracerisk.report.png.moments import FrameCounts, function_moments
from tracerisk.twin.recording.activity import ElementActivity

FRAME, STRIDE = 0.04, 20


def activity_of(**frames: str) -> dict[str, ElementActivity]:
    """Activity told frame by frame: `m` moving, `h` holding, `g` grasping, `b` g and m, `.` none."""
    found = {}
    for name, text in frames.items():
        codes = np.repeat(np.array(list(text)), STRIDE)
        zeros = np.zeros(len(codes))
        found[name] = ElementActivity(
            element=Element(name, "joint"),
            moving=np.isin(codes, ["m", "b"]),
            holding=codes == "h",
            grasping=np.isin(codes, ["g", "b"]),
            speed=zeros,
            torque=zeros,
            grip=zeros,
            travel=zeros,
        )
    return found


def moments(trace, activity, n_frames):
    return function_moments(trace, FrameCounts(activity, n_frames, FRAME, 0.002))


def test_the_most_active_elements_count_first_then_those_that_move(trace_of):
    trace = trace_of(("f", 0.0, 0.4, ("a", "b")), end_s=0.4)
    (most,) = moments(trace, activity_of(a="mm..hh.mhh", b=".....hh.mh"), 10)
    assert (most.frame, most.time_s) == (8, 0.32)
    assert most.states == {"a": ("holding",), "b": ("moving",)}


def test_of_equal_stretches_the_middle_of_the_longest_and_then_the_first_one_is_taken(trace_of):
    trace = trace_of(("f", 0.0, 0.4, ("a",)), end_s=0.4)
    assert moments(trace, activity_of(a="mm.mmm.mm."), 10)[0].frame == 4
    assert moments(trace, activity_of(a="mm..mm...."), 10)[0].frame == 0


def test_the_visit_is_reported_and_an_earlier_one_goes_before_its_equal(trace_of):
    visits = (("f", 0.0, 0.2, ("a", "b")), ("g", 0.2, 0.2, ("a",)), ("f", 0.4, 0.4, ("a", "b")))
    trace = trace_of(*visits, end_s=0.8)
    activity = activity_of(a="mmmmm.....mmmmm.....", b=".....mmmmm..m.......")
    f, g = moments(trace, activity, 20)
    assert (f.visit, f.n_visits, f.frame) == (2, 2, 12)
    # What moves on behalf of another visit does not count for this one.
    assert (g.visit, g.n_visits, dict(g.states)) == (1, 1, {})


def test_states_are_named_with_the_one_first_that_decides_the_colour(trace_of):
    trace = trace_of(("f", 0.0, 0.4, ("hand", "camera")), end_s=0.4)
    (found,) = moments(trace, activity_of(hand="bbbbbbbbbb"), 10)
    assert found.states == {"hand": ("grasping", "moving"), "camera": ("in use",)}


def test_a_visit_between_two_poses_has_a_moment_too(trace_of):
    trace = trace_of(("f", 0.05, 0.01, ("a",)), ("g", 0.06, 0.3, ("a",)), end_s=0.36)
    f, g = moments(trace, activity_of(a="mmmmmmmmm"), 9)
    assert f.frame == 2
    assert 2 <= g.frame < 9


@given(
    texts=st.lists(st.text("mhg.", min_size=25, max_size=25), min_size=1, max_size=4),
    cut=st.integers(1, 24),
)
def test_no_other_moment_has_more_active_elements(trace_of, texts, cut):
    names = tuple(f"e{index}" for index in range(len(texts)))
    trace = trace_of(
        ("f", 0.0, cut * FRAME, names), ("g", cut * FRAME, (25 - cut) * FRAME, names), end_s=1.0
    )
    found = moments(trace, activity_of(**dict(zip(names, texts, strict=True))), 25)
    for moment, frames in zip(found, (range(cut), range(cut, 25)), strict=True):

        def score(frame):
            column = [text[frame] for text in texts]
            return sum(each != "." for each in column), sum(each in "mg" for each in column)

        assert moment.frame in frames
        assert score(moment.frame) == max(score(frame) for frame in frames)
        assert len(moment.states) == score(moment.frame)[0]
