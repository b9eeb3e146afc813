"""`solve`, `cut-sets` and `convert` on model files of other tools."""

import json
import math
import os
from pathlib import Path
from types import SimpleNamespace

import pytest

from tracerisk.cli import main
from tracerisk.cli.shared.model_format import ModelFormat, detected

XML = """\
<?xml version="1.0"?>
<opsa-mef>
  <define-fault-tree name="cooling">
    <define-gate name="none">
      <or>
        <gate name="both"/>
        <basic-event name="valve"/>
      </or>
    </define-gate>
    <define-gate name="both">
      <and>
        <basic-event name="a"/>
        <basic-event name="b"/>
      </and>
    </define-gate>
  </define-fault-tree>
  <model-data>
    <define-basic-event name="a"><parameter name="pump"/></define-basic-event>
    <define-basic-event name="b"><parameter name="pump"/></define-basic-event>
    <define-basic-event name="valve"><float value="0.001"/></define-basic-event>
    <define-parameter name="pump">PUMP</define-parameter>
  </model-data>
</opsa-mef>
"""
NUMBER = '<float value="0.1"/>'
RATE = '<exponential><float value="0.01"/><system-mission-time/></exponential>'
DEVIATE = """<lognormal-deviate>
  <float value="0.1"/><float value="3"/><float value="0.9"/>
</lognormal-deviate>"""
EVENT_TREE = """\
<opsa-mef>
  <define-initiating-event name="leak" event-tree="T"/>
  <define-event-tree name="T">
    <define-functional-event name="stop"/>
    <define-sequence name="calm"/>
    <define-sequence name="fire"/>
    <initial-state>
      <fork functional-event="stop">
        <path state="works">
          <collect-formula><not><basic-event name="valve"/></not></collect-formula>
          <sequence name="calm"/>
        </path>
        <path state="fails">
          <collect-formula><basic-event name="valve"/></collect-formula>
          <sequence name="fire"/>
        </path>
      </fork>
    </initial-state>
  </define-event-tree>
  <model-data>
    <define-basic-event name="valve"><float value="0.001"/></define-basic-event>
  </model-data>
</opsa-mef>
"""
DFT = """\
// two pumps, of which one waits
toplevel "top";
"top" or "pumps" "valve";
"pumps" csp "a" "b";
"a" lambda=0.01;
"b" lambda=0.01;
"valve" prob=0.001;
"""
PRISM = """\
dtmc
const double p = 0.1;
module m
  s : [0..2] init 0;
  [] s=0 -> p : (s'=1) + 0.5*(1-p) : (s'=2) + 0.5*(1-p) : (s'=0);
endmodule
label "failed" = s=1;
label "done" = s=2;
"""
TRA = "ctmc\n0 1 0.1\n1 0 2\n1 2 0.01\n"
LAB = "#DECLARATION\ninit failed\n#END\n0 init\n2 failed\n"
FUNCTIONS = {
    "schema": "tracerisk-hybrid-model",
    "version": 1,
    "name": "cell",
    "entry": "pick",
    "latent": [],
    "parameters": [{"name": "gripper", "theta": 0.01}],
    "states": [
        {
            "name": "pick",
            "call_sequence": 1,
            "fault_tree": {
                "top": "fails",
                "gates": [{"name": "fails", "type": "or", "inputs": ["left", "right"]}],
                "basic_events": [
                    {"name": "left", "parameter": "gripper"},
                    {"name": "right", "parameter": "gripper"},
                ],
            },
            "probabilities": {"gripper": 0.01},
            "next": [{"target": "pick", "weight": "1/2"}, {"target": "done", "weight": "1/2"}],
        }
    ],
}


def xml(pump=NUMBER):
    return XML.replace("PUMP", pump)


@pytest.fixture
def call(tmp_path, monkeypatch, capsysbinary):
    """Run the command in a folder with a file of each format."""
    monkeypatch.chdir(tmp_path)
    texts = {
        "cooling.xml": xml(),
        "rate.xml": xml(RATE),
        "deviate.xml": xml(DEVIATE),
        "tree.xml": EVENT_TREE,
        "pumps.dft": DFT,
        "chain.prism": PRISM,
        "repair.tra": TRA,
        "repair.lab": LAB,
        "cell.json": json.dumps(FUNCTIONS),
    }
    for name, text in texts.items():
        Path(name).write_text(text)

    def run(*arguments):
        code = main(arguments)
        out, err = capsysbinary.readouterr()
        return SimpleNamespace(code=code, out=out.decode(), err=err.decode())

    return run


def solved(call, *arguments):
    outcome = call("solve", *arguments, "--json")
    assert outcome.code == 0, outcome.out
    return json.loads(outcome.out)


def cells(text):
    return [line.split() for line in text.splitlines()]


def top_of(call, *arguments):
    (top,) = solved(call, *arguments)["tops"]
    return top["probability"]


# Formats are told by what files hold.


