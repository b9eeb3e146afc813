"""Figures after failures in the field, against an integration of prior times likelihood."""

import math

import mpmath
import pytest

from tracerisk.adder.quantify.posterior import beta_posterior, gamma_posterior


def moments(value, error_factor, value_is):
    """The mean and the variance of the lognormal, by integration over its density."""
    sigma = mpmath.log(error_factor) / mpmath.mpf("1.6448536269514722")
    median = value if value_is == "median" else value * mpmath.e ** (-(sigma**2) / 2)

    def moment(k):
        return mpmath.quad(
            lambda z: (median * mpmath.e ** (sigma * z)) ** k * mpmath.npdf(z), [-12, -3, 0, 3, 20]
        )

    mean = moment(1)
    return mean, moment(2) - mean**2


@pytest.mark.parametrize("value_is", ["median", "mean"])
@pytest.mark.parametrize(("failures", "exposure"), [(0, 0.0), (0, 5e4), (3, 2e4), (40, 1e6)])
def test_a_rate_is_prior_times_likelihood(value_is, failures, exposure):
    found = gamma_posterior(2e-5, 5.0, failures, exposure, value_is=value_is)
    mean, variance = moments(2e-5, 5.0, value_is)
    shape, rate = mean**2 / variance, mean / variance

    def weight(x):
        prior = x ** (shape - 1) * mpmath.e ** (-rate * x)
        return prior * x**failures * mpmath.e ** (-exposure * x)

    top = (shape + failures) / (rate + exposure)
    cuts = [0, top / 100, top / 4, top, 2 * top, 5 * top, 30 * top]
    whole = mpmath.quad(weight, cuts)
    expected = mpmath.quad(lambda x: x * weight(x), cuts) / whole
    assert found.mean == pytest.approx(float(expected), rel=1e-4)
    below = mpmath.quad(weight, [0, top / 100, quantile(found, 0.5)]) / whole
    assert float(below) == pytest.approx(0.5, abs=1e-3)


def quantile(found, share):
    from scipy import stats

    return float(stats.gamma.ppf(share, found.alpha, scale=1 / found.beta))


def test_a_probability_per_demand_is_prior_times_likelihood():
    found = beta_posterior(1e-3, 3.0, 2, 1500.0)
    mean, variance = moments(1e-3, 3.0, "median")
    size = mean * (1 - mean) / variance - 1
    a, b = mean * size, (1 - mean) * size
    expected = (a + 2) / (a + b + 1500)
    assert found.mean == pytest.approx(float(expected), rel=1e-6)


def test_without_a_prior_jeffreys_counts():
    found = gamma_posterior(1e-9, None, 2, 1000.0)
    assert (found.alpha, found.beta) == (2.5, 1000.0)
    found = beta_posterior(1e-9, None, 1, 99.0)
    assert (found.alpha, found.beta) == (1.5, 98.5)


def test_exposure_without_failures_lowers_a_rate_and_narrows_it():
    before = gamma_posterior(1e-5, 10.0, 0, 0.0)
    after = gamma_posterior(1e-5, 10.0, 0, 1e6)
    assert after.mean < before.mean


def test_much_exposure_makes_the_figure_that_of_the_field():
    found = gamma_posterior(1e-4, 3.0, 400, 1e6)
    assert found.mean == pytest.approx(4e-4, rel=0.02)
    assert found.error_factor == pytest.approx(math.exp(1.645 / 20), rel=0.01)


@pytest.mark.parametrize(
    ("make", "failures", "exposure"),
    [
        (gamma_posterior, -1, 1.0),
        (gamma_posterior, 1, -1.0),
        (gamma_posterior, 1, math.inf),
        (beta_posterior, 5, 4.0),
    ],
)
def test_what_cannot_be_is_refused(make, failures, exposure):
    with pytest.raises(ValueError, match=r"failures|demands"):
        make(1e-3, None, failures, exposure)


def test_nothing_known_is_refused():
    with pytest.raises(ValueError, match="nothing is known"):
        gamma_posterior(1e-3, None, 0, 0.0)
