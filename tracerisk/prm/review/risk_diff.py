"""The difference of two risk models: what a change of the blocks does to the risk."""

from __future__ import annotations

import posixpath
from dataclasses import dataclass

from tracerisk.adder.merge.owned import MovedUse
from tracerisk.common.outcome.changes import OutcomeChanges
from tracerisk.errors import Location
from tracerisk.instrument.source.answers.changed_checks import ChangedCheck
from tracerisk.prm.hybrid.assessment import FIGURE_STATEMENT, MissionFigures
from tracerisk.prm.review.change_records import (
    NOISE,
    CauseShare,
    FunctionChange,
    PinChange,
    RiskChange,
    RunVerdicts,
    SinglePoint,
    is_news,
    is_noise,
)


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
    """Number of values that changed by less than `noise` and count as unchanged."""
    noise: float = NOISE
    """The relative change up to which a value counts as unchanged, greater where a run was live."""
    stated: MissionFigures | None = None
    """Figures of the later version's blocks as they stand, where `after` has earlier values of
    which its live run is a repetition; `None` elsewhere."""
    inputs: tuple[str, ...] = ()
    """Inputs of the runs behind the blocks that differ, one sentence each."""
    hardware: tuple[str, ...] = ()
    """What differs in the hardware description, a line a value, with both values and sources."""
    hardware_file: str = ""
    """The description of the later version, where the two differ; empty for none."""
    of_run: tuple[str, ...] = ()
    """What only the later run showed, such as unexpected contacts and motions without risk
    data; one sentence each."""
    of_comparison: tuple[str, ...] = ()
    """What keeps the outcomes of the two runs from being compared, or by what they are; one
    sentence each."""
    of_evidence: tuple[str, ...] = ()
    """What failures do otherwise, by the evidence of both versions; one sentence each."""
    verdicts: RunVerdicts | None = None
    """Verdicts of both runs; `None` where neither version has a run in its lock."""
    causes: tuple[CauseShare, ...] = ()
    """The changes by component and kind of cause, the greatest contribution first."""
    stale: tuple[str, ...] = ()
    """What has changed since the run behind the later version's blocks, or that no run of it is
    known; one sentence each."""
    refused: str = ""
    """The verdict of the run of the later version as it is, whose blocks were not written because
    it went wrong; empty for none."""
    outcome: OutcomeChanges | None = None
    """How the later run's outcome differs from the earlier run's; `None` if either is unknown."""
    evidence_change: str = ""
    """That the values of only one version take evidence, and why; empty where both or neither do.
    """
    asked_less: tuple[str, ...] = ()
    """What `success` of the scenario asked and does not ask any more, one sentence each."""
    not_asked: tuple[str, ...] = ()
    """Objects that the mission newly moves and of which `success` asks nothing, by name."""
    checks: tuple[ChangedCheck, ...] = ()
    """Answers of services, actions and drivers that the controller no longer looks at, then those
    that it newly does."""
    asked_otherwise: tuple[str, ...] = ()
    """What `success` of the scenario asks in place of what it asked, one sentence each."""
    asked_newly: tuple[str, ...] = ()
    """What `success` of the scenario newly asks, one sentence each."""
    without_step: tuple[str, ...] = ()
    """Functions with a block of the earlier version that are still there, and have none now."""
    moved: tuple[MovedUse, ...] = ()
    """Values set by hand that are newly not for what their functions do, or not for it alone."""
    success_place: Location | None = None
    """Where the later version declares `success`; `None` unless the scenarios differ."""

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
        if self._falls and (self.asked_less or self.asked_otherwise):
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
    def lost_checks(self) -> tuple[ChangedCheck, ...]:
        """The answers that the controller no longer looks at."""
        return tuple(check for check in self.checks if check.is_lost)

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
        if self.moved or self.of_run or self.of_comparison or self.of_evidence:
            return True
        if self.asked_less or self.asked_otherwise or self.asked_newly or self.checks:
            return True
        runs = self.verdicts
        if runs is not None and (runs.new_acceptances or runs.does_less or is_news(runs)):
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
    moved_on: tuple[str, ...] = ()
    """What the branch that the change goes to has of its controllers by now, where the earlier
    version is an older one of it; a sentence a controller."""
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
        is_told = any(controller.is_worth_telling(threshold) for controller in self.controllers)
        return is_told or bool(self.moved_on)

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


def ratio_of(before: float, after: float) -> float | None:
    """Return `after / before`: 1 for two zeros, `None` where only the first is zero."""
    if before > 0.0:
        return after / before
    return 1.0 if after == 0.0 else None


def _figure(mission: MissionFigures | None) -> float:
    return 0.0 if mission is None else mission.failure_probability
