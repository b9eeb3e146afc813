"""The verdict of a run, judged over what was recorded: no simulation."""

from dataclasses import replace

import numpy as np
import pytest

from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.common.traced.findings import Finding
from tracerisk.common.verdict import Acceptance, Coverage, Uncovered, verdict_line
from tracerisk.common.verdict_codes import ACCEPTABLE, CODES
from tracerisk.errors import Location
from tracerisk.pipeline.trace.falls import down_upright
from tracerisk.pipeline.trace.judge import judge, with_acceptances
from tracerisk.pipeline.trace.recorded_run import (
    Fall,
    IssuedCommand,
    MissedCommand,
    RecordedRun,
    UnmetNeed,
)
from tracerisk.trace import RunEnd

GOOD = RunEnd("ended", "the controller ended", 10.0)
HERE = Location("cell.py", 12)
ALL_RAN = Coverage(3, 3)


def recorded(**parts) -> RecordedRun:
    return RecordedRun(**{"end": GOOD, "coverage": ALL_RAN, "commands": (move(1.0),), **parts})


def finding(kind: str, **parts) -> Finding:
    given = {"message": f"a {kind}", "time_s": 2.0, "location": HERE, "function": "pick"}
    return Finding(kind, **{**given, **parts})


def move(issue_s: float, **parts) -> IssuedCommand:
    given = {
        "kind": "follow",
        "function": "move",
        "location": HERE,
        "elements": ("joint1",),
        "end_s": issue_s + 1.0,
        "end": "arrived",
        "goal": (0.5,),
        "callers": ("run", "move"),
        "path": ("run", "move"),
    }
    return IssuedCommand(issue_s=issue_s, **{**given, **parts})


def grip(issue_s: float, how: str, **parts) -> IssuedCommand:
    given = {"elements": ("hand",), "gripper": "hand", "grip": how, "goal": (0.0,)}
    return move(issue_s, **{**given, "kind": "gripper", "path": (how,), **parts})


def codes(run: RecordedRun) -> list[str]:
    return [each.code for each in judge(run).reasons]


def test_a_run_in_which_nothing_failed_is_complete():
    verdict = judge(recorded(commands=(move(1.0), move(3.0))))
    assert verdict.kind == "complete"
    assert verdict_line(verdict) == "complete, 3 of 3 functions with commands ran"


@pytest.mark.parametrize(
    ("kind", "code"),
    [
        ("execution_failure", "command-rejected"),
        ("goal_rejected", "command-rejected"),
        ("command_ignored", "command-ignored"),
        ("service_refused", "service-refused"),
        ("lookup_failure", "lookup-failed"),
        ("ik_failure", "ik-failed"),
        ("fk_failure", "fk-failed"),
        ("planning_failure", "planning-failed"),
        ("path_cut", "path-cut"),
        ("attach_failure", "attach-failed"),
        ("callback_failed", "callback-raised"),
        ("thread_failed", "thread-raised"),
        ("error_logged", "error-logged"),
    ],
)
def test_what_failed_and_was_not_retried_makes_the_run_faulted(kind, code):
    verdict = judge(recorded(findings=(finding(kind, object="part"),)))
    (reason,) = verdict.reasons
    assert verdict.kind == "faulted"
    assert (reason.code, reason.function, reason.object) == (code, "pick", "part")
    assert (reason.location, reason.time_s) == (HERE, 2.0)


@pytest.mark.parametrize(
    "kind", ["not_simulated", "assumed_name", "assumed_start", "concurrent_owners"]
)
def test_a_note_is_no_reason(kind):
    assert judge(recorded(findings=(finding(kind),))).kind == "complete"


def test_a_failure_whose_retry_succeeded_is_no_reason():
    found = finding("lookup_failure", object="part", recovered_s=4.0)
    assert judge(recorded(findings=(found,))).kind == "complete"


