"""What a reviewer should see of the last run without running anything, as the lock keeps it.

Motions that never ran, and contacts that were not to be: which functions and bodies. Beside the
contacts stand those of a hand with what it grasps, for whether they were to be hangs on the time.
"""

from __future__ import annotations

import math
from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import TYPE_CHECKING, Any

from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.common.text.plain_data import MismatchError, read_plain
from tracerisk.common.traced.elements import GENTLE_N

if TYPE_CHECKING:
    from tracerisk.common.traced.elements import Contact
    from tracerisk.trace import Trace, Visit

_UNCOVERED, _CONTACTS, _TOUCHES = "uncovered", "unexpected_contacts", "touches"
_REPEATS = "repeats"
_LIVE_REPEATS = 0.03
"""How far exposures of two live runs differ, as a part of one (docs/ros.md#on-real-ros)."""
_MOST_REPEATS = 0.25  # of what differs by more, a diff speaks, whatever made it
_LIVE_MEETS_S = 0.3
"""How far the times differ in which nodes find each other, and end: five runs of a node of roscpp
whose commands took the same time to the step began 0.20 to 0.47 s after it, and ended within 0.08 s
of each other."""
_WHOLE_N = 10.0  # forces from here on are given in whole newtons
_OF_SUPPORT = (
    f"what a thing is lifted from or put on may bear {GENTLE_N:.0f} N and twice its weight"
)
_ALIKE = 0.2
"""The share by which two touches may differ in force and duration, and be the same."""
_ALIKE_S = 0.02
"""The time by which their durations may differ beside that [s]."""
_AT_ONCE_S = 0.2
"""How far apart the same touch may begin in two runs that do the same [s]."""


@dataclass(frozen=True, slots=True)
class Touches:
    """How two bodies touched in the visits of a function, expected or not."""

    number: int
    """How many contacts of visits they had."""
    force_n: float
    """The greatest normal force [N]."""
    touching_s: float
    """For how long they touched, over all visits [s]."""
    start_s: float
    """When they first touched, in simulated time [s]."""
    from_grasp_s: float | None = None
    """How long before (negative) or after the grasp of the other body [s]; `None` for no grasp."""

    @classmethod
    def of(cls, contacts: Iterable[Contact]) -> Touches:
        """Return how the two bodies of all of the contacts touched."""
        return cls.joined(
            cls(1, touch.force_n, touch.touching_s, touch.start_s, touch.from_grasp_s)
            for touch in contacts
        )

    @classmethod
    def joined(cls, parts: Iterable[Touches]) -> Touches:
        """Return touches of the same bodies as one."""
        each = tuple(parts)
        gaps = [gap for part in each if (gap := part.from_grasp_s) is not None]
        nearest = min(gaps, key=lambda gap: (abs(gap), gap), default=None)
        return cls(
            sum(part.number for part in each),
            float(f"{max(part.force_n for part in each):.3g}"),
            round(math.fsum(part.touching_s for part in each), 3),
            round(min(part.start_s for part in each), 3),
            None if nearest is None else round(nearest, 3),
        )

    def are_of_grasp_as(self, other: Touches) -> bool:
        """Return whether these are the touches of the other run, at most at another time.

        A hand that bumps into a thing and grasps it has one contact more than one that grasps it.
        """
        return (
            self.from_grasp_s is not None
            and self.number == other.number
            and math.isclose(self.force_n, other.force_n, rel_tol=_ALIKE)
            and math.isclose(self.touching_s, other.touching_s, rel_tol=_ALIKE, abs_tol=_ALIKE_S)
        )

    def are_cut_otherwise(self, other: Touches, part: Touches) -> bool:
        """Return whether all touches of two bodies are those of the other run: as hard, long, soon.

        They may be cut otherwise into functions, whose contacts are counted one by one: by as much
        as one function has now, the others have less.
        """
        less_s = other.touching_s - (self.touching_s - part.touching_s)
        return (
            math.isclose(less_s, part.touching_s, rel_tol=_ALIKE, abs_tol=_ALIKE_S)
            and math.isclose(self.force_n, other.force_n, rel_tol=_ALIKE)
            and math.isclose(self.touching_s, other.touching_s, rel_tol=_ALIKE, abs_tol=_ALIKE_S)
            and math.isclose(self.start_s, other.start_s, abs_tol=_AT_ONCE_S)
        )

    @property
    def words(self) -> str:
        """How hard, how long and when they touched, as in `up to 30 N, 0.04 s, at 6.1 s`."""
        force = f"up to {_newtons(self.force_n)} N, " if self.force_n else ""
        return f"{force}{self.touching_s:.2f} s, at {self.start_s:.1f} s{grasp_text(self)}"


