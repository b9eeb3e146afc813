"""The first pages of a dossier warn of a figure of no mission, and of values set by hand."""

from dataclasses import replace

import pytest

from tracerisk.adder.blocks.override import Override
from tracerisk.common.verdict import Reason, Verdict, verdict_line
from tracerisk.errors import Location
from tracerisk.pipeline.dossier.guide import by_hand_words, warning_of
from tracerisk.pipeline.dossier.sheet import sheet
from tracerisk.prm import FaultTree, HybridModel, solve
from tracerisk.report.html.report_input import ReportInput

CLOSED = Reason("grasp-missed", "faulted", "the gripper closed on nothing")
FAULTED = Verdict("faulted", (CLOSED,))


@pytest.fixture(scope="module")
def report():
    tree = FaultTree.of("pick fails", {"pick fails": ("or", "gripper")}, {"gripper": 1e-8})
    model = HybridModel.of("arm.py", {"pick": tree})
    return lambda **verdicts: ReportInput(
        assessment=solve(model),
        model=model,
        verdicts=verdicts,
        verdict=tuple(f"{name}: {verdict_line(verdict)}" for name, verdict in verdicts.items()),
    )


@pytest.mark.parametrize(
    "verdicts",
    [
        {"arm": FAULTED},
        {"arm": Verdict("stuck")},
        {"arm": None},
        {"arm": Verdict("complete"), "other": FAULTED},
        {"arm": FAULTED, "with blanks": Verdict("complete")},
    ],
)
def test_a_figure_of_no_mission_is_marked_with_all_reasons(report, verdicts):
    shown = report(**verdicts)
    warning = "\n".join(warning_of(shown))
    assert warning.startswith("**Do not use the figures of this dossier**")
    lines = [line[2:] for line in warning.splitlines() if line.startswith("- ")]
    assert lines == list(shown.verdict)


@pytest.mark.parametrize(
    "verdicts",
    [
        {},
        {"arm": Verdict("complete")},
        {"arm": Verdict("partial", (Reason("no-answer", "partial", "no one answers"),))},
    ],
)
def test_a_figure_of_a_mission_is_not(report, verdicts):
    assert warning_of(report(**verdicts)) == []


def test_a_run_that_went_wrong_keeps_its_warning_where_words_accept_it(report):
    accepted = replace(CLOSED, accepted="a dry run")
    (warning, reason) = warning_of(report(arm=Verdict("complete", (accepted,))))
    assert warning.startswith("**Do not use the figures of this dossier** unless each of these")
    assert reason == (
        "- faulted: the gripper closed on nothing; accepted with the words: a dry run\n"
    )
    gap = Reason("no-answer", "partial", "no one answers", accepted="it is so")
    assert warning_of(report(arm=Verdict("complete", (gap,)))) == []


def test_what_a_check_does_not_let_pass_stands_first(report):
    shown = replace(report(), unpassed=("unjustified: pick.gripper.probability has no reason",))
    assert warning_of(shown) == [
        "**`tracerisk check FILE` does not pass here** (step 1 of `sheet.md`):\n",
        "- unjustified: pick.gripper.probability has no reason\n",
    ]


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
