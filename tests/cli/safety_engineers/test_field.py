"""`tracerisk field` and `hardware update`: recorded missions and failures, into the model."""

import json
from dataclasses import replace

import pytest

from tracerisk.adder.blocks.values import DONE
from tracerisk.common import trace_json
from tracerisk.common.field.file import dump_field, read_field
from tracerisk.common.function_ref import FunctionRef
from tracerisk.common.traced.elements import Element, Exposure
from tracerisk.pipeline.recordings.field_profile import gather_field
from tracerisk.trace import RunEnd, Trace, TracedFunction, Visit

PICK, PLACE = (FunctionRef("cell.py", name) for name in ("pick", "place"))
LOG = """\
Function:pick()
ActiveComponents:gripper
Function:place()
ActiveComponents:gripper

CallSequence:pick(),place(),pick(),place()
"""
HARDWARE = """\
# Kept.
robot: panda
components:
  gripper:
    # Its maker's.
    probability: {value: 1.0e-4, per: demand, error_factor: 5, source: maker}
    twin: {gripper: true}
  motor: {failure_rate: {value: 1.0e-5, per: hour, error_factor: 10}, quantity: 7, twin: {joints: "*"}}
  box: {probability: [{value: 1.0e-6, per: hour}, {value: 1.0e-6, per: minute}], active: always}
"""


def mission(*seconds, joint="panda_joint1"):
    """A mission of picks and places in turn, of so many seconds each."""
    visits, at = [], 0.0
    for number, s in enumerate(seconds):
        use = Exposure(moving_s=s, active_s=s, starts=1, longest_moving_s=s, longest_active_s=s)
        grip = Exposure(grasping_s=s, active_s=s, grasps=1)
        visits.append(
            Visit((PICK, PLACE)[number % 2], at, s, "succeeded", {joint: use, "panda_hand": grip})
        )
        at += s
    return Trace(
        controller="cell.py",
        robot="panda",
        scene="empty",
        end=RunEnd("ended", "returned", at),
        elements=(Element(joint, "joint"), Element("panda_hand", "gripper")),
        functions=(TracedFunction(PICK, 1, 1), TracedFunction(PLACE, 5, 2))[: len(seconds)],
        visits=tuple(visits),
    )


@pytest.fixture
def field(example):
    traces = [mission(2.0, 1.0), mission(2.2, 1.0, 2.0, 1.0), mission(1.8, 1.0)]
    names = [f"m{number}.json" for number, _ in enumerate(traces)]
    for name, trace in zip(names, traces, strict=True):
        example.write(name, trace_json.dumps(trace))
    example.write("hardware.yaml", HARDWARE)
    return example, names


def test_missions_are_summed_up(field):
    example, names = field
    outcome = example.run("field", *names, "-o", "field.json", "--json")
    assert outcome.code == 0, outcome.err
    found = outcome.json["field"]
    assert found["missions"] == 3
    assert found["functions"]["place"]["next"]["pick"]["share"] == "1/4"
    assert found["functions"]["place"]["next"][DONE]["count"] == 3
    assert found["functions"]["pick"]["duration_s"]["mean"] == pytest.approx(2.0)
    assert found["totals"]["panda_joint1"]["active_s"] == pytest.approx(12.0)
    assert found["totals"]["panda_hand"]["grasps"] == 8
    kept = read_field(example.folder / "field.json")
    assert json.loads(dump_field(kept)) == found


def test_the_table_says_what_follows(field):
    example, names = field
    outcome = example.run("field", *names)
    assert "3 missions in the field" in outcome.out
    assert "pick 0.25" in outcome.out


def test_the_title_of_a_small_table_stays_on_one_line(example):
    name = "a_controller_with_a_long_name.py"
    example.write("m.json", trace_json.dumps(replace(mission(2.0), controller=name)))
    outcome = example.run("field", "m.json", "-o", "field.json")
    assert outcome.out.startswith(f"{name} on panda: 1 mission in the field\n")
    assert "the profile of 1 mission\n" in outcome.err


def test_the_twin_is_reported_apart_where_it_leaves_the_intervals(field):
    example, names = field
    example.write("twin.json", trace_json.dumps(mission(2.0, 1.0)))
    fine = example.run("field", *names, "--against", "twin.json")
    assert fine.code == 0, fine.out
    assert "within the field's intervals" in fine.out
    example.write("twin.json", trace_json.dumps(mission(3.0, 1.0)))
    apart = example.run("field", *names, "--against", "twin.json")
    assert apart.code == 1
    assert "pick: duration_s is 3 on the twin, and 2 (" in apart.out
    assert "pick: panda_joint1 moving_s is 3 on the twin" in apart.out


def test_a_function_that_one_of_both_lacks_is_reported(field):
    example, names = field
    example.write("twin.json", trace_json.dumps(mission(2.0)))
    apart = example.run("field", *names, "--against", "twin.json")
    assert apart.code == 1
    assert "place: visits is 0 on the twin" in apart.out