@pytest.mark.parametrize(
    ("text", "name", "found"),
    [
        (XML, "x.txt", ModelFormat.OPEN_PSA),
        ("\ufeff\n<!-- a --><opsa-mef/>", "x", ModelFormat.OPEN_PSA),
        (DFT, "x.txt", ModelFormat.GALILEO),
        ('"a" prob=0.1;\ntoplevel "a";', "x.txt", ModelFormat.GALILEO),
        ('"t" 2of3 "a" "b" "c";\ntoplevel "t";', "x.txt", ModelFormat.GALILEO),
        ('"A docstring" or "none"[0]\n', "x.py", None),
        (PRISM, "x.txt", ModelFormat.PRISM),
        ("// a\n/* dtmc */ ctmc\n\nmodule m", "x", ModelFormat.PRISM),
        (TRA, "x.txt", ModelFormat.EXPLICIT),
        ("3 2\n0 1 0.5\n0 2 0.5\n", "x", ModelFormat.EXPLICIT),
        (json.dumps(FUNCTIONS), "x", ModelFormat.HYBRID),
        ('{"schema": "tracerisk-linked-model", "faultTrees": []}', "x", ModelFormat.LINKED),
        ('{"model": {"faultTrees": []}}', "x", ModelFormat.OPENPRA),
        ("", "x.dft", ModelFormat.GALILEO),
        ("", "x.SM", ModelFormat.PRISM),
        ("import rospy\n", "x.py", None),
        ("toplevel = 3\n", "x.py", None),
        ("// dtmc\nint main() {}\n", "x.cpp", None),
    ],
)
def test_the_format_is_reported_by_the_content_then_by_the_name(text, name, found):
    assert detected(text.encode(), name) is found


# Trees.


def test_a_fault_tree_is_solved_with_its_importances(call):
    expected = 1 - (1 - 0.1**2) * (1 - 0.001)
    data = solved(call, "cooling.xml", "--importance")
    (top,) = data["tops"]
    assert top["name"] == "none"
    assert top["probability"] == pytest.approx(expected, rel=1e-15)
    assert top["complement"] == pytest.approx((1 - 0.01) * 0.999, rel=1e-15)
    pump, valve = top["importance"]
    assert (pump["name"], valve["name"]) == ("pump", "valve")
    assert valve["birnbaum"] == pytest.approx(1 - 0.01, rel=1e-15)
    assert data["format"] == "open-psa"
    shown = call("solve", "cooling.xml", "--importance").out
    assert ["none", f"{expected:.6e}"] in cells(shown)
    assert "Importance for none" in shown


def test_a_likely_top_is_shown_with_its_complement(call):
    lines = cells(call("solve", "cooling.xml", "--set", "valve=0.999").out)
    assert ["none", "9.990100e-01", "9.900000e-04"] in lines


def test_figures_are_set_swept_and_asked_of_one_gate(call):
    assert top_of(call, "cooling.xml", "--set", "pump=0.5") == pytest.approx(0.25075, rel=1e-14)
    data = solved(call, "cooling.xml", "--figure", "both", "--sweep", "pump=0.01:1:3")
    (sweep,) = data["sweeps"]
    assert sweep["before"] == 0.1
    found = [point["figures"]["both"] for point in sweep["points"]]
    assert found == pytest.approx([1e-4, 1e-2, 1.0], rel=1e-12)
    assert (
        "both along pump"
        in call("solve", "cooling.xml", "--figure", "both", "--sweep", "pump=0.01:1:3").out
    )


def test_the_mission_time_is_asked_for_where_figures_hang_on_it(call):
    outcome = call("solve", "rate.xml")
    assert outcome.code == 2
    assert "figures of 'rate.xml' depend on the mission time; give --mission-time H" in outcome.err
    p = -math.expm1(-0.01 * 20)
    found = top_of(call, "rate.xml", "--mission-time", "20")
    assert found == pytest.approx(1 - (1 - p * p) * 0.999, rel=1e-14)


def test_deviates_are_drawn(call):
    found = solved(call, "deviate.xml", "--uncertainty", "--samples", "2000")["uncertainty"]
    (pump,) = found["inputs"]
    # Of a lognormal of mean m and error factor F at 90 % the median is m exp(-s^2/2).
    deviation = math.log(3) / 1.2815515655446004
    assert pump["name"] == "pump"
    assert pump["percentiles"][1] == pytest.approx(0.1 * math.exp(-(deviation**2) / 2), rel=1e-2)
    assert pump["share"] == pytest.approx(1.0, abs=5e-3)
    shown = call("solve", "deviate.xml", "--uncertainty", "--samples", "2000").out
    assert "none, 2000 samples, seed 0" in shown


def test_an_event_tree_has_sequences_and_outcomes(call):
    data = solved(call, "tree.xml")
    (tree,) = data["event_trees"]
    found = {each["name"]: each["probability"] for each in tree["sequences"]}
    assert found == {"calm": 0.999, "fire": 0.001}
    assert tree["outcomes"] == {"calm": 0.999, "fire": 0.001}
    assert ["fire", "fire", "1.000000e-03", "1.000000e-03"] in cells(call("solve", "tree.xml").out)
    assert (
        call("solve", "tree.xml", "--figure", "fire", "--max-failure-probability", "1e-4").code == 1
    )


