"""`tracerisk diff` as a user calls it: formats, limits, exit codes, and `git diff` with it."""

import json
import os
import re
import subprocess
import sys

import pytest

from tests.slow import slow_but


@pytest.fixture
def steps(annotated_source):
    def make(gripper="= 2e-07", power="1e-5 of2"):
        return annotated_source(
            pick=("place 1", f"motor = 2e-8 x7; power = {power}"),
            place=("pick 9/10, done 1/10", f"gripper {gripper}"),
        )

    return make


@pytest.fixture
def changed(repository, steps):
    """A repository in which the mission's failure probability is 1.59 times what it was."""
    repository.write("pick.py", steps())
    repository.commit()
    repository.write("pick.py", steps(gripper="= 4e-07"))
    return repository


def test_the_text_begins_with_one_sentence(changed):
    outcome = changed.run("diff")
    assert (outcome.code, outcome.err) == (0, "")
    assert outcome.out.startswith(
        "pick.py: mission failure rises from 3.410e-06 to 5.410e-06 (x1.59), mostly\n"
        "through gripper in place: probability 2e-07 -> 4e-07 (x2) [edited by hand].\n\n"
    )


@pytest.mark.parametrize("asked", [["--json"], ["--format", "json"]])
def test_the_json_is_versioned_and_has_every_figure(changed, asked):
    outcome = changed.run("diff", *asked, "HEAD", "pick.py")
    data = outcome.json
    assert (data["schema"], data["version"], data["verb"]) == ("tracerisk", 1, "diff")
    assert (data["exit_code"], outcome.code) == (0, 0)
    assert (data["before"], data["after"]) == ("HEAD", "working tree")
    assert list(data) == sorted(data)
    (controller,) = data["controllers"]
    assert controller["ratio"] == pytest.approx(1.585, rel=1e-3)
    assert controller["after"]["cycle_failure_probability"] == pytest.approx(5.4e-7, rel=1e-3)
    (change,) = controller["changes"]
    assert change["contribution"] == pytest.approx(2e-6, rel=1e-3)
    assert data["headline"].startswith("pick.py: mission failure rises")


def test_options_may_stand_anywhere(changed):
    outcome = changed.run("diff", "HEAD", "--format", "json", "pick.py", "-q", "pick.py")
    assert outcome.code == 0, outcome.err
    assert outcome.json["controllers"][0]["name"] == "pick.py"
    outcome = changed.run("diff", "HEAD", "--json", "pick.py", "--frmat", "text")
    assert outcome.code == 2
    assert "unknown option --frmat; did you mean --format?" in outcome.err


def test_the_markdown_has_its_tag(changed):
    outcome = changed.run("diff", "--format", "markdown")
    assert outcome.out.startswith("<!-- tracerisk-diff -->\n**pick.py: mission failure rises")


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(
    ("options", "code", "expected"),
    [
        (["--max-increase", "0.6"], 0, ""),
        (["--max-increase", "0.5"], 1, "mission failure rises by 58.7 %, over --max-increase 0.5"),
        (["--max-failure-probability", "1e-5"], 0, ""),
        (
            ["--max-failure-probability", "5e-6"],
            1,
            "mission failure 5.41e-06 is over --max-failure-probability 5e-06",
        ),
    ],
)
def test_limits_make_the_exit_code(changed, options, code, expected):
    outcome = changed.run("diff", *options)
    assert outcome.code == code
    assert expected in outcome.err
    assert (outcome.err == "") == (code == 0)
    data = changed.run("diff", *options, "--json").json
    assert (data["exit_code"], len(data["exceeded"])) == (code, code)


def test_a_rise_within_the_noise_exceeds_no_increase(changed, steps):
    changed.write("pick.py", steps(gripper="= 2.001e-07"))
    assert changed.run("diff", "--max-increase", "0").code == 0
    assert changed.run("diff", "--max-increase", "0", "--max-failure-probability", "1e-9").code == 1


def test_what_is_not_utf_8_is_reported_all_the_same(changed, steps):
    name = os.fsdecode(b"caf\xe9.py")
    published = (
        "/*** * RiskAnnotation\n * @Function {\n *   name = f\n *   callSequence = 1\n * }\n"
        " * @Component {\n *   name = arm\n *   probability := 1e-7 ! ;gr\udcfcn\n"
        " *   quantity = 1\n *   redundancy = false\n * }\n ***/\n"
    )
    changed.write(name, steps())
    changed.write("f.c", published.encode(errors="surrogateescape"))
    for form in ("text", "markdown", "json"):
        environment = {"PYTHONIOENCODING": "ascii"}
        options = ("HEAD", "--format", form, name, "f.c")
        outcome = changed.run("diff", *options, environment=environment)
        assert outcome.code == 0, outcome.err
        assert "caf\ufffd.py" in outcome.out


