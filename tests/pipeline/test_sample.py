"""The sample controller through the whole path."""

import json
import math

import pytest

from tests.pipeline.conftest import OUTPUTS
from tests.prm.other_models.formats.openpra_engine import (
    check_by_engine,
    needs_engine,
    violations,
)

STEPS = ["init", "pick_position", "pick", "place_position", "place"]
LISTING = """\
Function:init()
ActiveComponents:gripper,electric_motor
Function:pick_position()
ActiveComponents:electric_motor
Function:pick()
ActiveComponents:gripper,electric_motor
Function:place_position()
ActiveComponents:electric_motor
Function:place()
ActiveComponents:gripper

CallSequence:init(),pick_position(),pick(),place_position(),place()
"""
"""Grimmeisen et al. 2024, listing 1."""


def test_every_tube_stands_upright_in_its_slot_of_the_target_rack(sample_run, tubes):
    _, outcome = sample_run
    objects = outcome.json["objects"]
    assert [each["name"] for each in objects] == [f"tube_{i}" for i in range(1, 11)]
    moved = objects[:tubes]
    goals = [f"target_rack_slot_{i}" for i in range(1, tubes + 1)]
    assert [each["goal"] for each in moved] == goals
    assert all(each["upright"] for each in moved)
    assert max(each["offset_m"] for each in moved) < 0.003


def test_the_chain_is_the_published_one_over_all_rounds(sample_run, tubes):
    example, outcome = sample_run
    states = outcome.json["model"]["states"]
    assert [state["name"] for state in states] == STEPS
    follows = {
        state["name"]: {step["target"]: step["weight"] for step in state["next"]}
        for state in states
    }
    assert follows == {
        "init": {"pick_position": "1"},
        "pick_position": {"pick": "1"},
        "pick": {"place_position": "1"},
        "place_position": {"place": "1"},
        "place": {"init": f"{tubes - 1}/{tubes}", "done": f"1/{tubes}"},
    }
    source = example.read("pick_and_place.py").decode()
    assert source.count("# | RiskAnnotation") == 5
    again = f"    # |   next = init {tubes - 1}/{tubes}\n"
    assert f"{again}    # |   next = done 1/{tubes}\n" in source


def test_a_second_run_under_another_hash_seed_changes_no_byte(short_run):
    example, outcome = short_run
    before = example.files()
    again = example.run(
        "run",
        "pick_and_place.py",
        *OUTPUTS,
        environment={"PYTHONHASHSEED": "4711"},
    )
    assert again.code == 0
    assert example.files() == before
    assert again.out == outcome.out


def test_moving_only_reproduces_the_published_log(short_run):
    example, _ = short_run
    before = example.files()
    # The published arm began with a closed hand, and opened it first.
    example.write("closed.yaml", "start: {panda_finger_joint1: 0.0}\n")
    options = ("--active", "moving", "--scenario", "closed.yaml")
    outcome = example.run("run", "pick_and_place.py", *options, "--log", "out.log", "--check")
    assert outcome.code == 1, "other figures: the blocks would change"
    assert example.read("out.log").decode() == LISTING
    for name in ("out.log", "closed.yaml"):
        (example.folder / name).unlink()
    assert example.files() == before


def test_strip_gives_back_the_original_bytes(short_run, example, short_source):
    run, _ = short_run
    example.write("pick_and_place.py", run.read("pick_and_place.py"))
    assert example.run("strip", "pick_and_place.py").code == 0
    assert example.read("pick_and_place.py") == short_source


def test_exposures_over_all_visits_sum_to_the_active_time_of_the_run(sample_trace):
    step_s = 0.002
    assert set(sample_trace.active) == {element.name for element in sample_trace.elements}
    for name, whole in sample_trace.active.items():
        for field in ("moving_s", "holding_s", "grasping_s", "active_s"):
            parts = [
                getattr(v.exposures[name], field)
                for v in sample_trace.visits
                if name in v.exposures
            ]
            assert math.fsum(parts) == pytest.approx(getattr(whole, field), abs=step_s)


def test_visits_share_out_the_whole_time_of_the_run(sample_trace):
    total = math.fsum(visit.duration_s for visit in sample_trace.visits)
    assert total == pytest.approx(sample_trace.end.simulated_s, abs=0.004)


def test_only_the_carrying_functions_grasp(sample_trace):
    grasping = {
        visit.function.name
        for visit in sample_trace.visits
        if visit.exposures.get("panda_hand") is not None
        and visit.exposures["panda_hand"].grasping_s > 0.1
    }
    assert grasping == {"pick", "place_position"}


def test_the_figure_can_be_checked_by_hand_from_block_to_source(sample_run, sample_trace):
    """One motor's exposures, the published figure per minute, and the block's value."""
    _, outcome = sample_run
    visits = [v for v in sample_trace.visits if v.function.name == "pick"]
    motors = [e.name for e in sample_trace.elements if e.kind == "joint"]
    seconds = math.fsum(v.exposures[m].active_s for v in visits for m in motors)
    alive = seconds / 60.0 * math.log1p(-9.5e-08)
    unit = -math.expm1(alive / (len(visits) * len(motors)))
    (state,) = [s for s in outcome.json["model"]["states"] if s["name"] == "pick"]
    assert f"{state['probabilities']['electric_motor']:.4g}" == f"{unit:.4g}"


def test_the_model_file_and_the_annotated_source_solve_alike(sample_run):
    example, outcome = sample_run
    by_model = example.run("solve", "model.json", "--json").json["assessment"]
    by_source = example.run("solve", "pick_and_place.py", "--json").json["assessment"]
    assert by_model == by_source == outcome.json["assessment"]


def test_what_is_converted_keeps_the_rules_of_openpra(sample_run, example):
    run, _ = sample_run
    example.write("pick_and_place.py", run.read("pick_and_place.py"))
    assert example.run("convert", "pick_and_place.py", "-o", "openpra.json").code == 0
    assert violations(json.loads(example.read("openpra.json"))) == []


@needs_engine
def test_the_openpra_engine_itself_solves_what_is_converted(sample_run, example):
    run, _ = sample_run
    example.write("pick_and_place.py", run.read("pick_and_place.py"))
    check_by_engine(example, "pick_and_place.py")


def test_run_says_what_the_figure_is_and_never_calls_it_a_safety_level(sample_run):
    example, _ = sample_run
    shown = example.run("solve", "pick_and_place.py").out
    assert "hardware; not harm, software faults or people" in shown
    assert "PFH" not in shown
    assert "SIL" not in shown
