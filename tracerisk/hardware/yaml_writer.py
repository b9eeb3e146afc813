"""Write a hardware description as YAML that reads back as the same description."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

from tracerisk.hardware.model import (
    Component,
    FailureFigure,
    FailureMode,
    Hardware,
    LoadLaw,
    TwinBinding,
    default_detection,
)
from tracerisk.hardware.units import SECONDS_PER
from tracerisk.hardware.yaml_use import exponent_text

_PLAIN = re.compile(r"[A-Za-z_][A-Za-z0-9_./\-]*")
_WORDS_OF_YAML = frozenset({"true", "false", "null", "yes", "no", "on", "off", "y", "n"})
"""What is no string where it stands without quotes, in one version of YAML or the other."""
_ESCAPES = {'"': '\\"', "\\": "\\\\", "\n": "\\n", "\t": "\\t"}


def write_hardware(hardware: Hardware) -> str:
    """Return the description as YAML; reading it gives an equal one."""
    lines = []
    if hardware.robot is not None:
        lines.append(f"robot: {text_scalar(hardware.robot)}")
    if hardware.source is not None:
        lines.append(f"source: {text_scalar(hardware.source)}")
    lines.append("components:")
    for component in hardware.components:
        lines.append(f"  {text_scalar(component.name)}:")
        lines += (f"    {key}: {value}" for key, value in component_entries(component))
    return "\n".join(lines) + "\n"


def component_entries(component: Component) -> Iterator[tuple[str, str]]:
    """Yield each key of a component with its value, in the order in which they are written."""
    default = 1 if component.twin is None else component.twin.named_units
    if component.quantity != default:
        yield "quantity", '"*"' if component.quantity is None else str(component.quantity)
    yield from _redundancy(component)
    yield from _figures(component.figures)
    if component.age_s:
        yield "age", _time(component.age_s, "value")
    if component.load_law is not None:
        yield "load_law", _load_law(component.load_law)
    if component.modes:
        yield (
            "modes",
            _map((text_scalar(mode.name), _mode(mode)) for mode in component.modes),
        )
    if component.always_active:
        yield "active", "always"
    if component.twin is not None:
        yield "twin", _twin(component.twin)
    if component.source is not None:
        yield "source", text_scalar(component.source)


def number_scalar(value: float) -> str:
    """Return a number in the fewest digits that read back as the same."""
    text = repr(float(value))
    return text.removesuffix(".0")


def text_scalar(text: str) -> str:
    """Return a string, in quotes where it needs them."""
    if _PLAIN.fullmatch(text) and text.lower() not in _WORDS_OF_YAML:
        return text
    return '"' + "".join(map(_quoted, text)) + '"'


def _quoted(character: str) -> str:
    if character in _ESCAPES:
        return _ESCAPES[character]
    if character.isprintable():
        return character
    code = ord(character)
    if code < 0x100:
        return f"\\x{code:02x}"
    return f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"


def _map(entries: Iterable[tuple[str, str]]) -> str:
    return "{" + ", ".join(f"{key}: {value}" for key, value in entries) + "}"


def _list(texts: Iterable[str]) -> str:
    return "[" + ", ".join(map(text_scalar, texts)) + "]"


def _redundancy(component: Component) -> Iterator[tuple[str, str]]:
    group = component.redundancy
    if not group:
        return
    if group.required > 1:
        yield "required", str(group.required)
    elif not group.has_spares:
        yield "redundancy", "true"
    if group.has_spares:
        kinds = {1.0: "hot", 0.0: "cold"}
        yield "spare", kinds.get(group.dormancy, "warm")
        if group.dormancy not in kinds:
            yield "dormancy", number_scalar(group.dormancy)
        if group.switch:
            yield "switch", number_scalar(group.switch)
    if group.common_cause:
        yield "common_cause", _map([("beta", number_scalar(group.common_cause))])
    if component.test_interval_s is not None:
        yield "detected", _time(component.test_interval_s, "test_interval")
    elif group.detected != default_detection(component.figures, tested=False):
        yield "detected", group.detected


def _figures(figures: tuple[FailureFigure, ...]) -> Iterator[tuple[str, str]]:
    by_key: dict[str, list[str]] = {}
    for figure in figures:
        key: str = "standby_rate" if figure.standby else figure.kind
        by_key.setdefault(key, []).append(_map(_figure(figure)))
    for key, texts in by_key.items():
        yield key, texts[0] if len(texts) == 1 else "[" + ", ".join(texts) + "]"


def _figure(figure: FailureFigure) -> Iterator[tuple[str, str]]:
    if figure.kind == "weibull":
        yield "shape", number_scalar(figure.shape)
        yield "scale", number_scalar(figure.value)
    else:
        yield "value", number_scalar(figure.value)
    yield "per", figure.per.value
    if figure.demand is not None:
        yield "of", figure.demand
    if figure.error_factor is not None:
        yield "error_factor", number_scalar(figure.error_factor)
        if figure.value_is != "median":
            yield "value_is", figure.value_is
    if figure.source is not None:
        yield "source", text_scalar(figure.source)


def _time(seconds: float, key: str) -> str:
    """Return a time in the largest unit that gives back the very number of seconds."""
    for unit, span in sorted(SECONDS_PER.items(), key=lambda item: -item[1]):
        if seconds / span * span == seconds:
            return _map([(key, number_scalar(seconds / span)), ("per", unit)])
    raise AssertionError("a second is a unit")


def _load_law(law: LoadLaw) -> str:
    entries = [
        ("reference_load", number_scalar(law.reference_load)),
        ("wearing_share", number_scalar(law.wearing_share)),
        ("exponent", exponent_text(law.exponent)),
    ]
    if law.reference_speed is not None:
        entries.append(("reference_speed", number_scalar(law.reference_speed)))
    if law.source is not None:
        entries.append(("source", text_scalar(law.source)))
    return _map(entries)


def _mode(mode: FailureMode) -> str:
    entries = [("fraction", number_scalar(mode.fraction)), ("when", _list(mode.when))]
    if mode.source is not None:
        entries.append(("source", text_scalar(mode.source)))
    return _map(entries)


def _twin(twin: TwinBinding) -> str:
    entries = []
    if twin.joints:
        entries.append(("joints", '"*"' if twin.joints == "*" else _list(twin.joints)))
    if twin.actuators:
        entries.append(("actuators", _list(twin.actuators)))
    if twin.gripper:
        entries.append(("gripper", "true"))
    if twin.sensors:
        kind = isinstance(twin.sensors, str)
        entries.append(("sensors", str(twin.sensors) if kind else _list(twin.sensors)))
    if twin.contacts:
        entries.append(("contacts", _list(twin.contacts)))
    if twin.optional:
        entries.append(("optional", "true"))
    return _map(entries)
