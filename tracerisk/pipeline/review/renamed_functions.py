"""Functions that only bear another name in the later version of a controller.

A function that is gone and one that is new are the same one if they do the same: if their code is
the same but for the name, or, where it is not, if their blocks say the same.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Collection, Hashable, Iterable, Mapping
from typing import NamedTuple

from tracerisk.adder.blocks.block import RiskBlock
from tracerisk.adder.blocks.values import component_fields
from tracerisk.adder.sources.python_lines import parse_python
from tracerisk.common.function_ref import FunctionRef
from tracerisk.instrument.source.function_definitions import definitions
from tracerisk.instrument.source.language import is_c_like
from tracerisk.prm.review.change_records import is_noise


class FunctionSource(NamedTuple):
    """A function's block, and its place."""

    block: RiskBlock
    """The risk block of the function."""
    file: str
    """The path of the source from the top."""
    name: str
    """The qualified name in the file."""


def renamed_functions(
    before: Mapping[str, FunctionSource],
    after: Mapping[str, FunctionSource],
    sources: tuple[Mapping[str, bytes], Mapping[str, bytes]],
) -> dict[str, str]:
    """Return the later name of each function that was renamed, by its earlier one.

    `sources` are the two versions' files, which can be read as what they are.
    """
    gone = {name: function_source for name, function_source in before.items() if name not in after}
    new = {name: function_source for name, function_source in after.items() if name not in before}
    if not gone or not new:
        return {}
    codes = (
        _codes({function.file for function in gone.values()}, sources[0]),
        _codes({function.file for function in new.values()}, sources[1]),
    )
    pairs = _pairs(
        {
            name: codes[0].get((function_source.file, function_source.name))
            for name, function_source in gone.items()
        },
        {
            name: codes[1].get((function_source.file, function_source.name))
            for name, function_source in new.items()
        },
        lambda one, other: one == other,
    )
    left = (
        {
            name: function_source.block
            for name, function_source in gone.items()
            if name not in pairs
        },
        {
            name: function_source.block
            for name, function_source in new.items()
            if name not in pairs.values()
        },
    )
    return {**pairs, **_pairs(left[0], left[1], _say_the_same)}


def renamed_without_block(
    before: Collection[FunctionRef],
    after: Collection[FunctionRef],
    sources: tuple[Mapping[str, bytes], Mapping[str, bytes]],
    renamed: Mapping[str, str],
) -> dict[str, str]:
    """Return the later name of functions without a block, such as those that never ran.

    `renamed` are the functions with blocks that were renamed: what shares a class with one has
    that class's new name. Other functions are the same one if their code is.
    """
    gone = [ref for ref in before if ref not in after]
    new = [ref for ref in after if ref not in before]
    if not gone or not new:
        return {}
    pairs = (_without_common_end(old, name) for old, name in renamed.items())
    classes = {pair for pair in pairs if pair is not None}
    names = {ref.name for ref in new}
    by_class = {
        str(ref.name): moved
        for ref in gone
        for old, name in sorted(classes)
        if ref.name.startswith(f"{old}.") and (moved := name + ref.name.removeprefix(old)) in names
    }
    codes = [
        _codes({ref.file for ref in refs}, version)
        for refs, version in zip((gone, new), sources, strict=True)
    ]
    by_code = _pairs(
        {ref.name: codes[0].get((ref.file, ref.name)) for ref in gone},
        {ref.name: codes[1].get((ref.file, ref.name)) for ref in new},
        lambda one, other: one == other,
    )
    return {**by_code, **by_class}


def _without_common_end(old: str, new: str) -> tuple[str, str] | None:
    """Return the classes of one method before and after its class was renamed; else `None`."""
    class_of, _, method = old.rpartition(".")
    now, _, name = new.rpartition(".")
    return (class_of, now) if method == name and class_of and now else None


def _pairs(
    gone: Mapping[str, Hashable | None],
    new: Mapping[str, Hashable | None],
    same: Callable[..., bool],
) -> dict[str, str]:
    """Return what belongs together where each has one other only."""
    fits = {
        old: [name for name, other in new.items() if other is not None and same(one, other)]
        for old, one in gone.items()
        if one is not None
    }
    chosen = [names[0] for names in fits.values() if len(names) == 1]
    return {
        old: names[0]
        for old, names in fits.items()
        if len(names) == 1 and chosen.count(names[0]) == 1
    }


def without_step(
    before: Mapping[str, FunctionSource],
    after: Mapping[str, FunctionSource],
    sources: Mapping[str, bytes],
) -> tuple[str, ...]:
    """Return the functions that had a block and are still there without one, by their names.

    `sources` are the files of the later version.
    """
    gone = {name: function for name, function in before.items() if name not in after}
    codes = _codes({function.file for function in gone.values()}, sources) if gone else {}
    return tuple(sorted(name for name, one in gone.items() if (one.file, one.name) in codes))


def _codes(files: Iterable[str], sources: Mapping[str, bytes]) -> dict[tuple[str, str], str]:
    """Return what each function does, as text without its name, by file and qualified name."""
    codes = {}
    for file in sorted(file for file in files if file in sources and not is_c_like(file)):
        tree = parse_python(sources[file], file).tree
        lines = {definition.line: definition.name for definition in definitions(tree)}
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and node.lineno in lines:
                parts = [node.args, *node.body]
                codes[(file, str(lines[node.lineno]))] = "\n".join(map(ast.dump, parts))
    return codes


def _say_the_same(one: RiskBlock, other: RiskBlock) -> bool:
    if one.call_sequence.value != other.call_sequence.value or not one.components:
        return False
    earlier = {entry.name: entry for entry in one.components}
    later = {entry.name: entry for entry in other.components}
    return earlier.keys() == later.keys() and all(
        kind.same(value.value, new.value) or (kind.is_noisy and is_noise(value.value, new.value))
        for name, entry in earlier.items()
        for (kind, value), (_, new) in zip(
            component_fields(entry), component_fields(later[name]), strict=False
        )
    )
