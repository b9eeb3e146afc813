"""A layered layout of directed graphs: where each node stands, and how each edge runs.

The four steps of K. Sugiyama, S. Tagawa, M. Toda, "Methods for visual understanding of
hierarchical system structures", IEEE Transactions on Systems, Man, and Cybernetics 11 (1981):
edges that close cycles are turned, nodes are put on layers by their longest way from a source,
layers are ordered by barycentres, and nodes are drawn towards their neighbours.
"""

from __future__ import annotations

from bisect import bisect_right, insort
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

Edge = tuple[str, str]
_SWEEPS = 8


@dataclass(frozen=True, slots=True)
class Size:
    """The size of a node."""

    width: float
    """Horizontal extent [px]."""
    height: float
    """Vertical extent [px]."""


@dataclass(frozen=True, slots=True)
class Layout:
    """A graph laid out: places of nodes and edges, from the upper left corner (0, 0)."""

    centres: Mapping[str, tuple[float, float]]
    """Centre (x, y) of each node by name [px]."""
    ways: Mapping[Edge, tuple[tuple[float, float], ...]]
    """Polyline ((x, y), ...) of each edge by (source, target), from source to target [px]."""
    width: float
    """Horizontal extent of the whole drawing [px]."""
    height: float
    """Vertical extent of the whole drawing [px]."""


def layered(
    nodes: Mapping[str, Size], edges: Iterable[Edge], *, gap: float = 18.0, between: float = 46.0
) -> Layout:
    """Lay a graph out from the top down, `gap` between nodes and `between` layers, [px].

    Edges from a node to itself are left out.
    """
    given = [edge for edge in dict.fromkeys(edges) if edge[0] != edge[1]]
    turned = _back_edges(nodes, given)
    downward = [(b, a) if (a, b) in turned else (a, b) for a, b in given]
    rank = _ranks(nodes, downward)
    # A node of an edge that spans layers stands in each of those between; its name is a tuple.
    chains: dict[Edge, list[object]] = {}
    layers: list[list[object]] = [[] for _ in range(max(rank.values(), default=-1) + 1)]
    for name in _walked(nodes, downward):
        layers[rank[name]].append(name)
    below: dict[object, list[object]] = {}
    above: dict[object, list[object]] = {}
    for a, b in dict.fromkeys(downward):
        chain: list[object] = [a]
        for layer in range(rank[a] + 1, rank[b]):
            chain.append((a, b, layer))
            layers[layer].append((a, b, layer))
        chain.append(b)
        chains[a, b] = chain
        for upper, lower in pairwise(chain):
            below.setdefault(upper, []).append(lower)
            above.setdefault(lower, []).append(upper)
    _order(layers, above, below)
    widths = {
        node: nodes[node].width if isinstance(node, str) else 0.0 for row in layers for node in row
    }
    x = _columns(layers, above, below, widths, gap)
    heights = [
        max((nodes[node].height for node in row if isinstance(node, str)), default=0.0)
        for row in layers
    ]
    y: list[float] = []
    reached = 0.0
    for height in heights:
        y.append(reached + height / 2)
        reached += height + between
    place = {node: (x[node], y[layer]) for layer, row in enumerate(layers) for node in row}
    ways = {}
    for a, b in given:
        first, *inner, last = chains[a, b] if (a, b) in chains else chains[b, a]
        way = [place[first]]
        for layer, node in enumerate(inner, rank[str(first)] + 1):
            way += [
                (x[node], y[layer] - heights[layer] / 2),
                (x[node], y[layer] + heights[layer] / 2),
            ]
        way.append(place[last])
        ways[a, b] = tuple(way if (a, b) not in turned else reversed(way))
    return Layout(
        {name: place[name] for name in nodes},
        ways,
        max((x[node] + widths[node] / 2 for node in x), default=0.0),
        max(reached - between, 0.0),
    )


def _back_edges(nodes: Iterable[str], edges: Sequence[Edge]) -> set[Edge]:
    """Return the edges that close a cycle in a depth-first walk; they are drawn reversed."""
    following: dict[str, list[str]] = {}
    for a, b in edges:
        following.setdefault(a, []).append(b)
    turned: set[Edge] = set()
    done: set[str] = set()
    for root in nodes:
        stack = [(root, iter(following.get(root, ())))] if root not in done else []
        open_nodes = {root}
        while stack:
            name, rest = stack[-1]
            target = next(rest, None)
            if target is None:
                stack.pop()
                open_nodes.discard(name)
                done.add(name)
            elif target in open_nodes:
                turned.add((name, target))
            elif target not in done:
                open_nodes.add(target)
                stack.append((target, iter(following.get(target, ()))))
    return turned


