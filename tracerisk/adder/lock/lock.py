"""`tracerisk.lock`: what was last written into each controller's blocks, and from which trace.

The values last written are the base of the three-way merge that distinguishes a user's edit from a
change of the tool. The lock is written before the sources and names, until they are written
too, the values that they held before: whichever of the two a source holds after a kill was
written by the tool.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePosixPath
from typing import Any, NamedTuple

from tracerisk.adder.blocks.block import NO_FAILURES, ComponentEntry, Field, RiskBlock
from tracerisk.adder.blocks.values import (
    CALL_SEQUENCE,
    COMPONENT_KINDS,
    FAILURES,
    NEXT,
    NOTHING_COMPUTED,
    FieldKind,
    component_fields,
)
from tracerisk.common.text.digests import blake2b
from tracerisk.common.text.printable import printable_json
from tracerisk.errors import InputError, Location

LOCK_NAME = "tracerisk.lock"
SCHEMA = "tracerisk.lock"
VERSION = 2

FUNCTION_KEYS = {CALL_SEQUENCE.key: CALL_SEQUENCE, NEXT.key: NEXT}
COMPONENT_KEYS = {kind.key: kind for kind in (*COMPONENT_KINDS, FAILURES)}
CONTROLLER_KEYS = (
    *("behind", "blocks", "digest", "fingerprint", "inputs", "kept", "others", "owned"),
    *("previous", "trace"),
)


class LockError(InputError):
    """The lock file is malformed."""

    code = "lock"


class WrittenComponent(NamedTuple):
    """The tool's values of one component as last written."""

    values: Mapping[str, str]
    """The text of each value, by key."""
    omitted: bool = False
    """Whether a user had omitted the component then."""


class WrittenBlock(NamedTuple):
    """The tool's values of one block as last written: those behind `=` and `computed`."""

    values: Mapping[str, str]
    """The text of each value of the function, by key."""
    components: Mapping[str, WrittenComponent]
    """The values of each component, by name."""


Written = Mapping[str, WrittenBlock]
"""The blocks last written into one source, by the qualified name of their function."""


def written_block(block: RiskBlock) -> WrittenBlock | None:
    """Return the tool's values that a block states; `None` for a block given by hand."""
    if block.added:
        return None
    values = _tool_values(((CALL_SEQUENCE, block.call_sequence), (NEXT, block.next)))
    components = {
        component.name: _written_component(component)
        for component in block.components
        if not component.added
    }
    return WrittenBlock(values, components)


def _written_component(component: ComponentEntry) -> WrittenComponent:
    return WrittenComponent(_tool_values(component_fields(component)), component.omitted)


def _tool_values(fields: Iterable[tuple[FieldKind, Field[Any] | None]]) -> dict[str, str]:
    values = {}
    for kind, value in fields:
        if value is None or not value.is_stated:
            continue
        text = value.computed if value.pinned else value.text
        if text is not None and text != NOTHING_COMPUTED:
            values[kind.key] = text
    return values


def as_written(name: str, written: WrittenBlock) -> RiskBlock:
    """Return the block that states the tool's values as they were last written."""
    values = {kind.key: _field(kind, written.values) for kind in FUNCTION_KEYS.values()}
    return RiskBlock(
        name=name,
        call_sequence=values[CALL_SEQUENCE.key] or Field(1, "1"),
        next=values[NEXT.key],
        components=tuple(
            _component_as_written(text, component)
            for text, component in written.components.items()
            # A component kept only for a user's value has no computed values, so it is left out.
            if component.omitted
            or {kind.key for kind in COMPONENT_KINDS} <= component.values.keys()
        ),
    )


def _component_as_written(name: str, written: WrittenComponent) -> ComponentEntry:
    unstated: Field[Any] = Field(None, "")
    probability, quantity, redundancy = (
        _field(kind, written.values) or unstated for kind in COMPONENT_KINDS
    )
    failures = _field(FAILURES, written.values) or NO_FAILURES
    return ComponentEntry(
        name, probability, quantity, redundancy, omitted=written.omitted, failures=failures
    )