def test_a_dynamic_tree_is_solved(call):
    # Two pumps of one rate, the second in use after the first: Erlang's law.
    pumps = 1 - math.exp(-0.2) * 1.2
    found = top_of(call, "pumps.dft", "--mission-time", "20")
    assert found == pytest.approx(1 - (1 - pumps) * 0.999, rel=1e-13)
    shown = cells(call("solve", "pumps.dft", "--mission-time", "20", "--importance").out)
    assert ["top", f"{found:.6e}"] in shown
    assert any(line[:2] == ["a", "0.1813"] for line in shown)
    changed = top_of(call, "pumps.dft", "--mission-time", "20", "--set", "valve=0.5")
    assert changed == pytest.approx(1 - (1 - pumps) * 0.5, rel=1e-13)


REPAIRED = """\
toplevel "pair"; "pair" and "a" "b";
"a" lambda=0.01 repair=0.5;
"b" lambda=0.02 repair=0.1;
"""


def test_a_repaired_tree_fails_at_the_end_or_at_any_time(call):
    Path("repaired.dft").write_text(REPAIRED)
    arguments = ("solve", "repaired.dft", "--mission-time", "100")
    outcome = call(*arguments)
    assert outcome.err == "pair: failed at the end of the mission, if not repaired before\n"
    lines = [line.rsplit(maxsplit=1) for line in outcome.out.splitlines()[-2:]]
    assert lines == [["pair", "3.267954e-03"], ["pair at any time", "1.592208e-01"]]
    assert call(*arguments, "--figure", "pair", "--max-failure-probability", "0.1").code == 0
    outcome = call(*arguments, "--max-failure-probability", "0.1")
    assert outcome.code != 0
    assert "pair at any time 0.1592 is over" in outcome.err
    (faster,) = solved(call, *arguments[1:], "--set", "a=0.1")["tops"]
    assert faster["probability"] > 2.7e-2
    assert faster["at_any_time"]["is_bound"] is False


def test_a_large_repaired_tree_is_bounded_at_any_time(call):
    names = [f"e{number}" for number in range(15)]
    Path("large.dft").write_text(
        f"toplevel T; T 15of15 {' '.join(names)};"
        + "".join(f"{name} lambda=0.1 repair=1;" for name in names)
    )
    (top,) = solved(call, "large.dft", "--mission-time", "10")["tops"]
    assert top["at_any_time"]["is_bound"] is True
    assert top["at_any_time"]["probability"] == pytest.approx((1 - math.exp(-1)) ** 15, rel=1e-12)


def test_a_limit_is_held_against_tops(call):
    outcome = call("solve", "cooling.xml", "--max-failure-probability", "0.01")
    assert outcome.code == 1
    assert "none 0.01099 is over --max-failure-probability 0.01" in outcome.err
    assert call("solve", "cooling.xml", "--max-failure-probability", "0.02").code == 0


def test_a_doubled_argument_is_reported(call):
    doubled = '<basic-event name="valve"/>\n        <basic-event name="valve"/>\n      </or>'
    Path("doubled.xml").write_text(
        xml().replace('<basic-event name="valve"/>\n      </or>', doubled)
    )
    outcome = call("solve", "doubled.xml")
    assert outcome.code == 0
    assert "valve" in outcome.err
    (reported,) = solved(call, "doubled.xml")["notes"]
    assert reported in outcome.err


def test_tops_are_solved_in_each_phase_of_an_alignment(call):
    phases = """<define-alignment name="year">
      <define-phase name="run" time-fraction="0.75"/>
      <define-phase name="repair" time-fraction="0.25">
        <set-house-event name="open"><constant value="true"/></set-house-event>
      </define-phase>
    </define-alignment></opsa-mef>"""
    house = '<house-event name="open"/></or>'
    text = xml(RATE).replace("</or>", house).replace("</opsa-mef>", phases)
    text = text.replace(
        "<model-data>",
        '<model-data><define-house-event name="open"><constant value="false"/>'
        "</define-house-event>",
    )
    Path("phases.xml").write_text(text)
    data = solved(call, "phases.xml", "--mission-time", "20")
    run, repair = data["phases"]
    p = -math.expm1(-0.01 * 15)
    assert (run["name"], run["fraction"]) == ("year, run", 0.75)
    assert run["tops"][0]["probability"] == pytest.approx(1 - (1 - p * p) * 0.999, rel=1e-14)
    (top,) = repair["tops"]
    assert top["probability"] == pytest.approx(1.0, rel=1e-15)
    assert top["complement"] == 0.0
    (mission,) = data["missions"]
    assert mission["name"] == "year, any phase"
    assert mission["tops"][0]["probability"] == pytest.approx(1.0, rel=1e-15)
    outcome = call(
        "solve", "phases.xml", "--mission-time", "20", "--max-failure-probability", "0.9"
    )
    assert outcome.code == 1
    assert "none (year, repair) 1 is over" in outcome.err
    # With the house event off in both phases, the mission is that without phases.
    Path("off.xml").write_text(text.replace('"true"', '"false"'))
    (mission,) = solved(call, "off.xml", "--mission-time", "20")["missions"]
    p = -math.expm1(-0.01 * 20)
    expected = pytest.approx(1 - (1 - p * p) * 0.999, rel=1e-14)
    assert mission["tops"][0]["probability"] == expected


