"""`solve` asked what if, how sure and what matters."""

import json
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace

import pytest

from tracerisk.cli import main

BLOCKS = """\
def pick():
    # | RiskAnnotation
    # | @Function {
    # |   name = pick
    # |   callSequence = 1
    # |   next = place 1
    # | }
    # | @Component {
    # |   name = gripper
    # |   probability = 1e-06
    # |   quantity = 1
    # |   redundancy = false
    # | }
    pass


def place():
    # | RiskAnnotation
    # | @Function {
    # |   name = place
    # |   callSequence = 2
    # |   next = done 1
    # | }
    # | @Component {
    # |   name = power
    # |   probability = 1e-03
    # |   quantity = 2
    # |   redundancy = true
    # | }
    pass
"""


@dataclass
class InProcess:
    """The command as `example.run` gives it, without a process for each call."""

    capsysbinary: pytest.CaptureFixture[bytes]

    def run(self, *arguments):
        code = main(arguments)
        out, err = self.capsysbinary.readouterr()
        return SimpleNamespace(code=code, out=out.decode(), err=err.decode())


@pytest.fixture
def model(tmp_path, monkeypatch, capsysbinary):
    monkeypatch.chdir(tmp_path)
    Path("controller.py").write_text(BLOCKS)
    command = InProcess(capsysbinary)
    assert command.run("build", "controller.py", "-o", "model.json").code == 0
    return command


@pytest.fixture(params=["controller.py", "model.json"])
def file(request):
    return request.param


def failure(outcome):
    return json.loads(outcome.out)["assessment"]["mission"]["failure_probability"]


def test_a_figure_is_set_in_a_model_and_in_blocks_alike(model, file):
    outcome = model.run("solve", file, "--set", "gripper=1e-3", "--set", "power=0.1", "--json")
    assert outcome.code == 0, outcome.err
    assert failure(outcome) == pytest.approx(1e-3 + 0.999 * 0.01, rel=1e-12)
    assert json.loads(outcome.out)["set"] == [
        {"name": "gripper", "before": 1e-6, "now": 1e-3},
        {"name": "power", "before": 1e-3, "now": 0.1},
    ]
    shown = model.run("solve", file, "--set", "gripper=1e-3").out
    assert shown.removeprefix("verdict unknown\n").startswith("Set, for what follows\n")
    assert ["gripper", "1e-06", "0.001"] in [line.split() for line in shown.splitlines()]


def test_the_risk_limit_is_held_against_what_was_set(model):
    assert model.run("solve", "model.json", "--max-failure-probability", "1e-5").code == 0
    assert (
        model.run(
            "solve", "model.json", "--max-failure-probability", "1e-5", "--set", "gripper=1e-4"
        ).code
        == 1
    )


def test_a_sweep_lists_the_mission_along_a_range(model, file):
    outcome = model.run("solve", file, "--sweep", "gripper=1e-6:1e-2:3", "--json")
    (sweep,) = json.loads(outcome.out)["sweeps"]
    assert (sweep["name"], sweep["before"]) == ("gripper", 1e-6)
    assert [point["value"] for point in sweep["points"]] == pytest.approx([1e-6, 1e-4, 1e-2])
    expected = [1 - (1 - p) * (1 - 1e-6) for p in (1e-6, 1e-4, 1e-2)]
    found = [point["mission"]["failure_probability"] for point in sweep["points"]]
    assert found == pytest.approx(expected, rel=1e-9)
    shown = model.run("solve", file, "--sweep", "gripper=1e-6:1e-2:3").out
    assert "Sweep of gripper (1e-06 in the model)" in shown
    assert ["0.01", "1.0001e-02", "1.0001e-02", "1.0001e-02"] in [
        line.split() for line in shown.splitlines()
    ]


def test_a_sweep_has_nine_points_and_goes_on_from_what_is_set(model):
    outcome = model.run(
        "solve", "model.json", "--set", "power=0.1", "--sweep", "gripper=1e-9:1e-5", "--json"
    )
    points = json.loads(outcome.out)["sweeps"][0]["points"]
    assert len(points) == 9
    assert points[0]["mission"]["failure_probability"] == pytest.approx(0.01, rel=1e-6)


def test_importance_shows_every_component_by_function_and_unit(model):
    lines = [
        line.split() for line in model.run("solve", "model.json", "--importance").out.splitlines()
    ]
    assert ["power", "place", "0.002", "1"] in lines
    assert ["power", "power[1]", "0.001", "0.5"] in lines


