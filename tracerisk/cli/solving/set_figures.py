"""The figures that `--set` sets in a model of functions."""

from __future__ import annotations

import argparse
import math
from pathlib import Path

from tracerisk.cli.solving.figure_options import RATE, is_rate, number, parse_set, probability
from tracerisk.common.hardware.formats import read_description
from tracerisk.errors import InputError, one_of
from tracerisk.prm.hybrid.hybrid import HybridModel
from tracerisk.prm.questions.set_values import SetValue, set_values, value_of, with_values

_UNITS_H = {"h": 1.0, "min": 1.0 / 60.0, "s": 1.0 / 3600.0}
"""Units of time in which `--set` takes rates [h]."""


def set_in(model: HybridModel, options: argparse.Namespace) -> tuple[HybridModel, list[SetValue]]:
    """Return the model with the values of `--set`, and what was set.

    Raises InputError when a value is malformed, or a name unknown.
    """

    def figure(text: str, where: str) -> float:
        name = where.removeprefix("--set ").rpartition("=")[0]
        if is_rate(name, text):
            component = name.removesuffix(RATE)
            factor = _rate(text, where) / _own_rate(component, where, options)
            return probability(repr(factor * value_of(model, component)), where)
        if not text.startswith("x") or text == "x":
            return probability(text, where)
        return probability(repr(number(text[1:], where) * value_of(model, name)), where)

    values: dict[str, float] = {}
    for text in options.set_values:
        for name, value in parse_set([text], figure).items():
            component = name.removesuffix(RATE) if is_rate(name, text.rpartition("=")[2]) else name
            if component in values:
                raise InputError(f"--set names '{component}' twice; set it once")
            values[component] = value
    return with_values(model, values), list(set_values(model, values))


def _rate(text: str, where: str) -> float:
    """Return a rate per hour, such as `5e-7/h`."""
    value, _, unit = text.rpartition("/")
    if unit not in _UNITS_H:
        raise InputError(f"{where}: '{unit}' is not a unit of time; allowed: {', '.join(_UNITS_H)}")
    rate = number(value, where) / _UNITS_H[unit]
    if not 0.0 <= rate < math.inf:
        raise InputError(f"{where}: the rate {value} is not one of 0 or more")
    return rate


def _own_rate(name: str, where: str, options: argparse.Namespace) -> float:
    """Return the rate per hour that a hardware description has for a component."""
    if options.hardware is None:
        raise InputError(f"{where}: say with --hardware FILE which rate it takes the place of")
    hardware = read_description(Path(options.hardware), system=options.system)
    components = {component.name: component for component in hardware.components}
    if name not in components:
        raise InputError(f"{where}: no component '{name}'; {one_of(components, name)}")
    figures = components[name].figures
    seconds = figures[0].per.seconds if len(figures) == 1 else None
    if seconds is None or figures[0].kind == "weibull" or figures[0].value <= 0.0:
        raise InputError(
            f"{where}: '{name}' has not one figure per time in {hardware.file}; "
            f"set its probability, or a factor: {name}=x2"
        )
    return figures[0].value * 3600.0 / seconds
