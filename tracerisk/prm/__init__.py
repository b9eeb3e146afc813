"""The probabilistic risk model: fault trees, Markov chains, their link, and solving them."""

from tracerisk.prm.assessment import FIGURE_STATEMENT, Assessment
from tracerisk.prm.build import build_model
from tracerisk.prm.fault_tree import BasicEvent, FaultTree, Gate, GateKind
from tracerisk.prm.hybrid import FunctionState, HybridModel, NextStep, Parameter
from tracerisk.prm.markov import MarkovChain
from tracerisk.prm.solve import solve

__all__ = [
    "FIGURE_STATEMENT",
    "Assessment",
    "BasicEvent",
    "FaultTree",
    "FunctionState",
    "Gate",
    "GateKind",
    "HybridModel",
    "MarkovChain",
    "NextStep",
    "Parameter",
    "build_model",
    "solve",
]
