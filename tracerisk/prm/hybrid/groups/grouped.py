"""A mission with many redundant groups, each solved by its own small chain with the functions.

Given the path the groups fail independently of each other and of the rest of the trees. The
latter weighs each path by its survival R; with F_g the failure of group g on a path, a mission
fails with 1 - E R + E R U, U that of any group. E R F_g comes from the chain of one group, E R
F_g^2 from that of two alike, `bounds` makes U of them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

from tracerisk.prm.hybrid.fixed_cycles import Loop, Passage, failure_of, outcome_of, passed
from tracerisk.prm.hybrid.groups.bounds import Moments, any_block, any_group
from tracerisk.prm.hybrid.groups.group_chain import GroupChain, groups_of, states_with
from tracerisk.prm.hybrid.groups.independence import blocks_of
from tracerisk.prm.hybrid.hidden.hidden_chain import Flow, HiddenChain, Round
from tracerisk.prm.hybrid.hidden.hidden_states import HiddenStates
from tracerisk.prm.numbers.probability import Probability

_MOST_PAIRS = 200
"""How many hidden states two groups alike may have together, for the mean of a square."""


class Bound(NamedTuple):
    """The outcome of a mission, bounded from both sides."""

    outcome: Probability
    """Failure and success of the mission with the groups' failures at their upper bound."""
    least: float
    """Lower bound of the mission's failure probability."""


class Grouped:
    """A model's functions, and its redundant groups by themselves."""

    def __init__(self, states: HiddenStates) -> None:
        """Prepare the chains; raise ModelError when a tree cannot be solved."""
        self.states = states
        self.groups = groups_of(states)
        self.base = HiddenChain(states_with(states, ()))
        self.own = [
            HiddenChain(states_with(states, group), base=self.base) for group in self.groups
        ]
        self._chains = [GroupChain(self.base, [chain]) for chain in self.own]

    @cached_property
    def flow(self) -> Flow:
        """The flow of missions in which no group fails."""
        return self.base.flow()

    @cached_property
    def flows(self) -> list[Flow]:
        """The flow of missions in which one group may fail, and the mission goes on."""
        return [chain.flow() for chain in self._chains]

    @cached_property
    def own_flows(self) -> list[Flow]:
        """The flow of missions that one group, or the rest of the trees, ends."""
        return [chain.flow() for chain in self.own]

    @cached_property
    def groups_in(self) -> list[list[int]]:
        """The groups of each function, by number."""
        groups: list[list[int]] = [[] for _ in self.states.functions]
        for group, chain in enumerate(self.own):
            for number, function in enumerate(chain.states.functions):
                if function.parts:
                    groups[number].append(group)
        return groups

    @cached_property
    def groups_with(self) -> dict[str, list[int]]:
        """The groups of which units have a parameter."""
        groups: dict[str, list[int]] = {}
        for group, chain in enumerate(self.own):
            for name in {n: None for f in chain.states.functions for n in f.parameters.values()}:
                groups.setdefault(name, []).append(group)
        return groups

    def all_units(self) -> HiddenChain:
        """Return the chain with all groups, of which only few hidden states are held."""
        return HiddenChain(self.states, base=self.base)

    def geometric(self) -> Bound:
        """Return the outcome of a mission whose cycles vary around their mean."""
        rest = Probability(failure_of(self.flow), math.fsum(self.flow.done))
        return self._bound(rest, [flow.done for flow in self.flows], None)

    def fixed(self, passage: Passage) -> Bound:
        """Return the outcome of a mission that passes just this."""
        ends = [passed(chain, passage, [1.0])[0] for chain in self._chains]
        return self._bound(outcome_of(self.base, passage), ends, passage)

    def one_cycle(self, whole: Round) -> float:
        """Return an upper bound of the failure probability of one cycle."""
        flows = [chain.flow(cut=whole) for chain in self._chains]
        failed = [flow.done[-2] + flow.back[-2] for flow in flows]
        return min(1.0, math.fsum([failure_of(self.base.flow(cut=whole)), *failed]))

    def cycles(self, whole: Round, rounds: int) -> Probability:
        """Return the outcome of so many cycles in a row, with an upper bound of their failures."""
        passage = (Loop(whole, rounds, None),)
        ends = [passed(chain, passage, [1.0])[0] for chain in self._chains]
        failed = [
            end[len(chain.states.hidden) - 1] for end, chain in zip(ends, self._chains, strict=True)
        ]
        rest = outcome_of(self.base, passage)
        lost = min(rest.q, math.fsum(failed))
        return Probability(rest.p + lost, rest.q - lost)

    def absorption(self) -> list[float]:
        """Return for each function how often it fails: the rest of its tree, and each group.

        Each is by itself: their sum is above the mission's failure by what fails twice.
        """
        result = [list(row) for row in zip(*self.flow.failures, strict=True)]
        for chain, own, flow in zip(self._chains, self.own, self.flows, strict=True):
            last = len(chain.states.hidden) - 1
            for number, function in enumerate(own.states.functions):
                if function.parts:
                    q = own.rest[number].q
                    result[number] += [
                        row[number] * q * share
                        for layer, row in enumerate(flow.visits[:last])
                        for to, share in chain.spread(number, layer)
                        if to == last and row[number] > 0.0
                    ]
        return [math.fsum(parts) for parts in result]

    def _bound(
        self, rest: Probability, ends: Sequence[Sequence[float]], passage: Passage | None
    ) -> Bound:
        """Return the bound from the rest of the trees and the successful ends by hidden state."""
        if rest.q == 0.0:
            return Bound(rest, rest.p)
        moments: list[Moments | None] = [None] * len(self.own)
        blocks = []
        for block in blocks_of(self.states, self.groups, passage):
            is_alone = block.is_certain or len(block.groups) == 1
            for number in block.groups:
                moments[number] = self._moments(number, ends[number], rest.q, passage, is_alone)
            own = [each for number in block.groups if (each := moments[number]) is not None]
            blocks.append(any_group(own, is_certain=block.is_certain))
        failed = any_block(blocks)
        most = rest.p + rest.q * failed.most
        return Bound(
            Probability(most, rest.q * (1.0 - failed.most)),
            min(most, rest.p + rest.q * failed.least),
        )

    def _moments(
        self,
        number: int,
        ends: Sequence[float],
        survival: float,
        passage: Passage | None,
        is_alone: bool,
    ) -> Moments:
        chain, own = self._chains[number], self.own[number]
        most = min(1.0, ends[len(chain.states.hidden) - 1] / survival)
        least = most
        if own.states.most is not None:
            least = min(most, self._failed([own], passage, at_most=False) / survival)
        square = most
        layers = len(chain.states.hidden)
        if not is_alone and layers * (layers + 1) // 2 <= _MOST_PAIRS:
            square = min(most, self._failed([own, own], passage) / survival)
        return Moments(least, most, square)

    def _failed(
        self, own: Sequence[HiddenChain], passage: Passage | None, *, at_most: bool = True
    ) -> float:
        """Return how often missions end well but for the failure of all these groups."""
        chain = GroupChain(self.base, own, at_most=at_most)
        ends = chain.flow().done if passage is None else passed(chain, passage, [1.0])[0]
        return ends[len(chain.states.hidden) - 1]
