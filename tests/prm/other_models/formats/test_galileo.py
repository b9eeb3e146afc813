"""Galileo text: both ways, its errors, and the same unreliability in Storm."""

import math
import random
import re
from pathlib import Path

import pytest

from tests.slow import slow_but_every
from tracerisk.errors import ModelError
from tracerisk.prm import BasicEvent, FaultTree, Gate, GateKind, build_model
from tracerisk.prm.other_models.dynamic import (
    Dependency,
    DynamicEvent,
    DynamicGate,
    DynamicKind,
    DynamicTree,
    Restriction,
    RestrictionKind,
)
from tracerisk.prm.other_models.formats import galileo
from tracerisk.prm.trees.events import HouseEvent
from tracerisk.prm.trees.failure_models import (
    GLM,
    Constant,
    Erlang,
    Exponential,
    Lognormal,
    PerDemand,
    PeriodicTest,
    Weibull,
)

DOCS = Path(__file__).parents[4] / "docs" / "formats.md"

TEXT = """\
/* A pump with a spare,
   and its power. */
toplevel "System";  // the whole of it
"System" or "Pumps" valves "voted" "F";
"Pumps" wsp "P1" "P2" "P3";
valves pand-excl "V1" "V2";
"voted" 2of3 "S1" "S2"
    "S3";
"F" fdep "Power" "P1" "P2";
"Half" pdep=0.5 "V1" "S1";
"Order" seq "S2" "S3";
"P1" lambda=1e-3 dorm=1.0; "P2" lambda=1e-3 dorm=0.5;
"P3" lambda = 2e-3 phases=2 dorm=0;
"V1" lambda=1e-4;
"V2" prob=0.25 repl=1;
"S1" lambda=.5e-3;
"S2" lambda=1e-3;
"S3" lambda=1e-3;
"Power" lambda=1e-5;
"Unused" rate=1e-4 shape=2;
"""


def test_text_is_read_with_all_its_kinds():
    found = galileo.loads(TEXT, "pumps.dft")
    assert found == DynamicTree(
        "System",
        (
            Gate("System", GateKind.OR, ("Pumps", "valves", "voted")),
            DynamicGate("Pumps", DynamicKind.SPARE, ("P1", "P2", "P3")),
            DynamicGate("valves", DynamicKind.PAND, ("V1", "V2"), inclusive=False),
            Gate("voted", GateKind.ATLEAST, ("S1", "S2", "S3"), 2),
        ),
        (
            DynamicEvent("P1", Exponential(1e-3)),
            DynamicEvent("P2", Exponential(1e-3), 0.5),
            DynamicEvent("P3", Erlang(2e-3, 2), 0.0),
            DynamicEvent("V1", Exponential(1e-4)),
            DynamicEvent("V2", Constant(0.25)),
            DynamicEvent("S1", Exponential(0.5e-3)),
            DynamicEvent("S2", Exponential(1e-3)),
            DynamicEvent("S3", Exponential(1e-3)),
            DynamicEvent("Power", Exponential(1e-5)),
        ),
        (
            Dependency("F", "Power", ("P1", "P2")),
            Dependency("Half", "V1", ("S1",), 0.5),
        ),
        (Restriction("Order", RestrictionKind.SEQUENCE, ("S2", "S3")),),
    )


def test_the_documented_text_is_read_and_solved():
    documented = re.findall(r"```text\n(toplevel.*?)```", DOCS.read_text(), re.DOTALL)
    assert len(documented) == 1
    found = galileo.loads(documented[0], "docs/formats.md")
    assert [event.name for event in found.static_tree().events] == ["V1", "V2", "V3", "Pumps"]
    assert 3e-4 < found.probability(10.0).p < 5e-4


