"""The static call graph of a source file, and which functions can reach a motion command.

It errs on the side of more calls: a function that is handed on (a callback) counts as called by who
hands it on, and a method called on something unknown as each method of that name in the file.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import PurePosixPath

import libcst as cst

from tracerisk.common.function_ref import FunctionRef
from tracerisk.errors import Location, UnsafeRewriteError
from tracerisk.instrument.source.function_definitions import MODULE
from tracerisk.instrument.source.name_resolution import (
    ClassBody,
    NameResolver,
    Scope,
    external_name,
    written_name,
)
from tracerisk.instrument.source.python_source import ParsedSource, parse_source


@dataclass(frozen=True, slots=True)
class CalledBy:
    """What one function calls.

    Calls that lead out of the controller are named as written and by their last name
    (`self.arm.go` and `go`).
    """

    line: int
    """The line of the function's `def`, from 1."""
    functions: frozenset[FunctionRef]
    """The controller's functions that it calls."""
    others: frozenset[str]
    """The names of calls that lead out of the controller."""
    unknown: frozenset[str] = frozenset()
    """Those of `others` that are called on an object of unknown type."""

    def with_more(self, more: CalledBy) -> CalledBy:
        """Return it with what another part of the same function calls."""
        return CalledBy(
            self.line,
            self.functions | more.functions,
            self.others | more.others,
            self.unknown | more.unknown,
        )


@dataclass(frozen=True, slots=True)
class CallGraph:
    """The calls of every function of one or more source files, `<module>` of each included."""

    calls: Mapping[FunctionRef, CalledBy]
    """What each function calls."""
    imports: Mapping[str, frozenset[str]] = field(default_factory=dict)
    """The last names of the modules that a file may import, by file."""
    regular: Mapping[FunctionRef, CalledBy] = field(default_factory=dict)
    """The same as `calls`, without calls in `except` clauses."""

    @classmethod
    def joined(cls, graphs: Iterable[CallGraph]) -> CallGraph:
        """Return one graph of several files, calls from one to another among them.

        A call of a name that a directly or indirectly imported file defines counts as a call of
        that function; a method called on something unknown counts as a call of every method of that
        name.
        """
        graphs = tuple(graphs)
        calls = {ref: each for graph in graphs for ref, each in graph.calls.items()}
        regular = {ref: each for graph in graphs for ref, each in graph.regular.items()}
        imports = {file: names for graph in graphs for file, names in graph.imports.items()}
        named: dict[str, dict[str, set[FunctionRef]]] = {file: {} for file in imports}
        for ref in calls:
            parts = str(ref.name).split(".")
            # A class is called by its name.
            tail = parts[-2:] if parts[-1] == "__init__" else parts[-1:]
            for name in tail:
                named.setdefault(ref.file, {}).setdefault(name, set()).add(ref)
        seen = {file: _imported_files(file, imports) for file in imports}

        def linked(ref: FunctionRef, each: CalledBy) -> CalledBy:
            function_refs = set(each.functions)
            for file, functions in named.items():
                names = each.others if file in seen.get(ref.file, ()) else each.unknown
                for name in names & functions.keys():
                    function_refs |= functions[name]
            return replace(each, functions=frozenset(function_refs))

        return cls(
            {ref: linked(ref, each) for ref, each in calls.items()},
            imports,
            {ref: linked(ref, each) for ref, each in regular.items()},
        )


@lru_cache(maxsize=8)
def call_graph(source: bytes, file: str) -> CallGraph:
    """Read the static call graph of one source file.

    Raises:
        SourceError: the source is not Python 3.
        UnsafeRewriteError: libcst cannot read what Python can.
    """
    parsed = parse_source(source, file)
    reader = _Reader(parsed)
    try:
        cst.parse_module(parsed.text).visit(reader)
    except (cst.ParserSyntaxError, cst.CSTLogicError, RecursionError) as error:
        raise UnsafeRewriteError(
            "libcst cannot read this source, which Python can; write it in a plainer way",
            Location(file, getattr(error, "raw_line", None)),
        ) from error
    return reader.graph()


def _imported_files(file: str, imports: Mapping[str, frozenset[str]]) -> frozenset[str]:
    """Return the files that a file imports, at first hand or not; not itself."""
    by_name: dict[str, set[str]] = {}
    for text in imports:
        path = PurePosixPath(text)
        name = path.parent.name if path.stem == "__init__" else path.stem
        by_name.setdefault(name, set()).add(text)
    files: set[str] = set()
    pending = [file]
    while pending:
        new = {text for name in imports[pending.pop()] for text in by_name.get(name, ())} - files
        files |= new
        pending += new
    return frozenset(files - {file})


