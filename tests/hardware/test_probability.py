import math
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracerisk.hardware.model import Basis, FailureFigure
from tracerisk.hardware.probability import (
    Use,
    figure_probability,
    group_unit_probability,
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


probabilities = st.floats(min_value=1e-30, max_value=0.5)


@given(st.lists(st.lists(probabilities, min_size=3, max_size=3), min_size=1, max_size=5))
def test_group_value_gives_the_same_result_for_any_units_in_series(visits):
    unit = group_unit_probability(visits, quantity=3, redundancy=False)
    alive = math.fsum(math.log1p(-p) for units in visits for p in units)
    assert 3 * len(visits) * math.log1p(-unit) == pytest.approx(alive, rel=1e-13)


@given(st.lists(st.lists(probabilities, min_size=2, max_size=2), min_size=1, max_size=5))
def test_group_value_gives_the_same_result_for_units_that_are_whole_at_each_visit(visits):
    unit = group_unit_probability(visits, quantity=2, redundancy=True, detected="each_visit")
    alive = Fraction(1)
    for units in visits:
        alive *= 1 - Fraction(units[0]) * Fraction(units[1])
    same = (1 - Fraction(unit) ** 2) ** len(visits)
    assert float((1 - same) / (1 - alive)) == pytest.approx(1.0, rel=1e-12)


@given(st.lists(st.lists(probabilities, min_size=2, max_size=2), min_size=1, max_size=5))
def test_group_value_gives_the_same_result_for_units_whose_failures_stay_hidden(visits):
    unit = group_unit_probability(visits, quantity=2, redundancy=True)
    failed = Fraction(1)
    for units in zip(*visits, strict=True):
        failed *= 1 - math.prod(1 - Fraction(p) for p in units)
    same = (1 - (1 - Fraction(unit)) ** len(visits)) ** 2
    assert float(same / failed) == pytest.approx(1.0, rel=1e-12)


def test_a_group_of_units_that_never_or_surely_fail_keeps_that():
    assert group_unit_probability([[0.0, 0.1], [0.0, 0.2]], quantity=2, redundancy=True) == 0.0
    assert group_unit_probability([[1.0, 1.0]], quantity=2, redundancy=True) == 1.0
