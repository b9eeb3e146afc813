import re
import subprocess
import sys
from dataclasses import replace
from fractions import Fraction

import pytest
from rich.cells import cell_len

import tracerisk
from tracerisk.common.text.paper import Paper
from tracerisk.prm import (
    FIGURE_STATEMENT,
    BasicEvent,
    FaultTree,
    FunctionState,
    Gate,
    GateKind,
    HybridModel,
    NextStep,
    Parameter,
    solve,
)
from tracerisk.report.terminal import render_assessment, undetected_sentence

ANSI = re.compile("\\x1b\\[[0-9;]*m")
BAR = "\u2588\u258f\u258e\u258d\u258c\u258b\u258a\u2589"


def series_state(name, sequence, probabilities, following):
    """Return a state whose components are single and all needed."""
    top = Gate(f"{name} fails", GateKind.OR, tuple(probabilities))
    events = tuple(BasicEvent(component, component) for component in probabilities)
    steps = tuple(NextStep(target, Fraction(weight)) for target, weight in following.items())
    return FunctionState(name, sequence, FaultTree(top.name, (top,), events), probabilities, steps)


@pytest.fixture
def assessment():
    names = [f"component_{letter}" for letter in "abcdef"]
    values = {name: (rank + 1) * 1e-9 for rank, name in enumerate(names)}
    states = (
        series_state("PickAndPlaceNode.approach_the_rack", 1, values, {"hold": 1}),
        series_state("hold", 2, {"component_a": 1e-9}, {"done": Fraction(1, 4), "hold": "3/4"}),
        series_state("rest", 3, {}, {"done": 1}),
    )
    parameters = tuple(Parameter(name, value) for name, value in values.items())
    return solve(HybridModel("racks", states[0].name, states, parameters))


def test_table_fits_eighty_columns_and_carries_the_statement_in_one_line(assessment):
    lines = render_assessment(assessment).splitlines()
    assert max(map(len, lines)) <= 80
    assert lines.count(FIGURE_STATEMENT) == 1
    assert len(FIGURE_STATEMENT) <= 80


def test_statement_promises_no_safety_integrity_figure():
    assert "pfh" not in FIGURE_STATEMENT.lower()
    assert "sil" not in FIGURE_STATEMENT.lower().split()


def test_table_with_exposures_still_fits_and_shows_the_seconds(assessment):
    exposures = {"hold": {"component_a": 1234.5678}}
    text = render_assessment(assessment, exposures=exposures)
    assert max(map(len, text.splitlines())) <= 80
    assert "1234.57" in text
    assert "active s" in text
    assert "\nactive s: all visits; p failure: one visit\n" in text
    assert "active s" not in render_assessment(assessment)


def test_the_missions_figure_stands_first_and_what_it_is_right_below(assessment):
    lines = render_assessment(assessment, paper=Paper(120)).splitlines()
    assert lines[0] == (
        "Probability that a hardware failure ends a mission of racks: 2.50e-08, 24 % of it through "
        "component_f."
    )
    assert lines[1] == FIGURE_STATEMENT
    assert lines.index("Functions") < lines.index("Findings") < lines.index("Assumptions")


def test_how_missions_end_that_fail_stands_below_their_figure(assessment):
    assert undetected_sentence(assessment.mission, str) == ""
    mission = replace(
        assessment.mission,
        failure_probability=4e-6,
        undetected_probability=3e-6,
        stopped_late_probability=1e-6,
        stopped_safely_probability=1e-6,
    )
    shown = render_assessment(replace(assessment, mission=mission))
    assert " ".join(shown.split()).count(
        "Of which undetected, or with harm before the stop: 3.00e-06 (75 %); of that stopped late: "
        "1.00e-06. Stopped safely: 1.00e-06."
    )
    assert undetected_sentence(mission, "{:.0e}".format) == (
        "Of which undetected, or with harm before the stop: 3e-06; of that stopped late: 1e-06. "
        "Stopped safely: 1e-06."
    )


def test_a_mission_that_no_failure_can_end_is_reported_so():
    state = series_state("rest", 1, {}, {"done": 1})
    lines = render_assessment(solve(HybridModel("m", "rest", (state,), ()))).splitlines()
    assert lines[0] == "No hardware failure that is modelled can end a mission of m."
    assert "nan" not in "".join(lines)


