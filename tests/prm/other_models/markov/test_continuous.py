"""Chains in continuous time, against formulas, fractions and mpmath's matrix exponential."""

import math

import mpmath
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tracerisk.errors import ModelError, TooLargeError
from tracerisk.prm.other_models.markov import ContinuousChain
from tracerisk.prm.other_models.markov.uniformisation import poisson_weights

FAIL, REPAIR = 1e-5, 0.1
PAIR = ContinuousChain(
    {"both": {"one": 2 * FAIL}, "one": {"both": REPAIR, "none": FAIL}}, ("none",)
)
REPAIRED = ContinuousChain(
    {
        "both": {"one": 2 * FAIL},
        "one": {"both": REPAIR, "none": FAIL},
        "none": {"one": 2 * REPAIR},
    }
)


def at(chain, entry, time):
    """The distribution by mpmath, to sixty digits."""
    names = [*chain.rates, *chain.absorbing]
    with mpmath.workdps(60):
        generator = mpmath.zeros(len(names))
        for i, state in enumerate(names):
            for target, rate in chain.rates.get(state, {}).items():
                if target != state:
                    generator[i, names.index(target)] += mpmath.mpf(rate)
                    generator[i, i] -= mpmath.mpf(rate)
        row = mpmath.expm(generator * time)[names.index(entry), :]
        return {name: row[j] for j, name in enumerate(names)}


def test_a_repaired_pair_fails_after_the_time_that_the_formula_says():
    # MTTF = (3 l + m) / (2 l^2).
    solution = PAIR.solve("both")
    assert solution.expected_time() == pytest.approx((3 * FAIL + REPAIR) / (2 * FAIL**2), rel=1e-13)
    assert solution.absorption() == pytest.approx({"none": 1.0}, rel=1e-14)
    assert solution.expected_times()["one"] == pytest.approx(1 / FAIL, rel=1e-13)
    assert solution.expected_visits()["both"] == pytest.approx((REPAIR + FAIL) / FAIL, rel=1e-13)
    assert solution.per_time(["none"]) == pytest.approx(1 / solution.expected_time(), rel=1e-14)
    assert solution.absorption_from_each(["none"])["one"] == pytest.approx(1.0, rel=1e-14)


def test_two_ends_and_the_time_until_each():
    # From a: to b with 3, lost with 1; from b won with 2. Lost needs 1/4, won 1/4 + 1/2.
    chain = ContinuousChain({"a": {"b": 3.0, "lost": 1.0}, "b": {"won": 2.0}}, ("lost", "won"))
    solution = chain.solve("a")
    assert solution.absorption() == pytest.approx({"lost": 0.25, "won": 0.75}, rel=1e-15)
    assert solution.expected_time_given(["lost"]) == pytest.approx(0.25, rel=1e-15)
    assert solution.expected_time_given(["won"]) == pytest.approx(0.75, rel=1e-15)
    assert chain.embedded().solve("a").absorption() == pytest.approx({"lost": 0.25, "won": 0.75})


@pytest.mark.parametrize("time", [0.0, 1e-9, 1.0, 100.0, 1e4])
def test_the_pair_at_a_time_equals_the_matrix_exponential(time):
    found = PAIR.transient("both", time)
    for state, expected in at(PAIR, "both", time).items():
        assert found[state] == pytest.approx(float(expected), rel=1e-13)


def test_a_long_time_is_squared_up_and_keeps_rare_states():
    # Failures 1e-12, repair 1: the pair is lost with 2e-24 per hour, seen after 1e6 hours.
    fail = 1e-12
    chain = ContinuousChain(
        {"both": {"one": 2 * fail}, "one": {"both": 1.0, "none": fail}}, ("none",)
    )
    found = chain.transient("both", 1e6)
    assert found["none"] == pytest.approx(float(at(chain, "both", 10**6)["none"]), rel=1e-10)
    assert found["one"] == pytest.approx(2 * fail, rel=1e-10)


@settings(max_examples=25, deadline=None)
@given(
    rates=st.lists(
        st.lists(st.sampled_from([0.0, 1e-9, 1e-3, 1.0, 20.0]), min_size=4, max_size=4),
        min_size=3,
        max_size=3,
    ),
    time=st.sampled_from([0.01, 1.0, 30.0]),
)
def test_random_chains_at_a_time_equal_the_matrix_exponential(rates, time):
    names = ["a", "b", "c", "end"]
    chain = ContinuousChain(
        {s: dict(zip(names, row, strict=True)) for s, row in zip(names, rates, strict=False)},
        ("end",),
    )
    found = chain.transient("a", time)
    for state, expected in at(chain, "a", time).items():
        assert found[state] == pytest.approx(float(expected), rel=1e-11, abs=1e-250)


def test_a_chain_of_many_states_is_stepped_in_arrays():
    rates = {f"s{i}": {f"s{i + 1}": 1.0} for i in range(3000)}
    found = ContinuousChain(rates, ("s3000",)).transient("s0", 900.0)
    # A Poisson count of mean 900.
    expected = math.exp(950 * math.log(900.0) - 900.0 - math.lgamma(951))
    assert found["s950"] == pytest.approx(expected, rel=1e-9)


