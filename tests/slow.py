"""Cases of which each run of the tests takes a few of every kind, and the slow run the others."""

from collections.abc import Iterable, Sequence
from typing import Any
from zlib import crc32

import pytest

_MARKERS: list[str] = []
"""The expression of marks by which a run takes tests."""


def taken_by(markers: str) -> None:
    """Say by which expression of marks a run takes tests, before any test is read.

    A run without the slow cases does not even make them: every worker would, of thousands.
    """
    _MARKERS[:] = [markers]


def slow_but(quick: Iterable[Any], cases: Sequence[Any], *, of_one: bool = False) -> list[Any]:
    """Return all cases; those that are not among the quick ones are marked as slow.

    A tuple is a case of several arguments, or `of_one`.
    """
    chosen = list(quick)
    assert all(each in cases for each in chosen), "a quick case is none of the cases"
    return _cases(((each, each in chosen) for each in cases), of_one)


def slow_but_every(step: int, cases: Sequence[Any]) -> list[Any]:
    """Return all cases; all but every n-th are marked as slow."""
    return _cases(((each, i % step == 0) for i, each in enumerate(cases)), False)


def _cases(cases: Iterable[tuple[Any, bool]], of_one: bool) -> list[Any]:
    """Return the cases of a run, each given with whether it is quick."""
    if _MARKERS == ["not slow"]:
        return [case for case, is_quick in cases if is_quick]
    return [case if is_quick else _slow(case, of_one) for case, is_quick in cases]


def _slow(case: Any, of_one: bool) -> Any:
    values = case if isinstance(case, tuple) and not of_one else (case,)
    return pytest.param(*values, marks=pytest.mark.slow)


def take_some(tests: Iterable[pytest.Item], times: int) -> None:
    """Make some cases of each test marked `slow(but=n)` quick: n, times a number.

    They are always the same ones: those that come first by a sum of their names, which change with
    no other case. Where arguments are crossed, a case with values that none before it has goes
    before them.
    """
    families: dict[str, list[pytest.Item]] = {}
    for test in tests:
        if _is_of_family(test):
            families.setdefault(test.nodeid.partition("[")[0], []).append(test)
    for cases in families.values():
        cases.sort(key=lambda case: crc32(case.nodeid.encode()))
        shown: set[tuple[str, int]] = set()
        for _ in range(min(_quick_of(cases[0]) * times, len(cases))):
            chosen = max(cases, key=lambda case: len(_values(case) - shown))
            cases.remove(chosen)
            shown |= _values(chosen)
            chosen.own_markers[:] = [mark for mark in chosen.own_markers if mark.name != "slow"]


def _is_of_family(test: pytest.Item) -> bool:
    """Whether a test is a case of which some are quick; one that is slow by itself never is."""
    marks = list(test.iter_markers("slow"))
    return bool(marks) and all("but" in mark.kwargs for mark in marks)


def _quick_of(case: pytest.Item) -> int:
    return next(case.iter_markers("slow")).kwargs["but"]


def _values(case: pytest.Item) -> set[tuple[str, int]]:
    """Return each argument of a case with the place of its value among all."""
    if not hasattr(case, "callspec"):
        raise pytest.UsageError(
            f"{case.nodeid} is one case, of which none can be quick: mark it as slow without a "
            "number, or not at all"
        )
    return set(case.callspec.indices.items())
