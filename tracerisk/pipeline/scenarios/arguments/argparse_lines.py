"""The command lines that the options of `argparse` in a source take."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from tracerisk.instrument.source.dotted_names import last_name
from tracerisk.pipeline.scenarios.arguments.command_line import (
    NUMBERS,
    CommandLine,
    number_word,
    value_of,
)
from tracerisk.pipeline.scenarios.arguments.files import fitting_files, is_read
from tracerisk.ros.drafts.named_numbers import Reach, named_number, numbers_in_place, units_said
from tracerisk.ros.drafts.said_around import lines_with


def argparse_lines(
    tree: ast.AST, text: str, top: Path, reach: Reach | None
) -> Iterator[CommandLine]:
    """Yield what `argparse` demands, then that with options without a default, with switches."""
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
        is_switch = value_of(given.get("action")) in ("store_true", "store_const", "count")
        count = value_of(given.get("nargs"))
        value = _argument_value(names, given)
        repeat = count if isinstance(count, int) and not isinstance(count, bool) else 1
        values = () if is_switch else tuple([value] * max(repeat, 1))
        if not is_switch and reach is not None:
            values = _in_reach(names, given, len(values), text, reach) or values
        flag = max(flags, key=len, default=None)
        words = values if flag is None else (flag, *values)
        # Without `nargs` a positional argument must be given whatever its default.
        needed = value_of(given.get("required")) is True if flags else count not in ("?", "*")
        owner = ast.unparse(call.func.value) if isinstance(call.func, ast.Attribute) else ""
        metavar = value_of(given.get("metavar"))
        called = [*names, metavar] if isinstance(metavar, str) else names
        kind = given.get("type")
        kind = kind.func if isinstance(kind, ast.Call) else kind
        # The caller needs no file where there is a default or a list of choices.
        is_file = is_read(called, "" if kind is None else last_name(kind)) and value == (
            names[-1].strip("-") if names else ""
        )
        is_needed = bool(needed and names)
        is_number = not is_switch and not is_file and last_name(given.get("type")) in NUMBERS
        is_empty = bool(flags) and not is_needed and is_number and "default" not in given
        return cls(words, owner, is_needed, is_switch, is_file and not is_switch, is_empty)


def _in_reach(
    names: list[str], given: dict[str | None, ast.expr], count: int, text: str, reach: Reach
) -> tuple[str, ...]:
    """Return the numbers of an option where it is a place, an angle or a length; () for others."""
    cast = last_name(given["type"]) if "type" in given else ""
    if cast not in NUMBERS or not names or "choices" in given or "default" in given:
        return ()
    name = max(names, key=len).strip("-").replace("-", "_")
    units = units_said(f"{name} {value_of(given.get('help'))}\n{lines_with(text, f'.{name}')}")
    if count > 1:
        numbers = numbers_in_place(count, units, reach) or ()
        return tuple(number_word(value, cast) for value in numbers)
    number = named_number(name, units, reach)
    return () if number is None else (number_word(number, cast),)


def _argument_value(names: list[str], given: dict[str | None, ast.expr]) -> str:
    choices = value_of(given.get("choices"))
    if isinstance(choices, list | tuple) and choices:
        return str(choices[0])
    default = value_of(given.get("default"))
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
        if any(k.arg == "required" and value_of(k.value) is True for k in node.value.keywords)
        for target in node.targets
    }
