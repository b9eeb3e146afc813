"""Changed controllers are run from memory, beside the run without a change, and kept."""

from concurrent.futures import Future
from dataclasses import replace

import pytest

from tests.commands import ForkedWorkers
from tracerisk import api
from tracerisk.common.campaign import CampaignOptions
from tracerisk.common.verdict import MISSION_MISSED, Reason
from tracerisk.errors import ControllerFailedError, InputError
from tracerisk.pipeline.evidence import workers
from tracerisk.pipeline.mutation import campaign
from tracerisk.pipeline.mutation.campaign import plan_mutation
from tracerisk.pipeline.mutation.mutant_run import MutantJob, compared, run_mutant
from tracerisk.trace import Location

TURNING = """\
import moveit_commander, rospy
import angles

def main():
    rospy.init_node("turning")
    arm = moveit_commander.MoveGroupCommander("panda_arm")
    joints = arm.get_current_joint_values()
    for turn in angles.TURNS:
        joints[0] += angles.scaled(turn)
        arm.go(joints, wait=True)

if __name__ == "__main__":
    main()
"""
ANGLES = """\
TURNS = [0.02, 0.03]

def scaled(turn):
    while False:
        pass
    return turn * 1.0

def unused():
    return 5.0
"""


@pytest.fixture(scope="module")
def turning(tmp_path_factory, example_in):
    """A controller of two files, whose run without a change is there."""
    folder = example_in(tmp_path_factory.mktemp("turning"))
    folder.write("turning.py", TURNING)
    folder.write("angles.py", ANGLES)
    folder.write("pyproject.toml", "[tool.tracerisk]\nstall_limit_s = 1\n")
    return folder


@pytest.fixture(scope="module")
def plan(turning):
    return plan_mutation(turning.folder / "turning.py", (), most=200)


def job_of(plan, turning, words):
    (change,) = [change for change in plan.changes if change.words == words]
    return MutantJob(str(turning.folder / "turning.py"), (), plan.nominal.digest, "", change)


def test_the_files_that_ran_are_changed_in_what_ran(plan):
    places = {(change.file, change.function) for change in plan.changes}
    assert places == {
        ("turning.py", "main"),
        ("angles.py", "<module>"),
        ("angles.py", "scaled"),
    }


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("words", "differs"),
    [
        (
            "the loop over angles.TURNS leaves out the last",
            "rest 2 of 2 at (0.365, 0.018, 0.434) m is no longer reached",
        ),
        (
            "wait=True becomes False",
            "rest 1 of 2 at (0.365, 0.007, 0.434) m is no longer reached",
        ),
    ],
)
def test_a_change_of_the_script_is_run_and_no_file_is_touched(plan, turning, words, differs):
    before = turning.files()
    done = run_mutant(job_of(plan, turning, words))
    assert done.is_altered
    assert done.is_whole
    assert differs in done.differs
    assert turning.files() == before


def test_a_change_of_a_module_is_run(plan, turning):
    done = run_mutant(job_of(plan, turning, "0.02 becomes 0.04"))
    assert (done.file, done.line, done.function) == ("angles.py", 1, "<module>")
    shifted = "2 rests of 2 are now 8 mm away, by (0, 8, 0) mm: 1, 2, the first at "
    assert any(line.startswith(shifted) for line in done.differs)
    assert (done.verdict, done.noticed_by) == ("complete", "nothing")


def test_a_change_that_is_too_small_to_matter_alters_nothing(plan, turning):
    done = run_mutant(job_of(plan, turning, "0.02 becomes 0.022"))
    assert not done.is_altered


def test_the_tolerances_of_the_settings_say_what_is_altered(tmp_path_factory, example_in):
    wide = example_in(tmp_path_factory.mktemp("wide"))
    wide.write("turning.py", TURNING)
    wide.write("angles.py", ANGLES)
    settings = "[tool.tracerisk]\noutcome_place_mm = 20.0\noutcome_joint_mrad = 50.0\n"
    wide.write("pyproject.toml", settings)
    plan = plan_mutation(wide.folder / "turning.py", (), most=200)
    assert not run_mutant(job_of(plan, wide, "0.02 becomes 0.04")).is_altered


def test_a_change_that_breaks_the_run_is_noticed_by_the_verdict(plan, turning):
    done = run_mutant(job_of(plan, turning, "0.02 becomes 20.0, as in mm"))
    assert (done.verdict, done.noticed_by) == ("faulted", "verdict")
    assert "is outside" in done.reason


def test_a_run_that_does_not_end_counts_as_noticed(plan, turning):
    job = job_of(plan, turning, "0.02 becomes 0.04")
    at = plan.nominal.recording.sources["angles.py"].index(b"False")
    endless = replace(job.change, start=at, end=at + 5, old=b"False", new=b"True")
    done = run_mutant(replace(job, change=endless))
    assert (done.verdict, done.is_whole, done.noticed_by) == ("stuck", False, "no whole run")
    assert done.is_altered
    assert done.by_success
    assert done.by_verdict


def test_a_program_that_is_refused_counts_as_noticed(plan, turning):
    job = job_of(plan, turning, "arm.go(joints, wait=True) is left out")
    done = run_mutant(replace(job, change=replace(job.change, new=b"(")))
    assert not done.is_whole
    assert "not valid Python" in done.reason
    assert done.noticed_by == "no whole run"


