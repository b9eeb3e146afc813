import copy
import json
from decimal import Decimal, localcontext
from fractions import Fraction
from pathlib import Path

import pytest

from tracerisk.errors import ModelError
from tracerisk.prm import build_model
from tracerisk.prm.numbers.distributions import Beta, Gamma, Lognormal, Normal, Uniform
from tracerisk.prm.other_models.expressions import (
    Call,
    Difference,
    Expression,
    MissionTime,
    Negation,
    Number,
    Product,
    Quotient,
    Reference,
    Sum,
)
from tracerisk.prm.other_models.expressions.deviates import (
    BetaDeviate,
    GammaDeviate,
    Histogram,
    LognormalDeviate,
    NormalDeviate,
    UniformDeviate,
)
from tracerisk.prm.other_models.expressions.laws import Exponential, Glm, PeriodicTest, Weibull
from tracerisk.prm.other_models.formats.linked_json import dumps, linked_data, linked_schema, loads
from tracerisk.prm.other_models.linked import (
    Absorption,
    Figure,
    LinkedChain,
    LinkedEvent,
    LinkedModel,
    LinkedTree,
    ModelParameter,
    Occupancy,
    TopEvent,
    Transfer,
    Transition,
    linked,
)
from tracerisk.prm.trees.events import HouseEvent
from tracerisk.prm.trees.gates import Gate, GateKind

X, Y = Reference("x"), Number(0.25)
VALUES: tuple[Expression, ...] = (
    Number(0.1 + 0.2),
    Number(3, "int"),
    Number(1.0, "bool"),
    Number(5e-324),
    MissionTime(),
    Sum((X, Y)),
    Difference((Number(1.0), X)),
    Product((X, X)),
    Quotient((X, Y)),
    Negation(X),
    Call("pi", ()),
    Call("exp", (X,)),
    Call("pow", (X, Y)),
    Call("max", (X,)),
    Call("ite", (X, Y, X)),
    Exponential(X, MissionTime()),
    Glm(X, Y, Y, MissionTime()),
    Weibull(X, Y, Y, MissionTime()),
    PeriodicTest((X, Y, Y, MissionTime())),
    UniformDeviate(X, Y),
    NormalDeviate(X, Y),
    GammaDeviate(X, Y),
    BetaDeviate(X, Y),
    LognormalDeviate((X, Number(3.0), Number(0.95))),
    Histogram((Number(0.0), X, Number(1.0)), (Y, Number(0.5))),
    TopEvent("tree"),
    Absorption("chain", ("bad", "worse")),
    Occupancy("chain", ("bad",), steps=3),
    Occupancy("repair", ("down",)),
    Occupancy("repair", ("down",), 5.0),
)


@pytest.fixture(scope="module")
def whole() -> LinkedModel:
    """A model with everything that the format has a place for."""
    tree = LinkedTree(
        "tree",
        "top",
        (
            Gate("top", GateKind.OR, ("vote", "some", "other", "off")),
            Gate("vote", GateKind.ATLEAST, ("a", "b", "c"), 2),
            Gate("some", GateKind.CARDINALITY, ("a", "b"), 1, 1),
        ),
        (LinkedEvent("a", X), LinkedEvent("b", Y), LinkedEvent("c", Exponential(X, MissionTime()))),
        (HouseEvent("off", False),),
        (Transfer("other", "other"),),
    )
    other = LinkedTree("other", "a", (), (LinkedEvent("a", X),))
    chain = LinkedChain(
        "chain",
        "run",
        (
            Transition("run", "bad", TopEvent("tree")),
            Transition("run", "worse", Product((Number(1e-3), X))),
            Transition("run", "run", share=Fraction(1, 3)),
            Transition("run", "done", share=Fraction(2, 3)),
        ),
    )
    repair = LinkedChain(
        "repair",
        "up",
        (Transition("up", "down", X), Transition("down", "up", Number(0.125))),
        "continuous",
    )
    spreads = (
        Lognormal(3.0),
        Lognormal(10.0, "mean"),
        Uniform(0.0, 0.5),
        Uniform(1e-9, 1e-3, log=True),
        Beta(0.5, 3.0),
        Gamma(2.0, 1e-6),
        Normal(1e-3, 1e-4),
    )
    return LinkedModel(
        "whole: ünïcode",
        (
            ModelParameter("x", Number(1e-5), "hour-1"),
            *(
                ModelParameter(f"spread {number}", Number(1e-4), distribution=spread)
                for number, spread in enumerate(spreads)
            ),
        ),
        (tree, other),
        (chain, repair),
        tuple(Figure(f"figure {number}", value) for number, value in enumerate(VALUES)),
        24.0,
    )


