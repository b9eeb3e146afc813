"""Passes over the pattern of a sparse matrix: its transpose, its symmetric closure.

`tracerisk/prm/compiled/chains.c` goes through it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tracerisk.prm.compiled.library import loop

Array = np.ndarray[Any, Any]
Rows = tuple[Array, Array, Array]
"""A matrix in compressed rows: where each row begins, and ends; the columns; the entries."""

_transposed = loop("transposed", "lidllid")
_neighbours = loop("neighbours", "liliili", int)
_reach_backwards = loop("reach_backwards", "li?i")
_split = loop("split", "lid?illidddid", int)
_gathered = loop("gathered", "lid?lddd")
_row_sums_into = loop("row_sums_into", "lid?ldd")


def transposed(n: int, rows: Rows) -> Rows:
    """Return the transpose of an n x n matrix, its rows sorted."""
    count = len(rows[1])
    starts = np.zeros(n + 1, np.int64)
    turned, values = np.empty(count, np.int32), np.empty(count)
    _transposed(*rows, starts, np.empty(n, np.int64), turned, values)
    return starts, turned, values


def neighbours(
    n: int, indptr: Array, indices: Array, turned_ptr: Array, turned: Array
) -> tuple[Array, Array]:
    """Return who is joined to whom in either direction, themselves left out.

    `turned_ptr` and `turned` are the pattern of the transpose.
    """
    seen = np.full(n, -1, np.int32)
    starts = np.zeros(n + 1, np.int64)
    empty = np.empty(len(indices) + len(turned), np.int32)
    count = _neighbours(indptr, indices, turned_ptr, turned, seen, starts, empty)
    return starts, empty[:count].copy()


def not_reached_backwards(n: int, turned_ptr: Array, turned: Array, ends: Array) -> Array:
    """Return the states from which no path leads to one where `ends` holds, in order."""
    reached: Array = ends.copy()
    _reach_backwards(turned_ptr, turned, reached, np.empty(n, np.int32))
    return np.flatnonzero(~reached)


def split(
    rows: Rows, absorbing: Array, place: Array, transient: Array
) -> tuple[Array, Array, Array, Array, Array, Array, Array]:
    """Split the rows of the transient states into the ways between them and what leaves them.

    `place` numbers the transient states, `transient` holds them in that order.
    Returns indptr, indices and data of the ways between different transient states, and for
    each transient state the sum of its ways to absorbing ones, what its rounding lost, how many
    they are, and the sum of its whole row.
    """
    n = len(transient)
    starts = np.zeros(n + 1, np.int64)
    targets, values = np.empty(len(rows[1]), np.int32), np.empty(len(rows[1]))
    sums = np.zeros(n), np.zeros(n), np.zeros(n, np.int32), np.zeros(n)
    count = _split(*rows, absorbing, place, transient, starts, targets, values, *sums)
    return starts, targets[:count].copy(), values[:count].copy(), *sums


def gathered(rows: Rows, chosen: Array, transient: Array, stay: Array) -> Array:
    """Return for each state where `chosen` holds the sum of the ways into it times `stay`."""
    total, lost = np.zeros(len(chosen)), np.zeros(len(chosen))
    _gathered(*rows, chosen, transient, stay, total, lost)
    return total + lost


def row_sums_into(rows: Rows, chosen: Array, transient: Array) -> tuple[Array, Array]:
    """Return for each transient state the sum of its ways to states where `chosen` holds.

    And what its rounding lost.
    """
    sums, low = np.zeros(len(transient)), np.zeros(len(transient))
    _row_sums_into(*rows, chosen, transient, sums, low)
    return sums, low
