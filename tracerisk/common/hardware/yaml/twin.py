"""Read from YAML where the twin sees a component."""

from __future__ import annotations

from typing import Literal

from tracerisk.common.hardware.model import NOT_OPTIONAL, TwinBinding
from tracerisk.common.hardware.yaml.figures import words
from tracerisk.common.text.yaml_reader import YamlMap
from tracerisk.common.traced.elements import SensorKind
from tracerisk.errors import HardwareError, one_of

_SEEN_KEYS = frozenset({"joints", "gripper", "actuators", "sensors", "contacts"})
TWIN_KEYS = _SEEN_KEYS | {"optional"}
_SENSOR_KINDS: dict[str, SensorKind] = words(SensorKind)


def read_twin(entry: YamlMap) -> TwinBinding | None:
    """Return where the twin sees a component, `None` where the description does not say."""
    twin = entry.optional_map("twin")
    if twin is None:
        return None
    twin.forbid_unknown(TWIN_KEYS)
    if not set(twin.keys()) & _SEEN_KEYS:
        raise HardwareError(
            f"{entry.name_of('twin')}: is empty; {one_of(_SEEN_KEYS)}, or write 'active: always' "
            "instead",
            entry.key_location("twin"),
        )
    gripper = twin.boolean("gripper", default=False)
    binding = TwinBinding(
        joints=_joints(twin),
        gripper=gripper,
        optional=twin.boolean("optional", default=False),
        actuators=_names(twin, "actuators"),
        sensors=_sensors(twin),
        contacts=_names(twin, "contacts"),
    )
    if binding.named_units == 0:
        twin.fail("gripper", "is false, and there is no other binding")
    if binding.optional and not binding.can_be_optional:
        twin.fail("optional", NOT_OPTIONAL)
    return binding


def _joints(twin: YamlMap) -> tuple[str, ...] | Literal["*"]:
    if isinstance(twin.get("joints"), str):
        word = twin.string("joints")
        if word != "*":
            twin.fail("joints", f"'{word}' is not allowed; write \"*\" or a list of joints")
        return "*"
    return _names(twin, "joints", '; name a joint or write "*"')


def _sensors(twin: YamlMap) -> tuple[str, ...] | SensorKind:
    if isinstance(twin.get("sensors"), str):
        word = twin.string("sensors")
        if word not in _SENSOR_KINDS:
            twin.fail(
                "sensors",
                f"'{word}' is not a kind of sensor; {one_of(_SENSOR_KINDS, word)}, "
                "or a list of sensors by name",
            )
        return _SENSOR_KINDS[word]
    return _names(twin, "sensors", "; name a sensor or write a kind, such as encoder")


def _names(twin: YamlMap, key: str, advice: str = "; name one, or remove it") -> tuple[str, ...]:
    if key not in twin:
        return ()
    names = twin.strings(key)
    if not names:
        twin.fail(key, f"is an empty list{advice}")
    for index, name in enumerate(names):
        if name in names[:index]:
            raise HardwareError(
                f"{twin.name_of(key)}: names '{name}' twice",
                twin.entry_location(key, index),
            )
    return tuple(names)
