"""Cases of which each run of the tests takes a few of every kind, and the slow run the others."""

from collections.abc import Iterable, Sequence
from typing import Any

import pytest


def slow_but(quick: Iterable[Any], cases: Sequence[Any], *, of_one: bool = False) -> list[Any]:
    """Return all cases; those that are not among the quick ones are marked as slow.

    A tuple is a case of several arguments, or `of_one`.
    """
    chosen = list(quick)
    assert all(each in cases for each in chosen), "a quick case is none of the cases"
    return [each if each in chosen else _slow(each, of_one) for each in cases]


def slow_but_every(step: int, cases: Sequence[Any]) -> list[Any]:
    """Return all cases; all but every n-th are marked as slow."""
    return [_slow(each, False) if i % step else each for i, each in enumerate(cases)]


def _slow(case: Any, of_one: bool) -> Any:
    values = case if isinstance(case, tuple) and not of_one else (case,)
    return pytest.param(*values, marks=pytest.mark.slow)
