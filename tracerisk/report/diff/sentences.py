"""The words that describe a change of risk, the same in every format."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial

from tracerisk.common.outcome.changes import OutcomeChanges
from tracerisk.common.text.one_in import one_in
from tracerisk.common.verdict import UNKNOWN_VERDICT, Verdict, verdict_line
from tracerisk.errors import Location
from tracerisk.instrument.source.language import is_c
from tracerisk.prm.hybrid.assessment import MissionFigures
from tracerisk.prm.review.change_records import (
    NOISE,
    CauseShare,
    FunctionChange,
    Mark,
    PinChange,
    RiskChange,
    RunVerdicts,
    is_noise,
)
from tracerisk.prm.review.risk_diff import Review, RiskDiff, ratio_of

OF_RUN = "What the run showed that it did not before"
OF_EVIDENCE = "What failures on the twin do now that they did not before"
OF_OUTCOME = "What changed in what the mission does"
MOST_OF_KIND = 6
"""How many sentences on the outcome of one kind are shown; --json has all."""
ASKED_LESS = "What `success` no longer asks"
ASKED_NEWLY = "What `success` newly asks"
NOT_ASKED = "What the mission newly moves and `success` does not name"
UNCREDITED = "No evidence: checks of results are not credited"
OF_VISITS = "Functions that run more or less often"
OF_PACE = "What takes another time"
OF_HARDWARE = "What changed in the hardware description"
BROKE, REPAIRED = "What broke", "What was repaired"
OF_INPUTS = "What the runs behind the blocks depended on"

_ANOTHER_WAY = "goes another way, same result"

_MARKS: dict[Mark, str] = {
    "new_state": "new state",
    "lost_state": "lost state",
    "new_next": "new next",
    "lost_redundancy": "lost redundancy",
    "single_point_of_failure": "single point of failure",
}

_CAUSES = {
    "pin": "set by hand",
    "edit": "edited by hand",
    "code": "code",
    "hardware": "hardware",
    "settings": "settings",
    "files": "files of the run",
    "evidence": "evidence",
}


def headline(review: Review, *, below_verdicts: bool = False, one_in_n: bool = False) -> str:
    """Return the one sentence that says what the change did to the risk.

    Where it stands `below_verdicts`, a reason that is in these is not said again. With `one_in_n`
    a figure is also said as one in so many missions.
    """
    said = partial(sentence, below_verdict=below_verdicts, one_in_n=one_in_n)
    changed = [controller for controller in review.controllers if not controller.is_unchanged]
    apart = [controller for controller in review.controllers if not controller.is_comparable]
    if not review.controllers:
        return f"No risk block differs between {review.before} and {review.after}."
    if len(review.controllers) == 1:
        return f"{said(review.controllers[0])}."
    if apart:
        lead = f"The runs of {len(apart)} of {len(review.controllers)} controllers"
        return f"{lead} cannot be compared. The first: {said(apart[0])}."
    stale = [controller for controller in review.controllers if controller.stale]
    if not changed and stale:
        lead = (
            f"Not assessed as they are now: {len(stale)} of {len(review.controllers)} controllers"
        )
        return f"{lead}. The first: {said(stale[0])}."
    if not changed:
        return f"The risk of {len(review.controllers)} controllers is unchanged."
    lead = f"The risk of {len(changed)} of {len(review.controllers)} controllers changed"
    return f"{lead}. The greatest change: {said(changed[0])}."


def whole_headline(review: Review) -> str:
    """Return the headline, behind which controllers must do less."""
    return " ".join((*(f"{line}." for line in asked_less(review.controllers)), headline(review)))


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
            lines += [f"{name}no verdict: C and C++ are not run"] if is_c(diff.name) else []
            continue
        if not diff.verdicts.in_after:
            lines.append(f"{name}no risk blocks; before: {verdict_line(diff.verdicts.before)}")
            continue
        before = f"; before: {_short(diff.verdicts.before)}" if diff.verdicts.in_before else ""
        stale = " (of its last run: stale)" if diff.stale else ""
        lines.append(f"{name}{verdict_line(diff.verdicts.after)}{stale}{before}")
    return lines


def _is_wrong(diff: RiskDiff) -> bool:
    verdicts = diff.verdicts
    if verdicts is None or not verdicts.in_after:
        return False
    is_whole = verdicts.after is not None and not verdicts.after.is_bad
    return not is_whole or verdicts.does_less


def later_run(diff: RiskDiff) -> str:
    """Return the verdict of the later run in a few words; empty where there is none."""
    verdicts = diff.verdicts
    if verdicts is None or not verdicts.in_after:
        return ""
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
    return [f"{diff.name} {must_do_less(diff)}" for diff in diffs if diff.asked_less]


def must_do_less(diff: RiskDiff) -> str:
    """Return that `success` asks less, and the first that it does not ask any more."""
    return f"must do less: `success` no longer asks {first_of(diff.asked_less)}"


def first_of(lines: Sequence[str]) -> str:
    """Return the first of some sentences, and how many more there are."""
    return lines[0] + (f" (and {len(lines) - 1} more)" if len(lines) > 1 else "")


def of_missions(diff: RiskDiff) -> list[tuple[str, list[str]]]:
    """Return what the later run brought about otherwise, and what broke and was repaired.

    Each comes with its title, before any figure is shown.
    """
    pairs = [
        (ASKED_LESS, list(_at_most(diff.asked_less if len(diff.asked_less) > 1 else ()))),
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
        # The one that broke stands in the line of the verdict.
        is_told = len(broke) == 1 and _is_wrong(diff) and _is_said(diff.verdicts.after, broke[0])
        pairs += [
            (BROKE, [] if is_told else broke),
            (REPAIRED, [str(reason) for reason in diff.verdicts.repaired]),
        ]
    return [(title, lines) for title, lines in pairs if lines]


def of_parts(review: Review, diff: RiskDiff) -> list[tuple[str, list[str]]]:
    """Return what else differs, below the figures, with the title of each list."""
    single = [f"{point.component}, in {some(point.functions)}" for point in diff.single_points]
    pairs = [
        ("Single points of failure that were none", single),
        (OF_HARDWARE, list(of_hardware(diff))),
        ("Values set by hand", pins(review, diff)),
        (OF_PACE, list(of_pace(diff))),
        (OF_RUN, list(diff.of_run)),
        (OF_EVIDENCE, list(diff.of_evidence)),
        (UNCREDITED, list(_at_most(diff.uncredited))),
        (OF_INPUTS, list(_inputs(diff))),
    ]
    return [(title, lines) for title, lines in pairs if lines]


def _inputs(diff: RiskDiff) -> Iterator[str]:
    """Yield which other inputs of the run changed: not the controller, nor what is listed above."""
    for line in diff.inputs:
        file = line.removesuffix(" has changed")
        is_told = any(f"({file}:" in told for told in diff.hardware)
        if line == file or not (file == diff.name or is_told):
            yield line


def _is_said(verdict: Verdict | None, reason: str) -> bool:
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


def of_hardware(diff: RiskDiff) -> tuple[str, ...]:
    """Return what changed in the hardware description, with old and new values and sources."""
    return _at_most(diff.hardware)


def of_pace(diff: RiskDiff) -> tuple[str, ...]:
    """Return which rests and ways of the later run take another time."""
    return () if diff.outcome is None else _at_most(diff.outcome.pace)


def _at_most(lines: tuple[str, ...]) -> tuple[str, ...]:
    if len(lines) <= MOST_OF_KIND:
        return lines
    return (*lines[:MOST_OF_KIND], f"and {len(lines) - MOST_OF_KIND} more; --json lists them")


def _other_mission(diff: RiskDiff) -> str:
    """Return what another mission does otherwise, and both figures side by side."""
    figures = [version for version in (diff.before, diff.after) if version is not None]
    outcome = OutcomeChanges() if diff.outcome is None else diff.outcome
    old, new = figures[0].failure_probability, figures[-1].failure_probability
    # What it must not do any more stands before all else.
    said, apart = "must do less", "of different missions"
    if diff.goes_another_way or outcome.does_something_else:
        what = "does something else" if outcome.result else "does less"
        if diff.goes_another_way:
            what, apart = _ANOTHER_WAY, "by different ways"
        said = f"{what}: {first_of(outcome.of_mission)}"
    failure = f"{probability(new)} now and was {probability(old)}, {apart}"
    if diff.is_unchanged:
        about = "" if probability(old) == probability(new) else "about "
        both = "ways" if diff.goes_another_way else "missions"
        failure = f"{about}{probability(new)} for both {both}"
    return f"{diff.name} {said}; mission failure is {failure}"


def _incomparable(diff: RiskDiff, verdicts: RunVerdicts, *, below_verdict: bool) -> str:
    """Return what became of a run that cannot be compared; of the risk it says nothing."""
    old = verdicts.before.kind if verdicts.before else "unknown"
    new = verdicts.after.kind if verdicts.after else "unknown"
    if verdicts.after is None and verdicts.in_after:
        text = (
            f"{diff.name}: the verdict of its run is unknown; `tracerisk refresh {diff.name}` "
            "gives it one"
        )
    elif new in ("faulted", "stuck") or verdicts.does_less:
        reasons = verdicts.after.deciding_reasons if verdicts.after else ()
        # A lock that was edited by hand may keep a verdict without a reason.
        first = next(iter(verdicts.broke or reasons), None)
        was = f"was {old}, " if verdicts.in_before and old != new else ""
        is_known = first is None or (below_verdict and first in reasons[:1])
        text = f"{diff.name} {was}is {new}" + ("" if is_known else f": {first}")
    elif verdicts.before is None:
        text = f"{diff.name} is {new}; the verdict of its run before is unknown"
    else:
        first = next(iter(verdicts.repaired or verdicts.before.open_reasons), None)
        text = f"{diff.name} is {new}, was {old}" + (f"; repaired: {first}" if first else "")
    return f"{text}; the two runs cannot be compared"


def sentence(diff: RiskDiff, *, below_verdict: bool = False, one_in_n: bool = False) -> str:
    """Return what a change did to one controller's risk, without the full stop."""
    missions = "" if diff.after is None or not one_in_n else _missions(diff.after)
    if diff.is_other_mission:
        evidence = f"; {diff.evidence_change}" if diff.evidence_change else ""
        return _other_mission(diff) + evidence + _stale(diff)
    if diff.verdicts is not None and not diff.are_runs_comparable:
        return _incomparable(diff, diff.verdicts, below_verdict=below_verdict)
    if diff.before is None:
        assert diff.after is not None, "one version at least has blocks"
        figure = probability(diff.after.failure_probability)
        if diff.stale:
            return f"{diff.name} {not_assessed(diff)}; its blocks give {figure}; {_remedy(diff)}"
        return (
            f"{diff.name} is assessed for the first time: its mission fails with "
            f"{figure}{missions}{_of_which(diff)}"
        )
    if diff.after is None:
        figure = probability(diff.before.failure_probability)
        return f"{diff.name} has no risk blocks any more; its mission failed with {figure}"
    old, new = diff.before.failure_probability, diff.after.failure_probability
    if diff.evidence_change:
        return _by_evidence(diff, old, new) + _stale(diff)
    if diff.is_unchanged and diff.stale and not _structural(diff):
        return (
            f"{diff.name} {not_assessed(diff)}; its blocks give {probability(new)}; {_remedy(diff)}"
        )
    if diff.is_same_figure:
        text = f"{diff.name}: mission failure is unchanged at {probability(new)}{missions}"
        text += _of_which(diff)
        if diff.outcome is not None and diff.outcome.of_mission:
            text += f", yet the way is another: {(*diff.outcome.lost, *diff.outcome.added)[0]}"
        return text + (f", yet {_structural(diff)}{_stale(diff)}" if _structural(diff) else "")
    verb = "rises" if new > old else "falls"
    text = (
        f"{diff.name}: mission failure {verb} from {probability(old)} to {probability(new)} "
        f"({ratio(old, new)}{missions}){_main_cause(diff)}"
    )
    another_way = f"; it {_ANOTHER_WAY}" if diff.goes_another_way else ""
    return text + _of_which(diff) + another_way + _per_cycle(diff) + _stale(diff)


