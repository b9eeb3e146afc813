"""The built-in names of Python 2, which the modules of converted sources see in place of ours."""

from __future__ import annotations

import ast
import builtins
import functools
import io
import itertools
import math
import sys
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

from tracerisk.common.text.bounded import file_bytes
from tracerisk.instrument.python_2 import operators
from tracerisk.instrument.python_2.imports import import_module, reload_module
from tracerisk.instrument.python_2.meaning import (
    ATTRIBUTE,
    CLASS,
    COMPARED,
    DIVIDED,
    DIVIDED_IN_PLACE,
    SIGN,
    give_meaning,
)
from tracerisk.instrument.source.python_2 import NotConvertibleError
from tracerisk.instrument.source.python_2_text import converted
from tracerisk.instrument.source.python_source import decoded


@functools.lru_cache(maxsize=1)
def built_ins() -> dict[str, Any]:
    """Return the names, the same for all modules of a process."""
    return vars(builtins) | _names()


def raw_input(prompt: object = "") -> str:
    """Return a line of the standard input."""
    return builtins.input(prompt)


def evaluated_input(prompt: object = "") -> Any:
    """Return the value of the expression that a line of the standard input holds."""
    frame = sys._getframe(1)
    return _evaluate(builtins.input(prompt), frame.f_globals, frame.f_locals)


def evaluate(source: Any, names: Any = None, own: Any = None) -> Any:
    """Return the value of an expression, by the rules of Python 2."""
    names, own = _spaces(names, own, sys._getframe(1))
    return _evaluate(source, names, own)


def _evaluate(source: Any, names: Any, own: Any) -> Any:
    if isinstance(source, str):
        source = code_of(source.strip(), "<string>", "eval")
    return builtins.eval(source, names, own)


def execute(source: Any, names: Any = None, own: Any = None) -> None:
    """Execute statements, by the rules of Python 2."""
    names, own = _spaces(names, own, sys._getframe(1))
    if isinstance(source, str):
        source = code_of(source, "<string>", "exec")
    builtins.exec(source, names, own)


def execute_file(name: str, names: Any = None, own: Any = None) -> None:
    """Execute the statements of a file."""
    names, own = _spaces(names, own, sys._getframe(1))
    builtins.exec(code_of(decoded(file_bytes(Path(name))), name, "exec"), names, own)


def _spaces(names: Any, own: Any, frame: FrameType) -> tuple[Any, Any]:
    if names is None:
        return frame.f_globals, frame.f_locals if own is None else own
    names.setdefault("__builtins__", built_ins())
    return names, names if own is None else own


def code_of(text: str, name: str, mode: str) -> CodeType:
    """Return the code of a text in Python 2: `mode` is that of `compile`."""
    try:
        tree = ast.parse(converted(text), name)
    except NotConvertibleError as error:
        raise SyntaxError(error.reason) from error
    give_meaning(tree)
    if mode != "eval":
        return compile(tree, name, "exec", dont_inherit=True)
    value = getattr(tree.body[-1], "value", None)
    if not isinstance(tree.body[-1], ast.Expr) or value is None:
        raise SyntaxError("this is not an expression")
    return compile(ast.Expression(value), name, "eval", dont_inherit=True)


def listed_range(*bounds: Any) -> list[int]:
    """Return the numbers of a range as a list."""
    return list(range(*map(_whole, bounds)))


def lazy_range(*bounds: Any) -> range:
    """Return a range that makes its numbers when they are asked for."""
    return range(*map(_whole, bounds))


def _whole(value: Any) -> Any:
    # Python 2 refuses floats alone: it takes for whole what can be made so, of NumPy for instance.
    return int(value) if hasattr(value, "__int__") and not isinstance(value, float) else value


def mapped(function: Callable[..., Any] | None, *values: Iterable[Any]) -> list[Any]:
    """Return the results of a function; what is shorter than the others is filled up with None."""
    if len(values) == 1:
        return list(values[0]) if function is None else list(map(function, values[0]))
    rows = itertools.zip_longest(*values)
    return list(rows) if function is None else [function(*row) for row in rows]


def filtered(function: Callable[[Any], Any] | None, values: Any) -> Any:
    """Return what a function keeps, as a list, a text or a tuple."""
    kept = filter(function, values)
    if isinstance(values, str):
        return "".join(kept)
    return tuple(kept) if isinstance(values, tuple) else list(kept)


def zipped(*values: Iterable[Any]) -> list[tuple[Any, ...]]:
    """Return the pairs as a list."""
    return list(zip(*values, strict=False))


def rounded(number: Any, digits: int = 0) -> Any:
    """Return a number rounded half away from zero, as a float."""
    if isinstance(number, str):
        raise TypeError("a float is required")
    value = float(number)
    if not math.isfinite(value):
        return value
    from decimal import ROUND_HALF_UP, Decimal, localcontext

    with localcontext() as context:
        context.prec = 1500  # a decimal of all digits: the binary value itself decides what is half
        exact = Decimal(value).scaleb(digits).quantize(Decimal(1), rounding=ROUND_HALF_UP)
        return float(exact.scaleb(-digits))


