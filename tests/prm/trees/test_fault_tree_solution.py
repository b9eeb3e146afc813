import copy
import math
import pickle
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracerisk.errors import ModelError
from tracerisk.prm import BasicEvent, FaultTree, HybridModel, prime_implicants
from tracerisk.prm.numbers.probability import Probability, pair_of, value_of
from tracerisk.prm.other_models.dynamic import DynamicEvent, DynamicTree
from tracerisk.prm.other_models.expressions import (
    Definitions,
    ExpressionModel,
    MissionTime,
    Number,
    Reference,
)
from tracerisk.prm.other_models.expressions.laws import Exponential as ExponentialLaw
from tracerisk.prm.other_models.linked import LinkedModel
from tracerisk.prm.trees.failure_models import Exponential, PerDemand

PAIR = FaultTree.of(
    "top",
    {"top": ("or", "pair", "single"), "pair": ("and", "a", "b")},
    {"a": 6.7e-08, "b": 6.7e-08, "single": 1e-20},
)


def test_a_solution_holds_the_top_and_the_values_it_was_solved_for():
    tree = FaultTree.of("top", {"top": ("or", "a", "b")}, {"a": Exponential(1e-3), "b": None})
    solution = tree.solve({"b": 0.25}, mission_time_h=10.0)
    p = -math.expm1(-1e-2)
    assert solution.values == {"a": p, "b": 0.25}
    assert solution.probability == solution.top.p == pytest.approx(p + 0.25 - p * 0.25, rel=1e-15)


def test_stated_values_stand_above_the_models():
    assert PAIR.solve({"single": 0.5, "a": 0.0}).probability == 0.5


def test_importance_of_a_redundant_pair_keeps_its_digits():
    table = PAIR.solve().importance()
    p, s = Fraction(6.7e-08), Fraction(1e-20)
    total = p * p + s - p * p * s
    drop = p * p * (1 - s)
    row = table["a"]
    assert row.birnbaum == pytest.approx(float(p * (1 - s)), rel=1e-14)
    assert row.criticality == pytest.approx(float(drop / total), rel=1e-14)
    assert row.fussell_vesely == pytest.approx(float(drop / total), rel=1e-14)
    assert row.risk_reduction_worth == pytest.approx(float(total / s), rel=1e-14)
    assert row.risk_achievement_worth == pytest.approx(float((p + s - p * s) / total), rel=1e-14)
    assert table.names == ("a", "b", "single")


def test_what_alone_makes_failure_possible_has_an_infinite_reduction_worth():
    table = (
        FaultTree.of("top", {"top": ("and", "a", "b")}, {"a": 1e-9, "b": 1e-9}).solve().importance()
    )
    assert table["a"].risk_reduction_worth == math.inf


def test_a_top_that_never_happens_has_measures_of_zero_and_one():
    row = (
        FaultTree.of("top", {"top": ("and", "a", "b")}, {"a": 0.0, "b": 0.0})
        .solve()
        .importance()["a"]
    )
    assert (row.criticality, row.fussell_vesely) == (0.0, 0.0)
    assert (row.risk_reduction_worth, row.risk_achievement_worth) == (1.0, 1.0)


def test_a_parameter_changes_all_its_events_and_an_event_only_itself():
    from tracerisk.prm import BasicEvent

    tree = FaultTree.of(
        "top",
        {"top": ("and", "m1", "m2")},
        {"m1": BasicEvent("m1", "motor"), "m2": BasicEvent("m2", "motor")},
    )
    solution = tree.solve({"motor": 0.25})
    assert solution.importance()["motor"].birnbaum == 0.5
    assert solution.importance()["motor"].risk_achievement_worth == 16.0
    assert solution.importance("event")["m1"].birnbaum == 0.25
    assert solution.importance("event")["m1"].risk_achievement_worth == 4.0


@given(values=st.lists(st.floats(1e-25, 1.0), min_size=4, max_size=4))
def test_measures_equal_their_definitions_where_events_are_shared(values):
    tree = FaultTree.of(
        "top", {"top": ("or", ("and", "a", "b"), ("and", "b", "c"), ("xor", "a", "d"))}
    )
    given_values = dict(zip("abcd", values, strict=True))

    def exact(p):
        a, b, c, d = (p[name] for name in "abcd")
        # By the state of a and b: the pairs, else one of a and d alone.
        return a * b + a * (1 - b) * (1 - d) + (1 - a) * (d + (1 - d) * b * c)

    rational = {name: Fraction(p) for name, p in given_values.items()}
    total = exact(rational)
    for row in tree.solve(given_values).importance():
        without, failed = (exact({**rational, row.name: Fraction(x)}) for x in (0, 1))
        assert row.birnbaum == pytest.approx(float(failed - without), rel=1e-13, abs=1e-16)
        assert row.fussell_vesely == pytest.approx(
            float((total - without) / total), rel=1e-13, abs=1e-15
        )
        assert row.risk_achievement_worth == pytest.approx(float(failed / total), rel=1e-13)


