"""Groups with spares, against formulas on paper."""

import math

import pytest

from tracerisk.prm.trees.spares import Spares, spare_group_failure

COLD = Spares(dormancy=0.0)


def rate(p: float) -> float:
    return -math.log1p(-p)


def poisson_at_least(mean: float, count: int) -> float:
    """The chance of at least so many events, without a difference of near numbers."""
    terms = [math.exp(-mean) * mean**k / math.factorial(k) for k in range(count, count + 60)]
    return math.fsum(terms)


@pytest.mark.parametrize("p", [1e-9, 1e-3, 0.3, 0.99])
@pytest.mark.parametrize(("units", "required"), [(2, 1), (3, 1), (4, 2), (1, 1)])
def test_cold_spares_fail_one_after_the_other(p, units, required):
    found, _ = spare_group_failure(p, units=units, required=required, spares=COLD)
    expected = poisson_at_least(required * rate(p), units - required + 1)
    assert found == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("p", [1e-9, 1e-3, 0.3, 0.99])
@pytest.mark.parametrize(("units", "required"), [(2, 1), (3, 1), (3, 2), (5, 3)])
def test_hot_spares_are_redundant_units(p, units, required):
    found, _ = spare_group_failure(p, units=units, required=required, spares=Spares())
    expected = math.fsum(
        math.comb(units, k) * p**k * (1 - p) ** (units - k)
        for k in range(units - required + 1, units + 1)
    )
    assert found == pytest.approx(expected, rel=1e-12)


def test_a_switch_that_always_fails_leaves_one_unit():
    found, _ = spare_group_failure(1e-5, units=2, required=1, spares=Spares(0.0, 1.0))
    assert found == pytest.approx(1e-5, rel=1e-12)


def test_a_switch_that_may_fail_dominates_a_rare_pair():
    found, _ = spare_group_failure(1e-8, units=2, required=1, spares=Spares(0.0, 1e-3))
    assert found == pytest.approx(1e-11 + 0.5e-16, rel=1e-6)


def test_warm_spares_lie_between():
    cold, warm, hot = (
        spare_group_failure(1e-4, units=2, required=1, spares=Spares(d)).p for d in (0.0, 0.5, 1.0)
    )
    assert cold < warm < hot
    # Working and then either: rates 1.5 and 1, to the leading term.
    assert warm == pytest.approx(rate(1e-4) ** 2 * 1.5 / 2, rel=1e-3)


@pytest.mark.parametrize("p", [0.0, 1.0])
def test_what_never_or_always_fails(p):
    assert spare_group_failure(p, units=3, required=1, spares=Spares(0.2, 0.1)) == (p, 1 - p)


def test_figures_outside_their_ranges_are_refused():
    with pytest.raises(ValueError, match="required from 1 to units"):
        spare_group_failure(0.1, units=2, required=3, spares=COLD)


@pytest.mark.parametrize("spares", [COLD, Spares(0.3), Spares(0.0, 0.2)])
def test_both_halves_keep_their_digits_where_units_fail_nearly_surely(spares):
    p = 1.0 - 2.0**-50
    failed, survived = spare_group_failure(p, units=2, required=1, spares=spares)
    hazard = 50 * math.log(2)
    # A working unit, or one that took over from it: of two the first or the last to fail.
    d, s = spares.dormancy, spares.switch
    second = (1 - s + d) * (-math.expm1(-d * hazard) / d if d else hazard)
    assert survived == pytest.approx(2.0**-50 * (1 + second), rel=1e-13)
    assert failed == pytest.approx(1.0, rel=1e-15)
