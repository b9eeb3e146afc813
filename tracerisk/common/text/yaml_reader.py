"""Read YAML with the position of every key, so that each error names file and line.

YAML 1.2 as `ruamel.yaml` reads it: `1e-7` is a number, `yes` a string.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Collection, Iterator, Sequence
from pathlib import Path
from typing import Any, NoReturn, TypeVar, cast

from tracerisk.common.text.bounded import file_bytes
from tracerisk.common.text.yaml_kinds import is_finite, is_map, kind_of, short
from tracerisk.common.text.yaml_repeated_keys import fold_repeated
from tracerisk.errors import InputError, Location, one_of

_Word = TypeVar("_Word", bound=str)

_MAX_BYTES = 16 * 1024 * 1024


def plain_yaml(text: str) -> Any:
    """Return what a text in YAML 1.2 holds, `None` where it cannot be read."""
    from ruamel.yaml import YAML
    from ruamel.yaml.error import YAMLError

    try:
        return YAML(typ="safe", pure=True).load(text)
    except (YAMLError, ValueError, TypeError, RecursionError, AttributeError):
        return None


class YamlMap:
    """A mapping of a YAML file whose accessors check types and name the place of a mistake.

    `path` is the dotted path from the top, for messages; `error` the class that is raised.
    """

    def __init__(self, node: Any, file: str, path: str, error: type[InputError]) -> None:
        self._node = node
        self._file = file
        self._path = path
        self._error = error

    @property
    def location(self) -> Location:
        """Where the mapping begins."""
        return Location(self._file, self._node.lc.line + 1, self._node.lc.col + 1)

    def key_location(self, key: str) -> Location:
        """Return where `key` stands; where the mapping begins if it has no such key."""
        # A key that was merged in (`<<: *other`) has no place of its own here.
        if key not in self._node or key not in (self._node.lc.data or {}):
            return self.location
        line, column = self._node.lc.key(key)
        return Location(self._file, line + 1, column + 1)

    def entry_location(self, key: str, index: int) -> Location:
        """Return where entry `index`, from 0, of the list at `key` stands."""
        value = self._node.get(key)
        if not hasattr(value, "lc") or index not in (value.lc.data or {}):
            return self.key_location(key)
        line, column = value.lc.item(index)
        return Location(self._file, line + 1, column + 1)

    def nested_location(self, keys: Sequence[str]) -> Location:
        """Return where the key stands that `keys` lead to, or the last of them that is there."""
        place = self.location
        map_ = self
        for key in keys:
            if key not in map_:
                break
            place = map_.key_location(key)
            if not is_map(map_.get(key)):
                break
            map_ = map_.map(key)
        return place

    def name_of(self, key: str) -> str:
        """Return the dotted path of `key`, as messages call it."""
        return f"{self._path}.{key}" if self._path else key

    def fail(self, key: str, message: str) -> NoReturn:
        """Raise the file's error at `key`."""
        raise self._error(f"{self.name_of(key)}: {message}", self.key_location(key))

    def keys(self) -> tuple[str, ...]:
        """Return the keys in the order of the file."""
        return tuple(self._node)

    def __iter__(self) -> Iterator[str]:
        return iter(self.keys())

    def __contains__(self, key: str) -> bool:
        return key in self._node

    def forbid_unknown(
        self, allowed: Collection[str], hint: Callable[[str, Any], str] | None = None
    ) -> None:
        """Raise at the first key that is not allowed, with the nearest allowed name.

        `hint` may say of a key and its value what to write instead.
        """
        for key in self._node:
            if key not in allowed:
                what = f"unknown key '{key}'"
                where = f" in {self._path}" if self._path else ""
                advice = hint(key, self._node[key]) if hint is not None else ""
                text = f"{what}{where}; {advice or one_of(allowed, key)}"
                raise self._error(text, self.key_location(key))

    def get(self, key: str) -> Any:
        """Return the raw value of `key`, `None` where it is absent."""
        return self._node.get(key)

    def require(self, key: str) -> Any:
        """Return the raw value of `key`; raise where it is absent or empty."""
        if self._node.get(key) is None:
            where = self._path or "the file"
            missing = "has no value" if key in self._node else "is missing"
            raise self._error(f"'{key}' {missing} in {where}; give it one", self.key_location(key))
        return self._node[key]

    def map(self, key: str) -> YamlMap:
        """Return the mapping at `key`."""
        value = self.require(key)
        if not is_map(value):
            self.fail(key, f"expected a mapping, found {kind_of(value)}")
        return YamlMap(value, self._file, self.name_of(key), self._error)

    def optional_map(self, key: str) -> YamlMap | None:
        """Return the mapping at `key`, `None` where the key is absent."""
        return self.map(key) if key in self._node else None

    def section(self, key: str) -> YamlMap:
        """Return the mapping at `key`, an empty one where the key is absent."""
        return self.optional_map(key) or YamlMap({}, self._file, self.name_of(key), self._error)

    def items_as_maps(self) -> Iterator[tuple[str, YamlMap]]:
        """Yield each key with the mapping it holds."""
        for key in self._node:
            yield key, self.map(key)

    def maps(self, key: str) -> list[YamlMap]:
        """Return the list of mappings at `key`; empty where the key is absent."""
        value = self._list(key)
        yaml_maps = []
        for index, entry in enumerate(value):
            if not is_map(entry):
                self._fail_entry(key, index, f"expected a mapping, found {kind_of(entry)}")
            yaml_maps.append(
                YamlMap(entry, self._file, f"{self.name_of(key)}[{index}]", self._error)
            )
        return yaml_maps

    def string(self, key: str, *, default: str | None = None) -> str:
        """Return the string at `key`; without a default the key must be there."""
        if default is not None and key not in self._node:
            return default
        value = self.require(key)
        if not isinstance(value, str):
            self.fail(key, f"expected a string, found {kind_of(value)}; put it in quotes")
        return str(value)

    def choice(
        self, key: str, allowed: Collection[_Word], what: str, *, default: str | None = None
    ) -> _Word:
        """Return the string at `key`, one of those that are allowed; `what` it is, for messages."""
        value = self.string(key, default=default)
        self._check_choice(key, value, allowed, what)
        return cast(_Word, value)

    def choices(self, key: str, allowed: Collection[str], what: str) -> tuple[str, ...]:
        """Return the strings at `key`, each one of those that are allowed, as `choice` does."""
        values = self.strings(key)
        for value in values:
            self._check_choice(key, value, allowed, what)
        return tuple(values)

    def _check_choice(self, key: str, value: str, allowed: Collection[str], what: str) -> None:
        if value not in allowed:
            self.fail(key, f"unknown {what} '{value}'; {one_of(allowed, value)}")

    def optional_string(self, key: str) -> str | None:
        """Return the string at `key`, `None` where the key is absent."""
        return self.string(key) if key in self._node else None

    def strings(self, key: str) -> list[str]:
        """Return the list of strings at `key`; empty where the key is absent."""
        value = self._list(key)
        for index, entry in enumerate(value):
            if not isinstance(entry, str):
                message = f"expected a list of strings, found {kind_of(entry)} in it"
                self._fail_entry(key, index, message)
        return [str(entry) for entry in value]

    def number(
        self,
        key: str,
        *,
        default: float | None = None,
        minimum: float | None = None,
        maximum: float | None = None,
    ) -> float:
        """Return the finite number at `key`, checked against its closed bounds."""
        if default is not None and key not in self._node:
            return default
        value = self.require(key)
        if isinstance(value, bool) or not isinstance(value, int | float):
            self.fail(key, f"expected a number, found {kind_of(value)}")
        if not is_finite(value):
            self.fail(key, f"expected a finite number, found {short(value)}")
        number = float(value)
        low = minimum is not None and number < minimum
        high = maximum is not None and number > maximum
        if low or high:
            bounds = f"[{'-inf' if minimum is None else f'{minimum:g}'}, "
            bounds += f"{'inf' if maximum is None else f'{maximum:g}'}]"
            self.fail(key, f"{number:g} is outside {bounds}")
        return number

    def integer(self, key: str, *, default: int | None = None, minimum: int | None = None) -> int:
        """Return the whole number at `key`."""
        if default is not None and key not in self._node:
            return default
        value = self.require(key)
        if isinstance(value, bool) or not isinstance(value, int):
            self.fail(key, f"expected a whole number, found {kind_of(value)}")
        if minimum is not None and value < minimum:
            self.fail(key, f"{value} is below {minimum}")
        return int(value)

    def boolean(self, key: str, *, default: bool | None = None) -> bool:
        """Return the truth value at `key`."""
        if default is not None and key not in self._node:
            return default
        value = self.require(key)
        if not isinstance(value, bool):
            self.fail(key, f"expected true or false, found {kind_of(value)}")
        return bool(value)

    def numbers(self, key: str, *, length: int | None = None) -> list[float]:
        """Return the list of finite numbers at `key`, of the given length if one is given."""
        value = self._list(key)
        for index, entry in enumerate(value):
            if (
                isinstance(entry, bool)
                or not isinstance(entry, int | float)
                or not is_finite(entry)
            ):
                message = f"expected a list of finite numbers, found {kind_of(entry)} in it"
                self._fail_entry(key, index, message)
        if length is not None and len(value) != length:
            self.fail(key, f"expected {length} numbers, found {len(value)}")
        return [float(entry) for entry in value]

    def triple(
        self, key: str, default: tuple[float, float, float] = (0.0, 0.0, 0.0)
    ) -> tuple[float, float, float]:
        """Return the three numbers at `key`, the default where it is absent."""
        if key not in self._node:
            return default
        x, y, z = self.numbers(key, length=3)
        return x, y, z

    def _fail_entry(self, key: str, index: int, message: str) -> NoReturn:
        raise self._error(
            f"{self.name_of(key)}: entry {index + 1}: {message}", self.entry_location(key, index)
        )

    def _list(self, key: str) -> list[Any]:
        if key not in self._node:
            return []
        value = self.require(key)
        if not isinstance(value, list):
            self.fail(key, f"expected a list, found {kind_of(value)}")
        return list(value)


