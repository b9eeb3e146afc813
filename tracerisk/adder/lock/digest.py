"""The digest of a block's computed values, which travels with the block on its first line.

    # | RiskAnnotation 4kQ9xa-b7QxZ1

One group of six characters for the function, one for each component that the tool computed.
A group holds a short checksum of each value, so that each value can be checked by itself, even
where a merge has put lines of two branches into one block, or the lock is gone.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any
from zlib import crc32

from tracerisk.adder.blocks.block import ComponentEntry, Field, RiskBlock
from tracerisk.adder.blocks.failures import failures_text, with_renamed
from tracerisk.adder.blocks.values import (
    CALL_SEQUENCE,
    COMPONENT_KINDS,
    DONE,
    FAILURES,
    NEXT,
    PROBABILITY,
    QUANTITY,
    REDUNDANCY,
    FieldKind,
    component_fields,
    computed_redundancy,
)
from tracerisk.adder.lock.lock import ControllerLock, WrittenBlock, WrittenComponent, written_block

_SIGNS = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz"
# The number of checksum characters for each value in a group: of the function, of a component.
_FUNCTION_WIDTHS = {CALL_SEQUENCE.key: 2, NEXT.key: 2}
_WHOLE_WIDTH = 2
_NAME_WIDTH = 2
_COMPONENT_WIDTHS = {PROBABILITY.key: 2, QUANTITY.key: 1, REDUNDANCY.key: 1, FAILURES.key: 2}
KINDS = {kind.key: kind for kind in (CALL_SEQUENCE, NEXT, *COMPONENT_KINDS, FAILURES)}


def block_digests(entry: ControllerLock) -> set[str]:
    """Return the digests of all blocks that a lock knows of a controller, pending ones too."""
    return set().union(*digests_of_versions(entry))


def digests_of_versions(entry: ControllerLock) -> Iterator[frozenset[str]]:
    """Yield the digests of a controller's blocks in each version that its sources may hold."""
    for blocks in entry.all_blocks:
        yield frozenset(
            digest_of(block) for written in blocks.values() for block in written.values()
        )


def digest_of(written: WrittenBlock) -> str:
    """Return the digest of the values that the tool wrote into a block."""
    said = [f"{key}={_plain(key, text)}" for key, text in sorted(written.values.items())]
    groups = []
    for name, component in sorted(written.components.items()):
        mark = "omit " if component.omitted else ""
        values = {key: _plain(key, text) for key, text in component.values.items()}
        said.append(f"{mark}{name} {sorted(values.items())}")
        parts = [_checksum(f"{mark}{name}", _NAME_WIDTH)]
        parts += [
            _checksum(f"{name} {key}={values.get(key)}", width)
            for key, width in _COMPONENT_WIDTHS.items()
            # Of a component without a word on its failures, as of an earlier version.
            if key != FAILURES.key or key in values
        ]
        groups.append("".join(parts))
    own = {key: _plain(key, text) for key, text in written.values.items()}
    first = "".join(_checksum(f"{key}={own.get(key)}", n) for key, n in _FUNCTION_WIDTHS.items())
    return "-".join([first + _checksum("\n".join(said), _WHOLE_WIDTH), *groups])


def with_digest(block: RiskBlock) -> RiskBlock:
    """Return a block, all of whose computed values are the tool's, with their digest."""
    written = written_block(block)
    return replace(block, digest=None if written is None else digest_of(written))


def is_as_written(block: RiskBlock, written: WrittenBlock) -> bool:
    """Return whether a block and its digest are as the tool wrote them, apart from pins.

    A newly pinned value need not say yet what is computed there.
    """
    row = written_block(block)
    if row is None or block.digest != digest_of(written):
        return False
    if row == written:
        return True
    own: dict[str, Field[Any]] = {CALL_SEQUENCE.key: block.call_sequence}
    own |= {} if block.next is None else {NEXT.key: block.next}
    entries = {component.name: component for component in block.components if not component.added}
    return (
        _fits(own, row.values, written.values)
        and entries.keys() == written.components.keys()
        and all(
            _is_component_as_written(entry, row.components[name].values, written.components[name])
            for name, entry in entries.items()
        )
    )


def _is_component_as_written(
    entry: ComponentEntry, found: Mapping[str, str], written: WrittenComponent
) -> bool:
    """Return whether a component is as written; one that is omitted need not state its values."""
    if written.omitted and not entry.omitted:
        return False
    fields = {kind.key: value for kind, value in component_fields(entry)}
    kept = written.values
    if entry.omitted:
        kept = {key: text for key, text in kept.items() if key in found}
    return _fits(fields, found, kept)


def _fits(
    fields: Mapping[str, Field[Any]], found: Mapping[str, str], written: Mapping[str, str]
) -> bool:
    """Return whether values are as written; one set by hand may say nothing of that yet."""
    return all(
        found.get(key) == written.get(key)
        or (key in fields and fields[key].pinned and fields[key].computed is None)
        for key in {*found, *written}
    )


def vouched_part(block: RiskBlock) -> WrittenBlock | None:
    """Return those computed values of a block for which its digest vouches; `None` without any."""
    written, digest = written_block(block), DigestReading(block)
    if written is None or not digest.is_there:
        return None

    def vouched(component: str | None, values: Mapping[str, str]) -> dict[str, str]:
        return {
            key: text
            for key, text in values.items()
            if digest.vouches(component, KINDS[key], KINDS[key].read(text))
        }

    components = {
        name: WrittenComponent(vouched(name, written_component.values), written_component.omitted)
        for name, written_component in written.components.items()
        if digest.has_component(name) or digest.had_omitted(name)
    }
    return WrittenBlock(vouched(None, written.values), components)


