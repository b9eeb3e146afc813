"""Blocks that the last run wrote and that a version without a later run does not hold any more."""

from __future__ import annotations

import posixpath
from collections.abc import Mapping
from dataclasses import replace

from tracerisk.adder.blocks.block import RiskBlock
from tracerisk.adder.blocks.model_names import model_names
from tracerisk.adder.lock.digest import digest_of
from tracerisk.adder.lock.lock import WrittenBlock, as_written, written_block
from tracerisk.adder.sources.renames import follow_renames
from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.instrument.source.language import is_c_like
from tracerisk.pipeline.review.controllers import ControllerVersion
from tracerisk.prm.review.model_parts import renamed_block

FunctionBlocks = list[tuple[FunctionRef, RiskBlock]]


def with_lost_blocks(blocks: FunctionBlocks, version: ControllerVersion) -> FunctionBlocks:
    """Return the blocks, and those that the last run wrote into functions that are gone since.

    A version whose code has changed since is not assessed: it must neither make no model nor look
    safer. A block that only bears another name now is none that is lost.
    """
    if not blocks or not version.stale or version.entry is None:
        return blocks
    written = written_blocks(version)
    lost = _lost(blocks, version, written)
    new = [(ref, block) for ref, block in blocks if ref not in written]
    names = {}
    for ref, text in list(lost.items()):
        for other, block in new:
            if other.file == ref.file and _is_of(block, text):
                names[str(ref.name)] = str(other.name)
                lost.pop(ref, None)
    blocks = [(ref, renamed_block(block, names)) for ref, block in blocks]
    more = [(ref, as_written(ref.name, block)) for ref, block in sorted(lost.items(), key=_ref)]
    if not more:
        return blocks
    named = model_names([ref for ref, _ in (*blocks, *more)])
    return [
        (ref, replace(block, name=QualifiedName(named[ref]))) for ref, block in (*blocks, *more)
    ]


def _ref(item: tuple[FunctionRef, WrittenBlock]) -> FunctionRef:
    return item[0]


def _is_of(block: RiskBlock, text: WrittenBlock) -> bool:
    """Return whether a block is what the tool wrote, under another name."""
    return block.digest == digest_of(text) or written_block(block) == text


def written_blocks(version: ControllerVersion) -> dict[FunctionRef, WrittenBlock]:
    """Return what the last run wrote, by function."""
    entry = version.entry
    return {
        FunctionRef(_path(version, file), QualifiedName(name)): block
        for file, held in (entry.blocks.items() if entry is not None else ())
        for name, block in held.items()
    }


def _lost(
    blocks: FunctionBlocks, version: ControllerVersion, written: Mapping[FunctionRef, WrittenBlock]
) -> dict[FunctionRef, WrittenBlock]:
    there = {ref for ref, _ in blocks}
    followed = set()
    for file in {ref.file for ref in written}:
        if file in version.sources and not is_c_like(file):
            names = {ref.name for ref in written if ref.file == file}
            renamed = follow_renames(version.sources[file], file, names).renamed
            followed |= {FunctionRef(file, name) for name in renamed}
    return {ref: written[ref] for ref in written.keys() - there - followed}


def _path(version: ControllerVersion, file: str) -> str:
    return posixpath.normpath(posixpath.join(version.folder, file))
