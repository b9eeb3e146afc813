"""The parts of a dynamic tree that need a Markov model.

A part is all that stands below one gate, where nothing in it is an input of, or tied to, anything
outside: the rest of the tree then sees nothing of it but that gate. Such a gate dominates, in the
graph from the top downwards, all that is tied together in the part (T. Lengauer, R. Tarjan, "A fast
algorithm for finding dominators in a flowgraph", 1979, for the notion; on a graph without cycles
the dominators are found in one pass, as here).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from tracerisk.common.strong_components import reached
from tracerisk.prm.other_models.dynamic.elements import DynamicGate

if TYPE_CHECKING:
    from tracerisk.prm.other_models.dynamic.tree import DynamicTree


def find_groups(tree: DynamicTree) -> dict[str, tuple[str, ...]]:
    """Return the tops of the parts that need a Markov model, each with all that belongs to it.

    The parts are disjoint, and as small as they can be.
    """
    ties = tree.ties
    seeds: list[tuple[str, ...]] = [
        (gate.name,) for gate in tree.gates if isinstance(gate, DynamicGate)
    ]
    seeds += [tie.inputs for tie in ties]
    if not seeds:
        return {}
    inputs = {gate.name: gate.inputs for gate in tree.gates}
    above, depth = _dominators(tree, inputs)
    links = {name: list(below) for name, below in inputs.items()}
    for tie in ties:
        for name in tie.inputs:
            links.setdefault(name, []).extend(tie.inputs)
    for gate in tree.gates:
        if gate.name not in depth:
            # Tied to the tree from the side: the dominators do not see it.
            for name in gate.inputs:
                links.setdefault(name, []).append(gate.name)
    groups: dict[str, tuple[str, ...]] = {}
    for seed in seeds:
        if any(set(seed) <= {top, *members} for top, members in groups.items()):
            continue
        members: set[str] = set()
        top, grown = "", set(seed)
        while grown - members:
            members |= reached(grown, lambda name: links.get(name, ()))
            top = _dominator_of((name for name in sorted(members) if name in depth), above, depth)
            grown = {top}
        inside = {name: below for name, below in groups.items() if name in members}
        for name in inside:
            del groups[name]
        groups[top] = tuple(sorted(members - {top}))
    return groups


def _dominators(
    tree: DynamicTree, inputs: Mapping[str, tuple[str, ...]]
) -> tuple[dict[str, str], dict[str, int]]:
    """Return for each element below the top its immediate dominator, and its depth among them."""
    parents: dict[str, list[str]] = {}
    above = {tree.top: tree.top}
    depth = {tree.top: 0}
    reached = {tree.top}
    downwards = [gate.name for gate in reversed(tree.upwards)]
    for name in downwards:
        if name in reached:
            for child in inputs[name]:
                reached.add(child)
                parents.setdefault(child, []).append(name)
    order = [*downwards, *(event.name for event in tree.events)]
    for name in order:
        if name in reached and name != tree.top:
            above[name] = _dominator_of(parents[name], above, depth)
            depth[name] = depth[above[name]] + 1
    return above, depth


def _dominator_of(names: Iterable[str], above: Mapping[str, str], depth: Mapping[str, int]) -> str:
    """Return the lowest element that dominates all of the names."""
    dominator = ""
    for name in names:
        other = dominator or name
        while other != name:
            if depth[other] >= depth[name]:
                other = above[other]
            else:
                name = above[name]
        dominator = other
    return dominator
