"""Read the failure figures of a component from YAML, each with its unit."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar, get_args

from tracerisk.common.hardware.model import Basis, Demand, FailureFigure, Statistic
from tracerisk.common.hardware.units import (
    COLDEST_C,
    CYCLE_KINDS,
    DANGEROUS_KINDS,
    HOTTEST_C,
    HOURS_PER_YEAR,
    SECONDS_PER,
    SHEET_KINDS,
    DataSheet,
    SheetKind,
    Temperature,
    rate_from_fit,
    sheet_hint,
)
from tracerisk.common.text.yaml_reader import YamlMap
from tracerisk.errors import one_of

_SURE_KEYS = frozenset({"error_factor", "value_is", "source"})
_ALWAYS_KEYS = _SURE_KEYS | {"per"}
_SPANS = (Basis.MINUTE, Basis.HOUR)

_HOURS_PER = {"hour": 1.0, "year": HOURS_PER_YEAR}
_CYCLES_PER_HOUR = {"minute": 60.0, "hour": 1.0, "day": 1.0 / 24.0, "year": 1.0 / HOURS_PER_YEAR}

_PER_HOUR = "{value: NUMBER, per: hour}"
_FORMS: dict[str, str] = {
    "probability": _PER_HOUR,
    **dict.fromkeys(
        ("failure_rate", "standby_rate"), "{value: NUMBER, per: hour} or {value: NUMBER, unit: FIT}"
    ),
    "weibull": "{shape: SHAPE, scale: NUMBER, per: hour}",
    **dict.fromkeys(SHEET_KINDS, "{value: NUMBER, unit: hour}"),
    **dict.fromkeys(CYCLE_KINDS, "{value: NUMBER}, in cycles"),
}
"""How a figure is written, NUMBER standing for what a user gave without a unit."""

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
    for kind in SHEET_KINDS:
        read = _cycles if kind in CYCLE_KINDS else _mean_time
        figures += [read(yaml_map, kind) for yaml_map in _given(entry, kind)]
    return tuple(figures)


def read_time(entry: YamlMap, key: str, *, value: str = "value") -> float:
    """Return the time at `key`, such as `{value: 8, per: hour}`, in seconds; it is above 0."""
    time = unit_map(entry, key, _PER_HOUR.replace("value", value))
    time.forbid_unknown({value, "per"})
    given = positive(time, value)
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
        return [unit_map(entry, key, _FORMS[key])]
    if not (maps := entry.maps(key)):
        entry.fail(key, "is an empty list; give a figure, or remove it")
    return maps


def unit_map(entry: YamlMap, key: str, form: str) -> YamlMap:
    """Return the map at `key`; a bare number there is an error that shows it in the `form`."""
    if _is_number(entry.require(key)):
        number = str(entry.get(key))
        entry.fail(key, f"the number {number} has no unit; write {form.replace('NUMBER', number)}")
    return entry.map(key)


def _probability(figure: YamlMap) -> FailureFigure:
    figure.forbid_unknown(_ALWAYS_KEYS | {"value", "of"}, sheet_hint)
    value = figure.number("value", minimum=0.0, maximum=1.0)
    per = _basis(figure, tuple(Basis))
    demand = word_of(figure, "of", words(Demand)) if "of" in figure else None
    if demand is not None and per is not Basis.DEMAND:
        figure.fail("of", f"the figure is per {per.value}, not per demand; remove 'of'")
    return FailureFigure("probability", value, per, demand=demand, **_uncertainty(figure))


def _rate(figure: YamlMap, *, standby: bool) -> FailureFigure:
    figure.forbid_unknown(_ALWAYS_KEYS | {"value", "unit", "temperature"}, sheet_hint)
    value = figure.number("value", minimum=0.0)
    per = Basis.HOUR
    fit = None
    if "unit" in figure:
        unit = figure.string("unit")
        if unit != "FIT":
            span = unit.lower().removesuffix("s")
            instead = f"per: {span}" if span in ("hour", "minute") else "per: hour or per: minute"
            allowed = f"{one_of(['FIT'], unit)}, or write {instead} instead"
            figure.fail("unit", f"'{unit}' is not allowed; {allowed}")
        if "per" in figure:
            figure.fail("per", "FIT means failures per 1e9 hours; remove 'per'")
        fit, value = value, rate_from_fit(value)
    else:
        per = _basis(figure, _SPANS)
    sheet = None
    if "temperature" in figure:
        sheet = DataSheet(value, temperature=_temperature(figure))
        value = _stated(figure, sheet)
    return FailureFigure(
        "failure_rate", value, per, standby=standby, sheet=sheet, fit=fit, **_uncertainty(figure)
    )


def _mean_time(figure: YamlMap, kind: SheetKind) -> FailureFigure:
    dangerous = {"dangerous"} if kind in DANGEROUS_KINDS else set()
    figure.forbid_unknown(_SURE_KEYS | {"value", "unit", "temperature"} | dangerous)
    hours = positive(figure, "value") * word_of(figure, "unit", _HOURS_PER)
    temperature = _temperature(figure) if "temperature" in figure else None
    sheet = DataSheet(hours, kind, dangerous=_dangerous(figure), temperature=temperature)
    return FailureFigure(
        "failure_rate",
        _stated(figure, sheet),
        Basis.HOUR,
        sheet=sheet,
        **_uncertainty(figure, "mean"),
    )


def _cycles(figure: YamlMap, kind: SheetKind) -> FailureFigure:
    """Read a B10 or B10d: per demand, or per hour where the cycles in an hour are given."""
    dangerous = {"dangerous"} if kind in DANGEROUS_KINDS else set()
    figure.forbid_unknown(_SURE_KEYS | {"value", "of", "cycles"} | dangerous)
    value = figure.number("value", minimum=1.0)
    demand = word_of(figure, "of", words(Demand)) if "of" in figure else None
    per_hour = None
    if "cycles" in figure:
        if demand is not None:
            figure.fail("of", "the cycles are given, so no demand is counted; remove one of them")
        cycles = unit_map(figure, "cycles", _PER_HOUR)
        cycles.forbid_unknown({"value", "per"})
        per_hour = positive(cycles, "value") * word_of(cycles, "per", _CYCLES_PER_HOUR)
    sheet = DataSheet(value, kind, per_hour, _dangerous(figure))
    return FailureFigure(
        "probability" if per_hour is None else "failure_rate",
        _stated(figure, sheet),
        Basis.DEMAND if per_hour is None else Basis.HOUR,
        demand=demand,
        sheet=sheet,
        **_uncertainty(figure, "mean"),
    )


def _stated(entry: YamlMap, sheet: DataSheet) -> float:
    """Return the rate or the probability that a data sheet states."""
    if sheet.fault:
        entry.fail("value", f"{sheet.fault} with what stands beside it; mend one of them")
    return sheet.figure


def _dangerous(figure: YamlMap) -> float | None:
    if "dangerous" not in figure:
        return None
    if (share := figure.number("dangerous", minimum=0.0, maximum=1.0)) == 0.0:
        figure.fail("dangerous", "is 0; give the share of the failures that are dangerous")
    return share


def _temperature(figure: YamlMap) -> Temperature:
    at = figure.map("temperature")
    at.forbid_unknown({"rated", "working", "activation_energy"})
    rated, working = (
        at.number(key, minimum=COLDEST_C, maximum=HOTTEST_C) for key in ("rated", "working")
    )
    return Temperature(rated, working, at.number("activation_energy", minimum=0.0, maximum=2.0))


def _weibull(figure: YamlMap) -> FailureFigure:
    figure.forbid_unknown(_ALWAYS_KEYS | {"shape", "scale"})
    shape = positive(figure, "shape")
    scale = positive(figure, "scale")
    per = _basis(figure, _SPANS)
    return FailureFigure("weibull", scale, per, shape=shape, **_uncertainty(figure))


def _uncertainty(figure: YamlMap, usual: Statistic = "median") -> dict[str, Any]:
    """Return the fields of a figure of its uncertainty, and of its source."""
    factor = figure.number("error_factor", minimum=1.0) if "error_factor" in figure else None
    meaning = word_of(figure, "value_is", words(Statistic)) if "value_is" in figure else usual
    if "value_is" in figure and factor is None:
        figure.fail("value_is", "has no effect without 'error_factor'; give it, or remove both")
    source = figure.optional_string("source")
    return {"error_factor": factor, "value_is": meaning, "source": source}


def _basis(figure: YamlMap, allowed: tuple[Basis, ...]) -> Basis:
    return word_of(figure, "per", {basis.value: basis for basis in allowed})


def positive(entry: YamlMap, key: str) -> float:
    """Return the number at `key`, which is above 0."""
    value = entry.number(key, minimum=0.0)
    if value == 0.0:
        entry.fail(key, "is 0; give a number above 0")
    return value


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
