"""How figures, names and single changes are written, the same in every format."""

from __future__ import annotations

from collections.abc import Sequence

from tracerisk.errors import Location
from tracerisk.prm.review.change_records import (
    KIND_OF_CAUSE,
    NOISE,
    CauseShare,
    FunctionChange,
    Mark,
    PinChange,
    RiskChange,
    is_noise,
)
from tracerisk.prm.review.risk_diff import Review, RiskDiff, ratio_of

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


def noise(diff: RiskDiff) -> str:
    """Return how little the values changed that count as unchanged."""
    if diff.noise > NOISE:
        return f"no more than live runs differ by themselves, {100.0 * diff.noise:.2g} % at most"
    return f"less than {100.0 * NOISE:g} %"


def first_of(lines: Sequence[str]) -> str:
    """Return the first of some sentences, and how many more there are."""
    return lines[0] + (f" (and {len(lines) - 1} more)" if len(lines) > 1 else "")


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
    """Return whether a version has cycles, whose figure is another one than the mission's.

    Of stale blocks that are as they were, no figure of the later version is known.
    """
    if diff.stale and diff.is_unchanged:
        return False
    missions = [mission for mission in (diff.before, diff.after) if mission is not None]
    return any(
        mission.cycle_failure_probability is not None
        and probability(mission.failure_probability)
        != probability(mission.cycle_failure_probability)
        for mission in missions
    )


def probability(value: float) -> str:
    """Return a probability as every table shows it."""
    return f"{value:.3e}"


def small_changes(diff: RiskDiff) -> list[RiskChange]:
    """Return the changes that a reviewer need not see: below the noise of the mission's figure.

    What a user set or edited, what stands out whatever the figure does, and what the sentence
    names as the cause, is none of them.
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
        and not (diff.causes and not diff.is_same_figure and _is_of(change, diff.causes[0]))
    ]


def _is_of(change: RiskChange, cause: CauseShare) -> bool:
    """Return whether a change is one of those of a cause, as the sentence names it."""
    kinds = {KIND_OF_CAUSE[one] for one in change.causes}
    is_whole = change.component is not None or change.summary == cause.summary
    return change.component == cause.component and kinds == set(cause.kinds) and is_whole


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


def alone(change: RiskChange) -> str:
    """Return what only a change does to mission failure, or else to what is undetected of it."""
    if change.kind == "failures" and change.contribution == 0.0:
        return of_undetected(change)
    return difference(change.contribution)


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


def of_undetected(change: RiskChange) -> str:
    """Return what only a change of what follows failures does to the undetected failure.

    Empty for another change, and where that is not known.
    """
    if change.kind != "failures" or change.undetected is None:
        return ""
    return f"undetected {difference(change.undetected)}"


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


def status_of(diff: RiskDiff, function: FunctionChange) -> str:
    """Return what became of a function, in words."""
    is_there = function.status == "removed" and function.name in diff.without_step
    return "no step of its own any more" if is_there else function.status


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
