"""The values of the constants of a PRISM text, in whichever order they stand."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.other_models.formats.prism.evaluation import Scope, names_in
from tracerisk.prm.other_models.formats.prism.expressions import Expression
from tracerisk.prm.other_models.formats.prism.operations import Value
from tracerisk.prm.other_models.formats.prism.program import Constant


def constant_scope(
    constants: Sequence[Constant], formulas: Mapping[str, Expression], given: Mapping[str, Value]
) -> Scope:
    """Return a scope with the value of each constant; `given` go before those of the text.

    Raises ModelError for an unknown or open constant, and for one that is defined in terms of
    itself.
    """
    declared = {constant.name: constant for constant in constants}
    for name in given:
        if name not in declared:
            raise ModelError(f"unknown constant '{name}'; {one_of(declared, name)}")
    scope = Scope(formulas=formulas)
    for name in _in_order(declared, formulas, given):
        scope.constants[name] = _value(declared[name], scope, given)
    return scope


def known_constants(
    constants: Sequence[Constant], formulas: Mapping[str, Expression]
) -> dict[str, Value]:
    """Return the constants that stand in the text as numbers or can be computed from such."""
    declared = {constant.name: constant for constant in constants}
    scope = Scope(formulas=formulas)
    for name in _in_order(declared, formulas, {}):
        try:
            scope.constants[name] = _value(declared[name], scope, {})
        except ModelError:
            continue  # an open constant, or one that is made of it
    return scope.constants


def _in_order(
    declared: Mapping[str, Constant],
    formulas: Mapping[str, Expression],
    given: Mapping[str, Value],
) -> list[str]:
    """Return the constants, each behind those that it is made of."""
    ordered: list[str] = []
    done: set[str] = set()
    inside: set[str] = set()
    for first in declared:
        waiting = [first]
        while waiting:
            name = waiting[-1]
            needs = [] if name in done or name in given else _needs(name, declared, formulas)
            missing = [other for other in needs if other not in done]
            if name not in done and missing and name not in inside:
                inside.add(name)
                waiting += missing
                continue
            if missing and any(other in inside for other in missing) and name in declared:
                raise ModelError(
                    f"constant '{name}' is defined in terms of itself", declared[name].location
                )
            waiting.pop()
            inside.discard(name)
            if name not in done:
                done.add(name)
                if name in declared:
                    ordered.append(name)
    return ordered


def _needs(
    name: str, declared: Mapping[str, Constant], formulas: Mapping[str, Expression]
) -> list[str]:
    made = declared[name].value if name in declared else formulas[name]
    if made is None:
        return []
    fromkeys = dict.fromkeys(names_in(made))
    return [other for other in fromkeys if other in declared or other in formulas]


def _value(constant: Constant, scope: Scope, given: Mapping[str, Value]) -> Value:
    name = constant.name
    if name in given:
        value = given[name]
    elif constant.value is None:
        raise ModelError(f"constant '{name}' has no value; give one", constant.location)
    else:
        value = scope.value(constant.value)
        if constant.type in ("double", "rate", "prob") and not isinstance(value, bool):
            try:
                value = float(value)
            except OverflowError as error:
                raise ModelError(f"constant '{name}' is too large", constant.location) from error
    return value
