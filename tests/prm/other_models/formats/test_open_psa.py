"""Open-PSA XML out and back, and what is refused."""

import re
import subprocess
import time
import tracemalloc
from itertools import pairwise, product
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.prm.other_models.formats.models import gates, logic_models, names, ordered
from tracerisk.errors import ModelError
from tracerisk.prm.other_models.expressions import (
    MissionTime,
    Negation,
    Number,
    Reference,
    evaluate,
)
from tracerisk.prm.other_models.expressions.laws import Exponential
from tracerisk.prm.other_models.formats.open_psa import (
    loads_open_psa,
    read_open_psa,
)
from tracerisk.prm.other_models.formats.open_psa.rewriting import (
    accepted_form,
    gates_of,
    read_name,
    written_name,
)
from tracerisk.prm.other_models.formats.open_psa.writer import dumps_open_psa, write_open_psa
from tracerisk.prm.other_models.logic.model import (
    ALWAYS,
    NEVER,
    Container,
    EventDefinition,
    GateDefinition,
    LogicModel,
    Place,
)
from tracerisk.prm.trees.fault_tree import FaultTree
from tracerisk.prm.trees.gates import Gate, GateKind


@given(names)
def test_names_come_back(name):
    assert read_name(written_name(name)) == name


@pytest.mark.parametrize(
    ("name", "written"),
    [
        ("electric_motor[1]", "electric_motor__1"),
        ("supply[all]", "supply__all"),
        ("init fails", "init-_fails"),
        ("tank 2", "tank-_2"),
        ("a-b", "a-b"),
        ("a-_b", "a_x002D__x005F_b"),
        ("a__b", "a__x005F_b"),
        ("Robot.__init__", "Robot_x002E___init__"),
        ("[1]", "_x005B_1_x005D_"),
    ],
)
def test_names_are_written_as_readably_as_may_be(name, written):
    assert written_name(name) == written
    assert read_name(written) == name


def test_names_of_files_of_earlier_versions_are_read_as_they_were_written():
    text = """<opsa-mef><attributes><attribute name="tracerisk-names" value="escaped"/></attributes>
    <define-fault-tree name="T"><define-gate name="top-1__2"><or>
    <basic-event name="electric_motor_x005B_1_x005D_"/><basic-event name="a"/></or></define-gate>
    <define-basic-event name="electric_motor_x005B_1_x005D_"><float value="0.1"/></define-basic-event>
    <define-basic-event name="a"><float value="0.1"/></define-basic-event>
    </define-fault-tree></opsa-mef>"""
    (gate,) = loads_open_psa(text, "old.xml").gates
    assert gate.gate.name == "top-1__2"
    assert gate.gate.inputs == ("electric_motor[1]", "a")


@pytest.mark.parametrize(
    "name",
    [
        *(
            "_x0041_",
            "_x0041.",
            "__x0041_",
            "a_",
            "-",
            "--a--",
            "1",
            "_x",
            "a__1",
            "a___1",
            "a_[1]",
        ),
        *(
            "a[_1",
            "a[1]_",
            "a b",
            "a  b",
            " a",
            "a ",
            "a -b",
            "a[1][2]",
            "a__x0041_[b]",
            "x__",
            "__1",
        ),
    ],
)
def test_names_that_look_escaped_come_back(name):
    assert read_name(written_name(name)) == name
    assert "." not in written_name(name)


@settings(suppress_health_check=[HealthCheck.too_slow], max_examples=20, deadline=None)
@given(logic_models())
def test_a_model_comes_back_as_it_was(model):
    text = dumps_open_psa(model)
    again = loads_open_psa(text, "again.xml")
    assert ordered(again) == ordered(model)
    assert dumps_open_psa(again) == text


