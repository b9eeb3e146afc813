"""What a diff says of two runs that brought about other things: first, and before any figure."""

import json
from dataclasses import asdict, replace

import pytest

from tests.pipeline.review.test_review import lock_of, only, write
from tracerisk.common.outcome.arm import Arm, ArmFrame
from tracerisk.common.outcome.kept import outcome_summary
from tracerisk.common.outcome.outcome import ObjectOutcome, Outcome, rest_of
from tracerisk.common.outcome.tolerances import Tolerances
from tracerisk.common.text.plain_data import plain_data
from tracerisk.common.verdict import Coverage, Reason, Verdict
from tracerisk.pipeline.review.alerts import review_alerts
from tracerisk.pipeline.review.review import review

ARM = Arm(
    ("joint1",), (ArmFrame((0.3, 0.0, 0.5), (0.0, 0.0, 0.0), "joint1", (0.0, 1.0, 0.0), True),)
)
HOME = rest_of(ARM, (0.0,), took_s=1.0)
PLACE = rest_of(ARM, (0.2,), took_s=1.0, order=1)
DETOUR = rest_of(ARM, (0.1,), took_s=1.0, order=1)
HIGHER = rest_of(ARM, (0.15,), took_s=1.0, order=1)
CUP = ObjectOutcome("cup", (0.3, 0.0, 0.1), (0.3, 0.2, 0.1), 0.0, None, "table", "")
WHOLE = Outcome(arms=(ARM,), objects=(CUP,), rests=(HOME, PLACE))
HALF = replace(WHOLE, objects=(replace(CUP, end_m=CUP.begin_m),), rests=(HOME,))
LONGER = replace(WHOLE, rests=(HOME, DETOUR, replace(PLACE, order=2)))
WITHOUT_DETOUR, WITH_DETOUR = WHOLE, LONGER
COMPLETE = plain_data(Verdict("complete", (), Coverage(1, 1)))


@pytest.fixture
def both(repository, annotated_source):
    """Two versions of a controller, with the figure and the outcome of each."""

    def make(before: Outcome, after: Outcome, *, figures=("4e-07", "2e-07"), **tolerances):
        for figure, outcome in zip(figures, (before, after), strict=True):
            source = {"pick.py": annotated_source(place=("done 1", f"gripper = {figure}"))}
            limits = replace(Tolerances(), **tolerances)
            trace = {"verdict": COMPLETE, **outcome_summary(outcome, limits)}
            write(repository, source, ("pick.py", replace(lock_of(source, "pick.py"), trace=trace)))
            if figure == figures[0] and outcome is before:
                repository.commit()
        return repository

    return make


def test_half_of_the_work_never_looks_safer(both):
    repository = both(WHOLE, HALF)
    diff = only(review([], repository.folder))
    assert diff.outcome is not None
    assert "cup is no longer moved" in diff.outcome.result
    assert not diff.is_comparable
    outcome = repository.run("diff", "HEAD", "pick.py")
    assert "falls" not in outcome.out
    lines = outcome.out.splitlines()
    first = next(i for i, line in enumerate(lines) if "cup is no longer moved" in line)
    figure = next(i for i, line in enumerate(lines) if line.startswith("  mission failure"))
    assert first < figure
    assert "does something else: cup is no longer moved" in " ".join(lines)
    assert "of different missions" in " ".join(lines)


def test_a_shorter_way_to_the_same_result_is_not_called_safer(both):
    repository = both(WITH_DETOUR, WITHOUT_DETOUR)
    out = " ".join(repository.run("diff", "HEAD", "pick.py").out.split())
    assert "does less: rest 2 of 3 at (0.300, 0.100, 0.500) m is no longer reached" in out
    assert "falls" not in out


def test_rests_elsewhere_on_the_way_to_the_same_result_are_another_way_whatever_it_costs(both):
    elsewhere = replace(LONGER, rests=(HOME, HIGHER, replace(PLACE, order=2)))
    repository = both(LONGER, elsewhere)
    assert only(review([], repository.folder)).goes_another_way
    out = " ".join(repository.run("diff", "HEAD", "pick.py").out.split())
    assert (
        "pick.py goes another way, same result: rest 2 of 3 at (0.300, 0.100, 0.500) m is now 50 "
        "mm from there, at (0.300, 0.150, 0.500) m; mission failure is 2.000e-07 now and was "
        "4.000e-07, by different ways."
    ) in out
    for wrong in ("does less", "different missions", "falls"):
        assert wrong not in out
    repository.commit()
    repository = both(LONGER, elsewhere, figures=("1e-07", "4e-07"))
    out = " ".join(repository.run("diff", "HEAD", "pick.py").out.split())
    assert "mission failure rises from" in out
    assert "; it goes another way, same result." in out


