"""The elimination order: each state once, and little fill-in where little is needed."""

import numpy as np
import pytest
import scipy.sparse as sp

from tracerisk.prm.other_models.markov.large.factors import Budget, Weights, eliminate, plan
from tracerisk.prm.other_models.markov.large.ordering import TOO_DENSE, minimum_degree


def weights_of(pattern):
    """A chain whose ways are those of a symmetric pattern, one in ten of them out of it."""
    ways = sp.csr_array(pattern, dtype=float)
    ways.setdiag(0.0)
    ways.eliminate_zeros()
    n = ways.shape[0]
    return Weights(
        ways.indptr.astype(np.int64),
        ways.indices.astype(np.int32),
        ways.data,
        np.full(n, 0.1),
        np.zeros(n),
        np.ones(n, np.int32),
    )


def line(n):
    return sp.diags_array([np.ones(n - 1), np.ones(n - 1)], offsets=[1, -1], shape=(n, n))


def square(side):
    one = sp.eye_array(side)
    return sp.kron(line(side), one) + sp.kron(one, line(side))


def star(n):
    pattern = sp.lil_array((n, n))
    pattern[0, 1:] = 1.0
    pattern[1:, 0] = 1.0
    return pattern


def tree(n):
    child = np.arange(1, n)
    parent = (child - 1) // 2
    half = sp.csr_array((np.ones(n - 1), (parent, child)), shape=(n, n))
    return half + half.T


@pytest.mark.parametrize(
    ("pattern", "most"),
    [
        (line(5000), 5000),
        (tree(5000), 5000),
        (star(5000), 5000),
        # Row by row it would be 50 for each of the 2,500 states.
        (square(50), 40_000),
    ],
    ids=["line", "tree", "star", "square"],
)
def test_each_state_leaves_once_and_few_new_ways_arise(pattern, most):
    weights = weights_of(pattern)
    how = plan(weights, Budget())
    assert sorted(how.order.tolist()) == list(range(weights.size))
    assert how.rank[how.order].tolist() == list(range(weights.size))
    rest = weights.size - how.head
    assert how.out_ptr[-1] + rest * (rest - 1) // 2 <= most


@pytest.mark.parametrize("seed", range(10))
def test_random_patterns_are_ordered_and_solved(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 200))
    half = sp.csr_array(rng.random((n, n)) < rng.random() * 0.1, dtype=float)
    pattern = half + half.T
    weights = weights_of(pattern)
    factors = eliminate(weights, plan(weights, Budget()))
    ways = sp.csr_array((weights.data, weights.indices, weights.indptr), shape=(n, n)).toarray()
    matrix = np.diag(ways.sum(axis=1) + weights.slack) - ways
    reward = rng.random(n)
    assert matrix @ factors.right(reward) == pytest.approx(reward, rel=1e-9)
    assert factors.left(reward) @ matrix == pytest.approx(reward, rel=1e-9)


def test_a_pattern_that_fills_in_beyond_the_budget_has_no_order():
    rng = np.random.default_rng(1)
    half = sp.csr_array(rng.random((400, 400)) < 0.02, dtype=float)
    weights = weights_of(half + half.T)
    assert plan(weights, Budget(dense_rest=100)) is None
    assert plan(weights, Budget(products=1000.0)) is None
    _, head = minimum_degree(400, weights.indptr, weights.indices, 100, 1e9)
    assert head == TOO_DENSE
