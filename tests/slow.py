"""Cases of which each run of the tests takes a few of every kind, and the slow run the others."""

from collections.abc import Iterable, Sequence
from typing import Any

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
