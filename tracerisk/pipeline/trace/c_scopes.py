"""The full names of C++ functions, where a log holds short ones."""

from __future__ import annotations

from dataclasses import replace

from tracerisk.adder.sources.c_source import SCOPE
from tracerisk.adder.sources.functions import functions_in
from tracerisk.common.function_ref import FunctionRef
from tracerisk.errors import InputError, Location
from tracerisk.pipeline.workspace.controller import Controller
from tracerisk.trace import Trace


def with_scopes(controller: Controller, trace: Trace) -> Trace:
    """Return the trace with the names that its functions have in a source of C or C++.

    A log may say `pick` of `cell::Robot::pick`, where no other function is called so.
    Raises InputError where several are.
    """
    file = str(controller.path)
    defined = dict.fromkeys(name for name, _ in functions_in(controller.source, file))
    full: dict[FunctionRef, FunctionRef] = {}
    for ref in (function.ref for function in trace.functions):
        if ref.file != controller.file or ref.name in defined:
            continue
        fit = [name for name in defined if name.endswith(f"{SCOPE}{ref.name}")]
        if len(fit) > 1:
            raise InputError(
                f"the log's {ref.name} may be {' or '.join(fit)}; write the one that is meant "
                "into the log",
                Location(file),
            )
        if fit:
            full[ref] = replace(ref, name=fit[0])
    return replace(
        trace,
        functions=tuple(
            replace(traced_function, ref=full.get(traced_function.ref, traced_function.ref))
            for traced_function in trace.functions
        ),
        visits=tuple(
            replace(visit, function=full.get(visit.function, visit.function))
            for visit in trace.visits
        ),
    )
