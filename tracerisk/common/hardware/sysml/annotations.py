"""The metadata on an element that describe hardware, its own or inherited, with their values."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass

from tracerisk.common.hardware.sysml.language.name_resolution import (
    Symbol,
    ancestors,
)
from tracerisk.common.hardware.sysml.language.standard_names import (
    FEATURES,
    LEVELS,
    OURS,
    RISK,
    RISK_FEATURES,
    WITH_METADATA,
    Standard,
)
from tracerisk.common.hardware.sysml.language.syntax import (
    Annotation,
    Element,
    Expression,
    Member,
    Package,
    Reference,
)
from tracerisk.errors import HardwareError, Location, one_of

KINDS = ("FailureData", "FailureMode", "HardwareData", "Redundancy", "TwinBinding")
"""Our metadata."""

OF_FAILURES = re.compile(r"\b(?:TraceriskHardware|FailureData|RiskMetadata)\b")
"""What a text has in it that may give failure data."""

_NESTED = {
    "weibull": "Weibull",
    "loadLaw": "LoadLaw",
    "temperature": "Temperature",
    "totalRisk": "RiskLevel",
    "technicalRisk": "RiskLevel",
    "scheduleRisk": "RiskLevel",
    "costRisk": "RiskLevel",
}
_ALL_FEATURES = {**FEATURES, **RISK_FEATURES}


@dataclass(frozen=True, slots=True)
class Given:
    """What a feature of a metadata was given: an expression, or features of its own."""

    expression: Expression | None
    """The expression; `None` where features of its own are given."""
    scope: Symbol
    """The element in which the names of the expression are looked up."""
    at: int
    """The offset of the feature in the file's text [characters]."""
    nested: dict[str, Given]
    """The features of its own, by name; empty where an expression is given."""

    @property
    def location(self) -> Location:
        """Where the value, else the feature, stands."""
        return self.scope.location(self.at if self.expression is None else self.expression.at)


@dataclass(frozen=True, slots=True)
class Metadata:
    """A metadata usage."""

    symbol: Symbol
    """The usage in the symbol table."""
    kind: str | None
    """The kind of the metadata, one of `KINDS` or `Risk`; `None` for one that is not read."""
    standard: Standard | None
    """The library definition behind the kind; `None` where `kind` is `None`."""

    @property
    def location(self) -> Location:
        """Where it stands."""
        return self.symbol.location()

    def values(self) -> dict[str, Given]:
        """Return the values of its features: its own, else those of its definitions.

        Raises HardwareError at a feature that the metadata does not have.
        """
        assert self.kind is not None
        own = self._declared()
        values: dict[str, Given] = {}
        for ancestor in self._upwards():
            for node in _features(ancestor.nodes):
                steps = _feature_path(node)
                if steps[0] not in own or steps[0] in _ALL_FEATURES[self.kind]:
                    _read_feature(node, steps, ancestor, self.kind, values)
        return values

    def own_values(self) -> dict[str, Given]:
        """Return the values of features that its definitions declare beside those of the kind."""
        own = self._declared()
        return {
            name: Given(node.value.expression, ancestor, node.at, {})
            for ancestor in self._upwards()
            for node in _features(ancestor.nodes)
            if node.value is not None and (name := _feature_path(node)[0]) in own
        }

    def _declared(self) -> set[str | None]:
        """Return the names of the features that its definitions declare."""
        return {
            node.name
            for ancestor in self._upwards()
            if ancestor is not self.symbol
            for node in _features(ancestor.nodes)
            if not node.redefines and node.bare is None
        }

    def _upwards(self) -> list[Symbol]:
        """Return what it specialises, as far as it is declared in the files, and it; it last."""
        return [item for item in reversed(ancestors(self.symbol)) if isinstance(item, Symbol)]


def _features(members: tuple[Member, ...]) -> list[Element]:
    """Return the usages among what stands in a metadata, its definition or a feature of it."""
    return [node for node in members if isinstance(node, Element) and not node.is_definition]


def _feature_path(node: Element) -> tuple[str, ...]:
    """Return the name of the feature that an element binds, of several where it has dots."""
    target = node.redefines[0] if node.redefines else node.bare
    if target is not None:
        return (target.name[-1], *(step[-1] for step in target.steps))
    return (node.name or "",)


def _read_feature(
    node: Element, steps: tuple[str, ...], scope: Symbol, kind: str, found: dict[str, Given]
) -> None:
    name = steps[0]
    allowed = _ALL_FEATURES[kind]
    if name not in allowed:
        is_new = node.kind != "" and not node.redefines
        if is_new:
            return  # an attribute of a metadata definition's own, for its values to refer to
        raise HardwareError(
            f"{kind} has no feature '{name}'; {one_of(allowed, name)}", scope.location(node.at)
        )
    inner = _NESTED.get(name)
    before = found.get(name)
    if len(steps) > 1:
        nested = dict(before.nested) if before is not None else {}
        if inner is None:
            raise HardwareError(f"'{name}' has no features of its own", scope.location(node.at))
        _read_feature(node, steps[1:], scope, inner, nested)
        found[name] = Given(None, scope, node.at, nested)
        return
    if inner is not None and node.value is None:
        nested = dict(before.nested) if before is not None else {}
        for member in _features(node.members):
            _read_feature(member, _feature_path(member), scope, inner, nested)
        found[name] = Given(None, scope, node.at, nested)
    elif node.value is not None:
        found[name] = Given(node.value.expression, scope, node.at, {})


def elements_in(top: Symbol) -> Iterator[Symbol]:
    """Yield an element, and those within it that can have members, in the order of the file."""
    if isinstance(top.node, Package | Element):
        yield top
        for member in top.members:
            yield from elements_in(member)


