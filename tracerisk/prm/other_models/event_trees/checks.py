"""What an event tree must be: names that are there once, and paths that come to an end."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.numbers.quantities import check_names
from tracerisk.prm.other_models.event_trees.elements import Branch, End, Fork, Resume, Target

if TYPE_CHECKING:
    from tracerisk.prm.other_models.event_trees.event_tree import EventTree


def check_names_of(tree: EventTree) -> None:
    """Raise ModelError when a name is used twice, or cannot be printed."""
    where = f"event tree '{tree.name}': "
    check_names("functional event", tree.functional_events, where=where)
    check_names("sequence", (sequence.name for sequence in tree.sequences), where=where)
    check_names("branch", (branch.name for branch in tree.branches), where=where)


def check_targets(tree: EventTree) -> None:
    """Raise ModelError when a path leads to what is not there, or a fork has no proper paths."""
    sequences = {sequence.name for sequence in tree.sequences}
    branches = {branch.name for branch in tree.branches}
    for branch in (tree.start, *tree.branches):
        for target in _targets(branch):
            _check_target(tree, target, sequences, branches)


def _check_target(tree: EventTree, target: Target, sequences: set[str], branches: set[str]) -> None:
    where = f"event tree '{tree.name}'"
    match target:
        case End(sequence) if sequence not in sequences:
            raise ModelError(
                f"{where}: a path ends in '{sequence}', which is not a sequence; "
                f"{one_of(sequences, sequence)}"
            )
        case Resume(branch) if branch not in branches:
            raise ModelError(
                f"{where}: a path continues as '{branch}', which is not a branch; "
                f"{one_of(branches, branch)}"
            )
        case Fork(functional_event, paths):
            if functional_event not in tree.functional_events:
                raise ModelError(
                    f"{where}: a fork over '{functional_event}', which is not a functional "
                    f"event; {one_of(tree.functional_events, functional_event)}"
                )
            fork = f"{where}: fork over '{functional_event}'"
            if not paths:
                raise ModelError(f"{fork}: a path is missing; give it one for each state")
            seen: set[str] = set()
            for path in paths:
                if path.state in seen:
                    raise ModelError(
                        f"{fork}: two paths for the state '{path.state}'; merge them, or rename "
                        "one state"
                    )
                seen.add(path.state)


def check_order(tree: EventTree) -> None:
    """Raise ModelError when a path forks twice over an event, against the order, or for ever."""
    rank = {name: index for index, name in enumerate(tree.functional_events)}
    waiting: list[tuple[Target, int, tuple[str, ...]]] = [(tree.start.target, -1, ())]
    waiting += [(branch.target, -1, (branch.name,)) for branch in tree.branches]
    seen: set[tuple[int, int]] = set()
    while waiting:
        target, last, resumed = waiting.pop()
        match target:
            case Resume(name):
                if name in resumed:
                    raise ModelError(
                        f"event tree '{tree.name}': the branch '{name}' resumes itself; "
                        "let it end in a sequence"
                    )
                waiting.append((tree.branch(name).target, last, (*resumed, name)))
            case Fork(name, paths):
                if rank[name] <= last:
                    raise ModelError(
                        f"event tree '{tree.name}': a path forks over '{name}' after "
                        f"'{tree.functional_events[last]}'; a path may fork over each functional "
                        "event at most once, in their order"
                    )
                if (id(target), last) not in seen:
                    seen.add((id(target), last))
                    waiting.extend((path.target, rank[name], resumed) for path in paths)
            case _:
                pass


def _targets(branch: Branch) -> Iterator[Target]:
    """Yield the targets of a branch and of all forks in it."""
    waiting: list[Target] = [branch.target]
    while waiting:
        target = waiting.pop()
        yield target
        if isinstance(target, Fork):
            waiting.extend(path.target for path in reversed(target.paths))
