"""The OpenPRA engine's JSON out and back, and what is refused."""

import json
from dataclasses import replace

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from tests.prm.other_models.formats.models import logic_models, ordered, solved_tops
from tests.prm.other_models.formats.openpra_engine import engine_figures, needs_engine, violations
from tracerisk.errors import ModelError, TooLargeError
from tracerisk.prm.other_models.event_trees.elements import (
    Branch,
    Condition,
    End,
    EventSequence,
    Fork,
    InitiatingEvent,
    Link,
    Path,
    Weight,
)
from tracerisk.prm.other_models.event_trees.event_tree import EventTree
from tracerisk.prm.other_models.expressions import MissionTime, Number
from tracerisk.prm.other_models.expressions.laws import Exponential
from tracerisk.prm.other_models.formats.open_psa import loads_open_psa
from tracerisk.prm.other_models.formats.open_psa.writer import dumps_open_psa
from tracerisk.prm.other_models.formats.openpra import (
    dumps_openpra,
    loads_openpra,
    read_openpra,
    write_openpra,
)
from tracerisk.prm.other_models.logic.common_cause import CommonCauseLaw
from tracerisk.prm.other_models.logic.event_trees import solved_event_trees
from tracerisk.prm.other_models.logic.mission_parts import (
    Alignment,
    EventTreeDefinition,
    Substitution,
)
from tracerisk.prm.other_models.logic.model import (
    Container,
    EventDefinition,
    GateDefinition,
    LogicModel,
    Place,
)
from tracerisk.prm.trees.gates import Gate, GateKind

FIGURES = st.floats(0.0, 1.0).map(Number)


def op(kind, *args, **more):
    return {"op": kind, "args": [{"event": a} if isinstance(a, str) else a for a in args], **more}


def tree(name, top, figures, **more):
    events = [{"name": event, "p": p} for event, p in figures.items()]
    return {"name": name, "top": top, "basicEvents": events, **more}


def request(*trees, **more):
    model = {"name": "M", "faultTrees": list(trees), **more}
    return {"settings": {"bdd": True}, "model": model}


PUMPS = tree(
    "Pumps",
    op("or", op("atleast", "a", "b", "c", k=2), {"op": "not", "arg": op("or", "d", "h")}),
    {"a": 0.1, "b": 0.2, "c": 0.3, "d": 0.9},
    houseEvents=[{"name": "h", "state": False}],
)
VALVES = tree("Valves", op("and", "a", "e"), {"a": 0.1, "e": 0.5}, description="the valves")
GROUP = {
    "name": "G",
    "model": "MGL",
    "members": ["a", "b", "c"],
    "distribution": 0.1,
    "factors": [{"level": 2, "value": 0.2}, {"value": 0.5}],
}
EVENT_TREE = {
    "name": "Leak",
    "initiatingEvent": {"name": "LEAK", "frequency": 0.01, "unit": "yr-1"},
    "functionalEvents": [{"name": "Pumps", "description": "pumping"}, {"name": "Valves"}],
    "sequences": [
        {
            "name": "S1",
            "functionalStates": [
                {"name": "Pumps", "state": "failure"},
                {"name": "Valves", "state": "bypass"},
            ],
            "endState": "flood",
        },
        {
            "name": "S2",
            "functionalStates": [
                {"name": "Pumps", "state": "success"},
                {"name": "Valves", "state": "failure"},
            ],
            "endState": "flood",
        },
        {
            "name": "S3",
            "functionalStates": [
                {"name": "Pumps", "state": "success"},
                {"name": "Valves", "state": "success"},
            ],
            "endState": "dry",
        },
    ],
}


def read(data):
    return loads_openpra(json.dumps(data), "m.json")


