from __future__ import annotations

import pytest

from tracerisk.errors import ModelError
from tracerisk.prm import BasicEvent, FaultTree, Gate, GateKind
from tracerisk.prm.failure_models import Constant, Exponential
from tracerisk.prm.fault_tree import HouseEvent


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


def test_a_tree_may_be_one_event():
    assert FaultTree.of("a", {}, {"a": 0.5}).solve().probability == 0.5


@pytest.mark.parametrize(
    ("gates", "events", "message"),
    [
        ({"top": "or"}, None, "gate 'top': 'or' is no formula; give its kind and inputs"),
        ({"top": ()}, None, r"gate 'top': \(\) is no formula"),
        ({"top": ("ore", "a")}, None, "gate 'top': 'ore' is no kind of gate; did you mean 'or'"),
        (
            {"top": ("atleast", "a", "b")},
            None,
            "gate 'top': atleast needs 1 number before its inputs",
        ),
        ({"top": ("cardinality", 1, "a")}, None, "gate 'top': cardinality needs 2 numbers before"),
        ({"top": ("or", 2, "a")}, None, "gate 'top': 2 is no input; give a name or a formula"),
        (
            {"top": ("or", ("and", "a", "b")), "top.1": ("or", "c")},
            None,
            r"gate 'top\.1' stands twice; rename it",
        ),
        ({"top": ("or", "a")}, {"a": 1.5}, "event 'a': p "),
        (
            {"top": ("or", "a")},
            {"a": BasicEvent("b")},
            "event 'a' is given as 'b'; give it one name",
        ),
        ({"top": ("or", "a", "bb")}, {"a": 0.5}, "gate 'top': input 'bb' is no gate or event"),
    ],
)
def test_what_makes_no_tree_is_refused_with_its_element(gates, events, message):
    with pytest.raises(ModelError, match=message):
        FaultTree.of("top", gates, events)
