"""Read the failure figures of a component from YAML, each with its unit."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar, get_args

from tracerisk.common.hardware.model import Basis, Demand, FailureFigure, Statistic
from tracerisk.common.hardware.units import SECONDS_PER, mean_time_hint, rate_from_fit
from tracerisk.common.text.yaml_reader import YamlMap
from tracerisk.errors import one_of

FIGURE_KEYS = frozenset({"probability", "failure_rate", "standby_rate", "weibull"})

_ALWAYS_KEYS = frozenset({"per", "error_factor", "value_is", "source"})
_SPANS = (Basis.MINUTE, Basis.HOUR)

_Meant = TypeVar("_Meant")


def read_figures(entry: YamlMap) -> tuple[FailureFigure, ...]:
    """Return the failure figures of a component, those of one kind in the order of the file.

    Raises HardwareError at a figure that is malformed.
    """
    if _is_number(entry.get("probability")):
        # A bare number is the published reading: one figure for each visit of a function.
        value = entry.number("probability", minimum=0.0, maximum=1.0)
        figures = [FailureFigure("probability", value, Basis.VISIT)]
    else:
        figures = [_probability(yaml_map) for yaml_map in _given(entry, "probability")]
    figures += [_rate(yaml_map, standby=False) for yaml_map in _given(entry, "failure_rate")]
    figures += [_rate(yaml_map, standby=True) for yaml_map in _given(entry, "standby_rate")]
    figures += [_weibull(yaml_map) for yaml_map in _given(entry, "weibull")]
    return tuple(figures)


def read_time(entry: YamlMap, key: str, *, value: str = "value") -> float:
    """Return the time at `key`, such as `{value: 8, per: hour}`, in seconds; it is above 0."""
    time = _unit_map(entry, key, "{" + value + ": 8, per: hour}")
    time.forbid_unknown({value, "per"})
    given = _positive(time, value)
    return given * word_of(time, "per", SECONDS_PER)


def words(kind: Any) -> dict[str, Any]:
    """Return the words of a `Literal` by themselves, for `word_of`."""
    return {word: word for word in get_args(kind)}


def word_of(entry: YamlMap, key: str, words: Mapping[str, _Meant]) -> _Meant:
    """Return what the word at `key` stands for; raise at one that is not allowed."""
    word = entry.string(key)
    if word not in words:
        entry.fail(key, f"'{word}' is not allowed; {one_of(words, word)}")
    return words[word]


def _given(entry: YamlMap, key: str) -> list[YamlMap]:
    """Return the maps at `key`, which holds one or a list of them; empty where it is absent."""
    if key not in entry:
        return []
    if not isinstance(entry.require(key), list):
        example = {
            "probability": "{value: 1e-7, per: hour}",
            "weibull": "{shape: 2, scale: 30000, per: hour}",
        }.get(key, "{value: 5.7e-6, per: hour} or {value: 5700, unit: FIT}")
        return [_unit_map(entry, key, example)]
    if not (maps := entry.maps(key)):
        entry.fail(key, "is an empty list; give a figure, or remove it")
    return maps


def _unit_map(entry: YamlMap, key: str, example: str) -> YamlMap:
    if _is_number(entry.require(key)):
        entry.fail(key, f"the number {entry.get(key)} has no unit; write {example}")
    return entry.map(key)


def _probability(figure: YamlMap) -> FailureFigure:
    figure.forbid_unknown(_ALWAYS_KEYS | {"value", "of"}, mean_time_hint)
    value = figure.number("value", minimum=0.0, maximum=1.0)
    per = _basis(figure, tuple(Basis))
    demand = word_of(figure, "of", words(Demand)) if "of" in figure else None
    if demand is not None and per is not Basis.DEMAND:
        figure.fail("of", f"the figure is per {per.value}, not per demand; remove 'of'")
    return FailureFigure("probability", value, per, demand=demand, **_uncertainty(figure))


def _rate(figure: YamlMap, *, standby: bool) -> FailureFigure:
    figure.forbid_unknown(_ALWAYS_KEYS | {"value", "unit"}, mean_time_hint)
    value = figure.number("value", minimum=0.0)
    per = Basis.HOUR
    if "unit" in figure:
        unit = figure.string("unit")
        if unit != "FIT":
            span = unit.lower().removesuffix("s")
            instead = f"per: {span}" if span in ("hour", "minute") else "per: hour or per: minute"
            allowed = f"{one_of(['FIT'], unit)}, or write {instead} instead"
            figure.fail("unit", f"'{unit}' is not allowed; {allowed}")
        if "per" in figure:
            figure.fail("per", "FIT means failures per 1e9 hours; remove 'per'")
        value = rate_from_fit(value)
    else:
        per = _basis(figure, _SPANS)
    return FailureFigure("failure_rate", value, per, standby=standby, **_uncertainty(figure))


def _weibull(figure: YamlMap) -> FailureFigure:
    figure.forbid_unknown(_ALWAYS_KEYS | {"shape", "scale"})
    shape = _positive(figure, "shape")
    scale = _positive(figure, "scale")
    per = _basis(figure, _SPANS)
    return FailureFigure("weibull", scale, per, shape=shape, **_uncertainty(figure))


def _uncertainty(figure: YamlMap) -> dict[str, Any]:
    """Return the fields of a figure of its uncertainty, and of its source."""
    factor = figure.number("error_factor", minimum=1.0) if "error_factor" in figure else None
    meaning = word_of(figure, "value_is", words(Statistic)) if "value_is" in figure else "median"
    if "value_is" in figure and factor is None:
        figure.fail("value_is", "has no effect without 'error_factor'; give it, or remove both")
    source = figure.optional_string("source")
    return {"error_factor": factor, "value_is": meaning, "source": source}


def _basis(figure: YamlMap, allowed: tuple[Basis, ...]) -> Basis:
    return word_of(figure, "per", {basis.value: basis for basis in allowed})


def _positive(entry: YamlMap, key: str) -> float:
    value = entry.number(key, minimum=0.0)
    if value == 0.0:
        entry.fail(key, "is 0; give a number above 0")
    return value


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
