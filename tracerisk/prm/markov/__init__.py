"""Markov chains whose absorption, visits and times are computed without a subtraction."""

from importlib import import_module
from typing import TYPE_CHECKING

from tracerisk.prm.markov.chain import MarkovChain
from tracerisk.prm.markov.cycles import CycleFigures
from tracerisk.prm.markov.solution import ChainSolution

if TYPE_CHECKING:
    from tracerisk.prm.markov.continuous import ContinuousChain, ContinuousSolution
    from tracerisk.prm.markov.large.matrix_chain import MatrixChain
    from tracerisk.prm.markov.large.matrix_solution import MatrixSolution

__all__ = [
    "ChainSolution",
    "ContinuousChain",
    "ContinuousSolution",
    "CycleFigures",
    "MarkovChain",
    "MatrixChain",
    "MatrixSolution",
]

_ON_DEMAND = {
    "ContinuousChain": "continuous",
    "ContinuousSolution": "continuous",
    "MatrixChain": "large.matrix_chain",
    "MatrixSolution": "large.matrix_solution",
}
"""The modules of names that most programs do not use: imported when they are."""


def __getattr__(name: str) -> object:
    if name not in _ON_DEMAND:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    return getattr(import_module(f"{__name__}.{_ON_DEMAND[name]}"), name)
