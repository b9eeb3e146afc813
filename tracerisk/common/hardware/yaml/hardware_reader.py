"""Read a hardware description from YAML."""

from __future__ import annotations

from pathlib import Path

from tracerisk.common.hardware.checks import check_component
from tracerisk.common.hardware.model import FIGURE_KEYS, Component, Hardware, TwinBinding
from tracerisk.common.hardware.source_files import TOP_KEYS
from tracerisk.common.hardware.units import sheet_hint
from tracerisk.common.hardware.yaml.figures import read_figures, read_time, word_of
from tracerisk.common.hardware.yaml.redundancy import (
    REDUNDANCY_KEYS,
    read_redundancy,
    read_repair,
)
from tracerisk.common.hardware.yaml.twin import TWIN_KEYS, read_twin
from tracerisk.common.hardware.yaml.use import LAW_KEYS, MODE_KEYS, read_load_law, read_modes
from tracerisk.common.text.yaml_reader import YamlMap, read_large_yaml
from tracerisk.errors import HardwareError, Location

ROBOTS_NUMBER = "*"
"""What `quantity` says where the robot gives how many there are."""

_COMPONENT_KEYS = (
    frozenset(FIGURE_KEYS)
    | REDUNDANCY_KEYS
    | {
        "quantity",
        "age",
        "load_law",
        "modes",
        "twin",
        "active",
        "exposure_error_factor",
        "lot",
        "source",
    }
)

_WITHIN = {
    "a mean time or a rate, as in mtbf: {value: 42000, unit: hour, temperature: {rated: 40, "
    "working: 55, activation_energy: 0.7}}": {"temperature"},
    "'mttfd' or 'b10d'": {"dangerous"},
    "'b10' or 'b10d'": {"cycles"},
    "'weibull'": {"shape", "scale"},
    "a figure, as in failure_rate: {value: 1e-6, per: hour, error_factor: 3}": {
        "value",
        "per",
        "unit",
        "of",
        "error_factor",
        "value_is",
    },
    "'load_law'": LAW_KEYS - {"source"},
    "a mode of 'modes'": MODE_KEYS - {"source"},
    "'twin'": TWIN_KEYS,
    "'common_cause'": {"beta"},
    "'repair'": {"mean_time", "in_mission"},
    "'detected'": {"test_interval"},
}
"""The keys that stand within one of a component's own, by what holds them."""


def read_hardware(path: Path, *, shown: str | None = None) -> Hardware:
    """Read the hardware description at `path`, which is YAML.

    `shown` is the name of the file for messages, the path by default.
    Raises HardwareError with file, line and column at an unknown key, a missing value, a number
    outside its bounds, a value of the wrong type, or fields that contradict one another.
    """
    top = read_large_yaml(path, HardwareError, shown=shown)
    top.forbid_unknown(TOP_KEYS)
    described = top.map("components")
    components = tuple(
        _component(name, entry, described.key_location(name))
        for name, entry in described.items_as_maps()
    )
    if not components:
        top.fail("components", "has no components; give at least one")
    return Hardware(
        file=shown if shown is not None else str(path),
        components=components,
        robot=top.optional_string("robot"),
        source=top.optional_string("source"),
    )


def _component(name: str, entry: YamlMap, location: Location) -> Component:
    entry.forbid_unknown(_COMPONENT_KEYS, _level_hint)
    figures = read_figures(entry)
    redundancy, test_interval_s = read_redundancy(entry, figures)
    twin = read_twin(entry)
    component = Component(
        name=name,
        figures=figures,
        quantity=_quantity(entry, twin),
        redundancy=redundancy,
        always_active="active" in entry and word_of(entry, "active", {"always": True}),
        twin=twin,
        load_law=read_load_law(entry),
        modes=read_modes(entry),
        age_s=read_time(entry, "age") if "age" in entry else 0.0,
        source=entry.optional_string("source"),
        location=location,
        test_interval_s=test_interval_s,
        exposure_error_factor=entry.number("exposure_error_factor", minimum=1.0)
        if "exposure_error_factor" in entry
        else None,
        lot=entry.optional_string("lot"),
        repair=read_repair(entry),
    )

    def place(*keys: str) -> Location:
        return entry.nested_location(keys) if keys and keys[0] in entry else location

    check_component(component, place)
    return component


def _level_hint(key: str, value: object) -> str:
    """Return where a key of a component belongs, or how a data sheet's figure is written, if so."""
    holders = (holder for holder, keys in _WITHIN.items() if key in keys)
    holder = next(holders, "")
    return f"it belongs in {holder}" if holder else sheet_hint(key, value)


def _quantity(entry: YamlMap, twin: TwinBinding | None) -> int | None:
    if "quantity" not in entry:
        return 1 if twin is None else twin.named_units
    if isinstance(entry.get("quantity"), str):
        word = entry.string("quantity")
        if word != ROBOTS_NUMBER:
            entry.fail(
                "quantity",
                f"'{word}' is not allowed; write a whole number, or \"*\" for the number that "
                f"the robot has",
            )
        return None
    return entry.integer("quantity", minimum=1)
