"""The linked model: parameters, fault trees and Markov chains that take figures of one another."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from tracerisk.common.strong_components import upwards
from tracerisk.errors import ModelError, one_of
from tracerisk.prm.display import AsGraph
from tracerisk.prm.numbers.quantities import check_names
from tracerisk.prm.other_models.expressions import Expression, MissionTime, Number
from tracerisk.prm.other_models.linked.chain_solution import ChainToSolve, chain_to_solve
from tracerisk.prm.other_models.linked.derivative_tape import Tape
from tracerisk.prm.other_models.linked.elements import (
    Figure,
    LinkedChain,
    LinkedTree,
    ModelParameter,
    check_mission_time,
)
from tracerisk.prm.other_models.linked.links import ElementKey, Link, Occupancy, leaf_key
from tracerisk.prm.other_models.linked.tree_solution import TreeToSolve, tree_to_solve

if TYPE_CHECKING:
    from tracerisk.prm.other_models.linked.solution import LinkedSolution


Solvable = ChainToSolve | TreeToSolve
"""An element made ready for solving; its `inputs` are the expressions that it needs."""


@dataclass(frozen=True, slots=True)
class Prepared:
    """An element as it is solved."""

    key: ElementKey
    """What identifies the element."""
    element: Solvable | None
    """The fault tree or chain made ready for solving; `None` for a parameter."""
    tapes: tuple[Tape, ...]
    """Tapes of the expressions that it needs, in the order of its inputs."""


@dataclass(frozen=True, slots=True)
class LinkedModel(AsGraph):
    """A risk model of parameters, fault trees and Markov chains, joined by expressions.

    Raises ModelError, naming the element, when a name is used twice or unknown, elements depend
    on one another in a cycle, a chain lacks a state that is asked for, or a mission time is
    needed and not given.
    """

    name: str
    """Name of the model."""
    parameters: tuple[ModelParameter, ...] = ()
    """Named figures that expressions refer to."""
    trees: tuple[LinkedTree, ...] = ()
    """Fault trees."""
    chains: tuple[LinkedChain, ...] = ()
    """Markov chains."""
    figures: tuple[Figure, ...] = ()
    """Results of the model, with unique names."""
    mission_time_h: float | None = None
    """Length of the mission [h]; `None` where no expression or chain needs it."""
    prepared: tuple[Prepared, ...] = field(init=False, repr=False, compare=False)
    """Elements ready for solving, each after those that it takes figures of."""
    figure_tapes: Mapping[str, Tape] = field(init=False, repr=False, compare=False)
    """Tapes of the figures by name."""

    def __post_init__(self) -> None:
        check_mission_time(self.mission_time_h)
        for kind, names in (
            ("parameter", [parameter.name for parameter in self.parameters]),
            ("fault tree", [tree.name for tree in self.trees]),
            ("Markov chain", [chain.name for chain in self.chains]),
            ("figure", [item.name for item in self.figures]),
        ):
            check_names(kind, names)
        made = self._prepare()
        for key, prepared in made.items():
            for tape in prepared.tapes:
                self._check(str(key), tape, made)
        tapes = {figure.name: Tape.of(figure.value) for figure in self.figures}
        for name, tape in tapes.items():
            self._check(f"figure '{name}'", tape, made)
        object.__setattr__(self, "figure_tapes", tapes)
        object.__setattr__(self, "prepared", tuple(made[key] for key in _ordered(made)))

    def parameter(self, name: str) -> ModelParameter:
        """Return the parameter of a name; raise ModelError when there is none."""
        for parameter in self.parameters:
            if parameter.name == name:
                return parameter
        names = [parameter.name for parameter in self.parameters]
        raise ModelError(f"no parameter '{name}' in '{self.name}'; {one_of(names, name)}")

    def with_values(self, values: Mapping[str, float]) -> LinkedModel:
        """Return the model with parameters set to numbers; a distribution stays about them.

        Raises ModelError when a name is unknown or a number is not finite.
        """
        for name in values:
            self.parameter(name)
        parameters = tuple(
            replace(parameter, value=Number(values[parameter.name]))
            if parameter.name in values
            else parameter
            for parameter in self.parameters
        )
        return replace(self, parameters=parameters)

    def solve(self, values: Mapping[str, float] | None = None) -> LinkedSolution:
        """Solve every element once, in the order of their links.

        `values` stand in for those of parameters.
        Raises ModelError, naming the element, when a name is unknown, a probability is outside
        [0, 1], a row does not sum to one or a chain never ends.
        """
        from tracerisk.prm.other_models.linked.solution import LinkedSolution

        return LinkedSolution(self, dict(values or {}))

    def tape_of(self, figure: str | Expression) -> Tape:
        """Return the tape of a figure, by its name or as an expression over the elements.

        Raises ModelError when there is no such figure, or it refers to what is not there.
        """
        if isinstance(figure, str):
            if figure not in self.figure_tapes:
                raise ModelError(
                    f"no figure '{figure}' in '{self.name}'; {one_of(self.figure_tapes, figure)}"
                )
            return self.figure_tapes[figure]
        tape = Tape.of(figure)
        self._check("the figure", tape, {prepared.key: prepared for prepared in self.prepared})
        return tape

    def _prepare(self) -> dict[ElementKey, Prepared]:
        made: dict[ElementKey, Prepared] = {}
        for parameter in self.parameters:
            made[parameter.key] = Prepared(parameter.key, None, (Tape.of(parameter.value),))
        trees = {tree.name: tree for tree in self.trees}
        elements: list[tuple[ElementKey, Solvable]] = [
            *((tree.key, tree_to_solve(tree, trees)) for tree in self.trees),
            *((chain.key, chain_to_solve(chain)) for chain in self.chains),
        ]
        for key, element in elements:
            tapes = tuple(Tape.of(expression) for expression in element.inputs)
            made[key] = Prepared(key, element, tapes)
        return made

    def _check(self, where: str, tape: Tape, made: Mapping[ElementKey, Prepared]) -> None:
        """Raise ModelError when an expression refers to what the model has not."""
        for node in tape.nodes:
            needs_time = isinstance(node, MissionTime)
            key = leaf_key(node)
            if key is not None:
                if key not in made:
                    names = [
                        element_key.name for element_key in made if element_key.kind == key.kind
                    ]
                    raise ModelError(f"{where}: there is no {key}; {one_of(names, key.name)}")
                element = made[key].element
                if element is not None and isinstance(node, Link):
                    try:
                        element.check(node)
                    except ModelError as error:
                        raise ModelError(f"{where}: {error.message}") from error
                needs_time = (
                    isinstance(node, Occupancy) and node.steps is None and node.time_h is None
                )
            if needs_time and self.mission_time_h is None:
                raise ModelError(f"{where}: needs the mission time; give the model one, in hours")


def _ordered(made: Mapping[ElementKey, Prepared]) -> list[ElementKey]:
    """Return the elements, each after those that it takes figures of; iterative, for any depth."""

    def below(key: ElementKey) -> list[ElementKey]:
        keys = {leaf_key(leaf): None for tape in made[key].tapes for leaf in tape.leaves}
        return [item for item in keys if item is not None]

    def cycle(path: list[ElementKey]) -> ModelError:
        shown = " -> ".join(map(str, path[path.index(path[-1]) :]))
        return ModelError(f"elements depend on each other: {shown}; break the cycle")

    return upwards(made, below, cycle)
