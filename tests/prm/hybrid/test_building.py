from fractions import Fraction

import pytest

from tracerisk.errors import ModelError
from tracerisk.prm import (
    BasicEvent,
    FaultTree,
    Gate,
    GateKind,
    HybridModel,
    MarkovChain,
    NextStep,
    Parameter,
    failure_probabilities,
    solve,
)
from tracerisk.prm.trees.events import HouseEvent
from tracerisk.prm.trees.failure_models import Constant, Exponential


def test_formulas_make_gates_and_formulas_within_them_too():
    tree = FaultTree.of(
        "top",
        {
            "top": ("or", "pumps", "power"),
            "pumps": ("atleast", 2, "p1", "p2", ("and", "p3", "valve")),
        },
        {
            "p1": 1e-3,
            "p2": Exponential(1e-5),
            "p3": None,
            "valve": 0.5,
            "power": BasicEvent("power", "grid"),
        },
    )
    assert set(tree.gates) == {
        Gate("top", GateKind.OR, ("pumps", "power")),
        Gate("pumps", GateKind.ATLEAST, ("p1", "p2", "pumps.3"), 2),
        Gate("pumps.3", GateKind.AND, ("p3", "valve")),
    }
    assert tree.events == (
        BasicEvent("p1", model=Constant(1e-3)),
        BasicEvent("p2", model=Exponential(1e-5)),
        BasicEvent("p3"),
        BasicEvent("valve", model=Constant(0.5)),
        BasicEvent("power", "grid"),
    )


def test_inputs_are_events_where_none_are_given():
    tree = FaultTree.of(
        "top", {"top": ("cardinality", 1, 2, "a", "b", "dry")}, houses={"dry": True}
    )
    assert tree.gates == (Gate("top", GateKind.CARDINALITY, ("a", "b", "dry"), 1, 2),)
    assert tree.events == (BasicEvent("a"), BasicEvent("b"))
    assert tree.houses == (HouseEvent("dry", True),)


def test_numbers_of_numpy_are_numbers():
    np = pytest.importorskip("numpy")
    tree = FaultTree.of(
        "top", {"top": ("atleast", np.int64(2), "a", "b")}, {"a": np.float32(0.5), "b": 0.25}
    )
    assert tree.gates[0].k == 2
    assert tree.solve().probability == 0.125


def test_formulas_may_stand_as_deep_as_one_likes():
    formula = "e"
    for depth in range(5000):
        formula = ("and" if depth % 2 else "or", formula, f"e{depth}")
    tree = FaultTree.of("top", {"top": formula})
    assert len(tree.gates) == 5000
    assert tree.gates[1].name == "top.1"


def test_the_state_of_a_house_event_is_true_or_false():
    with pytest.raises(ModelError, match="house event 'dry': state 'false'; give True or False"):
        FaultTree.of("top", {"top": ("or", "a", "dry")}, houses={"dry": "false"})


def test_a_tree_may_be_one_event():
    assert FaultTree.of("a", {}, {"a": 0.5}).solve().probability == 0.5


@pytest.mark.parametrize(
    ("gates", "events", "message"),
    [
        ({"top": "or"}, None, "gate 'top': 'or' is not a formula; give its kind and inputs"),
        ({"top": ()}, None, r"gate 'top': \(\) is not a formula"),
        ({"top": 5}, None, "gate 'top': 5 is not a formula"),
        ({"top": {"or": ["a", "b"]}}, None, r"gate 'top': \{.*\} is not a formula"),
        ({"top": ("or", None, "a")}, None, r"gate 'top\.1': None is not a formula"),
        (
            {"top": ("or", 0.5, "a")},
            None,
            r"gate 'top': 0\.5 is not an input; give a name or a formula",
        ),
        ({"top": ("atleast", True, "a")}, None, "gate 'top': atleast needs 1 number before its"),
        (
            {"top": ("or", "a", "b")},
            {"a": "0.1", "b": 0.1},
            "event 'a': '0.1' is not a figure; give a probability, failure model or None",
        ),
        ({"top": ("ore", "a")}, None, "gate 'top': 'ore' is not a kind of gate; did you mean 'or'"),
        (
            {"top": ("atleast", "a", "b")},
            None,
            "gate 'top': atleast needs 1 number before its inputs",
        ),
        ({"top": ("cardinality", 1, "a")}, None, "gate 'top': cardinality needs 2 numbers before"),
        ({"top": ("or", 2, "a")}, None, "gate 'top': 2 is not an input; give a name or a formula"),
        (
            {"top": ("or", ("and", "a", "b")), "top.1": ("or", "c")},
            None,
            r"duplicate gate 'top\.1'; rename it",
        ),
        ({"top": ("or", "a")}, {"a": 1.5}, "event 'a': p "),
        (
            {"top": ("or", "a")},
            {"a": BasicEvent("b")},
            "event 'a' is given as 'b'; give it one name",
        ),
        ({"top": ("or", "a", "bb")}, {"a": 0.5}, "gate 'top': input 'bb' is not a gate or event"),
    ],
)
def test_what_makes_no_tree_is_refused_with_its_element(gates, events, message):
    with pytest.raises(ModelError, match=message):
        FaultTree.of("top", gates, events)


def test_states_of_a_chain_without_a_row_absorb():
    chain = MarkovChain.of({"a": {"b": 0.5, "x": 0.5}, "b": {"a": 0.25, "y": 0.5, "x": 0.25}})
    assert chain == MarkovChain(chain.transitions, ("x", "y"))
    assert chain.solve("a").absorption()["y"] == pytest.approx(2 / 7, rel=1e-15)


