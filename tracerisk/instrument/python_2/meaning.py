"""Give the tree of a converted source the meaning that Python 2 gives it.

What differs becomes a call of a function that only such sources see, in the place of the operation
and with its line: divisions, comparisons, attributes that Python 3 has taken away.
"""

from __future__ import annotations

import ast
from types import CodeType
from typing import TypeVar, cast

from tracerisk.instrument.marks.calls import is_lazy
from tracerisk.instrument.marks.endless_loops import begin_of_code
from tracerisk.instrument.python_2.operators import ATTRIBUTES, CLASS_NAMES
from tracerisk.instrument.source.python_2 import TUPLE_PARAMETER, UNPACKED

SIGN = "__tracerisk_python_2__"
"""A name that code of such a source loads first; by it is known how the code has to be run."""
DIVIDED = "__tracerisk_divided__"
"""The name of the function for `a / b`."""
DIVIDED_IN_PLACE = "__tracerisk_divided_in_place__"
"""The name of the function for `a /= b`."""
COMPARED = "__tracerisk_compared__"
"""The name of the function for `a < b` and its like; its first argument is the operator."""
ATTRIBUTE = "__tracerisk_attribute__"
"""The name of the function for attributes that Python 3 has not, or that are others there."""
CLASS = "__tracerisk_class__"
"""The name of the decorator of classes with methods that have another name in Python 3."""

_OPERATORS = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">="}
_COMPREHENSIONS = (ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp)
_Node = TypeVar("_Node", bound=ast.AST)


def give_meaning(tree: ast.Module) -> None:
    """Change a tree, whose nodes have positions, so that it means in Python 3 what it does in 2."""
    _Meaning(divides=not _imports_future(tree, "division")).visit(tree)
    begin = begin_of_code(tree)
    here = tree.body[begin] if begin < len(tree.body) else None
    sign = ast.Expr(ast.Name(SIGN, ast.Load()))
    for node in ast.walk(sign):
        _place(node, here)
    tree.body.insert(begin, sign)


def is_of_python_2(code: CodeType) -> bool:
    """Return whether the code of a module came from such a tree."""
    return SIGN in code.co_names


def _imports_future(tree: ast.Module, name: str) -> bool:
    return any(
        isinstance(node, ast.ImportFrom)
        and node.module == "__future__"
        and any(alias.name == name for alias in node.names)
        for node in tree.body
    )


def _place(node: ast.AST, like: ast.AST | None) -> None:
    if "lineno" in node._attributes:
        for name in ("lineno", "col_offset", "end_lineno", "end_col_offset"):
            default = 1 if "line" in name else 0
            setattr(node, name, getattr(like, name, default))


