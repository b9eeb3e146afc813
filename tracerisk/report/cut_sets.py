"""The cut sets of a fault tree, for a terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from tracerisk.common.text.paper import PAPER, Paper
from tracerisk.report.tables import plain, render_parts, table_of

if TYPE_CHECKING:
    from rich.console import RenderableType

    from tracerisk.prm.other_models.cut_sets import CutSet


def render_cut_sets(
    top: str,
    kind: str,
    by_order: Mapping[int, int],
    listed: Sequence[CutSet],
    *,
    total: float | None,
    top_probability: float | None,
    max_order: int | None,
    paper: Paper = PAPER,
) -> str:
    """Return how many cut sets there are by order, their sum, and those that are listed.

    `kind` is what one is called; `total` and `top_probability` are `None` without figures.
    A share is that of the sum.
    """
    count = sum(by_order.values())
    limit = "" if max_order is None else f" of at most {max_order} events"
    rows = [(str(order), str(number)) for order, number in by_order.items()]
    orders = table_of("", (), ("order", "number"), rows, overflow="ellipsis")
    kinds = kind if count == 1 else f"{kind}s"
    parts: list[RenderableType] = [*plain([f"{top}: {count} {kinds}{limit}"]), orders]
    if total is not None:
        parts += plain([f"sum of their probabilities: {total:.6e}"])
        parts += plain([f"top event, exactly:         {top_probability:.6e}", ""])
    if listed:
        first = "most probable" if total is not None else "of the lowest orders"
        title = f"The {len(listed)} {first}" if len(listed) < count else "All of them"
        table = table_of("", ["events"], ("probability", "share") if total is not None else ())
        for cut_set in listed:
            events = ", ".join([*cut_set.events, *(f"not {name}" for name in cut_set.absent)])
            cells = [events or "(always)"]
            if total is not None and cut_set.probability is not None:
                share = cut_set.probability / total if total > 0.0 else 0.0
                cells += [f"{cut_set.probability:.6e}", f"{100.0 * share:.3g} %"]
            table.add_row(*plain(cells))
        parts += [*plain([title]), table]
    return render_parts(parts, paper)
