"""Weibull ageing, against 60 digits."""

import math

import mpmath
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracerisk.adder.quantify.ageing import ageing_hazard, mean_ageing_rate
from tracerisk.common.hardware.model import Basis, FailureFigure

HOUR = 3600.0


def life(shape: float, scale_h: float) -> FailureFigure:
    return FailureFigure("weibull", scale_h, Basis.HOUR, shape=shape)


@given(
    shape=st.floats(0.3, 8.0),
    scale_h=st.floats(1.0, 1e6),
    age_s=st.just(0.0) | st.floats(1e-3, 1e9),
    use_s=st.floats(1e-3, 1e7),
)
def test_no_digit_is_lost_however_short_the_mission(shape, scale_h, age_s, use_s):
    with mpmath.workdps(60):
        scale = mpmath.mpf(scale_h) * 3600
        expected = ((mpmath.mpf(age_s) + use_s) / scale) ** shape - (age_s / scale) ** shape
    assert ageing_hazard(life(shape, scale_h), age_s, use_s) == pytest.approx(
        float(expected), rel=1e-13
    )


def test_a_shape_of_one_is_a_constant_rate():
    for age_h in (0.0, 12_000.0):
        assert ageing_hazard(life(1.0, 30_000.0), age_h * HOUR, HOUR) == pytest.approx(
            1 / 30_000, rel=1e-13
        )


def test_at_the_characteristic_life_63_percent_have_failed():
    hazard = ageing_hazard(life(3.0, 30_000.0), 0.0, 30_000 * HOUR)
    assert -math.expm1(-hazard) == pytest.approx(1 - 1 / math.e, rel=1e-14)


def test_a_worn_unit_fails_more_often_than_a_new_one_and_a_run_in_one_less():
    worn, new = (ageing_hazard(life(2.0, 1e4), age * HOUR, HOUR) for age in (5000.0, 0.0))
    assert worn > 1000 * new
    run_in, new = (ageing_hazard(life(0.5, 1e4), age * HOUR, HOUR) for age in (5000.0, 0.0))
    assert run_in < new / 10


def test_the_mean_rate_is_zero_without_use_and_endless_beyond_all_numbers():
    assert mean_ageing_rate(life(0.5, 1.0), 0.0, 0.0) == 0.0
    assert mean_ageing_rate(life(2.0, 10.0), 0.0, HOUR) == pytest.approx(0.01 / HOUR, rel=1e-14)
    assert ageing_hazard(life(100.0, 1e-3), 0.0, 1e6) == math.inf
    assert ageing_hazard(life(100.0, 1e-3), 2e6, 1e6) == math.inf