PICK = FaultTree.of("pick", {"pick": ("or", "gripper", "motor")}, {"gripper": 7e-8, "motor": 9e-8})
PLACE = FaultTree.of("place", {"place": ("or", "motor", "arm")}, {"motor": 1.3e-7, "arm": None})


def test_a_hybrid_model_is_a_fault_tree_for_each_state_and_what_follows():
    model = HybridModel.of(
        "robot",
        {"pick": PICK, "place": PLACE},
        {"pick": "place", "place": {"pick": 0.9, "done": 0.1}},
        values={"arm": 1e-9},
    )
    first, second = model.states
    assert model.entry == "pick"
    assert first.probabilities == {"gripper": 7e-8, "motor": 9e-8}
    assert second.probabilities == {"motor": 1.3e-7, "arm": 1e-9}
    assert first.next == (NextStep("place", Fraction(1)),)
    assert second.next == (NextStep("pick", Fraction(9, 10)), NextStep("done", Fraction(1, 10)))
    assert model.parameters == (
        Parameter("gripper", 7e-8),
        Parameter("motor", 1.3e-7),
        Parameter("arm", 1e-9),
    )
    # Ten cycles on average of 1.6e-7 and 1.31e-7.
    assert solve(model).mission.failure_probability == pytest.approx(2.91e-6, rel=1e-5)
    assert solve(model).importance()["motor"].theta == 1.3e-7


def test_states_follow_in_their_order_and_the_last_leads_to_done():
    model = HybridModel.of("robot", {"pick": PICK, "again": PICK}, entry="again")
    assert [state.next[0].target for state in model.states] == ["again", "done"]
    assert model.entry == "again"


def test_shares_that_sum_to_one_but_for_rounding_are_taken_as_summing_to_one():
    third = 1.0 / 3.0
    model = HybridModel.of(
        "robot",
        {"pick": PICK, "again": PICK},
        {"pick": {"pick": third, "again": third, "done": third}, "again": "done"},
    )
    assert sum(step.weight for step in model.states[0].next) == 1


def test_figures_are_those_of_a_visits_length():
    wearing = FaultTree.of("wearing", {}, {"wearing": Exponential(0.5)})
    model = HybridModel.of("robot", {"a": wearing, "b": wearing}, visit_h={"a": 1.0, "b": 2.0})
    found = [state.probabilities["wearing"] for state in model.states]
    assert found == [Exponential(0.5).probability(hours).p for hours in (1.0, 2.0)]
    assert model.parameters == (Parameter("wearing", found[1]),)


def test_latent_units_are_handed_on():
    pair = FaultTree.of("pair", {"pair": ("and", "a", "b")}, {"a": 1e-4, "b": 1e-4})
    assert HybridModel.of("robot", {"run": pair}, latent=["a", "b"]).latent == ("a", "b")


def test_missions_of_many_figures_are_solved_at_once_as_each_alone():
    model = HybridModel.of("robot", {"pick": PICK, "place": PLACE}, values={"arm": 1e-9})
    motors = [1e-20, 1e-6, 0.5]
    found = failure_probabilities(model, {"motor": motors, "arm": 1e-12})
    assert found.shape == (3,)
    for motor, failure in zip(motors, found, strict=True):
        share = 9e-8 / 1.3e-7
        survival = (
            (1 - Fraction(7e-8))
            * (1 - Fraction(motor * share))
            * (1 - Fraction(motor))
            * (1 - Fraction(1e-12))
        )
        assert failure == pytest.approx(float(1 - survival), rel=1e-13)
    assert failure_probabilities(model, {}) == pytest.approx(
        [solve(model).mission.failure_probability], rel=1e-14
    )
    with pytest.raises(
        ModelError, match="value of 'moter', which is not a parameter; did you mean 'motor'"
    ):
        failure_probabilities(model, {"moter": 0.5})
    with pytest.raises(ModelError, match="parameter 'motor': a probability is outside"):
        failure_probabilities(model, {"motor": [1.5]})


@pytest.mark.parametrize(
    ("trees", "more", "message"),
    [
        ({}, {}, "model 'm': no states; give a fault tree for each state"),
        (
            {"pick": PICK},
            {"following": {"pik": "done"}},
            "for 'pik', which is not a state; did you",
        ),
        (
            {"pick": PICK},
            {"following": {}},
            "state 'pick': 'next' is missing; give its successors, or 'done'",
        ),
        (
            {"pick": PICK},
            {"following": {"pick": {"done": float("nan")}}},
            "state 'pick': next 'done' is nan; give a finite share",
        ),
        (
            {"pick": PICK},
            {"following": {"pick": {"done": 0.5}}},
            "state 'pick': next sums to 1/2; it must sum to 1",
        ),
        (
            {"pick": PICK},
            {"visit_h": {"place": 1.0}},
            "visit_h is given for 'place', which is not a state;",
        ),
        (
            {"pick": PICK},
            {"values": {"gripr": 1.0}},
            "value of 'gripr', which is not a parameter; did",
        ),
        ({"place": PLACE}, {}, "state 'place': no probability for arm; give each one"),
        (
            {"run": FaultTree.of("e", {}, {"e": Exponential(1.0)})},
            {},
            "state 'run': event 'e' depends on how long a visit is; give visit_h, in hours",
        ),
    ],
)
def test_what_makes_no_hybrid_model_is_refused_with_its_element(trees, more, message):
    with pytest.raises(ModelError, match=message):
        HybridModel.of("m", trees, **more)