@pytest.fixture(scope="module")
def case(case_study):
    loop = {"place": {"init": Fraction(9, 10), "done": Fraction(1, 10)}}
    return linked(build_model(case_study, profile=loop, name="case study"))


@pytest.fixture(scope="module")
def validator():
    jsonschema = pytest.importorskip("jsonschema", reason="jsonschema checks the published schema")
    schema = linked_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


@pytest.mark.parametrize("name", ["whole", "case"])
def test_a_model_comes_back_as_it_was(request, name):
    model = request.getfixturevalue(name)
    text = dumps(model)
    assert loads(text, "model.json") == model
    assert dumps(loads(text, "model.json")) == text


@pytest.mark.parametrize("name", ["whole", "case"])
def test_what_is_written_is_valid_by_the_schema(request, validator, name):
    validator.validate(linked_data(request.getfixturevalue(name)))


def test_the_case_study_has_the_same_figures_after_the_way_through_json(case):
    again = loads(dumps(case), "model.json").solve()
    assert again.figures == case.solve().figures
    assert again.sensitivities("mission failure") == case.solve().sensitivities("mission failure")


def test_a_node_without_a_place_in_the_format_is_refused():
    class Odd(Expression):
        pass

    model = LinkedModel("m", (ModelParameter("x", Odd()),))
    with pytest.raises(ModelError, match="Odd cannot be written to the JSON of a linked model"):
        dumps(model)


# bad input

SMALL = {
    "schema": "tracerisk-linked-model",
    "version": 1,
    "name": "small",
    "modelData": [{"name": "x", "value": 0.5}],
    "faultTrees": [
        {
            "name": "t",
            "topEvent": "top",
            "gates": [{"name": "top", "type": "or", "inputs": ["a", "b"]}],
            "events": [
                {"name": "a", "type": "basic", "value": {"parameter": "x"}},
                {"name": "b", "type": "house", "value": False},
            ],
        }
    ],
    "markovChains": [
        {
            "name": "c",
            "initialState": "s",
            "transitions": [
                {"source": "s", "target": "bad", "probability": {"topEvent": "t"}},
                {"source": "s", "target": "done", "remainder": "1"},
            ],
        }
    ],
    "figures": [{"name": "f", "value": {"absorption": {"markovChain": "c", "states": ["bad"]}}}],
}
REMOVED = object()


def changed(path, value):
    data = copy.deepcopy(SMALL)
    place = data
    for key in path[:-1]:
        place = place[key]
    if value is REMOVED:
        del place[path[-1]]
    else:
        place[path[-1]] = value
    return data


X_VALUE = ("modelData", 0, "value")
TREE, CHAIN = ("faultTrees", 0), ("markovChains", 0)
STEP = (*CHAIN, "transitions", 0)

