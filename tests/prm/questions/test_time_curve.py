"""Figures along the mission time."""

import math

import pytest

from tracerisk.errors import ModelError
from tracerisk.prm.questions.time_curve import sil_band, time_curve


def test_a_mean_over_the_mission_is_that_of_the_integral():
    rate, hours = 1e-5, 8760.0
    curve = time_curve(lambda t: {"top": -math.expm1(-rate * t)}, hours, 2000)
    assert curve.times_h[0] == 0.0
    assert curve.times_h[-1] == hours
    assert curve.figures["top"][0] == 0.0
    exact = 1.0 + math.expm1(-rate * hours) / (rate * hours)
    assert curve.means["top"] == pytest.approx(exact, rel=1e-6)
    assert curve.sil_bands == {"top": 1}


@pytest.mark.parametrize(
    ("mean", "band"),
    [(9.9e-6, None), (1e-5, 4), (9.9e-5, 4), (1e-4, 3), (1e-3, 2), (0.01, 1), (0.1, None)],
)
def test_the_bands_are_those_of_the_standard(mean, band):
    assert sil_band(mean) == band


def test_a_curve_has_two_steps_at_least():
    with pytest.raises(ModelError, match="1 steps; give at least 2"):
        time_curve(lambda t: {"top": t}, 1.0, 1)