def test_what_was_written_reads_back_the_same():
    text = galileo.dumps(galileo.loads(TEXT, "pumps.dft"))
    again = galileo.loads(text, "again.dft")
    assert galileo.dumps(again) == text
    assert again.probability(100.0) == galileo.loads(TEXT, "pumps.dft").probability(100.0)
    assert text.splitlines()[:3] == [
        'toplevel "System";',
        '"System" or "Pumps" "valves" "voted";',
        '"voted" 2of3 "S1" "S2" "S3";',
    ]
    assert '"Half" pdep=0.5 "V1" "S1";' in text
    assert '"P3" lambda=0.002 phases=2 dorm=0.0;' in text


def test_every_failure_law_is_written_and_read():
    models = [
        Constant(1e-20),
        Exponential(3e-7),
        Erlang(0.1, 3),
        GLM(0.0, 3e-7, 0.125),
        Weibull(30000.0, 1.7),
        Weibull(7e4 / 3, 0.5),
        Lognormal(9.0, 1.5),
    ]
    names = tuple(f"e{number}" for number in range(len(models)))
    made = DynamicTree(
        "top",
        (Gate("top", GateKind.OR, names),),
        tuple(DynamicEvent(name, model) for name, model in zip(names, models, strict=True)),
    )
    assert galileo.loads(galileo.dumps(made), "x") == made


@pytest.mark.parametrize(
    ("kind", "dorm", "expected"),
    [("csp", "", 0.0), ("wsp", "", 1.0), ("hsp", "", 1.0), ("spare", " dorm=0.3", 0.3)],
)
def test_the_kind_of_a_spare_gate_gives_its_dormancy(kind, dorm, expected):
    text = f"toplevel T; T {kind} A B; A lambda=1; B lambda=1{dorm};"
    assert [event.dormancy for event in galileo.loads(text, "x").events] == [1.0, expected]


def test_a_sequence_that_is_an_input_is_an_and():
    found = galileo.loads("toplevel T; T or S A; S seq B C; A prob=0; B lambda=1; C lambda=2;", "x")
    assert Gate("S", GateKind.AND, ("B", "C")) in found.gates
    assert found.restrictions == (Restriction("S-order", RestrictionKind.SEQUENCE, ("B", "C")),)


def test_a_static_tree_is_written_with_names_that_every_tool_reads():
    made = FaultTree(
        "place tube",
        (
            Gate("place tube", GateKind.OR, ("motor", "nothing", "guard", "on")),
            Gate("motor", GateKind.AND, ("motor[1]", "motor[2]")),
            Gate("nothing", GateKind.OR, ()),
            Gate("guard", GateKind.INHIBIT, ("motor_1", "demand")),
        ),
        (
            BasicEvent("motor[1]", "motor"),
            BasicEvent("motor[2]", "motor"),
            BasicEvent("motor_1", model=Exponential(1e-6)),
            BasicEvent("demand", model=PerDemand(0.1)),
        ),
        (HouseEvent("on", False),),
    )
    text = galileo.dumps(made, {"motor": 1e-9})
    assert text == (
        "// place_tube is place tube\n"
        "// motor_1_2 is motor[1]\n"
        "// motor_2 is motor[2]\n"
        'toplevel "place_tube";\n'
        '"place_tube" or "motor" "nothing" "guard" "on";\n'
        '"guard" and "motor_1" "demand";\n'
        '"motor" and "motor_1_2" "motor_2";\n'
        '"motor_1_2" prob=1e-09 dorm=1.0;\n'
        '"motor_2" prob=1e-09 dorm=1.0;\n'
        '"motor_1" lambda=1e-06 dorm=1.0;\n'
        '"demand" prob=0.1 dorm=1.0;\n'
        '"on" prob=0.0 dorm=1.0;\n'
        '"nothing" prob=0.0 dorm=1.0;\n'
    )
    values = {"motor": 1e-9} | made.values_at(100.0)
    found = galileo.loads(text, "x").probability(100.0)
    assert found.p == pytest.approx(made.probability(values).p, rel=1e-15)