@dataclass(frozen=True, slots=True, order=True)
class UnexpectedContact:
    """An unexpected contact in a function."""

    function: FunctionRef
    """The function whose visit had the contact."""
    link: str
    """The link, or the thing held."""
    other: str
    """The body that it touched."""
    touches: Touches | None = field(default=None, compare=False)
    """How they touched; `None` where the lock does not say so."""

    @property
    def bodies(self) -> str:
        """The two bodies in words, which distinguish the contacts of one function."""
        return f"{self.link} and {self.other}"

    @property
    def how(self) -> str:
        """How they touched, behind a colon; empty where the lock does not say so."""
        return "" if self.touches is None else f": {self.touches.words}"

    def __str__(self) -> str:
        place = self.function.name
        return f"{self.bodies} touched in {place}, which was not to be expected{self.how}"


def unexpected_contacts(visits: Iterable[Visit]) -> dict[UnexpectedContact, list[Contact]]:
    """Return the contacts of a run that were not to be expected, in the order of the visits."""
    contacts: dict[UnexpectedContact, list[Contact]] = {}
    for visit in visits:
        for contact in visit.contacts:
            if not contact.expected:
                pair = UnexpectedContact(visit.function, contact.link, contact.other)
                contacts.setdefault(pair, []).append(contact)
    return contacts


def contact_text(
    contact: UnexpectedContact, touches: Sequence[Contact], links: Container[str]
) -> str:
    """Return in words what touched, for how long and how hard; `links` are the arm's."""
    link, other, function = contact.link, contact.other, contact.function.name
    seconds = sum(touch.touching_s for touch in touches)
    visits = "" if len(touches) == 1 else f" in {len(touches)} visits"
    if other in links:
        return (
            f"{link} overlaps {other}, of the arm itself, in {function}: for {seconds:.2f} s"
            f"{visits}; its force is not simulated"
        )
    force = max(touch.force_n for touch in touches)
    text = f"up to {_newtons(force)} N, {seconds:.2f} s{visits}"
    if link in links:
        gap = grasp_text(Touches.of(touches))
        return f"{link} touches {other} in {function}: {text}{gap}"
    why = f"; {_OF_SUPPORT}" if force > GENTLE_N else ""
    return f"{link}, which is held, touches {other} in {function}: {text}{why}"


def grasp_text(touches: Touches) -> str:
    """Return how far from the grasp of the other body touches were; empty where it has none."""
    gap = touches.from_grasp_s
    if gap is None:
        return ""
    return f", {abs(gap):.1f} s {'before' if gap < 0.0 else 'after'} it is held"


def _newtons(force: float) -> str:
    return f"{force:.0f}" if force >= _WHOLE_N else f"{force:.2g}"


def last_run_summary(trace: Trace) -> dict[str, Any]:
    """Return what the lock keeps, sorted; nothing where there is nothing to see.

    By file the names of the functions that never ran, and by file and function the pairs of
    bodies that touched, and how they did.
    """
    uncovered: dict[str, list[str]] = {}
    for ref in sorted({item.ref for item in trace.uncovered}):
        uncovered.setdefault(ref.file, []).append(ref.name)
    contacts: dict[str, dict[str, list[list[str]]]] = {}
    for unexpected_contact in sorted(unexpected_contacts(trace.visits)):
        functions = contacts.setdefault(unexpected_contact.function.file, {})
        functions.setdefault(unexpected_contact.function.name, []).append(
            [unexpected_contact.link, unexpected_contact.other]
        )
    touches: dict[str, dict[str, dict[str, Any]]] = {}
    for pair, own in sorted(_told(trace.visits).items()):
        functions_of = touches.setdefault(pair.function.file, {})
        functions_of.setdefault(pair.function.name, {}).setdefault(pair.link, {})[pair.other] = {
            _kind(expected): _as_kept(Touches.of(c for c in own if c.expected == expected))
            for expected in sorted({contact.expected for contact in own})
        }
    table = {_UNCOVERED: uncovered, _CONTACTS: contacts, _TOUCHES: touches}
    return {key: value for key, value in table.items() if value}


