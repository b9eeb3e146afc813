"""Samples of expressions: their distributions, and what is drawn together."""

import numpy as np
import pytest

from tracerisk.errors import ModelError
from tracerisk.prm.numbers.strata import LatinHypercube
from tracerisk.prm.other_models.expressions import (
    Call,
    Difference,
    MissionTime,
    Negation,
    Number,
    Product,
    Quotient,
    Reference,
    Sum,
    evaluate,
)
from tracerisk.prm.other_models.expressions.deviates import (
    BetaDeviate,
    GammaDeviate,
    Histogram,
    LognormalDeviate,
    NormalDeviate,
    UniformDeviate,
)
from tracerisk.prm.other_models.expressions.laws import Exponential, Glm, PeriodicTest, Weibull
from tracerisk.prm.other_models.expressions.sampling import Sampling, sample

DRAWS = LatinHypercube(2000, seed=1)


@pytest.fixture(scope="module")
def stats():
    """The distributions of SciPy, whose import takes every process that collects tests long."""
    from scipy import stats

    return stats


def numbers(*values):
    return tuple(Number(value) for value in values)


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(
    ("deviate", "distribution"),
    [
        (UniformDeviate(*numbers(2.0, 5.0)), lambda stats: stats.uniform(2.0, 3.0)),
        (NormalDeviate(*numbers(2.0, 5.0)), lambda stats: stats.norm(2.0, 5.0)),
        (
            LognormalDeviate(numbers(-7.0, 0.5)),
            lambda stats: stats.lognorm(0.5, scale=np.exp(-7.0)),
        ),
        (GammaDeviate(*numbers(2.0, 5.0)), lambda stats: stats.gamma(2.0, scale=5.0)),
        (BetaDeviate(*numbers(2.0, 5.0)), lambda stats: stats.beta(2.0, 5.0)),
        (
            Histogram(numbers(0.0, 1.0, 2.0, 4.0), numbers(1.0, 0.0, 3.0)),
            lambda stats: stats.rv_histogram(
                (np.array([1.0, 0.0, 3.0]), np.array([0.0, 1.0, 2.0, 4.0])), density=False
            ),
        ),
    ],
    ids=lambda part: type(part).__name__,
)
def test_a_deviate_has_its_distribution(deviate, distribution, stats):
    values = sample(deviate, {}, 1.0, DRAWS)
    assert stats.kstest(values, distribution(stats).cdf).statistic < 1 / DRAWS.size + 1e-9
    assert values.mean() == pytest.approx(evaluate(deviate, {}, 1.0), rel=0.02)


def test_the_error_factor_is_the_quantile_at_its_level_over_the_median():
    values = sample(LognormalDeviate(numbers(1e-3, 3.0, 0.95)), {}, 1.0, DRAWS)
    assert np.quantile(values, 0.95) / np.median(values) == pytest.approx(3.0, rel=0.02)
    assert values.mean() == pytest.approx(1e-3, rel=0.02)


def test_a_name_is_drawn_once_and_what_is_an_events_own_is_its_own():
    rate = LognormalDeviate(numbers(1e-6, 3.0, 0.95))
    sampling = Sampling({"rate": rate}, 10.0, DRAWS)
    first = sampling.of(Exponential(Reference("rate"), MissionTime()), "first")
    second = sampling.of(Exponential(Reference("rate"), MissionTime()), "second")
    assert (first == second).all()
    own = sampling.of(Exponential(rate, MissionTime()), "first")
    other = sampling.of(Exponential(rate, MissionTime()), "second")
    assert abs(np.corrcoef(own, other)[0, 1]) < 0.1
    assert abs(np.corrcoef(own, first)[0, 1]) < 0.1
    assert list(sampling.sampled) == ["rate"]


def test_two_deviates_of_one_expression_are_independent():
    deviate = UniformDeviate(*numbers(0.0, 1.0))
    values = sample(Difference((deviate, deviate)), {}, 1.0, DRAWS)
    assert values.std() == pytest.approx(np.sqrt(1 / 6), rel=0.05)


