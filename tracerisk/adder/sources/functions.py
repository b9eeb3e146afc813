"""The functions of a source, in Python as in C and C++."""

from __future__ import annotations

from tracerisk.adder.sources.python_lines import parse_python
from tracerisk.common.function_ref import QualifiedName
from tracerisk.instrument.source.function_definitions import MODULE, definitions
from tracerisk.instrument.source.language import is_c


def functions_in(source: bytes, file: str) -> list[tuple[QualifiedName, int]]:
    """Return the qualified name of each function, with the line on which it is defined.

    Code of a Python module is a function too, whose line is 1; it comes first.
    Raises SourceError where the source cannot be read, DependencyError for C and C++ without the
    extra `cpp`.
    """
    if is_c(file):
        from tracerisk.adder.sources.c_source import parse_c

        return [(function.name, function.line) for function in parse_c(source, file).functions]
    tree = parse_python(source, file).tree
    return [(MODULE, 1), *((definition.name, definition.line) for definition in definitions(tree))]
