"""Follow functions that were renamed since their blocks were written.

A block stands in its function's body, so it moves with it; only the names in it stay behind. A
block with a digest was written under the name that it has, and so was one that the lock knows:
where no function has that name any more, the function that holds the block was renamed. A block
given by hand is followed wherever no function has its name.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from typing import NamedTuple

from tracerisk.adder.blocks.compact import with_names
from tracerisk.adder.blocks.failures import goes_on, is_mode, renamed_text
from tracerisk.adder.blocks.grammar import is_header
from tracerisk.adder.blocks.values import FAILURES, NEXT
from tracerisk.adder.lock.lock import WrittenBlock
from tracerisk.adder.sources.functions import functions_in
from tracerisk.adder.sources.placed import MisplacedBlockError, PlacedBlock
from tracerisk.adder.sources.read import read_blocks
from tracerisk.common.function_ref import QualifiedName

# Behind the gutter of Python, or in a comment of C.
_GUTTER = rb"([ \t\f]*(?:#[ \t]?\||\*)[ \t]+"
_WORDS = rb"\S+(?: \([^()\r\n]+\))?"
_NAME = _GUTTER + rb"name = )(" + _WORDS + rb")([ \t\r\n]*)"
_NEXT = _GUTTER + rb"next :?= )(" + _WORDS + rb")([ \t].*)"
_ANY = re.compile(_GUTTER + rb")(.*)", re.DOTALL)


class FollowedBlocks(NamedTuple):
    """The blocks of a source under their functions' names."""

    source: bytes
    """The content with the new names in the blocks."""
    placed: tuple[PlacedBlock, ...]
    """The blocks, with their lines."""
    renamed: Mapping[QualifiedName, QualifiedName]
    """The new name of each renamed function, by the old name that its block still has."""


def follow_renames(source: bytes, file: str, known: Collection[QualifiedName]) -> FollowedBlocks:
    """Read the blocks of a source, those of renamed functions among them.

    `known` are the names under which blocks of this file were written.

    Raises:
        BlockError, SourceError: as `read_blocks`; a block that merely stands under another
            function than it says is such an error, and no renaming.
    """
    renamed: dict[QualifiedName, QualifiedName] = {}
    while True:
        named = source_with_names(source, renamed)
        try:
            return FollowedBlocks(named, read_blocks(named, file), renamed)
        except MisplacedBlockError as error:
            new = _new_name(source, file, error, known)
            if new is None or error.name in renamed or new in renamed.values():
                raise
            renamed[error.name] = new


def _new_name(
    source: bytes, file: str, error: MisplacedBlockError, known: Collection[QualifiedName]
) -> QualifiedName | None:
    defined = {name for name, _ in functions_in(source, file)}
    # The lock knows no block given by hand; a block with a digest was written by the tool under
    # that name.
    is_known = error.block.digest is not None or error.block.added or error.name in known
    if not is_known or error.name in defined or len(error.owners) != 1:
        return None
    return error.owners[0]


def source_with_names(source: bytes, renamed: Mapping[QualifiedName, QualifiedName]) -> bytes:
    """Return the source with new names in its blocks: of their functions, and of what follows."""
    if not renamed:
        return source
    names = {old.encode(): new.encode() for old, new in renamed.items()}
    in_text = {str(old): str(new) for old, new in renamed.items()}
    lines = []
    is_below_header = is_open = False
    for line in source.splitlines(keepends=True):
        behind = _ANY.fullmatch(line)
        text = "" if behind is None else behind[2].decode(errors="surrogateescape")
        if behind is not None and (is_open or is_mode(text)):
            words, mark, comment = text.partition("!")
            said = renamed_text(words, in_text) + mark + comment
            line = behind[1] + said.encode(errors="surrogateescape")
        elif behind is not None and (is_below_header or text.lstrip().startswith("->")):
            # The compact form; a line of the published one stays as it is here.
            said = with_names(text, in_text)
            line = behind[1] + said.encode(errors="surrogateescape")
        is_open = goes_on(text, is_open=is_open)
        is_below_header = behind is not None and is_header(text)
        matched = re.fullmatch(_NAME, line) or re.fullmatch(_NEXT, line, re.DOTALL)
        if matched is not None and matched[2] in names:
            line = matched[1] + names[matched[2]] + matched[3]
        lines.append(line)
    return b"".join(lines)


def base_with_names(
    base: Mapping[str, WrittenBlock], renamed: Mapping[QualifiedName, QualifiedName]
) -> Mapping[str, WrittenBlock]:
    """Return what was last written as it would have been under the new names."""
    if not renamed:
        return base
    return {
        str(renamed.get(QualifiedName(name), name)): block._replace(
            values={key: _value(key, text, renamed) for key, text in block.values.items()},
            components={
                component: written._replace(
                    values={key: _value(key, text, renamed) for key, text in written.values.items()}
                )
                for component, written in block.components.items()
            },
        )
        for name, block in base.items()
    }


def _value(key: str, text: str, renamed: Mapping[QualifiedName, QualifiedName]) -> str:
    if key == FAILURES.key:
        return renamed_text(text, {str(old): str(new) for old, new in renamed.items()})
    if key != NEXT.key:
        return text
    steps = (step.rpartition(" ") for step in text.split(", "))
    return ", ".join(
        f"{renamed.get(QualifiedName(target), target)} {share}" for target, _, share in steps
    )
