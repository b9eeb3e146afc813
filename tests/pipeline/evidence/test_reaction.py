"""How a controller reacted to a failure: its commands, handlers and log beside the nominal run."""

from dataclasses import replace

import pytest

from tests.pipeline.evidence.test_judgement import CELL, PICK, PLACE, run, visit
from tracerisk.common.evidence.advice import advice_of
from tracerisk.common.function_ref import FunctionRef
from tracerisk.common.traced.findings import Finding
from tracerisk.common.verdict import Reason, Verdict
from tracerisk.errors import Location
from tracerisk.instrument.commands import Command
from tracerisk.instrument.marks.call_log import CALLS
from tracerisk.instrument.recording import SIGN, Note, Recording
from tracerisk.instrument.tracer import Frame
from tracerisk.pipeline.evidence.judgement import judge
from tracerisk.pipeline.evidence.reaction import reaction_to
from tracerisk.trace import RunEnd

SECOND = 1_000_000_000


def command(number, line, at_s, *, goal=(), callers=(), end="arrived", root="main", by=None):
    """A command from a line of `pick`, which others may have called."""
    frames = [
        Frame(PICK, 1, 1, (caller, 1), root if at == 0 else None)
        for at, caller in enumerate((*callers, line))
    ]
    return Command(
        number,
        "move_group",
        ("joint_1",),
        tuple(frames),
        round(at_s * SECOND),
        round((at_s + 0.5) * SECOND),
        end,
        tuple(goal),
        replaced_by=by,
    )


def recorded(*lines, calls=(), handled=(), signs=(), sources=None):
    """A recording of commands from lines of `pick`, a second apart."""
    commands = [
        line if isinstance(line, Command) else command(at + 1, line, float(at))
        for at, line in enumerate(lines)
    ]
    executed = sorted(f"{line}:1:cell.py" for line, _ in calls)
    first_ns = [round(at_s * SECOND) for _, at_s in sorted(calls)]
    note = {
        "executed": executed,
        "first_ns": first_ns,
        **{key: [] for key in ("turns", "raised", "waiting")},
        "handled": [["cell.py", line, round(at_s * SECOND), own] for line, at_s, own in handled],
    }
    notes = [Note(CALLS, note)]
    notes += [
        Note(SIGN, {"by": by, "name": name, "ns": round(at_s * SECOND)}) for by, name, at_s in signs
    ]
    return Recording(commands=tuple(commands), notes=tuple(notes), sources=sources or {})


def made(recording, **changes):
    return replace(run(**changes), recording=recording)


NOMINAL = made(recorded(10, 11, 12, 13))


def ended(cause, at_s, **more):
    return RunEnd(cause, "it ended", at_s, **more)


def test_the_same_commands_are_no_reaction_whatever_an_interface_reported():
    report = Finding("execution_failure", "aborted", 2.2)
    failed = made(recorded(10, 11, 12, 13, signs=[("result", "/grasp", 2.2)]), findings=(report,))
    reaction = reaction_to(NOMINAL, failed, 2.0)
    assert (reaction.noticed_s, reaction.noticed_by, reaction.is_other_way) == (None, None, False)


def test_an_end_before_the_last_command_is_noticed_at_the_end():
    failed = made(recorded(10, 11, 12), end=ended("exited", 2.75))
    reaction = reaction_to(NOMINAL, failed, 2.0)
    assert (reaction.noticed_s, reaction.noticed_by) == (2.75, "control_flow")
    assert (reaction.went_on, reaction.next_s) == (False, None)


@pytest.mark.parametrize("cause", ["deadlock", "quiescent", "wall_limit", "duration"])
def test_a_run_that_waits_for_ever_notices_nothing(cause):
    failed = made(recorded(10, 11, 12), end=ended(cause, 9.0))
    assert reaction_to(NOMINAL, failed, 2.0).noticed_s is None


def test_a_code_at_the_end_alone_is_noticed_there():
    failed = made(recorded(10, 11, 12, 13), end=ended("exited", 4.5))
    reaction = reaction_to(NOMINAL, failed, 2.0)
    assert (reaction.noticed_s, reaction.went_on) == (4.5, False)


def test_what_leads_to_another_command_is_noticed_with_its_first_call():
    failed = made(
        recorded(10, 11, command(3, 30, 3.5), calls=[(29, 2.25)]), end=ended("ended", 4.0)
    )
    reaction = reaction_to(NOMINAL, failed, 2.0)
    assert (reaction.noticed_s, reaction.next_s) == (2.25, 3.5)


