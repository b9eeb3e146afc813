"""The table of failures and effects says what is not known of runs that ended early."""

import csv
from dataclasses import replace

import pytest

from tests.pipeline.evidence.test_file import CELL, EVIDENCE
from tracerisk.common.text.paper import Paper
from tracerisk.report.fmea import csv_text, end_effect, fmea_rows, render_fmea

LOST = replace(
    CELL, effect="wrong_position", told_after_s=None, told_by="", contact="", followed_s=None
)


@pytest.mark.parametrize(
    ("cells", "words"),
    [
        ([LOST], "wrong position"),
        ([replace(LOST, followed_s=23.5)], "wrong position or worse"),
        ([LOST, replace(LOST, effect="nothing", followed_s=23.5)], "wrong position or worse"),
        ([replace(CELL, followed_s=23.5)], "collision"),
    ],
)
def test_an_effect_may_be_worse_where_a_run_was_not_followed_to_its_end(cells, words):
    assert end_effect(cells) == words


def test_who_was_not_reported_within_a_run_that_ended_early_may_be_reported_later():
    cells = (LOST, replace(LOST, time_s=2.0, followed_s=23.5))
    found = replace(EVIDENCE, cells=cells)
    (row,) = fmea_rows(found)
    assert (row.notified, row.detection) == ("> 23", "nothing within 23 s")
    (written,) = csv.DictReader(csv_text(found).splitlines())
    assert (written["end effect"], written["ended early"]) == ("wrong position or worse", "1")
    (row,) = fmea_rows(replace(found, cells=cells[:1]))
    assert (row.notified, row.detection) == ("never", "nothing")


@pytest.mark.parametrize("width", [80, 120])
def test_no_line_of_the_table_wraps(width):
    cell = replace(
        LOST, component="electric_motor", function="TubePicker.put_back", followed_s=21.0
    )
    power = replace(cell, component="power_system", mode="lost_without_brakes")
    text = render_fmea(replace(EVIDENCE, cells=(cell, power)), paper=Paper(width))
    assert "\n  lost without brakes\n" in text
    text = render_fmea(replace(EVIDENCE, cells=(cell,)), paper=Paper(width))
    assert sum("TubePicker.put_back" in line for line in text.splitlines()) == 1
    assert sum("wrong position or worse" in line for line in text.splitlines()) == 1