def test_an_error_logged_between_a_failure_and_its_retry_is_settled_with_it():
    found = finding("lookup_failure", object="part", recovered_s=4.0)
    logged = finding("error_logged", time_s=2.1)
    assert codes(recorded(findings=(found, logged))) == []
    late = finding("error_logged", time_s=4.1)
    assert codes(recorded(findings=(found, late))) == ["error-logged"]
    elsewhere = finding("error_logged", time_s=2.1, function="place")
    assert codes(recorded(findings=(found, elsewhere))) == ["error-logged"]


def test_an_aborted_command_is_a_reason_in_the_words_of_its_finding():
    aborted = move(1.0, end="aborted")
    text = finding(
        "execution_failure", function="move", message="a goal was aborted", target=(0.5,)
    )
    verdict = judge(recorded(commands=(aborted,), findings=(text,)))
    (reason,) = verdict.reasons
    assert (reason.code, reason.words, reason.object) == (
        "command-aborted",
        "a goal was aborted",
        "joint1",
    )


def test_an_aborted_command_that_no_finding_speaks_of_is_a_reason_all_the_same():
    (reason,) = judge(recorded(commands=(move(1.0, end="aborted"),))).reasons
    assert reason.code == "command-aborted"
    assert "joint1" in reason.words


def test_a_command_of_the_same_function_and_goal_that_succeeds_later_is_its_retry():
    aborted = move(1.0, end="aborted")
    assert codes(recorded(commands=(aborted, move(3.0)))) == []


@pytest.mark.parametrize("other", [{"goal": (0.9,)}, {"function": "lift"}, {"kind": "move_group"}])
def test_another_goal_function_or_kind_is_no_retry(other):
    aborted = move(1.0, end="aborted")
    assert codes(recorded(commands=(aborted, move(3.0, **other)))) == ["command-aborted"]


def test_a_refused_goal_that_is_met_later_is_no_reason():
    refused = finding("goal_rejected", function="move", target=(0.5,))
    assert codes(recorded(findings=(refused,), commands=(move(3.0),))) == []
    assert codes(recorded(findings=(refused,), commands=(move(1.0),))) == ["command-rejected"]


def test_a_preempted_command_is_no_reason():
    assert codes(recorded(commands=(move(1.0, end="cancelled"), move(1.5)))) == []


@pytest.mark.parametrize(
    ("cause", "code", "kind"),
    [
        ("raised", "run-raised", "faulted"),
        ("exited", "run-exited", "faulted"),
        ("deadlock", "run-deadlock", "stuck"),
        ("no_motion", "run-no-motion", "stuck"),
        ("wall_limit", "run-wall-limit", "stuck"),
        ("memory_limit", "run-memory-limit", "stuck"),
        ("died", "run-died", "stuck"),
        ("not_importable", "run-not-importable", "stuck"),
    ],
)
def test_a_bad_end_is_a_reason(cause, code, kind):
    verdict = judge(recorded(end=RunEnd(cause, "why", 3.0, HERE), end_function="pick"))
    (reason,) = verdict.reasons
    assert (verdict.kind, reason.code, reason.function) == (kind, code, "pick")


def test_the_default_duration_that_cuts_a_run_makes_it_partial():
    end = RunEnd("duration", "the simulated time is over", 300.0)
    assert codes(recorded(end=end)) == ["duration-cut"]
    assert judge(recorded(end=end)).kind == "partial"


def test_a_duration_that_the_user_gave_is_no_reason():
    end = RunEnd("duration", "the simulated time is over", 300.0)
    assert judge(recorded(end=end, is_duration_given=True)).kind == "complete"


def test_a_function_that_never_ran_makes_the_run_partial():
    never = Uncovered(FunctionRef("cell.py", QualifiedName("Cell.recover")), 40)
    verdict = judge(recorded(coverage=Coverage(3, 4, (never,))))
    assert [each.code for each in verdict.reasons] == ["never-ran"]
    assert str(verdict.reasons[0].location) == "cell.py:40"
    assert verdict_line(verdict) == "partial, 3 of 4 functions with commands ran"


