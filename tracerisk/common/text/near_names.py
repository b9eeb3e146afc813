"""Which known name another one is likely a slip of: `tool00` of `tool0`, `pand_link0` of a panda.

Names that differ in their number, or in a letter for a side or an axis, are other things.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable

_SHORTEST = 5  # a shorter name one edit apart may well be another
_LONG = 8  # a name of so many characters may have two slips
_SERIES = 3  # names that differ in their number alone: one beyond them is likely miscounted
_NUMBER = re.compile(r"\d+")
_PART = re.compile(r"[/_\-.]+")


def near_names(name: str, known: Iterable[str]) -> tuple[str, ...]:
    """Return those of the known names that a name is likely a slip of, sorted; () for none."""
    names = sorted(set(known))
    if not name or name in names:
        return ()
    stems = Counter(map(_stem, names))
    edits = {other: _edits(name, other) for other in names if other}
    near = [other for other, count in edits.items() if count <= _most(name, other)]
    same = [other for other in near if not _are_apart(name, other)]
    if not same and stems[_stem(name)] >= _SERIES:
        same = near
    least = min((edits[other] for other in same), default=0)
    return tuple(other for other in same if edits[other] == least)


def likely_meant(name: str, known: Iterable[str]) -> str:
    """Return in words which known names a name is likely a slip of; empty for none."""
    near = near_names(name, known)
    return f"likely a mistake for {' or '.join(near)}" if near else ""


def is_respelt(name: str, other: str) -> bool:
    """Return whether two names are one, spelt otherwise: `/set_griper` and `/set_gripper`.

    Each word that differs is a slip of the other one, and begins as that does: words for opposites
    (`attach`, `detach`) begin otherwise.
    """
    if name == other:
        return False
    if _plain(name) == _plain(other):
        return True
    differing = _differing_parts(name, other)
    return differing is not None and all(
        one[:1] == two[:1] and near_names(one, [two]) for one, two in differing
    )


def _most(name: str, other: str) -> int:
    """Return how many edits lie at most between a name and what it is a slip of."""
    if _plain(name) == _plain(other):
        return len(name)
    shortest = min(len(name), len(other))
    return 0 if shortest < _SHORTEST else 1 if shortest < _LONG else 2


def _are_apart(name: str, other: str) -> bool:
    """Return whether two names are those of different things, by their number or a short part."""
    numbers = [[int(digits) for digits in _NUMBER.findall(text)] for text in (name, other)]
    if numbers[0] != numbers[1]:
        return True
    differing = _differing_parts(name, other) or ()
    return any(max(map(len, pair)) <= 2 for pair in differing)  # l and r, x and y


def _differing_parts(name: str, other: str) -> list[tuple[str, str]] | None:
    """Return the parts in which two names differ; `None` where one has more parts."""
    ours, theirs = _PART.split(name), _PART.split(other)
    if len(ours) != len(theirs):
        return None
    return [pair for pair in zip(ours, theirs, strict=True) if pair[0] != pair[1]]


def _stem(name: str) -> str:
    return _NUMBER.sub("#", name)


def _plain(name: str) -> str:
    return _PART.sub("", name).lower()


def _edits(one: str, other: str) -> int:
    """Return how many characters are to be put in, left out, changed or swapped with the next."""
    if abs(len(one) - len(other)) > 2:  # no more are asked for
        return len(one) + len(other)
    before: list[int] = []
    row = list(range(len(other) + 1))
    for i, a in enumerate(one, 1):
        earlier, before = before, row
        row = [i]
        for j, b in enumerate(other, 1):
            best = min(before[j] + 1, row[-1] + 1, before[j - 1] + (a != b))
            if i > 1 and j > 1 and a == other[j - 2] and one[i - 2] == b:
                best = min(best, earlier[j - 2] + 1)
            row.append(best)
    return row[-1]
