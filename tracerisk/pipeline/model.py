"""The risk model that the blocks in sources make, and nothing else."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING

from tracerisk.adder.blocks.block import RiskBlock
from tracerisk.adder.blocks.model_names import model_names
from tracerisk.adder.sources.published import read_c_blocks, read_plain_blocks
from tracerisk.adder.sources.read import read_blocks
from tracerisk.adder.sources.renames import follow_renames, source_with_names
from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.errors import InputError
from tracerisk.instrument.source.language import is_c_like
from tracerisk.prm.hybrid.from_blocks import build_model

if TYPE_CHECKING:
    from tracerisk.prm.hybrid.hybrid import HybridModel


def build(
    sources: Mapping[str, bytes],
    *,
    name: str,
    profile: Mapping[str, Mapping[str, Fraction]] | None = None,
) -> HybridModel:
    """Build the hybrid risk model from the blocks in the sources, and from nothing else.

    `sources` maps the names of files, for messages, to their bytes; by its ending a file is one of
    C, C++ or Java, else of Python.
    Raises BlockError or ModelError where the blocks are malformed or contradict each other.
    """
    blocks = [block for _, block in blocks_of(sources)]
    if not blocks:
        raise InputError(
            f"no risk block in {', '.join(sources)}; `tracerisk run FILE` writes them, or "
            "`tracerisk annotate FILE`"
        )
    return build_model(blocks, profile=profile, name=name)


def blocks_of(
    sources: Mapping[str, bytes], known: Mapping[str, Collection[QualifiedName]] | None = None
) -> list[tuple[FunctionRef, RiskBlock]]:
    """Return the blocks in the sources, each under the name that its function has in the model.

    Beside each stands its function: the file and the qualified name within it. A function that was
    renamed since its block was written has its new name in all of them; `known` are the names under
    which blocks of each file were written, as far as their digests do not say so.
    Raises BlockError or SourceError where a block or a source is malformed.
    """
    pairs = [
        (FunctionRef(file, name), block)
        for file, source in _with_followed_names(sources, known or {}).items()
        for name, block in _blocks_in(source, file)
    ]
    names = model_names([ref for ref, _ in pairs])
    return [(ref, replace(block, name=QualifiedName(names[ref]))) for ref, block in pairs]


def _with_followed_names(
    sources: Mapping[str, bytes], known: Mapping[str, Collection[QualifiedName]]
) -> dict[str, bytes]:
    """Return the sources with the new names of renamed functions in their blocks.

    Raises BlockError or SourceError where a block or a source is malformed.
    """
    followed = {
        file: follow_renames(source, file, known.get(file, ()))
        for file, source in sources.items()
        if not is_c_like(file)
    }
    written = {placed.function for one in followed.values() for placed in one.placed}
    renamed = {
        old: new
        for one in followed.values()
        for old, new in one.renamed.items()
        if old not in written
    }
    named = {file: one.source for file, one in followed.items()}
    return {
        file: source_with_names(named[file], renamed) if file in named else source
        for file, source in sources.items()
    }


def _blocks_in(source: bytes, file: str) -> Iterator[tuple[QualifiedName, RiskBlock]]:
    if is_c_like(file):
        yield from ((QualifiedName(block.name), block) for block in read_c_blocks(source, file))
        return
    yield from ((placed.function, placed.block) for placed in read_blocks(source, file))
    yield from ((QualifiedName(block.name), block) for block in read_plain_blocks(source, file))
