"""The operators and attributes of Python 2, as calls of its converted sources use them."""

from __future__ import annotations

import codecs
import datetime as dt
import functools
import operator
import sys
from collections.abc import Callable, Mapping
from types import FunctionType
from typing import Any

_LESS: dict[str, Callable[[Any, Any], Any]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}
_NUMBERS = (int, float)
_UNORDERED = (complex, set, frozenset, dt.date, dt.time, dt.timedelta)
_OF_BYTES = {"hex": "hex", "hex_codec": "hex", "base64": "base64", "zip": "zlib", "zlib": "zlib"}
_INSTEAD = {
    "func_name": "__name__",
    "func_code": "__code__",
    "func_defaults": "__defaults__",
    "func_globals": "__globals__",
    "func_doc": "__doc__",
    "func_dict": "__dict__",
    "im_func": "__func__",
    "im_self": "__self__",
    "isAlive": "is_alive",
    "next": "__next__",
}


def divided(left: Any, right: Any) -> Any:
    """Return `left / right`: of two integers, the largest integer that is not above it."""
    if _is_whole(left) and _is_whole(right):
        return left // right
    return left / right


def divided_in_place(left: Any, right: Any) -> Any:
    """Return what `left /= right` makes of the left side."""
    if _is_whole(left) and _is_whole(right):
        left //= right
    else:
        left /= right
    return left


def _is_whole(value: Any) -> bool:
    if isinstance(value, int):
        return True
    return getattr(getattr(value, "dtype", None), "kind", None) in ("i", "u", "b")


def compared(sign: str, left: Any, right: Any) -> Any:
    """Return `left < right`, or another comparison, of values of any types.

    None is below all, then come numbers; others go by the name of their type. Where Python 2 goes
    by the address in memory, both are equal.

    Raises:
        TypeError: a type of the two has no order with others there either.
    """
    try:
        return _LESS[sign](left, right)
    except TypeError:
        return _LESS[sign](ordered(left, right), 0)


def ordered(left: Any, right: Any) -> int:
    """Return -1, 0 or 1, as `cmp` of Python 2 does for values of any types."""
    try:
        if left == right:
            return 0
        return -1 if left < right else 1
    except TypeError:
        if isinstance(left, _UNORDERED) or isinstance(right, _UNORDERED):
            raise
    for one, other, sign in ((left, right, 1), (right, left, -1)):
        compare = getattr(type(one), "__cmp__", None)
        if compare is not None and (result := compare(one, other)) is not NotImplemented:
            return sign * int(result)
    if isinstance(left, list | tuple) and type(left) is type(right):
        for one, other in zip(left, right, strict=False):
            if (result := ordered(one, other)) != 0:
                return result
        return ordered(len(left), len(right))
    first, second = _rank(left), _rank(right)
    return (first > second) - (first < second)


def _rank(value: Any) -> tuple[str, int]:
    """Return by what values of different types are ordered."""
    if value is None:
        return "", 0
    if isinstance(value, _NUMBERS):
        return "", 1
    return type(value).__name__, 2


def sort_key(cmp: Callable[[Any, Any], int] | None, key: Callable[[Any], Any] | None) -> Any:
    """Return the key of `sorted` for a comparison and a key of Python 2."""
    by = functools.cmp_to_key(ordered if cmp is None else cmp)
    return by if key is None else lambda value: by(key(value))


def sorted_list(values: Any, cmp: Any = None, key: Any = None, reverse: bool = False) -> list[Any]:
    """Return the values in order, which may have any types."""
    result = list(values)
    _sort(result, cmp, key, reverse)
    return result


def _sort(values: list[Any], cmp: Any = None, key: Any = None, reverse: bool = False) -> None:
    if cmp is None:
        before = values[:]
        try:
            values.sort(key=key, reverse=reverse)
            return
        except TypeError:
            values[:] = before
    values.sort(key=sort_key(cmp, key), reverse=reverse)


def attribute(value: Any, name: str) -> Any:
    """Return an attribute that Python 3 has not, or whose value is another one there."""
    special = _SPECIAL.get(name)
    if special is not None:
        result = special(value, name)
        if result is not NotImplemented:
            return result
    try:
        return getattr(value, name)
    except AttributeError:
        if name in _INSTEAD and hasattr(value, _INSTEAD[name]):
            return getattr(value, _INSTEAD[name])
        if name in _LACKING:
            result = _LACKING[name](value)
            if result is not NotImplemented:
                return result
        raise


def to_bytes(value: Any) -> Any:
    """Return the bytes of a text whose characters are bytes; all else as it is."""
    if not isinstance(value, str):
        return value
    try:
        return value.encode("latin-1")
    except UnicodeEncodeError:
        return value.encode()


def to_text(value: Any) -> Any:
    """Return bytes as a text whose characters they are; all else as it is."""
    return bytes(value).decode("latin-1") if isinstance(value, bytes | bytearray) else value


def _of_dictionary(value: Any, name: str) -> Any:
    """Return what lists a dictionary's keys, where the class has not a method of its own."""
    if not isinstance(value, Mapping):
        return NotImplemented
    method = getattr(value, name)
    is_its_own = isinstance(getattr(type(value), name, None), FunctionType)
    if is_its_own and type(value).__module__ not in sys.stdlib_module_names:
        return NotImplemented
    return lambda: list(method())


def _sorting(value: Any, _: str) -> Any:
    return functools.partial(_sort, value) if type(value) is list else NotImplemented


