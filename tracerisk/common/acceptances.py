"""Read what a user accepts of a run's verdict: entries of the settings or of a scenario."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NoReturn

from tracerisk.common.verdict import Acceptance
from tracerisk.common.verdict_codes import ACCEPTABLE
from tracerisk.errors import one_of

KEYS = ("code", "function", "object", "words")


def read_acceptances(value: Any, fail: Callable[[str], NoReturn]) -> tuple[Acceptance, ...]:
    """Return the entries of an `accept`; `fail` raises the error of a message.

    Each is a table with `code`, `words` and, where the reason has them, `function` and `object`.
    """
    if not isinstance(value, list):
        fail("expected a list of tables with code, function, object and words")
    acceptances: dict[tuple[str, str, str], Acceptance] = {}
    for number, entry in enumerate(value, start=1):
        each = _acceptance(entry, number, fail)
        if each.key in acceptances:
            fail(f"entry {number} is a duplicate of {each.code} in '{each.function}'; remove one")
        acceptances[each.key] = each
    return tuple(acceptances.values())


def _acceptance(entry: Any, number: int, fail: Callable[[str], NoReturn]) -> Acceptance:
    if not isinstance(entry, Mapping):
        fail(f"entry {number} is not a table; expected code, function, object and words")
    for key in entry:
        if key not in KEYS:
            fail(f"entry {number}: unknown key '{key}'; {one_of(KEYS, str(key))}")
    given = {key: entry.get(key, "") for key in KEYS}
    for key, text in given.items():
        if not isinstance(text, str):
            fail(f"entry {number}: {key} is {text!r}; expected a string")
        if text == "*" or ("*" in text and key in ("code", "function")):
            fail(f"entry {number}: {key} is {text!r}; wildcards are not allowed")
    if given["code"] not in ACCEPTABLE:
        fail(
            f"entry {number}: code '{given['code']}' cannot be accepted; "
            f"{one_of(ACCEPTABLE, given['code'])}"
        )
    if not given["words"].strip():
        fail(f"entry {number}: words are missing; say why {given['code']} is accepted")
    return Acceptance(given["code"], given["function"], given["object"], given["words"].strip())
