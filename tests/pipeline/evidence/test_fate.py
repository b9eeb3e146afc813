"""A run with a failure ends once its fate is decided, at the same instant wherever it runs."""

import threading
from dataclasses import replace
from pathlib import Path

import pytest

from tests.pipeline.evidence.test_judgement import CELL
from tests.pipeline.run.branching.test_branches import check_equal
from tracerisk.common import trace_json
from tracerisk.common.evidence.cells import Cell
from tracerisk.common.evidence.file import cell_line
from tracerisk.pipeline.evidence import cell_runs, workers
from tracerisk.pipeline.evidence.cell_runs import CellBatch, fault_of, nominal_of, run_batch
from tracerisk.pipeline.run.branching.branches import Branch, run_branches
from tracerisk.pipeline.run.branching.fate import TOLD_S, UNTOLD_S
from tracerisk.pipeline.run.fault_run import run_with_faults
from tracerisk.twin.faults.fault import Fault

STEPS = 6
GOES_ON = f"""\
import sys
import moveit_commander, rospy

def turn(arm, by):
    wanted = arm.get_current_joint_values()
    wanted[0] = by
    arm.go(wanted, wait=True)

def first(arm):
    turn(arm, 0.4)

def second(arm):
    turn(arm, -0.4)

def only(arm):
    for number in range({STEPS}):
        arm.go([(-1) ** number * 0.4, *arm.get_current_joint_values()[1:]], wait=True)
        rospy.sleep(2.0)

def both(arm):
    for _ in range({STEPS // 2}):
        first(arm)
        rospy.sleep(2.0)
        second(arm)
        rospy.sleep(2.0)

def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("goes_on")
    arm = moveit_commander.MoveGroupCommander("panda_arm")
    arm.set_max_velocity_scaling_factor(1.0)
    WHAT(arm)

if __name__ == "__main__":
    main()
"""


def nominal(folder: Path, what: str = "both", scenario: str = ""):
    path = folder / "goes_on.py"
    path.write_text(GOES_ON.replace("WHAT", what))
    options = []
    if scenario:
        (folder / "mission.yaml").write_text(scenario)
        options.append(("scenario", str(folder / "mission.yaml")))
    return nominal_of(str(path), tuple(options))


def cell(mode: str = "jam", time_s: float = 1.0) -> Cell:
    return replace(CELL, unit="panda_joint1", mode=mode, time_s=time_s)


def fault(time_s: float = 1.0) -> Fault:
    return Fault("panda_joint1", "jam", time_s)


@pytest.fixture(scope="module")
def both(tmp_path_factory):
    """The run of six visits without a failure."""
    return nominal(tmp_path_factory.mktemp("both"))


@pytest.fixture(scope="module")
def claimed(both, tmp_path_factory):
    """A batch of three cells, the second of which another has claimed, and what came of it."""
    claims = tmp_path_factory.mktemp("claims")
    (claims / "1").touch()
    cells = (cell(), cell("dead", 1.0), cell("dead", 6.0))
    journal = tmp_path_factory.mktemp("kept") / "journal.jsonl"
    batch = CellBatch(
        str(both.controller.path),
        (),
        both.digest,
        cells,
        claims=str(claims),
        journal=str(journal),
    )
    return batch, run_batch(batch)


def test_cells_that_another_batch_has_claimed_are_left_to_it(claimed):
    batch, done = claimed
    assert [each.key for each in done.cells] == [batch.cells[0].key, batch.cells[2].key]
    assert not done.whole_runs
    assert sorted(each.name for each in Path(batch.claims).iterdir()) == ["0", "1", "2"]
    assert run_batch(batch).cells == ()


def test_each_cell_is_kept_as_soon_as_it_is_judged(claimed):
    batch, done = claimed
    kept = Path(batch.journal).read_text().splitlines()
    assert sorted(kept) == sorted(map(cell_line, done.cells))


def test_a_worker_that_ends_keeps_nothing_for_its_files_may_be_gone(claimed, monkeypatch, tmp_path):
    batch, _ = claimed
    ending = threading.Event()
    ending.set()
    monkeypatch.setattr(workers, "_ENDING", ending)
    journal = tmp_path / "journal.jsonl"
    alone = replace(batch, cells=batch.cells[:1], claims="", journal=str(journal))
    assert run_batch(alone).cells == ()
    assert not journal.exists()


def ended(found, cell: Cell, folder: Path, *, follows: bool = False):
    """Run a failure as a campaign does; return the trace of its run, and how it is judged.

    With `follows`, the run goes on to its end.
    """
    request = replace(found.run.request, beside=None if follows else found.beside)
    (result,) = run_branches(
        found.controller,
        found.settings,
        replace(found.run, request=request),
        [Branch(0, (fault_of(cell),))],
        keep=folder,
        beside=found.recording,
    )
    judged = cell_runs._judged(found, cell, result.done, None, folder / "0")
    return result.done.trace, judged


