"""How the answers of calls go through one function: by names, fields, arguments and `return`."""

from __future__ import annotations

import ast
import builtins
import sys
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, NamedTuple

from tracerisk.instrument.source.dotted_names import dotted_name, last_name
from tracerisk.instrument.source.function_definitions import MODULE

_CLIENTS = frozenset({"create_client", "ServiceProxy", "ActionClient", "SimpleActionClient"})
_WAITS = frozenset(
    {"spin_until_future_complete", "spin_once", "spin", "wait_for_service", "wait_for_server"}
    | {"service_is_ready", "server_is_ready", "done", "cancelled", "wait", "is_set", "sleep"}
    | {"ok", "is_shutdown", "now", "get_clock", "get_time", "get_rostime", "get_logger"}
    | {"get_parameter", "declare_parameter", "get_param", "has_parameter", "has_param"}
)
"""What only waits, or asks for something that is no answer of the robot or its cell."""
_PRINTS = frozenset(
    {"print", "debug", "info", "warn", "warning", "error", "fatal", "critical", "exception"}
    | {"log", "logdebug", "loginfo", "logwarn", "logerr", "logfatal", "format", "repr", "str"}
)
_OF_VALUES = frozenset(
    name for kind in (str, bytes, list, dict, set, deque, Path) for name in dir(kind)
)
_OTHER_LIBRARIES = frozenset({"numpy", "scipy", "yaml"})
_NO_ANSWER = frozenset(sys.stdlib_module_names) | _OTHER_LIBRARIES


class Answer(NamedTuple):
    """An answer of a call, or what gives one."""

    kind: Literal["answer", "answer_of", "parameter", "client"]
    """"answer_of" of the client that a parameter is; "parameter" for what a parameter is."""
    of: str
    """The interface of a client, such as `/arm/move`; else the name called, or the parameter."""
    path: str = ""
    """The fields that lead to the part of it, such as `result.error_code`; empty for all of it."""
    line: int = 0
    """The line of the call that gives it."""

    def at(self, attribute: str) -> Answer:
        """Return a field of it."""
        return self._replace(path=f"{self.path}.{attribute}".lstrip("."))


@dataclass
class OwnFunction:
    """A function of the controller, and what is known of its answers so far."""

    name: str
    """The qualified name."""
    file: str
    """The source of it."""
    body: Sequence[ast.stmt]
    """The statements of it."""
    parameters: tuple[str, ...]
    """The names of its parameters, `self` included."""
    imported: Mapping[str, str]
    """The module of each name that its source imports."""
    returns: set[Answer] = field(default_factory=set)
    """What it may return."""
    given: set[Answer] = field(default_factory=set)
    """The answers of its own calls."""
    used: set[Answer] = field(default_factory=set)
    """Answers that it hands to code that is not the controller's."""
    looks: set[tuple[str, str, int, Answer]] = field(default_factory=set)
    """Answers that decide something: the function that looks, with file and line."""
    own_calls: set[str] = field(default_factory=set)
    """The controller's functions that it calls."""


