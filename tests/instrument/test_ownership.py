"""Visits, live intervals, and the owner of every physics step."""

import dataclasses
from collections.abc import Sequence
from typing import get_args

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.errors import Location
from tracerisk.instrument.commands import Command
from tracerisk.instrument.ownership import Attribution, attribute
from tracerisk.instrument.recording import Recording
from tracerisk.instrument.tracer import Frame
from tracerisk.trace import CommandEnd, TracedFunction

MS = 1_000_000
STEP = 2 * MS
ARM, HAND = ("j1", "j2"), ("hand",)


def stack(*calls: tuple[str, int]) -> tuple[Frame, ...]:
    """Return a stack of (function, activation), each calling from a line of its own."""
    return tuple(
        Frame(
            FunctionRef("c.py", QualifiedName(name)),
            10,
            activation,
            (100 + len(calls), place + 1),
            "main" if place == 0 else None,
        )
        for place, (name, activation) in enumerate(calls)
    )


def recording(
    *commands: tuple[tuple[Frame, ...], Sequence[str], int, int | None, CommandEnd | None],
) -> Recording:
    """Return a recording of (stack, elements, issue [ms], end [ms], how it ended)."""
    return Recording(
        tuple(
            Command(
                k,
                "trajectory",
                tuple(elements),
                frames,
                issue * MS,
                None if end_ms is None else end_ms * MS,
                end,
            )
            for k, (frames, elements, issue, end_ms, end) in enumerate(commands, start=1)
        )
    )


