"""Where a line of a source stands once its risk blocks have changed."""

from __future__ import annotations

from collections.abc import Callable

from tracerisk.adder.read import read_blocks


def line_map(before: bytes, after: bytes, file: str) -> Callable[[int], int]:
    """Return what maps a line of `before` (from 1, outside its blocks) to the same in `after`.

    The two differ in their risk blocks alone.
    """
    old, new = _block_lines(before, file), _block_lines(after, file)

    def moved(line: int) -> int:
        rest = line - sum(1 for each in old if each < line)
        for each in new:
            if each <= rest:
                rest += 1
        return rest

    return moved


def _block_lines(source: bytes, file: str) -> tuple[int, ...]:
    """Return the lines that belong to risk blocks, ascending."""
    lines = {
        line
        for placed in read_blocks(source, file)
        for line in range(placed.first_line, placed.last_line + 1)
    }
    return tuple(sorted(lines))
