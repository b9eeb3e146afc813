"""What a reviewer should see of the last run without running anything, as the lock keeps it.

Motions that never ran, and contacts that were not to be: which functions and bodies, without
the times and forces that vary with every change.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from tracerisk.common.function_ref import FunctionRef, QualifiedName

if TYPE_CHECKING:
    from tracerisk.trace import Contact, Trace, Visit

_UNCOVERED, _CONTACTS = "uncovered", "unexpected_contacts"
_WHOLE_N = 10.0  # forces from here on are given in whole newtons


@dataclass(frozen=True, slots=True, order=True)
class UnexpectedContact:
    """An unexpected contact in a function."""

    function: FunctionRef
    """The function whose visit had the contact."""
    link: str
    """The link, or the thing held."""
    other: str
    """The body that it touched."""

    @property
    def bodies(self) -> str:
        """The two bodies in words, which distinguish the contacts of one function."""
        return f"{self.link} and {self.other}"

    def __str__(self) -> str:
        return f"{self.bodies} touched in {self.function.name}, which was not to be expected"


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
    text = f"{force:.0f}" if force >= _WHOLE_N else f"{force:.2g}"
    what = link if link in links else f"{link}, which is held,"
    return f"{what} touches {other} in {function}: up to {text} N, {seconds:.2f} s{visits}"


def last_run_summary(trace: Trace) -> dict[str, Any]:
    """Return what the lock keeps, sorted; nothing where there is nothing to see.

    By file the names of the functions that never ran, and by file and function the pairs of
    bodies that touched.
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
    table = {_UNCOVERED: uncovered, _CONTACTS: contacts}
    return {key: value for key, value in table.items() if value}


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
    return tuple(
        UnexpectedContact(FunctionRef(file, QualifiedName(name)), *pair)
        for file, functions in _mapping(summary.get(_CONTACTS)).items()
        for name, pairs in _mapping(functions).items()
        for pair in map(_sequence, _sequence(pairs))
        if [type(body) for body in pair] == [str, str]
    )


def _mapping(value: Any) -> Mapping[str, Any]:
    return value if isinstance(value, dict) else {}


def _sequence(value: Any) -> Sequence[Any]:
    return value if isinstance(value, list) else ()
