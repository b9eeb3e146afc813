"""Follow functions that were renamed, or moved to another file, since their blocks were written.

A block stands in its function's body, so it moves with it; only the names in it stay behind. A
block with a digest was written under the name that it has, and so was one that the lock knows:
where no function has that name any more, the function that holds the block was renamed. A block
given by hand is followed wherever no function has its name.

Search and replace gives a function its new name in its block too, and in what leads to it. Then
the block is recognised by its digest. What was written and what stands in the sources are both
brought to the new names before they are compared.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping, Sequence, Set
from typing import NamedTuple

from tracerisk.adder.blocks.block import RiskBlock
from tracerisk.adder.blocks.compact import with_names
from tracerisk.adder.blocks.failures import goes_on, is_mode, renamed_text
from tracerisk.adder.blocks.grammar import is_header
from tracerisk.adder.blocks.model_names import model_names
from tracerisk.adder.blocks.values import FAILURES, NEXT
from tracerisk.adder.lock.digest import digest_of
from tracerisk.adder.lock.lock import ControllerLock, Written, WrittenBlock
from tracerisk.adder.merge.bases import EarlierNames
from tracerisk.adder.sources.functions import functions_in
from tracerisk.adder.sources.placed import MisplacedBlockError, PlacedBlock
from tracerisk.adder.sources.read import read_blocks
from tracerisk.common.function_ref import FunctionRef, QualifiedName

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
        if behind is None or text.strip():  # an empty line of a block ends no mode
            is_open = goes_on(text, is_open=is_open)
        is_below_header = behind is not None and is_header(text)
        matched = re.fullmatch(_NAME, line) or re.fullmatch(_NEXT, line, re.DOTALL)
        if matched is not None and matched[2] in names:
            line = matched[1] + names[matched[2]] + matched[3]
        lines.append(line)
    return b"".join(lines)


class FollowedSource(NamedTuple):
    """One source of a controller, its blocks under the names that their functions have now."""

    source: bytes
    """The content with the new names in the blocks; the lines are those of the file."""
    placed: tuple[PlacedBlock, ...]
    """The blocks, with their lines."""
    renamed: Mapping[QualifiedName, QualifiedName]
    """The new name of each renamed function whose block still has the old name, by that."""
    names: EarlierNames
    """The earlier names of functions, those with the new name in their blocks among them."""
    bases: tuple[Written, ...]
    """What was last written into the source, then all else that it may hold, under new names.

    That is what it held before a write that was cut short, and what other branches had written."""
    came: frozenset[FunctionRef]
    """Where the blocks of renamed and moved functions were written that are in this source now."""


def followed_sources(
    sources: Mapping[str, bytes], entry: ControllerLock | None, shown: Mapping[str, str]
) -> dict[str, FollowedSource]:
    """Return the sources of a controller under the names that its functions have now.

    `sources` are all files of its with blocks, by their names in the lock; `shown` is how messages
    call each.
    Raises BlockError or SourceError as `follow_renames`.
    """
    written: Sequence[Mapping[str, Written]] = ({},) if entry is None else entry.all_blocks
    known = {ref for blocks in written for ref in refs_in(blocks)}
    followed = {
        file: follow_renames(source, shown[file], {ref.name for ref in known if ref.file == file})
        for file, source in sources.items()
    }
    moved = {
        FunctionRef(file, old): FunctionRef(file, new)
        for file, one in followed.items()
        for old, new in one.renamed.items()
    }
    placed = {
        FunctionRef(file, block.function): block.block
        for file, one in followed.items()
        for block in one.placed
    }
    lost = {ref for ref in known if ref not in placed and not _is_defined(ref, sources, shown)}
    moved |= _by_digest(written, lost - moved.keys(), placed, known | set(moved.values()))
    names = _model_names(written, moved, placed)
    earlier = {new: old for old, new in reversed(names.items())}
    result = {}
    for file, one in followed.items():
        source, blocks = one.source, one.placed
        # A name that some function has now is no earlier one, whoever had it before.
        left = {
            QualifiedName(old): QualifiedName(new)
            for old, new in names.items()
            if all(ref.name != old for ref in placed)
        }
        named = source_with_names(source, left)
        if named != source:
            source, blocks = named, read_blocks(named, shown[file])
        came = {old: new for old, new in moved.items() if new.file == file}
        own = {str(new.name): str(old.name) for old, new in came.items()}
        bases = tuple(_as_of_now(file, blocks, moved, names) for blocks in written)
        result[file] = FollowedSource(
            source, blocks, one.renamed, EarlierNames(own, earlier), bases, frozenset(came)
        )
    return result


def refs_in(blocks: Mapping[str, Written]) -> Iterable[FunctionRef]:
    """Return the functions whose blocks were written, as the lock says."""
    return (FunctionRef(file, QualifiedName(name)) for file in blocks for name in blocks[file])


def _is_defined(ref: FunctionRef, sources: Mapping[str, bytes], shown: Mapping[str, str]) -> bool:
    return ref.file in sources and any(
        name == ref.name for name, _ in functions_in(sources[ref.file], shown[ref.file])
    )


def _by_digest(
    written: Sequence[Mapping[str, Written]],
    lost: Set[FunctionRef],
    placed: Mapping[FunctionRef, RiskBlock],
    known: Collection[FunctionRef],
) -> dict[FunctionRef, FunctionRef]:
    """Return where functions are now whose block is not where it was written, or called so.

    Search and replace gives a function its new name in its block too, where only the digest says
    that it is the same block. Where two functions had that digest, either may have been copied.
    """
    before: dict[str, set[FunctionRef]] = {}
    now: dict[str, set[FunctionRef]] = {}
    for blocks in written:
        for ref in refs_in(blocks):
            before.setdefault(digest_of(blocks[ref.file][ref.name]), set()).add(ref)
    for ref, block in placed.items():
        if block.digest in before:
            (before if ref in known else now).setdefault(block.digest, set()).add(ref)
    return {
        min(before[digest]): min(refs)
        for digest, refs in now.items()
        if len(refs) == len(before[digest]) == 1 and before[digest] <= lost
    }


def _model_names(
    written: Sequence[Mapping[str, Written]],
    moved: Mapping[FunctionRef, FunctionRef],
    placed: Collection[FunctionRef],
) -> dict[str, str]:
    """Return the new name in the model of each function that has another, by its earlier one."""
    names: dict[str, str] = {}
    if not moved:
        return names
    now = model_names(placed)
    for blocks in written:
        before = model_names({*refs_in(blocks), *moved})
        for old, new in moved.items():
            if before[old] != now[new]:
                names.setdefault(before[old], now[new])
    return names


def _as_of_now(
    file: str,
    blocks: Mapping[str, Written],
    moved: Mapping[FunctionRef, FunctionRef],
    names: Mapping[str, str],
) -> Written:
    """Return what was written for the functions of a file as it would have been under new names."""
    if not moved:
        return blocks.get(file, {})
    came = [
        old
        for old, new in moved.items()
        if new.file == file and old.name in blocks.get(old.file, {})
    ]
    own = {str(moved[old].name): blocks[old.file][old.name] for old in came}
    stayed = {
        name: block
        for name, block in blocks.get(file, {}).items()
        if FunctionRef(file, QualifiedName(name)) not in moved
    }
    return {name: _written_with_names(block, names) for name, block in {**own, **stayed}.items()}


def _written_with_names(block: WrittenBlock, names: Mapping[str, str]) -> WrittenBlock:
    """Return what was last written as it would have been under the new names of what follows."""
    return WrittenBlock(
        {key: _value(key, text, names) for key, text in block.values.items()},
        {
            component: written._replace(
                values={key: _value(key, text, names) for key, text in written.values.items()}
            )
            for component, written in block.components.items()
        },
    )


def _value(key: str, text: str, names: Mapping[str, str]) -> str:
    if key == FAILURES.key:
        return renamed_text(text, names)
    if key != NEXT.key:
        return text
    steps = (step.rpartition(" ") for step in text.split(", "))
    return ", ".join(f"{names.get(target, target)} {share}" for target, _, share in steps)
