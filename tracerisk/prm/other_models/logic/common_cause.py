"""Common cause failures: groups of like units that one cause can hit together.

A group replaces each of its members by an OR over the events that hit it: alone, with one other,
up to all together. Each of those is a basic event whose probability is a share of the member's.

Sources: A. Mosleh, D. Rasmuson, F. Marshall, "Guidelines on Modeling Common-Cause Failures in
Probabilistic Risk Assessment", NUREG/CR-5485 (1998); "Open-PSA Model
Exchange Format" 2.0d, section "Common Cause Failures".
"""

from __future__ import annotations

import enum
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import accumulate, combinations
from math import comb, fsum
from operator import mul

from tracerisk.errors import ModelError, TooLargeError, one_of
from tracerisk.prm.numbers.probability import Probability, pair_of, value_of
from tracerisk.prm.numbers.quantities import check_share
from tracerisk.prm.trees.events import BasicEvent, FailureModel
from tracerisk.prm.trees.failure_models import Constant
from tracerisk.prm.trees.fault_tree import FaultTree
from tracerisk.prm.trees.gates import Gate, GateKind

__all__ = [
    "CommonCauseGroup",
    "CommonCauseLaw",
    "CommonCauseTree",
    "ShareOf",
    "expand_common_cause",
]

EVENT_LIMIT = 100_000
"""The most events that a group may need; 16 members, each set of them, need 65,535."""


class CommonCauseLaw(enum.Enum):
    """How the probability Q of a member is shared among the events that hit k of the n members.

    With m(k) = 1 / C(n-1, k-1), since a member belongs to so many sets of k:

    BETA, one factor: 1 - beta for the member alone, beta for all together.
    MGL, factors r2, r3...: m(k) r2 ... rk (1 - r(k+1)), r of more than the levels given being 0.
    ALPHA, factors a1, a2...: k m(k) ak / (a1 + 2 a2 + ...) where all units are tested together,
    m(k) ak / (a1 + a2 + ...) where they are tested one after the other (staggered).
    PHI, factors f1, f2...: fk, as it is given.
    """

    BETA = "beta-factor"
    MGL = "MGL"
    ALPHA = "alpha-factor"
    PHI = "phi-factor"


@dataclass(frozen=True, slots=True)
class CommonCauseGroup:
    """Basic events of one probability that a common cause can hit together.

    Raises ModelError when members or factors do not fit the law.
    """

    name: str
    """Name of the group, for messages and parameters."""
    members: tuple[str, ...]
    """Names of the basic events, at least two."""
    law: CommonCauseLaw
    """How a member's probability is shared among the events that hit several."""
    factors: tuple[float, ...]
    """Factors of the law in the order of their levels: one of BETA, from level 2 of MGL, from
    level 1 of ALPHA and PHI."""
    staggered: bool = False
    """Whether the units are tested one after the other, for ALPHA only; other laws' factors
    imply their tests."""

    def __post_init__(self) -> None:
        where = f"common cause group '{self.name}'"
        if len(self.members) < 2:
            raise ModelError(f"{where}: {len(self.members)} members; it needs at least 2")
        if len(set(self.members)) < len(self.members):
            raise ModelError(f"{where}: duplicate member; name each once")
        least, most = self._allowed_factors()
        if not least <= len(self.factors) <= most:
            allowed = str(least) if least == most else f"{least} to {most}"
            raise ModelError(
                f"{where}: {len(self.factors)} factors of {self.law.value} for "
                f"{len(self.members)} members; allowed: {allowed}"
            )
        for number, factor in enumerate(self.factors, start=1):
            check_share(f"{where}: factor {number}", factor)
        if self.law is CommonCauseLaw.ALPHA and not any(self.factors):
            raise ModelError(f"{where}: all factors are 0; give one that is not")
        if self.law is CommonCauseLaw.PHI and abs(fsum(self.factors) - 1.0) > 1e-4:
            raise ModelError(
                f"{where}: the factors sum to {fsum(self.factors)!r}; phi-factors must sum to 1"
            )
        if self.staggered and self.law is not CommonCauseLaw.ALPHA:
            raise ModelError(f"{where}: staggered is for alpha-factor only; leave it out")
        needed = sum(comb(len(self.members), level) for level in self.shares)
        if needed > EVENT_LIMIT:
            raise TooLargeError(
                f"{where}: {needed} events for {len(self.members)} members; allowed: "
                f"{EVENT_LIMIT}; give factors for fewer levels, or make smaller groups"
            )

    @property
    def shares(self) -> dict[int, float]:
        """The share of a member's probability that one event hitting k members has, by k."""
        count, factors = len(self.members), self.factors
        if self.law is CommonCauseLaw.BETA:
            return {1: 1.0 - factors[0], count: factors[0]}
        if self.law is CommonCauseLaw.PHI:
            return dict(enumerate(factors, start=1))
        if self.law is CommonCauseLaw.MGL:
            reached = accumulate(factors, mul, initial=1.0)
            stopped = [1.0 - factor for factor in factors] + [1.0]
            return {
                level: product * stop / comb(count - 1, level - 1)
                for level, (product, stop) in enumerate(zip(reached, stopped, strict=True), start=1)
            }
        weights = [1 if self.staggered else level for level, _ in enumerate(self.factors, start=1)]
        whole = fsum(weight * factor for weight, factor in zip(weights, factors, strict=True))
        return {
            level: weight * factor / whole / comb(count - 1, level - 1)
            for level, (weight, factor) in enumerate(zip(weights, factors, strict=True), start=1)
        }

    def _allowed_factors(self) -> tuple[int, int]:
        count = len(self.members)
        if self.law is CommonCauseLaw.BETA:
            return 1, 1
        return (1, count - 1) if self.law is CommonCauseLaw.MGL else (1, count)


