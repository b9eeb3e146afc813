"""What the source of a node provides to others, by literal names: services, topics, actions, ..."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

from tracerisk.instrument.source.dotted_names import last_name
from tracerisk.instrument.source.python_source import texts_in
from tracerisk.ros.controller.needs import Need, NeedKind


@dataclass(frozen=True, slots=True)
class Signature:
    """Where a call has the name and the type of a thing."""

    kind: NeedKind
    """The kind of the thing."""
    name: int
    """The position of the name among the arguments."""
    type: int | None
    """The position of the type among the arguments; `None` where it has none."""
    names: tuple[str, ...] = ("name",)
    """The keywords of the name."""
    types: tuple[str, ...] = ()
    """The keywords of the type."""


OF_ACTION = ("ActionSpec", "action_type")
NAMES_OF_ACTION = ("name", "ns", "action_name")
SIGNATURES: dict[int, dict[str, Signature]] = {
    1: {
        "Service": Signature("service", 0, 1, types=("service_class",)),
        "ServiceProxy": Signature("call", 0, 1, types=("service_class",)),
        "Publisher": Signature("topic", 0, 1, types=("data_class",)),
        "SimpleActionServer": Signature("action", 0, 1, NAMES_OF_ACTION, OF_ACTION),
        "ActionServer": Signature("action", 0, 1, NAMES_OF_ACTION, OF_ACTION),
        "SimpleActionClient": Signature("goal", 0, 1, NAMES_OF_ACTION, OF_ACTION),
        "ActionClient": Signature("goal", 0, 1, NAMES_OF_ACTION, OF_ACTION),
        "set_param": Signature("parameter", 0, None, ("param_name",)),
    },
    2: {
        "create_service": Signature("service", 1, 0, ("srv_name",), ("srv_type",)),
        "create_client": Signature("call", 1, 0, ("srv_name",), ("srv_type",)),
        "create_publisher": Signature("topic", 1, 0, ("topic",), ("msg_type",)),
        "ActionServer": Signature("action", 2, 1, NAMES_OF_ACTION, OF_ACTION),
        "ActionClient": Signature("goal", 2, 1, NAMES_OF_ACTION, OF_ACTION),
    },
}
_VALUES = frozenset({"value", "string_value"})
_BROADCASTS = frozenset(
    {"TransformBroadcaster", "StaticTransformBroadcaster", "sendTransform", "sendTransformMessage"}
)


@dataclass(frozen=True, slots=True)
class Provided:
    """What a source provides."""

    offers: frozenset[tuple[NeedKind, str, str]]
    """Kind, name as written, and last name of the type (or empty) of each thing."""
    frames: frozenset[str]
    """The strings of a source that broadcasts transforms, as frames; else empty."""

    def meets(self, need: Need) -> bool:
        """Return whether it provides what is needed, under that name and of that type."""
        if need.kind == "frame":
            return need.name.strip("/") in self.frames
        return any(
            kind == need.kind and _names(name, need.name) and _agree(type_name, need.type_name)
            for kind, name, type_name in self.offers
        )


def provided_by(tree: ast.Module, ros: Literal[1, 2]) -> Provided:
    """Return what a source of one ROS provides; names that it puts together are not known."""
    offers = {
        (kind, name, type_name)
        for kind, name, type_name, _ in named_calls(tree, SIGNATURES[ros])
        if name
    }
    frames: set[str] = set()
    called = {last_name(node.func) for node in ast.walk(tree) if isinstance(node, ast.Call)}
    if called & _BROADCASTS:
        frames = {text.strip("/") for text in texts_in(tree)}
    return Provided(frozenset(offers), frozenset(frames - {""}))


def named_calls(
    tree: ast.Module, signatures: Mapping[str, Signature]
) -> Iterator[tuple[NeedKind, str, str, ast.Call]]:
    """Yield what calls of these functions are about: kind, name, last name of the type, the call.

    A name that the source puts together is empty.
    """
    texts, declared = _constants(tree), _declared(tree)
    for node in ast.walk(tree):
        signature = signatures.get(last_name(node.func)) if isinstance(node, ast.Call) else None
        if signature is None or not isinstance(node, ast.Call):
            continue
        name = _text(_argument(node, signature.name, signature.names), texts, declared)
        position = signature.type
        kind = None if position is None else _argument(node, position, signature.types)
        yield signature.kind, name, "" if kind is None else last_name(kind), node


def _argument(call: ast.Call, position: int, keywords: tuple[str, ...]) -> ast.expr | None:
    for keyword in call.keywords:
        if keyword.arg in keywords:
            return keyword.value
    if position < len(call.args) and not any(isinstance(a, ast.Starred) for a in call.args):
        return call.args[position]
    return None


def _constants(tree: ast.Module) -> dict[str, str]:
    """Return the names, also of attributes, that are given one text and never anything else."""
    declared = _declared(tree)
    given: dict[str, set[str]] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign):
            targets, value = node.targets, node.value
        elif isinstance(node, ast.AnnAssign) and node.value is not None:
            targets, value = [node.target], node.value
        else:
            continue
        for target in targets:
            given.setdefault(last_name(target), set()).add(_literal(value, declared))
    return {
        name: next(iter(texts))
        for name, texts in given.items()
        if name and len(texts) == 1 and "" not in texts
    }


def _declared(tree: ast.Module) -> dict[str, str]:
    """Return the parameters of a node of ROS 2 whose default is a text."""
    declared: dict[str, str] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and last_name(node.func) == "declare_parameter":
            name, default = (_constant(argument) for argument in (*node.args, None, None)[:2])
            if name and default:
                declared[name] = default
    return declared


def _literal(node: ast.expr, declared: dict[str, str]) -> str:
    """Return the text that an expression is, a parameter's default included; empty for none."""
    text = _constant(node)
    if text or not isinstance(node, ast.Call | ast.Attribute):
        return text
    if isinstance(node, ast.Attribute):
        # `self.get_parameter("topic").value`, or `.get_parameter_value().string_value`.
        return _literal(node.value, declared) if node.attr in _VALUES else ""
    if last_name(node.func) in ("get_param", "declare_parameter") and len(node.args) > 1:
        return _constant(node.args[1])
    if last_name(node.func) == "get_parameter" and node.args:
        return declared.get(_constant(node.args[0]), "")
    if last_name(node.func) == "get_parameter_value" and isinstance(node.func, ast.Attribute):
        return _literal(node.func.value, declared)
    return ""


def _constant(node: ast.expr | None) -> str:
    is_text = isinstance(node, ast.Constant) and isinstance(node.value, str)
    return str(node.value) if is_text and isinstance(node, ast.Constant) else ""


def _text(node: ast.expr | None, texts: dict[str, str], declared: dict[str, str]) -> str:
    if node is None:
        return ""
    return _literal(node, declared) or texts.get(last_name(node), "")


def _names(written: str, full: str) -> bool:
    """Return whether a name as written in a source may be the full name of what is needed."""
    if written.startswith("/"):
        return written == full
    relative = written.lstrip("~").strip("/")
    return bool(relative) and f"/{full.strip('/')}".endswith(f"/{relative}")


def _agree(written: str, needed: str) -> bool:
    wanted = needed.rpartition("/")[2]
    return not written or not wanted or written in (wanted, f"{wanted}Action")