def test_an_unmet_need_makes_the_run_partial_and_names_it():
    need = UnmetNeed("/gripper/on", "service /gripper/on (std_srvs/SetBool)", HERE, "pick")
    verdict = judge(recorded(unmet=(need,)))
    assert verdict.kind == "partial"
    assert "nothing provides service /gripper/on" in verdict_line(verdict)


def test_a_frame_that_was_looked_up_in_vain_is_reported_once():
    need = UnmetNeed("part", "frame part", HERE, "pick", is_frame=True)
    found = finding("lookup_failure", object="part")
    assert codes(recorded(unmet=(need,), findings=(found,))) == ["lookup-failed"]


def test_what_nobody_publishes_and_a_companion_that_died_are_unmet():
    found = (finding("unprovided", object="/camera"), finding("companion_failed"))
    assert codes(recorded(findings=found)) == ["unmet-need", "companion-failed"]


def test_a_question_whose_answer_is_assumed_is_one_reason():
    need = UnmetNeed("'[h]ome'", "an answer to '[h]ome'")
    found = finding("answer_assumed", object="'[h]ome'")
    assert codes(recorded(unmet=(need,), findings=(found,))) == ["input-assumed"]
    assert codes(recorded(unmet=(need,))) == ["unmet-need"]


def test_what_of_the_robot_is_assumed_makes_the_run_partial():
    verdict = judge(recorded(assumed=(("generic", "a generic arm was taken"),)))
    assert (verdict.kind, verdict.reasons[0].object) == ("partial", "generic")


def test_a_gripper_that_is_commanded_as_another_one_is_assumed():
    verdict = judge(recorded(findings=(finding("foreign_gripper", object="hand"),)))
    assert (verdict.kind, verdict.reasons[0].code) == ("partial", "robot-assumed")


# Grasps


PICK = (grip(0.0, "opens"), move(1.0), grip(2.0, "closes"), move(3.0), grip(4.0, "opens"))


def held(command: IssuedCommand) -> IssuedCommand:
    return replace(command, holds=True)


def test_a_grasp_on_nothing_that_is_carried_and_let_go_is_a_fault():
    (reason,) = judge(recorded(commands=PICK, has_objects=True)).reasons
    assert (reason.code, reason.object, reason.time_s) == ("grasped-nothing", "hand", 2.0)


def test_a_grasp_in_a_scene_without_things_to_grasp_is_none():
    assert codes(recorded(commands=PICK)) == []


def test_a_grasp_that_holds_is_no_reason():
    commands = (*PICK[:2], held(PICK[2]), *PICK[3:])
    assert codes(recorded(commands=commands, has_objects=True)) == []


def test_a_call_that_holds_at_another_time_meant_to_hold():
    missed = tuple(replace(each, issue_s=each.issue_s + 10.0, posture=(1.0,)) for each in PICK)
    commands = (*PICK[:2], held(PICK[2]), *PICK[3:], *missed)
    (reason,) = judge(recorded(commands=commands)).reasons
    assert (reason.code, reason.time_s) == ("grasped-nothing", 12.0)


def test_a_second_try_at_the_same_place_clears_a_grasp_on_nothing():
    again = tuple(replace(each, issue_s=each.issue_s + 10.0) for each in PICK)
    commands = (*PICK, *again[:2], held(again[2]), *again[3:])
    assert codes(recorded(commands=commands, has_objects=True)) == []


def cycle(start_s: float, *grips: IssuedCommand) -> tuple[IssuedCommand, ...]:
    """Open, move, the commands to the gripper, move, and let go by a call of its own."""
    again = [replace(each, issue_s=start_s + 2.0 + rank) for rank, each in enumerate(grips)]
    let_go = grip(start_s + 9.0, "opens", path=("release",))
    return grip(start_s, "opens"), move(start_s + 1.0), *again, move(start_s + 8.0), let_go


CLOSE = grip(0.0, "closes", goal=(0.024,), posture=(1.0,))
CARRIED = cycle(0.0, held(grip(0.0, "closes", goal=(0.024,))))
ABORTED = replace(CLOSE, end="aborted")