def test_a_rest_that_is_gone_beside_one_elsewhere_does_less(both):
    twice = replace(LONGER, rests=(HOME, DETOUR, replace(HIGHER, order=2), replace(PLACE, order=3)))
    further = rest_of(ARM, (0.05,), took_s=1.0, order=1)
    repository = both(twice, replace(LONGER, rests=(HOME, further, replace(PLACE, order=2))))
    diff = only(review([], repository.folder))
    assert diff.outcome is not None
    assert len(diff.outcome.lost) == 2
    assert not diff.goes_another_way
    assert "does less: rest 2 of 4" in " ".join(repository.run("diff").out.split())


@pytest.mark.parametrize(
    ("figures", "verb"), [(("4e-07", "2e-07"), "falls"), (("2e-07", "4e-07"), "rises")]
)
def test_a_longer_way_to_the_same_result_rises_or_falls(both, figures, verb):
    repository = both(WHOLE, LONGER, figures=figures)
    out = " ".join(repository.run("diff", "HEAD", "pick.py").out.split())
    assert f"mission failure {verb} from" in out
    assert "a rest at (0.300, 0.100, 0.500) m is new" in out


def test_a_shorter_way_that_costs_more_rises(both):
    repository = both(WITH_DETOUR, WITHOUT_DETOUR, figures=("2e-07", "4e-07"))
    assert "mission failure rises from" in repository.run("diff", "HEAD", "pick.py").out


def test_the_same_outcome_says_nothing(both):
    repository = both(WHOLE, WHOLE)
    out = repository.run("diff", "HEAD", "pick.py").out
    assert "mission failure falls" in out
    assert "otherwise" not in out


def test_the_gate_is_on_just_that(both):
    repository = both(WHOLE, HALF)
    assert repository.run("diff", "HEAD", "pick.py").code == 0
    outcome = repository.run("diff", "HEAD", "pick.py", "--no-outcome-change")
    assert outcome.code == 1
    assert "pick.py: cup is no longer moved (and 2 more); --no-outcome-change" in outcome.err


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("figures", [("4e-07", "2e-07"), ("2e-07", "4e-07"), ("2e-07", "2e-07")])
def test_every_output_calls_two_missions_not_comparable(both, figures):
    repository = both(WHOLE, HALF, figures=figures)
    rows = repository.run("diff", "HEAD", "pick.py").out.splitlines()
    (row,) = (row for row in rows if row.startswith("  mission failure"))
    assert row.endswith(" not comparable")
    assert "| not comparable |" in repository.run("diff", "--format", "markdown").out
    assert repository.run("report", "pick.py", "--against", "HEAD", "-o", "r.html").code == 0
    page = repository.read("r.html").decode()
    section = page[page.index('id="difference-1-mission-table"') :]
    section = section[: section.index("</table>")]
    assert section.count("not comparable") == 1
    assert 'id="difference-1-changes-table"' not in page
    # Where the figures differ is seen by function; no ratio says that it is better or worse.
    is_other = figures[0] != figures[1]
    assert ('id="difference-1-functions-table"' in page) == is_other
    data = repository.run("diff", "HEAD", "pick.py", "--json").json["controllers"][0]
    assert [function["status"] for function in data["functions"]].count("changed") == is_other
    assert ("  Functions, a visit" in "\n".join(rows)) == is_other
    history = repository.run("history", "pick.py")
    assert "largest rise" not in history.out
    assert "another result since working tree" in history.out
    assert (
        repository.run("history", "pick.py", "--json").json["controllers"]["pick.py"][
            "largest_rise"
        ]
        is None
    )


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("words", [[], ["."], ["pick.py"]])
def test_another_outcome_is_found_where_no_block_differs(both, words):
    repository = both(WHOLE, HALF, figures=("2e-07", "2e-07"))
    assert repository.git("diff", "--name-only").split() == ["tracerisk.lock"]
    assert "cup is no longer moved" in repository.run("diff", *words).out
    outcome = repository.run("diff", *words, "--no-outcome-change")
    assert outcome.code == 1
    assert "pick.py: cup is no longer moved (and 2 more); --no-outcome-change" in outcome.err


def test_a_lock_that_lost_its_outcome_is_found_where_no_block_differs(both):
    repository = both(WHOLE, Outcome(), figures=("2e-07", "2e-07"))
    lock = json.loads((repository.folder / "tracerisk.lock").read_text())
    del lock["controllers"]["pick.py"]["trace"]["outcome"]
    repository.write("tracerisk.lock", json.dumps(lock))
    outcome = repository.run("diff", "--no-outcome-change")
    assert outcome.code == 1
    assert "is not known of both versions" in outcome.err


