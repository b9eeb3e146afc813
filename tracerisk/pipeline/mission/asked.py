"""What `success` of a later version asks less, and newly, than that of an earlier one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from tracerisk.ros.scenario.success import COUNTED, Condition


class AskedChange(NamedTuple):
    """What a later version asks in place of what an earlier one does, in words."""

    less: tuple[str, ...] = ()
    """What the earlier one asks and the later one does not, with what that asks of the same; what
    it does not ask at all comes first."""
    otherwise: tuple[str, ...] = ()
    """What the later one asks in place of what the earlier one does, no less of it."""
    newly: tuple[str, ...] = ()
    """What the later one asks and the earlier one did not, but for the others."""


def asked_change(old: Sequence[Condition], new: Sequence[Condition]) -> AskedChange:
    """Return how what `new` asks differs from what `old` does."""
    gone, looser, otherwise, known = [], [], [], []
    for condition in _not_implied(old, new):
        now, was = _instead(condition, old, new), _words(condition)
        known += now
        others = [later for later in now if _is_another(later, condition)]
        otherwise += [
            f"{_words(later)}; before: {_what_differs(_words(later), was)}" for later in others
        ]
        if not now:
            gone.append(was)
        elif not others:
            words = ", ".join(_what_differs(was, _words(later)) for later in now)
            looser.append(f"{was}; now: {words}")
    newly = [_words(later) for later in _not_implied(new, old) if later not in known]
    less = dict.fromkeys((*gone, *looser))
    return AskedChange(tuple(less), tuple(dict.fromkeys(otherwise)), tuple(dict.fromkeys(newly)))


def _instead(
    condition: Condition, old: Sequence[Condition], new: Sequence[Condition]
) -> list[Condition]:
    """Return the new conditions that judge the same thing by the same measure."""
    return [
        later
        for later in _not_implied(new, [one for one in old if one != condition])
        if (later.kind, later.name) == (condition.kind, condition.name)
        and (_measures(later) & _measures(condition) or not _measures(condition))
    ]


def _measures(condition: Condition) -> set[str]:
    """Return by which measures an object or a link is judged; none for all other conditions."""
    if condition.kind not in ("object", "link"):
        return set()
    if condition.is_at_goal:
        return {"goal"}
    said = {"at": condition.at, "moved": condition.moved, "tilt": condition.tilt}
    texts = {"rests_on": condition.rests_on, "held_by": condition.held_by}
    return {name for name, value in said.items() if value is not None} | {
        name for name, text in texts.items() if text
    }


def _is_another(new: Condition, old: Condition) -> bool:
    """Return whether a condition asks for something else, and no less: a call more, exactly."""
    if old.kind not in COUNTED or not (old.is_exact and new.is_exact):
        return False
    return new.times > old.times and new.fields == old.fields and not new.is_assumed


def _not_implied(conditions: Sequence[Condition], others: Sequence[Condition]) -> list[Condition]:
    """Return the conditions that a mission may miss although it meets all the others."""
    return [
        condition
        for condition in conditions
        if not any(_implies(other, condition) for other in others)
    ]


def _words(condition: Condition) -> str:
    return condition.words + (" (assumed: nobody has confirmed it)" if condition.is_assumed else "")


def _what_differs(was: str, now: str) -> str:
    """Return the words of a condition that are not those of another, and one on either side.

    All words, where the one only goes on where the other ends.
    """
    old, new = was.split(" "), now.split(" ")
    shorter = min(len(old), len(new))
    head = next((n for n in range(shorter) if old[n] != new[n]), shorter)
    tail = next((n for n in range(shorter - head) if old[-1 - n] != new[-1 - n]), shorter - head)
    if head + tail >= shorter:
        return now
    return " ".join(new[max(head - 1, 0) : len(new) - max(tail - 1, 0)])


def _implies(new: Condition, old: Condition) -> bool:
    """Return whether a mission that meets the new condition meets the old one for certain."""
    if new.kind != old.kind or (new.is_assumed and not old.is_assumed):
        return False
    match old.kind:
        case "object" | "link":
            return new.name == old.name and _implies_place(new, old)
        case "joints" | "reached" | "passed":
            held = _holds(new.joints, old.joints) and _holds(new.links, old.links)
            return held and new.within <= old.within
        case "within_s":
            return new.seconds <= old.seconds
        case "steps":
            return len(new.steps) == len(old.steps) and all(map(_implies, new.steps, old.steps))
    assert old.kind in COUNTED, old.kind
    if new.name != old.name:
        return False
    if old.is_exact:
        return new.is_exact and new.times == old.times and new.fields == old.fields
    return new.times >= old.times and _holds(new.fields, old.fields)


def _implies_place(new: Condition, old: Condition) -> bool:
    if old.is_at_goal or new.is_at_goal:
        return old.is_at_goal and new.is_at_goal and new.within <= old.within
    if old.at is not None and ((new.at, new.of) != (old.at, old.of) or new.within > old.within):
        return False
    if old.moved is not None:
        # To be moved by more than a larger distance asks more; to stay within it asks less.
        is_as_far = new.within >= old.within if old.moved else new.within <= old.within
        if new.moved != old.moved or not is_as_far:
            return False
    if old.tilt is not None and (new.tilt is None or new.tilt > old.tilt):
        return False
    return old.rests_on in ("", new.rests_on) and old.held_by in ("", new.held_by)


def _holds(new: Mapping[str, Any], old: Mapping[str, Any]) -> bool:
    """Return whether all that the old one gives stands in the new one."""
    return all(name in new and new[name] == value for name, value in old.items())
