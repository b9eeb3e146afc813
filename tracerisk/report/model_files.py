"""Solved model files of other tools, for a terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tracerisk.common.text.paper import PAPER, Paper
from tracerisk.report.tables import (
    WIDE,
    Column,
    part_of,
    plain,
    render_parts,
    render_table,
    table_of,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from tracerisk.prm.other_models.dynamic.solution import DynamicImportance
    from tracerisk.prm.other_models.event_trees.solution import EventTreeSolution
    from tracerisk.prm.other_models.properties import Answer
    from tracerisk.prm.questions.time_curve import Curve
    from tracerisk.prm.trees.fault_tree_solution import EventImportance

MOST_ROWS = 50
"""How many states or events are shown, those with the greatest figures."""


def render_tops(name: str, tops: Mapping[str, tuple[float, float]], paper: Paper = PAPER) -> str:
    """Return the probability of each top; of a likely one its complement too."""
    likely = any(p > 0.5 for p, _ in tops.values())
    columns = [Column("top"), Column("probability", is_number=True)]
    if likely:
        columns.append(Column("1 - probability", is_number=True))
    rows = []
    for top, (p, q) in tops.items():
        cells = [top, f"{p:.6e}"]
        if likely:
            cells.append(f"{q:.6e}" if p > 0.5 else "")
        rows.append(cells)
    return render_table(name, columns, rows, paper)


def render_top_importance(
    top: str,
    rows: Sequence[EventImportance | DynamicImportance],
    paper: Paper = PAPER,
) -> str:
    """Return the importance of each parameter, or of each event of a dynamic tree, for a top."""
    kept = rows[:MOST_ROWS]
    title = part_of(f"Importance for {top}", len(kept), len(rows))
    headings = {
        "probability": "probability",
        "birnbaum": "Birnbaum",
        "criticality": "criticality",
        "fussell_vesely": "Fussell-V.",
        "risk_reduction_worth": "RRW",
        "risk_achievement_worth": "RAW",
        "diagnostic_importance": "DIF",
        "tenfold": "tenfold",
    }
    if paper.width < WIDE:
        del headings["diagnostic_importance"]
    used = [name for name in headings if kept and hasattr(kept[0], name)]
    columns = [Column("event"), *(Column(headings[name], is_number=True) for name in used)]
    cells = [[row.name, *(f"{getattr(row, name):.4g}" for name in used)] for row in kept]
    return render_table(title, columns, cells, paper)


def render_event_tree(found: EventTreeSolution, paper: Paper = PAPER) -> str:
    """Return the sequences and outcomes of an event tree."""
    unit = f" per {found.initiating.per}" if found.initiating.per else ""
    rows = [
        (sequence.name, sequence.end_state, f"{sequence.probability:.6e}", f"{sequence.value:.6e}")
        for sequence in found.sequences
    ]
    headings = ("probability", f"value{unit}")
    sequences = table_of("", ("sequence", "end state"), headings, rows)
    parts = [*plain([f"Event tree {found.event_tree}, from {found.initiating.name}"]), sequences]
    if not any(found.outcomes):
        return render_parts(parts, paper)
    values = [(name, f"{value:.6e}") for name, value in found.outcomes.items()]
    outcomes = table_of("", ["end state"], [f"value{unit}"], values)
    parts += [*plain([f"Outcomes of {found.event_tree}"]), outcomes]
    return render_parts(parts, paper)


def render_states(
    name: str,
    heading: str,
    values: Mapping[str, float],
    paper: Paper = PAPER,
) -> str:
    """Return a figure of each state; of many states, the greatest."""
    shown = list(values.items())
    if len(shown) > MOST_ROWS:
        shown = sorted(shown, key=lambda pair: (-pair[1], pair[0]))[:MOST_ROWS]
    columns = [Column("state"), Column(heading, is_number=True)]
    rows = [[state, f"{value:.6e}"] for state, value in shown]
    return render_table(part_of(name, len(shown), len(values)), columns, rows, paper)


def render_answers(name: str, answers: Sequence[Answer], paper: Paper = PAPER) -> str:
    """Return the value of each property, a range where it differs by the start of the chain."""
    title, table = name, table_of("", ["property"])
    table.add_column("value", justify="right", overflow="fold")
    limited = any(answer.holds is not None for answer in answers)
    if limited:
        table.add_column("holds", no_wrap=True)
    for answer in answers:
        text = answer.question.text
        label = f"{answer.question.name}: {text}" if answer.question.name else text
        value = f"{answer.greatest:.6e}"
        cells = [label, value if answer.single else f"{answer.least:.6e} to {value}"]
        if limited:
            cells.append("" if answer.holds is None else "yes" if answer.holds else "no")
        table.add_row(*plain(cells))
    return render_parts([*plain([title]), table], paper)


def render_curve(curve: Curve, paper: Paper = PAPER) -> str:
    """Return the figures along the mission time, their means, and the bands of these."""
    table = table_of("", numbers=["hours"])
    for name in curve.figures:
        table.add_column(name, justify="right", overflow="fold")
    for index, time in enumerate(curve.times_h):
        cells = [f"{values[index]:.6e}" for values in curve.figures.values()]
        table.add_row(*plain([f"{time:.6g}", *cells]))
    table.add_row(*plain(["mean", *(f"{mean:.6e}" for mean in curve.means.values())]))
    parts = [*plain(["Along the mission time"]), table]
    bands = [f"{name}: SIL {band}" for name, band in curve.sil_bands.items() if band]
    if bands:
        parts += plain(
            [
                f"If such a mean is that of a failure on demand, it lies in the band of "
                f"{', '.join(bands)} (IEC 61508-1, table 2). That is no SIL assessment: the band "
                "of a mean says nothing of architecture, systematic capability and proof tests."
            ]
        )
    return render_parts(parts, paper)


def render_line(text: str, paper: Paper = PAPER) -> str:
    """Return a line of text."""
    return render_parts(plain([text]), paper)
