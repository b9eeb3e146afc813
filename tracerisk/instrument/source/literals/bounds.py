"""Numbers within the bounds that a source checks, and the lengths of lists that it asks for.

For `if not 0.1 < width < 0.5: return` a width that passes is 0.3; of `if len(poses) < 2: return`
the list has 2 items.
"""

from __future__ import annotations

import ast
import math
import re
from collections.abc import Iterator, Sequence
from typing import Any

from tracerisk.instrument.source.dotted_names import dotted_name, last_name
from tracerisk.instrument.source.literals.comparisons import is_number
from tracerisk.instrument.source.literals.named_literals import literal_value

LENGTH = "len()"
"""The last part of the path of a list's length."""
LEAST = "least len()"
"""The last part of the path of the length that a list must have at least."""
ROWS = "rows of"
"""The last part of the path of a list that is taken as rows, with the length of a row."""
_SIDES: dict[type[ast.cmpop], int] = {ast.Lt: -1, ast.LtE: -1, ast.Gt: +1, ast.GtE: +1}
_SAYS = re.compile(
    r"log|info|warn|error|debug|print|fatal|abort|cancel|succeed|reject", re.IGNORECASE
)
_REPLIES = frozenset({"success", "message", "msg", "result", "status", "error", "error_code"})


def turns_away(body: Sequence[ast.stmt]) -> bool:
    """Return whether a branch only says something and leaves: what takes it is not processed."""
    *others, last = body
    return isinstance(last, ast.Return | ast.Raise | ast.Continue) and all(map(_says, others))


def _says(line: ast.stmt) -> bool:
    if isinstance(line, ast.Assign):
        names = [dotted_name(target).rpartition(".")[2] for target in line.targets]
        return set(names) <= _REPLIES
    call = line.value if isinstance(line, ast.Expr) else None
    return isinstance(call, ast.Call) and _SAYS.search(last_name(call.func)) is not None


def refused_tests(tree: ast.AST) -> Iterator[tuple[ast.expr, bool]]:
    """Yield each test of a tree and whether the source goes on where it does not hold."""
    for node in ast.walk(tree):
        if isinstance(node, ast.If):
            yield node.test, not node.orelse and turns_away(node.body)
        elif isinstance(node, ast.Assert | ast.IfExp | ast.While):
            yield node.test, False


def bounds(test: ast.expr, *, is_refused: bool) -> Iterator[tuple[ast.expr, float | None, Any]]:
    """Yield what a test keeps within bounds [low, high] where it goes on; None for no bound.

    Of several comparisons only those that must hold at the same time are joined.
    """
    kept: dict[str, tuple[ast.expr, float | None, float | None]] = {}
    for subject, side, value in _sides(test, is_refused):
        key = ast.dump(subject)
        _, low, high = kept.get(key, (subject, None, None))
        if side > 0:
            low = value if low is None else max(low, value)
        else:
            high = value if high is None else min(high, value)
        kept[key] = subject, low, high
    yield from kept.values()


def _sides(test: ast.expr, is_refused: bool) -> Iterator[tuple[ast.expr, int, float]]:
    """Yield each subject, +1 where it is above and -1 where it is below, and the number."""
    if isinstance(test, ast.UnaryOp) and isinstance(test.op, ast.Not):
        yield from _sides(test.operand, not is_refused)
    elif isinstance(test, ast.BoolOp):
        # All of `a and b` hold; none of `a or b` where that is refused.
        if isinstance(test.op, ast.Or) is is_refused:
            for part in test.values:
                yield from _sides(part, is_refused)
    elif isinstance(test, ast.Compare) and (len(test.ops) == 1 or not is_refused):
        terms = [test.left, *test.comparators]
        for left, operator, right in zip(terms, test.ops, terms[1:], strict=False):
            side = _SIDES.get(type(operator), 0) * (-1 if is_refused else 1)
            if side and (value := _number(right)) is not None:
                yield left, side, value
            elif side and (value := _number(left)) is not None:
                yield right, -side, value


def within(low: float | None, high: float | None) -> float | None:
    """Return the middle of two bounds, whole where both are; None where one is not known."""
    if low is None or high is None or low > high:
        return None
    if type(low) is int and type(high) is int:
        return (low + high) // 2
    return round((low + high) / 2, 6)