@dataclass(slots=True)
class _Use:
    """What a part of a function's body uses, before names are resolved."""

    called: list[tuple[cst.BaseExpression, Scope]] = field(default_factory=list)
    """The expressions that are called, each with the scope of the call."""
    handed_on: list[tuple[cst.BaseExpression, Scope]] = field(default_factory=list)
    """The expressions that are passed as arguments, each with the scope of the call."""
    read: list[tuple[cst.BaseExpression, Scope]] = field(default_factory=list)
    """The names and attributes that are only read, each with its scope."""


@dataclass(slots=True)
class _Uses:
    """What a function's body uses, in its regular course and in its `except` clauses."""

    line: int
    """The line of the function's `def`, from 1."""
    regular: _Use = field(default_factory=_Use)
    """The use outside `except` clauses."""
    handling: _Use = field(default_factory=_Use)
    """The use in `except` clauses."""


class _Reader(cst.CSTVisitor):
    """Gathers scopes and uses; meets functions in the order of `ParsedSource.functions`."""

    def __init__(self, parsed: ParsedSource) -> None:
        super().__init__()
        self._module = module = FunctionRef(parsed.file, MODULE)
        self._remaining = iter(parsed.functions)
        self._scope = Scope("module", "", None, module)
        self._uses: dict[FunctionRef, _Uses] = {module: _Uses(1)}
        self._handling = 0
        self._classes: list[ClassBody] = []
        self._imports: set[str] = set()

    def graph(self) -> CallGraph:
        names = NameResolver(self._classes)
        calls, regular = {}, {}
        for ref, uses in self._uses.items():
            regular[ref] = self._resolved(uses.line, uses.regular, names)
            calls[ref] = regular[ref].with_more(self._resolved(uses.line, uses.handling, names))
        return CallGraph(calls, {self._module.file: frozenset(self._imports)}, regular)

    # --- scopes

    def visit_FunctionDef(self, node: cst.FunctionDef) -> bool:  # noqa: N802
        site = next(self._remaining)
        for decorator in (*node.decorators, node.params, node.returns):
            if decorator is not None:
                decorator.visit(self)
        outer = self._scope
        outer.functions.setdefault(node.name.value, []).append(site.ref)
        self._uses.setdefault(site.ref, _Uses(site.line))
        scope = Scope("function", str(site.ref.name), outer, site.ref)
        parameters = [*node.params.posonly_params, *node.params.params, *node.params.kwonly_params]
        for parameter in parameters:
            # A parameter hides the outer name, annotated or not.
            annotations = scope.annotated.setdefault(parameter.name.value, [])
            if parameter.annotation is not None:
                annotations.append(parameter.annotation.annotation)
        if outer.kind == "class" and parameters:
            _bind_first_parameter(scope, outer, node, parameters[0].name.value)
        handling, self._handling = self._handling, 0
        self._scope = scope
        node.body.visit(self)
        self._scope = outer
        self._handling = handling
        return False

    def visit_ClassDef(self, node: cst.ClassDef) -> bool:  # noqa: N802
        outer = self._scope
        for decorator in (*node.decorators, *node.bases, *node.keywords):
            decorator.visit(self)
        name = outer.prefix() + node.name.value
        scope = Scope("class", name, outer, outer.owner)
        body = ClassBody(name, scope, [base.value for base in node.bases])
        scope.klass = body
        outer.classes[node.name.value] = body
        self._classes.append(body)
        self._scope = scope
        node.body.visit(self)
        self._scope = outer
        return False

    # --- bindings

    def visit_ImportAlias(self, node: cst.ImportAlias) -> bool:  # noqa: N802
        name: cst.BaseExpression = node.name
        if node.asname is not None and isinstance(node.asname.name, cst.Name):
            name = node.asname.name
        last = external_name(node.name)
        if last is not None:
            self._imports.add(last)
        while isinstance(name, cst.Attribute):
            name = name.value
        if isinstance(name, cst.Name):
            self._scope.imported.add(name.value)
        return False

    def visit_ImportFrom(self, node: cst.ImportFrom) -> None:  # noqa: N802
        last = None if node.module is None else external_name(node.module)
        if last is not None:
            self._imports.add(last)

    def visit_Assign(self, node: cst.Assign) -> None:  # noqa: N802
        for target in node.targets:
            self._bind(target.target, node.value)

    def visit_AnnAssign(self, node: cst.AnnAssign) -> None:  # noqa: N802
        self._bind(node.target, node.annotation.annotation, is_annotation=True)
        if node.value is not None:
            self._bind(node.target, node.value)

    def _bind(
        self, target: cst.BaseExpression, value: cst.BaseExpression, *, is_annotation: bool = False
    ) -> None:
        scope = self._scope
        match target:
            case cst.Name(value=name):
                bound = scope.annotated if is_annotation else scope.assigned
                bound.setdefault(name, []).append(value)
            case cst.Attribute(value=cst.Name(value=name), attr=attribute):
                holder = next((s for s in scope.visible() if name == s.self_name), None)
                if holder is not None and holder.klass is not None:
                    body = holder.klass
                    table = body.annotations if is_annotation else body.attributes
                    table.setdefault(attribute.value, []).append((value, scope))
            case cst.Tuple(elements=targets) if isinstance(value, cst.Tuple):
                for node, part in zip(targets, value.elements, strict=False):
                    self._bind(node.value, part.value)

    # --- uses

    def visit_Call(self, node: cst.Call) -> bool:  # noqa: N802
        self._own.called.append((node.func, self._scope))
        self._own.handed_on += [(argument.value, self._scope) for argument in node.args]
        # The function's own name is dealt with; what stands before it (`a.b` of `a.b.c()`) still
        # has to be visited.
        inner = node.func.value if isinstance(node.func, cst.Attribute) else node.func
        if not isinstance(inner, cst.Name):
            inner.visit(self)
        for argument in node.args:
            argument.visit(self)
        return False

    def visit_Attribute(self, node: cst.Attribute) -> bool:  # noqa: N802
        self._own.read.append((node, self._scope))
        node.value.visit(self)
        return False

    def visit_Name(self, node: cst.Name) -> None:  # noqa: N802
        self._own.read.append((node, self._scope))

    def visit_Arg(self, node: cst.Arg) -> bool:  # noqa: N802
        node.value.visit(self)
        return False

    def visit_Annotation(self, node: cst.Annotation) -> bool:  # noqa: N802, ARG002
        return False

    def visit_ExceptHandler_body(self, node: cst.ExceptHandler) -> None:  # noqa: N802, ARG002
        self._handling += 1

    def leave_ExceptHandler_body(self, node: cst.ExceptHandler) -> None:  # noqa: N802, ARG002
        self._handling -= 1

    @property
    def _own(self) -> _Use:
        uses = self._uses[self._scope.owner]
        return uses.handling if self._handling else uses.regular

    # --- names resolved

    def _resolved(self, line: int, uses: _Use, names: NameResolver) -> CalledBy:
        functions: set[FunctionRef] = set()
        others: set[str] = set()
        unknown: set[str] = set()
        for expression, scope in uses.called:
            meanings = names.evaluate(expression, scope)
            for meaning in meanings:
                functions |= names.run_by_calling(meaning)
            name = external_name(expression)
            is_ours = any(item.kind != "external" for item in meanings)
            if name is not None and not is_ours:
                others |= {name, written_name(expression) or name}
                if not meanings and isinstance(expression, cst.Attribute):
                    functions |= self._methods_named(name)
                    unknown.add(name)
        for expression, scope in uses.handed_on:
            name = external_name(expression)
            if isinstance(expression, cst.Attribute) and name is not None:
                meanings = names.evaluate(expression, scope)
                if all(item.kind == "external" for item in meanings):
                    others |= {name, written_name(expression) or name}
        for expression, scope in uses.read:
            for meaning in names.evaluate(expression, scope):
                if meaning.function is not None:
                    functions.add(meaning.function)
        return CalledBy(line, frozenset(functions), frozenset(others), frozenset(unknown))

    def _methods_named(self, name: str) -> set[FunctionRef]:
        return {ref for body in self._classes for ref in body.scope.functions.get(name, ())}


def _bind_first_parameter(scope: Scope, outer: Scope, node: cst.FunctionDef, name: str) -> None:
    decorators = {external_name(decorator.decorator) for decorator in node.decorators}
    if "staticmethod" in decorators:
        return
    scope.klass = outer.klass
    if "classmethod" in decorators or node.name.value in ("__new__", "__init_subclass__"):
        scope.cls_name = name
    else:
        scope.self_name = name
