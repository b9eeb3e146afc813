"""What changed in runs, missions and inputs: lists, each with its title."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from tracerisk.common.verdict import UNKNOWN_VERDICT, Verdict, verdict_line
from tracerisk.instrument.source.answers.changed_checks import ChangedCheck
from tracerisk.instrument.source.language import is_c
from tracerisk.prm.review.change_records import (
    is_noise,
)
from tracerisk.prm.review.risk_diff import Review, RiskDiff
from tracerisk.report.diff.wording import (
    count,
    first_of,
    pins,
    some,
)

OF_RUN = "What the run showed that it did not before"


OF_MOVED = "Values set by hand for what their function does no more, or not alone"


OF_COMPARISON = "How far the outcomes of the two runs are compared"


OF_EVIDENCE = "What failures on the twin do now that they did not before"


OF_OUTCOME = "What changed in what the mission does"


MOST_OF_KIND = 6
"""How many sentences on the outcome of one kind are shown; --json has all."""


ASKED_LESS = "What else `success` no longer asks"


ASKED_OTHERWISE = "What `success` asks otherwise"


ASKED_NEWLY = "What `success` newly asks"


NOT_ASKED = "What the mission newly moves and `success` does not name"


LOST_CHECKS = "Answers that nobody looks at any more"


NEW_CHECKS = "Answers that are newly looked at"


NOT_CREDITED = ", which no figure credits without evidence"


OF_VISITS = "Functions that run more or less often"


OF_PACE = "What takes another time"


OF_HARDWARE = "What changed in the hardware description"


BROKE = "What broke"


ALSO_BROKE = "What else broke"


REPAIRED = "What was repaired"


OF_INPUTS = "What the runs behind the blocks depended on"


def verdict_lines(review: Review, *, only_wrong: bool = False) -> list[str]:
    """Return the verdicts of the later runs with those of the earlier, a line a controller.

    If asked, only of runs that went wrong, lost their verdict, or left out what they did before.
    """
    lines = []
    for diff in review.controllers:
        if only_wrong and not _is_wrong(diff):
            continue
        name = "" if len(review.controllers) == 1 else f"{diff.name}: "
        if diff.verdicts is None:
            lines += [f"{name}no verdict: a log of C or C++ has none"] if is_c(diff.name) else []
            continue
        if not diff.verdicts.in_after:
            lines.append(f"{name}no risk blocks; before: {verdict_line(diff.verdicts.before)}")
            continue
        before = f"; before: {_short(diff.verdicts.before)}" if diff.verdicts.in_before else ""
        stale = " (of its last run: stale)" if diff.stale else ""
        after = diff.refused or verdict_line(diff.verdicts.after) + stale
        lines.append(f"{name}{after}{before}")
    return lines


def _is_wrong(diff: RiskDiff) -> bool:
    verdicts = diff.verdicts
    if verdicts is None or not verdicts.in_after:
        return False
    is_whole = verdicts.after is not None and not verdicts.after.is_bad and not diff.refused
    return not is_whole or verdicts.does_less


def later_run(diff: RiskDiff) -> str:
    """Return the verdict of the later run in a few words; empty where there is none."""
    verdicts = diff.verdicts
    if verdicts is None or not verdicts.in_after:
        return ""
    if diff.refused:
        return f"{diff.refused.partition(':')[0]}, no blocks written"
    return _short(verdicts.after) + (", stale" if diff.stale else "")


def _short(verdict: Verdict | None) -> str:
    if verdict is None:
        return UNKNOWN_VERDICT
    return f"{verdict.kind}, {verdict.coverage.ran} of {verdict.coverage.all}"


def acceptances(diffs: Sequence[RiskDiff]) -> list[str]:
    """Return what a change accepts of its own runs and what happened there, a line each."""
    lines = []
    for diff in diffs:
        if diff.verdicts is None or diff.verdicts.after is None:
            continue
        name = "" if len(diffs) == 1 else f"{diff.name}: "
        for acceptance in diff.verdicts.new_acceptances:
            accepted = [
                str(reason)
                for reason in diff.verdicts.after.reasons
                if reason.accepted and reason.key == acceptance.key
            ]
            what = f"what happened: {some(accepted)}" if accepted else "it did not occur"
            lines.append(f"{name}newly accepted: {acceptance}; {what}")
    return lines


def asked_less(diffs: Sequence[RiskDiff]) -> list[str]:
    """Return of which controllers `success` asks less, a line each: this stands before all else."""
    return [f"{diff.name} {is_asked_less(diff)}" for diff in diffs if diff.asked_less]


def is_asked_less(diff: RiskDiff) -> str:
    """Return that `success` asks less, and the first that it does not ask any more."""
    return f"is asked less: `success` no longer asks {first_of(diff.asked_less)}"


def warnings(review: Review) -> list[str]:
    """Return what stands before all else, a line each.

    `success` asks less, a check is lost, or the branch that the change goes to has moved on.
    """
    lost = [diff for diff in review.controllers if diff.lost_checks]
    checks = [f"{diff.name} {looks_at_less(review, diff)}" for diff in lost]
    return [*asked_less(review.controllers), *checks, *review.moved_on]


def looks_at_less(review: Review, diff: RiskDiff) -> str:
    """Return the first answer that a controller no longer looks at, and what may follow."""
    said = first_of(of_checks(review, diff.lost_checks))
    return f"looks at less: {said}: a failure there may go unnoticed"


def of_checks(review: Review, checks: Sequence[ChangedCheck]) -> tuple[str, ...]:
    """Return checks of answers that only one version has, a line each."""
    lines = []
    for check in checks:
        verb = "no longer" if check.is_lost else "now"
        place = review.place(check.location, is_gone=check.is_lost)
        lines.append(f"{check.function} {verb} looks at {check.answer} ({place})")
    return tuple(lines)


def _checks_lists(review: Review, diff: RiskDiff) -> list[tuple[str, list[str]]]:
    """Return the lists of checks that are lost or new; the only lost one stands above all else."""
    lost = of_checks(review, diff.lost_checks)
    new = of_checks(review, [check for check in diff.checks if not check.is_lost])
    title = NEW_CHECKS + ("" if diff.undetected is not None else NOT_CREDITED)
    pairs = ((LOST_CHECKS, lost if len(lost) > 1 else ()), (title, new))
    return [(title, list(_at_most(lines))) for title, lines in pairs if lines]


def above_figures(review: Review, diff: RiskDiff) -> list[tuple[str, list[str]]]:
    """Return what a reviewer must see before any figure, with the title of each list."""
    pairs = [
        *_of_missions(diff),
        (OF_MOVED, [f"{one.message}; {one.remedy}" for one in diff.moved]),
        (OF_COMPARISON, list(diff.of_comparison)),
        (OF_RUN, list(diff.of_run)),
        (OF_EVIDENCE, list(diff.of_evidence)),
        *_checks_lists(review, diff),
        (OF_HARDWARE, list(_at_most(diff.hardware))),
    ]
    return [(title, lines) for title, lines in pairs if lines]


def _of_missions(diff: RiskDiff) -> list[tuple[str, list[str]]]:
    """Return what the later run brought about otherwise, and what broke and was repaired."""
    pairs = [
        (ASKED_LESS, list(_at_most(diff.asked_less[1:]))),
        (ASKED_OTHERWISE, list(_at_most(diff.asked_otherwise))),
        (ASKED_NEWLY, list(_at_most(diff.asked_newly))),
    ]
    if diff.outcome is not None:
        kinds = (diff.outcome.result, diff.outcome.lost, diff.outcome.added)
        pairs.append((OF_OUTCOME, [line for kind in kinds for line in _at_most(kind)]))
        pairs.append((NOT_ASKED, list(_at_most(diff.not_asked))))
        if diff.is_other_mission:
            pairs.append((OF_VISITS, list(_at_most(tuple(_visits(diff))))))
    if diff.verdicts is not None:
        broke = list(map(str, diff.verdicts.broke))
        # What stands in the line of the verdict is not said again.
        others = [text for text in broke if not (_is_wrong(diff) and _is_said(diff, text))]
        pairs += [
            (BROKE if len(others) == len(broke) else ALSO_BROKE, others),
            (REPAIRED, [str(reason) for reason in diff.verdicts.repaired]),
        ]
    return pairs


def below_figures(review: Review, diff: RiskDiff) -> list[tuple[str, list[str]]]:
    """Return what else differs, with the title of each list."""
    single = [f"{point.component}, in {some(point.functions)}" for point in diff.single_points]
    pairs = [
        ("Single points of failure that were none", single),
        ("Values set by hand", pins(review, diff)),
        (OF_PACE, list(of_pace(diff))),
        (OF_INPUTS, list(of_inputs(diff))),
    ]
    return [(title, lines) for title, lines in pairs if lines]


def of_inputs(diff: RiskDiff) -> Iterator[str]:
    """Yield which other inputs of the run changed: not the controller, nor what is listed above."""
    known = {f"{diff.name} has changed"}
    if diff.was is not None:
        known |= {f"{diff.name} is part of the run now"}
        known |= {f"{diff.was} is no part of the run any more"}
    for line in diff.inputs:
        file = line.removesuffix(" has changed")
        is_told = file != line and any(f"({file}:" in told for told in diff.hardware)
        if line not in known and not is_told:
            yield line


def _is_said(diff: RiskDiff, reason: str) -> bool:
    verdict = None if diff.verdicts is None else diff.verdicts.after
    return verdict is not None and reason in verdict_line(verdict)


def _visits(diff: RiskDiff) -> Iterator[str]:
    """Yield which functions another mission visits more or less often, those alike in one line."""
    alike: dict[tuple[str, str], list[str]] = {}
    for function in diff.functions:
        old, new = function.before, function.after
        if old is None or new is None or is_noise(old.expected_visits, new.expected_visits):
            continue
        counts = count(new.expected_visits), count(old.expected_visits)
        alike.setdefault(counts, []).append(function.name)
    for (now, was), names in alike.items():
        yield f"{', '.join(names)}: {now} visit{'s' * (now != '1')}, before: {was}"


def of_pace(diff: RiskDiff) -> tuple[str, ...]:
    """Return which rests and ways of the later run take another time; nothing if it went wrong."""
    verdict = None if diff.verdicts is None else diff.verdicts.after
    if diff.outcome is None or (verdict is not None and verdict.is_bad):
        return ()
    pace = diff.outcome.pace
    was, now = diff.outcome.arm_s
    if len(pace) <= MOST_OF_KIND or was is None or now is None:
        return _at_most(pace)
    whole = f"the arm is under way for {now:.1f} s, before: {was:.1f} s"
    return (whole, f"{len(pace)} ways and rests take another time; --json lists them")


def _at_most(lines: tuple[str, ...]) -> tuple[str, ...]:
    if len(lines) <= MOST_OF_KIND:
        return lines
    return (*lines[:MOST_OF_KIND], f"and {len(lines) - MOST_OF_KIND} more; --json lists them")
