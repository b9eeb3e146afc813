"""Point values of expressions, against mpmath and by hand."""

import math

import mpmath
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracerisk.errors import ModelError
from tracerisk.prm.other_models.expressions import (
    Call,
    Definitions,
    Difference,
    Evaluation,
    ExpressionModel,
    MissionTime,
    Negation,
    Number,
    Product,
    Quotient,
    Reference,
    Sum,
    evaluate,
    references,
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


def numbers(*values):
    return tuple(Number(value) for value in values)


def value(expression, names=None, mission_time_h=8760.0):
    return evaluate(expression, names or {}, mission_time_h)


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        (Sum(numbers(1.0, 1e-20, -1.0)), 1e-20),
        (Difference(numbers(1.0, 0.25, 0.5)), 0.25),
        (Product(numbers(2.0, 3.0, 4.0)), 24.0),
        (Quotient(numbers(1.0, 2.0, 4.0)), 0.125),
        (Negation(Number(3.0)), -3.0),
        (MissionTime(), 8760.0),
        (Call("pi", ()), math.pi),
        (Call("pow", numbers(2.0, 10.0)), 1024.0),
        (Call("mod", numbers(-7.9, 3.2)), -1.0),
        (Call("min", numbers(3.0, 1.0, 2.0)), 1.0),
        (Call("max", numbers(3.0)), 3.0),
        (Call("mean", numbers(1.0, 2.0, 6.0)), 3.0),
        (Call("ceil", numbers(1.2)), 2.0),
        (Call("log10", numbers(1000.0)), 3.0),
        (Call("not", numbers(0.0)), 1.0),
        (Call("and", numbers(1.0, 0.0)), 0.0),
        (Call("or", numbers(1.0, 0.0)), 1.0),
        (Call("leq", numbers(1.0, 1.0)), 1.0),
        (Call("df", numbers(1.0, 1.0)), 0.0),
        (Call("ite", numbers(0.0, 2.0, 3.0)), 3.0),
        (Call("switch", numbers(0.0, 5.0, 1.0, 6.0, 7.0)), 6.0),
        (Call("switch", numbers(7.0)), 7.0),
        (UniformDeviate(*numbers(1.0, 4.0)), 2.5),
        (NormalDeviate(*numbers(1.0, 4.0)), 1.0),
        (LognormalDeviate(numbers(1e-3, 3.0, 0.95)), 1e-3),
        (LognormalDeviate(numbers(0.0, 2.0)), math.exp(2.0)),
        (GammaDeviate(*numbers(2.0, 3.0)), 6.0),
        (BetaDeviate(*numbers(1.0, 3.0)), 0.25),
        (Histogram(numbers(0.0, 1.0, 3.0), numbers(1.0, 3.0)), 1.625),
    ],
    ids=lambda part: type(part).__name__ if not isinstance(part, float) else "",
)
def test_each_node_has_its_value(expression, expected):
    assert value(expression) == pytest.approx(expected, rel=1e-15, abs=0)


def test_names_are_followed_whatever_their_number():
    names = {f"p{i}": Reference(f"p{i + 1}") for i in range(50_000)} | {"p50000": 0.125}
    assert value(Reference("p0"), names) == 0.125


def test_an_expression_may_nest_as_deep_as_one_likes():
    expression = Number(1.0)
    for _ in range(50_000):
        expression = Negation(expression)
    assert value(expression) == 1.0


def test_references_are_listed_once_in_their_order():
    expression = Sum((Reference("b"), Product((Reference("a"), Reference("b")))))
    assert references(expression) == ("b", "a")


def test_a_name_is_evaluated_once_for_many_expressions():
    counted = []

    class Counting(Number):
        def value(self, arguments, mission_time_h):
            counted.append(self)
            return self.number

    evaluation = Evaluation({"a": Counting(0.5)}, 1.0)
    assert [evaluation.of(Reference("a")) for _ in range(3)] == [0.5] * 3
    assert len(counted) == 1