def test_a_call_that_leads_back_to_the_same_command_is_none():
    failed = made(recorded(10, 11, 12, 13, calls=[(29, 2.25)]))
    assert reaction_to(NOMINAL, failed, 2.0).noticed_s is None


@pytest.mark.parametrize(
    ("signs", "findings", "by"),
    [
        ([("result", "/grasp", 2.7)], (), "result"),
        ([("code", "/move", 2.7)], (), "code"),
        ([], (Finding("planning_failure", "no plan", 2.7),), "code"),
        ([("result", "/grasp", 2.5)], (), "control_flow"),
        ([("log", "lost #", 2.75)], (), "control_flow"),
        ([("log", "lost #", 2.75), ("code", "/move", 2.75)], (), "code"),
    ],
)
def test_by_what_it_was_noticed_is_what_came_right_before(signs, findings, by):
    failed = made(recorded(10, 11, 12, signs=signs), findings=findings, end=ended("ended", 2.75))
    reaction = reaction_to(NOMINAL, failed, 2.0)
    assert (reaction.noticed_s, reaction.noticed_by) == (2.75, by)


def test_a_line_of_the_log_alone_is_noticed_and_it_went_on():
    failed = made(recorded(10, 11, 12, 13, signs=[("log", "odd", 2.5)]))
    reaction = reaction_to(NOMINAL, failed, 2.0)
    assert (reaction.noticed_s, reaction.noticed_by, reaction.went_on) == (2.5, "log", True)
    both = made(recorded(10, 11, 12, 13, signs=[("log", "odd", 1.0)]))
    assert reaction_to(both, failed, 2.0).noticed_s is None


@pytest.mark.parametrize(("own", "by"), [(False, "exception"), (True, "control_flow")])
def test_an_except_clause_is_noticed_and_whose_exception_it_was(own, by):
    failed = made(recorded(10, 11, 12, handled=[(40, 2.6, own)]), end=ended("ended", 2.8))
    reaction = reaction_to(NOMINAL, failed, 2.0)
    assert (reaction.noticed_s, reaction.noticed_by) == (2.6, by)


@pytest.mark.parametrize(
    ("source", "by"),
    [(b"x = 1\nraise ValueError(x)\n", "control_flow"), (b"x = 1\ngo(x)\n", "exception")],
)
def test_an_exception_that_ends_the_run_is_the_controllers_own_or_not(source, by):
    failed = made(
        recorded(10, 11, 12, sources={"cell.py": source}),
        end=ended("raised", 2.8, location=Location("cell.py", 2)),
    )
    assert reaction_to(NOMINAL, failed, 2.0).noticed_by == by


def test_a_retry_that_leads_back_is_another_way_and_goes_on():
    again = (command(4, 11, 3.0), command(5, 12, 4.0), command(6, 13, 5.0))
    failed = made(recorded(10, 11, 12, *again), end=ended("ended", 6.0))
    reaction = reaction_to(NOMINAL, failed, 2.0)
    assert reaction.is_other_way
    assert (reaction.noticed_s, reaction.went_on, reaction.next_s) == (3.0, True, 3.0)


def test_a_retry_that_gives_up_did_not_go_on():
    again = (command(4, 11, 3.0), command(5, 12, 4.0), command(6, 50, 5.0))
    failed = made(recorded(10, 11, 12, *again), end=ended("exited", 6.0))
    assert not reaction_to(NOMINAL, failed, 2.0).went_on


def test_the_goal_tells_a_retry_from_the_next_round_of_a_loop():
    rounds = [command(at + 1, 10, float(at), goal=(float(at),)) for at in range(4)]
    nominal = made(recorded(*rounds))
    retry = command(4, 60, 2.5), command(5, 10, 3.0, goal=(2.0,))
    failed = made(recorded(*rounds[:3], *retry), end=ended("exited", 4.0))
    assert not reaction_to(nominal, failed, 2.0).went_on
    skip = command(4, 60, 2.5), command(5, 10, 3.0, goal=(3.0,))
    failed = made(recorded(*rounds[:3], *skip), end=ended("ended", 4.0))
    assert reaction_to(nominal, failed, 2.0).went_on