def test_another_pace_alone_is_no_change(both):
    slower = replace(WHOLE, rests=(HOME, replace(PLACE, took_s=9.0)))
    repository = both(WHOLE, slower, figures=("2e-07", "2e-07"))
    assert review([], repository.folder).controllers == ()


def test_the_limit_on_the_figure_holds_for_controllers_that_the_change_leaves_alone(both):
    repository = both(WHOLE, WHOLE, figures=("2e-07", "2e-07"))
    repository.write("README.md", "A cell\n")
    assert repository.run("diff", "--max-failure-probability", "1e-6").code == 0
    for words in ([], ["."], ["HEAD", "pick.py"]):
        outcome = repository.run("diff", *words, "--max-failure-probability", "1e-7")
        assert outcome.code == 1
        assert "pick.py: mission failure 2e-07 is over --max-failure-pro" in outcome.err
    assert repository.run("diff", "README.md", "--max-failure-probability", "1e-7").code == 0
    outcome = repository.run("diff", "--max-failure-probability", "1e-7", "--json")
    assert outcome.json["controllers"] == []


@pytest.mark.slow(but=2)
@pytest.mark.parametrize("kind", ["faulted", "stuck"])
@pytest.mark.parametrize("was", ["complete", "faulted"])
def test_a_run_that_went_wrong_passes_no_limit_on_the_figure(both, kind, was):
    repository = both(WHOLE, WHOLE, figures=("2e-07", "2e-07"))
    lock = json.loads((repository.folder / "tracerisk.lock").read_text())
    for name in (was, kind):
        lock["controllers"]["pick.py"]["trace"]["verdict"]["kind"] = name
        repository.write("tracerisk.lock", json.dumps(lock))
        if name == was:
            repository.commit()
    outcome = repository.run("diff", "--max-failure-probability", "0.5")
    assert outcome.code == 1
    assert f"pick.py: its run is {kind}" in outcome.err
    assert "; --max-failure-probability 0.5" in outcome.err


def test_the_gate_passes_another_pace(both):
    slower = replace(WHOLE, rests=(HOME, replace(PLACE, took_s=9.0)))
    repository = both(WHOLE, slower, figures=("2e-07", "4e-07"))
    outcome = repository.run("diff", "HEAD", "pick.py", "--no-outcome-change")
    assert outcome.code == 0, outcome.err
    assert "takes 9.0 s, before: 1.0 s" in " ".join(outcome.out.split())


def test_a_rise_of_another_mission_is_held_by_the_limit(both):
    repository = both(WHOLE, HALF, figures=("2e-07", "4e-07"))
    outcome = repository.run("diff", "HEAD", "pick.py", "--max-increase", "0.5")
    assert outcome.code == 1
    assert (
        "mission failure is more by 100 %, over --max-increase 0.5, though the figures are not "
        "comparable, of different missions"
    ) in outcome.err


MOVED = replace(WHOLE, objects=(replace(CUP, end_m=(0.3, 0.206, 0.1)),))


def test_tolerances_of_the_settings_are_those_of_both_runs(both):
    wide = both(WHOLE, MOVED, place_m=0.01)
    assert not only(review([], wide.folder)).outcome.result


def test_no_change_widens_the_tolerances_it_is_judged_by(both):
    repository = both(WHOLE, MOVED)
    lock = json.loads((repository.folder / "tracerisk.lock").read_text())
    (entry,) = lock["controllers"].values()
    wide = asdict(replace(Tolerances(), place_m=5.0))
    entry["trace"]["outcome"]["tolerances"] = wide
    repository.write("tracerisk.lock", json.dumps(lock))
    diff = only(review([], repository.folder))
    assert diff.outcome.result
    assert any("the smaller ones count" in line for line in diff.of_comparison)
    assert not diff.of_run, "no run showed it"


def test_an_unknown_outcome_is_said_and_fails_the_gate(both):
    repository = both(WHOLE, WHOLE)
    lock = json.loads((repository.folder / "tracerisk.lock").read_text())
    (entry,) = lock["controllers"].values()
    del entry["trace"]["outcome"]
    repository.write("tracerisk.lock", json.dumps(lock))
    outcome = repository.run("diff", "HEAD", "pick.py", "--no-outcome-change")
    assert outcome.code == 1
    assert "is not known of both versions" in outcome.err
    assert "what the later run brought about is not known" in " ".join(outcome.out.split())


