"""The failure modes of a controller and their effects, as a campaign on the twin showed them.

The table has the columns of IEC 60812; severity is left to the engineer.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from tracerisk.common.evidence.cells import EFFECTS, Cell, Effect, Evidence
from tracerisk.common.evidence.share_interval import clopper_pearson
from tracerisk.common.text.paper import PAPER, Paper
from tracerisk.report.tables import csv_of, rendered, table_of

HEADINGS = (
    "component",
    "failure mode",
    "function",
    "local effect",
    "end effect",
    "detected by",
    "told after s",
    "c",
    "c 5 %",
    "c 95 %",
    "failed",
    "cells",
    "ended early",
    "severity",
    "occurrence",
    "hardest contact",
)
"""The columns of the table that is written; those of occurrence and severity are the engineer's.
`ended early` counts the cells whose run was not followed to its end."""
WORDS: dict[Effect, str] = {
    "collision": "collision",
    "dropped": "object dropped",
    "not_placed": "object not placed",
    "ended_badly": "ended badly",
    "wrong_position": "wrong position",
    "late": "late",
    "told": "reported, no effect",
    "nothing": "no effect",
}
"""The effects in words."""


def end_effect(cells: Iterable[Cell]) -> str:
    """Return the worst effect of some cells in words, and that it may be worse where one of them
    was not followed to its end."""
    cells = list(cells)
    worst = min((cell.effect for cell in cells), key=EFFECTS.index)
    is_open = worst != EFFECTS[0] and any(cell.followed_s is not None for cell in cells)
    return f"{WORDS[worst]} or worse" if is_open else WORDS[worst]


def untold_for(cells: Iterable[Cell]) -> int | None:
    """Return for how long the controller was not notified, of cells where it was not [s].

    `None` where all runs were followed to their ends.
    """
    followed = [cell.followed_s for cell in cells if cell.followed_s is not None]
    return math.floor(min(followed)) if followed else None


@dataclass(frozen=True, slots=True)
class FmeaRow:
    """One line: a component's mode in a function, over the instants at which it was tried."""

    component: str
    """Name of the component."""
    mode: str
    """Name of the failure mode."""
    function: str
    """Qualified name of the function in which the failure happened."""
    cells: tuple[Cell, ...]
    """The failures tried, with their effects; at least one."""

    @property
    def failed(self) -> int:
        """In how many of the cells the mission failed."""
        return sum(1 for cell in self.cells if cell.fails)

    @property
    def share(self) -> float:
        """The share of the cells in which the mission failed: c."""
        return self.failed / len(self.cells)

    @property
    def interval(self) -> tuple[float, float]:
        """The 90 % interval of c (Clopper and Pearson)."""
        return clopper_pearson(self.failed, len(self.cells))

    @property
    def worst(self) -> Cell:
        """The cell with the worst effect, the soonest of several."""
        return min(self.cells, key=lambda cell: (EFFECTS.index(cell.effect), cell.time_s))

    @property
    def told_after_s(self) -> float | None:
        """The median time until the controller was notified, where it was [s]."""
        notified = [cell.told_after_s for cell in self.cells if cell.told_after_s is not None]
        return statistics.median(notified) if notified else None

    @property
    def notified(self) -> str:
        """The same in words, also where it was not notified of any."""
        notified, untold_s = self.told_after_s, untold_for(self.cells)
        if notified is not None:
            return f"{notified:.2f}"
        return "never" if untold_s is None else f"> {untold_s}"

    @property
    def detection(self) -> str:
        """By what the failure was reported, and in how many of the cells."""
        notified = [cell.told_by for cell in self.cells if cell.told_by]
        if not notified:
            untold_s = untold_for(self.cells)
            return "nothing" if untold_s is None else f"nothing within {untold_s} s"
        kinds = ", ".join(sorted({name.replace("_", " ") for name in notified}))
        return f"{kinds} ({len(notified)} of {len(self.cells)})"

    @property
    def hardest(self) -> str:
        """The hardest touch that was not to be expected; empty for none."""
        touched = [cell for cell in self.cells if cell.contact]
        return max((cell.contact for cell in touched), key=_newtons, default="")

    @property
    def values(self) -> tuple[str, ...]:
        """The row as text, in the order of `HEADINGS`."""
        low, high = self.interval
        notified = self.told_after_s
        return (
            self.component,
            self.mode,
            self.function,
            self.worst.local,
            end_effect(self.cells),
            self.detection,
            "" if notified is None else f"{notified:.3g}",
            f"{self.share:.4g}",
            f"{low:.4g}",
            f"{high:.4g}",
            str(self.failed),
            str(len(self.cells)),
            str(sum(1 for cell in self.cells if cell.followed_s is not None)),
            "",
            "",
            self.hardest,
        )