@pytest.mark.parametrize("shared", [False, True])
def test_samples_are_solved_at_once_as_each_alone(shared):
    tree = FaultTree.of(
        "top",
        {"top": ("or", ("atleast", 2, "a", "b", "c"), ("xor", "a" if shared else "d", "e"))},
        houses={} if shared else {"d": True},
    )
    rng = np.random.default_rng(1)
    values = {name: 10.0 ** rng.uniform(-20, 0, 50) for name in "abc"} | {"e": 1e-18}
    found = tree.probabilities(values)
    assert found.shape == (50, 2)
    for index in range(50):
        alone = tree.probability(
            {name: float(np.broadcast_to(v, 50)[index]) for name, v in values.items()}
        )
        assert found[index] == pytest.approx(alone, rel=1e-14)


def test_numbers_alone_are_one_sample():
    assert PAIR.probabilities({"a": 0.5, "b": 0.5, "single": 0.0}).tolist() == [[0.25, 0.75]]


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"a": 0.5, "b": 0.5}, "parameter 'single' has no value; allowed: a, b"),
        (
            {"a": 0.5, "b": [0.5, 1.5], "single": 0.0},
            r"parameter 'b': a probability is outside \[0, 1\]",
        ),
        (
            {"a": 0.5, "b": [0.5, math.nan], "single": 0.0},
            "parameter 'b': a probability is outside",
        ),
        ({"a": [[0.5]], "b": 0.5, "single": 0.0}, r"parameter 'a': an array of shape \(1, 1\)"),
        ({"a": [0.5], "b": [0.5, 0.5], "single": 0.0}, r"arrays of different lengths \(a 1, b 2\)"),
    ],
)
def test_samples_that_fit_no_tree_are_refused(values, message):
    with pytest.raises(ModelError, match=message):
        PAIR.probabilities(values)


def test_a_model_without_mission_time_is_refused():
    tree = FaultTree.of("a", {}, {"a": Exponential(1e-3)})
    with pytest.raises(
        ModelError, match="event 'a' depends on the mission time; give mission_time_h"
    ):
        tree.solve()


def test_values_of_unknown_parameters_are_refused():
    with pytest.raises(
        ModelError, match="value of 'singel', which is not a parameter; did you mean 'single'"
    ):
        PAIR.solve({"singel": 0.5})


def test_importance_by_something_else_is_refused():
    with pytest.raises(ModelError, match="importance by 'gate'; allowed: event, parameter"):
        PAIR.solve().importance("gate")


def test_a_unit_that_fails_almost_surely_keeps_the_digits_of_its_survival():
    survival = math.exp(-50.0)
    spent = Exponential(1.0)
    flat = FaultTree.of("top", {"top": ("not", "a")}, {"a": spent})
    assert flat.solve(mission_time_h=50).probability == pytest.approx(survival, rel=1e-15)
    shared = FaultTree.of(
        "top",
        {"top": ("or", ("and", ("not", "a"), "b"), ("and", "b", "c"))},
        {"a": spent} | {"b": 0.5, "c": 0.0},
    )
    solution = shared.solve(mission_time_h=50)
    assert shared.shared
    assert solution.probability == pytest.approx(0.5 * survival, rel=1e-15)
    assert solution.importance()["b"].fussell_vesely == pytest.approx(1.0, rel=1e-15)
    assert solution.importance("event")["b"].criticality == pytest.approx(1.0, rel=1e-15)
    ways = prime_implicants(shared).most_probable(solution.values)
    assert next(ways).probability == pytest.approx(0.5 * survival, rel=1e-15)


def test_a_figure_with_its_complement_is_copied_whole():
    figure = value_of(Exponential(1.0).probability(50.0))
    assert figure == 1.0
    for copied in (pickle.loads(pickle.dumps(figure)), copy.deepcopy(figure)):
        assert pair_of(copied) == (1.0, math.exp(-50.0))
    assert type(value_of(Probability(0.25, 0.75))) is float


def test_a_model_that_needs_no_mission_time_asks_for_none():
    per_demand = FaultTree.of("t", {"t": ("or", "a")}, {"a": PerDemand(0.1, 2)})
    assert per_demand.solve().probability == pytest.approx(0.19)
    definitions = Definitions(
        (
            ("share", Number(0.25)),
            ("late", ExponentialLaw(Reference("share"), MissionTime())),
        )
    )

    def event_of(name):
        model = ExpressionModel(Reference(name), definitions)
        return FaultTree("a", (), (BasicEvent("a", model=model),))

    assert event_of("share").solve().probability == 0.25
    with pytest.raises(ModelError, match="depends on the mission time"):
        event_of("late").solve()


@pytest.mark.parametrize("hours", ["x", None, math.nan, -1.0, [8.0]])
def test_a_mission_time_that_is_no_number_is_an_error_of_the_model(hours):
    tree = FaultTree("a", (), (BasicEvent("a", model=Exponential(1e-3)),))
    with pytest.raises(ModelError, match="mission time"):
        tree.solve(mission_time_h=hours)


def test_so_it_is_for_dynamic_trees_linked_models_and_visits():
    tree = FaultTree("a", (), (BasicEvent("a", model=Exponential(1e-3)),))
    dynamic = DynamicTree("a", (), (DynamicEvent("a", Exponential(1e-3)),))
    for make in (
        lambda: dynamic.solve(mission_time_h="x"),
        lambda: LinkedModel("m", mission_time_h="x"),
        lambda: HybridModel.of("m", {"a": tree}, visit_h="x"),
    ):
        with pytest.raises(ModelError, match="mission time"):
            make()
