"""A solved linked model, for a terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tracerisk.prm.linked.importance import ParameterImportance
from tracerisk.prm.linked.what_if import FigureSweep
from tracerisk.report.tables import plain, render_parts, table_of
from tracerisk.text.paper import PAPER, Paper


def render_figures(name: str, figures: Mapping[str, float], paper: Paper = PAPER) -> str:
    """Return the figures of a model."""
    table = table_of(name, ["figure"], ["value"])
    for figure, value in figures.items():
        table.add_row(*plain([figure, f"{value:.6e}"]))
    return render_parts([table], paper)


def render_importances(
    figure: str,
    parameters: Sequence[ParameterImportance],
    paper: Paper = PAPER,
) -> str:
    """Return the importance of every parameter for a figure."""
    measures = ("derivative", "criticality", "Fussell-V.", "RRW", "RAW", "tenfold")
    table = table_of(f"Importance for {figure}", ["parameter"], measures)
    for each in parameters:
        cells = [
            _shown(value)
            for value in (
                each.birnbaum,
                each.criticality,
                each.fussell_vesely,
                each.risk_reduction_worth,
                each.risk_achievement_worth,
                each.tenfold,
            )
        ]
        table.add_row(*plain([each.name, *cells]))
    return render_parts([table], paper)


def render_sweeps(figure: str, sweeps: Sequence[FigureSweep], paper: Paper = PAPER) -> str:
    """Return one figure along each sweep."""
    tables = []
    for swept in sweeps:
        table = table_of(f"{figure} along {swept.name} ({swept.before:.4g} in the model)")
        for heading in (swept.name, figure):
            table.add_column(heading, justify="right", overflow="fold")
        for point in swept.points:
            table.add_row(*plain([f"{point.value:.4g}", f"{point.figures[figure]:.6e}"]))
        tables.append(table)
    return render_parts(tables, paper)


def _shown(value: float | None) -> str:
    return "-" if value is None else f"{value:.4g}"
