"""Expressions of Open-PSA's stochastic layer: from elements, and to elements."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from tracerisk.errors import ModelError
from tracerisk.prm.other_models.expressions.arithmetic import (
    FUNCTIONS,
    Call,
    Difference,
    Negation,
    Product,
    Quotient,
    Sum,
)
from tracerisk.prm.other_models.expressions.node import Expression, MissionTime, Number, Reference
from tracerisk.prm.other_models.formats.open_psa.xml_elements import GREATEST_DEPTH, Element

UNITS = ("bool", "int", "float", "hours", "hours-1", "years", "years-1", "fit", "demands")

Resolve = Callable[[Element], str]
"""Gives the full name of the parameter that an element refers to."""

# By name, for a model of plain numbers needs neither laws nor deviates.
_FIXED: dict[str, tuple[str, int]] = {
    "neg": ("Negation", 1),
    "exponential": ("Exponential", 2),
    "GLM": ("Glm", 4),
    "Weibull": ("Weibull", 4),
    "uniform-deviate": ("UniformDeviate", 2),
    "normal-deviate": ("NormalDeviate", 2),
    "gamma-deviate": ("GammaDeviate", 2),
    "beta-deviate": ("BetaDeviate", 2),
}
_VARIED: dict[str, str] = {
    "add": "Sum",
    "sub": "Difference",
    "mul": "Product",
    "div": "Quotient",
    "periodic-test": "PeriodicTest",
    "lognormal-deviate": "LognormalDeviate",
}
_NUMBERS = ("float", "int", "bool")
_OTHERS = ("parameter", "system-mission-time", "histogram", "switch")
TAGS = frozenset((*_FIXED, *_VARIED, *_NUMBERS, *_OTHERS, *FUNCTIONS))
"""The elements that are expressions."""

_TAG_OF: dict[str, str] = {kind: tag for tag, (kind, _) in _FIXED.items()} | {
    kind: tag for tag, kind in _VARIED.items()
}


def read_expression(element: Element, resolve: Resolve) -> Expression:
    """Return the expression that an element is.

    Raises ModelError, with the position, when it is none or is malformed.
    """
    tag = element.tag
    if tag == "float":
        return Number(read_float(element))
    if tag == "parameter":
        _check_unit(element, UNITS)
        return Reference(resolve(element))
    if tag in _NUMBERS:
        return Number(read_int(element) if tag == "int" else float(read_bool(element)), tag)
    if tag == "system-mission-time":
        _check_unit(element, ("hours",))
        return MissionTime()
    if tag not in TAGS:
        element.unexpected(TAGS)
    if tag == "histogram":
        return _read_histogram(element, resolve)
    if tag == "switch":
        terms = _read_switch(element, resolve)
    else:
        terms = [read_expression(child, resolve) for child in element.children]
    try:
        if tag in _FIXED:
            kind, count = _FIXED[tag]
            if len(terms) != count:
                element.fail(f"<{tag}> has {len(terms)} arguments; allowed: {count}")
            return _kind(kind)(*terms)
        if tag in _VARIED:
            return _kind(_VARIED[tag])(tuple(terms))
        return Call(tag, tuple(terms))
    except ModelError as error:
        raise ModelError(error.message, error.location or element.location) from error


def _kind(name: str) -> Callable[..., Expression]:
    """Return the class of a name; laws and deviates are imported for them alone."""
    for kind in (Difference, Negation, Product, Quotient, Sum):
        if kind.__name__ == name:
            return kind
    from tracerisk.prm.other_models.expressions import deviates, laws

    result: Callable[..., Expression] = getattr(laws, name, None) or getattr(deviates, name)
    return result


def read_float(element: Element, attribute: str = "value") -> float:
    """Return an attribute as a finite number, or raise ModelError."""
    text = element.attribute(attribute)
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value) or "_" in text:
        element.fail(f"<{element.tag}> has the {attribute} '{text}'; give a finite number")
    return value


def read_int(element: Element, attribute: str = "value") -> int:
    """Return an attribute as a whole number, or raise ModelError."""
    text = element.attribute(attribute)
    # Bounded, for a number of a million digits takes hours to read.
    if not text.lstrip("+-").isdecimal() or len(text) > 15:
        element.fail(f"<{element.tag}> has the {attribute} '{text[:30]}'; give a whole number")
    return int(text)


def read_bool(element: Element) -> bool:
    """Return the attribute `value` as a truth value, or raise ModelError."""
    text = element.attribute("value")
    if text not in ("true", "false", "1", "0"):
        element.fail(f"<{element.tag}> has the value '{text}'; allowed: false, true")
    return text in ("true", "1")


def _check_unit(element: Element, allowed: Sequence[str]) -> None:
    unit = element.attributes.get("unit")
    if unit is not None and unit not in allowed:
        element.fail(f"<{element.tag}> has the unit '{unit}'; allowed: {', '.join(allowed)}")


def _read_histogram(element: Element, resolve: Resolve) -> Expression:
    if len(element.children) < 2:
        element.fail("<histogram> needs its lower boundary and at least one <bin>")
    first, *bins = element.children
    boundaries = [read_expression(first, resolve)]
    weights = []
    for item in bins:
        if item.tag != "bin" or len(item.children) != 2:
            item.fail("a histogram takes <bin> elements of an upper boundary and a weight")
        boundaries.append(read_expression(item.children[0], resolve))
        weights.append(read_expression(item.children[1], resolve))
    return _kind("Histogram")(tuple(boundaries), tuple(weights))


def _read_switch(element: Element, resolve: Resolve) -> list[Expression]:
    terms = []
    for child in element.children:
        if child.tag == "case":
            if len(child.children) != 2:
                child.fail("<case> takes a condition and a value")
            terms += [read_expression(item, resolve) for item in child.children]
        else:
            terms.append(read_expression(child, resolve))
    return terms


Node = tuple[str, dict[str, str], list["Node"]]
"""An element to be written: its tag, attributes and children."""


def constant_node(state: bool) -> Node:
    """Return the constant that always happens, or never."""
    return "constant", {"value": "true" if state else "false"}, []


def expression_node(expression: Expression, name_of: Callable[[str], str], depth: int = 0) -> Node:
    """Return the element of an expression; `name_of` gives the written name of a parameter.

    Raises ModelError when Open-PSA has no such expression.
    """
    if isinstance(expression, Number):
        return _number_node(expression)
    if isinstance(expression, Reference):
        return "parameter", {"name": name_of(expression.name)}, []
    if isinstance(expression, MissionTime):
        return "system-mission-time", {}, []
    if depth > GREATEST_DEPTH // 2:
        raise ModelError(
            f"an expression nests more than {GREATEST_DEPTH // 2} deep; make parts of it parameters"
        )
    parts = [expression_node(argument, name_of, depth + 1) for argument in expression.arguments]
    if len(parts) == 1 and _is_its_term(expression):
        # SCRAM takes two or more.
        return parts[0]
    from tracerisk.prm.other_models.expressions.deviates import Histogram

    if isinstance(expression, Histogram):
        count = len(expression.boundaries)
        bins: list[Node] = [
            ("bin", {}, [bound, weight])
            for bound, weight in zip(parts[1:count], parts[count:], strict=True)
        ]
        return "histogram", {}, [parts[0], *bins]
    if isinstance(expression, Call):
        if expression.function == "switch":
            cases: list[Node] = [
                ("case", {}, [test, value])
                for test, value in zip(parts[:-1:2], parts[1::2], strict=True)
            ]
            return "switch", {}, [*cases, parts[-1]]
        return expression.function, {}, parts
    tag = _TAG_OF.get(type(expression).__name__)
    if tag is None:
        raise ModelError(
            f"Open-PSA cannot express {type(expression).__name__}; give the figure as a number"
        )
    return tag, {}, parts


def _is_its_term(expression: Expression) -> bool:
    """Whether an operation on any number of terms is, on one, that term."""
    if isinstance(expression, Call):
        return expression.function in ("min", "max", "mean", "switch")
    return isinstance(expression, Sum | Difference | Product | Quotient)


def _number_node(number: Number) -> Node:
    value = number.number
    if number.form == "bool":
        return "bool", {"value": "true" if value else "false"}, []
    if number.form == "int":
        return "int", {"value": str(int(value))}, []
    return "float", {"value": repr(float(value))}, []
