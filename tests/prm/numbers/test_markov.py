from fractions import Fraction

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from tracerisk.errors import ModelError
from tracerisk.prm import MarkovChain

LIMIT = 1e-12


def check_against_rationals(exact, chain, entry):
    """Compare visits and absorptions with exact rationals of the same normalised rows."""
    rows = exact.normalised(chain.transitions)
    expected_visits = exact.visits(rows, entry)
    solution = chain.solve(entry)
    for state, found in solution.expected_visits().items():
        assert_close(found, expected_visits[state])
    absorption = solution.absorption()
    for target in chain.absorbing:
        expected = sum(
            (expected_visits[s] * rows[s].get(target, Fraction(0)) for s in rows), Fraction(0)
        )
        assert_close(absorption[target], expected)
        assert_close(solution.absorption_from_each([target])[entry], expected)


def assert_close(found: float, expected: Fraction) -> None:
    if expected == 0:
        assert found == 0.0
    else:
        assert abs(Fraction(found) / expected - 1) < LIMIT


@st.composite
def chains(draw):
    """Draw a chain of up to six states whose weights span thirty orders of magnitude."""
    size = draw(st.integers(1, 6))
    names = [f"s{i}" for i in range(size)]
    weight = st.one_of(st.just(0.0), st.floats(1e-30, 1.0), st.sampled_from([1e-28, 1e-14, 1.0]))
    rows = {}
    for name in names:
        row = {target: draw(weight) for target in [*names, "failed", "done"]}
        total = sum(row.values())
        assume(total > 0.0)
        rows[name] = {target: p / total for target, p in row.items()}
    # A way out of every state, however rare.
    for row in rows.values():
        row["done"] += 1e-25
    return MarkovChain(rows, ("failed", "done"))


@given(chain=chains())
def test_random_chains_equal_exact_rationals(exact, chain):
    check_against_rationals(exact, chain, "s0")


def test_a_ladder_fails_with_1e_28_to_full_precision(exact):
    # Each rung is climbed with 1e-4, else one falls back: the seventh is the failure.
    rows = {
        f"rung{i}": {f"rung{i + 1}" if i < 6 else "failed": 1e-4, "done": 0.5, "rung0": 0.4999}
        for i in range(7)
    }
    chain = MarkovChain(rows, ("failed", "done"))
    assert chain.solve("rung0").absorption()["failed"] < 1e-26
    check_against_rationals(exact, chain, "rung0")


@pytest.mark.parametrize("power", range(4, 29, 4))
def test_the_gambler_who_must_win_n_times_in_a_row_equals_the_closed_form(power):
    # Winning with 1/10 each, else done: 10^-n.
    rows = {f"won{i}": {f"won{i + 1}": 0.1, "done": 0.9} for i in range(power)}
    rows[f"won{power}"] = {"failed": 1.0}
    chain = MarkovChain(rows, ("failed", "done"))
    found = chain.solve("won0").absorption()["failed"]
    assert found == pytest.approx(0.1**power, rel=1e-13)


def test_a_nearly_recurrent_chain_keeps_its_digits(exact):
    leave, fail = 1e-9, 1e-14
    rows = {
        "a": {"b": 1.0 - fail, "failed": fail},
        "b": {"c": 1.0 - fail, "failed": fail},
        "c": {"a": 1.0 - leave - fail, "done": leave, "failed": fail},
    }
    check_against_rationals(exact, MarkovChain(rows, ("failed", "done")), "a")


def test_a_state_that_mostly_stays_is_visited_as_often_as_it_is_not_left():
    rows = {"wait": {"wait": 1.0 - 2.0**-30, "done": 2.0**-30}}
    solution = MarkovChain(rows, ("done",)).solve("wait")
    assert solution.expected_visits() == {"wait": 2.0**30}
    assert solution.absorption() == {"done": 1.0}


def test_rows_are_read_as_divided_by_their_sum(exact):
    rows = {"a": {"b": 0.5 + 4e-10, "done": 0.5 + 4e-10}, "b": {"a": 1.0 - 4e-10}}
    check_against_rationals(exact, MarkovChain(rows, ("done",)), "a")


