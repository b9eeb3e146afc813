"""Why a value of a block changed, by the lock and the sources of both versions."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from typing import get_args

from tracerisk.adder.lock.digest import KINDS, DigestReading
from tracerisk.adder.lock.lock import WrittenBlock
from tracerisk.adder.sources.published import read_c_blocks
from tracerisk.adder.sources.read import read_blocks
from tracerisk.pipeline.freshness.freshness import RunInputs
from tracerisk.pipeline.review.controllers import ControllerVersion
from tracerisk.prm.review.risk_change import Cause, ChangedField
from tracerisk.source.code_digest import code_digest
from tracerisk.source.language import is_c, is_c_like
from tracerisk.trace import FunctionRef

_OF_HARDWARE = frozenset({"hardware", "active"})


def cause_finder(
    before: ControllerVersion, after: ControllerVersion, refs: Mapping[str, FunctionRef]
) -> Callable[[ChangedField], tuple[Cause, ...]]:
    """Return a function that finds the cause of a change that no pin explains.

    A value that neither its block's digest nor the later lock knows is a user's edit. Else it is
    what the run depended on that differs: the controller's code, the hardware description,
    settings, other files. Where a version has no lock, its code decides.
    `refs` are the functions of the later version by their names in the model.
    """
    of_run = _run_causes(before, after)

    def cause_of(field: ChangedField) -> tuple[Cause, ...]:
        if _is_the_tools(field, after, refs):
            return of_run
        if _is_edited(field, after, refs):
            return ("edit",)
        return of_run or ("edit",)

    return cause_of


def input_changes(before: ControllerVersion, after: ControllerVersion) -> tuple[str, ...]:
    """Return in words what the runs of the two versions depended on that differs, by their locks.

    None where a version has no lock.
    """
    if before.entry is None or after.entry is None:
        return ()
    old, new = RunInputs.from_data(before.entry.inputs), RunInputs.from_data(after.entry.inputs)
    changed = [
        *_changed_files(old.sources, new.sources),
        *_changed_files(old.files, new.files),
    ]
    if old.hardware != new.hardware and old.hardware and new.hardware:
        changed.append("the hardware description has changed")
    for name in sorted({*old.settings, *new.settings}):
        values = old.settings.get(name), new.settings.get(name)
        if values[0] != values[1]:
            shown = ["the default" if value is None else str(value) for value in values]
            what = "the version of tracerisk" if name == "tracerisk" else f"setting {name}"
            changed.append(f"{what} was {shown[0]}, is {shown[1]}")
    return tuple(changed)


def _changed_files(old: Mapping[str, str], new: Mapping[str, str]) -> Iterator[str]:
    for file in sorted({*old, *new}):
        if file not in new:
            yield f"{file} is no part of the run any more"
        elif file not in old:
            yield f"{file} is part of the run now"
        elif old[file] != new[file]:
            yield f"{file} has changed"


def _run_causes(before: ControllerVersion, after: ControllerVersion) -> tuple[Cause, ...]:
    if before.entry is None or after.entry is None:
        return ("code",) if _codes(before) != _codes(after) else ()
    old, new = RunInputs.from_data(before.entry.inputs), RunInputs.from_data(after.entry.inputs)
    found: set[Cause] = set()
    if old.sources != new.sources:
        found.add("code")
    if old.files != new.files:
        found.add("files")
    if old.hardware != new.hardware:
        found.add("hardware")
    for name in {*old.settings, *new.settings}:
        if old.settings.get(name) != new.settings.get(name):
            found.add("hardware" if name in _OF_HARDWARE else "settings")
    return tuple(cause for cause in get_args(Cause) if cause in found)


def _codes(version: ControllerVersion) -> set[str]:
    """Return digests of what the sources say; where they stand does not matter."""
    return {
        repr(source) if is_c_like(file) and not is_c(file) else code_digest(source, file)
        for file, source in version.sources.items()
    }


def _is_the_tools(
    field: ChangedField, after: ControllerVersion, refs: Mapping[str, FunctionRef]
) -> bool:
    """Return whether the digest of its block says that the tool wrote a value, on any branch."""
    ref = refs.get(field.function)
    source = None if ref is None or field.is_gone else after.sources.get(ref.file)
    if ref is None or source is None:
        return False
    blocks = (
        {block.name: block for block in read_c_blocks(source, ref.file)}
        if is_c_like(ref.file)
        else {placed.function: placed.block for placed in read_blocks(source, ref.file)}
    )
    for name, block in blocks.items():
        if name == ref.name:
            digest = DigestReading(block)
            if field.component is not None and field.key is None:
                return digest.has_component(field.component)
            if field.key is None or field.after is None:
                return digest.is_there
            kind = KINDS[field.key]
            return digest.vouches(field.component, kind, kind.read(field.after))
    return False


def _is_edited(
    field: ChangedField, after: ControllerVersion, refs: Mapping[str, FunctionRef]
) -> bool:
    """Return whether the later lock knows that the tool wrote something else there."""
    ref = refs.get(field.function)
    if after.entry is None or ref is None or field.is_gone:
        return False
    file = os.path.relpath(ref.file, after.folder)
    candidates = [
        written[file][ref.name]
        for written in after.entry.all_blocks
        if ref.name in written.get(file, {})
    ]
    return bool(candidates) and all(_differs(field, each) for each in candidates)


def _differs(field: ChangedField, written: WrittenBlock) -> bool:
    if field.component is None:
        return field.key is not None and written.values.get(field.key) not in (None, field.after)
    component = written.components.get(field.component)
    if component is None:
        return True
    return field.key is not None and component.values.get(field.key) != field.after
