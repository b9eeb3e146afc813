"""What failures did on the twin: effects by function and component, delays, and the FMEA."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TypeVar
from xml.etree.ElementTree import SubElement

from tracerisk.common.evidence.cells import EFFECTS, Cell, Evidence
from tracerisk.report.fmea import (
    FATE_WORDS,
    WORDS,
    all_effects,
    end_effect,
    fmea_rows,
    summary_lines,
)
from tracerisk.report.html.page import asset, page, rendered
from tracerisk.report.html.section import Section
from tracerisk.report.html.svg import Drawing, number
from tracerisk.report.html.tables import Cell as TableCell
from tracerisk.report.html.tables import Column, Table, row_of, texts

T = TypeVar("T")

_MOST_UNFOLDED = 12
_WIDTH, _ROW, _LABEL = 640.0, 22.0, 270.0
_NOTE = 150.0  # beside the rows: how many failures were not noticed
_TICKS = 5


Pages = Mapping[tuple[str, str, float], str]
"""The file that shows a failure, by the key of its cell."""


def render_evidence(found: Evidence, name: str, pages: Pages, without: str) -> str:
    """Return the page of a campaign alone, the same for the same input.

    `pages` show single failures, and `without` the run that they are compared with.
    """
    lead = rendered(
        "fault.html.j2",
        name=name,
        context=(found.robot,),
        sentence=f"What {len(found.cells)} failures do to the mission",
    )
    section = evidence_section(found, is_used=None, pages=pages)
    runs = rendered("evidence_runs.html.j2", number=len(pages), without=without)
    return page(f"Failures of {name}", lead, (Section("replays", "Replays", runs), section))


def render_beside(name: str, pages: Pages, without: str) -> str:
    """Return the page that shows the failure named in its address beside the run without one.

    Both show the same instant.
    """
    return rendered("beside.html.j2", name=name, pages=sorted(pages.values()), without=without)


def evidence_section(
    found: Evidence, *, is_used: bool | None, pages: Pages | None = None
) -> Section:
    """Return the section; `is_used` says whether the figures beside it take the evidence.

    It is `None` where there are no figures.
    """
    pages = pages or {}
    cells = found.cells
    harmless = [cell for cell in cells if not cell.is_idle and not cell.fails]
    needed = [cell for cell in cells if cell.is_idle and cell.fails]
    html = rendered(
        "evidence.html.j2",
        lines=summary_lines(found),
        success=found.success,
        is_used=is_used,
        matrix=_matrix(found, pages),
        legend=[(effect, WORDS[effect]) for effect in EFFECTS],
        delays=_delays(cells),
        undetected=_listed(
            "evidence-undetected",
            "Undetected",
            [cell for cell in cells if cell.is_undetected and found.has_fates],
            pages,
        ),
        harmless=_listed("evidence-harmless", "In use, but harmless", harmless, pages),
        needed=_listed("evidence-needed", "Idle, but needed", needed, pages),
        table=_table(found, pages),
        most=_MOST_UNFOLDED,
    )
    return Section("evidence", "Failures on the twin", html, css=asset("evidence.css"))


def _matrix(found: Evidence, pages: Pages) -> dict[str, object]:
    """Return the worst effect of each component in each function, with its share of failures."""
    functions = _ordered(cell.function for cell in _by_time(found.cells))
    kinds = _ordered((cell.component, cell.mode) for cell in found.cells)
    tried = {(row.component, row.mode, row.function): row for row in fmea_rows(found)}
    rows = []
    for component, mode in kinds:
        entries = []
        for function in functions:
            row = tried.get((component, mode, function))
            if row is None:
                entries.append(("none", "", "", ""))
                continue
            failed = f"{row.failed} of {len(row.cells)}"
            failed += f", {row.undetected} undetected" if row.undetected else ""
            link = next((pages[cell.key] for cell in row.cells if cell.key in pages), "")
            entries.append((str(row.worst.effect), end_effect(row.cells), failed, link))
        rows.append((component, mode.replace("_", " "), entries))
    return {"functions": functions, "rows": rows}


def _delays(cells: Sequence[Cell]) -> object:
    """Return a drawing of when the controller noticed each failure, a row for each mode."""
    noticed = [cell for cell in cells if cell.noticed_s is not None]
    if not noticed:
        return ""
    most = max(cell.noticed_s or 0.0 for cell in noticed) or 1.0
    kinds = _ordered((cell.component, cell.mode) for cell in cells)
    drawing = Drawing(
        "evidence-delays",
        "When the controller noticed",
        "A dot for each failure that it noticed, by component and mode, over the seconds after "
        "it; beside them how many it did not notice while the run was followed.",
    )
    for index, (component, mode) in enumerate(kinds):
        y = (index + 0.5) * _ROW
        group = drawing.group("delays")
        name = f"{component} {mode.replace('_', ' ')}"
        label = SubElement(group, "text", {"x": "0", "y": number(y + 4.0)})
        label.text = name if len(name) <= 36 else f"{name[:35]}…"
        drawing.path(f"M{number(_LABEL)} {number(y)} H{number(_WIDTH)}", "edge")
        mine = [cell for cell in cells if (cell.component, cell.mode) == (component, mode)]
        for cell in mine:
            if cell.noticed_s is not None:
                x = _LABEL + (_WIDTH - _LABEL) * cell.noticed_s / most
                kind = "fails" if cell.is_undetected else "harmless"
                place = {"cx": number(x), "cy": number(y), "r": "3.5", "class": kind}
                SubElement(group, "circle", place)
        never = sum(1 for cell in mine if cell.noticed_s is None)
        if never:
            note = SubElement(group, "text", {"x": number(_WIDTH + 12.0), "y": number(y + 4.0)})
            note.text = f"{never} not noticed"
    bottom = len(kinds) * _ROW + 16.0
    axis = drawing.group("axis")
    for tick in range(_TICKS):
        share = tick / (_TICKS - 1)
        x = _LABEL + (_WIDTH - _LABEL) * share
        text = SubElement(axis, "text", {"x": number(x), "y": number(bottom)})
        text.set("text-anchor", "middle")
        text.text = f"{share * most:.3g} s"
    return drawing.markup(_WIDTH + _NOTE, bottom + 6.0)


def _listed(name: str, caption: str, cells: Sequence[Cell], pages: Pages) -> Table | None:
    if not cells:
        return None
    columns = (
        *texts("failure", "function"),
        Column("at s", "instant of the failure", is_number=True),
        Column("end effect"),
        Column("mission"),
        Column("see it", "the option of tracerisk run"),
    )
    rows = tuple(
        row_of(
            TableCell(f"{cell.component} {cell.mode.replace('_', ' ')}", note=cell.unit),
            cell.function,
            f"{cell.time_s:.3f}",
            TableCell(end_effect((cell,)), note="; ".join(cell.lost)),
            "not known" if cell.fate is None else FATE_WORDS[cell.fate],
            TableCell(
                f"--fault {cell.unit}:{cell.mode}@{cell.time_s:g}", link=pages.get(cell.key, "")
            ),
            function=cell.function,
        )
        for cell in cells
    )
    return Table(name, caption, columns, rows)


def _table(found: Evidence, pages: Pages) -> Table:
    columns = (
        *texts("failure", "function"),
        Column("end effect", "the worst of the tries"),
        Column("noticed after s", "median, of those noticed", is_number=True),
        Column("noticed by"),
        Column("failed", "of the tries", is_number=True),
        Column("undetected", "failed unnoticed, or with harm before the stop", is_number=True),
        Column("c", "share that ends the mission, with its 90 % interval", is_number=True),
    )
    rows = []
    for row in fmea_rows(found):
        low, high = row.interval
        shown = (pages[cell.key] for cell in row.cells if cell.key in pages)
        rows.append(
            row_of(
                f"{row.component} {row.mode.replace('_', ' ')}",
                row.function,
                TableCell(
                    end_effect(row.cells),
                    link=next(shown, ""),
                    note="; ".join(filter(None, (all_effects(row.worst), row.hardest))),
                ),
                row.noticed,
                row.detection,
                f"{row.failed} of {len(row.cells)}",
                str(row.undetected),
                TableCell(f"{row.share:.2f}", note=f"{low:.2f} to {high:.2f}"),
                function=row.function,
                component=row.component,
            )
        )
    return Table("evidence-fmea", "Failure modes and effects", columns, tuple(rows))


def _by_time(cells: Iterable[Cell]) -> list[Cell]:
    return sorted(cells, key=lambda cell: cell.time_s)


def _ordered(values: Iterable[T]) -> list[T]:
    return list(dict.fromkeys(values))
