"""Draft a scenario: an entry for each need of a controller, in the order in which it needs them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

from tracerisk.errors import InputError, Location
from tracerisk.instrument.source.literals.compared_values import (
    Compared,
)
from tracerisk.ros.controller.needs import Missed
from tracerisk.ros.drafts.draft import Draft, Lack
from tracerisk.ros.drafts.drafted_entries import (
    BROUGHT_UP,
    ENTRIES,
    TRANSITION,
    compared_in_sent,
)
from tracerisk.ros.drafts.drafted_parameter import (
    other_values,
    parameter_key,
)
from tracerisk.ros.drafts.pictures.drafted_pictures import DEPTHS, PICTURES, with_seen
from tracerisk.ros.drafts.pictures.seen_in_pictures import seen_in_pictures
from tracerisk.ros.drafts.usable_values import UsableValues
from tracerisk.ros.messages.pictures import PICTURE

_MOST_IN_TURN = 6  # calls of one service, each with another value
_BESIDE = 0.1  # from one drafted object to the next [m]
_SEEN_HZ = 5.0  # pictures a second
_SEEN_S = 6.0  # for how long something is seen at one place of a picture
_ON_S = 5.0  # before what was switched on is switched off
_FIRST_NAMES = re.compile(
    r"(^|[/_])(enable|activate|connect|init(ialize)?|unlock|power_?(on|up)|(servo|motors?)_?on"
    r"|clear_\w*|reset_\w*(errors?|faults?|alarms?))([/_]|$)",
    re.IGNORECASE,
)
_LAST_NAMES = re.compile(
    r"(^|[/_])(e?stop|shutdown|exit|quit|kill|cancel|abort|disable|deactivate|disconnect|pause"
    r"|power_?(off|down)|(servo|motors?)_?off)",
    re.IGNORECASE,
)


def drafts(
    missed: Iterable[Missed], interfaces: Any, values: UsableValues, *, with_others: bool = False
) -> tuple[Draft, ...]:
    """Return what would meet each need.

    What enables a controller is called first, what stops or ends it last.

    `interfaces` makes the message classes; a type it does not know is written without fields.
    `with_others`: what holds a pose comes with entries that hold other ones.
    """
    made_in_turn: list[Draft] = []
    missed = tuple(missed)
    # What is asked for in messages of a module that is not here follows once it is.
    absent = {lacking.need.name for lacking in missed if lacking.need.kind == "module"}
    for lacking in missed:
        if lacking.need.type_name.partition("/")[0] in absent:
            continue
        draft = drafted_entry(lacking, interfaces, values)
        if with_others and draft.value is not None:
            made = (
                drafted_entry(lacking, interfaces, values.with_pose(number)).value
                for number in range(1, len(values.poses))
            )
            draft = replace(draft, others=tuple(other for other in made if other != draft.value))
        made_in_turn += _in_turn(draft, lacking.location, interfaces)
    once: dict[tuple[str, str], Draft] = {}
    for draft in made_in_turn:
        once.setdefault((draft.section, draft.key), draft)
    _set_apart(once.values())
    return tuple(sorted(once.values(), key=_turn))


def _set_apart(found: Iterable[Draft]) -> None:
    """Move the objects among drafts aside, so that none stands in another."""
    for number, draft in enumerate(filter(stands_free, found)):
        for entry in (draft.value, *draft.others):
            move_aside(entry, number)


def stands_free(draft: Draft) -> bool:
    """Return whether a draft puts an object into the cell that nothing holds."""
    return draft.need.kind == "object" and "attached" not in draft.value


def move_aside(entry: dict[str, Any], places: int) -> None:
    """Move an object by some places, each wider than a drafted object."""
    entry["xyz"] = list(entry["xyz"])
    entry["xyz"][1] = round(entry["xyz"][1] + places * _BESIDE, 3)


def _in_turn(draft: Draft, place: Location | None, interfaces: Any) -> Iterator[Draft]:
    """Yield a draft; of a call with a field for which the code knows several values, each."""
    if draft.need.type_name in PICTURES and draft.value is not None:
        yield from _seen_in_turn(draft, place)
        return
    yield draft
    if draft.need.type_name == TRANSITION:
        for number, transition in enumerate(BROUGHT_UP[1:], 2):
            more = {**draft.value, "request": {"transition": transition}}
            yield replace(draft, key=f"{draft.key}[{number}]", value=more)
        return
    content = {"call": "request", "goal": "goal"}.get(draft.need.kind)
    sent = {} if content is None or draft.value is None else draft.value.get(content, {})
    compared = compared_in_sent(draft.need, place, interfaces) if sent else Compared()
    for (name, *deeper), literals in compared.values.items():
        now = sent.get(name)
        # A switch that would stop or only pretend stays off.
        if deeper or isinstance(now, list | dict | float) or now is None or now is False:
            continue
        others = [literal for literal in literals if type(literal) is type(now) and literal != now]
        for number, value in enumerate(others[: _MOST_IN_TURN - 1], 2):
            more = {**draft.value, content: {**sent, name: value}}
            if value is False:
                more["wait"] = _ON_S
            yield replace(
                draft, key=f"{draft.key}[{number}]", value=more, words="as the code compares it"
            )
        if others:
            return


def _seen_in_turn(draft: Draft, place: Location | None) -> Iterator[Draft]:
    """Yield a drafted picture, or those with what the code looks for at one place after another."""
    seen = seen_in_pictures(place)
    plain = draft.value["message"].get(PICTURE)
    if seen is None or plain is None or plain.get("encoding") == DEPTHS:
        yield draft
        return
    for number, message in enumerate(with_seen(draft.value["message"], seen)):
        begin = number * _SEEN_S
        timing = {"at": begin, "rate": _SEEN_HZ, "until": begin + _SEEN_S - 1 / _SEEN_HZ}
        value = {**draft.value, **timing, "message": message}
        key = f"{draft.key}[{number + 1}]" if number else draft.key
        yield replace(draft, key=key, value=value, words=seen.words)


def _turn(draft: Draft) -> int:
    """Return when a service or an action is called: before the others, among them or after."""
    need, sent = draft.need, draft.value
    if need.kind not in ("call", "goal"):
        return 0
    is_off = isinstance(sent, Mapping) and sent.get("request") == {"data": False}
    if _LAST_NAMES.search(need.name):
        return 1
    if _FIRST_NAMES.search(need.name):
        return 1 if is_off else -1
    return 0


def drafted_entry(missed: Missed, interfaces: Any, values: UsableValues) -> Draft:
    """Return the entry for one need, with the value that fits best."""
    need, place = missed.need, missed.location
    plain: list[Any] = []
    try:
        value, words, *plain = ENTRIES[need.kind](Lack(need, place, interfaces, values))
    except InputError:
        name = {"topic": "topic", "frame": "frame", "call": "service", "goal": "action"}
        value = {name.get(need.kind, "name"): need.name}
        words = "its type is not known"
    key = parameter_key(need, place) if need.kind == "parameter" else need.name
    return Draft(need, key, value, words, place, plain=plain[0] if plain else None)


def drafts_instead(taken: Iterable[tuple[Missed, str | bool]]) -> Iterator[Draft]:
    """Yield the values beside its own with which a code compares a parameter."""
    for missed, given in taken:
        value, *others = other_values(missed.need, missed.location, given) or (None,)
        if value is not None:
            key = parameter_key(missed.need, missed.location)
            words = f"as the code compares it, instead of {given}"
            yield Draft(
                missed.need, key, value, words, missed.location, tuple(others), is_instead=True
            )
