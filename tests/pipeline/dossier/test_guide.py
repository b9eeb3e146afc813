"""The first pages of a dossier warn of a figure of no mission, and of values set by hand."""

from dataclasses import replace

import pytest

from tracerisk.adder.blocks.override import Override
from tracerisk.errors import Location
from tracerisk.pipeline.dossier.guide import by_hand_words, warning_of
from tracerisk.pipeline.dossier.sheet import sheet
from tracerisk.prm import FaultTree, HybridModel, solve
from tracerisk.report.html.report_input import ReportInput


@pytest.fixture(scope="module")
def report():
    tree = FaultTree.of("pick fails", {"pick fails": ("or", "gripper")}, {"gripper": 1e-8})
    model = HybridModel.of("arm.py", {"pick": tree})
    return lambda *verdict: ReportInput(assessment=solve(model), model=model, verdict=verdict)


@pytest.mark.parametrize(
    "verdict",
    [
        ("faulted: the gripper closed on nothing (and 1 more); 2 of 2 ran", "the goal is in it"),
        ("stuck: it waited for a service, 1 of 2 functions with commands ran",),
        ("verdict unknown",),
        ("arm.py: complete, 1 of 1 ran", "other.py: faulted: planning failed; 1 of 1 ran"),
    ],
)
def test_a_figure_of_no_mission_is_marked_with_all_reasons(report, verdict):
    warning = "\n".join(warning_of(report(*verdict)))
    assert warning.startswith("**Do not use the figures of this dossier**")
    assert [line[2:] for line in warning.splitlines() if line.startswith("- ")] == list(verdict)


@pytest.mark.parametrize(
    "verdict",
    [
        (),
        ("complete, 6 of 6 functions with commands ran",),
        ("partial: no one answers (arm.py:3); 6 of 6 functions with commands ran",),
        ("complete, 1 of 1 ran", "accepted: faulted: nothing was grasped: a dry run"),
    ],
)
def test_a_figure_of_a_mission_is_not(report, verdict):
    assert warning_of(report(*verdict)) == []


@pytest.mark.parametrize(
    ("reasons", "words"),
    [
        ((), ""),
        (("supplier",), "1 value, none without a reason"),
        (("supplier", None, None), "3 values, 2 without a reason"),
    ],
)
def test_values_set_by_hand_are_counted_on_the_first_pages(report, reasons, words):
    pins = tuple(
        Override("value", "pick.gripper.probability", "1e-9", Location("arm.py", 3), reason=reason)
        for reason in reasons
    )
    by_hand = replace(report(), pins=pins)
    assert by_hand_words(by_hand) == words
    assert ("set by hand" in sheet(by_hand)) is bool(words)
    assert words in sheet(by_hand)