def _main_cause(diff: RiskDiff) -> str:
    """Return what made most of a change, with its share; where others work against, what each does.

    What works against the change is not what made it.
    """
    parts = [(cause, (cause.contribution or 0.0) / diff.increase) for cause in diff.causes]
    first = next(((cause, share) for cause, share in parts if share > 0.0), None)
    if first is None:
        return ""
    cause, share = first
    text = f", mostly through {cause.summary}{_because(cause)}"
    against = next((cause for cause, share in parts if share <= -NOISE), None)
    if against is not None:
        return (
            f"{text} ({difference(cause.contribution)}), against it {against.summary}"
            f"{_because(against)} ({difference(against.contribution)})"
        )
    if round(100.0 * share) > 100:
        return f"{text} ({difference(cause.contribution)})"
    if len(parts) == 1 and round(100.0 * share) == 100:
        return text
    return f"{text}, {100.0 * share:.0f} % of the {'rise' if diff.increase > 0.0 else 'fall'}"


def _by_evidence(diff: RiskDiff, old: float, new: float) -> str:
    """Return two figures of which only one takes evidence, side by side."""
    assert diff.before is not None
    assert diff.after is not None
    text = (
        f"{diff.name}: {diff.evidence_change}; mission failure is {probability(new)} now and was "
        f"{probability(old)}, not comparable with and without evidence"
    )
    if diff.after.undetected_probability is not None:
        return f"{text}; undetected is {probability(diff.after.undetected_probability)}"
    if diff.before.undetected_probability is not None:
        undetected = probability(diff.before.undetected_probability)
        text += f"; what is undetected is no longer known, it was {undetected}"
    return f"{text}; `tracerisk evidence {diff.name}` tries the failures again"


