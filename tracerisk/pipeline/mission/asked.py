"""What `success` of a later version asks less, and newly, than that of an earlier one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from tracerisk.ros.scenario.success import COUNTED, Condition


def asked_less(old: Sequence[Condition], new: Sequence[Condition]) -> tuple[str, ...]:
    """Return what `old` asks and `new` does not, in words, with what `new` asks of the same."""
    lines = []
    for condition in _not_implied(old, new):
        now = [_words(later) for later in new if _subject(later) == _subject(condition)]
        lines.append(_words(condition) + (f"; now: {', '.join(now)}" if now else ""))
    return tuple(dict.fromkeys(lines))


def asked_newly(old: Sequence[Condition], new: Sequence[Condition]) -> tuple[str, ...]:
    """Return what `new` asks and `old` did not, in words, but for what stands in `asked_less`."""
    less = set(map(_subject, _not_implied(old, new)))
    newly = (later for later in _not_implied(new, old) if _subject(later) not in less)
    return tuple(dict.fromkeys(map(_words, newly)))


def _not_implied(conditions: Sequence[Condition], others: Sequence[Condition]) -> list[Condition]:
    """Return the conditions that a mission may miss although it meets all the others."""
    return [
        condition
        for condition in conditions
        if not any(_implies(other, condition) for other in others)
    ]


def _subject(condition: Condition) -> tuple[str, str]:
    return condition.kind, condition.name


def _words(condition: Condition) -> str:
    return condition.words + (" (assumed: nobody has confirmed it)" if condition.is_assumed else "")


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
