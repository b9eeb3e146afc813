from dataclasses import replace

import pytest

import tracerisk
from tracerisk.common.outcome.changes import OutcomeChanges
from tracerisk.common.verdict import Coverage, Reason, Verdict
from tracerisk.prm import FIGURE_STATEMENT
from tracerisk.prm.review.change_records import PinChange, RunVerdicts
from tracerisk.report.diff.markdown import render_diff_markdown
from tracerisk.report.diff.text import render_diff


def one_step(component):
    return {"reach": ("done 1", component)}


def first_sentence(text):
    return " ".join(text.split("\n\n")[0].split())


def test_the_text_in_full(difference, review_of):
    before = {"pick": ("place 1", "motor = 2e-8 x7"), "place": ("done 1", "power = 1e-5 of2")}
    after = {"pick": ("place 1", "motor = 4e-8 x7"), "place": ("done 1", "power = 1e-5 x2")}
    text = render_diff(review_of(difference(before, after), notes=("arm is a submodule",)))
    assert (
        text
        == """\
cell.py: mission failure rises from 1.401e-07 to 2.028e-05 (x145), mostly
through power in place: redundancy true -> false [edited by hand], 99 % of the
rise.

before: HEAD; after: working tree

cell.py                                              before      after     ratio
  mission failure                                 1.401e-07  2.028e-05      x145

  What changed, by what each alone does to mission failure
   +2.00e-05  power in place: redundancy true -> false
              lost redundancy, single point of failure; edited by hand;
              cell.py:28
   +1.40e-07  motor in pick: probability 2e-8 -> 4e-8 (x2)
              edited by hand; cell.py:10

  Functions, a visit                                 before      after     ratio
    pick                                          1.400e-07  2.800e-07        x2
      1 visit
    place                                         1.000e-10  2.000e-05    x2e+05
      1 visit

  Single points of failure that were none
  - power, in place

- arm is a submodule

Probability of mission failure by hardware; not harm, software faults or people.
"""
    )


@pytest.mark.parametrize("width", [60, 80, 120])
def test_nothing_is_wider_than_the_terminal(eventful, review_of, width):
    lines = render_diff(review_of(eventful), width=width).splitlines()
    assert max(map(len, lines)) <= width
    assert " ".join(lines).count("FMEA|112 <b>") == 1


def test_everything_that_changed_is_reported(eventful, review_of):
    text = " ".join(render_diff(review_of(eventful)).split())
    for reported in (
        "new state check; grasp: next place 1 -> check 1",
        "check (added)",
        "lost redundancy, single point of failure",
        "camera, in check",
        "as before: place.gripper.probability := 2e-7, computed 1e-7 -> 1.5e-7",
        FIGURE_STATEMENT,
    ):
        assert reported in text


@pytest.mark.parametrize(
    ("before", "after", "expected"),
    [
        ("motor = 1e-7", "motor = 1.005e-7", "unchanged at 1.005e-07."),
        ("motor = 1e-7", "motor = 5e-8", "falls from 1.000e-07 to 5.000e-08 (x0.5), mostly"),
        ("motor = 0", "motor = 1e-7", "rises from 0.000e+00 to 1.000e-07 (from 0)"),
        (
            "motor = 1e-7; power = 1e-15 of2",
            "motor = 1e-7; power = 1e-15 x2",
            "yet redundancy is lost and",
        ),
        (None, "motor = 1e-7", "is assessed for the first time: its mission fails with 1.000e-07"),
        ("motor = 1e-7", None, "has no risk blocks any more; its mission failed with 1.000e-07."),
    ],
)
def test_the_first_sentence_says_what_happened(difference, review_of, before, after, expected):
    versions = [None if each is None else one_step(each) for each in (before, after)]
    sentence = first_sentence(render_diff(review_of(difference(*versions))))
    assert expected in sentence
    assert sentence.startswith("cell.py")
    assert sentence.endswith(".")


