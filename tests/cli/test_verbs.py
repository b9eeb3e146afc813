"""Each verb as a user calls it: what it prints, what it writes, how it exits."""

import json
import re
from pathlib import Path

import pytest

from tracerisk.common.dependencies import EXTRAS, MODULES
from tracerisk.common.settings.settings_file import loads_toml

REPOSITORY = Path(__file__).resolve().parents[2]


def edit(example, old: str, new: str) -> int:
    """Change the first place of a text in the annotated controller; return its line."""
    source = example.read("controller.py").decode()
    assert old in source
    example.write("controller.py", source.replace(old, new, 1))
    return source[: source.index(old)].count("\n") + 1


def first_value(example) -> str:
    """The first computed probability in the controller, as written."""
    return example.read("controller.py").decode().split("probability = ")[1].split("\n")[0]


# run


def test_run_prints_one_schema_with_its_result(annotated_run):
    _, outcome = annotated_run
    data = outcome.json
    assert (data["schema"], data["version"], data["verb"]) == ("tracerisk", 1, "run")
    assert data["exit_code"] == 0
    assert [state["name"] for state in data["assessment"]["states"]] == ["act", "home"]
    assert list(data) == sorted(data)


def test_run_check_says_that_a_controller_would_change_and_leaves_it(example, quick):
    example.write("controller.py", quick())
    before = example.files()
    outcome = example.run("run", "controller.py", "--check")
    assert outcome.code == 1
    assert "controller.py: 1 risk block, would change" in outcome.err
    assert example.files() == before


STEPS = """\
import sys
import moveit_commander

arm = moveit_commander.MoveGroupCommander("panda_arm")
arm.set_max_velocity_scaling_factor(1.0)


def send(angle):
    arm.go([angle, -0.785, 0, -2.356, 0, 1.571, 0.785], wait=True)


def first():
    send(0.1)


def second():
    send(0.2)


first()
if len(sys.argv) > 1:
    second()
"""


def test_a_function_that_is_a_step_no_more_by_other_calls_is_named(example):
    example.write("c.py", STEPS)
    first = example.run("run", "c.py", "--robot", "panda")
    assert first.code == 0
    assert "though the code" not in first.err
    again = example.run("run", "c.py", "--robot", "panda", "--", "both")
    assert again.code == 0
    said = "c.py: first now counts by itself and what send does now counts for its callers, though"
    assert said in again.err


def test_a_lock_that_is_not_where_one_stands_is_named(example, quick):
    (example.folder / "cell").mkdir()
    example.write("cell/pyproject.toml", "[tool.tracerisk]\n")
    example.write("cell/controller.py", quick())
    outcome = example.run("run", "cell/controller.py")
    assert outcome.code == 0
    assert "cell/controller.py: 1 risk block, changed, of cell/tracerisk.lock" in outcome.err


def test_run_check_of_what_is_up_to_date_is_fine_and_writes_the_log_that_was_asked_for(annotated):
    before = annotated.files()
    outcome = annotated.run("run", "controller.py", "--check", "--log", "run.log")
    assert outcome.code == 0, outcome.err
    assert "controller.py: 2 risk blocks, unchanged" in outcome.err
    log = annotated.read("run.log").decode()
    assert log.startswith("Function:act()\nActiveComponents:")
    assert log.endswith("CallSequence:act(),home()\n")
    (annotated.folder / "run.log").unlink()
    assert annotated.files() == before


def test_run_diff_prints_what_would_change_and_leaves_it(annotated, two_steps):
    value = first_value(annotated)
    annotated.write("controller.py", two_steps)
    before = annotated.files()
    outcome = annotated.run("run", "controller.py", "--diff")
    assert outcome.code == 0, outcome.err
    added = [line[1:] for line in outcome.out.splitlines() if line.startswith("+ ")]
    assert f"    # |   probability = {value}" in added
    assert not [line for line in outcome.out.splitlines() if line.startswith("- ")]
    assert annotated.files() == before


def test_an_edited_value_stops_the_run_and_is_named(annotated):
    value = first_value(annotated)
    line = edit(annotated, f"probability = {value}", "probability = 2e-07")
    before = annotated.files()
    outcome = annotated.run("run", "controller.py")
    assert outcome.code == 3
    assert f"controller.py:{line}" in outcome.err
    assert "2e-07" in outcome.err
    assert value in outcome.err
    assert "--accept-edits" in outcome.err
    assert annotated.files() == before


