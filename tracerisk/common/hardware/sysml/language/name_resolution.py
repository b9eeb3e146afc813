"""Find what a name stands for: members, inherited members, what is imported, files beside."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TypeAlias

from tracerisk.common.hardware.sysml.language.imports import Imports
from tracerisk.common.hardware.sysml.language.standard_names import (
    OF_ITEMS,
    WITH_PARTS,
    Standard,
)
from tracerisk.common.hardware.sysml.language.syntax import (
    Alias,
    Annotation,
    Element,
    Member,
    Name,
    Package,
    Reference,
    SourceText,
)
from tracerisk.errors import HardwareError, Location, one_of

MAX_CHAIN = 100
"""How many definitions may specialise one another in a row, and names lead to names."""

Found: TypeAlias = "Symbol | Standard"


class Symbol:
    """An element of the model, with its place among the others.

    `find_package` finds packages that no file around the element declares.
    """

    __slots__ = (
        "_active", "_by_name", "_generals", "_members", "_seen", "find_package",
        "has_unknown_general", "imports", "kin", "node", "owner", "source",
    )  # fmt: skip

    def __init__(
        self,
        node: Package | Element | Annotation | Alias,
        owner: Symbol | None,
        source: SourceText,
        find_package: Callable[[Name, Location], Found | None],
    ) -> None:
        self.node = node
        self.owner = owner
        self.source = source
        self.find_package = find_package
        self._members: tuple[Symbol, ...] | None = None
        self._by_name: dict[str, Symbol] | None = None
        self._generals: tuple[Found, ...] | None = None
        self._active = False
        self.kin: tuple[Found, ...] | None = None
        self._seen: dict[str, Found | None] = {}
        self.imports = Imports(self)
        self.has_unknown_general = False

    def location(self, at: int | None = None) -> Location:
        """Return where the element stands, or the offset `at` of its file."""
        return self.source.location(self.node.at if at is None else at)

    @property
    def name(self) -> str | None:
        """The declared name; of an element that only redefines, that of what it redefines."""
        node = self.node
        if isinstance(node, Element):
            if node.name is None and node.short is None and node.redefines:
                target = node.redefines[0]
                return (target.steps[-1] if target.steps else target.name)[-1]
            return node.name if node.name is not None else node.short
        return node.name

    def __str__(self) -> str:
        names: list[str] = []
        symbol: Symbol | None = self
        while symbol is not None and symbol.owner is not None:
            names.append(symbol.name or "...")
            symbol = symbol.owner
        return "::".join(reversed(names))

    @property
    def nodes(self) -> tuple[Member, ...]:
        """What stands within, as the syntax tree has it."""
        return () if isinstance(self.node, Alias) else self.node.members

    @property
    def members(self) -> tuple[Symbol, ...]:
        """The elements declared within, in the order of the file."""
        if self._members is None:
            self._members = tuple(
                Symbol(node, self, self.source, self.find_package)
                for node in self.nodes
                if isinstance(node, Package | Element | Annotation | Alias)
            )
        return self._members

    def own(self, name: str) -> Symbol | None:
        """Return the element declared within by that name or short name.

        Raises HardwareError where two are called alike.
        """
        return self._names().get(name)

    @property
    def names(self) -> tuple[str, ...]:
        """The names and short names of the elements declared within."""
        return tuple(self._names())

    def _names(self) -> dict[str, Symbol]:
        if self._by_name is None:
            symbols: dict[str, Symbol] = {}
            for member in self.members:
                node = member.node
                names = {member.name, None if isinstance(node, Annotation) else node.short}
                if isinstance(node, Element) and node.name is None and _is_chain(node):
                    names = {node.short}  # a value for a feature of a feature, `:>> arm.speed = 1`
                for key in sorted(filter(None, names)):
                    if key in symbols:
                        before = symbols[key].location()
                        raise HardwareError(
                            f"duplicate '{key}', first in line {before.line}; give it another name",
                            member.location(),
                        )
                    symbols[key] = member
            self._by_name = symbols
        return self._by_name

    # What an element specialises.

    def generals(self) -> tuple[Found, ...]:
        """Return what the element redefines, subsets and has as its type, in this order.

        Raises HardwareError at a name that stands for nothing, where the element can hold
        failure data.
        """
        if self._generals is not None:
            return self._generals
        node = self.node
        if isinstance(node, Annotation):
            self._generals = (self.scope().resolve(node.type),)
            return self._generals
        if not isinstance(node, Element) or self._active:
            return ()
        self._active = True
        try:
            symbols: list[Found | None] = [self.hidden()]
            symbols += [self._redefined(target) for target in node.redefines]
            symbols += [self._resolve_general(target) for target in (*node.subsets, *node.types)]
            self._generals = tuple(dict.fromkeys(item for item in symbols if item is not None))
        finally:
            self._active = False
        return self._generals

    @property
    def is_settled(self) -> bool:
        """Whether all that the element specialises is known, and it is not being looked up."""
        return self._generals is not None or not isinstance(self.node, Element | Annotation)

    def scope(self) -> Symbol:
        """Return the namespace in which the names of the element's declaration are looked up."""
        return self if self.owner is None else self.owner

    @property
    def is_structural(self) -> bool:
        """Whether the element is one whose generals may bring failure data."""
        return isinstance(self.node, Element) and self.node.kind in ("part", "item", "metadata")

    def redefined(self) -> tuple[Symbol, ...]:
        """Return the features that the element redefines."""
        if not isinstance(self.node, Element):
            return ()
        targets = [self.hidden(), *map(self._redefined, self.node.redefines)]
        return tuple(target for target in targets if isinstance(target, Symbol))

    def hidden(self) -> Symbol | None:
        """Return the inherited part that a part of the same name stands for without `:>>`."""
        node = self.node
        if not isinstance(node, Element) or not node.is_part or node.redefines:
            return None
        if node.name is None or "ref" in node.prefixes:
            return None
        hit = self.scope().inherited(node.name)
        is_part = isinstance(hit, Symbol) and isinstance(hit.node, Element) and hit.node.is_part
        return hit if is_part and hit is not self else None  # type: ignore[return-value]

    def _redefined(self, target: Reference) -> Found | None:
        owner = self.scope()
        if not target.steps and len(target.name) == 1:
            hit = owner.inherited(target.name[0])
            if hit is not None:
                return hit
            if any(
                isinstance(ancestor, Standard) or ancestor.has_unknown_general
                for ancestor in ancestors(owner)
            ):
                return None
            if not self.is_structural:
                return None
            names = sorted(
                {inherited_member.name or "" for inherited_member in inherited_members(owner)}
                - {""}
            )
            raise HardwareError(
                f"redefines '{target}', which its owner does not inherit; "
                f"{one_of(names, target.name[0])}",
                self.location(target.at),
            )
        return self._resolve_general(target)

    def _resolve_general(self, target: Reference) -> Found | None:
        hit = self.scope().lookup(target)
        if hit is None:
            if self.is_structural and not self.scope().imports.may_bring(target, WITH_PARTS):
                raise self.unknown(target)
            self.has_unknown_general = True
        return None if hit is self else hit

    # Looking up names.

    def resolve(self, target: Reference) -> Found:
        """Return what a name stands for; raise HardwareError where it is nothing."""
        hit = self.lookup(target)
        if hit is None:
            raise self.unknown(target)
        return hit

    def lookup(self, target: Reference) -> Found | None:
        """Return what a name stands for as seen from within this namespace."""
        hit = self.qualified(target.name)
        for step in target.steps:
            for name in step:
                hit = None if hit is None else hit.member(name)
        return hit

    def qualified(self, name: Name) -> Found | None:
        """Return what a qualified name stands for as seen from within this namespace."""
        hit = self._first(name[0])
        for index, segment in enumerate(name[1:], start=1):
            if hit is None:
                return None
            if isinstance(hit, Symbol) and isinstance(hit.node, Package):
                hit = hit.exported(segment) or hit.continued(segment)
            else:
                hit = hit.member(segment)
            if index >= MAX_CHAIN:
                return None
        return hit

    def _first(self, name: str) -> Found | None:
        scope: Symbol | None = self
        while scope is not None:
            hit = scope.visible(name)
            if hit is not None:
                return hit
            top = scope
            scope = scope.owner
        return top.find_package((name,), self.location()) or self.continued(name)

    def continued(self, name: str) -> Found | None:
        """Return what another file declares by a name in a package around that has one name."""
        scope: Symbol | None = self
        while scope is not None and scope.owner is not None:
            if isinstance(scope.node, Package) and scope.path is not None:
                hit = self.find_package((*scope.path, name), self.location())
                if hit is not None:
                    return hit
            scope = scope.owner
        return None

    @property
    def path(self) -> Name | None:
        """The names of the packages from the top of the file to this one; `None` for no package."""
        names: list[str] = []
        scope: Symbol | None = self
        while scope is not None and scope.owner is not None:
            if not isinstance(scope.node, Package) or scope.name is None:
                return None
            names.append(scope.name)
            scope = scope.owner
        return tuple(reversed(names))

    def visible(self, name: str) -> Found | None:
        """Return what `name` is in this namespace alone: own, inherited, then imported."""
        if name in self._seen:
            return self._seen[name]
        hit = _own(self, name) or self.inherited(name) or self.imports.named(name)
        if hit is not None:
            self._seen[name] = hit
        return hit

    def inherited(self, name: str) -> Found | None:
        """Return the member of that name that a general of this element has.

        A part without one has what every part has, such as a `shape`.
        """
        if not isinstance(self.node, Element | Annotation):
            return None
        for general in ancestors(self):
            if general is not self and isinstance(general, Symbol):
                hit = general.own(name)
                if hit is not None:
                    return hit
        has_features = isinstance(self.node, Element) and self.node.kind in ("part", "item")
        return Standard(("Items", "Item", name)) if has_features and name in OF_ITEMS else None

    def exported(self, name: str) -> Found | None:
        """Return what others see by `name` in this package: own, and what it imports publicly."""
        hit: Found | None = self.own(name)
        if isinstance(hit, Symbol) and isinstance(hit.node, Alias):
            return _aliased(hit)
        if hit is None and isinstance(self.node, Package):
            hit = self.imports.named(name, public_only=True)
        return hit

    def member(self, name: str) -> Found | None:
        """Return the member of this element by that name, its own or inherited."""
        hit = _own(self, name) or self.inherited(name)
        if hit is None and isinstance(self.node, Package):
            hit = self.exported(name)
        return hit

    def unknown(self, target: Reference) -> HardwareError:
        """Return the error for a name that stands for nothing."""
        from tracerisk.common.hardware.sysml.language.unknown_names import unknown_name

        cause = self.imports.cause(target.name[0])
        if cause is not None:
            return cause
        return HardwareError(unknown_name(self, target), self.location(target.at))


