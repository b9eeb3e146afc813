"""Open-PSA files against SCRAM: theirs read here, ours read there."""

import math

import pytest

from tests.prm.other_models.formats.models import solved_tops
from tests.slow import slow_but
from tracerisk.errors import ModelError
from tracerisk.prm import minimal_cut_sets, prime_implicants
from tracerisk.prm.other_models.formats.open_psa import (
    loads_open_psa,
    read_open_psa,
)
from tracerisk.prm.other_models.formats.open_psa.writer import dumps_open_psa
from tracerisk.prm.other_models.logic.event_trees import solved_event_trees

MISSION_H = 8760.0

SHIPPED = (
    ("BSCU/BSCU.xml",),
    ("Baobab/baobab1.xml", "Baobab/baobab1-basic-events.xml"),
    ("Baobab/baobab2.xml", "Baobab/baobab2-basic-events.xml"),
    ("Chinese/chinese.xml", "Chinese/chinese-basic-events.xml"),
    ("EventTrees/attack.xml",),
    ("EventTrees/bcd.xml",),
    ("EventTrees/gas_leak/gas_leak.xml", "EventTrees/gas_leak/gas_leak_reactive.xml"),
    ("HIPPS/HIPPS.xml",),
    ("Lift/lift.xml",),
    ("SmallTree/SmallTree.xml",),
    ("Theatre/theatre.xml",),
    ("ThreeMotor/three_motor.xml",),
    ("ThreeMotor/three_motor.xml", "ThreeMotor/event_tree.xml"),
    ("TwoTrain/two_train.xml",),
    ("TwoTrain/two_train.xml", "TwoTrain/event_tree.xml"),
    ("TwoTrain/common_cause.xml",),
    ("TwoTrain/substitutions.xml",),
    ("ne574/ne574.xml",),
)
"""Which of SCRAM's inputs it can solve, and which files belong together."""

ONE_TREE = (
    ("BSCU/BSCU.xml",),
    ("Baobab/baobab2.xml", "Baobab/baobab2-basic-events.xml"),
    ("Chinese/chinese.xml", "Chinese/chinese-basic-events.xml"),
    ("HIPPS/HIPPS.xml",),
    ("Lift/lift.xml",),
    ("SmallTree/SmallTree.xml",),
    ("Theatre/theatre.xml",),
    ("ThreeMotor/three_motor.xml",),
    ("TwoTrain/two_train.xml",),
    ("ne574/ne574.xml",),
)
"""Those of one fault tree, whose parts SCRAM tells all of in little time."""

SMALL = (("BSCU/BSCU.xml",), ("HIPPS/HIPPS.xml",), ("Lift/lift.xml",), ("TwoTrain/two_train.xml",))
SOME = (
    ("Chinese/chinese.xml", "Chinese/chinese-basic-events.xml"),
    ("EventTrees/attack.xml",),
    ("EventTrees/gas_leak/gas_leak.xml", "EventTrees/gas_leak/gas_leak_reactive.xml"),
    ("HIPPS/HIPPS.xml",),
    ("TwoTrain/two_train.xml", "TwoTrain/event_tree.xml"),
    ("TwoTrain/common_cause.xml",),
    ("TwoTrain/substitutions.xml",),
)
"""One of each kind."""


def same_digits(found: float, printed: float) -> bool:
    """Whether a figure is the one that SCRAM prints to six digits."""
    return math.isclose(found, printed, rel_tol=6e-6, abs_tol=1e-30)


def assert_as_scram(model, report, *, common_cause=False):
    found = solved_tops(model, MISSION_H, common_cause=common_cause)
    if report.tops or not report.sequences:
        assert set(found) == set(report.tops)
    for top, printed in report.tops.items():
        assert same_digits(found[top], printed), top
    sequences = {
        (solution.initiating.name, each.name): each.value
        for solution in solved_event_trees(model, MISSION_H, common_cause=common_cause)
        for each in solution.sequences
    }
    assert set(sequences) == set(report.sequences)
    for sequence, printed in report.sequences.items():
        assert same_digits(sequences[sequence], printed), sequence


