"""Find the part that is the system as a whole."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress

from tracerisk.common.hardware.sysml.annotations import OF_FAILURES, Annotations, own_annotations
from tracerisk.common.hardware.sysml.composition import Composition
from tracerisk.common.hardware.sysml.language.name_resolution import Symbol, ancestors
from tracerisk.common.hardware.sysml.language.skipped import skipped_warnings
from tracerisk.common.hardware.sysml.language.syntax import Element, Package
from tracerisk.errors import HardwareError, one_of

_STRUCTURAL = ("part", "item")
_SHOWN = 8
"""How many parts a message names."""


def find_root(
    mains: Sequence[Symbol],
    composition: Composition,
    annotations: Annotations,
    system: str | None = None,
) -> Symbol:
    """Return the system: the one part usage, else the one part definition, that holds components.

    A usage stands directly in a package; a definition, in a package before one within a definition,
    counts if no other element of the files is of it or specialises it. `system` names one of
    them, by its name or with its packages.
    Raises HardwareError where there are several, or none.
    """
    holds = _Holding(composition, annotations)
    top = [symbol for main in mains for symbol in _in_packages(main)]
    within = [inner for symbol in top for inner in _definitions_in(symbol)]
    if system is not None:
        return _named(system, [*top, *within], holds, mains[0])
    usages = [symbol for symbol in top if _is(symbol, is_definition=False) and holds(symbol)]
    definitions = [symbol for symbol in top if _is(symbol, is_definition=True)]
    symbols = (
        usages
        or _unused([symbol for symbol in definitions if holds(symbol)], mains)
        or _unused([symbol for symbol in within if holds(symbol)], mains)
    )
    if not symbols:
        _say_where_data_is_lost(mains)
        raise HardwareError(
            "no part has failure data; give one '@FailureData { rate = 5.7e-6 [h^-1]; }' "
            "(and 'private import TraceriskHardware::*;')",
            mains[0].location(0),
        )
    if len(symbols) > 1:
        symbols.sort(key=holds.is_unread)
        is_one_file = len({symbol.source for symbol in symbols}) == 1
        is_distinct = len({symbol.name for symbol in symbols}) == len(symbols)
        names = ", ".join(
            f"'{symbol.name if is_distinct else symbol}' "
            f"({f'line {symbol.location().line}' if is_one_file else symbol.location()})"
            for symbol in symbols[:_SHOWN]
        )
        more = f" and {len(symbols) - _SHOWN} more" if len(symbols) > _SHOWN else ""
        kind = "parts" if usages else "part definitions"
        raise HardwareError(
            f"several {kind} could be the system as a whole: {names}{more}; name one by --system "
            "or the setting system, or keep one, with the others as its parts",
            symbols[1].location(),
        )
    return symbols[0]


def _say_where_data_is_lost(mains: Sequence[Symbol]) -> None:
    """Raise HardwareError at the first failure data that belongs to no part of a system."""
    skipped_warnings(tuple(mains))
    waiting = list(reversed(mains))
    while waiting:
        symbol = waiting.pop()
        if not isinstance(symbol.node, Package | Element):
            continue
        if isinstance(symbol.node, Element):
            for metadata in own_annotations(symbol):
                if metadata.kind == "FailureData":
                    raise HardwareError(
                        f"the failure data of '{symbol}' is of no part of a system; describe "
                        "hardware by parts, in a part that stands directly in a package",
                        metadata.location,
                    )
        waiting += reversed(symbol.members)


def _named(system: str, top: list[Symbol], holds: _Holding, main: Symbol) -> Symbol:
    """Return the part or part definition of a name; raise HardwareError where it is none or two."""
    kinds = [symbol for symbol in top if _is_structural(symbol)]
    named = [symbol for symbol in kinds if system in _names(symbol)]
    symbols = [symbol for symbol in named if holds(symbol)] or named
    if not symbols:
        names = [str(symbol) for symbol in kinds if holds(symbol)] or map(str, kinds)
        raise HardwareError(
            f"the system '{system}' is no part in a package of it; {one_of(names, system)}",
            main.location(0),
        )
    if len(symbols) > 1:
        names = [f"'{symbol}' ({symbol.location()})" for symbol in symbols]
        raise HardwareError(
            f"the system '{system}' could be {', '.join(names)}; name it with its packages",
            symbols[1].location(),
        )
    return symbols[0]


def _names(symbol: Symbol) -> set[str | None]:
    assert isinstance(symbol.node, Element)
    return {symbol.name, symbol.node.short, str(symbol)}


def _in_packages(top: Symbol) -> Iterator[Symbol]:
    for member in top.members:
        if isinstance(member.node, Package):
            yield from _in_packages(member)
        elif isinstance(member.node, Element):
            yield member


def _definitions_in(symbol: Symbol) -> Iterator[Symbol]:
    """Yield the part definitions within a definition or a usage."""
    for member in symbol.members if isinstance(symbol.node, Element) else ():
        if _is(member, is_definition=True):
            yield member
        yield from _definitions_in(member)


def _is_structural(symbol: Symbol) -> bool:
    return isinstance(symbol.node, Element) and symbol.node.kind in _STRUCTURAL


def _is(symbol: Symbol, *, is_definition: bool) -> bool:
    node = symbol.node
    return (
        isinstance(node, Element)
        and _is_structural(symbol)
        and node.is_definition is is_definition
        and not ({"abstract", "ref"} & set(node.prefixes) and not is_definition)
    )


class _Holding:
    """Whether an element, or a part within it, has failure data, or cannot be read."""

    def __init__(self, composition: Composition, annotations: Annotations) -> None:
        self._composition = composition
        self._annotations = annotations
        self._known: dict[Symbol, bool] = {}

    def __call__(self, symbol: Symbol) -> bool:
        try:
            return self._holds(symbol)
        except HardwareError:
            return True  # whoever reads it as the system says what is wrong

    def is_unread(self, symbol: Symbol) -> bool:
        """Whether an element cannot be read, and nothing in its file speaks of failure data."""
        try:
            self._holds(symbol)
        except HardwareError:
            return OF_FAILURES.search(symbol.source.text) is None
        return False

    def _holds(self, symbol: Symbol) -> bool:
        waiting = [symbol]
        seen = {symbol}
        while waiting:
            each = waiting.pop()
            if self._has_data(each):
                return True
            for part in self._composition.parts(each):
                if part not in seen:
                    seen.add(part)
                    waiting.append(part)
        return False

    def _has_data(self, symbol: Symbol) -> bool:
        known = self._known.get(symbol)
        if known is None:
            known = any(
                any(
                    metadata.kind in ("FailureData", "Risk")
                    for metadata in self._annotations.own(ancestor)
                )
                for ancestor in ancestors(symbol)
                if isinstance(ancestor, Symbol)
            )
            self._known[symbol] = known
        return known


def _unused(definitions: list[Symbol], mains: Sequence[Symbol]) -> list[Symbol]:
    """Return the definitions that no element of the files is of, or specialises."""
    if len(definitions) < 2:
        return definitions
    used: set[Symbol] = set()
    waiting = list(mains)
    while waiting:
        symbol = waiting.pop()
        if isinstance(symbol.node, Package | Element):
            waiting.extend(symbol.members)
        if isinstance(symbol.node, Element) and symbol.is_structural:
            with suppress(HardwareError):  # whoever reads it as the system says what is wrong
                used.update(general for general in symbol.generals() if isinstance(general, Symbol))
    return [definition for definition in definitions if definition not in used]
