"""The verdict of a run as settings, scenarios and reviews see it."""

import json
import re
from pathlib import Path

import pytest

from tracerisk.adder.lock.lock import data_digest
from tracerisk.cli.authors.check import _lines
from tracerisk.errors import Location
from tracerisk.pipeline.check.finding import Checked, CheckFinding

ACCEPT = '[tool.tracerisk]\naccept = [{%s, words = "a lamp that is often out"}]\n'
LOGGED = 'code = "error-logged", function = "act", object = "lamp # is out"'


@pytest.fixture
def logs(quick):
    return quick('rospy.logerr("lamp 4 is out")')


def first_line(outcome) -> str:
    return outcome.out.splitlines()[0]


def test_a_line_of_error_makes_a_run_faulted(example, logs):
    example.write("c.py", logs)
    outcome = example.run("run", "c.py")
    assert outcome.code == 1
    assert first_line(outcome).startswith("faulted: it logged ERROR: lamp 4 is out (c.py:")


def test_an_accepted_reason_passes_and_stays_visible(example, logs):
    example.write("c.py", logs)
    example.write("pyproject.toml", ACCEPT % LOGGED)
    outcome = example.run("run", "c.py")
    assert outcome.code == 0, outcome.err
    assert first_line(outcome).startswith("partial, ")
    assert "accepted: it logged ERROR: lamp 4 is out" in outcome.out
    assert "a lamp that is often out" in outcome.out
    assert example.run("check", "c.py").code == 0


def test_a_scenario_accepts_as_well(example, logs):
    example.write("c.py", logs)
    entry = {"code": "error-logged", "function": "act", "object": "lamp # is out", "words": "old"}
    example.write("world.yaml", json.dumps({"accept": [entry]}))
    assert example.run("run", "c.py", "--scenario", "world.yaml").code == 0


def test_an_acceptance_that_does_not_occur_is_reported_by_run_and_check(example, quick):
    example.write("c.py", quick())
    example.write("pyproject.toml", ACCEPT % LOGGED)
    ran, checked = example.run("run", "c.py"), example.run("check", "c.py")
    assert (ran.code, checked.code) == (0, 0)
    assert "accepted, and did not occur: error-logged of 'lamp # is out' in act" in ran.out
    assert "accepted, and did not occur; remove it: error-logged" in checked.err


def test_a_check_says_once_how_reasons_are_mended_and_the_entries_where_asked(example, quick):
    example.write("c.py", quick('rospy.logerr("no lamp")', 'rospy.logerr("no tube")'))
    assert example.run("run", "c.py", "-q").code == 1
    brief = example.run("check", "c.py").out
    assert re.search(r"faulted: it logged ERROR: no lamp \(in act\)\n", brief)
    assert brief.count("`tracerisk run c.py`") == 1
    assert "accept = " not in brief
    assert "c.py: for each of these 2: mend it, then `tracerisk run c.py`" in brief
    whole = example.run("check", "c.py", "-v")
    assert whole.out.count("accept = [{code = ") == 2
    assert 'accept = [{code = "never-ran", function = "home", words = "WHY"}]' in whole.err
    remedies = [finding["remedy"] for finding in example.run("check", "--json").json["findings"]]
    assert all("accept = [{code = " in remedy for remedy in remedies)


def test_no_entry_is_promised_for_reasons_that_none_accepts():
    place = Location("c.py", 1)
    faulted = CheckFinding(
        "faulted", "x", place, remedy="mend it, or in [tool.tracerisk] accept = [1]"
    )
    stuck = faulted._replace(kind="stuck", remedy="mend it")
    checked = Checked(Path("c.py"), (faulted, stuck, stuck._replace(message="y")))
    *_, last = _lines(checked, is_brief=True)
    assert last == "c.py: for each of these 2: mend it"


def test_a_refresh_names_the_lines_that_a_check_then_names(example, logs, hardware):
    example.write("c.py", logs)
    example.run("run", "c.py", "-q")
    place = re.compile(r"c\.py:\d+, in act")
    checked = place.findall(example.run("check", "-v").out)
    assert checked
    assert checked == place.findall(example.run("refresh").err)
    # With one component the blocks are shorter.
    example.write("arm.yaml", hardware)
    example.write("pyproject.toml", '[tool.tracerisk]\nhardware = "arm.yaml"\n')
    refreshed = place.findall(example.run("refresh", "c.py").err)
    assert refreshed == place.findall(example.run("check", "-v").out) != checked