class Flow:
    """One reading of a function, with what is known of the others."""

    def __init__(
        self,
        function: OwnFunction,
        by_name: Mapping[str, Sequence[OwnFunction]],
        shared: dict[tuple[str, str], set[Answer]],
    ) -> None:
        """Take the functions by the last part of their names, and what attributes hold by file."""
        self._function = function
        self._by_name = by_name
        self._shared = shared
        self._names = {name: {Answer("parameter", name)} for name in function.parameters}
        self._names.pop("self", None)

    def run(self) -> None:
        """Read the function twice: a loop may use above what it assigns below."""
        for _ in range(2):
            self._block(self._function.body)

    def _block(self, statements: Iterable[ast.AST]) -> None:
        for statement in statements:
            self._statement(statement)

    def _statement(self, node: ast.AST) -> None:
        match node:
            case ast.FunctionDef() | ast.AsyncFunctionDef() | ast.ClassDef():
                return
            case ast.Assign(targets=targets, value=value):
                for target in targets:
                    self._bind(target, self._value(value))
            case ast.AnnAssign(target=target, value=ast.expr() as value):
                self._bind(target, self._value(value))
            case ast.AugAssign(target=target, value=value):
                self._bind(target, self._value(value))
            case ast.Return(value=ast.expr() as value):
                self._function.returns |= self._value(value)
            case ast.If(test=test) | ast.While(test=test):
                self._test(test)
                self._block([*node.body, *node.orelse])
            case ast.Assert(test=test):
                self._test(test)
            case ast.For() | ast.AsyncFor():
                self._bind(node.target, self._value(node.iter))
                self._block([*node.body, *node.orelse])
            case ast.With() | ast.AsyncWith():
                for item in node.items:
                    values = self._value(item.context_expr)
                    if item.optional_vars is not None:
                        self._bind(item.optional_vars, values)
                self._block(node.body)
            case ast.Match(subject=subject, cases=cases):
                self._test(subject)
                for case in cases:
                    self._block(case.body)
            case ast.expr():
                self._value(node)
            case _:
                self._block(ast.iter_child_nodes(node))

    def _bind(self, target: ast.expr, values: set[Answer]) -> None:
        match target:
            case ast.Name(id=name):
                self._names[name] = self._names.get(name, set()) | values
                if self._function.name == MODULE:
                    self._keep(name, values)
            case ast.Attribute():
                self._keep(dotted_name(target), values)
            case ast.Tuple(elts=parts) | ast.List(elts=parts):
                for part in parts:
                    self._bind(part, values)
            case ast.Starred(value=value):
                self._bind(value, values)

    def _keep(self, name: str, values: set[Answer]) -> None:
        # A parameter means nothing outside its function.
        plain = {answer for answer in values if answer.kind in ("answer", "client")}
        if name and plain:
            self._shared.setdefault((self._function.file, name), set()).update(plain)

    def _test(self, test: ast.expr) -> set[Answer]:
        values = self._value(test)
        for answer in values:
            self._look(answer, test.lineno)
        return values

    def _look(self, answer: Answer, line: int) -> None:
        if answer.kind != "client":
            function = self._function
            function.looks.add((function.name, function.file, line, answer))

    def _value(self, node: ast.expr) -> set[Answer]:
        """Return the answers that an expression may be, or is made of."""
        match node:
            case ast.Name(id=name):
                shared = self._shared.get((self._function.file, name), set())
                return self._names.get(name, shared)
            case ast.Attribute(value=value, attr=attribute):
                held = self._shared.get((self._function.file, dotted_name(node)), set())
                parts = {it.at(attribute) for it in self._value(value) if it.kind != "client"}
                return held | parts
            case ast.Call():
                return self._call(node)
            case ast.NamedExpr(target=target, value=value):
                values = self._value(value)
                self._bind(target, values)
                return values
            case ast.IfExp(test=test, body=body, orelse=orelse):
                self._test(test)
                return self._value(body) | self._value(orelse)
            case ast.BoolOp(values=operands):
                for operand in operands[:-1]:
                    self._test(operand)
                return set().union(*map(self._value, operands))
            case ast.Compare(left=left, comparators=others):
                values = set().union(*map(self._value, [left, *others]))
                is_none = any(isinstance(one, ast.Constant) and one.value is None for one in others)
                return {it.at("is None") for it in values} if is_none else values
            case ast.ListComp() | ast.SetComp() | ast.GeneratorExp() | ast.DictComp():
                for part in node.generators:
                    self._bind(part.target, self._value(part.iter))
                    for test in part.ifs:
                        self._test(test)
                made = node.value if isinstance(node, ast.DictComp) else node.elt
                return self._value(made)
            case ast.JoinedStr():
                self._of_parts(node)
                return set()
            case ast.Lambda():
                return set()
        return self._of_parts(node)

    def _of_parts(self, node: ast.AST) -> set[Answer]:
        values: set[Answer] = set()
        for part in ast.iter_child_nodes(node):
            values |= self._value(part) if isinstance(part, ast.expr) else self._of_parts(part)
        return values

    def _call(self, call: ast.Call) -> set[Answer]:
        name = last_name(call.func)
        given = [self._value(argument) for argument in call.args]
        named = {keyword.arg: self._value(keyword.value) for keyword in call.keywords}
        arguments: set[Answer] = set().union(*given, *named.values())
        if name in _CLIENTS:
            return {Answer("client", _interface(call))}
        receiver: set[Answer] = set()
        if isinstance(call.func, ast.Attribute):
            receiver = self._value(call.func.value)
        elif isinstance(call.func, ast.Name):
            receiver = {it for it in self._value(call.func) if it.kind == "client"}
        self._called_back(call, receiver)
        own = self._own(call)
        if own:
            return self._given(set().union(*(self._of_own(call, one, given, named) for one in own)))
        if name in _WAITS:
            return set()
        if receiver:
            return self._of_receiver(call, receiver)
        root = dotted_name(call.func).partition(".")[0]
        is_plain = isinstance(call.func, ast.Name) and hasattr(builtins, name)
        is_value = isinstance(call.func, ast.Attribute) and name in _OF_VALUES
        module = self._function.imported.get(root, "").partition(".")[0]
        if is_plain or is_value or module in _NO_ANSWER or name in _PRINTS:
            return set() if name in _PRINTS else arguments
        self._function.used |= arguments
        if not name or name[0].isupper():
            return set()
        return self._given({Answer("answer", f"{name}()", line=call.lineno)})

    def _given(self, answers: set[Answer]) -> set[Answer]:
        self._function.given |= answers
        return answers

    def _of_receiver(self, call: ast.Call, receiver: set[Answer]) -> set[Answer]:
        """Return what the method of a client, of an answer, or of a parameter gives."""
        answers: set[Answer] = set()
        for it in receiver:
            if it.kind == "client":
                answers.add(Answer("answer", it.of, line=call.lineno))
            elif it.kind == "parameter" and not it.path:
                # It may be a client, or the future of an answer.
                answers |= {it, Answer("answer_of", it.of, line=call.lineno)}
            else:
                answers.add(it)
        return self._given(answers)

    def _own(self, call: ast.Call) -> list[OwnFunction]:
        name = last_name(call.func)
        own = list(self._by_name.get(name, ()))
        if isinstance(call.func, ast.Attribute):
            is_self = dotted_name(call.func.value) in ("self", "cls")
            # A wrapper is often called as what it wraps.
            around = self._function.name.rpartition(".")[0]
            own = [one for one in own if is_self or one.name.rpartition(".")[0] != around]
        elif isinstance(call.func, ast.Name):
            own = [one for one in own if one.name == name or "<locals>" in one.name]
        self._function.own_calls |= {one.name for one in own}
        return own

    def _of_own(
        self,
        call: ast.Call,
        own: OwnFunction,
        given: Sequence[set[Answer]],
        named: Mapping[str | None, set[Answer]],
    ) -> set[Answer]:
        """Return what a call of the controller's own function gives, and note what it looks at."""
        skipped = own.parameters[:1] in (("self",), ("cls",)) and isinstance(
            call.func, ast.Attribute
        )
        names = own.parameters[int(skipped) :]
        bound = dict(zip(names, zip(given, call.args, strict=True), strict=False))
        for keyword in call.keywords:
            if keyword.arg is not None:
                bound[keyword.arg] = named[keyword.arg], keyword.value
        for owner, file, line, answer in list(own.looks):
            if answer.kind == "answer":
                continue
            for known in _bound(answer, bound, call.lineno):
                if answer.kind == "parameter":
                    self._look(known, call.lineno)
                else:
                    self._function.looks.add((owner, file, line, known))
        return {
            known._replace(line=call.lineno)
            for answer in own.returns
            for known in _bound(answer, bound, call.lineno)
        }

    def _called_back(self, call: ast.Call, receiver: set[Answer]) -> None:
        """Note what a function looks at that is called with the answer when it is there."""
        if last_name(call.func) != "add_done_callback" or not call.args:
            return
        for own in self._by_name.get(last_name(call.args[0]), ()):
            first = [name for name in own.parameters if name not in ("self", "cls")][:1]
            for owner, file, line, answer in list(own.looks):
                if answer.kind in ("parameter", "answer_of") and answer.of in first:
                    for it in receiver:
                        known = it._replace(path=f"{it.path}.{answer.path}".strip("."))
                        self._function.looks.add((owner, file, line, known))


