"""Logic models built in Python: what is below a top, and what does not fit together."""

import pytest

from tests.prm.other_models.formats.models import solved_tops
from tracerisk.errors import Location, ModelError
from tracerisk.prm.other_models.expressions import MissionTime, Number, Reference
from tracerisk.prm.other_models.expressions.laws import Exponential
from tracerisk.prm.other_models.logic.common_cause import CommonCauseLaw
from tracerisk.prm.other_models.logic.mission_parts import (
    Alignment,
    GroupDefinition,
    Phase,
    Substitution,
)
from tracerisk.prm.other_models.logic.model import (
    ALWAYS,
    Container,
    EventDefinition,
    GateDefinition,
    HouseDefinition,
    LogicModel,
    ParameterDefinition,
    Place,
)
from tracerisk.prm.trees.events import HouseEvent
from tracerisk.prm.trees.gates import Gate, GateKind


def gate(name, kind, *inputs, home="", k=None):
    return GateDefinition(Gate(name, kind, inputs, k), Place(home))


A, B = EventDefinition("a", Number(0.25)), EventDefinition("b", Number(0.5))
TOP = gate("top", GateKind.OR, "a", "b")


def test_tops_are_those_of_each_fault_tree():
    model = LogicModel(
        gates=(
            gate("one", GateKind.OR, "a", "two", home="X"),
            gate("two", GateKind.AND, "a", "b", home="Y"),
            gate("inner", GateKind.AND, "b", home="Y.Z"),
            gate("three", GateKind.OR, "inner", home="Y"),
        ),
        events=(A, B),
        containers=(Container("X"), Container("Y"), Container("Y.Z")),
    )
    assert model.tops == ("one", "two", "three")
    assert solved_tops(model, 1.0) == {"one": 0.25, "two": 0.125, "three": 0.5}


def test_a_gate_an_event_and_a_constant_can_be_a_top():
    model = LogicModel(gates=(TOP,), events=(A, B))
    assert model.fault_tree("a").probability({"a": 0.25}).p == 0.25
    assert model.fault_tree(ALWAYS).probability({}).p == 1.0


def test_events_of_one_parameter_share_it():
    model = LogicModel(
        gates=(gate("top", GateKind.OR, "a", "b", "rate"),),
        events=(
            EventDefinition("a", Reference("rate")),
            EventDefinition("b", Reference("rate")),
            EventDefinition("rate", Number(0.5)),
        ),
        parameters=(ParameterDefinition("rate", Number(0.125)),),
    )
    tree = model.fault_tree("top")
    assert [event.parameter for event in tree.events] == [
        "rate (shared)",
        "rate (shared)",
        "rate",
    ]
    assert tree.values_at(1.0) == {"rate (shared)": 0.125, "rate": 0.5}


GROUP = GroupDefinition("pumps", CommonCauseLaw.BETA, ("a", "b"), Number(0.1), ((2, Number(0.2)),))


def test_a_common_cause_joins_the_trees_that_it_hits():
    """One member stands in each tree; what hits both is one event of their AND."""
    model = LogicModel(
        gates=(
            gate("one", GateKind.OR, "a", home="X"),
            gate("two", GateKind.OR, "b", home="Y"),
            gate("both", GateKind.AND, "one", "two", home="Z"),
        ),
        events=(EventDefinition("a"), EventDefinition("b")),
        groups=(GROUP,),
        containers=(Container("X"), Container("Y"), Container("Z")),
    )
    found = solved_tops(model, 1.0)
    alone, common = 0.08, 0.02
    assert found["one"] == pytest.approx(alone + common - alone * common, rel=1e-15)
    assert found["both"] == pytest.approx(common + (1 - common) * alone**2, rel=1e-15)
    assert solved_tops(model, 1.0, common_cause=False)["both"] == pytest.approx(0.01, rel=1e-15)


def test_factors_of_a_group_may_depend_on_the_mission_time():
    factor = Exponential(Number(1e-3), MissionTime())
    group = GroupDefinition("g", CommonCauseLaw.BETA, ("a", "b"), Number(0.1), ((2, factor),))
    model = LogicModel(
        gates=(gate("top", GateKind.AND, "a", "b"),),
        events=(EventDefinition("a"), EventDefinition("b")),
        groups=(group,),
    )
    tree = model.fault_tree("top", mission_time_h=100.0)
    beta = 0.09516258196404043
    expected = beta * 0.1 + (1 - beta * 0.1) * ((1 - beta) * 0.1) ** 2
    assert tree.probability(tree.values_at(100.0)).p == pytest.approx(expected, rel=1e-14)