class _Meaning(ast.NodeTransformer):
    def __init__(self, *, divides: bool) -> None:
        self._divides = divides
        self._is_class = False
        self._in_comprehension = False
        self._number = 0
        self._unpacked: list[ast.expr] = []
        """What the present `except` clause unpacks the exception into; nothing for a name."""

    def generic_visit(self, node: ast.AST) -> ast.AST:
        before = self._is_class, self._in_comprehension
        if isinstance(node, ast.ClassDef):
            self._is_class, self._in_comprehension = True, False
        elif isinstance(node, ast.FunctionDef | ast.Lambda):
            self._is_class = self._in_comprehension = False
        elif isinstance(node, _COMPREHENSIONS):
            self._in_comprehension = True
        try:
            return super().generic_visit(node)
        finally:
            self._is_class, self._in_comprehension = before

    # --- operators

    def visit_BinOp(self, node: ast.BinOp) -> ast.AST:
        self.generic_visit(node)
        if not self._divides or not isinstance(node.op, ast.Div):
            return node
        return self._call(DIVIDED, [node.left, node.right], node)

    def visit_AugAssign(self, node: ast.AugAssign) -> ast.AST | list[ast.stmt]:
        self.generic_visit(node)
        if not self._divides or not isinstance(node.op, ast.Div):
            return node
        target, first = node.target, list[ast.stmt]()
        if isinstance(target, ast.Attribute):
            target.value = self._kept(target.value, first)
        elif isinstance(target, ast.Subscript):
            target.value = self._kept(target.value, first)
            if not any(isinstance(part, ast.Slice) for part in ast.walk(target.slice)):
                target.slice = self._kept(target.slice, first)
        value = self._call(DIVIDED_IN_PLACE, [_loaded(target), node.value], node)
        return [*first, self._like(ast.Assign([target], value), node)]

    def _kept(self, value: ast.expr, first: list[ast.stmt]) -> ast.expr:
        """Evaluate an expression before a statement, and return the name that holds its value."""
        if isinstance(value, ast.Name | ast.Constant):
            return value
        name = self._new_name()
        stored = self._like(ast.Name(name, ast.Store()), value)
        first.append(self._like(ast.Assign([stored], value), value))
        return self._like(ast.Name(name, ast.Load()), value)

    def visit_Compare(self, node: ast.Compare) -> ast.AST:
        self.generic_visit(node)
        if not any(type(operator) in _OPERATORS for operator in node.ops):
            return node
        lefts: list[ast.expr] = [node.left]
        rights: list[ast.expr] = []
        for operand in node.comparators[:-1]:
            if isinstance(operand, ast.Name | ast.Constant):
                rights.append(operand)
                lefts.append(operand)
            elif self._is_class or self._in_comprehension:
                return node  # no name can hold the value there
            else:
                stored = self._like(ast.Name(self._new_name(), ast.Store()), operand)
                rights.append(self._like(ast.NamedExpr(stored, operand), operand))
                lefts.append(self._like(ast.Name(stored.id, ast.Load()), operand))
        rights.append(node.comparators[-1])
        parts = [
            self._call(COMPARED, [ast.Constant(_OPERATORS[type(operator)]), left, right], node)
            if type(operator) in _OPERATORS
            else self._like(ast.Compare(left, [operator], [right]), node)
            for left, operator, right in zip(lefts, node.ops, rights, strict=True)
        ]
        return parts[0] if len(parts) == 1 else self._like(ast.BoolOp(ast.And(), parts), node)

    # --- names and values

    def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
        self.generic_visit(node)
        if node.attr not in ATTRIBUTES or not isinstance(node.ctx, ast.Load):
            return node
        return self._call(ATTRIBUTE, [node.value, ast.Constant(node.attr)], node)

    def visit_Constant(self, node: ast.Constant) -> ast.AST:
        if isinstance(node.value, bytes):
            node.value = node.value.decode("latin-1")
        return node

    def visit_Call(self, node: ast.Call) -> ast.AST:
        self.generic_visit(node)
        if not isinstance(node.func, ast.Name) or node.func.id != UNPACKED:
            return node
        kind, target = node.args
        self._unpacked.append(target)
        return kind

    # --- statements

    def visit_ExceptHandler(self, node: ast.ExceptHandler) -> ast.AST:
        """Keep the exception behind the clause, where Python 3 forgets its name."""
        if node.name is None:
            return self.generic_visit(node)
        kept: ast.expr = self._like(ast.Name(node.name, ast.Store()), node.body[0])
        node.name = self._new_name()
        caught: ast.expr = self._like(ast.Name(node.name, ast.Load()), node.body[0])
        self._unpacked.clear()
        node.type = None if node.type is None else self.visit(node.type)
        if self._unpacked:
            kept = self._unpacked.pop()
            if isinstance(kept, ast.Tuple | ast.List):
                caught = self._like(ast.Attribute(caught, "args", ast.Load()), node.body[0])
            _store(kept)
        node.body = [line for item in node.body for line in _listed(self.visit(item))]
        node.body.insert(0, self._like(ast.Assign([kept], caught), node.body[0]))
        return node

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        tuples = [arg for arg in node.args.args if arg.arg.startswith(TUPLE_PARAMETER)]
        assigned = []
        for arg in tuples:
            pattern, arg.annotation = cast(ast.expr, arg.annotation), None
            _store(pattern)
            value = self._like(ast.Name(arg.arg, ast.Load()), pattern)
            assigned.append(self._like(ast.Assign([pattern], value), pattern))
        self.generic_visit(node)
        begin = 1 if ast.get_docstring(node, clean=False) is not None else 0
        node.body[begin:begin] = assigned
        if is_lazy(node):
            node.body[begin:] = [self._ended_by_stop_iteration(node.body[begin:])]
        return node

    def _ended_by_stop_iteration(self, body: list[ast.stmt]) -> ast.stmt:
        """Make a StopIteration the end of a generator; in Python 3 it is a RuntimeError."""
        last = body[-1]
        kind = self._like(ast.Name("StopIteration", ast.Load()), last)
        end = self._like(ast.Return(None), last)
        handler = self._like(ast.ExceptHandler(kind, None, [end]), last)
        return self._like(ast.Try(body, [handler], [], []), body[0])

    def visit_ClassDef(self, node: ast.ClassDef) -> ast.AST:
        self.generic_visit(node)
        given: dict[str, ast.expr] = {}
        for statement in node.body:
            if isinstance(statement, ast.Assign):
                for name in statement.targets:
                    if isinstance(name, ast.Name):
                        given.setdefault(name.id, statement.value)
        # The class decorator cannot: a class is made by its metaclass.
        metaclass = given.get("__metaclass__")
        if isinstance(metaclass, ast.Name | ast.Attribute):
            node.keywords.append(self._like(ast.keyword("metaclass", metaclass), node))
        defined = {item.name for item in node.body if isinstance(item, ast.FunctionDef)}
        if CLASS_NAMES & (given.keys() | defined):
            node.decorator_list.append(self._like(ast.Name(CLASS, ast.Load()), node))
        return node

    # --- what is made

    def _call(self, function: str, arguments: list[ast.expr], like: ast.AST) -> ast.expr:
        for argument in arguments:
            if not hasattr(argument, "lineno"):
                _place(argument, like)
        name = self._like(ast.Name(function, ast.Load()), like)
        return self._like(ast.Call(name, arguments, []), like)

    def _like(self, node: _Node, like: ast.AST) -> _Node:
        _place(node, like)
        return node

    def _new_name(self) -> str:
        self._number += 1
        return f"__tracerisk_{self._number}__"


def _listed(statements: ast.stmt | list[ast.stmt]) -> list[ast.stmt]:
    return statements if isinstance(statements, list) else [statements]


def _store(target: ast.expr) -> None:
    """Make an expression the target of an assignment."""
    if isinstance(target, ast.Tuple | ast.List):
        for part in target.elts:
            _store(part)
    if isinstance(target, ast.Tuple | ast.List | ast.Name | ast.Attribute | ast.Subscript):
        target.ctx = ast.Store()


def _loaded(target: ast.expr) -> ast.expr:
    """Return what reads a target of an assignment."""
    if isinstance(target, ast.Name):
        result: ast.expr = ast.Name(target.id, ast.Load())
    elif isinstance(target, ast.Attribute):
        result = ast.Attribute(target.value, target.attr, ast.Load())
    else:
        assert isinstance(target, ast.Subscript)
        result = ast.Subscript(target.value, target.slice, ast.Load())
    _place(result, target)
    return result
