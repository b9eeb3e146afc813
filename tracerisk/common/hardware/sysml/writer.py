"""Write a hardware description in SysML v2 textual notation."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

from tracerisk.common.hardware.model import (
    Basis,
    Component,
    FailureFigure,
    FailureMode,
    Hardware,
    LoadLaw,
    TwinBinding,
)
from tracerisk.common.hardware.sysml.language.standard_names import ENUMERATIONS, FEATURES, OURS
from tracerisk.common.hardware.sysml.language.words import WORDS
from tracerisk.common.hardware.units import CYCLE_KINDS, DataSheet, SheetKind

_BASIC_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_ESCAPED = {"\\": "\\\\", '"': '\\"', "\n": "\\n", "\r": "\\r", "\t": "\\t"}
_ESCAPED |= {"\b": "\\b", "\f": "\\f"}
_QUOTED_ESCAPED = {**_ESCAPED, "'": "\\'"}
del _QUOTED_ESCAPED['"']
_UNIT = {Basis.MINUTE: "min", Basis.HOUR: "h"}
_WORDS = {
    (enumeration, meaning): word
    for enumeration, words in ENUMERATIONS.items()
    for word, meaning in words.items()
}
_LOOKED_UP = {
    **dict.fromkeys(("h", "min", "s"), "SI"),
    **dict.fromkeys((*FEATURES, *ENUMERATIONS), OURS),
}
"""The names that the parts refer to, and the packages that have them."""
_INDENT = "    "


def write_sysml(hardware: Hardware) -> str:
    """Return the description as a file in SysML v2 textual notation, which reads back as the same.

    The dots of names become parts within parts, where that keeps the order of the components.
    """
    parts = {part for component in hardware.components for part in component.name.split(".")}
    hidden = frozenset(
        parts | {m.name for component in hardware.components for m in component.modes}
    )
    writer = _Writer(hidden)
    body = [
        *writer.metadata("HardwareData", {"robot": hardware.robot, "source": hardware.source}),
        *writer.parts(hardware.components),
    ]
    lines = [
        "package Hardware {",
        *_indented(
            [
                "private import ScalarValues::*;",
                "private import SI::*;",
                "private import TraceriskHardware::*;",
                *writer.aliases(),
                "",
                "part robot {",
                *_indented(body),
                "}",
            ]
        ),
        "}",
    ]
    return "\n".join(lines) + "\n"


def _indented(lines: Iterable[str]) -> list[str]:
    return [_INDENT + line if line else line for line in lines]


def _name(name: str) -> str:
    """Return a name as it is written: in quotes where it is a word or has other characters."""
    if _BASIC_NAME.fullmatch(name) and name not in WORDS:
        return name
    return "'" + "".join(_QUOTED_ESCAPED.get(text, text) for text in name) + "'"


def _text(text: str) -> str:
    return '"' + "".join(_ESCAPED.get(name, name) for name in text) + '"'


def _number(number: float) -> str:
    """Return the shortest digits that read back as the same number."""
    if number == int(number) and abs(number) < 1e15:
        return str(int(number))
    return "10/3" if number == 10.0 / 3.0 else repr(number)


def _value(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return _number(value)
    return str(value)


class _Written(str):
    """A value that is written as it is."""

    __slots__ = ()


def _assignments(values: Mapping[str, object]) -> list[str]:
    """Return the lines that give values, but for `None`; those made of parts come last.

    A text is written in quotes; anything else that is a `str` must be one of `_Written`.
    """
    plain = [
        f"{key} = {_text(value) if type(value) is str else _value(value)};"
        for key, value in values.items()
        if value is not None and not isinstance(value, dict)
    ]
    nested = [
        line
        for key, value in values.items()
        if isinstance(value, dict)
        for line in (f"{key} {{", *_indented(_assignments(value)), "}")
    ]
    return plain + nested


def _several(values: Iterable[str]) -> _Written | None:
    written = list(values)
    if not written:
        return None
    return _Written(written[0] if len(written) == 1 else f"({', '.join(written)})")


class _Writer:
    """Writes parts, with the names by which it can call what a component's name would hide.

    `hidden` are the names of parts and modes; what they hide gets another name.
    """

    def __init__(self, hidden: frozenset[str]) -> None:
        self._called: dict[str, str] = {}
        for name in sorted(hidden & _LOOKED_UP.keys()):
            called = f"the {name}"
            while called in hidden:
                called += "_"
            self._called[name] = f"'{called}'"

    def aliases(self) -> list[str]:
        """Return the declarations of the other names."""
        return [
            f"alias {called} for {_LOOKED_UP[name]}::{name};"
            for name, called in self._called.items()
        ]

    def _name_of(self, name: str) -> str:
        return self._called.get(name, name)

    def _unit(self, name: str, power: str = "") -> str:
        return f"[{self._name_of(name)}{power}]"

    def metadata(
        self, kind: str, values: Mapping[str, object], name: str | None = None
    ) -> list[str]:
        """Return the lines of a metadata usage; none where no value is given."""
        given = _assignments(values)
        if not given:
            return []
        type_name = self._name_of(kind)
        head = f"@{type_name}" if name is None else f"metadata {_name(name)} : {type_name}"
        if len(given) == 1:
            return [f"{head} {{ {given[0]} }}"]
        return [f"{head} {{", *_indented(given), "}"]

    def _word(self, enumeration: str, meaning: str) -> _Written:
        return _Written(f"{self._name_of(enumeration)}::{_WORDS[enumeration, meaning]}")

    def parts(self, components: tuple[Component, ...]) -> list[str]:
        """Return the parts of a description, nested by the dots of their names where it can be."""
        tree = _Assembly()
        for component in components:
            tree.add(component.name.split("."), component)
        nested = [item.name for item in tree.in_order()]
        is_whole = all(part for item in components for part in item.name.split("."))
        if is_whole and tree.is_free() and nested == [item.name for item in components]:
            return tree.lines(self)
        # Quotes keep the dots of a name, where parts within parts would change the order, or
        # what they are.
        return [line for item in components for line in self.part(item.name, item, [])]

    def part(self, name: str, component: Component, inner: list[str]) -> list[str]:
        lines = [
            *self.metadata(
                "HardwareData",
                {
                    "exposureErrorFactor": component.exposure_error_factor,
                    "lot": component.lot,
                    "source": component.source,
                },
            ),
            *self._figures(component),
            *(line for mode in component.modes for line in self._mode(mode)),
            *self._redundancy(component),
            *self._twin(component),
            *inner,
        ]
        return [f"part {_name(name)}{_multiplicity(component)} {{", *_indented(lines), "}"]

    def _figures(self, component: Component) -> list[str]:
        """Return the `FailureData` of a component; the load law and the age go with the first."""
        shared: dict[str, object] = {}
        if component.age_s:
            shared["age"] = _Written(self._time(component.age_s))
        if component.load_law is not None:
            shared["loadLaw"] = _load_law(component.load_law)
        lines: list[str] = []
        for figure in component.figures:
            lines += self.metadata("FailureData", {**self._figure(figure), **shared})
            shared = {}
        return lines

    def _figure(self, figure: FailureFigure) -> dict[str, object]:
        values: dict[str, object] = {}
        sheet = figure.sheet
        if sheet is not None and sheet.kind is not None:
            values |= self._sheet(sheet, sheet.kind)
            if figure.demand is not None:
                values["demand"] = self._word("Use", figure.demand)
        elif figure.kind == "probability":
            values["probability"] = figure.value
            if figure.per is not Basis.VISIT:
                values["per"] = self._word("Basis", figure.per.value)
            if figure.demand is not None:
                values["demand"] = self._word("Use", figure.demand)
        elif figure.kind == "failure_rate":
            rate = figure.value if sheet is None else sheet.value
            unit = self._unit(_UNIT[figure.per], "^-1")
            if figure.fit is not None:
                rate, unit = figure.fit, "[FIT]"
            values["rate"] = _Written(f"{_operand(rate)} {unit}")
            if figure.standby:
                values["standby"] = True
        else:
            life = f"{_operand(figure.value)} {self._unit(_UNIT[figure.per])}"
            values["weibull"] = {"shape": figure.shape, "characteristicLife": _Written(life)}
        if sheet is not None and (at := sheet.temperature) is not None:
            values["temperature"] = {
                "rated": at.rated,
                "working": at.working,
                "activationEnergy": at.activation_energy,
            }
        if figure.error_factor is not None:
            values["errorFactor"] = figure.error_factor
            if figure.value_is != figure.usual_statistic:
                values["valueIs"] = self._word("Statistic", figure.value_is)
        values["source"] = figure.source
        return values

    def _sheet(self, sheet: DataSheet, kind: SheetKind) -> dict[str, object]:
        values: dict[str, object] = {}
        if kind in CYCLE_KINDS:
            values[kind] = sheet.value
        else:
            values[kind] = _Written(f"{_operand(sheet.value)} {self._unit('h')}")
        if sheet.cycles_per_hour is not None:
            rate = f"{_operand(sheet.cycles_per_hour)} {self._unit('h', '^-1')}"
            values["cycles"] = _Written(rate)
        return {**values, "dangerous": sheet.dangerous}

    def _mode(self, mode: FailureMode) -> list[str]:
        values = {
            "fraction": mode.fraction,
            "uses": _several(self._word("Use", literal) for literal in mode.when),
            "fault": None if mode.fault is None else self._word("Fault", mode.fault),
            "lasts": None if mode.lasts_s is None else _Written(self._time(mode.lasts_s)),
            "source": mode.source,
        }
        return self.metadata("FailureMode", values, mode.name)

    def _redundancy(self, component: Component) -> list[str]:
        group = component.redundancy
        if not group:
            return []
        kind = {0.0: "cold", 1.0: "hot"}.get(group.dormancy, "warm") if group.has_spares else None
        interval, repair = component.test_interval_s, component.repair
        values: dict[str, object] = {
            "redundant": True,
            "required": group.required if group.required != 1 else None,
            "spare": None if kind is None else self._word("Spare", kind),
            "dormancy": group.dormancy if kind == "warm" else None,
            "switch": group.switch if group.switch and kind is not None else None,
            "commonCause": group.common_cause or None,
            "testInterval": None if interval is None else _Written(self._time(interval)),
            "detected": self._word("Detection", group.detected) if interval is None else None,
            "repairTime": None if repair is None else _Written(self._time(repair.mean_time_s)),
            "repairInMission": True if repair is not None and repair.in_mission else None,
        }
        return self.metadata("Redundancy", values)

    def _twin(self, component: Component) -> list[str]:
        if component.always_active:
            return self.metadata("TwinBinding", {"always": True})
        twin = component.twin
        return [] if twin is None else self.metadata("TwinBinding", self._binding(twin))

    def _binding(self, twin: TwinBinding) -> dict[str, object]:
        joints = ("*",) if twin.joints == "*" else twin.joints
        values: dict[str, object] = {
            "joints": _several(map(_text, joints)),
            "actuators": _several(map(_text, twin.actuators)),
            "gripper": True if twin.gripper else None,
        }
        if isinstance(twin.sensors, str):
            values["sensorKind"] = self._word("SensorKind", twin.sensors)
        else:
            values["sensors"] = _several(map(_text, twin.sensors))
        values["contacts"] = _several(map(_text, twin.contacts))
        values["optional"] = True if twin.optional else None
        return values

    def _time(self, seconds: float) -> str:
        hours = seconds / 3600.0
        if hours * 3600.0 == seconds:
            return f"{_operand(hours)} {self._unit('h')}"
        return f"{_operand(seconds)} {self._unit('s')}"


class _Assembly:
    """The parts at one level of the names, each with its component, if it is one."""

    def __init__(self) -> None:
        self._component: Component | None = None
        self._inner: dict[str, _Assembly] = {}

    def add(self, path: list[str], component: Component) -> None:
        """Put a component where its name says."""
        here = self
        for name in path:
            here = here._inner.setdefault(name, _Assembly())
        here._component = component

    def in_order(self) -> list[Component]:
        """Return the components in the order in which they would be read."""
        components = [] if self._component is None else [self._component]
        for assembly in self._inner.values():
            components += assembly.in_order()
        return components

    def is_free(self) -> bool:
        """Whether parts can stand within components as they are.

        They cannot where one has the name of a failure mode around it, or where several units
        are around it, which would multiply it.
        """
        here = self._component
        if here is not None and self._inner:
            if any(mode.name in self._inner for mode in here.modes):
                return False
            if _multiplicity(here) not in ("", " [1]"):
                return False
        return all(assembly.is_free() for assembly in self._inner.values())

    def lines(self, writer: _Writer) -> list[str]:
        """Return the parts within."""
        return [
            line
            for name, assembly in self._inner.items()
            for line in assembly._part_lines(name, writer)
        ]

    def _part_lines(self, name: str, writer: _Writer) -> list[str]:
        if self._component is not None:
            return writer.part(name, self._component, self.lines(writer))
        return [f"part {_name(name)} {{", *_indented(self.lines(writer)), "}"]


def _load_law(law: LoadLaw) -> dict[str, object]:
    return {
        "referenceLoad": law.reference_load,
        "wearingShare": law.wearing_share,
        "exponent": None if law.exponent == 3.0 else law.exponent,
        "referenceSpeed": law.reference_speed,
        "source": law.source,
    }


def _multiplicity(component: Component) -> str:
    twin = component.twin
    by_default = 1 if twin is None else twin.named_units
    if component.quantity == by_default:
        return ""
    return f" [{'*' if component.quantity is None else component.quantity}]"


def _operand(number: float) -> str:
    """Return a number that a unit may follow."""
    text = _number(number)
    return f"({text})" if "/" in text else text