def _is_chain(node: Element) -> bool:
    return bool(node.redefines and node.redefines[0].steps)


def _own(space: Symbol, name: str) -> Found | None:
    """Return what is declared within by that name; of an alias, what it stands for."""
    hit = space.own(name)
    return _aliased(hit) if hit is not None and isinstance(hit.node, Alias) else hit


def _aliased(alias: Symbol) -> Found | None:
    """Return what an alias stands for; aliases of aliases are followed."""
    hit: Found | None = alias
    for _ in range(MAX_CHAIN):
        if not (isinstance(hit, Symbol) and isinstance(hit.node, Alias)):
            return hit
        target = hit.node.target
        scope = hit.scope()
        raw: Found | None = scope.own(target.name[0]) if len(target.name) == 1 else None
        hit = raw if raw is not None else scope.lookup(target)
    raise HardwareError(f"alias '{alias.name}' refers to itself", alias.location())


def ancestors(symbol: Symbol) -> tuple[Found, ...]:
    """Return an element and all that it specialises, each once, the nearer first.

    Raises HardwareError where elements specialise each other in a circle.
    """
    if symbol.kin is not None:
        return symbol.kin
    table: dict[Found, None] = {symbol: None}
    level: list[Found] = [symbol]
    for _ in range(MAX_CHAIN):
        following: list[Found] = []
        for item in level:
            if isinstance(item, Symbol):
                for general in item.generals():
                    if general is symbol:
                        raise HardwareError(
                            f"'{symbol.name}' specialises itself, through '{item.name}'; break "
                            "the cycle",
                            symbol.location(),
                        )
                    if general not in table:
                        table[general] = None
                        following.append(general)
        if not following:
            kin = tuple(table)
            if all(item.is_settled for item in kin if isinstance(item, Symbol)):
                symbol.kin = kin
            return kin
        level = following
    raise HardwareError(
        f"'{symbol.name}' has a chain of more than {MAX_CHAIN} specialisations",
        symbol.location(),
    )


def inherited_members(symbol: Symbol) -> Iterator[Symbol]:
    """Yield the members of all that an element specialises."""
    for general in ancestors(symbol):
        if general is not symbol and isinstance(general, Symbol):
            yield from general.members
