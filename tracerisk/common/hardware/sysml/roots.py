"""Find the part that is the system as a whole."""

from __future__ import annotations

from collections.abc import Iterator

from tracerisk.common.hardware.sysml.annotations import Annotations
from tracerisk.common.hardware.sysml.composition import Composition
from tracerisk.common.hardware.sysml.language.name_resolution import Symbol, ancestors
from tracerisk.common.hardware.sysml.language.syntax import Element, Package
from tracerisk.errors import HardwareError

_STRUCTURAL = ("part", "item")


def find_root(main: Symbol, composition: Composition, annotations: Annotations) -> Symbol:
    """Return the system: the one part usage, else the one part definition, that holds components.

    A usage stands directly in a package; a definition counts if no other element of the file is
    of it or specialises it. Raises HardwareError where there are several, or none.
    """
    holds = _Holding(composition, annotations)
    top = list(_in_packages(main))
    usages = [symbol for symbol in top if _is(symbol, is_definition=False) and holds(symbol)]
    symbols = usages or _unused(
        [symbol for symbol in top if _is(symbol, is_definition=True) and holds(symbol)], main
    )
    if not symbols:
        raise HardwareError(
            "no part has failure data; give one '@FailureData { rate = 5.7e-6 [h^-1]; }' "
            "(and 'private import TraceriskHardware::*;')",
            main.location(0),
        )
    if len(symbols) > 1:
        names = ", ".join(f"'{symbol.name}' (line {symbol.location().line})" for symbol in symbols)
        kind = "parts" if usages else "part definitions"
        raise HardwareError(
            f"several {kind} could be the system as a whole: {names}; keep one, with the others "
            "as its parts",
            symbols[1].location(),
        )
    return symbols[0]


def _in_packages(top: Symbol) -> Iterator[Symbol]:
    for member in top.members:
        if isinstance(member.node, Package):
            yield from _in_packages(member)
        elif isinstance(member.node, Element):
            yield member


def _is(symbol: Symbol, *, is_definition: bool) -> bool:
    node = symbol.node
    return (
        isinstance(node, Element)
        and node.kind in _STRUCTURAL
        and node.is_definition is is_definition
        and not ({"abstract", "ref"} & set(node.prefixes) and not is_definition)
    )


class _Holding:
    """Whether an element, or a part within it, has failure data."""

    def __init__(self, composition: Composition, annotations: Annotations) -> None:
        self._composition = composition
        self._annotations = annotations
        self._known: dict[Symbol, bool] = {}

    def __call__(self, symbol: Symbol) -> bool:
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


def _unused(definitions: list[Symbol], main: Symbol) -> list[Symbol]:
    """Return the definitions that no element of the file is of, or specialises."""
    if len(definitions) < 2:
        return definitions
    used: set[Symbol] = set()
    waiting = [main]
    while waiting:
        symbol = waiting.pop()
        if isinstance(symbol.node, Package | Element):
            waiting.extend(symbol.members)
        if isinstance(symbol.node, Element) and symbol.is_structural:
            used.update(general for general in symbol.generals() if isinstance(general, Symbol))
    return [definition for definition in definitions if definition not in used]