def test_a_model_without_a_word_is_written_for_a_mission():
    tested = PeriodicTest(1e-6, 720)
    made = FaultTree("e", (), (BasicEvent("e", model=tested),))
    assert f'"e" prob={tested.probability(8760.0).p!r} dorm=1.0;' in galileo.dumps(
        made, mission_time_h=8760.0
    )
    with pytest.raises(ModelError, match="event 'e': Galileo cannot express PeriodicTest; give a"):
        galileo.dumps(made)


def test_the_published_case_keeps_its_figures(case_study):
    model = build_model(case_study, name="case study")
    for state in model.states:
        text = galileo.dumps(state.tree, state.probabilities)
        found = galileo.loads(text, state.name).probability(1.0)
        expected = state.tree.probability(state.probabilities)
        assert found.p == pytest.approx(expected.p, rel=1e-15)
        assert found.q == pytest.approx(expected.q, rel=1e-15)


@pytest.mark.parametrize(
    ("tree", "message"),
    [
        (
            FaultTree("g", (Gate("g", GateKind.NOT, ("e",)),), (BasicEvent("e"),)),
            "gate 'g': Galileo has no not; allowed: and, atleast, inhibit, or, pand",
        ),
        (
            FaultTree("e", (), (BasicEvent("e"),)),
            "event 'e': parameter 'e' has neither a value nor a model; allowed: none",
        ),
        (
            DynamicTree(
                "g",
                (DynamicGate("g", DynamicKind.SPARE, ("a", "b"), switch=0.1),),
                (DynamicEvent("a", Constant(0.1)), DynamicEvent("b", Constant(0.1))),
            ),
            "gate 'g': Galileo has no spares whose switch fails",
        ),
    ],
)
def test_what_galileo_cannot_hold_is_refused(tree, message):
    with pytest.raises(ModelError, match=re.escape(message)):
        galileo.dumps(tree)


