"""All that must hold for a figure stands on one page of its dossier."""

import re
from dataclasses import replace

import pytest

from tracerisk.adder.blocks.override import Override
from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.common.hardware.formats import load_hardware
from tracerisk.common.hardware.shipped import hardware_of
from tracerisk.common.traced.elements import Payload
from tracerisk.common.verdict import Reason, Verdict
from tracerisk.config import Settings
from tracerisk.errors import Location
from tracerisk.pipeline.dossier.assumptions import GENERAL, assumptions
from tracerisk.prm import FaultTree, HybridModel, solve
from tracerisk.report.html.report_input import ReportInput
from tracerisk.trace import RunEnd, Trace, Visit

HARDWARE = """\
components:
  gear:
    mttfd: {value: 400000, unit: hour, dangerous: 0.5,
            temperature: {rated: 40, working: 55, activation_energy: 0.7}}
    load_law: {reference_load: 0.4, wearing_share: 0.6}
    quantity: 2
    redundancy: true
    common_cause: {beta: 0.05}
    twin: {joints: ["joint_1", "joint_2"]}
  unused: {failure_rate: {value: 1e-9, per: hour}, active: always}
"""


@pytest.fixture(scope="module")
def report():
    tree = FaultTree.of("pick fails", {"pick fails": ("or", "gear")}, {"gear": 1e-8})
    model = HybridModel.of("arm.py", {"pick": tree})
    return ReportInput(assessment=solve(model), model=model)


def section(text, title):
    return text.partition(f"## {title}\n\n")[2].partition("\n\n## ")[0].rstrip("\n")


def test_the_assumptions_of_all_figures_close_it(report):
    title = "Assumptions of all figures"
    listed = assumptions(report, {}).partition(f"## {title}\n\n")[2].partition("\n\n## ")[0]
    listed = listed.splitlines()[2:]
    assert len(listed) == len(GENERAL)
    for line, (assumption, effect) in zip(listed, GENERAL, strict=True):
        assert line == f"- {assumption}. If wrong: {effect}"


def test_every_setting_that_is_not_the_default_is_on_it(report):
    title = "Settings that are not the default"
    assert section(assumptions(report, {}), title) == "None."
    text = assumptions(report, {"active": "moving", "mission_cycles": 3})
    assert section(text, title) == "- `active`: moving\n- `mission_cycles`: 3"


def test_every_accepted_reason_is_on_it_with_its_words(report):
    reason = Reason("no-answer", "partial", "no one answers", accepted="it is so")
    shown = replace(report, verdicts={"arm": Verdict("complete", (reason,))})
    assert section(assumptions(shown, {}), "Accepted reasons") == (
        "- partial: no one answers; accepted with the words: it is so"
    )
    assert section(assumptions(report, {}), "Accepted reasons") == "None."


@pytest.fixture
def described(report, tmp_path):
    (tmp_path / "cell.yaml").write_text(HARDWARE)
    hardware = load_hardware(Settings(hardware=str(tmp_path / "cell.yaml")), "panda")
    return replace(report, hardware=hardware)


def test_what_the_data_of_a_component_assume_is_on_it(described):
    assert [
        line for line in assumptions(described, {}).splitlines() if line.startswith("- gear: ")
    ] == [
        "- gear: 50 % of its failures are dangerous, so that all are 2 times those of the data "
        "sheet",
        "- gear: it works at 55 degC, where its rate is 3.273 times that at 40 degC, by "
        "Arrhenius' law with 0.7 eV",
        "- gear: 5 % of the failures of a unit have a cause that fails all units",
        "- gear: 60 % of its failures come from wear, and grow with load to the power of 3, "
        "above 40 % of the rated torque (`reference_load`): below it they count for less",
    ]
    assert "unused: " not in assumptions(described, {})


def test_what_else_makes_the_figure_of_a_component_smaller_is_on_it(report, tmp_path):
    text = HARDWARE.replace(
        "    common_cause: {beta: 0.05}\n", "    spare: warm\n    dormancy: 0.1\n"
    )
    text = text.replace("wearing_share: 0.6", "wearing_share: 0.6, reference_speed: 0.5")
    text = text.replace(
        "    quantity", "    modes: {jam: {fraction: 0.4, when: [moving]}}\n    quantity"
    )
    (tmp_path / "cell.yaml").write_text(text)
    hardware = load_hardware(Settings(hardware=str(tmp_path / "cell.yaml")), "panda")
    page = assumptions(replace(report, hardware=hardware), {})
    for words in (
        "its wear is that of a motion at 50 % of the rated speed",
        "a spare fails 0.1 times as often before it is needed as a unit at work",
        "some of its failures count in certain uses alone: jam (40 %) moving",
    ):
        assert f"- gear: {words}" in page


def test_the_masses_of_what_was_carried_are_on_it(report):
    held = Payload("panda_hand", "tube", 0.004, 2.0, 1.0, 2.0)
    ref = FunctionRef("arm.py", QualifiedName("pick"))
    visit = Visit(ref, 0.0, 2.0, "done", {}, (held,))
    trace = Trace("arm.py", "panda", "cell", RunEnd("ended", "it returned", 1.0), (), (), (visit,))
    page = assumptions(replace(report, trace=trace), {})
    assert "- what was carried has the mass that the scene gives it: tube 0.004 kg" in page