def own_annotations(symbol: Symbol) -> list[Metadata]:
    """Return the metadata that are written on an element itself."""
    node = symbol.node
    if not isinstance(node, Element):
        return []
    annotations = [
        metadata(member)
        for member in symbol.members
        if isinstance(member.node, Annotation) and not member.node.about
    ]
    for mark in node.annotations:
        placed = Symbol(mark, symbol.owner, symbol.source, symbol.find_package)
        annotations.append(metadata(placed))
    return annotations


def metadata(symbol: Symbol) -> Metadata:
    """Return a metadata usage with its kind.

    Raises HardwareError where its definition is not known.
    """
    node = symbol.node
    assert isinstance(node, Annotation)
    scope = symbol.scope()
    hit = scope.lookup(node.type)
    if hit is None:
        if scope.imports.may_bring(node.type, WITH_METADATA):
            return Metadata(symbol, None, None)
        raise scope.unknown(node.type)
    standards = [hit] if isinstance(hit, Standard) else list(ancestors(hit))
    for standard in standards:
        if isinstance(standard, Standard):
            kind = _kind(standard)
            if kind is not None:
                return Metadata(symbol, kind, standard)
    return Metadata(symbol, None, None)


def _kind(standard: Standard) -> str | None:
    if len(standard.path) != 2:
        return None
    package, name = standard.path
    if (package == OURS and name in KINDS) or (package == RISK and name == "Risk"):
        return name
    return None


class Annotations:
    """The metadata of elements, those that stand elsewhere and are `about` them included."""

    def __init__(self) -> None:
        self._about: dict[Symbol, list[Metadata]] = {}
        self._own: dict[Symbol, list[Metadata]] = {}

    def collect_about(self, top: Symbol) -> None:
        """Note each metadata of a file that is about other elements."""
        if "about" not in top.source.text:
            return
        waiting = [top]
        while waiting:
            symbol = waiting.pop()
            if isinstance(symbol.node, Annotation) and symbol.node.about:
                self._note(symbol, symbol.node)
            elif isinstance(symbol.node, Package | Element):
                waiting.extend(reversed(symbol.members))

    def _note(self, symbol: Symbol, node: Annotation) -> None:
        scope = symbol.scope()
        known = metadata(symbol)
        if known.kind is None:
            return
        for target in node.about:
            hit = scope.lookup(target)
            if not isinstance(hit, Symbol):
                if known.kind == "Risk" and scope.imports.is_skipped(target.name):
                    continue  # a risk of behaviour
                raise scope.unknown(target)
            full = (*target.name, *(name for step in target.steps for name in step))
            if len(full) > 1 and hit.owner is not None:
                outer = scope.lookup(type(target)(full[:-1], target.at))
                if isinstance(outer, Symbol) and hit.owner is not outer:
                    raise HardwareError(
                        f"'{full[-1]}' is inherited by '{full[-2]}', and the data would apply to "
                        f"every part that inherits it; redefine it there ('part :>> {full[-1]}')",
                        scope.location(target.at),
                    )
            self._about.setdefault(hit, []).append(known)

    def targets(self) -> tuple[Symbol, ...]:
        """Return the elements that metadata elsewhere are about."""
        return tuple(self._about)

    def outside(self, inside: Collection[object], tops: Sequence[Symbol]) -> list[Symbol]:
        """Return the elements with failure data of their own that are not among some."""
        lost = []
        for symbol in (symbol for top in tops for symbol in elements_in(top)):
            if symbol not in inside:
                with suppress(HardwareError):  # of metadata that nothing needs
                    if any(metadata.kind == "FailureData" for metadata in self.own(symbol)):
                        lost.append(symbol)
        return lost

    def own(self, symbol: Symbol) -> list[Metadata]:
        """Return the metadata on an element itself, those about it included."""
        own = self._own.get(symbol)
        if own is None:
            own = self._own[symbol] = own_annotations(symbol) + self._about.get(symbol, [])
        return own

    def of(self, symbol: Symbol, *kinds: str) -> list[Metadata]:
        """Return the metadata of some kinds that hold for an element: its own, else inherited.

        Nearer ones take the place of those further off. Raises HardwareError where two elements
        of which none specialises the other give some.
        """
        sources = self._sources(symbol, kinds)
        if len(sources) > 1:
            names = " and ".join(f"'{source}'" for source in sources)
            raise HardwareError(
                f"'{symbol.name}' inherits {kinds[0]} from {names}; annotate it directly",
                symbol.location(),
            )
        return (
            [metadata for metadata in self.own(sources[0]) if metadata.kind in kinds]
            if sources
            else []
        )

    def _sources(self, symbol: Symbol, kinds: tuple[str, ...]) -> list[Symbol]:
        if self._gives(symbol, kinds):
            return [symbol]
        givers = [
            ancestor
            for ancestor in ancestors(symbol)
            if isinstance(ancestor, Symbol) and self._gives(ancestor, kinds)
        ]
        if len(givers) < 2:
            return givers
        return [
            giver
            for giver in givers
            if not any(giver is not other and giver in ancestors(other) for other in givers)
        ]

    def _gives(self, symbol: Symbol, kinds: tuple[str, ...]) -> bool:
        return any(
            metadata.kind in kinds and (metadata.kind != "Risk" or _has_number(metadata))
            for metadata in self.own(symbol)
        )


def _has_number(risk: Metadata) -> bool:
    """Whether a `@Risk` may give a probability, and not only a level such as `high`."""
    total = risk.values().get("totalRisk")
    if total is None:
        return False
    expression = total.expression
    if not isinstance(expression, Reference):
        return expression is not None or "probability" in total.nested
    hit = total.scope.lookup(expression)
    return not (isinstance(hit, Standard) and hit.path[-1] in LEVELS)
