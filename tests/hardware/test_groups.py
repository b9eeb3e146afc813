import math
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracerisk.hardware.groups import group_unit_probability

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
