"""Read from YAML how many units of a component must work, and when a failure is found."""

from __future__ import annotations

import math

from tracerisk.common.hardware.model import FailureFigure, default_detection
from tracerisk.common.hardware.redundancy import ALL_NEEDED, Detection, Redundancy, Repair
from tracerisk.common.hardware.units import SECONDS_PER
from tracerisk.common.hardware.yaml.figures import (
    positive,
    read_time,
    unit_map,
    word_of,
    words,
)
from tracerisk.common.text.yaml_reader import YamlMap
from tracerisk.errors import one_of

REDUNDANCY_KEYS = frozenset(
    {
        "redundancy",
        "required",
        "spare",
        "dormancy",
        "switch",
        "common_cause",
        "detected",
        "repair",
    }
)

_DETECTIONS: dict[str, Detection] = words(Detection)
_SPARES = {"hot": 1.0, "warm": None, "cold": 0.0}
_BEYOND_TRUE = ("required", "spare")


def read_redundancy(
    entry: YamlMap, figures: tuple[FailureFigure, ...]
) -> tuple[Redundancy, float | None]:
    """Return the redundancy of a component, and the time between the tests of the group [s].

    Raises HardwareError at what is malformed or contradicts itself.
    """
    implied = any(key in entry for key in _BEYOND_TRUE)
    is_redundant = entry.boolean("redundancy", default=implied)
    if not is_redundant:
        _forbid_for_all_needed(entry)
        return ALL_NEEDED, None
    detected, test_interval_s = _detected(entry)
    return (
        Redundancy(
            True,
            required=entry.integer("required", default=1, minimum=1),
            common_cause=_common_cause(entry),
            dormancy=_dormancy(entry),
            switch=_switch(entry),
            detected=detected
            or default_detection(figures, test_interval_s is not None or "repair" in entry),
        ),
        test_interval_s,
    )


def read_repair(entry: YamlMap) -> Repair | None:
    """Return how long the repair of a unit takes; `None` where the description does not say."""
    if "repair" not in entry:
        return None
    repair = unit_map(entry, "repair", "{mean_time: 8, per: hour}")
    repair.forbid_unknown({"mean_time", "rate", "per", "in_mission"})
    given = [key for key in ("mean_time", "rate") if key in repair]
    if len(given) != 1:
        entry.fail("repair", "needs either 'mean_time' or 'rate'; write {mean_time: 8, per: hour}")
    (key,) = given
    value, span = positive(repair, key), word_of(repair, "per", SECONDS_PER)
    mean_time_s = value * span if key == "mean_time" else span / value
    if not 0.0 < mean_time_s < math.inf:
        repair.fail(key, f"{value:g} gives no finite time above 0")
    return Repair(mean_time_s, repair.boolean("in_mission", default=False))


def _forbid_for_all_needed(entry: YamlMap) -> None:
    for key in _BEYOND_TRUE:
        if key in entry:
            entry.fail(key, "applies to redundant units, but 'redundancy' is false; remove one")
    for key in ("dormancy", "switch"):
        if key in entry:
            entry.fail(key, "applies to spares; give 'spare: hot', 'warm' or 'cold', or remove it")
    if "detected" in entry:
        entry.fail("detected", "units that are all needed have no hidden failures; remove it")
    if "common_cause" in entry:
        entry.fail(
            "common_cause",
            "applies to redundant units; when all units are needed, one failure is enough "
            "(redundancy: true, required: k or spare: hot)",
        )


def _common_cause(entry: YamlMap) -> float:
    cause = entry.optional_map("common_cause")
    if cause is None:
        return 0.0
    cause.forbid_unknown({"beta"})
    return cause.number("beta", minimum=0.0, maximum=1.0)


def _dormancy(entry: YamlMap) -> float:
    if "spare" not in entry:
        if "dormancy" in entry:
            entry.fail("dormancy", "applies to a warm spare; give 'spare: warm' too")
        return 1.0
    kind, fixed = entry.string("spare"), word_of(entry, "spare", _SPARES)
    if fixed is not None:
        if "dormancy" in entry:
            entry.fail("dormancy", f"is {fixed:g} for a {kind} spare; remove it")
        return fixed
    if "dormancy" not in entry:
        entry.fail(
            "spare",
            "a warm spare needs 'dormancy', its failure rate as a share of a working unit's",
        )
    dormancy = entry.number("dormancy", minimum=0.0, maximum=1.0)
    if dormancy in (0.0, 1.0):
        word = "cold" if dormancy == 0.0 else "hot"
        entry.fail(
            "dormancy", f"is {dormancy:g}, the dormancy of a {word} spare; write 'spare: {word}'"
        )
    return dormancy


def _switch(entry: YamlMap) -> float:
    if "switch" in entry and "spare" not in entry:
        entry.fail("switch", "is the probability that a spare fails to take over; give 'spare' too")
    return entry.number("switch", default=0.0, minimum=0.0, maximum=1.0)


def _detected(entry: YamlMap) -> tuple[Detection | None, float | None]:
    """Return when a failure of the group is detected, or the time between its tests [s]."""
    if "detected" not in entry:
        return None, None
    given = entry.require("detected")
    if isinstance(given, dict):
        return None, read_time(entry, "detected", value="test_interval")
    word = entry.string("detected")
    if word not in _DETECTIONS:
        entry.fail(
            "detected",
            f"'{word}' is not allowed; {one_of(_DETECTIONS, word)}, "
            "or {test_interval: 8, per: hour}",
        )
    return _DETECTIONS[word], None
