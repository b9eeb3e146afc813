"""The command lines of a source that reads `sys.argv` itself."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass

from tracerisk.instrument.source.dotted_names import last_name
from tracerisk.pipeline.scenarios.arguments.command_line import (
    NUMBERS,
    CommandLine,
    number_word,
    value_of,
)
from tracerisk.ros.drafts.named_numbers import Reach, named_number, numbers_in_place, units_said
from tracerisk.ros.drafts.said_around import lines_with

_JOINTS = re.compile(r"joint|angle|^q$|posture")


@dataclass(frozen=True, slots=True)
class _Word:
    """A word of `sys.argv` as a source reads it."""

    name: str
    """The variable that holds it; empty for none."""
    cast: str
    """The type that it is converted to, `float` or `int`; empty for a text."""


def words_read(tree: ast.AST) -> dict[int, _Word]:
    """Return the words of `sys.argv` that a source reads by their index, or in a slice."""
    words: dict[int, _Word] = {}
    for node in ast.walk(tree):
        index, cast = _argv_index(node)
        if index:
            words.setdefault(index, _Word("", cast))
    for target, value in _given(tree):
        index, cast = _argv_index(value)
        if index:
            words[index] = _Word(target, cast)
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign) and (start := _argv_slice(node.value)):
            targets = node.targets[0].elts if isinstance(node.targets[0], ast.Tuple) else ()
            for index, item in enumerate(targets, start):
                words[index] = _Word(last_name(item), _cast_in(node.value))
    return words


def _given(tree: ast.AST) -> Iterator[tuple[str, ast.expr]]:
    """Yield the names that are given a value, by an assignment or as a keyword."""
    for node in ast.walk(tree):
        if isinstance(node, ast.keyword) and node.arg:
            yield node.arg, node.value
        for target in node.targets if isinstance(node, ast.Assign) else ():
            assert isinstance(node, ast.Assign)
            if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
                pairs = zip(target.elts, node.value.elts, strict=False)
                yield from ((last_name(one), value) for one, value in pairs)
            else:
                yield last_name(target), node.value


def argv_lines(tree: ast.AST, text: str, reach: Reach | None) -> Iterator[CommandLine]:
    """Yield command lines of a source that reads `sys.argv` itself."""
    words = words_read(tree)
    names = {word.name: index for index, word in words.items() if word.name}
    literals: dict[int, list[str]] = {}
    tables = _tables(tree)
    for looked_up, container in _looked_up(tree):
        index = _argv_index(looked_up)[0] or names.get(last_name(looked_up), 0)
        value = tables.get(last_name(container)) or value_of(container)
        values = value if isinstance(value, list | tuple) else [value]
        if index:
            literals.setdefault(index, []).extend(str(v) for v in values if v is not None)
    if not words:
        yield from _of_slice(tree, text, reach)
        return

    def usual(index: int) -> str:
        word = words.get(index)
        if word is None or not word.cast or not word.name or reach is None:
            return "1"
        units = units_said(f"{_said_of_all(tree)}\n{lines_with(text, word.name)}")
        number = named_number(word.name, units, reach)
        return "1" if number is None else number_word(number, word.cast)

    first = literals.get(1) or [usual(1)]
    for word in dict.fromkeys(first):
        rest = [(literals.get(item) or [usual(item)])[0] for item in range(2, max(words) + 1)]
        is_plain = all(name == "1" for name in (word, *rest))
        remark = "as many words as the code reads" if is_plain else "numbers that the arm reaches"
        yield CommandLine((word, *rest), "as the code compares sys.argv" if literals else remark)


def _looked_up(tree: ast.AST) -> Iterator[tuple[ast.expr, ast.expr]]:
    """Yield what is compared, or looked up, each with that with or in which it is."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Compare) and isinstance(node.ops[0], ast.Eq | ast.In):
            yield node.left, node.comparators[0]
        elif isinstance(node, ast.Subscript) and isinstance(node.value, ast.Name):
            yield node.slice, node.value


def _tables(tree: ast.AST) -> dict[str, list[str]]:
    """Return the words that a dictionary of a source has for its keys, by its name."""
    return {
        last_name(node.targets[0]): words
        for node in ast.walk(tree)
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Dict)
        if (words := [key for item in node.value.keys if isinstance(key := value_of(item), str)])
    }


def _of_slice(tree: ast.AST, text: str, reach: Reach | None) -> Iterator[CommandLine]:
    """Yield the command line of a source that takes its words as one list of numbers."""
    for node in ast.walk(tree):
        start = _argv_slice(node.value) if isinstance(node, ast.Assign) else 0
        if not start or reach is None:
            continue
        assert isinstance(node, ast.Assign)
        cast, name = _cast_in(node.value), last_name(node.targets[0])
        count = _slice_length(node.value) or (len(reach.posture) if _JOINTS.search(name) else 3)
        units = units_said(f"{_said_of_all(tree)}\n{lines_with(text, name)}")
        numbers = numbers_in_place(count, units, reach) if cast else None
        if numbers is not None:
            words = tuple(number_word(number, cast) for number in numbers)
            yield CommandLine((*["1"] * (start - 1), *words), "numbers that the arm reaches")
            return


def _said_of_all(tree: ast.AST) -> str:
    """Return what a source says of its words as a whole: its docstring and how it is used."""
    usage = [
        node.value
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
        if "usage" in node.value.lower()
    ]
    docstring = ast.get_docstring(tree) if isinstance(tree, ast.Module) else None
    return "\n".join([docstring or "", *usage])


def _is_argv(node: ast.AST) -> bool:
    return isinstance(node, ast.Subscript) and ast.unparse(node.value) in ("sys.argv", "argv")


def _argv_index(node: ast.AST) -> tuple[int, str]:
    """Return which word of `sys.argv` an expression is, 0 for none, and the number made of it."""
    cast = ""
    while isinstance(node, ast.Call) and len(node.args) == 1:
        cast = last_name(node.func) if last_name(node.func) in NUMBERS else cast
        node = node.args[0]
    # `radians(float(sys.argv[1]))`, `float(sys.argv[1]) / 1000`
    if isinstance(node, ast.BinOp):
        return _argv_index(node.left)
    if _is_argv(node):
        assert isinstance(node, ast.Subscript)
        index = value_of(node.slice)
        return (index, cast) if isinstance(index, int) and index > 0 else (0, "")
    return 0, ""


def _argv_slice(node: ast.AST) -> int:
    """Return where a slice of `sys.argv` begins that is within an expression, 0 for none."""
    for item in ast.walk(node):
        if _is_argv(item) and isinstance(item, ast.Subscript):
            start = value_of(item.slice.lower) if isinstance(item.slice, ast.Slice) else None
            if isinstance(start, int) and start > 0:
                return start
    return 0


def _slice_length(node: ast.AST) -> int:
    for item in ast.walk(node):
        if _is_argv(item) and isinstance(item, ast.Subscript) and isinstance(item.slice, ast.Slice):
            start, end = value_of(item.slice.lower), value_of(item.slice.upper)
            if isinstance(start, int) and isinstance(end, int):
                return max(end - start, 0)
    return 0


def _cast_in(node: ast.AST) -> str:
    """Return the number that an expression makes of words: `map(float, sys.argv[1:4])`."""
    names = [item.id for item in ast.walk(node) if isinstance(item, ast.Name)]
    return next((name for name in names if name in NUMBERS), "")
