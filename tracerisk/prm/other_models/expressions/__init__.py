"""Expressions: what the figures of a model are computed from.

An expression is a tree of frozen nodes over numbers, the mission time and named parameters.
It has one point value, in which a deviate stands for its mean, and can be sampled.
Names and semantics follow the Open-PSA Model Exchange Format 2.0d.
"""

from tracerisk.prm.other_models.expressions.arithmetic import (
    Call,
    Difference,
    Negation,
    Product,
    Quotient,
    Sum,
)
from tracerisk.prm.other_models.expressions.evaluation import (
    Definitions,
    Evaluation,
    ExpressionModel,
    depends_on_mission_time,
    evaluate,
    references,
)
from tracerisk.prm.other_models.expressions.node import (
    Expression,
    MissionTime,
    Number,
    Reference,
)

__all__ = [
    "Call",
    "Definitions",
    "Difference",
    "Evaluation",
    "Expression",
    "ExpressionModel",
    "MissionTime",
    "Negation",
    "Number",
    "Product",
    "Quotient",
    "Reference",
    "Sum",
    "depends_on_mission_time",
    "evaluate",
    "references",
]
