"""The formats in which models and assessments leave and enter."""

from tracerisk.prm.formats.assessment_json import assessment_to_json
from tracerisk.prm.formats.model_json import dumps, loads

__all__ = ["assessment_to_json", "dumps", "loads"]
