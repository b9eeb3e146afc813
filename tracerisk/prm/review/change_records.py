"""What a change of the blocks changed, as data: values, functions, pins, verdicts."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from tracerisk.adder.blocks.values import CALL_SEQUENCE
from tracerisk.common.verdict import GAPS, NEVER_RAN, Acceptance, Reason, Verdict
from tracerisk.errors import Location

ChangeKind = Literal[
    "structure",
    "probability",
    "quantity",
    "redundancy",
    "failures",
    "component_added",
    "component_removed",
    "component_omitted",
    "component_restored",
]
"""What changed: states and their `next`; a figure of a component, or what follows its failures;
whether it counts at all."""

Cause = Literal["pin", "edit", "code", "hardware", "settings", "files", "evidence"]
"""Why a value changed: a user's `:=`; a user's change of a `=` value; the controller's own
sources; the hardware description; settings or the version of tracerisk; other files of the run
(a robot, a scene, parameters); other evidence, or evidence in one version alone."""

Mark = Literal["new_state", "lost_state", "new_next", "lost_redundancy", "single_point_of_failure"]
"""What a reviewer should see of a change, whatever it does to the figure."""


ENTRY = "entry"
"""The key of the function that runs first, which no line of a block states."""


@dataclass(frozen=True, slots=True)
class ChangedField:
    """One thing that differs between the versions: a value of a block, a block, the entry."""

    path: str
    """Dotted: `place.gripper.probability`, `place.next`, `place` for a whole block, `entry`."""
    function: str
    """The function of the block; of the entry, the one that runs first in the later version."""
    component: str | None
    """Name of the component; `None` for the function's own values and for the entry."""
    key: str | None
    """The key of the value in its block, or `ENTRY`; `None` for a whole block or component."""
    before: str | None
    """What to print for the earlier version; `None` where it has no such value."""
    after: str | None
    """What to print for the later version; `None` where it has no such value."""
    location: Location | None
    """The place in the later version; in the earlier one if `is_gone`."""
    is_gone: bool = False
    """Whether only the earlier version has it."""
    causes: tuple[Cause, ...] = ()
    """Why the value changed, in order; empty until known."""

    @property
    def stated(self) -> tuple[tuple[str, str | None], ...]:
        """The values of blocks that make the change: the function and the key of each.

        Two make the entry: the ranks of the function that runs first now, and of the one that did.
        """
        if self.key != ENTRY:
            return ((self.function, self.key),)
        names = dict.fromkeys(name for name in (self.after, self.before) if name is not None)
        return tuple((name, CALL_SEQUENCE.key) for name in names)


@dataclass(frozen=True, slots=True)
class RiskChange:
    """One change of the model, and its effect on the mission's failure probability F."""

    kind: ChangeKind
    """What changed."""
    summary: str
    """The change in words, without cause and figure."""
    component: str | None
    """Name of the component; `None` for a change of the chain."""
    functions: tuple[str, ...]
    """Functions in which it was made."""
    fields: tuple[ChangedField, ...]
    """Values that differ, at least one."""
    marks: tuple[Mark, ...]
    """What a reviewer should see of it, whatever its contribution."""
    contribution: float | None = None
    """F(before with only this change) - F(before); `None` where that model has no solution."""
    undetected: float | None = None
    """The same of the undetected failure; `None` where the earlier version does not know it."""

    @property
    def causes(self) -> tuple[Cause, ...]:
        """The causes of its fields, each once, sorted."""
        return tuple(sorted({cause for field in self.fields for cause in field.causes}))


CauseKind = Literal["code", "hardware data", "set by hand", "edited by hand", "run", "evidence"]
"""The kind of cause named in the summary sentence; "run" stands for the settings and other files of
the run."""

KIND_OF_CAUSE: Mapping[Cause, CauseKind] = {
    "pin": "set by hand",
    "edit": "edited by hand",
    "code": "code",
    "hardware": "hardware data",
    "settings": "run",
    "files": "run",
    "evidence": "evidence",
}


@dataclass(frozen=True, slots=True)
class CauseShare:
    """What all changes of one component by one kind of cause do together, over the functions."""

    component: str | None
    """`None` for a change of the chain."""
    kinds: tuple[CauseKind, ...]
    """Several where the versions differ in several things that may have changed a value."""
    functions: tuple[str, ...]
    """Where the changes are, sorted."""
    summary: str
    """What it is in words, without cause and figure."""
    contribution: float | None
    """F(before with only these changes) - F(before); `None` where they alone make no model."""


@dataclass(frozen=True, slots=True)
class FunctionFigures:
    """The figures of a function in one version."""

    top_event: float
    """Probability that one visit fails."""
    expected_visits: float
    """Mean number of visits in a mission."""


@dataclass(frozen=True, slots=True)
class FunctionChange:
    """A function in both versions."""

    name: str
    """Qualified name, in the later version where that has the function."""
    was: str | None
    """Earlier name of a renamed function; `None` where it was not renamed."""
    before: FunctionFigures | None
    """Figures of the earlier version; `None` where it lacks the function."""
    after: FunctionFigures | None
    """Figures of the later version; `None` where it lacks the function."""

    @property
    def status(self) -> Literal["added", "removed", "renamed", "changed", "unchanged"]:
        """What became of it; figures within the noise are unchanged."""
        if self.before is None:
            return "added"
        if self.after is None:
            return "removed"
        if self.was is not None:
            return "renamed"
        same = is_noise(self.before.top_event, self.after.top_event) and is_noise(
            self.before.expected_visits, self.after.expected_visits
        )
        return "unchanged" if same else "changed"