def test_pairs_show_what_components_do_together(model, file):
    (pair,) = json.loads(model.run("solve", file, "--pairs", "--json").out)["pairs"]
    assert (pair["first"], pair["second"]) == ("gripper", "power")
    assert pair["fussell_vesely"] == pytest.approx(1.0, rel=1e-12)
    # F = 1 - (1 - g)(1 - p^2): the mixed derivative is -2 p.
    assert pair["joint_birnbaum"] == pytest.approx(-2e-3, rel=1e-9)
    shown = [line.split() for line in model.run("solve", file, "--pairs").out.splitlines()]
    assert ["gripper", "power", "1"] in [line[:3] for line in shown]


def test_uncertainty_is_reported_with_the_share_of_each_component(model, file):
    call = ("solve", file, "--uncertainty", "--error-factor", "3", "--error-factor", "power=1.5")
    outcome = model.run(*call, "--samples", "2000", "--seed", "4", "--json")
    assert outcome.code == 0, outcome.err
    found = json.loads(outcome.out)["uncertainty"]
    assert (found["samples"], found["seed"], found["levels"]) == (2000, 4, [5.0, 50.0, 95.0])
    assert found["point"] == failure(outcome)
    assert found["percentiles"][0] < found["point"] < found["percentiles"][2]
    power = next(each for each in found["inputs"] if each["name"] == "power")
    assert power["percentiles"] == pytest.approx([1e-3 / 1.5, 1e-3, 1.5e-3], rel=1e-2)
    again = model.run(*call, "--samples", "2000", "--seed", "4", "--json")
    assert again.out == outcome.out
    shown = model.run(*call).out
    assert "Mission failure probability, 10000 samples, seed 0" in shown
    assert "Share of each input in that spread" in shown


def test_samples_that_are_cut_are_reported(model):
    call = ("--uncertainty", "--error-factor", "power=3", "--samples", "100")
    shown = model.run("solve", "model.json", "--set", "power=0.9", *call).out
    assert "samples above 1 were set to 1; is its error factor" in " ".join(shown.split())


def test_what_was_not_asked_for_is_not_in_the_json(model):
    data = json.loads(model.run("solve", "model.json", "--json").out)
    assert not {"set", "sweeps", "uncertainty", "pairs"} & set(data)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ["--set", "griper=1"],
            "no parameter 'griper' in 'controller.py'; did you mean 'gripper'?",
        ),
        (["--set", "gripper=2"], "--set gripper=2: 2 is not a probability; allowed: 0 to 1"),
        (["--set", "gripper=x"], "--set gripper=x: 'x' is not a number"),
        (["--set", "gripper"], "--set gripper: expected NAME=P, such as gripper=1e-6"),
        (["--set", "gripper=0", "--set", "gripper=1"], "--set names 'gripper' twice; set it once"),
        (["--sweep", "gripper=1e-6"], "--sweep gripper=1e-6: expected NAME=LOW:HIGH[:N]"),
        (["--sweep", "gripper=0:1"], "give 0 < LOW < HIGH, the steps are logarithmic"),
        (["--sweep", "gripper=.1:.01"], "give 0 < LOW < HIGH"),
        (["--sweep", "gripper=.1:2"], "2 is not a probability; allowed: 0 to 1"),
        (["--sweep", "gripper=.1:.2:1"], "'1' points; allowed: 2 to 10000"),
        (["--sweep", "gripper=.1:.2:many"], "'many' points; allowed: 2 to 10000"),
        (
            ["--sweep", "arm=.1:.2"],
            "no parameter 'arm' in 'controller.py'; allowed: gripper, power",
        ),
        (["--uncertainty"], "no parameter has a distribution"),
        (["--uncertainty", "--error-factor", "much"], "expected [NAME=]F, such as 3 or gripper=3"),
        (
            ["--uncertainty", "--error-factor", "0.5"],
            "error factor 0.5: allowed: finite numbers from 1",
        ),
        (["--uncertainty", "--error-factor", "arm=3"], "no parameter 'arm'"),
        (
            ["--uncertainty", "--error-factor", "3", "--error-factor", "4"],
            "--error-factor 4: every component has one; give it once",
        ),
        (
            ["--uncertainty", "--error-factor", "power=3", "--error-factor", "power=4"],
            "--error-factor power=4: power has one; give it once",
        ),
        (
            ["--uncertainty", "--error-factor", "3", "--samples", "1"],
            "1 samples; give at least 2",
        ),
        (["--seed", "3"], "--seed goes with --uncertainty; add it"),
        (["--samples", "3"], "--samples goes with --uncertainty; add it"),
        (["--error-factor", "3"], "--error-factor goes with --uncertainty; add it"),
    ],
)
def test_what_cannot_be_asked_is_reported(model, arguments, message):
    outcome = model.run("solve", "controller.py", *arguments, "--json")
    assert outcome.code == 2
    assert message in outcome.err
    assert message in json.loads(outcome.out)["error"]["message"]


