"""Markov chains whose absorption, visits and times are computed without a subtraction."""

from typing import TYPE_CHECKING

from tracerisk.common.on_demand import on_demand

if TYPE_CHECKING:
    from tracerisk.prm.other_models.markov.chain import MarkovChain
    from tracerisk.prm.other_models.markov.continuous import ContinuousChain, ContinuousSolution
    from tracerisk.prm.other_models.markov.cycles import CycleFigures
    from tracerisk.prm.other_models.markov.large.matrix_chain import MatrixChain
    from tracerisk.prm.other_models.markov.large.matrix_solution import MatrixSolution
    from tracerisk.prm.other_models.markov.solution import ChainSolution

__all__ = [
    "ChainSolution",
    "ContinuousChain",
    "ContinuousSolution",
    "CycleFigures",
    "MarkovChain",
    "MatrixChain",
    "MatrixSolution",
]

__getattr__ = on_demand(
    __name__,
    {
        "chain": "MarkovChain",
        "continuous": "ContinuousChain ContinuousSolution",
        "cycles": "CycleFigures",
        "large.matrix_chain": "MatrixChain",
        "large.matrix_solution": "MatrixSolution",
        "solution": "ChainSolution",
    },
)