def test_the_first_sentence_of_several_controllers_reports_the_greatest(difference, review_of):
    big = difference(one_step("motor = 1e-7"), one_step("motor = 9e-7"), name="big.py")
    small = difference(one_step("motor = 1e-7"), one_step("motor = 2e-7"), name="small.py")
    same = difference(one_step("motor = 1e-7"), one_step("motor = 1e-7"), name="same.py")
    sentence = first_sentence(render_diff(review_of(big, small, same)))
    assert sentence.startswith(
        "The risk of 2 of 3 controllers changed. The greatest change: big.py: "
    )
    both = first_sentence(render_diff(review_of(same, same)))
    assert both == "The risk of 2 controllers is unchanged."
    none = first_sentence(render_diff(review_of()))
    assert none == "No risk block differs between HEAD and working tree."


def test_noise_is_counted_and_not_listed(difference, review_of):
    diff = difference(one_step("motor = 1e-7"), one_step("motor = 1.005e-7"))
    text = render_diff(review_of(diff))
    assert "1 value changes by less than 1 %: reported as unchanged" in text
    assert "What changed" not in text


def test_the_first_sentence_names_what_made_the_change_and_not_what_worked_against_it(
    difference, review_of
):
    before = one_step("a = 9e-7; b = 1e-7; c = 1e-7; d = 1e-7")
    after = one_step("a = 5e-7; b = 4e-7; c = 4e-7; d = 4e-7")
    sentence = first_sentence(render_diff(review_of(difference(before, after))))
    assert "rises" in sentence
    assert "mostly through b in reach" in sentence


def test_the_first_sentence_gives_what_each_does_where_causes_have_opposite_signs(
    difference, review_of
):
    before = {"reach": ("grip 1", "motor = 9e-8"), "grip": ("done 1", "gripper = 1e-8")}
    after = {"reach": ("grip 1", "motor = 6e-8"), "grip": ("done 1", "gripper = 5e-8")}
    rises = first_sentence(render_diff(review_of(difference(before, after))))
    assert rises.endswith(
        "mostly through gripper in grip: probability 1e-8 -> 5e-8 (x5) [edited by hand] "
        "(+4.00e-08), against it motor in reach: probability 9e-8 -> 6e-8 (x0.6667) [edited by "
        "hand] (-3.00e-08)."
    )
    falls = first_sentence(render_diff(review_of(difference(after, before))))
    assert "falls" in falls
    assert "(-4.00e-08), against it motor in reach" in falls
    assert "%" not in rises + falls


def test_the_first_sentence_puts_a_cause_together_over_functions(difference, review_of):
    before = {
        "reach": ("grip 1", "motor = 1e-7; gripper = 1e-8"),
        "grip": ("turn 1", "gripper = 2e-8"),
        "turn": ("done 1", "gripper = 3e-8"),
    }
    after = {
        "reach": ("grip 1", "motor = 2e-7; gripper := 1e-7 ! computed 1e-8"),
        "grip": ("turn 1", "gripper := 1e-7 ! computed 2e-8"),
        "turn": ("done 1", "gripper := 1e-7 ! computed 3e-8"),
    }
    diff = difference(before, after)
    assert diff.changes[0].component == "motor"
    sentence = first_sentence(render_diff(review_of(diff)))
    # 24e-8 of 34e-8, where no single change makes more than the motor's 10e-8.
    assert sentence.endswith(
        "mostly through gripper in 3 functions [set by hand], 71 % of the rise, and motor in "
        "reach: probability 1e-7 -> 2e-7 (x2) [edited by hand], 29 %."
    )
    found = [(each.component, each.kinds, each.functions) for each in diff.causes]
    assert found == [
        ("gripper", ("set by hand",), ("grip", "reach", "turn")),
        ("motor", ("edited by hand",), ("reach",)),
    ]
    assert diff.causes[0].contribution == pytest.approx(2.4e-7, rel=1e-6)


def test_the_first_sentence_names_a_cause_of_another_kind_that_made_much_of_it(
    difference, review_of
):
    before = {"reach": ("grip 1", "motor = 1e-7"), "grip": ("done 1", "gripper = 1e-7")}
    after = {
        "reach": ("grip 1", "motor = 6e-7"),
        "grip": ("done 1", "gripper := 5e-7 ! computed 1e-7"),
    }
    sentence = first_sentence(render_diff(review_of(difference(before, after))))
    assert sentence.endswith(
        "mostly through motor in reach: probability 1e-7 -> 6e-7 (x6) [edited by hand], 56 % of "
        "the rise, and gripper in grip: probability 1e-7 -> 5e-7 (x5) [set by hand], 44 %."
    )


