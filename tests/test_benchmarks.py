"""What the programs that measure the project say."""

import argparse
import csv
import hashlib
import importlib.metadata
import importlib.util
import json
import re
import sys
from pathlib import Path
from types import ModuleType

import pytest

from tests.slow import slow_but

ROOT = Path(__file__).parents[1]
STARTED = {"upstream_child.py"}
"""Started by another program, with a task that only it can give."""
PROGRAMS = sorted(
    path.name
    for path in (ROOT / "benchmarks").glob("*.py")
    if '__name__ == "__main__"' in path.read_text(encoding="utf-8") and path.name not in STARTED
)
LONG = {
    *("activity_truth.py", "branches.py", "broken_controllers.py", "bug_reports.py"),
    *("check_speed.py", "comments.py", "corpus.py", "editor_times.py", "fault_trees.py"),
    *("greenlets.py", "hardware_reading.py", "history_speed.py", "independent_missions.py"),
    *("merge_histories.py", "needed.py", "planning.py"),
    *("run_overhead.py", "sandbox.py", "start_up.py", "streams.py", "upstream_tests.py"),
    *("watch_speed.py", "worlds.py"),
}
"""Those whose quick form makes several runs, or merges, or waits for what it measures."""
SPAWNING = {"prism_suite.py"}
"""Those whose workers import the program again: it has to be the main module from the start."""


@pytest.mark.parametrize("program", PROGRAMS)
def test_every_program_says_how_it_is_started_and_has_a_quick_form(program):
    text = (ROOT / "benchmarks" / program).read_text(encoding="utf-8")
    assert f"python benchmarks/{program}" in text
    assert re.search(r"^from quick import .*\bparsed\b|^import quick\b", text, re.MULTILINE)


@pytest.mark.slow(but=12)
@pytest.mark.parametrize("program", slow_but(set(PROGRAMS) - LONG, PROGRAMS))
def test_every_program_has_a_quick_form_that_works(program, example):
    script = ROOT / "benchmarks" / program
    done = example.run("--quick", script=script, is_afresh=program in SPAWNING)
    if done.code == 77:
        pytest.skip(done.out.strip())
    assert done.code == 0, done.out + done.err
    assert done.out.strip()
    assert not example.files(), "it leaves files where it was started"


def test_a_quick_form_finds_a_file_that_has_moved(monkeypatch):
    quick = _loaded("quick", monkeypatch)
    monkeypatch.setattr(sys.modules["__main__"], "SCENES", ROOT / "nowhere", raising=False)
    with pytest.raises(SystemExit, match=r"SCENES is .*nowhere, which is not there"):
        quick.parsed(argparse.ArgumentParser(), ["--quick"])
    assert not quick.parsed(argparse.ArgumentParser(), []).quick


@pytest.mark.parametrize(
    ("verdict", "reasons", "is_noticed"),
    [
        ("complete", (), False),
        ("complete", ("unmet-need",), False),
        ("partial", (), False),
        ("partial", ("assumed-part",), False),
        ("partial", ("assumed-part", "unmet-need"), True),
        ("faulted", ("raised",), True),
        ("stuck", (), True),
        ("refused", (), True),
        ("internal error", (), False),
    ],
)
def test_a_broken_mission_is_noticed_by_the_rules_alone(verdict, reasons, is_noticed, monkeypatch):
    broken = _loaded("broken_controllers", monkeypatch)

    def outcome(kind, *codes):
        return broken.Outcome(kind, frozenset((code, "pick", "") for code in codes), "", None)

    unbroken = outcome("partial", "assumed-part")
    assert broken.is_noticed(unbroken, outcome(verdict, *reasons)) is is_noticed