def test_a_retry_that_opens_a_gripper_which_closed_on_nothing_is_no_success():
    opened = replace(CLOSE, grip="opens")
    run = recorded(commands=(*CARRIED, *cycle(20.0, ABORTED, opened)), has_objects=True)
    assert codes(run) == ["command-aborted", "grasped-nothing"]
    # Where there is nothing to grasp, nothing is held whatever a controller does.
    assert codes(recorded(commands=cycle(20.0, ABORTED, opened))) == []


def test_a_gripper_that_opens_on_nothing_and_is_let_go_as_if_it_held_is_a_fault():
    opened = grip(0.0, "opens", path=("reopen",))
    commands = (*CARRIED, *cycle(20.0, CLOSE, opened))
    assert codes(recorded(commands=commands, has_objects=True)) == ["grasped-nothing"]
    # It may be open already when it is to let go.
    idle = (*commands[:-1], replace(commands[-1], grip=None))
    assert codes(recorded(commands=idle, has_objects=True)) == ["grasped-nothing"]


def test_a_controller_that_opens_on_nothing_and_begins_anew_is_not_at_fault():
    opened = grip(0.0, "opens", path=("reopen",))
    turned_back = cycle(20.0, CLOSE, opened)[:-1]
    later = cycle(40.0, held(grip(0.0, "closes", goal=(0.024,), posture=(2.0,))))
    run = recorded(commands=(*CARRIED, *turned_back, *later), has_objects=True)
    assert codes(run) == []


def test_a_gripper_that_closes_and_opens_on_the_spot_is_no_grasp():
    commands = (grip(0.0, "closes"), grip(1.0, "opens"), move(2.0))
    assert codes(recorded(commands=commands, has_objects=True)) == []


def test_a_gripper_that_travels_closed_from_the_begin_is_no_grasp():
    commands = (grip(0.0, "closes"), move(1.0), grip(2.0, "opens"))
    assert codes(recorded(commands=commands, has_objects=True)) == []


def test_a_gripper_that_is_parked_closed_after_the_work_is_no_grasp():
    commands = (*PICK[:2], held(PICK[2]), *PICK[3:], move(5.0), grip(6.0, "closes", path=("park",)))
    assert codes(recorded(commands=(*commands, move(7.0)), has_objects=True)) == []


LEFT_OPEN = (grip(0.0, "opens"), move(1.0), grip(2.0, None), move(3.0))


def test_a_gripper_that_never_closes_on_what_there_is_to_grasp_is_a_reason():
    verdict = judge(recorded(commands=LEFT_OPEN, has_objects=True))
    (reason,) = verdict.reasons
    assert (verdict.kind, reason.code, reason.object) == ("partial", "never-grasped", "hand")
    assert "hand was commanded 2 times and never closed" in reason.words


def test_a_gripper_that_is_sent_to_where_it_is_again_and_again_is_a_reason_without_objects_too():
    (reason,) = judge(recorded(commands=LEFT_OPEN)).reasons
    assert (reason.code, reason.verdict) == ("never-grasped", "partial")
    assert "commanded 2 times and stayed as it was after the first time" in reason.words


@pytest.mark.parametrize(
    ("commands", "has_objects"),
    [
        ((*LEFT_OPEN, grip(4.0, "closes")), False),
        (LEFT_OPEN[:2], True),
        ((LEFT_OPEN[0], LEFT_OPEN[2], LEFT_OPEN[1]), True),
        ((*LEFT_OPEN, grip(4.0, "closes")), True),
        ((*LEFT_OPEN, held(grip(4.0, None)), grip(5.0, "opens")), True),
        ((LEFT_OPEN[0], LEFT_OPEN[1], grip(2.0, None, goal=())), True),
    ],
    ids=["closed at the end", "once", "no motion between", "closed", "held", "no goal known"],
)
def test_a_gripper_that_may_stay_open_is_no_reason(commands, has_objects):
    assert codes(recorded(commands=commands, has_objects=has_objects)) == []


