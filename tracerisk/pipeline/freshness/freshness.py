"""Whether what a trace depended on is still as it was, checked without a run."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Collection, Iterable, Mapping
from pathlib import Path
from typing import Any

from tracerisk.adder.lock.lock import ControllerLock
from tracerisk.common.evidence import EVIDENCE_NAME
from tracerisk.common.settings.python_here import CHANGED_PYTHON
from tracerisk.config import Settings
from tracerisk.errors import DependencyError
from tracerisk.instrument.source.code_digest import code_digest
from tracerisk.pipeline.freshness.run_inputs import (
    GONE,
    UNSET,
    RunInputs,
    file_digest,
    hardware_digest,
    libraries_of,
    settings_data,
    variable_digests,
)
from tracerisk.pipeline.freshness.used_evidence import evidence_digest
from tracerisk.pipeline.workspace.controller import Controller

_NOT_SET = {
    "tracerisk": "version of tracerisk",
    CHANGED_PYTHON: "what PYTHONPATH changes in Python",
}
"""What is kept among the settings and is none, in words."""
_TOLERANCES = (
    ("outcome_place_mm", "place_m", 1000.0),
    ("outcome_angle_deg", "angle_deg", 1.0),
    ("outcome_joint_mrad", "joint", 1000.0),
)
"""Settings of the outcome, with the name and the unit that the lock has for each."""


def variable_changes(before: Mapping[str, str], now: Mapping[str, str]) -> Iterable[str]:
    """Yield in words which environment variables differ that both versions name.

    That one is named no more, or newly, is a change of the settings.
    """
    for name in sorted({*now} & {*before}):
        if before[name] != now[name]:
            verb = "is not set any more" if now[name] == UNSET else "has another value"
            verb = "is set now" if before[name] == UNSET else verb
            yield f"environment variable {name} {verb}"


def stale_reasons(
    recorded: RunInputs, controller: Controller, settings: Settings
) -> tuple[str, ...]:
    """Return why the trace of a controller is no longer what a run would give; none if it is.

    Raises as `run_inputs`.
    """
    root = controller.root.resolve()
    return (
        *_settings_reasons(recorded.settings, settings_data(settings, root)),
        *_changed(recorded.sources, lambda file: _code_now(controller, file)),
        *_changed(_comparable(recorded, root), lambda file: file_digest(root / file)),
        *_library_reasons(recorded, libraries_of(controller, settings, recorded.sources)),
        *variable_changes(recorded.variables, variable_digests(settings)),
    )


def values_reasons(
    recorded: RunInputs, controller: Controller, settings: Settings
) -> tuple[str, ...]:
    """Return why the values no longer follow from the trace: other hardware, other evidence."""
    texts = []
    # Another description that the settings name is a change of the settings.
    named = settings_data(settings, controller.root.resolve()).get("hardware")
    is_same = named == recorded.settings.get("hardware")
    if is_same and recorded.hardware != hardware_digest(settings):
        name = settings.hardware or "the hardware description"
        if Path(name).is_absolute():
            name = os.path.relpath(name, controller.root.resolve())
        texts.append(f"{name} has changed")
    if recorded.evidence != evidence_digest(controller, settings, recorded.fingerprint):
        texts.append(f"{EVIDENCE_NAME} has changed")
    return tuple(texts)


def tolerance_reasons(entry: ControllerLock, settings: Settings) -> Iterable[str]:
    """Yield which tolerances of an outcome are not those with which the lock keeps it.

    By those of the locks `diff` judges whether two missions are the same.
    """
    kept, usual = entry.trace.get("outcome"), Settings()
    is_usual = all(getattr(settings, name) == getattr(usual, name) for name, *_ in _TOLERANCES)
    if not isinstance(kept, dict) or (is_usual and "tolerances" not in kept):
        return
    # Not needed to check most controllers, which must be quick.
    from tracerisk.common.outcome.kept import kept_outcome, kept_tolerances
    from tracerisk.common.outcome.tolerances import Tolerances

    if kept_outcome(entry.trace) is None:
        return
    now, before = Tolerances.of(settings), kept_tolerances(entry.trace)
    for name, field_name, per_unit in _TOLERANCES:
        was, is_now = getattr(before, field_name), getattr(now, field_name)
        if was != is_now:
            yield f"setting {name} was {was * per_unit:g}, is {is_now * per_unit:g}"


def check_changed_hardware(settings: Settings, recorded: RunInputs) -> None:
    """Raise HardwareError where the hardware description has changed and cannot be read.

    No refresh would go on with it.
    """
    if settings.hardware is None or recorded.hardware == hardware_digest(settings):
        return
    from tracerisk.common.hardware.formats import read_description  # rarely read here

    with contextlib.suppress(DependencyError):  # a refresh says what to install
        read_description(Path(settings.hardware), system=settings.system)


def _comparable(recorded: RunInputs, root: Path) -> dict[str, str]:
    """Return the files of a run that can be compared here.

    Those of a prefix that this machine does not have cannot: where blocks are checked, no ROS
    needs to be installed.
    """
    prefixes = [Path(os.path.normpath(root / name)) for name in recorded.prefixes]
    absent = [prefix for prefix in prefixes if not prefix.is_dir()]
    if not absent:
        return dict(recorded.files)
    return {
        file: digest
        for file, digest in recorded.files.items()
        if not any(Path(os.path.normpath(root / file)).is_relative_to(prefix) for prefix in absent)
    }


def _settings_reasons(before: Mapping[str, Any], now: Mapping[str, Any]) -> Iterable[str]:
    for name in sorted({*before, *now}):
        if before.get(name) != now.get(name):
            text = _NOT_SET.get(name, f"setting {name}")
            yield from value_changes(text, before.get(name), now.get(name))


def value_changes(what: str, before: Any, now: Any) -> Iterable[str]:
    """Yield in words how the value of a setting changed; of a list of tables, entry by entry."""
    old, new = ([] if value is None else value for value in (before, now))
    values = [*old, *new] if isinstance(old, list) and isinstance(new, list) else []
    if not values or not all(isinstance(value, dict) for value in values):
        was, is_now = ("the default" if value is None else value for value in (before, now))
        yield f"{what} was {was}, is {is_now}"
        return
    gone = [f"{what} has no entry any more with {_entry(one)}" for one in old if one not in new]
    added = [f"{what} has a new entry with {_entry(one)}" for one in new if one not in old]
    yield from [*gone, *added] or [f"{what} has its entries in another order"]


def _entry(table: Mapping[str, Any]) -> str:
    return ", ".join(f"{key} {value!r}" for key, value in table.items() if value not in ("", None))


def _changed(recorded: Mapping[str, str], now: Callable[[str], str]) -> Iterable[str]:
    for file, digest in sorted(recorded.items()):
        text = now(file)
        if text != digest:
            verb = {GONE: "is gone"}.get(text, "is there now" if digest == GONE else "has changed")
            yield f"{file} {verb}"


def _library_reasons(recorded: RunInputs, now: Collection[str]) -> Iterable[str]:
    for file in sorted({*recorded.libraries} ^ {*now}):
        if file in now:
            yield f"{file} is library code now: its functions are no steps any more"
        elif file in recorded.sources:
            yield f"{file} is not a library code any more: its functions may be steps"


def _code_now(controller: Controller, file: str) -> str:
    if file != controller.file and not controller.path_of(file).is_file():
        return GONE
    return code_digest(controller.source_of(file), file)
