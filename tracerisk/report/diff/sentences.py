"""The words that describe a change of risk, the same in every format."""

from __future__ import annotations

from functools import partial

from tracerisk.common.outcome.changes import OutcomeChanges
from tracerisk.common.text.one_in import one_in
from tracerisk.instrument.source.language import is_c
from tracerisk.prm.hybrid.assessment import MissionFigures
from tracerisk.prm.review.change_records import (
    NOISE,
    CauseShare,
    RunVerdicts,
    is_noise,
)
from tracerisk.prm.review.risk_diff import Review, RiskDiff, ratio_of
from tracerisk.report.diff.titled_lists import warnings
from tracerisk.report.diff.wording import (
    count,
    difference,
    first_of,
    probability,
    ratio,
    some,
)

_DIFFERENT = "of different missions"
_ANOTHER_WAY = "goes another way, same result"


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


def whole_headline(review: Review, *, below_verdicts: bool = False) -> str:
    """Return the headline, behind which controllers are asked less; see `headline`."""
    said = headline(review, below_verdicts=below_verdicts)
    return " ".join((*(f"{line}." for line in warnings(review)), said))


def _other_mission(diff: RiskDiff) -> str:
    """Return what another mission does otherwise, and both figures side by side."""
    figures = [version for version in (diff.before, diff.after) if version is not None]
    outcome = OutcomeChanges() if diff.outcome is None else diff.outcome
    old, new = figures[0].failure_probability, figures[-1].failure_probability
    # What it is not asked any more stands before all else.
    said, apart = "is asked less" if diff.asked_less else "is asked something else", _DIFFERENT
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
        text = f"{diff.name}: the verdict of its run is unknown; {runs_again(diff)} gives it one"
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
            text = f"{diff.name} {not_assessed(diff, below_verdict=below_verdict)}; "
            return text + _old_figure(diff, diff.after.failure_probability) + _remedy(diff)
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
        why = not_assessed(diff, below_verdict=below_verdict)
        return f"{diff.name} {why}; {_old_figure(diff, new)}{_remedy(diff)}"
    if diff.is_same_figure:
        text = f"{diff.name}: mission failure is unchanged at {probability(new)}{missions}"
        text += _of_which(diff)
        if diff.outcome is not None and diff.outcome.of_mission:
            text += f", yet the way is another: {(*diff.outcome.lost, *diff.outcome.added)[0]}"
        text += _same_mission(diff)
        return text + (f", yet {_structural(diff)}{_stale(diff)}" if _structural(diff) else "")
    verb = "rises" if new > old else "falls"
    text = (
        f"mission failure {verb} from {probability(old)} to {probability(new)} "
        f"({ratio(old, new)}{missions}){_main_cause(diff)}"
    )
    if new > old and diff.is_credited:
        # What the change is for comes first; what it costs comes second.
        text = f"{_of_undetected(diff, 'undetected failure')}; {text}"
    else:
        text += _of_which(diff)
    another_way = f"; it {_ANOTHER_WAY}" if diff.goes_another_way else _same_mission(diff)
    return f"{diff.name}: {text}{another_way}{_per_cycle(diff)}{_stale(diff)}"


def _same_mission(diff: RiskDiff) -> str:
    """Return that a mission brings about the same, and by which way; nothing if that is unknown."""
    outcome = diff.outcome
    if outcome is None or outcome.result or outcome.lost:
        return ""
    if _is_of_another_number(diff):
        return (
            "; the run brings about the same, but by `next` set by hand one of the two figures is "
            "of another mission than its run"
        )
    way = "by a longer way" if outcome.added else "by the same way"
    return f"; the mission brings about the same, {way}"


def _is_of_another_number(diff: RiskDiff) -> bool:
    """Return whether a user has changed how often a mission visits a function."""
    if not any(pin.path.endswith(".next") and pin.kind != "drifted" for pin in diff.pins):
        return False
    visits = [(one.before, one.after) for one in diff.functions]
    return any(
        before is not None
        and after is not None
        and not is_noise(before.expected_visits, after.expected_visits)
        for before, after in visits
    )


