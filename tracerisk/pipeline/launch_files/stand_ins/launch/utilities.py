"""`launch.utilities`: texts of substitutions."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Any

from tracerisk.pipeline.launch_files.placeholders import Absent, AbsentError
from tracerisk.pipeline.launch_files.stand_ins.launch.substitution import Substitution


def normalize_to_list_of_substitutions(subs: Any) -> list[Substitution]:
    """Return the substitutions whose texts, joined, a value stands for.

    Raises:
        TypeError: it is not text, path, substitution or series of them.
        AbsentError: it comes from what is not here.
    """
    from tracerisk.pipeline.launch_files.stand_ins.launch.substitutions import TextSubstitution

    if isinstance(subs, Absent):
        raise AbsentError(f"{subs.words} is not here")
    if isinstance(subs, Substitution):
        return [subs]
    if isinstance(subs, str):
        return [TextSubstitution(text=subs)]
    if isinstance(subs, os.PathLike):
        return [TextSubstitution(text=os.fspath(subs))]
    if isinstance(subs, Iterable):
        parts = list(subs)
        if not any(isinstance(part, list | tuple | set | dict) for part in parts):
            return [
                substitution
                for part in parts
                for substitution in normalize_to_list_of_substitutions(part)
            ]
        subs = next(part for part in parts if isinstance(part, list | tuple | set | dict))
    raise TypeError(
        f"Failed to normalize given item of type '{type(subs)}', when only 'str' or "
        "'launch.Substitution' were expected."
    )


def perform_substitutions(context: Any, subs: Any) -> str:
    """Return the joined texts of substitutions."""
    return "".join(sub.perform(context) for sub in subs)


def text_of(context: Any, value: Any) -> str:
    """Return the text that a value stands for."""
    return perform_substitutions(context, normalize_to_list_of_substitutions(value))