def test_errors_exit_with_2_and_say_the_version(changed, steps, tmp_path):
    outcome = changed.run("diff", "nope")
    assert (outcome.code, outcome.out) == (2, "")
    assert "'nope' is not a revision here" in outcome.err
    changed.write("pick.py", steps().replace("quantity = 7", "quantity = 0"))
    outcome = changed.run("diff", "--format", "json")
    assert outcome.code == 2
    assert "in working tree: quantity = 0 is not allowed" in outcome.json["error"]["message"]
    outside = type(changed)(tmp_path)
    outcome = outside.run("diff", environment={"GIT_CEILING_DIRECTORIES": str(tmp_path.parent)})
    assert outcome.code == 2
    assert "is in no git repository" in outcome.err


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (["--max-increase", "-1"], "'-1' is not a share from 0 up, such as 0.1 for 10 %"),
        (["--max-increase", "x"], "'x' is not a share from 0 up"),
        (["--format", "html"], "invalid choice: 'html'"),
        (["--textconv", "pick.py", "HEAD"], "--textconv takes one file and no revision"),
        (["--textconv", "gone.py"], "gone.py: cannot be read"),
    ],
)
def test_bad_options_exit_with_2(changed, options, expected):
    outcome = changed.run("diff", *options)
    assert outcome.code == 2
    assert expected in outcome.err


def test_it_imports_no_simulator_and_no_libcst(changed):
    code = (
        "import sys; from tracerisk.cli import main; code = main(['diff']); "
        "heavy = {'mujoco', 'dm_control', 'libcst', 'numpy', 'rich'} & set(sys.modules); "
        "sys.exit(f'imported {heavy}' if heavy else code)"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=changed.folder, capture_output=True)
    assert done.returncode == 0, done.stderr


def test_plain_git_diff_shows_the_model_by_textconv(changed):
    changed.write(".gitattributes", "*.py diff=tracerisk\n")
    command = f"'{sys.executable}' -m tracerisk diff --textconv"
    changed.git("config", "diff.tracerisk.textconv", command)
    shown = changed.git("diff").splitlines()
    assert "-    # |   probability = 2e-07" in shown
    assert "-risk model: mission failure 3.41e-06, per cycle 3.401e-07" in shown
    assert "+risk model: mission failure 5.41e-06, per cycle 5.401e-07" in shown
    assert "+  place: 4e-07 a visit, next pick 9/10, done 1/10" in shown
    assert not [line for line in shown if "pick: " in line and line[0] in "+-"]


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (("quantity = 7", "quantity = 0"), "risk model: line 11: quantity = 0 is not allowed"),
        (("next = place 1", "next = elsewhere 1"), "no mission of these blocks alone: function"),
        (("quantity = 7", "quantity = 1000000000"), "  pick: no figure, next place 1"),
        (("callSequence = 2", "callSequence = 1"), "(the other is at line 2)"),
    ],
)
def test_textconv_says_what_is_wrong_and_never_fails(changed, steps, change, expected):
    changed.write("bad.py", steps().replace(*change))
    outcome = changed.run("diff", "--textconv", "bad.py")
    assert outcome.code == 0, outcome.err
    assert expected in outcome.out
    assert "bad.py" not in outcome.out
    assert outcome.out.startswith(steps().replace(*change))


def test_textconv_leaves_a_source_without_blocks_as_it_is(changed):
    source = "x = 'grün'\r\n# RiskAnnotation"
    changed.write("plain.py", source)
    outcome = changed.run("diff", "--textconv", "plain.py")
    assert (outcome.code, outcome.out) == (0, source)


@pytest.mark.slow(but=3)
@pytest.mark.parametrize(
    ("change", "threshold", "is_reported"),
    [
        ({"gripper": "= 2.1e-07"}, "0.1", False),
        ({"gripper": "= 2.1e-07"}, "0.01", True),
        ({"gripper": "= 1e-08"}, "0.1", True),
        ({"gripper": ":= 2e-07"}, "0.5", True),
        ({"power": "1e-9"}, "0.5", True),
        ({}, "0", False),
    ],
)
@pytest.mark.parametrize("form", slow_but(("text",), ("text", "markdown")))
def test_a_small_change_is_reported_only_where_a_reviewer_must_see_it(
    repository, steps, change, threshold, is_reported, form
):
    repository.write("pick.py", steps())
    repository.commit()
    repository.write("pick.py", steps(**change))
    outcome = repository.run("diff", "--silent-below", threshold, "--format", form)
    assert outcome.code == 0, outcome.err
    assert bool(outcome.out) == is_reported