def test_a_figure_is_set_by_a_factor_of_its_own(model):
    def found(*call):
        return json.loads(model.run("solve", "model.json", *call, "--json").out)

    before = found()["assessment"]["components"]
    theta = next(each["theta"] for each in before if each["name"] == "gripper")
    by_factor, by_value = found("--set", "gripper=x2.5"), found("--set", f"gripper={2.5 * theta!r}")
    assert by_factor["assessment"] == by_value["assessment"]
    for text, message in (("gripper=xx", "is not a number"), ("gripper=x1e12", "0 to 1")):
        outcome = model.run("solve", "model.json", "--set", text)
        assert outcome.code == 2
        assert message in outcome.err


HARDWARE = """\
components:
  gripper: {failure_rate: {value: 1e-6, per: hour}}
  power: {failure_rate: {value: 6e-8, per: minute}, active: always}
  arm:
    quantity: 7
    failure_rate: [{value: 1e-6, per: hour}, {value: 1e-7, per: hour}]
"""


@pytest.mark.parametrize(
    "words",
    [("gripper=x2.5",), ("gripper=1e-6",), ("gripper.rate=5e-7/h", "--hardware", "arm.yaml")],
)
def test_a_built_model_has_the_figures_that_were_set(example, annotated_source, words):
    example.write("cell.py", annotated_source(pick=("done 1", "gripper = 1e-7; power = 2e-7")))
    example.write("arm.yaml", HARDWARE)
    built = example.run("build", "cell.py", "--set", *words, "-o", "set.json")
    assert built.code == 0, built.err
    by_model = example.run("solve", "set.json", "--json").json["assessment"]
    asked = example.run("solve", "cell.py", "--set", *words, "--json").json["assessment"]
    assert by_model["mission"] == asked["mission"]
    plain = example.run("solve", "cell.py", "--json").json["assessment"]
    assert by_model["mission"] != plain["mission"]
    wrong = example.run("build", "cell.py", "--set", "grip=x2")
    assert wrong.code == 2
    assert "grip" in wrong.err


def test_a_figure_is_set_by_a_rate_beside_that_of_the_hardware_description(model):
    Path("arm.yaml").write_text(HARDWARE, encoding="utf-8")

    def found(*call):
        return json.loads(model.run("solve", "model.json", *call, "--json").out)["assessment"]

    for rate, factor in (
        ("gripper.rate=5e-7/h", "gripper=x0.5"),
        ("power.rate=7.2e-6/h", "power=x2"),
        ("power.rate=1.2e-7/min", "power=x2"),
    ):
        by_rate = found("--set", rate, "--hardware", "arm.yaml")["mission"]
        by_factor = found("--set", factor)["mission"]
        assert by_rate["failure_probability"] == pytest.approx(
            by_factor["failure_probability"], rel=1e-14
        )


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["gripper.rate=5e-7/h"], "say with --hardware FILE which rate it takes the place of"),
        (["gripper.rate=5e-7/d", "--hardware", "arm.yaml"], "'d' is not a unit of time; allowed"),
        (["gripper.rate=-1/h", "--hardware", "arm.yaml"], "the rate -1 is not one of 0 or more"),
        (
            ["grip.rate=1/h", "--hardware", "arm.yaml"],
            "no component 'grip'; did you mean 'gripper'",
        ),
        (["arm.rate=1/h", "--hardware", "arm.yaml"], "'arm' has not one figure per time"),
        (
            ["gripper=1e-6", "--set", "gripper.rate=1e-9/h", "--hardware", "arm.yaml"],
            "--set names 'gripper' twice",
        ),
        (["gripper=1e-6", "--hardware", "arm.yaml"], "--hardware goes with --uncertainty; add it"),
    ],
)
def test_what_is_no_rate_is_reported(model, arguments, message):
    Path("arm.yaml").write_text(HARDWARE, encoding="utf-8")
    outcome = model.run("solve", "model.json", "--set", *arguments)
    assert outcome.code == 2
    assert message in outcome.err
