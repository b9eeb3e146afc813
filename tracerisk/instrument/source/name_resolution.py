"""Resolve, as far as a reader could without running it, what the names of a source file mean.

Followed: functions and classes by name, `self`, `cls` and `super()` through the classes of the
file and their subclasses, and variables and attributes through what is assigned to them
(`self.arm = Arm()`) or how they are annotated.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Literal

import libcst as cst

from tracerisk.common.function_ref import FunctionRef, QualifiedName

# Assignments followed one after the other: `a = b`, `b = c`, ...
_LONGEST_CHAIN = 50


@dataclass(eq=False, slots=True)
class Scope:
    """A module, class or function body, and what is bound in it."""

    kind: Literal["module", "class", "function"]
    """What the body belongs to."""
    qualified: str
    """The qualified name of the class or function; empty for a module."""
    parent: Scope | None
    """The enclosing scope; `None` for a module."""
    owner: FunctionRef
    """The function to which calls in this body are attributed; `<module>` outside functions."""
    klass: ClassBody | None = None
    """The class of a class body, or of the method that a function is; else `None`."""
    self_name: str | None = None
    """The first parameter of a method; `None` for all others."""
    cls_name: str | None = None
    """The first parameter of a class method; `None` for all others."""
    functions: dict[str, list[FunctionRef]] = field(default_factory=dict)
    """The functions that a name is bound to by `def`."""
    classes: dict[str, ClassBody] = field(default_factory=dict)
    """The class that a name is bound to by `class`."""
    imported: set[str] = field(default_factory=set)
    """The names bound by imports."""
    assigned: dict[str, list[cst.BaseExpression]] = field(default_factory=dict)
    """The expressions assigned to a name."""
    annotated: dict[str, list[cst.BaseExpression]] = field(default_factory=dict)
    """The annotations of a name; empty for a parameter that has none."""

    def prefix(self) -> str:
        """Return what stands before the name of something defined here."""
        dot = {"module": "", "class": ".", "function": ".<locals>."}[self.kind]
        return self.qualified + dot

    def binds(self, name: str) -> bool:
        """Return whether a name is bound here, even to something unknown."""
        tables = (self.functions, self.classes, self.imported, self.assigned, self.annotated)
        return any(name in table for table in tables)

    def visible(self) -> Iterator[Scope]:
        """Iterate over the scopes in which a name used here is looked for, innermost first."""
        yield self
        scope = self.parent
        while scope is not None:
            if scope.kind != "class":
                yield scope
            scope = scope.parent


@dataclass(eq=False, slots=True)
class ClassBody:
    """A class of the file."""

    name: str
    """The qualified name of the class."""
    scope: Scope
    """The scope of the class body."""
    bases: list[cst.BaseExpression] = field(default_factory=list)
    """The expressions of the bases, in order."""
    subclasses: list[ClassBody] = field(default_factory=list)
    """The direct subclasses in the same file."""
    attributes: dict[str, list[tuple[cst.BaseExpression, Scope]]] = field(default_factory=dict)
    """The expressions assigned to an attribute of `self` or `cls`, each with its scope."""
    annotations: dict[str, list[tuple[cst.BaseExpression, Scope]]] = field(default_factory=dict)
    """The annotations of an attribute, each with its scope."""


MeaningKind = Literal["function", "class", "instance", "super", "external"]


@dataclass(frozen=True, slots=True)
class Meaning:
    """One thing that an expression may be."""

    kind: MeaningKind
    """What it is; `external` for what is not of this file."""
    function: FunctionRef | None = None
    """The function; `None` for other kinds."""
    klass: ClassBody | None = None
    """The class, the class of an instance, or the one that `super()` starts from; else `None`."""


EXTERNAL = Meaning("external")
Meanings = frozenset[Meaning]
_UNKNOWN: Meanings = frozenset()


class NameResolver:
    """Answers what expressions mean, once the scopes of a whole file are known."""

    def __init__(self, classes: Sequence[ClassBody]) -> None:
        self._known: dict[tuple[int, str], Meanings] = {}
        self._asked: set[tuple[int, str]] = set()
        for class_ in classes:
            for base in self._bases(class_):
                base.subclasses.append(class_)
        # A name may have been asked for before the subclasses were known.
        self._known.clear()

    def evaluate(self, expression: cst.CSTNode, scope: Scope) -> Meanings:
        """Return all that an expression may be in a scope; empty where that is not known."""
        match expression:
            case cst.Name(value=name):
                return self._once(scope, name, lambda: self._name(name, scope))
            case cst.Attribute(value=value, attr=attribute):
                parts = (self._member(m, attribute.value) for m in self.evaluate(value, scope))
                return _union(parts)
            case cst.Call(func=cst.Name(value="super"), args=[]) if klass := _class_of(scope):
                return frozenset({Meaning("super", klass=klass)})
            case cst.Call(func=function):
                return _union(_called(meaning) for meaning in self.evaluate(function, scope))
            case cst.IfExp(body=left, orelse=right) | cst.BooleanOperation(left=left, right=right):
                return self.evaluate(left, scope) | self.evaluate(right, scope)
            case cst.NamedExpr(value=value):
                return self.evaluate(value, scope)
        return _UNKNOWN

    def methods(self, klass: ClassBody, name: str) -> frozenset[FunctionRef]:
        """Return the methods that `name` may call on an instance: own, inherited, overriding."""
        function_refs = set(self._inherited(klass, name))
        for class_body in _below(klass):
            function_refs.update(class_body.scope.functions.get(name, ()))
        return frozenset(function_refs)

    def run_by_calling(self, meaning: Meaning) -> frozenset[FunctionRef]:
        """Return the functions that run when something is called."""
        if meaning.function is not None:
            return frozenset({meaning.function})
        if meaning.klass is None:
            return frozenset()
        if meaning.kind == "class":
            return self.methods(meaning.klass, "__init__") | self.methods(meaning.klass, "__new__")
        return self.methods(meaning.klass, "__call__")

    def _once(self, holder: object, name: str, answer: Callable[[], Meanings]) -> Meanings:
        """Ask for each name once; in a ring of assignments the inner question has no answer."""
        key = (id(holder), name)
        if key in self._known:
            return self._known[key]
        if key in self._asked or len(self._asked) >= _LONGEST_CHAIN:
            return _UNKNOWN
        self._asked.add(key)
        try:
            self._known[key] = answer()
        finally:
            self._asked.discard(key)
        return self._known[key]

    def _name(self, name: str, scope: Scope) -> Meanings:
        for item in scope.visible():
            if name in (item.self_name, item.cls_name) and item.klass is not None:
                kind: MeaningKind = "instance" if name == item.self_name else "class"
                return frozenset({Meaning(kind, klass=item.klass)})
            if item.binds(name):
                return self._bound(item, name)
        return _UNKNOWN

    def _bound(self, scope: Scope, name: str) -> Meanings:
        """Return what a name is in the scope that binds it."""
        bound = {Meaning("function", ref) for ref in scope.functions.get(name, ())}
        if name in scope.classes:
            bound.add(Meaning("class", klass=scope.classes[name]))
        if name in scope.imported:
            bound.add(EXTERNAL)
        for value in scope.assigned.get(name, ()):
            bound |= self.evaluate(value, scope)
        for annotation in scope.annotated.get(name, ()):
            bound |= self._annotated(annotation, scope)
        return frozenset(bound)

    def _annotated(self, annotation: cst.BaseExpression, scope: Scope) -> Meanings:
        if isinstance(annotation, cst.SimpleString):
            name = annotation.evaluated_value
            if isinstance(name, str) and name.isidentifier():
                annotation = cst.Name(name)
        return _union(_called(meaning) for meaning in self.evaluate(annotation, scope))

    def _member(self, meaning: Meaning, name: str) -> Meanings:
        klass = meaning.klass
        if klass is None:
            return frozenset({EXTERNAL}) if meaning.kind == "external" else _UNKNOWN
        if meaning.kind == "super":
            above = {ref for base in self._bases(klass) for ref in self._inherited(base, name)}
            return frozenset(Meaning("function", ref) for ref in above) or frozenset({EXTERNAL})
        return self._once(klass, name, lambda: self._attribute(klass, name))

    def _attribute(self, klass: ClassBody, name: str) -> Meanings:
        members = {Meaning("function", ref) for ref in self.methods(klass, name)}
        for class_body in (*self._above(klass), *_below(klass)):
            if name in class_body.scope.classes:
                members.add(Meaning("class", klass=class_body.scope.classes[name]))
            for value in class_body.scope.assigned.get(name, ()):
                members |= self.evaluate(value, class_body.scope)
            for value, scope in class_body.attributes.get(name, ()):
                members |= self.evaluate(value, scope)
            for annotation, scope in class_body.annotations.get(name, ()):
                members |= self._annotated(annotation, scope)
        return frozenset(members)

    def _inherited(self, klass: ClassBody, name: str) -> list[FunctionRef]:
        """Return the methods of the nearest class upwards that has some."""
        for class_body in self._above(klass):
            if name in class_body.scope.functions:
                return class_body.scope.functions[name]
        return []

    def _above(self, klass: ClassBody) -> list[ClassBody]:
        """Return a class and its bases, each once, nearer ones first."""
        above = [klass]
        for class_body in above:
            above += [base for base in self._bases(class_body) if base not in above]
        return above

    def _bases(self, klass: ClassBody) -> list[ClassBody]:
        scope = klass.scope.parent
        assert scope is not None
        bases: list[ClassBody] = []
        for base in klass.bases:
            meanings = self.evaluate(base, scope)
            classes = {m.klass for m in meanings if m.klass is not None and m.kind == "class"}
            bases += sorted(classes, key=lambda class_body: class_body.name)
        return bases


def _below(klass: ClassBody) -> list[ClassBody]:
    """Return the subclasses of a class, each once."""
    subclasses = list(klass.subclasses)
    for class_body in subclasses:
        subclasses += [below for below in class_body.subclasses if below not in subclasses]
    return subclasses


def _union(parts: Iterator[Meanings]) -> Meanings:
    return frozenset().union(*parts)


def _class_of(scope: Scope) -> ClassBody | None:
    """Return the class whose method encloses a scope."""
    return next((item.klass for item in scope.visible() if item.klass is not None), None)


def _called(meaning: Meaning) -> Meanings:
    """Return what calling something gives: an instance of a class; what is not ours stays so."""
    if meaning.kind == "class":
        return frozenset({Meaning("instance", klass=meaning.klass)})
    return frozenset({EXTERNAL}) if meaning.kind == "external" else _UNKNOWN


def external_name(expression: cst.CSTNode) -> QualifiedName | None:
    """Return the last name of a name or an attribute: `go` of `self.arm.go`."""
    match expression:
        case cst.Name(value=name) | cst.Attribute(attr=cst.Name(value=name)):
            return QualifiedName(name)
    return None


def written_name(expression: cst.CSTNode) -> str | None:
    """Return names and dots as they are written, `self.arm.go`; None for anything else."""
    match expression:
        case cst.Name(value=name):
            return name
        case cst.Attribute(value=value, attr=cst.Name(value=name)):
            before = written_name(value)
            return None if before is None else f"{before}.{name}"
    return None
