"""Which answers the functions of a controller look at: of services, actions and drivers."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from tracerisk.instrument.source.answers.flow import Answer, Flow, OwnFunction
from tracerisk.instrument.source.function_definitions import MODULE, functions_of
from tracerisk.instrument.source.python_source import parsed

_ROUNDS = 4
"""So many levels of functions that only hand an answer on are followed."""


@dataclass
class LookedAt:
    """What one function does with the answers of its calls, each by its name and field."""

    checks: dict[tuple[str, str], set[tuple[str, int]]] = field(default_factory=dict)
    """The answers that decide something: where each is looked at, file and line."""
    asked: dict[tuple[str, str], set[int]] = field(default_factory=dict)
    """The same answers: the lines of the calls that give them."""
    calls: dict[str, set[int]] = field(default_factory=dict)
    """The lines of the calls that give each answer, looked at or not."""
    used: set[str] = field(default_factory=set)
    """The answers that are handed to other code, which may look at them."""
    own_calls: set[str] = field(default_factory=set)
    """The controller's functions that it calls."""


def looked_at(sources: Mapping[str, bytes]) -> dict[str, LookedAt]:
    """Return what the functions of Python sources look at, by qualified name.

    An answer that a function only returns is followed to whoever looks at it. Nothing is returned
    of a source that cannot be read.
    """
    functions = [
        function
        for file in sorted(sources)
        for tree in (parsed(sources[file]),)
        if tree is not None
        for function in _functions(file, tree)
    ]
    by_name: dict[str, list[OwnFunction]] = {}
    for function in functions:
        by_name.setdefault(function.name.rpartition(".")[2], []).append(function)
    shared: dict[tuple[str, str], set[Answer]] = {}
    for _ in range(_ROUNDS):
        for function in functions:
            Flow(function, by_name, shared).run()
    found: dict[str, LookedAt] = {function.name: LookedAt() for function in functions}
    for function in functions:
        here = found[function.name]
        here.own_calls |= function.own_calls
        for answer in function.given:
            if answer.kind == "answer":
                here.calls.setdefault(answer.of, set()).add(answer.line)
        here.used |= {answer.of for answer in function.used if answer.kind == "answer"}
        for owner, file, line, answer in function.looks:
            if answer.kind == "answer":
                key = answer.of, answer.path
                found[owner].checks.setdefault(key, set()).add((file, line))
                found[owner].asked.setdefault(key, set()).add(answer.line)
    return found


def _functions(file: str, tree: ast.Module) -> Iterator[OwnFunction]:
    imported = {
        (alias.asname or alias.name).partition(".")[0]: (node.module or "")
        if isinstance(node, ast.ImportFrom)
        else alias.name
        for node in ast.walk(tree)
        if isinstance(node, ast.Import | ast.ImportFrom)
        for alias in node.names
    }
    body = [node for node in tree.body if not isinstance(node, ast.FunctionDef | ast.ClassDef)]
    yield OwnFunction(MODULE, file, body, (), imported)
    for name, node in functions_of(tree):
        taken = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
        names = tuple(argument.arg for argument in taken)
        yield OwnFunction(name, file, node.body, names, imported)
