"""Expressions: what the figures of a model are computed from.

An expression is a tree of frozen nodes over numbers, the mission time and named parameters.
It has one point value, in which a deviate stands for its mean, and can be sampled.
Names and semantics follow the Open-PSA Model Exchange Format 2.0d.
"""

from tracerisk.common.on_demand import on_demand

TYPE_CHECKING = False
if TYPE_CHECKING:
    from tracerisk.prm.other_models.expressions.arithmetic import (
        Call,
        Difference,
        Negation,
        Product,
        Quotient,
        Sum,
    )
    from tracerisk.prm.other_models.expressions.deviates import (
        BetaDeviate,
        Deviate,
        GammaDeviate,
        Histogram,
        LognormalDeviate,
        NormalDeviate,
        UniformDeviate,
    )
    from tracerisk.prm.other_models.expressions.evaluation import (
        Definitions,
        Evaluation,
        ExpressionModel,
        depends_on_mission_time,
        evaluate,
        references,
    )
    from tracerisk.prm.other_models.expressions.laws import Exponential, Glm, PeriodicTest, Weibull
    from tracerisk.prm.other_models.expressions.node import (
        Expression,
        MissionTime,
        Number,
        Reference,
    )
    from tracerisk.prm.other_models.expressions.sampling import Sampling, sample

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

__getattr__ = on_demand(
    __name__,
    {
        "arithmetic": "Call Difference Negation Product Quotient Sum",
        "deviates": (
            "BetaDeviate Deviate GammaDeviate Histogram LognormalDeviate NormalDeviate "
            "UniformDeviate"
        ),
        "evaluation": (
            "Definitions Evaluation ExpressionModel depends_on_mission_time evaluate references"
        ),
        "laws": "Exponential Glm PeriodicTest Weibull",
        "node": "Expression MissionTime Number Reference",
        "sampling": "Sampling sample",
    },
)