def test_a_model_is_read_as_the_engine_reads_it():
    model = read(request(PUMPS, VALVES))
    assert model.name == "M"
    assert model.tops == ("Pumps", "Valves")
    assert model.gates_by_name["Pumps#1"] == Gate("Pumps#1", GateKind.ATLEAST, ("a", "b", "c"), 2)
    assert model.containers[1] == Container("Valves", label="the valves")
    # At least two of three, or not d: 0.098 and 0.1 apart.
    at_least_two = 0.1 * 0.2 * 0.7 + 0.1 * 0.8 * 0.3 + 0.9 * 0.2 * 0.3 + 0.1 * 0.2 * 0.3
    found = solved_tops(model, 1.0)
    assert found["Pumps"] == pytest.approx(at_least_two + (1 - at_least_two) * 0.1, rel=1e-15)
    assert found["Valves"] == 0.05


def test_a_bare_model_needs_no_request_around_it():
    assert read(request(PUMPS)["model"]) == read(request(PUMPS))


def test_the_sequences_of_an_event_tree_come_out():
    model = read(request(PUMPS, VALVES, eventTrees=[EVENT_TREE]))
    (solution,) = solved_event_trees(model, 1.0)
    assert solution.initiating == InitiatingEvent("LEAK", 0.01, "year")
    assert solution.total == pytest.approx(1.0, rel=1e-14)
    tops = solved_tops(model, 1.0)
    assert solution["S1"] == pytest.approx(0.01 * tops["Pumps"], rel=1e-14)
    # 'a' feeds both: enumerated by hand over a, given b, c, d, e.
    not_pumps_and_valves = 0.1 * 0.5 * (0.8 * 0.7) * 0.9
    assert solution["S2"] == pytest.approx(0.01 * not_pumps_and_valves, rel=1e-14)


def test_common_causes_are_written_out_for_the_engine_and_read_back_as_groups():
    """A member that no tree has stays an event, and groups that do not fit the gates are left."""
    lone = tree("Pumps", op("or", "a", "b"), {"a": 0.1, "b": 0.1, "c": 0.1})
    model = read(request(lone, ccfGroups=[GROUP]))
    request_ = json.loads(dumps_openpra(model))
    assert violations(request_) == []
    again = read(request_)
    assert again.groups == model.groups
    assert solved_tops(again, 1.0) == solved_tops(model, 1.0)
    request_["model"]["faultTrees"][0]["basicEvents"][0]["p"] = 0.5
    changed = read(request_)
    assert changed.groups == ()
    assert solved_tops(changed, 1.0)["Pumps"] > 0.5
    assert changed.findings[-1].endswith(
        "the common cause groups do not fit the gates and events of the model, which count"
    )


def test_names_and_ends_that_the_engine_refuses_come_back_by_the_table_beside():
    model = read(
        request(
            tree("T", op("or", "a.1", "T_g1", "h"), {"a.1": 0.5, "T_g1": 0.25}, houseEvents=HOUSE),
            tree("T.x", op("and", "a 1", "h"), {"a 1": 0.5}, houseEvents=HOUSE),
            eventTrees=[
                EVENT_TREE
                | {
                    "functionalEvents": [{"name": "T"}, {"name": "T.x"}],
                    "sequences": [
                        SEQUENCE | {"name": "S1", "endState": "bad.end"},
                        SEQUENCE
                        | {
                            "name": "S2",
                            "endState": "bad.end",
                            "functionalStates": [{"name": "T.x", "state": "success"}],
                        },
                    ],
                }
            ],
        )
    )
    text = dumps_openpra(model)
    request_ = json.loads(text)
    assert violations(request_) == []
    assert request_["tracerisk"] == {
        "names": {"T_x": "T.x", "a_1": "a.1", "T_g1-2": "T_g1", "a_1-2": "a 1"},
        "endStates": {"bad_end-S1": "bad.end", "bad_end-S2": "bad.end"},
        "houseEvents": ["h"],
    }
    assert loads_openpra(text, "again.json") == model


HOUSE = [{"name": "h", "state": True}]
SEQUENCE = {"functionalStates": [{"name": "T.x", "state": "failure"}]}


