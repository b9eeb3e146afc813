"""A linked model solved: its figures, their derivatives by every parameter, their exact changes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from tracerisk.errors import ModelError
from tracerisk.prm.numbers.probability import Probability
from tracerisk.prm.other_models.expressions import Expression, Reference
from tracerisk.prm.other_models.expressions.rules import apart
from tracerisk.prm.other_models.linked.chain_solution import SolvedChain
from tracerisk.prm.other_models.linked.derivative_tape import Tape
from tracerisk.prm.other_models.linked.links import ElementKey, Link, leaf_key
from tracerisk.prm.other_models.linked.tree_solution import SolvedTree

if TYPE_CHECKING:
    from tracerisk.prm.other_models.linked.model import LinkedModel, Prepared

TapeValues = tuple[Probability, ...]


class LinkedSolution:
    """The elements of a model, solved for one assignment of its parameters."""

    def __init__(self, model: LinkedModel, values: Mapping[str, float]) -> None:
        for name, value in values.items():
            model.parameter(name)
            if not math.isfinite(value):
                raise ModelError(f"parameter '{name}' is set to {value!r}; give a finite number")
        self.model = model
        self._set = values
        # Never used where no expression asks for it: the model has checked that.
        self._time_h = model.mission_time_h if model.mission_time_h is not None else math.nan
        self._tapes: dict[ElementKey, tuple[TapeValues, ...]] = {}
        self._parameters: dict[str, Probability] = {}
        self._elements: dict[ElementKey, SolvedChain | SolvedTree] = {}
        self._links: dict[Expression, Probability] = {}
        for prepared in model.prepared:
            self._solve_one(prepared)

    @property
    def parameters(self) -> dict[str, float]:
        """The value of each parameter."""
        return {
            parameter.name: self._parameters[parameter.name].p
            for parameter in self.model.parameters
        }

    @property
    def figures(self) -> dict[str, float]:
        """The value of each figure."""
        return {figure.name: self.figure(figure.name).p for figure in self.model.figures}

    def figure(self, figure: str | Expression) -> Probability:
        """Return a figure and its complement, by name or as an expression over the elements.

        Raises ModelError when there is no such figure, or it has no value.
        """
        return self._evaluated(self.model.tape_of(figure))[-1]

    def sensitivities(self, figure: str | Expression) -> dict[str, float]:
        """Return the derivative of a figure by every parameter, by one pass backwards.

        A parameter that is defined by others counts as if it were set to its value.
        """
        tape = self.model.tape_of(figure)
        weights: dict[Expression, float] = {}
        pending: dict[ElementKey, list[Expression]] = {}
        fromkeys = dict.fromkeys((parameter.name for parameter in self.model.parameters), 0.0)

        def add(leaf: Expression, weight: float) -> None:
            if leaf not in weights:
                key = leaf_key(leaf)
                assert key is not None
                pending.setdefault(key, []).append(leaf)
                weights[leaf] = 0.0
            weights[leaf] += weight

        for leaf, weight in tape.pull(self._evaluated(tape), 1.0, self._time_h):
            add(leaf, weight)
        for prepared in reversed(self.model.prepared):
            key = prepared.key
            leaves = pending.get(key, [])
            if not leaves:
                continue
            if prepared.element is None:
                slopes = [math.fsum(weights[leaf] for leaf in leaves)]
                fromkeys[key.name] = slopes[0]
            else:
                slopes = [0.0] * len(prepared.tapes)
                for leaf in leaves:
                    assert isinstance(leaf, Link)
                    for place, slope in enumerate(self._elements[key].gradient(leaf)):
                        slopes[place] += weights[leaf] * slope
            if prepared.element is None and key.name in self._set:
                continue
            for below, values, slope in zip(prepared.tapes, self._tapes[key], slopes, strict=True):
                for leaf, weight in below.pull(values, slope, self._time_h):
                    add(leaf, weight)
        return fromkeys

    def change_from(self, low: LinkedSolution, figure: str | Expression) -> float:
        """Return a figure less that of another solution of the same model.

        The difference is taken where the parameters differ and carried through every link: it
        keeps its relative precision beside a figure of any size.
        """
        asked = self.model.tape_of(figure)
        leaves: dict[ElementKey, dict[Expression, None]] = {}
        for tape in (*(item for p in self.model.prepared for item in p.tapes), asked):
            for leaf in tape.leaves:
                key = leaf_key(leaf)
                assert key is not None
                leaves.setdefault(key, {})[leaf] = None
        changes: dict[Expression, float] = {}
        for prepared in self.model.prepared:
            key = prepared.key
            tapes = zip(prepared.tapes, self._tapes[key], low._tapes[key], strict=True)
            grown = [
                tape.change(high_values, low_values, changes, self._time_h)
                for tape, high_values, low_values in tapes
            ]
            for leaf in leaves.get(key, {}):
                if isinstance(leaf, Link):
                    if any(grown):
                        below: Any = low._elements[key]  # of the same kind: one model made both
                        changes[leaf] = self._elements[key].change(below, grown, leaf)
                elif key.name in self._set or key.name in low._set:
                    changes[leaf] = apart(self._parameters[key.name], low._parameters[key.name])
                else:
                    changes[leaf] = grown[0]
        return asked.change(self._evaluated(asked), low._evaluated(asked), changes, self._time_h)

    def _solve_one(self, prepared: Prepared) -> None:
        key = prepared.key
        try:
            values = tuple(self._evaluated(tape) for tape in prepared.tapes)
        except ModelError as error:
            raise ModelError(f"{key}: {error.message}", error.location) from error
        self._tapes[key] = values
        results = [probabilities[-1] for probabilities in values]
        if prepared.element is not None:
            self._elements[key] = prepared.element.solve(results, self._time_h)
        elif key.name in self._set:
            value = self._set[key.name]
            self._parameters[key.name] = Probability(value, 1.0 - value)
        else:
            self._parameters[key.name] = results[0]

    def _evaluated(self, tape: Tape) -> TapeValues:
        return tape.values(self._value, self._time_h)

    def _value(self, leaf: Expression) -> Probability:
        """Return what a node that refers to an element stands for."""
        if isinstance(leaf, Reference):
            return self._parameters[leaf.name]
        assert isinstance(leaf, Link)
        if leaf not in self._links:
            self._links[leaf] = self._elements[leaf.element].figure(leaf)
        return self._links[leaf]
