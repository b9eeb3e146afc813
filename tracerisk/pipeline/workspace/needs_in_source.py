"""What a controller's source asks its world for, as far as it can be read without running it."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

from tracerisk.errors import Location, TraceRiskError
from tracerisk.pipeline.workspace.argument_files import fitting_files, is_read
from tracerisk.pipeline.workspace.controller import Controller, from_root
from tracerisk.pipeline.workspace.own_modules import own_modules, source_bytes
from tracerisk.pipeline.workspace.provided import NAMES_OF_ACTION, OF_ACTION, Signature, named_calls
from tracerisk.pipeline.workspace.workspace import project_top
from tracerisk.ros.controller.needs import Missed, Need
from tracerisk.source.dotted_names import last_name
from tracerisk.source.python_source import parsed
from tracerisk.source.ros_version import ros_version
from tracerisk.trace import RunEnd

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
_OF_ARGUMENTS = re.compile(r"arg")
_ARGV = re.compile(rb"\b(argv\[|add_argument\b)")
_LEFT_OUT = frozenset({"action", "frame"})  # which the twin often gives
_PART = 2  # arguments of which the second is a default


def asked_in_source(controller: Controller) -> tuple[Missed, ...]:
    """Return what the script and its own modules ask for; a name put together is an expression.

    Parameters with a default of their own are left out. Places are from the controller's root.
    """
    root = controller.root.resolve()
    ros = ros_version(controller.path.resolve(), root)
    found: dict[tuple[str, str, str], Missed] = {}
    for path in (controller.path.resolve(), *own_modules(controller)):
        file = from_root(root, path)
        for each in asked_in_file(path, ros):
            need, place = each.need, each.location
            if place is not None:
                place = Location(file, place.line)
            line = str(place) if need.name.startswith("(") else ""
            first = found.setdefault((need.kind, need.name, line), replace(each, location=place))
            if not first.need.type_name and need.type_name:
                # Waited for by its name alone, before a client of a type is made.
                found[need.kind, need.name, line] = replace(first, need=need)
    return tuple(found.values())


def asked_in_file(path: Path, ros: Literal[1, 2]) -> Iterator[Missed]:
    """Yield what one source asks for, in the order of its lines, as `asked_in_source` does."""
    tree = parsed(source_bytes(path))
    if tree is None:
        return
    types = dict(_types(tree))
    signatures = {**_SIGNATURES[ros], **_BOTH}
    calls = sorted(named_calls(tree, signatures), key=lambda each: each[3].lineno)
    for kind, name, type_name, call in calls:
        if kind == "parameter" and _has_default(call):
            continue
        shown = repr(name) if kind == "input" and name else name or _expression(call, signatures)
        kept = types.get(type_name, type_name)
        if ros == 1 and kind in ("action", "goal"):
            kept = kept.removesuffix("Action")
        yield Missed(Need(kind, shown, kept), 0, 0, Location(str(path), call.lineno))


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
    return any(each.arg in _DEFAULTS.get(name, ()) for each in call.keywords)


@dataclass(frozen=True, slots=True)
class CommandLine:
    """Arguments with which a controller may be started, and where they are from."""

    words: tuple[str, ...]
    remark: str


def may_lack(controller: Controller) -> bool:
    """Return whether a script asks for something by name that somebody else has to give it."""
    script = controller.path.resolve()
    ros = ros_version(script, controller.root.resolve())
    return _ARGV.search(controller.source) is not None or any(
        each.need.kind not in _LEFT_OUT for each in asked_in_file(script, ros)
    )


def reads_arguments(controller: Controller, end: RunEnd) -> bool:
    """Return whether a run was ended by an exception at a line that reads the command line."""
    place = end.location
    if end.cause != "raised" or place is None or place.line is None:
        return False
    if not place.file.endswith(".py"):
        return False
    try:
        lines = controller.source_of(place.file).decode(errors="replace").splitlines()
    except TraceRiskError:
        return False
    return any(_OF_ARGUMENTS.search(line) for line in lines[place.line - 1 : place.line])


def command_lines(controller: Controller, written: Iterable[tuple[tuple[str, ...], str]] = ()) -> (
    tuple[CommandLine, ...]
):  # fmt: skip
    """Return command lines that the source takes, the likeliest first.

    Those that the repository writes (`written`, each with its place), then what `argparse` demands,
    a file to read being one of the repository's that fits, then this with each of its switches,
    then the words with which `sys.argv` is compared.
    """
    found = [CommandLine(words, f"as in {place}") for words, place in written]
    for path in (controller.path.resolve(), *own_modules(controller)):
        tree = parsed(source_bytes(path))
        if tree is not None:
            found += _of_argparse(tree, project_top(controller.root))
            found += _of_argv(tree)
    return tuple({each.words: each for each in reversed(found) if each.words}.values())[::-1]


def _of_argparse(tree: ast.AST, top: Path) -> Iterator[CommandLine]:
    options = [
        _Option.read(node)
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and last_name(node.func) in ("add_argument", "option")
    ]
    needed = [word for each in options if each.is_needed for word in each.words]
    # Of a group of which one must be given, the first.
    groups = _required_groups(tree)
    for each in options:
        if each.owner in groups and not each.is_needed:
            groups.discard(each.owner)
            needed += each.words
    read = {word for each in options if each.is_file for word in each.words[-1:]} & {*needed}
    if read:
        files = fitting_files(tree, top)
        for file in files:
            words = tuple(file if each in read else each for each in needed)
            yield CommandLine(words, "what argparse demands, with a file of the repository")
        if not files:
            remark = (
                f"a file of yours has to stand for {' and '.join(sorted(read))}: none here fits"
            )
            yield CommandLine(tuple(needed), f"what argparse demands; {remark}")
        needed = [files[0] if files and each in read else each for each in needed]
    elif needed:
        yield CommandLine(tuple(needed), "what argparse demands")
    for each in options:
        if not each.is_needed and each.is_switch and each.words[0] not in needed:
            yield CommandLine((*needed, *each.words), f"with the switch {each.words[0]}")


@dataclass(frozen=True, slots=True)
class _Option:
    words: tuple[str, ...]
    owner: str
    is_needed: bool
    is_switch: bool
    is_file: bool

    @classmethod
    def read(cls, call: ast.Call) -> _Option:
        names = [str(each.value) for each in call.args if isinstance(each, ast.Constant)]
        given = {each.arg: each.value for each in call.keywords}
        flags = [each for each in names if each.startswith("-")]
        is_switch = _value(given.get("action")) in ("store_true", "store_const", "count")
        count = _value(given.get("nargs"))
        value = _argument_value(names, given)
        repeat = count if isinstance(count, int) and not isinstance(count, bool) else 1
        values = () if is_switch else tuple([value] * max(repeat, 1))
        flag = max(flags, key=len, default=None)
        words = values if flag is None else (flag, *values)
        needed = _value(given.get("required")) is True if flags else count not in ("?", "*")
        has_default = "default" in given and not flags
        owner = ast.unparse(call.func.value) if isinstance(call.func, ast.Attribute) else ""
        metavar = _value(given.get("metavar"))
        called = [*names, metavar] if isinstance(metavar, str) else names
        kind = given.get("type")
        kind = kind.func if isinstance(kind, ast.Call) else kind
        # The caller needs no file where there is a default or a list of choices.
        is_file = is_read(called, "" if kind is None else last_name(kind)) and value == (
            names[-1].strip("-") if names else ""
        )
        is_needed = bool(needed and names and not has_default)
        return cls(words, owner, is_needed, is_switch, is_file and not is_switch)


def _argument_value(names: list[str], given: dict[str | None, ast.expr]) -> str:
    choices = _value(given.get("choices"))
    if isinstance(choices, list | tuple) and choices:
        return str(choices[0])
    default = _value(given.get("default"))
    if default is not None and not isinstance(default, bool | list | tuple | dict):
        return str(default)
    kind = last_name(given["type"]) if "type" in given else "str"
    return {"int": "1", "float": "0.1", "bool": "true"}.get(kind) or names[-1].strip("-")


def _required_groups(tree: ast.AST) -> set[str]:
    return {
        ast.unparse(target)
        for node in ast.walk(tree)
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Call)
        if last_name(node.value.func) == "add_mutually_exclusive_group"
        if any(k.arg == "required" and _value(k.value) is True for k in node.value.keywords)
        for target in node.targets
    }


def _of_argv(tree: ast.AST) -> Iterator[CommandLine]:
    """Yield command lines of a source that reads `sys.argv` itself."""
    indices = set()
    literals: dict[int, list[str]] = {}
    names: dict[str, int] = {}
    for node in ast.walk(tree):
        index = _argv_index(node)
        if index:
            indices.add(index)
        if isinstance(node, ast.Assign) and (index := _argv_index(node.value)):
            names |= {ast.unparse(each): index for each in node.targets}
    for node in ast.walk(tree):
        if isinstance(node, ast.Compare) and isinstance(node.ops[0], ast.Eq | ast.In):
            index = _argv_index(node.left) or names.get(ast.unparse(node.left), 0)
            value = _value(node.comparators[0])
            values = value if isinstance(value, list | tuple) else [value]
            if index:
                literals.setdefault(index, []).extend(str(v) for v in values if v is not None)
    if not indices:
        return
    first = literals.get(1) or ["1"]
    for word in dict.fromkeys(first):
        rest = [(literals.get(each) or ["1"])[0] for each in range(2, max(indices) + 1)]
        remark = "as the code compares sys.argv" if literals else "as many words as the code reads"
        yield CommandLine((word, *rest), remark)


def _argv_index(node: ast.AST) -> int:
    while isinstance(node, ast.Call) and len(node.args) == 1:
        node = node.args[0]
    if isinstance(node, ast.Subscript) and ast.unparse(node.value) in ("sys.argv", "argv"):
        index = _value(node.slice)
        return index if isinstance(index, int) and index > 0 else 0
    return 0


def _value(node: ast.expr | None) -> Any:
    if node is None:
        return None
    try:
        return ast.literal_eval(node)
    except (ValueError, TypeError, SyntaxError, RecursionError):
        return None
