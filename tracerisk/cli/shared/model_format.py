"""Detect the format of a model file: by its content, else by the end of its name."""

from __future__ import annotations

import enum
import os
import re


class ModelFormat(enum.Enum):
    """A format of model files; the values are the names on the command line."""

    HYBRID = "hybrid"
    LINKED = "linked"
    OPEN_PSA = "open-psa"
    OPENPRA = "openpra"
    GALILEO = "galileo"
    PRISM = "prism"
    EXPLICIT = "explicit"


SUFFIXES = {
    ".xml": ModelFormat.OPEN_PSA,
    ".opsa": ModelFormat.OPEN_PSA,
    ".json": ModelFormat.HYBRID,
    ".dft": ModelFormat.GALILEO,
    ".prism": ModelFormat.PRISM,
    ".pm": ModelFormat.PRISM,
    ".sm": ModelFormat.PRISM,
    ".tra": ModelFormat.EXPLICIT,
}
"""What the endings of names stand for."""

_HEAD = 65_536
_SCHEMA = re.compile(rb'"schema"\s*:\s*"tracerisk-(hybrid|linked)-model"')
_OPENPRA = re.compile(rb'"(?:faultTrees|eventTrees|ccfGroups)"\s*:')
_SKIPPED = re.compile(rb"(?s)(?:\s|//[^\n]*(?:\n|\Z)|/\*.*?\*/)*")
_TEXTS = (
    (re.compile(rb"toplevel\s[^;=]*;"), ModelFormat.GALILEO),
    (
        re.compile(
            rb'"[^"\n]+"\s+(?:(?:and|or|\d+of\d+|[whc]sp|pand)(?:\s+"[^"\n]+")+\s*;|(?:prob|lambda)\s*=)'
        ),
        ModelFormat.GALILEO,
    ),
    (re.compile(rb"(?:dtmc|ctmc)\s+\d+[ \t]+\d+[ \t]+[\d.]"), ModelFormat.EXPLICIT),
    (re.compile(rb"\d+[ \t]+\d+[ \t]*\r?\n\s*\d+[ \t]+\d+[ \t]+[\d.]"), ModelFormat.EXPLICIT),
    (
        re.compile(
            rb"(?:dtmc|ctmc|mdp|probabilistic|stochastic|nondeterministic)\s+"
            rb"(?:const|module|formula|global|label|rewards|init|//|/\*)"
        ),
        ModelFormat.PRISM,
    ),
)


def detected(data: bytes, name: str) -> ModelFormat | None:
    """Return the format of a file's bytes, `None` where it is that of no model.

    `name` decides where the content does not.
    """
    text = data.removeprefix(b"\xef\xbb\xbf").lstrip()
    if text.startswith((b"<", b"\xff\xfe", b"\xfe\xff")):
        return ModelFormat.OPEN_PSA
    if text.startswith(b"{"):
        return _json_format(text)
    start = _SKIPPED.match(text, 0, _HEAD)
    place = start.end() if start else 0
    for start_of, model_format in _TEXTS:
        if start_of.match(text, place, place + _HEAD):
            return model_format
    return SUFFIXES.get(os.path.splitext(name)[1].lower())  # noqa: PTH122 - no start needs pathlib


def _json_format(text: bytes) -> ModelFormat:
    schema = _SCHEMA.search(text)
    if schema is not None:
        return ModelFormat(schema[1].decode())
    return ModelFormat.OPENPRA if _OPENPRA.search(text) else ModelFormat.HYBRID
