"""Distributions of parameters as JSON values: an object with one key, the kind."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields
from functools import partial
from typing import Any

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.formats.element import Element
from tracerisk.prm.numbers.distributions import (
    Beta,
    Distribution,
    Gamma,
    Lognormal,
    Normal,
    Uniform,
)


def distribution_to_json(distribution: Distribution) -> dict[str, Any]:
    """Return a distribution as plain JSON values; raise ModelError for one of an unknown kind."""
    if isinstance(distribution, Lognormal):
        written = {"errorFactor": distribution.error_factor, "valueIs": distribution.value_is}
        return {"lognormal": written}
    kind = _KINDS.get(type(distribution))
    if kind is None:
        raise ModelError(f"{type(distribution).__name__} cannot be written to the JSON of a model")
    if isinstance(distribution, Uniform) and distribution.log:
        kind = "loguniform"
    values = [getattr(distribution, entry.name) for entry in fields(distribution)]  # type: ignore[arg-type]
    return {kind: dict(zip(_PLAIN[kind][1], values, strict=False))}


def read_distribution(element: Element) -> Distribution:
    """Return the distribution that an element states.

    Raises ModelError with its path and place when it states none.
    """
    entries = element.entries()
    names = ("lognormal", *_PLAIN)
    if len(entries) != 1:
        element.fail(f"expected one key; {one_of(names)}")
    ((name, inner),) = entries.items()
    if name not in names:
        element.fail(f"unknown distribution '{name}'; {one_of(names, name)}")
    if name == "lognormal":
        stated = inner.fields(("errorFactor",), optional=("valueIs",))
        return inner.guard(lambda: _lognormal(stated))
    make, keys = _PLAIN[name]
    fields = inner.fields(keys)
    return inner.guard(lambda: make(*(fields[key].number() for key in keys)))


def _lognormal(fields: Mapping[str, Element]) -> Lognormal:
    if "valueIs" not in fields:
        return Lognormal(fields["errorFactor"].number())
    stated = fields["valueIs"].choice(("mean", "median"))
    return Lognormal(fields["errorFactor"].number(), "mean" if stated == "mean" else "median")


_PLAIN: dict[str, tuple[Callable[..., Distribution], tuple[str, ...]]] = {
    "uniform": (Uniform, ("low", "high")),
    "loguniform": (partial(Uniform, log=True), ("low", "high")),
    "beta": (Beta, ("alpha", "beta")),
    "gamma": (Gamma, ("shape", "scale")),
    "normal": (Normal, ("mean", "deviation")),
}
"""What takes numbers alone, with their keys in order."""
_KINDS: dict[type, str] = {Uniform: "uniform", Beta: "beta", Gamma: "gamma", Normal: "normal"}
