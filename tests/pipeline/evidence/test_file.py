"""The file of evidence: the same bytes for the same evidence, and clear errors for anything else."""

import json
import subprocess
from dataclasses import replace

import pytest

from tracerisk.common.evidence.cells import Cell, Evidence
from tracerisk.common.evidence.file import (
    cell_line,
    dump_evidence,
    loads_evidence,
    merge_evidence,
    parse_cell,
    read_evidence,
)
from tracerisk.common.traced.elements import Exposure
from tracerisk.errors import InputError, Location
from tracerisk.pipeline.freshness.evidence_lines import at_lines_now
from tracerisk.pipeline.workspace.controller import load_controller

CELL = Cell(
    component="motor",
    unit="joint_1",
    mode="dead",
    time_s=1.25,
    use="moving",
    function="pick",
    drawn=True,
    active_s=1.0,
    states_s=(0.75, 0.25, 0.0),
    stretch=Exposure(moving_s=0.5, active_s=0.75, starts=2, wear=(0.1,) * 7),
    fails=True,
    effect="collision",
    effects=("collision", "not_placed"),
    fate="stopped_late",
    noticed_by="result",
    noticed_s=0.75,
    shows_in="place",
    next_function="retreat",
    local="off its way by 0.3 within a second",
    told_after_s=0.5,
    told_by="execution_failure",
    effect_after_s=0.25,
    lost=("tube not at slot",),
    contact="link_4 on table, 31 N",
    followed_s=21.5,
)
EVIDENCE = Evidence(
    fingerprint="abc",
    robot="panda",
    seed=3,
    declared=2,
    success=("tube at its goal within 0.01 m",),
    cells=(CELL, replace(CELL, time_s=2.0, drawn=False, fails=False)),
)


def test_the_shares_before_are_kept_and_read():
    found = replace(
        EVIDENCE, before={("joint_1", "dead", False): 0.25, ("joint_1", "jam", True): 1.0}
    )
    text = dump_evidence({"a.py": found})
    assert loads_evidence(text, "tracerisk.evidence")["a.py"].before == found.before


@pytest.mark.parametrize(
    "row", ['["joint_1", "dead", "idle", 2]', '["joint_1", "dead", "asleep", 0.5]', '"joint_1"']
)
def test_a_malformed_share_before_is_refused(row):
    text = dump_evidence({"a.py": replace(EVIDENCE, before={("joint_1", "dead", False): 0.25})})
    broken = text.replace('["joint_1", "dead", "in use", 0.25]', row)
    assert broken != text
    with pytest.raises(InputError, match="before: expected rows of a unit"):
        loads_evidence(broken, "tracerisk.evidence")


@pytest.mark.parametrize("place", ["pick.py:\u00b2", "pick.py", f"pick.py:{'9' * 5000}", ":3"])
def test_a_place_that_is_none_is_refused(place):
    found = replace(EVIDENCE, cells=(replace(CELL, missed_check="result", missed_at=place),))
    with pytest.raises(InputError, match="missed_at: expected file:line, not '"):
        loads_evidence(dump_evidence({"a.py": found}), "tracerisk.evidence")


def test_places_in_what_is_no_source_stay_as_they_are(example):
    example.write("pick.py", "print()\n")
    example.write("broken.py", "def (\n# | @Function := {\n")
    controller = load_controller(example.folder / "pick.py")
    cells = (replace(CELL, missed_at="broken.py:2"), replace(CELL, missed_at="../x.py:1"))
    assert at_lines_now(replace(EVIDENCE, cells=cells), controller).cells == cells


def written(tmp_path, text, name="tracerisk.evidence"):
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return path


def test_what_is_written_is_read_again(tmp_path):
    everything = {"a.py": EVIDENCE, "b.py": replace(EVIDENCE, cells=())}
    path = written(tmp_path, dump_evidence(everything))
    assert read_evidence(path) == everything
    assert dump_evidence(read_evidence(path)) == path.read_text()


def test_a_cell_is_a_line(tmp_path):
    text = dump_evidence({"a.py": EVIDENCE})
    assert sum(1 for line in text.splitlines() if '"unit"' in line) == 2
    assert parse_cell(cell_line(CELL), Location("x")) == CELL


def test_cells_are_sorted_whatever_their_order():
    turned = replace(EVIDENCE, cells=EVIDENCE.cells[::-1])
    assert dump_evidence({"a.py": turned}) == dump_evidence({"a.py": EVIDENCE})


def test_no_file_is_no_evidence(tmp_path):
    assert read_evidence(tmp_path / "tracerisk.evidence") == {}