def test_a_new_kind_of_node_needs_no_more_than_its_value():
    class Doubled(Negation):
        def value(self, arguments, mission_time_h):
            return 2 * arguments[0]

    assert value(Doubled(Reference("a")), {"a": 0.25}) == 0.5


rates = st.floats(1e-22, 1e-1)
times = st.floats(0.0, 1e5)


@given(rates, times)
def test_exponential_keeps_both_halves(rate, time):
    pair = ExpressionModel(Exponential(Number(rate), MissionTime())).probability(time)
    with mpmath.workdps(60):
        hazard = mpmath.mpf(rate) * mpmath.mpf(time)
        slack = 4e-16 * (1 + rate * time)
        assert pair.p == pytest.approx(float(-mpmath.expm1(-hazard)), rel=slack, abs=1e-300)
        assert pair.q == pytest.approx(float(mpmath.exp(-hazard)), rel=slack, abs=1e-300)


@given(st.floats(0.0, 1.0), rates, rates, times)
def test_glm_is_open_psas_formula(on_demand, rate, repair, time):
    expression = Glm(Number(on_demand), Number(rate), Number(repair), Number(time))
    pair = ExpressionModel(expression).probability(0.0)
    with mpmath.workdps(90):
        g, lam, mu, t = map(mpmath.mpf, (on_demand, rate, repair, time))
        r = lam + mu
        exact = (lam - (lam - g * r) * mpmath.exp(-r * t)) / r
        slack = 1e-15 * (2 + (rate + repair) * time)
        assert pair.p == pytest.approx(float(exact), rel=slack, abs=1e-60)
        assert pair.q == pytest.approx(float(1 - exact), rel=slack, abs=1e-60)


def test_weibull_counts_from_its_shift():
    law = Weibull(*numbers(1000.0, 2.0, 100.0), MissionTime())
    assert value(law, mission_time_h=100.0) == 0.0
    assert value(law, mission_time_h=600.0) == pytest.approx(-math.expm1(-0.25), rel=1e-15)
    assert value(Weibull(*numbers(1e-3, 200.0, 0.0), MissionTime())) == 1.0


def hypoexponential(mu, lam, t):
    """The probability of two exponential times, one after the other, within t; exact."""
    with mpmath.workdps(500):
        mu, lam, t = map(mpmath.mpf, (mu, lam, t))
        if mu == lam:
            return 1 - mpmath.exp(-mu * t) * (1 + mu * t)
        return 1 - (lam * mpmath.exp(-mu * t) - mu * mpmath.exp(-lam * t)) / (lam - mu)


def scram_periodic(lam, mu, tau, theta, t):
    """Open-PSA's five-term periodic test, period after period, at 60 digits."""
    with mpmath.workdps(60):
        lam, mu, tau, theta, t = map(mpmath.mpf, (lam, mu, tau, theta, t))

        def failed(rate, time):
            return 1 - mpmath.exp(-rate * time)

        def period(p, time):
            again = hypoexponential(mu, lam, time)
            return p * (1 - failed(mu, time) + again) + (1 - p) * failed(lam, time)

        if t <= theta:
            return failed(lam, t)
        p = failed(lam, theta)
        count = int((t - theta) / tau)
        for _ in range(count):
            p = period(p, tau)
        return period(p, t - theta - count * tau)


@pytest.mark.parametrize(
    "terms",
    [
        (7e-4, 4e-4, 4020.0, 4740.0, 8760.0),
        (7e-4, 4e-4, 120.0, 4740.0, 8760.0),
        (7e-4, 7e-4, 120.0, 4740.0, 8760.0),
        (1e-15, 1e-2, 100.0, 50.0, 8760.0),
        (1e-9, 1e-1, 1.0, 0.5, 876.25),
        (7e-4, 4e-4, 120.0, 9000.0, 8760.0),
    ],
)
def test_a_periodic_test_with_repair_is_open_psas(terms):
    assert value(PeriodicTest(numbers(*terms))) == pytest.approx(
        float(scram_periodic(*terms)), rel=1e-12
    )


