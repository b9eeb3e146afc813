"""Markov chains whose absorption, visits and times are computed without a subtraction."""

from tracerisk.prm.markov.chain import ChainSolution, MarkovChain

__all__ = ["ChainSolution", "MarkovChain"]