EVENTS = '"A" lambda=1;\n"B" lambda=1;\n'


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('"T" or "A" "B";\n' + EVENTS, "f: no statement declares the top gate"),
        (
            'toplevel "T";\n"T" or "A" "B"',
            "f:2:1: the statement that begins with 'T' has no closing semi",
        ),
        ('toplevel "T', "f:1:10: unterminated name in quotes"),
        ("toplevel T; /* T or A B;", "f:1:13: unterminated comment"),
        ('toplevel "T" "A";', "f:1:1: toplevel needs exactly one name after it"),
        ('toplevel "T";\ntoplevel "A";', "f:2:1: duplicate toplevel, already 'T'"),
        ("param;", "f:1:1: param needs exactly one name after it"),
        (
            "param x;\nA lambda=x;",
            "f:2:10: parameter 'x' has no value; give one: `solve --set x=VALUE`",
        ),
        ("lambda=1;", "f:1:1: a statement must begin with a name"),
        ("A = = 1;", "f:1:1: 'A=' needs a value after it"),
        ("= 1;", "f:1:1: an equals sign needs a name before it"),
        ("A lambda=;", "f:1:3: 'lambda=' needs a value after it"),
        (
            '"A" lambda=1;\n "A" lambda=2;',
            "f:2:2: 'A' is defined twice, first at f:1:1",
        ),
        (
            'toplevel "T"; "T" xor "A";',
            "f:1:19: 'xor' is not a kind of gate; did you mean 'or'? allowed:",
        ),
        ('"T" 2of3 "A" "B";', "f:1:5: gate 'T' is 2of3 and has 2 inputs"),
        ('"T" or "A" dorm=1;', "f:1:12: gate 'T' takes no attributes"),
        ('"T" pdep=0.5 "A" "B" dorm=1;', "f:1:22: dependency 'T' takes no attributes"),
        ('"T" fdep "A";', "f:1:1: dependency 'T' needs a trigger and at least one dependent"),
        ('"T" pdep=2 "A" "B";', "f:1:1: dependency 'T': probability is 2.0; allowed: above 0"),
        ('"T" seq "A";', "f:1:1: restriction 'T': seq needs two inputs or more"),
        ('"T" wsp;', "f:1:1: gate 'T': spare needs at least one input"),
        (
            '"A" lamda=1;',
            "f:1:5: event 'A': attribute 'lamda' is not supported; did you mean 'lambda'?",
        ),
        (
            '"A" cov=0.5 lambda=1;',
            "f:1:5: event 'A': attribute 'cov' is not supported; allowed: dorm,",
        ),
        ('"A" lambda=1 lambda=2;', "f:1:14: event 'A': lambda is given twice"),
        ('"A" lambda=x;', "f:1:12: 'x' is not a number"),
        ('"A" lambda=-1;', "f:1:1: rate is -1.0 1/h; allowed: 0 or more"),
        (
            '"A" dorm=1;',
            "f:1:1: event 'A' has no failure law; allowed: prob; lambda; lambda and repair; ",
        ),
        ('"A" prob=1 lambda=1;', "f:1:1: event 'A' has lambda and prob; allowed: prob;"),
        ('"A" lambda=1 phases=1.5;', "f:1:21: event 'A': phases=1.5; allowed: whole numbers"),
        ('"A" rate=0 shape=1;', "f:1:10: event 'A': rate=0; allowed: above 0"),
        ('"A" lambda=1 repair=-1;', "f:1:1: repair_rate is -1.0 1/h; allowed: 0 or more"),
        ('"A" repair=1;', "f:1:1: event 'A' has repair; allowed: prob; lambda; lambda and repair"),
        ('"A" lambda=1 repl=2;', "f:1:19: event 'A': repl=2; allowed: 1"),
        ('toplevel "X";\n' + EVENTS, "f:1:10: top 'X' is not a gate or event; allowed: A, B"),
        (
            'toplevel "T";\n"T" or "C";\n' + EVENTS,
            "f:2:1: 'T' has the input 'C', which is not defined",
        ),
        ('toplevel "T";\n"T" or "G";\n"G" or "T";', "f:2:1: gate 'T' depends on itself"),
        ('toplevel "T";\n"T" vot3 "A" "B";\n' + EVENTS, "f:2:1: gate 'T': k is 3; allowed: 1 to 2"),
        (
            'toplevel T; T or F; F fdep "A" "B";\n' + EVENTS,
            "f:1:13: gate 'T' has only dep",
        ),
        (
            'toplevel T; T or M; M mutex "A" "B";\n' + EVENTS,
            "f:1:21: 'M' is mutex, which never happ",
        ),
        (
            "toplevel T; T and S U;\nS csp A B; U hsp C B; A lambda=1; C lambda=1;\nB lambda=1;",
            "f:3:1: event 'B' is a spare of csp gate 'S' and of hsp gate 'U', with the dormancies 0 and 1; give",
        ),
        (
            "toplevel T; T or A;\nA lambda=1 dorm=2;",
            "f:2:1: event 'A': dormancy is 2.0; allowed: 0",
        ),
    ],
)
def test_bad_text_is_refused_where_it_stands(text, message):
    with pytest.raises(ModelError) as caught:
        galileo.loads(text, "f")
    assert str(caught.value).startswith(message)


@pytest.mark.parametrize("seed", range(10))
def test_damaged_text_is_read_or_refused_with_its_place(seed):
    rng = random.Random(seed)
    for _ in range(50):
        text = TEXT
        for _ in range(rng.randint(1, 3)):
            place, length = rng.randrange(len(text)), rng.randint(0, 8)
            inserted = "".join(rng.choices('"; =/*aP1.e-\n', k=rng.randint(0, 3)))
            text = text[:place] + inserted + text[place + length :]
        refused = None
        try:
            found = galileo.loads(text, "damaged.dft")
        except ModelError as error:
            refused = error
        if refused is None:
            assert 0.0 <= found.probability(10.0).p <= 1.0
        else:
            assert refused.location is not None
            assert refused.location.line is not None or "which gate is the top" in refused.message


