"""`--sarif` of check, diff and run, in a repository as code scanning finds it."""

import json

import pytest


def results_in(folder, name: str) -> list[dict]:
    return json.loads((folder / name).read_text(encoding="utf-8"))["runs"][0]["results"]


def summary(results: list[dict]) -> set[tuple[str, str]]:
    return {
        (each["ruleId"], each["locations"][0]["physicalLocation"]["artifactLocation"]["uri"])
        for each in results
    }


def fingerprints(results: list[dict]) -> list[str]:
    return sorted(each["partialFingerprints"]["tracerisk/v1"] for each in results)


@pytest.fixture
def steps(annotated_source):
    return annotated_source(
        pick=("place 1", "motor = 2e-8 x7; power = 1e-5 of2"),
        place=("pick 9/10, done 1/10", "gripper := 2e-07"),
    )


def test_check_says_what_code_scanning_should_show(repository, steps):
    repository.write("src/cell.py", steps)
    repository.commit()
    outcome = repository.run("check", "src/cell.py", "--sarif", "found.sarif")
    assert outcome.code == 1
    found = results_in(repository.folder, "found.sarif")
    assert summary(found) == {
        (rule, "src/cell.py")
        for rule in ("unknown-blocks", "unjustified-pin", "single-point-of-failure")
    }
    points = [each for each in found if each["ruleId"] == "single-point-of-failure"]
    assert {
        each["locations"][0]["logicalLocations"][1]["fullyQualifiedName"] for each in points
    } == {
        "motor",
        "gripper",
    }


def test_shifted_lines_give_the_same_fingerprints(repository, steps):
    repository.write("cell.py", steps)
    repository.commit()
    repository.run("check", "cell.py", "--sarif", "one.sarif")
    repository.write("cell.py", "import os\n\n\nX = os.name\n\n\n" + steps)
    repository.commit()
    repository.run("check", "cell.py", "--sarif", "two.sarif")
    one, two = (results_in(repository.folder, name) for name in ("one.sarif", "two.sarif"))
    lines = [
        sorted(each["locations"][0]["physicalLocation"]["region"]["startLine"] for each in found)
        for found in (one, two)
    ]
    assert fingerprints(one) == fingerprints(two)
    assert lines[0] != lines[1]
    assert len(set(fingerprints(one))) == len(one) == 4


def test_a_block_that_cannot_be_read_is_an_alert(repository, steps):
    repository.write("cell.py", steps.replace("# | }", "# | ]", 1))
    outcome = repository.run("check", "cell.py", "--sarif", "found.sarif")
    assert outcome.code == 2
    assert summary(results_in(repository.folder, "found.sarif")) == {("unreadable", "cell.py")}


def test_diff_reports_redundancy_that_a_change_took(repository, steps):
    repository.write("cell.py", steps)
    repository.commit()
    repository.write("cell.py", steps.replace("redundancy = true", "redundancy := false  ! ; sold"))
    outcome = repository.run("diff", "--sarif", "found.sarif")
    assert outcome.code == 0, outcome.err
    assert summary(results_in(repository.folder, "found.sarif")) == {
        ("lost-redundancy", "cell.py"),
        ("single-point-of-failure", "cell.py"),
    }


def test_diff_reports_a_component_that_a_change_leaves_out(repository, steps):
    repository.write("cell.py", steps)
    repository.commit()
    lines = steps.splitlines()
    motor = next(i for i, line in enumerate(lines) if line.endswith("name = motor"))
    lines[motor - 1] = lines[motor - 1].replace("@Component {", "@Component := omit {  ! why")
    repository.write("cell.py", "\n".join(lines) + "\n")
    outcome = repository.run("diff", "--sarif", "found.sarif")
    assert outcome.code == 0, outcome.err
    (alert,) = results_in(repository.folder, "found.sarif")
    assert (alert["ruleId"], alert["level"]) == ("omitted-component", "warning")
    place = alert["locations"][0]["physicalLocation"]
    assert place["region"]["startLine"] == motor
    assert alert["message"]["text"] == "motor in pick: left out by hand"


@pytest.fixture(scope="module")
def dead_branch(tmp_path_factory, example_in, quick):
    """One run of a controller with a branch that never runs."""
    source = quick().replace("def main():", "def never(arm):\n    home(arm)\n\n\ndef main():")
    source = source.replace("    act(arm)\n", "    if False:\n        never(arm)\n    act(arm)\n")
    example = example_in(tmp_path_factory.mktemp("dead"))
    example.write("pyproject.toml", '[tool.tracerisk]\nfail_on = "finding"\n')
    example.write("controller.py", source)
    outcome = example.run("run", "controller.py", "--sarif", "run.sarif")
    assert outcome.code == 0, outcome.err
    return example


def test_run_reports_motions_that_never_ran(dead_branch):
    found = results_in(dead_branch.folder, "run.sarif")
    assert {each["ruleId"] for each in found} == {"uncovered-motion"}
    names = [each["locations"][0]["logicalLocations"][0]["fullyQualifiedName"] for each in found]
    assert names == ["home", "never"]
    assert "never can move the arm and never ran" in found[1]["message"]["text"]


def test_check_reports_them_without_a_run_where_they_stand_now(dead_branch, example):
    for name, data in dead_branch.files().items():
        example.write(name, data)
    lock = json.loads(example.read("tracerisk.lock"))
    kept = lock["controllers"]["controller.py"]["trace"]
    assert kept["uncovered"] == {"controller.py": ["home", "never"]}
    outcome = example.run("check", "controller.py", "--sarif", "check.sarif")
    assert outcome.code == 0, outcome.out
    never_ran = [
        [each for each in results_in(example.folder, name) if each["ruleId"] == "uncovered-motion"]
        for name in ("run.sarif", "check.sarif")
    ]
    assert len(never_ran[0]) == 2
    assert never_ran[0] == never_ran[1]
    # Comments shift lines and make nothing stale; a block by hand is risk data.
    annotated = example.read("controller.py").decode()
    by_hand = (
        "def never(arm):\n    # | RiskAnnotation\n    # | @Function := {  ! ; by FMEA-7\n"
        "    # |   name = never\n    # |   callSequence := 9\n    # |   next := done 1\n    # | }\n"
    )
    shifted = "# one\n# two\n" + annotated.replace("def never(arm):\n", by_hand)
    example.write("controller.py", shifted)
    outcome = example.run("check", "controller.py", "--sarif", "check.sarif")
    (home,) = [
        each
        for each in results_in(example.folder, "check.sarif")
        if each["ruleId"] == "uncovered-motion"
    ]
    place = home["locations"][0]["physicalLocation"]
    line = shifted.splitlines().index("def home(arm):") + 1
    assert place["region"]["startLine"] == line
    assert fingerprints([home]) == fingerprints(never_ran[0][:1])
    # A function that is gone cannot move anything.
    example.write("controller.py", annotated.replace("def never(", "def other("))
    example.run("check", "controller.py", "--sarif", "check.sarif")
    names = [
        each["locations"][0]["logicalLocations"][0]["fullyQualifiedName"]
        for each in results_in(example.folder, "check.sarif")
        if each["ruleId"] == "uncovered-motion"
    ]
    assert names == ["home"]


def test_a_file_that_cannot_be_written_is_bad_input(repository, steps):
    repository.write("cell.py", steps)
    outcome = repository.run("check", "cell.py", "--sarif", "gone/found.sarif")
    assert outcome.code == 2
    assert "gone/found.sarif: cannot be written" in outcome.err
