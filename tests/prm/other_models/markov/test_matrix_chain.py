"""Chains as arrays: compiled elimination, iteration, and the bounds that come with them."""

import math
from fractions import Fraction

import numpy as np
import pytest
import scipy.sparse as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from tracerisk.errors import ModelError, TooLargeError
from tracerisk.prm import MarkovChain
from tracerisk.prm.other_models.markov.large.factors import Budget

LIMIT = 1e-12
ONLY_ITERATION = Budget(dense_rest=0, entries=0)
ITERATION_FIRST = Budget(iterate_first=-1.0)


def chain_of(n, entries, absorbing):
    """A chain of n states from (row, column, value) triples."""
    rows, columns, values = zip(*entries, strict=True)
    return MarkovChain.from_matrix(sp.csr_array((values, (rows, columns)), shape=(n, n)), absorbing)


def walk(n, failure=1e-8, seed=1):
    """States in a band: mostly onwards, at times back or by a random branch; failed is n + 1."""
    rng = np.random.default_rng(seed)
    state = np.arange(n)
    targets = np.stack(
        [
            state + 1,
            np.maximum(state - 1, 0),
            np.clip(state + rng.integers(-9, 10, n), 0, n - 1),
        ],
        axis=1,
    )
    weights = rng.random((n, 3)) * [3.0, 1.0, 1.0]
    weights *= (1.0 - failure) / weights.sum(axis=1, keepdims=True)
    rows = np.concatenate((np.repeat(state, 3), state))
    columns = np.concatenate((targets.ravel(), np.full(n, n + 1)))
    values = np.concatenate((weights.ravel(), np.full(n, failure)))
    return sp.csr_array((values, (rows, columns)), shape=(n + 2, n + 2))


def scattered(n, failure=1e-7, leave=1e-2, seed=3):
    """States with four ways to anywhere: elimination fills them in. Failed is n + 1."""
    rng = np.random.default_rng(seed)
    weights = rng.random((n, 4)) + 0.1
    weights *= (1.0 - failure - leave) / weights.sum(axis=1, keepdims=True)
    state = np.arange(n)
    rows = np.concatenate((np.repeat(state, 4), state, state))
    columns = np.concatenate((rng.integers(0, n, 4 * n), np.full(n, n), np.full(n, n + 1)))
    values = np.concatenate((weights.ravel(), np.full(n, leave), np.full(n, failure)))
    return sp.csr_array((values, (rows, columns)), shape=(n + 2, n + 2))


@st.composite
def matrices(draw):
    """Draw the rows of a chain of up to eight states, over thirty orders of magnitude."""
    size = draw(st.integers(1, 8))
    weight = st.one_of(st.just(0.0), st.floats(1e-30, 1.0), st.sampled_from([1e-28, 1e-14, 1.0]))
    rows = np.array([[draw(weight) for _ in range(size + 2)] for _ in range(size)])
    rows[:, size + 1] += 1e-25
    rows /= rows.sum(axis=1, keepdims=True)
    return np.vstack((rows, np.zeros((2, size + 2))))


def exact_rows(matrix):
    size = len(matrix) - 2
    return {i: {j: Fraction(p) for j, p in enumerate(matrix[i]) if p} for i in range(size)}


@settings(max_examples=25, deadline=None)
@given(matrix=matrices())
def test_random_matrices_equal_exact_rationals(exact, matrix):
    size = len(matrix) - 2
    rows = exact.normalised(exact_rows(matrix))
    expected = exact.visits(rows, 0)
    solution = MarkovChain.from_matrix(matrix, [size, size + 1]).solve(0)
    visits = solution.expected_visits()
    failure = sum((expected[i] * rows[i].get(size, Fraction(0)) for i in rows), Fraction(0))
    found = solution.absorption()[size]
    from_each = solution.absorption_from_each([size])[0]
    for value, answer in [
        *((visits[i], expected[i]) for i in rows),
        (found, failure),
        (from_each, failure),
    ]:
        if answer == 0:
            assert value == 0.0
        else:
            assert abs(Fraction(float(value)) / answer - 1) < LIMIT


