"""Which parts of its path every mission passes, and which of them have certain visit counts.

Two groups whose functions lie on parts of the path that do not know of each other are independent.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from tracerisk.common.strong_components import joined_parts, strong_components
from tracerisk.prm.hybrid.fixed_cycles import Loop, Passage
from tracerisk.prm.hybrid.groups.group_chain import Group
from tracerisk.prm.hybrid.hidden.hidden_states import HiddenStates


class Block(NamedTuple):
    """Groups that share parts of the path, independent of all other blocks."""

    groups: tuple[int, ...]
    """Numbers of the groups, in ascending order."""
    is_certain: bool
    """Whether it is certain how often each part is visited: the groups then fail independently."""


def blocks_of(
    states: HiddenStates, groups: Sequence[Group], passage: Passage | None
) -> tuple[Block, ...]:
    """Return blocks of groups that are independent of each other.

    `passage` is what each mission passes, where its loops go round as often as was counted.
    """
    segments = _segments(states) if passage is None else _passed(passage)
    segment_of = {number: s for s, (numbers, _) in enumerate(segments) for number in numbers}
    group_of = {c: number for number, group in enumerate(groups) for c in group}
    used: list[set[int]] = [set() for _ in groups]
    for number, function in enumerate(states.functions):
        for part in function.parts:
            used[group_of[part.classes[0]]].add(segment_of[number])
    return tuple(
        Block(tuple(sorted(members)), all(segments[index][1] for index in own))
        for own, members in joined_parts((own, [number]) for number, own in enumerate(used))
    )


Segment = tuple[frozenset[int], bool]
"""Functions of a part of the path, and whether it is certain which are visited how often."""


def _segments(states: HiddenStates) -> list[Segment]:
    """Return the parts that each mission passes one after the other, entered at one function.

    With the loops in the order of the path, a new part begins at a loop that no earlier step skips.
    """
    following = {
        number: [target for target, _ in function.steps]
        for number, function in enumerate(states.functions)
    }
    components = strong_components({states.entry: following[states.entry], **following})[::-1]
    place = {number: i for i, component in enumerate(components) for number in component}
    heads = _heads(components, place, following)
    pairs: list[tuple[set[int], bool]] = []
    farthest = 0
    for i, component in enumerate(components):
        if farthest <= i and len(heads.get(i, {states.entry})) == 1:
            pairs.append((set(), True))
        numbers, is_certain = pairs[-1]
        is_plain = len(component) == 1 and component[0] not in following[component[0]]
        pairs[-1] = numbers | set(component), is_certain and is_plain and not numbers
        for number in component:
            # A mission that may end here passes nothing else in any case.
            ends = states.functions[number].done > 0.0
            reached = (place[target] for target in following[number])
            farthest = len(components) if ends else max(farthest, *reached)
    return [(frozenset(numbers), is_certain) for numbers, is_certain in pairs]


def _heads(
    components: Sequence[Sequence[int]],
    place: Mapping[int, int],
    following: Mapping[int, Iterable[int]],
) -> dict[int, set[int]]:
    """Return the functions at which each component is entered from others."""
    heads: dict[int, set[int]] = {}
    for i, component in enumerate(components):
        for number in component:
            for target in following[number]:
                if place[target] != i:
                    heads.setdefault(place[target], set()).add(target)
    return heads


def _passed(passage: Passage) -> list[Segment]:
    return [
        (frozenset([item]), True)
        if isinstance(item, int)
        else (item.round.functions, _is_certain(item))
        for item in passage
    ]


def _is_certain(loop: Loop) -> bool:
    return loop.body is not None and all(
        isinstance(item, int) or _is_certain(item) for item in loop.body
    )
