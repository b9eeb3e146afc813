"""Distributions of parameters as JSON values: an object with one key, the kind."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
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
        fields = {"errorFactor": distribution.error_factor, "valueIs": distribution.value_is}
        return {"lognormal": fields}
    if isinstance(distribution, Uniform):
        kind = "loguniform" if distribution.log else "uniform"
        return {kind: {"low": distribution.low, "high": distribution.high}}
    if isinstance(distribution, Beta):
        return {"beta": {"alpha": distribution.alpha, "beta": distribution.beta}}
    if isinstance(distribution, Gamma):
        return {"gamma": {"shape": distribution.shape, "scale": distribution.scale}}
    if isinstance(distribution, Normal):
        fields = {"mean": distribution.mean_value, "deviation": distribution.deviation}
        return {"normal": fields}
    raise ModelError(f"{type(distribution).__name__} has no place in the JSON of models")


def read_distribution(element: Element) -> Distribution:
    """Return the distribution that an element states.

    Raises ModelError with its path and place when it states none.
    """
    entries = element.entries()
    if len(entries) != 1:
        element.fail(f"expected one key; {one_of(_DISTRIBUTIONS)}")
    ((name, inner),) = entries.items()
    if name not in _DISTRIBUTIONS:
        element.fail(f"unknown distribution '{name}'; {one_of(_DISTRIBUTIONS, name)}")
    required, optional, make = _DISTRIBUTIONS[name]
    fields = inner.fields(required, optional=optional)
    return inner.guard(lambda: make(fields))


def _lognormal(fields: Mapping[str, Element]) -> Lognormal:
    if "valueIs" not in fields:
        return Lognormal(fields["errorFactor"].number())
    stated = fields["valueIs"].choice(("mean", "median"))
    return Lognormal(fields["errorFactor"].number(), "mean" if stated == "mean" else "median")


_DISTRIBUTIONS: dict[
    str, tuple[Sequence[str], Sequence[str], Callable[[Mapping[str, Element]], Distribution]]
] = {
    "lognormal": (("errorFactor",), ("valueIs",), _lognormal),
    "uniform": (("low", "high"), (), lambda f: Uniform(f["low"].number(), f["high"].number())),
    "loguniform": (
        ("low", "high"),
        (),
        lambda f: Uniform(f["low"].number(), f["high"].number(), log=True),
    ),
    "beta": (("alpha", "beta"), (), lambda f: Beta(f["alpha"].number(), f["beta"].number())),
    "gamma": (("shape", "scale"), (), lambda f: Gamma(f["shape"].number(), f["scale"].number())),
    "normal": (
        ("mean", "deviation"),
        (),
        lambda f: Normal(f["mean"].number(), f["deviation"].number()),
    ),
}
