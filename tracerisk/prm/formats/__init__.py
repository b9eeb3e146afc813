"""The formats in which models and assessments leave and enter."""

from tracerisk.common.on_demand import on_demand

TYPE_CHECKING = False
if TYPE_CHECKING:
    from tracerisk.prm.formats.assessment_json import assessment_to_json
    from tracerisk.prm.formats.model_json import dumps, loads

__all__ = ["assessment_to_json", "dumps", "loads"]

__getattr__ = on_demand(
    __name__,
    {
        "assessment_json": "assessment_to_json",
        "model_json": "dumps loads",
    },
)