def visits_of(found: Attribution) -> list[tuple[str, int, int, str]]:
    return [
        (str(v.function.name), v.start_ns // MS, len(v.commands), v.outcome) for v in found.visits
    ]


def test_a_visit_is_one_activation_of_its_owner() -> None:
    found = attribute(
        recording(
            (stack(("m", 1), ("pick", 2)), ARM, 0, 10, "arrived"),
            (stack(("m", 1), ("pick", 2)), HAND, 10, 20, "arrived"),
            (stack(("m", 1), ("place", 3)), ARM, 20, 30, "aborted"),
            (stack(("m", 1), ("pick", 4)), ARM, 30, 40, "arrived"),
        ),
        end_ns=40 * MS,
    )
    assert visits_of(found) == [
        ("pick", 0, 2, "succeeded"),
        ("place", 20, 1, "aborted"),
        ("pick", 30, 1, "succeeded"),
    ]
    assert found.functions == (
        TracedFunction(FunctionRef("c.py", QualifiedName("pick")), 10, 1),
        TracedFunction(FunctionRef("c.py", QualifiedName("place")), 10, 2),
    )


def test_next_activation_is_a_new_visit_when_the_command_ended_even_at_that_instant() -> None:
    found = attribute(
        recording(
            (stack(("m", 1), ("step", 2)), ARM, 0, 10, "arrived"),
            (stack(("m", 1), ("step", 3)), ARM, 10, 20, "arrived"),
        ),
        end_ns=20 * MS,
    )
    assert len(found.visits) == 2


def test_a_stream_of_set_points_is_one_visit() -> None:
    ticks = [
        (
            (dataclasses.replace(stack(("tick", k))[0], root="timer"),),
            ARM,
            10 * k,
            10 * k + (10 if k < 99 else 40),
            "replaced" if k < 99 else "arrived",
        )
        for k in range(1, 100)
    ]
    assert visits_of(attribute(recording(*ticks), end_ns=2000 * MS)) == [
        ("tick", 10, 99, "succeeded")
    ]


def test_a_stream_is_one_visit_though_another_owner_commands_in_between() -> None:
    found = attribute(
        recording(
            (stack(("tick", 1)), ARM, 0, 50, "replaced"),
            (stack(("m", 2), ("grip", 3)), HAND, 20, 30, "arrived"),
            (stack(("tick", 4)), ARM, 50, 100, "arrived"),
        ),
        end_ns=100 * MS,
    )
    assert visits_of(found) == [("tick", 0, 2, "succeeded"), ("grip", 20, 1, "succeeded")]


def test_a_stream_that_another_owner_took_over_begins_a_new_visit() -> None:
    found = attribute(
        recording(
            (stack(("tick", 1)), ARM, 0, None, None),
            (stack(("m", 2), ("stop", 3)), ARM, 20, 30, "arrived"),
            (stack(("tick", 4)), ARM, 50, 100, "arrived"),
        ),
        end_ns=100 * MS,
    )
    assert visits_of(found) == [
        ("tick", 0, 1, "unfinished"),
        ("stop", 20, 1, "succeeded"),
        ("tick", 50, 1, "succeeded"),
    ]


def test_visit_of_a_helper_is_the_activation_of_its_owner() -> None:
    found = attribute(
        recording(
            (stack(("m", 1), ("pick", 2), ("go", 3)), ARM, 0, 10, "arrived"),
            (stack(("m", 1), ("pick", 2), ("go", 4)), ARM, 10, 20, "arrived"),
            (stack(("m", 1), ("place", 5), ("go", 6)), ARM, 20, 30, "arrived"),
        ),
        end_ns=30 * MS,
    )
    assert visits_of(found) == [("pick", 0, 2, "succeeded"), ("place", 20, 1, "succeeded")]
    assert [ref.name for ref in found.helpers] == ["go"]


def test_each_element_belongs_to_the_latest_live_command_that_addresses_it() -> None:
    found = attribute(
        recording(
            (stack(("left", 1)), ("l1", "l2"), 4, 20, "arrived"),
            (stack(("right", 2)), ("r1",), 8, 12, "arrived"),
            (stack(("hand", 3)), ("l2",), 14, 16, "arrived"),
        ),
        end_ns=24 * MS,
    )
    # Steps start at 0, 2, 4, ... ms; the first visit owns the time before it.
    assert found.assign("l1", 12, STEP).tolist() == [0] * 10 + [2, 2]
    assert found.assign("r1", 12, STEP).tolist() == [0] * 4 + [1, 1] + [0] + [2] + [0, 0] + [2, 2]
    # Superseded on l2 at 14 ms: from then on l2 goes with the current visit.
    assert found.assign("l2", 12, STEP).tolist() == [0] * 7 + [2] + [0, 0] + [2, 2]
    assert found.current(12, STEP).tolist() == [0] * 4 + [1, 1] + [0] + [2] + [0, 0] + [2, 2]


def test_an_element_that_nobody_addressed_goes_with_the_current_visit() -> None:
    found = attribute(
        recording(
            (stack(("grip", 1)), HAND, 0, 4, "arrived"),
            (stack(("move", 2)), ARM, 6, 10, "arrived"),
        ),
        end_ns=12 * MS,
    )
    assert found.assign("camera", 6, STEP).tolist() == [0, 0, 0, 1, 1, 1]
    assert found.assign("hand", 6, STEP).tolist() == [0, 0, 0, 1, 1, 1]
    assert found.current(6, STEP).dtype == np.int64


def test_a_run_without_commands_has_no_visit() -> None:
    found = attribute(Recording(), end_ns=10 * MS)
    assert found.visits == found.functions == ()
    assert found.assign("j1", 3, STEP).tolist() == [-1, -1, -1]


def test_a_command_that_never_ended_lives_until_the_run_does() -> None:
    found = attribute(recording((stack(("m", 1)), ARM, 2, None, None)), end_ns=9 * MS)
    assert found.commands[0].live_until_ns == 9 * MS
    assert found.visits[0].outcome == "unfinished"


def test_two_owners_with_live_commands_are_reported_once() -> None:
    found = attribute(
        recording(
            (stack(("left", 1)), ("l1",), 0, 20, "arrived"),
            (stack(("right", 2)), ("r1",), 8, 30, "arrived"),
            (stack(("left", 3)), ("l1",), 22, 40, "arrived"),
            (stack(("last", 4)), ("l1",), 40, 50, "arrived"),
        ),
        end_ns=50 * MS,
    )
    (finding,) = found.findings
    assert (finding.kind, finding.time_s) == ("concurrent_owners", 0.008)
    assert finding.location == Location("c.py", 10)
    assert finding.message.startswith("right commands r1 while a command of left is still live")


def test_a_hundred_hertz_stream_of_five_minutes_is_assigned_quickly() -> None:
    frames = stack(("tick", 1))
    found = attribute(
        recording(*((frames, ARM, 10 * k, 10 * k + 10, "replaced") for k in range(30_000))),
        end_ns=300_000 * MS,
    )
    assert len(found.visits) == 1
    assert found.assign("j1", 150_000, STEP).tolist() == [0] * 150_000


# --- the law of refactoring, on controllers made at random

ELEMENTS = ("j1", "j2", "hand")
N_STEPS = 200


@st.composite
def missions(
    draw: st.DrawFn,
) -> list[tuple[int, tuple[str, ...], int, int | None, CommandEnd | None]]:
    """Draw (step of the task, elements, issue, end [ms], how it ended) of up to twelve commands."""
    commands: list[tuple[int, tuple[str, ...], int, int | None, CommandEnd | None]] = []
    now = draw(st.integers(0, 20))
    for _ in range(draw(st.integers(1, 12))):
        step = draw(st.integers(0, 4))
        elements = draw(st.lists(st.sampled_from(ELEMENTS), min_size=1, unique=True))
        length = draw(st.integers(0, 60))
        end = draw(st.sampled_from([*get_args(CommandEnd), None]))
        end_ms = None if end is None else now + length
        commands.append((step, tuple(elements), now, end_ms, end))
        now += draw(st.integers(0, 40))
    return commands


Cut = dict[int, tuple[tuple[str, int], ...]]


@st.composite
def cuts(draw: st.DrawFn) -> Cut:
    """Draw how the steps of a task are cut into functions: the calls that lead to each."""
    names = st.sampled_from(["main", "run", "pick", "place", "go", "send"])
    return {
        step: tuple(
            (name, 100 * step + depth)
            for depth, name in enumerate(draw(st.lists(names, max_size=4)))
        )
        for step in range(5)
    }


def cut_into_functions(
    mission: list[tuple[int, tuple[str, ...], int, int | None, CommandEnd | None]], cut: Cut
) -> Attribution:
    return attribute(
        recording(
            *(
                (stack(("<module>", 0), *cut[step]), elements, issue, end, outcome)
                for step, elements, issue, end, outcome in mission
            )
        ),
        end_ns=N_STEPS * STEP,
    )


@given(mission=missions(), cut=cuts())
def test_every_step_of_every_element_belongs_to_exactly_one_visit(
    mission: list[tuple[int, tuple[str, ...], int, int | None, CommandEnd | None]], cut: Cut
) -> None:
    found = cut_into_functions(mission, cut)
    for element in (*ELEMENTS, "camera"):
        owner = found.assign(element, N_STEPS, STEP)
        per_visit = [int((owner == k).sum()) for k in range(len(found.visits))]
        assert sum(per_visit) == N_STEPS
    ids = sorted(k for visit in found.visits for k in visit.commands)
    assert ids == [each.command.id for each in found.commands]
    starts = [visit.start_ns for visit in found.visits]
    assert starts == sorted(starts)


@given(mission=missions(), cut=cuts(), other=cuts())
def test_how_the_code_is_cut_moves_no_step_from_one_command_to_another(
    mission: list[tuple[int, tuple[str, ...], int, int | None, CommandEnd | None]],
    cut: Cut,
    other: Cut,
) -> None:
    """Split, merge, inline: each step stays with its command, only visits are named anew."""
    one, two = cut_into_functions(mission, cut), cut_into_functions(mission, other)
    assert [each.until_ns for each in one.commands] == [each.until_ns for each in two.commands]
    assert [each.command.issue_ns for each in one.commands] == [
        each.command.issue_ns for each in two.commands
    ]
    # Where every command is a visit of its own, a cut can only gather them.
    finest = attribute(
        recording(
            *(
                (stack(("<module>", 0), (f"step{k}", k)), elements, issue, end, outcome)
                for k, (_, elements, issue, end, outcome) in enumerate(mission)
            )
        ),
        end_ns=N_STEPS * STEP,
    )
    for found in (one, two):
        gathered = np.array([each.visit for each in found.commands])
        for element in ELEMENTS:
            command = finest.assign(element, N_STEPS, STEP)
            assert gathered[command].tolist() == found.assign(element, N_STEPS, STEP).tolist()


@given(mission=missions(), cut=cuts())
def test_renaming_functions_renames_owners_and_nothing_else(
    mission: list[tuple[int, tuple[str, ...], int, int | None, CommandEnd | None]], cut: Cut
) -> None:
    renamed = {
        step: tuple((f"z_{name[::-1]}", activation) for name, activation in calls)
        for step, calls in cut.items()
    }
    before, after = cut_into_functions(mission, cut), cut_into_functions(mission, renamed)
    assert [v.commands for v in before.visits] == [v.commands for v in after.visits]
    for element in ELEMENTS:
        assert np.array_equal(
            before.assign(element, N_STEPS, STEP), after.assign(element, N_STEPS, STEP)
        )


def test_names_that_overrule_reach_the_rules() -> None:
    run = recording((stack(("m", 1), ("pick", 2)), ARM, 0, 10, "arrived"))
    owner = attribute(run, helpers=["pick"], end_ns=10 * MS).functions[0].ref.name
    assert owner == "m"
    with pytest.raises(ValueError, match="both"):
        attribute(run, helpers=["pick"], states=["pick"], end_ns=10 * MS)


WITHOUT = recording(
    (stack(("m", 1), ("turn", 2)), ARM, 0, 10, "arrived"),
    (stack(("m", 1), ("home", 3)), ARM, 10, 20, "arrived"),
    (stack(("m", 1), ("open", 4), ("go", 5)), HAND, 20, 30, "arrived"),
    (stack(("m", 1), ("close", 6), ("go", 7)), HAND, 30, 40, "arrived"),
)


def test_a_run_beside_another_has_its_functions_also_where_it_calls_them_from_more_places() -> None:
    tried_again = recording(
        (stack(("m", 1), ("turn", 2)), ARM, 0, 10, "aborted"),
        (stack(("m", 1), ("back_off", 3), ("home", 4)), ARM, 10, 20, "arrived"),
        (stack(("m", 1), ("turn", 5)), ARM, 20, 30, "arrived"),
        (stack(("m", 1), ("home", 6)), ARM, 30, 40, "arrived"),
    )
    alone = attribute(tried_again, end_ns=40 * MS)
    assert [visit[0] for visit in visits_of(alone)] == ["turn", "back_off", "turn", "m"]
    found = attribute(tried_again, end_ns=40 * MS, beside=WITHOUT)
    assert [visit[0] for visit in visits_of(found)] == ["turn", "home", "turn", "home"]


def test_a_run_beside_another_has_its_helpers_also_where_it_ends_before_their_second_call() -> None:
    cut_short = recording((stack(("m", 1), ("open", 2), ("go", 3)), HAND, 0, 10, "aborted"))
    found = attribute(cut_short, end_ns=40 * MS, beside=WITHOUT)
    assert [visit[0] for visit in visits_of(found)] == ["open"]
    assert attribute(WITHOUT, end_ns=40 * MS) == attribute(WITHOUT, end_ns=40 * MS, beside=WITHOUT)


def entered(*states: tuple[str, str]) -> Recording:
    """Return a recording of states that command, each a method and its instance."""
    stacks = [stack((name, number)) for number, (name, _) in enumerate(states, start=1)]
    return recording(
        *(
            ((dataclasses.replace(frames[0], instance=label),), ARM, 10 * k, 10 * k + 10, "arrived")
            for k, (frames, (_, label)) in enumerate(zip(stacks, states, strict=True))
        )
    )


def test_a_run_beside_another_names_instances_as_it_does() -> None:
    whole = entered(("Move.execute", "tray"), ("Move.execute", "rack"), ("Stop.execute", "end"))
    cut_short = entered(("Move.execute", "tray"), ("Stop.execute", "end"), ("Stop.execute", "bad"))
    found = attribute(cut_short, end_ns=90 * MS, beside=whole)
    names = [visit[0] for visit in visits_of(found)]
    assert names == ["Move (tray)", "Stop.execute", "Stop.execute"]
    other = entered(("Move.execute", "tray"), ("Move.on_error", "tray"), ("Move.execute", "rack"))
    found = attribute(other, end_ns=90 * MS, beside=whole)
    names = [visit[0] for visit in visits_of(found)]
    assert names == ["Move (tray)", "Move.on_error", "Move (rack)"]
