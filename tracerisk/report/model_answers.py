"""What-if, importance and uncertainty of a model, for a terminal."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from tracerisk.common.text.paper import PAPER, Paper
from tracerisk.prm.hybrid.assessment import ComponentImportance
from tracerisk.prm.questions.pair_importance import PairImportance
from tracerisk.prm.questions.set_values import SetValue, Sweep
from tracerisk.prm.questions.uncertainty import InputShare, Uncertainty
from tracerisk.report.tables import MEASURES, part_of, render_parts, table_of

if TYPE_CHECKING:
    from rich.table import Table

MOST_PAIRS = 20
"""How many of the pairs that share most of the risk are shown."""


def render_set_values(values: Sequence[SetValue], paper: Paper = PAPER) -> str:
    """Return the parameters that were set, each with its value in the model."""
    rows = [
        (value.name, "-" if math.isnan(value.before) else f"{value.before:.4g}", f"{value.now:.4g}")
        for value in values
    ]
    headings = ("in the model", "now")
    title = "Set, for what follows"
    return render_parts(
        [table_of(title, ["parameter"], headings, rows, overflow="ellipsis")], paper
    )


def render_sweeps(sweeps: Sequence[Sweep], paper: Paper = PAPER) -> str:
    """Return the mission's figures along each sweep."""
    return render_parts([_sweep(sweep) for sweep in sweeps], paper)


def render_importances(components: Sequence[ComponentImportance], paper: Paper = PAPER) -> str:
    """Return every importance measure of every component, and its parts by state and unit."""
    digits = dict.fromkeys(MEASURES, 4) | {"risk_achievement_worth": 3}
    rows = [
        (
            component.name,
            *(f"{getattr(component, name):.{count}g}" for name, count in digits.items()),
        )
        for component in components
    ]
    return render_parts(
        [
            table_of("Importance over the mission", ["component"], MEASURES.values(), rows),
            _shares("Criticality by function", "function", components),
            _shares("Criticality by unit", "unit", components),
        ],
        paper,
    )


def render_pairs(pairs: Sequence[PairImportance], paper: Paper = PAPER) -> str:
    """Return what pairs of components do together, those that share most of the risk first."""
    shown = pairs[:MOST_PAIRS]
    title = part_of("Importance of pairs", len(shown), len(pairs))
    headings = {
        "fussell_vesely": "Fussell-V.",
        "interaction": "interaction",
        "joint_birnbaum": "joint B.",
        "joint_criticality": "joint crit.",
    }
    rows = [
        (pair.first, pair.second, *(f"{getattr(pair, name):.4g}" for name in headings))
        for pair in shown
    ]
    return render_parts([table_of(title, ("component", "and"), headings.values(), rows)], paper)


def render_uncertainty(
    found: Uncertainty,
    figure: str = "Mission failure probability",
    paper: Paper = PAPER,
) -> str:
    """Return the percentiles of a figure, and the share of each input."""
    headings = [f"{level:.0f} %" for level in found.levels]
    figures = (found.point, found.mean, *found.percentiles, found.deviation)
    rows = [[f"{item:.3e}" for item in figures]]
    for end, name in enumerate(("95 % from", "to")):
        ends = [
            "" if interval[end] is None else f"{interval[end]:.3e}" for interval in found.intervals
        ]
        rows += [[name, "", *ends, ""]] if ends else []
    title = f"{figure}, {found.samples} samples, seed {found.seed}"
    numbers = ("point", "mean", *headings, "std. deviation")
    spread = table_of(title, (), numbers, rows, overflow="ellipsis")
    inputs = [_input_shares("Share of each input in that spread", found.inputs, headings)]
    if {item.name for item in found.undetected_inputs} - {item.name for item in found.inputs}:
        title = "Share of each input in the spread of the undetected failure"
        inputs.append(_input_shares(title, found.undetected_inputs, headings))
    cut = [
        f"{input_share.name}: {input_share.cut} of {found.samples} samples above 1 were set to 1; "
        "is its error factor meant?"
        for input_share in found.inputs
        if input_share.cut
    ]
    lines = []
    if found.undetected:
        said = [
            f"{value:.3e} ({level:.0f} %)"
            for level, value in zip(found.levels, found.undetected, strict=True)
        ]
        lines.append(f"Of which undetected, or with harm before the stop: {', '.join(said)}.")
    if found.mean > 0.0:
        lines.append(
            f"The mean has a standard error of {found.standard_error:.2g} "
            f"({100.0 * found.standard_error / found.mean:.2g} %)."
        )
    if found.is_weighted:
        lines.append(
            "The mean lies in draws too rare for this sample: it comes from as many others, half "
            "of them from the tails of the inputs with the greatest shares, weighted."
        )
    if not found.knows_mean:
        lines.append(
            f"This sample does not give the mean: the greatest of its {found.samples} draws alone "
            f"makes {100.0 * found.greatest_share:.2g} % of it, so that still greater ones, which "
            "were not drawn, matter as much. The mean is likely higher, and its standard error "
            "with it; go by the percentiles."
        )
    if found.point > 0.0 and abs(found.mean - found.point) > 0.01 * found.point:
        lines.append(
            f"The mean is {found.mean / found.point:.3g} times the point, in which each parameter "
            "has its own value: the median of its distribution, unless it says otherwise."
        )
    return render_parts([spread, *lines, *inputs, *cut], paper)


def _input_shares(title: str, inputs: Sequence[InputShare], headings: Sequence[str]) -> Table:
    rows = []
    for item in inputs:
        cells = [f"{value:.3e}" for value in (item.value, *item.percentiles)]
        rows.append([item.name, *cells, f"{100.0 * item.share:.3g} %"])
    numbers = ("point", *headings, "share")
    return table_of(title, ["parameter"], numbers, rows, overflow="ellipsis")


def _sweep(swept: Sweep) -> Table:
    rows = []
    for point in swept.points:
        mission = point.mission
        figures = (mission.geometric_cycles, mission.fixed_cycles, mission.visits_as_run)
        rows.append((f"{point.value:.4g}", *(f"{figure:.4e}" for figure in figures)))
    headings = (swept.name, "geometric cycles", "fixed cycles", "as executed")
    title = f"Sweep of {swept.name} ({swept.before:.4g} in the model)"
    return table_of(title, (), headings, rows, overflow="fold")


def _shares(title: str, by: str, components: Sequence[ComponentImportance]) -> Table:
    rows = []
    for component in components:
        parts = component.by_state if by == "function" else component.by_unit
        for index, part in enumerate(parts):
            name = component.name if index == 0 else ""
            rows.append((name, part.name, f"{part.birnbaum:.4g}", f"{part.criticality:.4g}"))
    headings = ("Birnbaum", "criticality")
    return table_of(title, ("component", by), headings, rows, overflow="ellipsis")
