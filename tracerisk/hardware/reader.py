"""Read a hardware description from YAML."""

from __future__ import annotations

import re
from pathlib import Path

from tracerisk.errors import HardwareError, Location, one_of
from tracerisk.hardware.model import (
    Basis,
    Component,
    FailureFigure,
    Hardware,
    TwinBinding,
    default_detection,
)
from tracerisk.hardware.redundancy import Detection, Redundancy
from tracerisk.yaml_reader import YamlMap, read_yaml

_TOP_KEYS = frozenset({"components", "robot", "source"})
_COMPONENT_KEYS = frozenset(
    {
        "quantity",
        "redundancy",
        "detected",
        "probability",
        "failure_rate",
        "twin",
        "active",
        "source",
    }
)
_DETECTIONS: dict[str, Detection] = {"mission_start": "mission_start", "each_visit": "each_visit"}
_TEST_KEYS = frozenset({"test_interval", "per"})
_FIGURE_KEYS = frozenset({"value", "per", "unit", "source"})
_TWIN_KEYS = frozenset({"joints", "gripper", "optional"})
_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_.\-]*")
_HOURS_PER_FIT = 1e9


def read_hardware(path: Path, *, shown: str | None = None) -> Hardware:
    """Read the hardware description at `path`.

    `shown` is the name of the file for messages, the path by default.
    Raises HardwareError with file and line at an unknown key, a missing value, a probability
    outside [0, 1], a negative rate or a value of the wrong type.
    """
    top = read_yaml(path, HardwareError, shown=shown)
    top.forbid_unknown(_TOP_KEYS)
    components = tuple(
        _component(name, entry, top.map("components").key_location(name))
        for name, entry in top.map("components").items_as_maps()
    )
    if not components:
        top.fail("components", "names no component; give at least one")
    return Hardware(
        file=shown if shown is not None else str(path),
        components=components,
        robot=top.optional_string("robot"),
        source=top.optional_string("source"),
    )


def _component(name: str, entry: YamlMap, location: Location) -> Component:
    if not _NAME.fullmatch(name):
        raise HardwareError(
            f"'{name}' is not a component's name; "
            "allowed: letters, digits, '_', '.', '-', a letter or '_' first",
            location,
        )
    entry.forbid_unknown(_COMPONENT_KEYS)
    figures = _figures(name, entry, location)
    twin = _twin(entry.map("twin")) if "twin" in entry else None
    always = False
    if "active" in entry:
        word = entry.string("active")
        if word != "always":
            entry.fail("active", f"'{word}' is not allowed; {one_of(['always'], word)}")
        always = True
        if twin is not None:
            entry.fail("active", "a component is either always active or seen by the twin")
        if any(figure.per is Basis.DEMAND for figure in figures):
            entry.fail("active", "what is always active has no demands; give its figure per time")
    redundancy = entry.boolean("redundancy", default=False)
    if "detected" in entry and not redundancy:
        entry.fail("detected", "of units that are all needed none stays hidden; leave it out")
    detected, test_interval_s = _detected(entry)
    found = detected or default_detection(figures, test_interval_s is not None)
    return Component(
        name=name,
        figures=figures,
        quantity=_quantity(entry, twin),
        redundancy=Redundancy(redundancy, detected=found) if redundancy else Redundancy(False),
        always_active=always,
        twin=twin,
        source=entry.optional_string("source"),
        location=location,
        test_interval_s=test_interval_s,
    )


def _detected(entry: YamlMap) -> tuple[Detection | None, float | None]:
    """Return when a failure of the group is detected, or the time between its tests [s]."""
    if "detected" not in entry:
        return None, None
    if not isinstance(entry.require("detected"), dict):
        word = entry.string("detected")
        if word not in _DETECTIONS:
            entry.fail(
                "detected",
                f"'{word}' is not allowed; {one_of(_DETECTIONS, word)}, "
                "or {test_interval: 8, per: hour}",
            )
        return _DETECTIONS[word], None
    test = entry.map("detected")
    test.forbid_unknown(_TEST_KEYS)
    interval = test.number("test_interval", minimum=0.0)
    if interval == 0.0:
        test.fail("test_interval", "is 0; give the time between two tests")
    span = _basis(test, (Basis.MINUTE, Basis.HOUR)).seconds
    assert span is not None
    return None, interval * span


