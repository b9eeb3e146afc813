"""Unfold the parts of a system: inherited ones, redefined ones, and how many there are."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from tracerisk.common.hardware.sysml.annotations import own_annotations
from tracerisk.common.hardware.sysml.language.name_resolution import Symbol, ancestors
from tracerisk.common.hardware.sysml.language.syntax import Element, Multiplicity, Reference
from tracerisk.errors import HardwareError

MAX_PARTS = 20_000
"""How many parts a system may unfold to."""
MAX_NESTING = 100
"""How deep parts may stand within parts."""


@dataclass(frozen=True, slots=True)
class Place:
    """A part within the system."""

    way: tuple[Symbol, ...]
    """The parts from the root, which is first, to the part itself."""
    own: tuple[int, int | None] | None
    """The lower and upper bound of the part's multiplicity, an open upper bound `None`; `None`
    where no multiplicity is written."""
    outer: tuple[int, int | None]
    """The bounds of the number of enclosing parts, an open upper bound `None`."""

    @property
    def symbol(self) -> Symbol:
        """The part itself."""
        return self.way[-1]


class Composition:
    """The parts of definitions and usages; what was found is kept."""

    def __init__(self) -> None:
        self._parts: dict[Symbol, tuple[Symbol, ...]] = {}

    def parts(self, symbol: Symbol) -> tuple[Symbol, ...]:
        """Return the parts of an element, the inherited ones first, each redefined by its own.

        Raises HardwareError where a part hides an inherited one, or two have one name.
        """
        known = self._parts.get(symbol)
        if known is None:
            known = self._parts[symbol] = self._collect(symbol)
        return known

    def _collect(self, symbol: Symbol) -> tuple[Symbol, ...]:
        members: dict[Symbol, None] = {}
        for general in reversed(ancestors(symbol)):
            if isinstance(general, Symbol):
                members = _with_members(general, members)
        return tuple(members)

    def unfold(self, root: Symbol) -> Iterator[Place]:
        """Yield the root and all parts within it, each before its own parts.

        Raises HardwareError at a part that holds itself, and at more than `MAX_PARTS` parts.
        """
        count = 0
        once = (1, 1)
        waiting = [Place((root,), multiplicity(root), once)]
        while waiting:
            place = waiting.pop()
            count += 1
            if count > MAX_PARTS:
                raise HardwareError(
                    f"expands to more than {MAX_PARTS:,} parts; describe the system with fewer",
                    root.location(),
                )
            yield place
            inner = product(place.outer, place.own or once)
            parts = self._composed(place.symbol)
            for part in reversed(parts):
                _check_circle(place, part)
                waiting.append(Place((*place.way, part), multiplicity(part), inner))

    def _composed(self, symbol: Symbol) -> list[Symbol]:
        """Return the parts that are units of their own: none that others are subsets of."""
        parts = self.parts(symbol)
        subsetters: dict[Symbol, list[Symbol]] = {}
        for part in parts:
            node = part.node
            assert isinstance(node, Element)
            if node.subsets:
                for general in part.generals():
                    if general in parts and general not in part.redefined():
                        assert isinstance(general, Symbol)
                        subsetters.setdefault(general, []).append(part)
        return [
            part
            for part in parts
            if not _is_abstract(part) and not _is_covered(part, subsetters.get(part, []))
        ]


def _with_members(general: Symbol, inherited: dict[Symbol, None]) -> dict[Symbol, None]:
    """Return the parts that were inherited, and those of `general` in their place or after them."""
    symbols: dict[Symbol, Symbol] = {symbol: symbol for symbol in inherited}
    names = {symbol.name: symbol for symbol in inherited if symbol.name}
    for member in general.members:
        node = member.node
        if not isinstance(node, Element) or node.is_definition:
            continue
        redefined = member.redefined()
        replaced = [symbol for symbol in redefined if symbol in symbols]
        if node.kind not in ("part", "item") and not (node.kind == "" and replaced):
            continue
        if "ref" in node.prefixes and not replaced:
            _forbid_data_on_reference(member)
            continue
        _forbid_variation(member)
        if replaced:
            symbols[replaced[0]] = member
            for symbol in replaced[1:]:
                del symbols[symbol]
            continue
        _forbid_redefined(member, redefined, symbols)
        before = names.get(member.name) if member.name else None
        if before is not None and symbols.get(before) is before:
            line = before.location().line
            text = f"inherited from line {line} already; write 'part :>> {member.name}' to redefine"
            if before in general.members:
                text = f"declared in line {line} already; write a multiplicity for several of"
            raise HardwareError(
                f"'{member.name}' is {text} it, or give it another name", member.location()
            )
        symbols[member] = member
        if member.name:
            names[member.name] = member
    return dict.fromkeys(symbols.values())


def _forbid_redefined(
    member: Symbol, redefined: tuple[Symbol, ...], found: dict[Symbol, Symbol]
) -> None:
    """Refuse to redefine what another part has redefined already: it would count twice."""
    for symbol in found if redefined else ():
        if any(every in redefined for every in ancestors(symbol) if every is not symbol):
            raise HardwareError(
                f"redefines the same part as '{symbol.name}'; write 'part :>> {symbol.name}'",
                member.location(),
            )


def _forbid_data_on_reference(member: Symbol) -> None:
    if any(annotation.kind is not None for annotation in own_annotations(member)):
        raise HardwareError(
            f"'{member.name}' is a reference, not a part; put the data where the part is declared",
            member.location(),
        )


def _forbid_variation(member: Symbol) -> None:
    node = member.node
    assert isinstance(node, Element)
    for word in ("variation", "variant"):
        if word in node.prefixes:
            raise HardwareError(
                f"'{member.name}' is a {word}, so the parts are not fixed; describe one "
                "configuration, without variation points",
                member.location(),
            )


def _check_circle(place: Place, part: Symbol) -> None:
    if len(place.way) > MAX_NESTING or part in place.way:
        names = " > ".join(str(symbol.name) for symbol in (*place.way[-3:], part))
        raise HardwareError(
            f"a part contains itself, or parts nest more than {MAX_NESTING} levels deep: {names}",
            part.location(),
        )


def _is_abstract(part: Symbol) -> bool:
    return isinstance(part.node, Element) and "abstract" in part.node.prefixes


def _is_covered(part: Symbol, subsetters: list[Symbol]) -> bool:
    """Whether the parts that are subsets of `part` are all there is of it."""
    if not subsetters:
        return False
    bounds = multiplicity(part)
    counts = [multiplicity(subsetter) or (1, 1) for subsetter in subsetters]
    if bounds is None or bounds[1] is None:
        return True
    total = sum(low for low, _ in counts)
    if bounds[0] == bounds[1] == total and all(low == high for low, high in counts):
        return True
    names = ", ".join(f"'{subsetter.name}'" for subsetter in subsetters)
    raise HardwareError(
        f"'{part.name}' has {_text(bounds)} units, but the parts that are subsets of it, {names}, "
        f"have {total}; name every unit, or none",
        part.location(),
    )


def _text(bounds: tuple[int, int | None]) -> str:
    low, high = bounds
    return str(low) if low == high else f"{low}..{'*' if high is None else high}"


def multiplicity(part: Symbol) -> tuple[int, int | None] | None:
    """Return the bounds of a part's multiplicity, its own or that of what it redefines.

    `None` where nothing was said, which is one unit.
    """
    waiting = [part]
    seen = {part}
    while waiting:
        each = waiting.pop(0)
        if isinstance(each.node, Element) and each.node.multiplicity is not None:
            return _bounds(each, each.node.multiplicity)
        for general in each.redefined():
            if general not in seen:
                seen.add(general)
                waiting.append(general)
    return None


def _bounds(part: Symbol, given: Multiplicity) -> tuple[int, int | None]:
    low, high = given.lower, given.upper
    if isinstance(low, Reference) or isinstance(high, Reference):
        named = low if isinstance(low, Reference) else high
        raise HardwareError(
            f"'{named}' is not a number of units; write the whole number itself",
            part.location(given.at),
        )
    if high is not None and low > high:
        raise HardwareError(
            f"a multiplicity of {_text((low, high))} allows no units; write the lower bound first",
            part.location(given.at),
        )
    return low, high


def product(outer: tuple[int, int | None], inner: tuple[int, int | None]) -> tuple[int, int | None]:
    """Return the bounds of the number of units in all, of `inner` in each of `outer`."""
    high = None if outer[1] is None or inner[1] is None else outer[1] * inner[1]
    return outer[0] * inner[0], high
