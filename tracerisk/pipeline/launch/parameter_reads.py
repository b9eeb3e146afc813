"""Which parameters a source asks for, as far as can be seen without running it."""

from __future__ import annotations

import ast
import contextlib
from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from tracerisk.common.text.bounded import file_bytes
from tracerisk.instrument.source.dotted_names import last_name
from tracerisk.instrument.source.python_source import texts_in
from tracerisk.pipeline.workspace.controller import Controller

_MOST_MODULES = 60

_READS = frozenset(
    {"get_param", "get_param_cached", "has_param", "search_param"}
    | {"get_parameter", "get_parameter_or", "declare_parameter", "has_parameter"}
)
_NEEDS = frozenset({"get_param", "get_param_cached", "declare_parameter"})
_NODES = frozenset({"create_node", "init_node", "Node", "LifecycleNode"})


@dataclass(frozen=True, slots=True)
class Asked:
    """The names of parameters in a source."""

    names: frozenset[str] = frozenset()
    """All parameters that the source reads."""
    required: frozenset[str] = frozenset()
    """The parameters that it reads without a default of its own."""
    literals: frozenset[str] = frozenset()
    """All strings in the source."""
    nodes: tuple[str, ...] = ()
    """The names that the source gives its nodes."""
    spaces: frozenset[str] = frozenset()
    """The namespaces that the source gives its nodes itself, like `/left`."""


def asked_by(controller: Controller, folders: Mapping[str, Path]) -> Asked:
    """Return what a script and the modules of the workspace that it imports ask for.

    `folders` are those in which the workspace's Python packages stand, by their names. The nodes
    are those of the script alone.
    """
    project, script = controller.project, controller.path.resolve()
    asked = _asked_of(controller.tree)
    waiting, seen = deque([(script, controller.source)]), {script}
    while waiting and len(seen) < _MOST_MODULES:
        path, text = waiting.popleft()
        for module in _imported(path, project.imports(text), folders):
            if module in seen:
                continue
            seen.add(module)
            with contextlib.suppress(OSError):
                waiting.append((module, file_bytes(module)))
                more = _asked_of(project.tree(waiting[-1][1]))
                asked = replace(
                    asked, names=asked.names | more.names, required=asked.required | more.required
                )
    return asked


def _imported(
    path: Path, imports: Iterable[tuple[int, tuple[str, ...]]], folders: Mapping[str, Path]
) -> Iterator[Path]:
    """Yield the files of the modules of the workspace that a module imports."""
    for level, parts in imports:
        if not parts:
            continue
        top = path.parents[level - 1] if level else folders.get(parts[0], path.parent)
        target = top.joinpath(*parts)
        for file in (target.with_suffix(".py"), target / "__init__.py"):
            if file.is_file():
                yield file.resolve()


def _asked_of(tree: ast.Module | None) -> Asked:
    """Return what a source asks for; nothing where it is not Python 3."""
    if tree is None:
        return Asked()
    names: set[str] = set()
    required: set[str] = set()
    calls = [node for node in ast.walk(tree) if isinstance(node, ast.Call)]
    for call in calls:
        called = last_name(call.func)
        if called in _READS:
            name = _text(call.args[0]) if call.args else _keyword(call, "name")
            if name is not None:
                names.add(name)
                if called in _NEEDS and _is_needed(call):
                    required.add(name)
        elif called == "declare_parameters":
            names |= set(_declared(call))
    nodes = tuple(_node_names(calls))
    spaces = frozenset(_node_spaces(calls))
    return Asked(frozenset(names), frozenset(required), frozenset(texts_in(tree)), nodes, spaces)


def _text(node: ast.expr) -> str | None:
    is_text = isinstance(node, ast.Constant) and isinstance(node.value, str)
    return node.value if is_text else None  # type: ignore[attr-defined]


def _keyword(call: ast.Call, name: str) -> str | None:
    for keyword in call.keywords:
        if keyword.arg == name:
            return _text(keyword.value)
    return None


def _is_needed(call: ast.Call) -> bool:
    """Return whether a read or a declaration gives no value for where nobody else does."""
    keywords = {keyword.arg for keyword in call.keywords}
    if len(call.args) < 2:
        return not keywords & {"default", "value"}
    second = call.args[1]
    # `Parameter.Type.STRING` says of which type it is, not what.
    return isinstance(second, ast.Attribute) and "Type" in ast.unparse(second)


def _declared(call: ast.Call) -> Iterator[str]:
    given = [keyword.value for keyword in call.keywords if keyword.arg == "parameters"]
    space = (_text(call.args[0]) if call.args else _keyword(call, "namespace")) or ""
    for argument in [*call.args[1:2], *given]:
        for entry in argument.elts if isinstance(argument, ast.List | ast.Tuple) else ():
            first = entry.elts[0] if isinstance(entry, ast.Tuple) and entry.elts else None
            name = _text(first) if first is not None else None
            if name is not None:
                yield f"{space}.{name}" if space else name


def _node_spaces(calls: Iterable[ast.Call]) -> Iterator[str]:
    """Yield the namespaces that calls give the nodes that they make."""
    for call in calls:
        if last_name(call.func) in _NODES or _is_base(call):
            space = (_keyword(call, "namespace") or "").strip("/")
            if space:
                yield f"/{space}"


def _is_base(call: ast.Call) -> bool:
    """Return whether a call makes what a class derives from: `super().__init__("x")`."""
    return last_name(call.func) == "__init__" and isinstance(call.func, ast.Attribute)


def _node_names(calls: Iterable[ast.Call]) -> Iterator[str]:
    """Yield what nodes are called: `super().__init__("x")`, `create_node("x")`, `Node("x")`."""
    for call in calls:
        is_base = _is_base(call)
        if last_name(call.func) not in _NODES and not is_base:
            continue
        arguments = [*call.args[:1], *(call.args[1:2] if is_base else ())]
        name = next((text for argument in arguments if (text := _text(argument)) is not None), None)
        name = name if name is not None else _keyword(call, "node_name")
        if name:
            yield name
