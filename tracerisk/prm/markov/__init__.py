"""Markov chains whose absorption, visits and times are computed without a subtraction."""

from tracerisk.prm.markov.chain import MarkovChain
from tracerisk.prm.markov.continuous import ContinuousChain, ContinuousSolution
from tracerisk.prm.markov.cycles import CycleFigures
from tracerisk.prm.markov.solution import ChainSolution

__all__ = [
    "ChainSolution",
    "ContinuousChain",
    "ContinuousSolution",
    "CycleFigures",
    "MarkovChain",
]
