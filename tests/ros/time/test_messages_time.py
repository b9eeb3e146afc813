import copy
import pickle

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracerisk.ros.time.rostime import Duration, Time, TVal

SECONDS = st.integers(0, 2**31)
NANOSECONDS = st.integers(-(2**40), 2**40)


@given(SECONDS, st.integers(0, 2**40))
def test_nanoseconds_are_carried_into_seconds(secs, nsecs):
    time = Time(secs, nsecs)
    assert 0 <= time.nsecs < 10**9
    assert time.to_nsec() == secs * 10**9 + nsecs


@given(SECONDS, SECONDS)
def test_a_difference_of_times_undoes_a_sum(a, b):
    assert (Time(a, 5) + Duration(b, 7)) - Time(a, 5) == Duration(b, 7)


@given(NANOSECONDS, NANOSECONDS)
def test_durations_add_and_order_as_their_nanoseconds(a, b):
    first, second = Duration(0, a), Duration(0, b)
    assert (first + second).to_nsec() == a + b
    assert (first - second).to_nsec() == a - b
    assert (first < second, first <= second, first == second) == (a < b, a <= b, a == b)
    assert (-first).to_nsec() == -a
    assert abs(first).to_nsec() == abs(a)


def test_seconds_may_be_a_float():
    assert (Time(1.5).secs, Time(1.5).nsecs) == (1, 500_000_000)
    assert Duration.from_sec(-0.25).to_nsec() == -250_000_000
    assert Time(2, 250_000_000).to_sec() == Time(2, 250_000_000).to_time() == 2.25


def test_a_float_and_nanoseconds_exclude_each_other():
    with pytest.raises(ValueError, match="if secs is a float, nsecs cannot be set"):
        Duration(1.5, 3)


def test_a_time_is_never_negative():
    with pytest.raises(TypeError, match="time values must be positive"):
        Time(1) - Duration(2)


def test_a_duration_is_multiplied_and_divided():
    assert Duration(2) * 3 == 3 * Duration(2) == Duration(6)
    assert Duration(1) * 0.5 == Duration(0, 500_000_000)
    assert Duration(3) / 2 == Duration(1, 500_000_000)
    assert Duration(3) / Duration(2) == 1.5
    assert Duration(7) // Duration(2) == 3
    assert Duration(7) // 2 == Duration(3)
    assert Duration(7) % Duration(4) == Duration(3)
    assert divmod(Duration(7), Duration(4)) == (1, Duration(3))


@pytest.mark.parametrize(
    "work",
    [
        lambda: Time(1) + Time(1),
        lambda: Duration(1) - Time(1),
        lambda: Time(1) + 1,
        lambda: Duration(1) < 1,
        lambda: Time(1) < Duration(2),
        lambda: Duration(1) * "2",
        lambda: Duration(1) / "2",
    ],
)
def test_what_has_no_meaning_is_a_type_error(work):
    with pytest.raises(TypeError):
        work()


def test_times_equal_only_times():
    assert Time(1) != Duration(1)
    assert Time(1) != 1
    assert hash(Time(1)) == hash(Time(1, 0))


def test_zero_is_false():
    assert not Duration(0)
    assert Duration(0).is_zero()
    assert Duration(0, 1)


def test_values_print_as_genpys():
    assert (repr(Time(1)), repr(Duration(0, 5)), repr(TVal(0, 1))) == (
        "genpy.Time[1000000000]",
        "genpy.Duration[5]",
        "genpy.TVal[1]",
    )
    assert str(Time(1)) == "1000000000"


def test_values_are_copied_and_pickled():
    time = Time(3, 4)
    assert copy.deepcopy(time) == pickle.loads(pickle.dumps(time)) == time


def test_set_takes_values_as_they_are_until_canon():
    time = Time()
    time.set(1, 2 * 10**9)
    assert time.nsecs == 2 * 10**9
    time.canon()
    assert (time.secs, time.nsecs) == (3, 0)