def test_a_mission_of_phases_of_what_is_repaired_is_that_of_any_time(call):
    law = "<GLM>" + "".join(f'<float value="{v}"/>' for v in (0.0, 0.1, 1.0))
    text = xml(law + "<system-mission-time/></GLM>")
    phases = (
        '<define-alignment name="year"><define-phase name="all" time-fraction="1"/>'
        "</define-alignment></opsa-mef>"
    )
    Path("repaired.xml").write_text(text.replace("</opsa-mef>", phases))
    data = solved(call, "repaired.xml", "--mission-time", "20")
    (mission,) = data["missions"]
    Path("pair.dft").write_text(
        "toplevel T; T or valve both; both and a b; valve prob=0.001;"
        "a lambda=0.1 repair=1; b lambda=0.1 repair=1;"
    )
    (pair,) = solved(call, "pair.dft", "--mission-time", "20")["tops"]
    expected = pytest.approx(pair["at_any_time"]["probability"], rel=1e-13)
    assert mission["tops"][0]["probability"] == expected
    # Cutting the mission in two changes nothing.
    phases = phases.replace('"all" time-fraction="1"', '"first" time-fraction="0.3"').replace(
        "</define-al", '<define-phase name="then" time-fraction="0.7"/></define-al'
    )
    Path("repaired.xml").write_text(text.replace("</opsa-mef>", phases))
    (mission,) = solved(call, "repaired.xml", "--mission-time", "20")["missions"]
    assert mission["tops"][0]["probability"] == expected


CLIMB = "toplevel top; top 2of3 a b c; a lambda=0.01; b lambda=0.01; c lambda=0.01;"
CRUISE = "toplevel top; top and a b; a lambda=0.001; b lambda=0.002;"


def test_files_of_galileo_are_the_phases_of_a_mission(call):
    Path("climb.dft").write_text(CLIMB)
    Path("cruise.dft").write_text(CRUISE)
    arguments = ("climb.dft", "cruise.dft", "--phase-hours", "2,10")
    (top,) = solved(call, *arguments)["tops"]
    sound = {name: math.exp(-0.01 * 2) for name in "abc"}
    later = {"a": math.exp(-0.001 * 10), "b": math.exp(-0.002 * 10)}
    failed = 0.0
    for bits in range(8):
        down = {name for number, name in enumerate("abc") if bits >> number & 1}
        chance = math.prod(1 - sound[name] if name in down else sound[name] for name in "abc")
        # In the second phase the mission fails if both `a` and `b` are down by its end.
        both = math.prod(1.0 if name in down else 1 - later[name] for name in "ab")
        failed += chance if len(down) >= 2 else chance * both
    assert top["name"] == "any phase"
    assert top["probability"] == pytest.approx(failed, rel=1e-13)
    (higher,) = solved(call, *arguments, "--set", "c=0.1")["tops"]
    assert higher["probability"] > top["probability"]
    outcome = call("solve", *arguments, "--max-failure-probability", "1e-6")
    assert outcome.code == 1
    assert "any phase 0.00" in outcome.err
    assert "climb.dft -> cruise.dft" in outcome.out


