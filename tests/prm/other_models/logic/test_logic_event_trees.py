import shutil
import subprocess
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from tracerisk.errors import ModelError
from tracerisk.prm.other_models.event_trees.elements import (
    Branch,
    Condition,
    End,
    EventSequence,
    InitiatingEvent,
    SetHouse,
)
from tracerisk.prm.other_models.event_trees.event_tree import EventTree
from tracerisk.prm.other_models.expressions import Number
from tracerisk.prm.other_models.formats.open_psa import read_open_psa
from tracerisk.prm.other_models.logic.event_trees import solved_event_trees
from tracerisk.prm.other_models.logic.mission_parts import EventTreeDefinition, Substitution
from tracerisk.prm.other_models.logic.model import (
    EventDefinition,
    GateDefinition,
    HouseDefinition,
    LogicModel,
)
from tracerisk.prm.trees.events import HouseEvent
from tracerisk.prm.trees.gates import Gate, GateKind

INPUTS = Path("/usr/share/scram/input")
needs_scram = pytest.mark.skipif(
    shutil.which("scram") is None or not INPUTS.exists(), reason="SCRAM is not installed"
)


def scram(*files):
    """SCRAM's sequences of each initiating event, six digits each."""
    command = ["scram", "--bdd", "--probability", "1", *map(str, files)]
    done = subprocess.run(command, capture_output=True, check=True)
    return {
        event.get("name"): {
            each.get("name"): float(each.get("value")) for each in event.iter("sequence")
        }
        for event in ET.fromstring(done.stdout).iter("initiating-event")
        if event.get("sequences")
    }


@needs_scram
@pytest.mark.parametrize(
    "files",
    [
        ["EventTrees/attack.xml"],
        ["EventTrees/bcd.xml"],
        ["EventTrees/gas_leak/gas_leak.xml", "EventTrees/gas_leak/gas_leak_reactive.xml"],
        ["ThreeMotor/event_tree.xml", "ThreeMotor/three_motor.xml"],
        ["TwoTrain/event_tree.xml", "TwoTrain/two_train.xml"],
    ],
    ids=lambda files: files[0],
)
def test_scram_agrees_on_its_own_event_trees(files):
    paths = [INPUTS / name for name in files]
    solutions = solved_event_trees(read_open_psa(*paths), 8760.0)
    found = {
        solution.initiating.name: {each.name: each.value for each in solution.sequences}
        for solution in solutions
    }
    expected = scram(*paths)
    assert expected
    assert found == {
        name: {sequence: pytest.approx(value, rel=1e-5) for sequence, value in sequences.items()}
        for name, sequences in expected.items()
    }


@needs_scram
def test_the_outcomes_of_the_gas_leak_sum_to_one():
    files = sorted((INPUTS / "EventTrees" / "gas_leak").glob("*.xml"))
    for solution in solved_event_trees(read_open_psa(*files), 8760.0):
        assert solution.total == pytest.approx(1.0, rel=1e-14)
        assert solution.findings == ()


def logic_model(*instructions, **more):
    tree = EventTree(
        "t",
        (),
        Branch(End("S"), instructions),
        (EventSequence("S"),),
        initiating=InitiatingEvent("i"),
    )
    return LogicModel(
        gates=(GateDefinition(Gate("g", GateKind.OR, ("a", "b"))),),
        events=(EventDefinition("a", Number(0.25)), EventDefinition("b", Number(0.5))),
        houses=(HouseDefinition(HouseEvent("h", False)),),
        event_trees=(EventTreeDefinition(tree),),
        **more,
    )


def test_a_house_event_may_be_set_that_no_condition_stands_above():
    model = logic_model(SetHouse("h", True), Condition("g"), Condition("a", False))
    (solution,) = solved_event_trees(model, 1.0)
    assert solution["S"] == 0.375


def test_a_tree_that_nothing_begins_is_no_result():
    tree = EventTree("t", (), Branch(End("S")), (EventSequence("S"),))
    assert solved_event_trees(LogicModel(event_trees=(EventTreeDefinition(tree),)), 1.0) == ()


def test_event_trees_under_substitutions_are_refused():
    model = logic_model(Condition("g"), substitutions=(Substitution("s", "g", False),))
    with pytest.raises(ModelError, match="event tree 't' is in a model with substitutions,"):
        solved_event_trees(model, 1.0)