@pytest.mark.parametrize("files", slow_but(SOME, SHIPPED, of_one=True), ids=lambda files: files[-1])
def test_a_shipped_model_comes_out_as_in_scram(files, scram, scram_inputs, tmp_path):
    paths = [scram_inputs / file for file in files]
    model = read_open_psa(*paths)
    options = ("--limit-order", "2", "--mission-time", str(MISSION_H))
    assert_as_scram(model, scram(*paths, options=options))
    exported = tmp_path / "exported.xml"
    exported.write_text(dumps_open_psa(model))
    assert_as_scram(model, scram(exported, options=options))


@pytest.mark.slow  # SCRAM takes 3 s for its cut sets.
def test_the_largest_shipped_model_comes_out_as_in_scram(scram, scram_inputs, tmp_path):
    paths = [scram_inputs / f"CEA9601/CEA9601{part}.xml" for part in ("", "-basic-events")]
    model = read_open_psa(*paths)
    exported = tmp_path / "exported.xml"
    exported.write_text(dumps_open_psa(model))
    assert_as_scram(model, scram(exported, options=("--limit-order", "1")))


@pytest.mark.parametrize("files", SHIPPED, ids=lambda files: files[-1])
def test_a_shipped_model_comes_back_as_it_was(files, scram_inputs):
    model = read_open_psa(*[scram_inputs / file for file in files])
    text = dumps_open_psa(model)
    again = loads_open_psa(text, "again.xml")
    assert again == model
    assert dumps_open_psa(again) == text


def test_common_causes_come_out_as_in_scram(scram, scram_inputs):
    path = scram_inputs / "TwoTrain/common_cause.xml"
    report = scram(path, options=("--ccf", "true"))
    assert_as_scram(read_open_psa(path), report, common_cause=True)


@pytest.mark.slow(but=2)
@pytest.mark.parametrize("law", ["beta-factor", "MGL", "alpha-factor", "phi-factor"])
def test_every_common_cause_law_comes_out_as_in_scram(law, scram, tmp_path):
    factors = {
        "beta-factor": ("4", [0.13]),
        "MGL": ("2", [0.13, 0.4, 0.6]),
        "alpha-factor": ("1", [0.9, 0.06, 0.03, 0.01]),
        "phi-factor": ("1", [0.8, 0.1, 0.06, 0.04]),
    }
    level, values = factors[law]
    path = tmp_path / "group.xml"
    path.write_text(
        f"""<opsa-mef><define-fault-tree name="T">
        <define-gate name="top"><or>
        <atleast min="2">{"".join(f'<event name="{e}"/>' for e in "abcd")}</atleast>
        <and><event name="a"/><event name="x"/></and></or></define-gate>
        <define-basic-event name="x"><float value="0.3"/></define-basic-event>
        <define-CCF-group name="G" model="{law}">
        <members>{"".join(f'<basic-event name="{e}"/>' for e in "abcd")}</members>
        <distribution><float value="0.07"/></distribution>
        <factors>{"".join(f'<factor level="{int(level) + i}"><float value="{v}"/></factor>' for i, v in enumerate(values))}
        </factors></define-CCF-group></define-fault-tree></opsa-mef>"""
    )
    model = read_open_psa(path)
    assert_as_scram(model, scram(path, options=("--ccf", "true")), common_cause=True)
    assert_as_scram(model, scram(path, options=("--ccf", "false")), common_cause=False)
    exported = tmp_path / "exported.xml"
    exported.write_text(dumps_open_psa(model))
    assert_as_scram(model, scram(exported, options=("--ccf", "true")), common_cause=True)


