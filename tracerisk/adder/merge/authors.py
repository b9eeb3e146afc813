"""Who wrote what stands in a block: the tool, on whichever branch, or a user.

The block's own digest is asked first, then the lock, then the versions that git keeps. A value
that none of them knows is a user's only if no branch can have brought it there; otherwise its
author is unknown.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import permutations
from typing import Any, Literal

from tracerisk.adder.blocks.block import Field, RiskBlock
from tracerisk.adder.blocks.values import (
    CALL_SEQUENCE,
    NEXT,
    NOTHING_COMPUTED,
    PROBABILITY,
    FieldKind,
    component_fields,
)
from tracerisk.adder.lock.digest import (
    DigestReading,
    digest_of,
    functions_named,
    value_with_names,
)
from tracerisk.adder.lock.lock import WrittenBlock, WrittenComponent
from tracerisk.adder.merge.bases import NO_EARLIER_NAMES, EarlierNames

Author = Literal["tool", "user", "unknown"]

_MOST_RENAMED = 5  # in one `next`: each way to pair them is tried


@dataclass(frozen=True, slots=True)
class Evidence:
    """What is known of one source beyond its blocks and the lock."""

    is_fresh: bool = True
    """Whether nothing that the values depend on has changed since the lock was written, and no
    other branch has come in."""
    is_complete: bool = False
    """Whether git kept every version of the source, and all its blocks are of one of them or of
    the lock."""
    written: Mapping[str, Sequence[WrittenBlock]] = field(default_factory=dict)
    """The blocks that the tool wrote in those versions, by function."""
    standing: Mapping[str, Sequence[RiskBlock]] = field(default_factory=dict)
    """All blocks in those versions, whoever wrote their values, by function."""
    versions: Collection[frozenset[str]] = ()
    """The functions with a block in each version."""


class KnownBlock:
    """What the tool is known to have written into one block."""

    def __init__(
        self,
        current: RiskBlock,
        bases: Sequence[WrittenBlock],
        evidence: Callable[[], Evidence] = Evidence,
        names: EarlierNames = NO_EARLIER_NAMES,
    ) -> None:
        """`bases` is what the lock holds, latest first."""
        self._current = current
        self._bases = bases
        self._digest = DigestReading(current, names.following)
        self._evidence = evidence
        # In git's versions the block has its current name, or the one it had before a renaming.
        self._names = frozenset({current.name, names.own.get(current.name, current.name)})

    @property
    def is_known(self) -> bool:
        """Whether the tool has written the block, whatever became of it since."""
        return bool(self._bases) or self._digest.is_there

    def last(
        self, component: str | None, kind: FieldKind, current: Field[Any]
    ) -> tuple[str | None, bool]:
        """Return the text that the tool last wrote for a value, and whether the block holds it now.

        If the tool is known to have written what the block holds now, on any branch, that text is
        returned.
        """
        texts = [text for base in self._bases if (text := _value(base, component, kind))]
        standing = current.computed if current.pinned else current.text
        if standing and standing != NOTHING_COMPUTED:
            value = kind.read(standing)
            for text in texts:
                if kind.same(kind.read(text), value):
                    return text, True
            if self._digest.vouches(component, kind, value):
                return standing, True
        return (texts[0] if texts else None), False

    def held(self, component: str) -> bool | None:
        """Return whether the block held a component when the tool last wrote it, not omitted.

        Branches may differ: then it may have come, or gone, with any of them, and a component
        that is not there counts as not held. `None` where nothing is known of the block.
        """
        written = [base.components.get(component) for base in self._bases]
        if self._digest.is_there and not self._digest.has_component(component):
            return False
        if not self.is_known:
            return None
        return all(item is not None and not item.omitted for item in written)

    def knows(self, component: str) -> bool:
        """Return whether the tool has written a component into the block, on any branch."""
        return (
            any(component in base.components for base in self._bases)
            or self._digest.has_component(component)
            or self._digest.had_omitted(component)
        )

    def author_of_value(self, component: str | None, kind: FieldKind, value: Any) -> Author:
        """Return who wrote a value that neither the digest nor the lock knows."""
        earlier = self._digest.earlier(kind, value)

        def is_it(text: str | None) -> bool:
            return text is not None and any(
                kind.same(kind.read(text), item) for item in (value, earlier)
            )

        if any(
            is_it(_value(written_component, component, kind))
            for written_component in self._written()
        ):
            # A figure of four digits is no coincidence; a small number may be.
            return "tool" if kind is PROBABILITY else "unknown"
        # The same figure in another function is no coincidence either: a merge may have moved its
        # lines here.
        is_moved = kind is PROBABILITY or (component is not None and not self.knows(component))
        names = self._all_names() if is_moved else self._possible_names()
        if any(
            is_it(_value(written_component, component, kind))
            for written_component in self._written(names)
        ):
            return "unknown"
        stood = any(
            field is not None and not field.pinned and is_it(field.text or None)
            for block in self._standing(names)
            for field in (_field(block, component, kind),)
        )
        texts = [_value(block, component, kind) for block in (*self._bases, *self._written(names))]
        if any(text and self._may_be_renamed(kind, value, kind.read(text)) for text in texts):
            return "unknown"
        return self._user_or_unknown(stood)

    def _may_be_renamed(self, kind: FieldKind, value: Any, written: Any) -> bool:
        """Return whether a value may only have new names for functions that it named before.

        Another branch may have renamed them. Two that had blocks in one version are two.
        """
        now, before = functions_named(kind, value), functions_named(kind, written)
        new, old = sorted(now - before), sorted(before - now)
        if not new or len(new) != len(old) or len(new) > _MOST_RENAMED:
            return False
        versions = self._evidence().versions
        return any(
            kind.same(value_with_names(kind, value, dict(zip(new, chosen, strict=True))), written)
            and not any(
                {one, other} <= names
                for one, other in zip(new, chosen, strict=True)
                for names in versions
            )
            for chosen in permutations(old)
        )

    def author_of_component(self, component: str, value: float) -> Author:
        """Return who put in a component that neither the digest nor the lock knows."""

        def is_it(block: WrittenBlock) -> bool:
            text = _value(block, component, PROBABILITY)
            return text is not None and bool(PROBABILITY.read(text) == value)

        if any(map(is_it, self._written())):
            return "tool"
        names = self._possible_names()
        # A merge may have moved the section here from the block of another function.
        if any(component in block.components for block in self._written(names)) or any(
            map(is_it, self._written(self._all_names()))
        ):
            return "unknown"
        stood = any(
            component_entry.name == component and not component_entry.added
            for block in self._standing(names)
            for component_entry in block.components
        )
        return self._user_or_unknown(stood)

    def author_of_removal(self, component: str) -> Author:
        """Return who took out a component that the tool had written."""
        entries = [
            {component_entry.name: component_entry for component_entry in block.components}
            for block in self._standing()
        ]
        if any(component in entry and entry[component].omitted for entry in entries):
            # A user had omitted it, and has taken that back.
            return "tool"
        names = self._possible_names()
        if any(
            component not in written_component.components
            for written_component in self._written(names)
        ):
            return "unknown"
        was_without = any(
            all(component_entry.name != component for component_entry in block.components)
            for block in self._standing(names)
        )
        return self._user_or_unknown(was_without)

    def author_of_block(self) -> Author:
        """Return who put in a block of which neither a digest nor the lock knows."""
        if self._written():
            return "tool"
        return self._user_or_unknown(bool(self._standing()))

    def _written(self, names: Collection[str] = ()) -> list[WrittenBlock]:
        kept = self._evidence().written
        return [block for name in sorted(names or self._names) for block in kept.get(name, ())]

    def _standing(self, names: Collection[str] = ()) -> list[RiskBlock]:
        kept = self._evidence().standing
        return [block for name in sorted(names or self._names) for block in kept.get(name, ())]

    def _all_names(self) -> frozenset[str]:
        return self._names.union(*self._evidence().versions)

    def _possible_names(self) -> frozenset[str]:
        """Return the names that the function may have on some branch: one may have renamed it.

        A function that had a block in the same version as this one is a different function.
        """
        beside = (names for names in self._evidence().versions if names & self._names)
        return (self._all_names() - frozenset().union(*beside)) | self._names

    def _user_or_unknown(self, stood_before: bool) -> Author:
        """Decide who wrote something that no version shows the tool writing into this block.

        Even committed text may come from a merge whose other branch is gone.
        """
        evidence = self._evidence()
        if self._is_mixed():
            return "unknown"
        if evidence.is_complete and not stood_before and self._written():
            return "user"
        return "user" if evidence.is_fresh and self._lock_matches_block() else "unknown"

    def _is_mixed(self) -> bool:
        """Return whether a merge moved lines here that the tool wrote into another version.

        The tool's own value stands beside one that is pinned, and it never wrote that one here.
        """
        nothing = (None, NOTHING_COMPUTED)
        return self.is_known and any(
            value.computed not in nothing and not self.last(entry.name, kind, value)[1]
            for entry in self._current.components
            if not entry.added
            for kind, value in component_fields(entry)
        )

    def _lock_matches_block(self) -> bool:
        if self._current.digest is None:
            return len(self._bases) < 2
        return len(self._bases) == 1 and digest_of(self._bases[0]) == self._current.digest


def _value(base: WrittenBlock, component: str | None, kind: FieldKind) -> str | None:
    if component is None:
        return base.values.get(kind.key)
    entry: WrittenComponent | None = base.components.get(component)
    return None if entry is None else entry.values.get(kind.key)


def _field(block: RiskBlock, component: str | None, kind: FieldKind) -> Field[Any] | None:
    if component is None:
        return {CALL_SEQUENCE: block.call_sequence, NEXT: block.next}[kind]
    for component_entry in block.components:
        if component_entry.name == component:
            return dict(component_fields(component_entry))[kind]
    return None
