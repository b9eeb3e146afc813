"""The answers that a source knows to its own question, in the order in which a user gives them."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from tracerisk.errors import Location
from tracerisk.instrument.source.dotted_names import dotted_name, last_name
from tracerisk.instrument.source.literals.answers import ends_program, ordered_answers
from tracerisk.instrument.source.literals.called_functions import functions_of, parameter_name
from tracerisk.instrument.source.literals.comparisons import comparisons
from tracerisk.ros.drafts.answers.split_answers import numbers_answer
from tracerisk.ros.drafts.asked_results import (
    calls_of,
    compared_results,
    held_by,
    is_held,
)
from tracerisk.ros.drafts.usable_values import UsableValues

_OPTION = re.compile(r"^\s*[\[(]?(\w{1,2})(?:[\])]|[.:]\s|\s+[-=:]\s)\s*(\S.*)$", re.MULTILINE)
_LEAVES = re.compile(r"\b(quit|exit|leave|end|stop|back|cancel)\b", re.IGNORECASE)
_LEAVING: Mapping[type[ast.stmt], tuple[type[ast.cmpop], ...]] = {
    ast.If: (ast.Eq, ast.In),
    ast.While: (ast.NotEq, ast.NotIn),
}
"""The comparisons of a test with what ends its loop."""
_EXITS = frozenset({"exit", "_exit", "quit", "shutdown", "signal_shutdown"})


class KnownAnswers(NamedTuple):
    """The answers that a code knows to a question, in the order in which a user gives them."""

    going_on: tuple[str, ...] = ()
    """Those with which the program does something."""
    leaving: tuple[str, ...] = ()
    """Those with which a loop, a function or the program is left."""

    @property
    def in_turn(self) -> tuple[str, ...]:
        """All of them: what ends the program comes last."""
        return (*self.going_on, *self.leaving)


def known_answers(place: Location | None, values: UsableValues) -> KnownAnswers:
    """Return the answers that the code knows to its question at `place`.

    Numbers into which the code takes the answer apart, else what it compares the answer with, the
    keys of a table in which it looks it up, or the options that it prints.
    """
    numbers = numbers_answer(place, values)
    answers = ordered_answers((*compared_results(place, "input"), *_keys(place)))
    answers = tuple(_with_verbs(answers, place))
    left_by = _leaving(place)
    leaving = tuple(answer for answer in answers if answer in left_by or ends_program(answer))
    if numbers is not None:
        return KnownAnswers((numbers,), tuple(answer for answer in leaving if answer in left_by))
    going_on = tuple(answer for answer in answers if answer not in leaving)
    if not going_on:
        printed = _printed(place)
        going_on = tuple(answer for answer in printed.going_on if answer not in leaving)
        leaving = tuple(dict.fromkeys((*printed.leaving, *leaving)))
    return KnownAnswers(going_on, leaving)


def _with_verbs(answers: Sequence[str], place: Location | None) -> Iterator[str]:
    """Yield answers; a word that is split off another has this before it: `move home`.

    The code asks for the first word (`cmd.startswith('move ')`), and compares the part behind.
    """
    verbs: list[str] = []
    whole: set[str] = set()
    for tree, call in calls_of(place, "input"):
        names, _ = held_by(tree, call)
        split = _split_off(tree)
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and last_name(node.func) == "startswith" and node.args:
                owner = node.func.value if isinstance(node.func, ast.Attribute) else node
                text = node.args[0].value if isinstance(node.args[0], ast.Constant) else ""
                if is_held(owner, call, names) and isinstance(text, str) and text.endswith(" "):
                    verbs.append(text)
            for subject, value in comparisons(node) if isinstance(node, ast.Compare) else ():
                if subject is not None and is_held(subject, call, names - split):
                    whole.add(str(value))
    for answer in answers:
        if not verbs or answer in whole or any(answer.startswith(verb) for verb in verbs):
            yield answer
        else:
            yield from (f"{verb}{answer}" for verb in verbs)


def _split_off(tree: ast.AST) -> set[str]:
    """Return the names that hold a part of a text, also those of a function that is handed it."""
    split = {
        dotted_name(target)
        for node in ast.walk(tree)
        if isinstance(node, ast.Assign) and ".split(" in ast.unparse(node.value)
        for target in node.targets
    }
    functions = functions_of(tree)
    handed = (
        parameter_name(functions[last_name(node.func)], index)
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and last_name(node.func) in functions
        for index, value in enumerate(node.args)
        if dotted_name(value) in split
    )
    return split.union(name for name in handed if name is not None)


def _leaving(place: Location | None) -> frozenset[str]:
    """Return the answers with which a loop or a function is left."""
    return frozenset(
        str(value)
        for tree, call in calls_of(place, "input")
        for names in (held_by(tree, call)[0],)
        for node in ast.walk(tree)
        if isinstance(node, ast.While) or (isinstance(node, ast.If) and _leaves(node.body))
        for test in ast.walk(node.test)
        if isinstance(test, ast.Compare)
        for subject, value in comparisons(test)
        if subject is not None and is_held(subject, call, names)
        and isinstance(test.ops[0], _LEAVING[type(node)])
    )  # fmt: skip


def _leaves(body: list[ast.stmt]) -> bool:
    last = body[-1]
    if isinstance(last, ast.Break | ast.Return):
        # A function that returns something has made an answer of it.
        return not (isinstance(last, ast.Return) and last.value is not None)
    if isinstance(last, ast.Assign):
        return isinstance(last.value, ast.Constant) and last.value.value is False
    is_call = isinstance(last, ast.Expr) and isinstance(last.value, ast.Call)
    return is_call and last_name(last.value.func) in _EXITS  # type: ignore[attr-defined]


def _keys(place: Location | None) -> Iterator[str]:
    """Yield the keys of the tables in which the answer is looked up."""
    for tree, call in calls_of(place, "input"):
        names, _ = held_by(tree, call)
        tables = {
            dotted_name(target): node.value
            for node in ast.walk(tree)
            if isinstance(node, ast.Assign) and isinstance(node.value, ast.Dict)
            for target in node.targets
        }
        for node in ast.walk(tree):
            table, key = _looked_up(node)
            if table is None or key is None or not is_held(key, call, names):
                continue
            result = table if isinstance(table, ast.Dict) else tables.get(dotted_name(table))
            for item in () if result is None else result.keys:
                if isinstance(item, ast.Constant) and isinstance(item.value, str | int):
                    yield str(item.value)


def _looked_up(node: ast.AST) -> tuple[ast.AST | None, ast.expr | None]:
    """Return a table and the key that is looked up in it."""
    if isinstance(node, ast.Subscript):
        return node.value, node.slice
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.args:
        return (node.func.value, node.args[0]) if node.func.attr == "get" else (None, None)
    if isinstance(node, ast.Compare) and isinstance(node.ops[0], ast.In | ast.NotIn):
        return node.comparators[0], node.left
    return None, None


def _printed(place: Location | None) -> KnownAnswers:
    """Return the options of the menu that is printed around the question: `1. Home`, `[q] quit`."""
    labels: dict[str, str] = {}
    for tree, call in calls_of(place, "input"):
        around = [
            node
            for node in ast.walk(tree)
            if isinstance(node, ast.FunctionDef | ast.While)
            and any(inner is call for inner in ast.walk(node))
        ]
        for node in ast.walk(around[-1] if around else tree):
            if isinstance(node, ast.Call) and last_name(node.func) in ("print", "input"):
                for text in _texts(node):
                    labels |= {match[1]: match[2] for match in _OPTION.finditer(text)}
    options = labels if len(labels) > 1 else {}
    leaving = tuple(option for option, label in options.items() if _LEAVES.search(label))
    return KnownAnswers(tuple(option for option in options if option not in leaving), leaving)


def _texts(call: ast.Call) -> Iterator[str]:
    for argument in call.args:
        if isinstance(argument, ast.Constant) and isinstance(argument.value, str):
            yield argument.value
