"""Changes of numbers: another unit, sign, size or place among its neighbours."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

import libcst as cst

from tracerisk.pipeline.mutation.change import ChangeKind, Draft, brief
from tracerisk.pipeline.mutation.source_tree import Walk, last_name, number_of

_OTHER_UNITS = ((1000.0, "as in mm"), (180.0 / math.pi, "as in degrees"))
_SCALES = (0.5, 0.9, 1.1, 2.0)
_FEW, _MANY = 10, 10_000
"""A number between these is taken for one of mm or degrees, a smaller one for one of m or rad."""
_NO_QUANTITIES = frozenset({"queue_size", "latch", "depth"})
_AXES = ("x", "y", "z")


def number_changes(node: cst.CSTNode, walk: Walk) -> Iterator[Draft]:
    """Yield the changes of a number by unit, sign and scale; of an index, those by slot."""
    value, above = number_of(node), walk.parent
    if value is None or (isinstance(above, cst.UnaryOperation) and number_of(above) is not None):
        return
    keyword = above.keyword if isinstance(above, cst.Arg) else None
    if keyword is not None and keyword.value in _NO_QUANTITIES:
        return
    if isinstance(above, cst.Index):
        if isinstance(value, int) and value >= 0:
            for other in (value + 1, value - 1):
                if other >= 0:
                    yield walk.tree.replaced(node, str(other), "slot")
        return
    if value == 0:
        return
    is_count = isinstance(value, int) and _is_of_range(walk)
    if not is_count:
        yield walk.tree.replaced(node, _written(-value, value), "sign")
        if abs(value) < _MANY and (isinstance(value, float) or abs(value) >= _FEW):
            yield from _in_other_units(node, value, walk)
    sizes: list[float] = [value * scale for scale in _SCALES]
    if isinstance(value, int):
        sizes = [value - 1, value + 1]
    for size in sizes:
        yield walk.tree.replaced(node, _written(size, value), "scale")


def _in_other_units(node: cst.CSTNode, value: float, walk: Walk) -> Iterator[Draft]:
    code = walk.tree.code(node)
    for factor, words in _OTHER_UNITS:
        is_large = abs(value) >= _FEW
        new = _written(value / factor if is_large else value * factor, 1.0)
        unit = {"as in mm": "as in m", "as in degrees": "as in rad"}[words] if is_large else words
        yield walk.tree.replaced(node, new, "unit", f"{code} becomes {new}, {unit}")


def _is_of_range(walk: Walk) -> bool:
    calls = [node for node in walk.above[-2:] if isinstance(node, cst.Call)]
    return any(last_name(call.func) == "range" for call in calls)


def _written(value: float, like: float) -> str:
    """Return a number as a source has it: a whole one where `like` is one."""
    if isinstance(like, int):
        return str(round(value))
    return repr(float(f"{value:.6g}"))


def order_changes(node: cst.CSTNode, walk: Walk) -> Iterator[Draft]:
    """Yield the changes by slot: neighbours that are numbers change places."""
    neighbours: Sequence[cst.CSTNode] = ()
    if isinstance(node, cst.List | cst.Tuple):
        neighbours = [element.value for element in node.elements]
    elif isinstance(node, cst.Call):
        neighbours = [
            argument.value
            for argument in node.args
            if argument.keyword is None and not argument.star
        ]
    for one, other in pairwise(neighbours):
        values = number_of(one), number_of(other)
        if None not in values and values[0] != values[1]:
            yield exchanged(one, other, "slot", walk)


def exchanged(one: cst.CSTNode, other: cst.CSTNode, kind: ChangeKind, walk: Walk) -> Draft:
    """Return the draft by which two nodes change places, the first of which stands before."""
    tree = walk.tree
    (start, end), (begin, last) = tree.span(one), tree.span(other)
    first, second = tree.code(one), tree.code(other)
    words = f"{brief(first)} and {brief(second)} change places"
    return Draft(start, last, f"{second}{tree.between(end, begin)}{first}", kind, words)


def axis_changes(node: cst.CSTNode, walk: Walk) -> Iterator[Draft]:
    """Yield the changes by slot of what is assigned to an axis: `pose.position.x = 0.3`."""
    if isinstance(node, cst.AssignTarget) and isinstance(node.target, cst.Attribute):
        name = node.target.attr.value
        if name in _AXES:
            other = _AXES[(_AXES.index(name) + 1) % len(_AXES)]
            words = f"{brief(walk.tree.code(node.target))} is assigned as .{other}"
            yield walk.tree.replaced(node.target.attr, other, "slot", words)