@pytest.fixture
def corpus(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    return _loaded("corpus", monkeypatch)


def test_the_page_of_comments_shows_every_change(monkeypatch):
    comments = _loaded("comments", monkeypatch)
    page = (ROOT / "docs" / "comments.md").read_text(encoding="utf-8")
    assert re.findall(r"^## (.+)$", page, re.MULTILINE) == [one.title for one in comments.CHANGES]
    texts = re.findall(r"````markdown\n(.*?)````", page, re.DOTALL)
    assert comments.page_of(list(zip(comments.CHANGES, texts, strict=True))) == page
    assert len(texts[0].splitlines()) == 2
    assert (ROOT / "docs" / "pictures" / "comments.png").stat().st_size < 400_000


def _loaded(name: str, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    path = ROOT / "benchmarks" / f"{name}.py"
    monkeypatch.syspath_prepend(path.parent)
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, name, module)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(
    ("distribution", "modules"), [("pyyaml", {"yaml"}), ("pillow", {"PIL"}), ("six", {"six"})]
)
def test_the_modules_of_a_distribution_are_those_of_its_metadata(
    distribution, modules, monkeypatch
):
    table = _loaded("module_table", monkeypatch)
    assert table.modules_of(importlib.metadata.distribution(distribution)) == modules


def test_the_pages_say_of_active_and_needed_what_the_benchmark_wrote(monkeypatch):
    needed = _loaded("needed", monkeypatch)
    with (ROOT / "benchmarks" / "needed.csv").open(encoding="utf-8", newline="") as file:
        rows = [needed.Row(*row[:3], *map(int, row[3:])) for row in list(csv.reader(file))[1:]]
    theory = (ROOT / "docs" / "theory.md").read_text()
    section = theory.split("### Active against needed\n")[1].split("\n### ")[0]
    assert "\n".join(needed.table_of(rows)) in section
    tries, reported = sum(sum(row[3:7]) for row in rows), sum(row.reported for row in rows)
    assert f"Of the {tries:,} failures {reported:,} were reported to the controller" in section
    assert len({row.sample for row in rows}) == 7
    assert f"[{tries:,} injected failures]" in (ROOT / "docs" / "safety.md").read_text()


@pytest.mark.parametrize(
    ("code", "cause", "is_traced"),
    [(0, "ended", True), (1, "ended", True), (4, "wall_limit", False), (4, "raised", False)],
)
def test_a_row_of_the_corpus_is_traced_only_if_its_run_came_to_a_good_end(
    corpus, code, cause, is_traced
):
    trace = {"functions": [{"name": "pick"}], "end": {"cause": cause}}
    row = corpus._row("repo:pick.py", 1.0, {"exit_code": code, "trace": trace})
    assert row.is_traced is is_traced
    assert row.functions == 1


def test_a_run_that_moved_nothing_is_no_trace(corpus):
    row = corpus._row("repo:pick.py", 1.0, {"exit_code": 0, "trace": {"functions": []}})
    assert not row.is_traced


def test_at_least_nine_in_ten_of_the_rows_judged_by_hand_are_true():
    with (ROOT / "benchmarks" / "corpus_truth.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    keys = [hashlib.sha256(f"{row['repo']}:{row['path']}".encode()).hexdigest() for row in rows]
    assert len(set(keys)) == 40
    assert keys == sorted(keys)
    judged = [{row[what] for what in ("robot", "steps", "motions")} for row in rows]
    assert all(words <= {"true", "false"} for words in judged)
    assert sum(words == {"true"} for words in judged) >= 36
    assert all(row["note"] for row in rows)


@pytest.mark.parametrize(
    ("kind", "verdict", "seconds", "counts"),
    [
        ("", "complete", 3.0, True),
        ("", "partial", 120.0, True),
        ("", "partial", 121.0, False),
        ("", "faulted", 3.0, False),
        ("f", "faulted", 3.0, True),
        ("f", "stuck", 3.0, False),
    ],
)
def test_a_row_of_the_corpus_counts_by_its_verdict_and_its_time(
    corpus, kind, verdict, seconds, counts
):
    trace = {"functions": [{"name": "pick"}], "end": {"cause": "ended"}}
    code = {"complete": 0, "partial": 0, "faulted": 1, "stuck": 4}[verdict]
    found = {"exit_code": code, "trace": trace, "verdict": {"kind": verdict}}
    row = corpus._row("repo:pick.py", seconds, found)
    assert row.counts(kind) is counts


def test_the_shares_leave_out_the_rows_that_cannot_give_a_trace(corpus):
    trace = {"functions": [{"name": "pick"}], "end": {"cause": "ended"}}
    found = {"exit_code": 0, "trace": trace, "verdict": {"kind": "complete"}}
    rows = [
        corpus._row("repo:pick.py", 1.0, found),
        corpus._row("repo:slow.py", 150.0, found),
        corpus._row("repo:two.py", 1.0, {"exit_code": 2}),
    ]
    reported = corpus.shares(rows, {"repo:two.py": "a"})
    assert reported.startswith("1 of 2 rows outside class a (50.0%)")
    assert reported.endswith("took longer: repo:slow.py")


def test_each_row_with_a_class_has_a_reason(corpus, tmp_path):
    assert set(corpus.classes().values()) <= {"a", "f"}
    file = tmp_path / "classes.csv"
    file.write_text("repo,path,class,reason\nsome/arm,pick.py,a,\n")
    with pytest.raises(ValueError, match=r"some/arm:pick\.py: no class or no reason"):
        corpus.classes(file)


TESTS_OF_A_LIBRARY = """\
import threading
import rclpy
import test_rclpy
from test_msgs.msg import Word
from test_msgs.fixtures import WORDS


def test_passes():
    assert Word(text=WORDS[0]).text == "go"


def test_hangs():
    threading.Event().wait()


def test_fails_behind_one_that_hangs():
    assert rclpy.ok()


def test_take_from_the_layer_below():
    raise AssertionError
"""


# The two programs of tests measure the project, and are no part of what is installed.
@pytest.mark.slow
def test_the_tests_of_a_library_are_run_on_the_stand_ins_and_judged(tmp_path, monkeypatch, capsys):
    upstream = _loaded("upstream_tests", monkeypatch)
    texts, library = tmp_path / "texts" / "test_msgs", tmp_path / "rclpy" / "rclpy" / "test"
    for folder in (texts / "msg", texts / "src" / "test_msgs", library):
        folder.mkdir(parents=True)
    (texts / "msg" / "Word.msg").write_text("string text\n")
    (texts / "src" / "test_msgs" / "fixtures.py").write_text('WORDS = ["go"]\n')
    (library / "test_words.py").write_text(TESTS_OF_A_LIBRARY)
    scope = tmp_path / "scope.csv"
    scope.write_text(
        "test,kind,reason\n"
        "rclpy/test_words.py::test_take_*,out,needs the layer below\n"
        "rclpy/test_words.py::test_hangs,fails,waits for ever\n"
    )
    monkeypatch.setattr(upstream, "SCOPE", scope)
    found = tmp_path / "found.json"
    arguments = ["--rclpy", tmp_path / "rclpy", "--test-msgs", tmp_path / "texts", "--json", found]
    monkeypatch.setattr(sys, "argv", ["upstream_tests.py", *map(str, arguments)])
    assert upstream.main() == 1
    outcomes = {each["test"]: each["outcome"] for each in json.loads(found.read_text())}
    assert outcomes == {
        "rclpy/test_words.py::test_passes": "passed",
        "rclpy/test_words.py::test_hangs": "failed",
        "rclpy/test_words.py::test_fails_behind_one_that_hangs": "failed",
        "rclpy/test_words.py::test_take_from_the_layer_below": "out",
    }
    said = capsys.readouterr().out
    assert "1 of 3 in scope pass: 33.3%" in said
    assert "waits for ever" in said
    assert "test_fails_behind_one_that_hangs\n    not known to fail: " in said


LAUNCH_OF_TESTS = """
<launch>
  <param name="speed" value="2" type="int"/>
  <node name="server" pkg="lab" type="server.py"/>
  <test test-name="test_lab" pkg="lab" type="test_lab.py"/>
</launch>
"""
SERVER = """
import rospy
from lab.srv import Twice, TwiceResponse

rospy.init_node("server")
rospy.Service("twice", Twice, lambda request: TwiceResponse(2 * request.number))
rospy.spin()
"""
TESTS_OF_A_PROGRAM = """
import unittest
import rospy
from lab.srv import Twice


class TestLab(unittest.TestCase):
    def test_the_server_beside_it_answers(self):
        rospy.wait_for_service("twice")
        assert rospy.ServiceProxy("twice", Twice)(rospy.get_param("/speed")).number == 4

    def test_it_has_the_name_that_the_launch_file_gives(self):
        assert rospy.get_name() == "/test_lab"


def test_that_is_none():
    raise AssertionError


if __name__ == "__main__":
    import rostest
    rospy.init_node("other")
    rostest.rosrun("lab", "test_lab", TestLab)
"""


@pytest.mark.slow
def test_a_program_of_tests_of_ros_1_runs_beside_the_nodes_of_its_launch_file(
    tmp_path, monkeypatch
):
    upstream = _loaded("upstream_tests", monkeypatch)
    package = tmp_path / "actionlib" / "actionlib"
    files = {
        "package.xml": "<package><name>lab</name></package>",
        "srv/Twice.srv": "int32 number\n---\nint32 number\n",
        "nodes/server.py": SERVER,
        "test/lab.launch": LAUNCH_OF_TESTS,
        "test/test_lab.py": TESTS_OF_A_PROGRAM,
    }
    for name, text in files.items():
        (package / name).parent.mkdir(parents=True, exist_ok=True)
        (package / name).write_text(text)
    found = tmp_path / "found.json"
    arguments = ["--actionlib", tmp_path / "actionlib", "--json", found]
    monkeypatch.setattr(sys, "argv", ["upstream_tests.py", *map(str, arguments)])
    assert upstream.main() == 0
    tests = "noetic/actionlib/lab.launch/test_lab::TestLab::test_"
    assert {each["test"]: each["outcome"] for each in json.loads(found.read_text())} == {
        f"{tests}it_has_the_name_that_the_launch_file_gives": "passed",
        f"{tests}the_server_beside_it_answers": "passed",
    }


def test_a_command_without_a_checkout_says_what_it_needs(monkeypatch, capsys):
    upstream = _loaded("upstream_tests", monkeypatch)
    monkeypatch.setattr(sys, "argv", ["upstream_tests.py"])
    with pytest.raises(SystemExit):
        upstream.main()
    assert "name one with --rclpy DIR" in capsys.readouterr().err


def test_every_rule_of_the_scope_has_a_reason_and_a_kind(monkeypatch):
    rules = _loaded("upstream_tests", monkeypatch).rules()
    assert {rule.kind for rule in rules} == {"out", "fails"}
    assert all(rule.reason and rule.test.partition("/")[2] for rule in rules)


def test_the_page_says_every_reason_and_the_command_as_it_is(monkeypatch, capsys):
    upstream = _loaded("upstream_tests", monkeypatch)
    page = (ROOT / "docs" / "upstream.md").read_text(encoding="utf-8")
    reported = {line.partition(": `")[0].lower() for line in page.splitlines() if ": `" in line}
    assert {f"- {rule.reason}".lower() for rule in upstream.rules()} <= reported
    monkeypatch.setattr(sys, "argv", ["upstream_tests.py", "--help"])
    with pytest.raises(SystemExit):
        upstream.main()
    options = capsys.readouterr().out
    shown = set(re.findall(r"(?<![-|])--[a-z][\w-]*", page))
    assert shown
    assert [each for each in sorted(shown) if each not in options] == []
