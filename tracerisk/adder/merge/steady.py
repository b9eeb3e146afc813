"""Which written values a refresh may keep, what it kept, and what was computed for them.

A simulation rounds differently on another processor. A value that differs from the written one by
less than the tolerance is noise if nothing behind it changed in kind: the code of the function, the
hardware data of the component, its units and redundancy, the function's components, the robot and
all else that the run depended on.
"""

from __future__ import annotations

from collections.abc import Mapping

from tracerisk.adder.blocks.block import ComponentEntry, RiskBlock
from tracerisk.adder.blocks.values import NOTHING_COMPUTED, PROBABILITY, QUANTITY, REDUNDANCY
from tracerisk.adder.lock.lock import Behind, ControllerLock, WrittenBlock
from tracerisk.adder.merge.edits_found import MergePolicy
from tracerisk.adder.merge.merge import is_noise
from tracerisk.common.function_ref import QualifiedName


def steady_components(
    entry: ControllerLock | None,
    behind: Behind,
    file: str,
    function: QualifiedName,
    computed: RiskBlock | None,
) -> frozenset[str]:
    """Return the components of a function behind whose values nothing changed in kind."""
    if entry is None or computed is None or not entry.is_settled:
        return frozenset()
    before = entry.behind
    written = entry.blocks.get(file, {}).get(function)
    code = behind.functions.get(file, {}).get(function)
    is_same_code = code is not None and before.functions.get(file, {}).get(function) == code
    if written is None or not is_same_code or before.run != behind.run:
        return frozenset()
    names = {component.name for component in computed.components}
    if names != _computed_names(written):
        return frozenset()
    return frozenset(
        component.name
        for component in computed.components
        if _is_same(component, written)
        and component.name in behind.components
        and before.components.get(component.name) == behind.components[component.name]
    )


def _computed_names(written: WrittenBlock) -> set[str]:
    return {
        name
        for name, component in written.components.items()
        if component.omitted or PROBABILITY.key in component.values
    }


def _is_same(component: ComponentEntry, written: WrittenBlock) -> bool:
    """Return whether a component has the units and redundancy that were written."""
    values = written.components[component.name].values
    return all(
        kind.key not in values or kind.same(kind.read(values[kind.key]), field.value)
        for kind, field in ((QUANTITY, component.quantity), (REDUNDANCY, component.redundancy))
    )


def is_same_run(
    entry: ControllerLock | None, fingerprint: str, behind: Behind, policy: MergePolicy
) -> bool:
    """Return whether a lock is of a run of the very same: another may only differ by noise."""
    return (
        entry is not None
        and entry.is_settled
        and not policy.fresh
        and policy.tolerance > 0.0
        and (entry.fingerprint, entry.behind) == (fingerprint, behind)
    )


def kept_values(
    blocks: Mapping[QualifiedName, RiskBlock | None],
    computed: Mapping[QualifiedName, RiskBlock],
    earlier: Mapping[str, Mapping[str, str]] | None,
    tolerance: float,
) -> dict[str, dict[str, str]]:
    """Return what was computed where the blocks of a file keep an earlier value.

    `earlier` is what a lock of the very same run says of the file: another processor's figure is as
    good, so the lock does not change with it. Without `earlier` the figures are those of this run.
    """
    kept: dict[str, dict[str, str]] = {}
    for name, block in blocks.items():
        new_block = computed.get(name)
        of_run = (
            {}
            if new_block is None
            else {component.name: component for component in new_block.components}
        )
        for entry in block.components if block is not None else ():
            new = of_run.get(entry.name)
            standing = _tool_text(entry)
            text = None if new is None else _tool_text(new)
            if text is None or standing is None:
                continue
            if earlier is not None:
                before = earlier.get(name, {}).get(entry.name, standing)
                if is_noise(PROBABILITY, float(before), float(text), tolerance):
                    text = before
            if float(text) != float(standing):
                kept.setdefault(name, {})[entry.name] = text
    return kept


def _tool_text(entry: ComponentEntry) -> str | None:
    field = entry.probability
    text = field.computed if field.pinned else field.text
    return text if text and text != NOTHING_COMPUTED else None
