"""A hardware description as plain data, in the keys of its YAML and its JSON Schema."""

from __future__ import annotations

from typing import Any

from tracerisk.common.hardware.load import exponent_text
from tracerisk.common.hardware.model import (
    Component,
    FailureFigure,
    FailureMode,
    Hardware,
    LoadLaw,
    TwinBinding,
    default_detection,
)
from tracerisk.common.hardware.units import CYCLE_KINDS, SECONDS_PER, DataSheet

_SPARES = {1.0: "hot", 0.0: "cold"}


def description_data(hardware: Hardware) -> dict[str, Any]:
    """Return the description as maps, lists, strings and numbers; what is usual is left unsaid.

    The keys are in the order in which they are written.
    """
    components = {component.name: component_data(component) for component in hardware.components}
    return {**head_data(hardware), "components": components}


def head_data(hardware: Hardware) -> dict[str, str]:
    """Return what a description says of itself: its robot and its source."""
    return {**_given("robot", hardware.robot), **_given("source", hardware.source)}


def component_data(component: Component) -> dict[str, Any]:
    """Return one component as plain data, without its name."""
    data: dict[str, Any] = {}
    usual = 1 if component.twin is None else component.twin.named_units
    if component.quantity != usual:
        data["quantity"] = "*" if component.quantity is None else component.quantity
    data |= _redundancy(component)
    data |= _figures(component.figures)
    if component.age_s:
        data["age"] = _time(component.age_s, "value")
    if component.load_law is not None:
        data["load_law"] = _load_law(component.load_law)
    if component.modes:
        data["modes"] = {mode.name: _mode(mode) for mode in component.modes}
    if component.always_active:
        data["active"] = "always"
    if component.twin is not None:
        data["twin"] = _twin(component.twin)
    data |= _given("exposure_error_factor", component.exposure_error_factor)
    return data | _given("lot", component.lot) | _given("source", component.source)


def _given(key: str, value: Any) -> dict[str, Any]:
    return {} if value is None else {key: value}


def _redundancy(component: Component) -> dict[str, Any]:
    group = component.redundancy
    if not group:
        return {}
    data: dict[str, Any] = {}
    if group.required > 1:
        data["required"] = group.required
    elif not group.has_spares:
        data["redundancy"] = True
    if group.has_spares:
        data["spare"] = _SPARES.get(group.dormancy, "warm")
        if group.dormancy not in _SPARES:
            data["dormancy"] = group.dormancy
        if group.switch:
            data["switch"] = group.switch
    if group.common_cause:
        data["common_cause"] = {"beta": group.common_cause}
    if component.test_interval_s is not None:
        data["detected"] = _time(component.test_interval_s, "test_interval")
    elif component.repair is not None:
        data["repair"] = _time(component.repair.mean_time_s, "mean_time")
        if component.repair.in_mission:
            data["repair"]["in_mission"] = True
    elif group.detected != default_detection(component.figures, tested=False):
        data["detected"] = group.detected
    return data


def _figures(figures: tuple[FailureFigure, ...]) -> dict[str, Any]:
    by_key: dict[str, list[dict[str, Any]]] = {}
    for figure in figures:
        by_key.setdefault(figure.key, []).append(figure_data(figure))
    return {key: item[0] if len(item) == 1 else item for key, item in by_key.items()}


def figure_data(figure: FailureFigure) -> dict[str, Any]:
    """Return one failure figure as plain data, with its unit."""
    sheet = figure.sheet
    data: dict[str, Any] = {"value": figure.value if sheet is None else sheet.value}
    if figure.kind == "weibull":
        data = {"shape": figure.shape, "scale": figure.value}
    if figure.fit is not None:
        data = {"value": figure.fit, "unit": "FIT"}
    elif sheet is None or sheet.kind is None:
        data["per"] = figure.per.value
    elif sheet.kind not in CYCLE_KINDS:
        data["unit"] = "hour"
    data |= _given("of", figure.demand)
    if sheet is not None:
        data |= _sheet(sheet)
    data |= _given("error_factor", figure.error_factor)
    if figure.value_is != figure.usual_statistic and figure.error_factor is not None:
        data["value_is"] = figure.value_is
    return data | _given("source", figure.source)


def _sheet(sheet: DataSheet) -> dict[str, Any]:
    data: dict[str, Any] = {}
    if sheet.cycles_per_hour is not None:
        data["cycles"] = {"value": sheet.cycles_per_hour, "per": "hour"}
    data |= _given("dangerous", sheet.dangerous)
    if (at := sheet.temperature) is not None:
        data["temperature"] = {
            "rated": at.rated,
            "working": at.working,
            "activation_energy": at.activation_energy,
        }
    return data


def _time(seconds: float, key: str) -> dict[str, Any]:
    """Return a time in the largest unit that gives back the very number of seconds."""
    for unit, span in sorted(SECONDS_PER.items(), key=lambda item: -item[1]):
        if seconds / span * span == seconds:
            return {key: seconds / span, "per": unit}
    raise AssertionError("a second is a unit")


def _load_law(law: LoadLaw) -> dict[str, Any]:
    whole = law.exponent.is_integer()
    return {
        "reference_load": law.reference_load,
        "wearing_share": law.wearing_share,
        "exponent": int(law.exponent) if whole else exponent_text(law.exponent),
        **_given("reference_speed", law.reference_speed),
        **_given("source", law.source),
    }


def _mode(mode: FailureMode) -> dict[str, Any]:
    return {
        "fraction": mode.fraction,
        **({"when": list(mode.when)} if mode.when else {}),
        **_given("fault", mode.fault),
        **_given("lasts_s", mode.lasts_s),
        **_given("source", mode.source),
    }


def _twin(twin: TwinBinding) -> dict[str, Any]:
    keys = ("joints", "actuators", "gripper", "sensors", "contacts", "optional")
    given = {key: getattr(twin, key) for key in keys}
    return {
        key: list(value) if isinstance(value, tuple) else value
        for key, value in given.items()
        if value
    }
