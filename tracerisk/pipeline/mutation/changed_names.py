"""Changes of names: others that exist take their place.

Texts are exchanged for texts that play the same part, or for other names of the same kind of the
robot and its scene; constants and variables for those of the same shape; a controller's own
functions for those that take as many arguments.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import libcst as cst

from tracerisk.pipeline.mutation.change import Draft
from tracerisk.pipeline.mutation.source_tree import SourceTree, Walk, last_name, number_of

_MOST = 3
"""How many other names are tried at a place."""
_READ_BY = (
    *(cst.Arg, cst.BinaryOperation, cst.Assign, cst.Return, cst.Element, cst.DictElement),
    *(cst.Subscript, cst.Comparison, cst.ComparisonTarget),
)
Role = tuple[Any, ...]


@dataclass(frozen=True, slots=True)
class KnownNames:
    """The names of a source, by what they can take the place of."""

    texts: Mapping[Role, Collection[str]]
    """The texts that play each part: an argument of a function, a value of a variable, a key."""
    variables: Mapping[tuple[str, str], Role]
    """The shape of what each name is assigned, by its function or class, and the name."""
    functions: Mapping[tuple[str, str], int]
    """How many arguments each function takes, by its class (empty for none) and its name."""
    alike: Sequence[Collection[str]] = field(default_factory=tuple)
    """Names of robot and scene, those of each kind."""

    def other_texts(self, role: Role | None, value: str) -> tuple[str, ...]:
        """Return the texts that can take the place of one."""
        same = set(self.texts.get(role, ())) if role is not None else set()
        return _others(value, same) or _others(
            value, {name for kind in self.alike if value in kind for name in kind}
        )

    def other_variables(self, scopes: Sequence[str], name: str) -> tuple[str, ...]:
        """Return the variables of the same shape, of the innermost of some scopes that has it."""
        for scope in scopes:
            shape = self.variables.get((scope, name))
            if shape is not None:
                same = {
                    other
                    for (place, other), item in self.variables.items()
                    if place == scope and item == shape
                }
                return _others(name, same)
        return ()

    def other_functions(self, owner: str, name: str, but: str) -> tuple[str, ...]:
        """Return the functions of a class that take as many arguments, but the one that calls."""
        count = self.functions.get((owner, name))
        if count is None:
            return ()
        same = {
            other
            for (place, other), number in self.functions.items()
            if place == owner and number == count and other != but and not other.startswith("__")
        }
        return _others(name, same)


def _others(name: str, same: Collection[str]) -> tuple[str, ...]:
    """Return those that follow a name in the alphabet, and then those before it."""
    names = sorted({*same, name})
    at = names.index(name)
    return tuple(names[at + 1 :] + names[:at])[:_MOST]


def known_names(tree: SourceTree, alike: Sequence[Collection[str]] = ()) -> KnownNames:
    """Return the names of a source; `alike` are names of robot and scene, those of each kind."""
    collected = _Collected(tree)
    tree.module.visit(collected)
    functions = {key: number for key, number in collected.functions.items() if number is not None}
    variables = {key: shape for key, shape in collected.variables.items() if shape is not None}
    return KnownNames(collected.texts, variables, functions, tuple(alike))


class _Collected(Walk):
    def __init__(self, tree: SourceTree) -> None:
        super().__init__(tree)
        self.texts: dict[Role, set[str]] = {}
        self.variables: dict[tuple[str, str], Role | None] = {}
        self.functions: dict[tuple[str, str], int | None] = {}

    def at(self, node: cst.CSTNode) -> None:
        if isinstance(node, cst.SimpleString):
            role, value = _role(node, self), _text(node)
            if role is not None and value is not None:
                self.texts.setdefault(role, set()).add(value)
        elif isinstance(node, cst.Assign) and len(node.targets) == 1:
            self._assigned(node.targets[0].target, node.value)
        elif isinstance(node, cst.FunctionDef):
            self._defined(node)

    def _assigned(self, target: cst.BaseExpression, value: cst.BaseExpression) -> None:
        shape = _shape(value, self.tree)
        key = _scope_of(target, self)
        if key is not None:
            # What is assigned twice has the shape that both have.
            known = self.variables.get(key, shape)
            self.variables[key] = shape if known == shape else None
            if isinstance(value, cst.Dict):
                keys = [
                    element.key
                    for element in value.elements
                    if isinstance(element, cst.DictElement)
                ]
                names = {_text(node) for node in keys if isinstance(node, cst.SimpleString)}
                role = ("key", self.tree.code(target))
                self.texts.setdefault(role, set()).update(name for name in names if name)

    def _defined(self, node: cst.FunctionDef) -> None:
        # Of a class that is its body, which stands in between.
        inside = self.above[-2] if len(self.above) > 1 else None
        is_own = isinstance(inside, cst.ClassDef) or inside is None
        plain = node.params
        if not is_own or node.decorators or plain.kwonly_params or plain.posonly_params:
            return
        owner = self.owner if isinstance(inside, cst.ClassDef) else ""
        number = len([parameter for parameter in plain.params if parameter.default is None])
        key = (owner, node.name.value)
        self.functions[key] = None if key in self.functions else number


def _scope_of(target: cst.BaseExpression, walk: Walk) -> tuple[str, str] | None:
    """Return whose a name is that is assigned or read, and the name: a function, class, module."""
    if isinstance(target, cst.Attribute):
        is_self = isinstance(target.value, cst.Name) and target.value.value == "self"
        return (f"{walk.owner}.self", target.attr.value) if is_self and walk.owner else None
    if not isinstance(target, cst.Name):
        return None
    is_in_class = walk.above and any(isinstance(node, cst.ClassDef) for node in walk.above[-4:])
    if is_in_class and walk.function == "<module>":
        return f"{walk.owner}.self", target.value
    return walk.function, target.value


def _shape(value: cst.BaseExpression, tree: SourceTree) -> Role | None:
    """Return what is equal for values that can take each other's place; `None` for none."""
    if number_of(value) is not None:
        return ("number",)
    if isinstance(value, cst.SimpleString):
        return ("text",)
    if isinstance(value, cst.List | cst.Tuple):
        return ("items", len(value.elements))
    if isinstance(value, cst.Dict):
        return ("table", len(value.elements))
    return ("call", tree.code(value.func)) if isinstance(value, cst.Call) else None


