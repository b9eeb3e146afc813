"""How a trace shows itself in a notebook: when each function ran, and for how long it used what.

It needs nothing but the standard library, and is imported only when a trace is shown.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from html import escape
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from tracerisk.trace import Trace, TracedFunction

_Shown = TypeVar("_Shown")

_MOST_FUNCTIONS = 30
_MOST_ELEMENTS = 16
_MOST_BARS = 600
_LONGEST = 28
_CHARACTER, _ROW, _BAR, _WIDE, _MARGIN = 6.6, 20.0, 12.0, 640.0, 12.0  # [px]
_INK, _PAPER, _FAINT, _FILL = "#222222", "#ffffff", "#767676", "#9db4d6"


def trace_html(trace: Trace) -> str:
    """Return a trace as HTML: how the run ended, its visits over time, seconds by element.

    Names are text and never markup. Of very many functions, elements or visits the first are
    shown, and the rest is counted.
    """
    findings = f"<p>{escape(_counted(trace))}</p>"
    head = f"<h4>{escape(trace.controller)}</h4><p>{escape(_headline(trace))}</p>"
    drawing = _timeline(trace) if trace.end.simulated_s and trace.visits else ""
    return f"<div>{head}{drawing}{_table(trace)}{findings}</div>"


def trace_text(trace: Trace) -> str:
    """Return a trace as text of a few lines."""
    lines = [f"Trace of {trace.controller}: {_headline(trace)}"]
    functions, more = _shown(trace.functions, _MOST_FUNCTIONS)
    for function in functions:
        visits = [visit for visit in trace.visits if visit.function == function.ref]
        seconds = math.fsum(visit.duration_s or 0.0 for visit in visits)
        lines.append(f"  {function.ref.name}: {_plural(len(visits), 'visit')}, {seconds:.2f} s")
    if more:
        lines.append(f"  and {more} more functions")
    return "\n".join([*lines, _counted(trace)])


def _headline(trace: Trace) -> str:
    seconds = trace.end.simulated_s
    parts = [f"on {trace.robot} in scene {trace.scene}"] if trace.robot else []
    parts += [] if seconds is None else [f"{seconds:.1f} s simulated"]
    return ", ".join([*parts, trace.end.message])


def _counted(trace: Trace) -> str:
    counts = [
        _plural(len(trace.functions), "function"),
        _plural(len(trace.visits), "visit"),
        _plural(len(trace.findings), "finding"),
        f"{_plural(len(trace.uncovered), 'function')} that can move the arm but never ran",
    ]
    return ", ".join(counts)


def _table(trace: Trace) -> str:
    """Return a table of functions by elements, with the seconds for which each was in use."""
    functions, more = _shown(trace.functions, _MOST_FUNCTIONS)
    seconds: dict[tuple[object, str], float] = {}
    unknown: set[tuple[object, str]] = set()
    for visit in trace.visits:
        for name, exposure in visit.exposures.items():
            key = visit.function, name
            if exposure is None:
                unknown.add(key)
                continue
            seconds[key] = seconds.get(key, 0.0) + (exposure.active_s or exposure.reading_s)
    used = {name for (_, name), total in seconds.items() if total >= 0.005}
    used |= {name for _, name in unknown}
    elements, left_out = _shown([e.name for e in trace.elements if e.name in used], _MOST_ELEMENTS)
    head = ["function", "visits", "seconds", *elements]
    rows = []
    for function in functions:
        visits = [visit for visit in trace.visits if visit.function == function.ref]
        known = [visit.duration_s for visit in visits if visit.duration_s is not None]
        row = [function.ref.name, str(len(visits)), f"{math.fsum(known):.2f}" if known else ""]
        for name in elements:
            key = function.ref, name
            total = seconds.get(key, 0.0)
            row.append("in use" if key in unknown else f"{total:.2f}" if total >= 0.005 else "")
        rows.append(row)
    remarks = [f"{more} more functions"] if more else []
    remarks += [f"{left_out} more elements"] if left_out else []
    rest = f"<p>and {' and '.join(remarks)}</p>" if remarks else ""
    body = "".join(_html_row("td", row) for row in rows)
    return f"<table><thead>{_html_row('th', head)}</thead><tbody>{body}</tbody></table>{rest}"


def _timeline(trace: Trace) -> str:
    """Return a drawing with a row for each function and a bar for each of its visits."""
    functions, _ = _shown(trace.functions, _MOST_FUNCTIONS)
    left = (
        max(
            (_CHARACTER * len(_short(traced_function.ref.name)) for traced_function in functions),
            default=0.0,
        )
        + 10
    )
    end_s = max(trace.end.simulated_s or 0.0, 1e-9)
    height = _ROW * (len(functions) + 1)
    parts = list(_bars(trace, functions, left, _WIDE / end_s))
    for rank, function in enumerate(functions):
        name = function.ref.name
        title = f"<title>{escape(name)}</title>" if _short(name) != name else ""
        y = rank * _ROW + 14
        parts.append(
            f"<text x='{left - 10:.1f}' y='{y:.1f}' text-anchor='end'>{escape(_short(name))}"
            f"{title}</text>"
        )
    base = _ROW * len(functions) + 2
    parts.append(f"<path d='M{left:.1f} {base:.1f} h{_WIDE:.0f}' stroke='{_FAINT}'/>")
    for x, text, anchor in ((left, "0 s", "start"), (left + _WIDE, f"{end_s:.1f} s", "end")):
        parts.append(
            f"<text x='{x:.1f}' y='{base + 14:.1f}' text-anchor='{anchor}' fill='{_FAINT}'>"
            f"{text}</text>"
        )
    wide, high = left + _WIDE + 2 * _MARGIN, height + 2 * _MARGIN
    return (
        f"<svg xmlns='http://www.w3.org/2000/svg' width='{wide:.0f}' height='{high:.0f}' "
        f"viewBox='{-_MARGIN:.0f} {-_MARGIN:.0f} {wide:.0f} {high:.0f}' "
        "style='max-width:100%;height:auto' font-family='sans-serif' font-size='12' "
        f"fill='{_INK}'><title>{escape(f'Visits of {trace.controller} over time')}</title>"
        f"<rect x='{-_MARGIN:.0f}' y='{-_MARGIN:.0f}' width='{wide:.0f}' height='{high:.0f}' "
        f"fill='{_PAPER}'/>{''.join(parts)}</svg>"
    )


def _bars(
    trace: Trace, functions: Sequence[TracedFunction], left: float, scale: float
) -> Iterator[str]:
    rank_of = {function.ref: rank for rank, function in enumerate(functions)}
    visits = [visit for visit in trace.visits if visit.function in rank_of]
    for visit in visits[:_MOST_BARS]:
        x = left + visit.start_s * scale
        width = max((visit.duration_s or 0.0) * scale, 1.0)
        y = rank_of[visit.function] * _ROW + 4
        seconds = "" if visit.duration_s is None else f", {visit.duration_s:.2f} s"
        words = f"{visit.function.name}: from {visit.start_s:.2f} s{seconds}, {visit.outcome}"
        yield (
            f"<rect x='{x:.1f}' y='{y:.1f}' width='{width:.1f}' height='{_BAR:.0f}' "
            f"fill='{_FILL}' stroke='{_INK}' stroke-width='0.5'>"
            f"<title>{escape(words)}</title></rect>"
        )
    if len(visits) > _MOST_BARS:
        y = _ROW * len(functions) + 16
        text = f"the first {_MOST_BARS} of {len(visits)} visits"
        yield (
            f"<text x='{left + _WIDE / 2:.1f}' y='{y:.1f}' text-anchor='middle' fill='{_FAINT}'>"
            f"{text}</text>"
        )


def _shown(found: Sequence[_Shown], most: int) -> tuple[Sequence[_Shown], int]:
    return found[:most], max(len(found) - most, 0)


def _plural(count: int, noun: str) -> str:
    return f"{count} {noun}{'' if count == 1 else 's'}"


def _short(name: str) -> str:
    return name if len(name) <= _LONGEST else f"{name[: _LONGEST - 1]}…"


def _html_row(tag: str, texts: Sequence[str]) -> str:
    return f"<tr>{''.join(f'<{tag}>{escape(text)}</{tag}>' for text in texts)}</tr>"