def _of_which(diff: RiskDiff) -> str:
    """Return what nobody notices of the mission's failure, and how that changed."""
    if diff.undetected is not None:
        old, new = diff.undetected
        if diff.undetected_increase == 0.0:
            return f"; undetected of it is unchanged at {probability(new)}"
        verb = "rises" if new > old else "falls"
        return (
            f"; undetected of it {verb} from {probability(old)} to {probability(new)} "
            f"({ratio(old, new)})"
        )
    after = None if diff.after is None else diff.after.undetected_probability
    if after is not None:
        return f"; undetected of it is {probability(after)}"
    if diff.before is not None and diff.before.undetected_probability is not None:
        return "; it is no longer known what of it is undetected"
    return ""


def _missions(mission: MissionFigures) -> str:
    """Return how many missions a failure is one in, as what follows a figure."""
    often = one_in(mission.failure_probability)
    return f", {often} missions" if often else ""


def _stale(diff: RiskDiff) -> str:
    """Return that the later figure is not of the version that it stands beside."""
    return f"; {diff.name} {not_assessed(diff)}; {_remedy(diff)}" if diff.stale else ""


def not_assessed(diff: RiskDiff) -> str:
    """Return why the blocks of a controller are not those of a run of it as it is."""
    verdicts = diff.verdicts
    is_run = verdicts is not None and verdicts.in_after and verdicts.after is not None
    since = "since its last run " if is_run else ""
    return f"is not assessed as it is now: {since}{some(diff.stale)}"