def _quantity(entry: YamlMap, twin: TwinBinding | None) -> int | None:
    if "quantity" in entry:
        quantity = entry.integer("quantity", minimum=1)
        if twin is not None and twin.joints and twin.joints != "*":
            bound = len(twin.joints)
            if bound != quantity:
                entry.fail("quantity", f"is {quantity}, but twin.joints names {bound} joints")
        return quantity
    if twin is not None and twin.joints:
        return None if twin.joints == "*" else len(twin.joints)
    return 1


def _figures(name: str, entry: YamlMap, location: Location) -> tuple[FailureFigure, ...]:
    found = []
    if "probability" in entry:
        found.append(_probability(entry))
    if "failure_rate" in entry:
        found.append(_failure_rate(entry.map("failure_rate")))
    if not found:
        raise HardwareError(
            f"component '{name}' has no failure figure; give it "
            "'probability: {value: 1e-7, per: hour}' or 'failure_rate: {value: 1e-7, per: hour}'",
            location,
        )
    return tuple(found)


def _probability(entry: YamlMap) -> FailureFigure:
    if not isinstance(entry.require("probability"), dict):
        # A bare number is the published reading: one figure for each visit of a function.
        value = entry.number("probability", minimum=0.0, maximum=1.0)
        return FailureFigure("probability", value, Basis.VISIT)
    figure = entry.map("probability")
    figure.forbid_unknown(_FIGURE_KEYS - {"unit"})
    value = figure.number("value", minimum=0.0, maximum=1.0)
    return FailureFigure("probability", value, _basis(figure, tuple(Basis)))


def _failure_rate(figure: YamlMap) -> FailureFigure:
    figure.forbid_unknown(_FIGURE_KEYS)
    value = figure.number("value", minimum=0.0)
    if "unit" in figure:
        unit = figure.string("unit")
        if unit != "FIT":
            figure.fail("unit", f"'{unit}' is not allowed; {one_of(['FIT'], unit)}")
        if "per" in figure:
            figure.fail("per", "FIT are failures per 1e9 hours already; leave 'per' out")
        return FailureFigure("failure_rate", value / _HOURS_PER_FIT, Basis.HOUR)
    return FailureFigure("failure_rate", value, _basis(figure, (Basis.MINUTE, Basis.HOUR)))


def _basis(figure: YamlMap, allowed: tuple[Basis, ...]) -> Basis:
    word = figure.string("per")
    if word not in {basis.value for basis in allowed}:
        figure.fail("per", f"'{word}' is not allowed; {one_of([b.value for b in allowed], word)}")
    return Basis(word)


def _twin(binding: YamlMap) -> TwinBinding:
    binding.forbid_unknown(_TWIN_KEYS)
    if not binding.keys():
        raise HardwareError(
            f"names nothing; {one_of(_TWIN_KEYS)}, or write 'active: always' in its place",
            binding.location,
        )
    gripper = binding.boolean("gripper", default=False)
    optional = binding.boolean("optional", default=False)
    if optional and not gripper:
        binding.fail("optional", "only a component of the gripper can be optional")
    if "joints" not in binding:
        if not gripper:
            binding.fail("gripper", "is false and no joints are named: the twin sees nothing")
        return TwinBinding(gripper=True, optional=optional)
    if gripper:
        binding.fail("gripper", "a component is seen by joints or by the gripper, not by both")
    if isinstance(binding.require("joints"), str):
        word = binding.string("joints")
        if word != "*":
            binding.fail("joints", f"'{word}' is not allowed; write \"*\" or a list of joints")
        return TwinBinding(joints="*")
    joints = tuple(binding.strings("joints"))
    if not joints:
        binding.fail("joints", 'is an empty list; name a joint or write "*"')
    if len(set(joints)) != len(joints):
        binding.fail("joints", "names a joint twice")
    return TwinBinding(joints=joints)