PICKED = (*PICK[:2], held(PICK[2]), PICK[3])
"""Open, go there, grip a thing, and lift it."""
CUT = {cause: RunEnd(cause, "the run was cut", 10.0) for cause in ("duration", "cycles")}


def later(commands, by_s):
    return tuple(replace(each, issue_s=each.issue_s + by_s) for each in commands)


PLACED = (*PICKED, grip(8.0, "opens"), move(9.0))
OTHER = tuple(replace(each, gripper="left" if each.gripper else "") for each in later(PICKED, 20.0))


@pytest.mark.parametrize(
    "commands",
    [
        PICKED,
        PICKED[1:],
        # The gripper was tried before, and let go of nothing.
        (grip(0.1, "closes", path=("try",)), grip(0.2, "opens"), *PICKED),
        (*PICKED, move(9.0), move(11.0)),
        # A thing that is handed over: the one hand opens when the other holds it.
        (*PICKED, *OTHER, grip(30.0, "opens"), move(31.0)),
    ],
    ids=["a pick", "no opening first", "a gripper tried", "carried on", "handed over"],
)
def test_a_pick_that_ends_with_what_it_took_is_no_reason(commands):
    assert codes(recorded(commands=commands)) == []


@pytest.mark.parametrize(
    "parts",
    [
        {"commands": PICKED[:3]},
        {"commands": (*PLACED, *later(PICKED, 20.0))},
        {"commands": (*PLACED, *OTHER)},
        {"commands": PICKED, "end": CUT["cycles"]},
        {"commands": PICKED, "end": CUT["duration"], "is_duration_given": True},
    ],
    ids=["not lifted", "others were released", "by another hand", "a loop", "cut"],
)
def test_what_is_held_at_the_end_is_a_reason_where_it_is_no_pick(parts):
    (reason,) = judge(recorded(**parts)).reasons
    assert (reason.code, reason.verdict) == ("never-released", "partial")


def test_a_last_grasp_without_a_release_is_a_reason_where_the_same_call_had_one_before():
    again = tuple(replace(each, issue_s=each.issue_s + 10.0) for each in PICK)
    assert codes(recorded(commands=(*PICK, *again[:4]))) == ["never-released"]
    assert codes(recorded(commands=PICK)) == []


def test_a_last_grasp_on_nothing_is_not_said_to_hold():
    held_before = (*PICK[:2], held(PICK[2]), *PICK[3:])
    empty = replace(PICK[2], issue_s=12.0, place="at (0.450, 0.000, 0.078) m", posture=(1.0,))
    (reason,) = judge(recorded(commands=(*held_before, move(11.0), empty, move(13.0)))).reasons
    assert reason.code == "never-released"
    assert reason.words == (
        "hand closed on nothing at (0.450, 0.000, 0.078) m, and was not opened again"
    )


@pytest.mark.parametrize(
    ("was_held", "code"), [(True, "object-dropped"), (False, "object-knocked")]
)
def test_a_thing_that_fell_is_a_reason_at_the_last_command(was_held, code):
    fall = Fall("tube", 3.5, 0.15, was_held)
    (reason,) = judge(recorded(commands=(move(1.0), move(9.0)), falls=(fall,))).reasons
    assert (reason.code, reason.function, reason.object) == (code, "move", "tube")
    assert "fell 150 mm" in reason.words


@pytest.mark.parametrize(
    ("name", "touched_s", "is_said"),
    [("tube", 3.4, True), ("tube", 1.0, False), ("tube_2", 3.4, False)],
)
def test_the_touch_before_a_thing_slips_is_in_its_reason(name, touched_s, is_said):
    words = f"unexpected contact: {name}, which is held, touches rack in place: up to 275 N; may bear 20 N"
    touch = finding("unexpected_contact", message=words, time_s=touched_s)
    fall = Fall("tube", 3.5, 0.15, True, slipped_from="hand")
    (reason,) = judge(recorded(findings=(touch,), falls=(fall,))).reasons
    said = "(unexpected contact: tube, which is held, touches rack in place: up to 275 N, 0.10 s before)"
    assert (said in reason.words) is is_said