def _remedy(diff: RiskDiff) -> str:
    """Return the command that makes the blocks those of the later version."""
    if is_c(diff.name):
        return f"`tracerisk annotate {diff.name} --trace TRACE` (or `--log LOG`) writes them again"
    verb = "refresh" if diff.verdicts is not None else "run"
    return f"`tracerisk {verb} {diff.name}` writes them again"


def _because(cause: CauseShare) -> str:
    return f" [{', '.join(cause.kinds)}]" if cause.kinds else ""


_APART = 1.1
"""How far the ratios of the mission and of one cycle may lie apart without a word."""

_LIKELY = 0.05
"""Above it a mission's failure grows less than that of a cycle, because it ends at 1."""


def _per_cycle(diff: RiskDiff) -> str:
    """Return why a mission's failure changes more, or less, than that of its first cycle."""
    before, after = diff.before, diff.after
    if before is None or before.cycle_failure_probability is None or not before.expected_cycles:
        return ""
    if after is None or after.cycle_failure_probability is None or not after.expected_cycles:
        return ""
    figures = before.failure_probability, after.failure_probability
    if max(figures) > _LIKELY:
        return ""
    mission = ratio_of(*figures)
    cycles = before.cycle_failure_probability, after.cycle_failure_probability
    cycle = ratio_of(*cycles)
    if not mission or not cycle or 1 / _APART <= mission / cycle <= _APART:
        return ""
    counts = before.expected_cycles, after.expected_cycles
    if not is_noise(*counts):
        plural = "" if count(counts[1]) == "1" else "s"
        why = f"the mission has {count(counts[1])} cycle{plural}, it had {count(counts[0])}"
    else:
        why = (
            "all redundant units work when it begins, and failures that stay hidden add up in "
            "later ones"
        )
    return f"; the first cycle alone: {ratio(*cycles)}, for {why}"