@pytest.mark.parametrize("kind", ["or", "and", "atleast"])
def test_an_operation_of_one_event_is_one_that_the_engine_builds(kind):
    """Its engine makes no gate of an event, so that it cannot be a top, nor stand twice."""
    inner = op("or", op("or", "a"), "a", op("or", op("or", "a")))
    for top in ({"event": "a"}, op(kind, "a", **({"k": 1} if kind == "atleast" else {})), inner):
        text = dumps_openpra(read(request(tree("T", top, {"a": 0.5}))))
        assert violations(json.loads(text)) == []
        again = loads_openpra(text, "again.json")
        assert solved_tops(again, 1.0) == {"T": 0.5}
        assert dumps_openpra(again) == text


def test_common_causes_are_read():
    model = read(request(PUMPS, VALVES, ccfGroups=[GROUP | {"distribution": 0.1}]))
    (group,) = model.groups
    assert group.law is CommonCauseLaw.MGL
    assert group.factors == ((2, Number(0.2)), (3, Number(0.5)))
    assert model.findings == (
        "m.json:1:640: the members of 'G' have figures of their own; the figure of the group, 0.1, is used",
    )
    assert {each.name for each in model.events if each.expression is None} == {"a", "b", "c"}


@pytest.mark.parametrize(
    "more",
    [{}, {"ccfGroups": [GROUP]}, {"eventTrees": [EVENT_TREE]}, {"description": "all of it"}],
)
def test_a_model_comes_back_as_it_was(more):
    model = read(request(PUMPS, VALVES, **more))
    text = dumps_openpra(model)
    assert violations(json.loads(text)) == []
    assert ordered(loads_openpra(text, "again.json")) == ordered(model)
    assert dumps_openpra(loads_openpra(text, "again.json")) == text
    across = loads_open_psa(dumps_open_psa(model), "across.xml")
    assert ordered(across) == ordered(model)


@settings(suppress_health_check=list(HealthCheck))
@given(st.booleans().flatmap(lambda plain: logic_models(figures=FIGURES, plain_names=plain)))
def test_a_random_model_is_taken_by_the_engine_and_keeps_its_names_and_figures(model):
    """Gates may be written otherwise; what their tops come to may not change."""
    assume(model.tops)
    text = dumps_openpra(model)
    assert violations(json.loads(text)) == []
    again = loads_openpra(text, "again.json")
    found = solved_tops(model, 1.0)
    assert set(found) <= set(again.gates_by_name)
    for top, figure in found.items():
        shared = again.fault_tree(top)
        assert shared.probability(shared.values_at(1.0)).p == pytest.approx(figure, rel=1e-12)
    assert dumps_openpra(model) == text


@needs_engine
@settings(suppress_health_check=list(HealthCheck), max_examples=200, deadline=None)
@given(st.booleans().flatmap(lambda plain: logic_models(figures=FIGURES, plain_names=plain)))
def test_the_engine_itself_solves_a_random_model_to_our_digits(model):
    assume(model.tops)
    found, _ = engine_figures(json.loads(dumps_openpra(model)))
    ours = solved_tops(model, 1.0)
    assert sorted(found.values()) == pytest.approx(sorted(ours.values()), rel=1e-12, abs=1e-15)


def test_a_home_with_the_name_of_another_top_gives_no_tree_its_name():
    places = {"aa": Place("a"), "a": Place()}
    gates = tuple(
        GateDefinition(Gate(name, GateKind.OR, ("b",)), place) for name, place in places.items()
    )
    events = (EventDefinition("b", Number(0.25)),)
    model = LogicModel(gates=gates, events=events, containers=(Container("a"),))
    again = loads_openpra(dumps_openpra(model), "again.json")
    assert solved_tops(again, 1.0) == solved_tops(model, 1.0)


def test_a_gate_that_feeds_two_comes_back_as_one():
    gates = (
        Gate("top", GateKind.OR, ("one", "two")),
        Gate("one", GateKind.AND, ("shared", "a")),
        Gate("two", GateKind.AND, ("shared", "b")),
        Gate("shared", GateKind.XOR, ("c", "shared#1")),
    )
    definitions = [GateDefinition(gate, Place("T")) for gate in gates]
    inner = Gate("shared#1", GateKind.NOT, ("a",))
    definitions.append(GateDefinition(inner, Place("T"), nested=True))
    model = LogicModel(
        gates=tuple(definitions),
        events=tuple(EventDefinition(name, Number(0.25), Place("T")) for name in "abc"),
        containers=(Container("T"),),
    )
    again = loads_openpra(dumps_openpra(model), "again.json")
    assert sorted(map(str, again.gates)) == sorted(map(str, model.gates))
    assert solved_tops(again, 1.0) == solved_tops(model, 1.0)