_ALSO = 0.2
"""The share of a change from which on a cause of another kind is named beside the main one."""


def _main_cause(diff: RiskDiff) -> str:
    """Return what made most of a change, with its share; where others work against, what each does.

    What works against the change is not what made it. Beside code, new data are named, and the
    reverse, where they made much of it; where no cause made more than half, so is the next one.
    """
    parts = [(cause, (cause.contribution or 0.0) / diff.increase) for cause in diff.causes]
    first = next(((cause, share) for cause, share in parts if share > 0.0), None)
    if first is None:
        return ""
    cause, share = first
    moved = next((one for one in diff.moved if one.is_of(cause.component, cause.functions)), None)
    if moved is not None:
        return f", mostly because {moved.message}"
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
    text += f", {100.0 * share:.0f} % of the {'rise' if diff.increase > 0.0 else 'fall'}"
    # Half of a change is not most of it, and what made the other half is named too.
    is_half = round(100.0 * share) <= 50
    for other, part in parts:
        if other is not cause and (is_half or other.kinds != cause.kinds) and part >= _ALSO:
            return f"{text}, and {other.summary}{_because(other)}, {100.0 * part:.0f} %"
    return text


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
        return f"; {_of_undetected(diff, 'undetected of it')}"
    after = None if diff.after is None else diff.after.undetected_probability
    if after is not None:
        return f"; undetected of it is {probability(after)}"
    if diff.before is not None and diff.before.undetected_probability is not None:
        return "; it is no longer known what of it is undetected"
    return ""


def _of_undetected(diff: RiskDiff, what: str) -> str:
    """Return how the undetected failure changed, which both versions know."""
    assert diff.undetected is not None, "both know it"
    old, new = diff.undetected
    if diff.undetected_increase == 0.0:
        return f"{what} is unchanged at {probability(new)}"
    verb = "rises" if new > old else "falls"
    return f"{what} {verb} from {probability(old)} to {probability(new)} ({ratio(old, new)})"


def _missions(mission: MissionFigures) -> str:
    """Return how many missions a failure is one in, as what follows a figure."""
    often = one_in(mission.failure_probability)
    return f", {often} missions" if often else ""


def _stale(diff: RiskDiff) -> str:
    """Return that the later figure is not of the version that it stands beside."""
    return f"; {diff.name} {not_assessed(diff)}; {_remedy(diff)}" if diff.stale else ""


def not_assessed(diff: RiskDiff, *, below_verdict: bool = False) -> str:
    """Return why the blocks of a controller are not those of a run of it as it is.

    Where it stands `below_verdict`, the reason of a run that went wrong is not said again.
    """
    if diff.refused:
        # How much of it ran stands in the line of the verdict.
        why, _, _ = diff.refused.rpartition("; ")
        why = why.partition(": ")[0] if below_verdict else why
        return f"is not assessed as it is now: its last run is {why}, and wrote no blocks"
    verdicts = diff.verdicts
    is_run = verdicts is not None and verdicts.in_after and verdicts.after is not None
    since = "since its last run " if is_run else ""
    return f"is not assessed as it is now: {since}{some(diff.stale)}"


def _old_figure(diff: RiskDiff, figure: float) -> str:
    """Return what the blocks give that are not those of a run; nothing if that run went wrong."""
    return "" if diff.refused else f"its blocks give {probability(figure)}; "


def runs_again(diff: RiskDiff) -> str:
    """Return the command that gives the later version a run with a verdict, which no log has."""
    if is_c(diff.name):
        return f"`tracerisk annotate {diff.name} --trace TRACE` of a live run"
    return f"`tracerisk refresh {diff.name}`"


def _remedy(diff: RiskDiff) -> str:
    """Return the command that makes the blocks those of the later version."""
    if is_c(diff.name):
        return f"`tracerisk annotate {diff.name} --trace TRACE` (or `--log LOG`) writes them again"
    if diff.refused:
        return f"mend it, then `tracerisk refresh {diff.name}`"
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
