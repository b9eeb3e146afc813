"""Read from YAML what a component's use does to it: load law and failure modes."""

from __future__ import annotations

from collections.abc import Mapping

from tracerisk.common.hardware.load import unmeasured_exponent
from tracerisk.common.hardware.model import (
    LONGEST_FAULT_S,
    SHORTEST_FAULT_S,
    Demand,
    FailureMode,
    FaultMode,
    LoadLaw,
    State,
)
from tracerisk.common.hardware.yaml.figures import word_of, words
from tracerisk.common.text.yaml_reader import YamlMap
from tracerisk.common.traced.elements import WEAR_EXPONENTS
from tracerisk.errors import HardwareError, one_of

USES: Mapping[str, State | Demand] = words(State) | words(Demand)
"""The words for the uses in which a failure mode can matter."""

LAW_KEYS = frozenset({"reference_load", "wearing_share", "exponent", "reference_speed", "source"})
MODE_KEYS = frozenset({"fraction", "when", "source", "fault", "lasts_s"})


def read_load_law(entry: YamlMap) -> LoadLaw | None:
    """Return the load law of a component, `None` where it has none."""
    law = entry.optional_map("load_law")
    if law is None:
        return None
    law.forbid_unknown(LAW_KEYS)
    return LoadLaw(
        reference_load=_fraction(law, "reference_load"),
        wearing_share=law.number("wearing_share", minimum=0.0, maximum=1.0),
        exponent=_exponent(law),
        reference_speed=_fraction(law, "reference_speed") if "reference_speed" in law else None,
        source=law.optional_string("source"),
    )


def read_modes(entry: YamlMap) -> tuple[FailureMode, ...]:
    """Return the failure modes of a component; empty where it names none."""
    modes = entry.optional_map("modes")
    if modes is None:
        return ()
    if not modes.keys():
        entry.fail("modes", "is empty; give a mode such as jam: {fraction: 0.4, when: [moving]}")
    return tuple(_mode(name, mode) for name, mode in modes.items_as_maps())


def _mode(name: str, mode: YamlMap) -> FailureMode:
    mode.forbid_unknown(MODE_KEYS)
    given = mode.strings("when") if "when" in mode else ()
    if "when" in mode and not given:
        mode.fail("when", f"is an empty list; {one_of(USES)}")
    for index, word in enumerate(given):
        place = mode.entry_location("when", index)
        if word not in USES:
            raise HardwareError(
                f"{mode.name_of('when')}: '{word}' is not allowed; {one_of(USES, word)}", place
            )
        if word in given[:index]:
            raise HardwareError(f"{mode.name_of('when')}: names '{word}' twice", place)
    return FailureMode(
        name,
        _fraction(mode, "fraction"),
        tuple(USES[word] for word in given),
        mode.optional_string("source"),
        word_of(mode, "fault", words(FaultMode)) if "fault" in mode else None,
        _lasts_s(mode),
    )


def _lasts_s(mode: YamlMap) -> float | None:
    if "lasts_s" not in mode:
        return None
    if "fault" not in mode:
        mode.fail("lasts_s", "is of a fault that passes; give the mode a 'fault'")
    return mode.number("lasts_s", minimum=SHORTEST_FAULT_S, maximum=LONGEST_FAULT_S)


def _exponent(law: YamlMap) -> float:
    if "exponent" not in law:
        return 3.0
    given = law.require("exponent")
    if isinstance(given, str):
        exponent = 10.0 / 3.0 if given == "10/3" else None
    else:
        number = law.number("exponent")
        exponent = number if number in WEAR_EXPONENTS else None
    if exponent is None:
        law.fail("exponent", unmeasured_exponent(f"{given}"))
    return exponent


def _fraction(entry: YamlMap, key: str) -> float:
    """Return the number at `key`, which is above 0 and at most 1."""
    value = entry.number(key, minimum=0.0, maximum=1.0)
    if value == 0.0:
        entry.fail(key, "is 0; give a fraction above 0 and at most 1")
    return value
