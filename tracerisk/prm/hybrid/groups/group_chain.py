"""The functions with a few redundant groups whose failure does not end the mission.

A failed group is one more hidden state, the last one. So the mission's successful ends in that
state show how often such a mission would have failed by these groups, as a sum of positive terms.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import product

from tracerisk.prm.hybrid.hidden.hidden_chain import HiddenChain, Round, Spread
from tracerisk.prm.hybrid.hidden.hidden_states import Function, HiddenStates, Part, states_of
from tracerisk.prm.numbers.elimination import Elimination
from tracerisk.prm.numbers.probability import Probability

Group = tuple[int, ...]
"""The classes of units that parts of any function join."""

MOST_LAYERS = 32
"""Up to how many hidden states of one group are held."""


def groups_of(states: HiddenStates) -> tuple[Group, ...]:
    """Return the groups: those of different ones fail independently, given the visits."""
    group_of = {c: {c} for c in range(len(states.classes))}
    for function in states.functions:
        for part in function.parts:
            joined = set().union(*(group_of[c] for c in part.classes))
            if len(joined) > len(group_of[part.classes[0]]):
                group_of.update(dict.fromkeys(joined, joined))
    return tuple(dict.fromkeys(tuple(sorted(group)) for group in group_of.values()))


def states_with(states: HiddenStates, group: Group) -> HiddenStates:
    """Return the states of a chain in which only the units of one group can fail unseen."""
    place = {c: index for index, c in enumerate(group)}
    functions = tuple(_with_parts(function, place) for function in states.functions)
    classes = tuple(states.classes[c] for c in group)
    return states_of(functions, classes, states.entry, states.pattern, MOST_LAYERS)


def _with_parts(function: Function, place: dict[int, int]) -> Function:
    if not function.parts:
        return function
    return replace(
        function,
        parts=tuple(
            Part(tuple(place[c] for c in part.classes), part.threshold, part.spares)
            for part in function.parts
            if part.classes[0] in place
        ),
        parameters={place[c]: name for c, name in function.parameters.items() if c in place},
    )


class GroupChain(HiddenChain):
    """The chain of one group, or of several independent ones of the same path, that may all fail.

    `own` are the chains of the groups by themselves; one that is there twice is two groups alike.
    More failed units than a group's chain holds count as its failure, or as none if `at_most` is
    false.
    """

    def __init__(
        self, base: HiddenChain, own: Sequence[HiddenChain], *, at_most: bool = True
    ) -> None:
        """Join the chains; `base` is that of the functions without groups."""
        self._base, self._own, self._at_most = base, own, at_most
        self.rest = base.rest
        # The failure of a group comes after all of its hidden states.
        layers = list(product(*(range(len(chain.states.hidden) + 1) for chain in own)))
        self._alike = len(own) == 2 and own[0] is own[1]
        if self._alike:
            layers = [layer for layer in layers if layer[0] <= layer[1]]
        self._failed = tuple(len(chain.states.hidden) for chain in own)
        self._index = {layer: number for number, layer in enumerate(layers)}
        self.states = replace(base.states, hidden=tuple(layers), most=None)
        self._layers: dict[tuple[int, Round | None], Elimination] = {}
        self._products: dict[tuple[int, int], Spread] = {}

    def visit(
        self,
        number: int,
        layer: int,  # noqa: ARG002
        fewer: int | None = None,  # noqa: ARG002
    ) -> Probability:
        """Return the probability that the rest of the tree fails in a visit."""
        return self.rest[number]

    def spread(
        self,
        number: int,
        layer: int,
        chosen: object = None,  # noqa: ARG002
    ) -> Spread:
        """Return the layers to which a visit leads that the rest of the tree does not fail."""
        key = (number, layer)
        if key not in self._products:
            values: dict[tuple[int, ...], float] = {(): 1.0}
            hidden = self.states.hidden[layer]
            for chain, lost, failed in zip(self._own, hidden, self._failed, strict=True):
                ways = self._ways(chain, number, lost, failed)
                values = {
                    (*before, after): weight * share
                    for before, weight in values.items()
                    for after, share in ways
                }
            joined: dict[int, float] = {}
            for after, weight in values.items():
                to = self._index[tuple(sorted(after)) if self._alike else after]
                joined[to] = joined.get(to, 0.0) + weight
            self._products[key] = tuple(joined.items())
        return self._products[key]

    def _ways(self, chain: HiddenChain, number: int, lost: int, failed: int) -> Spread:
        if lost == failed:
            return ((failed, 1.0),)
        fails = chain.latent_failure(number, lost).p
        if self._at_most:
            fails += chain.exceeding(number, lost)
        ways = chain.spread(number, lost)
        return (*ways, (failed, fails)) if fails > 0.0 else ways

    def exceeding(
        self,
        number: int,
        layer: int,
        fewer: int | None = None,  # noqa: ARG002
    ) -> float:
        """Return the probability of more failed units than are held, if they have no layer."""
        if self._at_most or self.states.hidden[layer] == self._failed:
            return 0.0
        return self._own[0].exceeding(number, self.states.hidden[layer][0])

    def _layer(self, layer: int, cut: Round | None) -> Elimination:
        hidden = self.states.hidden[layer]
        if hidden == self._failed:
            return self._base._layer(0, cut)
        return super()._layer(layer, cut)