def storm_figures(path, tree, mission):
    """The least and the greatest unreliability that Storm finds; they differ where order is open.

    All elements are observed: of what makes no difference to the top any more Storm otherwise
    forgets that it still takes spares and puts them in service.
    """
    dft = pytest.importorskip("stormpy.dft", reason="stormpy is not installed")
    stormpy = pytest.importorskip("stormpy", reason="stormpy is not installed")
    loaded = dft.prepare_for_analysis(dft.load_dft_galileo_file(str(path)))
    names = [element.name for element in (*tree.gates, *tree.events)]
    figures = []
    for measure in ("Pmin", "Pmax"):
        properties = stormpy.parse_properties(f'{measure}=? [F<={mission} "failed"]')
        observed = dft.compute_relevant_events(properties, additional_relevant_names=names)
        figures += dft.analyze_dft(loaded, properties, relevant_events=observed)
    return figures


def drawn_tree(seed):
    """A random dynamic tree: two spare gates with a common pool, and gates over them and events."""
    rng = random.Random(seed)
    rates = (0.25, 0.5, 1.0, 2.0)
    free = [f"e{number}" for number in range(rng.randint(3, 4))]
    pool = [f"s{number}" for number in range(rng.randint(1, 2))]
    events = [DynamicEvent(name, Exponential(rng.choice(rates))) for name in (*free, "p0", "p1")]
    events += [
        DynamicEvent(name, Exponential(rng.choice(rates)), rng.choice((0.0, 0.5, 1.0)))
        for name in pool
    ]
    gates = [
        DynamicGate(f"spare{number}", DynamicKind.SPARE, (f"p{number}", *pool))
        for number in range(2)
    ]
    parts = [*free, "spare0", "spare1"]
    for number in range(rng.randint(2, 3)):
        inputs = tuple(rng.sample(parts, rng.randint(2, 3)))
        kind = rng.choice(("or", "and", "vote", "pand", "por"))
        name = f"g{number}"
        if kind == "vote":
            gates.append(Gate(name, GateKind.ATLEAST, inputs, 2))
        elif kind in ("or", "and"):
            gates.append(Gate(name, GateKind(kind), inputs))
        else:
            gates.append(DynamicGate(name, DynamicKind(kind), inputs))
        parts.append(name)
    below = {child for gate in gates for child in gate.inputs}
    open_parts = tuple(name for name in parts if name not in below)
    gates.append(Gate("top", rng.choice((GateKind.OR, GateKind.AND)), open_parts))
    dependencies, restrictions = [], []
    if rng.random() < 0.5:
        hit = rng.choice((free[0], "p0", pool[0]))
        trigger = rng.choice([name for name in free if name != hit])
        share = rng.choice((1.0, 0.25))
        dependencies.append(Dependency("dep", trigger, (hit,), share))
    if rng.random() < 0.3:
        restrictions.append(
            Restriction("tie", rng.choice(list(RestrictionKind)), (free[1], free[2]))
        )
    return DynamicTree("top", tuple(gates), tuple(events), tuple(dependencies), tuple(restrictions))


def drawn_spare(rng, name, gates, events, depth=0):
    """A spare that is an event, or a gate over spares of its own."""
    if depth > 1 or rng.random() < 0.5:
        events.append(DynamicEvent(name, Exponential(0.5), rng.choice((0.0, 0.5, 1.0))))
        return name
    parts = tuple(drawn_spare(rng, f"{name}_{i}", gates, events, depth + 1) for i in range(2))
    kind = rng.choice((GateKind.OR, GateKind.AND, DynamicKind.SPARE))
    gates.append(Gate(name, kind, parts) if kind in GateKind else DynamicGate(name, kind, parts))
    return name