def test_repair_and_dynamic_gates_go_on_from_phase_to_phase(call):
    pair = "toplevel T; T and a b; a lambda=0.1 repair=1; b lambda=0.2 repair=1;"
    spare = "toplevel T; T wsp a b; a lambda=0.1; b lambda=0.1 dorm=0.5;"
    for text in (pair, spare):
        Path("one.dft").write_text(text)
        Path("two.dft").write_text(text)
        (whole,) = solved(call, "one.dft", "--mission-time", "5")["tops"]
        (parts,) = solved(call, "one.dft", "two.dft", "--phase-hours", "2,3")["tops"]
        expected = whole.get("at_any_time", whole)["probability"]
        assert parts["probability"] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("second", "options", "message"),
    [
        (CRUISE, ["--phase-hours", "2"], "--phase-hours gives 1 times, and there are 2 files"),
        (CRUISE, ["--phase-hours", "2,1", "--curve", "3"], "--curve goes up to the mission time"),
        (CRUISE, ["--phase-hours", "2,1", "--mission-time", "3"], "leave out --mission-time"),
        (CRUISE, ["--phase-hours", "2,1", "--importance"], "--importance goes with one tree"),
        (CRUISE, ["--phase-hours", "2,1", "--set", "x=1"], "there is no event 'x'"),
        (CRUISE, ["--mission-time", "3"], "2 files; a model of the format galileo is one file"),
        (
            "toplevel T; T or a b; a prob=0.1; b lambda=1;",
            ["--phase-hours", "2,1"],
            "event 'a' is Exponential(rate=0.01) in 'climb.dft' and Constant(p=0.1) in",
        ),
        (
            "toplevel T; T or a b; a lambda=0.1 repair=1; b lambda=1 repair=1;",
            ["--phase-hours", "2,1"],
            "event 'b' is repaired in 'second.dft', and 'climb.dft' does not have it; add it",
        ),
        (
            "toplevel T; T or a w; a lambda=0.01; w rate=1 shape=2;",
            ["--phase-hours", "2,1"],
            "event 'w': Weibull counts the time of every phase, but 'climb.dft' does not have it",
        ),
    ],
)
def test_phases_that_make_no_mission_say_why(call, second, options, message):
    climb = CLIMB.replace("b c; a", "c; a").replace("2of3", "2of2").replace("b lambda=0.01;", "")
    Path("climb.dft").write_text(climb)
    Path("second.dft").write_text(second)
    outcome = call("solve", "climb.dft", "second.dft", *options)
    assert outcome.code == 2
    assert message in outcome.err


# Chains.


def test_a_prism_file_is_solved_and_its_constants_set(call):
    def failed(p):
        return p / (1 - (1 - p) / 2)

    data = solved(call, "chain.prism")
    assert data["absorption"]["failed"] == pytest.approx(failed(0.1), rel=1e-14)
    assert data["expected_steps"] == pytest.approx(1 / (1 - 0.45), rel=1e-14)
    data = solved(call, "chain.prism", "--set", "p=0.2", "--sweep", "p=0.01:0.1:2")
    assert data["absorption"]["failed"] == pytest.approx(failed(0.2), rel=1e-14)
    assert data["set"] == [{"name": "p", "before": 0.1, "now": 0.2}]
    points = data["sweeps"][0]["points"]
    assert [each["figures"]["failed"] for each in points] == pytest.approx(
        [failed(0.01), failed(0.1)], rel=1e-14
    )
    shown = call("solve", "chain.prism").out
    assert ["failed", f"{failed(0.1):.6e}"] in cells(shown)
    assert "mean number of steps: 1.818182e+00" in shown


def test_explicit_files_are_solved_with_the_labels_beside_them(call):
    data = solved(call, "repair.tra")
    assert data["absorption"] == {"failed": pytest.approx(1.0, rel=1e-15)}
    assert data["expected_time"] == pytest.approx(2110.0, rel=1e-14)
    assert solved(call, "repair.tra", "repair.lab") == data
    found = solved(call, "repair.tra", "--mission-time", "5")["distribution"]
    assert math.fsum(found.values()) == pytest.approx(1.0, rel=1e-14)
    outcome = call("solve", "repair.tra", "--mission-time", "5", "--figure", "failed")
    assert ["failed", f"{found['failed']:.6e}"] in cells(outcome.out)


def test_a_chain_without_an_end_has_its_long_run(call):
    Path("long.tra").write_text("ctmc\n0 1 0.1\n1 0 0.3\n")
    Path("long.lab").write_text("#DECLARATION\ninit down\n#END\n0 init\n1 down\n")
    assert solved(call, "long.tra")["steady_state"]["down"] == pytest.approx(0.25, rel=1e-14)


# What does not go together.


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["chain.prism", "--importance"], "--importance goes with models of components"),
        (["chain.prism", "--uncertainty"], "--uncertainty needs distributions"),
        (["chain.prism", "--mission-time", "3"], "--mission-time goes with a ctmc"),
        (
            ["chain.prism", "--max-failure-probability", "0"],
            "say with --figure which is a risk; allowed: done",
        ),
        (["chain.prism", "--figure", "fail"], "no figure of 'chain.prism'; did you mean 'failed'?"),
        (["chain.prism", "--set", "q=3"], "unknown constant 'q'"),
        (["repair.tra", "--set", "p=3"], "which a .tra file has none of"),
        (["repair.tra", "repair.lab", "x"], "3 files; a model of the format explicit is one file"),
        (
            ["pumps.dft", "--uncertainty", "--mission-time", "3"],
            "--uncertainty needs distributions",
        ),
        (["pumps.dft"], "depend on the mission time"),
        (["pumps.dft", "--set", "c=1"], "there is no event 'c'; allowed: a, b, valve"),
        (["pumps.dft", "--set", "valve=2"], "event 'valve': 2.0 is not a probability"),
        (["pumps.dft", "--set", "a=-1"], "event 'a': the rate -1.0 is below zero"),
        (["pumps.dft", "pumps.dft"], "2 files; a model of the format galileo is one file"),
        (["cooling.xml", "--set", "x=1"], "no parameter, event or house event 'x'"),
        (["cooling.xml", "--set", "valve=2"], "event 'valve': 2.0 is not a probability"),
        (["cooling.xml", "--uncertainty"], "nothing below 'none' is uncertain"),
        (["cooling.xml", "--error-factor", "3"], "--error-factor goes with models of functions"),
        (["cooling.xml", "--pairs"], "--pairs goes with models of functions"),
        (["cooling.xml", "--profile", "a:b=1"], "--profile goes with sources"),
        (["cooling.xml", "--figure", "nono"], "--figure nono: no figure of 'cooling.xml'"),
        (["cell.json", "--mission-time", "3"], "--mission-time goes with trees and chains"),
    ],
)
def test_errors_say_what_goes_with_what(call, arguments, message):
    outcome = call("solve", *arguments)
    assert outcome.code == 2
    assert message in outcome.err