def test_draws_follow_from_seed_and_key_alone_and_fill_each_stratum():
    again = LatinHypercube(2000, seed=1)
    again.uniform("other")
    values = again.uniform("key")
    assert (values == DRAWS.uniform("key")).all()
    assert (values != LatinHypercube(2000, seed=2).uniform("key")).any()
    assert sorted((values * 2000).astype(int)) == list(range(2000))


@pytest.mark.parametrize(
    "expression",
    [
        Sum((Reference("x"), Number(1.0), MissionTime())),
        Difference((Number(1.0), Reference("x"), Reference("x"))),
        Product((Reference("x"), Reference("x"))),
        Quotient((Number(1.0), Reference("x"), Number(4.0))),
        Negation(Reference("x")),
        *(
            Call(name, (Reference("x"),))
            for name in ("abs", "exp", "log", "log10", "sqrt", "min", "cosh", "not")
        ),
        Call("pow", (Reference("x"), Number(3.0))),
        Call("max", (Reference("x"), Number(0.4), Number(0.3))),
        Call("ite", (Call("lt", (Reference("x"), Number(0.5))), Reference("x"), Number(0.1))),
        Call("pi", ()),
        Exponential(Reference("x"), MissionTime()),
        Glm(Reference("x"), Reference("x"), Number(0.5), MissionTime()),
        Glm(Reference("x"), Number(0.0), Number(0.0), MissionTime()),
        Weibull(Reference("x"), Number(2.0), Reference("x"), MissionTime()),
        PeriodicTest((Reference("x"), Number(0.5), Number(0.1), Number(0.0), MissionTime())),
    ],
    ids=lambda part: getattr(part, "function", type(part).__name__),
)
def test_a_sample_is_the_value_at_each_draw(expression):
    inputs = np.array([0.05, 0.3, 0.55, 0.999])

    class Given:
        size = 4

        def uniform(self, key):
            return inputs

    names = {"x": UniformDeviate(Number(0.0), Number(1.0))}
    found = sample(expression, names, 2.0, Given())
    expected = [evaluate(expression, {"x": float(each)}, 2.0) for each in inputs]
    assert found == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize(
    ("expression", "message"),
    [
        (
            Quotient((Number(1.0), Number(0.0))),
            "a quotient divides by zero in a draw; give another divisor",
        ),
        (Call("log", (Negation(Reference("x")),)), "log(-"),
        (Exponential(Negation(Reference("x")), Number(1.0)), "Exponential: rate is -"),
        (
            Glm(Number(2.0), *numbers(1.0, 1.0, 1.0)),
            "Glm: failure_on_demand is 2.0; allowed: 0 to 1",
        ),
        (Weibull(Negation(Reference("x")), *numbers(1.0, 1.0, 1.0)), "Weibull: scale_h is -"),
        (UniformDeviate(*numbers(1.0, 0.0)), "a uniform deviate from 1.0 to 0.0"),
        (NormalDeviate(*numbers(1.0, -1.0)), "normal deviate: sigma is -1.0"),
        (LognormalDeviate(numbers(1.0, 0.5, 0.95)), "lognormal deviate: the error factor is 0.5"),
        (LognormalDeviate(numbers(1.0, -1.0)), "lognormal deviate: sigma is -1.0"),
        (GammaDeviate(*numbers(1.0, 0.0)), "gamma deviate: scale is 0.0"),
        (BetaDeviate(*numbers(-1.0, 1.0)), "beta deviate: alpha is -1.0"),
        (Histogram(numbers(1.0, 0.0), numbers(1.0)), "a histogram with the boundaries 1.0, 0.0"),
        (Reference("y"), "there is no parameter 'y'"),
        (Reference("cycle"), "parameter 'cycle' is defined in terms of itself (cycle -> cycle)"),
    ],
)
def test_what_cannot_be_sampled_is_reported(expression, message):
    names = {"x": UniformDeviate(*numbers(0.5, 1.0)), "cycle": Reference("cycle")}
    with pytest.raises(ModelError) as caught:
        sample(expression, names, 1.0, DRAWS)
    assert str(caught.value).startswith(message)


def test_no_draws_are_refused():
    with pytest.raises(ModelError, match="0 draws; give 1 or more"):
        LatinHypercube(0, seed=1)
