"""The instances of a run, from the trace to the lock, the table and the errors."""

import json
import math

import pytest

PANDA = """\
robot: panda
components:
  electric_motor:
    probability: {value: 9.5e-08, per: minute, source: assumed for the test}
    quantity: 7
    twin: {joints: "*"}
"""


@pytest.fixture
def annotated(short_run, example):
    """The sample, annotated from the trace of its run with motors only."""
    run, _ = short_run
    for name in ("trace.json", "pick_and_place.py", "tracerisk.lock"):
        example.write(name, run.read(name))
    example.write("hardware.yaml", PANDA)
    options = ("pick_and_place.py", "--trace", "trace.json", "--hardware", "hardware.yaml")
    assert example.run("annotate", *options).code == 0
    return example, options


def test_the_run_reports_every_instance(short_run):
    _, outcome = short_run
    instances = outcome.json["instances"]
    motors = [each for each in instances if each["component"] == "electric_motor"]
    assert len(motors) == 7
    assert math.fsum(each["share"] for each in motors) == pytest.approx(1.0, rel=1e-12)
    component = next(
        each
        for each in outcome.json["assessment"]["components"]
        if each["name"] == "electric_motor"
    )
    total = math.fsum(each["fussell_vesely"] for each in motors)
    assert total == pytest.approx(component["fussell_vesely"], rel=1e-9)
    # Shipped figures of the published study are not assumed.
    assert outcome.json["assumed_figures"] == []


def test_the_lock_holds_the_instances_of_each_function(short_run):
    run, outcome = short_run
    lock = json.loads(run.read("tracerisk.lock"))
    functions = lock["controllers"]["pick_and_place.py"]["trace"]["functions"]
    held = functions["place_position"]["instances"]["electric_motor"]
    reported = {
        each["instance"]: each["per_visit"]["place_position"]
        for each in outcome.json["instances"]
        if each["component"] == "electric_motor"
    }
    assert held == pytest.approx(reported, rel=1e-3)
    assert held == {name: float(f"{value:.4g}") for name, value in reported.items()}


def test_a_redundancy_by_hand_over_motors_that_differ_stops_annotate_and_check(annotated):
    example, options = annotated
    source = example.read("pick_and_place.py").decode()
    before, found, after = source.partition("redundancy = false")
    assert found
    line = before.count("\n") + 1
    pinned = f"{before}redundancy := required 6  ! computed false; one may fail{after}"
    example.write("pick_and_place.py", pinned)
    outcome = example.run("annotate", *options)
    assert outcome.code == 2
    assert f"pick_and_place.py:{line}: function 'init', component 'electric_motor'" in outcome.err
    assert "'redundancy := required 6' is set for units that differ (panda_joint" in outcome.err
    assert example.read("pick_and_place.py").decode() == pinned
    checked = example.run("check", "pick_and_place.py", "--json")
    kinds = [each["kind"] for each in json.loads(checked.out)["findings"]]
    assert checked.code == 1
    assert "unequal" in kinds


def test_a_redundancy_by_hand_is_unfounded_before_any_refresh_wrote_what_is_computed(annotated):
    example, _ = annotated
    source = example.read("pick_and_place.py").decode()
    example.write("pick_and_place.py", source.replace("redundancy = false", "redundancy := true"))
    checked = example.run("check", "pick_and_place.py", "--json")
    found = [each for each in json.loads(checked.out)["findings"] if each["kind"] == "unequal"]
    assert checked.code == 1
    assert "function 'init', component 'electric_motor'" in found[0]["message"]
    assert all("holds only with 'redundancy = false'" in each["message"] for each in found)
    refreshed = example.run("refresh", "pick_and_place.py", "--check")
    assert (refreshed.code, "is set for units that differ" in refreshed.err) == (2, True)
    told = example.run("report", "pick_and_place.py", "--dossier", "out.zip")
    assert (told.code, "unequal: function 'init'" in told.err) == (1, True)
    assert not (example.folder / "out.zip").exists()