def _field(kind: FieldKind, values: Mapping[str, str]) -> Field[Any] | None:
    text = values.get(kind.key)
    return None if text is None else Field(kind.read(text), text)


Kept = Mapping[str, Mapping[str, Mapping[str, str]]]
"""The text of a computed probability, by source, function and component."""


Uses = Mapping[str, Mapping[str, str]]
"""The text of a computed probability, by source and function: what one component does there."""


class OwnedValue(NamedTuple):
    """A figure that a user set, with what it was set for."""

    value: str
    """The text of the value, or `omit`."""
    reason: str
    """The user's reason, in one line; empty for none."""
    uses: Uses
    """What the component did in all functions when the value was written."""
    data: str
    """The digest of the component's hardware data by which `uses` was computed."""

    def is_of(self, value: str, reason: str) -> bool:
        """Whether it is what a block states, and not an earlier value or reason."""
        return (self.value, self.reason) == (value, reason)


Owned = Mapping[str, Mapping[str, Mapping[str, OwnedValue]]]
"""The figures that users set, by source, function and component."""


class Behind(NamedTuple):
    """Digests of what stands behind computed values: where they are the same, only noise differs.

    Empty in a lock of an earlier version, and then the same as nothing.
    """

    run: str = ""
    """Of the robot, the scene, the settings, the evidence, and all files that are no source."""
    functions: Mapping[str, Mapping[str, str]] = {}
    """Of the code behind each function, by source and function."""
    components: Mapping[str, str] = {}
    """Of each component in the hardware description, by name."""


@dataclass(frozen=True, slots=True)
class ControllerLock:
    """What the lock knows of one controller."""

    fingerprint: str
    """The digest of all that the trace depended on."""
    blocks: Mapping[str, Written]
    """What was last written into each source, by path from the lock's folder and function."""
    trace: Mapping[str, Any] = field(default_factory=dict)
    """The summary of the trace, as plain JSON values."""
    previous: Mapping[str, Written] | None = None
    """What the sources held before a write that is under way; `None` where none is."""
    inputs: Mapping[str, Any] = field(default_factory=dict)
    """All that the trace depended on, as plain JSON values."""
    others: tuple[Mapping[str, Written], ...] = ()
    """What other branches had written into the sources, of locks that were merged; the sources may
    hold any of them until the next write."""
    is_mixed: bool = False
    """Whether a merge has put lines of several entries into this one, or somebody changed it."""
    behind: Behind = field(default_factory=Behind)
    """What the values in the blocks rest on."""
    kept: Kept = field(default_factory=dict)
    """What was computed where the blocks keep a value within the tolerance of it."""
    owned: Owned = field(default_factory=dict)
    """What the values that users set were set for."""

    @property
    def is_settled(self) -> bool:
        """Whether the entry is as one run wrote it, and its sources were written too."""
        return self.previous is None and not self.others and not self.is_mixed

    @property
    def all_blocks(self) -> tuple[Mapping[str, Written], ...]:
        """What was last written into the sources, then all else that they may hold."""
        before = () if self.previous is None else (self.previous,)
        return (self.blocks, *before, *self.others)


@dataclass(frozen=True, slots=True)
class Lock:
    """The lock file."""

    controllers: Mapping[str, ControllerLock] = field(default_factory=dict)
    """The entry of each controller, by its path from the lock's folder."""

    def with_controller(self, path: str, controller: ControllerLock) -> Lock:
        """Return a lock in which `controller` stands at `path` (posix, relative).

        Raises:
            ValueError: if `path` is absolute or no posix path.
        """
        check_relative(path)
        for blocks in controller.all_blocks:
            for source in blocks:
                check_relative(source)
        return replace(self, controllers={**self.controllers, path: controller})

    def without_controller(self, path: str) -> Lock:
        """Return a lock that knows nothing of the controller at `path`."""
        kept = {name: entry for name, entry in self.controllers.items() if name != path}
        return replace(self, controllers=kept)

    def dumps(self) -> bytes:
        """Return the lock as bytes: JSON, sorted, one value a line, UTF-8 and line feeds."""
        data = {
            "schema": SCHEMA,
            "version": VERSION,
            "controllers": {
                path: _controller_data(entry) for path, entry in self.controllers.items()
            },
        }
        text = json.dumps(data, indent=1, sort_keys=True, ensure_ascii=False, allow_nan=False)
        return printable_json(text).encode() + b"\n"


