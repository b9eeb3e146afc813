"""A change of risk as Markdown, for a comment on a pull request."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from tracerisk.prm.review.change_records import FunctionFigures, Review, RiskDiff
from tracerisk.report.diff import sentences

TAG = "<!-- tracerisk-diff -->"
"""By it a bot finds the comment that it wrote before."""

MOST_CONTROLLERS = 50
MOST_CHANGES = 30
"""How many controllers and changes of one are shown; GitHub takes 65,536 characters a comment."""

_NONE = "none"
_SPECIAL = re.compile(r"([\\`*_\[\]<>|~])")


def render_diff_markdown(review: Review) -> str:
    """Return the review as Markdown: one sentence, a small table, the rest folded."""
    shown = review.controllers[:MOST_CONTROLLERS]
    lines = [TAG]
    verdicts = sentences.verdict_lines(review)[:MOST_CONTROLLERS]
    accepted = [line for risk_diff in shown for line in sentences.acceptances(risk_diff)]
    for line in (*verdicts, *accepted):
        lines += [_escaped(line), ""]
    lines += [f"**{_escaped(sentences.headline(review, below_verdicts=True))}**", ""]
    for risk_diff in shown:
        for title, entries in sentences.of_missions(risk_diff):
            of = "" if len(shown) == 1 else f", {risk_diff.name}"
            lines += _list(title + _escaped(of), entries)
    if review.controllers:
        lines += _table(
            ("controller", _escaped(review.before), _escaped(review.after), "ratio", "per cycle"),
            [_figures(risk_diff) for risk_diff in shown],
            right=(1, 2, 3, 4),
        )
    for risk_diff in shown:
        parts = list(_parts(review, risk_diff))
        if parts:
            lines += [
                "<details>",
                f"<summary>What changed in {_html(risk_diff.name)}</summary>",
                "",
                *parts,
                "</details>",
                "",
            ]
    notes = [_escaped(note) for note in review.notes]
    if len(review.controllers) > len(shown):
        notes.insert(0, f"and {len(review.controllers) - len(shown)} more controllers")
    if notes:
        lines += [*(f"- {note}" for note in notes), ""]
    lines.append(f"*{_escaped(review.statement)}*")
    return "\n".join(lines) + "\n"


def _figures(diff: RiskDiff) -> tuple[str, ...]:
    old, new = diff.before, diff.after
    ratio = cycles = ""
    if old is not None and new is not None:
        ratio = sentences.ratio(old.failure_probability, new.failure_probability)
        ratio = ratio if diff.is_comparable else "not comparable"
        earlier, later = old.cycle_failure_probability, new.cycle_failure_probability
        cycles = f"{sentences.probability(earlier)} → {sentences.probability(later)}"
    return (
        _escaped(sentences.name_of(diff)),
        _NONE if old is None else sentences.probability(old.failure_probability),
        _NONE if new is None else sentences.probability(new.failure_probability),
        ratio,
        cycles,
    )


def _parts(review: Review, diff: RiskDiff) -> Iterator[str]:
    if diff.changes and diff.is_comparable:
        small = sentences.small_changes(diff)
        large = [change for change in diff.changes if change not in small]
        rows = [
            (
                sentences.difference(change.contribution),
                _escaped(change.summary) + _marked(sentences.marks(change)),
                _escaped(sentences.causes(change)),
                _escaped(sentences.places(review, change)),
            )
            for change in large[:MOST_CHANGES]
        ]
        if len(large) > MOST_CHANGES:
            rows.append(("", f"and {len(large) - MOST_CHANGES} more changes", "", ""))
        if small:
            rows.append(("", sentences.small_line(small, diff), "", ""))
        if diff.interaction is not None and sentences.has_interaction(diff):
            text = "what they do only together, and noise"
            rows.append((sentences.difference(diff.interaction), text, "", ""))
        yield from _table(("alone", "change", "cause", "where"), rows, right=(0,))
    functions = [function for function in diff.functions if function.status != "unchanged"]
    if functions and diff.is_comparable:
        yield from _table(
            ("function", "a visit, before", "after", "visits, before", "after"),
            [
                (
                    _escaped(sentences.name_of(function)),
                    *_of_function(function.before, function.after),
                )
                for function in functions
            ],
            right=(1, 2, 3, 4),
        )
    for point in diff.single_points:
        where = f"{point.component} is a single point of failure now, in "
        yield f"- {_escaped(where + sentences.some(point.functions))}"
    for pin in diff.pins:
        place = review.place(pin.location, is_gone=pin.kind == "removed")
        yield f"- {_escaped(sentences.pin(pin))} ({_escaped(place)})"
    if diff.within_noise:
        yield f"- values that changed by less than 1 %, reported as unchanged: {diff.within_noise}"
    if diff.single_points or diff.pins or diff.within_noise:
        yield ""
    yield from _list(sentences.OF_PACE, sentences.of_pace(diff))
    yield from _list(sentences.OF_RUN, diff.of_run)
    yield from _list(sentences.OF_INPUTS, diff.inputs)


def _list(title: str, entries: Sequence[str]) -> Iterator[str]:
    if entries:
        yield from (f"{title}:", "", *(f"- {_escaped(entry)}" for entry in entries), "")


def _marked(marks: str) -> str:
    return f" (**{marks}**)" if marks else ""


def _of_function(
    before: FunctionFigures | None, after: FunctionFigures | None
) -> tuple[str, str, str, str]:
    return (
        _NONE if before is None else sentences.probability(before.top_event),
        _NONE if after is None else sentences.probability(after.top_event),
        _NONE if before is None else sentences.count(before.expected_visits),
        _NONE if after is None else sentences.count(after.expected_visits),
    )


def _table(
    heads: Sequence[str], rows: Sequence[Sequence[str]], *, right: Sequence[int]
) -> Iterator[str]:
    yield f"| {' | '.join(heads)} |"
    yield f"|{'|'.join('---:' if i in right else '---' for i in range(len(heads)))}|"
    for row in rows:
        yield f"| {' | '.join(row)} |"
    yield ""


def _escaped(text: str) -> str:
    """Keep names and reasons from being read as Markdown, HTML, a mention or a cell's end."""
    return _SPECIAL.sub(r"\\\1", " ".join(text.split())).replace("@", "@\u200b")


def _html(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