def fmea_rows(found: Evidence) -> tuple[FmeaRow, ...]:
    """Return the table, by component, mode and function in the order of their first cells."""
    rows: dict[tuple[str, str, str], list[Cell]] = {}
    order = {name: index for index, name in enumerate(_functions(found.cells))}
    for cell in found.cells:
        rows.setdefault((cell.component, cell.mode, cell.function), []).append(cell)
    keys = sorted(rows, key=lambda key: (key[0], key[1], order[key[2]]))
    return tuple(FmeaRow(*key, tuple(rows[key])) for key in keys)


def confusion(cells: Iterable[Cell]) -> tuple[int, int, int, int]:
    """Return how many cells were in use and failed, in use and harmless, idle and each."""
    counts = [0, 0, 0, 0]
    for cell in cells:
        counts[2 * cell.is_idle + (not cell.fails)] += 1
    in_use, harmless, idle, idle_harmless = counts
    return in_use, harmless, idle, idle_harmless


def render_fmea(found: Evidence, paper: Paper = PAPER) -> str:
    """Return the table for a terminal."""
    table = table_of("Failures and their effects")
    for heading in ("failure in function", "end effect", "detected s", "failed", "c 90 %"):
        is_text = heading in ("failure in function", "end effect")
        table.add_column(
            heading,
            justify="left" if is_text else "right",
            overflow="fold",
            no_wrap=not is_text,
        )
    component = mode = None
    for row in fmea_rows(found):
        low, high = row.interval
        if component != row.component:
            component, mode = row.component, None
            table.add_row(row.component)
        if mode != row.mode:
            mode = row.mode
            table.add_row(f"  {row.mode.replace('_', ' ')}")
        table.add_row(
            f"    {row.function}",
            end_effect(row.cells),
            row.notified,
            f"{row.failed} of {len(row.cells)}",
            f"{low:.2f}..{high:.2f}",
        )
    return rendered(lambda console: console.print(table), paper)


def summary_lines(found: Evidence) -> list[str]:
    """Return what a campaign showed over all, a line each."""
    cells = found.cells
    needed, harmless, idle_needed, idle_harmless = confusion(cells)
    delays = [cell.told_after_s for cell in cells if cell.told_after_s is not None]
    lines = [
        f"{len(cells)} failures tried, {found.drawn} of them drawn from the hazard; "
        f"{sum(1 for cell in cells if cell.fails)} ended the mission",
        f"in use: {needed} needed, {harmless} harmless; idle: {idle_needed} needed, "
        f"{idle_harmless} harmless",
    ]
    if delays:
        lines.append(
            f"reported to the controller in {len(delays)}, "
            f"after {statistics.median(delays):.2f} s in the median"
        )
    else:
        lines.append("reported to the controller in none")
    if found.edited is not None:
        lines.append(
            f"the file was edited: {found.edited.words}; what does not fit its digest is left out, "
            "and figures take none of it until `tracerisk evidence FILE` has tried it again"
        )
    if not found.has_digest:
        lines.append("the file is of an earlier version, without digests: edits of it do not show")
    kept = sum(1 for key, share in found.shares().items() if found.before.get(key) == share)
    if kept:
        lines.append(
            f"{kept} units and modes count by the share of the evidence before, which lies in the "
            "90 % interval of the one here"
        )
    return lines


def csv_text(found: Evidence) -> str:
    """Return the table as CSV."""
    return csv_of(HEADINGS, (row.values for row in fmea_rows(found)))


def markdown_text(found: Evidence, name: str) -> str:
    """Return the table as Markdown."""
    lines = [f"# Failures of {name} and their effects", "", *_listed(summary_lines(found)), ""]
    if not found.success:
        lines += ["The mission is what the run without a failure reached.", ""]
    else:
        lines += ["The mission is:", "", *_listed(found.success), ""]
    lines += [_row(HEADINGS), _row(["---"] * len(HEADINGS))]
    lines += [_row(row.values) for row in fmea_rows(found)]
    return "\n".join(lines) + "\n"


def _row(values: Sequence[str]) -> str:
    return "| " + " | ".join(value.replace("|", "\\|") for value in values) + " |"


def _listed(lines: Iterable[str]) -> list[str]:
    return [f"- {line}" for line in lines]


def _functions(cells: Sequence[Cell]) -> list[str]:
    return list(dict.fromkeys(cell.function for cell in sorted(cells, key=lambda c: c.time_s)))


def _newtons(contact: str) -> float:
    try:
        return float(contact.rsplit(",", 1)[-1].split()[0])
    except (ValueError, IndexError):
        return 0.0
