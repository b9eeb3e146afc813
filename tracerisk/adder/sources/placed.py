"""A risk block and where it stands in a source, in Python as in C and C++."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Literal, NamedTuple

from tracerisk.adder.blocks.block import RiskBlock
from tracerisk.adder.blocks.grammar import print_block
from tracerisk.common.function_ref import QualifiedName
from tracerisk.common.instance_name import name_at, places
from tracerisk.config import BlockForm
from tracerisk.errors import BlockError, InputError, Location, UnsafeRewriteError, one_of

Place = Literal["body", "above", "module"]
"""Where a block stands: in a function's body, above a function whose body is on the line where
it begins, or at the top of a module's code."""


class MisplacedBlockError(BlockError):
    """A block stands at another function than its `name` says: `owners` are what it may describe.

    `name` is the function that the block names.
    """

    def __init__(
        self, block: RiskBlock, name: QualifiedName, functions: Iterable[str], location: Location
    ) -> None:
        self.owners = tuple(
            dict.fromkeys(QualifiedName(name_at(name, function)) for function in functions)
        )
        names = " or ".join(self.owners)
        advice = f"`{names}` for its name" if block.form == "compact" else f"`name = {names}`"
        super().__init__(
            f"the risk block of `{block.name}` stands at `{names}`; write {advice}, there and in "
            f"what leads to `{block.name}`, or move or delete the block",
            location,
        )
        self.block = block
        self.name = name


class PlacedBlock(NamedTuple):
    """A block in a source, with the function that it describes; lines count from 1."""

    block: RiskBlock
    """The risk block."""
    function: QualifiedName
    """The qualified name; where the block describes one instance of several, its name: `Pick
    (tray)`."""
    line: int
    """The line of the function's `def`; of the first statement for module-level code."""
    place: Place
    """Where the block stands: in the function's body, above the function, or at the top of the
    module."""
    first_line: int
    """The first line of the block."""
    last_line: int
    """The last line of the block."""


def only_one_each(placed: tuple[PlacedBlock, ...], file: str) -> tuple[PlacedBlock, ...]:
    """Return the blocks; raise BlockError where two describe one function."""
    seen: dict[QualifiedName, PlacedBlock] = {}
    for block in placed:
        if block.function in seen:
            raise BlockError(
                f"{block.function} has two risk blocks, the first at line "
                f"{seen[block.function].first_line}; delete one",
                Location(file, block.first_line),
            )
        seen[block.function] = block
    return placed


def targets_of(
    found: Sequence[tuple[QualifiedName, int]],
    placed: Sequence[PlacedBlock],
    blocks: Mapping[QualifiedName, RiskBlock | None],
    lines: Mapping[QualifiedName, int],
    file: str,
    hint: str = "",
) -> dict[tuple[QualifiedName, int], RiskBlock | None]:
    """Return at which definition, by name and line, each block goes.

    `found` are the definitions of the source; `lines` says which of several of a name is meant.
    `hint` is appended to the error message.
    Raises InputError for a function that the source does not define.
    """
    defined = {name: places(name, found) for name in blocks}
    holding = {block.function: block.line for block in placed}
    targets: dict[tuple[QualifiedName, int], RiskBlock | None] = {}
    for name, block in blocks.items():
        if not defined[name]:
            known = {function for function, _ in found}
            raise InputError(
                f"there is no function {name} to annotate; {one_of(known, name)}{hint}",
                Location(file),
            )
        wanted = lines.get(name)
        line = wanted if wanted in defined[name] else holding.get(name, defined[name][-1])
        assert line is not None
        targets[name, line] = block
        if block is not None:
            # A block at another definition of the same name gives way to this one.
            for other in placed:
                if other.function == name and other.line != line:
                    targets[name, other.line] = None
    return targets


def in_other_form(
    placed: Iterable[PlacedBlock], form: BlockForm
) -> dict[tuple[QualifiedName, int], RiskBlock | None]:
    """Return the targets of `insert_at` that bring the blocks of a source into one form."""
    return {
        (block.function, block.line): replace(block.block, form=form, moved_from=block.block.form)
        for block in placed
        if block.block.form != form
    }


def check_same_bytes(bare: bytes, bare_after: bytes, file: str) -> None:
    """Raise UnsafeRewriteError where a source without its blocks is not what it was."""
    if bare_after != bare:
        raise UnsafeRewriteError(
            "taking the risk blocks out again would not give the same bytes", Location(file)
        )


def check_same_blocks(
    expected: Iterable[RiskBlock], placed: Iterable[PlacedBlock], file: str
) -> None:
    """Raise UnsafeRewriteError where a source holds other blocks than were meant for it."""
    if sorted(print_block(replace(block, moved_from=None)) for block in expected) != sorted(
        print_block(placed_block.block) for placed_block in placed
    ):
        raise UnsafeRewriteError(
            "the risk blocks would not be read back as they were written", Location(file)
        )
