"""The algebra of gates over independent inputs, on pairs (p, 1-p).

Of coherent gates every result is a sum of products of non-negative numbers, so that nothing
cancels.
The derivative of a gate that is not coherent can have either sign: there, and only there, two
sums of such products are subtracted.
"""

from __future__ import annotations

import enum
import operator
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate

from tracerisk.errors import ModelError
from tracerisk.prm.numbers.probability import Probability, at_least, counted, deciding


class GateKind(enum.Enum):
    """How a gate joins its inputs.

    ATLEAST happens when at least `k` of its inputs do, CARDINALITY when from `k` to `most` do;
    XOR when an odd number does; IFF when its two inputs both happen or both do not; IMPLY unless
    its first input happens without its second.
    INHIBIT is an AND whose last input is the enabling condition; TRANSFER hands on its one input,
    which may be the top of another tree.
    """

    OR = "or"
    AND = "and"
    ATLEAST = "atleast"
    CARDINALITY = "cardinality"
    NOT = "not"
    XOR = "xor"
    IFF = "iff"
    IMPLY = "imply"
    NAND = "nand"
    NOR = "nor"
    INHIBIT = "inhibit"
    TRANSFER = "transfer"

    __hash__ = object.__hash__  # in C; each kind is one object

    @property
    def is_coherent(self) -> bool:
        """Whether more failures below such a gate can only make it happen, never prevent it."""
        return self in _COHERENT


_COHERENT = frozenset(
    (GateKind.OR, GateKind.AND, GateKind.ATLEAST, GateKind.INHIBIT, GateKind.TRANSFER)
)
_ALL = frozenset((GateKind.AND, GateKind.NAND, GateKind.INHIBIT, GateKind.TRANSFER, GateKind.NOT))
_COMPLEMENTED = frozenset((GateKind.NOT, GateKind.NAND, GateKind.NOR))
_ANY_INPUTS = frozenset((GateKind.OR, GateKind.AND))
_ALLOWED_INPUTS = {
    GateKind.NOT: (1, 1),
    GateKind.TRANSFER: (1, 1),
    GateKind.IFF: (2, 2),
    GateKind.IMPLY: (2, 2),
    GateKind.INHIBIT: (2, 2),
    GateKind.XOR: (2, None),
    GateKind.OR: (0, None),
}


@dataclass(frozen=True, slots=True)
class Gate:
    """A gate over gates and events.

    An OR without inputs never happens: a function that uses no hardware.
    """

    name: str
    """Unique in the tree."""
    kind: GateKind
    """How the inputs are joined."""
    inputs: tuple[str, ...]
    """Names of the gates and events below it, in order; IMPLY and INHIBIT depend on the order."""
    k: int | None = None
    """Least number of inputs that must happen, of ATLEAST and CARDINALITY; else `None`."""
    most: int | None = None
    """Greatest number of inputs that may happen, of CARDINALITY; else `None`."""

    @property
    def threshold(self) -> int:
        """The least number of inputs that makes the gate, or what it complements, happen."""
        if self.k is not None:
            return self.k
        return len(self.inputs) if self.kind in _ALL else 1


def check_gate(gate: Gate) -> None:
    """Raise ModelError when a gate's inputs, `k` or `most` do not fit its kind."""
    count = len(gate.inputs)
    if count and gate.kind in _ANY_INPUTS and gate.k is None and gate.most is None:
        return
    least, greatest = _ALLOWED_INPUTS.get(gate.kind, (1, None))
    if count < least or (greatest is not None and count > greatest):
        allowed = f"{least} input{'' if least == 1 else 's'}"
        if least != greatest:
            allowed = f"at least {'one input' if least == 1 else allowed}"
        raise ModelError(f"gate '{gate.name}': {gate.kind.value} needs {allowed}, it has {count}")
    if gate.kind is GateKind.CARDINALITY:
        if gate.k is None or gate.most is None or not 0 <= gate.k <= gate.most <= count:
            raise ModelError(
                f"gate '{gate.name}': k is {gate.k} and most is {gate.most}; "
                f"allowed: 0 <= k <= most <= {count}"
            )
        return
    if gate.most is not None:
        raise ModelError(f"gate '{gate.name}': most is for cardinality only; leave it out")
    if gate.kind is not GateKind.ATLEAST:
        if gate.k is not None:
            raise ModelError(
                f"gate '{gate.name}': k is for atleast and cardinality only; leave it out"
            )
    elif gate.k is None or not 1 <= gate.k <= count:
        raise ModelError(f"gate '{gate.name}': k is {gate.k}; allowed: 1 to {count}")