def test_logs_give_a_profile_without_times(example):
    example.write("a.log", LOG)
    outcome = example.run("field", "a.log", "a.log", "--json")
    assert outcome.code == 0, outcome.err
    found = outcome.json["field"]
    assert found["duration_s"] is None
    assert found["functions"]["place"]["next"] == {
        "pick": {
            "count": 2,
            "share": "1/2",
            "low": pytest.approx(0.0976, abs=1e-4),
            "high": pytest.approx(0.9024, abs=1e-4),
        },
        DONE: {
            "count": 2,
            "share": "1/2",
            "low": pytest.approx(0.0976, abs=1e-4),
            "high": pytest.approx(0.9024, abs=1e-4),
        },
    }


def test_a_profile_of_the_field_is_one_of_the_model(example, annotated_source):
    example.write("a.log", LOG)
    example.write(
        "cell.py",
        annotated_source(pick=("place 1", "motor = 1e-5"), place=("done 1", "motor = 2e-5")),
    )
    assert example.run("field", "a.log", "-o", "field.json").code == 0
    by_file = example.run("solve", "cell.py", "--profile", "field.json", "--json")
    by_hand = example.run("solve", "cell.py", "--profile", "place:pick=1/2,done=1/2", "--json")
    assert by_file.code == by_hand.code == 0, by_file.err
    assert by_file.json["assessment"] == by_hand.json["assessment"]
    twice = example.run("solve", "cell.py", "--profile", "place:done=1", "--profile", "field.json")
    assert twice.code == 2
    assert "names 'place' twice" in twice.err


def test_recordings_of_two_controllers_are_refused(field):
    example, names = field
    example.write("a.log", LOG)
    outcome = example.run("field", *names, "a.log")
    assert outcome.code == 2
    assert "a.log: is of a log, but m0.json of cell.py on panda" in outcome.err


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "CallSequence"),
        ("{", "JSON"),
        ('{"schema": "x"}', "m.json"),
        ("\0", "m.json"),
    ],
)
def test_broken_recordings_are_named(example, text, message):
    example.write("m.json", text)
    outcome = example.run("field", "m.json")
    assert outcome.code == 2
    assert message in outcome.err


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('"schema": "tracerisk/field/1"', '"schema": "other"'), "is not a field profile:"),
        (('"missions": 3', '"missions": -3'), "is malformed"),
        (('"share": "1/4"', '"share": "1/5"'), "does not match its count"),
        (('"functions"', '"steps"'), "is malformed"),
    ],
)
def test_a_broken_profile_is_named(field, change, message):
    example, names = field
    example.run("field", *names, "-o", "field.json")
    example.write("field.json", example.read("field.json").decode().replace(*change))
    example.write("cell.py", "def pick():\n    pass\n")
    outcome = example.run("solve", "cell.py", "--profile", "field.json")
    assert outcome.code == 2
    assert message in outcome.err


def updated(field, rows, *more):
    example, names = field
    example.run("field", *names, "-o", "field.json")
    example.write("failures.csv", rows)
    return example.run(
        *("hardware", "update", "hardware.yaml", "--failures", "failures.csv"), *more
    )


def test_failures_bring_figures_up_to_date_and_comments_stay(field):
    example, _ = field
    rows = "component,failures,demands,hours\ngripper,3,20000,\nmotor,1,,50000\n"
    outcome = updated(field, rows, "--json")
    assert outcome.code == 0, outcome.err
    gripper, motor = outcome.json["updates"]
    assert gripper["after"] == pytest.approx(
        gripper["alpha"] / (gripper["alpha"] + gripper["beta"]), rel=1e-3
    )
    assert motor["exposure"] == 50000
    text = example.read("hardware.yaml").decode()
    assert "# Kept." in text
    assert "# Its maker's." in text
    assert "3 failures in 20000 demands (failures.csv), beta posterior" in text
    assert "before: maker" in text
    assert example.run("hardware", "show", "hardware.yaml").code == 0
    again = updated(field, rows)
    assert again.code == 2
    assert "are in it already" in again.err
    assert example.read("hardware.yaml").decode() == text


def test_failures_in_missions_take_the_exposure_of_the_field(field):
    rows = "component,failures,missions\ngripper,1,300\nmotor,0,9000\n"
    outcome = updated(field, rows, "--field", "field.json", "--json", "--dry-run")
    assert outcome.code == 0, outcome.err
    gripper, motor = outcome.json["updates"]
    # Eight grasps in three missions; twelve seconds of one joint in three missions.
    assert gripper["exposure"] == pytest.approx(800.0)
    assert motor["exposure"] == pytest.approx(9000 * 12 / 3 / 3600)


FIGURES = """\
component,failure_rate,probability,per,error_factor,source
gripper,,2e-6,demand,,data sheet
motor,2.5e-7,,,3,
"""


