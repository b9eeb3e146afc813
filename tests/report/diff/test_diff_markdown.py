import re

import tracerisk
from tracerisk.report.diff.markdown import TAG, render_diff_markdown


def test_a_comment_is_a_tag_a_sentence_a_table_and_folded_details(eventful, review_of):
    text = render_diff_markdown(review_of(eventful))
    lines = text.splitlines()
    assert lines[0] == TAG == "<!-- tracerisk-diff -->"
    assert lines[1].startswith("**cell.py: mission failure rises from ")
    assert lines[3] == "| controller | HEAD | working tree | ratio | per cycle |"
    assert lines[5].startswith("| cell.py | ")
    assert text.count("<details>") == text.count("</details>") == 1
    assert text.index("| alone | change | cause | where |") > text.index("<details>")


def test_every_row_has_as_many_cells_as_its_table(eventful, review_of):
    text = render_diff_markdown(review_of(eventful))
    tables = re.findall(r"(?:^\|.*\n)+", text, re.MULTILINE)
    assert len(tables) == 3
    for table in tables:
        counts = {len(re.findall(r"(?<!\\)\|", row)) for row in table.splitlines()}
        assert len(counts) == 1


def test_names_and_reasons_are_not_read_as_markup(eventful, review_of):
    text = render_diff_markdown(review_of(eventful, notes=("a <script> | b",)))
    assert r"FMEA\|112 \<b\>" in text
    assert r"- a \<script\> \| b" in text
    assert r"approach\_the\_rack\_from\_above" in text


def test_a_review_without_controllers_has_no_table(review_of):
    assert render_diff_markdown(review_of()) == (
        f"{TAG}\n**No risk block differs between HEAD and working tree.**\n\n"
        "*Probability of mission failure by hardware; not harm, software faults or people.*\n"
    )


def test_a_controller_that_is_new_or_gone_has_no_ratio(difference, review_of):
    step = {"reach": ("done 1", "motor = 1e-7")}
    text = render_diff_markdown(review_of(difference(None, step), difference(step, None)))
    assert "| cell.py | none | 1.000e-07 |  |  |" in text
    assert "| cell.py | 1.000e-07 | none |  |  |" in text


def test_a_long_review_is_cut_to_what_a_comment_holds(difference, review_of):
    step = {"reach": ("done 1", "motor = 1e-7")}
    many = "; ".join(f"c{number} = {number + 1}e-9" for number in range(40))
    more = "; ".join(f"c{number} = {(number + 1) * (2 + number)}e-9" for number in range(40))
    big = difference({"reach": ("done 1", many)}, {"reach": ("done 1", more)})
    text = render_diff_markdown(review_of(big, *[difference(step, step)] * 60))
    assert "| and 10 more changes |" in text
    assert "- and 11 more controllers" in text
    assert len(text) < 65_536


def test_changes_below_the_noise_share_one_row(review_of, annotated_source):
    before = annotated_source(reach=("done 1", "motor = 1e-3; hand = 1e-9; grip = 1e-9"))
    after = annotated_source(reach=("done 1", "motor = 2e-3; hand = 2e-9; grip = 3e-9"))
    changed = after.replace("arm.go(", "arm.run(")
    diff = tracerisk.diff({"x.py": before.encode()}, {"x.py": changed.encode()})
    text = render_diff_markdown(review_of(diff))
    assert "|  | and 2 more, each below 1 % of mission failure; --json lists them |  |  |" in text
    assert "grip" not in text
    calm = tracerisk.diff(
        {"x.py": before.encode()}, {"x.py": changed.replace("2e-3", "1e-3").encode()}
    )
    text = render_diff_markdown(review_of(calm))
    assert "|  | 2 changes, each below 1 % of mission failure; --json lists them |  |  |" in text


def test_a_reason_mentions_nobody(difference, review_of):
    before = {"reach": ("done 1", "motor = 1e-7")}
    after = {"reach": ("done 1", "motor := 1e-7 ! ;asked_by @alice")}
    text = render_diff_markdown(review_of(difference(before, after)))
    assert "alice" in text
    assert "@alice" not in text