def _bound(
    answer: Answer, bound: Mapping[str, tuple[set[Answer], ast.expr]], line: int
) -> set[Answer]:
    """Return what an answer of a function is for a caller that gives it these arguments."""
    if answer.kind in ("answer", "client"):
        return {answer}
    values, text = bound.get(answer.of, (set(), None))
    known: set[Answer] = set()
    for value in values:
        if answer.kind == "parameter" and value.kind != "client":
            known.add(value._replace(path=f"{value.path}.{answer.path}".strip(".")))
        elif answer.kind == "answer_of" and value.kind == "client":
            known.add(Answer("answer", value.of, answer.path, line))
        elif answer.kind == "answer_of" and value.kind == "parameter":
            known.add(Answer("answer_of", value.of, answer.path, line))
    if answer.kind == "answer_of" and not values and text is not None:
        known.add(Answer("answer", ast.unparse(text), answer.path, line))
    return known


def _interface(call: ast.Call) -> str:
    """Return the name of the interface that a client is made for, or else its type."""
    given = [*call.args, *(keyword.value for keyword in call.keywords)]
    for argument in given:
        if isinstance(argument, ast.Constant) and isinstance(argument.value, str):
            return argument.value
    kinds = [last_name(argument) for argument in given if last_name(argument)[:1].isupper()]
    return next(iter(kinds), ast.unparse(call.func))
