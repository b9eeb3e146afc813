import time
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from tracerisk.errors import ModelError, TooLargeError
from tracerisk.prm import build_model
from tracerisk.prm.numbers.distributions import Lognormal, Uniform
from tracerisk.prm.other_models.expressions import Number, Product, Reference, Sum
from tracerisk.prm.other_models.expressions.deviates import LognormalDeviate, UniformDeviate
from tracerisk.prm.other_models.linked import (
    Figure,
    LinkedChain,
    LinkedModel,
    ModelParameter,
    Occupancy,
    Transition,
    linked,
)
from tracerisk.prm.other_models.linked.importance import importances
from tracerisk.prm.other_models.linked.sampling import SampledModel
from tracerisk.prm.other_models.linked.uncertainty import propagate
from tracerisk.prm.questions.uncertainty import propagate as propagate_hybrid

FIGURES = ("failure", "lost", "done", "after ten", "unavailable", "odd", "cost")


@pytest.mark.parametrize("figure", FIGURES)
def test_each_draw_is_the_model_solved_there(plant, figure):
    drawn = {
        "motor": np.array([2e-6, 1e-3, 0.2]),
        "wear rate": np.array([1e-6, 1e-2, 0.5]),
        "repair rate": np.array([0.0, 0.125, 3.0]),
    }
    expected = [
        plant.solve({name: float(values[draw]) for name, values in drawn.items()}).figure(figure).p
        for draw in range(3)
    ]
    assert SampledModel(plant, drawn).figure(figure) == pytest.approx(expected, rel=1e-11)


def test_a_parameter_that_is_drawn_stands_in_for_its_expression(plant):
    drawn = {"sensor": np.array([0.5, 0.25])}
    expected = [plant.solve({"sensor": float(each)}).figures["odd"] for each in drawn["sensor"]]
    assert SampledModel(plant, drawn).figure("odd") == pytest.approx(expected, rel=1e-12)


def test_the_case_study_has_the_spread_of_its_model_of_functions(case_study):
    loop = {"place": {"init": Fraction(9, 10), "done": Fraction(1, 10)}}
    model = build_model(case_study, profile=loop, name="case study")
    spreads = {parameter.name: Lognormal(3.0) for parameter in model.parameters}
    found = propagate(linked(model), "mission failure", distributions=spreads, seed=3)
    expected = propagate_hybrid(model, distributions=spreads, seed=3)
    assert found.percentiles == pytest.approx(expected.percentiles, rel=1e-10)
    assert found.mean == pytest.approx(expected.mean, rel=1e-10)
    assert found.inputs[0] == replace(
        expected.inputs[0], share=pytest.approx(expected.inputs[0].share, rel=1e-6)
    )
    start = time.process_time()
    propagate(linked(model), "mission failure", distributions=spreads)
    assert time.process_time() - start < 1.0


def sum_of(*parameters):
    value = Sum(tuple(Reference(each.name) for each in parameters))
    return LinkedModel("m", parameters, (), (), (Figure("f", value),))


def test_a_deviate_is_the_distribution_of_its_parameter():
    model = sum_of(
        ModelParameter("x", LognormalDeviate((Number(1e-3), Number(3.0), Number(0.95)))),
        ModelParameter("y", UniformDeviate(Number(0.0), Number(2e-3)), distribution=None),
    )
    found = propagate(model, "f", samples=4000)
    assert found.point == pytest.approx(2e-3, rel=1e-14)
    assert found.mean == pytest.approx(2e-3, rel=1e-2)
    x, y = (next(each for each in found.inputs if each.name == name) for name in "xy")
    assert x.percentiles[2] / x.percentiles[1] == pytest.approx(3.0, rel=1e-2)
    assert y.percentiles == pytest.approx((1e-4, 1e-3, 1.9e-3), rel=1e-2)
    assert x.share + y.share == pytest.approx(1.0, abs=0.02)