def test_a_thing_that_tipped_is_a_reason():
    (reason,) = judge(recorded(falls=(Fall("tube", 3.5, 0.0, False, is_tipped=True),))).reasons
    assert reason.code == "object-tipped"
    assert reason.words == "'tube' tipped over after the robot touched it"


def test_a_thing_that_fell_and_tipped_is_one_reason():
    (reason,) = judge(recorded(falls=(Fall("tube", 3.5, 0.15, True, True, 0.009),))).reasons
    assert reason.code == "object-dropped"
    assert reason.words == (
        "'tube' fell 150 mm (its middle; 9 mm before it began to tip) and tipped over after it was "
        "let go"
    )


def test_the_height_under_a_thing_is_told_from_its_tipping():
    height = np.array([0.20, 0.195, 0.191, 0.15, 0.13])
    tilts = np.radians([0.0, 0.0, 1.0, 40.0, 90.0])
    axis = np.stack((np.sin(tilts), np.zeros(5), np.cos(tilts)), axis=1)
    assert down_upright(height, axis) == pytest.approx(0.009)
    assert down_upright(height[:3], axis[:3]) == pytest.approx(0.009)


@pytest.mark.parametrize(("height", "also"), [(0.003, ""), (0.15, ", and fell 150 mm")])
def test_a_thing_that_slipped_is_a_reason_however_far_it_fell(height, also):
    fall = Fall("tube", 3.5, height, True, slipped_from="hand")
    (reason,) = judge(recorded(falls=(fall,))).reasons
    assert reason.code == "object-slipped"
    assert reason.words == f"'tube' slipped out of hand, which was not opened{also}"


# Order, acceptances


def test_the_worst_and_earliest_reason_comes_first():
    run = recorded(
        findings=(finding("error_logged", time_s=2.0), finding("lookup_failure", time_s=1.0)),
        unmet=(UnmetNeed("x", "service x"),),
        end=RunEnd("deadlock", "waits for ever", 3.0),
    )
    assert codes(run) == ["run-deadlock", "lookup-failed", "error-logged", "unmet-need"]


def test_what_fails_again_and_again_at_one_place_is_one_reason():
    found = tuple(finding("ik_failure", object="arm", time_s=float(t)) for t in range(4))
    (reason,) = judge(recorded(findings=found)).reasons
    assert reason.time_s == 0.0


ACCEPTED = Acceptance("lookup-failed", "pick", "part", "the part may be gone")


def test_an_accepted_reason_makes_the_verdict_no_worse():
    found = (finding("lookup_failure", object="part"),)
    verdict = judge(recorded(findings=found), (ACCEPTED,))
    assert verdict.kind == "complete"
    assert [each.accepted for each in verdict.reasons] == ["the part may be gone"]
    assert verdict.unused_acceptances == ()


@pytest.mark.parametrize("other", [{"code": "ik-failed"}, {"function": "place"}, {"object": "lid"}])
def test_an_acceptance_of_something_else_accepts_nothing_and_is_unused(other):
    found = (finding("lookup_failure", object="part"),)
    verdict = judge(recorded(findings=found), (replace(ACCEPTED, **other),))
    assert verdict.kind == "faulted"
    assert len(verdict.unused_acceptances) == 1


def test_what_is_stuck_cannot_be_accepted():
    end = RunEnd("deadlock", "waits for ever", 3.0, HERE)
    accepted = Acceptance("run-deadlock", "pick", "", "never mind")
    verdict = judge(recorded(end=end, end_function="pick"), (accepted,))
    assert verdict.kind == "stuck"


def test_other_acceptances_judge_a_kept_verdict_anew():
    verdict = judge(recorded(findings=(finding("lookup_failure", object="part"),)))
    accepted = with_acceptances(verdict, (ACCEPTED,))
    assert accepted.kind == "complete"
    assert with_acceptances(accepted, ()).kind == "faulted"