def test_the_first_sentence_names_the_next_cause_where_none_made_more_than_half(
    difference, review_of
):
    steps = one_step("motor = 1e-7; encoder = 1e-7"), one_step("motor = 2e-7; encoder = 2e-7")
    sentence = first_sentence(render_diff(review_of(difference(*steps))))
    assert "50 % of the rise, and " in sentence
    assert "encoder in " in sentence
    assert "motor in " in sentence


def test_the_first_sentence_says_why_the_first_cycle_changes_by_another_ratio(
    difference, review_of
):
    before = {"reach": ("reach 99/100, done 1/100", "power = 1e-4 of2; motor = 1e-8")}
    after = {"reach": ("reach 99/100, done 1/100", "power = 1e-6 x2; motor = 1e-8")}
    sentence = first_sentence(render_diff(review_of(difference(before, after))))
    assert "the first cycle alone: x100, for all redundant units work when it begins" in sentence
    alike = {"reach": ("reach 99/100, done 1/100", "power = 1e-6 x2; motor = 5e-8")}
    assert "cycle" not in first_sentence(render_diff(review_of(difference(after, alike))))


def test_the_first_sentence_names_functions_apart_in_which_its_cause_works_against_it(
    difference, review_of
):
    before = {"take": ("put 1", "motor = 4e-8"), "put": ("done 1", "motor = 4e-8")}
    after = {"take": ("put 1", "motor = 2e-8"), "put": ("done 1", "motor = 9e-8")}
    rises = first_sentence(render_diff(review_of(difference(before, after))))
    assert "rises" in rises
    assert "mostly through motor in put (falling in take) [edited by hand]" in rises
    falls = first_sentence(render_diff(review_of(difference(after, before))))
    assert "mostly through motor in put (rising in take)" in falls


def test_what_the_first_sentence_names_is_in_the_list_however_small(review_of, annotated_source):
    names = [f"part_{number}" for number in range(8)]
    before, after = (
        annotated_source(reach=("done 1", "; ".join(f"{name} = {value}" for name in names)))
        for value in ("1e-6", "1.05e-6")
    )
    after = after.replace("arm.go(", "arm.run(").replace("1.05e-6", "1.06e-6", 1)
    diff = tracerisk.diff({"x.py": before.encode()}, {"x.py": after.encode()})
    text = render_diff(review_of(diff))
    assert "mostly through part_0 in reach" in first_sentence(text)
    assert "+6.00e-08  part_0 in reach" in text
    assert "and 7 more, each below 1 % of mission failure" in text


@pytest.mark.parametrize("render", [render_diff, render_diff_markdown])
def test_the_verdicts_first_reason_is_not_said_to_have_broken_once_more(
    difference, review_of, render
):
    step = one_step("motor = 4e-8")
    faulted = run_of("faulted", "first", "second")
    diff = replace(difference(step, step), verdicts=RunVerdicts(run_of("complete"), faulted))
    text = render(review_of(diff))
    assert text.count("first happened") == text.count("second happened") == 1
    assert "What else broke" in text


@pytest.mark.parametrize("render", [render_diff, render_diff_markdown])
def test_what_a_reviewer_must_see_stands_above_the_figures_in_every_format(
    difference, review_of, render
):
    diff = replace(
        difference(one_step("motor = 4e-8"), one_step("motor = 6e-8")),
        of_run=("jar and infeed touch",),
        of_evidence=("a failure is now noticed",),
        hardware=("motor: failure_rate 1e-7/h -> 2e-7/h",),
        inputs=("cell.py has changed", "scene.xml has changed"),
    )
    text = render(review_of(diff))
    places = [
        text.index(part)
        for part in ("jar and infeed", "now noticed", "1e-7/h -", "4.000e-08<br>")
        if part != "4.000e-08<br>" or render is render_diff_markdown
    ]
    assert places == sorted(places)
    if render is render_diff:
        assert places[-1] < text.index("  mission failure ")
    # The controller itself has changed: a reviewer knows.
    assert "scene.xml has changed" in text
    assert "cell.py has changed" not in text


