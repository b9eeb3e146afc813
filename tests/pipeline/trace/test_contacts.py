"""Collisions of a run: the shipped table with all that stands on it as it is, and 10 cm higher."""

import json
import re

import pytest

from tracerisk.common import trace_json
from tracerisk.common.traced.findings import NOTES
from tracerisk.trace import Trace
from tracerisk.twin.physics.scene import SHIPPED_SCENES

RAISED = 0.1


def raised_table() -> str:
    """The shipped scene with its table raised by 10 cm: the racks now stand within it."""
    text = (SHIPPED_SCENES / "tube_racks.yaml").read_text(encoding="utf-8")
    table = "xyz: [0.35, 0.0, -0.02]"
    assert text.count(table) == 1
    return text.replace(table, f"xyz: [0.35, 0.0, {RAISED - 0.02}]").replace(
        "name: tube_racks", "name: raised_table", 1
    )


@pytest.fixture(scope="module")
def raised(tmp_path_factory, example_in, pick_and_place):
    """One run of the sample, of one tube, at the raised table; it is told to fail on findings."""
    example = example_in(tmp_path_factory.mktemp("raised"))
    example.write("scene.yaml", raised_table())
    example.write("pick.py", pick_and_place.replace(b"TUBES = 10", b"TUBES = 1"))
    outcome = example.run(
        "run", "pick.py", "--scene", "scene.yaml", "--trace", "trace.json", "--fail-on", "finding",
        "--sarif", "run.sarif",
    )  # fmt: skip
    return example, outcome


@pytest.fixture(scope="module")
def trace(raised) -> Trace:
    example, _ = raised
    return trace_json.loads(example.read("trace.json").decode(), "trace.json")


def test_a_raised_table_is_hit_and_the_run_says_function_bodies_force_and_time(raised):
    _, outcome = raised
    lines = " ".join(outcome.out.split())
    reported = re.search(
        r"pick\.py:\d+: unexpected contact: panda_rightfinger touches table in pick: "
        r"up to (\d+) N, ([\d.]+) s \(at ([\d.]+) s\)",
        lines,
    )
    assert reported is not None, lines
    force, seconds, start = map(float, reported.groups())
    assert 50.0 < force < 5000.0
    assert 1.0 < seconds < 10.0
    assert 3.0 < start < 6.0


def test_findings_fail_a_run_only_where_it_is_asked_for(raised):
    example, failed = raised
    assert failed.code == 1
    assert re.search(r"tracerisk: \d+ findings, and --fail-on finding", failed.err)
    fine = example.run("run", "pick.py", "--scene", "scene.yaml", "--check")
    # The motion that the table ends makes the run faulted, whatever findings do.
    assert fine.code == 1, fine.err
    assert fine.out.startswith("faulted: a motion was aborted")
    assert "--fail-on" not in fine.err
    assert "unexpected contact: " in fine.out


@pytest.mark.slow
def test_a_project_can_settle_what_a_run_fails_on(raised, example):
    before, _ = raised
    for name in ("scene.yaml", "pick.py"):
        example.write(name, before.read(name))
    example.write("pyproject.toml", '[tool.tracerisk]\nfail_on = "unexpected_contact"\n')
    outcome = example.run("run", "pick.py", "--scene", "scene.yaml", "--json")
    assert outcome.code == outcome.json["exit_code"] == 1
    assert "and --fail-on unexpected_contact" in outcome.err
    checked = example.run("check", "pick.py", "--json")
    assert checked.code == 1
    kinds = {each["kind"] for each in checked.json["findings"]}
    assert kinds == {"contact", "faulted"}
    reported = [each["message"] for each in checked.json["findings"]]
    assert "panda_rightfinger and table touched in pick, which was not to be expected" in reported


def test_a_check_alerts_of_the_contacts_of_the_last_run_as_the_run_does(raised):
    example, _ = raised
    checked = example.run("check", "pick.py", "--sarif", "check.sarif")
    assert checked.code == 1, "the run is faulted: a motion was aborted"
    assert "contact: " not in checked.out, "no setting says that a finding fails"
    ran, kept = (
        {
            each["partialFingerprints"]["tracerisk/v1"]: each["locations"]
            for each in json.loads(example.read(name))["runs"][0]["results"]
            if each["ruleId"] == "unexpected-contact"
        }
        for name in ("run.sarif", "check.sarif")
    )
    assert len(ran) > 2
    assert ran == kept
    lock = json.loads(example.read("tracerisk.lock"))["controllers"]["pick.py"]["trace"]
    assert ["panda_rightfinger", "table"] in lock["unexpected_contacts"]["pick.py"]["pick"]


def test_the_findings_are_those_of_the_contacts_one_for_each_function_and_pair(trace):
    found = [finding for finding in trace.findings if finding.kind == "unexpected_contact"]
    unexpected = {
        (visit.function.name, contact.link, contact.other): visit.function
        for visit in trace.visits
        for contact in visit.contacts
        if not contact.expected
    }
    assert len(found) == len(unexpected) > 2
    assert not NOTES & {"unexpected_contact"}
    for function, link, other in unexpected:
        (finding,) = [
            each
            for each in found
            if re.search(
                rf": {link}(, which is held,)? touches {other} in {function}:", each.message
            )
        ]
        starts = [
            contact.start_s
            for visit in trace.visits
            if visit.function.name == function
            for contact in visit.contacts
            if (contact.link, contact.other, contact.expected) == (link, other, False)
        ]
        assert finding.time_s == min(starts)
    assert [each.time_s for each in trace.findings] == sorted(
        each.time_s for each in trace.findings
    )


def test_what_presses_where_a_motion_was_aborted_is_an_unexpected_contact(trace):
    """The stepping core tells of its own what holds the arm back: another way to the same."""
    pressed = {
        tuple(re.findall(r"'(\w+)' presses on '(\w+)'", finding.message)[0])
        for finding in trace.findings
        if "presses on" in finding.message
    }
    hit = {
        (contact.link, contact.other)
        for visit in trace.visits
        for contact in visit.contacts
        if not contact.expected
    }
    assert pressed
    assert pressed <= hit


def test_where_nothing_is_in_the_way_every_contact_is_expected(short_run, short_trace):
    _, outcome = short_run
    contacts = [contact for visit in short_trace.visits for contact in visit.contacts]
    assert len(contacts) > 10
    assert all(contact.expected for contact in contacts)
    assert not any(finding["kind"] not in NOTES for finding in outcome.json["trace"]["findings"])


def test_each_tube_is_touched_by_both_fingers_and_by_its_racks_alone(short_trace):
    pairs = {
        (contact.link.rstrip("_0123456789"), contact.other.rstrip("_0123456789"))
        for visit in short_trace.visits
        for contact in visit.contacts
    }
    assert pairs == {
        ("panda_leftfinger", "tube"),
        ("panda_rightfinger", "tube"),
        ("tube", "source_rack"),
        ("tube", "target_rack"),
    }


def test_a_finger_touches_for_as_long_as_its_contacts_do(short_trace):
    """Contact elements count from 0.5 N on and over short gaps: all but the same time."""
    for finger in ("panda_leftfinger", "panda_rightfinger"):
        exposure = short_trace.active[finger]
        touching = sum(
            contact.touching_s
            for visit in short_trace.visits
            for contact in visit.contacts
            if contact.link == finger
        )
        assert exposure.grasping_s == exposure.active_s == pytest.approx(touching, rel=0.02)
        assert exposure.grasps == exposure.releases == 2