def read_yaml(
    path: Path,
    error: type[InputError] = InputError,
    *,
    shown: str | None = None,
    version: tuple[int, int] = (1, 2),
    may_repeat: bool = False,
) -> YamlMap:
    """Read one YAML document whose top is a mapping.

    `shown` is the name for messages, the path by default; `version` that of YAML: in 1.1 `yes`
    is true. Keys that come twice are taken as ROS takes them where they `may_repeat`.
    Raises `error` with file and line when the file is absent, is not UTF-8, is larger than
    16 MB, is not YAML, is nested deeper than 100 levels, holds a key twice, or does not hold a
    mapping with string keys.
    """
    # Imported here: the verbs that read no YAML start faster without it.
    from ruamel.yaml.error import MarkedYAMLError, YAMLError

    from tracerisk.common.text.yaml_bounds import bounded_yaml

    file = shown if shown is not None else str(path)
    text = _text(path, file, error)
    try:
        yaml = bounded_yaml("rt", version)
        with warnings.catch_warnings():
            # `1e3`, which YAML 1.1 wants written `1.0e3`.
            warnings.simplefilter("ignore")
            root = yaml.compose(text) if may_repeat else None
            if root is None:
                node = yaml.load(text)
            else:
                fold_repeated(root)
                node = bounded_yaml("rt", version).constructor.construct_document(root)
    except MarkedYAMLError as cause:
        mark = cause.problem_mark or cause.context_mark
        place = Location(file, mark.line + 1, mark.column + 1) if mark else Location(file)
        raise error(f"is not valid YAML: {cause.problem or cause.context}", place) from cause
    except YAMLError as cause:
        raise error(f"is not valid YAML: {cause}", Location(file)) from cause
    except (TypeError, ValueError, RecursionError) as cause:
        # Keys that are mappings, dates that are none, what is nested without an end.
        raise error(f"cannot be read as YAML: {cause}", Location(file)) from cause
    except AttributeError as cause:
        # The library takes a value with one of these tags for a mapping without looking.
        tags = ("!!set", "!!omap")
        lines = enumerate(text.splitlines(), start=1)
        line = next((n for n, words in lines if any(tag in words for tag in tags)), None)
        raise error(
            "has a value that does not fit its tag (!!set, !!omap); write it without the tag",
            Location(file, line),
        ) from cause
    return _top(node, file, error)


