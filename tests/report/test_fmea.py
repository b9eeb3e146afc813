"""The table of failures and effects says what is not known of runs that ended early."""

import csv
from dataclasses import replace

import pytest

from tests.pipeline.evidence.test_file import CELL, EVIDENCE
from tracerisk.common.evidence.cells import FATES
from tracerisk.common.text.paper import Paper
from tracerisk.report.fmea import (
    DFMEA_HEADINGS,
    all_effects,
    csv_text,
    dfmea_text,
    end_effect,
    fmea_rows,
    render_fmea,
    summary_lines,
)

LOST = replace(
    CELL,
    effect="wrong_position",
    effects=("wrong_position",),
    fate="unaware",
    noticed_by=None,
    noticed_s=None,
    next_function="",
    told_after_s=None,
    told_by="",
    contact="",
    followed_s=None,
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


def test_what_was_not_noticed_within_a_run_that_ended_early_may_be_noticed_later():
    cells = (LOST, replace(LOST, time_s=2.0, followed_s=23.5))
    found = replace(EVIDENCE, cells=cells)
    (row,) = fmea_rows(found)
    assert (row.noticed, row.detection) == ("> 23", "nothing within 23 s")
    (written,) = csv.DictReader(csv_text(found).splitlines())
    assert (written["end effect"], written["ended early"]) == ("wrong position or worse", "1")
    (row,) = fmea_rows(replace(found, cells=cells[:1]))
    assert (row.noticed, row.detection) == ("never", "nothing")


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


def test_the_table_says_what_became_of_the_missions_and_who_noticed():
    stopped = replace(CELL, time_s=3.0, fate="stopped_safely", noticed_by="code", noticed_s=0.25)
    fine = replace(LOST, time_s=4.0, fails=False, fate="carried_out", effect="nothing", effects=())
    found = replace(EVIDENCE, cells=(CELL, stopped, LOST, fine))
    (row,) = csv.DictReader(csv_text(found).splitlines())
    fates = [row[name.replace("_", " ")] for name in FATES]
    assert fates == ["1", "0", "1", "1", "1"]
    assert row["detected by"] == "result (1 of 4), code (1 of 4)"
    assert float(row["detected after s"]) == 0.5
    assert (row["c"], row["undetected"]) == ("0.75", "0.5")
    assert float(row["undetected 5 %"]) < 0.5 < float(row["undetected 95 %"])
    assert (row["failure cause"], row["severity"]) == ("motor without torque", "")
    lines = summary_lines(found)
    assert (
        "missions: 1 carried out, 0 recovered, 1 stopped safely, 1 stopped late, 1 unaware" in lines
    )
    assert any("noticed 2, after 0.50 s in the median; 2 ended" in line for line in lines)


def test_the_table_for_a_dfmea_leaves_the_ratings_to_the_engineer():
    (row,) = csv.DictReader(dfmea_text(replace(EVIDENCE, cells=(CELL,))).splitlines())
    assert list(row) == list(DFMEA_HEADINGS)
    assert row["Focus Element"] == "motor"
    assert row["Failure Effects (FE)"] == "off its way by 0.3 within a second; collision"
    assert row["Current Detection Controls (DC) of FC or FM"] == "result (1 of 1)"
    ratings = [name for name in row if name.startswith(("Severity", "Occurrence", "Detection"))]
    assert [row[name] for name in (*ratings, "DFMEA AP")] == [""] * 4
    assert row["Remarks"].startswith("of 1 tries: stopped late 1; undetected 1, 90 % interval 0.05")


def test_a_file_of_an_earlier_version_is_said_to_be_without_fates():
    old = replace(LOST, fate=None, effects=())
    found = replace(EVIDENCE, cells=(old,))
    (row,) = fmea_rows(found)
    assert (row.noticed, row.detection, row.undetected) == ("not known", "not known", 1)
    assert any("without what became of the missions" in line for line in summary_lines(found))


def test_an_effect_is_not_hidden_by_a_worse_one():
    assert all_effects(replace(CELL, effects=("collision", "dropped", "told"))) == "object dropped"
