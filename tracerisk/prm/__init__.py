"""The probabilistic risk model: fault trees, Markov chains, their link, and solving them."""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tracerisk.prm.bayes.network import BayesianNetwork, Given
    from tracerisk.prm.cut_sets import CutSet, CutSets, minimal_cut_sets, prime_implicants
    from tracerisk.prm.dynamic import (
        Dependency,
        DynamicEvent,
        DynamicGate,
        DynamicKind,
        DynamicTree,
        Restriction,
        RestrictionKind,
    )
    from tracerisk.prm.event_trees.event_tree import EventTree
    from tracerisk.prm.hybrid.assessment import FIGURE_STATEMENT, Assessment
    from tracerisk.prm.hybrid.from_blocks import build_model
    from tracerisk.prm.hybrid.hybrid import FunctionState, HybridModel, NextStep, Parameter
    from tracerisk.prm.hybrid.solve import solve
    from tracerisk.prm.linked import LinkedModel
    from tracerisk.prm.markov import ContinuousChain, MarkovChain
    from tracerisk.prm.questions.pair_importance import PairImportance, pair_importances
    from tracerisk.prm.questions.sampled_mission import failure_probabilities
    from tracerisk.prm.trees.common_cause import (
        CommonCauseGroup,
        CommonCauseLaw,
        expand_common_cause,
    )
    from tracerisk.prm.trees.failure_models import (
        GLM,
        Constant,
        Erlang,
        Exponential,
        Lognormal,
        PerDemand,
        PeriodicTest,
        Weibull,
    )
    from tracerisk.prm.trees.fault_tree import BasicEvent, FaultTree
    from tracerisk.prm.trees.gates import Gate, GateKind

__all__ = [
    "FIGURE_STATEMENT",
    "GLM",
    "Assessment",
    "BasicEvent",
    "BayesianNetwork",
    "CommonCauseGroup",
    "CommonCauseLaw",
    "Constant",
    "ContinuousChain",
    "CutSet",
    "CutSets",
    "Dependency",
    "DynamicEvent",
    "DynamicGate",
    "DynamicKind",
    "DynamicTree",
    "Erlang",
    "EventTree",
    "Exponential",
    "FaultTree",
    "FunctionState",
    "Gate",
    "GateKind",
    "Given",
    "HybridModel",
    "LinkedModel",
    "Lognormal",
    "MarkovChain",
    "NextStep",
    "PairImportance",
    "Parameter",
    "PerDemand",
    "PeriodicTest",
    "Restriction",
    "RestrictionKind",
    "Weibull",
    "build_model",
    "expand_common_cause",
    "failure_probabilities",
    "minimal_cut_sets",
    "pair_importances",
    "prime_implicants",
    "solve",
]

_ON_DEMAND = (
    {
        "FIGURE_STATEMENT": "hybrid.assessment",
        "Assessment": "hybrid.assessment",
        "BasicEvent": "trees.fault_tree",
        "BayesianNetwork": "bayes.network",
        "CommonCauseGroup": "trees.common_cause",
        "CommonCauseLaw": "trees.common_cause",
        "ContinuousChain": "markov.continuous",
        "CutSet": "cut_sets",
        "CutSets": "cut_sets",
        "EventTree": "event_trees.event_tree",
        "FaultTree": "trees.fault_tree",
        "FunctionState": "hybrid.hybrid",
        "Gate": "trees.gates",
        "GateKind": "trees.gates",
        "Given": "bayes.network",
        "HybridModel": "hybrid.hybrid",
        "LinkedModel": "linked",
        "MarkovChain": "markov",
        "NextStep": "hybrid.hybrid",
        "PairImportance": "questions.pair_importance",
        "Parameter": "hybrid.hybrid",
        "build_model": "hybrid.from_blocks",
        "expand_common_cause": "trees.common_cause",
        "failure_probabilities": "questions.sampled_mission",
        "minimal_cut_sets": "cut_sets",
        "pair_importances": "questions.pair_importance",
        "prime_implicants": "cut_sets",
        "solve": "hybrid.solve",
    }
    | dict.fromkeys(
        (
            "GLM",
            "Constant",
            "Erlang",
            "Exponential",
            "Lognormal",
            "PerDemand",
            "PeriodicTest",
            "Weibull",
        ),
        "trees.failure_models",
    )
    | dict.fromkeys(
        (
            "Dependency",
            "DynamicEvent",
            "DynamicGate",
            "DynamicKind",
            "DynamicTree",
            "Restriction",
            "RestrictionKind",
        ),
        "dynamic",
    )
)
"""The module of each name, imported when the name is first used."""


def __getattr__(name: str) -> object:
    if name not in _ON_DEMAND:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    return getattr(import_module(f"{__name__}.{_ON_DEMAND[name]}"), name)
