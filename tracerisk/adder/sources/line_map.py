"""Where a line of a source stands once its risk blocks have changed."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from tracerisk.adder.sources.read import block_lines


def line_map(before: bytes, after: bytes, file: str) -> Callable[[int], int]:
    """Return what maps a line of `before` (from 1, outside its blocks) to the same in `after`.

    The two differ in their risk blocks alone; what the blocks say does not matter.
    """
    old, new = block_lines(before, file), block_lines(after, file)

    def moved(line: int) -> int:
        rest = line - sum(1 for number in old if number < line)
        for number in new:
            if number <= rest:
                rest += 1
        return rest

    return moved


def line_maps(
    before: Mapping[str, bytes], after: Mapping[str, bytes], shown: Mapping[str, str]
) -> Callable[[str, int], int]:
    """Return what maps a file and a line of it in `before` to the line of the same in `after`.

    A file that `after` lacks is taken without its blocks; lines of other files stay.
    `shown` is how messages call each source.
    """
    maps = {
        file: line_map(source, after.get(file, b""), shown[file])
        for file, source in before.items()
        if source != after.get(file)
    }
    return lambda file, line: maps[file](line) if file in maps else line