def test_a_controller_that_was_reported_and_goes_on_is_followed_for_ten_seconds(both, tmp_path):
    trace, _ = ended(both, cell(), tmp_path)
    (reported, *_) = (each.time_s for each in trace.findings if each.kind == "execution_failure")
    after = min(each.start_s for each in trace.visits if each.start_s > reported)
    assert trace.end.simulated_s == pytest.approx(after + TOLD_S, abs=0.002)
    assert trace.end.simulated_s < both.trace.end.simulated_s - 1.0
    whole = run_with_faults(both.controller, both.settings, both.run, [fault()]).trace
    assert whole.end.simulated_s > trace.end.simulated_s + 1.0


def test_what_is_judged_is_what_a_run_to_the_end_shows_by_then(claimed):
    _, done = claimed
    early, late = done.cells
    for each in (early, late):
        assert each.fails
        assert each.effect == "wrong_position"
        assert each.told_by == "execution_failure"
    assert early.lost == ("first aborted",)


@pytest.mark.slow
def test_a_visit_that_is_not_over_decides_nothing(tmp_path):
    # All commands are of one visit: that the last one fails is known at the end alone.
    found = nominal(tmp_path, "only")
    request = replace(found.run.request, beside=found.beside)
    cut = run_with_faults(
        found.controller, found.settings, replace(found.run, request=request), [fault()]
    ).trace
    assert cut.end.cause == "duration"
    batch = CellBatch(str(found.controller.path), (), found.digest, (cell(),))
    (judged,) = run_batch(batch).cells
    assert judged.lost == ("only aborted",)


@pytest.mark.slow
def test_a_declared_mission_is_followed_to_its_end(tmp_path):
    scenario = "success:\n  - {joints: {panda_joint1: -0.4}, within: 0.02}\n"
    found = nominal(tmp_path, scenario=scenario)
    assert found.beside.has_conditions
    trace, judged = ended(found, cell(), tmp_path)
    whole, _ = ended(found, cell(), tmp_path / "whole", follows=True)
    assert trace_json.dumps(trace) == trace_json.dumps(whole)
    assert judged.fails
    assert judged.lost[0].startswith("missed: ")


@pytest.mark.parametrize(
    "faults",
    [
        ((fault(),),),
        pytest.param(((Fault("panda_joint2", "dead", 2.0),),), marks=pytest.mark.slow),
        pytest.param(((fault(7.3),),), marks=pytest.mark.slow),
    ],
    ids=["early", "dead", "late"],
)
def test_a_branch_ends_where_a_run_from_the_beginning_on_threads_does(both, faults, tmp_path):
    request = replace(both.run.request, beside=both.beside)
    before = replace(both.run, request=request)
    wanted = [Branch(index, each) for index, each in enumerate(faults)]
    check_equal(both.controller, both.settings, before, wanted, tmp_path)


@pytest.mark.slow
def test_an_arm_that_is_elsewhere_when_the_next_visit_begins_ends_its_run(tmp_path):
    found = nominal(tmp_path, "first(arm); rospy.sleep(1.0); second(arm); rospy.sleep(24.0); first")
    # While the arm rests nobody notices, and what follows succeeds.
    shifted = replace(cell("offset", 2.6), unit="panda_joint3/encoder")
    trace, judged = ended(found, shifted, tmp_path)
    _, second = trace.visits
    assert [each.outcome for each in trace.visits] == ["succeeded", "succeeded"]
    assert trace.end.simulated_s == pytest.approx(second.start_s + UNTOLD_S, abs=0.002)
    assert (judged.effect, judged.told_by) == ("wrong_position", "")
    assert judged.lost[0].startswith("panda_joint3 off by ")


@pytest.mark.slow  # one that is elsewhere ends its run as soon, and test_judgement.py has collisions
def test_an_arm_that_fell_on_itself_ends_its_run(tmp_path):
    # Nobody looks at the arm for half a minute, and nothing is told.
    found = nominal(tmp_path, "first(arm); rospy.sleep(30.0); second")
    trace, judged = ended(found, replace(cell("dead", 5.0), unit="panda_joint2"), tmp_path)
    touch = min(
        each.start_s for visit in trace.visits for each in visit.contacts if not each.expected
    )
    assert trace.end.simulated_s == pytest.approx(touch + UNTOLD_S, abs=0.1)
    assert (judged.effect, judged.told_by) == ("collision", "")