@pytest.mark.parametrize("render", [render_diff, render_diff_markdown])
def test_a_controller_that_moved_is_no_new_input_of_its_run(difference, review_of, render):
    step = one_step("motor = 4e-8")
    diff = replace(
        difference(step, one_step("motor = 9e-8"), name="src/cell.py"),
        was="cell.py",
        inputs=(
            "cell.py is no part of the run any more",
            "src/cell.py is part of the run now",
            "src/motions.py is part of the run now",
        ),
    )
    text = render(review_of(diff))
    assert "src/motions.py is part of the run now" in text
    assert text.count("part of the run") == 1


def test_changes_that_do_next_to_nothing_are_only_counted(difference, review_of, annotated_source):
    before = annotated_source(reach=("done 1", "motor = 1e-3; hand = 1e-9; grip = 1e-9"))
    after = annotated_source(reach=("done 1", "motor = 2e-3; hand = 2e-9; grip = 3e-9"))
    changed = after.replace("arm.go(", "arm.run(")
    diff = tracerisk.diff({"x.py": before.encode()}, {"x.py": changed.encode()})
    text = render_diff(review_of(diff))
    assert "and 2 more, each below 1 % of mission failure; --json lists them" in text
    assert "grip" not in text
    by_hand = tracerisk.diff({"x.py": before.encode()}, {"x.py": after.encode()})
    assert "grip" in render_diff(review_of(by_hand)), "a person's edit is always told"


def test_one_change_in_several_functions_says_both_values(difference, review_of):
    before = {"a": ("b 1", "power = 1e-5 of2"), "b": ("done 1", "power = 1e-5 of2")}
    after = {"a": ("b 1", "power = 1e-5 x2"), "b": ("done 1", "power = 1e-5 x2")}
    text = render_diff(review_of(difference(before, after)))
    assert "power in 2 functions: redundancy true -> false" in text


def test_every_kind_of_redundancy_is_reported(review_of, annotated_source):
    def source(redundancy):
        text = annotated_source(reach=("done 1", "power = 1e-3 of3"))
        return {"x.py": text.replace("redundancy = true", f"redundancy = {redundancy}").encode()}

    fewer = tracerisk.diff(source("true"), source("required 2"))
    text = render_diff(review_of(fewer))
    assert "power in reach: redundancy true -> required 2" in text
    assert "lost redundancy;" in text
    assert "Single points" not in text
    common = tracerisk.diff(source("true"), source("true, common_cause 0.1"))
    (change,) = common.changes
    assert change.marks == ()
    assert change.contribution == pytest.approx(1e-4, rel=1e-3)
    all_needed = tracerisk.diff(source("required 2"), source("required 3"))
    assert all_needed.changes[0].marks == ("lost_redundancy", "single_point_of_failure")


def run_of(kind, *codes):
    reasons = tuple(Reason(code, kind, f"{code} happened") for code in codes)
    return Verdict(kind, reasons, Coverage(1, 1))


def test_a_reason_of_a_renamed_function_or_one_that_moved_did_not_break():
    def run(function, call, *parts):
        reasons = (
            *(Reason("lookup-failed", "faulted", "no frame", function, part) for part in parts),
            Reason("never-called", "partial", "not executed", function, call),
        )
        return Verdict("faulted", reasons, Coverage(1, 1))

    runs = run("find", "self.go", "part"), run("locate", "self.move", "part")
    renamed = RunVerdicts(*runs, renamed={"find": "locate"})
    assert renamed.broke == renamed.repaired == ()
    # Whoever extracts a function moves what was said of its code.
    moved = RunVerdicts(*runs)
    assert moved.broke == moved.repaired == ()
    twice = RunVerdicts(runs[0], run("locate", "self.move", "part", "part"))
    assert [reason.code for reason in twice.broke] == ["lookup-failed"]
    other = RunVerdicts(runs[0], run("find", "self.go", "tray"))
    assert [reason.object for reason in other.broke] == ["tray"]


