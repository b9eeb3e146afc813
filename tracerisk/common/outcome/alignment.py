"""Align the steps of two runs, as sequences are."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from tracerisk.common.outcome.outcome import CellUse, Step


def aligned(
    before: Sequence[Step], after: Sequence[Step], same: Callable[[Step, Step], bool]
) -> list[tuple[int, int]]:
    """Return the places of a longest common subsequence of both."""
    first = 0
    while first < min(len(before), len(after)) and same(before[first], after[first]):
        first += 1
    end = 0
    most = min(len(before), len(after)) - first
    while end < most and same(before[-1 - end], after[-1 - end]):
        end += 1
    rows, columns = before[first : len(before) - end], after[first : len(after) - end]
    lengths = [[0] * (len(columns) + 1) for _ in range(len(rows) + 1)]
    # A use of the cell moves among the rests of the arm, and not the other way round.
    worth = [1 if isinstance(row, CellUse) else len(rows) + len(columns) for row in rows]
    alike = [[same(row, column) for column in columns] for row in rows]
    for i in range(len(rows) - 1, -1, -1):
        for j in range(len(columns) - 1, -1, -1):
            lengths[i][j] = (
                max(lengths[i + 1][j], lengths[i][j + 1], lengths[i + 1][j + 1] + worth[i])
                if alike[i][j]
                else max(lengths[i + 1][j], lengths[i][j + 1])
            )
    pairs = [(place, place) for place in range(first)]
    i = j = 0
    while i < len(rows) and j < len(columns):
        if alike[i][j] and lengths[i][j] == lengths[i + 1][j + 1] + worth[i]:
            pairs.append((first + i, first + j))
            i, j = i + 1, j + 1
        elif lengths[i + 1][j] >= lengths[i][j + 1]:
            i += 1
        else:
            j += 1
    ends = range(end, 0, -1)
    return pairs + [(len(before) - place, len(after) - place) for place in ends]
