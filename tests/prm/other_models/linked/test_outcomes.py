import pytest

from tracerisk.errors import ModelError
from tracerisk.prm.other_models.bayes.network import BayesianNetwork
from tracerisk.prm.other_models.bayes.tables import Given
from tracerisk.prm.other_models.event_trees.event_tree import EventTree
from tracerisk.prm.other_models.expressions import Number, Reference
from tracerisk.prm.other_models.formats.linked_json import dumps, loads
from tracerisk.prm.other_models.linked import (
    Absorption,
    Figure,
    LinkedChain,
    LinkedEvent,
    LinkedModel,
    LinkedTree,
    ModelParameter,
    TopEvent,
    Transition,
)
from tracerisk.prm.other_models.linked.outcomes import outcome_trees, over_conditions
from tracerisk.prm.trees.gates import Gate, GateKind


def pair(name, *events, values=("p", "q")):
    return LinkedTree(
        name,
        f"{name} fails",
        (Gate(f"{name} fails", GateKind.OR, events),),
        tuple(LinkedEvent(e, Reference(v)) for e, v in zip(events, values, strict=True)),
    )


def course():
    return EventTree.of(
        "slip",
        {"stop": "stop fails", "brake": "brake fails"},
        {
            "held": {"stop": "success"},
            "caught": {"stop": "failure", "brake": "success"},
            "fallen": {"stop": "failure", "brake": "failure"},
        },
    )


def test_the_outcomes_of_an_event_tree_lead_a_chain_on_shared_events():
    # Stop and brake share the power, so that they fail together.
    stop = pair("stop", "power", "relay")
    brake = pair("brake", "power", "pad", values=("p", "r"))
    outcomes = outcome_trees(course(), (stop, brake))
    assert [tree.name for tree in outcomes] == ["slip: held", "slip: caught", "slip: fallen"]
    chain = LinkedChain(
        "mission",
        "move",
        (
            Transition("move", "damage", TopEvent("slip: fallen")),
            Transition("move", "move", TopEvent("slip: caught")),
            Transition("move", "done", TopEvent("slip: held")),
        ),
    )
    values = {"p": 1e-9, "q": 1e-3, "r": 2e-4}
    model = LinkedModel(
        "m",
        tuple(ModelParameter(name, Number(value)) for name, value in values.items()),
        outcomes,
        (chain,),
        (Figure("damage", Absorption("mission", ("damage",))),),
    )
    p, q, r = values.values()
    fallen = p + (1 - p) * q * r
    held = (1 - p) * (1 - q)
    assert model.solve().figures["damage"] == pytest.approx(fallen / (fallen + held), rel=1e-12)
    # d/dr: fallen' held / (fallen + held)^2, of fallen alone.
    slope = (1 - p) * q * held / (fallen + held) ** 2
    assert model.solve().sensitivities("damage")["r"] == pytest.approx(slope, rel=1e-10)
    assert loads(dumps(model), "m.json") == model


def test_an_event_of_two_values_cannot_be_joined():
    trees = (pair("stop", "power", "relay"), pair("brake", "power", "pad", values=("q", "r")))
    with pytest.raises(ModelError, match="event tree 'slip': event 'power' has different values"):
        outcome_trees(course(), trees)


def heat_model():
    """Two visits whose motors both run hot, or neither."""
    trees = tuple(
        LinkedTree(name, "m", (), (LinkedEvent("m", Reference("motor")),)) for name in "ab"
    )
    chain = LinkedChain(
        "mission",
        "a",
        (
            Transition("a", "failed", TopEvent("a")),
            Transition("a", "b"),
            Transition("b", "failed", TopEvent("b")),
            Transition("b", "done"),
        ),
    )
    return LinkedModel(
        "m",
        (ModelParameter("motor", Number(0.5)),),
        trees,
        (chain,),
        (Figure("failure", Absorption("mission", ("failed",))),),
    )


def test_conditions_bear_on_the_whole_model_at_once():
    pytest.importorskip("pyagrum", reason="networks are solved by pyAgrum")
    network = BayesianNetwork(
        {"heat": {"hot": 0.25, "cool": 0.75}},
        {"motor": Given("heat", {"hot": 0.4, "cool": 1e-9})},
    )
    found = over_conditions(heat_model(), network, "failure")
    expected = 0.25 * (1 - 0.6**2) + 0.75 * (2e-9 - 1e-18)
    assert found.figure.p == pytest.approx(expected, rel=1e-12)
    assert found.figure.q == pytest.approx(1 - expected, rel=1e-12)
    assert [dict(case.states) for case in found.cases] == [{"heat": "hot"}, {"heat": "cool"}]
    known = over_conditions(heat_model(), network, "failure", evidence={"heat": "cool"})
    assert known.figure.p == pytest.approx(2e-9, rel=1e-8)


def test_an_event_of_the_network_must_be_a_parameter():
    network = BayesianNetwork(
        {"heat": {"hot": 0.25, "cool": 0.75}}, {"moter": Given("heat", {"hot": 0.4, "cool": 0.1})}
    )
    with pytest.raises(
        ModelError, match=r"event 'moter' is not a parameter of 'm'; did you mean 'motor'\?"
    ):
        over_conditions(heat_model(), network, "failure")