@pytest.mark.parametrize(
    "files", slow_but(SMALL, ONE_TREE, of_one=True), ids=lambda files: files[-1]
)
def test_importances_come_out_as_in_scram(files, scram, scram_inputs):
    # Where the top is not coherent, SCRAM 0.16.2 gives every figure the opposite sign.
    paths = [scram_inputs / file for file in files]
    model = read_open_psa(*paths)
    report = scram(*paths, options=("--importance", "true"))
    assert report.importance
    for top, events in report.importance.items():
        tree = model.fault_tree(top, common_cause=False)
        solution = tree.solve(mission_time_h=MISSION_H)
        parameter_of = {event.name: event.parameter for event in tree.events}
        found = {each.name: each for each in solution.importance()}
        for event, figures in events.items():
            ours = found[parameter_of[event]]
            expected = {
                "MIF": ours.birnbaum,
                "CIF": ours.criticality,
                # Diagnostic importance: the chance that the event is there, given the top.
                "DIF": ours.diagnostic_importance,
                "RAW": ours.risk_achievement_worth,
                # What could not fail without the event has an infinite one, for which SCRAM prints 0.
                "RRW": 0.0 if math.isinf(ours.risk_reduction_worth) else ours.risk_reduction_worth,
            }
            for measure, value in expected.items():
                assert same_digits(value, figures[measure]), (top, event, measure)


def test_the_phases_of_an_alignment_can_be_solved(scram_inputs):
    model = read_open_psa(scram_inputs / "TwoTrain/two_train_alignment.xml")
    normal = solved_tops(model.in_phase("Maintenance", "Normal"), MISSION_H)
    assert normal == solved_tops(model, MISSION_H)
    outage = solved_tops(model.in_phase("Maintenance", "PumpOne"), MISSION_H)
    # With the pump of the first train out of its formula, only the valve fails that train.
    tree = model.in_phase("Maintenance", "PumpOne").fault_tree("TopEvent")
    assert outage["TopEvent"] == tree.probability(tree.values_at(MISSION_H)).p
    assert outage["TopEvent"] < normal["TopEvent"]


def test_replacements_in_cut_sets_have_no_exact_probability(scram_inputs):
    model = read_open_psa(scram_inputs / "TwoTrain/nondeclarative_substitutions.xml")
    with pytest.raises(ModelError) as caught:
        model.fault_tree("TopEvent")
    assert "substitution 'ExchangeValves' replaces events in cut sets" in str(caught.value)
    assert str(caught.value).startswith(str(scram_inputs))


@pytest.mark.parametrize(
    "files", slow_but(SMALL, ONE_TREE, of_one=True), ids=lambda files: files[-1]
)
def test_minimal_cut_sets_are_those_of_scram(files, scram, scram_inputs):
    paths = [scram_inputs / file for file in files]
    model = read_open_psa(*paths)
    # SCRAM leaves out what is less probable than 1e-8, unless it is told not to.
    report = scram(*paths, options=("--cut-off", "0"))
    assert report.products
    for top, expected in report.products.items():
        tree = model.fault_tree(top, common_cause=False)
        found = list(minimal_cut_sets(tree).most_probable(tree.values_at(MISSION_H)))
        ways = [(frozenset(each.events), frozenset(each.absent)) for each in found]
        assert len(ways) == len(expected)
        assert set(ways) == expected


def test_prime_implicants_are_those_of_scram(scram, tmp_path):
    text = """<opsa-mef><define-fault-tree name="tree">
    <define-gate name="top">
      <atleast min="2"><gate name="one"/><gate name="some"/><gate name="both"/></atleast>
    </define-gate>
    <define-gate name="one"><xor><event name="a"/><event name="b"/></xor></define-gate>
    <define-gate name="some"><nand><event name="b"/><gate name="any"/></nand></define-gate>
    <define-gate name="any"><or><event name="c"/><event name="e"/></or></define-gate>
    <define-gate name="both"><and><event name="c"/><event name="d"/></and></define-gate>
    %s</define-fault-tree></opsa-mef>"""
    event = '<define-basic-event name="%s"><float value="0.25"/></define-basic-event>'
    path = tmp_path / "tree.xml"
    path.write_text(text % "".join(event % name for name in "abcde"))
    report = scram(path, options=("--cut-off", "0", "--prime-implicants"))
    [expected] = report.products.values()
    ways = {
        (frozenset(each.events), frozenset(each.absent))
        for each in prime_implicants(read_open_psa(path).fault_tree("top")).most_probable()
    }
    assert any(absent for _, absent in expected)
    assert ways == expected
