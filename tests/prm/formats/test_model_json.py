import json
import math
import subprocess
import sys
from dataclasses import replace
from fractions import Fraction

import pytest
from hypothesis import given
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
from tracerisk.prm.formats import assessment_to_json, dumps, loads
from tracerisk.prm.formats.model_json import model_data, model_schema
from tracerisk.prm.numbers.distributions import Lognormal, Uniform
from tracerisk.prm.trees.events import HouseEvent


@pytest.fixture(scope="module")
def model():
    """A model with every kind of gate, two states and a branch."""
    gates = (
        Gate("top", GateKind.OR, ("cells", "pair", "motor")),
        Gate("cells", GateKind.ATLEAST, ("c1", "c2", "c3"), k=2),
        Gate("pair", GateKind.AND, ("p1", "p2")),
    )
    events = tuple(BasicEvent(name, "cell") for name in ("c1", "c2", "c3"))
    events += (BasicEvent("p1", "power"), BasicEvent("p2", "power"), BasicEvent("motor", "motor"))
    pick = FunctionState(
        "pick",
        1,
        FaultTree("top", gates, events),
        {"cell": 1e-3, "power": 0.1 + 0.2, "motor": 5e-324},
        (NextStep("rest", Fraction(2, 3)), NextStep("done", Fraction(1, 3))),
    )
    empty = FaultTree("top", (Gate("top", GateKind.OR, ()),), ())
    rest = FunctionState("rest", 4, empty, {}, (NextStep("pick", Fraction(1)),))
    parameters = (Parameter("cell", 1e-3), Parameter("motor", 5e-324), Parameter("power", 0.5))
    return HybridModel("Zelle ä", "pick", (pick, rest), parameters, ("c1", "c2", "c3"))


def edited(model, change):
    """Return the model's text after `change` was applied to its data."""
    data = json.loads(dumps(model))
    change(data)
    return json.dumps(data)


def test_a_model_reads_back_as_it_was_written(model, case_study):
    assert loads(dumps(model), "m.json") == model
    case = build_model(case_study, name="case")
    assert loads(dumps(case), "m.json") == case
    assert solve(loads(dumps(case), "m.json")) == solve(case)


@given(value=st.floats(0.0, 1.0))
def test_every_probability_reads_back_to_the_same_bits(model, value):
    pick = replace(model.states[0], probabilities={**model.states[0].probabilities, "cell": value})
    parameters = (Parameter("cell", 1.0), *model.parameters[1:])
    changed = replace(model, states=(pick, model.states[1]), parameters=parameters)
    read = loads(dumps(changed), "m.json").states[0].probabilities["cell"]
    assert read.hex() == value.hex()


def test_writing_is_a_fixed_point_with_sorted_keys_and_names_its_schema(model):
    text = dumps(model)
    assert dumps(loads(text, "m.json")) == text
    data = json.loads(text)
    assert (data["schema"], data["version"]) == ("tracerisk-hybrid-model", 1)
    assert list(data) == sorted(data)
    assert text.endswith("}\n")
    assert "Zelle ä" in text


def test_text_does_not_depend_on_the_hash_seed(model):
    code = (
        "import sys; from tracerisk.prm.formats import dumps, loads;"
        "sys.stdout.write(dumps(loads(sys.stdin.read(), 'm.json')))"
    )
    for seed in ("0", "1"):
        done = subprocess.run(
            [sys.executable, "-X", "utf8", "-c", code],
            input=dumps(model),
            capture_output=True,
            encoding="utf-8",
            check=True,
            env={"PYTHONHASHSEED": seed},
        )
        assert done.stdout == dumps(model)


def test_a_decimal_weight_is_read_exactly(model):
    def change(data):
        data["states"][0]["next"] = [
            {"target": "rest", "weight": "0.9"},
            {"target": "done", "weight": "0.1"},
        ]

    read = loads(edited(model, change), "m.json")
    assert read.states[0].next[0].weight == Fraction(9, 10)