def changed(**values):
    data = json.loads(dump_evidence({"a.py": EVIDENCE}))
    data["controllers"]["a.py"].update(values)
    return json.dumps(data)


def with_cell(**values):
    data = json.loads(dump_evidence({"a.py": EVIDENCE}))
    cells = data["controllers"]["a.py"]["cells"]
    return changed(cells=[{**cells[0], **values}])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "is not an evidence"),
        ("[]", "expected an object"),
        ('{"version": 9, "controllers": {}}', "version 9"),
        ('{"version": 1, "controllers": {"a.py": 3}}', "a.py: expected an object"),
        ('{"version": 1, "controllers": {"a.py": {}}}', "cells is missing"),
        (changed(cells=3), "expected a list"),
        (changed(seed=-1), "seed: expected a whole number"),
        (changed(success=3), "success: expected a list"),
        (with_cell(stretch=3), "stretch: expected an object"),
        (with_cell(stretch={"moved": 1}), "unknown key 'moved'"),
        (with_cell(stretch={"wear": [1.0]}), "wear: expected 7"),
        (with_cell(stretch={"moving_s": -1.0}), "moving_s: expected seconds"),
        (changed(cells=[3]), "a cell: expected an object"),
        (changed(cells=[{}]), "a cell: component is missing"),
        (with_cell(effekt="x"), "unknown key 'effekt'"),
        (with_cell(effect="explosion"), "effect 'explosion'"),
        (with_cell(effects=["explosion"]), "effects \\['explosion'\\]"),
        (with_cell(effects="collision"), "effects: expected a list of strings"),
        (with_cell(fate="lucky"), "fate 'lucky'"),
        (with_cell(noticed_by="smell"), "noticed_by 'smell'"),
        (with_cell(noticed_s="soon"), "noticed_s: expected seconds"),
        (with_cell(shows_in=3), "shows_in: expected a string"),
        (with_cell(use="flying"), "use 'flying'"),
        (with_cell(time_s="soon"), "time_s: expected seconds"),
        (with_cell(time_s=-1.0), "time_s: expected seconds"),
        (with_cell(states_s=[1.0]), "expected three times"),
        (with_cell(fails="yes"), "fails: expected true or false"),
        (with_cell(lost=None), "lost: expected a list of strings"),
        (with_cell(lost="all"), "lost: expected a list of strings"),
        (with_cell(unit=7), "unit: expected a string"),
        (with_cell(followed_s="long"), "followed_s: expected seconds"),
        (with_cell(time_s=10**400), "time_s: expected seconds"),
        ("[" * 100_000, "is not an evidence"),
    ],
)
def test_what_is_malformed_is_named_with_its_file(tmp_path, text, message):
    path = written(tmp_path, text)
    with pytest.raises(InputError, match=message) as raised:
        read_evidence(path)
    assert raised.value.location is not None
    assert raised.value.location.file == str(path)


def test_duplicate_cells_are_an_error(tmp_path):
    data = json.loads(dump_evidence({"a.py": EVIDENCE}))
    cells = data["controllers"]["a.py"]["cells"]
    path = written(tmp_path, changed(cells=[cells[0], cells[0]]))
    with pytest.raises(InputError, match="duplicate"):
        read_evidence(path)


def edited(text, before, after):
    assert before in text
    return loads_evidence(text.replace(before, after, 1), "tracerisk.evidence")["a.py"]


def test_a_cell_that_was_edited_is_left_out_and_named():
    text = dump_evidence({"a.py": replace(EVIDENCE, before={("joint_1", "dead", False): 0.25})})
    found = edited(text, '"fails": true, ', "")
    assert found.cells == EVIDENCE.cells[1:]
    assert found.before == {("joint_1", "dead", False): 0.25}
    assert found.edited is not None
    assert found.edited.words == "the failure of joint_1 (dead) at 1.25 s was changed"
    assert not found.is_complete


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ('"declared": 2', '"declared": 1'),
        ('"fingerprint": "abc"', '"fingerprint": "abd"'),
        ('"seed": 3', '"seed": 4'),
        ('"in use", 0.25', '"in use", 0.5'),
        ("tube at its goal within 0.01 m", "tube at its goal within 0.02 m"),
        ('"digest": "', '"digest": "0'),
        (f",\n    {cell_line(EVIDENCE.cells[1])}", ""),
        (cell_line(EVIDENCE.cells[1]), cell_line(replace(EVIDENCE.cells[1], fails=True))),
    ],
)
def test_nothing_is_taken_of_evidence_whose_heading_or_list_was_edited(before, after):
    text = dump_evidence({"a.py": replace(EVIDENCE, before={("joint_1", "dead", False): 0.25})})
    found = edited(text, before, after)
    assert (found.cells, dict(found.before)) == ((), {})
    assert found.edited is not None
    assert "its heading was changed, or failures were added" in found.edited.words


