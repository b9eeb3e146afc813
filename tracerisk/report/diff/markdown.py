"""A change of risk as Markdown, for a comment on a pull request."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from tracerisk.common.text.one_in import one_in
from tracerisk.common.verdict import Verdict
from tracerisk.prm.review.change_records import NOISE, FunctionFigures
from tracerisk.prm.review.risk_diff import Review, RiskDiff
from tracerisk.report.diff import sentences, titled_lists, wording
from tracerisk.report.diff.links import Links, escaped, in_html

TAG = "<!-- tracerisk-diff -->"
"""By it a bot finds the comment that it wrote before."""

MOST_CONTROLLERS = 50
MOST_CHANGES = 30
"""How many controllers and changes of one are shown."""
MOST_UNFOLDED = 3
"""Of so many controllers the lists are shown that a reviewer must see; of others they are folded.
"""
MOST_CHARACTERS = 65_000
"""The length of a comment; GitHub takes 65,536 characters."""

_NONE = "none"
_NOT_KNOWN = "not known"


def render_diff_markdown(review: Review, *, link_base: str | None = None) -> str:
    """Return the review as Markdown: what went wrong, one sentence, a small table, the rest folded.

    Where nothing changed it is one line. `link_base` is the address that a commit, a path and a
    line follow, such as `https://github.com/OWNER/NAME/blob`: places lead there.
    """
    links = Links(review, link_base)
    if not review.is_worth_telling(NOISE) and not review.notes:
        headline = links.text(sentences.headline(review, one_in_n=True))
        return f"{TAG}\n**{headline}** *{escaped(review.statement)}*\n"
    shown = review.controllers[:MOST_CONTROLLERS]
    head = [TAG]
    verdicts = titled_lists.verdict_lines(review, only_wrong=True)[:MOST_CONTROLLERS]
    warnings = titled_lists.warnings(replace(review, controllers=shown))
    head += [line for text in warnings for line in (f"**{links.text(text)}**", "")]
    for line in (*titled_lists.acceptances(shown), *verdicts):
        head += [links.text(line), ""]
    headline = sentences.headline(review, below_verdicts=bool(verdicts), one_in_n=True)
    head += [f"**{links.text(headline)}**", ""]
    above = titled_lists.above_figures
    unfolded = [diff for diff in shown if above(review, diff)][:MOST_UNFOLDED]
    for risk_diff in unfolded:
        of = "" if len(shown) == 1 else f", {risk_diff.name}"
        for title, entries in above(review, risk_diff):
            head += _list(title + escaped(of), entries, links)
    if review.controllers:
        head += _summary(review, shown, links)
    folded = []
    for risk_diff in shown:
        parts = list(_parts(review, risk_diff, links, with_lists=risk_diff not in unfolded))
        if parts:
            title = f"<summary>What changed in {in_html(risk_diff.name)}</summary>"
            folded.append(["<details>", title, "", *parts, "</details>", ""])
    notes = [escaped(note) for note in review.notes]
    if len(review.controllers) > len(shown):
        notes.insert(0, f"and {len(review.controllers) - len(shown)} more controllers")
    return _fitting(head, folded, notes, f"*{escaped(review.statement)}*")


def _fitting(
    head: Sequence[str], folded: Sequence[Sequence[str]], notes: Sequence[str], end: str
) -> str:
    """Return as much of a comment as a comment may hold, and what was left out."""
    kept, left_out = list(folded), 0
    head = list(head)
    while True:
        more = [*notes]
        if left_out:
            more.append("too long for a comment: `tracerisk diff` prints the rest")
        listed = [*(f"- {note}" for note in more), ""] if more else []
        text = "\n".join([*head, *(line for part in kept for line in part), *listed, end]) + "\n"
        if len(text) <= MOST_CHARACTERS:
            return text
        left_out += 1
        if kept:
            kept.pop()
        elif notes:
            notes = notes[:-1]
        else:
            head.pop()


def _summary(review: Review, shown: Sequence[RiskDiff], links: Links) -> Iterator[str]:
    heads = ["controller", escaped(review.before), escaped(review.after), "ratio"]
    rows = [list(_figures(risk_diff, links)) for risk_diff in shown]
    more = {
        "undetected": [_of_failure(risk_diff, "undetected") for risk_diff in shown],
        "stopped safely": [_of_failure(risk_diff, "stopped safely") for risk_diff in shown],
        "per cycle": [_cycles(risk_diff) for risk_diff in shown],
        "run": [titled_lists.later_run(risk_diff) for risk_diff in shown],
    }
    for head, cells in more.items():
        if any(cells):
            heads.append(head)
            rows = [[*row, cell] for row, cell in zip(rows, cells, strict=True)]
    right = [i for i, head in enumerate(heads) if head not in ("controller", "run")]
    yield from _table(heads, rows, right=right)


def _cycles(diff: RiskDiff) -> str:
    """Return the figures of a cycle; nothing where they are those of the mission."""
    if diff.before is None or diff.after is None or not wording.has_cycles(diff):
        return ""
    figures = [mission.cycle_failure_probability for mission in (diff.before, diff.after)]
    return " → ".join("none" if p is None else wording.probability(p) for p in figures)


def _of_failure(diff: RiskDiff, name: str) -> str:
    """Return what of a mission's failure is undetected, or stops safely; nothing if not known."""
    both = wording.mission_figures(diff).get(name)
    if both is None:
        return ""
    before, after = (_NOT_KNOWN if it is None else wording.probability(it) for it in both)
    ratio = wording.compared(diff, *both)
    return f"{before} → {after}" + (f" ({ratio})" if ratio else "")


