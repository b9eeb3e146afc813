"""The messages, services and actions of a package that is not here, as a program uses them.

A definition says which fields there are and of which type. A program shows most of that: it fills
fields, reads them, compares them and goes through them. What it does not use, it does not miss.
"""

from __future__ import annotations

import ast
import builtins
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from tracerisk.instrument.source.definitions.shapes import Shape, definition_lines
from tracerisk.instrument.source.definitions.used_values import UsedValues
from tracerisk.instrument.source.dotted_names import dotted_name

_KINDS = ("msg", "srv", "action")
_PARTS = {
    "msg": ("",),
    "srv": ("Request", "Response"),
    "action": ("Goal", "Result", "Feedback"),
}
_OF_ACTIONS = ("ActionGoal", "ActionResult", "ActionFeedback", "Action", *_PARTS["action"])
KnownNames = Callable[[str, str], Collection[str]]
"""The function that returns the names in a kind of a package whose definitions are here."""


@dataclass(slots=True, eq=False)
class _Interface:
    """One message, service or action."""

    kind: str
    """`msg`, `srv` or `action`."""
    name: str
    """Its name, without that of a part."""
    parts: dict[str, Shape] = field(default_factory=dict)
    """What is known of each part."""

    def part(self, name: str) -> Shape:
        return self.parts.setdefault(name, Shape())


def used_definitions(
    trees: Sequence[ast.AST], package: str, known_names: KnownNames, *, is_ros1: bool
) -> Mapping[tuple[str, str], str]:
    """Return the texts of the definitions of a package that sources use, by kind and name."""
    names = [_names_of(tree, package, trees, known_names) for tree in trees]
    used = {full for mapping in names for full in mapping.values()}
    used |= {
        found
        for tree, mapping in zip(trees, names, strict=True)
        for found in _used_through(tree, mapping)
    }
    table = _interfaces(used, is_ros1=is_ros1)
    for tree, mapping in zip(trees, names, strict=True):
        # A field of ROS 1 that holds decimals takes whole numbers too.
        UsedValues(tree, _Classes(mapping, table), "float64" if is_ros1 else "int64").read()
    texts: dict[tuple[str, str], str] = {}
    made: dict[str, str] = {}
    for interface in dict.fromkeys(interface for interface, _ in table.values()):
        nested = _nested_of(package, interface.name, made)
        shapes = (interface.part(part) for part in _PARTS[interface.kind])
        parts = ("\n".join(definition_lines(shape, nested)) for shape in shapes)
        texts[interface.kind, interface.name] = "\n---\n".join(parts) + "\n"
    return {**{("msg", name): text for name, text in made.items()}, **texts}


def imports_interfaces(names: Iterable[Sequence[str]], package: str) -> bool:
    """Return whether what is imported of a package is definitions alone, by dotted names."""
    below = [parts[1:] for parts in names if parts[:1] == [package]]
    return bool(below) and all(parts[:1] and parts[0] in _KINDS for parts in below)


def _nested_of(package: str, owner: str, made: dict[str, str]) -> Callable[[str, Shape], str]:
    def nested(name: str, shape: Shape) -> str:
        words = "".join(word.capitalize() for word in name.split("_"))
        text = "\n".join(definition_lines(shape, nested)) + "\n"
        # `encoder1` and `encoder2` are of one type if they have the same fields.
        full = f"{owner}{words.rstrip('0123456789')}"
        if made.setdefault(full, text) != text:
            full = f"{owner}{words}"
            made[full] = text
        return f"{package}/{full}"

    return nested


def _names_of(
    tree: ast.AST, package: str, trees: Sequence[ast.AST], known_names: KnownNames
) -> dict[str, str]:
    """Return what names of a source stand for: `Pick` for `own_msgs.srv.Pick`."""
    names: dict[str, str] = {}
    starred: list[str] = []
    others: list[tuple[str, str]] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                if alias.name.split(".")[0] == package:
                    top = alias.asname or package
                    names[top] = alias.name if alias.asname else package
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            top, _, kind = node.module.partition(".")
            for alias in node.names:
                if alias.name == "*" and top == package:
                    starred.append(kind)
                elif alias.name == "*":
                    others.append((top, kind))
                elif top == package:
                    names[alias.asname or alias.name] = f"{node.module}.{alias.name}"
    if starred:
        elsewhere = {name for top, kind in others for name in known_names(top, kind)}
        for unbound in sorted(_unbound(tree, trees) - elsewhere):
            names[unbound] = f"{package}.{starred[0].split('.')[0]}.{unbound}"
    return names