def test_a_periodic_test_without_repair_is_as_good_as_new_after_each():
    def at(time):
        return value(PeriodicTest((*numbers(7e-7, 720.0, 100.0), MissionTime())), None, time)

    assert at(50.0) == -math.expm1(-7e-7 * 50.0)
    assert at(830.0) == -math.expm1(-7e-7 * 10.0)
    assert at(100.0 + 3 * 720.0) == -math.expm1(-7e-7 * 720.0)


def test_at_a_test_rounding_does_not_move_the_clock():
    """0.9 h are three intervals of 0.3 h, although not in floating point."""
    law = PeriodicTest(numbers(1e-3, 0.3, 0.0, 0.9))
    assert value(law) == pytest.approx(-math.expm1(-1e-3 * 0.3), rel=1e-14)


def test_the_full_periodic_test_falls_back_to_the_short_one():
    short = PeriodicTest(numbers(7e-4, 4e-4, 120.0, 4740.0, 8760.5))
    full = PeriodicTest(numbers(7e-4, 6e-4, 4e-4, 120.0, 4740.0, 0.0, 0.0, 1.0, 1.0, 0.0, 8760.5))
    assert value(full) == pytest.approx(value(short), rel=1e-13)


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({}, 0.668316),
        ({"available": 0.0}, 0.668316),
        ({"available": 0.0, "time": 4750.0}, 1.0),
        ({"available": 0.0, "time": 4870.0}, 0.996715),
        ({"available": 0.0, "time": 8710.0}, 0.997478),
        ({"in_test": 7e-4, "repair": 7e-4}, 0.543401),
        ({"duration": 120.0}, 0.6469),
    ],
)
def test_the_full_periodic_test_gives_the_figures_of_scrams_tests(changes, expected):
    """The figures of expression_tests.cc, PeriodicTest11, of SCRAM 0.16.2, to its 1e-5."""
    terms = {
        "rate": 7e-4,
        "in_test": 6e-4,
        "repair": 4e-4,
        "interval": 120.0,
        "first": 4740.0,
        "by_test": 0.01,
        "duration": 20.0,
        "available": 1.0,
        "detection": 0.9,
        "at_restart": 0.01,
        "time": 8760.0,
    } | changes
    pair = ExpressionModel(PeriodicTest(numbers(*terms.values()))).probability(0.0)
    assert pair.p == pytest.approx(expected, abs=1e-5)
    assert pair.p + pair.q == pytest.approx(1.0, rel=1e-14)