@settings(suppress_health_check=[HealthCheck.too_slow], max_examples=4, deadline=None)
@given(model=logic_models(figures=st.floats(0.0, 1.0).map(Number)))
def test_scram_accepts_what_is_written(model, scram, tmp_path_factory):
    path = tmp_path_factory.mktemp("written") / "model.xml"
    write_open_psa(model, path)
    done = subprocess.run(["scram", "--validate", path], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr + path.read_text()


@given(st.data())
def test_an_accepted_form_is_the_gate_itself(data):
    """All combinations of the events, through the rewritten gates and through the gate."""
    gate = data.draw(gates("g", ["a", "b", "c", ALWAYS, NEVER]))
    rewritten = {each.name: each for each in gates_of("g", accepted_form(gate))}

    def happens(given_gates, name, states):
        if name in (ALWAYS, NEVER):
            return name == ALWAYS
        if name not in given_gates:
            return states[name]
        each = given_gates[name]
        inputs = [happens(given_gates, below, states) for below in each.inputs]
        count = sum(inputs)
        return {
            GateKind.AND: all(inputs),
            GateKind.INHIBIT: all(inputs),
            GateKind.OR: any(inputs),
            GateKind.NAND: not all(inputs),
            GateKind.NOR: not any(inputs),
            GateKind.XOR: count % 2 == 1,
            GateKind.NOT: not any(inputs),
            GateKind.TRANSFER: any(inputs),
            GateKind.ATLEAST: count >= (each.k or 0),
            GateKind.CARDINALITY: (each.k or 0) <= count <= (each.most or 0),
            GateKind.IFF: len(inputs) == 2 and inputs[0] == inputs[-1],
            GateKind.IMPLY: len(inputs) == 2 and (not inputs[0] or inputs[-1]),
        }[each.kind]

    for states in product((False, True), repeat=3):
        named = dict(zip("abc", states, strict=True))
        assert happens(rewritten, "g", named) == happens({"g": gate}, "g", named)
    for each in rewritten.values():
        assert len(set(each.inputs)) == len(each.inputs)
        assert each.kind.value in {"and", "or", "not", "nand", "nor", "xor", "atleast", "transfer"}


def model(body, **files):
    return f'<opsa-mef><define-fault-tree name="T">{body}</define-fault-tree></opsa-mef>'


def gate(formula, name="top"):
    return f'<define-gate name="{name}">{formula}</define-gate>'


def event(name, figure='<float value="0.5"/>'):
    return f'<define-basic-event name="{name}">{figure}</define-basic-event>'


A, B = '<event name="a"/>', '<event name="b"/>'
EVENTS = event("a") + event("b")


@pytest.mark.parametrize(
    ("formula", "expected"),
    [
        ("<and>AB</and>", Gate("top", GateKind.AND, ("a", "b"))),
        ("<iff>AB</iff>", Gate("top", GateKind.IFF, ("a", "b"))),
        ("<imply>AB</imply>", Gate("top", GateKind.IMPLY, ("a", "b"))),
        ('<atleast min="1">AB</atleast>', Gate("top", GateKind.ATLEAST, ("a", "b"), 1)),
        (
            '<cardinality min="0" max="1">AB</cardinality>',
            Gate("top", GateKind.CARDINALITY, ("a", "b"), 0, 1),
        ),
        ("A", Gate("top", GateKind.TRANSFER, ("a",))),
        ('<constant value="true"/>', Gate("top", GateKind.TRANSFER, (ALWAYS,))),
        ('<or>A<constant value="0"/></or>', Gate("top", GateKind.OR, ("a", NEVER))),
        ("<or>A<not>B</not></or>", Gate("top", GateKind.OR, ("a", "top#1"))),
    ],
)
def test_every_formula_is_read(formula, expected):
    text = formula.replace("A", A).replace("B", B)
    read = loads_open_psa(model(gate(text) + EVENTS), "m.xml")
    assert read.gates[0].gate == expected
    assert loads_open_psa(dumps_open_psa(read), "again.xml") == read


def test_a_mark_that_no_longer_fits_gives_way_to_the_formula():
    read = loads_open_psa(model(gate(f"<imply>{A}{B}</imply>") + EVENTS), "m.xml")
    text = dumps_open_psa(read)
    assert 'value="imply a b"' in text
    edited = text.replace('<define-gate name="top">', '<define-gate name="top">', 1)
    edited = edited.replace("<or>", "<and>").replace("</or>", "</and>")
    found = loads_open_psa(edited, "edited.xml").gates_by_name
    assert found["top"] == Gate("top", GateKind.AND, ("top#1", "b"))


def test_private_names_are_those_of_their_home():
    text = """<opsa-mef>
    <define-fault-tree name="One">
      <define-gate name="top"><and><event name="a"/><event name="inner.a"/></and></define-gate>
      <define-basic-event name="a" role="private"><float value="0.5"/></define-basic-event>
      <define-component name="inner" role="private">
        <define-gate name="g"><or><event name="a"/><event name="b"/></or></define-gate>
        <define-basic-event name="a"><parameter name="p"/></define-basic-event>
        <define-parameter name="p"><float value="0.25"/></define-parameter>
      </define-component>
    </define-fault-tree>
    <model-data>
      <define-basic-event name="b"><float value="0.125"/></define-basic-event>
    </model-data>
    </opsa-mef>"""
    read = loads_open_psa(text, "m.xml")
    assert read.gates_by_name["top"].inputs == ("One.a", "One.inner.a")
    assert read.gates_by_name["One.inner.g"].inputs == ("One.inner.a", "b")
    assert read.events[1].expression == Reference("One.inner.p")
    assert loads_open_psa(dumps_open_psa(read), "again.xml") == read


def test_labels_attributes_and_units_are_kept():
    text = model(
        "<label>pumps &amp; valves</label>"
        '<attributes><attribute name="source" value="x" type="text"/></attributes>'
        + gate("<label>the top</label>" + A)
        + event(
            "a",
            '<label>a pump</label><exponential><parameter name="rate"/>'
            "<system-mission-time/></exponential>",
        )
        + '<define-parameter name="rate" unit="hours-1"><float value="1e-6"/></define-parameter>'
    )
    read = loads_open_psa(text, "m.xml")
    assert read.containers[0].label == "pumps & valves"
    assert read.gates[0].place.label == "the top"
    assert read.events[0].expression == Exponential(Reference("rate"), MissionTime())
    assert read.parameters[0].unit == "hours-1"
    assert (
        evaluate(read.events[0].expression, read.definitions.by_name, 1e3) == 0.0009995001666250084
    )
    assert loads_open_psa(dumps_open_psa(read), "again.xml") == read


def test_a_duplicate_argument_is_accepted_and_reported():
    read = loads_open_psa(model(gate(f"<and>{A}{A}</and>") + event("a")), "m.xml")
    tree = read.fault_tree("top")
    assert tree.probability({"a": 0.5}).p == 0.5
    assert read.findings == ("m.xml:1:63: gate 'top' has duplicate inputs: a",)


def test_a_tree_may_transfer_to_another():
    text = (
        '<opsa-mef><define-fault-tree name="One">'
        + gate(f'<or>{A}<gate name="two"/></or>', "one")
        + '</define-fault-tree><define-fault-tree name="Two">'
        + gate(f"<and>{A}{B}</and>", "two")
        + f"</define-fault-tree><model-data>{EVENTS}</model-data></opsa-mef>"
    )
    read = loads_open_psa(text, "m.xml")
    assert read.tops == ("one", "two")
    tree = read.fault_tree("one")
    assert {each.name for each in tree.gates} == {"one", "two"}
    assert tree.probability(tree.values_at(1.0)).p == 0.5


TOP = gate(f"<or>{A}{B}</or>")
BAD = [
    ("", "m.xml:1:1: is empty; expected an XML file"),
    ("plain text", "m.xml:1:1: is not well-formed XML: syntax error; is the file truncated?"),
    (
        model(TOP)[:60],
        "m.xml:1:39: is not well-formed XML: unclosed token; is the file truncated?",
    ),
    (
        model(TOP + EVENTS).replace("</define-fault-tree></opsa-mef>", ""),
        "is not well-formed XML: no element found; is the file truncated?",
    ),
    ("<scram/>", "m.xml:1:1: <scram> is not an Open-PSA model; the root must be <opsa-mef>"),
    (
        "<opsa-mef><define-gate/></opsa-mef>",
        "m.xml:1:11: <define-gate> does not belong in <opsa-mef>; did you mean 'define-rule'?",
    ),
    (
        '<opsa-mef version="3"/>',
        "m.xml:1:1: <opsa-mef> has the unknown attribute 'version'; allowed: name",
    ),
    (
        '<!DOCTYPE opsa-mef [<!ENTITY a "b">]><opsa-mef/>',
        "declares an entity; write out what it stands for",
    ),
    (
        '<!DOCTYPE opsa-mef SYSTEM "http://example.com/mef.dtd"><opsa-mef name="x">&a;</opsa-mef>',
        "refers to the entity 'a'; write out what it stands for",
    ),
    (
        '<!DOCTYPE opsa-mef [<!ENTITY % a SYSTEM "file:///etc/passwd"> %a;]><opsa-mef/>',
        "declares an entity; write out what it stands for",
    ),
    ("<a>" * 300, "m.xml:1:604: elements nest more than 200 deep; flatten the model"),
    (model(gate("<or/>")), "m.xml:1:63: <or> has no arguments; give it at least one"),
    (model(gate(A + B)), "gate 'top' has 2 formulas; give it exactly one"),
    (model(gate("<maybe/>")), "<maybe> does not belong here; allowed: and, atleast, "),
    (
        model(gate(f'<atleast min="3">{A}{B}</atleast>') + EVENTS),
        "m.xml:1:63: gate 'top': k is 3; allowed: 1 to 2",
    ),
    (
        model(gate(f'<atleast min="two">{A}{B}</atleast>')),
        "m.xml:1:63: <atleast> has the min 'two'; give a whole number",
    ),
    (model(gate(f"<atleast>{A}{B}</atleast>")), "<atleast> has no min; give it one"),
    (
        model(gate(f"<iff>{A}</iff>") + EVENTS),
        "m.xml:1:63: gate 'top': iff needs 2 inputs, it has 1",
    ),
    (
        model(TOP + event("a")),
        "m.xml:1:84: gate or event 'b' is not defined; allowed: a, top",
    ),
    (
        model(gate('<or><gate name="a"/></or>') + EVENTS),
        "m.xml:1:67: 'a' is a basic event, not a gate; refer to it as a basic event",
    ),
    (
        model(gate('<or><event name="a" type="pump"/></or>') + EVENTS),
        "<event> has the type 'pump'; allowed: basic-event, gate, house-event",
    ),
    (
        model(TOP + EVENTS + event("a")),
        "'a' is defined twice, first at m.xml:1:120; rename or remove one",
    ),
    (
        model(gate('<gate name="g"/>') + gate('<gate name="top"/>', "g")),
        "m.xml:1:39: gate 'top' depends on itself (top -> g -> top); break the cycle",
    ),
    (
        model(event("a", '<float value="1.5"/>')),
        "m.xml:1:68: basic event 'a': probability 1.5 is outside [0, 1]; give a number within",
    ),
    (
        model(event("a", '<float value="much"/>')),
        "m.xml:1:68: <float> has the value 'much'; give a finite number",
    ),
    (
        model(event("a", '<float value="nan"/>')),
        "m.xml:1:68: <float> has the value 'nan'; give a finite number",
    ),
    (model(event("a", "<float/>")), "m.xml:1:68: <float> has no value; give it one"),
    (
        model(event("a", '<int value="0.5"/>')),
        "m.xml:1:68: <int> has the value '0.5'; give a whole number",
    ),
    (
        model(event("a", '<bool value="maybe"/>')),
        "m.xml:1:68: <bool> has the value 'maybe'; allowed: false, true",
    ),
    (
        model(event("a", '<exponential><float value="1"/></exponential>')),
        "m.xml:1:68: <exponential> has 1 arguments; allowed: 2",
    ),
    (
        model(event("a", "<pow/>")),
        "m.xml:1:68: pow has 0 terms; allowed: 2",
    ),
    (
        model(event("a", '<extern-function name="f"/>')),
        "m.xml:1:68: <extern-function> does not belong here; allowed: GLM, ",
    ),
    (
        model(event("a", '<system-mission-time unit="years"/>')),
        "<system-mission-time> has the unit 'years'; allowed: hours",
    ),
    (
        model(event("a", '<parameter name="p"/>')),
        "m.xml:1:68: parameter 'p' is not defined; allowed: none",
    ),
    (
        model(
            '<define-parameter name="p"><parameter name="q"/></define-parameter>'
            '<define-parameter name="q"><parameter name="p"/></define-parameter>'
        ),
        "m.xml:1:39: parameter 'p' depends on itself (p -> q -> p); break the cycle",
    ),
    (
        model('<define-parameter name="p" unit="furlongs"><float value="1"/></define-parameter>'),
        "parameter 'p' has the unit 'furlongs'; allowed: ",
    ),
    (
        model('<define-basic-event name="a.b"/>'),
        "m.xml:1:39: the name 'a.b' contains a point, which separates the names of a path; rename it",
    ),
    (
        model('<define-basic-event name="a" role="secret"/>'),
        "m.xml:1:39: <define-basic-event> has the role 'secret'; allowed: private, public",
    ),
    (
        '<opsa-mef><model-data><define-basic-event name="a" role="private"/></model-data></opsa-mef>',
        "<define-basic-event> is private outside any fault tree; make it public, or move it",
    ),
    (
        model('<define-basic-event name="a" probability="0.5"/>'),
        "<define-basic-event> has the unknown attribute 'probability'; allowed: name, role",
    ),
    (model("<define-basic-event/>"), "m.xml:1:39: <define-basic-event> has no name; give it one"),
    (
        model('<define-house-event name="h"><float value="1"/></define-house-event>'),
        "<float> does not belong here; allowed: constant",
    ),
    (
        '<opsa-mef><define-fault-tree name="T"/><define-fault-tree name="T"/></opsa-mef>',
        "m.xml:1:40: 'T' is defined twice, first at m.xml:1:11; rename one",
    ),
]


@pytest.mark.parametrize(
    "text",
    [
        "<open-psa>{}</open-psa>",
        '<opsa-mef xmlns="http://open-psa.org/mef">{}</opsa-mef>',
        '<open-psa xmlns="http://open-psa.org/mef" name="">{}</open-psa>',
    ],
)
def test_the_root_may_have_another_name_and_a_namespace(text):
    body = model(TOP + EVENTS).removeprefix("<opsa-mef>").removesuffix("</opsa-mef>")
    assert loads_open_psa(text.format(body), "m.xml") == loads_open_psa(
        model(TOP + EVENTS), "m.xml"
    )


def test_a_namespace_may_have_a_prefix():
    text = re.sub(r"<(/?)(?=[a-z])", r"<\1mef:", model(TOP + EVENTS))
    text = text.replace("<mef:opsa-mef", '<mef:opsa-mef xmlns:mef="http://open-psa.org/mef"', 1)
    assert loads_open_psa(text, "m.xml") == loads_open_psa(model(TOP + EVENTS), "m.xml")
    with pytest.raises(ModelError, match="<scram> is not an Open-PSA model"):
        loads_open_psa("<m:scram xmlns:m='x'/>", "m.xml")


GROUP = """<opsa-mef><define-CCF-group name="G" model="{model}">
<members>{members}</members>
{distribution}
{factors}
</define-CCF-group></opsa-mef>"""
PARTS = {
    "model": "beta-factor",
    "members": '<basic-event name="a"/><basic-event name="b"/>',
    "distribution": '<distribution><float value="0.1"/></distribution>',
    "factors": '<factor level="2"><float value="0.2"/></factor>',
}
BAD += [
    (GROUP.format(**PARTS | part), message)
    for part, message in (
        (
            {"model": "gamma-factor"},
            "m.xml:1:11: the common cause model 'gamma-factor' is unknown; did you mean",
        ),
        ({"distribution": ""}, "common cause group 'G' has no <distribution>; give it one"),
        ({"factors": ""}, "common cause group 'G' has no <factor>; give it one"),
        (
            {"factors": '<factor level="3"><float value="1"/></factor>'},
            "m.xml:4:1: the level 3 of beta-factor; allowed: 2 to 2",
        ),
        (
            {"model": "MGL", "factors": PARTS["factors"] * 2},
            "m.xml:4:48: duplicate level 2; give each level once",
        ),
        ({"members": '<gate name="a"/>'}, "m.xml:2:10: <gate> does not belong here"),
        (
            {"members": '<basic-event name="a"/><basic-event name="a"/>'},
            "m.xml:2:33: 'a' is a member of common cause group 'G' already; remove it from one",
        ),
    )
]
TREE = """<opsa-mef><define-initiating-event name="I" event-tree="{tree}"/>
<define-event-tree name="E"><define-functional-event name="F"/><define-sequence name="S"/>
<initial-state><fork functional-event="F"><path state="x">{path}</path></fork></initial-state>
</define-event-tree></opsa-mef>"""
BAD += [
    (TREE.format(**{"tree": "E", "path": '<sequence name="S"/>'} | part), message)
    for part, message in (
        ({"tree": "D"}, "m.xml:1:11: event tree 'D' is not defined; allowed: E"),
        (
            {"path": '<sequence name="R"/>'},
            "m.xml:2:1: event tree 'E': a path ends in 'R', which is not a sequence; allowed: S",
        ),
        (
            {"path": ""},
            "m.xml:3:43: <path> leads nowhere; end it with a <fork>, <sequence> or <branch>",
        ),
        (
            {"path": '<collect-formula><gate name="g"/></collect-formula><sequence name="S"/>'},
            "m.xml:3:76: gate 'g' is not defined; allowed: none",
        ),
        (
            {"path": '<rule name="r"/><sequence name="S"/>'},
            "m.xml:3:59: rule 'r' is not defined; allowed: none",
        ),
        (
            {"path": '<event-tree name="r"/><sequence name="S"/>'},
            "a link to an event tree is allowed in a <define-sequence> only",
        ),
        (
            {
                "path": '<collect-expression><float value="2"/></collect-expression>'
                '<sequence name="S"/>'
            },
            "m.xml:3:79: probability 2.0 is outside [0, 1]",
        ),
    )
]


@pytest.mark.parametrize(("text", "message"), BAD, ids=[message[:60] for _, message in BAD])
def test_what_is_wrong_is_reported_where_it_stands(text, message):
    with pytest.raises(ModelError) as caught:
        loads_open_psa(text, "m.xml")
    assert message in str(caught.value)
    assert caught.value.location is not None
    assert caught.value.location.line is not None


def test_a_figure_that_cannot_be_evaluated_is_reported_where_it_stands():
    figure = '<sub><float value="0"/><system-mission-time/></sub>'
    read = loads_open_psa(model(gate(A) + "\n" + event("a", figure)), "m.xml")
    with pytest.raises(ModelError) as caught:
        read.fault_tree("top").values_at(2.0)
    assert (
        str(caught.value)
        == "m.xml:2:1: event 'a': probability -2.0 is outside [0, 1]; give a number within"
    )


def test_an_event_without_a_figure_is_reported():
    read = loads_open_psa(model(gate(A) + '<define-basic-event name="a"/>'), "m.xml")
    tree = read.fault_tree("top")
    with pytest.raises(ModelError, match="event 'a': parameter 'a' has no value"):
        tree.probability(tree.values_at(1.0))


def test_an_unknown_top_is_reported():
    read = loads_open_psa(model(TOP + EVENTS), "m.xml")
    with pytest.raises(ModelError, match="there is no top 'tap'; did you mean 'top'\\?"):
        read.fault_tree("tap")


def test_bytes_that_are_not_utf_8_are_reported():
    text = model(event("a")).replace("<opsa-mef>", "<opsa-mef><!-- \xe9 -->").encode("latin-1")
    with pytest.raises(ModelError) as caught:
        loads_open_psa(text, "m.xml")
    assert str(caught.value) == (
        "m.xml:1:16: the byte 0xE9 is not valid here; save the file as UTF-8, or state its "
        "encoding in the XML declaration"
    )
    declared = b'<?xml version="1.0" encoding="ISO-8859-1"?>' + text
    assert loads_open_psa(declared, "m.xml").events[0].name == "a"


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_an_entity_bomb_is_refused_at_once(encoding, tmp_path):
    levels = "".join(
        f'<!ENTITY e{level} "{f"&e{level - 1};" * 10}">' if level else '<!ENTITY e0 "haha">'
        for level in range(30)
    )
    path = tmp_path / "bomb.xml"
    path.write_bytes(f'<!DOCTYPE b [{levels}]><b name="&e29;">&e29;</b>'.encode(encoding))
    tracemalloc.start()
    started = time.process_time()
    try:
        with pytest.raises(ModelError, match="declares an entity"):
            read_open_psa(path)
        assert tracemalloc.get_traced_memory()[1] < 2_000_000
    finally:
        tracemalloc.stop()
    assert time.process_time() - started < 2.0


def test_a_folder_and_a_missing_file_are_reported(tmp_path):
    with pytest.raises(ModelError, match="cannot be read: Is a directory"):
        read_open_psa(tmp_path)
    with pytest.raises(ModelError, match="cannot be read: No such file or directory"):
        read_open_psa(tmp_path / "none.xml")
    with pytest.raises(ModelError, match="cannot be written: Is a directory"):
        write_open_psa(LogicModel(), tmp_path)


def test_a_doctype_without_entities_is_fine():
    text = '<!DOCTYPE opsa-mef SYSTEM "mef.dtd">' + model(TOP + EVENTS)
    assert loads_open_psa(text, "m.xml").tops == ("top",)


def test_a_chain_of_gates_of_any_length_is_read():
    count = 5_000
    body = "".join(gate(f'<gate name="g{i + 1}"/>', f"g{i}") for i in range(count))
    read = loads_open_psa(model(body + gate(A, f"g{count}") + event("a")), "m.xml")
    assert read.tops == ("g0",)
    assert read.fault_tree("g0").probability({"a": 0.25}).p == 0.25


def test_formulas_that_nest_deep_are_written_as_gates():
    names_ = ["top", *(f"top#{i}" for i in range(1, 400)), "a"]
    gates_ = tuple(
        GateDefinition(Gate(name, GateKind.NOT, (below,)), Place("T"), nested=name != "top")
        for name, below in pairwise(names_)
    )
    events = (EventDefinition("a", Number(0.5), Place("T")),)
    deep = LogicModel(gates=gates_, events=events, containers=(Container("T"),))
    text = dumps_open_psa(deep)
    assert loads_open_psa(text, "again.xml") == deep
    assert max(len(line) - len(line.lstrip()) for line in text.splitlines()) < 200


def test_an_xor_of_many_is_written_without_depth():
    names_ = [f"e{i}" for i in range(2000)]
    events = tuple(EventDefinition(name, Number(0.5), Place("T")) for name in names_)
    gates_ = (GateDefinition(Gate("top", GateKind.XOR, tuple(names_)), Place("T")),)
    wide = LogicModel(gates=gates_, events=events, containers=(Container("T"),))
    assert loads_open_psa(dumps_open_psa(wide), "again.xml") == wide


def test_an_expression_that_nests_too_deep_to_write_is_reported():
    figure = Number(0.5)
    for _ in range(150):
        figure = Negation(figure)
    deep = LogicModel(events=(EventDefinition("a", figure),))
    with pytest.raises(ModelError, match="an expression nests more than 100 deep"):
        dumps_open_psa(deep)


def test_an_expression_without_a_word_in_open_psa_is_reported():
    class Own(Number):
        pass

    class Odd(Negation):
        pass

    odd = LogicModel(events=(EventDefinition("a", Odd(Own(0.5))),))
    with pytest.raises(ModelError, match="Open-PSA cannot express Odd;"):
        dumps_open_psa(odd)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"containers": (Container("#"),)},
            "the fault tree '#' has the name reserved for gates outside fault trees; rename it",
        ),
        (
            {"events": (EventDefinition("a", None, Place("U")),)},
            "the fault tree 'U' is not among the containers; add it to them",
        ),
        (
            {
                "events": (EventDefinition("a", None, Place("U", private=True)),),
                "containers": (Container("U"),),
            },
            "'a' is private in 'U', but its name does not begin with that; name it 'U.a'",
        ),
    ],
)
def test_what_open_psa_cannot_hold_is_reported(changes, message):
    with pytest.raises(ModelError) as caught:
        dumps_open_psa(LogicModel(**changes))
    assert caught.value.message == message


