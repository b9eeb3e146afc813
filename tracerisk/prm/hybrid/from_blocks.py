"""Build the hybrid model from risk blocks, and from nothing else."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import NoReturn

from tracerisk.adder.blocks.block import ComponentEntry, Field, RiskBlock, Transition
from tracerisk.errors import BlockError, Location, ModelError, one_of
from tracerisk.prm.hybrid.elements import DONE, FunctionState, NextStep, Parameter
from tracerisk.prm.hybrid.fates.of_blocks import component_fates
from tracerisk.prm.hybrid.function_fault_tree import (
    component_figures,
    component_spares,
    function_fault_tree,
    in_one_visit,
    latent_units,
)
from tracerisk.prm.hybrid.hybrid import HybridModel, endless_states
from tracerisk.prm.hybrid.part_names import unit_name
from tracerisk.prm.trees.fault_tree import FaultTree
from tracerisk.prm.trees.gates import Gate, GateKind

MAX_QUANTITY = 10_000
"""The most units of one component: each becomes a basic event."""

Profile = Mapping[str, Mapping[str, Fraction]]


def build_model(
    blocks: Sequence[RiskBlock], *, profile: Profile | None = None, name: str
) -> HybridModel:
    """Build the model that the blocks describe.

    Each block is a state; its fault tree's top is an OR over the components, a component of
    several units an OR of them (each needed) or an AND (redundant: one suffices).
    A component that several blocks name is one parameter.
    Blocks without `next` lead to the block that follows in call sequence, the last to `done`.
    `profile` replaces the `next` of the functions it names.
    The numbers of cycles are taken as fixed where every `next` was counted by the tool, as
    `is_counted` says, and none comes from the profile.
    Raises BlockError with the block's place when blocks contradict each other or lead nowhere,
    ModelError when the profile names an unknown function or does not sum to one.
    """
    if not blocks:
        raise BlockError(
            "no risk blocks; `tracerisk run FILE` writes them, or `tracerisk annotate FILE`"
        )
    _check_distinct(blocks)
    ordered = sorted(blocks, key=lambda block: block.call_sequence.value)
    # A dict keeps the order of the states and makes lookups fast.
    names = dict.fromkeys(block.name for block in ordered)
    chosen = _check_profile(profile or {}, names)
    steps = {}
    for block, following in zip(ordered, [*list(names)[1:], DONE], strict=True):
        if block.name in chosen:
            steps[block.name] = chosen[block.name]
        elif block.next is not None:
            steps[block.name] = _steps_of(block, block.next, names)
        else:
            steps[block.name] = (NextStep(following, Fraction(1)),)
    _check_end(ordered, steps)
    for block in ordered:
        _check_components(block)
    latent = {
        entry.name: block.name
        for block in ordered
        for entry in block.components
        if not entry.omitted and latent_units(entry)
    }
    for block in ordered:
        _check_failures(block, names, latent)
    states = [function_state(block, block.components, steps[block.name]) for block in ordered]
    entries = [entry for block in ordered for entry in block.components]
    counted = is_counted(blocks) and not chosen
    return model_of_states(name, ordered[0].name, states, entries, counted=counted)


def is_counted(blocks: Iterable[RiskBlock]) -> bool:
    """Whether the tool counted each `next` in one mission: shares like 9/10, none set by hand."""
    following = [block.next for block in blocks if block.next is not None]
    shares = [line.rpartition(" ")[2] for field in following for line in field.text.split(", ")]
    return (
        bool(following)
        and all(share.replace("/", "").isdigit() for share in shares)
        and not any(field.pinned for field in following)
    )


def model_of_states(
    name: str,
    entry: str,
    states: Sequence[FunctionState],
    components: Iterable[ComponentEntry],
    *,
    counted: bool = False,
) -> HybridModel:
    """Return the model of the states; the parameters are what their trees name.

    `components` are those of all states. A unit whose failure stays hidden after a visit of one
    function is the same failed unit in every other, however often a group is renewed there.
    Raises BlockError with its place when a group with spares is counted differently somewhere.
    """
    latent: dict[str, None] = {}
    groups = set()
    components = [component for component in components if not component.omitted]
    for component in components:
        units = latent_units(component)
        if units:
            latent |= dict.fromkeys(units)
            groups.add(component.name)
    _check_spares(components, groups)
    states = [_with_renewed_spares(state, latent) for state in states]
    if groups:
        states = [_with_first_units(state, groups) for state in states]
    return HybridModel(name, entry, tuple(states), _parameters(states), tuple(latent), counted)


def function_state(
    block: RiskBlock, components: Sequence[ComponentEntry], steps: tuple[NextStep, ...]
) -> FunctionState:
    """Return the state of a block with these components and this `next`."""
    return FunctionState(
        name=block.name,
        call_sequence=block.call_sequence.value,
        tree=function_fault_tree(block.name, components),
        probabilities={
            name: value
            for entry in components
            if not entry.omitted
            for name, value in component_figures(entry)
        },
        next=steps,
        spares={
            gate: spares
            for entry in components
            if not entry.omitted
            for gate, spares in component_spares(entry).items()
        },
        fates={
            entry.name: component_fates(entry.failures.value)
            for entry in components
            if entry.failures.value and not entry.omitted
        },
    )


def _check_spares(components: Sequence[ComponentEntry], groups: Collection[str]) -> None:
    """Raise BlockError where functions use another number of units of one group with spares."""
    quantities = {
        component.name: component.quantity.value
        for component in components
        if component_spares(component)
    }
    for component in components:
        expected = quantities.get(component.name, component.quantity.value)
        if component.name in groups and component.quantity.value != expected:
            raise BlockError(
                f"component '{component.name}': quantity is {component.quantity.value} "
                f"here, but {expected} in another function that keeps spares of it; use one "
                "quantity everywhere",
                component.quantity.location or component.location,
            )


def _with_renewed_spares(state: FunctionState, latent: Collection[str]) -> FunctionState:
    """Return the state with one event for each group with spares that no function keeps hidden."""
    renewed = [
        gate.name
        for gate in state.tree.gates
        if gate.name in state.spares and gate.inputs[0] not in latent
    ]
    return in_one_visit(state, renewed)


def _with_first_units(state: FunctionState, groups: Collection[str]) -> FunctionState:
    """Return the state with the first unit of a group where it counts one unit of it only."""
    single = {event.name for event in state.tree.events if event.name in groups}
    if not single:
        return state
    tree = FaultTree(
        state.tree.top,
        (
            *state.tree.gates,
            *(Gate(name, GateKind.OR, (unit_name(name, 1),)) for name in sorted(single)),
        ),
        tuple(
            replace(event, name=unit_name(event.name, 1)) if event.name in single else event
            for event in state.tree.events
        ),
    )
    return replace(state, tree=tree)


def _parameters(states: Sequence[FunctionState]) -> tuple[Parameter, ...]:
    greatest: dict[str, float] = {}
    for state in states:
        for name, value in state.probabilities.items():
            greatest[name] = max(value, greatest.get(name, 0.0))
    events = {event.parameter: event for state in states for event in state.tree.events}
    return tuple(
        Parameter(name, theta, component=events[name].component, share=events[name].share)
        for name, theta in sorted(greatest.items())
    )


def _check_distinct(blocks: Sequence[RiskBlock]) -> None:
    by_name: dict[str, RiskBlock] = {}
    by_sequence: dict[int, RiskBlock] = {}
    for block in blocks:
        if block.name == DONE:
            _fail(
                block,
                f"a function named '{DONE}' would be taken for the end of the mission; rename it",
            )
        if block.name in by_name:
            place = by_name[block.name].location
            _fail(block, f"duplicate block name{_also(place)}; rename or remove one")
        by_name[block.name] = block
        sequence = block.call_sequence.value
        if sequence in by_sequence:
            other = by_sequence[sequence]
            _fail(
                block,
                f"callSequence {sequence} is already used by "
                f"'{other.name}'{_also(other.location)}; "
                "give each function its own",
                block.call_sequence.location,
            )
        by_sequence[sequence] = block


def _steps_of(
    block: RiskBlock, following: Field[tuple[Transition, ...]], names: Collection[str]
) -> tuple[NextStep, ...]:
    place = following.location
    seen: set[str] = set()
    for transition in following.value:
        target = transition.target
        if target not in names and target != DONE:
            allowed = one_of([*names, DONE], target)
            _fail(block, f"next leads to '{target}', which has no block; {allowed}", place)
        if target in seen:
            _fail(block, f"next names '{target}' twice; add up the two", place)
        if transition.weight < 0:
            _fail(block, f"next {target} {transition.weight} is below zero", place)
        seen.add(target)
    total = sum((transition.weight for transition in following.value), Fraction(0))
    if total != 1:
        _fail(block, f"next sums to {total}; the lines of one function must sum to 1", place)
    return tuple(NextStep(transition.target, transition.weight) for transition in following.value)


def _check_profile(profile: Profile, names: Collection[str]) -> dict[str, tuple[NextStep, ...]]:
    chosen = {}
    for function, row in profile.items():
        if function not in names:
            raise ModelError(f"profile: '{function}' has no risk block; {one_of(names, function)}")
        for target, weight in row.items():
            if target not in names and target != DONE:
                raise ModelError(
                    f"profile of '{function}': '{target}' has no risk block; "
                    f"{one_of([*names, DONE], target)}"
                )
            if weight < 0:
                raise ModelError(f"profile of '{function}': {target}={weight} is below zero")
        total = sum(row.values(), Fraction(0))
        if total != 1:
            raise ModelError(
                f"profile of '{function}': the probabilities sum to {total}; they must sum to 1"
            )
        chosen[function] = tuple(NextStep(target, weight) for target, weight in row.items())
    return chosen


def _check_end(ordered: Sequence[RiskBlock], steps: Mapping[str, tuple[NextStep, ...]]) -> None:
    caught = endless_states(steps, ordered[0].name)
    if caught:
        block = next(block for block in ordered if block.name == caught[0])
        _fail(
            block,
            f"'{DONE}' cannot be reached from {', '.join(caught)}; add '{DONE}' to 'next' of one "
            "of them, or give a profile",
            None if block.next is None else block.next.location,
        )


def _check_components(block: RiskBlock) -> None:
    seen: set[str] = set()
    for entry in block.components:
        where = f"component '{entry.name}'"
        if entry.name in seen:
            _fail(block, f"duplicate {where}; remove one", entry.location)
        seen.add(entry.name)
        if entry.omitted:
            continue
        value = entry.probability.value
        if not 0.0 <= value <= 1.0:
            place = entry.probability.location or entry.location
            _fail(block, f"{where}: probability {value!r} is outside [0, 1]", place)
        if not 1 <= entry.quantity.value <= MAX_QUANTITY:
            place = entry.quantity.location or entry.location
            number = entry.quantity.value
            _fail(block, f"{where}: quantity is {number}; allowed: 1 to {MAX_QUANTITY}", place)
        required = entry.redundancy.value.required
        if required > entry.quantity.value:
            place = entry.redundancy.location or entry.location
            number = entry.quantity.value
            _fail(block, f"{where}: required {required} of {number}; allowed: 1 to {number}", place)


def _check_failures(block: RiskBlock, names: Collection[str], latent: Mapping[str, str]) -> None:
    """Raise BlockError where failures may not be said to lead to what a section says.

    `latent` gives a function in which units of a component fail unseen, by component.
    """
    for entry in block.components:
        place = entry.failures.location or entry.location
        where = f"what follows failures of '{entry.name}'"
        if not entry.failures.value or entry.omitted:
            continue
        if entry.redundancy.value and entry.quantity.value > 1:
            _fail(
                block,
                f"{where} can be given only where each unit is needed, and it is redundant; "
                "delete its `@Failure`",
                place,
            )
        if entry.name in latent:
            _fail(
                block,
                f"{where} can be given only where each unit is needed, and it is redundant in "
                f"'{latent[entry.name]}', where its units may have failed unseen; delete its "
                "`@Failure`",
                place,
            )
        for mode in entry.failures.value:
            for outcome in mode.outcomes:
                for name in (outcome.target, outcome.shows_in):
                    if name and name not in names:
                        allowed = one_of(names, name)
                        _fail(
                            block, f"{where} names '{name}', which has no block; {allowed}", place
                        )


def _fail(block: RiskBlock, message: str, place: Location | None = None) -> NoReturn:
    raise BlockError(f"function '{block.name}': {message}", place or block.location)


def _also(place: Location | None) -> str:
    return "" if place is None else f" (the other is at {place})"