def gate_probability(gate: Gate, inputs: Sequence[Probability]) -> Probability:
    """Return the probability of a gate over independent inputs, exact to rounding."""
    kind = gate.kind
    if kind is GateKind.XOR or kind is GateKind.IFF:
        odd = _odd(inputs)
        return odd if kind is GateKind.XOR else odd.complement
    if kind is GateKind.IMPLY:
        return at_least(1, (inputs[0].complement, inputs[1]))
    if kind is GateKind.CARDINALITY:
        return counted(gate.k or 0, gate.most or 0, inputs)
    joined = at_least(gate.threshold, inputs)
    return joined.complement if kind in _COMPLEMENTED else joined


def gate_shares(
    gate: Gate, before: Sequence[Probability], after: Sequence[Probability]
) -> tuple[float, ...]:
    """Return for each input how much the gate's probability changes per change of the input's.

    Input i stands beside those before it, with their probabilities from `before`, and those
    after it, from `after`: with both equal these are the partial derivatives; else the sum of
    share_i (before_i - after_i) is the exact difference of the gate's probability (a telescoping
    sum, own derivation).
    Those of coherent gates are probabilities; the others can be negative.
    """
    kind = gate.kind
    if kind.is_coherent:
        return deciding(gate.threshold, before, after)
    if kind in _COMPLEMENTED:
        return tuple(-share for share in deciding(gate.threshold, before, after))
    if kind is GateKind.IMPLY:
        first, second = deciding(
            1, (before[0].complement, before[1]), (after[0].complement, after[1])
        )
        return -first, second
    if kind is GateKind.CARDINALITY:
        least, most = gate.k or 0, gate.most or 0
        gained = deciding(least, before, after) if least else (0.0,) * len(before)
        lost = deciding(most + 1, before, after) if most < len(before) else (0.0,) * len(before)
        return tuple(more - less for more, less in zip(gained, lost, strict=True))
    # Even less odd counts of the others, which is the product of q - p over them.
    sign = 1.0 if kind is GateKind.XOR else -1.0
    heads = accumulate((pair.q - pair.p for pair in before[:-1]), operator.mul, initial=sign)
    tails = list(accumulate((pair.q - pair.p for pair in after[:0:-1]), operator.mul, initial=1.0))
    return tuple(head * tail for head, tail in zip(heads, reversed(tails), strict=True))


def swept(
    gates: Iterable[Gate],
    nodes: dict[str, Probability],
    of: Callable[[Probability], Probability] | None = None,
) -> dict[str, Probability]:
    """Add the pair of each gate to `nodes` and return them; `gates` are ordered from the leaves up.

    `of`, if given, is applied to each gate's pair.
    """
    for gate in gates:
        pair = gate_probability(gate, [nodes[name] for name in gate.inputs])
        nodes[gate.name] = pair if of is None else of(pair)
    return nodes


def slopes(gates: Sequence[Gate], top: str, nodes: Mapping[str, Probability]) -> dict[str, float]:
    """Return the derivative of the top by each node below it, where none feeds two gates.

    `gates` stand each below those that they feed.
    """
    weights = {top: 1.0}
    for gate in reversed(gates):
        inputs = [nodes[name] for name in gate.inputs]
        for name, share in zip(gate.inputs, gate_shares(gate, inputs, inputs), strict=True):
            weights[name] = weights[gate.name] * share
    return weights


def _odd(inputs: Sequence[Probability]) -> Probability:
    """Return the probability that an odd number of the independent inputs happens."""
    p, q = 0.0, 1.0
    for pair in inputs:
        p, q = p * pair.q + q * pair.p, p * pair.p + q * pair.q
    return Probability(p, q)