def test_poisson_weights_of_small_and_great_means():
    first, weights = poisson_weights(2.5)
    assert first == 0
    assert weights[3] == pytest.approx(math.exp(-2.5) * 2.5**3 / 6, rel=1e-14)
    first, weights = poisson_weights(1e6)
    mean = math.fsum((first + k) * w for k, w in enumerate(weights))
    assert math.fsum(weights) == pytest.approx(1.0, rel=1e-15)
    assert mean == pytest.approx(1e6, rel=1e-12)


def test_the_availability_of_a_repaired_pair_equals_the_formula():
    ratio = FAIL / REPAIR
    expected = ratio**2 / (1 + ratio) ** 2
    assert REPAIRED.unavailability(["both", "one"]) == pytest.approx(expected, rel=1e-14)
    assert REPAIRED.availability(["both", "one"]) == pytest.approx(1 - expected, rel=1e-15)
    assert REPAIRED.failure_frequency(["both", "one"]) == pytest.approx(
        expected * 2 * REPAIR, rel=1e-14
    )


def test_rare_states_keep_their_digits_in_the_long_run():
    # Birth and death: pi_k = (1e-6)^k pi_0.
    rates = {f"s{k}": {} for k in range(6)}
    for k in range(5):
        rates[f"s{k}"][f"s{k + 1}"] = 1e-6
        rates[f"s{k + 1}"][f"s{k}"] = 1.0
    shares = ContinuousChain(rates).steady_state()
    assert shares["s5"] == pytest.approx(1e-30 * (1 - 1e-6), rel=1e-12)


def test_states_that_are_left_for_good_have_no_share():
    chain = ContinuousChain({"start": {"a": 1.0}, "a": {"b": 1.0}, "b": {"a": 3.0}})
    assert chain.steady_state() == pytest.approx({"start": 0.0, "a": 0.75, "b": 0.25})
    assert ContinuousChain({"a": {"end": 1.0}}, ("end",)).steady_state() == {"a": 0.0, "end": 1.0}


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: ContinuousChain({"a": {"b": 1.0}}, ("c",)),
            "state 'a': 'b' is not a state of the chain",
        ),
        (lambda: ContinuousChain({"a": {"a": -1.0}}), "state 'a': -1.0 to 'a' is not a rate"),
        (lambda: ContinuousChain({"a": {"e": math.inf}}, ("e",)), "state 'a': inf to 'e'"),
        (lambda: ContinuousChain({"a": {}}, ("a",)), "duplicate state 'a'"),
        (lambda: PAIR.solve("none"), "entry 'none' is not a transient state"),
        (lambda: REPAIRED.solve("both"), "no absorbing state can be reached from both, one, none"),
        (lambda: REPAIRED.embedded(), "no absorbing state can be reached from both, one, none"),
        (lambda: PAIR.transient("both", -1.0), "time -1.0: give a time of 0 or more"),
        (lambda: PAIR.transient("both", math.nan), "time nan: give a time"),
        (lambda: REPAIRED.availability(["all"]), "'all' is not a state of the chain; .*both"),
        (
            lambda: ContinuousChain({"s": {"a": 1.0, "b": 1.0}}, ("a", "b")).steady_state(),
            "the steady state depends on the start: '[ab]' and '[ab]' cannot",
        ),
        (lambda: ContinuousChain({}).steady_state(), "a chain without states has no steady state"),
        (
            lambda: (
                ContinuousChain({"a": {"x": 1.0, "y": 1.0}}, ("x", "y"))
                .solve("a")
                .expected_time_given([])
            ),
            "no target is never reached from 'a'",
        ),
    ],
)
def test_what_makes_no_sense_is_refused(make, message):
    with pytest.raises(ModelError, match=message):
        make()


def test_too_many_moves_of_a_large_chain_are_refused():
    rates = {f"s{i}": {f"s{(i + 1) % 2500}": 1.0} for i in range(2500)}
    with pytest.raises(TooLargeError, match=r"2500 states that move 1.1e\+12 times"):
        ContinuousChain(rates).transient("s0", 1e12)


def test_states_without_a_row_absorb_where_none_is_named():
    chain = ContinuousChain({"up": {"worn": 2.0, "down": 1.0}, "worn": {"down": 3.0}})
    assert chain == ContinuousChain(chain.rates, ("down",))
    assert chain.solve("up").absorption() == {"down": 1.0}
    assert chain.transient("up", 0.1)["up"] == pytest.approx(math.exp(-0.3), rel=1e-14)
    # A state with an empty row stays one that is not absorbing, as before.
    assert ContinuousChain({"up": {"down": 1.0}, "down": {}}).absorbing == ()


def test_rates_beyond_all_numbers_are_refused():
    with pytest.raises(
        ModelError, match=r"state 'a': the sum of its rates overflows; give all rates"
    ):
        ContinuousChain({"a": {"b": 1e308, "c": 1e308}, "b": {"a": 1.0}, "c": {"a": 1.0}})
    chain = ContinuousChain({"a": {"b": 1e300}, "b": {"a": 1.0}})
    with pytest.raises(TooLargeError, match=r"makes too many transitions to count"):
        chain.transient("a", 1e300)
