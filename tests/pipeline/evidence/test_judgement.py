"""What a failure did to a mission: each effect alone, and what a scenario declares."""

from dataclasses import replace

import pytest

from tracerisk.common.evidence.cells import Cell
from tracerisk.common.function_ref import FunctionRef
from tracerisk.common.traced.elements import Contact
from tracerisk.common.traced.findings import Finding
from tracerisk.common.verdict import Reason, Verdict
from tracerisk.errors import Location
from tracerisk.pipeline.evidence.judgement import judge
from tracerisk.pipeline.evidence.mission_run import MissionRun
from tracerisk.pipeline.run.fault_run import FaultRun
from tracerisk.trace import ObjectOffset, RunEnd, Trace, TracedCommand, TracedFunction, Visit
from tracerisk.twin.faults.fault import Fault

PICK, PLACE = FunctionRef("cell.py", "pick"), FunctionRef("cell.py", "place")
CELL = Cell(
    component="motor",
    unit="joint_1",
    mode="dead",
    time_s=2.0,
    use="moving",
    function="pick",
    drawn=True,
    active_s=1.5,
    states_s=(1.0, 0.5, 0.0),
)


def visit(ref, start_s, outcome="succeeded", contacts=()):
    return Visit(ref, start_s, 2.0, outcome, {}, contacts=tuple(contacts))


def run(**changes):
    """A good run of two visits that puts a tube into its slot."""
    arrivals = changes.pop("arrivals", ({"joint_1": 0.5}, {"joint_1": -0.5}))
    things = changes.pop("things", {"tube": (0.1, 0.2, 0.3)})
    trace = Trace(
        controller="cell.py",
        robot="panda",
        scene="empty",
        end=RunEnd("ended", "the controller ended", 4.0),
        elements=(),
        functions=(TracedFunction(PICK, 1, 1), TracedFunction(PLACE, 5, 2)),
        visits=(visit(PICK, 0.0), visit(PLACE, 2.0)),
        objects=(ObjectOffset("tube", "slot", 0.001, 0.0, True),),
        verdict=Verdict("complete"),
    )
    return MissionRun(replace(trace, **changes), arrivals, things)


def judged(failed, *, has_conditions=False):
    return judge(run(), failed, CELL, has_conditions=has_conditions)


def test_the_same_run_shows_no_effect():
    cell = judged(run())
    assert (cell.effect, cell.fails, cell.told_after_s, cell.lost) == ("nothing", False, None, ())


def test_a_new_touch_is_a_collision_with_its_force_and_time():
    touch = Contact("link_4", "table", 2.5, 0.2, 31.0, expected=False)
    cell = judged(run(visits=(visit(PICK, 0.0), visit(PLACE, 2.0, contacts=[touch]))))
    assert (cell.effect, cell.fails, cell.effect_after_s) == ("collision", True, 0.5)
    assert cell.contact == "link_4 on table, 31 N"


def test_a_touch_that_the_run_without_had_too_is_none():
    touch = Contact("link_4", "table", 2.5, 0.2, 31.0, expected=False)
    both = (visit(PICK, 0.0), visit(PLACE, 2.0, contacts=[touch]))
    assert judge(run(visits=both), run(visits=both), CELL).effect == "nothing"


def test_a_grasp_in_the_run_without_excuses_no_other_touch_of_the_same_two():
    grasp = Contact("finger", "tube", 0.5, 1.0, 15.0, expected=True)
    blow = Contact("finger", "tube", 2.5, 0.02, 35.5, expected=False)
    nominal = run(visits=(visit(PICK, 0.0, contacts=[grasp]), visit(PLACE, 2.0)))
    failed = run(visits=(visit(PICK, 0.0, contacts=[grasp]), visit(PLACE, 2.0, contacts=[blow])))
    assert judge(nominal, nominal, CELL).effect == "nothing"
    cell = judge(nominal, failed, CELL)
    assert (cell.effect, cell.fails, cell.contact) == ("collision", True, "finger on tube, 35.5 N")


def test_what_fell_is_dropped():
    fell = Reason("object-dropped", "faulted", "'tube' fell", object="tube", time_s=3.0)
    cell = judged(run(verdict=Verdict("faulted", (fell,))))
    assert (cell.effect, cell.fails, cell.effect_after_s) == ("dropped", True, 1.0)


@pytest.mark.parametrize(
    "offset",
    [
        ObjectOffset("tube", "slot", 0.02, 0.0, True),
        ObjectOffset("tube", "slot", 0.001, 1.5, False),
        ObjectOffset("tube", None, 0.001, 0.0, True),
    ],
)
def test_a_thing_off_its_goal_is_not_placed(offset):
    cell = judged(run(objects=(offset,)))
    assert (cell.effect, cell.fails) == ("not_placed", True)
    assert cell.lost == ("tube not at slot",)


@pytest.mark.parametrize(
    ("place", "effect"), [((0.1, 0.2, 0.3), "nothing"), ((0.13, 0.2, 0.3), "not_placed")]
)
def test_a_thing_that_lies_where_it_lay_is_not_lost_by_a_goal_that_another_left(place, effect):
    astray = ObjectOffset("tube", "slot", 0.3, 0.0, True)
    failed = run(objects=(replace(astray, goal="free", offset_m=0.2),), things={"tube": place})
    assert judge(run(objects=(astray,)), failed, CELL).effect == effect