def test_computed_figures_need_a_mission_time():
    events = (EventDefinition("a", Exponential(Number(1e-3), MissionTime()), Place("T")),)
    gate = GateDefinition(Gate("T", GateKind.OR, ("a",)), Place("T"))
    model = LogicModel(gates=(gate,), events=events, containers=(Container("T"),))
    with pytest.raises(
        ModelError, match="event 'a': its figure is an expression, but OpenPRA takes"
    ):
        dumps_openpra(model)
    again = loads_openpra(dumps_openpra(model, mission_time_h=1.0), "again.json")
    assert again.events[0].expression == Number(0.0009995001666250084)


def leaf(name="a", p=0.5):
    return tree("T", {"event": name}, {"a": p})


BAD = [
    ("", "m.json: is empty; expected a JSON file"),
    ('{"model": {', "m.json:1:12: is not valid JSON"),
    ('{"model": {"name": "a", "name": "b"}}', "duplicate key 'name' in one object"),
    ("[1]", "m.json:1:1: the document: expected an object, found a list"),
    ({"model": {}, "version": 2}, "unknown key 'version'; allowed: model, settings"),
    (
        {"model": {"gates": []}},
        "m.json:1:21: model: unknown key 'gates'; allowed: ccfGroups, ",
    ),
    ({"model": {"faultTrees": {}}}, "model.faultTrees: expected a list, found an object"),
    (request({"name": "T"}), "model.faultTrees[0]: 'top' is missing"),
    (
        request(leaf("b")),
        "faultTrees[0].top.event: 'b' is not an event or fault tree; allowed: T, a",
    ),
    (request(leaf(p=1.5)), "basicEvents[0].p: probability 1.5 is outside [0, 1]"),
    (request(leaf(p="0.5")), "basicEvents[0].p: expected a number, found the string '0.5'"),
    (request(leaf(), leaf()), "faultTrees[1].name: 'T' names two fault trees; rename one"),
    (
        request(tree("T", op("maybe", "a"), {"a": 0.5})),
        "top.op: is 'maybe'; allowed: and, ",
    ),
    (
        request(tree("T", op("or"), {"a": 0.5})),
        "model.faultTrees[0].top.args: is empty; give at least one argument",
    ),
    (
        request(tree("T", op("atleast", "a"), {"a": 0.5})),
        "model.faultTrees[0].top: 'k' is missing",
    ),
    (
        request(tree("T", op("atleast", "a", k=2), {"a": 0.5})),
        "model.faultTrees[0].top: gate 'T': k is 2; allowed: 1 to 1",
    ),
    (
        request(tree("T", op("xor", "a"), {"a": 0.5})),
        "gate 'T': xor needs at least 2 inputs, it has 1",
    ),
    (
        request(tree("T", {"event": "T"}, {})),
        "gate 'T' depends on itself (T -> T); break the cycle",
    ),
    (
        request(tree("T", op("or", "U"), {}), tree("U", op("or", "T"), {})),
        "gate 'T' depends on itself (T -> U -> T); break the cycle",
    ),
    (
        request(tree("T", {"event": "a"}, {"a": 0.5}), tree("U", {"event": "a"}, {"a": 0.25})),
        "model.faultTrees[1].basicEvents[0].p: is 0.25, but 'a' has 0.5 at m.json:1:120; give an event one",
    ),
    (
        request(
            tree("T", {"event": "h"}, {}, houseEvents=[{"name": "h", "state": True}]),
            tree("U", {"event": "h"}, {}, houseEvents=[{"name": "h", "state": False}]),
        ),
        "faultTrees[1].houseEvents[0].state: is false, at m.json:1:139 it is not; give one house",
    ),
    (
        request(tree("T", op("or", op("or", "a", name="G"), op("and", "a", name="G")), {"a": 0.5})),
        "'G' names two different gates, one at m.json:1:",
    ),
    (
        request(leaf(), ccfGroups=[GROUP]),
        "model.ccfGroups[0].members[1]: member 'b' is not a basic event; allowed: a",
    ),
    (
        request(PUMPS, ccfGroups=[GROUP | {"model": "gamma"}]),
        "ccfGroups[0].model: is 'gamma'; ",
    ),
    (
        request(PUMPS, ccfGroups=[GROUP | {"factors": []}]),
        "ccfGroups[0]: 'factors' are missing; give at least one",
    ),
    (
        request(PUMPS, ccfGroups=[GROUP | {"factors": [{"level": 4, "value": 0.1}]}]),
        "factors[0]: the level 4 of MGL; allowed: 2 to 3",
    ),
    (
        request(PUMPS, ccfGroups=[GROUP | {"distribution": 2}]),
        "ccfGroups[0].distribution: probability 2.0 is outside [0, 1]",
    ),
    (
        request(
            PUMPS,
            ccfGroups=[
                {key: value for key, value in GROUP.items() if key != "distribution"},
            ],
        ),
        "'distribution' is missing, and its members have different figures",
    ),
    (
        request(PUMPS, ccfGroups=[GROUP, GROUP | {"name": "H"}]),
        "common cause group 'H': member 'a' is a member of 'G' too; remove it from one",
    ),
    (
        request(PUMPS, eventTrees=[EVENT_TREE]),
        "functionalStates[1].name: 'Valves' is not a fault tree; allowed: Pumps",
    ),
    (
        request(PUMPS, VALVES, eventTrees=[EVENT_TREE | {"functionalEvents": [{"name": "Pumps"}]}]),
        "functionalStates[1]: 'Valves' is not a functional event; allowed: Pumps",
    ),
    (
        request(PUMPS, VALVES, eventTrees=[EVENT_TREE | {"sequences": []}]),
        "eventTrees[0]: 'sequences' are missing; give at least one",
    ),
    (
        request(
            PUMPS,
            VALVES,
            eventTrees=[
                EVENT_TREE
                | {
                    "sequences": [
                        EVENT_TREE["sequences"][0],
                        EVENT_TREE["sequences"][0] | {"name": "S9"},
                    ]
                }
            ],
        ),
        "eventTrees[0].sequences[1]: has the same states as 'S1'; remove one of them",
    ),
    (
        request(
            PUMPS,
            eventTrees=[
                EVENT_TREE | {"initiatingEvent": {"name": "I", "frequency": -1, "unit": "yr-1"}}
            ],
        ),
        "initiatingEvent.frequency: initiating event 'I': frequency per year -1.0; allowed: finite,",
    ),
    (
        request(
            PUMPS,
            eventTrees=[
                EVENT_TREE | {"initiatingEvent": {"name": "I", "frequency": 1, "unit": "s"}}
            ],
        ),
        "initiatingEvent.unit: is 's'; allowed: yr-1",
    ),
]


