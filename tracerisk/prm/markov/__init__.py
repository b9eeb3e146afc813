"""Markov chains whose absorption, visits and times are computed without a subtraction."""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tracerisk.prm.markov.chain import MarkovChain
    from tracerisk.prm.markov.continuous import ContinuousChain, ContinuousSolution
    from tracerisk.prm.markov.cycles import CycleFigures
    from tracerisk.prm.markov.large.matrix_chain import MatrixChain
    from tracerisk.prm.markov.large.matrix_solution import MatrixSolution
    from tracerisk.prm.markov.solution import ChainSolution

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
    "ChainSolution": "solution",
    "ContinuousChain": "continuous",
    "ContinuousSolution": "continuous",
    "CycleFigures": "cycles",
    "MarkovChain": "chain",
    "MatrixChain": "large.matrix_chain",
    "MatrixSolution": "large.matrix_solution",
}
"""The module of each name, imported when the name is first used."""


def __getattr__(name: str) -> object:
    if name not in _ON_DEMAND:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    return getattr(import_module(f"{__name__}.{_ON_DEMAND[name]}"), name)