def test_a_reason_that_is_accepted_now_was_not_repaired():
    reason = Reason("error-logged", "partial", "no part", "find", "part")
    before = Verdict("partial", (reason,), Coverage(1, 1))
    after = Verdict("complete", (replace(reason, accepted="meant so"),), Coverage(1, 1))
    assert RunVerdicts(before, after).repaired == ()
    assert RunVerdicts(before, Verdict("complete", (), Coverage(1, 1))).repaired == (reason,)


def test_what_a_run_that_was_cut_short_left_out_did_not_break_in_the_next():
    gap = Reason("never-called", "partial", "this call never ran", "find", "self.go")
    cut = Verdict("faulted", (Reason("raised", "faulted", "no service"),), Coverage(1, 1))
    whole = Verdict("partial", (gap,), Coverage(1, 1))
    assert RunVerdicts(cut, whole).broke == ()
    assert RunVerdicts(Verdict("complete", (), Coverage(1, 1)), whole).broke == (gap,)


@pytest.mark.parametrize("code", ["never-grasped", "unmet-need"])
def test_a_figure_that_falls_because_the_run_does_less_is_not_said_to_fall(
    difference, review_of, code
):
    before, after = one_step("motor = 4e-8 x7"), one_step("motor = 2e-8 x7")
    runs = RunVerdicts(run_of("complete"), run_of("partial", code))
    less = replace(difference(before, after), verdicts=runs)
    text = " ".join(render_diff(review_of(less)).split())
    assert "cell.py was complete, is partial; the two runs cannot be compared." in text
    assert "falls" not in text
    assert less.is_worth_telling(0.5)
    assert not less.is_comparable
    more = replace(difference(after, before), verdicts=runs)
    assert "mission failure rises from" in " ".join(render_diff(review_of(more)).split())


@pytest.mark.parametrize(("kind", "is_said"), [("faulted", False), ("partial", True)])
def test_what_a_run_that_was_cut_short_does_not_show_is_not_said_to_be_repaired(
    difference, review_of, kind, is_said
):
    runs = RunVerdicts(run_of("partial", "assumed-part"), run_of(kind, "raised"))
    diff = replace(difference(one_step("motor = 4e-8"), one_step("motor = 4e-8")), verdicts=runs)
    text = render_diff(review_of(diff))
    assert "raised happened" in text
    assert ("What was repaired" in text) is is_said


@pytest.mark.parametrize("render", [render_diff, render_diff_markdown])
@pytest.mark.parametrize(
    ("kinds", "said"),
    [
        (("complete", "faulted"), "cell.py was complete, is faulted; the two runs cannot"),
        (("faulted", "complete"), "cell.py is complete, was faulted; the two runs cannot"),
        (("stuck", "stuck"), "cell.py is stuck; the two runs cannot"),
    ],
)
def test_a_verdict_of_a_lock_that_gives_no_reason_is_reported_without(
    difference, review_of, kinds, said, render
):
    step = one_step("motor = 4e-8")
    diff = replace(difference(step, step), verdicts=RunVerdicts(*map(run_of, kinds)))
    assert said in " ".join(render(review_of(diff)).split())


def test_functions_that_never_ran_keep_no_figure_from_falling(difference, review_of):
    runs = RunVerdicts(run_of("complete"), run_of("partial", "never-ran", "missed-call"))
    less = replace(
        difference(one_step("motor = 4e-8 x7"), one_step("motor = 2e-8 x7")), verdicts=runs
    )
    assert "mission failure falls from" in " ".join(render_diff(review_of(less)).split())


def test_code_that_has_not_run_is_said_beside_the_figure_of_the_code_that_has(
    difference, review_of
):
    same = replace(
        difference(one_step("motor = 4e-8 x7"), one_step("motor = 4e-8 x7")),
        stale=("cell.py has changed",),
        verdicts=RunVerdicts(run_of("complete"), run_of("complete")),
    )
    text = " ".join(render_diff(review_of(same)).split())
    said = (
        "cell.py is not assessed as it is now: since its last run cell.py has changed; its blocks "
        "give 2.800e-07; `tracerisk refresh cell.py` writes them again."
    )
    assert said in text
    other = replace(same, name="other.py", stale=())
    text = " ".join(render_diff(review_of(other, same)).split())
    assert f"Not assessed as they are now: 1 of 2 controllers. The first: {said}" in text
    assert same.is_worth_telling(0.5)