def test_a_deviate_within_an_expression_is_drawn_without_a_share_of_its_own():
    inner = Product((Number(2.0), UniformDeviate(Number(0.0), Number(1.0))))
    model = sum_of(
        ModelParameter("x", inner, "hours"),
        ModelParameter("y", Number(1.0), "hours", Uniform(0.5, 1.5)),
    )
    found = propagate(model, "f", samples=4000)
    # Variances of 1/3 and 1/12.
    assert [each.name for each in found.inputs] == ["y"]
    assert found.inputs[0].share == pytest.approx(0.2, abs=0.03)
    assert found.deviation == pytest.approx((5 / 12) ** 0.5, rel=2e-2)


def test_many_draws_are_taken_in_passes(plant, monkeypatch):
    spreads = {"motor": Lognormal(3.0), "power": Lognormal(3.0)}
    whole = propagate(plant, "failure", samples=500, distributions=spreads)
    monkeypatch.setattr("tracerisk.prm.other_models.linked.uncertainty._CELLS", 100)
    assert propagate(plant, "failure", samples=500, distributions=spreads) == whole


def test_deviates_without_a_share_are_drawn_anew_in_each_block(monkeypatch):
    monkeypatch.setattr("tracerisk.prm.other_models.linked.uncertainty._CELLS", 100)
    monkeypatch.setattr("tracerisk.prm.questions.draws.MOST_FITTED", 1_000)
    monkeypatch.setattr("tracerisk.prm.questions.draws.MOST_DRAWN", 200)
    inner = Product((Number(1.0), UniformDeviate(Number(0.0), Number(1.0))))
    known = [ModelParameter(f"y{i}", Number(0.1), "hours", Uniform(0.09, 0.11)) for i in range(2)]
    model = sum_of(ModelParameter("x", inner, "hours"), *known)
    found = propagate(model, "f", samples=1_000)
    assert found.mean == pytest.approx(0.7, rel=1e-3)
    assert found.deviation == pytest.approx((1 / 12) ** 0.5, rel=1e-2)
    # Ten blocks of one and the same 100 draws would have a hundredth of the range for each.
    low, middle, high = found.percentiles
    assert (low, middle, high) == pytest.approx((0.25, 0.7, 1.15), rel=0.02)


def test_a_row_that_a_draw_breaks_is_reported():
    model = LinkedModel(
        "m",
        (ModelParameter("x", Number(0.4)),),
        (),
        (
            LinkedChain(
                "c",
                "s",
                (
                    Transition("s", "bad", Product((Number(2.0), Reference("x")))),
                    Transition("s", "done"),
                ),
            ),
        ),
        (Figure("f", Occupancy("c", ("bad",), steps=2)),),
    )
    assert propagate(model, "f", distributions={"x": Uniform(0.0, 0.5)}).mean == pytest.approx(0.5)
    with pytest.raises(
        ModelError, match="Markov chain 'c', state 's': a draw gives 'bad' a probability outside"
    ):
        propagate(model, "f", distributions={"x": Uniform(0.0, 0.9)})


def test_a_chain_too_fast_to_step_through_is_refused():
    chain = LinkedChain("c", "up", (Transition("up", "down", Reference("x")),), "continuous")
    model = LinkedModel(
        "m",
        (ModelParameter("x", Number(1.0), "hour-1"),),
        (),
        (chain,),
        (Figure("f", Occupancy("c", ("down",))),),
        10.0,
    )
    with pytest.raises(TooLargeError, match=r"takes 1.* steps in a draw; allowed: 100000;"):
        propagate(model, "f", distributions={"x": Uniform(1e4, 1e5)})
    # Its figure is had by squaring; what its derivatives need, step by step, is not held.
    assert model.solve({"x": 1e7}).figure("f").p == 1.0
    with pytest.raises(TooLargeError, match=r"about 1.25e\+08 steps of 2 states"):
        importances(replace(model, parameters=(ModelParameter("x", Number(1e7), "hour-1"),)), "f")


def test_what_is_not_there_cannot_be_drawn(plant):
    with pytest.raises(ModelError, match="no parameter 'x' in 'plant'"):
        propagate(plant, "failure", distributions={"x": Lognormal(3.0)})
    with pytest.raises(ModelError, match="no parameter has a distribution"):
        propagate(plant, "failure")
    with pytest.raises(ModelError, match="no figure 'x' in 'plant'"):
        propagate(plant, "x", distributions={"motor": Lognormal(3.0)})
