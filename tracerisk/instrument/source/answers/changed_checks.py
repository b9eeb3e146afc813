"""Which answers a later version of a controller no longer looks at, and which it newly does."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from tracerisk.common.text.near_names import is_respelt
from tracerisk.errors import Location
from tracerisk.instrument.source.answers.looked_at import LookedAt, looked_at

_NONE = LookedAt()


class ChangedCheck(NamedTuple):
    """An answer that a function looks at in one version and not in the other."""

    is_lost: bool
    """Whether the later version no longer looks at it; else it newly does."""
    function: str
    """The qualified name of the function that looks at it."""
    answer: str
    """The answer in words, such as "`ret` of /arm/move"."""
    location: Location
    """Where it is looked at: in the earlier version if it is lost."""


def changed_checks(
    before: Mapping[str, bytes], after: Mapping[str, bytes], renamed: Mapping[str, str]
) -> tuple[ChangedCheck, ...]:
    """Return the checks of answers that are lost, then those that are new.

    A check that moved to a caller, to a function called, or to a new function is neither; nor is
    one of a service whose name was corrected. `renamed` gives the later name of functions by their
    earlier one.
    """
    new = looked_at(after)
    old = _with_corrected_names(looked_at(before), new)
    back = {now: was for was, now in renamed.items()}
    return (*_only_in(old, new, renamed, is_lost=True), *_only_in(new, old, back, is_lost=False))


def _with_corrected_names(
    old: Mapping[str, LookedAt], new: Mapping[str, LookedAt]
) -> Mapping[str, LookedAt]:
    """Return what functions look at, each answer by its later name where that was corrected."""
    was, now = (
        {name for here in version.values() for name in here.calls} for version in (old, new)
    )
    pairs = [
        (one, two) for one in sorted(was - now) for two in sorted(now - was) if is_respelt(one, two)
    ]
    ends = [name for pair in pairs for name in pair]
    names = {one: two for one, two in pairs if ends.count(one) == ends.count(two) == 1}
    if not names:
        return old

    def later(of: str) -> str:
        return names.get(of, of)

    return {
        name: LookedAt(
            {(later(of), part): places for (of, part), places in here.checks.items()},
            {(later(of), part): lines for (of, part), lines in here.asked.items()},
            {later(of): lines for of, lines in here.calls.items()},
            {later(of) for of in here.used},
            here.own_calls,
        )
        for name, here in old.items()
    }


def _only_in(
    one: Mapping[str, LookedAt],
    other: Mapping[str, LookedAt],
    renamed: Mapping[str, str],
    *,
    is_lost: bool,
) -> Iterator[ChangedCheck]:
    known = {renamed.get(name, name) for name in one}
    moved = set().union(*(here.checks for name, here in other.items() if name not in known))
    for name, here in one.items():
        counterpart = renamed.get(name, name)
        there = other.get(counterpart, _NONE)
        for key in sorted(here.checks):
            answer, part = key
            words = _words(answer, part)
            file, line = min(here.checks[key])
            if not _is_covered(other, counterpart, key) and key not in moved:
                yield ChangedCheck(is_lost, name, words, Location(file, line))
                continue
            asked, still = here.asked[key], there.asked.get(key, set())
            dropped = [
                len(version.calls.get(answer, ())) - len(calls)
                for version, calls in ((here, asked), (there, still))
            ]
            if still and len(still) < len(asked) and dropped[1] > dropped[0]:
                words += f" in {len(asked) - len(still)} of {len(asked)} calls"
                yield ChangedCheck(is_lost, name, words, Location(file, line))


def _is_covered(version: Mapping[str, LookedAt], name: str, key: tuple[str, str]) -> bool:
    """Return whether a function, one that it calls, or each of its callers looks at an answer."""
    if name not in version:
        return any(key in here.checks for here in version.values())
    seen: set[str] = set()
    ahead = [name]
    while ahead:
        here = ahead.pop()
        if here in seen or here not in version:
            continue
        seen.add(here)
        if key in version[here].checks or (here == name and key[0] in version[here].used):
            return True
        ahead += version[here].own_calls
    callers = [here for here in version.values() if name in here.own_calls]
    return bool(callers) and all(key in here.checks for here in callers)


def _words(answer: str, part: str) -> str:
    if part.endswith("is None"):
        return f"whether {answer} answers at all"
    return f"`{part}` of {answer}" if part else f"the answer of {answer}"