@pytest.mark.parametrize(
    ("leave", "fail"), [(1e-9, 1e-14), (1e-17, 1e-24), (1e-28, 1e-30), (1e-100, 1e-110)]
)
def test_a_chain_that_hardly_ever_ends_keeps_its_digits(exact, leave, fail):
    matrix = np.zeros((5, 5))
    matrix[0, [1, 4]] = 1.0, fail
    matrix[1, [2, 4]] = 1.0, fail
    matrix[2, [0, 3, 4]] = 1.0 - leave, leave, fail
    rows = exact.normalised(exact_rows(matrix))
    expected = exact.visits(rows, 0)
    solution = MarkovChain.from_matrix(matrix, [3, 4]).solve(0)
    failure = sum((expected[i] * rows[i].get(4, Fraction(0)) for i in rows), Fraction(0))
    assert abs(Fraction(float(solution.absorption()[4])) / failure - 1) < LIMIT
    assert abs(Fraction(float(solution.absorption_from_each([4])[0])) / failure - 1) < LIMIT


@pytest.mark.parametrize("budget", [None, ONLY_ITERATION], ids=["elimination", "iteration"])
def test_the_bounds_hold_against_exact_rationals(exact, budget):
    rng = np.random.default_rng(5)
    proven = 0
    for _ in range(40):
        n = int(rng.integers(2, 12))
        weights = rng.random((n, n + 2)) * 10.0 ** -rng.integers(0, 20, (n, n + 2))
        weights *= rng.random((n, n + 2)) < 0.5
        weights[:, n] += 10.0 ** -rng.integers(1, 20)
        weights[:, n + 1] += 10.0 ** -rng.integers(5, 20)
        matrix = np.zeros((n + 2, n + 2))
        matrix[:n] = weights / weights.sum(axis=1, keepdims=True)
        rows = exact.normalised(exact_rows(matrix))
        expected = exact.visits(rows, 0)
        try:
            solution = MarkovChain.from_matrix(matrix, [n, n + 1]).solve(0, budget)
            each = solution.certified_absorption_from_each([n + 1])
        except TooLargeError:
            # An iteration that cannot be certified gives no answer.
            continue
        proven += solution.error_bound < 1e-15 and each.bound < 1e-15
        failure = sum((expected[i] * rows[i].get(n + 1, Fraction(0)) for i in rows), Fraction(0))
        assert abs(Fraction(float(each.values[0])) / failure - 1) <= each.bound
        for state, visits in expected.items():
            found = Fraction(float(solution.expected_visits()[state]))
            assert abs(found - visits) <= Fraction(solution.error_bound) * visits
    assert proven > 20


def test_a_cycle_of_many_states_equals_the_closed_form():
    # n states in a ring, each fails with f; from the last one the mission ends with 1/10.
    n, f = 100_000, 2.0**-30
    state = np.arange(n)
    onward = np.full(n, 1.0 - f)
    onward[-1] = 0.875 - f
    rows = np.concatenate((state, state, [n - 1]))
    columns = np.concatenate(((state + 1) % n, np.full(n, n + 1), [n]))
    values = np.concatenate((onward, np.full(n, f), [0.125]))
    matrix = sp.csr_array((values, (rows, columns)), shape=(n + 2, n + 2))
    solution = MarkovChain.from_matrix(matrix, [n, n + 1]).solve(0)
    reached = math.exp((n - 1) * math.log1p(-f))
    done = reached * 0.125 / (1.0 - reached * (0.875 - f))
    assert solution.absorption()[n] == pytest.approx(done, rel=1e-13)
    assert solution.error_bound < 1e-15


def test_a_star_whose_hub_leads_to_each_of_many_states():
    n, f = 20_000, 1e-9
    leaf = np.arange(1, n)
    ahead = np.full(n - 1, 0.5 / (n - 1))
    rows = np.concatenate((np.zeros(n - 1, int), [0], leaf, leaf))
    columns = np.concatenate((leaf, [n], np.zeros(n - 1, int), np.full(n - 1, n + 1)))
    values = np.concatenate((ahead, [0.5], np.full(n - 1, 1.0 - f), np.full(n - 1, f)))
    matrix = sp.csr_array((values, (rows, columns)), shape=(n + 2, n + 2))
    solution = MarkovChain.from_matrix(matrix, [n, n + 1]).solve(0)
    # Half of the visits of the hub lead to a leaf, where f fails and the rest comes back.
    out = float(ahead.sum()) + 0.5
    leaves = float(ahead.sum()) / out
    assert solution.absorption()[n + 1] == pytest.approx(
        leaves * f / (1.0 - leaves + leaves * f), rel=1e-11
    )
    assert solution.expected_visits()[1:n].std() < 1e-18


