"""Second-order importance against mixed differences in 250 digits."""

from fractions import Fraction
from itertools import product

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from tracerisk.errors import ModelError
from tracerisk.prm import (
    BasicEvent,
    FaultTree,
    FunctionState,
    Gate,
    GateKind,
    HybridModel,
    NextStep,
    Parameter,
    build_model,
    solve,
)
from tracerisk.prm.questions.pair_importance import pair_importances


def close(expected, rel=1e-11):
    return pytest.approx(float(expected), rel=rel, abs=0.0)


def joint_by_differences(exact, model, first, second):
    """Return d2F / (dtheta_a dtheta_b), by four missions 1e-40 apart."""
    one, step = exact.number(1), exact.number(10) ** -40
    corners = sum(
        a * b * exact.mission_by_events(model, {first: one + a * step, second: one + b * step})
        for a, b in product((1, -1), repeat=2)
    )
    thetas = {parameter.name: parameter.theta for parameter in model.parameters}
    return corners / (4 * step**2) / thetas[first] / thetas[second]


@settings(max_examples=4, deadline=None)
@given(data=st.data())
def test_pairs_equal_mixed_differences_in_250_digits(in_many_digits, small_models, data):
    model = data.draw(small_models(functions=2, parts_each=2, rare=True))
    total = in_many_digits.mission_by_events(model, {})
    assume(total > 0)
    slopes = {each.name: each.birnbaum for each in solve(model).components}
    latent = {e.parameter for s in model.states for e in s.tree.events if e.name in model.latent}
    for pair in pair_importances(model):
        expected = joint_by_differences(in_many_digits, model, pair.first, pair.second)
        # Of two groups with hidden failures, terms of either sign nearly cancel.
        both = {pair.first, pair.second} <= latent
        room = 1e-12 * max(slopes[pair.first], slopes[pair.second]) if both else 1e-60
        assert pair.joint_birnbaum == pytest.approx(float(expected), rel=1e-10, abs=room)
        neither = in_many_digits.mission_by_events(model, {pair.first: 0, pair.second: 0})
        assert pair.fussell_vesely == close((total - neither) / total)


def test_two_units_that_must_both_fail_do_so_together(block, component):
    # F = a b: d2F = 1, and all of the risk goes with either.
    tree = FaultTree(
        "top",
        (Gate("top", GateKind.AND, ("a", "b")),),
        (BasicEvent("a"), BasicEvent("b")),
    )
    state = FunctionState("s", 1, tree, {"a": 1e-20, "b": 1e-9}, (NextStep("done", Fraction(1)),))
    model = HybridModel("m", "s", (state,), (Parameter("a", 1e-20), Parameter("b", 1e-9)))
    (pair,) = pair_importances(model)
    assert (pair.first, pair.second) == ("a", "b")
    assert pair.joint_birnbaum == close(1)
    assert pair.joint_criticality == close(1)
    assert pair.fussell_vesely == close(1)
    assert pair.interaction == close(1)


def test_a_hidden_pair_beside_a_part_keeps_its_digits(in_many_digits, block, component):
    # F = 1 - (1-a)(1-p^2) in one visit: d2F = -2p.
    parts = (component("motor", 0.125), component("pair", 1e-20, 2, "true"))
    (pair,) = pair_importances(build_model([block("s", 1, parts)], name="m"))
    assert pair.joint_birnbaum == close(-2e-20)
    renewed = (component("motor", 0.125), component("pair", 1e-20, 2, "true, detected each_visit"))
    (pair,) = pair_importances(build_model([block("s", 1, renewed)], name="m"))
    assert pair.joint_birnbaum == close(-2e-20)


def test_two_units_each_of_which_fails_the_mission_do_so_apart(block, component):
    # F = 1 - (1-a)(1-b): d2F = -1.
    parts = (component("a", 1e-20), component("b", 0.25))
    (pair,) = pair_importances(build_model([block("s", 1, parts)], name="m"))
    assert pair.joint_birnbaum == close(-1)
    assert pair.joint_criticality == close(-1e-20)


def test_units_of_one_hidden_group_with_figures_of_their_own(in_many_digits):
    events = (BasicEvent("x", "p"), BasicEvent("y", "q"))
    tree = FaultTree("top", (Gate("top", GateKind.AND, ("x", "y")),), events)
    steps = (NextStep("s", Fraction(9, 10)), NextStep("done", Fraction(1, 10)))
    state = FunctionState("s", 1, tree, {"p": 1e-9, "q": 3e-8}, steps)
    parameters = (Parameter("p", 1e-9), Parameter("q", 3e-8))
    model = HybridModel("m", "s", (state,), parameters, ("x", "y"))
    (pair,) = pair_importances(model)
    assert pair.joint_birnbaum == close(joint_by_differences(in_many_digits, model, "p", "q"))
    # Over a mean of ten visits near (2 10^2 - 10) p q.
    assert pair.joint_birnbaum == pytest.approx(190, rel=1e-4)


def test_a_tree_with_shared_events_has_pairs_as_well(in_many_digits):
    gates = (
        Gate("top", GateKind.OR, ("one", "two")),
        Gate("one", GateKind.AND, ("x", "y")),
        Gate("two", GateKind.AND, ("x", "z")),
    )
    events = tuple(BasicEvent(name) for name in "xyz")
    steps = (NextStep("s", Fraction(1, 2)), NextStep("done", Fraction(1, 2)))
    values = {"x": 0.01, "y": 0.02, "z": 0.03}
    state = FunctionState("s", 1, FaultTree("top", gates, events), values, steps)
    model = HybridModel("m", "s", (state,), tuple(Parameter(n, v) for n, v in values.items()))
    found = {(pair.first, pair.second): pair for pair in pair_importances(model)}
    assert set(found) == {("x", "y"), ("x", "z"), ("y", "z")}
    for (first, second), pair in found.items():
        expected = joint_by_differences(in_many_digits, model, first, second)
        assert pair.joint_birnbaum == close(expected, 1e-10)


def test_pairs_of_chosen_parameters_only_and_an_unknown_one(block, component):
    parts = tuple(component(name, 0.125) for name in "abc")
    model = build_model([block("s", 1, parts)], name="m")
    assert [(pair.first, pair.second) for pair in pair_importances(model, ["c", "a"])] == [
        ("c", "a")
    ]
    with pytest.raises(ModelError, match="no parameter 'gripper'; allowed: a, b, c"):
        pair_importances(model, ["a", "gripper"])