def test_figures_of_a_table_are_taken_and_comments_stay(field):
    example, _ = field
    example.write("rates.csv", FIGURES)
    before = example.read("hardware.yaml")
    update = ("hardware", "update", "hardware.yaml", "--figures", "rates.csv")
    shown = example.run(*update, "--dry-run", "--json")
    assert shown.code == 0, shown.err
    assert [each["value"] for each in shown.json["figures"]] == [2e-6, 2.5e-7]
    assert example.read("hardware.yaml") == before
    assert example.run(*update).code == 0
    text = example.read("hardware.yaml").decode()
    assert "# Kept." in text
    assert "# Its maker's." in text
    assert "probability: {value: 2e-06, per: demand, source: data sheet}" in text
    motor = "failure_rate: {value: 2.5e-07, per: hour, error_factor: 3, source: rates.csv}"
    assert motor in text
    assert example.run("hardware", "show", "hardware.yaml").code == 0


def test_a_table_with_semicolons_and_decimal_commas_is_read(field):
    example, _ = field
    example.write("rates.csv", "Component;Failure_Rate;source\nmotor;2,5e-7;Lieferant, 2025\n")
    shown = example.run(
        *("hardware", "update", "hardware.yaml", "--figures", "rates.csv", "--dry-run", "--json")
    )
    assert shown.code == 0, shown.err
    (figure,) = shown.json["figures"]
    assert (figure["value"], figure["source"]) == (2.5e-7, "Lieferant, 2025")


def test_a_figure_with_a_source_is_assumed_no_longer(example):
    assert example.run("hardware", "init", "--robot", "ur5e", "-o", "h.yaml").code == 0
    names = ("power_system", "control_system", "gripper", "electric_motor", "joint_encoder")
    rows = [f"{name},4e-6,3,supplier" for name in (*names, "wrist_force_sensor")]
    example.write("rates.csv", "\n".join(("component,failure_rate,error_factor,source", *rows)))
    before = example.run("hardware", "show", "h.yaml", "--json").json
    assert before["assumed"] == [*names, "wrist_force_sensor"]
    assert example.run("hardware", "update", "h.yaml", "--figures", "rates.csv").code == 0
    shown = example.run("hardware", "show", "h.yaml", "--json").json
    assert shown["assumed"] == []
    rates = [each["failure_rate"]["value"] for each in shown["hardware"]["components"].values()]
    assert rates == [4e-6] * 6


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ("nothing,1e-6,,,,", "rates.csv:2: unknown component 'nothing'"),
        ("motor,,,,,", "motor: expected one of failure_rate, probability, mtbf"),
        ("motor,1e-6,1e-6,,,", "motor: expected one of"),
        ("motor,1e-6,,demand,,", "per: 'demand' is not allowed of a failure_rate; allowed: hour"),
        ("motor,x,,,,", "failure_rate: expected a number"),
        ("motor,,2,,,", "expected at most 1"),
        ("motor,1e-6,,,0.5,", "error_factor: expected a number from 1"),
        ("motor,1e-6,,,,\nmotor,1e-6,,,,", "rates.csv:3: duplicate motor"),
        ("box,1e-6,,,,", "box has several figures"),
    ],
)
def test_a_malformed_table_of_figures_is_named_and_nothing_is_written(field, row, message):
    example, _ = field
    example.write("rates.csv", f"{FIGURES.splitlines()[0]}\n{row}\n")
    before = example.read("hardware.yaml")
    outcome = example.run("hardware", "update", "hardware.yaml", "--figures", "rates.csv")
    assert outcome.code == 2
    assert message in " ".join(outcome.err.split())
    assert example.read("hardware.yaml") == before


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ("component,failures,hours\nnothing,1,5\n", "failures.csv:2: unknown component 'nothing'"),
        ("component,failures,hours\nmotor,1.5,5\n", "expected a whole number"),
        ("component,failures,hours\nmotor,1,\n", "expected one of hours"),
        ("component,failures,hours\nmotor,1,x\n", "hours: expected a number"),
        ("component,failures,hours\nmotor,1,5\nmotor,1,5\n", "duplicate motor"),
        ("component,failures,hours\ngripper,1,5\n", "fails per demand"),
        ("component,failures,demands\nmotor,1,5\n", "fails per time"),
        ("component,failures,demands\ngripper,7,5\n", "too few demands"),
        ("component,failures,hours\nbox,1,5\n", "brings one figure up to date"),
        ("component,failures,missions\nmotor,1,5\n", "need --field"),
        ("part,failures\nmotor,1\n", "unknown column 'part'"),
        ("component,mtbf\nmotor,1\n", "unknown column 'mtbf'"),
        ("component,failures,hours\n", "has no row"),
    ],
)
def test_what_does_not_fit_is_named_and_nothing_is_written(field, rows, message):
    example, _ = field
    outcome = updated(field, rows)
    assert outcome.code == 2
    assert message in outcome.err
    assert example.read("hardware.yaml").decode() == HARDWARE


def test_the_same_missions_give_the_same_bytes(field):
    example, names = field
    example.run("field", *names, "-o", "one.json")
    example.run("field", *names, "-o", "two.json")
    assert example.read("one.json") == example.read("two.json")
    assert gather_field([mission(1.0, 2.0)], ["m"]).missions == 1
