"""The loop of orders by FORCE, on flat sequences, as Python; `compiled/force.c` is the same."""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from tracerisk.prm.trees.bdd.kernel import Floats, Integers


def draw(
    rounds: int,
    offsets: Integers,
    members: Integers,
    place: Floats,
    best: Floats,
    counts: Integers,
    pairs: Floats,  # noqa: ARG001 - as the compiled loop takes it
) -> None:
    """Give the places of the best of some rounds, in which each group draws its members.

    A round puts each node at the mean of the places that its groups draw it to, which is their
    own mean; the best is the one with the least sum of the groups' spans.

    offsets, members: group i has the nodes `members[offsets[i]:offsets[i + 1]]`; each node is in
        one at least.
    place: (nodes,) in, where they stand before the first round; scratch.
    best: (nodes,) out, their ranks.
    counts: (nodes,) zeros, scratch; pairs: (2 nodes,) scratch of the compiled loop.
    """
    for node in members:
        counts[node] += 1
    _rank(place)
    least = -1.0
    for _ in range(rounds):
        drawn = [0.0] * len(place)
        span = 0.0
        for group in range(len(offsets) - 1):
            nodes = members[offsets[group] : offsets[group + 1]]
            places = [place[node] for node in nodes]
            span += max(places) - min(places)
            mean = sum(places) / len(places)
            for node in nodes:
                drawn[node] += mean
        if least < 0.0 or span < least:
            least = span
            best[:] = place
        place[:] = [sum_ / count for sum_, count in zip(drawn, counts, strict=True)]
        _rank(place)


def _rank(place: Floats) -> None:
    """Put each node's rank for its place; of two at one place the lesser node goes first."""
    for rank, node in enumerate(sorted(range(len(place)), key=place.__getitem__)):
        place[node] = float(rank)
