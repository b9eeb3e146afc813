"""A run with a failure ends once its fate is decided, at the same instant wherever it runs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from tests.pipeline.evidence.test_judgement import CELL
from tests.pipeline.test_branches import check_equal, jam
from tracerisk import trace_json
from tracerisk.evidence.cells import Cell
from tracerisk.pipeline.evidence.cell_runs import CellBatch, nominal_of, run_batch
from tracerisk.pipeline.run.branching.branches import Branch, run_branches
from tracerisk.pipeline.run.branching.fate import TOLD_S, UNTOLD_S
from tracerisk.pipeline.run.fault_run import run_with_faults
from tracerisk.twin.faults.fault import Fault

STEPS = 8
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


def run(found, *cells: Cell):
    options = () if found.settings.scenario is None else (("scenario", found.settings.scenario),)
    return run_batch(CellBatch(str(found.controller.path), options, found.digest, cells)).cells


def test_cells_that_another_batch_has_claimed_are_left_to_it(tmp_path):
    found = nominal(tmp_path)
    cells = (cell(), cell("dead", 6.0), cell("dead", 1.0))
    claims = tmp_path / "claims"
    claims.mkdir()
    (claims / "1").touch()
    batch = CellBatch(str(found.controller.path), (), found.digest, cells, claims=str(claims))
    done = run_batch(batch)
    assert [each.key for each in done.cells] == [cells[0].key, cells[2].key]
    assert not done.whole_runs
    assert sorted(each.name for each in claims.iterdir()) == ["0", "1", "2"]
    assert run_batch(batch).cells == ()


def ended(found, fault: Fault, *, follows: bool = False):
    """Run a failure as a campaign does; with `follows`, to its end."""
    request = replace(found.run.request, beside=None if follows else found.beside)
    (result,) = run_branches(
        found.controller,
        found.settings,
        replace(found.run, request=request),
        [Branch(0, (fault,))],
        beside=found.recording,
    )
    return result.done.trace


def test_a_controller_that_was_reported_and_goes_on_is_followed_for_ten_seconds(tmp_path):
    found = nominal(tmp_path)
    trace = ended(found, jam(1, time_s=1.0).faults[0])
    (reported, *_) = (each.time_s for each in trace.findings if each.kind == "execution_failure")
    after = min(each.start_s for each in trace.visits if each.start_s > reported)
    assert trace.end.simulated_s == pytest.approx(after + TOLD_S, abs=0.002)
    assert trace.end.simulated_s < found.trace.end.simulated_s - 1.0
    whole = ended(found, jam(1, time_s=1.0).faults[0], follows=True)
    assert whole.end.simulated_s > trace.end.simulated_s + 1.0


def test_what_is_judged_is_what_a_run_to_the_end_shows_by_then(tmp_path):
    found = nominal(tmp_path)
    early, late = run(found, cell(), cell("dead", 6.0))
    for each in (early, late):
        assert each.fails
        assert each.effect == "wrong_position"
        assert each.told_by == "execution_failure"
    assert early.lost == ("first aborted",)


def test_a_visit_that_is_not_over_decides_nothing(tmp_path):
    # All commands are of one visit: that the last one fails is known at the end alone.
    found = nominal(tmp_path, "only")
    request = replace(found.run.request, beside=found.beside)
    cut = run_with_faults(
        found.controller, found.settings, replace(found.run, request=request), [fault()]
    ).trace
    assert cut.end.cause == "duration"
    (judged,) = run(found, cell())
    assert judged.lost == ("only aborted",)


def fault(time_s: float = 1.0) -> Fault:
    return Fault("panda_joint1", "jam", time_s)


def test_a_declared_mission_is_followed_to_its_end(tmp_path):
    scenario = "success:\n  - {joints: {panda_joint1: -0.4}, within: 0.02}\n"
    found = nominal(tmp_path, scenario=scenario)
    assert found.beside.has_conditions
    trace = ended(found, fault())
    assert trace_json.dumps(trace) == trace_json.dumps(ended(found, fault(), follows=True))
    (judged,) = run(found, cell())
    assert judged.fails
    assert judged.lost[0].startswith("missed: ")


def test_a_branch_ends_where_a_run_from_the_beginning_on_threads_does(tmp_path):
    found = nominal(tmp_path)
    request = replace(found.run.request, beside=found.beside)
    before = replace(found.run, request=request)
    wanted = [jam(1, 0, 1.0), jam(1, 1, 7.3), Branch(2, (Fault("panda_joint2", "dead", 2.0),))]
    check_equal(found.controller, found.settings, before, wanted, tmp_path)


def test_an_arm_that_is_elsewhere_when_the_next_visit_begins_ends_its_run(tmp_path):
    found = nominal(tmp_path, "first(arm); rospy.sleep(1.0); second(arm); rospy.sleep(60.0); first")
    # While the arm rests nobody notices, and what follows succeeds.
    shifted = Fault("panda_joint3/encoder", "offset", 2.6)
    trace = ended(found, shifted)
    _, second = trace.visits
    assert [each.outcome for each in trace.visits] == ["succeeded", "succeeded"]
    assert trace.end.simulated_s == pytest.approx(second.start_s + UNTOLD_S, abs=0.002)
    (judged,) = run(found, replace(cell("offset", 2.6), unit="panda_joint3/encoder"))
    assert (judged.effect, judged.told_by) == ("wrong_position", "")
    assert judged.lost[0].startswith("panda_joint3 off by ")


def test_an_arm_that_fell_on_itself_ends_its_run(tmp_path):
    # Nobody looks at the arm for a minute, and nothing is told.
    found = nominal(tmp_path, "first(arm); rospy.sleep(60.0); second")
    trace = ended(found, Fault("panda_joint2", "dead", 5.0))
    touch = min(
        each.start_s for visit in trace.visits for each in visit.contacts if not each.expected
    )
    assert trace.end.simulated_s == pytest.approx(touch + UNTOLD_S, abs=0.1)
    (judged,) = run(found, replace(cell("dead", 5.0), unit="panda_joint2"))
    assert (judged.effect, judged.told_by) == ("collision", "")
