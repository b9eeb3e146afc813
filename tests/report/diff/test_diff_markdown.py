import re
from dataclasses import replace

import pytest
from markdown_it import MarkdownIt

import tracerisk
from tests.report.diff.test_diff_text import run_of
from tracerisk.prm import FIGURE_STATEMENT
from tracerisk.prm.review.change_records import RunVerdicts
from tracerisk.report.diff.markdown import TAG, render_diff_markdown


def test_a_comment_is_a_tag_a_sentence_a_table_and_folded_details(eventful, review_of):
    text = render_diff_markdown(review_of(eventful))
    lines = text.splitlines()
    assert lines[0] == TAG == "<!-- tracerisk-diff -->"
    assert lines[1].startswith("**cell.py: mission failure rises from ")
    assert lines[3] == "| controller | HEAD | working tree | ratio |"
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


def test_what_stands_between_backticks_is_code_if_it_is_a_word_or_a_command(difference, review_of):
    step = {"reach": ("done 1", "motor = 1e-7")}
    diff = replace(difference(step, step), asked_less=("jar at `x|y`",))
    notes = ("run `tracerisk check pick.py`, not `<b>`",)
    text = render_diff_markdown(review_of(diff, notes=notes))
    assert "is asked less: `success` no longer asks jar at \\`x\\|y\\`" in text
    assert "run `tracerisk check pick.py`, not \\`\\<b\\>\\`" in text


def test_a_review_without_controllers_has_no_table(review_of):
    assert render_diff_markdown(review_of()) == (
        f"{TAG}\n**No risk block differs between HEAD and working tree.** "
        "*Probability of mission failure by hardware; not harm, software faults or people.*\n"
    )


def test_a_controller_that_is_new_or_gone_has_no_ratio(difference, review_of):
    step = {"reach": ("done 1", "motor = 1e-7")}
    text = render_diff_markdown(review_of(difference(None, step), difference(step, None)))
    assert "| cell.py | none | 1.000e-07<br>one in 10,000,000 |  |" in text
    assert "| cell.py | 1.000e-07<br>one in 10,000,000 | none |  |" in text


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
    assert render_diff_markdown(review_of(calm)).splitlines()[1:] == [
        "**x.py: mission failure is unchanged at 1.000e-03, one in 1,000 missions.** "
        f"*{FIGURE_STATEMENT}*"
    ]


def test_a_reason_mentions_nobody(difference, review_of):
    before = {"reach": ("done 1", "motor = 1e-7")}
    after = {"reach": ("done 1", "motor := 1e-7 ! ;asked_by @alice")}
    text = render_diff_markdown(review_of(difference(before, after)))
    assert "alice" in text
    assert "@alice" not in text


SHA = "0123456789abcdef0123456789abcdef01234567"


def test_places_lead_to_the_lines_of_the_commits(eventful, review_of):
    commits = ("b" * 40, SHA)
    review = replace(review_of(eventful), commits=commits, folder="robots/cell 1")
    base = "https://github.com/OWNER/NAME/blob"
    text = render_diff_markdown(review, link_base=base)
    assert f"[cell.py]({base}/{SHA}/robots/cell%201/cell.py)" in text
    assert re.search(rf"\[cell\.py:\d+\]\({base}/{SHA}/robots/cell%201/cell\.py#L\d+\)", text)
    assert not re.search(r"(?<!\[)cell\.py:\d", text)
    gone = replace(review, controllers=(replace(eventful, changes=eventful.changes),))
    assert render_diff_markdown(gone, link_base=f"{base}/") == text
    # The working tree is no commit, and without an address nothing is a link.
    tree = render_diff_markdown(replace(review, commits=("b" * 40, None)), link_base=base)
    assert SHA not in tree
    assert "](" not in render_diff_markdown(review)


def test_a_place_of_the_earlier_version_leads_to_its_commit(difference, review_of):
    before = {"reach": ("done 1", "motor = 1e-7; hand = 2e-7")}
    after = {"reach": ("done 1", "motor = 1e-7")}
    review = replace(review_of(difference(before, after)), commits=("b" * 40, SHA))
    text = render_diff_markdown(review, link_base="https://h/o/r/-/blob")
    assert re.search(
        rf"\[HEAD:cell\.py:\d+\]\(https://h/o/r/-/blob/{'b' * 40}/cell\.py#L\d+\)", text
    )