class DigestReading:
    """What the digest of a block says of the values that stand in the block now."""

    def __init__(self, block: RiskBlock, names: Mapping[str, str] | None = None) -> None:
        """Read `block.digest`; `names` gives the earlier names of functions renamed since."""
        self._names = names or {}
        groups = (block.digest or "").split("-")
        self._first, self._groups = groups[0], {group[:_NAME_WIDTH]: group for group in groups[1:]}
        own = [_digest_now(block, names) for names in (self._names, {})]
        # Each value matches its checksum but the checksum of the whole does not: one matches by
        # chance, so none is believed.
        self._is_believed = bool(self._first) and (
            block.digest in own or not any(self._is_chance(digest) for digest in own)
        )

    def _is_chance(self, digest: str | None) -> bool:
        """Return whether a digest has all checksums of values, and another one of the whole."""
        first, *groups = (digest or "").split("-")
        shorter = len(self._first) - _WHOLE_WIDTH
        return (
            sorted(groups) == sorted(self._groups.values())
            and first[:shorter] == self._first[:shorter]
        )

    @property
    def is_there(self) -> bool:
        """Whether there is a digest that can be believed."""
        return self._is_believed

    def has_component(self, name: str) -> bool:
        """Return whether the block held the component, computed and not omitted."""
        return self._is_believed and _checksum(name, _NAME_WIDTH) in self._groups

    def had_omitted(self, name: str) -> bool:
        """Return whether the block held the component as omitted."""
        return self._is_believed and _checksum(f"omit {name}", _NAME_WIDTH) in self._groups

    def vouches(self, component: str | None, kind: FieldKind, value: Any) -> bool:
        """Return whether the tool wrote this value, of a component or of the function itself."""
        if not self._is_believed:
            return False
        # It may have been written before a function that it names was renamed, or since.
        return any(
            self._has(component, kind, _plain_value(kind.key, one))
            for one in (value, self.earlier(kind, value))
        )

    def _has(self, component: str | None, kind: FieldKind, text: str) -> bool:
        said = f"{kind.key}={text}"
        if component is None:
            return _is_at(self._first, 0, _FUNCTION_WIDTHS, kind.key, said)
        named = (
            self._groups.get(_checksum(f"{mark}{component}", _NAME_WIDTH), "")
            for mark in ("", "omit ")
        )
        return any(
            _is_at(group, _NAME_WIDTH, _COMPONENT_WIDTHS, kind.key, f"{component} {said}")
            for group in named
        )

    def earlier(self, kind: FieldKind, value: Any) -> Any:
        """Return a value with the earlier names of the functions that it names."""
        return value_with_names(kind, value, self._names)


def value_with_names(kind: FieldKind, value: Any, names: Mapping[str, str]) -> Any:
    """Return a value with other names for the functions that it names."""
    if kind is FAILURES:
        return with_renamed(value, names)
    return _renamed(value, names) if kind is NEXT and names else value


def functions_named(kind: FieldKind, value: Any) -> frozenset[str]:
    """Return the functions that a value names: those that follow, after a failure among them."""
    if kind is NEXT:
        return frozenset(step.target for step in value if step.target != DONE)
    outcomes = [outcome for mode in value for outcome in mode.outcomes] if kind is FAILURES else []
    named = {name for outcome in outcomes for name in (outcome.target, outcome.shows_in)}
    return frozenset(name for name in named if name)


def _is_at(group: str, start: int, widths: Mapping[str, int], key: str, said: str) -> bool:
    for name, width in widths.items():
        if name == key:
            return group[start : start + width] == _checksum(said, width)
        start += width
    return False


def _digest_now(block: RiskBlock, names: Mapping[str, str]) -> str | None:
    written = written_block(block)
    if written is None:
        return None
    return digest_of(_with_earlier(written, names) if names else written)


def _with_earlier(written: WrittenBlock, names: Mapping[str, str]) -> WrittenBlock:
    """Return values with the earlier names of the functions that they name."""
    values, components = dict(written.values), {}
    if NEXT.key in values:
        steps = _renamed(NEXT.read(values[NEXT.key]), names)
        values[NEXT.key] = ", ".join(f"{step.target} {step.weight}" for step in steps)
    for name, component in written.components.items():
        own = dict(component.values)
        if FAILURES.key in own:
            own[FAILURES.key] = failures_text(with_renamed(FAILURES.read(own[FAILURES.key]), names))
        components[name] = component._replace(values=own)
    return WrittenBlock(values, components)


def _renamed(steps: Any, names: Mapping[str, str]) -> Any:
    return tuple(type(step)(names.get(step.target, step.target), step.weight) for step in steps)


# Most texts of a project come again and again: `1`, `false`, `done 1`.
@lru_cache(maxsize=4096)
def _plain(key: str, text: str) -> str:
    return _plain_value(key, KINDS[key].read(text))


def _plain_value(key: str, value: Any) -> str:
    """Return a value as text, whatever digits and order it is written in."""
    if key == NEXT.key:
        return ", ".join(sorted(f"{item.target} {item.weight}" for item in value))
    if key == FAILURES.key:
        return failures_text(value)
    if key == REDUNDANCY.key:
        return computed_redundancy(value).text
    return repr(value)


def _checksum(text: str, width: int) -> str:
    number = crc32(text.encode("utf-8", errors="surrogatepass"))
    signs = []
    for _ in range(width):
        number, sign = divmod(number, len(_SIGNS))
        signs.append(_SIGNS[sign])
    return "".join(signs)
