"""What follows a component's failures, as text: modes, and for each what becomes of the mission.

dead 3/4: stopped safely 1/2, unaware 1/2 | stuck 1/4: stopped safely in place 1
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple, TypeAlias

from tracerisk.adder.blocks.names import TARGET, WEIGHT, read_share

_KINDS = ("stopped safely", "stopped late", "unaware")
_MODE = re.compile(
    rf"(?P<name>[^\s!{{}}:;,|]+(?: [^\s!{{}}:;,|]+)*?) (?P<share>{WEIGHT}): (?P<rest>.+)", re.ASCII
)
_OUTCOME = re.compile(
    rf"(?:(?P<kind>{'|'.join(_KINDS)})|back to (?P<target>{TARGET}))"
    rf"(?: in (?P<shows_in>{TARGET}))? (?P<share>{WEIGHT})"
)
_LEAD = re.compile(r"\s*(?:->|mode\s*:?=)\s*(?::=\s*)?")
_NAMED = re.compile(rf"\b((?:to|in) )({TARGET})(?=(?: in {TARGET})? {WEIGHT}\s*(?:[,|!]|$))")
_ALLOWED = (
    "a mode with its share of the failures and what follows, such as "
    "`dead 3/4: stopped safely 1/2, unaware 1/2`; what may follow: `stopped safely`, "
    "`stopped late`, `unaware`, `back to FUNCTION`, each with ` in FUNCTION` where it shows "
    "later, and its share"
)


class FailureOutcome(NamedTuple):
    """What follows some failures of a mode."""

    kind: str
    """`stopped safely`, `stopped late`, `unaware`, or `back` to a function."""
    target: str
    """The function to which the mission goes back; empty for the other kinds."""
    shows_in: str
    """The later function in which the failure shows; empty where it shows at once."""
    share: Fraction
    """The share of the mode's failures."""


class FailureMode(NamedTuple):
    """One `mode` line."""

    name: str
    """The failure mode."""
    share: Fraction
    """The share of the component's failures in a visit."""
    outcomes: tuple[FailureOutcome, ...]
    """What follows, sorted; the shares sum to 1."""


FailureModes: TypeAlias = tuple[FailureMode, ...]


@lru_cache(maxsize=4096)
def read_failures(text: str) -> FailureModes:
    """Return the modes that `text` states, parted by bars.

    Raises:
        ValueError: if one is malformed or named twice, or shares do not sum up.
    """
    modes = tuple(_mode(part.strip()) for part in text.split(" | "))
    names = [mode.name for mode in modes]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ValueError(f"one line for each mode, and not two for {', '.join(twice)}")
    total = sum((mode.share for mode in modes), Fraction(0))
    if total > 1:
        raise ValueError(f"modes whose shares sum to 1 at most, and not to {total}")
    return modes


def _mode(text: str) -> FailureMode:
    matched = _MODE.fullmatch(text)
    if matched is None:
        raise ValueError(_ALLOWED)
    outcomes = [_outcome(part.strip()) for part in matched["rest"].split(",")]
    said = [outcome[:3] for outcome in outcomes]
    if len(set(said)) < len(said):
        raise ValueError("what follows a mode, each said once; add up the two shares")
    total = sum((outcome.share for outcome in outcomes), Fraction(0))
    if total != 1:
        raise ValueError(f"shares of what follows a mode that sum to 1, and not to {total}")
    return FailureMode(matched["name"], _share(matched["share"]), tuple(sorted(outcomes)))


def _outcome(text: str) -> FailureOutcome:
    matched = _OUTCOME.fullmatch(text)
    if matched is None:
        raise ValueError(_ALLOWED)
    return FailureOutcome(
        matched["kind"] or "back",
        matched["target"] or "",
        matched["shows_in"] or "",
        _share(matched["share"]),
    )


def _share(text: str) -> Fraction:
    share = read_share(text)
    if share is None:
        raise ValueError(_ALLOWED)
    return share


def are_close(one: FailureModes, other: FailureModes, tolerance: float) -> bool:
    """Return whether modes say the same, and each of their shares within a relative tolerance."""
    first, second = _flat(one), _flat(other)
    return first.keys() == second.keys() and all(
        abs(first[key] - second[key]) <= tolerance * first[key] for key in first
    )


def _flat(modes: FailureModes) -> dict[tuple[str, ...], Fraction]:
    return {
        (mode.name, *outcome[:3]): mode.share * outcome.share
        for mode in modes
        for outcome in mode.outcomes
    }


def failures_text(modes: FailureModes) -> str:
    """Return the text of modes, shares reduced, whatever their order: what two texts share."""
    return " | ".join(sorted(map(_mode_text, modes)))


def _mode_text(mode: FailureMode) -> str:
    said = []
    for outcome in mode.outcomes:
        words = f"back to {outcome.target}" if outcome.target else outcome.kind
        words += f" in {outcome.shows_in}" if outcome.shows_in else ""
        said.append(f"{words} {outcome.share}")
    return f"{mode.name} {mode.share}: {', '.join(said)}"


def with_renamed(modes: FailureModes, names: Mapping[str, str]) -> FailureModes:
    """Return modes with new names for functions, by the names that they have."""
    return tuple(
        mode._replace(
            outcomes=tuple(
                sorted(
                    outcome._replace(
                        target=names.get(outcome.target, outcome.target),
                        shows_in=names.get(outcome.shows_in, outcome.shows_in),
                    )
                    for outcome in mode.outcomes
                )
            )
        )
        for mode in modes
    )


def renamed_text(text: str, names: Mapping[str, str]) -> str:
    """Return the text of modes with new names for functions, all else as it is written."""
    return _NAMED.sub(lambda found: found[1] + names.get(found[2], found[2]), text)


def is_mode(text: str) -> bool:
    """Return whether a line begins that of a mode, in either form, whatever its shares."""
    lead = _LEAD.match(text)
    words = text.partition("!")[0].strip()
    return lead is not None and _MODE.fullmatch(words[len(lead[0].lstrip()) :]) is not None


def goes_on(text: str, *, is_open: bool) -> bool:
    """Return whether the next line goes on with the mode of this one, which ends with a comma.

    `is_open` says whether this line goes on with the one before.
    """
    return text.rstrip().endswith(",") and "!" not in text and (is_open or is_mode(text))