GITHUB = MarkdownIt("commonmark", {"html": True}).enable(["table", "strikethrough"])
HOSTILE = [
    "a](http://x).py",
    "`rm -rf`.py",
    "@team.py",
    "#12 fixes !3.py",
    "<img src=x>.py",
    "</summary></details>.py",
    "a|b.py",
    "&lt;.py",
    "https://x.example/a.py",
    "www.x.example.py",
    "\u202eyp.a",
    "a\n/close\n.py",
    "- [ ] a.py",
    "1. a.py",
    "x`tracerisk `y.py",
]


@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_name_is_shown_and_does_nothing(difference, review_of, name):
    before, after = {"reach": ("done 1", "motor = 1e-7")}, {"reach": ("done 1", "motor = 9e-7")}
    diff = difference(before, after, name=name)
    review = replace(review_of(diff, diff, notes=(name,)), commits=(None, SHA))
    for base in (None, "https://h/o/r/blob"):
        page = GITHUB.render(render_diff_markdown(review, link_base=base))
        assert not re.search(r"<(img|code|input|h1|ol)", page)
        targets = set(re.findall(r'href="([^"]*)"', page))
        assert all(target.startswith(f"https://h/o/r/blob/{SHA}/") for target in targets)
        text = render_diff_markdown(review, link_base=base)
        assert text.count("<details>") == text.count("</details>") == text.count("</summary>") == 2
        assert "\n/close" not in text
        assert "\u202e" not in text
        said = re.sub(r"\]\([^)]*\)", "]", text)
        assert not re.search(r"@team|#12|!3|://x\.|www\.x", said)
        tables = re.findall(r"(?:^\|.*\n)+", text, re.MULTILINE)
        for table in tables:
            assert len({len(re.findall(r"(?<!\\)\|", row)) for row in table.splitlines()}) == 1


def test_a_comment_is_never_longer_than_a_comment_may_be(difference, review_of):
    step = {"reach": ("done 1", "; ".join(f"component_{n} = {n + 1}e-9" for n in range(60)))}
    more = {"reach": ("done 1", "; ".join(f"component_{n} = {n + 2}e-8" for n in range(60)))}
    diff = difference(step, more, name="x" * 200 + ".py")
    text = render_diff_markdown(review_of(*[diff] * 50, notes=("n" * 5000,) * 20))
    assert len(text) <= 65_000
    assert text.count("<details>") == text.count("</details>")
    assert "too long for a comment: `tracerisk diff` prints the rest" in text
    assert text.splitlines()[0] == TAG
    assert text.endswith(f"*{FIGURE_STATEMENT}*\n")


def test_verdicts_come_before_the_sentence_only_where_something_is_wrong(difference, review_of):
    step = {"reach": ("done 1", "motor = 1e-7")}
    diff = difference(step, {"reach": ("done 1", "motor = 2e-7")})
    good, bad = run_of("complete"), run_of("faulted", "raised")
    fine = render_diff_markdown(review_of(replace(diff, verdicts=RunVerdicts(good, good))))
    assert fine.splitlines()[1].startswith("**cell.py: mission failure rises from ")
    assert "| complete, 1 of 1 |" in fine
    wrong = render_diff_markdown(review_of(replace(diff, verdicts=RunVerdicts(good, bad))))
    assert wrong.splitlines()[1].startswith("faulted: raised happened")
    # Of what ran before it failed nobody is to read a figure of missions.
    assert "| 1.000e-07<br>one in 10,000,000 | 2.000e-07 | not comparable |" in wrong


def test_old_and_new_hardware_figures_stand_before_the_table(difference, review_of):
    line = "motor: failure_rate 2.1e-07/h (IEC 61709) -> 3e-07/h (data sheet)"
    step = {"reach": ("done 1", "motor = 1e-7")}
    diff = replace(difference(step, {"reach": ("done 1", "motor = 2e-7")}), hardware=(line,))
    text = render_diff_markdown(review_of(diff))
    assert r"- motor: failure\_rate 2.1e-07/h (IEC 61709) -\> 3e-07/h (data sheet)" in text
    assert text.index("IEC 61709") < text.index("| controller |")
