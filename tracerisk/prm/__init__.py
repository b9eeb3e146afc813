"""The probabilistic risk model: fault trees, Markov chains, their link, and solving them."""

from importlib import import_module
from typing import TYPE_CHECKING

from tracerisk.prm.assessment import FIGURE_STATEMENT, Assessment
from tracerisk.prm.build import build_model
from tracerisk.prm.fault_tree import BasicEvent, FaultTree, Gate, GateKind
from tracerisk.prm.hybrid import FunctionState, HybridModel, NextStep, Parameter
from tracerisk.prm.markov import MarkovChain
from tracerisk.prm.solve import solve

if TYPE_CHECKING:
    from tracerisk.prm.bayes import BayesianNetwork, Given
    from tracerisk.prm.common_cause import (
        CommonCauseGroup,
        CommonCauseLaw,
        expand_common_cause,
    )
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
    from tracerisk.prm.event_tree import EventTree
    from tracerisk.prm.failure_models import (
        GLM,
        Constant,
        Erlang,
        Exponential,
        Lognormal,
        PerDemand,
        PeriodicTest,
        Weibull,
    )
    from tracerisk.prm.linked import LinkedModel
    from tracerisk.prm.markov import ContinuousChain
    from tracerisk.prm.pair_importance import PairImportance, pair_importances

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
    "minimal_cut_sets",
    "pair_importances",
    "prime_implicants",
    "solve",
]

_ON_DEMAND = (
    {
        "BayesianNetwork": "bayes",
        "CommonCauseGroup": "common_cause",
        "CommonCauseLaw": "common_cause",
        "ContinuousChain": "markov.continuous",
        "CutSet": "cut_sets",
        "CutSets": "cut_sets",
        "EventTree": "event_tree",
        "Given": "bayes",
        "LinkedModel": "linked",
        "PairImportance": "pair_importance",
        "expand_common_cause": "common_cause",
        "minimal_cut_sets": "cut_sets",
        "pair_importances": "pair_importance",
        "prime_implicants": "cut_sets",
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
        "failure_models",
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
"""The modules of names that most programs do not use: imported when they are."""


def __getattr__(name: str) -> object:
    if name not in _ON_DEMAND:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    return getattr(import_module(f"{__name__}.{_ON_DEMAND[name]}"), name)
