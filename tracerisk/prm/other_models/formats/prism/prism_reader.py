"""The chain of a text in the PRISM language, with its rewards and what its names mean."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from tracerisk.common.strong_components import upwards
from tracerisk.errors import ModelError
from tracerisk.prm.other_models.formats.explicit_chain import (
    INITIAL,
    ExplicitChain,
    names_from_labels,
)
from tracerisk.prm.other_models.formats.prism.constants import constant_scope, known_constants
from tracerisk.prm.other_models.formats.prism.evaluation import Scope, State, names_in
from tracerisk.prm.other_models.formats.prism.expressions import Expression
from tracerisk.prm.other_models.formats.prism.operations import Value
from tracerisk.prm.other_models.formats.prism.program import parse_program
from tracerisk.prm.other_models.formats.prism.state_space import MOST_STATES, StateSpace

__all__ = ["MOST_STATES", "PrismModel", "constant_values", "read_prism", "read_prism_model"]


@dataclass(frozen=True, slots=True)
class PrismModel:
    """A chain with the variables that its states stand for."""

    chain: ExplicitChain
    """The chain."""
    states: tuple[State, ...]
    """Values of the variables in each state, (n_states, n_variables)."""
    scope: Scope
    """What names mean in expressions over the states."""


def read_prism(
    text: str,
    *,
    file: str = "model",
    constants: Mapping[str, Value] | None = None,
    most_states: int = MOST_STATES,
) -> ExplicitChain:
    """Return the chain of a dtmc or ctmc in the PRISM language.

    Read are constants, formulas, global and module variables, modules, renamed modules, commands
    alone and with actions, labels, rewards, and several starts by `init`.
    `constants` gives those that the text leaves open. Where several commands of a dtmc hold in
    a state, each is taken equally often, as PRISM and Storm do. States are named by the first
    label that they have alone, else by the values of their variables.
    Raises ModelError with the position of what is malformed, not read, or has no value;
    TooLargeError beyond `most_states` states, or where they take too much work to find.
    """
    return read_prism_model(text, file=file, constants=constants, most_states=most_states).chain


def read_prism_model(
    text: str,
    *,
    file: str = "model",
    constants: Mapping[str, Value] | None = None,
    most_states: int = MOST_STATES,
) -> PrismModel:
    """Return the chain of a text, and what properties of it are computed by; see `read_prism`."""
    program = parse_program(text, file)
    scope = constant_scope(program.constants, program.formulas, constants or {})
    space = StateSpace(program, scope, most_states)
    explore = space.explore()
    initial = frozenset(range(explore.starts))
    absorbing = frozenset(number for number, row in enumerate(explore.rows) if not row)
    known = {INITIAL: initial, "deadlock": absorbing}
    for label in _labels_upwards(program.labels):
        known[label] = space.holding(program.labels[label], f'label "{label}"', known)
    labels = {label: known[label] for label in (INITIAL, *program.labels)}
    names = names_from_labels(
        len(explore.states), labels, [space.valuation(state) for state in explore.states]
    )
    chain = ExplicitChain(
        program.kind,
        0,
        explore.rows,
        labels,
        names,
        tuple(space.notes),
        tuple(sorted(initial)) if len(initial) > 1 else (),
        explore.rewards,
    )
    return PrismModel(chain, explore.states, scope)


def _labels_upwards(labels: Mapping[str, Expression]) -> list[str]:
    """Return the labels, each behind those that stand in it.

    Raises ModelError where one is defined in terms of itself.
    """

    def below(label: str) -> list[str]:
        return [name for name in names_in(labels[label], "label") if name in labels]

    def cycle(path: list[str]) -> ModelError:
        return ModelError(
            f'label "{path[-1]}" is defined in terms of itself', labels[path[-1]].location
        )

    return upwards(labels, below, cycle)


def constant_values(text: str, file: str) -> dict[str, Value]:
    """Return the constants that stand in the text as numbers or can be computed from such.

    Raises ModelError with the position of what is malformed.
    """
    program = parse_program(text, file)
    return known_constants(program.constants, program.formulas)