def mission_figures(diff: RiskDiff) -> dict[str, tuple[float | None, float | None]]:
    """Return the figures of the mission before and after, by name; `None` for what is not known.

    What nobody notices, and what stops safely, only where a version knows it. Blocks that are
    stale and as they were say nothing of the later version.
    """
    kinds = {
        "mission failure": "failure_probability",
        "undetected": "undetected_probability",
        "stopped safely": "stopped_safely_probability",
    }
    figures: dict[str, tuple[float | None, float | None]] = {}
    for name, kind in kinds.items():
        before, after = (
            None if version is None else getattr(version, kind)
            for version in (diff.before, diff.after)
        )
        if name == "mission failure" or before is not None or after is not None:
            figures[name] = before, None if diff.stale and diff.is_unchanged else after
    return figures


def has_cycles(diff: RiskDiff) -> bool:
    """Return whether a version has cycles, whose figure is another one than the mission's."""
    missions = [mission for mission in (diff.before, diff.after) if mission is not None]
    return any(
        mission.cycle_failure_probability is not None
        and probability(mission.failure_probability)
        != probability(mission.cycle_failure_probability)
        for mission in missions
    )


def _structural(diff: RiskDiff) -> str:
    """Return what a reviewer must see although the figure stays."""
    reported = []
    if any("lost_redundancy" in change.marks for change in diff.changes):
        reported.append("redundancy is lost")
    old = [point.component for point in diff.single_points if not point.is_new]
    if old:
        verb = "are single points" if len(old) > 1 else "is a single point"
        reported.append(f"{', '.join(old)} {verb} of failure now")
    return " and ".join(reported)


def probability(value: float) -> str:
    """Return a probability as every table shows it."""
    return f"{value:.3e}"


def small_changes(diff: RiskDiff) -> list[RiskChange]:
    """Return the changes that a reviewer need not see: below the noise of the mission's figure.

    What a user set or edited, and what stands out whatever the figure does, is none of them.
    """
    figures = [
        mission_figures.failure_probability
        for mission_figures in (diff.before, diff.after)
        if mission_figures is not None
    ]
    return [
        change
        for change in diff.changes
        if change.contribution is not None
        and abs(change.contribution) < NOISE * max(figures, default=0.0)
        and not change.marks
        and change.kind != "failures"
        and not {"pin", "edit"} & set(change.causes)
    ]


