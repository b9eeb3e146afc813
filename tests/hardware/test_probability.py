import math

import pytest

from tracerisk.hardware.model import Basis, FailureFigure
from tracerisk.hardware.probability import (
    Use,
    figure_probability,
    unit_probability,
)

PER_MINUTE = FailureFigure("probability", 6.674e-08, Basis.MINUTE)


def test_probability_per_minute_scales_with_the_exposure():
    assert figure_probability(PER_MINUTE, Use(60.0, 0)) == pytest.approx(6.674e-08, rel=1e-14)
    assert figure_probability(PER_MINUTE, Use(6.0, 0)) == pytest.approx(6.674e-09, rel=1e-7)
    assert figure_probability(PER_MINUTE, Use(0.0, 0)) == 0.0


def test_two_halves_of_an_exposure_fail_as_the_whole():
    figure = FailureFigure("probability", 0.3, Basis.HOUR)
    half = figure_probability(figure, Use(1800.0, 0))
    assert 1 - (1 - half) ** 2 == pytest.approx(0.3, rel=1e-14)


def test_failure_rate_is_exponential():
    figure = FailureFigure("failure_rate", 2.0, Basis.HOUR)
    assert figure_probability(figure, Use(1800.0, 0)) == pytest.approx(1 - math.exp(-1), rel=1e-15)


def test_demands_are_counted():
    figure = FailureFigure("probability", 0.1, Basis.DEMAND)
    assert figure_probability(figure, Use(0.0, 3)) == pytest.approx(1 - 0.9**3, rel=1e-15)
    assert figure_probability(figure, Use(9.0, 0)) == 0.0


def test_a_figure_per_visit_does_not_look_at_the_use():
    figure = FailureFigure("probability", 1e-20, Basis.VISIT)
    assert figure_probability(figure, Use(None, None)) == pytest.approx(1e-20, rel=1e-15)


def test_certain_failure_stays_certain():
    figure = FailureFigure("probability", 1.0, Basis.MINUTE)
    assert figure_probability(figure, Use(1e-3, 0)) == 1.0
    assert figure_probability(figure, Use(0.0, 0)) == 0.0


@pytest.mark.parametrize("basis", [Basis.MINUTE, Basis.DEMAND])
def test_unknown_use_is_an_error(basis):
    with pytest.raises(ValueError, match="not known"):
        figure_probability(FailureFigure("probability", 0.1, basis), Use(None, None))


def test_terms_of_one_unit_combine_as_independent_causes():
    figures = (
        FailureFigure("probability", 0.1, Basis.VISIT),
        FailureFigure("probability", 0.2, Basis.DEMAND),
    )
    assert unit_probability(figures, Use(None, 1)) == pytest.approx(0.28, rel=1e-15)
