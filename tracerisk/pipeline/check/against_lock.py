"""What the lock says of the blocks of a controller, and what its sources hold."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Any, NamedTuple

from tracerisk.adder.blocks.block import Field, RiskBlock
from tracerisk.adder.blocks.values import (
    CALL_SEQUENCE,
    NEXT,
    NOTHING_COMPUTED,
    FieldKind,
    component_fields,
)
from tracerisk.adder.lock.digest import is_as_written
from tracerisk.adder.lock.lock import ControllerLock, WrittenBlock, as_written, written_block
from tracerisk.adder.merge.bases import NO_EARLIER_NAMES, merge_with_bases
from tracerisk.adder.sources.functions import functions_in
from tracerisk.adder.sources.placed import PlacedBlock
from tracerisk.adder.sources.renames import FollowedSource, refs_in
from tracerisk.common.function_ref import QualifiedName
from tracerisk.common.instance_name import places
from tracerisk.errors import Location
from tracerisk.pipeline.check.finding import CheckFinding
from tracerisk.pipeline.workspace.controller import Controller

if TYPE_CHECKING:
    from tracerisk.adder.merge.bases import SourceEvidence
    from tracerisk.adder.merge.edits_found import HandEdit


class CheckedSource(NamedTuple):
    """A file with blocks."""

    file: str
    """The path in the lock, from the controller's root."""
    shown: str
    """The path in messages."""
    source: bytes
    """The content of the file."""
    followed: FollowedSource
    """The same under the names that its functions have now, and what was last written into it."""

    @property
    def placed(self) -> tuple[PlacedBlock, ...]:
        """The risk blocks in the file, with their lines."""
        return self.followed.placed


def blocks_against_lock(
    controller: Controller,
    entry: ControllerLock,
    sources: Sequence[CheckedSource],
    evidence: SourceEvidence,
) -> Iterable[CheckFinding]:
    """Yield what the sources do not hold as it was written: blocks renamed, edited, lost, gone."""
    for source in sources:
        for old, new in source.followed.renamed.items():
            line = next(b.first_line for b in source.placed if b.function == new)
            yield CheckFinding(
                "orphaned",
                f"the function of the block `{old}` is called `{new}` now",
                Location(source.shown, line),
                old,
            )
        current = {block.function: block for block in source.placed}
        reported = set()
        for name, placed in current.items():
            written = source.followed.bases[0].get(name)
            lost = () if written is None else tuple(_lost_lines(written, source, placed))
            yield from lost
            if lost:
                reported.add(name)
        yield from _edits(source, current, evidence, reported)
        yield from _missing(entry, source, current)
    files = {source.file for source in sources}
    came = {ref for source in sources for ref in source.followed.came}
    gone = {ref for ref in refs_in(entry.blocks) if ref.file not in files} - came
    for file, refs in groupby(sorted(gone), lambda ref: ref.file):
        names = ", ".join(ref.name for ref in refs)
        message = f"the file is gone, and with it the blocks of {names}"
        yield CheckFinding("missing", message, Location(str(controller.path_of(file))))


def _edits(
    source: CheckedSource,
    current: Mapping[QualifiedName, PlacedBlock],
    evidence: SourceEvidence,
    reported: Collection[QualifiedName],
) -> Iterable[CheckFinding]:
    """Yield what is not as the lock says it was written, and whose work that is.

    Of the functions in `reported` it is known already that they are stale.
    """
    followed = source.followed
    for name, placed in current.items():
        written = followed.bases[0].get(name)
        is_settled = written is not None and (
            is_as_written(placed.block, written)
            # Only the names in it are new; the digest is of the earlier ones.
            or (followed.names != NO_EARLIER_NAMES and written_block(placed.block) == written)
        )
        if is_settled or placed.block.added:
            continue
        from tracerisk.adder.merge.edits_found import MergePolicy

        outcome = merge_with_bases(
            name,
            followed.bases,
            placed.block,
            None if written is None else as_written(name, written),
            MergePolicy(),
            lambda: evidence(source.file),
            followed.names,
        )
        place = Location(source.shown, placed.first_line)
        for edit in outcome.edits:
            yield _edit_finding(edit, edit.location or place)
        if not outcome.edits and name not in reported:
            message = f"the risk block of {name} {_behind(placed.block, outcome.block)}"
            yield CheckFinding("stale", message, place, name)


def _edit_finding(edit: HandEdit, place: Location) -> CheckFinding:
    what = (
        f"{edit.field} is {edit.found}, was written as {edit.written or 'nothing'}"
        if edit.kind == "changed"
        else f"{edit.field} was {edit.kind}{' by hand' if edit.is_certain else ''}"
    )
    return CheckFinding("edited" if edit.is_certain else "undecided", what, place, edit.field)


def _behind(found: RiskBlock, due: RiskBlock | None) -> str:
    """Return in what a block is not as it was last written, by no one's edit."""
    if due is None:
        return "is not of the last run"
    if found.digest is None:
        return "was written by an earlier version of tracerisk, without a digest"
    return "holds values of another run or another branch"


def _lost_lines(
    written: WrittenBlock, source: CheckedSource, placed: PlacedBlock
) -> Iterable[CheckFinding]:
    """Yield what the tool wrote and is not there, or not so: `next` lines, `computed` values."""
    name, block = placed.function, placed.block
    if block.next is None and NEXT.key in written.values:
        place = Location(source.shown, placed.first_line)
        message = f"the `next` lines of {name} are gone"
        yield CheckFinding("missing", message, place, f"{name}.{NEXT.key}")
    values: list[tuple[str, FieldKind, Field[Any], Mapping[str, str]]] = [
        (name, CALL_SEQUENCE, block.call_sequence, written.values)
    ]
    if block.next is not None:
        values.append((name, NEXT, block.next, written.values))
    for component in block.components:
        known = written.components.get(component.name)
        if known is not None:
            path = f"{name}.{component.name}"
            values += [
                (path, kind, field, known.values) for kind, field in component_fields(component)
            ]
    for path, kind, field, texts in values:
        was = texts.get(kind.key, NOTHING_COMPUTED)
        if not _is_computed_as_written(kind, field, was):
            message = f"{path}.{kind.key}: `! computed {field.computed}` was written as {was}"
            place = field.location or Location(source.shown, placed.first_line)
            yield CheckFinding("stale", message, place, f"{path}.{kind.key}")


def _is_computed_as_written(kind: FieldKind, field: Field[Any], was: str) -> bool:
    if not field.pinned or field.computed is None or field.computed == was:
        return True
    if NOTHING_COMPUTED in (field.computed, was):
        return False
    return kind.same(kind.read(field.computed), kind.read(was))


def _missing(
    entry: ControllerLock, source: CheckedSource, current: Mapping[QualifiedName, PlacedBlock]
) -> Iterable[CheckFinding]:
    written = set(entry.blocks.get(source.file, {})) - set(source.followed.renamed)
    lost = sorted(written - set(current))
    if not lost:
        return
    lines = functions_in(source.source, source.shown)
    for name in lost:
        if numbers := places(name, lines):
            place = Location(source.shown, numbers[-1])
            yield CheckFinding("missing", f"the risk block of {name} is gone", place, name)
