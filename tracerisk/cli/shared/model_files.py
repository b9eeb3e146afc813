"""Read the model files of other tools that verbs are given."""

from __future__ import annotations

import os
import stat
from collections.abc import Mapping, Sequence

from tracerisk.cli.shared.model_format import ModelFormat, detected
from tracerisk.cli.shared.sources import decoded, read_file
from tracerisk.errors import InputError, Location

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import TypeAlias

    from tracerisk.prm.hybrid.hybrid import HybridModel
    from tracerisk.prm.other_models.dynamic import DynamicTree
    from tracerisk.prm.other_models.formats.explicit_chain import ExplicitChain
    from tracerisk.prm.other_models.linked import LinkedModel
    from tracerisk.prm.other_models.logic.model import LogicModel

    Model: TypeAlias = LogicModel | DynamicTree | ExplicitChain | LinkedModel | HybridModel

OWN = (ModelFormat.HYBRID, ModelFormat.LINKED)
"""The formats that are tracerisk's own."""


def format_of(files: Sequence[str]) -> ModelFormat | None:
    """Return the format of model files, inferred from the first; `None` where they are sources.

    Raises InputError when the first cannot be read, or only once.
    """
    if _is_pipe(files[0]):
        raise InputError(
            "is a pipe, which is read only once; save it to a file", Location(files[0])
        )
    return detected(read_file(files[0]), files[0])


def _is_pipe(name: str) -> bool:
    try:
        return stat.S_ISFIFO(os.stat(name).st_mode)  # noqa: PTH116 - as in `model_format`
    except OSError:
        return False  # what reads it says so


def read_model(
    files: Sequence[str],
    kind: ModelFormat,
    constants: Mapping[str, int | float | bool] | None = None,
) -> Model:
    """Read the model of one file, of several of Open-PSA, or of a .tra file with its .lab.

    `constants` are values for the constants of a PRISM file, or the parameters of Galileo.
    Raises InputError, with the position, when a file cannot be read or is malformed.
    """
    first = files[0]
    most = {ModelFormat.OPEN_PSA: len(files), ModelFormat.EXPLICIT: 2}.get(kind, 1)
    if len(files) > most:
        raise InputError(
            f"{len(files)} files; a model of the format {kind.value} is one file"
            f"{' and that of its labels' if kind is ModelFormat.EXPLICIT else ''}"
        )
    if kind is ModelFormat.OPEN_PSA:
        from tracerisk.prm.other_models.formats.open_psa import read_open_psa

        return read_open_psa(*files)
    if kind is ModelFormat.OPENPRA:
        from tracerisk.prm.other_models.formats.openpra import read_openpra

        return read_openpra(first)
    text = read_text(first)
    if kind is ModelFormat.GALILEO:
        from tracerisk.prm.other_models.formats import galileo

        given = {name: float(value) for name, value in (constants or {}).items()}
        return galileo.loads(text, first, given)
    if kind is ModelFormat.PRISM:
        from tracerisk.prm.other_models.formats.prism import read_prism

        return read_prism(text, file=first, constants=constants)
    if kind is ModelFormat.EXPLICIT:
        from tracerisk.prm.other_models.formats.explicit import read_explicit

        labels = files[1] if len(files) == 2 else labels_beside(first)
        return read_explicit(text, read_text(labels), transitions_file=first, labels_file=labels)
    if kind is ModelFormat.LINKED:
        from tracerisk.prm.other_models.formats import linked_json

        return linked_json.loads(text, first)
    from tracerisk.prm.formats import model_json

    return model_json.loads(text, first)


def labels_beside(transitions: str) -> str:
    """Return the file of labels that belongs to a file of transitions."""
    return f"{os.path.splitext(transitions)[0]}.lab"  # noqa: PTH122 - as in `model_format`


def read_text(name: str) -> str:
    """Return the text of a file; raise InputError where it cannot be read."""
    return decoded(read_file(name), name, "utf-8-sig")