CASES = [
    (("schema",), "other", "schema: is 'other'; expected 'tracerisk-linked-model'", True),
    (("version",), 2, "version: is 2; this version of tracerisk reads 1", True),
    (("version",), True, "version: is True; this version of tracerisk reads 1", True),
    (("name",), REMOVED, "the document: 'name' is missing", True),
    (("trees",), [], "the document: unknown key 'trees'; did you mean 'faultTrees'?", True),
    (("modelData",), {}, "modelData: expected a list, found an object", True),
    (
        ("systemMissionTime",),
        -1.0,
        "mission time -1.0: give a finite number of hours above 0",
        True,
    ),
    (X_VALUE, "0.5", "modelData[0].value: expected an object, found the string '0.5'", True),
    (X_VALUE, None, "modelData[0].value: expected an object, found null", True),
    (X_VALUE, {}, "modelData[0].value: expected a number or an object with one key", True),
    (
        X_VALUE,
        {"addd": [1]},
        "modelData[0].value.addd: unknown value 'addd'; did you mean 'add'?",
        True,
    ),
    (X_VALUE, {"add": []}, "modelData[0].value: a sum needs at least one term", True),
    (X_VALUE, {"GLM": [1, 2]}, "modelData[0].value.GLM: GLM takes 4 values, found 2", True),
    (X_VALUE, {"pow": [1]}, "modelData[0].value: pow has 1 terms; allowed: 2", True),
    (X_VALUE, {"parameter": "y"}, "modelData[0]: parameter 'x': there is no parameter 'y'", False),
    (X_VALUE, {"systemMissionTime": False}, "is false; write true, or leave it out", True),
    (X_VALUE, {"systemMissionTime": True}, "parameter 'x': needs the mission time", False),
    (
        X_VALUE,
        {"absorption": {"markovChain": "c", "states": ["bad"]}},
        "elements depend on each other: parameter 'x' -> Markov chain 'c' -> fault tree 't' -> "
        "parameter 'x'",
        False,
    ),
    (("modelData", 0, "unit"), "m", "modelData[0].unit: is 'm'; ", True),
    (
        ("modelData", 0, "distribution"),
        {"lognormal": {"errorFactor": 0.5}},
        "modelData[0].distribution.lognormal: error factor 0.5",
        True,
    ),
    (
        ("modelData", 0, "distribution"),
        {"normal": {"mean": 1.0}},
        "modelData[0].distribution.normal: 'deviation' is missing",
        True,
    ),
    (
        ("modelData", 0, "distribution"),
        {"triangle": {}},
        "modelData[0].distribution: unknown distribution 'triangle'; allowed: beta, gamma, ",
        True,
    ),
    (
        (*TREE, "topEvent"),
        "tip",
        "faultTrees[0]: fault tree 't': top 'tip' is not a gate",
        False,
    ),
    (
        (*TREE, "gates", 0, "type"),
        "nor2",
        "faultTrees[0].gates[0].type: is 'nor2'; did you mean 'nor'?",
        True,
    ),
    (
        (*TREE, "gates", 0, "min"),
        2,
        "faultTrees[0].gates[0]: gate 'top': k is for atleast and cardinality only",
        True,
    ),
    (
        (*TREE, "gates", 0, "inputs"),
        ["a", "top"],
        "faultTrees[0]: fault tree 't': gate 'top' depends on itself;",
        False,
    ),
    (
        (*TREE, "events", 0, "type"),
        "spare",
        "faultTrees[0].events[0].type: is 'spare'; allowed: basic, house, transfer",
        True,
    ),
    ((*TREE, "events", 0, "type"), REMOVED, "faultTrees[0].events[0]: 'type' is missing", True),
    (
        (*TREE, "events", 1),
        {"name": "b", "type": "transfer", "faultTree": "u"},
        "faultTrees[0]: fault tree 't', transfer 'b': there is no fault tree 'u'; allowed: t",
        False,
    ),
    (
        (*TREE, "events", 1),
        {"name": "b", "type": "transfer", "faultTree": "t"},
        "faultTrees[0]: fault tree 't': transfers form a cycle ('t' -> 't'); break the cycle",
        False,
    ),
    (("faultTrees", 0, "name"), "", "fault tree '': a name needs printable characters", True),
    ((*CHAIN, "time"), "slow", "markovChains[0].time: is 'slow'; allowed: continuous, dis", True),
    (
        (*CHAIN, "initialState"),
        "x",
        "markovChains[0]: Markov chain 'c': entry 'x' is not a st",
        False,
    ),
    (
        (*STEP, "rate"),
        1.0,
        "markovChains[0].transitions[0]: unknown key 'rate'; allowed: probability, remainder",
        True,
    ),
    (
        (*STEP, "remainder"),
        "1",
        "markovChains[0].transitions[0]: states probability and remainder; give one",
        True,
    ),
    ((*STEP, "probability"), REMOVED, "markovChains[0].transitions[0]: states neither; give", True),
    (
        (*CHAIN, "transitions", 1, "remainder"),
        "0.5",
        "markovChains[0]: Markov chain 'c', state 's': the shares of its remainder sum to 1/2",
        False,
    ),
    (
        (*CHAIN, "transitions", 1, "remainder"),
        "all",
        "markovChains[0].transitions[1].remainder: is 'all'; expected a fraction",
        True,
    ),
    (
        (*CHAIN, "transitions", 1, "remainder"),
        "1/0",
        "markovChains[0].transitions[1].remainder: is '1/0', a division by zero",
        True,
    ),
    (
        (*CHAIN, "transitions", 1, "target"),
        "bad",
        "markovChains[0]: Markov chain 'c', transition 's' to 'bad': duplicate transition",
        False,
    ),
    (
        ("figures", 0, "value"),
        {"absorption": {"markovChain": "c", "states": ["worse"]}},
        "figures[0]: figure 'f': Markov chain 'c': 'worse' is not an absorbing state; allowed: bad, ",
        False,
    ),
    (
        ("figures", 0, "value"),
        {"occupancy": {"markovChain": "c", "states": ["bad"]}},
        "figures[0]: figure 'f': Markov chain 'c' is in discrete time; ask for its occupancy after a number",
        False,
    ),
]


