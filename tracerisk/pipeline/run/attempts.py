"""Run a controller with what is assumed of its surroundings, and again where that does not fit."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, replace
from pathlib import Path

from tracerisk.common.hardware.binding import bind
from tracerisk.common.hardware.formats import load_hardware
from tracerisk.config import Settings
from tracerisk.pipeline.launch.choose import LaunchChoice
from tracerisk.pipeline.robot.kept_choices import KeptChoices
from tracerisk.pipeline.robot.scenario_settings import with_scenario
from tracerisk.pipeline.run.companions.find import find_companions
from tracerisk.pipeline.run.controller_run import run_controller
from tracerisk.pipeline.run.ended_run import PLAIN, ControllerRun, RunOptions
from tracerisk.pipeline.trace.run_files import Companion
from tracerisk.pipeline.trace.sensors import elements_of
from tracerisk.pipeline.workspace.controller import Controller, from_root
from tracerisk.trace import EndCause, Trace

_MOST_COMPANIONS = 4
_MOST_DURATIONS = 4  # simulated time of all attempts, in that which one run may take
# A process that died may have been ended for want of memory.
OF_THE_MACHINE: frozenset[EndCause] = frozenset({"wall_limit", "memory_limit", "died"})
"""How a run may end by a limit of the machine: nothing is concluded from it."""
_ROBOTS_TRIED = 3  # for the names that a run shows, of an arm and then of its gripper


@dataclass(frozen=True, slots=True)
class _Accompanied:
    """What runs with companions came to."""

    trace: Trace | None
    """The run that counts, None where none does."""
    companions: tuple[Companion, ...] = ()
    """The nodes beside the controller in that run."""
    has_helped: bool = False
    """Whether one of them gave the controller what it lacked, though it lacked more then."""


def trace_attempts(
    controller: Controller,
    settings: Settings,
    options: RunOptions = PLAIN,
    kept: KeptChoices | None = None,
) -> Trace:
    """Return what the run showed whose launch file and robot fit the controller.

    A run that moves joints which a robot lacks that nobody named is done again with the robot
    that has them: no source shows the names that a controller puts together as it runs.
    A run that shows no risk with what a launch file gives is done again without it: the file was
    found, not asked for, and must not keep a controller from running.
    A run that shows no risk for want of something that other nodes of the workspace provide is
    done again with these beside it.
    Simulated time and the number of runs bound the attempts. A run that a limit of the machine
    ended is the last: nothing is concluded from it. What is chosen of the workspace is `kept` for
    further runs of the controller.
    """
    settings = with_scenario(settings)
    kept = kept or KeptChoices()
    simulated_s = 0.0
    is_repeated = False

    def may_go_on() -> bool:
        return simulated_s < _MOST_DURATIONS * settings.run_duration_s

    def run(
        choice: LaunchChoice, keep: Path | None, companions: tuple[Companion, ...] = ()
    ) -> ControllerRun:
        nonlocal simulated_s
        # With a launch file it was shown what the controller prints: it would come twice.
        asked = replace(options, keep=keep, quiet=options.quiet or is_repeated)
        done = _with_robot(controller, settings, choice, companions, asked, kept)
        simulated_s += done.trace.end.simulated_s or 0.0
        if options.on_run is not None:
            options.on_run(done)
        return done

    def attempt(choice: LaunchChoice, keep: Path | None) -> Trace:
        done = run(choice, keep)
        if not settings.companions or _is_final(done.trace):
            return done.trace
        if _lacks(done) in kept.in_vain:
            return done.trace
        accompanied = _with_companions(
            controller, settings, done, lambda companions: run(choice, None, companions), may_go_on
        )
        if accompanied.trace is None:
            if not accompanied.has_helped:
                kept.in_vain.add(_lacks(done))
            return done.trace
        if keep is None or _is_cut_short(accompanied.trace):
            return accompanied.trace
        return run(choice, keep, accompanied.companions).trace

    choice = kept.launch(controller, settings)
    trace = attempt(choice, options.keep)
    is_found = choice.setup is not None and settings.launch is True
    if not is_found or not may_go_on() or _is_final(trace):
        return trace
    assert choice.setup is not None
    without = LaunchChoice(
        notes=(
            f"launch: nothing is taken from {choice.setup.file}: with it the run shows no risk "
            f"({trace.end.message}); --launch FILE takes it",
        )
    )
    is_repeated = True
    plain = attempt(without, None)
    if _is_cut_short(plain):
        return plain
    if not _shows_risk(plain):
        # What is kept is the recording of the run that is reported.
        return trace
    return plain if options.keep is None else attempt(without, options.keep)


def _shows_risk(trace: Trace) -> bool:
    return trace.end.is_good and bool(trace.functions)


def _is_cut_short(trace: Trace) -> bool:
    """Return whether the machine may have ended a run, by a limit or for want of memory."""
    return trace.end.cause in OF_THE_MACHINE


def _lacks(run: ControllerRun) -> Hashable:
    """Return how a run ended, and what it lacked."""
    return run.trace.end.cause, run.trace.end.location, frozenset(run.needs)


def _is_final(trace: Trace) -> bool:
    return _shows_risk(trace) or _is_cut_short(trace)


def _with_companions(
    controller: Controller,
    settings: Settings,
    done: ControllerRun,
    run: Callable[[tuple[Companion, ...]], ControllerRun],
    may_go_on: Callable[[], bool],
) -> _Accompanied:
    """Run a controller with the nodes beside it that provide what a run lacked.

    No trace counts where no run shows risk, or where a companion moved the robot unasked: then it
    is a controller itself. A run that was cut short counts.
    """
    companions: tuple[Companion, ...] = ()
    has_helped = False
    while done.needs and len(companions) < _MOST_COMPANIONS and may_go_on():
        more = find_companions(controller, done.needs, settings, companions)
        if not more:
            break
        companions = (*companions, *more)[:_MOST_COMPANIONS]
        before, done = done, run(companions)
        if _is_cut_short(done.trace):
            return _Accompanied(done.trace, companions)
        if _shows_risk(done.trace):
            theirs = {companion.told for companion in companions}
            is_own = not any(function.ref.file in theirs for function in done.trace.functions)
            return _Accompanied(done.trace if is_own else None, companions)
        if _lacks(done) == _lacks(before):
            # Nor would another node that says it provides the same.
            break
        has_helped = True
    return _Accompanied(None, companions, has_helped)


def _with_robot(
    controller: Controller,
    settings: Settings,
    launch: LaunchChoice,
    companions: tuple[Companion, ...],
    options: RunOptions,
    kept: KeptChoices,
) -> ControllerRun:
    """Run the controller on the robot of its names, then on that of the names its run shows."""
    asked: tuple[str, ...] = ()
    choice = kept.robot(controller, settings, launch, asked)
    for _ in range(_ROBOTS_TRIED):
        # What the robot has no place for is reported before a minute is spent on simulation.
        bind(load_hardware(settings, choice.robot.name), elements_of(choice.robot, settings))
        done = run_controller(controller, choice.robot, settings, launch, options, companions)
        if _is_cut_short(done.trace):
            break
        if settings.robot is not None or not set(done.joints_asked) - set(asked):
            break
        asked = (*asked, *done.joints_asked)
        other = kept.robot(controller, settings, launch, asked)
        if other.robot == choice.robot:
            break
        choice = other
    root = controller.root.resolve()
    read = {from_root(root, file.resolve()) for file in choice.files}
    inputs = tuple(sorted({*done.trace.inputs, *read}))
    return replace(done, trace=replace(done.trace, inputs=inputs))