def test_errors_of_files_say_where(call):
    Path("bad.dft").write_text('toplevel "a";\n"a" or "b";\n')
    outcome = call("solve", "bad.dft")
    assert outcome.code == 2
    assert "bad.dft:2:" in outcome.err
    Path("alone.tra").write_text(TRA)
    assert "alone.lab: cannot be read" in call("solve", "alone.tra").err


# Cut sets.


def test_cut_sets_are_counted_summed_and_listed(call):
    outcome = call("cut-sets", "cooling.xml", "--json")
    data = json.loads(outcome.out)
    assert (data["count"], data["count_by_order"]) == (2, {"1": 1, "2": 1})
    assert data["rare_event_sum"] == pytest.approx(0.011, rel=1e-15)
    assert data["top_probability"] == pytest.approx(0.01099, rel=1e-14)
    assert [each["events"] for each in data["cut_sets"]] == [["a", "b"], ["valve"]]
    shown = call("cut-sets", "cooling.xml").out
    assert "none: 2 minimal cut sets" in shown
    assert ["a,", "b", "1.000000e-02", "90.9", "%"] in cells(shown)
    assert "The 1 most probable" in call("cut-sets", "cooling.xml", "--limit", "1").out
    assert (
        "none: 1 minimal cut set of at most 1 events"
        in call("cut-sets", "cooling.xml", "--max-order", "1").out
    )
    cut = json.loads(call("cut-sets", "cooling.xml", "--cut-off", "0.005", "--json").out)
    assert [each["order"] for each in cut["cut_sets"]] == [2]
    assert cut["count"] == 2


def test_cut_sets_of_functions_of_gates_and_without_figures(call):
    found = call("cut-sets", "cell.json").out
    assert "fails: 2 minimal cut sets" in found
    assert "both: 1 minimal cut set\n" in call("cut-sets", "cooling.xml", "--top", "both").out
    outcome = call("cut-sets", "rate.xml")
    assert "with --mission-time H there are probabilities" in outcome.err
    assert "sum" not in outcome.out
    assert ["valve"] in cells(outcome.out)
    dynamic = call("cut-sets", "pumps.dft", "--mission-time", "20")
    assert "'pumps' is a dynamic group" in dynamic.err
    assert "top: 2 minimal cut sets" in dynamic.out


def test_prime_implicants_say_what_must_not_happen(call):
    Path("not.xml").write_text(
        xml().replace('<basic-event name="b"/>', '<not><basic-event name="b"/></not>')
    )
    outcome = call("cut-sets", "not.xml")
    assert "the tree is not coherent" in outcome.err
    assert "a, not b" in call("cut-sets", "not.xml", "--prime").out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["chain.prism"], "'chain.prism' holds no fault tree with cut sets"),
        (["cooling.xml", "--top", "x"], "--top x: there is no such top; allowed: none"),
        (["tree.xml"], "the model has no top"),
        (["cooling.xml", "--max-order", "0"], "max_order is 0"),
    ],
)
def test_what_has_no_cut_sets_is_reported(call, arguments, message):
    outcome = call("cut-sets", *arguments)
    assert outcome.code == 2
    assert message in outcome.err


# Conversion.


@pytest.mark.parametrize("name", ["out.xml", "out.json", "out.dft"])
@pytest.mark.parametrize("given", ["cooling.xml", "rate.xml"])
def test_trees_come_to_the_same_in_each_format(call, given, name):
    expected = top_of(call, given, "--mission-time", "20")
    assert call("convert", given, "-o", name, "--mission-time", "20").code == 0
    found = top_of(call, name, "--mission-time", "20")
    assert found == pytest.approx(expected, rel=1e-15)


def test_a_rate_stays_a_rate(call):
    assert call("convert", "rate.xml", "-o", "out.dft").code == 0
    assert '"a" lambda=0.01' in Path("out.dft").read_text()
    assert call("convert", "out.dft", "-o", "back.xml").code == 0
    expected = top_of(call, "rate.xml", "--mission-time", "7")
    assert top_of(call, "back.xml", "--mission-time", "7") == pytest.approx(expected, rel=1e-15)