def test_blocks_of_no_run_are_not_said_to_be_an_assessment(difference, review_of):
    new = replace(
        difference(None, one_step("motor = 4e-8")), stale=("tracerisk.lock knows no run of it",)
    )
    assert first_sentence(render_diff(review_of(new))) == (
        "cell.py is not assessed as it is now: tracerisk.lock knows no run of it; its blocks give "
        "4.000e-08; `tracerisk run cell.py` writes them again."
    )


def test_the_figure_of_a_cycle_is_shown_only_where_it_is_another_one(difference, review_of):
    once = {"pick": ("done 1", "motor = 2e-8")}
    often = {"pick": ("pick 9/10, done 1/10", "motor = 2e-8")}
    assert "per cycle" not in render_diff(review_of(difference(once, once)))
    assert "per cycle" in render_diff(review_of(difference(often, often)))
    assert "per cycle" in render_diff(review_of(difference(once, often)))
    ends_at_home = {
        "home": ("pick 1/2, done 1/2", "motor = 2e-8"),
        "pick": ("pick 2/3, home 1/3", "motor = 2e-8"),
    }
    home = review_of(difference(ends_at_home, ends_at_home))
    assert "per cycle" not in render_diff(home) + render_diff_markdown(home)
    only_mission = render_diff_markdown(
        review_of(difference(once, {"pick": ("done 1", "motor = 4e-8")}))
    )
    assert "| controller | HEAD | working tree | ratio |\n|---|---:|---:|---:|\n" in only_mission
    both = render_diff_markdown(review_of(difference(once, often)))
    assert "| ratio | per cycle |\n|---|---:|---:|---:|---:|\n" in both


@pytest.mark.parametrize(("after", "is_shown"), [("1e-3 x2", True), ("2e-5 of2", False)])
def test_what_changes_do_only_together_is_shown_where_it_is_no_noise(
    difference, review_of, after, is_shown
):
    diff = difference(one_step("power = 1e-5 of2"), one_step(f"power = {after}"))
    text = render_diff(review_of(diff))
    assert ("what they do only together, and noise" in text) is is_shown


def test_many_other_times_are_one_line_with_how_long_the_arm_is_under_way(difference, review_of):
    pace = tuple(f"the way to rest {number} of 9 takes 2.0 s, before: 1.0 s" for number in range(9))
    outcome = OutcomeChanges(pace=pace, arm_s=(48.6, 60.1))
    diff = replace(difference(one_step("motor = 4e-8"), one_step("motor = 4e-8")), outcome=outcome)
    text = render_diff(review_of(diff))
    assert "the arm is under way for 60.1 s, before: 48.6 s" in text
    assert "9 ways and rests take another time; --json lists them" in text
    assert "the way to rest" not in text
    few = replace(diff, outcome=replace(outcome, pace=pace[:2]))
    assert "the way to rest 1 of 9" in render_diff(review_of(few))
    gone_wrong = RunVerdicts(run_of("complete"), run_of("faulted", "raised"))
    assert "under way" not in render_diff(review_of(replace(diff, verdicts=gone_wrong)))


def test_a_next_that_a_user_set_is_not_said_to_be_the_mission_of_the_run(difference, review_of):
    diff = difference(one_step("motor = 4e-8"), one_step("motor = 4e-9"))
    diff = replace(diff, outcome=OutcomeChanges())
    assert "the mission brings about the same" in first_sentence(render_diff(review_of(diff)))
    (function,) = diff.functions
    fewer = replace(function, after=replace(function.after, expected_visits=0.1))
    pin = PinChange("new", "reach.next", None, "done 1", None, None, None, None)
    said = first_sentence(render_diff(review_of(replace(diff, functions=(fewer,), pins=(pin,)))))
    assert "the mission brings about the same" not in said
    assert "by `next` set by hand one of the two figures is of another mission" in said
