"""Linked models: fault trees, Markov chains and parameters joined by expressions."""

from tracerisk.prm.linked.conversion import linked
from tracerisk.prm.linked.elements import (
    Figure,
    LinkedChain,
    LinkedEvent,
    LinkedTree,
    ModelParameter,
    Transfer,
    Transition,
)
from tracerisk.prm.linked.links import Absorption, Link, Occupancy, TopEvent, complement
from tracerisk.prm.linked.model import LinkedModel

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
