"""`tracerisk sweep`: every combination is run once, and nothing but the cache is written."""

import xml.etree.ElementTree as ET

import pytest

from tests.commands import ForkedWorkers
from tracerisk import api
from tracerisk.common.campaign import CampaignOptions
from tracerisk.common.text.paper import Paper
from tracerisk.errors import InputError
from tracerisk.pipeline.evidence.sweep import Factor, SweepPoint, parse_factor
from tracerisk.report.series.sweep import csv_text, plot_svg, render_points

SWEEP = (
    "sweep",
    "controller.py",
    "--over",
    "mission_cycles=5,10",
    "--over",
    "active=moving",
    "-j1",
)


@pytest.fixture(scope="module")
def swept(tmp_path_factory, example_in):
    from tests.conftest import quick_controller

    folder = example_in(tmp_path_factory.mktemp("sweep"))
    folder.write("controller.py", quick_controller())
    folder.write(
        "cell.yaml", "objects:\n  - {name: cup, box: [0.1, 0.1, 0.1], xyz: [2, 2, 0.05]}\n"
    )
    folder.write("pyproject.toml", '[tool.tracerisk]\nscenario = "cell.yaml"\n')
    before = folder.files()
    return folder, before, folder.run(*SWEEP, "--json")


def test_every_combination_has_its_figure(swept):
    folder, before, outcome = swept
    assert outcome.code == 0, outcome.err
    points = outcome.json["points"]
    assert [each["values"] for each in points] == [
        {"mission_cycles": 5, "active": "moving"},
        {"mission_cycles": 10, "active": "moving"},
    ]
    assert all(0.0 < each["failure_probability"] < 1e-6 for each in points)
    assert {each["verdict"] for each in points} == {"partial"}
    assert folder.files() == before


def test_points_whose_inputs_are_the_same_are_not_run_again(swept, monkeypatch):
    folder, _, _ = swept
    from tracerisk.pipeline.evidence import sweep

    monkeypatch.setattr(sweep, "run_point", None)
    found = api.sweep(
        folder.folder / "controller.py", {"mission_cycles": [5, 10], "active": ["moving"]}
    )
    assert len(found) == 2


def test_a_changed_source_is_run_again(swept, tmp_path, example_in):
    import shutil

    folder = example_in(tmp_path / "changed")
    shutil.copytree(swept[0].folder, folder.folder)
    text = folder.read("controller.py").decode().replace("0.", "0.0", 1)
    folder.write("controller.py", text + "\nCHANGED = 1\n")
    calls = []

    class Refusing:
        def submit(self, function, *arguments):
            calls.append(arguments)
            raise InputError("not now")

    with pytest.raises(InputError, match="not now"):
        api.sweep(
            folder.folder / "controller.py",
            ["mission_cycles=5,10", "active=moving"],
            options=CampaignOptions(executor=Refusing()),
        )
    assert calls


def test_the_scenario_and_parameters_are_varied(swept, monkeypatch):
    folder, _, _ = swept
    from tracerisk.pipeline.evidence import workers

    over = ["scenario:objects.cup.xyz=0", "param:/speed=0.5"]
    with pytest.raises(InputError, match=r"scenario:objects.mug"):
        api.sweep(folder.folder / "controller.py", ["scenario:objects.mug.mass=1"])
    monkeypatch.setattr(workers, "_CONTEXT", ForkedWorkers())
    (point,) = api.sweep(folder.folder / "controller.py", over, options=CampaignOptions(jobs=1))
    # The scenario of the point is refused by its own reader.
    assert "xyz" in point.error
    (point,) = api.sweep(
        folder.folder / "controller.py",
        ["scenario:objects.0.name=mug", "param:/speed=0.5"],
        options=CampaignOptions(jobs=1),
    )
    assert point.failure_probability is not None


@pytest.mark.parametrize(
    ("text", "factor"),
    [
        ("seed=0,1,2", Factor("seed", (0, 1, 2))),
        ("seed=3..5", Factor("seed", (3, 4, 5))),
        ("param:/v=0.5,true,fast", Factor("param:/v", (0.5, True, "fast"))),
    ],
)
def test_values_are_read_as_they_are_written(text, factor):
    assert parse_factor(text) == factor


@pytest.mark.parametrize(
    ("over", "message"),
    [
        (["seed"], "expected NAME=VALUE"),
        (["seed=5..1"], "below the first"),
        (["sed=1"], "did you mean 'seed'"),
        (["seed=1", "seed=2"], "varied twice"),
        (["seed=x"], "is no number"),
        ([], "nothing is varied"),
        (["seed=0..9999", "mission_cycles=1,2"], "at most"),
        (["scenario:nothing.x=1"], "there is no 'nothing'"),
    ],
)
def test_what_cannot_be_varied_is_said(swept, over, message):
    with pytest.raises(InputError, match=message):
        api.sweep(swept[0].folder / "controller.py", over)


POINTS = (
    SweepPoint({"seed": 0, "robot": "a"}, 1e-6, "complete", 10.0, "motor", 0.9),
    SweepPoint({"seed": 1, "robot": "a"}, 2e-5, "faulted", 12.0, "motor", 0.8),
    SweepPoint({"seed": 0, "robot": "b"}, None, "stuck", 3.0, error="it hangs"),
)


def test_a_point_whose_run_raised_says_what(example, quick):
    example.write("controller.py", quick().replace("panda_arm", "other_arm"))
    outcome = example.run("sweep", "controller.py", "--over", "robot=panda", "-j1", "--json")
    (point,) = outcome.json["points"]
    assert "other_arm" in point["error"]
    assert point["failure_probability"] is None


def test_a_point_without_a_figure_says_why():
    text = render_points(POINTS, paper=Paper(100))
    assert "none" in text
    assert "it hangs" in text
    assert "faulted" in text
    rows = csv_text(POINTS).splitlines()
    assert rows[0] == "seed,robot,failure_probability,verdict,simulated_s,leading,share,error"
    assert rows[3] == "0,b,,stuck,3.0,,0.0,it hangs"


def test_the_drawing_is_whole_and_marks_what_went_wrong():
    root = ET.fromstring(plot_svg(POINTS))
    circles = [each for each in root.iter() if each.tag.endswith("circle")]
    assert [each.get("fill") == "white" for each in circles] == [False, True]
    assert "no point has a figure" in plot_svg(POINTS[2:])
    assert "1e-06" in plot_svg(POINTS)