def test_an_accepted_edit_becomes_the_persons_and_survives_the_next_run(annotated):
    value = first_value(annotated)
    edit(annotated, f"probability = {value}", "probability = 2e-07")
    assert annotated.run("run", "controller.py", "--accept-edits").code == 0
    kept = f"probability := 2e-07  ! computed {value}"
    assert kept in annotated.read("controller.py").decode()
    before = annotated.files()
    again = annotated.run("run", "controller.py", "--json")
    assert again.code == 0, again.err
    assert annotated.files() == before
    states = {state["name"]: state for state in again.json["model"]["states"]}
    assert 2e-07 in states["home"]["probabilities"].values()


def test_a_discarded_edit_gives_way_to_the_computed_value(annotated):
    before = annotated.files()
    edit(annotated, f"probability = {first_value(annotated)}", "probability = 2e-07")
    assert annotated.run("run", "controller.py", "--discard-edits").code == 0
    assert annotated.files() == before


def test_accepting_and_discarding_at_once_is_a_usage_error(annotated):
    outcome = annotated.run("run", "controller.py", "--accept-edits", "--discard-edits")
    assert outcome.code == 2
    assert "not allowed with argument" in outcome.err


def test_a_malformed_block_is_reported_before_a_run(annotated):
    line = edit(annotated, "callSequence = 1", "calSequence = 1")
    before = annotated.files()
    outcome = annotated.run("run", "controller.py")
    assert outcome.code == 2
    assert f"controller.py:{line}" in outcome.err
    assert "calSequence" in outcome.err
    assert "simulated" not in outcome.err
    assert annotated.files() == before


def test_a_malformed_lock_is_reported_before_a_run(annotated):
    annotated.write("tracerisk.lock", "{")
    outcome = annotated.run("run", "controller.py")
    assert outcome.code == 2
    assert "tracerisk.lock" in outcome.err
    assert "simulated" not in outcome.err


# annotate


def test_annotate_from_the_trace_gives_what_the_run_gave(annotated, two_steps):
    blocks = annotated.read("controller.py")
    (annotated.folder / "tracerisk.lock").unlink()
    annotated.write("controller.py", two_steps)
    outcome = annotated.run("annotate", "controller.py", "--trace", "trace.json", "--json")
    assert outcome.code == 0, outcome.err
    assert (outcome.json["changed"], outcome.json["blocks"]) == (True, ["act", "home"])
    assert annotated.read("controller.py") == blocks


def test_annotate_check_and_diff_leave_all_as_it_is(annotated, two_steps):
    annotated.write("controller.py", two_steps)
    before = annotated.files()
    checked = annotated.run("annotate", "controller.py", "--trace", "trace.json", "--check")
    shown = annotated.run("annotate", "controller.py", "--trace", "trace.json", "--diff")
    assert (checked.code, shown.code) == (1, 0), checked.err + shown.err
    assert "+    # | RiskAnnotation " in shown.out
    assert annotated.files() == before


def test_annotate_writes_a_profile_as_the_persons(annotated):
    outcome = annotated.run(
        "annotate", "controller.py", "--trace", "trace.json", "--profile", "home:act=0.5,done=0.5"
    )
    assert outcome.code == 0, outcome.err
    source = annotated.read("controller.py").decode()
    assert "next := act 0.5" in source
    assert "next := done 0.5" in source


@pytest.mark.parametrize(
    ("profile", "message"),
    [
        ("home", "expected FUNCTION:TARGET=SHARE"),
        ("home:act", "'act' is not a target of its own with a share"),
        ("home:act=x", "'act=x' is not a target"),
        ("home:act=-1", "'act=-1' is not a target"),
        ("home:act=1,act=1", "'act=1' is not a target"),
        ("nowhere:done=1", "nowhere"),
        ("home:nowhere=1", "nowhere"),
        ("home:act=1/0", "'act=1/0' is not a target"),
        ("home:act=0.5", "1/2"),
    ],
)
def test_a_malformed_profile_is_bad_input(profile, message, annotated):
    before = annotated.files()
    for call in (
        ("annotate", "controller.py", "--trace", "trace.json"),
        ("solve", "controller.py"),
    ):
        outcome = annotated.run(*call, "--profile", profile)
        assert outcome.code == 2, (call, outcome.err)
        assert message in outcome.err
    assert annotated.files() == before