def test_elimination_and_iteration_agree_where_elimination_fills_in():
    matrix = scattered(600)
    chain = MarkovChain.from_matrix(matrix, [600, 601])
    eliminated, iterated = chain.solve(0), chain.solve(0, ONLY_ITERATION)
    assert (eliminated.method, iterated.method) == ("elimination", "iteration")
    assert iterated.error_bound < 1e-13
    assert eliminated.expected_visits() == pytest.approx(iterated.expected_visits(), rel=1e-15)
    assert eliminated.absorption_from_each([601]) == pytest.approx(
        iterated.absorption_from_each([601]), rel=1e-15
    )
    # Own elimination in dense arrays: its last block, and rows behind a block.
    assert 600 - eliminated._solver._eliminated.plan.head > 200


def test_iteration_is_tried_first_where_elimination_is_dear_and_left_where_it_is_not_certain():
    easy = MarkovChain.from_matrix(scattered(300), [300, 301]).solve(0, ITERATION_FIRST)
    assert easy.method == "iteration"
    assert easy.error_bound < 1e-13
    hard = MarkovChain.from_matrix(walk(3000), [3000, 3001]).solve(0, ITERATION_FIRST)
    assert hard.method == "elimination"
    assert hard.error_bound < 1e-13


def test_a_chain_that_neither_way_solves_is_refused_with_what_was_tried():
    # Up and down alike along a line: iteration crawls.
    n = 4000
    state = np.arange(n)
    rows = np.concatenate((state, state))
    columns = np.concatenate((np.append(state[1:], n), np.maximum(state - 1, 0)))
    matrix = sp.csr_array((np.full(2 * n, 0.5), (rows, columns)), shape=(n + 1, n + 1))
    chain = MarkovChain.from_matrix(matrix, [n])
    assert chain.solve(0).expected_steps() == pytest.approx(n * (n + 1), rel=1e-14)
    with pytest.raises(TooLargeError, match="4000 transient states: the fill-in"):
        chain.solve(0, ONLY_ITERATION)


