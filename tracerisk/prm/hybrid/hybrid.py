"""The hybrid model: a Markov chain over functions, a fault tree in each of its states."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

from tracerisk.common.strong_components import reached, strong_components
from tracerisk.errors import ModelError, one_of
from tracerisk.prm.display import DisplayedGraph
from tracerisk.prm.hybrid.elements import DONE, FunctionState, NextStep, Parameter
from tracerisk.prm.hybrid.hidden.latent_units import check_latent
from tracerisk.prm.numbers.quantities import check_names
from tracerisk.prm.trees.fault_tree import FaultTree

if TYPE_CHECKING:
    from tracerisk.prm.hybrid.building import Following


@dataclass(frozen=True, slots=True)
class HybridModel(DisplayedGraph):
    """A risk model: states in the order of their call sequence, the entry, the parameters.

    Each visit to a state fails with its tree's top probability and ends the mission there, else
    goes on by `next`.
    All units but the latent ones are as good as new at each visit.

    Raises ModelError, naming the element, when names clash or are unknown, a probability is
    outside [0, 1], a `next` does not sum to one, `done` cannot be reached from a state that
    the entry leads to, or a tree cannot carry the latent units (see `latent_parts`).
    """

    name: str
    """Name of the model, usually the controller's."""
    entry: str
    """Name of the state in which the mission starts."""
    states: tuple[FunctionState, ...]
    """Functions with their fault trees, in the order of their call sequence."""
    parameters: tuple[Parameter, ...]
    """Figures theta that the states' probabilities refer to."""
    latent: tuple[str, ...] = ()
    """Basic events whose hidden failure lasts, in every state with an event of the name, until
    the mission ends."""
    counted: bool = False
    """Whether each `next` was counted in one mission, so that the numbers of cycles are fixed
    and not random."""

    def __post_init__(self) -> None:
        check_names("state", [state.name for state in self.states], reserved=(DONE,))
        check_names("parameter", [parameter.name for parameter in self.parameters])
        names = {state.name for state in self.states}
        if self.entry not in names:
            raise ModelError(f"entry '{self.entry}' is not a state; {one_of(names, self.entry)}")
        for parameter in self.parameters:
            _check_probability(f"parameter '{parameter.name}': theta", parameter.theta)
        thetas = {parameter.name: parameter.theta for parameter in self.parameters}
        targets = names | {DONE}
        for state in self.states:
            _check_probabilities(state, thetas)
            _check_next(state, targets)
            if state.fates:
                _check_fates(state, names, self.latent)
        spares = {state.name: state.spares for state in self.states if state.spares}
        if self.latent or spares:
            check_latent({state.name: state.tree for state in self.states}, self.latent, spares)
        steps = {state.name: state.next for state in self.states}
        caught = endless_states(steps, self.entry)
        if caught:
            raise ModelError(
                f"'{DONE}' cannot be reached from {', '.join(caught)}; "
                f"add '{DONE}' to 'next' of one of them"
            )

    @classmethod
    def of(
        cls,
        name: str,
        trees: Mapping[str, FaultTree],
        following: Mapping[str, Following] | None = None,
        *,
        values: Mapping[str, float] | None = None,
        visit_h: float | Mapping[str, float] | None = None,
        entry: str | None = None,
        latent: Iterable[str] = (),
    ) -> HybridModel:
        """Build a hybrid model from the fault tree of each state.

        `following` gives each state what follows a visit that did not fail: a state or `done`,
        or several with their shares; without it the states follow in their order.
        Figures come from the events' models, for visits of `visit_h` hours, and from `values`.
        The first state is the entry unless another is named.
        Raises ModelError, naming the state, as the class does and when a figure is missing.
        """
        from tracerisk.prm.hybrid.building import state_parts

        states, parameters = state_parts(name, trees, following, values or {}, visit_h)
        return cls(
            name,
            states[0].name if entry is None else entry,
            states,
            parameters,
            tuple(latent),
        )

    @property
    def reachable(self) -> tuple[str, ...]:
        """The states that the entry leads to, in the order of `states`."""
        reachable = reachable_states({state.name: state.next for state in self.states}, self.entry)
        return tuple(state.name for state in self.states if state.name in reachable)

    @property
    def has_cycle(self) -> bool:
        """Whether a mission can come back to a state it has visited."""
        following = {
            state.name: {step.target for step in state.next if step.weight > 0} - {DONE}
            for state in self.states
        }
        reachable = set(self.reachable)
        return any(
            len(component) > 1 or component[0] in following[component[0]]
            for component in strong_components(following)
            if component[0] in reachable
        )

    @property
    def has_rounds(self) -> bool:
        """Whether a mission is nothing but rounds of a cycle that begins at the entry.

        Each round but the last leads back to the entry, and the last ends where others do. So it
        is not where the entry is a home position that the mission takes at its end once more, or
        where other functions follow the rounds. A mission that visits its entry once is one round.
        """
        reachable = set(self.reachable)
        following = {
            state.name: {step.target for step in state.next if step.weight > 0}
            for state in self.states
            if state.name in reachable
        }
        if not any(self.entry in targets for targets in following.values()):
            return True
        if len(following) > 1 and following[self.entry] & {self.entry, DONE}:
            return False
        return all(self.entry in targets for targets in following.values() if DONE in targets)

    @property
    def failure_states(self) -> Mapping[str, str]:
        """Each state's absorbing failure state: `<name>_failure`.

        A function that already bears that name keeps it; the failure state then gets as many
        more underscores as it takes to differ.
        """
        taken = {state.name for state in self.states}
        named = {}
        for state in self.states:
            failure = f"{state.name}_failure"
            while failure in taken:
                failure = failure.removesuffix("failure") + "_failure"
            taken.add(failure)
            named[state.name] = failure
        return named


