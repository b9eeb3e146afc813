"""The assumed figures that a result hangs on."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tracerisk.common.hardware.model import Hardware
from tracerisk.common.hardware.sources import assumed_sources
from tracerisk.prm.hybrid.assessment import Assessment
from tracerisk.report.instances import component_shares
from tracerisk.report.tables import add_share_columns, part_of, plain, share_cells, table_of

if TYPE_CHECKING:
    from rich.table import Table

MOST_SHOWN = 5
LEAST_SHARE = 1e-4
"""Part of the mission's failure probability from which a figure is said to drive it."""


@dataclass(frozen=True, slots=True)
class AssumedFigure:
    """A component whose figures are assumed."""

    component: str
    """Name of the component."""
    fussell_vesely: float
    """Part of the mission's failure probability that goes with it, in [0, 1]."""
    source: str
    """What the hardware description states as the source of the figures."""


def assumed_figures(
    hardware: Hardware, assessment: Assessment, *, by_hand: Collection[str] = ()
) -> tuple[AssumedFigure, ...]:
    """Return the assumed figures that are part of a result, that which matters most first.

    `by_hand` names components whose probability is a user's in every block: there nothing
    hangs on the description.
    """
    shares = component_shares(assessment)
    figures = [
        AssumedFigure(name, shares[name], source)
        for name, source in assumed_sources(hardware).items()
        if name in shares and name not in by_hand
    ]
    return tuple(
        sorted(
            figures,
            key=lambda assumed_figure: (-assumed_figure.fussell_vesely, assumed_figure.component),
        )
    )


def assumed_table(figures: Sequence[AssumedFigure], width: int = 80) -> Table | None:
    """Return the assumed figures that matter most as a table; `None` where there are none."""
    if not figures:
        return None
    # The first stands for all where none drives anything.
    driving = [figure for figure in figures if figure.fussell_vesely >= LEAST_SHARE] or figures[:1]
    shown = driving[:MOST_SHOWN]
    title = part_of("Assumed figures that drive the result", len(shown), len(figures))
    table = table_of(title, ["component"])
    add_share_columns(table, width)
    table.add_column("source", overflow="fold")
    for assumed_figure in shown:
        console_renderables = plain([assumed_figure.source])
        table.add_row(
            *plain([assumed_figure.component]),
            *share_cells(assumed_figure.fussell_vesely, width),
            *console_renderables,
        )
    return table