def test_a_command_that_is_refused_at_the_instant_of_the_next_came_before_it():
    """A controller that looks at no answer goes on within no time."""
    refused = replace(command(0, 12, 2.5, end="refused"), elements=(), after=2)
    failed = replace(recorded(10, 11, command(3, 13, 2.5)), refused=(refused,))
    reaction = reaction_to(NOMINAL, made(failed), 1.5)
    assert (reaction.noticed_s, reaction.is_other_way) == (None, False)


@pytest.mark.parametrize("kind", ["message", "goal"])
def test_commands_that_a_driver_takes_no_more_are_the_same_to_a_controller_that_looks_at_nothing(
    kind,
):
    """An arm with an error moves no further, whatever the controller sends; it has seen nothing."""
    refused = [
        replace(command(0, line, at_s, end="ignored"), kind=kind, elements=(), after=2)
        for line, at_s in ((12, 2.5), (13, 2.6))
    ]
    failed = replace(recorded(10, 11), refused=tuple(refused))
    reaction = reaction_to(NOMINAL, made(failed, end=ended("ended", 2.7)), 1.2)
    assert (reaction.noticed_s, reaction.is_other_way) == (None, False)


def test_another_command_that_is_refused_is_another_way():
    refused = replace(command(0, 40, 2.5, end="refused"), elements=(), after=2)
    failed = replace(recorded(10, 11, command(3, 13, 2.5)), refused=(refused,))
    assert reaction_to(NOMINAL, made(failed), 1.5).is_other_way


def test_threads_may_come_in_another_order():
    nominal = made(recorded(10, command(2, 20, 1.0, root="thread"), 12))
    failed = made(recorded(10, command(2, 12, 1.5), command(3, 20, 2.5, root="thread")))
    assert reaction_to(nominal, failed, 1.2).noticed_s is None


def test_a_stream_may_be_longer():
    def stream(length):
        numbers = range(1, length + 1)
        sent = [command(n, 10, n / 100, end="replaced", by=n + 1) for n in numbers]
        return made(recorded(*sent, command(length + 1, 10, 1.0), command(length + 2, 11, 3.0)))

    assert reaction_to(stream(20), stream(30), 0.05).noticed_s is None


def test_a_loop_that_waits_longer_notices_nothing_until_its_limit():
    source = b"""def pick():
    while not_there():
        sleep(0.05)
        if now() - began > 3.0:
            raise Stop(now())
"""
    sites = [(3, 9), (4, 12), (5, 19), (5, 24)]
    times = dict(zip(sites, (2.1, 2.15, 5.2, 5.2), strict=True))
    recording = recorded(10, 11, 12, sources={"cell.py": source})
    executed = {f"{line}:{column}:cell.py": at for (line, column), at in times.items()}
    note = {
        "executed": sorted(executed),
        "first_ns": [round(executed[key] * SECOND) for key in sorted(executed)],
        **{key: [] for key in ("turns", "raised", "waiting", "handled")},
    }
    failed = made(replace(recording, notes=(Note(CALLS, note),)), end=ended("raised", 5.2))
    assert reaction_to(NOMINAL, failed, 2.0).noticed_s == pytest.approx(5.2)


def test_functions_play_no_role():
    """The same lines, cut into other functions, give the same reaction."""
    failed = made(recorded(10, 11, command(3, 30, 2.5)), end=ended("ended", 3.0))
    cut = [
        replace(each, recording=replace(each.recording, commands=tuple(map(inlined, commands))))
        for each in (NOMINAL, failed)
        for commands in (each.recording.commands,)
    ]
    assert reaction_to(*cut, 2.0) == reaction_to(NOMINAL, failed, 2.0)


def inlined(command):
    """The command as from a function of its own, that `pick` calls."""
    outer, *_ = command.stack
    return replace(command, stack=(outer, replace(outer, root=None, activation=2)))


@pytest.mark.parametrize(
    ("lines", "end", "fells", "fate"),
    [
        ((10, 11, 12, 13), "ended", False, "unaware"),
        ((10, 11, 12), "exited", False, "stopped_safely"),
        ((10, 11, 12), "exited", True, "stopped_late"),
        ((10, 11, 12, 60, 13), "ended", False, "stopped_late"),
        ((10, 11, 12, 60), "ended", False, "stopped_safely"),
        ((10, 11, 12), "deadlock", False, "unaware"),
    ],
)
def test_the_fate_of_a_mission_that_failed(lines, end, fells, fate):
    fell = Reason("object-dropped", "faulted", "'tube' fell", object="tube", time_s=2.5)
    verdict = Verdict("faulted", (fell,)) if fells else Verdict("complete")
    off = ({"joint_1": 0.9}, {"joint_1": -0.5})
    failed = made(recorded(*lines), arrivals=off, end=ended(end, 6.0), verdict=verdict)
    cell = judge(NOMINAL, failed, CELL)
    assert (cell.fails, cell.fate) == (True, fate)


