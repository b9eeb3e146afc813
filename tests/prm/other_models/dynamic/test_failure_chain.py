"""Chains that fail, against matrix exponentials of sixty digits and more."""

import random
import re

import pytest

from tracerisk.errors import TooLargeError
from tracerisk.prm.other_models.dynamic.failure_chain import FailureChain

mpmath = pytest.importorskip("mpmath", reason="mpmath gives the exact figures")


def drawn_chain(seed, states, exponents):
    """A random chain without a way back, its rates of many sizes."""
    rng = random.Random(seed)
    transitions = []
    for source in range(1, states):
        following = 0 if source == states - 1 else source + 1
        transitions += [
            (source, target, 10.0 ** rng.uniform(*exponents))
            for target in sorted({following, *rng.sample(range(states), 2)})
            if target > source or (target == 0 and source > states // 2)
        ]
    return FailureChain(states, ((1, 0.75), (2, 0.25)), tuple(transitions))


def exact(chain, time):
    with mpmath.workdps(150):
        generator = mpmath.matrix(chain.states, chain.states)
        for source, target, rate in chain.transitions:
            generator[source, target] += mpmath.mpf(rate)
            generator[source, source] -= mpmath.mpf(rate)
        start = mpmath.matrix(1, chain.states)
        for state, share in chain.initial:
            start[0, state] = mpmath.mpf(share)
        end = start * mpmath.expm(generator * mpmath.mpf(time), method="taylor")
        return float(end[0, 0]), float(mpmath.fsum(end[0, i] for i in range(1, chain.states)))


@pytest.mark.parametrize("exponents", [(-12, -9), (-9, 0), (-2, 1.5)])
@pytest.mark.parametrize("seed", range(6))
def test_both_halves_keep_their_digits(seed, exponents):
    chain = drawn_chain(seed, 8, exponents)
    found = chain.failed_by(1.0)
    p, q = exact(chain, 1.0)
    assert found.p == pytest.approx(p, rel=1e-13, abs=0)
    assert found.q == pytest.approx(q, rel=1e-13, abs=0)


def test_a_large_chain_is_solved_alike():
    """A cold group of 300 phases, which takes arrays: Poisson's law by mpmath."""
    chain = FailureChain(
        301, ((1, 1.0),), tuple((k, k + 1 if k < 300 else 0, 250.0) for k in range(1, 301))
    )
    found = chain.failed_by(1.0)
    with mpmath.workdps(40):
        p = mpmath.gammainc(300, 0, 250, regularized=True)
    assert found.p == pytest.approx(float(p), rel=1e-12)
    assert found.q == pytest.approx(float(1 - p), rel=1e-12)


def test_what_cannot_fail_or_has_failed_is_certain():
    assert FailureChain(3, ((1, 1.0),), ((1, 2, 5.0),)).failed_by(10.0) == (0.0, 1.0)
    assert FailureChain(2, ((1, 1.0),), ((1, 0, 5.0),)).failed_by(0.0) == (0.0, 1.0)
    assert FailureChain(1, ((0, 1.0),), ()).failed_by(7.0) == (1.0, 0.0)


def test_survival_of_many_events_is_not_lost():
    found = FailureChain(2, ((1, 1.0),), ((1, 0, 650.0),)).failed_by(1.0)
    with mpmath.workdps(40):
        assert found.q == pytest.approx(float(mpmath.exp(-650)), rel=1e-12, abs=0)


@pytest.mark.parametrize(("fast", "slow"), [(1e6, 1e-9), (1e12, 1e-20), (3e3, 2.0), (5e4, 30.0)])
def test_fast_events_beside_slow_ones_cost_no_digits(fast, slow):
    chain = FailureChain(
        5,
        ((1, 1.0),),
        ((1, 2, fast), (1, 3, slow), (2, 4, slow), (3, 0, fast / 2), (4, 0, 3 * slow)),
    )
    found = chain.failed_by(1.0)
    with mpmath.workdps(60):
        fast, slow = mpmath.mpf(fast), mpmath.mpf(slow)
        taken = fast / (fast + slow)
        # The fast phase, then two slow ones; or a slow one, then a fast one.
        p = taken * hypoexponential(fast + slow, slow, 3 * slow)
        p += (1 - taken) * hypoexponential(fast + slow, fast / 2)
        assert found.p == pytest.approx(float(p), rel=1e-12, abs=0)
        assert found.q == pytest.approx(float(1 - p), rel=1e-12, abs=0)


def hypoexponential(*rates):
    total = mpmath.mpf(1)
    for i, rate in enumerate(rates):
        others = mpmath.fprod(r / (r - rate) for j, r in enumerate(rates) if j != i)
        total -= others * mpmath.exp(-rate)
    return total


def test_too_many_steps_are_refused():
    chain = FailureChain(
        500, ((1, 1.0),), tuple((k, k + 1 if k < 499 else 0, 1e12) for k in range(1, 500))
    )
    with pytest.raises(TooLargeError, match=re.escape("allowed: 5e+09; shorten the mission")):
        chain.failed_by(1.0)


def test_rates_beyond_all_numbers_are_refused():
    for rates in ((1e308, 1e308), (1e308, 1.0)):
        transitions = ((1, 0, rates[0]), (1, 2, rates[1]), (2, 0, 1.0))
        chain = FailureChain(3, ((1, 1.0),), transitions)
        with pytest.raises(TooLargeError, match=r"of a chain of 3 states overflow in a"):
            chain.failed_by(10.0)
