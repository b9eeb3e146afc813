"""A part of a dynamic tree that is solved as a whole: the failure model of one basic event."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from tracerisk.prm.numbers.probability import Probability
from tracerisk.prm.other_models.dynamic.exploration import explore
from tracerisk.prm.other_models.dynamic.failure_chain import FailureChain
from tracerisk.prm.other_models.dynamic.layout import lay_out

if TYPE_CHECKING:
    from tracerisk.prm.other_models.dynamic.tree import DynamicTree


@dataclass(frozen=True, slots=True)
class DynamicGroup:
    """A dynamic tree that is solved as a whole by one Markov chain: a failure model."""

    tree: DynamicTree
    """The dynamic tree of the group alone."""
    _chain: FailureChain | None = field(init=False, repr=False, compare=False, default=None)
    """Markov chain of the group's states; `None` until first needed."""

    @property
    def chain(self) -> FailureChain:
        """The chain of the group's states, made when it is first asked for.

        Raises as `probability` does.
        """
        if self._chain is None:
            tree = self.tree
            layout = lay_out(
                tree.top, tree.upwards, tree.events, tree.dependencies, tree.restrictions
            )
            object.__setattr__(self, "_chain", explore(layout, tree.state_limit))
        assert self._chain is not None
        return self._chain

    def probability(self, mission_time_h: float) -> Probability:
        """Return the probability that the group fails within the mission, [h].

        Raises TooLargeError when there are too many states or steps, ModelError when an event or a
        gate has no meaning in a Markov model.
        """
        return self.chain.failed_by(mission_time_h)
