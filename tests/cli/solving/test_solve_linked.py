"""`solve` of a linked model."""

import json
from pathlib import Path
from types import SimpleNamespace

import pytest

from tracerisk.cli import main

MODEL = {
    "schema": "tracerisk-linked-model",
    "version": 1,
    "name": "cell",
    "systemMissionTime": 8.0,
    "modelData": [
        {"name": "motor", "value": 1e-3},
        {
            "name": "rate",
            "value": 1e-2,
            "unit": "hour-1",
            "distribution": {"lognormal": {"errorFactor": 2.0}},
        },
    ],
    "faultTrees": [
        {
            "name": "pick",
            "topEvent": "fails",
            "gates": [{"name": "fails", "type": "or", "inputs": ["motor", "valve"]}],
            "events": [
                {"name": "motor", "type": "basic", "value": {"parameter": "motor"}},
                {
                    "name": "valve",
                    "type": "basic",
                    "value": {"occupancy": {"markovChain": "valve", "states": ["stuck"]}},
                },
            ],
        }
    ],
    "markovChains": [
        {
            "name": "valve",
            "time": "continuous",
            "initialState": "free",
            "transitions": [{"source": "free", "target": "stuck", "rate": {"parameter": "rate"}}],
        },
        {
            "name": "mission",
            "initialState": "pick",
            "transitions": [
                {"source": "pick", "target": "failed", "probability": {"topEvent": "pick"}},
                {"source": "pick", "target": "pick", "remainder": "1/2"},
                {"source": "pick", "target": "done", "remainder": "1/2"},
            ],
        },
    ],
    "figures": [
        {
            "name": "failure",
            "value": {"absorption": {"markovChain": "mission", "states": ["failed"]}},
        },
        {"name": "stuck", "value": {"occupancy": {"markovChain": "valve", "states": ["stuck"]}}},
    ],
}


@pytest.fixture
def solve(tmp_path, monkeypatch, capsysbinary):
    monkeypatch.chdir(tmp_path)
    Path("cell.json").write_text(json.dumps(MODEL, indent=1))

    def run(*arguments, file="cell.json"):
        code = main(["solve", file, *arguments])
        out, err = capsysbinary.readouterr()
        return SimpleNamespace(code=code, out=out.decode(), err=err.decode())

    return run


def expected_failure(motor=1e-3, rate=1e-2):
    """p / (1 - (1-p)/2) with p = motor or valve."""
    import math

    p = 1 - (1 - motor) * math.exp(-8.0 * rate)
    return p / (1 - (1 - p) / 2)


def test_the_figures_are_printed_and_given_as_json(solve):
    data = json.loads(solve("--json").out)
    assert data["model"] == "cell"
    assert data["figure"] == "failure"
    assert data["figures"]["failure"] == pytest.approx(expected_failure(), rel=1e-12)
    assert data["parameters"] == {"motor": 1e-3, "rate": 1e-2}
    lines = [line.split() for line in solve().out.splitlines()]
    assert ["failure", f"{expected_failure():.6e}"] in lines
    assert ["stuck", "7.688365e-02"] in lines


def test_parameters_are_set_and_swept_rates_above_one_too(solve):
    outcome = solve("--set", "motor=0.1", "--sweep", "rate=0.01:4:3", "--json")
    data = json.loads(outcome.out)
    assert data["set"] == [{"name": "motor", "before": 1e-3, "now": 0.1}]
    (sweep,) = data["sweeps"]
    assert [point["value"] for point in sweep["points"]] == pytest.approx([0.01, 0.2, 4.0])
    assert [point["figures"]["failure"] for point in sweep["points"]] == pytest.approx(
        [expected_failure(0.1, rate) for rate in (0.01, 0.2, 4.0)], rel=1e-12
    )
    shown = solve("--sweep", "rate=0.01:4:3", "--figure", "stuck").out
    assert "stuck along rate" in shown
    assert ["0.01", "7.688365e-02"] in [line.split() for line in shown.splitlines()]


def test_importance_is_of_the_figure_that_is_asked_about(solve):
    data = json.loads(solve("--importance", "--figure", "stuck", "--json").out)
    assert data["figure"] == "stuck"
    rate, motor = data["importance"]
    assert (rate["name"], motor["name"]) == ("rate", "motor")
    assert (motor["birnbaum"], motor["fussell_vesely"], motor["risk_reduction_worth"]) == (0, 0, 1)
    # Without the rate the valve never sticks: an infinite worth, which JSON has not.
    assert rate["fussell_vesely"] == pytest.approx(1.0, rel=1e-14)
    assert rate["risk_reduction_worth"] is None
    shown = solve("--importance", "--figure", "stuck").out
    assert "Importance for stuck" in shown
    assert ["motor", "0", "0", "0", "1", "1", "1"] in [line.split() for line in shown.splitlines()]


def test_uncertainty_takes_the_distributions_of_the_model_and_of_the_call(solve):
    call = ("--uncertainty", "--samples", "1000", "--error-factor", "3")
    found = json.loads(solve(*call, "--json").out)["uncertainty"]
    inputs = {each["name"]: each for each in found["inputs"]}
    assert inputs["motor"]["percentiles"][2] == pytest.approx(3e-3, rel=2e-2)
    # The model's own error factor of 2 stays.
    assert inputs["rate"]["percentiles"][2] == pytest.approx(2e-2, rel=2e-2)
    assert "failure, 1000 samples, seed 0" in solve(*call).out


def test_the_limit_is_held_against_the_figure(solve):
    assert solve("--max-failure-probability", "0.5").code == 0
    outcome = solve("--max-failure-probability", "0.1")
    assert outcome.code == 1
    assert "tracerisk: failure 0.1" in outcome.err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--figure", "stick"], "--figure stick: no figure of 'cell'; did you mean 'stuck'?"),
        (["--set", "motr=1"], "no parameter 'motr' in 'cell'; did you mean 'motor'?"),
        (["--set", "motor=inf"], "--set motor=inf: inf is not finite; give a number"),
        (["--set", "motor=much"], "--set motor=much: 'much' is not a number"),
        (
            ["--set", "motor=2"],
            "fault tree 'pick', event 'motor': probability 2.0 is outside [0, 1]",
        ),
        (["--sweep", "motr=1:2"], "no parameter 'motr'"),
        (["--profile", "a:b=1"], "--profile goes with sources; a linked model has its own chains"),
        (["--pairs"], "--pairs goes with models of functions; leave it out"),
        (["--uncertainty", "--error-factor", "motr=2"], "no parameter 'motr'"),
    ],
)
def test_what_cannot_be_asked_is_reported(solve, arguments, message):
    outcome = solve(*arguments)
    assert outcome.code == 2
    assert message in outcome.err


def test_a_model_without_figures_and_a_broken_one_are_refused(solve):
    Path("none.json").write_text(json.dumps({**MODEL, "figures": []}))
    assert "'cell' has no figures; state one in the model" in solve(file="none.json").err
    Path("cut.json").write_text(json.dumps(MODEL)[:300])
    outcome = solve(file="cut.json")
    assert outcome.code == 2
    assert "cut.json:1:301: is not valid JSON" in outcome.err


def test_a_figure_is_of_linked_models_only(solve):
    Path("controller.py").write_text("# | no block\n")
    assert "--figure goes with a linked model" in solve("--figure", "x", file="controller.py").err