@pytest.mark.parametrize(("data", "message"), BAD, ids=[message[:50] for _, message in BAD])
def test_what_is_wrong_is_reported_where_it_stands(data, message):
    text = data if isinstance(data, str) else json.dumps(data)
    with pytest.raises(ModelError) as caught:
        loads_openpra(text, "m.json")
    assert message in str(caught.value)
    assert str(caught.value).startswith("m.json:")


def test_deep_nesting_is_refused():
    expression = {"event": "a"}
    for _ in range(250):
        expression = {"op": "not", "arg": expression}
    with pytest.raises(ModelError, match="expressions nest more than 200 deep; flatten the model"):
        read(request(tree("T", expression, {"a": 0.5})))
    with pytest.raises(ModelError, match="a number or nesting too large"):
        loads_openpra("[" * 100_000, "m.json")


def test_files_that_cannot_be_read_or_written_are_reported(tmp_path):
    with pytest.raises(ModelError, match="cannot be read: Is a directory"):
        read_openpra(tmp_path)
    with pytest.raises(ModelError, match="cannot be written: Is a directory"):
        write_openpra(LogicModel(), tmp_path)
    path = tmp_path / "latin.json"
    path.write_bytes('{"model":\n {"name": "é"}}'.encode("latin-1"))
    with pytest.raises(ModelError, match=r"latin\.json:2: the byte 0xE9 is not UTF-8"):
        read_openpra(path)


