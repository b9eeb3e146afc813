"""Linked models: fault trees, Markov chains and parameters joined by expressions."""

from tracerisk.prm.other_models.linked.conversion import linked
from tracerisk.prm.other_models.linked.elements import (
    Figure,
    LinkedChain,
    LinkedEvent,
    LinkedTree,
    ModelParameter,
    Transfer,
    Transition,
)
from tracerisk.prm.other_models.linked.links import (
    Absorption,
    Link,
    Occupancy,
    TopEvent,
    complement,
)
from tracerisk.prm.other_models.linked.model import LinkedModel

__all__ = [
    "Absorption",
    "Figure",
    "Link",
    "LinkedChain",
    "LinkedEvent",
    "LinkedModel",
    "LinkedTree",
    "ModelParameter",
    "Occupancy",
    "TopEvent",
    "Transfer",
    "Transition",
    "complement",
    "linked",
]