@dataclass(frozen=True, slots=True)
class PinChange:
    """What became of a value, a component or a block that a user set."""

    kind: Literal["new", "removed", "changed", "drifted"]
    """Kind of change; "drifted" where the user's value stands and the computed value changed."""
    path: str
    """Dotted path of the value, such as `place.gripper.probability`."""
    before: str | None
    """Text of the earlier pin; `None` where there was none."""
    after: str | None
    """Text of the later pin; `None` where there is none."""
    computed_before: str | None
    """Computed value beside the earlier pin; `None` where none is stated."""
    computed_after: str | None
    """Computed value beside the later pin; `None` where none is stated."""
    reason: str | None
    """The user's reason, the later one if both have one; `None` where none is given."""
    location: Location | None
    """Line of the pin, in the earlier version where the later has none."""


@dataclass(frozen=True, slots=True)
class SinglePoint:
    """A component one unit of which newly fails the mission alone."""

    component: str
    """Name of the component."""
    functions: tuple[str, ...]
    """Functions in which it does, in the later version."""
    is_new: bool
    """Whether the earlier version does not use the component at all."""


@dataclass(frozen=True, slots=True)
class RunVerdicts:
    """The verdicts of the runs behind two versions."""

    before: Verdict | None
    """Verdict of the earlier run; `None` where unknown."""
    after: Verdict | None
    """Verdict of the later run; `None` where unknown."""
    in_before: bool = True
    """Whether the earlier version has blocks."""
    in_after: bool = True
    """Whether the later version has blocks."""
    renamed: Mapping[str, str] = field(default_factory=dict)
    """The later name of functions that were renamed, by their earlier one."""

    @property
    def is_comparable(self) -> bool:
        """Whether the figures of the two runs say anything of each other."""
        return _is_whole(self.before, self.in_before) and _is_whole(self.after, self.in_after)

    @property
    def broke(self) -> tuple[Reason, ...]:
        """What went wrong in the later run and not in the earlier one.

        What an earlier run that was cut short left out may have been left out before.
        """
        reasons = _only_in(self.after, self.before, {new: old for old, new in self.renamed.items()})
        if _is_whole(self.before, self.in_before):
            return reasons
        return tuple(reason for reason in reasons if reason.code not in GAPS)

    @property
    def does_less(self) -> bool:
        """Whether the later run lacks what the earlier had, apart from functions that never ran."""
        return self.in_before and any(reason.code not in GAPS for reason in self.broke)

    @property
    def repaired(self) -> tuple[Reason, ...]:
        """What went wrong in the earlier run and does not in the later one.

        Nothing where only the later run was cut short: it may not have come so far.
        """
        is_cut_short = not _is_whole(self.after, self.in_after)
        if is_cut_short and _is_whole(self.before, self.in_before):
            return ()
        # What the later version accepts still happens.
        after = () if self.after is None else self.after.reasons
        accepted = {_key(reason, {}) for reason in after if reason.accepted}
        return tuple(
            reason
            for reason in _only_in(self.before, self.after, self.renamed)
            if _key(reason, self.renamed) not in accepted
        )

    @property
    def new_acceptances(self) -> tuple[Acceptance, ...]:
        """What the later version accepts and the earlier one did not."""
        if self.after is None:
            return ()
        known = {acceptance.key for acceptance in self.before.acceptances} if self.before else set()
        return tuple(
            acceptance for acceptance in self.after.acceptances if acceptance.key not in known
        )


def is_news(verdicts: RunVerdicts) -> bool:
    """Return whether a run went wrong, or lost its verdict or got its first."""
    is_unknown = verdicts.before is None and verdicts.after is None
    return not verdicts.is_comparable and not is_unknown


def _is_whole(verdict: Verdict | None, is_there: bool) -> bool:
    return not is_there or (verdict is not None and not verdict.is_bad)


def _only_in(
    verdict: Verdict | None, other: Verdict | None, renamed: Mapping[str, str]
) -> tuple[Reason, ...]:
    """Return the reasons that only the first verdict has, functions that never ran left aside.

    `renamed` gives the other verdict's name of a function by its own. Calls that were left out are
    compared only by number, because their object is the call's text, which a renaming changes. A
    reason about the same object in another function counts as moved, not as new.
    """
    left = Counter(_key(reason, {}) for reason in _open(other))
    alone = []
    for reason in _open(verdict):
        key = _key(reason, renamed)
        if reason.code == NEVER_RAN or left[key] > 0:
            left[key] -= 1
        else:
            alone.append(reason)
    moved = Counter(_thing(key) for key in left.elements())
    reasons = []
    for reason in alone:
        thing = _thing(_key(reason, renamed))
        if thing[1] and moved[thing] > 0:
            moved[thing] -= 1
        else:
            reasons.append(reason)
    return tuple(reasons)


def _thing(key: tuple[str, str, str]) -> tuple[str, str]:
    code, _, thing = key
    return code, thing


def _open(verdict: Verdict | None) -> tuple[Reason, ...]:
    return () if verdict is None else verdict.open_reasons


def _key(reason: Reason, renamed: Mapping[str, str]) -> tuple[str, str, str]:
    if reason.code in GAPS:
        return reason.code, "", ""
    return reason.code, renamed.get(reason.function, reason.function), reason.object


NOISE = 0.01
"""The relative change of a figure that counts as no change."""


def is_noise(before: float, after: float) -> bool:
    """Return whether two figures differ by no more than the noise."""
    return abs(after - before) <= NOISE * abs(before)
