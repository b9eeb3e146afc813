"""Why a value of a block changed, by the lock and the sources of both versions."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, get_args

from tracerisk.adder.blocks.values import FAILURES, PROBABILITY, FieldKind, block_fields
from tracerisk.adder.lock.digest import DigestReading
from tracerisk.adder.lock.lock import WrittenBlock
from tracerisk.common.evidence import EVIDENCE_NAME
from tracerisk.instrument.source.code_digest import code_digest
from tracerisk.instrument.source.language import is_c, is_c_like
from tracerisk.pipeline.freshness.run_inputs import RunInputs
from tracerisk.pipeline.freshness.used_evidence import unfit
from tracerisk.pipeline.review.changed_inputs import changed_inputs
from tracerisk.pipeline.review.controllers import ControllerVersion
from tracerisk.pipeline.review.renamed_functions import FunctionSource
from tracerisk.prm.review.change_records import Cause, ChangedField

_OF_DESCRIPTION = frozenset({"hardware", "system"})
"""The settings that say which description holds."""


def cause_finder(
    before: ControllerVersion, after: ControllerVersion, functions: Mapping[str, FunctionSource]
) -> Callable[[ChangedField], tuple[Cause, ...]]:
    """Return a function that finds the cause of a change that no pin explains.

    A value that neither its block's digest nor the later lock knows is a user's edit. Else it is
    what the run depended on that differs: the controller's code, the hardware description,
    settings, other files. Where a version has no lock, its code decides. A component whose own
    entry in the hardware description is the same did not change because of another one's.
    Evidence is a cause of what follows failures, and of their probabilities, where only one
    version takes it, or where nothing else differs.
    `functions` are those of the later version by their names in the model.
    """
    of_any = _run_causes(before, after)
    of_same_entry = _run_causes(before, after, is_described_alike=True) or of_any
    by_evidence = _evidence_causes(before, after, of_any)

    def cause_of(field: ChangedField) -> tuple[Cause, ...]:
        of_run = of_same_entry if _is_same_entry(before, after, field.component) else of_any
        of_run = by_evidence.get(field.key or "", of_run)
        values = [
            _BlockValue(functions[function], field.component, key)
            for function, key in field.stated
            if function in functions and not field.is_gone
        ]
        if len(values) == len(field.stated) and all(value.is_the_tools for value in values):
            return of_run
        if any(value.is_edited(after) for value in values):
            return ("edit",)
        return of_run or ("edit",)

    return cause_of


class _BlockValue(NamedTuple):
    """A value in a block of the later version."""

    function: FunctionSource
    """The function whose block has the value."""
    component: str | None
    """`None` for a value of the function itself."""
    key: str | None
    """`None` for the whole component, or the whole block."""

    @property
    def stated(self) -> tuple[FieldKind, Any] | None:
        """How the value is read, and the value; `None` where the block states none."""
        block_field = block_fields(self.function.block, self.component).get(self.key or "")
        return None if block_field is None else (block_field[0], block_field[1].value)

    @property
    def is_the_tools(self) -> bool:
        """Whether the digest of its block says that the tool wrote it, on any branch."""
        digest = DigestReading(self.function.block)
        if self.key is None and self.component is not None:
            return digest.has_component(self.component)
        if self.key is None:
            return digest.is_there
        return self.stated is not None and digest.vouches(self.component, *self.stated)

    def is_edited(self, after: ControllerVersion) -> bool:
        """Return whether the later lock knows that the tool wrote something else there."""
        if after.entry is None:
            return False
        file, name = os.path.relpath(self.function.file, after.folder), self.function.name
        candidates = [
            written[file][name]
            for written in after.entry.all_blocks
            if name in written.get(file, {})
        ]
        return bool(candidates) and not any(map(self._is_as_in, candidates))

    def _is_as_in(self, written: WrittenBlock) -> bool:
        values = written.values
        if self.component is not None:
            if self.component not in written.components:
                return False
            values = written.components[self.component].values
        if self.key is None:
            return True
        if self.key not in values:
            # An earlier version of the tool wrote no `next`.
            return self.component is None or self.stated is None
        if self.stated is None:
            return False
        kind, value = self.stated
        return kind.same(kind.read(values[self.key]), value)


def input_changes(before: ControllerVersion, after: ControllerVersion) -> tuple[str, ...]:
    """Return in words what the runs of the two versions depended on that differs, by their locks.

    None where a version has no lock.
    """
    if before.entry is None or after.entry is None:
        return ()
    old, new = RunInputs.from_data(before.entry.inputs), RunInputs.from_data(after.entry.inputs)
    texts = list(changed_inputs(old, new))
    if old.evidence != new.evidence:
        verb = "has changed" if new.evidence else "is no longer taken"
        texts.append(f"{EVIDENCE_NAME} {verb if old.evidence else 'is taken now'}")
    return tuple(texts)


def evidence_change(before: ControllerVersion, after: ControllerVersion) -> str:
    """Return that the values of only one version take evidence, and why; empty where they do alike.

    By the locks: a version without one takes none that is known.
    """
    if before.entry is None or after.entry is None:
        return ""
    old, new = RunInputs.from_data(before.entry.inputs), RunInputs.from_data(after.entry.inputs)
    if bool(old.evidence) == bool(new.evidence):
        return ""
    if new.evidence:
        return "evidence is taken now and was not before"
    why = unfit(after.evidence, new.fingerprint) or "the settings ask for none"
    return f"evidence is no longer taken: {why}"


def _evidence_causes(
    before: ControllerVersion, after: ControllerVersion, others: tuple[Cause, ...]
) -> dict[str, tuple[Cause, ...]]:
    """Return the causes of the values that evidence weighs, by key; empty where it is no cause."""
    if before.entry is None or after.entry is None:
        return {}
    old, new = (RunInputs.from_data(entry.inputs).evidence for entry in (before.entry, after.entry))
    # Evidence of both that differs beside something else is another for that reason.
    if old == new or (old and new and others):
        return {}
    return {FAILURES.key: ("evidence",), PROBABILITY.key: (*others, "evidence")}


def _is_same_entry(
    before: ControllerVersion, after: ControllerVersion, component: str | None
) -> bool:
    """Return whether both locks know that a component's entry in the description is the same."""
    if component is None or before.entry is None or after.entry is None:
        return False
    old, new = (entry.behind.components for entry in (before.entry, after.entry))
    return component in old and old[component] == new.get(component)


