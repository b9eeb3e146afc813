"""The formats in which models and assessments leave and enter."""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tracerisk.prm.formats.assessment_json import assessment_to_json
    from tracerisk.prm.formats.model_json import dumps, loads

__all__ = ["assessment_to_json", "dumps", "loads"]

_ON_DEMAND = {
    "assessment_to_json": "assessment_json",
    "dumps": "model_json",
    "loads": "model_json",
}
"""The module of each name, imported when the name is first used."""


def __getattr__(name: str) -> object:
    if name not in _ON_DEMAND:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    return getattr(import_module(f"{__name__}.{_ON_DEMAND[name]}"), name)
