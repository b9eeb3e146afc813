"""Approximate solution of chains in which elimination fills in, to be refined and certified.

H. A. van der Vorst, "Bi-CGSTAB", SIAM Journal on Scientific and Statistical Computing 13 (1992).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from tracerisk.prm.other_models.markov.large.pattern import Array

if TYPE_CHECKING:
    from tracerisk.prm.other_models.markov.large.factors import Weights

Product = Callable[[Array], Array]

ROUNDS = 12
"""Refinements at most: each takes a new residual and solves for what it shows."""
TRIAL_STEPS = 60
STEPS = 2000
_TOLERANCE = 1e-8
_RESTARTS = 4


class NotConvergedError(ArithmeticError):
    """An iteration did not come to its tolerance within its steps."""


class Iteration:
    """Solves u G = start and G x = reward to about eight digits, of either sign.

    Raises NotConvergedError from a solve that takes more than `steps` steps.
    """

    def __init__(self, weights: Weights, steps: int) -> None:
        from scipy.sparse import csr_array

        n = weights.size
        ways = csr_array((weights.data, weights.indices, weights.indptr), shape=(n, n))
        self._leaving = ways.sum(axis=1) + weights.slack
        self._right = ways
        self._steps = steps
        self._left = ways.T.tocsr()

    def left(self, start: Array) -> Array:
        """Return an approximate u with u G = start; both: (n,)."""
        return self._solve(self._left, start)

    def right(self, reward: Array) -> Array:
        """Return an approximate x with G x = reward; both: (n,)."""
        return self._solve(self._right, reward)

    def _solve(self, ways: Any, given: Array) -> Array:
        """Solve for y = s x, whose equations have a diagonal of ones."""
        leaving = self._leaving
        scale = float(np.abs(given).max(initial=0.0))
        if scale == 0.0:
            return np.zeros_like(given)
        target = given / scale

        def product(y: Array) -> Array:
            return np.asarray(y - ways @ (y / leaving))

        bicgstab = _bicgstab(product, target, self._steps)
        return np.asarray(bicgstab / leaving * scale)


def _bicgstab(product: Product, target: Array, limit: int) -> Array:
    """Return x with product(x) = target to `_TOLERANCE`, in at most `limit` steps.

    The shadow residual is no residual of a sparse target, to which whole steps can be
    orthogonal, but a fixed vector; after a breakdown the iteration starts again from where it is.
    """
    x = np.zeros_like(target)
    goal = _TOLERANCE * float(np.linalg.norm(target))
    best, best_norm = x, float(np.linalg.norm(target))
    shadow = np.cos(np.arange(len(target), dtype=np.float64)) + 1.5
    steps = 0
    for _ in range(_RESTARTS):
        residual = target - product(x)
        direction = np.zeros_like(target)
        image = np.zeros_like(target)
        rho = alpha = omega = 1.0
        while steps < limit:
            steps += 1
            rho_now = float(shadow @ residual)
            if rho_now == 0.0 or omega == 0.0:
                break
            direction = residual + (rho_now / rho) * (alpha / omega) * (direction - omega * image)
            rho = rho_now
            image = product(direction)
            below = float(shadow @ image)
            if below == 0.0:
                break
            alpha = rho / below
            half = residual - alpha * image
            turned = product(half)
            norm = float(turned @ turned)
            omega = float(turned @ half) / norm if norm > 0.0 else 0.0
            x = x + alpha * direction + omega * half
            residual = half - omega * turned
            now = float(np.linalg.norm(residual))
            if not np.isfinite(now):
                x = best
                break
            if now < best_norm:
                best, best_norm = x, now
            # Checked by the equations: what is carried along drifts from them.
            if now <= goal:
                break
        if float(np.linalg.norm(target - product(x))) <= 2.0 * goal:
            return x
        if steps >= limit:
            break
    raise NotConvergedError(f"{best_norm / (goal / _TOLERANCE):.0e} in {steps} steps")
