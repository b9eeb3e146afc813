"""Plan the changes of a controller: every place of the functions that ran, and a draw of them."""

from __future__ import annotations

import ast
import hashlib
import warnings
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import lru_cache
from itertools import zip_longest
from typing import Any

import libcst as cst

from tracerisk.pipeline.mutation.change import Change, Draft
from tracerisk.pipeline.mutation.changed_calls import (
    call_changes,
    result_changes,
    swapped_calls,
    wait_option_changes,
)
from tracerisk.pipeline.mutation.changed_flow import condition_changes, loop_changes
from tracerisk.pipeline.mutation.changed_names import (
    KnownNames,
    function_changes,
    known_names,
    text_changes,
    variable_changes,
)
from tracerisk.pipeline.mutation.changed_numbers import (
    axis_changes,
    number_changes,
    order_changes,
)
from tracerisk.pipeline.mutation.source_tree import SourceTree, Walk

_Changes = Callable[[cst.CSTNode, Walk], Iterator[Draft]]
_OF_NODES: tuple[_Changes, ...] = (
    number_changes,
    order_changes,
    axis_changes,
    call_changes,
    swapped_calls,
    wait_option_changes,
    result_changes,
    loop_changes,
    condition_changes,
)
_OF_NAMES = (text_changes, variable_changes, function_changes)


def changes_of(
    source: bytes, file: str, ran: Collection[str], alike: Sequence[Collection[str]] = ()
) -> tuple[Change, ...]:
    """Return the changes of a file in the functions that ran, in the order of their places.

    `ran` are qualified names, `<module>` among them; `alike` are names of robot and scene, those
    of each kind. Not every change gives another program: see `is_another`.
    Raises SourceError or UnsafeRewriteError where the source cannot be read.
    """
    tree = SourceTree(source, file)
    planned = _Planned(tree, ran, known_names(tree, alike))
    tree.module.visit(planned)
    return tuple(sorted(planned.changes, key=lambda change: (change.start, change.end, change.new)))


class _Planned(Walk):
    def __init__(self, tree: SourceTree, ran: Collection[str], known: KnownNames) -> None:
        super().__init__(tree)
        self._ran = frozenset(ran)
        self._known = known
        self.changes: set[Change] = set()

    def at(self, node: cst.CSTNode) -> None:
        if self.function in self._ran:
            drafts = [draft for make in _OF_NODES for draft in make(node, self)]
            drafts += [draft for make in _OF_NAMES for draft in make(node, self, self._known)]
            self.changes |= {self.tree.change(draft, self.function) for draft in drafts}


def is_another(change: Change, source: bytes) -> bool:
    """Return whether a change of a source gives a program that is another one, and is one."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            changed = ast.parse(change.applied(source))
            compile(changed, change.file, "exec", dont_inherit=True)
        except (SyntaxError, ValueError, RecursionError):
            return False
        return ast.dump(changed) != _tree_text(source)


@lru_cache(maxsize=8)
def _tree_text(source: bytes) -> str:
    return ast.dump(ast.parse(source))


def drawn(
    changes: Sequence[Change], sources: Mapping[str, bytes], *, most: int, seed: int
) -> tuple[Change, ...]:
    """Return at most so many changes, spread over kinds, then functions, then lines.

    The order is drawn by the seed. Fewer of the same seed are the first of more.
    """

    def drawn_number(change: Change) -> str:
        text = f"{seed} {change.file} {change.start} {change.end} {change.new!r}"
        return hashlib.sha256(text.encode()).hexdigest()

    ordered = _in_turn(
        sorted(changes, key=drawn_number),
        (
            lambda change: change.kind,
            lambda change: (change.file, change.function),
            lambda change: change.line,
        ),
    )
    result: list[Change] = []
    for change in ordered:
        if len(result) == most:
            break
        if is_another(change, sources[change.file]):
            result.append(change)
    return tuple(result)


def _in_turn(changes: Sequence[Change], keys: Sequence[Callable[[Change], Any]]) -> list[Change]:
    """Return changes so that those with different keys take turns, the first key first."""
    if not keys:
        return list(changes)
    groups: dict[Any, list[Change]] = {}
    for change in changes:
        groups.setdefault(keys[0](change), []).append(change)
    queues = (_in_turn(group, keys[1:]) for group in groups.values())
    return [change for turn in zip_longest(*queues) for change in turn if change is not None]
