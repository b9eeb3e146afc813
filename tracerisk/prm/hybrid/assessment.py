"""What solving a model gives: figures per function, for the mission and per component."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, Literal

from tracerisk.prm.display import Displayed

if TYPE_CHECKING:
    from tracerisk.prm.numbers.table import Table

FIGURE_STATEMENT = (
    "Probability of mission failure by hardware; not harm, software faults or people."
)
"""What every figure of tracerisk is: the one line that each output carries."""

RENEWED_REDUNDANCY = (
    "redundant units with detection at each visit are assumed to work at its start: a first "
    "failure that "
    "stays hidden is not counted, which understates the failure probability of a pair by about "
    "the number of visits and makes its share depend on how the code is divided into functions"
)
RENEWED_SPARES = (
    "groups with spares and detection at each visit are assumed complete at its start: a spare "
    "used up in an earlier visit counts as available, which understates their share and makes it "
    "depend on how the code is divided into functions"
)
HIDDEN_FAILURES = (
    "failed units of a redundant group stay failed and undetected until the mission ends; every "
    "mission starts with all redundant units working"
)
GEOMETRIC_CYCLES = (
    "the number of cycles is geometric: it varies from mission to mission around its mean"
)
FIXED_CYCLES = (
    "`next` holds the counts of one mission, so its numbers of cycles are fixed; visits, shares "
    "and importances come from the chain, in which the numbers of cycles vary around these "
    "(geometric cycles)"
)

Reading = Literal["geometric cycles", "fixed cycles"]
"""How a mission's failure probability is read, where its functions repeat."""
GEOMETRIC: Final = "geometric cycles"
FIXED: Final = "fixed cycles"


def bounded(most: int, least: float, failure: float) -> str:
    """Return the assumption of a mission in which more failed units than `most` are bounded."""
    above = (failure - least) / least if least > 0.0 else math.inf
    return (
        f"hidden failures of more than {most} units at once are bounded from above: the mission's "
        f"failure probability is between {least:.6e} and {failure:.6e}, too high by at most "
        f"{100.0 * above:.2g} %; importances count such failures as mission failures"
    )


def grouped(groups: int, least: float, failure: float) -> str:
    """Return the assumption of a mission whose redundant groups are solved one by one."""
    above = (failure - least) / least if least > 0.0 else math.inf
    return (
        f"{groups} redundant groups are too many to solve at once: each is solved separately, "
        "and the results bound the mission's failure probability, stated as the upper bound: it "
        f"is between {least:.6e} and {failure:.6e}, too high by at most "
        f"{100.0 * above:.2g} %; functions and importances are given for each group separately"
    )


@dataclass(frozen=True, slots=True)
class ComponentContribution:
    """What one parameter adds to one function's top event."""

    component: str
    """Name of the component whose failures the parameter counts."""
    name: str
    """Name of the parameter, which counts all or a share of the component's failures."""
    units: int
    """Number of units of the component in the function's tree."""
    required: int | None
    """Number of units that must work; `None` where the tree has them under several gates."""
    probability: float
    """Probability that one unit fails during one visit."""
    contribution: float
    """Fall of the top event's probability if the component never fails nor has failed."""


@dataclass(frozen=True, slots=True)
class StateAssessment:
    """The figures of one function."""

    name: str
    """Qualified name of the function."""
    call_sequence: int
    """Rank of the function by first visit, from 1; unique in the model."""
    failure_state: str
    """Name of the absorbing state that its failure leads to."""
    top_event: float
    """Probability that one visit fails; the mean over the mission's visits where units may have
    failed in earlier ones."""
    expected_visits: float
    """Mean number of visits in a mission."""
    absorption_probability: float
    """Probability that the mission ends in `failure_state`."""
    components: tuple[ComponentContribution, ...]
    """What each parameter of the tree adds to `top_event`."""


