"""Expressions: what the figures of a model are computed from.

An expression is a tree of frozen nodes over numbers, the mission time and named parameters.
It has one point value, in which a deviate stands for its mean, and can be sampled.
Names and semantics follow the Open-PSA Model Exchange Format 2.0d.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tracerisk.prm.expressions.arithmetic import (
        Call,
        Difference,
        Negation,
        Product,
        Quotient,
        Sum,
    )
    from tracerisk.prm.expressions.deviates import (
        BetaDeviate,
        Deviate,
        GammaDeviate,
        Histogram,
        LognormalDeviate,
        NormalDeviate,
        UniformDeviate,
    )
    from tracerisk.prm.expressions.evaluation import (
        Definitions,
        Evaluation,
        ExpressionModel,
        depends_on_mission_time,
        evaluate,
        references,
    )
    from tracerisk.prm.expressions.laws import Exponential, Glm, PeriodicTest, Weibull
    from tracerisk.prm.expressions.node import Expression, MissionTime, Number, Reference
    from tracerisk.prm.expressions.sampling import LatinHypercube, Sampling, sample

__all__ = [
    "BetaDeviate",
    "Call",
    "Definitions",
    "Deviate",
    "Difference",
    "Evaluation",
    "Exponential",
    "Expression",
    "ExpressionModel",
    "GammaDeviate",
    "Glm",
    "Histogram",
    "LatinHypercube",
    "LognormalDeviate",
    "MissionTime",
    "Negation",
    "NormalDeviate",
    "Number",
    "PeriodicTest",
    "Product",
    "Quotient",
    "Reference",
    "Sampling",
    "Sum",
    "UniformDeviate",
    "Weibull",
    "depends_on_mission_time",
    "evaluate",
    "references",
    "sample",
]

_ON_DEMAND = {
    "BetaDeviate": "deviates",
    "Call": "arithmetic",
    "Definitions": "evaluation",
    "Deviate": "deviates",
    "Difference": "arithmetic",
    "Evaluation": "evaluation",
    "Exponential": "laws",
    "Expression": "node",
    "ExpressionModel": "evaluation",
    "GammaDeviate": "deviates",
    "Glm": "laws",
    "Histogram": "deviates",
    "LatinHypercube": "sampling",
    "LognormalDeviate": "deviates",
    "MissionTime": "node",
    "Negation": "arithmetic",
    "NormalDeviate": "deviates",
    "Number": "node",
    "PeriodicTest": "laws",
    "Product": "arithmetic",
    "Quotient": "arithmetic",
    "Reference": "node",
    "Sampling": "sampling",
    "Sum": "arithmetic",
    "UniformDeviate": "deviates",
    "Weibull": "laws",
    "depends_on_mission_time": "evaluation",
    "evaluate": "evaluation",
    "references": "evaluation",
    "sample": "sampling",
}
"""The module of each name, imported when the name is first used."""


def __getattr__(name: str) -> object:
    if name not in _ON_DEMAND:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    return getattr(import_module(f"{__name__}.{_ON_DEMAND[name]}"), name)