def reachable_states(steps: Mapping[str, Sequence[NextStep]], entry: str) -> set[str]:
    """Return the states, `done` excepted, that can be visited from `entry` on."""
    return reached(
        (entry,),
        lambda name: [s.target for s in steps[name] if s.weight > 0 and s.target != DONE],
    )


def endless_states(steps: Mapping[str, Sequence[NextStep]], entry: str) -> list[str]:
    """Return the states that `entry` leads to and that never lead to `done`, in order."""
    sources: dict[str, list[str]] = {}
    for name, following in steps.items():
        for step in following:
            if step.weight > 0:
                sources.setdefault(step.target, []).append(name)
    ending = reached((DONE,), lambda name: sources.get(name, ()))
    reachable = reachable_states(steps, entry)
    return [name for name in steps if name in reachable and name not in ending]


def _check_probability(where: str, value: float) -> None:
    if not 0.0 <= value <= 1.0:
        raise ModelError(f"{where} {value!r} is outside [0, 1]; give a number within")


def _check_probabilities(state: FunctionState, parameters: Mapping[str, float]) -> None:
    where = f"state '{state.name}'"
    for name, value in state.probabilities.items():
        if name not in parameters:
            raise ModelError(f"{where}: no parameter '{name}'; {one_of(parameters, name)}")
        _check_probability(f"{where}: probability of '{name}'", value)
        if value > parameters[name]:
            raise ModelError(
                f"{where}: probability {value!r} of '{name}' is above its theta "
                f"{parameters[name]!r}; theta must be the greatest value over the states"
            )
    needed = set(state.tree.parameters)
    missing = sorted(needed - set(state.probabilities))
    if missing:
        raise ModelError(f"{where}: no probability for {', '.join(missing)}; give each one")
    superfluous = sorted(set(state.probabilities) - needed)
    if superfluous:
        raise ModelError(
            f"{where}: the fault tree has no event with the parameter {', '.join(superfluous)}; "
            "remove the probability"
        )


def _check_next(state: FunctionState, targets: set[str]) -> None:
    where = f"state '{state.name}'"
    seen: set[str] = set()
    for step in state.next:
        if step.target not in targets:
            raise ModelError(
                f"{where}: next '{step.target}' is not a state; {one_of(targets, step.target)}"
            )
        if step.target in seen:
            raise ModelError(f"{where}: duplicate next '{step.target}'; add up the two")
        if step.weight < 0:
            raise ModelError(f"{where}: next '{step.target}' is {step.weight}, below zero")
        seen.add(step.target)
    total = sum((step.weight for step in state.next), Fraction(0))
    if total != 1:
        raise ModelError(f"{where}: next sums to {total}; it must sum to 1")


def _check_fates(state: FunctionState, names: set[str], latent: Sequence[str]) -> None:
    for parameter, fates in state.fates.items():
        where = f"state '{state.name}': failures of '{parameter}'"
        events = [event for event in state.tree.events if event.parameter == parameter]
        if not events:
            known = set(state.tree.parameters)
            raise ModelError(f"{where}: no such parameter here; {one_of(known, parameter)}")
        redundant = [event for event in events if event.name in latent]
        if redundant or not all(_fails_alone(state.tree, event.name) for event in events):
            raise ModelError(
                f"{where}: what follows can be given only where each unit is needed; a redundant "
                "group counts as failed unnoticed"
            )
        for fate in fates:
            if fate.share < 0:
                raise ModelError(f"{where}: a share of {fate.share} is below zero")
            if (fate.kind == "back") != bool(fate.target):
                raise ModelError(f"{where}: '{fate.kind}' with the target '{fate.target}'")
            for name in (fate.target, fate.shows_in):
                if name and name not in names:
                    raise ModelError(f"{where}: '{name}' is not a state; {one_of(names, name)}")
        total = sum((fate.share for fate in fates), Fraction(0))
        if total > 1:
            raise ModelError(f"{where}: the shares sum to {total}; they may sum to 1 at most")


def _fails_alone(tree: FaultTree, name: str) -> bool:
    """Return whether a node by itself brings about the top event, through gates that need one."""
    if name == tree.top:
        return True
    return any(
        gate.threshold == 1 and gate.most is None and _fails_alone(tree, gate.name)
        for gate in tree.gates
        if name in gate.inputs
    )