OFF = ({"joint_1": 0.9}, {"joint_1": -0.5})


def missed(failed, unit="joint_1"):
    cell = judge(NOMINAL, failed, replace(CELL, unit=unit))
    return cell.missed_check, cell.missed_at


def told(by, at_s, line, name="/grasp"):
    return Note(
        SIGN, {"by": by, "name": name, "ns": round(at_s * SECOND), "file": "cell.py", "line": line}
    )


def test_what_would_help_is_the_first_answer_that_nobody_looked_at():
    recording = recorded(10, 11, 12, 13)
    notes = (*recording.notes, told("result", 3.1, 12), told("code", 2.6, 11))
    unaware = made(replace(recording, notes=notes), arrivals=OFF)
    assert missed(unaware) == ("result", "cell.py:11")
    # One that the run without the failure gets too says nothing.
    usual = replace(NOMINAL, recording=replace(NOMINAL.recording, notes=notes))
    assert judge(usual, unaware, CELL).missed_check is None
    # Nor does one to which it reacted at once.
    recording = recorded(10, 11)
    notes = (*recording.notes, told("code", 2.6, 11))
    stopped = made(replace(recording, notes=notes), arrivals=OFF, end=ended("exited", 2.6))
    assert missed(stopped) == (None, "")


def test_what_would_help_with_a_gripper_is_its_width_after_its_last_command():
    grip = replace(command(2, 21, 1.0), elements=("hand",))
    nominal = recorded(10, grip, 12, 13)
    failed = made(nominal, arrivals=OFF)
    cell = judge(made(nominal), failed, replace(CELL, unit="hand", mode="no_force"))
    assert (cell.missed_check, cell.missed_at) == ("grip", "cell.py:21")


@pytest.mark.parametrize("cause", ["deadlock", "wall_limit", "duration"])
def test_what_would_help_with_a_wait_for_ever_is_a_limit(cause):
    end = ended(cause, 30.0, location=Location("cell.py", 17))
    assert missed(made(recorded(10, 11, 12), arrivals=OFF, end=end)) == ("time_limit", "cell.py:17")


def test_places_where_a_check_would_help_come_with_what_they_would_show():
    result = replace(
        CELL, fails=True, fate="unaware", missed_check="result", missed_at="cell.py:11"
    )
    cells = [
        result,
        replace(result, time_s=3.0, mode="jam"),
        replace(result, time_s=4.0, missed_check="grip", missed_at="cell.py:21"),
        replace(result, time_s=5.0, fate="stopped_safely"),
    ]
    first, second = advice_of(cells)
    assert (str(first.location), len(first.cells)) == ("cell.py:11", 2)
    assert first.words == (
        "the answer to this call is not looked at: 2 failures end the mission undetected "
        "(motor dead, motor jam)"
    )
    assert second.words.startswith(
        "the width of the gripper is not read in time after this command, or not acted upon: 1 fail"
    )


@pytest.mark.parametrize(
    ("lines", "fate"), [((10, 11, 12, 13), "carried_out"), ((10, 11, 12, 12, 13), "recovered")]
)
def test_the_fate_of_a_mission_that_did_not_fail(lines, fate):
    cell = judge(NOMINAL, made(recorded(*lines), end=ended("ended", 4.5)), CELL)
    assert (cell.fails, cell.fate) == (False, fate)


BACK_OFF = FunctionRef("cell.py", "back_off")


@pytest.mark.parametrize(
    ("functions", "goes_on"),
    [
        ((PICK, BACK_OFF, PLACE, PICK), "place"),
        ((PICK, BACK_OFF, BACK_OFF), "back_off"),
        ((PICK, PICK, BACK_OFF), "pick"),
    ],
)
def test_a_mission_goes_on_with_the_first_function_that_the_run_without_has_too(functions, goes_on):
    # It shows that it has noticed by its fourth command, which begins the second visit.
    visits = tuple(map(visit, functions, (1.0, 3.0, 4.0, 5.0)))
    failed = made(recorded(10, 11, 12, 12, 13), end=ended("ended", 6.0), visits=visits)
    assert judge(NOMINAL, failed, CELL).next_function == goes_on