@pytest.fixture
def checked(repository, steps):
    """A repository in which a check is added: more missions fail, fewer of them unnoticed."""
    section = (
        "    # | @Failure {{\n    # |   component = gripper\n"
        "    # |   mode := dead 1: stopped safely {}, unaware {}\n    # | }}\n"
    )

    def source(gripper, *shares):
        head, place = steps(gripper=gripper).split("def place")
        body, closed, rest = place.rpartition("    # | }\n")
        return f"{head}def place{body}{closed}{section.format(*shares)}{rest}"

    repository.write("pick.py", source("= 2e-07", "1/10", "9/10"))
    repository.commit()
    repository.write("pick.py", source("= 2.5e-07", "9/10", "1/10"))
    return repository


def test_the_sentence_credits_a_check(checked):
    outcome = checked.run("diff")
    said = " ".join(outcome.out.split())
    assert said.startswith(
        "pick.py: undetected failure falls from 3.210e-06 to 1.660e-06 (x0.517); mission failure "
        "rises from 3.410e-06 to 3.910e-06 (x1.15), mostly through gripper in place"
    )
    # What a change of what follows failures does is not told as nothing.
    assert re.search(r"undetected -\d\.\d\de-0\d; ", said)
    assert "+0.00e+00" not in outcome.out + checked.run("diff", "--format", "markdown").out


def test_a_check_passes_the_limit_on_the_increase(checked, steps):
    assert checked.run("diff", "--max-increase", "0.1").code == 0
    checked.write("pick.py", steps(gripper="= 2.5e-07"))
    outcome = checked.run("diff", "--max-increase", "0.1")
    assert outcome.code == 1
    assert "mission failure rises by 14.7 %, over --max-increase 0.1" in outcome.err


def test_a_check_that_is_removed_fails_it(checked):
    later = checked.read("pick.py")
    checked.commit()
    checked.write(
        "pick.py", later.replace(b"safely 9/10, unaware 1/10", b"safely 1/9, unaware 8/9")
    )
    outcome = checked.run("diff", "--max-increase", "0.1")
    assert outcome.code == 1
    assert "undetected failure rises by" in outcome.err


def test_the_undetected_failure_has_a_limit_of_its_own(checked):
    assert checked.run("diff", "--max-undetected-probability", "2e-6").code == 0
    outcome = checked.run("diff", "--max-undetected-probability", "1e-6")
    assert outcome.code == 1
    assert "undetected failure 1.66e-06 is over --max-undetected-probability 1e-06" in outcome.err
    outcome = checked.run("solve", "pick.py", "--max-undetected-probability", "1e-6", "--json")
    assert outcome.code == 1
    assert outcome.json["assessment"]["mission"]["undetected_probability"] == pytest.approx(
        1.66e-6, rel=1e-3
    )


def test_what_is_undetected_is_in_metrics_json_and_badge(checked):
    outcome = checked.run("diff", "--metrics", "m.txt", "--json")
    (controller,) = outcome.json["controllers"]
    after = controller["after"]
    fraction = after["undetected_probability"] / after["failure_probability"]
    assert after["undetected_fraction"] == pytest.approx(fraction, rel=1e-12)
    text = checked.read("m.txt").decode()
    metrics = dict(re.findall(r"^tracerisk_(\w+)\{\S+ (\S+)$", text, re.MULTILINE))
    of_mission = {
        "undetected_probability": after["undetected_probability"],
        "undetected_probability_before": controller["before"]["undetected_probability"],
        "undetected_fraction": fraction,
        "stopped_late_probability": 0.0,
        "stopped_safely_probability": after["stopped_safely_probability"],
    }
    for name, value in of_mission.items():
        assert float(metrics[f"mission_{name}"]) == pytest.approx(value, rel=1e-5)
    assert checked.run("history", "pick.py", "--badge", "b.svg").code == 0
    assert b", undetected 1.66e-06" in checked.read("b.svg")
    model = checked.run("build", "pick.py", "-o", "model.json")
    assert model.code == 0, model.err
    (place,) = [s for s in json.loads(checked.read("model.json"))["states"] if "failures" in s]
    assert place["failures"]["gripper"] == [
        {"kind": "stopped_safely", "mode": "dead", "share": "9/10"},
        {"kind": "unaware", "mode": "dead", "share": "1/10"},
    ]