def _unbound(tree: ast.AST, trees: Sequence[ast.AST]) -> set[str]:
    """Return the names in capitals that a source reads and no source binds."""
    read: set[str] = set()
    bound = set(dir(builtins))
    for node in ast.walk(tree):
        if isinstance(node, ast.Name):
            (read if isinstance(node.ctx, ast.Load) else bound).add(node.id)
    for other in trees:
        for node in ast.walk(other):
            if isinstance(node, ast.ClassDef | ast.FunctionDef):
                bound.add(node.name)
            elif isinstance(node, ast.Name) and not isinstance(node.ctx, ast.Load):
                bound.add(node.id)
            elif isinstance(node, ast.Import | ast.ImportFrom):
                bound |= {(alias.asname or alias.name).split(".")[0] for alias in node.names}
            elif isinstance(node, ast.arg):
                bound.add(node.arg)
    return {name for name in read - bound if name[:1].isupper()}


def _used_through(tree: ast.AST, names: Mapping[str, str]) -> set[str]:
    """Return the full names that a source reads as attributes: `own_msgs.msg.Thing`."""
    dotted = (dotted_name(node) for node in ast.walk(tree) if isinstance(node, ast.Attribute))
    return {_full(name, names) for name in dotted if name} - {""}


def _full(dotted: str, names: Mapping[str, str]) -> str:
    top, dot, rest = dotted.partition(".")
    return f"{names[top]}{dot}{rest}" if top in names else ""


def _interfaces(used: Collection[str], *, is_ros1: bool) -> dict[str, tuple[_Interface, str]]:
    """Return the interface and the part that each full name stands for; no part for the whole."""
    leaves: dict[str, tuple[str, str]] = {}
    for full in sorted(used):
        parts = full.split(".")
        # A generated module in between: `own_msgs.srv._Pick`.
        below = [part for part in parts[2:] if not part.startswith("_")]
        if len(parts) > 2 and parts[1] in _KINDS and below:
            leaves[".".join((*parts[:2], below[0]))] = parts[1], below[0]
    made: dict[tuple[str, str], _Interface] = {}
    table: dict[str, tuple[_Interface, str]] = {}
    everything = {leaf for _, leaf in leaves.values()}
    for full, (kind, leaf) in leaves.items():
        kind, name, part = _base(kind, leaf, everything) if is_ros1 else (kind, leaf, "")
        interface = made.setdefault((kind, name), _Interface(kind, name))
        table[full] = interface, part
    return table


def _base(kind: str, leaf: str, everything: Collection[str]) -> tuple[str, str, str]:
    """Return the kind, the name and the part of a class of ROS 1."""
    if kind == "srv":
        for part in _PARTS["srv"]:
            if leaf.endswith(part) and leaf != part:
                return "srv", leaf.removesuffix(part), part
    if kind == "msg":
        for part in _OF_ACTIONS:
            base = leaf.removesuffix(part)
            if base and base != leaf and f"{base}Action" in everything:
                return "action", base, part if part in _PARTS["action"] else ""
    return kind, leaf, ""


@dataclass(frozen=True, slots=True, eq=False)
class _Classes:
    """What expressions of one source mean that name classes of the package."""

    names: Mapping[str, str]
    """The full names of what is imported."""
    table: Mapping[str, tuple[_Interface, str]]
    """The interface and part of each full name."""

    def part(self, node: ast.expr, default: str = "") -> Shape | None:
        """Return the shape of what an expression makes, a part of a service or an action.

        `default` is the part that is meant where the expression names the whole.
        """
        full = _full(dotted_name(node), self.names)
        for cut in range(full.count(".") + 1):
            head = ".".join(full.split(".")[: full.count(".") + 1 - cut])
            if head in self.table:
                interface, part = self.table[head]
                within = full[len(head) + 1 :]
                part = within or part or default
                return interface.part(part) if part in _PARTS[interface.kind] else None
        return None