def test_every_code_that_is_not_stuck_may_be_accepted():
    stuck = {code for code in CODES if code not in ACCEPTABLE}
    assert stuck == {
        *("run-deadlock", "run-no-motion", "run-wall-limit", "run-memory-limit"),
        *("run-died", "run-not-importable"),
    }


def test_a_run_without_a_command_is_partial():
    verdict = judge(recorded(commands=()))
    assert verdict.kind == "partial"
    assert [each.code for each in verdict.reasons] == ["no-command"]


def test_a_call_that_led_to_no_command_is_reported_first_and_may_be_accepted():
    missed = MissedCommand("pick", "self.arm.go", HERE)
    verdict = judge(recorded(missed=(missed,)))
    assert verdict_line(verdict) == (
        "partial: this call of self.arm.go led to no command; another did (cell.py:12, in pick); "
        "3 of 3 functions with commands ran"
    )
    accepted = Acceptance("missed-call", "pick", "self.arm.go", "a second try")
    assert judge(recorded(missed=(missed,)), [accepted]).kind == "complete"
    branch = MissedCommand("pick", "self.arm.go", HERE, was_executed=False)
    verdict = judge(recorded(missed=(branch,)), [accepted])
    assert verdict_line(verdict) == (
        "partial: this call of self.arm.go never ran: what it would command is in no "
        "figure (cell.py:12, in pick); 3 of 3 functions with commands ran"
    )
    assert [reason.code for reason in verdict.reasons] == ["never-called"]


def test_a_function_to_which_only_an_exception_leads_is_counted_and_no_reason():
    never = Uncovered(FunctionRef("cell.py", QualifiedName("Cell.recover")), 40, is_spare=True)
    verdict = judge(recorded(coverage=Coverage(3, 4, (never,))))
    assert verdict_line(verdict) == "complete, 3 of 4 functions with commands ran"


@pytest.mark.parametrize(
    ("end", "expected"),
    [
        ("cancelled", ["past-limit"]),
        (None, ["past-limit"]),
        ("arrived", ["past-limit"]),
        # Its abort tells what happened.
        ("aborted", ["command-aborted"]),
    ],
)
def test_a_goal_past_a_limit_is_a_fault_however_its_motion_ended(end, expected):
    words = "to 9, past its limits [-2.9, 2.9]"
    past = move(1.0, end=end, past_limit="joint1", past_words=words)
    found = judge(recorded(commands=(past, move(3.0, goal=(0.1,)))))
    assert [each.code for each in found.reasons] == expected
    assert found.reasons[0].object == "joint1"


def test_the_reason_of_a_verdict_is_one_of_that_verdict_and_only_those_are_counted():
    branch = MissedCommand("pick", "self.arm.go", HERE, was_executed=False)
    falls = (Fall("tube", 3.5, 0.15, True),)
    moves = (move(1.0), move(9.0))
    line = verdict_line(judge(recorded(commands=moves, missed=(branch,), falls=falls)))
    assert line.startswith("faulted: 'tube' fell 150 mm after it was let go (")
    assert "more)" not in line
    falls = (*falls, Fall("cup", 4.5, 0.15, True))
    line = verdict_line(judge(recorded(commands=moves, missed=(branch,), falls=falls)))
    assert line.startswith("faulted: 'tube' fell")
    assert " (and 1 more); " in line


def test_a_reason_in_a_helper_names_the_line_that_called_it_and_moves_with_it():
    aborted = replace(move(1.0, end="aborted"), called_from=Location("cell.py", 131))
    (reason,) = judge(recorded(commands=(aborted,))).open_reasons
    # It is aborted when it ends, whenever it was issued.
    assert ", called from line 131, at 2.0 s)" in str(reason)
    refused = replace(
        finding("planning_failure", function="move"), called_from=Location("other.py", 7)
    )
    (reason,) = judge(recorded(findings=(refused,))).open_reasons
    assert "called from line 7 of other.py" in str(reason)
    verdict = judge(recorded(commands=(aborted,))).with_lines(lambda file, line: line + 9)
    assert "called from line 140" in str(verdict)
