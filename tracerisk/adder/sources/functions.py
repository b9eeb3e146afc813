"""The functions of a source, in Python as in C and C++."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING

from tracerisk.adder.sources.edits import Edit, apply_edits, line_starts
from tracerisk.adder.sources.python_lines import parse_python
from tracerisk.common.function_ref import QualifiedName
from tracerisk.common.instance_name import is_name_at
from tracerisk.common.text.digests import short_digest
from tracerisk.errors import SourceError
from tracerisk.instrument.source.code_digest import code_digest
from tracerisk.instrument.source.function_definitions import MODULE, definitions
from tracerisk.instrument.source.language import is_c

if TYPE_CHECKING:
    from tracerisk.adder.sources.c_source import CFunction

_Spans = list[tuple[QualifiedName, int, int]]


def functions_in(source: bytes, file: str) -> list[tuple[QualifiedName, int]]:
    """Return the qualified name of each function, with the line on which it is defined.

    Code of a Python module is a function too, whose line is 1; it comes first.
    Raises SourceError where the source cannot be read, DependencyError for C and C++ without the
    extra `cpp`.
    """
    if is_c(file):
        return [(function.name, function.line) for function in _c_functions(source, file)]
    tree = parse_python(source, file).tree
    return [(MODULE, 1), *((definition.name, definition.line) for definition in definitions(tree))]


def _c_functions(source: bytes, file: str) -> Sequence[CFunction]:
    from tracerisk.adder.sources.c_source import parse_c

    return parse_c(source, file).functions


def digests_behind(
    sources: Mapping[str, bytes], functions: Mapping[str, Collection[QualifiedName]]
) -> dict[str, dict[str, str]]:
    """Return, by file and function, a digest of the code that the function's values rest on.

    That is its own code, and all code of the `sources` that is in none of the `functions`:
    constants, classes, the helpers that it calls. Comments and blank lines count for nothing.
    Raises DependencyError for C and C++ without the extra `cpp`.
    """
    own: dict[str, dict[str, str]] = {}
    rest = []
    for file, source in sorted(sources.items()):
        spans = _spans(source, file) if functions.get(file) else []
        own[file] = {}
        edits: list[Edit] = []
        for name in functions.get(file, ()):
            held = [(start, end) for at, start, end in spans if is_name_at(name, at)]
            code = b"\n".join(source[start:end] for start, end in held)
            own[file][name] = code_digest(code, file)
            edits += [Edit(start, end, b"") for start, end in held]
        rest.append(code_digest(apply_edits(source, _outermost(edits)), file))
    return {
        file: {
            name: short_digest("\n".join([digest, *rest])) for name, digest in sorted(held.items())
        }
        for file, held in own.items()
        if held
    }


def _outermost(edits: list[Edit]) -> list[Edit]:
    """Return the edits that lie within no other."""
    kept: list[Edit] = []
    for edit in sorted(set(edits), key=lambda edit: (edit.start, -edit.end)):
        if not kept or edit.start >= kept[-1].end:
            kept.append(edit)
    return kept


def _spans(source: bytes, file: str) -> _Spans:
    """Return the first byte of each function, and the byte after it; none of what is no source."""
    if is_c(file):
        functions = _c_functions(source, file)
        return [(function.name, function.begins, function.end) for function in functions]
    try:
        parsed = parse_python(source, file)
    except SourceError:
        return []
    starts = line_starts(parsed)
    return [
        (definition.name, starts[definition.first_line - 1], starts[definition.last_line])
        for definition in definitions(parsed.tree)
    ]
