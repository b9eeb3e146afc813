"""The command lines that a controller's source takes, as far as it can be read without running it.

A number is one that the arm reaches where its name says that it is a place, in the units that the
source says.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tracerisk.errors import TraceRiskError
from tracerisk.instrument.source.dotted_names import last_name
from tracerisk.instrument.source.literals.named_literals import literal_value
from tracerisk.pipeline.scenarios.argument_files import fitting_files, is_read
from tracerisk.pipeline.scenarios.handed_arguments import with_plain_argv
from tracerisk.pipeline.workspace.controller import Controller
from tracerisk.pipeline.workspace.own_modules import own_modules, source_bytes
from tracerisk.ros.drafts.named_numbers import Reach, named_number, numbers_in_place, units_said
from tracerisk.ros.drafts.said_around import lines_with
from tracerisk.trace import RunEnd

_OF_ARGUMENTS = re.compile(r"arg")
_NUMBERS = ("float", "int")
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?", re.IGNORECASE)
_JOINTS = re.compile(r"joint|angle|^q$|posture")


@dataclass(frozen=True, slots=True)
class CommandLine:
    """Arguments with which a controller may be started."""

    words: tuple[str, ...]
    """The arguments, without the program."""
    remark: str
    """Where they are from, in words."""


def reads_arguments(controller: Controller, end: RunEnd) -> bool:
    """Return whether a run was ended by an exception for want of arguments.

    It is at a line that reads the command line, or of None in a source that reads options.
    """
    place = end.location
    if end.cause != "raised" or place is None or place.line is None:
        return False
    if not place.file.endswith(".py"):
        return False
    try:
        text = controller.source_of(place.file).decode(errors="replace")
    except TraceRiskError:
        return False
    if "NoneType" in end.message and "add_argument" in text:
        # An option of argparse that is not given is None, wherever that is used.
        return True
    lines = text.splitlines()
    return any(_OF_ARGUMENTS.search(line) for line in lines[place.line - 1 : place.line])


def command_lines(
    controller: Controller,
    written: Iterable[tuple[tuple[str, ...], str]] = (),
    reach: Reach | None = None,
) -> tuple[CommandLine, ...]:
    """Return command lines that the source takes, the likeliest first.

    Those that the repository writes (`written`, each with its place), then what `argparse` demands,
    a file to read being one of the repository's that fits, then this with each of its switches,
    then the words with which `sys.argv` is compared, and numbers within `reach`.
    """
    lines: list[CommandLine] = []
    numbers: set[int] = set()
    for path in (controller.path.resolve(), *own_modules(controller)):
        source = source_bytes(path)
        tree = controller.project.tree(source)
        if tree is not None:
            tree = with_plain_argv(tree)
            text = source.decode(errors="replace")
            lines += _of_argparse(tree, text, controller.project.top, reach)
            lines += _of_argv(tree, text, reach)
            numbers |= {index for index, word in _words_read(tree).items() if word.cast}
    lines = [
        *(CommandLine(words, f"as in {place}") for words, place in written if _has(words, numbers)),
        *lines,
    ]
    return tuple(
        {
            command_line.words: command_line
            for command_line in reversed(lines)
            if command_line.words
        }.values()
    )[::-1]


def _has(words: Sequence[str], numbers: Iterable[int]) -> bool:
    """Return whether a written command line has numbers where the source makes some of its words.

    `move.py X Y Z` names them alone.
    """
    at = [words[index - 1] for index in numbers if index <= len(words)]
    return all(_NUMBER.fullmatch(name) for name in at)


def _of_argparse(tree: ast.AST, text: str, top: Path, reach: Reach | None) -> Iterator[CommandLine]:
    options = [
        _Option.read(node, text, reach)
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and last_name(node.func) in ("add_argument", "option")
    ]
    needed = [word for option in options if option.is_needed for word in option.words]
    # Of a group of which one must be given, the first.
    groups = _required_groups(tree)
    for option in options:
        if option.owner in groups and not option.is_needed:
            groups.discard(option.owner)
            needed += option.words
    read = {word for option in options if option.is_file for word in option.words[-1:]} & {*needed}
    if read:
        files = fitting_files(tree, top)
        for file in files:
            words = tuple(file if name in read else name for name in needed)
            yield CommandLine(words, "what argparse demands, with a file of the repository")
        if not files:
            remark = (
                f"a file of yours has to stand for {' and '.join(sorted(read))}: none here fits"
            )
            yield CommandLine(tuple(needed), f"what argparse demands; {remark}")
        needed = [files[0] if files and name in read else name for name in needed]
    elif needed:
        yield CommandLine(tuple(needed), "what argparse demands")
    empty = [word for option in options if option.is_empty for word in option.words]
    if empty:
        yield CommandLine((*needed, *empty), "with the options that have no default")
    for option in options:
        if not option.is_needed and option.is_switch and option.words[0] not in needed:
            yield CommandLine((*needed, *option.words), f"with the switch {option.words[0]}")


@dataclass(frozen=True, slots=True)
class _Option:
    words: tuple[str, ...]
    """The words with which it is given: flag and values, or the values alone."""
    owner: str
    """The expression of the parser or group that it belongs to."""
    is_needed: bool
    """Whether it must be given."""
    is_switch: bool
    """Whether it takes no value."""
    is_file: bool
    """Whether its value names a file to read."""
    is_empty: bool
    """Whether it is a number or several, and None where it is not given."""

    @classmethod
    def read(cls, call: ast.Call, text: str, reach: Reach | None) -> _Option:
        names = [
            str(argument.value) for argument in call.args if isinstance(argument, ast.Constant)
        ]
        given = {keyword.arg: keyword.value for keyword in call.keywords}
        flags = [name for name in names if name.startswith("-")]
        is_switch = _value(given.get("action")) in ("store_true", "store_const", "count")
        count = _value(given.get("nargs"))
        value = _argument_value(names, given)
        repeat = count if isinstance(count, int) and not isinstance(count, bool) else 1
        values = () if is_switch else tuple([value] * max(repeat, 1))
        if not is_switch and reach is not None:
            values = _in_reach(names, given, len(values), text, reach) or values
        flag = max(flags, key=len, default=None)
        words = values if flag is None else (flag, *values)
        # Without `nargs` a positional argument must be given whatever its default.
        needed = _value(given.get("required")) is True if flags else count not in ("?", "*")
        owner = ast.unparse(call.func.value) if isinstance(call.func, ast.Attribute) else ""
        metavar = _value(given.get("metavar"))
        called = [*names, metavar] if isinstance(metavar, str) else names
        kind = given.get("type")
        kind = kind.func if isinstance(kind, ast.Call) else kind
        # The caller needs no file where there is a default or a list of choices.
        is_file = is_read(called, "" if kind is None else last_name(kind)) and value == (
            names[-1].strip("-") if names else ""
        )
        is_needed = bool(needed and names)
        is_number = not is_switch and not is_file and last_name(given.get("type")) in _NUMBERS
        is_empty = bool(flags) and not is_needed and is_number and "default" not in given
        return cls(words, owner, is_needed, is_switch, is_file and not is_switch, is_empty)


def _in_reach(
    names: list[str], given: dict[str | None, ast.expr], count: int, text: str, reach: Reach
) -> tuple[str, ...]:
    """Return the numbers of an option where it is a place, an angle or a length; () for others."""
    cast = last_name(given["type"]) if "type" in given else ""
    if cast not in _NUMBERS or not names or "choices" in given or "default" in given:
        return ()
    name = max(names, key=len).strip("-").replace("-", "_")
    units = units_said(f"{name} {_value(given.get('help'))}\n{lines_with(text, f'.{name}')}")
    if count > 1:
        numbers = numbers_in_place(count, units, reach) or ()
        return tuple(_shown(value, cast) for value in numbers)
    number = named_number(name, units, reach)
    return () if number is None else (_shown(number, cast),)


def _argument_value(names: list[str], given: dict[str | None, ast.expr]) -> str:
    choices = _value(given.get("choices"))
    if isinstance(choices, list | tuple) and choices:
        return str(choices[0])
    default = _value(given.get("default"))
    if default is not None and not isinstance(default, bool | list | tuple | dict):
        return str(default)
    kind = last_name(given["type"]) if "type" in given else "str"
    return {"int": "1", "float": "0.1", "bool": "true"}.get(kind) or names[-1].strip("-")


def _required_groups(tree: ast.AST) -> set[str]:
    return {
        ast.unparse(target)
        for node in ast.walk(tree)
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Call)
        if last_name(node.value.func) == "add_mutually_exclusive_group"
        if any(k.arg == "required" and _value(k.value) is True for k in node.value.keywords)
        for target in node.targets
    }


@dataclass(frozen=True, slots=True)
class _Word:
    """A word of `sys.argv` as a source reads it."""

    name: str
    """The variable that holds it; empty for none."""
    cast: str
    """The type that it is converted to, `float` or `int`; empty for a text."""


def _words_read(tree: ast.AST) -> dict[int, _Word]:
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


def _of_argv(tree: ast.AST, text: str, reach: Reach | None) -> Iterator[CommandLine]:
    """Yield command lines of a source that reads `sys.argv` itself."""
    words = _words_read(tree)
    names = {word.name: index for index, word in words.items() if word.name}
    literals: dict[int, list[str]] = {}
    tables = _tables(tree)
    for looked_up, container in _looked_up(tree):
        index = _argv_index(looked_up)[0] or names.get(last_name(looked_up), 0)
        value = tables.get(last_name(container)) or _value(container)
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
        return "1" if number is None else _shown(number, word.cast)

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
        if (words := [key for item in node.value.keys if isinstance(key := _value(item), str)])
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
            words = tuple(_shown(number, cast) for number in numbers)
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


def _shown(number: float, cast: str) -> str:
    return str(round(number)) if cast == "int" else f"{number + 0.0:.4g}"


def _is_argv(node: ast.AST) -> bool:
    return isinstance(node, ast.Subscript) and ast.unparse(node.value) in ("sys.argv", "argv")


def _argv_index(node: ast.AST) -> tuple[int, str]:
    """Return which word of `sys.argv` an expression is, 0 for none, and the number made of it."""
    cast = ""
    while isinstance(node, ast.Call) and len(node.args) == 1:
        cast = last_name(node.func) if last_name(node.func) in _NUMBERS else cast
        node = node.args[0]
    # `radians(float(sys.argv[1]))`, `float(sys.argv[1]) / 1000`
    if isinstance(node, ast.BinOp):
        return _argv_index(node.left)
    if _is_argv(node):
        assert isinstance(node, ast.Subscript)
        index = _value(node.slice)
        return (index, cast) if isinstance(index, int) and index > 0 else (0, "")
    return 0, ""


def _argv_slice(node: ast.AST) -> int:
    """Return where a slice of `sys.argv` begins that is within an expression, 0 for none."""
    for item in ast.walk(node):
        if _is_argv(item) and isinstance(item, ast.Subscript):
            start = _value(item.slice.lower) if isinstance(item.slice, ast.Slice) else None
            if isinstance(start, int) and start > 0:
                return start
    return 0


def _slice_length(node: ast.AST) -> int:
    for item in ast.walk(node):
        if _is_argv(item) and isinstance(item, ast.Subscript) and isinstance(item.slice, ast.Slice):
            start, end = _value(item.slice.lower), _value(item.slice.upper)
            if isinstance(start, int) and isinstance(end, int):
                return max(end - start, 0)
    return 0


def _cast_in(node: ast.AST) -> str:
    """Return the number that an expression makes of words: `map(float, sys.argv[1:4])`."""
    names = [item.id for item in ast.walk(node) if isinstance(item, ast.Name)]
    return next((name for name in names if name in _NUMBERS), "")


def _value(node: ast.expr | None) -> Any:
    return None if node is None else literal_value(node)
