"""What a change of the blocks does to the risk: the difference of two models, as data."""

from __future__ import annotations

import posixpath
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from tracerisk.adder.blocks.values import CALL_SEQUENCE
from tracerisk.common.outcome.changes import OutcomeChanges
from tracerisk.common.verdict import GAPS, NEVER_RAN, Acceptance, Reason, Verdict
from tracerisk.errors import Location
from tracerisk.prm.hybrid.assessment import FIGURE_STATEMENT, MissionFigures

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

    @property
    def causes(self) -> tuple[Cause, ...]:
        """The causes of its fields, each once, sorted."""
        return tuple(sorted({cause for field in self.fields for cause in field.causes}))


CauseKind = Literal["code", "hardware data", "pin", "edited by hand", "run", "evidence"]
"""The kind of cause named in the summary sentence; "run" stands for the settings and other files of
the run."""

KIND_OF_CAUSE: Mapping[Cause, CauseKind] = {
    "pin": "pin",
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
        """What went wrong in the later run and not in the earlier one."""
        return _only_in(self.after, self.before, {new: old for old, new in self.renamed.items()})

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
        return _only_in(self.before, self.after, self.renamed)

    @property
    def new_acceptances(self) -> tuple[Acceptance, ...]:
        """What the later version accepts and the earlier one did not."""
        if self.after is None:
            return ()
        known = {acceptance.key for acceptance in self.before.acceptances} if self.before else set()
        return tuple(
            acceptance for acceptance in self.after.acceptances if acceptance.key not in known
        )


def _is_news(verdicts: RunVerdicts) -> bool:
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


@dataclass(frozen=True, slots=True)
class RiskDiff:
    """The difference in risk between two versions of one controller."""

    name: str
    """Path of the controller, in the later version where that has it."""
    was: str | None
    """Earlier path of a moved controller; `None` where it was not moved."""
    before: MissionFigures | None
    """Figures of the earlier version; `None` where it has no blocks."""
    after: MissionFigures | None
    """Figures of the later version; `None` where it has no blocks."""
    changes: tuple[RiskChange, ...]
    """Changes of the model, the greatest contribution first."""
    interaction: float | None
    """Change of the mission's figure beyond the sum of the contributions, noise included;
    `None` where a version has no blocks."""
    functions: tuple[FunctionChange, ...]
    """Functions of either version, the later version's first."""
    pins: tuple[PinChange, ...]
    """Changes of values that users set, by path."""
    single_points: tuple[SinglePoint, ...]
    """Components that newly fail the mission alone, by name."""
    within_noise: int
    """Number of values that changed by less than 1 % and count as unchanged."""
    inputs: tuple[str, ...] = ()
    """Inputs of the runs behind the blocks that differ, one sentence each."""
    hardware: tuple[str, ...] = ()
    """What differs in the hardware description, a line a value, with both values and sources."""
    hardware_file: str = ""
    """The description of the later version, where the two differ; empty for none."""
    of_run: tuple[str, ...] = ()
    """What only the later run showed, such as unexpected contacts and motions without risk
    data; one sentence each."""
    of_evidence: tuple[str, ...] = ()
    """What failures do otherwise, by the evidence of both versions; one sentence each."""
    verdicts: RunVerdicts | None = None
    """Verdicts of both runs; `None` where neither version has a run in its lock."""
    causes: tuple[CauseShare, ...] = ()
    """The changes by component and kind of cause, the greatest contribution first."""
    stale: tuple[str, ...] = ()
    """What has changed since the run behind the later version's blocks, or that no run of it is
    known; one sentence each."""
    outcome: OutcomeChanges | None = None
    """How the later run's outcome differs from the earlier run's; `None` if either is unknown."""
    evidence_change: str = ""
    """That the values of only one version take evidence, and why; empty where both or neither do.
    """
    asked_less: tuple[str, ...] = ()
    """What `success` of the scenario asked and does not ask any more, one sentence each."""
    not_asked: tuple[str, ...] = ()
    """Objects that the mission newly moves and of which `success` asks nothing, by name."""
    uncredited: tuple[str, ...] = ()
    """Of which calls the result is newly or no longer used, where no version has evidence."""
    asked_newly: tuple[str, ...] = ()
    """What `success` of the scenario newly asks, one sentence each."""

    @property
    def is_comparable(self) -> bool:
        """Whether the figures of the two versions can be compared.

        A figure without evidence counts every failure, one with evidence only those that end the
        mission.
        """
        return self.are_runs_comparable and not self.evidence_change

    @property
    def are_runs_comparable(self) -> bool:
        """Whether the runs behind the two versions can be compared; models alone always can.

        A run that broke does less, so that a figure which falls with it says nothing.
        """
        if self.verdicts is None:
            return self.is_same_mission
        falls = self._falls and self.verdicts.does_less
        return self.verdicts.is_comparable and not falls and self.is_same_mission

    @property
    def is_same_mission(self) -> bool:
        """Whether the later figure may be said to rise or fall, by what the runs brought about.

        A run with a different result is a different mission. A run that left out part of the way
        does less, so it must not count as safer; nor must one of which `success` asks less.
        """
        if self._falls and self.asked_less:
            return False
        if self.outcome is None:
            return True
        return not self.outcome.result and not (self._falls and self.outcome.lost)

    @property
    def is_other_mission(self) -> bool:
        """Whether both runs went well, but are of different missions.

        Then both figures are true of their missions, and so are those of each function.
        """
        verdicts = self.verdicts
        went_well = verdicts is None or (verdicts.is_comparable and not verdicts.does_less)
        return went_well and not self.is_same_mission

    @property
    def shown_functions(self) -> tuple[FunctionChange, ...]:
        """The functions that a reader should see: those that differ, of runs that went well."""
        if not self.is_comparable and not self.is_other_mission:
            return ()
        return tuple(function for function in self.functions if function.status != "unchanged")

    @property
    def goes_another_way(self) -> bool:
        """Whether the result is the same, and only rests on the way are elsewhere."""
        return self.outcome is not None and self.outcome.is_other_way and not self.outcome.result

    @property
    def _falls(self) -> bool:
        return (self.increase < 0.0 and not self.is_same_figure) or self.undetected_increase < 0.0

    @property
    def undetected(self) -> tuple[float, float] | None:
        """The undetected failure before and after; `None` unless both versions know it."""
        if self.before is None or self.after is None:
            return None
        before, after = self.before.undetected_probability, self.after.undetected_probability
        return None if before is None or after is None else (before, after)

    @property
    def undetected_increase(self) -> float:
        """How much the undetected failure rose, noise left aside; 0 where it is not known."""
        if self.undetected is None or is_noise(*self.undetected):
            return 0.0
        return self.undetected[1] - self.undetected[0]

    @property
    def is_credited(self) -> bool:
        """Whether the undetected failure falls by at least as much as the mission's rises."""
        return self.undetected_increase < 0.0 and self.increase <= -self.undetected_increase

    @property
    def increase(self) -> float:
        """How much the mission's figure rose; a version without blocks counts as none."""
        return _figure(self.after) - _figure(self.before)

    @property
    def ratio(self) -> float | None:
        """The later figure over the earlier; `None` where there is none to compare with."""
        if self.before is None or self.after is None:
            return None
        return ratio_of(self.before.failure_probability, self.after.failure_probability)

    @property
    def is_unchanged(self) -> bool:
        """Whether both figures of the mission are the same, noise left aside."""
        if not self.is_same_figure or self.before is None or self.after is None:
            return False
        unknown = [mission.undetected_probability is None for mission in (self.before, self.after)]
        return unknown[0] == unknown[1] and self.undetected_increase == 0.0

    @property
    def is_same_figure(self) -> bool:
        """Whether the mission's failure probability is the same, noise left aside."""
        if self.before is None or self.after is None:
            return False
        return is_noise(self.before.failure_probability, self.after.failure_probability)

    def is_worth_telling(self, threshold: float) -> bool:
        """Return what `Review.is_worth_telling` says, for one controller."""
        if self.before is None or self.after is None or self.pins:
            return True
        if self.of_run or self.of_evidence:
            return True
        if self.asked_less or self.asked_newly or self.uncredited:
            return True
        runs = self.verdicts
        if runs is not None and (runs.new_acceptances or runs.does_less or _is_news(runs)):
            return True
        is_apart = bool(self.stale or self.evidence_change)
        if is_apart or (self.outcome is not None and self.outcome.of_mission):
            return True
        marks = {mark for change in self.changes for mark in change.marks}
        if marks & {"lost_redundancy", "single_point_of_failure"}:
            return True
        before, after = self.before.failure_probability, self.after.failure_probability
        known = self.undetected
        if known is not None and abs(self.undetected_increase) > threshold * known[0]:
            return True
        return abs(after - before) > threshold * before


@dataclass(frozen=True, slots=True)
class Review:
    """What changed in risk between two versions of a repository."""

    before: str
    """The earlier version as the user named it."""
    after: str
    """The later version as the user named it."""
    controllers: tuple[RiskDiff, ...]
    """Differences by controller, the greatest change first."""
    notes: tuple[str, ...] = ()
    """Remarks on the comparison, one sentence each."""
    prefixes: tuple[str, str] = ("", "")
    """Text before file names of the earlier and the later version, as git writes it (`HEAD:`)."""
    commits: tuple[str | None, str | None] = (None, None)
    """The commits of the earlier and the later version; `None` for the working tree."""
    folder: str = ""
    """The path from the repository's top to the folder from which files are named; empty for the
    top."""
    statement: str = FIGURE_STATEMENT
    """What the figures are and are not, for every output."""
    others: tuple[RiskDiff, ...] = ()
    """Controllers that the change leaves alone, by name; empty unless they were asked for."""

    @property
    def renamed(self) -> dict[str, str]:
        """The later name of each function that was renamed, by its earlier one."""
        return {
            function.was: function.name
            for controller in self.controllers
            for function in controller.functions
            if function.was is not None
        }

    def is_worth_telling(self, threshold: float) -> bool:
        """Return whether a reviewer should hear of it: a figure changed by more, or a mark.

        `threshold` is a relative change of a mission's failure probability, up or down. Whatever
        the figure does, controllers that come or go, redundancy that is lost, new single points
        of failure, values set by hand and what a run newly showed are reported.
        """
        return any(controller.is_worth_telling(threshold) for controller in self.controllers)

    def path(self, location: Location) -> str | None:
        """Return the path of a place's file from the repository's top; `None` outside it."""
        path = posixpath.normpath(posixpath.join(self.folder, location.file))
        return None if path.startswith(("../", "/")) else path

    def place(self, location: Location | None, *, is_gone: bool = False) -> str:
        """Return a place as the user finds it: `place.py:12`, `HEAD:place.py:12` if it is gone."""
        if location is None:
            return ""
        return f"{self.prefixes[0 if is_gone else 1]}{location}"


WORKING_TREE = "working tree"
"""What a version is called that is no commit."""

NOISE = 0.01
"""The relative change of a figure that counts as no change."""


def is_noise(before: float, after: float) -> bool:
    """Return whether two figures differ by no more than the noise."""
    return abs(after - before) <= NOISE * abs(before)


def ratio_of(before: float, after: float) -> float | None:
    """Return `after / before`: 1 for two zeros, `None` where only the first is zero."""
    if before > 0.0:
        return after / before
    return 1.0 if after == 0.0 else None


def _figure(mission: MissionFigures | None) -> float:
    return 0.0 if mission is None else mission.failure_probability
