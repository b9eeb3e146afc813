"""The names of functions in a model that is built from several files.

A block's `name` is the qualified name within its module. Where blocks of two files have one name,
the model and every `next` put the module before it: `left_arm.open`, `right_arm.open`. They do the
same where a function has the name of the mission's end: `arm.done`.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from os.path import commonpath
from pathlib import Path

from tracerisk.adder.blocks.values import DONE
from tracerisk.common.function_ref import FunctionRef

_INIT = "__init__"


def model_names(functions: Collection[FunctionRef]) -> dict[FunctionRef, str]:
    """Return each function's name in the model: its own, or with its module where that is taken.

    The module is the file's stem; where that is shared as well, it is prefixed by as many folders
    as it takes to distinguish the files.
    """
    files_of: dict[str, set[str]] = {}
    for ref in functions:
        files_of.setdefault(ref.name, set()).add(ref.file)
    names = {}
    for ref in functions:
        files = files_of[ref.name]
        is_free = len(files) == 1 and ref.name != DONE
        names[ref] = ref.name if is_free else f"{_modules(files)[ref.file]}.{ref.name}"
    return names


def _modules(files: Collection[str]) -> dict[str, str]:
    """Return a dotted name for each of several files: distinct and as short as possible.

    What all have in common is left out, so that it does not matter where a path begins.
    """
    common = len(Path(commonpath(Path(file).resolve().parent for file in files)).parts)
    parts = {file: _parts(file)[common:] or _parts(file)[-1:] for file in files}
    longest = max(len(part) for part in parts.values())
    for count in range(1, longest + 1):
        short = {file: ".".join(part[-count:]) for file, part in parts.items()}
        if len(set(short.values())) == len(files):
            return short
    return {file: ".".join(part) for file, part in parts.items()}


def _parts(file: str) -> Sequence[str]:
    path = Path(file).resolve().with_suffix("")
    parts = path.parts[:-1] if path.name == _INIT and len(path.parts) > 1 else path.parts
    return [re.sub(r"\W", "_", part) for part in parts]