@pytest.mark.parametrize(
    ("path", "value", "message", "by_schema"), CASES, ids=[case[2][:60] for case in CASES]
)
def test_bad_input_is_reported_with_its_path_and_place(validator, path, value, message, by_schema):
    data = changed(path, value)
    text = json.dumps(data, indent=1)
    with pytest.raises(ModelError) as raised:
        loads(text, "bad.json")
    assert message in raised.value.message
    assert raised.value.location is not None
    assert raised.value.location.file == "bad.json"
    assert raised.value.location.line is not None
    # What only the whole model tells, such as a name that nothing bears, no schema can.
    assert validator.is_valid(data) is not by_schema


def test_the_place_of_an_element_is_its_line_and_column():
    text = json.dumps(changed(X_VALUE, "half"), indent=1)
    with pytest.raises(ModelError) as raised:
        loads(text, "bad.json")
    place = raised.value.location
    line = text.splitlines()[place.line - 1]
    assert line[place.column - 1 :] == '"half"'


def test_a_small_model_is_solved():
    text = json.dumps(SMALL)
    assert loads(text, "small.json").solve().figures == {"f": 0.5}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (json.dumps(SMALL)[:200], "is not valid JSON: .*; is the file truncated?"),
        ("", "is not valid JSON: Expecting value; is the file truncated?"),
        ('{"a": 1, "a": 2}', "cannot be read: duplicate key 'a' in one object; remove one"),
        ('{"a": NaN}', "cannot be read: NaN is not allowed; give a finite number"),
        ("[" * 100_000, "cannot be read: a number or nesting too large"),
        ("[]", "the document: expected an object, found a list"),
        (
            json.dumps(SMALL).replace("0.5", "1e999"),
            r"modelData\[0\].value: is too large for double precision",
        ),
    ],
)
def test_text_that_is_no_document_is_refused(text, message):
    with pytest.raises(ModelError, match=message):
        loads(text, "bad.json")


def test_what_is_nested_too_deep_is_refused_both_ways():
    value = 0.5
    for _ in range(600):
        value = {"neg": value}
    with pytest.raises(ModelError, match=r"^bad.json: values are nested too deep; name parts"):
        loads(json.dumps(changed(X_VALUE, value)), "bad.json")
    deep = X
    for _ in range(3000):
        deep = Negation(deep)
    model = LinkedModel("m", (ModelParameter("x", Y),), (), (), (Figure("f", deep),))
    assert model.solve().figures == {"f": 0.25}
    with pytest.raises(ModelError, match="'m' has expressions nested too deep for JSON"):
        dumps(model)


def test_an_unreachable_end_is_reported_when_the_model_is_solved():
    data = changed((*CHAIN, "transitions", 1, "target"), "s")
    data["modelData"][0]["value"] = 0.0
    model = loads(json.dumps(data), "bad.json")
    with pytest.raises(
        ModelError, match="Markov chain 'c': no absorbing state can be reached from s"
    ):
        _ = model.solve().figures


def test_the_documented_model_is_valid_and_has_its_figure(validator, oracle_of_compressors):
    text = (Path(__file__).parents[4] / "docs" / "formats.md").read_text(encoding="utf-8")
    written = text.partition("## Linked models")[2].partition("```json\n")[2].partition("```")[0]
    validator.validate(json.loads(written))
    failure = loads(written, "docs/formats.md").solve().figures["failure"]
    drop = 1 - (1 - 7.344e-08) * (1 - oracle_of_compressors)
    assert failure == pytest.approx(drop / (1 - 0.9 * (1 - drop)), rel=1e-6)


@pytest.fixture(scope="module")
def oracle_of_compressors():
    """Both compressors down within eight hours: two sums of exponentials, on paper.

    With a = 2 lambda, b = lambda, c = mu: the roots r of r^2 + (a + b + c) r + a b, and
    1 - p = (r1 exp(r2 t) - r2 exp(r1 t)) / (r1 - r2).
    """
    a, b, c, t = Decimal("2e-05"), Decimal("1e-05"), Decimal("0.125"), Decimal(8)
    with localcontext() as context:
        context.prec = 50
        total = a + b + c
        root = (total * total - 4 * a * b).sqrt()
        r1, r2 = (-total + root) / 2, (-total - root) / 2
        return float(1 - (r1 * (r2 * t).exp() - r2 * (r1 * t).exp()) / (r1 - r2))
