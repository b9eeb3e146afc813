from __future__ import annotations

import subprocess
import sys
from fractions import Fraction

import pytest

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
from tracerisk.report.terminal import render_assessment


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
    assert "active s" not in render_assessment(assessment)


def test_a_row_shows_sequence_components_top_visits_and_absorption(assessment):
    rows = [line.split() for line in render_assessment(assessment).splitlines()]
    assert ["2", "hold", "component_a", "1", "of", "1", "1.00e-09", "4", "4.00e-09"] in rows
    assert ["3", "rest", "(none)", "0.00e+00", "0", "0.00e+00"] in rows


def test_a_function_of_several_components_shows_its_figures_once(assessment):
    table = render_assessment(assessment).split("Mission")[0]
    rows = [line.split() for line in table.splitlines()]
    assert [row.count("2.10e-08") for row in rows if "2.10e-08" in row] == [2]
    assert ["component_f", "1", "of", "1"] in rows


def test_at_most_five_components_are_shown_the_greatest_first(assessment):
    text = render_assessment(assessment)
    assert "Components that matter most (5 of 6)" in text
    table = text.split("Components that matter most")[1]
    shown = [line.split()[0] for line in table.splitlines() if line.startswith("component_")]
    # component_a is used in both functions: 1e-9 + 4e-9, level with component_e.
    assert shown[0] == "component_f"
    assert set(shown) == {f"component_{letter}" for letter in "acdef"}


def test_the_three_mission_figures_stand_side_by_side(assessment):
    mission = render_assessment(assessment).split("Mission failure probability")[1]
    row = next(line for line in mission.splitlines() if "e-" in line)
    assert row.split()[:3] == ["2.50e-08", "2.50e-08", "2.50e-08"]


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
    assert "\x1b[" in render_assessment(assessment, color=True)


def test_importing_the_report_does_not_import_rich():
    code = "import sys, tracerisk.report.terminal; print('rich' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
