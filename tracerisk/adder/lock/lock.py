"""`tracerisk.lock`: what was last written into each controller's blocks, and from which trace.

The values last written are the base of the three-way merge that distinguishes a user's edit from a
change of the tool. The lock is written before the sources and names, until they are written
too, the values that they held before: whichever of the two a source holds after a kill was
written by the tool.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from functools import lru_cache
from pathlib import Path, PurePosixPath
from typing import Any

from tracerisk.adder.blocks.block import ComponentEntry, Field, RiskBlock
from tracerisk.adder.blocks.conflicts import conflict_sides
from tracerisk.adder.blocks.values import (
    CALL_SEQUENCE,
    COMPONENT_KINDS,
    NEXT,
    NOTHING_COMPUTED,
    FieldKind,
    component_fields,
)
from tracerisk.errors import InputError, Location, one_of
from tracerisk.records import dataclass, field, replace
from tracerisk.text.bounded import loads_json
from tracerisk.text.digests import blake2b

LOCK_NAME = "tracerisk.lock"
SCHEMA = "tracerisk.lock"
VERSION = 2
_READ_VERSIONS = (1, VERSION)  # before 2 neither entries nor blocks had a digest

_FUNCTION_KEYS = {CALL_SEQUENCE.key: CALL_SEQUENCE, NEXT.key: NEXT}
_COMPONENT_KEYS = {kind.key: kind for kind in COMPONENT_KINDS}
_CONTROLLER_KEYS = ("blocks", "digest", "fingerprint", "inputs", "others", "previous", "trace")


class LockError(InputError):
    """The lock file is malformed."""

    code = "lock"


@dataclass(frozen=True, slots=True)
class WrittenComponent:
    """The tool's values of one component as last written, as text by key.

    `omitted`: a user had omitted the component then.
    """

    values: Mapping[str, str]
    omitted: bool = False


@dataclass(frozen=True, slots=True)
class WrittenBlock:
    """The tool's values of one block as last written: those behind `=` and `computed`."""

    values: Mapping[str, str]
    components: Mapping[str, WrittenComponent] = field(default_factory=dict)


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
    values = {kind.key: _field(kind, written.values) for kind in _FUNCTION_KEYS.values()}
    return RiskBlock(
        name=name,
        call_sequence=values[CALL_SEQUENCE.key] or Field(1, "1"),
        next=values[NEXT.key],
        components=tuple(
            _component_as_written(each, component)
            for each, component in written.components.items()
            # Where a user's value outlives its component, nothing was computed there.
            if component.omitted or _COMPONENT_KEYS.keys() <= component.values.keys()
        ),
    )


def _component_as_written(name: str, written: WrittenComponent) -> ComponentEntry:
    unstated: Field[Any] = Field(None, "")
    probability, quantity, redundancy = (
        _field(kind, written.values) or unstated for kind in COMPONENT_KINDS
    )
    return ComponentEntry(name, probability, quantity, redundancy, omitted=written.omitted)


def _field(kind: FieldKind, values: Mapping[str, str]) -> Field[Any] | None:
    text = values.get(kind.key)
    return None if text is None else Field(kind.read(text), text)


@dataclass(frozen=True, slots=True)
class ControllerLock:
    """What the lock knows of one controller.

    `blocks` maps each source, relative to the lock's folder, to what was last written in it.
    `previous` is not `None` while a write is under way: what the sources held before it.
    `others` is what other branches had written into the sources, of locks that were merged: what
    the sources hold now may be of any of them, until the next write.
    `is_mixed` marks an entry read from a file into which a merge has put lines of several.
    `fingerprint` is a digest of what the trace depended on, `inputs` what that was and `trace`
    the summary of the trace: plain JSON values, as the caller gave them.
    """

    fingerprint: str
    blocks: Mapping[str, Written]
    trace: Mapping[str, Any] = field(default_factory=dict)
    previous: Mapping[str, Written] | None = None
    inputs: Mapping[str, Any] = field(default_factory=dict)
    others: tuple[Mapping[str, Written], ...] = ()
    is_mixed: bool = False

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
    """The lock file: one entry a controller, by its path relative to the lock's folder."""

    controllers: Mapping[str, ControllerLock] = field(default_factory=dict)

    def with_controller(self, path: str, controller: ControllerLock) -> Lock:
        """Return a lock in which `controller` stands at `path` (posix, relative).

        Raises:
            ValueError: if `path` is absolute or no posix path.
        """
        _check_relative(path)
        for blocks in controller.all_blocks:
            for source in blocks:
                _check_relative(source)
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
        return text.encode() + b"\n"


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