@pytest.mark.parametrize("name", ["out.prism", "out.tra"])
@pytest.mark.parametrize("given", ["chain.prism", "repair.tra"])
def test_chains_come_to_the_same_in_each_format(call, given, name):
    outcome = call("convert", given, "-o", name, "--json")
    assert outcome.code == 0
    written = json.loads(outcome.out)["files"]
    assert written == (["out.prism"] if name == "out.prism" else ["out.tra", "out.lab"])
    expected = solved(call, given)["absorption"]
    assert solved(call, name)["absorption"] == pytest.approx(expected, rel=1e-15)


def test_a_model_of_functions_goes_to_chains_trees_and_links(call):
    pick = 1 - 0.99**2
    failure = pick / (1 - (1 - pick) / 2)
    assert call("convert", "cell.json", "-o", "out.tra").code == 0
    assert solved(call, "out.tra")["absorption"]["pick_failure"] == pytest.approx(
        failure, rel=1e-14
    )
    for name in ("out.xml", "out.json", "out.dft"):
        assert call("convert", "cell.json", "-o", name).code == 0
        assert top_of(call, name) == pytest.approx(pick, rel=1e-14)
    assert call("convert", "cell.json", "-o", "linked.json", "--to", "linked").code == 0
    figures = json.loads(call("solve", "linked.json", "--json").out)["figures"]
    assert figures["mission failure"] == pytest.approx(failure, rel=1e-14)


def test_constants_of_prism_are_set_in_what_is_written(call):
    assert call("convert", "chain.prism", "-o", "out.tra", "--set", "p=0.2").code == 0
    expected = solved(call, "chain.prism", "--set", "p=0.2")["absorption"]
    assert solved(call, "out.tra")["absorption"] == pytest.approx(expected, rel=1e-15)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ["pumps.dft", "-o", "o.xml"],
            "pumps.dft: 'pumps': only Galileo can hold elements that depend",
        ),
        (["tree.xml", "-o", "o.dft"], "'T': only Open-PSA and OpenPRA can hold event trees"),
        (["chain.prism", "-o", "o.xml"], "holds a chain, which open-psa cannot hold"),
        (["cooling.xml", "-o", "o.tra"], "holds fault or event trees, which explicit cannot hold"),
        (["cooling.xml", "-o", "o.txt"], "no format has this ending; --to allowed: explicit"),
        (["cooling.xml", "-o", "o.xml", "--top", "none"], "--top goes with --to galileo"),
        (["cooling.xml", "-o", "o.xml", "--set", "p=1"], "--set goes with constants of a PRISM"),
        (["repair.tra", "-o", "o.lab", "--to", "explicit"], "name it .tra"),
        (["rate.xml", "-o", "o.json"], "give the mission time to evaluate it"),
        (["cooling.xml", "-o", "o.dft", "--profile", "a:b=1"], "--profile goes with sources; a"),
        (["x.py", "-o", "o.xml"], "no risk block in x.py; `tracerisk run FILE`"),
        (["cooling.xml", "-o", "no/o.xml"], "no/o.xml: cannot be written"),
    ],
)
def test_what_a_format_cannot_hold_is_reported_and_nothing_written(call, arguments, message):
    Path("x.py").write_text("pass\n")
    before = sorted(Path().iterdir())
    outcome = call("convert", *arguments)
    assert outcome.code == 2
    assert message in outcome.err
    assert sorted(Path().iterdir()) == before


def test_the_blocks_of_sources_are_converted_as_the_model_built_of_them(call, annotated_source):
    source = annotated_source(
        pick=("place 1", "gripper = 1e-7; power = 1e-5 of2"), place=("done 1", "gripper = 3e-7")
    )
    Path("cell.py").write_text(source)
    assert call("build", "cell.py", "-o", "cell.json").code == 0
    for output, kind in (("x.xml", "open-psa"), ("x.prism", "prism"), ("x.json", "openpra")):
        assert call("convert", "cell.py", "-o", output, "--to", kind).code == 0
        of_sources = Path(output).read_text()
        assert call("convert", "cell.json", "-o", output, "--to", kind).code == 0
        assert Path(output).read_text() == of_sources


def test_the_profile_of_sources_is_converted(call, annotated_source):
    Path("cell.py").write_text(
        annotated_source(pick=("place 1", "gripper = 1e-3"), place=("done 1", "gripper = 3e-3"))
    )
    profile = ("--profile", "place:pick=0.9,done=0.1")
    assert call("convert", "cell.py", "-o", "x.prism", *profile).code == 0
    expected = solved(call, "cell.py", *profile)["assessment"]["states"]
    found = solved(call, "x.prism")["absorption"]
    assert found["pick_failure"] == pytest.approx(expected[0]["absorption_probability"], rel=1e-12)
    assert found["pick_failure"] > 5e-3