def test_another_layout_of_the_file_is_no_edit():
    data = json.loads(dump_evidence({"a.py": EVIDENCE}))
    text = json.dumps(data, indent=4, sort_keys=True)
    assert loads_evidence(text, "tracerisk.evidence") == {"a.py": EVIDENCE}


def test_edited_evidence_is_written_as_it_was_read():
    text = dump_evidence({"a.py": EVIDENCE, "b.py": EVIDENCE}).replace("collision", "nothing", 1)
    assert dump_evidence(loads_evidence(text, "tracerisk.evidence")) == text


def test_evidence_of_the_version_without_digests_is_read():
    data = json.loads(dump_evidence({"a.py": EVIDENCE}))
    data["version"] = 1
    entry = data["controllers"]["a.py"]
    for each in (entry, *entry["cells"]):
        del each["digest"]
    found = loads_evidence(json.dumps(data), "tracerisk.evidence")
    assert found == {"a.py": replace(EVIDENCE, has_digest=False)}
    assert dump_evidence(found) == dump_evidence({"a.py": EVIDENCE})


def test_evidence_of_the_version_without_fates_is_read_and_counts_as_undetected():
    old = {"effects": (), "fate": None, "noticed_by": None, "noticed_s": None}
    old |= {"shows_in": "", "next_function": ""}
    before = replace(EVIDENCE, cells=tuple(replace(cell, **old) for cell in EVIDENCE.cells))
    data = json.loads(dump_evidence({"a.py": before}))
    data["version"] = 2
    found = loads_evidence(json.dumps(data), "tracerisk.evidence")["a.py"]
    assert found == before
    assert (found.has_fates, EVIDENCE.has_fates) == (False, True)
    assert [cell.is_undetected for cell in found.cells] == [True, False]


@pytest.mark.parametrize(
    ("fate", "fails", "is_undetected"),
    [
        ("carried_out", False, False),
        ("recovered", False, False),
        ("stopped_safely", True, False),
        ("stopped_late", True, True),
        ("unaware", True, True),
    ],
)
def test_a_failure_is_undetected_that_nobody_noticed_or_that_did_harm_first(
    fate, fails, is_undetected
):
    assert replace(CELL, fate=fate, fails=fails).is_undetected == is_undetected


def test_a_line_of_a_journal_that_was_edited_is_refused():
    with pytest.raises(InputError, match="does not match its digest"):
        parse_cell(cell_line(CELL).replace("collision", "nothing"), Location("x"))


def test_edited_evidence_is_not_merged(tmp_path):
    text = dump_evidence({"a.py": EVIDENCE})
    one = written(tmp_path, text, "one")
    two = written(tmp_path, text.replace("collision", "nothing", 1), "two")
    with pytest.raises(InputError, match="was edited: the failure of joint_1"):
        merge_evidence([one, two])


def test_git_merges_no_lines_of_two_campaigns_unseen(tmp_path):
    parts = [
        replace(EVIDENCE, cells=cells) for cells in ((), *((each,) for each in EVIDENCE.cells))
    ]
    base, ours, theirs = (
        written(tmp_path, dump_evidence({"a.py": each}), f"{number}")
        for number, each in enumerate(parts)
    )
    done = subprocess.run(
        ["git", "merge-file", "-q", str(ours), str(base), str(theirs)], check=False
    )
    assert done.returncode > 0, "both have a digest of their own"


def test_shards_merge_to_the_whole(tmp_path):
    parts = [
        written(tmp_path, dump_evidence({"a.py": replace(EVIDENCE, cells=(cell,))}), f"{i}")
        for i, cell in enumerate(EVIDENCE.cells)
    ]
    assert merge_evidence(parts) == {"a.py": EVIDENCE}
    assert merge_evidence([*parts, parts[0]]) == {"a.py": EVIDENCE}


def test_evidence_of_other_campaigns_is_not_merged(tmp_path):
    one = written(tmp_path, dump_evidence({"a.py": EVIDENCE}), "one")
    two = written(tmp_path, dump_evidence({"a.py": replace(EVIDENCE, seed=4)}), "two")
    with pytest.raises(InputError, match="another campaign"):
        merge_evidence([one, two])
    with pytest.raises(InputError, match="does not exist"):
        merge_evidence([one, tmp_path / "three"])
