"""Wear by load: what counts, and what a trace must tell for it."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracerisk.common.hardware.load import UnitLoad, mean_speed, wear_s
from tracerisk.common.hardware.model import LoadLaw
from tracerisk.common.hardware.use import UnknownUseError
from tracerisk.common.traced.elements import WEAR_EXPONENTS, Exposure

loads = st.floats(0.05, 1.5)
speeds = st.floats(0.02, 1.2)
exponents = st.sampled_from(WEAR_EXPONENTS)


def steady(seconds: float, speed: float, load: float) -> Exposure:
    """Motion at one speed and one load, both as fractions of the rated ones."""
    travel = seconds * speed
    return Exposure(
        moving_s=seconds,
        active_s=seconds,
        travel_s=travel,
        wear=tuple(travel * load**k for k in WEAR_EXPONENTS),
    )


@given(exponents, loads, loads, speeds)
def test_at_the_mean_speed_of_the_mission_time_counts_by_the_load_alone(k, reference, load, speed):
    law = LoadLaw(reference, 1.0, k)
    exposure = steady(40.0, speed, load)
    unit = UnitLoad(law, mean_speed(exposure.travel_s, exposure.moving_s))
    assert unit.wearing_s(exposure) == pytest.approx(40.0 * (load / reference) ** k, rel=1e-12)


@given(exponents, loads, loads, speeds, speeds)
def test_life_counts_in_revolutions(k, reference, load, speed, reference_speed):
    # Twice as fast for half the time wears alike.
    unit = UnitLoad(LoadLaw(reference, 1.0, k, reference_speed), reference_speed)
    slow, fast = steady(40.0, speed, load), steady(20.0, 2 * speed, load)
    assert unit.wearing_s(fast) == pytest.approx(unit.wearing_s(slow), rel=1e-12)
    expected = 40.0 * speed / reference_speed * (load / reference) ** k
    assert unit.wearing_s(slow) == pytest.approx(expected, rel=1e-12)


def test_only_the_wearing_share_goes_with_the_load():
    unit = UnitLoad(LoadLaw(0.5, 0.6), 0.2)
    assert unit.counted_s(10.0, 4.0) == pytest.approx(0.4 * 10 + 0.6 * 4)
    assert unit.counted_s(10.0, 0.0) == pytest.approx(4.0)


def test_what_never_moves_has_no_mean_speed_and_does_not_wear():
    unit = UnitLoad(LoadLaw(0.5, 1.0), mean_speed(0.0, 0.0))
    assert unit.reference_speed == 0.0
    assert unit.wearing_s(Exposure(holding_s=5.0, active_s=5.0)) == 0.0
    assert unit.wearing_s(steady(1.0, 0.5, 0.5)) == 0.0


def test_a_trace_that_says_no_wear_of_what_moved_is_not_taken_for_no_wear():
    with pytest.raises(UnknownUseError, match="the wear of what moves is not known") as caught:
        wear_s(LoadLaw(0.5, 1.0), Exposure(moving_s=1.0, active_s=1.0))
    assert caught.value.advice == "`tracerisk run FILE` gives it"


def test_an_exponent_for_which_no_wear_is_measured_is_reported_with_those_that_are():
    with pytest.raises(UnknownUseError, match=r"the wear at exponent 3\.5 is not known") as caught:
        wear_s(LoadLaw(0.5, 1.0, 3.5), steady(1.0, 0.5, 0.5))
    assert caught.value.advice == "allowed: 1, 2, 3, 3.333, 4, 6, 9"
