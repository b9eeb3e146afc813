import math
from fractions import Fraction

import pytest

from tracerisk.errors import ModelError
from tracerisk.prm import build_model, solve
from tracerisk.prm.other_models.expressions import Call, Number, Quotient, Reference
from tracerisk.prm.other_models.linked import Figure, LinkedModel, ModelParameter, linked
from tracerisk.prm.other_models.linked.importance import importances


def close(expected):
    return pytest.approx(float(expected), rel=1e-11, abs=0.0)


def by_name(model, figure):
    return {each.name: each for each in importances(model, figure)}


def test_the_measures_of_the_case_study_are_those_of_its_model_of_functions(case_study):
    loop = {"place": {"init": Fraction(9, 10), "done": Fraction(1, 10)}}
    model = build_model(case_study, profile=loop, name="case study")
    found = importances(linked(model), "mission failure")
    expected = solve(model).components
    assert [each.name for each in found] == [each.name for each in expected]
    for one, other in zip(found, expected, strict=True):
        assert one.birnbaum == close(other.birnbaum)
        assert one.criticality == close(other.criticality)
        assert one.fussell_vesely == close(other.fussell_vesely)
        assert one.without == close(other.without)
        assert one.risk_reduction_worth == close(other.risk_reduction_worth)
        assert one.risk_achievement_worth == close(other.risk_achievement_worth)


def test_every_measure_follows_its_definition(plant, oracle):
    found = by_name(plant, "failure")
    total = oracle(plant).figure("failure")
    for name in ("power", "motor", "jam"):
        each = found[name]
        theta = oracle(plant).of(Reference(name))
        without = oracle(plant, {name: 0}).figure("failure")
        assert each.criticality == close(oracle(plant).slope("failure", name) * theta / total)
        assert each.fussell_vesely == close((total - without) / total)
        assert each.risk_reduction_worth == close(total / without)
        if name != "power":
            # The motors' events would have a probability above one.
            assert each.risk_achievement_worth is None
        else:
            failed = oracle(plant, {name: 1}).figure("failure")
            assert each.risk_achievement_worth == close(failed / total)
        assert each.tenfold == close(oracle(plant, {name: 10 * theta}).figure("failure") / total)


def test_a_rate_has_no_risk_achievement_worth(plant):
    assert by_name(plant, "failure")["wear rate"].risk_achievement_worth is None
    assert by_name(plant, "failure")["wear rate"].tenfold is not None


def test_a_parameter_without_which_nothing_fails_has_an_infinite_worth():
    model = LinkedModel(
        "m", (ModelParameter("x", Number(1e-20)),), (), (), (Figure("f", Reference("x")),)
    )
    (found,) = importances(model, "f")
    assert found.risk_reduction_worth == math.inf
    assert (found.fussell_vesely, found.criticality, found.birnbaum) == (1.0, 1.0, 1.0)


def test_what_has_no_value_at_zero_has_no_such_measures():
    model = LinkedModel(
        "m",
        (ModelParameter("x", Number(0.5), "hours"),),
        (),
        (),
        (Figure("f", Quotient((Number(1.0), Reference("x")))),),
    )
    (found,) = importances(model, "f")
    assert found.birnbaum == -4.0
    assert (found.without, found.fussell_vesely, found.risk_reduction_worth) == (None, None, None)


def test_a_model_that_has_no_value_at_all_is_refused():
    model = LinkedModel(
        "m",
        (ModelParameter("x", Call("log", (Number(0.0),))),),
        (),
        (),
        (Figure("f", Reference("x")),),
    )
    with pytest.raises(ModelError, match=r"parameter 'x': log\(0.0\) has no finite value"):
        importances(model, "f")
