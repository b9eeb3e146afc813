"""Markov chains whose absorption, visits and times are computed without a subtraction."""

from tracerisk.prm.other_models.markov.chain import MarkovChain
from tracerisk.prm.other_models.markov.continuous import ContinuousChain, ContinuousSolution
from tracerisk.prm.other_models.markov.cycles import CycleFigures
from tracerisk.prm.other_models.markov.solution import ChainSolution

__all__ = [
    "ChainSolution",
    "ContinuousChain",
    "ContinuousSolution",
    "CycleFigures",
    "MarkovChain",
]
