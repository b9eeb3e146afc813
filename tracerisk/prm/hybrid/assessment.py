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
    """What one component adds to one function's top event.

    Of `units`, `required` must work; `None` where the tree holds them under several gates.
    `probability` is that of one unit failing during one visit; `contribution` is how much the
    top event's probability falls when the component never fails, nor has failed before.
    `name` is that of the parameter, which counts all or a share of the failures of `component`.
    """

    component: str
    name: str
    units: int
    required: int | None
    probability: float
    contribution: float


@dataclass(frozen=True, slots=True)
class StateAssessment:
    """The figures of one function.

    `top_event` is the probability that one visit fails, in the mean over the visits of a mission
    where units failed in earlier ones; `expected_visits` the mean number of
    visits in a mission, `absorption_probability` the probability that the mission ends in
    `failure_state`.
    """

    name: str
    call_sequence: int
    failure_state: str
    top_event: float
    expected_visits: float
    absorption_probability: float
    components: tuple[ComponentContribution, ...]


@dataclass(frozen=True, slots=True)
class MissionFigures:
    """The mission's failure probability, read in three ways.

    `failure_probability` is the one that holds, by `reading`: limits and changes go by it;
    `done_probability` is its complement.
    `geometric_cycles` is the chain's own: the number of cycles varies around its mean.
    `fixed_cycles` has each loop go round as often as `next` counts. Where `next` is a
    distribution, it is 1-(1-f)^N, with `cycle_failure_probability` f, the chain cut where it
    comes back to the entry, and `expected_cycles` N, the entry's expected visits where nothing
    fails.
    `visits_as_run` is 1-prod(1-t_s)^(v0_s), with v0 the expected visits where nothing fails:
    the run's own counts when `next` comes from one run.
    """

    failure_probability: float
    done_probability: float
    reading: Reading
    geometric_cycles: float
    cycle_failure_probability: float
    expected_cycles: float
    fixed_cycles: float
    visits_as_run: float

    def as_geometric(self) -> MissionFigures:
        """Return the figures with the geometric reading for the one that holds."""
        failure = self.geometric_cycles
        return replace(
            self,
            failure_probability=failure,
            done_probability=1.0 - failure,
            reading=GEOMETRIC,
        )


@dataclass(frozen=True, slots=True)
class ImportanceShare:
    """The part of a component's Birnbaum importance and criticality that one state or unit has."""

    name: str
    birnbaum: float
    criticality: float


@dataclass(frozen=True, slots=True)
class ComponentImportance:
    """How much the mission's failure probability F hangs on one component.

    The unit is the parameter theta, common to all states, visits and units; a state's own value
    is theta times a fixed factor.
    `birnbaum` is dF/dtheta, not bounded by one; `criticality` is theta/F times it.
    `without` is F0, the mission's failure probability with a component that never fails;
    `fussell_vesely` is (F-F0)/F; `risk_reduction_worth` is F/F0, infinite where F0 is zero.
    `risk_achievement_worth` is F/F with a component that has failed wherever it is used;
    `tenfold` is F(10 theta)/F, each probability at most one.
    Where F is zero, criticality and Fussell-Vesely are zero, the ratios one or infinite.
    `name` is that of the parameter, which counts all or a share of the failures of `component`.
    """

    component: str
    name: str
    theta: float
    birnbaum: float
    criticality: float
    fussell_vesely: float
    without: float
    risk_reduction_worth: float
    risk_achievement_worth: float
    tenfold: float
    by_state: tuple[ImportanceShare, ...]
    by_unit: tuple[ImportanceShare, ...]


@dataclass(frozen=True, slots=True)
class Assessment(Displayed):
    """All figures of a model; `components` with the one that matters most first.

    `assumptions` are those of the model itself, `findings` what a user should look at.
    """

    model: str
    entry: str
    states: tuple[StateAssessment, ...]
    mission: MissionFigures
    components: tuple[ComponentImportance, ...]
    assumptions: tuple[str, ...]
    findings: tuple[str, ...]
    statement: str = FIGURE_STATEMENT

    def importance(self) -> Table[ComponentImportance]:
        """Return the components as a table, whose columns are arrays."""
        from tracerisk.prm.numbers.table import Table

        return Table(self.components)