def test_two_states_equal_the_answer_on_paper():
    # v_a = 1 + v_b/2, v_b = v_a/2: v_a = 4/3, v_b = 2/3.
    rows = {"a": {"b": 0.5, "lost": 0.5}, "b": {"a": 0.5, "won": 0.5}}
    solution = MarkovChain(rows, ("lost", "won")).solve("a")
    assert solution.expected_visits() == pytest.approx({"a": 4 / 3, "b": 2 / 3}, rel=1e-15)
    assert solution.absorption() == pytest.approx({"lost": 2 / 3, "won": 1 / 3}, rel=1e-15)
    assert solution.absorption_from_each(["won"]) == pytest.approx(
        {"a": 1 / 3, "b": 2 / 3}, rel=1e-15
    )


def test_the_order_of_states_does_not_change_the_answer():
    rows = {
        "a": {"b": 0.3, "c": 0.7},
        "b": {"c": 0.9, "failed": 0.1},
        "c": {"a": 0.999, "failed": 1e-12, "done": 0.001 - 1e-12},
    }
    turned = dict(reversed(rows.items()))
    first = MarkovChain(rows, ("failed", "done")).solve("a").absorption()
    second = MarkovChain(turned, ("failed", "done")).solve("a").absorption()
    assert first == pytest.approx(second, rel=1e-14)


def test_a_state_that_is_never_entered_has_no_visits():
    rows = {"a": {"done": 1.0}, "b": {"a": 1.0}}
    assert MarkovChain(rows, ("done",)).solve("a").expected_visits() == {"a": 1.0, "b": 0.0}


def test_a_sparse_chain_of_a_thousand_states_is_solved():
    rows = {f"s{i}": {f"s{i + 1}": 1.0 - 1e-9, "failed": 1e-9} for i in range(1000)}
    rows["s1000"] = {"s0": 0.9, "done": 0.1}
    visits = MarkovChain(rows, ("failed", "done")).solve("s0").expected_visits()
    assert visits["s0"] == pytest.approx(1 / (1 - 0.9 * (1.0 - 1e-9) ** 1000), rel=1e-9)


@pytest.mark.parametrize(
    ("rows", "absorbing", "message"),
    [
        ({"a": {"done": 1.0}}, ("done", "done"), "duplicate state 'done'"),
        (
            {"a": {"dome": 1.0}},
            ("done",),
            "state 'a': 'dome' is not a state .* did you mean 'done'",
        ),
        ({"a": {"a": -0.5, "done": 1.5}}, ("done",), "state 'a': -0.5 to 'a' is not a probability"),
        ({"a": {"done": float("nan")}}, ("done",), "state 'a': nan to 'done'"),
        ({"a": {"done": 0.9}}, ("done",), "state 'a': its transitions sum to 0.9; they must"),
        (
            {"a": {"b": 0.5, "done": 0.5}, "b": {"c": 1.0}, "c": {"b": 1.0}},
            ("done",),
            r"no absorbing state can be reached from b, c; lead each to one \(done\)",
        ),
    ],
)
def test_a_malformed_chain_is_refused_with_its_state(rows, absorbing, message):
    with pytest.raises(ModelError, match=message):
        MarkovChain(rows, absorbing)


def test_an_entry_that_is_no_transient_state_is_refused():
    chain = MarkovChain({"start": {"done": 1.0}}, ("done",))
    with pytest.raises(ModelError, match=r"entry 'stat' .* did you mean 'start'"):
        chain.solve("stat")
    with pytest.raises(ModelError, match="'start' is not an absorbing state; allowed: done"):
        chain.solve("start").absorption_from_each(["start"])


def test_an_exit_below_double_precision_is_an_error_not_a_division_by_zero():
    tiny = 1e-200
    rows = {
        "a": {"b": 1.0},
        "b": {"a": 1.0, "c": tiny},
        "c": {"a": 1.0, "done": tiny},
    }
    chain = MarkovChain(rows, ("done",))
    with pytest.raises(ModelError, match=r"state '.' is left with a probability below 2e-308"):
        chain.solve("a")