def _ranks(nodes: Iterable[str], edges: Sequence[Edge]) -> dict[str, int]:
    """Return the length of the longest way from a source to each node."""
    following: dict[str, list[str]] = {}
    waiting = dict.fromkeys(nodes, 0)
    for a, b in dict.fromkeys(edges):
        following.setdefault(a, []).append(b)
        waiting[b] += 1
    rank = dict.fromkeys(waiting, 0)
    free = [name for name, count in waiting.items() if count == 0]
    for name in free:
        for target in following.get(name, ()):
            rank[target] = max(rank[target], rank[name] + 1)
            waiting[target] -= 1
            if waiting[target] == 0:
                free.append(target)
    return rank


def _walked(nodes: Iterable[str], edges: Sequence[Edge]) -> list[str]:
    """Return the nodes as a walk in depth meets them, children in their order."""
    following: dict[str, list[str]] = {}
    for a, b in edges:
        following.setdefault(a, []).append(b)
    targets = {b for _, b in edges}
    met: dict[str, None] = {}
    stack = [name for name in reversed(list(nodes)) if name not in targets]
    while stack:
        name = stack.pop()
        if name not in met:
            met[name] = None
            stack.extend(reversed(following.get(name, ())))
    return list(met)


def _order(
    layers: list[list[object]],
    above: Mapping[object, Sequence[object]],
    below: Mapping[object, Sequence[object]],
) -> None:
    """Sort each layer by the mean place of its neighbours, downwards and upwards in turn.

    The order with the fewest crossings stays, of several the first.
    """
    best, least = [list(row) for row in layers], _crossings(layers, below)
    for sweep in range(_SWEEPS):
        if not least:
            break
        downwards = sweep % 2 == 0
        neighbours = above if downwards else below
        place: dict[object, float] = {}
        for row in layers if downwards else reversed(layers):
            own = {node: at / len(row) for at, node in enumerate(row)}
            mean = {
                node: _mean([place[other] for other in neighbours.get(node, ())], own[node])
                for node in row
            }
            row.sort(key=mean.__getitem__)
            place = {node: at / len(row) for at, node in enumerate(row)}
        crossings = _crossings(layers, below)
        if crossings < least:
            best, least = [list(row) for row in layers], crossings
    layers[:] = best


def _crossings(layers: Sequence[Sequence[object]], below: Mapping[object, Sequence[object]]) -> int:
    """Return how many lines between neighbouring layers cross: inversions, by insertion."""
    total = 0
    for upper, lower in pairwise(layers):
        place = {node: at for at, node in enumerate(lower)}
        seen: list[int] = []
        for node in upper:
            ends = sorted(place[other] for other in below.get(node, ()))
            total += sum(len(seen) - bisect_right(seen, end) for end in ends)
            for end in ends:
                insort(seen, end)
    return total


def _columns(
    layers: Sequence[Sequence[object]],
    above: Mapping[object, Sequence[object]],
    below: Mapping[object, Sequence[object]],
    widths: Mapping[object, float],
    gap: float,
) -> dict[object, float]:
    """Return where each node stands across: near its neighbours, none over another."""
    x: dict[object, float] = {}
    for row in layers:
        _spread(row, [0.0] * len(row), widths, gap, x)
    for sweep in range(_SWEEPS):
        downwards = sweep % 2 == 0
        neighbours = above if downwards else below
        for row in layers if downwards else list(reversed(layers)):
            wanted = [
                _mean([x[other] for other in neighbours.get(node, ())], x[node]) for node in row
            ]
            _spread(row, wanted, widths, gap, x)
    left = min((x[node] - widths[node] / 2 for node in x), default=0.0)
    return {node: at - left for node, at in x.items()}


def _spread(
    row: Sequence[object],
    wanted: Sequence[float],
    widths: Mapping[object, float],
    gap: float,
    x: dict[object, float],
) -> None:
    """Place the nodes of a layer in their order, as near as can be to where they should be.

    Least squares of the displacements under minimum distances, by pool adjacent violators.
    """
    offsets: list[float] = []
    reached = 0.0
    for rank, node in enumerate(row):
        if rank:
            reached += (widths[row[rank - 1]] + widths[node]) / 2 + gap
        offsets.append(reached)
    pools: list[tuple[float, int]] = []
    for want, offset in zip(wanted, offsets, strict=True):
        mean, count = want - offset, 1
        while pools and pools[-1][0] > mean:
            other, more = pools.pop()
            mean = (mean * count + other * more) / (count + more)
            count += more
        pools.append((mean, count))
    at = 0
    for mean, count in pools:
        for _ in range(count):
            x[row[at]] = mean + offsets[at]
            at += 1


def _mean(values: Sequence[float], default: float) -> float:
    return sum(values) / len(values) if values else default