@pytest.mark.parametrize("share", [0.0, 0.2, 0.5, 0.9])
def test_a_truncated_file_is_refused_with_line_and_column(model, share):
    text = dumps(model)
    cut = text[: int(share * len(text))]
    with pytest.raises(ModelError, match=r"^m.json:\d+:\d+: is not valid JSON: .*truncated\?"):
        loads(cut, "m.json")


def change_at(path, value):
    """Return an edit that sets, or with `...` removes, the element at a path of keys."""

    def change(data):
        *way, last = path
        for key in way:
            data = data[key]
        if value is ...:
            del data[last]
        else:
            data[last] = value

    return change


STATE = ("states", 0)
TREE = (*STATE, "fault_tree")


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (["schema"], "other", "schema: is 'other'; expected 'tracerisk-hybrid-model'"),
        (["version"], 7, "version: is 7; this version of tracerisk reads 1"),
        (["version"], 0, r"version: is 0; .* reads 1: rebuild the model \(version 0 does not"),
        (["version"], False, "version: is False"),
        (["entry"], ..., "the document: 'entry' is missing"),
        (["entri"], "pick", "the document: unknown key 'entri'; did you mean 'entry'"),
        (["entry"], "pack", "entry 'pack' is not a state; did you mean 'pick'"),
        (["name"], 3, "name: expected a string, found the number 3"),
        (["states"], {}, "states: expected a list, found an object"),
        (["states", 1], None, r"states\[1\]: expected an object, found null"),
        (["states", 1, "name"], "pick", "duplicate state 'pick'"),
        (["states", 1, "name"], "done", "state 'done': this name is kept"),
        (["states", 1, "name"], "a\x1b[2J", "needs printable characters"),
        (["parameters", 0, "theta"], 1.5, r"parameters\[0\].theta: probability 1.5 is outside"),
        (["parameters", 0, "theta"], True, r"parameters\[0\].theta: expected a number, found true"),
        (["parameters", 0], ..., "state 'pick': no parameter 'cell'"),
        ([*STATE, "call_sequence"], 1.5, r"states\[0\].call_sequence: expected a whole number"),
        ([*STATE, "probabilities", "cell"], -0.1, r"states\[0\].probabilities.cell: .*-0.1 is out"),
        ([*STATE, "probabilities", "cell"], "x", r"probabilities.cell: .*found the string 'x'"),
        ([*STATE, "probabilities", "cell"], ..., "state 'pick': no probability for cell"),
        ([*STATE, "probabilities", "cell"], 0.5, "0.5 of 'cell' is above its theta 0.001"),
        (
            ["states", 1, "probabilities", "cell"],
            1e-9,
            "state 'rest': .* has no event with the parameter cell",
        ),
        ([*STATE, "next", 0, "weight"], "1/2", "state 'pick': next sums to 5/6; it must sum to 1"),
        ([*STATE, "next", 0, "weight"], "1/0", r"next\[0\].weight: is '1/0', a division by zero"),
        ([*STATE, "next", 0, "weight"], "1e9", r"next\[0\].weight: is '1e9'; expected a fraction"),
        ([*STATE, "next", 0, "weight"], 0.5, r"next\[0\].weight: expected a string, found"),
        (
            [*STATE, "next", 0, "target"],
            "dome",
            "state 'pick': next 'dome' is not a state; did you",
        ),
        ([*STATE, "next", 0, "target"], "done", "state 'pick': duplicate next 'done'"),
        (["states", 1, "next", 0, "target"], "rest", "'done' cannot be reached from rest"),
        ([*TREE, "top"], "tip", r"states\[0\].fault_tree: top 'tip' is not a gate or event"),
        ([*TREE, "gates", 1, "k"], 4, r"fault_tree: gate 'cells': k is 4; allowed: 1 to 3"),
        ([*TREE, "gates", 1, "type"], "xorr", r"gates\[1\].type: is 'xorr'; did you mean 'xor'"),
        ([*TREE, "gates", 1, "inputs", 0], "c9", "gate 'cells': input 'c9' is not a gate or event"),
        ([*TREE, "gates", 1, "inputs", 0], 9, r"gates\[1\].inputs\[0\]: expected a string"),
        (["latent"], ..., "the document: 'latent' is missing"),
        (["latent", 0], "c9", "latent: 'c9' is not a basic event of a fault tree; remove it"),
        (["latent", 0], "c2", "latent: duplicate c2; remove one"),
        (
            ["latent", 2],
            "p1",
            "state 'pick': latent unit 'c1' is an input of gate 'cells': it has other inputs, c3",
        ),
        ([*TREE, "basic_events", 0, "parameter"], "zell", "no probability for zell"),
    ],
)
def test_bad_input_is_refused_with_file_and_element(model, path, value, message):
    with pytest.raises(ModelError, match=rf"^m.json(:\d+:\d+)?: .*{message}"):
        loads(edited(model, change_at(path, value)), "m.json")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('{"name": 1, "name": 2}', "duplicate key 'name' in one object"),
        ('{"name": NaN}', "NaN is not allowed; give a finite number"),
        ('{"name": ' + "9" * 5000 + "}", "a number or nesting too large"),
        ("[" * 200_000, "a number or nesting too large"),
        ("[]", "the document: expected an object, found a list"),
    ],
)
def test_hostile_json_is_refused_with_one_message(text, message):
    with pytest.raises(ModelError, match=rf"m.json(:\d+:\d+)?: .*{message}"):
        loads(text, "m.json")


