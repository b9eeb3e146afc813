"""Bayesian networks of operating conditions on which the probabilities of basic events depend.

Events that depend on common conditions are not independent: their fault tree is solved for each
joint state of the conditions that matter to it, and the results are weighed by the probabilities
of these states (J. Pearl, "Probabilistic Reasoning in Intelligent Systems", 1988, conditioning).
The network itself is solved exactly by pyAgrum, which is imported only then.
pyAgrum works in double precision and, for this, by products and sums of the non-negative numbers
of the tables and one division: nothing cancels, and states of 1e-20 keep their relative precision.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from itertools import product
from typing import TYPE_CHECKING

from tracerisk.errors import ModelError, TooLargeError, one_of
from tracerisk.prm.display import Displayed
from tracerisk.prm.other_models.bayes.inference import joint_probabilities
from tracerisk.prm.other_models.bayes.solution import solve_network
from tracerisk.prm.other_models.bayes.tables import Case, Distribution, Entry, Figure, Given, States

if TYPE_CHECKING:
    from tracerisk.prm.other_models.bayes.solution import BayesianSolution
    from tracerisk.prm.trees.fault_tree import FaultTree

_MOST_CASES = 100_000
_TOLERANCE = 1e-9


@dataclass(frozen=True, slots=True)
class BayesianNetwork(Displayed):
    """Conditions with their distributions, and basic events whose probability depends on them.

    A basic event that is itself a condition has the probabilities 0 and 1 given its states.

    Raises ModelError, naming the condition or event, when a parent or state is unknown, a state
    of the parents has no entry, a distribution does not sum to one, a probability is outside
    [0, 1], or conditions depend on each other in a circle.
    """

    conditions: Mapping[str, Distribution | Given[Distribution]]
    """Distribution over the states of each condition, alone or given other conditions."""
    events: Mapping[str, Given[Figure]] = field(default_factory=dict)
    """Probability of fault-tree parameters given conditions; events of one parameter are
    independent in every state."""

    def __post_init__(self) -> None:
        for name, condition in self.conditions.items():
            for states, row in _rows(condition).items():
                _check_row(f"condition '{name}'{_text(condition, states)}", row)
            alike = {frozenset(row) for row in _rows(condition).values()}
            if len(alike) != 1:
                raise ModelError(
                    f"condition '{name}': its rows have different states; give each row all states"
                )
        for name, condition in self.conditions.items():
            if isinstance(condition, Given):
                self._check_table(f"condition '{name}'", condition)
        for name, event in self.events.items():
            self._check_table(f"event '{name}'", event)
            for states, figure in event.rows().items():
                if isinstance(figure, int | float) and not 0.0 <= figure <= 1.0:
                    raise ModelError(
                        f"event '{name}'{_text(event, states)}: probability {figure!r} is outside "
                        "[0, 1]; give a number within"
                    )
        _ = self.ordered

    @property
    def ordered(self) -> tuple[str, ...]:
        """The conditions, each after those that it depends on."""
        waiting = {name: set(self.parents(name)) for name in self.conditions}
        order: list[str] = []
        while waiting:
            free = [name for name, parents in waiting.items() if not parents]
            if not free:
                raise ModelError(
                    f"the conditions {', '.join(waiting)} depend on each other in a cycle; break it"
                )
            order.extend(free)
            waiting = {
                name: parents.difference(free)
                for name, parents in waiting.items()
                if name not in free
            }
        return tuple(order)

    def parents(self, condition: str) -> tuple[str, ...]:
        """Return the conditions that a condition directly depends on."""
        given = self.conditions[condition]
        return given.names if isinstance(given, Given) else ()

    def states(self, condition: str) -> tuple[str, ...]:
        """Return the states of a condition.

        Raises ModelError when there is no such condition.
        """
        if condition not in self.conditions:
            raise ModelError(
                f"'{condition}' is not a condition; {one_of(self.conditions, condition)}"
            )
        return tuple(next(iter(_rows(self.conditions[condition]).values())))

    def distribution(self, condition: str, evidence: States | None = None) -> dict[str, float]:
        """Return the probability of each state of a condition, given what is known.

        Raises ModelError when a name is unknown, what is known is impossible, or pyAgrum is not
        installed.
        """
        return {
            states[0]: probability
            for states, probability in self.joint((condition,), evidence).items()
        }

    def joint(
        self, conditions: Iterable[str], evidence: States | None = None
    ) -> dict[tuple[str, ...], float]:
        """Return the probability of each joint state of conditions, given what is known.

        Raises as `distribution` does, and TooLargeError beyond 100,000 joint states.
        """
        names = tuple(dict.fromkeys(conditions))
        known = dict(evidence or {})
        for name, state in known.items():
            if state not in self.states(name):
                raise ModelError(
                    f"condition '{name}' has no state '{state}'; {one_of(self.states(name), state)}"
                )
        count = math.prod(len(self.states(name)) for name in names if name not in known)
        if count > _MOST_CASES:
            raise TooLargeError(
                f"the conditions {', '.join(names)} have {count} joint states; at most "
                f"{_MOST_CASES} are supported; merge states, or let events depend on fewer "
                "conditions"
            )
        return joint_probabilities(self, names, known)

    def cases(
        self,
        parameters: Iterable[str],
        *,
        mission_time_h: float | None = None,
        evidence: States | None = None,
    ) -> tuple[Case, ...]:
        """Return the joint states of the conditions that bear on some parameters.

        Any probability, of a top event, an event tree's outcome or a mission's failure, is the
        sum of its values in these cases, weighed by their probabilities.
        Parameters that no event of the network names are left to the caller.
        Raises as `joint` does, and ModelError when a failure model needs the mission's length.
        """
        bearing = [name for name in dict.fromkeys(parameters) if name in self.events]
        conditions = tuple(
            dict.fromkeys(parent for name in bearing for parent in self.events[name].names)
        )
        tables = {name: self.events[name].rows() for name in bearing}
        result = []
        for joint, probability in self.joint(conditions, evidence).items():
            states = dict(zip(conditions, joint, strict=True))
            values = {}
            for name, table in tables.items():
                figure = table[tuple(states[parent] for parent in self.events[name].names)]
                values[name] = _figure(name, figure, mission_time_h)
            result.append(Case(states, probability, values))
        return tuple(result)

    def solve(
        self,
        tree: FaultTree,
        values: Mapping[str, float] | None = None,
        *,
        mission_time_h: float | None = None,
        evidence: States | None = None,
    ) -> BayesianSolution:
        """Solve a fault tree whose basic events depend on the network's conditions.

        `values` gives the parameters that the network does not; where it gives none either,
        the events' own models do, for `mission_time_h`, [h].
        `evidence` gives known states of conditions.
        Raises as `cases` and the tree's `probability` do.
        """
        return solve_network(self, tree, values or {}, mission_time_h, evidence or {})

    def _check_table(self, where: str, given: Given[Entry]) -> None:
        for parent in given.names:
            if parent not in self.conditions:
                raise ModelError(
                    f"{where}: it depends on '{parent}', which is not a condition; "
                    f"{one_of(self.conditions, parent)}"
                )
        needed = set(product(*(self.states(parent) for parent in given.names)))
        for states in given.rows():
            if states not in needed:
                allowed = one_of(", ".join(texts) for texts in needed)
                raise ModelError(
                    f"{where}: a row for {', '.join(states)}, which is not a state of "
                    f"{', '.join(given.names)}; {allowed}"
                )
        for states in sorted(needed - set(given.rows())):
            raise ModelError(f"{where}: no row for {', '.join(states)}; give one")


def _rows(condition: Distribution | Given[Distribution]) -> dict[tuple[str, ...], Distribution]:
    return condition.rows() if isinstance(condition, Given) else {(): condition}


def _text(given: object, states: tuple[str, ...]) -> str:
    """Return where in a table a row stands."""
    return f" given {', '.join(states)}" if isinstance(given, Given) else ""


def _check_row(where: str, row: Distribution) -> None:
    for state, probability in row.items():
        if not 0.0 <= probability <= 1.0:
            raise ModelError(
                f"{where}: probability {probability!r} of '{state}' is outside [0, 1]; "
                "give a number within"
            )
    total = math.fsum(row.values())
    if abs(total - 1.0) > _TOLERANCE:
        raise ModelError(f"{where}: its states sum to {total!r}; they must sum to 1")


def _figure(name: str, figure: Figure, mission_time_h: float | None) -> float:
    if isinstance(figure, int | float):
        return float(figure)
    if mission_time_h is None:
        raise ModelError(f"event '{name}' depends on the mission time; give mission_time_h")
    return figure.probability(mission_time_h).p
