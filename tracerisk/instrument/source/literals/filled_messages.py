"""The literals with which a source fills a message, a request or a goal before it sends it."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

from tracerisk.instrument.source.dotted_names import last_name
from tracerisk.instrument.source.literals.comparisons import is_number
from tracerisk.instrument.source.literals.named_literals import literal_value
from tracerisk.instrument.source.python_source import parsed


def filled_fields(source: str, kind: str, need: str) -> tuple[dict[str, Any], int]:
    """Return the literals that a source sets in a message of a type, and the first one's line.

    `kind` is the last name of the type, `need` what the message is for: `call` (a service request),
    `goal` (an action goal) or another.
    """
    tree = parsed(source)
    if tree is None:
        return {}, 0
    part = {"call": "Request", "goal": "Goal"}.get(need)
    classes = {kind, f"{kind}Request", f"{kind}Goal"}
    fields: dict[str, Any] = {}
    first = 0

    def is_made(node: ast.AST) -> bool:
        if not isinstance(node, ast.Call):
            return False
        name = ast.unparse(node.func).split(".")
        return name[-1] in classes if name[-1] != part else name[-2:-1] == [kind]

    names: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign) and is_made(node.value):
            names |= {ast.unparse(item) for item in node.targets}
        if isinstance(node, ast.Call) and is_made(node):
            for keyword in node.keywords:
                if keyword.arg and (value := _literal(keyword.value)) is not None:
                    fields.setdefault(keyword.arg, value)
                    first = first or node.lineno
    for node in ast.walk(tree):
        if not isinstance(node, ast.Assign) or (value := _literal(node.value)) is None:
            continue
        for target in node.targets:
            owner = next((n for n in sorted(names) if ast.unparse(target).startswith(f"{n}.")), "")
            path = ast.unparse(target)[len(owner) + 1 :].split(".")
            if owner and all(text.isidentifier() for text in path):
                _put(fields, path, value)
                first = first or node.lineno
    return fields, first


def listed_names(tree: ast.AST | None) -> dict[str, tuple[str, ...]]:
    """Return the names of what a source puts into lists, by the field that each list is given to.

    `request.angle = [command.force, command.position]` gives `angle: (force, position)`.
    """
    names_of: dict[str, tuple[str, ...]] = {}
    for name, elements in _lists_given(tree):
        names_of.setdefault(name, tuple(last_name(element) for element in elements))
    return names_of


def listed_lengths(tree: ast.AST | None) -> dict[str, int]:
    """Return how long the lists are that a source gives each field; none where they differ.

    `goal.data.append(x)` adds one to a list that is given nothing at once. Where that comes in a
    loop or a branch, and the message is not made there, the list has no known length.
    """
    lengths: dict[str, set[int]] = {}
    for name, elements in _lists_given(tree):
        lengths.setdefault(name, set()).add(len(elements))
    given = frozenset(lengths)
    for name, count in _added(tree):
        lengths.setdefault(name, set()).add(0 if name in given else count)
    return {name: min(known) for name, known in lengths.items() if len(known) == 1 and min(known)}


def _added(tree: ast.AST | None) -> Iterator[tuple[str, int]]:
    """Yield the fields that a block of lines appends to, and how often, 0 if that is unknown."""
    for node in () if tree is None else ast.walk(tree):
        is_once = isinstance(node, ast.Module | ast.FunctionDef | ast.AsyncFunctionDef)
        for lines in (getattr(node, part, ()) for part in ("body", "orelse", "finalbody")):
            counts: Counter[str] = Counter()
            made: set[str] = set()
            for line in lines if isinstance(lines, list) else ():
                if isinstance(line, ast.Assign):
                    made.update(map(ast.unparse, line.targets))
                called = line.value if isinstance(line, ast.Expr) else None
                called = called.func if isinstance(called, ast.Call) else None
                if isinstance(called, ast.Attribute) and called.attr == "append":
                    counts[ast.unparse(called.value)] += 1
            for owner, count in counts.items():
                is_whole = is_once or any(owner.startswith(f"{name}.") for name in made)
                yield owner.rpartition(".")[2], count if is_whole else 0


def _lists_given(tree: ast.AST | None) -> Iterator[tuple[str, Sequence[ast.expr]]]:
    """Yield the fields and keywords that a source gives lists, with what is in each."""
    for node in () if tree is None else ast.walk(tree):
        given: list[tuple[str, ast.expr]] = []
        if isinstance(node, ast.Assign):
            fields = (target for target in node.targets if isinstance(target, ast.Attribute))
            given = [(field.attr, node.value) for field in fields]
        elif isinstance(node, ast.Call):
            given = [(keyword.arg, keyword.value) for keyword in node.keywords if keyword.arg]
        for name, value in given:
            elements = value.elts if isinstance(value, ast.List | ast.Tuple) else []
            if elements and not any(isinstance(element, ast.Starred) for element in elements):
                yield name, elements


def largest_given(tree: ast.AST | None) -> dict[str, float]:
    """Return the largest number that a source gives each name, where it is above 1 and none is < 0.

    `angle = 90.0`, `request.angle = 0.0` and `send(angle=45)` give `angle: 90.0`.
    """
    given: dict[str, list[float]] = {}
    for node in () if tree is None else ast.walk(tree):
        pairs: list[tuple[str, ast.expr]] = []
        if isinstance(node, ast.Assign):
            pairs = [(last_name(target), node.value) for target in node.targets]
        elif isinstance(node, ast.Call):
            pairs = [(keyword.arg, keyword.value) for keyword in node.keywords if keyword.arg]
        for name, value in pairs:
            number = _literal(value)
            if name and is_number(number):
                given.setdefault(name, []).append(float(number))
    return {
        name: max(numbers)
        for name, numbers in given.items()
        if max(numbers) > 1.0 and min(numbers) >= 0.0
    }


def _literal(node: ast.expr) -> Any:
    return plain_value(literal_value(node))


def _put(fields: dict[str, Any], path: Sequence[str], value: Any) -> None:
    for key in path[:-1]:
        inner = fields.setdefault(key, {})
        if not isinstance(inner, dict):
            return
        fields = inner
    fields.setdefault(path[-1], value)


def plain_value(value: Any) -> Any:
    """Return a value reduced to what a scenario can hold; anything else becomes None."""
    if isinstance(value, dict):
        return {str(key): plain_value(inner) for key, inner in value.items()}
    if isinstance(value, list):
        return [plain_value(inner) for inner in value]
    return value if isinstance(value, bool | int | float | str) else None
