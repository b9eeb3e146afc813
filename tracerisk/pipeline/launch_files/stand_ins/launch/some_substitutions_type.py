"""`launch.some_substitutions_type`: what stands for a text."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from tracerisk.pipeline.launch_files.stand_ins.launch.substitution import Substitution

SomeSubstitutionsType = str | Substitution | Iterable[Any]
SomeSubstitutionsType_types_tuple = (str, Substitution, Iterable)