def drawn_tree_of_parts(seed):
    """A random tree whose spares are gates, with dependencies between all that there is."""
    rng = random.Random(seed)
    gates, events = [], [DynamicEvent(name, Exponential(0.5)) for name in ("e0", "e1", "e2")]
    pool = [drawn_spare(rng, f"s{i}", gates, events) for i in range(rng.randint(1, 2))]
    parts = ["e0", "e1", "e2"]
    for number in range(rng.randint(1, 2)):
        first = drawn_spare(rng, f"p{number}", gates, events, 1)
        gates.append(DynamicGate(f"spare{number}", DynamicKind.SPARE, (first, *pool)))
        parts.append(f"spare{number}")
    for number in range(2):
        inputs = tuple(rng.sample(parts, 2))
        kind = rng.choice((GateKind.OR, GateKind.AND, DynamicKind.PAND, DynamicKind.POR))
        name = f"g{number}"
        gates.append(
            Gate(name, kind, inputs) if kind in GateKind else DynamicGate(name, kind, inputs)
        )
        parts.append(name)
    below = {child for gate in gates for child in gate.inputs}
    open_parts = tuple(name for name in parts if name not in below)
    gates.append(Gate("top", rng.choice((GateKind.OR, GateKind.AND)), open_parts))
    names = [event.name for event in events]
    dependencies = []
    for number in range(rng.randint(0, 2)):
        trigger = rng.choice([*names, *(gate.name for gate in gates[:-1])])
        hit = rng.choice([name for name in names if name != trigger])
        dependencies.append(Dependency(f"d{number}", trigger, (hit,), rng.choice((1.0, 0.25))))
    return DynamicTree("top", tuple(gates), tuple(events), tuple(dependencies))


@pytest.mark.parametrize("draw", [drawn_tree, drawn_tree_of_parts])
@pytest.mark.parametrize("seed", slow_but_every(3, range(30)))
def test_storm_finds_the_same_unreliability(tmp_path, draw, seed):
    made = draw(seed)
    path = tmp_path / "tree.dft"
    path.write_text(galileo.dumps(made))
    least, greatest = storm_figures(path, made, 1.0)
    found = galileo.loads(path.read_text(), "tree.dft").probability(1.0).p
    assert found == made.probability(1.0).p
    assert least * (1 - 1e-9) <= found <= greatest * (1 + 1e-9)
    if not made.dependencies:
        assert least == greatest


SPARE_IN_VAIN = """\
toplevel "top";
"top" and "e1" "e0" "g0";
"g0" por "e2" "sp0" "e0";
"sp0" wsp "p0" "s1" "s0";
"s0" or "s0_0" "s0_1";
"s0_1" and "a" "b";
"d0" fdep "s0_1" "e1";
"e0" lambda=2.0 dorm=1.0;
"e1" lambda=0.5 dorm=1.0;
"e2" lambda=1.0 dorm=1.0;
"s0_0" lambda=0.5 dorm=1.0;
"a" lambda=2.0 dorm=1.0;
"b" lambda=1.0 dorm=0.0;
"s1" lambda=0.5 dorm=0.5;
"p0" lambda=2.0 dorm=0.5;
"""


def test_a_spare_that_is_taken_in_vain_is_in_service_for_all_that_depends_on_it(tmp_path):
    """Once `e2` is first, `sp0` makes no difference; but `b` only fails when `s0` is in service."""
    path = tmp_path / "tree.dft"
    path.write_text(SPARE_IN_VAIN)
    made = galileo.loads(SPARE_IN_VAIN, "tree.dft")
    assert made.probability(1.0).p == pytest.approx(0.09843594103996683, rel=1e-12)
    assert storm_figures(path, made, 1.0) == pytest.approx([0.09843594103996683] * 2, rel=1e-9)


@pytest.mark.parametrize("phases", ["1000000000", "1e300"])
def test_phases_beyond_count_are_refused_at_once(phases):
    with pytest.raises(ModelError, match=r"t.dft:2:1: .*phases; allowed: 1 to 10000"):
        galileo.loads(f'toplevel "A";\n"A" lambda=0.1 phases={phases};', "t.dft")


