"""Fault trees as data, and their exact probability.

A tree in which each event and gate is an input once takes the closed form of independent inputs,
gate by gate; any other goes to `tracerisk.prm.trees.bdd`, which is imported only then.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from operator import mul

from tracerisk.errors import ModelError, TooLargeError, one_of
from tracerisk.prm.display import DisplayedGraph
from tracerisk.prm.numbers.gc_pause import collection_paused
from tracerisk.prm.numbers.probability import Probability, pair_of, total, value_of
from tracerisk.prm.numbers.quantities import check_mission_time
from tracerisk.prm.trees.events import BasicEvent, HouseEvent
from tracerisk.prm.trees.gates import Gate, GateKind, gate_probability, gate_shares
from tracerisk.prm.trees.numbering import Numbering, numbered

TYPE_CHECKING = False
if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from tracerisk.prm.trees.bdd import SharedTree
    from tracerisk.prm.trees.building import Figure, Formula
    from tracerisk.prm.trees.conditional_tops import Conditional
    from tracerisk.prm.trees.fault_tree_solution import FaultTreeSolution

_pair = tuple.__new__


@dataclass(frozen=True, slots=True)
class FaultTree(DisplayedGraph):
    """A fault tree: named gates over named basic and house events.

    Raises ModelError when a name is used twice, an input is unknown, a gate stands above
    itself, a gate or event is not below the top, a gate's `k` or inputs do not fit its kind, or
    two events of one parameter have different models.
    """

    top: str
    """Name of the gate or event that is the top event."""
    gates: tuple[Gate, ...]
    """Gates in any order, all below the top."""
    events: tuple[BasicEvent, ...]
    """Basic events, all below the top."""
    houses: tuple[HouseEvent, ...] = ()
    """House events, all below the top."""
    _numbering: Numbering = field(init=False, repr=False, compare=False)
    """Events and gates by number, from the leaves up."""
    _shared: Mapping[str, tuple[str, ...]] = field(init=False, repr=False, compare=False)
    """Gates fed by each node that feeds several gates, or one gate twice."""
    _solver: SharedTree | None = field(init=False, repr=False, compare=False, default=None)
    """Decision diagrams of a tree that shares nodes; `None` until first needed."""

    def __post_init__(self) -> None:
        numbering = numbered(self)
        _check_models(self)
        object.__setattr__(self, "_numbering", numbering)
        object.__setattr__(self, "_shared", numbering.shared)

    @classmethod
    def of(
        cls,
        top: str,
        gates: Mapping[str, Formula],
        events: Mapping[str, Figure | BasicEvent] | None = None,
        houses: Mapping[str, bool] | None = None,
    ) -> FaultTree:
        """Build a fault tree from formulas such as `{"top": ("atleast", 2, "a", "b", "c")}`.

        A formula names the kind of a gate, its numbers if it has any, and its inputs, which may
        be formulas themselves.
        `events` gives each basic event a probability, a failure model, `None` or a `BasicEvent`;
        without it, every input that is not a gate or house event is one.
        Raises ModelError, naming the gate or event, when they make no tree.
        """
        from tracerisk.prm.trees.building import tree_parts

        return cls(top, *tree_parts(top, gates, events, houses or {}))

    @property
    def parameters(self) -> tuple[str, ...]:
        """The parameters of the events, each once, in the order of the events."""
        return tuple(dict.fromkeys(event.parameter for event in self.events))

    @property
    def shared(self) -> Mapping[str, tuple[str, ...]]:
        """The gates and events that feed more than one gate, or one gate twice, with those."""
        return self._shared

    @property
    def is_coherent(self) -> bool:
        """Whether more failures can only make the top happen, never prevent it."""
        return all(gate.kind.is_coherent for gate in self.gates)

    @property
    def upwards(self) -> tuple[Gate, ...]:
        """The gates, each after those below it."""
        return self._numbering.gates

    def values_at(self, mission_time_h: float | None) -> dict[str, float]:
        """Return the probability of each parameter whose events have a model, for a mission, [h].

        Each number keeps the complement that its model gives, see `PairedFloat`.
        Without a mission time, `None`, only of those whose model needs none.
        Raises ModelError, with the event, when a model cannot be evaluated, and for a mission time
        that is not a number of 0 or more.
        """
        if mission_time_h is not None:
            check_mission_time(mission_time_h)
        values: dict[str, float] = {}
        for event in self.events:
            if event.model is None or event.parameter in values:
                continue
            if mission_time_h is None and getattr(event.model, "needs_mission_time", True):
                continue
            try:
                values[event.parameter] = value_of(event.model.probability(mission_time_h or 0.0))
            except ModelError as error:
                raise ModelError(
                    f"event '{event.name}': {error.message}", error.location
                ) from error
        return values

    def solve(
        self, values: Mapping[str, float] | None = None, *, mission_time_h: float | None = None
    ) -> FaultTreeSolution:
        """Solve the tree: its top's probability, and the importance of its parameters.

        `values` gives parameters their probability and overrides what their models give for
        `mission_time_h`, [h].
        Raises as `probability` does, and when a model needs the mission time and has none.
        """
        from tracerisk.prm.trees.fault_tree_solution import solve_tree

        return solve_tree(self, values or {}, mission_time_h)

    def probability(self, values: Mapping[str, float]) -> Probability:
        """Return the top event's probability, exact to rounding.

        `values` gives each parameter the probability of one event.
        Raises ModelError when a parameter has no value or one outside [0, 1], TooLargeError when
        events are shared and the tree's decision diagram outgrows every budget.
        """
        if self._shared:
            pairs = self._event_values(values)
            try:
                return self._compiled().probability(pairs)
            except TooLargeError as error:
                from tracerisk.prm.trees.bdd import with_bounds

                raise with_bounds(error, self, pairs) from error
        return self._swept(values)[self._numbering.top]

    def node_probabilities(self, values: Mapping[str, float]) -> dict[str, Probability]:
        """Return the probability of every event and gate of a tree that shares none.

        Raises as `probability` does.
        """
        return dict(zip(self._numbering.names, self._swept(values), strict=True))

    def probabilities(self, values: Mapping[str, ArrayLike]) -> NDArray[np.float64]:
        """Return the top's probability and its complement for n samples at once, (n, 2).

        `values` gives each parameter n probabilities, (n,), or one for all samples.
        Raises as `probability` does, and when arrays differ in length.
        """
        from tracerisk.prm.trees.sampled_tree import top_samples

        return top_samples(self, values, self._compiled() if self._shared else None)

    def sensitivities(self, values: Mapping[str, float]) -> dict[str, float]:
        """Return for each event the derivative of the top's probability by the event's.

        For coherent trees these are sums and products of probabilities only: no difference is
        taken, nothing cancels (Birnbaum 1969, "On the importance of different components").
        Raises as `probability` does.
        """
        if self._shared:
            return self._compiled().sensitivities(self._event_values(values))
        numbering = self._numbering
        nodes = self._swept(values)
        weights = [0.0] * len(nodes)
        weights[numbering.top] = 1.0
        number = len(nodes)
        for gate, inputs in zip(reversed(numbering.gates), reversed(numbering.inputs), strict=True):
            number -= 1
            pairs = [nodes[below] for below in inputs]
            for below, share in zip(inputs, gate_shares(gate, pairs, pairs), strict=True):
                weights[below] = weights[number] * share
        return {event.name: weights[place] for place, event in enumerate(self.events)}

    def conditional_tops(self, values: Mapping[str, float]) -> dict[str, Conditional]:
        """Return for each event the top's pair given that it happens, and that it does not.

        Where nothing is shared one pass gives all.
        Raises as `probability` does.
        """
        from tracerisk.prm.trees.conditional_tops import conditional_tops, shared_conditional_tops

        if self._shared:
            return shared_conditional_tops(self._compiled(), self._event_values(values))
        return conditional_tops(self, self.node_probabilities(values))

    def drop_without(self, parameter: str, values: Mapping[str, float]) -> float:
        """Return how much the top's probability falls when `parameter` is set to zero.

        The difference is taken inside the tree as a sum of products of probabilities: it keeps
        its relative precision beside a top of any size.
        Raises as `probability` does.
        """
        return self.difference(values, {**values, parameter: 0.0})

    def difference(self, high: Mapping[str, float], low: Mapping[str, float]) -> float:
        """Return the top's probability with the values `high` less that with `low`.

        The difference is taken inside the tree, see `drop_without`.
        Raises as `probability` does.
        """
        if self._shared:
            return self._compiled().difference(self._event_values(high), self._event_values(low))
        before, after = self._swept(high), self._swept(low)
        drops = [before[number].p - after[number].p for number in range(len(self.events))]
        drops += [0.0] * len(self.houses)
        for gate, inputs in zip(self._numbering.gates, self._numbering.inputs, strict=True):
            shares = gate_shares(gate, [before[n] for n in inputs], [after[n] for n in inputs])
            drops.append(total(map(mul, shares, [drops[number] for number in inputs])))
        return drops[self._numbering.top]

    def _compiled(self) -> SharedTree:
        """Return the tree's decision diagrams, made when first asked for."""
        if self._solver is None:
            from tracerisk.prm.trees import bdd

            object.__setattr__(self, "_solver", bdd.SharedTree(self))
        assert self._solver is not None
        return self._solver

    def _event_values(self, values: Mapping[str, float]) -> dict[str, Probability]:
        """Return the probability of each basic event."""
        pairs = self._parameter_values(values)
        return {event.name: pairs[event.parameter] for event in self.events}

    def _parameter_values(self, values: Mapping[str, float]) -> dict[str, Probability]:
        """Return the probability of each parameter's events."""
        pairs: dict[str, Probability] = {}
        for event in self.events:
            parameter = event.parameter
            if parameter not in pairs:
                if parameter not in values:
                    raise ModelError(
                        f"event '{event.name}': parameter '{parameter}' has no value; "
                        f"{one_of(values)}"
                    )
                value = values[parameter]
                if not 0.0 <= value <= 1.0:
                    raise ModelError(
                        f"event '{event.name}': probability {value!r} is outside [0, 1]; "
                        "give a number within"
                    )
                # Made as a tuple: a named tuple's own constructor takes twice the time.
                plain = type(value) is float
                pairs[parameter] = (
                    _pair(Probability, (value, 1.0 - value)) if plain else pair_of(value)
                )
        return pairs

    def _swept(self, values: Mapping[str, float]) -> list[Probability]:
        """Return the probability of every event and gate, by number."""
        with collection_paused(len(self.events) + len(self.gates)):
            pairs = self._parameter_values(values)
            nodes = [pairs[event.parameter] for event in self.events]
            nodes += (Probability(float(h.state), float(not h.state)) for h in self.houses)
            either, both = GateKind.OR, GateKind.AND
            for gate, inputs in zip(self._numbering.gates, self._numbering.inputs, strict=True):
                kind = gate.kind
                if len(inputs) == 2 and (kind is either or kind is both):
                    # The commonest gates, without the way through the general ones.
                    p, q = nodes[inputs[0]]
                    p_other, q_other = nodes[inputs[1]]
                    if kind is either:
                        pair = _pair(Probability, (p + q * p_other, q * q_other))
                    else:
                        pair = _pair(Probability, (p * p_other, q + p * q_other))
                else:
                    pair = gate_probability(gate, [nodes[number] for number in inputs])
                nodes.append(pair)
        return nodes


def _check_models(tree: FaultTree) -> None:
    models: dict[str, BasicEvent] = {}
    for event in tree.events:
        first = models.setdefault(event.parameter, event)
        if first.model != event.model:
            raise ModelError(
                f"events '{first.name}' and '{event.name}' share the parameter "
                f"'{event.parameter}' but have different models; give them one model, or two "
                "parameters"
            )
