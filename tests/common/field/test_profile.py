"""Intervals of what recorded missions show: they hold what is true as often as they say."""

import math
import random
from fractions import Fraction

import pytest

from tracerisk.common.field.profile import following, ratio, student_t


@pytest.fixture(scope="module")
def stats():
    """The distributions of SciPy, whose import takes every process that collects tests long."""
    from scipy import stats

    return stats


@pytest.mark.parametrize("freedom", [1, 2, 5, 30, 1000])
@pytest.mark.parametrize("share", [0.75, 0.95, 0.995])
def test_students_t_is_that_of_scipy(stats, freedom, share):
    assert student_t(freedom, share) == pytest.approx(stats.t.ppf(share, freedom), rel=1e-6)


def test_the_share_of_what_follows_is_exact(stats):
    found = following({"init": 9, "done": 1})
    assert found["init"].share == Fraction(9, 10)
    assert found["init"].low == pytest.approx(stats.beta.ppf(0.05, 9, 2))
    assert found["init"].high == pytest.approx(stats.beta.ppf(0.95, 10, 1))


def test_intervals_of_what_follows_hold_the_truth_in_at_least_nine_of_ten_fields():
    chance = random.Random(1)
    held = 0
    fields = 300
    for _ in range(fields):
        count = sum(chance.random() < 0.9 for _ in range(40))
        found = following({"init": count, "done": 40 - count})["init"]
        held += found.low <= 0.9 <= found.high
    assert 0.89 <= held / fields <= 0.99


def test_intervals_of_times_hold_the_truth_in_nine_of_ten_fields():
    chance = random.Random(2)
    held = 0
    fields = 500
    for _ in range(fields):
        visits = [chance.randint(5, 15) for _ in range(20)]
        # Visits of one mission are alike, as those with one payload are.
        times = [n * chance.gauss(2.0, 0.3) for n in visits]
        found = ratio(times, [float(n) for n in visits])
        held += found.low <= 2.0 <= found.high
    assert 0.86 <= held / fields <= 0.93


def test_one_mission_has_no_interval():
    found = ratio([4.0], [2.0])
    assert (found.mean, found.low, found.high) == (2.0, None, None)
    assert not found.excludes(100.0)


def test_missions_all_alike_have_an_interval_of_no_width():
    found = ratio([4.0, 4.0, 2.0], [2.0, 2.0, 1.0])
    assert found.low == pytest.approx(2.0)
    assert found.high == pytest.approx(2.0)
    assert found.excludes(2.1)
    assert not found.excludes(2.05, within=0.03)


def test_a_function_that_was_never_visited_takes_no_time():
    assert ratio([0.0, 0.0], [0.0, 0.0]).mean == 0.0
    assert math.isfinite(ratio([0.0, 3.0], [0.0, 1.0]).high)
