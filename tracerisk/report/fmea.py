"""The failure modes of a controller and their effects, as a campaign on the twin showed them.

The table has the columns of IEC 60812; severity is left to the engineer.
"""

from __future__ import annotations

import math
import statistics
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from tracerisk.common.evidence.advice import advice_of
from tracerisk.common.evidence.cells import (
    EFFECTS,
    FATES,
    NOTICES,
    Cell,
    Effect,
    Evidence,
    Fate,
)
from tracerisk.common.evidence.share_interval import clopper_pearson
from tracerisk.common.hardware.model import CONTROL, mode_and_duration
from tracerisk.common.text.paper import PAPER, Paper
from tracerisk.report.tables import csv_of, rendered, table_of

HEADINGS = (
    *("component", "failure mode", "failure cause", "function", "local effect", "end effect"),
    *(
        "detected by",
        "detected after s",
        "told after s",
        *(fate.replace("_", " ") for fate in FATES),
    ),
    *("c", "c 5 %", "c 95 %", "undetected", "undetected 5 %", "undetected 95 %"),
    *("failed", "cells", "ended early", "severity", "occurrence", "hardest contact"),
)
"""The columns of the table that is written, with the names of IEC 60812; those of occurrence and
severity are the engineer's. `told after s` is when an interface first reported a failure, noticed
or not; `ended early` counts the cells whose run was not followed to its end."""
DFMEA_HEADINGS = (
    *("Focus Element", "Function", "Failure Effects (FE)", "Severity (S) of FE"),
    *("Failure Mode (FM)", "Failure Cause (FC)", "Current Prevention Controls (PC) of FC"),
    *("Occurrence (O) of FC", "Current Detection Controls (DC) of FC or FM"),
    *("Detection (D) of FC/FM", "DFMEA AP", "Remarks"),
)
"""The columns that spreadsheets by the AIAG & VDA FMEA Handbook (2019) have for a design."""
CAUSES = {
    "dead": "motor without torque",
    "jam": "joint blocked",
    "no_force": "fingers without force",
    "opens": "fingers open by themselves",
    "stuck": "fingers blocked",
    "offset": "reading with an offset",
    "noisy": "noisy reading",
    "frozen": "reading that does not change",
    "absent": "no reading",
    "lost_with_brakes": "no supply, brakes close",
    "lost_without_brakes": "no supply, no brakes",
    "link_lost": "no communication with the arm",
}
"""What causes a failure, by the mode of a unit."""
WORDS: dict[Effect, str] = {
    "collision": "collision",
    "dropped": "object dropped",
    "not_placed": "object not placed",
    "ended_badly": "ended badly",
    "wrong_position": "wrong position",
    "touched": "touch",
    "late": "late",
    "told": "reported, no effect",
    "nothing": "no effect",
}
"""The effects in words."""
FATE_WORDS: dict[Fate, str] = {
    "carried_out": "carried out",
    "recovered": "recovered",
    "stopped_safely": "stopped safely",
    "stopped_late": "stopped late",
    "unaware": "unaware",
}
"""What became of missions, in words."""


def end_effect(cells: Iterable[Cell]) -> str:
    """Return the worst effect of some cells in words, and that it may be worse where one of them
    was not followed to its end."""
    cells = list(cells)
    worst = min((cell.effect for cell in cells), key=EFFECTS.index)
    is_open = worst != EFFECTS[0] and any(cell.followed_s is not None for cell in cells)
    return f"{WORDS[worst]} or worse" if is_open else WORDS[worst]


def all_effects(cell: Cell) -> str:
    """Return all effects of a cell in words, the worst first, without what did no harm."""
    effects = [effect for effect in cell.effects if effect not in ("touched", "told", "late")]
    return "; ".join(WORDS[effect] for effect in effects[1:])