@dataclass(frozen=True, slots=True)
class MissionFigures:
    """The mission's failure probability, read in three ways."""

    failure_probability: float
    """The reading that holds; limits and comparisons use it."""
    done_probability: float
    """Complement of `failure_probability`: the mission ends well."""
    reading: Reading
    """Which reading `failure_probability` is."""
    geometric_cycles: float
    """Failure probability of the chain itself: cycles vary around their mean."""
    cycle_failure_probability: float | None
    """Failure probability of one cycle: the chain cut where it comes back to the entry; `None`
    where the mission is not only rounds from the entry (`HybridModel.has_rounds`)."""
    expected_cycles: float | None
    """Number of cycles: the entry's expected visits where nothing fails; `None` as above."""
    fixed_cycles: float
    """Failure probability with each loop repeated as often as `next` counts; 1-(1-f)^N where
    `next` is a distribution, with N visits of the entry and f the failure between two of them."""
    visits_as_run: float
    """Failure probability 1-prod(1-t_s)^(v0_s), v0 the visits expected where nothing fails: the
    run's own counts when `next` comes from one run."""
    undetected_probability: float | None = None
    """Probability that the mission fails unnoticed, or does harm before it stops, in the reading
    that holds; `None` where nothing is said of what follows a failure."""
    undetected_geometric: float | None = None
    """The same of the chain itself."""
    stopped_late_probability: float | None = None
    """Probability that the mission does harm before it stops, a part of the undetected failure, in
    the reading that holds; `None` as above."""
    stopped_late_geometric: float | None = None
    """The same of the chain itself."""
    stopped_safely_probability: float | None = None
    """Probability that the mission stops before any harm, in the reading that holds; `None` as
    above."""
    stopped_safely_geometric: float | None = None
    """The same of the chain itself."""

    @property
    def undetected_or_all(self) -> float:
        """The undetected failure; all of it where nothing is said of what follows a failure."""
        known = self.undetected_probability
        return self.failure_probability if known is None else known

    @property
    def undetected_fraction(self) -> float | None:
        """The part of the mission's failure that is undetected; `None` where nothing is said of
        what follows a failure, or nothing fails."""
        if self.undetected_probability is None or self.failure_probability <= 0.0:
            return None
        return self.undetected_probability / self.failure_probability

    def as_geometric(self) -> MissionFigures:
        """Return the figures with the geometric reading as the one that applies."""
        failure = self.geometric_cycles
        return replace(
            self,
            failure_probability=failure,
            done_probability=1.0 - failure,
            reading=GEOMETRIC,
            undetected_probability=self.undetected_geometric,
            stopped_late_probability=self.stopped_late_geometric,
            stopped_safely_probability=self.stopped_safely_geometric,
        )


@dataclass(frozen=True, slots=True)
class ImportanceShare:
    """The part of a component's Birnbaum importance and criticality that one state or unit has."""

    name: str
    """Name of the function or unit."""
    birnbaum: float
    """Part of the derivative dF/dtheta."""
    criticality: float
    """Part of theta/F dF/dtheta."""


@dataclass(frozen=True, slots=True)
class ComponentImportance:
    """How much the mission's failure probability F depends on one parameter theta.

    Theta is common to all states, visits and units; a state's own value is theta times a fixed
    factor. Where F is zero, criticality and Fussell-Vesely are zero, the ratios one or infinite.
    """

    component: str
    """Name of the component whose failures the parameter counts."""
    name: str
    """Name of the parameter, which counts all or a share of the component's failures."""
    theta: float
    """Greatest probability over the states that one unit fails in one visit."""
    birnbaum: float
    """Derivative dF/dtheta; may exceed 1."""
    criticality: float
    """Birnbaum importance times theta/F."""
    fussell_vesely: float
    """(F-F0)/F, with F0 as `without`."""
    without: float
    """Failure probability F0 of the mission with a component that never fails."""
    risk_reduction_worth: float
    """F/F0; infinite where F0 is zero."""
    risk_achievement_worth: float
    """F with a component that has failed wherever it is used, over F."""
    tenfold: float
    """F(10 theta)/F, with every probability at most 1."""
    by_state: tuple[ImportanceShare, ...]
    """Parts of `birnbaum` and `criticality` by function."""
    by_unit: tuple[ImportanceShare, ...]
    """Parts of `birnbaum` and `criticality` by unit."""


@dataclass(frozen=True, slots=True)
class Assessment(Displayed):
    """All figures of a model."""

    model: str
    """Name of the model."""
    entry: str
    """Name of the function that runs first."""
    states: tuple[StateAssessment, ...]
    """Figures of the functions, in the order of the model."""
    mission: MissionFigures
    """Failure probability of the mission in each reading."""
    components: tuple[ComponentImportance, ...]
    """Importance of the parameters, the most important first; empty when not computed."""
    assumptions: tuple[str, ...]
    """What the model assumes, one sentence each."""
    findings: tuple[str, ...]
    """What a user should look at, such as functions never reached; one sentence each."""
    statement: str = FIGURE_STATEMENT
    """What the figures are and are not, for every output."""
    undetected_components: tuple[ComponentImportance, ...] = ()
    """Importance of the parameters for the undetected failure, the most important first; empty
    where nothing is said of what follows a failure."""

    def importance(self) -> Table[ComponentImportance]:
        """Return the components as a table, whose columns are arrays."""
        from tracerisk.prm.numbers.table import Table

        return Table(self.components)