def lock_key(path: Path, folder: Path) -> str:
    """Return how the lock in `folder` names the file at `path`: relative, with slashes.

    Raises:
        LockError: if the file is not in the folder of the lock.
    """
    try:
        return path.resolve().relative_to(folder.resolve()).as_posix()
    except ValueError as error:
        raise LockError(
            f"is not in {folder}, the folder of {LOCK_NAME}; move the lock to a common folder",
            Location(str(path)),
        ) from error


def check_relative(path: str) -> None:
    """Raise ValueError for a path that is not below the lock's folder."""
    if PurePosixPath(path).is_absolute() or "\\" in path or ".." in PurePosixPath(path).parts:
        raise ValueError(f"{path} is not a path relative to the lock's folder")


def _controller_data(entry: ControllerLock) -> dict[str, Any]:
    data: dict[str, Any] = {
        "blocks": _sources_data(entry.blocks),
        "fingerprint": entry.fingerprint,
        "inputs": dict(entry.inputs),
        "trace": dict(entry.trace),
    }
    if entry.previous is not None:
        data["previous"] = _sources_data(entry.previous)
    if entry.behind != Behind():
        data["behind"] = {
            "run": entry.behind.run,
            "functions": {file: dict(row) for file, row in entry.behind.functions.items()},
            "components": dict(entry.behind.components),
        }
    if entry.kept:
        data["kept"] = {
            file: {name: dict(row) for name, row in held.items()}
            for file, held in entry.kept.items()
        }
    if entry.owned:
        data["owned"] = {
            file: {
                name: {component: _owned_data(owned) for component, owned in row.items()}
                for name, row in functions.items()
            }
            for file, functions in entry.owned.items()
        }
    if entry.others:
        data["others"] = [_sources_data(other) for other in entry.others]
    # An entry that a merge has mixed stays so until it is written anew.
    data["digest"] = "" if entry.is_mixed else data_digest(data)
    return data


def _owned_data(owned: OwnedValue) -> dict[str, Any]:
    # A figure stands in one line with the data that it is of: no merge by lines parts them.
    uses = {
        file: {name: f"{text} of {owned.data}" for name, text in row.items()}
        for file, row in owned.uses.items()
    }
    data = {"value": owned.value, "reason": owned.reason, "uses": uses}
    return data if any(uses.values()) else {**data, "data": owned.data}


def data_digest(data: Mapping[str, Any]) -> str:
    """Return the digest of an entry's values, of what they depended on, and of the run's verdict.

    After a merge that mixes lines of two branches, the stored digest no longer matches.
    """
    inputs = data.get("inputs")
    depended_on = dict(inputs) if isinstance(inputs, Mapping) else {}
    depended_on.pop("given", None)  # only says how the `settings` were passed
    kept = [data.get("blocks"), data.get("fingerprint"), depended_on]
    kept += [data[key] for key in ("behind", "kept", "owned") if key in data]
    trace = data.get("trace")
    if isinstance(trace, Mapping) and "digest" in trace:  # locks of earlier versions have none
        kept.append([trace["digest"], trace.get("verdict")])
    text = json.dumps(kept, sort_keys=True, ensure_ascii=False)
    return str(blake2b(text.encode(errors="surrogatepass"), digest_size=8).hexdigest())


def _sources_data(sources: Mapping[str, Written]) -> dict[str, Any]:
    return {
        source: {name: _block_data(block) for name, block in written.items()}
        for source, written in sources.items()
    }


def _block_data(block: WrittenBlock) -> dict[str, Any]:
    components = {
        name: {**component.values, **({"omitted": True} if component.omitted else {})}
        for name, component in block.components.items()
    }
    return {**block.values, "components": components}