def test_a_redundant_pair_without_a_common_cause_is_named(report, tmp_path):
    for common_cause, is_named in (("    common_cause: {beta: 0.05}\n", False), ("", True)):
        text = HARDWARE.replace("    common_cause: {beta: 0.05}\n", common_cause)
        (tmp_path / "cell.yaml").write_text(text)
        hardware = load_hardware(Settings(hardware=str(tmp_path / "cell.yaml")), "panda")
        page = assumptions(replace(report, hardware=hardware), {})
        assert ("- gear: no common cause is stated" in page) is is_named


def test_sensors_that_are_listed_by_name_are_of_their_kind(report, tmp_path):
    """They are no kind that the shipped description has, and this one lacks."""
    (tmp_path / "cell.yaml").write_text(
        "components:\n  encoder: {failure_rate: {value: 1e-6, per: hour}, "
        "twin: {sensors: [panda_joint1/encoder]}}\n"
    )
    hardware = load_hardware(Settings(hardware=str(tmp_path / "cell.yaml")), "panda")
    trace = Trace("arm.py", "panda", "empty", RunEnd("ended", "it returned", 1.0), (), (), ())
    page = assumptions(replace(report, hardware=hardware, trace=trace), {})
    assert "it lists encoder sensors: encoder\n" in page
    assert "- encoder sensors: the description that is shipped" not in page


@pytest.mark.parametrize(
    ("field", "words"),
    [
        ("pick.encoder.probability", "the hardware description does not have it"),
        ("pick.gear.probability", "the run does not use it there"),
    ],
)
def test_a_pin_that_alone_keeps_its_component_is_named(described, field, words):
    pin = Override("value", field, "2e-09", Location("arm.py", 3))
    listed = section(assumptions(replace(described, pins=(pin,)), {}), "Values set by hand")
    assert listed == (
        f"- arm.py:3: {field} := 2e-09, computed nothing, as {words} (the pin alone keeps it); "
        "no reason is given"
    )


def test_parts_that_only_the_shipped_description_has_are_named(described):
    trace = Trace("arm.py", "panda", "empty", RunEnd("ended", "it returned", 1.0), (), (), ())
    text = assumptions(replace(described, trace=trace), {})
    assert "- what the hardware description does not list never fails, " in text
    assert "; it lists joints: gear; always in use: unused\n" in text
    assert (
        "- always in use: the description that is shipped for panda has power_system, "
        "control_system, and this one has unused\n"
    ) in text
    assert "- gripper: the description that is shipped for panda has gripper, and this" in text
    assert described.hardware.file not in text  # another folder gives the same page
    assert "- joints: " not in text
    assert "is shipped for" not in assumptions(
        replace(described, trace=trace, hardware=hardware_of("panda")), {}
    )


MIDDLE = """\
while True:
    reach()
    if done():
        break
    place()
"""
ENDS = """\
while True:
    reach()
    for part in parts:
        break
    if done():
        break
"""


@pytest.mark.parametrize(
    ("source", "met"),
    [
        (MIDDLE, "K1"),
        (ENDS, ""),
        ("import os\nos.path.exists('a')\n", "K2"),
        ("from pathlib import Path\nPath('a').glob('*')\n", "K2"),
        ("import subprocess\nsubprocess.run(['cat', 'a'])\n", "K2"),
        ("import os\nos.stat('a')\n", "K2"),
        ("import ctypes\nctypes.CDLL(None).fopen(b'a', b'r')\n", "K2"),
        ("data = open('/opt/cell/slots.json').read()\n", "K2"),
        ("# os.path.exists('a')\nopen('a')\n", ""),
        ("print 1\n", ""),
    ],
)
def test_lines_that_may_meet_a_known_anomaly_are_named(report, source, met):
    text = assumptions(report, {}, {"arm.py": source.encode(), "notes.yaml": b"{"})
    lines = text.partition("## Known anomalies\n\n")[2].splitlines()[2:]
    assert [line[2:4] for line in lines] == ["K1", "K2"]
    for line in lines:
        if line[2:4] == met:
            assert re.search(r": look at arm\.py:[12]$", line)
        else:
            assert line.endswith(": no such line was found in `files/`, which proves nothing")


@pytest.mark.parametrize(
    ("source", "lines"),
    [
        (b'import os\nTUBES = int(os.environ.get("TUBES", "1"))\n', "arm.py:2"),
        (b'from os import getenv\n\nTUBES = getenv("TUBES")\n', "arm.py:3"),
        (b"TUBES = 10\n", None),
    ],
)
def test_lines_that_read_the_environment_are_named(report, source, lines):
    text = assumptions(report, {}, {"arm.py": source})
    said = f"the controller reads environment variables ({lines}): one that the setting `env`"
    assert (said in text) is (lines is not None)
    assert ("environment variables" in text) is (lines is not None)