def test_a_row_shows_sequence_top_visits_and_share_and_its_components_below(assessment):
    rows = [line.split() for line in render_assessment(assessment).splitlines()]
    place = rows.index(["2", "hold", "1.00e-09", "4", "16", "%"])
    assert rows[place + 1] == ["component_a", "1", "of", "1", "1.00e-09", "16", "%"]
    place = rows.index(["3", "rest", "0.00e+00", "0", "0", "%"])
    assert rows[place + 1] == ["(none)"]


def test_shares_of_functions_and_of_their_components_add_up_to_the_missions(assessment):
    text = render_assessment(assessment).split("Components that")[0]
    shares = {"function": 0.0, "component": 0.0}
    for line in text.splitlines():
        if line.endswith(" %"):
            kind = "component" if "component_" in line else "function"
            shares[kind] += float(line.split()[-2])
    assert shares == pytest.approx({"function": 100.0, "component": 100.0}, abs=0.2)


def test_components_of_a_function_stand_in_the_order_in_which_they_matter(assessment):
    table = render_assessment(assessment).split("2  hold")[0]
    names = [word for word in table.split() if word.startswith("component_")]
    # The first is in the sentence.
    assert names[1:] == [f"component_{letter}" for letter in "fedcba"]


def many_components(number: int, name: str = "joint_motor_{}"):
    names = {name.format(index): (index + 1) * 1e-9 for index in range(number)}
    state = series_state("pick", 1, names, {"done": 1})
    parameters = tuple(Parameter(*each) for each in names.items())
    return solve(HybridModel("cell.py", "pick", (state,), parameters))


def test_of_many_components_those_that_matter_are_shown_and_the_rest_counted():
    text = render_assessment(many_components(40)).split("Components that")[0]
    assert "and 34 more" in text
    assert [word in text for word in ("_39 ", "_34 ", "_33 ")] == [True, True, False]
    assert "more" not in render_assessment(many_components(7)).split("Components that")[0]


LONG = "PickAndPlaceNode.approach_the_rack_from_above_with_an_open_gripper_and_then_wait.inner"
WIDE_LETTERS = "\u628a\u8bd5\u7ba1\u653e\u5165\u67b6\u5b50" * 6
EMOJI = "\U0001f916_arm"


@pytest.mark.slow(but=16)
@pytest.mark.parametrize("width", [60, 72, 80, 109, 110, 120, 160, 240])
@pytest.mark.parametrize("name", [LONG, WIDE_LETTERS, EMOJI])
@pytest.mark.parametrize("color", [True, False])
def test_the_table_fits_every_terminal_and_loses_no_letter_of_a_name(width, name, color):
    parts = {f"{name}_{index}": 1e-7 * 10.0**-index for index in range(12)}
    states = [series_state(f"{name}{n}", n, parts, {"done": 1}) for n in (1, 2)]
    states[0] = series_state(f"{name}1", 1, parts, {f"{name}2": 1})
    parameters = tuple(Parameter(*each) for each in parts.items())
    model = HybridModel("cell.py", f"{name}1", tuple(states), parameters)
    exposures = {f"{name}1": dict.fromkeys(parts, 12345.678)}
    text = render_assessment(solve(model), exposures=exposures, paper=Paper(width, color=color))
    lines = [line.rstrip() for line in ANSI.sub("", text).splitlines()]
    assert max(map(cell_len, lines)) <= min(width, 160)
    # Folded names are whole when the lines of their column are joined.
    table = "\n".join(lines).split("Functions\n")[1].split("Findings")[0]
    column = table.split("Components that")[0].splitlines()
    assert "\N{HORIZONTAL ELLIPSIS}" not in text
    joined = "".join(line[3:].strip().split("  ")[0] for line in column)
    assert f"{name}1" in joined
    assert f"{name}_0" in joined


def test_a_wide_terminal_gets_bars_as_long_as_the_shares(assessment):
    narrow, wide = (render_assessment(assessment, paper=Paper(width)) for width in (109, 110))
    assert not any(mark in narrow for mark in BAR)
    assert "absorbed" in wide
    assert "absorbed" not in narrow
    table = wide.split("Components that")[0].splitlines()
    approach, hold = (
        next(line for line in table if re.match(rf" *{number}  \w", line)) for number in (1, 2)
    )
    assert [sum(letter in BAR for letter in line) for line in (approach, hold)] == [10, 2]


