"""What two runs depended on, or a run and the files as they are now, and how that differs."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from tracerisk.pipeline.freshness.freshness import value_changes, variable_changes
from tracerisk.pipeline.freshness.run_inputs import GONE, RunInputs


def changed_inputs(
    old: RunInputs, new: RunInputs, shown: Callable[[str], str] = str
) -> Iterator[str]:
    """Yield in words what differs; `shown` returns how messages name a file of the inputs."""
    yield from _changed_files(old.sources, new.sources, shown)
    yield from _changed_files(old.files, new.files, shown)
    before, after = (inputs.settings.get("hardware") for inputs in (old, new))
    if before == after and old.hardware != new.hardware and old.hardware and new.hardware:
        name = "the hardware description" if after is None else shown(str(after))
        yield f"{name} is gone" if new.hardware == GONE else f"{name} has changed"
    for name in sorted({*old.settings, *new.settings}):
        values = old.settings.get(name), new.settings.get(name)
        if values[0] != values[1]:
            what = "the version of tracerisk" if name == "tracerisk" else f"setting {name}"
            yield from value_changes(what, *values)
    yield from variable_changes(old.variables, new.variables)


def _changed_files(
    old: Mapping[str, str], new: Mapping[str, str], shown: Callable[[str], str]
) -> Iterator[str]:
    for file in sorted({*old, *new}):
        if file not in new:
            yield f"{shown(file)} is no part of the run any more"
        elif file not in old:
            yield f"{shown(file)} is part of the run now"
        elif old[file] != new[file]:
            verb = {GONE: "is gone"}.get(new[file], "has changed")
            yield f"{shown(file)} {'is there now' if old[file] == GONE else verb}"