def _coding(value: Any, name: str) -> Any:
    """Return what encodes or decodes a text: byte strings are texts of characters below 256."""
    if not isinstance(value, str):
        return NotImplemented

    def coded(encoding: str = "utf-8", errors: str = "strict") -> str:
        codec = _OF_BYTES.get(encoding.replace("-", "_"))
        if codec is not None:
            code = codecs.encode if name == "encode" else codecs.decode
            return str(to_text(code(to_bytes(value), codec)))
        if encoding in ("unicode_escape", "string_escape", "rot13", "rot_13"):
            if encoding.startswith("rot"):
                return codecs.encode(value, "rot13")
            if name == "encode":
                return value.encode("unicode_escape").decode("ascii")
            return value.encode("latin-1", "backslashreplace").decode("unicode_escape")
        if codecs.lookup(encoding).name == "ascii" and errors == "strict":
            if name == "encode":
                return value.encode("ascii").decode()
            return str(to_bytes(value).decode("ascii"))
        if errors in ("ignore", "replace"):
            return value.encode(encoding, errors).decode(encoding)
        return value

    return coded


def translated(text: str, table: Any, deleted: str = "") -> str:
    """Return a text without some characters, and with those of a table in the place of others."""
    kept = text.translate(dict.fromkeys(map(ord, deleted)))
    return kept if table is None else kept.translate(table)


def _translating(value: Any, _: str) -> Any:
    return functools.partial(translated, value) if isinstance(value, str) else NotImplemented


def _array_of_text(value: Any, _: str) -> Any:
    """Return what makes an array of a text that holds bytes, for NumPy takes only bytes."""
    if getattr(value, "__name__", "") != "numpy":
        return NotImplemented

    def fromstring(text: Any, dtype: Any = float, count: int = -1, sep: str = "") -> Any:
        if sep:
            return value.fromstring(text, dtype, count, sep=sep)
        return value.frombuffer(to_bytes(text), dtype, count).copy()

    return fromstring


_SPECIAL: dict[str, Callable[[Any, str], Any]] = {
    "keys": _of_dictionary,
    "values": _of_dictionary,
    "items": _of_dictionary,
    "sort": _sorting,
    "encode": _coding,
    "decode": _coding,
    "translate": _translating,
    "fromstring": _array_of_text,
}


def _iterating(method: str, *, as_view: bool = False) -> Callable[[Any], Any]:
    def lacking(value: Any) -> Any:
        if not hasattr(value, method):
            return NotImplemented
        return getattr(value, method) if as_view else lambda: iter(getattr(value, method)())

    return lacking


def _message(error: Any) -> Any:
    if not isinstance(error, BaseException):
        return NotImplemented
    return error.args[0] if len(error.args) == 1 else ""


def _of_sys(result: Callable[[], Any]) -> Callable[[Any], Any]:
    return lambda value: result() if value is sys else NotImplemented


_LACKING: dict[str, Callable[[Any], Any]] = {
    "has_key": lambda value: (
        value.__contains__ if hasattr(value, "__contains__") else NotImplemented
    ),
    "iteritems": _iterating("items"),
    "iterkeys": _iterating("keys"),
    "itervalues": _iterating("values"),
    "viewitems": _iterating("items", as_view=True),
    "viewkeys": _iterating("keys", as_view=True),
    "viewvalues": _iterating("values", as_view=True),
    "message": _message,
    "im_class": lambda value: (
        type(value.__self__) if hasattr(value, "__self__") else NotImplemented
    ),
    "maxint": _of_sys(lambda: sys.maxsize),
    "setdefaultencoding": _of_sys(lambda: lambda _: None),
    "exc_clear": _of_sys(lambda: lambda: None),
    "exc_type": _of_sys(lambda: sys.exc_info()[0]),
    "exc_value": _of_sys(lambda: sys.exc_info()[1]),
    "getchildren": lambda value: lambda: list(value),
    "getiterator": lambda value: value.iter if hasattr(value, "iter") else NotImplemented,
    "tostring": lambda value: (
        (lambda: value.tobytes().decode("latin-1")) if hasattr(value, "tobytes") else NotImplemented
    ),
}


ATTRIBUTES = frozenset({*_SPECIAL, *_INSTEAD, *_LACKING})
"""The attributes whose values may differ."""


def completed_class(kind: type) -> type:
    """Give a class the methods that Python 3 calls in the place of those of Python 2."""
    own = vars(kind)
    for old, new in _METHODS.items():
        if old in own and new not in own:
            setattr(kind, new, own[old])
    if "__cmp__" in own:
        for name, is_true in _BY_ORDER.items():
            if name not in own:
                setattr(kind, name, _by_cmp(is_true))
    if ("__eq__" in own or "__cmp__" in own) and own.get("__hash__", None) is None:
        kind.__hash__ = object.__hash__  # type: ignore[method-assign,assignment]
    return kind


_METHODS = {
    "__nonzero__": "__bool__",
    "next": "__next__",
    "__div__": "__truediv__",
    "__rdiv__": "__rtruediv__",
    "__idiv__": "__itruediv__",
}
CLASS_NAMES = frozenset({*_METHODS, "__cmp__", "__eq__"})
"""What a class may define that Python 3 calls by another name, or in another way."""
_BY_ORDER: dict[str, Callable[[int], bool]] = {
    "__lt__": lambda order: order < 0,
    "__le__": lambda order: order <= 0,
    "__gt__": lambda order: order > 0,
    "__ge__": lambda order: order >= 0,
    "__eq__": lambda order: order == 0,
    "__ne__": lambda order: order != 0,
}


def _by_cmp(is_true: Callable[[int], bool]) -> Callable[[Any, Any], bool]:
    def compare(self: Any, other: Any) -> bool:
        return is_true(self.__cmp__(other))

    return compare