def _run_causes(
    before: ControllerVersion, after: ControllerVersion, *, is_described_alike: bool = False
) -> tuple[Cause, ...]:
    """Return what the runs depended on that differs, of a component that is described alike or not.

    The setting `active` says how each is used, whatever its entry.
    """
    if before.entry is None or after.entry is None:
        return ("code",) if _codes(before) != _codes(after) else ()
    old, new = RunInputs.from_data(before.entry.inputs), RunInputs.from_data(after.entry.inputs)
    causes: set[Cause] = set()
    if old.sources != new.sources:
        causes.add("code")
    if old.files != new.files:
        causes.add("files")
    if old.hardware != new.hardware and not is_described_alike:
        causes.add("hardware")
    for name in {*old.settings, *new.settings}:
        if old.settings.get(name) == new.settings.get(name):
            continue
        if name not in _OF_DESCRIPTION:
            causes.add("hardware" if name == "active" else "settings")
        elif not is_described_alike:
            causes.add("hardware")
    return tuple(cause for cause in get_args(Cause) if cause in causes)


def _codes(version: ControllerVersion) -> set[str]:
    """Return digests of what the sources say; where they stand does not matter."""
    return {
        repr(source) if is_c_like(file) and not is_c(file) else code_digest(source, file)
        for file, source in version.sources.items()
    }
