"""A change of what `success` asks: what it asks less is said first, and is stopped by a gate."""

import json
from dataclasses import replace

import pytest

from tests.pipeline.review.test_outcome import CUP, WHOLE
from tests.pipeline.review.test_review import lock_of, only, write
from tracerisk.common.outcome.kept import outcome_summary
from tracerisk.common.outcome.tolerances import Tolerances
from tracerisk.common.text.digests import sha256
from tracerisk.common.text.plain_data import plain_data
from tracerisk.common.verdict import Coverage, Verdict
from tracerisk.instrument.source.code_digest import code_digest
from tracerisk.pipeline.review.review import review

COMPLETE = plain_data(Verdict("complete", (), Coverage(1, 1)))
STRICT = "success:\n- {object: cup, at: tray}\n- {called: weld, times: 2}\n"
LOOSE = STRICT.replace("at: tray", "at: tray, within: 0.05")
SETTINGS = '[tool.tracerisk]\nscenario = "cell.yaml"\n'
SAID = (
    "pick.py is asked less: `success` no longer asks cup at tray within 0.01 m; now: within 0.05 m"
)


@pytest.fixture
def cell(repository, annotated_source):
    """Two versions of a controller, each with its scenario (`None`: no scenario) and its run."""

    def make(before, after, *, figures=("2e-07", "2e-07"), is_run=True, outcomes=(WHOLE, WHOLE)):
        for index, (scenario, figure) in enumerate(zip((before, after), figures, strict=True)):
            source = {"pick.py": annotated_source(place=("done 1", f"gripper = {figure}"))}
            inputs = {}
            if scenario is not None:
                inputs = {
                    "files": {"cell.yaml": sha256(scenario.encode())},
                    "settings": {"scenario": "cell.yaml"},
                }
                repository.write("cell.yaml", scenario)
            else:
                (repository.folder / "cell.yaml").unlink()
            repository.write("pyproject.toml", SETTINGS if scenario is not None else "")
            if index == 0 or is_run:
                trace = {"verdict": COMPLETE, **outcome_summary(outcomes[index], Tolerances())}
                entry = replace(lock_of(source, "pick.py", **inputs), trace=trace)
                write(repository, source, ("pick.py", entry))
            if index == 0:
                repository.commit()
        return repository

    return make


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("is_run", [True, False])
def test_a_looser_success_is_the_first_thing_said_in_every_output(cell, is_run):
    repository = cell(STRICT, LOOSE, is_run=is_run)
    assert " ".join(repository.run("diff", "HEAD").out.split()).startswith(f"{SAID} ")
    comment = repository.run("diff", "HEAD", "--format", "markdown", "--silent-below", "0.01").out
    first = next(line for line in comment.splitlines() if line and not line.startswith("<!--"))
    assert "is asked less" in first
    assert "within 0.05 m" in first
    assert repository.run("diff", "HEAD", "--json").json["headline"].startswith(f"{SAID}. ")
    assert repository.run("report", "pick.py", "--against", "HEAD", "-o", "r.html").code == 0
    page = repository.read("r.html").decode()
    assert page.count("pick.py is asked less: ") == 2
    repository.run("diff", "HEAD", "--sarif", "alerts.sarif")
    results = json.loads(repository.read("alerts.sarif"))["runs"][0]["results"]
    (result,) = (one for one in results if "no longer asks cup" in one["message"]["text"])
    place = result["locations"][0]["physicalLocation"]
    assert (place["artifactLocation"]["uri"], place["region"]["startLine"]) == ("cell.yaml", 1)


def test_a_gate_stops_it(cell):
    repository = cell(STRICT, LOOSE)
    assert repository.run("diff", "HEAD").code == 0
    assert repository.run("diff", "HEAD", "--no-weaker-checks").code == 1
    done = repository.run("diff", "HEAD", "--no-outcome-change")
    assert done.code == 1
    assert f"{SAID.replace('pick.py is', 'pick.py: is')}; --no-outcome-change" in done.err


def test_a_scenario_that_is_gone_asks_nothing(cell):
    diff = only(review(["HEAD"], cell(STRICT, None).folder))
    assert diff.asked_less == ("cup at tray within 0.01 m", "called /weld 2 times")


def test_a_robot_that_must_do_less_never_looks_safer(cell):
    repository = cell(STRICT, LOOSE, figures=("4e-07", "2e-07"))
    diff = only(review(["HEAD"], repository.folder))
    assert not diff.is_comparable
    out = " ".join(repository.run("diff", "HEAD").out.split())
    assert "falls" not in out
    assert "not comparable" in out
    assert "pick.py is asked less; mission failure is 2.000e-07 now and was 4.000e-07" in out


def test_a_call_more_is_asked_otherwise_and_not_less(cell):
    calls = "success:\n- {called: /weigh, exactly: %d}\n"
    repository = cell(calls % 2, calls % 3)
    diff = only(review(["HEAD"], repository.folder))
    said = "called /weigh exactly 3 times; before: exactly 2 times"
    assert (diff.asked_less, diff.asked_otherwise, diff.asked_newly) == ((), (said,), ())
    out = repository.run("diff", "HEAD", "--no-weaker-checks")
    assert out.code == 0
    assert "is asked less" not in out.out
    assert f"What `success` asks otherwise - {said}" in " ".join(out.out.split())
    fewer = only(review(["HEAD"], cell(calls % 3, calls % 2).folder))
    assert fewer.asked_less == ("called /weigh exactly 3 times; now: exactly 2 times",)


