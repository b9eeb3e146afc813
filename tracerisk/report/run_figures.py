"""What a run knows of its figures beyond the model: instances, and which figures are assumed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from tracerisk.adder.blocks.block import RiskBlock
from tracerisk.adder.figures.instances import ComponentInstances
from tracerisk.common.function_ref import FunctionRef
from tracerisk.common.hardware.model import Hardware
from tracerisk.prm.hybrid.assessment import Assessment
from tracerisk.report.assumed import AssumedFigure, assumed_figures, assumed_table
from tracerisk.report.instances import (
    InstanceImportance,
    instance_importances,
    instances_data,
    instances_table,
)

if TYPE_CHECKING:
    from rich.console import RenderableType


@dataclass(frozen=True, slots=True)
class RunFigures:
    """What a run knows of its figures beyond the model."""

    instances: tuple[ComponentInstances, ...]
    """Components with their instances."""
    importances: tuple[InstanceImportance, ...]
    """Instances with their importance, the most important component first."""
    assumed: tuple[AssumedFigure, ...]
    """Assumed figures that are part of the result, the most important first."""

    def tables(self, width: int = 80) -> list[RenderableType]:
        """Return the tables for a terminal; none where instances are alike and none is assumed."""
        row = (
            instances_table(self.instances, self.importances, width),
            assumed_table(self.assumed, width),
        )
        return [item for item in row if item is not None]

    def data(self, names: Mapping[FunctionRef, str]) -> dict[str, Any]:
        """Return all as plain data; `names` are the functions' names in the model."""
        return {
            "instances": instances_data(self.importances, names),
            "assumed_figures": [asdict(assumed_figure) for assumed_figure in self.assumed],
        }


def run_figures(
    assessment: Assessment,
    hardware: Hardware,
    instances: Sequence[ComponentInstances],
    blocks: Iterable[RiskBlock],
) -> RunFigures:
    """Return what a run knows of the figures of an assessment of its blocks."""
    return RunFigures(
        tuple(instances),
        instance_importances(instances, assessment),
        assumed_figures(hardware, assessment, by_hand=set_by_hand(blocks)),
    )


def set_by_hand(blocks: Iterable[RiskBlock]) -> list[str]:
    """Return the components whose probability is a user's in every block that has them."""
    computed: dict[str, bool] = {}
    for block in blocks:
        for entry in block.components:
            if not entry.omitted:
                is_tools = not (block.added or entry.added or entry.probability.pinned)
                computed[entry.name] = computed.get(entry.name, False) or is_tools
    return [name for name, is_tools in computed.items() if not is_tools]


def outcomes_set_by_hand(blocks: Iterable[RiskBlock]) -> list[str]:
    """Return the components of which a user says in some block what follows their failures."""
    by_hand: dict[str, None] = {}
    for block in blocks:
        for entry in block.components:
            if entry.failures.is_stated and (block.added or entry.added or entry.failures.pinned):
                by_hand[entry.name] = None
    return list(by_hand)
