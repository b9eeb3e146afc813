"""How a source uses the values of messages: which variables hold one, and what is done with it."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from typing import Protocol

from tracerisk.instrument.source.definitions.shapes import Shape
from tracerisk.instrument.source.dotted_names import dotted_name, last_name
from tracerisk.instrument.source.literals.called_functions import (
    Function,
    functions_of,
    parameter_name,
)

_PASSES = 3  # a value may be used above the line that says what it is
_OF_TEXT = frozenset(
    {"lower", "upper", "split", "strip", "startswith", "endswith", "replace", "encode", "format"}
)
_OF_LISTS = frozenset(
    {"append", "extend", "insert", "pop", "index", "remove", "sort", "clear", "tolist", "count"}
)
_LISTING = frozenset({"len", "list", "tuple", "enumerate", "zip", "sum", "max", "min", "sorted"})
_ARRAYS = frozenset({"array", "asarray", "deg2rad", "rad2deg", "radians", "degrees"})
_MADE = {"str": "string", "float": "float64", "int": "int64", "bool": "bool", "repr": "string"}
_TIMES = frozenset({"now", "get_rostime", "from_sec"})
_ASKING = frozenset({"call", "call_async", "send_goal", "send_goal_async"})
# The place of the class among the arguments.
_CLIENTS = {"ServiceProxy": 1, "SimpleActionClient": 1, "create_client": 0, "ActionClient": 1}
_CLASS_ARGUMENTS = frozenset({"service_class", "ActionSpec", "srv_type", "action_type"})


class Classes(Protocol):
    """What expressions of a source mean that name classes."""

    def part(self, node: ast.expr, default: str = "") -> Shape | None:
        """Return the shape of a message, or of a part; `default` where the whole is named."""


class UsedValues:
    """Follows the messages through the variables of one source."""

    def __init__(self, tree: ast.AST, classes: Classes, whole: str) -> None:
        """`whole` is the type of a field that a whole number is put into."""
        self._whole = whole
        self._tree = tree
        self._classes = classes
        self._functions = functions_of(tree)
        self._held: dict[tuple[int, str], Shape] = {}
        self._clients: dict[str, ast.expr] = {}
        self._futures: dict[str, ast.expr] = {}
        self._references = dict(_references(tree))
        self._keys = dict(_keys(tree))
        calls = (node for node in ast.walk(tree) if isinstance(node, ast.Call))
        self._called = {id(call.func) for call in calls}

    def read(self) -> None:
        """Note everything that the source shows of each shape."""
        for _ in range(_PASSES):
            for scope, node in _scoped(self._tree, self._tree):
                self._note(node, id(scope))

    def _note(self, node: ast.AST, scope: int) -> None:
        if isinstance(node, ast.Assign):
            for target in node.targets:
                self._assign(target, node.value, scope)
        elif isinstance(node, ast.AnnAssign) and node.value is not None:
            self._assign(node.target, node.value, scope)
        elif isinstance(node, ast.ClassDef):
            self._hold_of_class(node, scope)
        elif isinstance(node, ast.AugAssign):
            self._kind(node.target, scope, "float64")
        elif isinstance(node, ast.For | ast.comprehension):
            shape = self._shape(node.iter, scope)
            if shape is not None and isinstance(node.target, ast.Name):
                self._held[scope, node.target.id] = shape.each()
        elif isinstance(node, ast.arg) and node.annotation is not None:
            shape = self._classes.part(node.annotation)
            if shape is not None:
                self._held[scope, node.arg] = shape
        elif isinstance(node, ast.Call):
            self._call(node, scope)
        elif isinstance(node, ast.Compare):
            for one, other in ((node.left, node.comparators[0]), (node.comparators[0], node.left)):
                self._same(one, other, scope)
        elif isinstance(node, ast.BinOp) and not isinstance(node.op, ast.Mod | ast.Add):
            self._kind(node.left, scope, "float64")
            self._kind(node.right, scope, "float64")
        elif isinstance(node, ast.If | ast.While):
            self._kind(node.test, scope, "bool")
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            self._kind(node.operand, scope, "bool")
        elif isinstance(node, ast.Attribute | ast.Subscript):
            self._shape(node, scope)
            if isinstance(node, ast.Subscript) and (key := self._keys.get(dotted_name(node.value))):
                self._kind(node.slice, scope, key)

    def _kind(self, node: ast.expr, scope: int, kind: str) -> None:
        shape = self._shape(node, scope)
        if shape is not None and not shape.fields:
            shape.kinds.add(kind)

    def _same(self, one: ast.expr, other: ast.expr, scope: int) -> None:
        """Note of a value what it is compared with."""
        shape = self._shape(one, scope)
        if shape is None:
            return
        if isinstance(other, ast.List | ast.Tuple | ast.Set):
            for element in other.elts:
                self._value(shape, element, scope)
        elif isinstance(other, ast.Constant):
            self._value(shape, other, scope)

    def _assign(self, target: ast.expr, value: ast.expr, scope: int) -> None:
        name = dotted_name(target)
        made = self._shape(value, scope)
        if name and made is not None and self._shape(target, scope) is None:
            self._held[self._key(name, scope)] = made
            return
        if name and isinstance(value, ast.Call):
            self._hold_client(name, value)
        shape = self._shape(target, scope)
        if shape is not None:
            self._value(shape, value, scope)

    def _hold_of_class(self, owner: ast.ClassDef, scope: int) -> None:
        """Hold what the body of a class is given, which its methods have as their own."""
        for line in (line for line in owner.body if isinstance(line, ast.Assign)):
            shape = self._shape(line.value, scope)
            for target in line.targets:
                if shape is not None and isinstance(target, ast.Name):
                    self._held.setdefault(self._key(f"self.{target.id}", scope), shape)

    def _hold_client(self, name: str, call: ast.Call) -> None:
        kind = _class_of_client(call)
        if kind is not None:
            self._clients[name] = kind
        elif last_name(call.func) == "call_async":
            client = self._client(call)
            if client is not None:
                self._futures[name] = client

    @staticmethod
    def _key(name: str, scope: int) -> tuple[int, str]:
        # An attribute of the object is one for all its methods.
        return (0 if "." in name else scope), name

    def _value(self, shape: Shape, value: ast.expr, scope: int) -> None:
        """Note of a shape that it is given a value."""
        if isinstance(value, ast.List | ast.Tuple):
            for element in value.elts:
                self._value(shape.each(), element, scope)
            shape.each()
        elif isinstance(value, ast.ListComp):
            self._value(shape.each(), value.elt, scope)
        elif isinstance(value, ast.Constant):
            kinds = {bool: "bool", int: self._whole, float: "float64", str: "string"}
            kind = kinds.get(type(value.value))
            if kind is not None:
                shape.kinds.add(kind)
        elif isinstance(value, ast.JoinedStr):
            shape.kinds.add("string")
        elif isinstance(value, ast.UnaryOp) and not isinstance(value.op, ast.Not):
            self._value(shape, value.operand, scope)
        elif isinstance(value, ast.Compare | ast.BoolOp | ast.UnaryOp):
            shape.kinds.add("bool")
        elif isinstance(value, ast.BinOp) and (lists := _lists_in(value)):
            for part in lists:
                self._value(shape, part, scope)
        elif isinstance(value, ast.BinOp):
            is_text = isinstance(value.left, ast.Constant) and isinstance(value.left.value, str)
            shape.kinds.add("string" if is_text else "float64")
        elif isinstance(value, ast.Call):
            self._value_of_call(shape, value)

    def _value_of_call(self, shape: Shape, value: ast.Call) -> None:
        name = dotted_name(value.func)
        if last_name(value.func) in _MADE and name in _MADE:
            shape.kinds.add(_MADE[name])
        elif name in ("list", "tuple") or last_name(value.func) in (*_ARRAYS, "tolist"):
            shape.each()
        elif name in self._references:
            shape.kinds.add(self._references[name])
        elif last_name(value.func) in _TIMES:
            shape.kinds.add("time")

    def _call(self, call: ast.Call, scope: int) -> None:
        """Note what a call shows: what it is given, and who is called back with what."""
        function = last_name(call.func)
        made = self._made_by(call)
        if made is not None:
            self._given(made, call, scope)
        asked = self._asked_of(call)
        if asked is not None and not self._is_whole(call, scope):
            self._given(asked, call, scope)
        self._callbacks(call, function)
        if function in (*_LISTING, *_ARRAYS):
            for argument in call.args:
                shape = self._shape(argument, scope)
                if shape is not None and not shape.fields:
                    shape.each()
        elif function in ("range", "int", "float") and dotted_name(call.func) == function:
            for argument in call.args:
                self._kind(argument, scope, "int64" if function == "range" else "float64")
        elif function == "imgmsg_to_cv2" and call.args:
            self._kind(call.args[0], scope, "sensor_msgs/Image")
        if isinstance(call.func, ast.Attribute):
            owner = self._shape(call.func.value, scope)
            if owner is not None and function in _OF_TEXT:
                owner.kinds.add("string")
            elif owner is not None and function in _OF_LISTS:
                for argument in call.args if function == "append" else ():
                    self._value(owner.each(), argument, scope)
                owner.each()

    def _given(self, shape: Shape, call: ast.Call, scope: int) -> None:
        for keyword in call.keywords:
            if keyword.arg:
                self._value(shape.at(keyword.arg), keyword.value, scope)
        for number, argument in enumerate(call.args):
            if isinstance(argument, ast.Starred):
                break
            self._value(shape.given(number), argument, scope)

    def _made_by(self, call: ast.Call) -> Shape | None:
        """Return the shape of the message that a call makes."""
        return self._classes.part(call.func)

    def _asked_of(self, call: ast.Call) -> Shape | None:
        """Return the shape of the request that a call of a client sends."""
        kind = self._client(call)
        return None if kind is None else self._classes.part(kind, "Request")

    def _is_whole(self, call: ast.Call, scope: int) -> bool:
        """Return whether a client is given one whole request, goal, or nothing."""
        if not call.args:
            return not call.keywords
        first = call.args[0]
        is_made = isinstance(first, ast.Call) and self._made_by(first) is not None
        held = isinstance(first, ast.Name) and (scope, first.id) in self._held
        return is_made or held or last_name(call.func) in ("call_async", "send_goal")

    def _callbacks(self, call: ast.Call, function: str) -> None:
        """Note what the functions are given that a call makes callbacks."""
        # The place of the type, of the callback, and which part each of its parameters is.
        places: Mapping[str, tuple[int, int, tuple[str, ...]]] = {
            "Subscriber": (1, 2, ("",)),
            "Service": (1, 2, ("Request",)),
            "SimpleActionServer": (1, 2, ("Goal",)),
            "create_subscription": (0, 2, ("",)),
            "create_service": (0, 2, ("Request", "Response")),
        }
        if function not in places:
            return
        kind_at, called_at, parts = places[function]
        named = {keyword.arg: keyword.value for keyword in call.keywords}
        kind = call.args[kind_at] if len(call.args) > kind_at else None
        called = call.args[called_at] if len(call.args) > called_at else None
        for key in ("data_class", "service_class", "msg_type", "srv_type", "ActionSpec"):
            kind = named.get(key, kind)
        for key in ("callback", "handler", "execute_cb"):
            called = named.get(key, called)
        if kind is None or called is None:
            return
        callback: Function | None = (
            called if isinstance(called, ast.Lambda) else self._functions.get(last_name(called))
        )
        for number, part in enumerate(parts):
            shape = self._classes.part(kind, part)
            name = None if callback is None else parameter_name(callback, number)
            if shape is not None and name is not None:
                self._held[id(callback), name] = shape

    def _shape(self, node: ast.expr, scope: int) -> Shape | None:
        """Return the shape of what an expression gives, `None` for what is no part of a message."""
        if isinstance(node, ast.Name):
            held = self._held.get((scope, node.id))
            return held if held is not None else self._held.get((id(self._tree), node.id))
        if isinstance(node, ast.Attribute):
            held = self._held.get((0, dotted_name(node)))
            if held is not None:
                return held
            owner = self._shape(node.value, scope)
            is_method = id(node) in self._called or node.attr.startswith("_")
            return None if owner is None or is_method else owner.at(node.attr)
        if isinstance(node, ast.Subscript):
            owner = self._shape(node.value, scope)
            if owner is None:
                return None
            return owner if isinstance(node.slice, ast.Slice) else owner.each()
        return self._shape_of_call(node, scope) if isinstance(node, ast.Call) else None

    def _shape_of_call(self, call: ast.Call, scope: int) -> Shape | None:
        function = last_name(call.func)
        made = self._made_by(call)
        if made is not None:
            return made
        if function in ("deepcopy", "copy") and call.args:
            return self._shape(call.args[0], scope)
        if function == "wait_for_message" and len(call.args) > 1:
            return self._classes.part(call.args[1])
        owner = dotted_name(call.func.value) if isinstance(call.func, ast.Attribute) else ""
        if function == "get_result" and owner in self._clients:
            return self._classes.part(self._clients[owner], "Result")
        if function == "result" and owner in self._futures:
            return self._classes.part(self._futures[owner], "Response")
        if function == "call_async":
            return None
        kind = self._client(call)
        return None if kind is None else self._classes.part(kind, "Response")

    def _client(self, call: ast.Call) -> ast.expr | None:
        """Return the class of the client that a call asks: `pick(1)`, `self.pick.call(1)`."""
        asked = call.func
        if isinstance(asked, ast.Attribute) and asked.attr in _ASKING:
            asked = asked.value
        if isinstance(asked, ast.Call):
            return _class_of_client(asked)
        return self._clients.get(dotted_name(asked))


def _class_of_client(call: ast.Call) -> ast.expr | None:
    """Return the class that a call makes a client of, `None` for other calls."""
    place = _CLIENTS.get(last_name(call.func))
    if place is None:
        return None
    named = (item.value for item in call.keywords if item.arg in _CLASS_ARGUMENTS)
    return call.args[place] if len(call.args) > place else next(named, None)


def _scoped(node: ast.AST, scope: ast.AST) -> Iterator[tuple[ast.AST, ast.AST]]:
    """Yield each node with the innermost function that it is in, else the whole source."""
    for child in ast.iter_child_nodes(node):
        is_function = isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)
        inner = child if is_function else scope
        yield inner, child
        yield from _scoped(child, inner)


def _references(tree: ast.AST) -> Iterator[tuple[str, str]]:
    """Yield the names under which a source has messages of other packages, each with its type."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.endswith(".msg"):
            package = node.module.removesuffix(".msg")
            for alias in node.names:
                yield alias.asname or alias.name, f"{package}/{alias.name}"
        elif isinstance(node, ast.Attribute) and dotted_name(node).count(".") == 2:
            package, kind, name = dotted_name(node).split(".")
            if kind == "msg":
                yield dotted_name(node), f"{package}/{name}"


def _lists_in(value: ast.BinOp) -> list[ast.expr]:
    """Return the lists that are repeated or joined: `[0.1] * 6`, `[x] + [y]`."""
    return [part for part in (value.left, value.right) if isinstance(part, ast.List)]


def _keys(tree: ast.AST) -> Iterator[tuple[str, str]]:
    """Yield the names of written lists and tables, with the type of their keys."""
    for node in ast.walk(tree):
        if not isinstance(node, ast.Assign):
            continue
        kind = ""
        if isinstance(node.value, ast.List | ast.Tuple) and node.value.elts:
            kind = "int64"
        elif isinstance(node.value, ast.Dict):
            keys = {type(key.value) for key in node.value.keys if isinstance(key, ast.Constant)}
            kind = {str: "string", int: "int64"}.get(keys.pop(), "") if len(keys) == 1 else ""
        yield from ((dotted_name(target), kind) for target in node.targets if kind)
