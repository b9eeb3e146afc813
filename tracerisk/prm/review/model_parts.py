"""A model taken apart, so that one change at a time can be made in it and solved."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from tracerisk.adder.blocks.block import ComponentEntry, RiskBlock
from tracerisk.adder.blocks.failures import renamed_text, with_renamed
from tracerisk.prm.hybrid.elements import FunctionState, NextStep
from tracerisk.prm.hybrid.from_blocks import build_model, function_state, model_of_states
from tracerisk.prm.hybrid.hybrid import HybridModel
from tracerisk.prm.hybrid.solve import ModelFigures, solve_figures
from tracerisk.prm.trees.fault_tree import FaultTree

Steps = tuple[NextStep, ...]


class RiskVersion(NamedTuple):
    """One version of a controller's risk model."""

    blocks: Mapping[str, RiskBlock]
    """Risk blocks by qualified name of the function."""
    model: HybridModel
    """Model that the blocks make."""
    figures: ModelFigures
    """Solution of the model."""

    @classmethod
    def of_blocks(cls, blocks: Sequence[RiskBlock], name: str) -> RiskVersion:
        """Build and solve the version's model; raise as `build_model` and `solve`."""
        model = build_model(blocks, name=name)
        return cls({block.name: block for block in blocks}, model, solve_figures(model))

    def read_as_geometric(self) -> RiskVersion:
        """Return the version with the mission read with a geometric number of cycles."""
        mission = self.figures.mission.as_geometric()
        return self._replace(
            model=replace(self.model, counted=False),
            figures=replace(self.figures, mission=mission),
        )

    def renamed(self, names: Mapping[str, str]) -> RiskVersion:
        """Return the version with new names for some of its functions."""
        if not names:
            return self
        blocks = [renamed_block(block, names) for block in self.blocks.values()]
        return RiskVersion.of_blocks(blocks, self.model.name)

    @property
    def states(self) -> dict[str, FunctionState]:
        """The model's states by name."""
        return {state.name: state for state in self.model.states}


def renamed_block(block: RiskBlock, names: Mapping[str, str]) -> RiskBlock:
    """Return a block with new names for functions, wherever it names one."""
    following = block.next
    if following is not None:
        steps = tuple(
            step._replace(target=names.get(step.target, step.target)) for step in following.value
        )
        text = ", ".join(
            f"{names.get(target, target)} {share}"
            for target, _, share in (line.rpartition(" ") for line in following.text.split(", "))
        )
        following = replace(following, value=steps, text=text)
    components = tuple(
        replace(
            entry,
            failures=replace(
                entry.failures,
                value=with_renamed(entry.failures.value, names),
                text=renamed_text(entry.failures.text, names),
            ),
        )
        if entry.failures.is_stated
        else entry
        for entry in block.components
    )
    name = names.get(block.name, block.name)
    return replace(block, name=name, next=following, components=components)


class ModelParts:
    """The entry, the `next` and the components of each function, each to be changed alone.

    Omitted components are left out, for they are no part of the model.
    """

    def __init__(self, version: RiskVersion) -> None:
        self._name = version.model.name
        self._counted = version.model.counted
        self.entry = version.model.entry
        self.blocks = dict(version.blocks)
        self.steps: dict[str, Steps] = {state.name: state.next for state in version.model.states}
        self.components = {name: counted_components(version.blocks[name]) for name in self.steps}

    def model(self) -> HybridModel:
        """Return the model that the parts make now; raise ModelError where they make none."""
        states = [self.state(name) for name in self.steps]
        entries = [
            components for name in self.steps for components in self.components[name].values()
        ]
        model = model_of_states(self._name, self.entry, states, entries)
        return replace(model, counted=self._counted)

    def state(self, function: str) -> FunctionState:
        """Return one function's state as the parts make it now."""
        components = tuple(self.components[function].values())
        return function_state(self.blocks[function], components, self.steps[function])

    def put(self, version: RiskVersion, function: str) -> None:
        """Take a whole function over from another version."""
        self.blocks[function] = version.blocks[function]
        self.steps[function] = version.states[function].next
        self.components[function] = counted_components(version.blocks[function])

    def drop(self, function: str) -> None:
        """Take a function out."""
        for part in (self.blocks, self.steps, self.components):
            del part[function]


def counted_components(block: RiskBlock) -> dict[str, ComponentEntry]:
    """Return the components that count, by name, in the order of the block."""
    return {entry.name: entry for entry in block.components if not entry.omitted}


def tolerated_failures(tree: FaultTree) -> dict[str, int]:
    """Return for each component how many of its units may fail before the top event happens.

    Where its units stand under several gates, it is the least. What hits all units at once, a
    parameter of its own, is not a unit.
    """
    above = {name: gate for gate in tree.gates for name in gate.inputs}
    least: dict[str, int] = {}
    components = {event.parameter: event.component for event in tree.events}
    for event in tree.events:
        tolerated, name = 0, event.name
        while name in above:
            tolerated = max(tolerated, above[name].threshold - 1)
            name = above[name].name
        least[event.parameter] = min(tolerated, least.get(event.parameter, tolerated))
    numbers: dict[str, int] = {}
    for parameter, tolerated in least.items():
        component = components[parameter]
        numbers[component] = max(tolerated, numbers.get(component, 0))
    return numbers


def single_points(model: HybridModel) -> dict[str, list[str]]:
    """Return each component one unit of which fails the mission alone, and in which functions.

    One that cannot fail in a function, with a probability of 0, is none there.
    """
    functions: dict[str, list[str]] = {}
    reached = set(model.reachable)
    for state in model.states:
        if state.name in reached:
            may_fail = {
                event.component
                for event in state.tree.events
                if state.probabilities.get(event.parameter, 0.0) > 0.0
            }
            for component, tolerated in tolerated_failures(state.tree).items():
                if tolerated == 0 and component in may_fail:
                    functions.setdefault(component, []).append(state.name)
    return functions