def _figures(diff: RiskDiff, links: Links) -> tuple[str, ...]:
    old, new = wording.mission_figures(diff)["mission failure"]
    name, runs = wording.name_of(diff), diff.verdicts
    return (
        escaped(name) if diff.after is None else links.file(name, diff.name),
        _NONE if old is None else _figure(old, runs.before if runs else None),
        _NONE if new is None else _figure(new, runs.after if runs else None),
        wording.compared(diff, old, new),
    )


def _figure(probability: float, verdict: Verdict | None) -> str:
    """Return a figure with how many missions it is one in; not so that of a run gone wrong."""
    often = None if verdict is not None and verdict.is_bad else one_in(probability)
    return wording.probability(probability) + (f"<br>{often}" if often else "")


def _parts(review: Review, diff: RiskDiff, links: Links, *, with_lists: bool) -> Iterator[str]:
    if with_lists:
        for title, entries in titled_lists.above_figures(review, diff):
            yield from _list(title, entries, links)
    if diff.changes and diff.is_comparable:
        yield from _changes(review, diff, links)
    if diff.shown_functions:
        yield from _table(
            ("function", "a visit, before", "after", "visits, before", "after"),
            [
                (
                    escaped(wording.name_of(function)),
                    *_of_function(function.before, function.after),
                )
                for function in diff.shown_functions
            ],
            right=(1, 2, 3, 4),
        )
    for point in diff.single_points:
        where = f"{point.component} is a single point of failure now, in "
        yield f"- {escaped(where + wording.some(point.functions))}"
    for pin in diff.pins:
        place = review.place(pin.location, is_gone=pin.kind == "removed")
        yield f"- {links.text(f'{wording.pin(pin)} ({place})')}"
    noise = diff.within_noise if diff.is_comparable else 0
    if noise:
        yield f"- values that changed by {wording.noise(diff)}, reported as unchanged: {noise}"
    if diff.single_points or diff.pins or noise:
        yield ""
    yield from _list(titled_lists.OF_PACE, titled_lists.of_pace(diff), links)
    yield from _list(titled_lists.OF_INPUTS, list(titled_lists.of_inputs(diff)), links)


def _changes(review: Review, diff: RiskDiff, links: Links) -> Iterator[str]:
    small = wording.small_changes(diff)
    large = [change for change in diff.changes if change not in small]
    rows = [
        (
            wording.alone(change),
            escaped(change.summary) + _marked(wording.marks(change)),
            escaped(wording.causes(change)),
            links.text(wording.places(review, change)),
        )
        for change in large[:MOST_CHANGES]
    ]
    if len(large) > MOST_CHANGES:
        rows.append(("", f"and {len(large) - MOST_CHANGES} more changes", "", ""))
    if small:
        rows.append(("", wording.small_line(small, diff), "", ""))
    if diff.interaction is not None and wording.has_interaction(diff):
        text = "what they do only together, and noise"
        rows.append((wording.difference(diff.interaction), text, "", ""))
    yield from _table(("alone", "change", "cause", "where"), rows, right=(0,))


def _list(title: str, entries: Sequence[str], links: Links) -> Iterator[str]:
    if entries:
        is_gone = title.startswith(titled_lists.REPAIRED)
        texts = (links.text(entry, is_gone=is_gone) for entry in entries)
        yield from (f"{title}:", "", *(f"- {text}" for text in texts), "")


def _marked(marks: str) -> str:
    return f" (**{marks}**)" if marks else ""


def _of_function(
    before: FunctionFigures | None, after: FunctionFigures | None
) -> tuple[str, str, str, str]:
    return (
        _NONE if before is None else wording.probability(before.top_event),
        _NONE if after is None else wording.probability(after.top_event),
        _NONE if before is None else wording.count(before.expected_visits),
        _NONE if after is None else wording.count(after.expected_visits),
    )


def _table(
    heads: Sequence[str], rows: Sequence[Sequence[str]], *, right: Sequence[int]
) -> Iterator[str]:
    yield f"| {' | '.join(heads)} |"
    yield f"|{'|'.join('---:' if i in right else '---' for i in range(len(heads)))}|"
    for row in rows:
        yield f"| {' | '.join(row)} |"
    yield ""
