"""Reading a lock: its JSON, its versions, and the sides that a merge left in it."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from tracerisk.adder.blocks.conflicts import conflict_sides
from tracerisk.adder.blocks.values import PROBABILITY, FieldKind
from tracerisk.adder.lock.lock import (
    COMPONENT_KEYS,
    CONTROLLER_KEYS,
    FUNCTION_KEYS,
    SCHEMA,
    VERSION,
    Behind,
    ControllerLock,
    Lock,
    LockError,
    OwnedValue,
    Written,
    WrittenBlock,
    WrittenComponent,
    check_relative,
    data_digest,
)
from tracerisk.common.text.bounded import MOST_WRITTEN, file_bytes, loads_json
from tracerisk.errors import Location, one_of

_READ_VERSIONS = (1, VERSION)  # before 2 neither entries nor blocks had a digest


def read_lock(path: Path) -> Lock:
    """Return the lock at `path`; an empty one where there is no such file.

    Raises:
        LockError: if the file is not a lock, or was cut short.
    """
    try:
        data = file_bytes(path, MOST_WRITTEN)
    except FileNotFoundError:
        return Lock()
    except OSError as error:
        raise LockError(
            f"cannot be read: {error.strerror}; restore it from version control",
            Location(str(path)),
        ) from error
    return loads(data, str(path))


def loads(data: bytes, file: str) -> Lock:
    """Return the lock that `data` states; `file` is its name in messages.

    If git left a conflict, each side is read as a lock of its own (it may mix lines of several
    entries). The sources hold what either branch wrote; the next write repairs the file.

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
            "the same command again",
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
        self._has_digests = True

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
        self._has_digests = top["version"] == VERSION
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
        table = dict(pairs)
        if len(table) != len(pairs) and not self._is_side:
            names = [name for name, _ in pairs]
            twice = sorted({name for name in names if names.count(name) > 1})
            raise self._error(
                f"duplicate {', '.join(twice)} in one object, as after a careless merge; "
                "restore it from version control"
            )
        return table

    def _controller(self, path: str, value: Any) -> ControllerLock:
        entry = self._mapping(value, path)
        self._known(entry, CONTROLLER_KEYS, path)
        fingerprint = entry.get("fingerprint")
        if not isinstance(fingerprint, str):
            raise self._error(f"{path}: fingerprint is missing or not a string")
        previous = entry.get("previous")
        others = entry.get("others", [])
        if not isinstance(others, list):
            raise self._error(f"{path}: others is not a JSON list; restore the file")
        digest = entry.get("digest")
        try:
            check_relative(path)
        except ValueError as error:
            raise self._error(str(error)) from error
        return ControllerLock(
            fingerprint=fingerprint,
            blocks=self._sources(entry.get("blocks"), f"{path}: blocks"),
            trace=self._mapping(entry.get("trace"), f"{path}: trace"),
            inputs=self._mapping(entry.get("inputs", {}), f"{path}: inputs"),
            previous=None if previous is None else self._sources(previous, f"{path}: previous"),
            others=tuple(self._sources(other, f"{path}: others") for other in others),
            behind=self._behind(entry.get("behind"), f"{path}: behind"),
            kept=self._kept(entry.get("kept", {}), f"{path}: kept"),
            owned=self._owned(entry.get("owned", {}), f"{path}: owned"),
            is_mixed=self._has_digests and digest != data_digest(entry),
        )

    def _behind(self, value: Any, where: str) -> Behind:
        if value is None:
            return Behind()
        table = self._mapping(value, where)
        self._known(table, Behind._fields, where)
        functions = self._mapping(table.get("functions"), f"{where}: functions")
        return Behind(
            str(table.get("run", "")),
            {file: self._mapping(held, f"{where}: {file}") for file, held in functions.items()},
            self._mapping(table.get("components"), f"{where}: components"),
        )

    def _kept(self, value: Any, where: str) -> dict[str, dict[str, dict[str, str]]]:
        kept: dict[str, dict[str, dict[str, str]]] = {}
        for file, functions in self._mapping(value, where).items():
            kept[file] = {}
            for name, texts in self._mapping(functions, f"{where}: {file}").items():
                place = f"{where}: {file}: {name}"
                kinds = dict.fromkeys(self._mapping(texts, place), PROBABILITY)
                kept[file][name] = self._values(texts, kinds, place)
        return kept

    def _owned(self, value: Any, where: str) -> dict[str, dict[str, dict[str, OwnedValue]]]:
        owned: dict[str, dict[str, dict[str, OwnedValue]]] = {}
        for file, functions in self._mapping(value, where).items():
            owned[file] = {}
            for name, row in self._mapping(functions, f"{where}: {file}").items():
                place = f"{where}: {file}: {name}"
                owned[file][name] = {
                    component: self._owned_value(held, file, name, f"{place}: {component}")
                    for component, held in self._mapping(row, place).items()
                }
        return owned

    def _owned_value(self, value: Any, file: str, function: str, where: str) -> OwnedValue:
        entry = self._mapping(value, where)
        self._known(entry, OwnedValue._fields, where)
        uses: dict[str, dict[str, str]] = {}
        data_of: dict[tuple[str, str], str] = {}
        for source, row in self._mapping(entry.get("uses"), f"{where}: uses").items():
            place = f"{where}: {source}"
            texts = {}
            for name, text in self._mapping(row, place).items():
                texts[name], _, data_of[source, name] = str(text).partition(" of ")
            uses[source] = self._values(texts, dict.fromkeys(texts, PROBABILITY), place)
        # Only the function's own figure is compared; a merge may have mixed it with others.
        own = data_of.get((file, function))
        said = {*data_of.values()} if own is None else {own}
        data = said.pop() if len(said) == 1 else ""
        # One for no use says it by itself, and those of earlier versions do.
        data = data or str(entry.get("data", ""))
        return OwnedValue(str(entry.get("value", "")), str(entry.get("reason", "")), uses, data)

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
            self._values(entry, FUNCTION_KEYS, where),
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
        return WrittenComponent(self._values(entry, COMPONENT_KEYS, where), omitted)

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
            raise self._error(f"{where} is missing or not a JSON object; restore the file")
        return value

    def _known(self, entry: Mapping[str, Any], allowed: Iterable[str], where: str) -> None:
        names = sorted(allowed)
        for key in entry:
            if key not in names:
                raise self._error(f"{where}: unknown key {key}; {one_of(names, key)}")
