"""Redundancy that a model states by metadata definitions of its own."""

from __future__ import annotations

from collections.abc import Callable

from tracerisk.common.hardware.model import FailureFigure
from tracerisk.common.hardware.sysml.annotations import Annotations, Given, Metadata
from tracerisk.common.hardware.sysml.composition import Place
from tracerisk.common.hardware.sysml.fields import Fields
from tracerisk.common.hardware.sysml.figures import read_redundancy
from tracerisk.common.hardware.sysml.language.name_resolution import Symbol, ancestors
from tracerisk.common.hardware.sysml.language.standard_names import FEATURES
from tracerisk.common.hardware.sysml.language.syntax import Annotation
from tracerisk.errors import HardwareError, Location

_STEM = "redundan"
_OURS = {name: name for name in FEATURES["Redundancy"]} | {
    "redundancy": "redundant",
    "isRedundant": "redundant",
}
"""Our feature for each of theirs that says the same."""


def redundancy_of_others(
    place: Place,
    figures: tuple[FailureFigure, ...],
    annotations: Annotations,
    warn: Callable[[Location, str], None],
) -> Fields | None:
    """Return the redundancy that metadata of others on a part state as ours does.

    `warn` takes the place of each that is read, and of each that says something else.
    """
    part = place.symbol
    for owner in ancestors(part):
        for metadata in annotations.own(owner) if isinstance(owner, Symbol) else ():
            node = metadata.symbol.node
            assert isinstance(node, Annotation)
            values = _values(metadata)
            texts = (node.type.name[-1], *values)
            if metadata.kind not in (None, "Risk") or not any(_STEM in t.lower() for t in texts):
                continue
            what = f"'@{node.type}' on '{part.name}'"
            fields = _as_ours(metadata, values, place, figures)
            if fields is None:
                warn(
                    metadata.location,
                    f"{what} is not read, so that every unit of it is needed; state its redundancy "
                    "by Redundancy of TraceriskHardware",
                )
                continue
            warn(metadata.location, f"{what} is read as Redundancy of TraceriskHardware")
            return fields
    return None


def _values(metadata: Metadata) -> dict[str, Given]:
    try:
        return metadata.own_values()
    except HardwareError:
        return {}  # its definition is in a library that is not read


def _as_ours(
    metadata: Metadata,
    values: dict[str, Given],
    place: Place,
    figures: tuple[FailureFigure, ...],
) -> Fields | None:
    """Return the values as features of our metadata; `None` where some say something else."""
    if not values or not all(name in _OURS for name in values):
        return None
    ours = {_OURS[name]: value for name, value in values.items()}
    fields = Fields("Redundancy", ours, metadata.location, place.way)
    try:
        read_redundancy(fields, figures)
    except HardwareError:
        return None
    return fields
