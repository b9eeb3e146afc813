"""Times, cycles and distributions after a number of steps, against answers on paper."""

import math
from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tracerisk.errors import ModelError
from tracerisk.prm import MarkovChain

PLAY = MarkovChain({"a": {"b": 0.5, "lost": 0.5}, "b": {"a": 0.5, "won": 0.5}}, ("lost", "won"))
RARE = MarkovChain(
    {
        "a": {"b": 1.0 - 1e-20, "failed": 1e-20},
        "b": {"a": 0.9, "done": 0.1 - 1e-18, "failed": 1e-18},
    },
    ("failed", "done"),
)


def test_times_equal_the_answer_on_paper():
    # v_a = 4/3, v_b = 2/3; from b v_b = 4/3, v_a = 2/3.
    solution = PLAY.solve("a")
    times = {"a": 3.0, "b": 6.0}
    assert solution.expected_steps() == pytest.approx(2.0, rel=1e-15)
    assert solution.expected_time(times) == pytest.approx(8.0, rel=1e-15)
    assert solution.expected_time_from_each(times) == pytest.approx({"a": 8.0, "b": 10.0})
    # Lost after 1, 3, 5, ... visits: 3 + 9 k with probability (3/4) (1/4)^k, so 3 + 9/3.
    assert solution.expected_time_given(["lost"], times) == pytest.approx(6.0, rel=1e-15)
    # Won after 9 + 9 k: 9 + 3; and 2/3 of 6 and 1/3 of 12 make 8.
    assert solution.expected_time_given(["won"], times) == pytest.approx(12.0, rel=1e-15)
    assert solution.per_time(["lost"], times) == pytest.approx(1 / 12, rel=1e-15)


def test_the_time_until_a_failure_of_1e_19_given_that_it_happens():
    solution = RARE.solve("a")
    # Ten cycles of two steps; the failure hits a uniformly drawn one of geometrically many.
    given_failure = solution.expected_time_given(["failed"], {"a": 1.0, "b": 1.0})
    a, b = 1e-20, 1e-18
    expected = (a * (2 * 9 + 1) + b * (2 * 9 + 2)) / (a + b)
    assert given_failure == pytest.approx(expected, rel=1e-12)
    assert solution.per_time(["failed"], {"a": 0.5, "b": 0.5}) == pytest.approx(
        10 * (a + b) / 10, rel=1e-12
    )


def test_cycles_multiply_up_to_the_whole():
    cycle = RARE.solve("a").cycles(["failed"])
    assert cycle.failure == pytest.approx(1.01e-18, rel=1e-13)
    assert (cycle.end, cycle.back) == pytest.approx((0.1, 0.9), rel=1e-13)
    assert cycle.begun(1) == 1.0
    assert cycle.begun(3) == pytest.approx(0.81, rel=1e-13)
    assert cycle.failure_in(3) == pytest.approx(0.81 * 1.01e-18, rel=1e-12)
    assert cycle.failure_within(1) == pytest.approx(cycle.failure, rel=1e-13)
    assert cycle.failure_within(2) == pytest.approx(1.9 * 1.01e-18, rel=1e-12)
    assert cycle.failure_within(10**6) == pytest.approx(
        RARE.solve("a").absorption()["failed"], rel=1e-13
    )


def test_cycles_that_seldom_end_keep_their_digits():
    rows = {"a": {"a": 1.0 - 1e-15 - 1e-25, "done": 1e-15, "failed": 1e-25}}
    cycle = MarkovChain(rows, ("failed", "done")).solve("a").cycles(["failed"])
    assert cycle.failure_within(1000) == pytest.approx(1000 * 1e-25, rel=1e-12)
    assert cycle.begun(10**15) == pytest.approx(math.exp(-1.0), rel=1e-9)


def test_a_chain_that_never_comes_back_has_one_cycle():
    cycle = MarkovChain({"a": {"b": 1.0}, "b": {"done": 1.0}}, ("done",)).solve("a").cycles([])
    assert (cycle.failure, cycle.end, cycle.back) == (0.0, 1.0, 0.0)
    assert (cycle.begun(2), cycle.failure_within(5)) == (0.0, 0.0)