def test_a_curve_goes_up_to_the_mission_time(call):
    asked = ("--mission-time", "1000", "--curve", "4")
    found = solved(call, "rate.xml", *asked)
    (name,) = found["curve"]["figures"]
    values = found["curve"]["figures"][name]
    assert found["curve"]["times_h"] == [0.0, 250.0, 500.0, 750.0, 1000.0]
    assert values[-1] == found["tops"][0]["probability"]
    assert values == sorted(values)
    assert found["curve"]["means"][name] == pytest.approx(
        (values[0] / 2 + sum(values[1:4]) + values[4] / 2) / 4, rel=1e-12
    )
    shown = call("solve", "rate.xml", *asked).out
    assert "Along the mission time" in shown
    assert "mean" in shown


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("rate.xml", "--curve", "4"), "--curve goes up to the mission time; give --mission-time"),
        (("rate.xml", "--mission-time", "9", "--curve", "1"), "1 steps; give at least 2"),
    ],
)
def test_a_curve_that_cannot_be_is_reported(call, arguments, message):
    outcome = call("solve", *arguments)
    assert outcome.code == 2
    assert message in outcome.err


def test_importances_say_how_likely_an_event_is_where_the_top_is(call):
    found = solved(call, "cooling.xml", "--importance", "--mission-time", "100")["tops"][0]
    for each in found["importance"]:
        expected = each["probability"] * each["risk_achievement_worth"]
        assert each["diagnostic_importance"] == pytest.approx(expected, rel=1e-12)


WALK = """dtmc
module walk
  x : [0..3] init 1;
  [] x>0 & x<3 -> 0.5:(x'=x+1) + 0.5:(x'=x-1);
  [] x=0 | x=3 -> true;
endmodule
label "won" = x=3;
"""


def test_properties_of_a_chain_are_answered(call):
    Path("walk.prism").write_text(WALK)
    Path("asked.props").write_text('const int k; "soon": P=? [F<=k "won"]; P<0.5 [F "won"];')
    asked = ("--property", 'P=? [F "won"]', "--properties", "asked.props", "--set", "k=2")
    found = solved(call, "walk.prism", *asked)["answers"]
    assert [each["name"] for each in found] == ["soon", "", ""]
    assert [each["greatest"] for each in found] == pytest.approx([0.25, 1 / 3, 1 / 3], rel=1e-14)
    assert [each["holds"] for each in found] == [None, True, None]
    shown = call("solve", "walk.prism", *asked).out
    assert "soon: P=? [F<=k" in shown
    limit = call(
        "solve", "walk.prism", *asked, "--figure", "soon", "--max-failure-probability", "0.2"
    )
    assert limit.code == 1
    swept = solved(
        call, "walk.prism", "--property", "const int k = 1; P=? [F<=k x=3]", "--sweep", "k=2:8:2"
    )
    assert len(swept["sweeps"][0]["points"]) == 2


def test_a_limit_that_does_not_hold_is_reported_by_the_exit_code(call):
    Path("walk.prism").write_text(WALK)
    outcome = call("solve", "walk.prism", "--property", 'P>=0.5 [F "won"]')
    assert outcome.code == 1
    assert 'P>=0.5 [F "won"] does not hold' in outcome.err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("cooling.xml", "--property", "P=? [F x]"), "--property goes with chains"),
        (("chain.prism", "--property", "P=? [F"), "--property P=? [F:1:7: expected"),
        (("chain.prism", "--properties", "none.props"), "none.props: cannot be read"),
        (("repair.tra", "--property", "P=? [F x=1]"), "'x' is not a variable"),
    ],
)
def test_what_cannot_be_asked_of_a_model_is_reported(call, arguments, message):
    outcome = call("solve", *arguments)
    assert outcome.code == 2
    assert message in outcome.err


def test_parameters_of_galileo_are_set_and_swept(call, tmp_path):
    (tmp_path / "open.dft").write_text(
        "param x;\ntoplevel T; T and A B; A prob=x; B prob=0.5;", encoding="utf-8"
    )
    assert top_of(call, "open.dft", "--set", "x=0.5") == 0.25
    assert top_of(call, "open.dft", "--set", "x=0.5", "--set", "B=0.1") == pytest.approx(0.05)
    swept = call("solve", "open.dft", "--set", "x=0.5", "--set", "B=1", "--sweep", "x=0.1:1:3")
    assert "1.000000e-01" in swept.out


def test_a_pipe_and_a_file_without_an_end_are_refused(tmp_path, capsys, monkeypatch):
    os.mkfifo(tmp_path / "pipe")
    assert main(["solve", str(tmp_path / "pipe")]) == 2
    assert "pipe: is a pipe, which is read only once; save it to a file" in capsys.readouterr().err
    monkeypatch.setattr("tracerisk.cli.shared.sources.MOST_WRITTEN", 2**20)
    (tmp_path / "large.tra").write_bytes(b" " * (2**20 + 1))
    for name in ("/dev/zero", str(tmp_path / "large.tra")):
        assert main(["solve", name]) == 2
        words = f"{name}: holds more than 1 MB; no larger file is read"
        assert words in capsys.readouterr().err
