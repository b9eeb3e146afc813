"""Dynamic trees built of plain values, and the importance of their events."""

import math
import re
from dataclasses import replace

import pytest

from tracerisk.errors import ModelError
from tracerisk.prm.other_models.dynamic import (
    Dependency,
    DynamicEvent,
    DynamicGate,
    DynamicKind,
    DynamicTree,
    Restriction,
    RestrictionKind,
)
from tracerisk.prm.trees.failure_models import Constant, Exponential, Weibull
from tracerisk.prm.trees.gates import Gate, GateKind

GATES = {
    "top": ("or", "pumps", "valves"),
    "pumps": ("spare", "p1", "p2"),
    "valves": ("atleast", 2, "v1", "v2", "v3"),
    "supply": ("fdep", "power", "p1", "p2"),
}
EVENTS = {
    "p1": Exponential(1e-3),
    "p2": DynamicEvent("p2", Exponential(1e-3), 0.0),
    "v1": 1e-3,
    "v2": 1e-3,
    "v3": Weibull(1e4, 2.0),
    "power": Exponential(1e-6),
}


def test_a_tree_is_built_of_formulas():
    made = DynamicTree.of(
        "top",
        {
            "top": ("atleast", 1, "g", "h"),
            "g": ("pand", "a", "b"),
            "h": ("or", "c"),
            "half": ("pdep", 0.5, "a", "c"),
            "one": ("mutex", "a", "b"),
        },
        {"a": 0.25, "b": Exponential(1.0), "c": DynamicEvent("c", Exponential(2.0), 0.5)},
    )
    assert made == DynamicTree(
        "top",
        (
            Gate("top", GateKind.ATLEAST, ("g", "h"), 1),
            DynamicGate("g", DynamicKind.PAND, ("a", "b")),
            Gate("h", GateKind.OR, ("c",)),
        ),
        (
            DynamicEvent("a", Constant(0.25)),
            DynamicEvent("b", Exponential(1.0)),
            DynamicEvent("c", Exponential(2.0), 0.5),
        ),
        (Dependency("half", "a", ("c",), 0.5),),
        (Restriction("one", RestrictionKind.EXCLUSION, ("a", "b")),),
    )


@pytest.mark.parametrize(
    ("formula", "message"),
    [
        ("a", "'top': 'a' is not a formula; give its kind and inputs"),
        (
            ("spair", "a"),
            "'top': 'spair' is not a kind of gate; did you mean 'spare'? allowed: and",
        ),
        (("atleast", "a"), "'top': atleast needs a number before its inputs"),
        (("or", "a", 1), "'top': ['a', 1] contains an input that is not a name; give"),
        (("fdep",), "'top': fdep needs a trigger and its dependents"),
    ],
)
def test_formulas_that_say_nothing_are_refused(formula, message):
    with pytest.raises(ModelError, match=re.escape(message)):
        DynamicTree.of("top", {"top": formula}, {"a": 0.1})


@pytest.mark.parametrize(
    ("figure", "message"),
    [
        (1.5, "event 'a': p is 1.5; allowed: 0 to 1"),
        (DynamicEvent("b", Constant(0.1)), "event 'a' is given as 'b'; give it one name"),
    ],
)
def test_figures_that_fit_no_event_are_refused(figure, message):
    with pytest.raises(ModelError, match=re.escape(message)):
        DynamicTree.of("top", {"top": ("or", "a")}, {"a": figure})


def test_the_importance_of_an_event_is_that_of_trees_with_it_changed():
    tree = DynamicTree.of("top", GATES, EVENTS)
    solution = tree.solve(mission_time_h=100.0)
    table = solution.importance()
    assert sorted(table.names) == sorted(EVENTS)
    for event in tree.events:

        def with_model(model, event=event):
            events = tuple(
                replace(one, model=model) if one == event else one for one in tree.events
            )
            return replace(tree, events=events).probability(100.0).p

        row = table[event.name]
        never, start = with_model(Constant(0.0)), with_model(Constant(1.0))
        total = solution.probability
        assert row.fussell_vesely == pytest.approx(1 - never / total, rel=1e-9)
        assert row.risk_reduction_worth == pytest.approx(total / never, rel=1e-12)
        assert row.risk_achievement_worth == pytest.approx(start / total, rel=1e-12)
    assert table["p1"].tenfold == pytest.approx(
        DynamicTree.of("top", GATES, EVENTS | {"p1": Exponential(1e-2)}).probability(100.0).p
        / solution.probability,
        rel=1e-12,
    )
    assert table["p1"].probability == pytest.approx(-math.expm1(-0.1), rel=1e-14)


def test_without_what_makes_failure_possible_the_worth_is_infinite():
    tree = DynamicTree.of(
        "top", {"top": ("spare", "a", "b")}, {"a": Exponential(1e-12), "b": Exponential(1e-12)}
    )
    table = tree.solve(mission_time_h=1.0).importance()
    assert table["a"].risk_reduction_worth == math.inf
    assert table["a"].fussell_vesely == 1.0
    assert table["a"].tenfold == pytest.approx(10.0, rel=1e-9)


def test_an_event_that_prevents_has_a_negative_share():
    tree = DynamicTree.of(
        "top", {"top": ("por", "a", "b")}, {"a": Exponential(0.5), "b": Exponential(0.5)}
    )
    assert tree.solve(mission_time_h=1.0).importance()["b"].fussell_vesely < -0.1


def test_a_dynamic_tree_is_a_graph_from_its_gates_and_ties_to_their_inputs():
    pytest.importorskip("networkx", reason="networkx is not installed")
    graph = DynamicTree.of("top", GATES, EVENTS).to_networkx()
    assert graph.nodes["pumps"]["kind"] == "spare"
    assert graph.nodes["p2"] == {"kind": "event", "dormancy": 0.0, "model": Exponential(1e-3)}
    assert list(graph.successors("supply")) == ["power", "p1", "p2"]
    assert graph.edges["supply", "p2"] == {"rank": 2}