def test_every_format_says_it_first(both):
    repository = both(WHOLE, HALF)
    data = repository.run("diff", "--json", "HEAD", "pick.py", "--sarif", "out.sarif").json
    (controller,) = data["controllers"]
    assert controller["outcome"]["result"][0] == "cup is no longer moved"
    assert (controller["ratio"], controller["increase"]) == (None, None)
    assert data["headline"].startswith("pick.py does something else")
    alerts = json.loads((repository.folder / "out.sarif").read_text())["runs"][0]["results"]
    assert {alert["ruleId"] for alert in alerts} == {"changed-outcome"}
    markdown = repository.run("diff", "--format", "markdown", "HEAD", "pick.py").out
    assert markdown.index("cup is no longer moved") < markdown.index("| controller |")


def test_a_quiet_bot_speaks_of_another_outcome(both):
    repository = both(WHOLE, HALF, figures=("2e-07", "2.0001e-07"))
    assert repository.run("diff", "HEAD", "pick.py", "--silent-below", "0.5").out


def test_history_marks_the_commit_that_changed_the_result(both):
    repository = both(WHOLE, HALF)
    repository.commit()
    out = repository.run("history", "pick.py").out
    assert any("2.000e-07" in line and "result" in line for line in out.splitlines()), out
    assert "x0.5" not in out
    data = repository.run("history", "pick.py", "--json").json
    assert [point["outcome"] for point in data["controllers"]["pick.py"]["commits"]] == [
        "",
        "result",
    ]


def faulted(repository):
    """Make the run of the working tree one that dropped its cup."""
    dropped = Reason("object-dropped", "faulted", "'cup' fell 170 mm", "place", "cup", 3.0)
    lock = json.loads((repository.folder / "tracerisk.lock").read_text())
    (entry,) = lock["controllers"].values()
    entry["trace"]["verdict"] = plain_data(Verdict("faulted", (dropped,), Coverage(1, 1)))
    repository.write("tracerisk.lock", json.dumps(lock))
    return repository


def test_a_fault_is_an_alert_of_the_change_and_one_with_that_of_a_check(both):
    repository = faulted(both(WHOLE, WHOLE))
    quality = ("--code-quality", "quality.json")

    def faults(*words):
        assert repository.run(*words, *quality, "--quiet").code in (0, 1)
        found = json.loads(repository.read("quality.json"))
        return {
            alert["fingerprint"]: alert["severity"]
            for alert in found
            if alert["check_name"] == "faulted-run"
        }

    of_change = faults("diff", "HEAD", "pick.py")
    assert list(of_change.values()) == ["major"]
    assert of_change == faults("check", "pick.py")


def test_history_ends_with_what_went_wrong_and_the_last_other_result(both):
    repository = both(WHOLE, HALF)
    repository.commit()
    out = repository.run("history", "pick.py").out
    assert "never rose" not in out
    assert "another result since " in out
    assert "cup is no longer moved" in out
    faulted(repository)
    repository.commit()
    repository.write("notes.txt", "well")
    last = repository.run("history", "pick.py").out.split("faulted since ")[1]
    assert "'cup' fell 170 mm" in last.splitlines()[1]


def test_a_run_of_the_same_verdict_and_figure_is_no_row_of_a_history(both):
    repository = both(WHOLE, WHOLE, figures=("2e-07", "2e-07"))
    lock = json.loads((repository.folder / "tracerisk.lock").read_text())
    (entry,) = lock["controllers"].values()
    entry["trace"]["verdict"] = plain_data(Verdict("complete", (), Coverage(2, 2)))
    repository.write("tracerisk.lock", json.dumps(lock))
    repository.commit()
    assert "x1" not in repository.run("history", "pick.py").out


def test_of_another_mission_it_is_said_how_often_functions_run(repository, annotated_source):
    second = replace(CUP, name="second_cup")
    for following, objects in (("done 1", (CUP,)), ("place 1/2, done 1/2", (CUP, second))):
        source = {"pick.py": annotated_source(place=(following, "gripper = 2e-07"))}
        outcome = replace(WHOLE, objects=objects)
        trace = {"verdict": COMPLETE, **outcome_summary(outcome, Tolerances())}
        write(repository, source, ("pick.py", replace(lock_of(source, "pick.py"), trace=trace)))
        if following == "done 1":
            repository.commit()
    for form in ("text", "markdown"):
        out = repository.run("diff", "HEAD", "pick.py", "--format", form).out
        plain = " ".join(out.replace("\\", "").split())
        moved = "is moved by 200 mm to (0.300, 0.200, 0.100) m, ends on table"
        assert f"second_cup is new in the scene and {moved}" in plain
        assert "place: 2 visits, before: 1" in plain


def test_alerts_name_files_from_the_top_wherever_a_user_stands(both, monkeypatch):
    repository = both(WHOLE, HALF)
    (repository.folder / "below").mkdir()
    monkeypatch.chdir(repository.folder / "below")
    alerts = review_alerts(review(["HEAD", "../pick.py"]))
    assert {alert.file for alert in alerts} == {"pick.py"}
