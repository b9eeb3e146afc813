"""What a controller's source asks its world for, as far as it can be read without running it."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Literal

from tracerisk.errors import Location
from tracerisk.instrument.source.dotted_names import last_name
from tracerisk.instrument.source.service_types import starred_type
from tracerisk.pipeline.workspace.controller import Controller, from_root
from tracerisk.pipeline.workspace.own_modules import own_modules, source_bytes
from tracerisk.pipeline.workspace.project import Project
from tracerisk.pipeline.workspace.provided import NAMES_OF_ACTION, OF_ACTION, Signature, named_calls
from tracerisk.ros.controller.needs import Missed, Need

_SIGNATURES: dict[int, dict[str, Signature]] = {
    1: {
        "Subscriber": Signature("topic", 0, 1, types=("data_class",)),
        "wait_for_message": Signature("topic", 0, 1, ("topic",), ("topic_type",)),
        "ServiceProxy": Signature("service", 0, 1, types=("service_class",)),
        "wait_for_service": Signature("service", 0, None, ("service",)),
        "SimpleActionClient": Signature("action", 0, 1, NAMES_OF_ACTION, OF_ACTION),
        "ActionClient": Signature("action", 0, 1, NAMES_OF_ACTION, OF_ACTION),
        "Service": Signature("call", 0, 1, types=("service_class",)),
        "SimpleActionServer": Signature("goal", 0, 1, NAMES_OF_ACTION, OF_ACTION),
        "ActionServer": Signature("goal", 0, 1, NAMES_OF_ACTION, OF_ACTION),
        "get_param": Signature("parameter", 0, None, ("param_name",)),
    },
    2: {
        "create_subscription": Signature("topic", 1, 0, ("topic",), ("msg_type",)),
        "create_client": Signature("service", 1, 0, ("srv_name",), ("srv_type",)),
        "ActionClient": Signature("action", 2, 1, NAMES_OF_ACTION, OF_ACTION),
        "create_service": Signature("call", 1, 0, ("srv_name",), ("srv_type",)),
        "ActionServer": Signature("goal", 2, 1, NAMES_OF_ACTION, OF_ACTION),
        "declare_parameter": Signature("parameter", 0, None),
    },
}
_BOTH = {
    "lookup_transform": Signature("frame", 1, None, ("source_frame",)),
    "lookupTransform": Signature("frame", 1, None, ("source_frame",)),
    "input": Signature("input", 0, None, ("prompt",)),
}
_DEFAULTS = {"get_param": ("default",), "declare_parameter": ("value", "descriptor")}
_LONGEST = 60  # of an expression that is shown for a name
_ARGV = re.compile(rb"\b(argv\[|add_argument\b)")
_LEFT_OUT = frozenset({"action", "frame"})  # which the twin often gives
_PART = 2  # arguments of which the second is a default


def asked_in_source(controller: Controller) -> tuple[Missed, ...]:
    """Return what the script and its own modules ask for; a name put together is an expression.

    Parameters with a default of their own are left out. Places are from the controller's root.
    """
    root, ros = controller.root.resolve(), controller.ros_version
    asked: dict[tuple[str, str, str], Missed] = {}
    for path in (controller.path.resolve(), *own_modules(controller)):
        file = from_root(root, path)
        for missed in asked_in_file(path, ros, controller.project):
            need, place = missed.need, missed.location
            if place is not None:
                place = Location(file, place.line)
            line = str(place) if need.name.startswith("(") else ""
            first = asked.setdefault((need.kind, need.name, line), replace(missed, location=place))
            if not first.need.type_name and need.type_name:
                # Waited for by its name alone, before a client of a type is made.
                asked[need.kind, need.name, line] = replace(first, need=need)
    return tuple(asked.values())


def asked_in_file(path: Path, ros: Literal[1, 2], project: Project) -> Iterator[Missed]:
    """Yield what one source asks for, in the order of its lines, as `asked_in_source` does."""
    tree = project.tree(source_bytes(path))
    if tree is None:
        return
    types = dict(_types(tree))
    signatures = {**_SIGNATURES[ros], **_BOTH}
    calls = sorted(named_calls(tree, signatures), key=lambda row: row[3].lineno)
    for kind, name, type_name, call in calls:
        if kind == "parameter" and _has_default(call):
            continue
        shown = repr(name) if kind == "input" and name else name or _expression(call, signatures)
        kept = types.get(type_name) or _starred(tree, kind, type_name, ros)
        if kind == "parameter":
            kept = _declared_type(call)
        if ros == 1 and kind in ("action", "goal"):
            kept = kept.removesuffix("Action")
        yield Missed(Need(kind, shown, kept), 0, 0, Location(str(path), call.lineno))


def _starred(tree: ast.Module, kind: str, name: str, ros: Literal[1, 2]) -> str:
    """Return the type of a name that `from package.srv import *` brings, else the name alone."""
    of_actions = "msg" if ros == 1 else "action"
    folder = {"topic": "msg", "service": "srv", "call": "srv"}.get(kind, of_actions)
    return starred_type(tree, folder, name) or name


def _declared_type(call: ast.Call) -> str:
    """Return the type that a parameter is declared with: `double_array`; empty for none."""
    text = ast.unparse(call.args[1]) if len(call.args) >= _PART else ""
    return text.rpartition(".Type.")[2].lower() if ".Type." in text else ""


def _types(tree: ast.Module) -> Iterator[tuple[str, str]]:
    """Yield the names under which interfaces are imported, each with its type: `pkg/Name`."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module:
            package, _, kind = node.module.partition(".")
            if kind.split(".")[0] in ("msg", "srv", "action"):
                for alias in node.names:
                    yield alias.asname or alias.name, f"{package}/{alias.name}"


def _expression(call: ast.Call, signatures: Mapping[str, Signature]) -> str:
    """Return the expression that stands where a name would, in brackets."""
    position = signatures[last_name(call.func)].name
    if position >= len(call.args):
        return "(no name)" if last_name(call.func) != "input" else "(no prompt)"
    text = ast.unparse(call.args[position])
    return f"({text if len(text) <= _LONGEST else text[: _LONGEST - 3] + '...'})"


def _has_default(call: ast.Call) -> bool:
    name = call.func.attr if isinstance(call.func, ast.Attribute) else ""
    if len(call.args) >= _PART:
        # `declare_parameter("x", Parameter.Type.DOUBLE)` says its type alone.
        return ".Type." not in ast.unparse(call.args[1])
    return any(keyword.arg in _DEFAULTS.get(name, ()) for keyword in call.keywords)


def may_lack(controller: Controller) -> bool:
    """Return whether a script asks for something by name that somebody else has to give it."""
    script, ros = controller.path.resolve(), controller.ros_version
    return _ARGV.search(controller.source) is not None or any(
        missed.need.kind not in _LEFT_OUT
        for missed in asked_in_file(script, ros, controller.project)
    )


def reads_command_line(script: Path) -> bool:
    """Return whether a script may read its command line itself."""
    return _ARGV.search(source_bytes(script)) is not None