def test_the_run_without_a_change_must_be_the_same(plan, turning):
    job = job_of(plan, turning, "arm.go(joints, wait=True) is left out")
    with pytest.raises(InputError, match="differs from that of the campaign"):
        run_mutant(replace(job, digest="other"))


def judged(plan, *reasons):
    nominal = plan.nominal.trace
    verdict = replace(nominal.verdict, kind="faulted", reasons=reasons)
    return compared(plan.changes[0], nominal, replace(nominal, verdict=verdict))


def test_success_and_the_verdict_notice_by_their_own_reasons(plan):
    missed = Reason(MISSION_MISSED, "faulted", "the cup is not at its place")
    other = Reason("command-aborted", "faulted", "a motion ended", "main")
    assert not judged(plan).success_notices
    assert judged(plan, missed).noticed_by == "success"
    assert judged(plan, other).noticed_by == "verdict"
    assert judged(plan, missed, other).noticed_by == "success, verdict"
    assert judged(plan, missed, other).reason == "the cup is not at its place"


def test_a_reason_of_the_run_without_a_change_is_not_new(plan):
    nominal = plan.nominal.trace
    known = Reason("missed-call", "partial", "a call led to no command", "main", "arm.go")
    other = replace(known, object="arm.execute", location=Location("turning.py", 3))
    before = replace(nominal, verdict=replace(nominal.verdict, reasons=(known,)))
    after = replace(nominal, verdict=replace(nominal.verdict, reasons=(other,)))
    assert not compared(plan.changes[0], before, after).verdict_notices


def test_the_same_run_differs_in_nothing(plan):
    nominal = plan.nominal.trace
    assert not compared(plan.changes[0], nominal, nominal).is_altered


@pytest.mark.slow
def test_what_is_declared_is_noticed(example):
    path = example.write("turning.py", TURNING)
    example.write("angles.py", ANGLES)
    example.write("pyproject.toml", '[tool.tracerisk]\nscenario = "cell.yaml"\n')
    example.write("cell.yaml", "success:\n  - {joints: {panda_joint1: 0.05}, within: 0.004}\n")
    plan = plan_mutation(path, (), most=200)
    by = {}
    for words in ("0.02 becomes 0.04", "wait=True becomes False", "0.02 and 0.03 change places"):
        (change,) = [change for change in plan.changes if change.words == words]
        done = run_mutant(MutantJob(str(path), (), plan.nominal.digest, "", change))
        assert done.is_altered
        by[words] = done.noticed_by
    # The way there is no part of what is declared.
    assert list(by.values()) == ["success", "verdict", "nothing"]


def test_a_campaign_goes_on_where_it_was_and_ends_as_in_one_go(turning, monkeypatch):
    monkeypatch.setattr(workers, "_CONTEXT", ForkedWorkers())
    path = turning.folder / "turning.py"
    at_once = api.mutate(path, options=CampaignOptions(jobs=1), most=4)
    assert (len(at_once.runs), at_once.planned) == (4, 4)
    (journal,) = (turning.folder / ".tracerisk_cache").glob("mutate-*.jsonl")
    lines = journal.read_text().splitlines()
    # One was done, and the next was being written, when the campaign was killed.
    journal.write_text(f"{lines[0]}\n{lines[1][:30]}")
    tried = []

    class Here:
        def submit(self, function, job):
            tried.append(job)
            done = Future()
            done.set_result(function(job))
            return done

    assert api.mutate(path, options=CampaignOptions(executor=Here()), most=4) == at_once
    assert len(tried) == 3
    monkeypatch.setattr(campaign, "run_mutant", None)
    assert api.mutate(path, most=4) == at_once
    assert api.mutate(path, most=2).planned == 2


def test_a_changed_source_is_tried_anew(turning, example_in, tmp_path):
    other = example_in(tmp_path)
    other.write("turning.py", "# other lines\n" + TURNING)
    other.write("angles.py", ANGLES)
    other.write("pyproject.toml", "")
    first = plan_mutation(turning.folder / "turning.py", (), most=1)
    second = plan_mutation(tmp_path / "turning.py", (), most=1)
    assert first.journal.name != second.journal.name
    assert (
        first.journal.name == plan_mutation(turning.folder / "turning.py", (), most=9).journal.name
    )


def test_what_is_kept_of_other_inputs_is_removed(turning, monkeypatch):
    monkeypatch.setattr(workers, "_CONTEXT", ForkedWorkers())
    plan = plan_mutation(turning.folder / "turning.py", (), most=1)
    other = plan.journal.with_name(plan.journal.name.replace(".jsonl", "0.jsonl"))
    other.parent.mkdir(exist_ok=True)
    other.write_text("\n")
    api.mutate(turning.folder / "turning.py", options=CampaignOptions(jobs=1, fresh=True), most=1)
    assert plan.journal.is_file()
    assert not other.exists()


def test_a_run_without_a_mission_is_refused(example):
    path = example.write("idle.py", "import rospy\nrospy.init_node('idle')\n")
    with pytest.raises(ControllerFailedError, match="there is no mission to change"):
        api.mutate(path)
    with pytest.raises(InputError, match="0 changes; allowed: 1 to 10000"):
        api.mutate(path, most=0)