def exact_distribution(chain, entry, steps):
    names = [*chain.transitions, *chain.absorbing]
    now = {name: Fraction(int(name == entry)) for name in names}
    for _ in range(steps):
        following = dict.fromkeys(names, Fraction(0))
        for state, mass in now.items():
            row = chain.transitions.get(state, {state: 1.0})
            total = sum(map(Fraction, row.values()))
            for target, p in row.items():
                following[target] += mass * Fraction(p) / total
        now = following
    return now


@settings(max_examples=20, deadline=None)
@given(
    weights=st.lists(
        st.lists(st.sampled_from([0.0, 1e-20, 1e-7, 0.3, 1.0]), min_size=5, max_size=5),
        min_size=3,
        max_size=3,
    ),
    steps=st.integers(0, 40),
)
def test_the_distribution_after_some_steps_equals_exact_rationals(weights, steps):
    names = ["a", "b", "c", "failed", "done"]
    rows = {}
    for name, row in zip(names, weights, strict=False):
        row = [*row[:4], row[4] + 1e-9]
        rows[name] = {t: p / math.fsum(row) for t, p in zip(names, row, strict=True)}
    chain = MarkovChain(rows, ("failed", "done"))
    found = chain.transient("a", steps)
    for name, expected in exact_distribution(chain, "a", steps).items():
        if expected < 1e-290:
            # Numbers below 2e-308 have fewer digits.
            assert 0.0 <= found[name] < 1e-289
        else:
            assert abs(Fraction(found[name]) / expected - 1) < 1e-12


@pytest.mark.parametrize("states", [3, 40, 700])
def test_many_steps_of_a_ring_that_seldom_fails(states):
    # Stepping, squaring in Python and squaring in arrays; f fails at each step.
    f = 1e-22
    rows = {
        f"s{i}": {f"s{(i + 1) % states}": 1.0 - 1e-7, "done": 1e-7 - f, "failed": f}
        for i in range(states)
    }
    steps = 5_000_000 if states < 700 else 3_000
    found = MarkovChain(rows, ("failed", "done")).transient("s0", steps)
    alive = math.exp(steps * math.log1p(-1e-7))
    assert found[f"s{steps % states}"] == pytest.approx(alive, rel=1e-9)
    assert found["failed"] == pytest.approx(
        -math.expm1(steps * math.log1p(-1e-7)) * f / 1e-7, rel=1e-9
    )


def test_an_absorbing_state_keeps_what_it_has():
    later = PLAY.transient("a", 100_000)
    assert later["lost"] == pytest.approx(2 / 3, rel=1e-14)
    assert math.fsum(later.values()) == pytest.approx(1.0, rel=1e-15)


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda s: s.expected_time({"a": 1.0}), "no duration for b; give each state one"),
        (lambda s: s.expected_time({"a": 1.0, "c": 1.0}), "duration of 'c': no such state; .*a, b"),
        (lambda s: s.expected_time({"a": -1.0, "b": 1.0}), "duration of 'a': -1.0 is not a time"),
        (
            lambda s: s.expected_time({"a": math.nan, "b": 1.0}),
            "duration of 'a': nan is not a time",
        ),
        (lambda s: s.per_time(["lost"], {"a": 0.0, "b": 0.0}), "the mean time to absorption is 0"),
        (lambda s: s.cycles(["a"]), "'a' is not an absorbing state; allowed: lost, won"),
        (lambda s: s.expected_time_given([], {"a": 1.0, "b": 1.0}), "no target is never reached"),
        (lambda s: s.cycles(["won"]).begun(0), "cycle 0; cycles are numbered from 1"),
        (lambda s: PLAY.transient("a", -1), "-1 steps; allowed: 0 or more"),
        (lambda s: PLAY.transient("won", 1), "entry 'won' is not a transient state"),
    ],
)
def test_figures_that_make_no_sense_are_refused(ask, message):
    with pytest.raises(ModelError, match=message):
        ask(PLAY.solve("a"))
