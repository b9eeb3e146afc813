"""What users set by hand in risk blocks, beside what the tool computes there now."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

from tracerisk.adder.blocks.block import ComponentEntry, Field, RiskBlock, Transition
from tracerisk.adder.blocks.override import Override
from tracerisk.adder.blocks.values import (
    CALL_SEQUENCE,
    NEXT,
    NOTHING_COMPUTED,
    PROBABILITY,
    QUANTITY,
    FieldKind,
    component_fields,
)
from tracerisk.adder.lock.lock import LOCK_NAME, ControllerLock, Lock, WrittenBlock, lock_key
from tracerisk.adder.sources.published import read_c_blocks, read_plain_blocks
from tracerisk.adder.sources.read import read_blocks
from tracerisk.adder.sources.renames import followed_sources
from tracerisk.common.text.bounded import file_bytes
from tracerisk.errors import InputError, Location, readable
from tracerisk.instrument.source.language import is_c_like
from tracerisk.pipeline.freshness.known_controllers import locks_in
from tracerisk.pipeline.workspace.controller import Controller
from tracerisk.pipeline.workspace.project import Projects


def overrides_in(
    files: Sequence[Path | str], *, contents: Mapping[str, bytes] | None = None
) -> tuple[Override, ...]:
    """Return what users set in the blocks of the files, sorted by place.

    `contents` is what files are to hold that are not written yet, by their paths.
    What is computed now is from the lock, where there is one that knows the value; else the comment
    beside the value.
    Raises InputError for a file that cannot be read, BlockError for a malformed block.
    """
    projects = Projects()
    overrides: dict[Path, list[Override]] = {}
    for file in files:
        path = Path(file)
        if path.resolve() not in overrides:
            overrides[path.resolve()] = list(
                _of_file(path, (contents or {}).get(str(file)), projects)
            )
    listed = [override for of_one in overrides.values() for override in of_one]
    return tuple(sorted(listed, key=_order))


def files_of_locks(root: Path) -> tuple[Path, ...]:
    """Return every file with blocks that a lock in or below a folder knows, and that is there.

    Raises InputError where there is none.
    """
    names = {
        folder / file
        for folder, lock in locks_in(root, Projects())
        for controller, entry in lock.controllers.items()
        for file in (controller, *(name for name, blocks in entry.blocks.items() if blocks))
    }
    files = tuple(path for path in sorted(names) if path.is_file())
    if not files:
        raise InputError(f"no {LOCK_NAME} in or below this folder knows a controller; name a FILE")
    return files


def partly_set(overrides: Sequence[Override]) -> Iterator[str]:
    """Yield in words which components have a figure by hand in some functions and not in others.

    Who knows the figure of a part means it in each of them, most likely.
    """
    by_file: dict[str, dict[str, list[str]]] = {}
    for override in overrides:
        if override.figure_of is not None and not is_c_like(override.location.file):
            function, component = override.figure_of
            of_file = by_file.setdefault(override.location.file, {})
            of_file.setdefault(component, []).append(function)
    for file, by_hand in by_file.items():
        computed: dict[str, list[str]] = {}
        for placed in read_blocks(file_bytes(Path(file)), file):
            for entry in () if placed.block.added else placed.block.components:
                is_tools = not (entry.added or entry.omitted or entry.probability.pinned)
                if is_tools and entry.probability.value > 0.0:
                    computed.setdefault(entry.name, []).append(placed.block.name)
        for component in sorted(by_hand.keys() & computed.keys()):
            hand, rest = ", ".join(by_hand[component]), ", ".join(computed[component])
            yield f"{file}: {component} is set by hand in {hand}, and computed in {rest}"


def _of_file(path: Path, content: bytes | None, projects: Projects) -> Iterator[Override]:
    with readable(path):
        source = file_bytes(path) if content is None else content
    project = projects.of(path)
    key, shown = lock_key(path, project.root), str(path)
    entry = _written_into(key, project.lock)
    if is_c_like(path.name) and entry is None:
        for block in read_c_blocks(source, str(path)):
            yield from _of_block(block, None, str(path))
        return
    followed = followed_sources({key: source}, entry, {key: shown})[key]
    for placed in followed.placed:
        bases = (base[placed.function] for base in followed.bases if placed.function in base)
        yield from _of_block(placed.block, next(bases, None), shown)
    if not is_c_like(path.name):
        for block in read_plain_blocks(source, str(path)):
            yield from _of_block(block, None, str(path))


def _written_into(file: str, lock: Lock) -> ControllerLock | None:
    """Return what the lock says of one file, whichever controllers have blocks there.

    What was last written comes first; `None` where the lock knows no block of the file.
    """
    users = [entry for entry in lock.controllers.values() if file in entry.blocks]
    last = [entry.blocks[file] for entry in users]
    more = [blocks.get(file, {}) for entry in users for blocks in entry.all_blocks[1:]]
    written = [{file: blocks} for blocks in (*last, *more) if blocks]
    return ControllerLock("", written[0], others=tuple(written[1:])) if written else None


def _of_block(block: RiskBlock, base: WrittenBlock | None, file: str) -> Iterator[Override]:
    place = block.location or Location(file)
    if block.added:
        yield Override("block", block.name, "by hand", place, reason=block.reason)
    values = base.values if base is not None else {}
    for kind, value in ((CALL_SEQUENCE, block.call_sequence), (NEXT, block.next)):
        if value is not None:
            yield from _of_value(kind, value, block.name, values, place)
    for component in block.components:
        written = base.components.get(component.name) if base is not None else None
        yield from _of_component(
            component, f"{block.name}.{component.name}", written.values if written else {}, place
        )


def _of_component(
    component: ComponentEntry, path: str, written: Mapping[str, str], place: Location
) -> Iterator[Override]:
    place = component.location or place
    if component.added:
        text = _summary(component)
        yield Override("added", path, f"added: {text}", place, reason=component.reason)
    elif component.omitted:
        yield Override(
            "omitted", path, "omitted", place, _omitted(component, written), component.reason
        )
    for kind, value in component_fields(component):
        yield from _of_value(kind, value, path, written, place)


def _of_value(
    kind: FieldKind,
    value: Field[Any],
    path: str,
    written: Mapping[str, str],
    place: Location,
) -> Iterator[Override]:
    if not value.pinned:
        return
    # The lock says what was computed; the comment may have been edited since.
    computed = written.get(kind.key, value.computed)
    if computed == NOTHING_COMPUTED:
        computed = None
    yield Override(
        "value",
        f"{path}.{kind.key}",
        value.text,
        value.location or place,
        computed,
        value.reason,
        None if computed is None else drift_of(kind, value.value, kind.read(computed)),
    )


def _summary(component: ComponentEntry) -> str:
    times = "" if component.quantity.value == 1 else f" x {component.quantity.text}"
    redundant = ", redundant" if component.redundancy.value else ""
    return f"{component.probability.text}{times}{redundant}"


def _omitted(component: ComponentEntry, written: Mapping[str, str]) -> str | None:
    """Return the figure that the omitted component would have: in short entries the lock's."""
    stated = {kind.key: value.text for kind, value in component_fields(component) if value.text}
    values = {**written, **stated}
    if PROBABILITY.key not in values:
        return None
    quantity = values.get(QUANTITY.key, "1")
    return values[PROBABILITY.key] + ("" if quantity == "1" else f" x {quantity}")