FORKED = """<opsa-mef>
  <define-initiating-event name="I" event-tree="E"/>
  {rules}
  <define-event-tree name="E">
    <define-functional-event name="F"/>
    <define-sequence name="S">{sequence}</define-sequence>
    <initial-state>
      <fork functional-event="F">
        <path state="yes">{weight}<sequence name="S"/></path>
      </fork>
    </initial-state>
  </define-event-tree>
  {more}
</opsa-mef>"""
QUARTER = '<collect-expression><float value="0.25"/></collect-expression>'
HALF = '<collect-expression><float value="0.5"/></collect-expression>'
YES = '<test-functional-event name="F" state="yes"/>'
NO = '<test-functional-event name="F" state="no"/>'


def sequences_of(tmp_path, **parts):
    path = tmp_path / "m.xml"
    path.write_text(
        FORKED.format_map({"rules": "", "sequence": "", "weight": "", "more": ""} | parts)
    )
    (solution, *_) = solved_event_trees(read_open_psa(path), 1.0)
    return {each.name: each.value for each in solution.sequences}


@pytest.mark.parametrize(
    ("test", "expected"),
    [
        ('<bool value="true"/>', 0.25),
        ('<bool value="false"/>', 0.5),
        (f"<and>{YES}<not>{NO}</not></and>", 0.25),
        (f"<and>{YES}{NO}</and>", 0.5),
        (f"<or>{NO}{YES}</or>", 0.25),
        (f"<or>{NO}<and>{YES}{NO}</and></or>", 0.5),
        (f"<not><or>{NO}{NO}</or></not>", 0.25),
    ],
)
def test_tests_are_joined_and_can_be_constants(test, expected, tmp_path):
    found = sequences_of(tmp_path, weight=f"<if>{test}{QUARTER}{HALF}</if>")
    assert found == {"S": expected}


LATER = """<define-event-tree name="later"><define-functional-event name="G"/>
  <define-sequence name="end"/>
  <initial-state><fork functional-event="G"><path state="on">{}<sequence name="end"/></path></fork>
  </initial-state></define-event-tree>"""


def test_a_rule_may_hold_the_link_of_a_sequence(tmp_path):
    rule = '<define-rule name="R"><event-tree name="later"/></define-rule>'
    found = sequences_of(
        tmp_path, rules=rule, sequence='<rule name="R"/>', weight=HALF, more=LATER.format(QUARTER)
    )
    assert found == {"end": 0.125}


def test_a_path_may_end_in_a_sequence_of_another_event_tree(tmp_path):
    other = """<define-initiating-event name="J" event-tree="other"/>
      <define-event-tree name="other"><initial-state><sequence name="S"/></initial-state>
      </define-event-tree>"""
    path = tmp_path / "m.xml"
    path.write_text(FORKED.format(rules="", sequence=HALF, weight="", more=other))
    solutions = solved_event_trees(read_open_psa(path), 1.0)
    assert [[each.value for each in one.sequences] for one in solutions] == [[0.5], [0.5]]


@needs_scram
def test_scram_agrees_on_joined_tests_links_in_rules_and_borrowed_sequences(tmp_path):
    rule = '<define-rule name="R"><event-tree name="later"/></define-rule>'
    path = tmp_path / "m.xml"
    test = f'<and>{YES}<not>{NO}</not><bool value="true"/></and>'
    path.write_text(
        FORKED.format(
            rules=rule,
            sequence='<rule name="R"/>',
            weight=f"<if>{test}{QUARTER}{HALF}</if>",
            more=LATER.format(HALF),
        )
    )
    (solution,) = solved_event_trees(read_open_psa(path), 1.0)
    found = {solution.initiating.name: {each.name: each.value for each in solution.sequences}}
    assert found == scram(path) == {"I": {"end": 0.125}}


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ({"rules": '<define-rule name="R"/><define-rule name="R"/>'}, "rule 'R' is defined twice"),
        ({"weight": f"<if><xor>{YES}</xor>{HALF}</if>"}, "<xor> does not belong here"),
    ],
)
def test_what_is_wrong_with_rules_and_tests_is_reported(parts, message, tmp_path):
    with pytest.raises(ModelError, match=message):
        sequences_of(tmp_path, **parts)
