"""Which calls look as if they command, where a run has shown none that does."""

from __future__ import annotations

import ast
import re
from collections.abc import Collection, Iterable, Iterator

from tracerisk.instrument.motion_calls import is_like_command
from tracerisk.instrument.source.dotted_names import dotted_name
from tracerisk.instrument.source.python_source import parsed
from tracerisk.pipeline.workspace.provided import SIGNATURES, named_calls
from tracerisk.ros.drafts.commanding_messages import commands_something

_SENDING = frozenset({"publish", "call", "call_async"})
"""Last names of calls whose meaning lies in the type of what they send."""
_ONLY_SAYS = re.compile(r"publish_feedback|sendTransform|send_transform|set_(succeeded|aborted)")
_ONLY_ASKS = re.compile(r"^(Get|List|Query|Check|Describe|Compute)(?![a-z])|PlanningScene")
_OF_ROS = frozenset({"std_msgs", "geometry_msgs", "sensor_msgs", "moveit_msgs"})


def like_commands(called: Collection[str], sources: Iterable[bytes]) -> frozenset[str]:
    """Return those of the names `called` that functions have which command hardware.

    A call that sends a message or request counts by the type of its publisher or client in the
    sources: markers, transforms, states and edits of the planning scene move nothing.
    """
    declared = [pair for source in sources for pair in _declared(source)]
    moving = {name for name, moves in declared if moves}
    saying = {name for name, moves in declared if not moves} - moving
    names = {name for name in called if is_like_command(name) and not _ONLY_SAYS.search(name)}
    for name in list(names):
        owner, _, last = name.rpartition(".")
        if last in _SENDING and owner in saying:
            names.discard(name)
    # The last name alone stands for calls of what has no plain name; who declares all, has none.
    written = {name.rpartition(".")[2] for name in called if "." in name}
    return frozenset(name for name in names if name not in _SENDING & written)


def _declared(source: bytes) -> Iterator[tuple[str, bool]]:
    """Yield the publishers and clients of a source by name, and whether they command something."""
    tree = parsed(source)
    if tree is None:
        return
    packages = {
        alias.asname or alias.name: (node.module.partition(".")[0], alias.name)
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and node.module
        for alias in node.names
    }
    targets: dict[ast.expr, str] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign) and len(node.targets) == 1:
            targets[node.value] = dotted_name(node.targets[0])
        elif isinstance(node, ast.AnnAssign) and node.value is not None:
            targets[node.value] = dotted_name(node.target)
    for signatures in SIGNATURES.values():
        for kind, name, type_name, call in named_calls(tree, signatures):
            if (target := targets.get(call)) and kind in ("topic", "call"):
                package, short = packages.get(type_name, ("", type_name))
                moves = not _ONLY_ASKS.search(short) if kind == "call" else None
                yield target, _moves(name, package, short) if moves is None else moves


def _moves(topic: str, package: str, short: str) -> bool:
    if not package:
        return True
    # A topic whose name is put together, and a message of the workspace, may command anything.
    name = f"/command/{topic.strip('/')}" if topic and package not in _OF_ROS else topic
    return commands_something(name or "/command", f"{package}/{short}", None)
