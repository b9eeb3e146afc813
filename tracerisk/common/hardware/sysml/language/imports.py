"""What a namespace imports: members of packages, packages below them, of libraries or files."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from tracerisk.common.hardware.sysml.language.standard_names import (
    OURS,
    RISK,
    Standard,
    known_members,
)
from tracerisk.common.hardware.sysml.language.syntax import (
    Alias,
    Annotation,
    Import,
    Name,
    Package,
    Reference,
    Skipped,
)
from tracerisk.errors import HardwareError

if TYPE_CHECKING:
    from tracerisk.common.hardware.sysml.language.name_resolution import Found, Symbol


class Imports:
    """The imports of one namespace, and what they name."""

    __slots__ = ("_asked", "_found", "_space", "missing")

    def __init__(self, space: Symbol) -> None:
        self._space = space
        self._found: list[tuple[Import, Found]] | None = None
        self._asked: set[str] = set()
        self.missing: list[tuple[Import, HardwareError]] = []
        """The imports that lead to nothing, as far as they were looked up, and why."""

    def named(self, name: str, *, public_only: bool = False) -> Found | None:
        """Return what is imported by a name; `None` for nothing."""
        spaces = self._spaces()
        if name in self._asked:
            return None  # packages that import each other
        self._asked.add(name)
        try:
            for item, space in spaces:
                if not (public_only and item.is_private):
                    hit = _through(item, space, name)
                    if hit is not None:
                        return hit
        finally:
            self._asked.remove(name)
        return None

    def _spaces(self) -> list[tuple[Import, Found]]:
        """Return the imports of this namespace with what they name.

        An import may name what another one brings. One that names nothing is `missing`: an error
        where a name may come from it.
        """
        if self._found is not None:
            return self._found
        # What is found so far helps to find the rest.
        imports = self._found = []
        left = [member for member in self._space.nodes if isinstance(member, Import)]
        count = -1
        while len(left) != count:
            count = len(left)
            left = [item for item in left if not self._is_done(item, imports)]
        return imports

    def _is_done(self, item: Import, imports: list[tuple[Import, Found]]) -> bool:
        """Note what an import names; return whether there is anything, read or not."""
        self.missing = [pair for pair in self.missing if pair[0] is not item]
        try:
            space = self._space.lookup(item.target)
        except HardwareError as error:
            self.missing.append((item, error))
            return False
        if space is not None:
            imports.append((item, space))
        elif not self.is_skipped(item.target.name):
            self.missing.append((item, self._space.unknown(item.target)))
            return False
        return True

    def cause(self, name: str) -> HardwareError | None:
        """Return the error of the missing import, here or around, that may have had a name."""
        scope: Symbol | None = self._space
        while scope is not None:
            for item, error in scope.imports.missing:
                if item.every or item.recursive or item.target.name[-1] == name:
                    return error
            scope = scope.owner
        return None

    def is_skipped(self, name: Name) -> bool:
        """Whether a name leads into an element that is not read, such as an action."""
        spaces: list[Found | None] = [self._space]
        owner = self._space.owner
        while owner is not None:
            spaces.append(owner)
            owner = owner.owner
        for index, segment in enumerate(name):
            namespaces = [
                space for space in spaces if space is not None and not isinstance(space, Standard)
            ]
            if any(space.imports.skips(segment) for space in namespaces):
                return True
            spaces = [self._space.qualified(name[: index + 1])]
        return False

    def skips(self, name: str) -> bool:
        """Whether what is not read has a name here, or in what is imported whole so far."""
        waiting, seen = [self._space], {self._space}
        while waiting:
            space = waiting.pop()
            if any(isinstance(node, Skipped) and node.name == name for node in space.nodes):
                return True
            for item, imported in space.imports._found or ():
                if item.every and not isinstance(imported, Standard) and imported not in seen:
                    seen.add(imported)
                    waiting.append(imported)
        return False

    def open_libraries(self) -> Iterator[Standard]:
        """Yield the library packages that are imported here or around, not all names known."""
        scope: Symbol | None = self._space
        seen: set[Symbol] = set()
        while scope is not None:
            yield from scope.imports._open(seen, public_only=False)
            scope = scope.owner

    def _open(self, seen: set[Symbol], *, public_only: bool) -> Iterator[Standard]:
        """Yield those of this namespace, and of the packages that it imports."""
        seen.add(self._space)
        for item, space in self._spaces():
            if (public_only and item.is_private) or not (item.every or item.recursive):
                continue
            if isinstance(space, Standard):
                if not space.is_closed:
                    yield space
                continue
            waiting = [space]
            while waiting:
                package = waiting.pop()
                if package in seen or isinstance(package.node, Alias):
                    continue
                yield from package.imports._open(seen, public_only=not item.overrides_private)
                waiting += package.members if item.recursive else ()

    def may_bring(self, target: Reference, packages: frozenset[str]) -> bool:
        """Whether one of some library packages that are imported here may have the name."""
        known = known_members((OURS,)) + known_members((RISK,))
        return (
            len(target.name) == 1
            and target.name[0] not in known
            and any(library.path[0] in packages for library in self.open_libraries())
        )


def _through(item: Import, space: Found, name: str) -> Found | None:
    """Return what an import brings by a name."""
    if not (item.every or item.recursive):
        if item.target.name[-1] == name:
            return space
        is_named = not isinstance(space, Standard) and not isinstance(space.node, Annotation)
        return space if is_named and space.node.short == name else None  # type: ignore[union-attr]
    if isinstance(space, Standard):
        return space.member(name) if space.offers(name) else None
    if item.recursive:
        return _below(space, name)
    if not isinstance(space.node, Package):
        return space.member(name)
    hit = space.exported(name)
    return space.imports.named(name) if hit is None and item.overrides_private else hit


def _below(space: Symbol, name: str) -> Found | None:
    """Return what is called `name` in a namespace or in a package below it."""
    waiting = [space]
    while waiting:
        package = waiting.pop(0)
        hit = package.exported(name)
        if hit is not None:
            return hit
        waiting += [member for member in package.members if isinstance(member.node, Package)]
    return None