def has_interaction(diff: RiskDiff) -> bool:
    """Return whether changes do together what none does alone, more than noise."""
    figures = [
        mission_figures.failure_probability
        for mission_figures in (diff.before, diff.after)
        if mission_figures is not None
    ]
    return abs(diff.interaction or 0.0) >= NOISE * max(figures, default=0.0) > 0.0


def small_line(small: Sequence[RiskChange], diff: RiskDiff) -> str:
    """Return the one line that stands for small changes."""
    more = "and " if len(small) < len(diff.changes) else ""
    count = f"{len(small)} more" if more else f"{len(small)} change{'s' * (len(small) > 1)}"
    each = ", each" if len(small) > 1 else ""
    return f"{more}{count}{each} below {100.0 * NOISE:g} % of mission failure; --json lists them"


def difference(value: float | None) -> str:
    """Return how much a figure changes, with its sign."""
    return "only with others" if value is None else f"{value:+.2e}"


def ratio(before: float, after: float) -> str:
    """Return `x2.00`; `unchanged` within the noise, `from 0` where there was none."""
    if is_noise(before, after):
        return "unchanged"
    value = ratio_of(before, after)
    return "from 0" if value is None else f"x{value:.3g}"


def compared(diff: RiskDiff, before: float | None, after: float | None) -> str:
    """Return how two figures of a controller compare, or that they do not: the same everywhere.

    Empty where a version has no figure.
    """
    if diff.stale and before is not None:
        return "not assessed"
    if before is None or after is None:
        return ""
    return ratio(before, after) if diff.is_comparable else "not comparable"


def count(value: float) -> str:
    """Return an expected number of visits or cycles."""
    return f"{value:.4g}"


def causes(change: RiskChange) -> str:
    """Return the causes of a change in words."""
    return ", ".join(_CAUSES[cause] for cause in change.causes)


def marks(change: RiskChange) -> str:
    """Return what stands out of a change in words."""
    return ", ".join(_MARKS[mark] for mark in change.marks)


def places(review: Review, change: RiskChange) -> str:
    """Return where the fields of a change stand, at most three of them."""
    fields = sorted(change.fields, key=lambda field: (field.is_gone, *_in_file(field.location)))
    places = [review.place(field.location, is_gone=field.is_gone) for field in fields]
    return some([place for place in places if place])


def _in_file(place: Location | None) -> tuple[str, int]:
    return ("", 0) if place is None else (place.file, place.line or 0)


def some(names: Sequence[str], most: int = 3) -> str:
    """Return the first of the names, and how many more there are."""
    shown = ", ".join(names[:most])
    return shown if len(names) <= most else f"{shown} and {len(names) - most} more"


def name_of(changed: RiskDiff | FunctionChange) -> str:
    """Return the name of a controller or function, with the one that it had."""
    return changed.name if changed.was is None else f"{changed.name} (was {changed.was})"


def pins(review: Review, diff: RiskDiff) -> list[str]:
    """Return what became of each value that a user set, and where that is."""
    return [
        f"{pin(pin_change)} "
        f"({review.place(pin_change.location, is_gone=pin_change.kind == 'removed')})"
        for pin_change in diff.pins
    ]


def pin(change: PinChange) -> str:
    """Return what became of a value that a user set."""
    match change.kind:
        case "new":
            text = f"new: {change.path} := {change.after}"
        case "removed":
            return f"no longer: {change.path} := {change.before}"
        case "changed":
            text = f"changed: {change.path} := {change.before} -> {change.after}"
        case "drifted":
            text = f"as before: {change.path} := {change.after}, computed {change.computed_before}"
            return f"{text} -> {change.computed_after}{_reason(change)}"
    if change.computed_after is not None:
        text += f" (computed {change.computed_after})"
    return text + _reason(change)


def _reason(change: PinChange) -> str:
    return f"; {change.reason}" if change.reason else "; without a reason"