def test_annotate_takes_no_trace_of_another_controller(annotated, quick):
    annotated.write("other.py", quick())
    outcome = annotated.run("annotate", "other.py", "--trace", "trace.json")
    assert outcome.code == 2
    assert "is a trace of 'controller.py', not of 'other.py'" in outcome.err


@pytest.mark.parametrize("text", ["", "{", "[]", '{"schema": "other"}'])
def test_annotate_takes_no_malformed_trace(text, annotated):
    annotated.write("trace.json", text)
    outcome = annotated.run("annotate", "controller.py", "--trace", "trace.json")
    assert outcome.code == 2
    assert "tracerisk: trace.json" in outcome.err


# strip


def test_strip_gives_back_the_bytes_and_check_leaves_them(annotated, two_steps):
    before = annotated.files()
    checked = annotated.run("strip", "controller.py", "--check", "--json")
    assert (checked.code, checked.json["changed"]) == (1, ["controller.py"])
    shown = annotated.run("strip", "controller.py", "--diff")
    assert shown.code == 0
    assert "-    # | RiskAnnotation " in shown.out
    assert annotated.files() == before
    assert annotated.run("strip", "controller.py").code == 0
    assert annotated.read("controller.py").decode() == two_steps
    assert annotated.run("strip", "controller.py", "--check").code == 0


def test_strip_keeps_what_a_person_set_unless_reported(annotated):
    line = edit(annotated, "probability = ", "probability := ")
    before = annotated.files()
    outcome = annotated.run("strip", "controller.py")
    assert outcome.code == 3
    assert f"controller.py:{line}" in outcome.err
    assert annotated.files() == before
    assert annotated.run("strip", "controller.py", "--discard-edits").code == 0
    assert b"RiskAnnotation" not in annotated.read("controller.py")


# build, solve


def test_build_prints_the_model_or_writes_it(annotated, annotated_run):
    _, run = annotated_run
    printed = annotated.run("build", "controller.py", "-q")
    assert printed.code == 0
    assert json.loads(printed.out)["states"] == run.json["model"]["states"]
    as_json = annotated.run("build", "controller.py", "--json", "-o", "other.json")
    assert as_json.json["model"] == json.loads(annotated.read("other.json")) == run.json["model"]


def test_build_of_a_source_without_blocks_is_bad_input(example, quick):
    example.write("controller.py", quick())
    outcome = example.run("build", "controller.py", "--json")
    assert outcome.code == outcome.json["exit_code"] == 2
    assert "no risk block in controller.py" in outcome.json["error"]["message"]


def test_a_file_is_named_once(annotated):
    outcome = annotated.run("build", "controller.py", "controller.py")
    assert outcome.code == 2
    assert "named twice" in outcome.err


@pytest.mark.parametrize("text", ["{", "{}", '{"schema": "x", "version": 1}', "\xff"])
def test_solve_takes_no_malformed_model(text, example):
    example.write("model.json", text.encode("latin-1"))
    outcome = example.run("solve", "model.json")
    assert outcome.code == 2
    assert "tracerisk: " in outcome.err
    assert "model.json" in outcome.err


def test_a_risk_over_the_limit_is_exit_1(annotated):
    risk = annotated.run("solve", "model.json", "--json").json["assessment"]["mission"][
        "failure_probability"
    ]
    over = annotated.run(
        "solve", "model.json", "--max-failure-probability", str(risk / 2), "--json"
    )
    assert over.code == over.json["exit_code"] == 1
    assert "is over --max-failure-probability" in over.err
    assert annotated.run("solve", "model.json", "--max-failure-probability", repr(risk)).code == 0


@pytest.mark.parametrize("limit", ["nan", "-1", "2", "x"])
def test_a_limit_that_is_no_probability_is_a_usage_error(limit, annotated):
    outcome = annotated.run("solve", "model.json", f"--max-failure-probability={limit}")
    assert outcome.code == 2
    assert "--max-failure-probability" in outcome.err


# trace, doctor


def test_trace_writes_what_annotate_reads(annotated_run, example, two_steps):
    run, _ = annotated_run
    example.write("controller.py", two_steps)
    before = example.read("controller.py")
    outcome = example.run("trace", "controller.py", "-o", "trace.json", "--log", "run.log")
    assert outcome.code == 0, outcome.err
    assert "1 act (line 9, 1 visit): panda_joint1" in outcome.out
    assert example.read("controller.py") == before
    assert not (example.folder / "tracerisk.lock").exists()
    assert b"CallSequence:act(),home()" in example.read("run.log")
    assert example.run("annotate", "controller.py", "--trace", "trace.json").code == 0
    assert example.read("controller.py") == run.read("controller.py")