def test_an_assessment_becomes_plain_json_with_null_for_infinity(block, component):
    blocks = [block("move", 1, (component("motor", 1e-6),))]
    assessment = solve(build_model(blocks, name="m"))
    assert assessment.components[0].risk_reduction_worth == math.inf
    data = assessment_to_json(assessment)
    assert json.loads(json.dumps(data, allow_nan=False)) == data
    assert data["components"][0]["risk_reduction_worth"] is None
    assert data["mission"]["failure_probability"] == assessment.mission.failure_probability
    assert data["states"][0]["failure_state"] == "move_failure"
    assert data["statement"] == assessment.statement


def test_house_events_ranges_and_distributions_read_back(model):
    tree = FaultTree(
        "top",
        (Gate("top", GateKind.CARDINALITY, ("a", "b", "on"), 1, 2),),
        (BasicEvent("a"), BasicEvent("b")),
        (HouseEvent("on", True),),
    )
    state = FunctionState("s", 1, tree, {"a": 0.25, "b": 0.5}, (NextStep("done", Fraction(1)),))
    parameters = (
        Parameter("a", 0.25, Lognormal(3.0, "mean")),
        Parameter("b", 0.5, Uniform(1e-3, 0.5, log=True)),
    )
    written = HybridModel("m", "s", (state,), parameters)
    assert loads(dumps(written), "m.json") == written


def test_what_is_written_is_valid_by_the_published_schema(model, case_study):
    jsonschema = pytest.importorskip("jsonschema", reason="jsonschema checks the schema")
    schema = model_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    validator = jsonschema.Draft202012Validator(schema)
    case = build_model(case_study, name="case")
    parameters = tuple(replace(each, distribution=Lognormal(3.0)) for each in case.parameters)
    for written in (model, case, replace(case, parameters=parameters)):
        validator.validate(model_data(written))
    for path, value in (
        (["version"], 2),
        (["entry"], ...),
        (["parameters", 0, "theta"], 1.5),
        (["states", 0, "next", 0, "weight"], "1/0"),
        (["states", 0, "fault_tree", "gates", 0, "type"], "xorr"),
    ):
        data = model_data(model)
        change_at(path, value)(data)
        assert not validator.is_valid(data), path