def test_names_stand_for_indices():
    matrix = np.array([[0.5, 0.25, 0.25], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    chain = MarkovChain.from_matrix(matrix, ["lost", "won"], ["play", "lost", "won"])
    solution = chain.solve("play")
    assert solution.absorption_from_each(["won"]).tolist() == [0.5, 0.0, 1.0]
    assert solution.expected_visits().tolist() == [2.0, 0.0, 0.0]
    assert MarkovChain.from_matrix(matrix).absorbing.tolist() == [False, True, True]
    assert MarkovChain.from_matrix(matrix, [False, True, True]).solve(0).expected_steps() == 2.0


def test_figures_of_arrays_equal_those_of_names():
    matrix = walk(40, failure=1e-3).toarray()
    names = [f"s{i}" for i in range(42)]
    rows = {names[i]: {names[j]: p for j, p in enumerate(matrix[i]) if p > 0.0} for i in range(40)}
    named = MarkovChain(rows, (names[40], names[41])).solve("s3")
    arrays = MarkovChain.from_matrix(matrix, [40, 41], names).solve("s3")
    times = np.linspace(1.0, 2.0, 42)
    by_name = dict(zip(names[:40], times[:40].tolist(), strict=True))
    close = {"rel": 1e-13}
    assert arrays.expected_visits()[:40].tolist() == pytest.approx(
        list(named.expected_visits().values()), **close
    )
    assert arrays.expected_steps() == pytest.approx(named.expected_steps(), **close)
    assert arrays.expected_time(times) == pytest.approx(named.expected_time(by_name), **close)
    assert arrays.expected_time_from_each(times)[:40].tolist() == pytest.approx(
        list(named.expected_time_from_each(by_name).values()), **close
    )
    assert arrays.expected_time_given(["s41"], times) == pytest.approx(
        named.expected_time_given(["s41"], by_name), **close
    )
    assert arrays.per_time([41], times) == pytest.approx(named.per_time(["s41"], by_name), **close)
    ours, theirs = arrays.cycles([41]), named.cycles(["s41"])
    assert (ours.failure, ours.end, ours.back) == pytest.approx(
        (theirs.failure, theirs.end, theirs.back), **close
    )
    assert arrays.chain.transient_distribution("s3", 7) == pytest.approx(
        np.linalg.matrix_power(np.vstack((matrix[:40], np.eye(42)[40:])), 7)[3], rel=1e-12
    )


def test_large_chains_by_name_are_solved_like_small_ones():
    matrix = walk(800).toarray()
    rows = {f"s{i}": {f"s{j}": p for j, p in enumerate(matrix[i]) if p > 0.0} for i in range(800)}
    solution = MarkovChain(rows, ("s800", "s801")).solve("s0")
    arrays = MarkovChain.from_matrix(matrix, [800, 801]).solve(0)
    assert solution.absorption()["s801"] == pytest.approx(arrays.absorption()[801], rel=1e-14)
    assert solution.absorption_from_each(["s801"])["s5"] == pytest.approx(
        arrays.absorption_from_each([801])[5], rel=1e-14
    )


GOOD = np.array([[0.5, 0.5], [0.0, 1.0]])


@pytest.mark.parametrize(
    ("matrix", "options", "message"),
    [
        (np.ones((2, 3)), {}, r"a matrix of shape \(2, 3\); expected a row and a column"),
        (np.array([["a"]]), {}, "a matrix of <U1; give floating-point numbers"),
        ([[0.5, 0.4], [0.0, 1.0]], {}, "state 0: its transitions sum to 0.9; they must sum to 1"),
        ([[1.5, -0.5], [0.0, 1.0]], {}, "state 0: -0.5 to 1 is not a probability"),
        ([[math.nan, 0.5], [0.0, 1.0]], {}, "state 0: nan to 0 is not a probability"),
        (GOOD, {"names": ["a", "a"]}, "duplicate state 'a' in the chain"),
        (GOOD, {"names": ["a"]}, "1 names for 2 states"),
        (GOOD, {"absorbing": [2]}, "absorbing: 2 is not a state; the states are 0 to 1"),
        (
            GOOD,
            {"absorbing": [True]},
            r"absorbing: shape \(1,\); expected one mark for each of 2 states",
        ),
        (GOOD, {"absorbing": [0, 1]}, "state 0 is marked as absorbing but has transitions"),
        (
            np.eye(8, k=1) + np.eye(8, k=-7),
            {},
            r"can be reached from 0, 1, 2, 3, 4 and 3 more states; lead each to one \(there is none\)",
        ),
        (
            [[0.0, 0.5, 0.5], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            {"absorbing": [1], "names": ["a", "b", "c"]},
            "no absorbing state can be reached from 'c'; lead each to one",
        ),
    ],
)
def test_a_malformed_matrix_is_refused_with_its_state(matrix, options, message):
    with pytest.raises(ModelError, match=message):
        MarkovChain.from_matrix(np.asarray(matrix), **options)


def test_states_that_are_not_there_are_refused():
    chain = MarkovChain.from_matrix(GOOD, names=["go", "end"])
    with pytest.raises(ModelError, match="'ende' is not a state of the chain; did you mean 'end'"):
        chain.solve("ende")
    with pytest.raises(ModelError, match="5 is not a state of the chain; its states are 0 to 1"):
        chain.solve(5)
    with pytest.raises(ModelError, match="entry 'end' is not a transient state"):
        chain.solve(1)
    with pytest.raises(ModelError, match="'go' is not an absorbing state"):
        chain.solve(0).absorption_from_each([0])
    with pytest.raises(
        ModelError, match="'x' is not a state of the chain; the states have no names"
    ):
        MarkovChain.from_matrix(GOOD).solve("x")
    with pytest.raises(ModelError, match="-1 steps; allowed: 0 or more"):
        chain.transient_distribution(0, -1)
    with pytest.raises(ModelError, match=r"duration of state 0: -1.0 is not a time"):
        chain.solve(0).expected_time(-1.0)
    with pytest.raises(
        ModelError, match="the mean time to absorption is 0: no visit has a duration"
    ):
        chain.solve(0).per_time([1], 0.0)
    unreached = np.array([[0.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    with pytest.raises(ModelError, match="the targets are never reached"):
        MarkovChain.from_matrix(unreached).solve(0).expected_time_given([2], 1.0)


def test_an_exit_below_double_precision_is_reported_with_its_state():
    matrix = np.zeros((700, 700))
    for state in range(699):
        matrix[state, [0, state + 1]] = 1.0, 1e-5
    matrix[0, 0] = 0.0
    matrix[0, 1] = 1.0
    matrix /= np.maximum(matrix.sum(axis=1, keepdims=True), 1e-300)
    chain = MarkovChain.from_matrix(matrix, [699])
    with pytest.raises(ModelError, match=r"state \d+ is left with a probability below 2e-308"):
        chain.solve(0)