def test_colours_say_nothing_that_is_not_in_the_text(assessment):
    for width in (80, 120):
        plain = render_assessment(assessment, paper=Paper(width))
        colored = render_assessment(assessment, paper=Paper(width, color=True))
        bare = "".join(f"{line.rstrip()}\n" for line in ANSI.sub("", colored).splitlines())
        assert bare == plain


def test_what_is_said_twice_is_printed_once(assessment):
    text = render_assessment(assessment, findings=["out of reach", "out of reach", "slipped"])
    assert text.count("- out of reach") == 1
    assert "- slipped" in text


def test_at_most_five_components_are_shown_the_greatest_first(assessment):
    text = render_assessment(assessment)
    assert "Components that matter most (5 of 6)" in text
    table = text.split("Components that matter most")[1].split("Assumptions")[0]
    shown = [line.split()[0] for line in table.splitlines() if line.startswith("component_")]
    # component_a is used in both functions: 1e-9 + 4e-9, level with component_e.
    assert shown[0] == "component_f"
    assert set(shown) == {f"component_{letter}" for letter in "acdef"}


def test_readings_of_one_figure_are_named_and_others_stand_side_by_side(assessment):
    once = replace(
        assessment,
        states=tuple(replace(each, expected_visits=1.0) for each in assessment.states),
    )
    assert "However repeats" not in render_assessment(once)
    lines = render_assessment(assessment).splitlines()
    text = "However repeats are counted, it is the same: geometric cycles, fixed cycles, as"
    assert text in " ".join(lines)
    mission = replace(assessment.mission, geometric_cycles=5e-8)
    text = render_assessment(replace(assessment, mission=mission))
    assert "Geometric cycles 5.00e-08; fixed cycles 2.50e-08; as executed 2.50e-08: they" in text


def test_findings_and_assumptions_of_caller_and_model_are_all_shown(assessment):
    text = render_assessment(
        assessment, findings=["pose out of reach"], assumptions=["per: visit breaks the law"]
    )
    findings, assumptions = text.split("Findings")[1].split("Assumptions")
    assert "pose out of reach" in findings
    assert "rest is never reached" in findings
    assert "per: visit breaks the law" in assumptions
    assert "geometric" in assumptions


def test_names_with_brackets_are_shown_as_they_are():
    state = series_state("[red]pick", 1, {"[bold]motor": 1e-6}, {"done": 1})
    model = HybridModel("m", state.name, (state,), (Parameter("[bold]motor", 1e-6),))
    text = render_assessment(solve(model))
    assert "[red]pick" in text
    assert "[bold]motor" in text


def test_output_depends_on_neither_environment_nor_repetition(assessment, monkeypatch):
    first = render_assessment(assessment)
    for name, value in {"COLUMNS": "40", "NO_COLOR": "1", "TERM": "dumb"}.items():
        monkeypatch.setenv(name, value)
    assert render_assessment(assessment) == first
    assert "\x1b[" not in first
    assert "\x1b[" in render_assessment(assessment, paper=Paper(color=True))


def test_importing_the_report_does_not_import_rich():
    code = "import sys, tracerisk.report.terminal; print('rich' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


def test_the_parts_of_a_group_with_a_common_cause_show_its_seconds(annotated_source):
    text = annotated_source(place=("done 1", "power = 1e-5 of2"))
    text = text.replace("redundancy = true", "redundancy = true, common_cause 0.1")
    found = tracerisk.solve(tracerisk.build({"cell.py": text.encode()}, name="cell.py"))
    table = render_assessment(found, exposures={"place": {"power": 12.34}})
    rows = [line for line in table.splitlines() if line.strip().startswith("power {")]
    assert len(rows) >= 2
    assert all("12.34" in row for row in rows[:2])


def test_of_very_many_functions_those_with_the_greatest_share_are_shown():
    states = tuple(
        series_state(
            f"step_{number}",
            number,
            {"arm": 1e-6 if number % 2 else 1e-9},
            {f"step_{number + 1}" if number < 400 else "done": 1},
        )
        for number in range(1, 401)
    )
    model = HybridModel("many", "step_1", states, (Parameter("arm", 1e-6),))
    shown = render_assessment(solve(model), paper=Paper(100))
    assert "Functions (200 of 400, those with the greatest share)" in shown
    assert "step_399" in shown
    assert "step_400" not in shown