def test_a_file_may_hold_what_another_defines(tmp_path):
    (tmp_path / "gates.xml").write_text(model(TOP))
    figures = f"<opsa-mef name='M'><model-data>{EVENTS}</model-data></opsa-mef>"
    (tmp_path / "figures.xml").write_text(figures)
    read = read_open_psa(tmp_path / "gates.xml", tmp_path / "figures.xml")
    assert read.name == "M"
    assert read.fault_tree("top").events[0].name == "a"


def test_writing_is_the_same_each_time(tmp_path: Path):
    read = loads_open_psa(model(TOP + EVENTS), "m.xml")
    first, second = tmp_path / "a.xml", tmp_path / "b.xml"
    write_open_psa(read, first)
    write_open_psa(read, second)
    assert first.read_bytes() == second.read_bytes()


def test_a_fault_tree_of_python_goes_out_with_its_values():
    tree = FaultTree.of("top", {"top": ("or", "valve", "pumps"), "pumps": ("and", "p1", "p2")})
    values = {"valve": 1e-6, "p1": 1e-3, "p2": 2e-3}
    again = loads_open_psa(dumps_open_psa(tree, values), "tree.xml").fault_tree("top")
    assert again.probability(again.values_at(0.0)).p == tree.probability(values).p
    with pytest.raises(ModelError, match="'valv' is not a parameter;"):
        dumps_open_psa(tree, {"valv": 1e-6})