def test_a_thing_without_a_goal_is_to_end_where_it_ended():
    nominal = run(objects=(), things={"cup": (0.0, 0.0, 0.0)})
    failed = run(objects=(), things={"cup": (0.03, 0.0, 0.0)})
    assert judge(nominal, failed, CELL).effect == "not_placed"


@pytest.mark.parametrize("cause", ["raised", "deadlock", "wall_limit", "died", "duration"])
def test_a_run_that_does_not_end_by_itself_ended_badly(cause):
    cell = judged(run(end=RunEnd(cause, "it went wrong", 3.5)))
    assert (cell.effect, cell.fails) == ("ended_badly", True)


def test_a_visit_that_ends_elsewhere_is_a_wrong_position():
    cell = judged(run(arrivals=({"joint_1": 0.55}, {"joint_1": -0.5})))
    assert (cell.effect, cell.fails, cell.effect_after_s) == ("wrong_position", True, 0.0)
    assert cell.lost == ("joint_1 off by 0.05 after pick",)


@pytest.mark.parametrize(
    "visits",
    [
        (visit(PICK, 0.0),),
        (visit(PICK, 0.0), visit(PICK, 2.0)),
        (visit(PICK, 0.0), visit(PLACE, 2.0, "aborted")),
    ],
)
def test_a_visit_that_is_missing_or_aborted_is_a_wrong_position(visits):
    cell = judged(run(visits=visits))
    assert (cell.effect, cell.fails) == ("wrong_position", True)


def test_late_alone_does_not_end_a_mission():
    cell = judged(run(end=RunEnd("ended", "the controller ended", 9.0)))
    assert (cell.effect, cell.fails, cell.lost) == ("late", False, ("5.0 s later",))


def test_a_report_alone_does_not_end_a_mission_and_has_its_delay():
    found = Finding("execution_failure", "the goal was aborted", 2.75)
    before = Finding("execution_failure", "an earlier one", 0.5)
    cell = judged(run(findings=(before, found)))
    assert (cell.effect, cell.fails) == ("told", False)
    assert (cell.told_after_s, cell.told_by) == (0.75, "execution_failure")


def test_the_worst_effect_leads():
    touch = Contact("link_4", "table", 2.5, 0.2, 31.0, expected=False)
    cell = judged(run(visits=(visit(PICK, 0.0, contacts=[touch]),), objects=()))
    assert cell.effect == "collision"
    assert "place was not visited, but nothing" in cell.lost


MISSED = Reason("mission-missed", "faulted", "tube ends 40 mm from slot", object="tube")


@pytest.mark.parametrize(
    ("reason", "lost"),
    [
        (MISSED, ("missed: tube ends 40 mm from slot",)),
        (replace(MISSED, accepted="slot 2 will do"), ()),
        (replace(MISSED, code="input-assumed", verdict="partial"), ()),
    ],
    ids=["declared", "accepted", "assumed"],
)
def test_a_declared_mission_fails_by_the_conditions_that_its_verdict_misses(reason, lost):
    cell = judged(run(verdict=Verdict("faulted", (reason,))), has_conditions=True)
    assert (cell.fails, cell.lost) == (bool(lost), lost)


def test_a_declared_mission_that_is_met_survives_a_wrong_position():
    failed = run(arrivals=({"joint_1": 0.9}, {"joint_1": -0.5}))
    cell = judged(failed, has_conditions=True)
    assert (cell.effect, cell.fails) == ("wrong_position", False)


def test_a_declared_mission_fails_by_a_collision():
    touch = Contact("link_4", "table", 2.5, 0.2, 31.0, expected=False)
    failed = run(visits=(visit(PICK, 0.0), visit(PLACE, 2.0, contacts=[touch])))
    assert judged(failed, has_conditions=True).fails


def test_of_a_run_that_ended_early_it_is_kept_how_long_it_was_followed():
    good = run()
    failed = run(end=RunEnd("duration", "decided", 23.5))
    assert judge(good, failed, CELL).followed_s is None
    assert judge(good, replace(failed, is_decided=True), CELL).followed_s == 21.5


@pytest.mark.parametrize(
    ("kind", "told"), [("follow_joint_trajectory", "execution_failure"), ("joint_trajectory", "")]
)
def test_who_publishes_a_trajectory_is_told_nothing_of_its_end(kind, told):
    sent = TracedCommand(PICK, 7, kind, ("joint_1",), 1.0, 2.5, "aborted")
    aborted = Finding("execution_failure", "aborted", 2.5, Location("cell.py", 7, 5))
    failed = run(commands=(sent,), findings=(aborted,))
    assert judged(failed).told_by == told
    faults = FaultRun((Fault("joint_1", "dead", 2.0),), run().trace, failed.trace)
    assert faults.reported == ((aborted,) if told else ())
    assert faults.other_findings == (() if told else (aborted,))