def test_a_number_of_inputs_too_long_to_read_is_refused():
    with pytest.raises(ModelError, match=r"t.dft:2:5: cannot read a number of 5000 digits"):
        galileo.loads(f'toplevel "A";\n"A" {"9" * 5000}of1 "B";\n"B" prob=0.1;', "t.dft")


def test_the_dormancy_of_an_event_goes_before_that_of_the_kind_of_its_gate():
    text = "toplevel T; T and S U;\nS csp A B; U hsp C B; A lambda=1; C lambda=1; B lambda=1 {};"
    found = galileo.loads(text.format("dorm=0.5"), "x")
    assert {event.name: event.dormancy for event in found.events} == {"A": 1, "B": 0.5, "C": 1}


def test_repair_has_no_meaning_in_the_group_of_a_dynamic_gate():
    text = "toplevel T; T pand A B; A lambda=1 repair=2; B lambda=1;"
    tree = galileo.loads(text, "f")
    with pytest.raises(ModelError, match="event 'A': is repaired, which the group of a dynamic"):
        tree.probability(1.0)


def test_parameters_take_their_values_from_outside():
    text = 'param x;\nparam y;\ntoplevel T; T and A B; A lambda=x dorm=y; "B" prob=x;'
    assert galileo.parameter_names(text, "x") == ("x", "y")
    given = galileo.loads(text, "x", {"x": 0.25, "y": 1e-5})
    assert given == galileo.loads(
        "toplevel T; T and A B; A lambda=0.25 dorm=1e-5; B prob=0.25;", "x"
    )


def test_a_spare_that_another_gate_uses_from_the_start_is_in_service_from_the_start():
    text = """toplevel T; T or M S; M and A B; S wsp C B;
        A lambda=1 dorm=0; B lambda=1 dorm=0; C lambda=1 dorm=0;"""
    p = -math.expm1(-0.7)
    found = galileo.loads(text, "x").probability(0.7).p
    assert found == pytest.approx(p * (1 - (1 - p) ** 2), rel=1e-12)


def test_a_first_unit_may_be_an_input_of_a_gate_beside_its_spare_gate():
    text = """toplevel T; T or N A; N prob=0; A lambda=1 dorm=0; F fdep G N; G or P S;
        P pand C D; S wsp D E; C lambda=1 dorm=0; D lambda=2 dorm=0; E lambda=5 dorm=0;"""
    t = 0.7
    whole = math.exp(-t) * (math.exp(-3 * t) + math.exp(-2 * t) - math.exp(-5 * t))
    assert galileo.loads(text, "x").probability(t).p == pytest.approx(1 - whole, rel=1e-12)


@pytest.mark.parametrize("seed", range(20))
def test_a_shared_spare_equals_a_hot_one_with_an_echo(seed):
    rng = random.Random(seed)
    rates = {name: rng.choice((0.5, 1.0, 2.0)) for name in "ABCUVX"}
    spares = [rng.sample("UV", k=rng.randint(1, 2)) for _ in range(2)]
    top, gate = rng.choice(("and", "or", "2of3")), rng.choice(("and", "or", "por"))

    def text(used, dormancy, more):
        events = " ".join(
            f"{name} lambda={rate} dorm={dormancy if name == 'U' else 0.3};"
            for name, rate in rates.items()
        )
        units = [" ".join(each) for each in spares]
        return f"""toplevel T; T {top} R S M; R wsp A {units[0]}; S wsp B {units[1]} C;
            M {gate} {used} X; {events} {more}"""

    shared = galileo.loads(text("U", 0.1, ""), "x").probability(0.7).p
    echo = galileo.loads(text("E", 1.0, "E prob=0; F fdep U E;"), "x").probability(0.7).p
    assert shared == pytest.approx(echo, rel=1e-12)
