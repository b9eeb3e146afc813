"""How a group of dynamic gates goes from state to state.

A state is a row of bytes, see `layout`. An event fails, and what fails of it goes upwards; then the
dependencies act one after the other, each on all of its dependents at once. What can make no
difference to the top any more is forgotten, so that states which differ in it alone are one.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from heapq import heappop, heappush
from itertools import pairwise

from tracerisk.prm.other_models.dynamic.elements import DynamicGate, DynamicKind, RestrictionKind
from tracerisk.prm.other_models.dynamic.layout import (
    FAILED,
    GONE,
    IN_SERVICE,
    SAFE,
    START,
    TAKEN,
    Layout,
)

Outcome = tuple[float, bytes]
"""A probability and the state it leads to."""


def start(layout: Layout, failed: Iterable[int]) -> list[Outcome]:
    """Return what becomes of a group in which these events are failed from the start.

    They are so all together; where a restriction rules that out, one after the other, and those
    that it still rules out wait until they may.
    """
    row = bytearray(layout.size)
    slots = {
        dependents[0]: layout.first_dependency_slot + number
        for number, (trigger, dependents, _) in enumerate(layout.dependencies)
        if trigger == START
    }
    for slot in slots.values():
        row[slot] = 1
    for gate in layout.spare_gates:
        first = layout.inputs[gate][0]
        row[layout.spare_slots[first]] |= TAKEN
        if layout.owner[gate] is None:
            _put_in_service(layout, row, first)
    together = bytearray(row)
    pairs = list(_settle(layout, together, _fail(layout, together, failed), 1.0))
    if pairs:
        return pairs
    for event in failed:
        row[slots[event]] = 0
    return list(_settle(layout, row, [], 1.0))


def after_failure(layout: Layout, state: bytes, event: int) -> list[Outcome]:
    """Return what becomes of a state when an event fails; nothing where that is ruled out."""
    row = bytearray(state)
    return list(_settle(layout, row, _fail(layout, row, (event,)), 1.0))


def after_phase(layout: Layout, state: bytes, event: int) -> bytes:
    """Return what becomes of a state when a phase of an event ends that is not its last."""
    row = bytearray(state)
    row[event] += 1
    return _in_order(layout, row)


def is_in_service(layout: Layout, state: bytes | bytearray, element: int) -> bool:
    """Return whether an element is in service, and not part of a spare that waits."""
    owner = layout.owner[element]
    return owner is None or bool(state[layout.spare_slots[owner]] & IN_SERVICE)


def _fail(layout: Layout, row: bytearray, events: Iterable[int]) -> list[int]:
    """Mark events as failed, and return the gates to look at, as a heap."""
    pending: list[int] = []
    for event in events:
        row[event] = FAILED
        _push_gates_above(layout, pending, event)
    return pending


def _push_gates_above(layout: Layout, pending: list[int], element: int) -> None:
    for gate in layout.parents[element]:
        heappush(pending, gate)


def _settle(
    layout: Layout,
    row: bytearray,
    pending: list[int],
    chance: float,
    acting: tuple[int, bytes] | None = None,
    blocked: frozenset[int] = frozenset(),
) -> Iterator[Outcome]:
    """Yield the states in which failures can end, once they went upwards from the gates given.

    Where that is ruled out there are none; but `acting`, the dependency whose dependents fail and
    the state before, waits then until they may, as do those that are `blocked`.
    """
    while True:
        while pending:
            gate = heappop(pending)
            if row[gate] >= SAFE:
                continue
            switch = _switch(layout, row, gate)
            if switch > 0.0:
                # The spare does not take over: the gate fails, and the spare waits for others.
                other, above = bytearray(row), list(pending)
                other[gate] = FAILED
                _push_gates_above(layout, above, gate)
                yield from _settle(layout, other, above, chance * switch, acting, blocked)
                chance *= 1.0 - switch
                if chance == 0.0:
                    return
            row[gate] = _status(layout, row, gate)
            if row[gate] >= SAFE:
                _push_gates_above(layout, pending, gate)
        if _is_ruled_out(layout, row):
            if acting is None:
                return
            row = bytearray(acting[1])
            chance /= layout.dependencies[acting[0]][2]
            blocked |= {acting[0]}
        elif acting is not None:
            probability = layout.dependencies[acting[0]][2]
            if probability < 1.0:
                spared = bytearray(acting[1])
                spared[layout.first_dependency_slot + acting[0]] = 1
                yield from _settle(layout, spared, [], chance * (1.0 - probability) / probability)
            blocked = frozenset()
        number = _next_dependency(layout, row, blocked)
        if number is None:
            break
        acting = number, bytes(row)
        _, dependents, probability = layout.dependencies[number]
        row[layout.first_dependency_slot + number] = 1
        chance *= probability
        pending = _fail(layout, row, [event for event in dependents if row[event] < SAFE])
    yield chance, _without_the_forgotten(layout, row)


def _switch(layout: Layout, row: bytearray, gate: int) -> float:
    """Return the probability that a take-over which is due now fails."""
    kind = layout.gates[gate]
    if not isinstance(kind, DynamicGate) or not kind.switch:
        return 0.0
    used = layout.inputs[gate][row[gate]]
    return kind.switch if row[used] == FAILED and _next_spare(layout, row, gate) else 0.0


def _status(layout: Layout, row: bytearray, gate: int) -> int:
    """Return the status of a gate that has not failed yet, after a change of its inputs.

    A spare that takes over is taken and put in service.
    """
    this, inputs = layout.gates[gate], layout.inputs[gate]
    if not isinstance(this, DynamicGate):
        failed, safe, threshold = 0, 0, this.threshold
        for child in inputs:
            failed += row[child] == FAILED
            safe += row[child] == SAFE
        if failed >= threshold:
            return FAILED
        return SAFE if len(inputs) - safe < threshold else 0
    if this.kind is DynamicKind.SPARE:
        return _spare_status(layout, row, gate)
    if this.kind is DynamicKind.POR:
        others = any(row[child] == FAILED for child in inputs[1:])
        if row[inputs[0]] == FAILED:
            return FAILED if this.inclusive or not others else SAFE
        return SAFE if others or row[inputs[0]] == SAFE else 0
    in_order = 0
    while in_order < len(inputs) and row[inputs[in_order]] == FAILED:
        in_order += 1
    together = in_order > row[gate] + 1 and not this.inclusive
    if together or any(row[child] == SAFE for child in inputs):
        return SAFE
    if any(row[child] == FAILED for child in inputs[in_order:]):
        return SAFE
    return FAILED if in_order == len(inputs) else in_order


def _spare_status(layout: Layout, row: bytearray, gate: int) -> int:
    used = layout.inputs[gate][row[gate]]
    if row[used] != FAILED:
        return SAFE if row[used] == SAFE else row[gate]
    following = _next_spare(layout, row, gate)
    if not following:
        return FAILED
    unit = layout.inputs[gate][following]
    row[layout.spare_slots[unit]] |= TAKEN
    if is_in_service(layout, row, gate):
        _put_in_service(layout, row, unit)
    return following


def _next_spare(layout: Layout, row: bytearray, gate: int) -> int:
    """Return the position of the spare that can take over, 0 where there is none."""
    inputs = layout.inputs[gate]
    for position in range(row[gate] + 1, len(inputs)):
        unit = inputs[position]
        if row[unit] != FAILED and not row[layout.spare_slots[unit]] & TAKEN:
            return position
    return 0


def _put_in_service(layout: Layout, row: bytearray, unit: int) -> None:
    """Put a spare in service, with the units that the spare gates within it use."""
    row[layout.spare_slots[unit]] |= IN_SERVICE
    for gate in layout.spare_gates:
        if layout.owner[gate] == unit and row[gate] < SAFE:
            _put_in_service(layout, row, layout.inputs[gate][row[gate]])


def _next_dependency(layout: Layout, row: bytearray, blocked: frozenset[int]) -> int | None:
    slot = layout.first_dependency_slot
    for number, (trigger, _, _) in enumerate(layout.dependencies):
        happened = trigger == START or row[trigger] == FAILED
        if happened and not row[slot + number] and number not in blocked:
            return number
    return None


def _is_ruled_out(layout: Layout, row: bytearray) -> bool:
    for kind, inputs in layout.restrictions:
        failed = [row[element] == FAILED for element in inputs]
        if kind is RestrictionKind.EXCLUSION:
            if sum(failed) > 1:
                return True
        elif any(late and not early for early, late in pairwise(failed)):
            return True
    return False


def _without_the_forgotten(layout: Layout, row: bytearray) -> bytes:
    """Return the state with all that makes no difference to the top any more marked as gone."""
    counts = bytearray(len(layout.names))
    _mark(layout, row, counts, [layout.top])
    grown = True
    while grown:
        grown = _mark_users_of_spares(layout, row, counts)
        for number, (trigger, dependents, _) in enumerate(layout.dependencies):
            acted = row[layout.first_dependency_slot + number]
            if trigger == START or acted or counts[trigger]:
                continue
            if _any_open(row, counts, dependents):
                _mark(layout, row, counts, [trigger])
                grown = True
        for _, inputs in layout.restrictions:
            # Those that failed, too: what may happen now depends on them.
            if any(counts[index] for index in inputs) and not all(
                counts[index] for index in inputs
            ):
                _mark(layout, row, counts, inputs)
                grown = True
    for element, counted in enumerate(counts):
        if not counted:
            row[element] = GONE
    for number, (_, dependents, _) in enumerate(layout.dependencies):
        if not _any_open(row, counts, dependents):
            row[layout.first_dependency_slot + number] = 1
    for unit, slot in layout.spare_slots.items():
        if not _any_open(row, counts, layout.parts[unit]):
            row[slot] = 0
    return _in_order(layout, row)


def _in_order(layout: Layout, row: bytearray) -> bytes:
    """Return the state with events that are alike in order: only how many failed counts."""
    for members in layout.alike:
        for member, status in zip(members, sorted(row[index] for index in members), strict=True):
            row[member] = status
    return bytes(row)


def _mark_users_of_spares(layout: Layout, row: bytearray, counts: bytearray) -> bool:
    """Mark the spare gates that can still take or put in service what is of account.

    They do so even where their own failure makes no difference any more.
    """
    grown = False
    for unit, parts in layout.parts.items():
        if len(parts) == 1:
            if not counts[unit] or row[unit] >= SAFE:
                continue
        elif not _any_open(row, counts, parts):
            continue
        users = [gate for gate in layout.parents[unit] if row[gate] < SAFE and not counts[gate]]
        if users or not counts[unit]:
            _mark(layout, row, counts, [unit, *users])
            grown = True
    return grown


def _any_open(row: bytearray, counts: bytearray, elements: Iterable[int]) -> bool:
    return any(counts[element] and row[element] < SAFE for element in elements)


def _mark(layout: Layout, row: bytearray, counts: bytearray, elements: Iterable[int]) -> None:
    """Mark elements as of account, with all below them that can still change them."""
    stack, first_gate = list(elements), len(layout.events)
    while stack:
        element = stack.pop()
        if counts[element]:
            continue
        counts[element] = 1
        if row[element] < SAFE and element >= first_gate:
            inputs = layout.inputs[element]
            stack.extend(inputs[row[element] :] if element in layout.spare_gates else inputs)
