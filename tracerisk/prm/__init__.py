"""The probabilistic risk model: fault trees, Markov chains, their link, and solving them.

The public names of the room, each imported when it is first used: importing one kind of model does
not load the others, and a small tree is solved without NumPy. No other package of tracerisk does
this.
"""

from importlib import import_module

TYPE_CHECKING = False
if TYPE_CHECKING:
    from tracerisk.prm.hybrid.assessment import FIGURE_STATEMENT, Assessment
    from tracerisk.prm.hybrid.elements import FunctionState, NextStep, Parameter
    from tracerisk.prm.hybrid.from_blocks import build_model
    from tracerisk.prm.hybrid.hybrid import HybridModel
    from tracerisk.prm.hybrid.solve import solve
    from tracerisk.prm.other_models.bayes.network import BayesianNetwork
    from tracerisk.prm.other_models.bayes.tables import Given
    from tracerisk.prm.other_models.cut_sets import (
        CutSet,
        CutSets,
        minimal_cut_sets,
        prime_implicants,
    )
    from tracerisk.prm.other_models.dynamic import (
        Dependency,
        DynamicEvent,
        DynamicGate,
        DynamicKind,
        DynamicTree,
        Restriction,
        RestrictionKind,
    )
    from tracerisk.prm.other_models.event_trees.event_tree import EventTree
    from tracerisk.prm.other_models.linked import LinkedModel
    from tracerisk.prm.other_models.logic.common_cause import (
        CommonCauseGroup,
        CommonCauseLaw,
        expand_common_cause,
    )
    from tracerisk.prm.other_models.markov import ContinuousChain, MarkovChain
    from tracerisk.prm.questions.pair_importance import PairImportance, pair_importances
    from tracerisk.prm.questions.sampled_mission import failure_probabilities
    from tracerisk.prm.trees.events import BasicEvent
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
    from tracerisk.prm.trees.fault_tree import FaultTree
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

_HOMES = {
    name: module
    for module, names in {
        "hybrid.assessment": "Assessment FIGURE_STATEMENT",
        "hybrid.elements": "FunctionState NextStep Parameter",
        "hybrid.from_blocks": "build_model",
        "hybrid.hybrid": "HybridModel",
        "hybrid.solve": "solve",
        "other_models.bayes.network": "BayesianNetwork",
        "other_models.bayes.tables": "Given",
        "other_models.cut_sets": "CutSet CutSets minimal_cut_sets prime_implicants",
        "other_models.dynamic": (
            "Dependency DynamicEvent DynamicGate DynamicKind DynamicTree Restriction "
            "RestrictionKind"
        ),
        "other_models.event_trees.event_tree": "EventTree",
        "other_models.linked": "LinkedModel",
        "other_models.logic.common_cause": "CommonCauseGroup CommonCauseLaw expand_common_cause",
        "other_models.markov": "MarkovChain",
        "other_models.markov.continuous": "ContinuousChain",
        "questions.pair_importance": "PairImportance pair_importances",
        "questions.sampled_mission": "failure_probabilities",
        "trees.events": "BasicEvent",
        "trees.failure_models": (
            "Constant Erlang Exponential GLM Lognormal PerDemand PeriodicTest Weibull"
        ),
        "trees.fault_tree": "FaultTree",
        "trees.gates": "Gate GateKind",
    }.items()
    for name in names.split()
}
"""The module of each name."""


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module 'tracerisk.prm' has no attribute '{name}'")
    return getattr(import_module(f"tracerisk.prm.{_HOMES[name]}"), name)