def drift_of(kind: FieldKind, value: Any, computed: Any) -> float:
    """Return how far a value set by hand lies from the computed one [%].

    Of a number: the difference relative to the computed one, below zero where the user's is
    the smaller; infinite where zero is computed and the user's is another.
    Of `next`: the share of visits that the two send elsewhere (half the sum of the differences).
    Of `redundancy` and `callSequence`, which have no size: 0 if the same, else 100.
    """
    if kind.same(value, computed):
        return 0.0
    if kind is NEXT:
        return 100.0 * float(_moved(value, computed))
    if kind in (PROBABILITY, QUANTITY):
        return math.inf if computed == 0 else 100.0 * (value - computed) / computed
    return 100.0


def _moved(value: Sequence[Transition], computed: Sequence[Transition]) -> Fraction:
    shares: dict[str, Fraction] = {}
    for transition in value:
        shares[transition.target] = transition.weight
    for transition in computed:
        shares[transition.target] = shares.get(transition.target, Fraction(0)) - transition.weight
    return sum((abs(share) for share in shares.values()), Fraction(0)) / 2


def _order(override: Override) -> tuple[str, int, str]:
    return (override.location.file, override.location.line or 0, override.field)


def hand_set(controller: Controller) -> tuple[str, ...]:
    """Return what a user set in the blocks of a source, each with its place.

    Raises BlockError when a block cannot be read.
    """
    changed = []
    for placed in read_blocks(controller.source, str(controller.path)):
        block = placed.block
        if block.added:
            changed.append(f"{block.location}: the block of {block.name}")
        fields = [("callSequence", block.call_sequence), ("next", block.next)]
        for component in block.components:
            if component.added or component.omitted:
                changed.append(f"{component.location}: {block.name}.{component.name}")
            fields += [
                (f"{component.name}.{kind.key}", value)
                for kind, value in component_fields(component)
            ]
        changed += [
            f"{value.location}: {block.name}.{key}"
            for key, value in fields
            if value is not None and value.pinned
        ]
    return tuple(changed)