CHAIN = [GateDefinition(Gate(f"g{i}", GateKind.OR, (f"g{i + 1}", f"g{i + 2}"))) for i in range(60)]
EVENT = EventDefinition("a", Number(0.5))
TOP = GateDefinition(Gate("T", GateKind.OR, ("a", "b")), Place("T"))
MODEL = LogicModel(
    gates=(TOP,),
    events=(EVENT, EventDefinition("b", Number(0.5))),
    containers=(Container("T"),),
)


def with_tree(start, **more):
    tree = EventTree("E", ("F",), start, (EventSequence("S"),), **more)
    return replace(MODEL, event_trees=(EventTreeDefinition(tree),))


@pytest.mark.parametrize(
    ("model", "message"),
    [
        (
            replace(MODEL, events=(EventDefinition("a"), MODEL.events[1])),
            "event 'a' has no probability, which OpenPRA needs; give it one",
        ),
        (
            LogicModel(events=(EVENT,)),
            "OpenPRA allows events in fault trees only, but the model has none; add one",
        ),
        (
            replace(MODEL, substitutions=(Substitution("s", "T", False),)),
            "OpenPRA has no substitutions; write them as gates, or leave them out",
        ),
        (
            with_tree(Branch(End("S"), (Condition("T"),))),
            "event tree 'E': the initial state has instructions of its own",
        ),
        (
            with_tree(Branch(Fork("F", (Path("x", End("S"), (Weight(0.5),)),)))),
            "event tree 'E': at 'F' a path does more than collect one gate",
        ),
        (
            with_tree(Branch(Fork("F", (Path("x", End("S")), Path("y", End("S")))))),
            "event tree 'E': several paths end in the sequence 'S'",
        ),
        (
            with_tree(Branch(Link("other"))),
            "event tree 'E': a path leads into another event tree",
        ),
        (
            with_tree(Branch(Fork("F", (Path("x", End("S"), (Condition("a"),)),)))),
            "an event tree collects 'a', but OpenPRA takes fault trees only;",
        ),
        (
            with_tree(Branch(End("S")), initiating=InitiatingEvent("I", 2.0, "month")),
            "event tree 'E': OpenPRA has frequencies per year only, not per month; convert it",
        ),
    ],
    ids=lambda part: part[:40] if isinstance(part, str) else "",
)
def test_what_openpra_cannot_hold_is_reported(model, message):
    with pytest.raises(ModelError) as caught:
        dumps_openpra(model)
    assert message in str(caught.value)


def test_gates_that_would_be_written_without_end_are_too_large():
    last = (
        GateDefinition(Gate("g60", GateKind.OR, ("a", "b"))),
        GateDefinition(Gate("g61", GateKind.AND, ("a", "b"))),
    )
    model = LogicModel(gates=(*CHAIN, *last), events=MODEL.events, alignments=(Alignment("n", ()),))
    with pytest.raises(TooLargeError, match="OpenPRA repeats a gate for each of its uses,"):
        dumps_openpra(model)


def test_gates_too_deep_to_nest_are_reported():
    chain = [GateDefinition(Gate(f"g{i}", GateKind.NOT, (f"g{i + 1}",))) for i in range(300)]
    last = GateDefinition(Gate("g300", GateKind.OR, ("a", "b")))
    model = LogicModel(gates=(*chain, last), events=MODEL.events)
    with pytest.raises(
        TooLargeError, match="gate 'g0' has 301 levels of gates below it, which OpenPRA nests;"
    ):
        dumps_openpra(model)