def read_large_yaml(
    path: Path, error: type[InputError] = InputError, *, shown: str | None = None
) -> YamlMap:
    """Read one YAML document, which may hold thousands of entries, whose top is a mapping.

    As `read_yaml`, by libyaml; a date is a string.
    """
    from tracerisk.common.text.yaml_nodes import PlacedYamlError, load_placed

    file = shown if shown is not None else str(path)
    text = _text(path, file, error)
    try:
        node = load_placed(text)
    except PlacedYamlError as cause:
        place = Location(file)
        if cause.position is not None:
            line, column = cause.position
            place = Location(file, line + 1, column + 1)
        raise error(f"is not valid YAML: {cause.message}", place) from cause
    return _top(node, file, error)


def _text(path: Path, file: str, error: type[InputError]) -> str:
    try:
        data = file_bytes(path)
    except OSError as cause:
        raise error(f"cannot be read: {cause.strerror}", Location(file)) from cause
    if len(data) > _MAX_BYTES:
        raise error(f"holds {len(data)} bytes; at most {_MAX_BYTES} are allowed", Location(file))
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as cause:
        line = data[: cause.start].count(b"\n") + 1
        raise error("is not UTF-8; save it as UTF-8", Location(file, line)) from cause


def _top(node: Any, file: str, error: type[InputError]) -> YamlMap:
    if not is_map(node):
        raise error(f"expected a mapping at the top, found {kind_of(node)}", Location(file, 1))
    _check_keys(node, file, error, set())
    return YamlMap(node, file, "", error)


def _check_keys(node: Any, file: str, error: type[InputError], seen: set[int]) -> None:
    """Raise at a key that is not a string; what stands behind several anchors is looked at once."""
    if id(node) in seen:
        return
    if is_map(node):
        seen.add(id(node))
        for key in node:
            if not isinstance(key, str):
                line, column = node.lc.key(key)
                raise error(
                    f"key {key!r} is not a string; put it in quotes",
                    Location(file, line + 1, column + 1),
                )
            _check_keys(node[key], file, error, seen)
    elif isinstance(node, list):
        seen.add(id(node))
        for entry in node:
            _check_keys(entry, file, error, seen)
