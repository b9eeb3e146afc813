"""What is printed from the blocks up to the mission, recomputed by hand."""

import re

import pytest

import tracerisk
from tracerisk.prm import solve
from tracerisk.report.explain.mission import render_mission

SOURCE = """\
def pick(arm):
    # | RiskAnnotation
    # | @Function {
    # |   name = pick
    # |   callSequence = 1
    # |   next = pick 4/5
    # |   next = done 1/5
    # | }
    # | @Component {
    # |   name = motor
    # |   probability = 0.002
    # |   quantity = 3
    # |   redundancy = false
    # | }
    # | @Component {
    # |   name = power
    # |   probability = 0.01
    # |   quantity = 2
    # |   redundancy = true, common_cause 0.1
    # | }
    arm.go()
"""


@pytest.fixture
def shown():
    model = tracerisk.build({"cell.py": SOURCE.encode()}, name="cell.py")
    return solve(model), render_mission(model, solve(model), "pick")


def figure(text, line):
    return [float(each) for each in re.search(rf"{line}(.*)", text)[1].split()]


def test_a_functions_figures_can_be_checked_by_hand(shown):
    _, text = shown
    motor = 1 - (1 - 0.002) ** 3
    own, common = (0.01 * 0.9) ** 2, 0.01 * 0.1
    power = 1 - (1 - own) * (1 - common)
    assert figure(text, "    motor ") == pytest.approx([0.002, motor], rel=1e-7)
    assert figure(text, "    power ") == pytest.approx([0.01, power], rel=1e-7)
    assert figure(text, "own failures ") == pytest.approx([own], rel=1e-7)
    assert figure(text, "common cause ") == pytest.approx([common], rel=1e-7)
    top = 1 - (1 - motor) * (1 - power)
    assert figure(text, r"fails with\): ") == pytest.approx([top], rel=1e-7)


def test_the_missions_figure_follows(shown):
    assessment, text = shown
    visits, mean = re.search(
        r"visits expected: (\S+), each failing in the mean with (\S+)", text
    ).groups()
    assert float(visits) * float(mean) == pytest.approx(
        assessment.mission.geometric_cycles, rel=1e-7
    )
    (reported,) = figure(text, "as `next` counts them: ")
    assert reported == pytest.approx(assessment.mission.failure_probability, rel=1e-7)


def test_a_function_that_is_not_in_the_model_has_nothing_to_say():
    model = tracerisk.build({"cell.py": SOURCE.encode()}, name="cell.py")
    assert render_mission(model, solve(model), "place") == ""


def test_a_unit_has_the_sum_of_two_equal_parts():
    source = SOURCE.replace("common_cause 0.1", "common_cause 0.5")
    model = tracerisk.build({"cell.py": source.encode()}, name="cell.py")
    unit, _ = figure(render_mission(model, solve(model), "pick"), "    power ")
    assert unit == pytest.approx(0.01, rel=1e-7)