def test_a_recording_is_kept_in_a_folder_only(example, quick):
    example.write("controller.py", quick())
    outcome = example.run("trace", "controller.py", "--keep", "controller.py")
    assert outcome.code == 2
    assert (
        "controller.py: is not a folder that a recording can be kept in: File exists" in outcome.err
    )


def test_doctor_says_what_a_controller_gets(annotated):
    outcome = annotated.run("doctor", "controller.py", "--json")
    assert outcome.code == 0, outcome.err
    found = outcome.json["found"]
    assert outcome.json["faults"] == {}
    assert found["robot"].startswith(
        "panda (its source names parts of it: panda_arm (controller.py); "
    )
    assert "+40.0 for panda: panda is named in its source" in found["what speaks for robots"]
    assert found["physics"].endswith("built and stepped")
    assert found["scene"] == "empty"


def test_doctor_looks_at_every_dependency():
    declared = loads_toml((REPOSITORY / "pyproject.toml").read_text())["project"]
    extras = declared["optional-dependencies"]

    def named(requirements: list[str]) -> list[str]:
        names = (re.split(r"[<>=;\[]", each)[0] for each in requirements)
        return sorted(name for name in names if name != "tracerisk")

    assert {extra: named(extras[extra]) for extra in EXTRAS} == {
        extra: sorted(names) for extra, names in EXTRAS.items()
    }
    base = set(MODULES) - {name for names in EXTRAS.values() for name in names}
    assert named(declared["dependencies"]) == sorted(base)


# usage


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["rum"], "unknown verb 'rum'; did you mean 'run'?"),
        (["zzz"], "unknown verb 'zzz'; `tracerisk --help` lists all verbs"),
        (["run"], "FILE"),
        (["run", "c.py", "--durration", "2"], "unknown option --durration; did you mean --durati"),
        (["run", "c.py", "--duration", "0"], "--duration: 0 is not a number above 0"),
        (["run", "c.py", "--duration", "x"], "--duration: 'x' is not a number"),
        (["run", "c.py", "--duration", "nan"], "--duration: nan is not a number above 0"),
        (["run", "c.py", "--seed", "-1"], "--seed"),
        (["run", "c.py", "--active", "held"], "--active: invalid choice: 'held'"),
        (["annotate", "c.py"], "--trace --log"),
        (["annotate", "c.py", "--trace", "a", "--log", "b"], "not allowed with"),
        (["solve", "c.json", "--zzz"], "unknown option --zzz; `tracerisk solve --help` lists all"),
        (["sweep", "c.py", "--set", "seed=3"], "unknown option --set; did you mean --over?"),
    ],
)
def test_a_usage_error_is_exit_2(arguments, message, example):
    outcome = example.run(*arguments)
    assert outcome.code == 2
    assert outcome.out == ""
    assert message in outcome.err.splitlines()[-1]


def test_a_file_in_the_place_of_a_verb_is_meant_for_run(example):
    example.write("pick.py", "x = 1\n")
    outcome = example.run("pick.py")
    assert outcome.code == 2
    assert "did you mean `tracerisk run pick.py`?" in outcome.err


def test_doctor_fits_a_terminal(example):
    outcome = example.run("doctor")
    assert all(len(line) <= 80 for line in outcome.out.splitlines())


def test_hardware_show_alone_is_that_of_the_settings(example):
    reported = example.run("hardware", "show")
    assert reported.code == 2
    assert "the settings name no description" in reported.err
    example.write("pyproject.toml", '[tool.tracerisk]\nhardware = "cell/hw.yaml"\n')
    example.write(
        "cell/hw.yaml",
        "components:\n  motor: {failure_rate: {value: 1e-6, per: hour}, active: always}\n",
    )
    shown = example.run("hardware", "show")
    assert shown.code == 0, shown.err
    assert "motor" in shown.out


def test_a_usage_error_is_json_where_that_was_asked_for(example):
    outcome = example.run("solve", "model.json", "--zzz", "--json")
    assert outcome.code == outcome.json["exit_code"] == 2
    assert outcome.json["error"]["message"].startswith("unknown option --zzz;")
    assert outcome.json["verb"] == "solve"