def _check_relative(path: str) -> None:
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
    if entry.others:
        data["others"] = [_sources_data(each) for each in entry.others]
    # An entry that a merge has mixed stays so until it is written anew.
    data["digest"] = "" if entry.is_mixed else _data_digest(data)
    return data


def _data_digest(data: Mapping[str, Any]) -> str:
    """Return the digest of an entry's values and of what they depended on.

    Where a merge mixes lines of two branches, it does not fit.
    """
    inputs = data.get("inputs")
    depended_on = dict(inputs) if isinstance(inputs, Mapping) else {}
    depended_on.pop("given", None)  # says how it was asked for what `settings` hold
    kept = [data.get("blocks"), data.get("fingerprint"), depended_on]
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


def read_lock(path: Path) -> Lock:
    """Return the lock at `path`; an empty one where there is no such file.

    Raises:
        LockError: if the file is not a lock, or was cut short.
    """
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        return Lock()
    return _loads_once(data, str(path))


# A refresh of many controllers reads their lock several times for each.
@lru_cache(maxsize=4)
def _loads_once(data: bytes, file: str) -> Lock:
    return loads(data, file)


def loads(data: bytes, file: str) -> Lock:
    """Return the lock that `data` states; `file` is its name in messages.

    Where git left a conflict, each side is a lock, or lines of several: the sources hold what one
    branch or the other has written, and the next write heals the file.

    Raises:
        LockError: as `read_lock`.
    """
    reader = _Reader(file)
    sides = conflict_sides(data)
    if sides is None:
        return reader.lock(data)
    line, ours, theirs = sides
    try:
        reader = _Reader(file, is_side=True)
        return _joined(reader.lock(ours), reader.lock(theirs))
    except LockError as error:
        raise LockError(
            "holds a conflict whose sides are no whole locks; take one side of the file, then run "
            "tracerisk again",
            Location(file, line),
        ) from error


def _joined(ours: Lock, theirs: Lock) -> Lock:
    """Return one lock of two: what differs is stale, and either may be what the sources hold."""
    controllers = {**theirs.controllers, **ours.controllers}
    for path, entry in ours.controllers.items():
        other = theirs.controllers.get(path, entry)
        if other != entry:
            controllers[path] = joined_entry(entry, other)
    return Lock(controllers)


def joined_entry(ours: ControllerLock, theirs: ControllerLock) -> ControllerLock:
    """Return one entry of two that differ: stale, with all that either may have written."""
    others: list[Mapping[str, Written]] = []
    for blocks in (*ours.all_blocks[1:], *theirs.all_blocks):
        if blocks not in (ours.blocks, *others):
            others.append(blocks)
    return replace(
        ours, fingerprint="", previous=None, others=tuple(others or [ours.blocks]), is_mixed=False
    )


