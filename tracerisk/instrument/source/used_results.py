"""Whether a Python source uses what its calls return, by the names of what is called."""

from __future__ import annotations

import ast
from collections.abc import Mapping

from tracerisk.instrument.source.python_source import parsed


def changed_uses(before: Mapping[str, bytes], after: Mapping[str, bytes]) -> tuple[str, ...]:
    """Return of which calls in files of both versions more or fewer results are used.

    Names are left out whose result is used in all calls of both versions. Nothing is returned of a
    source that cannot be read.
    """
    texts = []
    for file in sorted(before.keys() & after.keys()):
        old, new = _calls(before[file]), _calls(after[file])
        for name in sorted(old.keys() & new.keys()):
            was, now = (sum(map(bool, lines[name])) for lines in (old, new))
            if was != now and 0 in (*old[name], *new[name]):
                place = f" ({file}:{min(filter(None, new[name]))})" if now else f" ({file})"
                texts.append(
                    f"the result of {name}() is used in {now} of {len(new[name])} calls{place}, "
                    f"before: in {was} of {len(old[name])}"
                )
    return tuple(texts)


def _calls(source: bytes) -> dict[str, list[int]]:
    """Return what is called, with a line for each call that uses the result, and 0 for others."""
    tree = parsed(source)
    if tree is None:
        return {}
    dropped = {id(_called(node.value)) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    lines: dict[str, list[int]] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name | ast.Attribute):
            line = 0 if id(node) in dropped else node.lineno
            lines.setdefault(ast.unparse(node.func), []).append(line)
    return lines


def _called(node: ast.expr) -> ast.expr:
    return node.value if isinstance(node, ast.Await) else node