def _text(node: cst.SimpleString) -> str | None:
    value = node.evaluated_value
    is_name = isinstance(value, str) and value.strip() and len(node.quote) == 1
    return value if is_name and isinstance(value, str) else None


def _role(node: cst.CSTNode, walk: Walk) -> Role | None:
    """Return what part a text plays: which argument, key or value it is; `None` for none."""
    tree, above = walk.tree, walk.parent
    around = walk.above[-2] if len(walk.above) > 1 else above
    if isinstance(above, cst.Arg) and isinstance(around, cst.Call):
        place = above.keyword.value if above.keyword else around.args.index(above)
        return "argument", last_name(around.func), place
    if isinstance(above, cst.Index):
        subscript = walk.above[-3]
        return ("key", tree.code(subscript.value)) if isinstance(subscript, cst.Subscript) else None
    if isinstance(above, cst.ComparisonTarget) and isinstance(around, cst.Comparison):
        return "value", tree.code(around.left)
    if isinstance(above, cst.Assign):
        return "value", tree.code(above.targets[0].target)
    if isinstance(above, cst.Element):
        return "item", tree.span(around)
    if isinstance(above, cst.DictElement) and above.value is node:
        return "entry", tree.span(around)
    return None


def text_changes(node: cst.CSTNode, walk: Walk, known: KnownNames) -> Iterator[Draft]:
    """Yield the changes of a text into others that play the same part."""
    if not isinstance(node, cst.SimpleString):
        return
    value, above = _text(node), walk.parent
    is_key = isinstance(above, cst.DictElement) and above.key is node
    if value is None or is_key:
        return
    for other in known.other_texts(_role(node, walk), value):
        quoted = f"{node.quote}{other}{node.quote}"
        is_plain = other.isprintable() and not set(other) & {"\\", node.quote}
        yield walk.tree.replaced(node, quoted if is_plain else repr(other), "name")


def variable_changes(node: cst.CSTNode, walk: Walk, known: KnownNames) -> Iterator[Draft]:
    """Yield the changes of a variable or constant that is read into others of its shape."""
    above = walk.parent
    if not isinstance(node, cst.Name | cst.Attribute) or not isinstance(above, _READ_BY):
        return
    if isinstance(above, cst.Arg) and above.keyword is node:
        return
    key = _scope_of(node, walk)
    if key is None:
        return
    name = node.attr if isinstance(node, cst.Attribute) else node
    scopes = (key[0],) if isinstance(node, cst.Attribute) else (walk.function, "<module>")
    for other in known.other_variables(scopes, key[1]):
        words = f"{walk.tree.code(node)} becomes {other}"
        yield walk.tree.replaced(name, other, "name", words)


def function_changes(node: cst.CSTNode, walk: Walk, known: KnownNames) -> Iterator[Draft]:
    """Yield the changes of a call into one of another function of the controller."""
    if not isinstance(node, cst.Call):
        return
    called, owner = node.func, ""
    if isinstance(called, cst.Attribute):
        if not isinstance(called.value, cst.Name) or called.value.value != "self":
            return
        called, owner = called.attr, walk.owner
    if isinstance(called, cst.Name):
        this = walk.function.rpartition(".")[2]
        for other in known.other_functions(owner, called.value, this):
            before = walk.tree.code(node.func)
            words = f"{before}() becomes {before.removesuffix(called.value)}{other}()"
            yield walk.tree.replaced(called, other, "name", words)