def test_a_missing_level_is_reported():
    factors = ((1, Number(0.9)), (3, Number(0.1)))
    members = tuple(EventDefinition(name) for name in "abc")
    group = GroupDefinition("g", CommonCauseLaw.PHI, ("a", "b", "c"), Number(0.1), factors)
    model = LogicModel(
        gates=(gate("top", GateKind.OR, "a", "b", "c"),), events=members, groups=(group,)
    )
    with pytest.raises(ModelError, match="'g': the factor of level 2 is missing; give one for"):
        model.fault_tree("top")


def test_what_a_substitution_rules_out_is_left_out():
    both = gate("both", GateKind.AND, "a", "b")
    model = LogicModel(
        gates=(TOP, both), events=(A, B), substitutions=(Substitution("s", "both", False),)
    )
    assert model.tops == ("top",)
    # Either, and not both: 1 - 0.75 * 0.5 - 0.125.
    assert solved_tops(model, 1.0) == {"top": 0.5}


def test_phases_that_are_not_there_are_reported():
    house = HouseDefinition(HouseEvent("h", False))
    alignment = Alignment("year", (Phase("outage", 0.1, (("h", True),)),))
    model = LogicModel(houses=(house,), alignments=(alignment,))
    assert model.in_phase("year", "outage").houses[0].house.state
    with pytest.raises(ModelError, match="there is no alignment 'day'; allowed: year"):
        model.in_phase("day", "outage")
    with pytest.raises(ModelError, match="alignment 'year' has no phase 'run'; allowed: outage"):
        model.in_phase("year", "run")


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ({"gates": (TOP,)}, "gate 'top': input 'a' is not a gate or event; allowed: top"),
        (
            {"gates": (TOP,), "events": (A, B, EventDefinition("top"))},
            "'top' names a basic event and a gate; rename one",
        ),
        ({"events": (EventDefinition(ALWAYS),)}, "'#true' names a basic event; use"),
        ({"events": (EventDefinition("a\n"),)}, "'a\\n' names a basic event; use"),
        (
            {"gates": (gate("g", GateKind.ATLEAST, "a", k=2),), "events": (A,)},
            "gate 'g': k is 2; allowed: 1 to 1",
        ),
        (
            {"gates": (gate("g", GateKind.OR, "h"), gate("h", GateKind.OR, "g"))},
            "gate 'g' depends on itself (g -> h -> g); break the cycle",
        ),
        (
            {"parameters": (ParameterDefinition("p", Reference("p")),)},
            "parameter 'p' depends on itself (p -> p); break the cycle",
        ),
        (
            {"parameters": (ParameterDefinition("p", Reference("q")),)},
            "parameter 'p': no parameter 'q'; allowed: p",
        ),
        (
            {"events": (EventDefinition("a", Reference("q")),)},
            "basic event 'a': no parameter 'q'; allowed: none",
        ),
        (
            {"groups": (GROUP,), "events": (A,)},
            "common cause group 'pumps': member 'b' is not a basic event; allowed: a",
        ),
        (
            {
                "groups": (
                    GROUP,
                    GroupDefinition(
                        "more",
                        *[
                            getattr(GROUP, part)
                            for part in ("law", "members", "distribution", "factors")
                        ],
                    ),
                ),
                "events": (A, B),
            },
            "common cause group 'more': member 'a' is a member of 'pumps' too; remove it from one",
        ),
        (
            {"alignments": (Alignment("y", (Phase("p", 1.0, (("h", True),)),)),)},
            "alignment 'y': phase 'p' sets 'h', which is not a house event; allowed: none",
        ),
    ],
    ids=lambda part: part[:40] if isinstance(part, str) else "",
)
def test_what_does_not_fit_together_is_reported(parts, message):
    with pytest.raises(ModelError) as caught:
        LogicModel(**parts)
    assert message in str(caught.value)


def test_a_bad_figure_is_reported_where_its_event_stands():
    model = LogicModel(
        gates=(TOP,),
        events=(EventDefinition("a", Reference("p")), B),
        parameters=(ParameterDefinition("p", MissionTime()),),
        locations={("basic event", "a"): Location("m.xml", 7, 3)},
    )
    with pytest.raises(ModelError) as caught:
        model.fault_tree("top").values_at(2.0)
    assert str(caught.value).startswith("m.xml:7:3: event 'a': probability 2.0 is outside [0, 1]")
