"""A solved linked model, for a terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tracerisk.common.text.paper import PAPER, Paper
from tracerisk.prm.other_models.linked.importance import ParameterImportance
from tracerisk.prm.other_models.linked.parameter_sweep import FigureSweep
from tracerisk.report.tables import MEASURES, render_parts, table_of


def render_figures(name: str, figures: Mapping[str, float], paper: Paper = PAPER) -> str:
    """Return the figures of a model."""
    rows = [(figure, f"{value:.6e}") for figure, value in figures.items()]
    return render_parts([table_of(name, ["figure"], ["value"], rows)], paper)


def render_importances(
    figure: str,
    parameters: Sequence[ParameterImportance],
    paper: Paper = PAPER,
) -> str:
    """Return the importance of every parameter for a figure."""
    measures = MEASURES | {"birnbaum": "derivative"}
    rows = [
        (parameter.name, *(_shown(getattr(parameter, measure)) for measure in measures))
        for parameter in parameters
    ]
    title = f"Importance for {figure}"
    return render_parts([table_of(title, ["parameter"], measures.values(), rows)], paper)


def render_sweeps(figure: str, sweeps: Sequence[FigureSweep], paper: Paper = PAPER) -> str:
    """Return one figure along each sweep."""
    tables = []
    for swept in sweeps:
        title = f"{figure} along {swept.name} ({swept.before:.4g} in the model)"
        rows = [(f"{point.value:.4g}", f"{point.figures[figure]:.6e}") for point in swept.points]
        tables.append(table_of(title, (), (swept.name, figure), rows, overflow="fold"))
    return render_parts(tables, paper)


def _shown(value: float | None) -> str:
    return "-" if value is None else f"{value:.4g}"
