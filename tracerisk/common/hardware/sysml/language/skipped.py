"""List what of a file was skipped, and refuse what would be lost with it."""

from __future__ import annotations

from tracerisk.common.hardware.sysml.annotations import KINDS, elements_in
from tracerisk.common.hardware.sysml.language.name_resolution import Symbol, ancestors
from tracerisk.common.hardware.sysml.language.standard_names import OURS, Standard
from tracerisk.common.hardware.sysml.language.syntax import Reference, Skipped
from tracerisk.errors import HardwareError


def skipped_warnings(files: tuple[Symbol, ...]) -> tuple[str, ...]:
    """Return a line for each kind of element that was skipped in a file, with its first place.

    Raises HardwareError at one that holds our metadata, which would be lost.
    """
    warnings = []
    for top in files:
        counts: dict[str, list[int]] = {}
        for scope, node in _skipped(top):
            for target in node.metadata:
                if _is_ours(scope, target):
                    raise HardwareError(
                        f"'{target}' is inside '{node.word} ...', which is not read; describe "
                        "hardware by parts",
                        scope.location(target.at),
                    )
            counts.setdefault(node.word, []).append(node.at)
        for word, offsets in counts.items():
            number = f"{len(offsets)} elements are" if len(offsets) > 1 else "an element is"
            warnings.append(
                f"{top.location(offsets[0])}: '{word}': {number} skipped; behaviour, "
                "requirements and connections are not part of the hardware description"
            )
    return tuple(warnings)


def missing_warnings(files: tuple[Symbol, ...]) -> tuple[str, ...]:
    """Return a line for each file with imports that lead to nothing, with the first of them."""
    warnings = []
    for top in files:
        errors = [error for symbol in elements_in(top) for _, error in symbol.imports.missing]
        if errors:
            more = f" ({len(errors) - 1} more like it)" if len(errors) > 1 else ""
            why = "this import leads to nothing, and no part of the system needs it"
            warnings.append(f"{errors[0]}; {why}{more}")
    return tuple(warnings)


def _skipped(top: Symbol) -> list[tuple[Symbol, Skipped]]:
    pairs = [
        (symbol, node)
        for symbol in elements_in(top)
        for node in symbol.nodes
        if isinstance(node, Skipped)
    ]
    return sorted(pairs, key=lambda pair: pair[1].at)


def _is_ours(scope: Symbol, target: Reference) -> bool:
    hit = scope.lookup(target)
    kin = ancestors(hit) if isinstance(hit, Symbol) else (hit,)
    return any(
        isinstance(standard, Standard) and standard.path[0] == OURS and standard.path[-1] in KINDS
        for standard in kin
    )