class _Reader:
    """Checks the shape of a lock while turning it into a `Lock`.

    One side of a conflict (`is_side`) may hold lines of the other, and so a name twice.
    """

    def __init__(self, file: str, *, is_side: bool = False) -> None:
        self._file = file
        self._is_side = is_side

    def _error(self, message: str, line: int | None = None, column: int | None = None) -> LockError:
        return LockError(message, Location(self._file, line, column))

    def lock(self, data: bytes) -> Lock:
        top = self._mapping(self._json(data), "the lock")
        if top.get("schema") != SCHEMA:
            raise self._error(f"is not a lock of tracerisk: it has no `schema` {SCHEMA}")
        if top.get("version") not in _READ_VERSIONS:
            raise self._error(
                f"has version {top.get('version')}; this tracerisk reads {VERSION}; "
                "use the tracerisk that wrote it, or delete the file"
            )
        self._known(top, ("controllers", "schema", "version"), "the lock")
        controllers = self._mapping(top.get("controllers"), "controllers")
        return Lock({path: self._controller(path, value) for path, value in controllers.items()})

    def _json(self, data: bytes) -> Any:
        try:
            text = data.decode()
        except UnicodeDecodeError as error:
            raise self._error("is not UTF-8 text; restore it from version control") from error
        try:
            return loads_json(text, object_pairs_hook=self._object)
        except json.JSONDecodeError as error:
            raise self._error(
                f"is not JSON ({error.msg}), or was cut short; restore it from version control",
                error.lineno,
                error.colno,
            ) from error
        except LockError:
            raise
        except ValueError as error:
            raise self._error(f"holds {error}; restore it from version control") from error

    def _object(self, pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        found = dict(pairs)
        if len(found) != len(pairs) and not self._is_side:
            names = [name for name, _ in pairs]
            twice = sorted({name for name in names if names.count(name) > 1})
            raise self._error(
                f"duplicate {', '.join(twice)} in one object, as after a careless merge; "
                "restore it from version control"
            )
        return found

    def _controller(self, path: str, value: Any) -> ControllerLock:
        entry = self._mapping(value, path)
        self._known(entry, _CONTROLLER_KEYS, path)
        fingerprint = entry.get("fingerprint")
        if not isinstance(fingerprint, str):
            raise self._error(f"{path}: fingerprint is missing or no text")
        previous = entry.get("previous")
        others = entry.get("others", [])
        if not isinstance(others, list):
            raise self._error(f"{path}: others is not JSON list; restore the file")
        digest = entry.get("digest")
        try:
            _check_relative(path)
        except ValueError as error:
            raise self._error(str(error)) from error
        return ControllerLock(
            fingerprint=fingerprint,
            blocks=self._sources(entry.get("blocks"), f"{path}: blocks"),
            trace=self._mapping(entry.get("trace"), f"{path}: trace"),
            inputs=self._mapping(entry.get("inputs", {}), f"{path}: inputs"),
            previous=None if previous is None else self._sources(previous, f"{path}: previous"),
            others=tuple(self._sources(each, f"{path}: others") for each in others),
            is_mixed=digest is not None and digest != _data_digest(entry),
        )

    def _sources(self, value: Any, where: str) -> dict[str, dict[str, WrittenBlock]]:
        return {
            source: {
                name: self._block(block, f"{where}: {source}: {name}")
                for name, block in self._mapping(blocks, f"{where}: {source}").items()
            }
            for source, blocks in self._mapping(value, where).items()
        }

    def _block(self, value: Any, where: str) -> WrittenBlock:
        entry = dict(self._mapping(value, where))
        components = self._mapping(entry.pop("components", None), f"{where}: components")
        return WrittenBlock(
            self._values(entry, _FUNCTION_KEYS, where),
            {
                name: self._component(component, f"{where}: {name}")
                for name, component in components.items()
            },
        )

    def _component(self, value: Any, where: str) -> WrittenComponent:
        entry = dict(self._mapping(value, where))
        omitted = entry.pop("omitted", False)
        if not isinstance(omitted, bool):
            raise self._error(f"{where}: omitted = {omitted} is not allowed; allowed: true, false")
        return WrittenComponent(self._values(entry, _COMPONENT_KEYS, where), omitted)

    def _values(
        self, entry: Mapping[str, Any], kinds: Mapping[str, FieldKind], where: str
    ) -> dict[str, str]:
        self._known(entry, kinds, where)
        for key, text in entry.items():
            try:
                kinds[key].read(text if isinstance(text, str) else "")
            except ValueError as error:
                raise self._error(
                    f"{where}: {key} = {text} is not allowed; allowed: {error}"
                ) from error
        return dict(entry)

    def _mapping(self, value: Any, where: str) -> dict[str, Any]:
        if not isinstance(value, dict):
            raise self._error(f"{where} is missing or no JSON object; restore the file")
        return value

    def _known(self, entry: Mapping[str, Any], allowed: Iterable[str], where: str) -> None:
        names = sorted(allowed)
        for key in entry:
            if key not in names:
                raise self._error(f"{where}: unknown key {key}; {one_of(names, key)}")