def unnoticed_for(cells: Iterable[Cell]) -> int | None:
    """Return for how long a controller was followed that did not notice the failure [s].

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
    def undetected(self) -> int:
        """In how many of the cells the mission failed unnoticed, or did harm before the stop."""
        return sum(1 for cell in self.cells if cell.is_undetected)

    @property
    def noticed_s(self) -> float | None:
        """The median time until the controller noticed, where it did [s]."""
        noticed = [cell.noticed_s for cell in self.cells if cell.noticed_s is not None]
        return statistics.median(noticed) if noticed else None

    @property
    def noticed(self) -> str:
        """The same in words, also where it noticed none."""
        if not any(cell.fate for cell in self.cells):
            return "not known"
        noticed, unnoticed_s = self.noticed_s, unnoticed_for(self.cells)
        if noticed is not None:
            return f"{noticed:.2f}"
        return "never" if unnoticed_s is None else f"> {unnoticed_s}"

    @property
    def detection(self) -> str:
        """By what the controller noticed the failure, each with the number of the cells."""
        if not any(cell.fate for cell in self.cells):
            return "not known"
        noticed = Counter(cell.noticed_by for cell in self.cells if cell.noticed_by is not None)
        if not noticed:
            unnoticed_s = unnoticed_for(self.cells)
            return "nothing" if unnoticed_s is None else f"nothing within {unnoticed_s} s"
        number = len(self.cells)
        return ", ".join(
            f"{by.replace('_', ' ')} ({noticed[by]} of {number})" for by in NOTICES if noticed[by]
        )

    @property
    def cause(self) -> str:
        """What makes the component fail so, in words."""
        mode, lasts_s = mode_and_duration(self.mode)
        of_control = self.mode == "frozen" and any(cell.unit == CONTROL for cell in self.cells)
        cause = "commands that do not change" if of_control else CAUSES.get(mode, mode)
        return cause if lasts_s is None else f"{cause}, intermittent"

    @property
    def fates(self) -> tuple[int, ...]:
        """In how many of the cells each of `FATES` came."""
        return tuple(sum(1 for cell in self.cells if cell.fate == fate) for fate in FATES)

    @property
    def hardest(self) -> str:
        """The hardest touch that was not to be expected; empty for none."""
        touched = [cell for cell in self.cells if cell.contact]
        return max((cell.contact for cell in touched), key=_newtons, default="")

    @property
    def values(self) -> tuple[str, ...]:
        """The row as text, in the order of `HEADINGS`."""
        noticed = self.noticed_s
        told = [cell.told_after_s for cell in self.cells if cell.told_after_s is not None]
        told_s = statistics.median(told) if told else None
        return (
            self.component,
            self.mode,
            self.cause,
            self.function,
            self.worst.local,
            end_effect(self.cells),
            self.detection,
            "" if noticed is None else f"{noticed:.3g}",
            "" if told_s is None else f"{told_s:.3g}",
            *map(str, self.fates),
            *_share(self.failed, len(self.cells)),
            *_share(self.undetected, len(self.cells)),
            str(self.failed),
            str(len(self.cells)),
            str(sum(1 for cell in self.cells if cell.followed_s is not None)),
            "",
            "",
            self.hardest,
        )

    @property
    def dfmea_values(self) -> tuple[str, ...]:
        """The row as text, in the order of `DFMEA_HEADINGS`."""
        fates = zip(FATES, self.fates, strict=True)
        counted = ", ".join(f"{FATE_WORDS[fate]} {number}" for fate, number in fates if number)
        low, high = clopper_pearson(self.undetected, len(self.cells))
        remarks = (
            f"of {len(self.cells)} tries: {counted or 'not known who noticed'}; undetected "
            f"{self.undetected}, 90 % interval {low:.2f} to {high:.2f}"
        )
        return (
            *(self.component, self.function, f"{self.worst.local}; {end_effect(self.cells)}", ""),
            *(self.mode.replace("_", " "), self.cause, "", "", self.detection, "", "", remarks),
        )


def _share(failed: int, tried: int) -> tuple[str, str, str]:
    """Return a share and its 90 % interval, as text."""
    low, high = clopper_pearson(failed, tried)
    return f"{failed / tried:.4g}", f"{low:.4g}", f"{high:.4g}"


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
    for heading in ("failure in function", "end effect", "noticed s", "failed", "undetected"):
        is_text = heading in ("failure in function", "end effect")
        table.add_column(
            heading,
            justify="left" if is_text else "right",
            overflow="fold",
            no_wrap=not is_text,
        )
    component = mode = None
    for row in fmea_rows(found):
        if component != row.component:
            component, mode = row.component, None
            table.add_row(row.component)
        if mode != row.mode:
            mode = row.mode
            table.add_row(f"  {row.mode.replace('_', ' ')}")
        table.add_row(
            f"    {row.function}",
            end_effect(row.cells),
            row.noticed,
            f"{row.failed} of {len(row.cells)}",
            f"{row.undetected}",
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
    if found.has_fates:
        counts = Counter(cell.fate for cell in cells)
        lines.append(
            "missions: " + ", ".join(f"{counts[fate]} {FATE_WORDS[fate]}" for fate in FATES)
        )
        noticed = [cell.noticed_s for cell in cells if cell.noticed_s is not None]
        median = f", after {statistics.median(noticed):.2f} s in the median" if noticed else ""
        undetected = sum(1 for cell in cells if cell.is_undetected)
        lines.append(
            f"the controller noticed {len(noticed)}{median}; {undetected} ended the mission "
            "undetected"
        )
    else:
        lines.append(
            "the file is of an earlier version, without what became of the missions: who noticed "
            "is not known, and each failed mission counts as undetected"
        )
    lines += [f"{advice.location}: {advice.words}" for advice in advice_of(cells)]
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


def dfmea_text(found: Evidence) -> str:
    """Return the table as CSV with the columns of a DFMEA; its ratings are the engineer's."""
    return csv_of(DFMEA_HEADINGS, (row.dfmea_values for row in fmea_rows(found)))


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
