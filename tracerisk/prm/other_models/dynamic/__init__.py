"""Dynamic fault trees: spares, order, sequences and functional dependency, by Markov models."""

from tracerisk.prm.other_models.dynamic.elements import (
    Dependency,
    DynamicEvent,
    DynamicGate,
    DynamicKind,
    Restriction,
    RestrictionKind,
)
from tracerisk.prm.other_models.dynamic.tree import DynamicGroup, DynamicTree

__all__ = [
    "Dependency",
    "DynamicEvent",
    "DynamicGate",
    "DynamicGroup",
    "DynamicKind",
    "DynamicTree",
    "Restriction",
    "RestrictionKind",
]