def test_a_change_that_accepts_its_own_fault_is_reported_first_and_can_fail(
    repository, logs, quick
):
    repository.write("c.py", quick())
    assert repository.run("run", "c.py", "-q").code == 0
    repository.commit()
    repository.write("c.py", logs)
    repository.write("pyproject.toml", ACCEPT % LOGGED)
    assert repository.run("run", "c.py", "-q", "--discard-edits").code == 0
    outcome = repository.run("diff")
    assert outcome.code == 0
    out = " ".join(outcome.out.split())
    assert out.startswith("newly accepted: error-logged of 'lamp # is out' in act: ")
    assert "; what happened: it logged ERROR: lamp 4 is out (c.py:" in out
    assert "setting accept has a new entry with code 'error-logged', function 'act', object" in out
    page = repository.run("diff", "--format", "markdown").out
    assert page.splitlines()[1].startswith("newly accepted: error-logged")
    strict = repository.run("diff", "--no-new-accepts")
    assert strict.code == 1
    assert "newly accepted, and --no-new-accepts: error-logged" in strict.err


def test_of_a_lock_of_before_verdicts_and_of_code_that_did_not_run_the_verdict_is_unknown(
    example, quick
):
    example.write("c.py", quick())
    assert example.run("run", "c.py", "-q").code == 0
    assert first_line(example.run("solve", "c.py")).startswith("partial, ")
    ran = example.read("c.py")
    example.write("c.py", ran + b"\nLATER = 1\n")
    assert first_line(example.run("solve", "c.py")) == "verdict unknown", "of code that did not run"
    example.write("c.py", ran)
    lock = json.loads(example.read("tracerisk.lock"))
    entry = lock["controllers"]["c.py"]
    del entry["trace"]["verdict"], entry["trace"]["digest"]
    entry["digest"] = data_digest(entry)
    example.write("tracerisk.lock", json.dumps(lock))
    checked = example.run("check", "c.py")
    assert (checked.code, checked.out) == (0, "c.py: verdict unknown\n")
    assert "`tracerisk refresh c.py` gives it one" in checked.err
    assert first_line(example.run("solve", "c.py")) == "verdict unknown", "of an old lock"
    assert example.run("refresh", "c.py").code == 0
    assert example.run("check", "c.py").out.startswith("c.py: partial, ")


def test_a_retry_that_succeeds_clears_a_look_up(example, quick):
    retry = (
        "import tf2_ros",
        "frames = tf2_ros.Buffer(); listener = tf2_ros.TransformListener(frames)",
        "found = None",
        "while found is None:",
        "    try: found = frames.lookup_transform('panda_link0', 'part', rospy.Time())",
        "    except tf2_ros.LookupException: rospy.logerr('no part yet'); rospy.sleep(0.2)",
    )
    example.write("c.py", quick(*retry))
    example.write(
        "world.yaml",
        "publish:\n  - topic: /tf\n    type: tf2_msgs/TFMessage\n    at: [6.0]\n"
        "    message: {transforms: [{header: {frame_id: panda_link0}, child_frame_id: part,\n"
        "      transform: {rotation: {w: 1.0}}}]}\n",
    )
    outcome = example.run("trace", "c.py", "--scenario", "world.yaml")
    assert outcome.code == 0, outcome.out + outcome.err
    assert first_line(outcome).startswith("partial, ")
    assert "a retry at" in outcome.out


def test_places_are_files_as_the_user_would_type_them(repository, logs):
    repository.write("src/cell/package.xml", "<package/>")
    repository.write("src/cell/scripts/c.py", logs)
    repository.commit()
    for arguments in (
        ("run", "src/cell/scripts/c.py"),
        ("solve", "src/cell/scripts/c.py"),
        ("diff",),
    ):
        told = " ".join(repository.run(*arguments).out.split())
        assert "faulted: it logged ERROR: lamp 4 is out (src/cell/scripts/c.py:" in told, arguments
    verdict, finding = repository.run("check").out.splitlines()
    assert verdict.startswith("src/cell/scripts/c.py: faulted: it logged ERROR: lamp 4 is out (src")
    assert re.match(r"src/cell/scripts/c\.py:\d+: faulted: it logged ERROR: lamp 4", finding)
    traced = repository.run("trace", "src/cell/scripts/c.py")
    assert first_line(traced).startswith("faulted: it logged ERROR: lamp 4 is out (src/cell/")
    assert "\nsrc/cell/scripts/c.py on panda in scene empty, " in traced.err