def _told(visits: Iterable[Visit]) -> dict[UnexpectedContact, list[Contact]]:
    """Return the contacts, by function and bodies, of which any was unexpected or of a grasp."""
    contacts: dict[UnexpectedContact, list[Contact]] = {}
    for visit in visits:
        for contact in visit.contacts:
            pair = UnexpectedContact(visit.function, contact.link, contact.other)
            contacts.setdefault(pair, []).append(contact)
    return {
        pair: own
        for pair, own in contacts.items()
        if any(not contact.expected or contact.from_grasp_s is not None for contact in own)
    }


def kept_touches(
    summary: Mapping[str, Any], contact: UnexpectedContact
) -> tuple[Touches | None, Touches | None]:
    """Return how two bodies touched by the lock's summary: all they did, and what was unexpected.

    `None` stands for what it does not say.
    """
    value: Any = summary.get(_TOUCHES)
    for key in (contact.function.file, contact.function.name, contact.link, contact.other):
        value = _mapping(value).get(key)
    try:
        kept = {kind: read_plain(Touches, part) for kind, part in _mapping(value).items()}
    except MismatchError:
        return None, None
    return Touches.joined(kept.values()) if kept else None, kept.get(_kind(expected=False))


def _kind(expected: bool) -> str:
    return "expected" if expected else "unexpected"


def _as_kept(touches: Touches) -> dict[str, Any]:
    return {key: value for key, value in asdict(touches).items() if value is not None}


def repeats_summary(trace: Trace, visits: Sequence[Visit]) -> dict[str, Any]:
    """Return how far, relatively, the time of a function's visits repeats; nothing where it does.

    Live runs differ most before their first command and after their last.
    """
    lasting_s = math.fsum(visit.duration_s or 0.0 for visit in visits)
    if not trace.is_live or not lasting_s:
        return {}
    is_at_an_end = trace.visits[0] in visits or trace.visits[-1] in visits
    repeats = _LIVE_REPEATS + (_LIVE_MEETS_S / lasting_s if is_at_an_end else 0.0)
    return {_REPEATS: round(min(repeats, _MOST_REPEATS), 4)}


def kept_repeats(summary: Mapping[str, Any], function: str) -> float:
    """Return how far, relatively, the lock says that a function of a live run repeats."""
    repeats = _mapping(_mapping(summary.get("functions")).get(function)).get(_REPEATS)
    return repeats if isinstance(repeats, float) and 0.0 < repeats <= _MOST_REPEATS else 0.0


def kept_uncovered(summary: Mapping[str, Any]) -> tuple[FunctionRef, ...]:
    """Return the functions of the lock's summary that can move the arm and never ran.

    What has another form than the tool gives it, as a lock edited by hand may have, is left out.
    """
    return tuple(
        FunctionRef(file, QualifiedName(name))
        for file, names in _mapping(summary.get(_UNCOVERED)).items()
        for name in _sequence(names)
        if isinstance(name, str)
    )


def kept_contacts(summary: Mapping[str, Any]) -> tuple[UnexpectedContact, ...]:
    """Return the unexpected contacts of the lock's summary, others left out as above."""
    contacts = (
        UnexpectedContact(FunctionRef(file, QualifiedName(name)), *pair)
        for file, functions in _mapping(summary.get(_CONTACTS)).items()
        for name, pairs in _mapping(functions).items()
        for pair in map(_sequence, _sequence(pairs))
        if [type(body) for body in pair] == [str, str]
    )
    return tuple(
        replace(contact, touches=kept_touches(summary, contact)[1]) for contact in contacts
    )


def _mapping(value: Any) -> Mapping[str, Any]:
    return value if isinstance(value, dict) else {}


def _sequence(value: Any) -> Sequence[Any]:
    return value if isinstance(value, list) else ()