WHOLE = '<opsa-mef xmlns:xi="http://www.w3.org/2001/XInclude">{}</opsa-mef>'
INCLUDE = '<xi:include href="{}" xpointer="xpointer(/opsa-mef/*)"/>'


def test_files_that_a_file_includes_are_read_with_it(tmp_path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "m.xml").write_text(WHOLE.format(INCLUDE.format("parts/tree.xml")))
    (tmp_path / "parts/tree.xml").write_text(
        WHOLE.format(
            INCLUDE.format("../data.xml") + '<define-fault-tree name="T"><define-gate name="top">'
            '<or><event name=" a " type=" basic-event "/><event name="b"/></or>'
            "</define-gate></define-fault-tree>"
        )
    )
    figure = '<define-basic-event name="{}"><float value="0.5"/></define-basic-event>'
    data = "<model-data>" + figure.format("a") + figure.format("b") + "</model-data>"
    (tmp_path / "data.xml").write_text(
        '<opsa-mef xmlns:x="urn:x" x:made="today">' + data + "</opsa-mef>"
    )
    tree = read_open_psa(tmp_path / "m.xml").fault_tree("top")
    assert tree.probability(tree.values_at(0.0)).p == 0.75


@pytest.mark.parametrize(
    ("href", "more", "message"),
    [
        ("m.xml", "", "m.xml' includes itself; break the cycle"),
        ("none.xml", "", "none.xml: cannot be read"),
        ("n.xml", 'parse="text"', "has the unknown attribute 'parse';"),
    ],
)
def test_what_cannot_be_included_is_reported(href, more, message, tmp_path):
    included = INCLUDE.format(href).replace("/>", f" {more}/>")
    (tmp_path / "m.xml").write_text(WHOLE.format(included))
    with pytest.raises(ModelError, match=re.escape(message)):
        read_open_psa(tmp_path / "m.xml")


def test_a_text_without_a_folder_includes_nothing():
    with pytest.raises(ModelError, match="text has no folder to"):
        loads_open_psa(WHOLE.format(INCLUDE.format("other.xml")), "m.xml")