@pytest.mark.parametrize(
    ("expression", "message"),
    [
        (
            Reference("pump"),
            "there is no parameter 'pump'; did you mean 'pumps'? allowed: a, b, pumps",
        ),
        (
            Reference("a"),
            "parameter 'a' is defined in terms of itself (a -> b -> a); break the cycle",
        ),
        (Quotient(numbers(1.0, 0.0)), "a quotient divides by zero; give another divisor"),
        (Sum(numbers(1e308, 1e308)), "a sum is too large for a number; give smaller terms"),
        (Product(numbers(1e308, 1e308)), "a product is too large for a number; give smaller terms"),
        (Call("log", numbers(0.0)), "log(0.0) has no finite value; give other terms"),
        (Call("exp", numbers(1e3)), "exp(1000.0) has no finite value; give other terms"),
        (Call("pow", numbers(-1.0, 0.5)), "pow(-1.0, 0.5) has no finite value; give other terms"),
        (
            Exponential(*numbers(-1.0, 1.0)),
            "Exponential: rate is -1.0 1/h; allowed: 0 or more, finite",
        ),
        (
            Glm(*numbers(2.0, 1.0, 1.0, 1.0)),
            "Glm: failure_on_demand is 2.0; allowed: 0 to 1",
        ),
        (
            Weibull(*numbers(0.0, 1.0, 1.0, 1.0)),
            "Weibull: scale_h is 0.0 h; allowed: above 0, finite",
        ),
        (
            PeriodicTest(numbers(1.0, 0.0, 1.0, 1.0)),
            "PeriodicTest: interval_h is 0.0 h; allowed: above 0, finite",
        ),
        (
            PeriodicTest(numbers(1, 1, 1, 2.0, 0, 0, 3.0, 1, 1, 0, 9)),
            "PeriodicTest: test_duration_h is 3.0 h, longer than the interval of 2.0 h between tests; make it shorter",
        ),
        (
            UniformDeviate(*numbers(1.0, 1.0)),
            "a uniform deviate from 1.0 to 1.0; give a greater upper bound",
        ),
        (
            NormalDeviate(*numbers(1.0, 0.0)),
            "normal deviate: sigma is 0.0; allowed: more than 0",
        ),
        (
            LognormalDeviate(numbers(1e-3, 1.0, 0.95)),
            "lognormal deviate: the error factor is 1.0; allowed: more than 1",
        ),
        (
            LognormalDeviate(numbers(1e-3, 3.0, 0.5)),
            "lognormal deviate: the level of the error factor is 0.5; allowed: more than 0.5, less than 1",
        ),
        (
            LognormalDeviate(numbers(1e3, 3.0)),
            "the mean of a lognormal deviate of mu 1000.0 and sigma 3.0 is too large for a number; give smaller ones",
        ),
        (
            Histogram(numbers(1.0, 1.0), numbers(1.0)),
            "a histogram with the boundaries 1.0, 1.0; each must exceed the one before",
        ),
        (
            Histogram(numbers(1.0, 2.0), numbers(0.0)),
            "a histogram with the weights 0.0; no weight may be negative, and not all may be 0",
        ),
    ],
    ids=lambda part: part if isinstance(part, str) else "",
)
def test_what_has_no_value_is_reported(expression, message):
    names = {"a": Reference("b"), "b": Reference("a"), "pumps": 1.0}
    with pytest.raises(ModelError) as caught:
        value(expression, names)
    assert str(caught.value) == message


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Number(math.nan), "nan is not allowed; give a finite number"),
        (lambda: Sum(()), "a sum needs at least one term"),
        (
            lambda: Call("sqr", numbers(1.0)),
            "'sqr' is not a function; did you mean 'sqrt'? allowed: abs, ",
        ),
        (lambda: Call("pow", numbers(1.0)), "pow has 1 terms; allowed: 2"),
        (lambda: Call("min", ()), "min has 0 terms; allowed: 1 or more"),
        (
            lambda: Call("switch", numbers(1.0, 2.0)),
            "switch has 2 terms; allowed: pairs of a condition and a value, and one more value",
        ),
        (lambda: PeriodicTest(numbers(1.0)), "a periodic test has 1 terms; allowed: 4, 5 or 11"),
        (lambda: LognormalDeviate(()), "a lognormal deviate has 0 terms; allowed: 2 or 3"),
        (
            lambda: Histogram(numbers(1.0), ()),
            "a histogram has 0 weights and 1 boundaries; give at least one weight, and one more boundary than weights",
        ),
        (
            lambda: Definitions((("a", Number(1.0)), ("a", Number(2.0)))),
            "parameter 'a' is defined twice; rename or remove one",
        ),
        (lambda: Evaluation({}, -1.0), "the mission time is -1.0 h; allowed: 0 or more"),
        (
            lambda: ExpressionModel(Number(1.5)).probability(1.0),
            "probability 1.5 is outside [0, 1]; give a number within",
        ),
    ],
)
def test_what_cannot_be_is_refused(make, message):
    with pytest.raises(ModelError) as caught:
        make()
    assert str(caught.value).startswith(message)


def test_the_complement_survives_a_reference():
    definitions = Definitions((("p", Exponential(Number(1.0), Number(50.0))),))
    pair = ExpressionModel(Reference("p"), definitions).probability(1.0)
    assert pair.q == math.exp(-50.0)