def _extreme(function: Callable[..., Any]) -> Callable[..., Any]:
    def extreme(*values: Any, **options: Any) -> Any:
        if len(values) == 1:
            values = (list(values[0]),)
        try:
            return function(*values, **options)
        except TypeError:
            key = operators.sort_key(None, options.get("key"))
            return function(*values, **{**options, "key": key})

    return extreme


def _instances_of(kind: Any) -> type:
    """Return the metaclass of a type whose instances are those of another."""

    class Meta(type):
        def __instancecheck__(cls, value: object) -> bool:
            return isinstance(value, kind)

        def __subclasscheck__(cls, other: type) -> bool:
            return issubclass(other, kind)

        def __eq__(cls, other: object) -> bool:
            return other is cls or other is kind

        def __hash__(cls) -> int:
            return hash(kind) if not isinstance(kind, tuple) else id(cls)

    return Meta


class Text(str, metaclass=_instances_of(str)):  # type: ignore[metaclass]
    """`unicode`: a text is one type here."""

    __slots__ = ()

    def __new__(cls, value: Any = "", encoding: str | None = None, errors: str = "strict") -> Any:
        """Return a plain text."""
        if isinstance(value, bytes | bytearray):
            return value.decode(encoding or "ascii", errors)
        convert = getattr(type(value), "__unicode__", None)
        return convert(value) if convert is not None else str(value)


class OpenFile(metaclass=_instances_of(io.IOBase)):  # type: ignore[metaclass]
    """`file`: opens a file."""

    def __new__(cls, *arguments: Any, **options: Any) -> Any:
        """Return the open file."""
        return opened(*arguments, **options)


class Bytes(bytearray, metaclass=_instances_of(bytearray)):  # type: ignore[metaclass]
    """`bytearray`, made of a text too."""

    def __new__(cls, value: Any = b"", *rest: Any) -> Any:
        """Return a plain array."""
        if isinstance(value, str) and not rest:
            return bytearray(value, "latin-1")
        return bytearray(value, *rest)


def opened(name: Any, mode: str = "r", buffering: int = -1) -> Any:
    """Open a file, which gives texts: of a binary one, each character is a byte."""
    plain = mode.replace("U", "") or "r"
    if "b" not in plain:
        if buffering == 0:
            buffering = 1
        return builtins.open(name, plain, buffering, errors="surrogateescape")  # noqa: PTH123
    plain, buffering = plain.replace("b", ""), -1 if buffering in (0, 1) else buffering
    return builtins.open(name, plain, buffering, encoding="latin-1", newline="")  # noqa: PTH123


def ordinal(value: Any) -> int:
    """Return the number of a character; a byte that is a number already is itself."""
    return value if isinstance(value, int) else ord(value)


def applied(function: Callable[..., Any], arguments: Any = (), named: Any = None) -> Any:
    """Call a function."""
    return function(*arguments, **(named or {}))


def coerced(left: Any, right: Any) -> tuple[Any, Any]:
    """Return two numbers as numbers of one type."""
    kind = type(left + right)
    return kind(left), kind(right)


def next_of(iterator: Iterator[Any], *default: Any) -> Any:
    """Return the next value, by the method of either Python."""
    if not hasattr(iterator, "__next__") and hasattr(iterator, "next"):
        try:
            return iterator.next()
        except StopIteration:
            if default:
                return default[0]
            raise
    return next(iterator, *default)


def _names() -> dict[str, Any]:
    return {
        SIGN: True,
        DIVIDED: operators.divided,
        DIVIDED_IN_PLACE: operators.divided_in_place,
        COMPARED: operators.compared,
        ATTRIBUTE: operators.attribute,
        CLASS: operators.completed_class,
        "__import__": import_module,
        "apply": applied,
        "basestring": str,
        "buffer": memoryview,
        "bytearray": Bytes,
        "bytes": str,
        "cmp": operators.ordered,
        "coerce": coerced,
        "eval": evaluate,
        "exec": execute,
        "execfile": execute_file,
        "file": OpenFile,
        "filter": filtered,
        "input": evaluated_input,
        "intern": sys.intern,
        "long": int,
        "map": mapped,
        "max": _extreme(max),
        "min": _extreme(min),
        "next": next_of,
        "open": opened,
        "ord": ordinal,
        "range": listed_range,
        "raw_input": raw_input,
        "reduce": functools.reduce,
        "reload": reload_module,
        "round": rounded,
        "sorted": operators.sorted_list,
        "StandardError": Exception,
        "unichr": chr,
        "unicode": Text,
        "WindowsError": OSError,
        "xrange": lazy_range,
        "zip": zipped,
    }