def lengths(test: ast.expr, *, is_refused: bool) -> Iterator[tuple[ast.expr, str, int]]:
    """Yield each list of which a test asks something, with `LENGTH` or `LEAST` and the length."""
    if isinstance(test, ast.BoolOp):
        for part in test.values:
            yield from lengths(part, is_refused=is_refused)
    elif isinstance(test, ast.UnaryOp) and isinstance(test.op, ast.Not):
        yield from lengths(test.operand, is_refused=not is_refused)
    elif isinstance(test, ast.Compare) and len(test.ops) == 1:
        counted, operator = _counted(test.left), test.ops[0]
        value = _asked(test.comparators[0])
        if counted is not None and value is not None:
            length = _length(operator, value, is_refused)
            if length is not None and length > 0:
                is_exact = isinstance(operator, ast.NotEq if is_refused else ast.Eq)
                yield counted, LENGTH if is_exact else LEAST, length
    elif not is_refused and isinstance(test, ast.Name | ast.Attribute):
        yield test, LEAST, 1


def lengths_read(node: ast.AST) -> Iterator[tuple[ast.expr, str, int]]:
    """Yield a list that a node indexes, takes apart or gives a shape, with what that asks of it.

    That is `LENGTH`, `LEAST` or `ROWS`, and the length of the list or of a row.
    """
    if isinstance(node, ast.Subscript) and isinstance(node.ctx, ast.Load):
        is_part = isinstance(node.slice, ast.Slice)
        last = node.slice.upper if isinstance(node.slice, ast.Slice) else node.slice
        index = None if last is None else whole(last)
        if index is not None and (index > 0 or not is_part):
            yield node.value, LEAST, index if is_part else index + 1 if index >= 0 else -index
    elif isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Tuple):
        parts = node.targets[0].elts
        if not any(isinstance(part, ast.Starred) for part in parts):
            yield node.value, LENGTH, len(parts)
    elif isinstance(node, ast.Call) and last_name(node.func) == "reshape":
        yield from _shaped(node)


def _shaped(call: ast.Call) -> Iterator[tuple[ast.expr, str, int]]:
    """Yield the list that a call gives a shape: `reshape(4, 4)` takes 16, `reshape(-1, 3)` rows."""
    listed, sizes = call.args[:1], call.args[1:]
    owner = call.func.value if isinstance(call.func, ast.Attribute) else None
    if owner is not None and dotted_name(owner) not in ("np", "numpy"):
        listed, sizes = [owner], call.args
    if sizes and isinstance(sizes[0], ast.Tuple | ast.List):
        sizes = sizes[0].elts
    known = [whole(size) for size in sizes]
    numbers = [number for number in known if number is not None]
    if not listed or len(numbers) < len(known) or len(numbers) < len("xy"):
        return
    fixed = math.prod(number for number in numbers if number > 0)
    yield listed[0], ROWS if -1 in numbers else LENGTH, fixed


def whole(node: ast.expr) -> int | None:
    """Return the whole number that an expression is; None where it is none."""
    value = literal_value(node)
    return value if type(value) is int else None


def _counted(node: ast.expr) -> ast.expr | None:
    if isinstance(node, ast.Call) and last_name(node.func) == "len" and len(node.args) == 1:
        return node.args[0]
    is_shape = isinstance(node, ast.Attribute) and node.attr in ("shape", "size")
    return node.value if is_shape and isinstance(node, ast.Attribute) else None


def _length(operator: ast.cmpop, value: int, is_refused: bool) -> int | None:
    if is_refused:
        other: dict[type[ast.cmpop], int | None] = {
            ast.NotEq: value, ast.Lt: value, ast.LtE: value + 1, ast.Gt: value, ast.GtE: value - 1,
            ast.Eq: 1 if value == 0 else None,
        }  # fmt: skip
        return other.get(type(operator))
    held: dict[type[ast.cmpop], int | None] = {
        ast.Eq: value, ast.GtE: value, ast.Gt: value + 1, ast.NotEq: 1 if value == 0 else None,
    }  # fmt: skip
    return held.get(type(operator))


def _number(node: ast.expr) -> float | None:
    value = literal_value(node)
    return value if is_number(value) else None


def _asked(node: ast.expr) -> int | None:
    """Return the number that a length is compared with, or the only one in a 1-D shape."""
    is_shape = isinstance(node, ast.Tuple | ast.List) and len(node.elts) == 1
    value = _number(node.elts[0] if is_shape else node)  # type: ignore[attr-defined]
    if value is None or not math.isfinite(value) or value != int(value):
        return None
    return int(value)