def test_a_stricter_success_is_told_and_stopped_by_no_gate(cell):
    repository = cell(LOOSE, STRICT + "- within_s: 30\n")
    diff = only(review(["HEAD"], repository.folder))
    assert diff.asked_less == ()
    assert diff.asked_newly == ("cup at tray within 0.01 m", "over within 30 s")
    assert "What `success` newly asks" in repository.run("diff", "HEAD").out
    assert repository.run("diff", "HEAD", "--no-outcome-change").code == 0


def test_a_scenario_that_asks_the_same_says_nothing(cell):
    diff = only(review(["HEAD"], cell(STRICT, f"# Two welds.\n{STRICT}").folder))
    assert diff.asked_less == diff.asked_newly == ()


def test_a_scenario_that_cannot_be_read_is_no_success(cell):
    (said,) = only(review(["HEAD"], cell(STRICT, "success: 3\n").folder)).asked_less
    assert "the scenario of the later version cannot be read" in said


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("success", "said"),
    [(STRICT, ("can",)), (f"{STRICT}- {{object: can, rests_on: table}}\n", ()), ("{}\n", ())],
)
def test_an_object_that_is_newly_moved_and_not_named_by_success_is_told(cell, success, said):
    with_can = replace(WHOLE, objects=(CUP, replace(CUP, name="can")))
    repository = cell(success, success, outcomes=(WHOLE, with_can))
    assert only(review(["HEAD"], repository.folder)).not_asked == said
    out = " ".join(repository.run("diff", "HEAD").out.split())
    title = "What the mission newly moves and `success` does not name - can"
    assert (title in out) is bool(said)
    assert "can is new in the scene and is moved by 200 mm to (0.300, 0.200, 0.100) m" in out


@pytest.fixture
def with_check(repository, annotated_source):
    """Commit a controller without a check of an answer, and write one with it, or the reverse."""
    text = annotated_source(place=("done 1", "gripper = 2e-07"))
    bare = f"{text}\narm.go(wait=True)\nlog(1)\n"
    checked = f"{text}\nif not arm.go(wait=True):\n    raise SystemExit\nlog(2)\n"

    def make(*, is_lost):
        for source in (checked, bare) if is_lost else (bare, checked):
            if (repository.folder / "pick.py").exists():
                repository.commit()
            write(
                repository,
                {"pick.py": source},
                ("pick.py", lock_of({"pick.py": source}, "pick.py")),
            )
        return repository

    return make


def test_a_new_check_of_an_answer_is_named_as_not_credited(with_check):
    repository = with_check(is_lost=False)
    (check,) = only(review(["HEAD"], repository.folder)).checks
    assert (check.is_lost, check.answer) == (False, "the answer of go()")
    for form in ("text", "markdown"):
        out = repository.run("diff", "HEAD", "--format", form, "--silent-below", "0.01").out
        assert "Answers that are newly looked at, which no figure credits without evidence" in out
        assert "looks at less" not in out
    assert repository.run("diff", "HEAD", "--no-weaker-checks").code == 0


def test_a_lost_check_of_an_answer_stands_before_all_else_and_has_a_gate(with_check):
    repository = with_check(is_lost=True)
    said = "pick.py looks at less: <module> no longer looks at the answer of go() (HEAD:pick.py:"
    out = repository.run("diff", "HEAD", "--silent-below", "0.01").out
    assert " ".join(out.split()).startswith(said)
    comment = repository.run("diff", "HEAD", "--format", "markdown").out.splitlines()
    assert comment[1].startswith("**pick.py looks at less: ")
    assert repository.run("diff", "HEAD", "--json").json["headline"].startswith(said)
    assert repository.run("diff", "HEAD", "--max-increase", "0.1").code == 0
    done = repository.run("diff", "HEAD", "--no-weaker-checks", "--sarif", "alerts.sarif")
    assert done.code == 1
    assert "may go unnoticed; --no-weaker-checks" in done.err
    results = json.loads(repository.read("alerts.sarif"))["runs"][0]["results"]
    assert [result["ruleId"] for result in results] == ["lost-check"]


def test_a_check_in_a_module_without_blocks_counts(repository, annotated_source):
    text = annotated_source(place=("done 1", "gripper = 2e-07"))
    source = f"{text}\nimport sure\nsure.go()\n"
    checked = "def go():\n    if not arm.go(): raise SystemExit\n"
    for module in (checked, "def go():\n    arm.go()\n"):
        if module is not checked:
            repository.commit()
        files = {"pick.py": source, "sure.py": module}
        sources = {file: code_digest(text.encode(), file) for file, text in files.items()}
        write(repository, files, ("pick.py", lock_of(files, "pick.py", sources=sources)))
    (check,) = only(review(["HEAD"], repository.folder)).lost_checks
    assert (check.function, check.location.file) == ("go", "sure.py")