@dataclass(frozen=True, slots=True)
class ShareOf:
    """A share of the probability that another model gives."""

    model: FailureModel
    """That of the whole figure."""
    share: float
    """From 0 to 1."""
    parameter: str
    """The parameter of the whole figure."""

    def probability(self, mission_time_h: float) -> Probability:
        """Return the share of the model's probability over the mission, [h]."""
        return _share(self.model.probability(mission_time_h), self.share)


@dataclass(frozen=True, slots=True)
class CommonCauseTree:
    """A fault tree whose common cause groups are expanded."""

    tree: FaultTree
    """The expanded tree."""
    shares: Mapping[str, tuple[str, float]] = field(default_factory=dict)
    """Parameter and share of it, (whole, share), by parameter that the expansion added."""

    def values(self, values: Mapping[str, float]) -> dict[str, float]:
        """Return the values of the tree's parameters from those before the expansion.

        Raises ModelError when a parameter has no value or one outside [0, 1].
        """
        table = {name: values[name] for name in self.tree.parameters if name in values}
        for name, (whole, share) in self.shares.items():
            if whole not in values:
                raise ModelError(f"parameter '{whole}' has no value; {one_of(values, whole)}")
            table[name] = value_of(_share(pair_of(values[whole]), share))
        return table


def expand_common_cause(tree: FaultTree, groups: Sequence[CommonCauseGroup]) -> CommonCauseTree:
    """Replace the members of each group by ORs over the events that hit them.

    The event that hits `a` and `b` together is named `[a b]`; those that hit k of the n members
    of the group share the parameter `<parameter> {k of n}`, and the model's share where the members
    have a model. A gate takes the name of the member.
    As in the sources, the events that hit one member are independent, so that the OR of them is
    less than the member's Q by their products.
    Raises ModelError when a member is no event of the tree, belongs to two groups or has another
    parameter than the rest of its group.
    """
    events = {event.name: event for event in tree.events}
    owners: dict[str, str] = {}
    shares: dict[str, tuple[str, float]] = {}
    gates: list[Gate] = list(tree.gates)
    added: list[BasicEvent] = []
    for group in groups:
        like = _like_members(group, events, owners)
        hitting: dict[str, list[str]] = {member: [] for member in group.members}
        for level, share in sorted(group.shares.items()):
            parameter = f"{like.parameter} {{{level} of {len(group.members)}}}"
            if shares.setdefault(parameter, (like.parameter, share))[1] != share:
                parameter = f"{like.parameter} {{{level} of {len(group.members)}, {group.name}}}"
                shares[parameter] = (like.parameter, share)
            model = None if like.model is None else _share_of(like, like.model, share)
            for hit in combinations(group.members, level):
                name = f"[{' '.join(hit)}]"
                added.append(BasicEvent(name, parameter, model))
                for member in hit:
                    hitting[member].append(name)
        gates += [Gate(name, GateKind.OR, tuple(hits)) for name, hits in hitting.items()]
    kept = [event for event in tree.events if event.name not in owners]
    expanded = FaultTree(tree.top, tuple(gates), (*kept, *added), tree.houses)
    return CommonCauseTree(expanded, shares)


def _share(pair: Probability, share: float) -> Probability:
    return Probability(share * pair.p, (1.0 - share) + share * pair.q)


def _share_of(event: BasicEvent, model: FailureModel, share: float) -> FailureModel:
    """Return a share of an event's model; of a constant one that needs no mission either."""
    if isinstance(model, Constant):
        return Constant(share * model.p)
    return ShareOf(model, share, event.parameter)


def _like_members(
    group: CommonCauseGroup, events: Mapping[str, BasicEvent], owners: dict[str, str]
) -> BasicEvent:
    """Return the first member, once all of them are known to be like it and in no other group."""
    where = f"common cause group '{group.name}'"
    for member in group.members:
        if member not in events:
            raise ModelError(
                f"{where}: member '{member}' is not a basic event; {one_of(events, member)}"
            )
        if member in owners:
            raise ModelError(
                f"{where}: member '{member}' is in group '{owners[member]}' too; keep it in one "
                "of them"
            )
        owners[member] = group.name
    first = events[group.members[0]]
    for member in group.members[1:]:
        if events[member].parameter != first.parameter:
            raise ModelError(
                f"{where}: members '{first.name}' and '{member}' have the parameters "
                f"'{first.parameter}' and '{events[member].parameter}'; give all members the "
                "same parameter"
            )
    return first
