"""A JSON document read element by element, with the path and the place of each in messages."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Collection, Mapping
from typing import Any, NoReturn, TypeVar

from tracerisk.errors import Location, ModelError, one_of

T = TypeVar("T")
Path = tuple[str | int, ...]


def read_document(text: str, file: str) -> Element:
    """Return the top of a JSON document; `file` is its name in messages.

    Raises ModelError, with line and column, when the text is not JSON, a key is repeated in one
    object, or a number is not finite.
    """
    document = _Document(text, file)
    try:
        data = json.loads(text, object_pairs_hook=_without_duplicates, parse_constant=_no_constant)
    except json.JSONDecodeError as error:
        raise ModelError(
            f"is not valid JSON: {error.msg}; is the file truncated?",
            Location(file, error.lineno, error.colno),
        ) from error
    except (ValueError, RecursionError) as error:
        detail = error.message if isinstance(error, ModelError) else "a number or nesting too large"
        raise ModelError(f"cannot be read: {detail}", Location(file)) from error
    return Element(data, (), document)


class Element:
    """A value of a document and its path, `faultTrees[2].gates[0].type`, for messages."""

    def __init__(self, value: Any, path: Path, document: _Document) -> None:
        self.value = value
        self.path = path
        self._document = document

    def __str__(self) -> str:
        text = ""
        for part in self.path:
            text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else part
        return text or "the document"

    @property
    def location(self) -> Location:
        """The place of the value in the file."""
        return self._document.location(self.path)

    def fail(self, message: str) -> NoReturn:
        """Raise ModelError with the path and the place of the value."""
        raise ModelError(f"{self}: {message}", self.location)

    def guard(self, make: Callable[[], T]) -> T:
        """Return what `make` does; its ModelError gets this path and place if it has none."""
        try:
            return make()
        except ModelError as error:
            if error.location is not None:
                raise
            raise ModelError(f"{self}: {error.message}", self.location) from error

    def entries(self) -> dict[str, Element]:
        """Return the entries of an object."""
        if not isinstance(self.value, Mapping):
            self.fail(f"expected an object, found {kind_of(self.value)}")
        return {
            key: Element(value, (*self.path, key), self._document)
            for key, value in self.value.items()
        }

    def fields(
        self, required: Collection[str], *, optional: Collection[str] = ()
    ) -> dict[str, Element]:
        """Return the entries of an object with known keys."""
        entries = self.entries()
        for key in sorted(required):
            if key not in entries:
                self.fail(f"'{key}' is missing")
        for key, element in entries.items():
            if key not in required and key not in optional:
                allowed = one_of({*required, *optional}, key)
                raise ModelError(f"{self}: unknown key '{key}'; {allowed}", element.location)
        return entries

    def items(self) -> tuple[Element, ...]:
        """Return the elements of a list."""
        if not isinstance(self.value, list):
            self.fail(f"expected a list, found {kind_of(self.value)}")
        return tuple(
            Element(value, (*self.path, index), self._document)
            for index, value in enumerate(self.value)
        )

    def each(self, read: Callable[[Element], T]) -> tuple[T, ...]:
        """Return what `read` makes of each element of a list."""
        return tuple(read(element) for element in self.items())

    def string(self) -> str:
        """Return a string."""
        if not isinstance(self.value, str):
            self.fail(f"expected a string, found {kind_of(self.value)}")
        return self.value

    def choice(self, allowed: Collection[str]) -> str:
        """Return a string that is one of `allowed`."""
        text = self.string()
        if text not in allowed:
            self.fail(f"is '{text}'; {one_of(allowed, text)}")
        return text

    def boolean(self) -> bool:
        """Return true or false."""
        if not isinstance(self.value, bool):
            self.fail(f"expected true or false, found {kind_of(self.value)}")
        return self.value

    def integer(self) -> int:
        """Return a whole number."""
        if isinstance(self.value, bool) or not isinstance(self.value, int):
            self.fail(f"expected a whole number, found {kind_of(self.value)}")
        return self.value

    def number(self) -> float:
        """Return a number of double precision."""
        if isinstance(self.value, bool) or not isinstance(self.value, int | float):
            self.fail(f"expected a number, found {kind_of(self.value)}")
        try:
            number = float(self.value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            self.fail("is too large for double precision")
        return number

    def probability(self) -> float:
        """Return a number from 0 to 1."""
        number = self.number()
        if not 0.0 <= number <= 1.0:
            self.fail(f"probability {self.value!r} is outside [0, 1]")
        return number


class _Document:
    """The text of a document, in which elements are found by their path."""

    def __init__(self, text: str, file: str) -> None:
        self._text = text
        self._file = file

    def location(self, path: Path) -> Location:
        offset = self._offset(path)
        before = self._text[:offset]
        line = before.count("\n") + 1
        return Location(self._file, line, offset - before.rfind("\n"))

    def _offset(self, path: Path) -> int:
        """Return where the value of a path begins; reads the text anew, for messages only."""
        decode = json.JSONDecoder().raw_decode
        at = self._skip(0)
        for part in path:
            at = self._skip(at + 1)
            index = 0
            while True:
                key: str | int = index
                if isinstance(part, str):
                    key, at = decode(self._text, at)
                    at = self._skip(self._skip(at) + 1)
                if key == part:
                    break
                _, at = decode(self._text, at)
                at = self._skip(self._skip(at) + 1)
                index += 1
        return at

    def _skip(self, at: int) -> int:
        while at < len(self._text) and self._text[at] in " \t\n\r":
            at += 1
        return at


def kind_of(value: Any) -> str:
    """Return what a JSON value is, in words."""
    if value is None:
        return "null"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int | float):
        return f"the number {value!r}"
    if isinstance(value, str):
        return f"the string '{value}'"
    return "a list" if isinstance(value, list) else "an object"


def _without_duplicates(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    without_duplicates: dict[str, Any] = {}
    for key, value in pairs:
        if key in without_duplicates:
            raise ModelError(f"duplicate key '{key}' in one object; remove one")
        without_duplicates[key] = value
    return without_duplicates


def _no_constant(text: str) -> NoReturn:
    raise ModelError(f"{text} is not allowed; give a finite number")
