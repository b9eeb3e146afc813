"""Changes of the way through a program: shorter loops and conditions that are turned round."""

from __future__ import annotations

from collections.abc import Iterator

import libcst as cst

from tracerisk.pipeline.mutation.change import Draft, brief
from tracerisk.pipeline.mutation.changed_calls import is_wait_option
from tracerisk.pipeline.mutation.source_tree import Walk, last_name

_FINITE = frozenset(
    {"enumerate", "zip", "sorted", "reversed", "list", "tuple", "items", "keys", "values"}
)
"""Calls that give a list as well as they are gone through: nothing runs between two of its items.
"""
_TURNED = {"True": "False", "False": "True"}
_PLAIN = (cst.Name, cst.Attribute, cst.Call, cst.Subscript)


def loop_changes(node: cst.CSTNode, walk: Walk) -> Iterator[Draft]:
    """Yield the changes by which a loop leaves out its last item, or never begins."""
    tree = walk.tree
    if isinstance(node, cst.While):
        words = f"the loop 'while {brief(tree.code(node.test))}' never begins"
        yield tree.replaced(node.test, "False", "loop-shortened", words)
        return
    if not isinstance(node, cst.For | cst.CompFor) or node.asynchronous is not None:
        return
    shorter = _without_last(node.iter, walk)
    if shorter is not None:
        words = f"the loop over {brief(tree.code(node.iter))} leaves out the last"
        yield tree.replaced(node.iter, shorter, "loop-shortened", words)


def _without_last(items: cst.BaseExpression, walk: Walk) -> str | None:
    """Return what gives all but the last of some items; `None` where nobody knows them before."""
    code = walk.tree.code(items)
    if isinstance(items, cst.Tuple) and not items.lpar:
        return f"({code})[:-1]"
    if isinstance(items, cst.List | cst.Tuple):
        return f"{code}[:-1]"
    if isinstance(items, cst.Call):
        name = last_name(items.func)
        if name == "range":
            return f"{code}[:-1]"
        return f"list({code})[:-1]" if name in _FINITE else None
    if isinstance(items, cst.Name | cst.Attribute | cst.Subscript):
        return f"list({code})[:-1]"
    return None


def condition_changes(node: cst.CSTNode, walk: Walk) -> Iterator[Draft]:
    """Yield the change by which a condition is turned round, or a flag."""
    tree = walk.tree
    if isinstance(node, cst.If | cst.IfExp | cst.CompIf | cst.Assert):
        test = node.test
        if isinstance(test, cst.UnaryOperation) and isinstance(test.operator, cst.Not):
            turned = tree.whole(test.expression)
        else:
            code = tree.code(test)
            turned = f"not {code}" if isinstance(test, _PLAIN) else f"not ({code})"
        words = f"the condition '{brief(tree.code(test))}' is turned round"
        yield tree.replaced(test, turned, "condition-turned", words)
        return
    flag = _flag(node)
    if flag is not None:
        words = f"{brief(tree.code(node))} becomes {_TURNED[flag.value]}"
        yield tree.replaced(flag, _TURNED[flag.value], "condition-turned", words)


def _flag(node: cst.CSTNode) -> cst.Name | None:
    """Return the `True` or `False` that a node passes, assigns or returns."""
    if isinstance(node, cst.Arg) and is_wait_option(node):
        return None
    value = node.value if isinstance(node, cst.Arg | cst.Assign | cst.Return) else None
    return value if isinstance(value, cst.Name) and value.value in _TURNED else None
