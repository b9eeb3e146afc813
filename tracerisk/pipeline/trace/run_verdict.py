"""Gather from a recording what the verdict of its run rests on."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tracerisk.common.traced.findings import NOTHING_TO_GRASP, UNUSED, Finding
from tracerisk.common.verdict import Acceptance, Coverage, Verdict
from tracerisk.errors import Location
from tracerisk.instrument.commands import Command
from tracerisk.instrument.marks.call_log import CALLS, Calls
from tracerisk.instrument.marks.caught_exceptions import with_settled_refusals
from tracerisk.instrument.motion_calls import Commanding, missed_calls
from tracerisk.instrument.recording import NEAR, STOPS, Recording
from tracerisk.pipeline.launch_files.records import words_of_missing
from tracerisk.pipeline.mission.facts import mission_facts
from tracerisk.pipeline.mission.judged import missed
from tracerisk.pipeline.mission.named_objects import check_objects
from tracerisk.pipeline.robot.elsewhere import not_blamed
from tracerisk.pipeline.trace.falls import falls
from tracerisk.pipeline.trace.grasp_place import grasp_place
from tracerisk.pipeline.trace.gripper_faults import closed_on_nothing, empty_grasps
from tracerisk.pipeline.trace.judge import judge, with_acceptances
from tracerisk.pipeline.trace.recorded_run import (
    Grip,
    IssuedCommand,
    MissedCommand,
    MissedCondition,
    Ran,
    RecordedRun,
    UnmetNeed,
)
from tracerisk.pipeline.trace.run_files import GIVEN, GRAPH_USE, LAUNCH, OBJECTS, UNMET
from tracerisk.pipeline.trace.unfinished import retry_of
from tracerisk.pipeline.workspace.controller import from_root, function_of
from tracerisk.ros.scenario.file.marks import Unconfirmed
from tracerisk.ros.scenario.file.scenario_reader import read_scenario
from tracerisk.trace import EndCause, SuccessCondition, Visit
from tracerisk.twin.motion.plausible_units import past_limits
from tracerisk.twin.recording.contact_pairs import Hold
from tracerisk.twin.recording.contacts import RunContacts
from tracerisk.twin.recording.samples import Samples
from tracerisk.twin.robots.added_gripper import NAME as ASSUMED_GRIPPER
from tracerisk.twin.robots.added_gripper import has_assumed_gripper, words_of_assumed_gripper
from tracerisk.twin.robots.generic import NAME as GENERIC
from tracerisk.twin.robots.gripper_ends import GripperEnds, gripper_ends

if TYPE_CHECKING:
    from tracerisk.pipeline.workspace.controller import Controller
    from tracerisk.twin.robots.robot import Robot
    from tracerisk.twin.robots.robot_parts import Gripper, Joint

_BY_ITSELF: frozenset[EndCause] = frozenset({"raised", "exited"})
"""How a controller ends itself badly; what it brought about until then is known."""
_SAME_PLACE = 0.05  # of its range: a command that moves a gripper by less neither opens nor closes
_AT_END_S = 0.1  # what is touched this shortly before a run ends is touched at its end [s]
_AFTER_S = 1.0  # a grip shows no later than this after the gripper's command ended [s]


def placed_findings(findings: Sequence[Finding], controller: Controller) -> tuple[Finding, ...]:
    """Return the findings with places below the controller's root, and the function of each."""
    return tuple(_placed(finding, controller) for finding in findings)


def _placed(finding: Finding, controller: Controller) -> Finding:
    root = controller.root.resolve()

    def shortened(name: str) -> str:
        file = Path(name)
        is_below = file.is_absolute() and file.is_relative_to(root)
        return file.relative_to(root).as_posix() if is_below else name

    placed = finding.with_files(shortened)
    if placed.location is None:
        return placed
    return replace(placed, function=function_of(controller, placed.location))


def run_verdict(
    ran: Ran,
    findings: Sequence[Finding],
    coverage: Coverage,
    samples: Samples | None,
    contacts: RunContacts | None,
    visits: Sequence[Visit],
) -> tuple[Verdict, tuple[Finding, ...], tuple[SuccessCondition, ...]]:
    """Return the verdict of a run, a finding on the first grasp on nothing that is no fault, and
    what the mission had to bring about.

    `findings` have their functions: `placed_findings`.
    """
    controller, settings, recording = ran.controller, ran.settings, ran.recording
    given = recording.note(GIVEN) or {"objects": (), "accept": (), "unconfirmed": ()}
    # What nobody has confirmed and the run made no use of decides nothing.
    unused = {finding.object for finding in findings if finding.kind == UNUSED and finding.object}
    used = [finding for finding in findings if finding.kind != UNUSED or not finding.object]
    commands = tuple(_commands(ran, samples, contacts))
    note = recording.note(CALLS)
    calls = None if note is None else Calls.of(note)
    bodies = samples.header.free_bodies if samples is not None else ()
    named = given["objects"] if settings.scene is None else (*given["objects"], *bodies)
    success, mission = _mission(ran, samples, contacts, visits)
    run = RecordedRun(
        end=ran.end,
        end_function=function_of(controller, ran.end.location),
        findings=with_settled_refusals(used, calls, ran.end, controller.source_of),
        commands=commands,
        unmet=tuple(_unmet(recording, controller)),
        coverage=coverage,
        missed=tuple(_missed(ran, calls)),
        falls=falls(samples, contacts) if samples is not None else (),
        mission=mission,
        assumed=tuple(_assumed(ran.robot, recording)),
        unconfirmed=(
            *_unconfirmed(given["unconfirmed"], unused, controller),
            *_without_file(recording),
        ),
        has_objects=bool(named),
        is_duration_given=settings.duration_s is not None,
        is_speed_known=ran.robot.name != GENERIC,
    )
    accepted = (*settings.accept, *(Acceptance(**item) for item in given["accept"]))
    verdict = judge(run, accepted)
    if settings.robot is None:
        verdict = with_acceptances(not_blamed(verdict, ran.robot, controller), accepted)
    return verdict, tuple(islice(_noted_grasps(run), 1)), success


def _noted_grasps(run: RecordedRun) -> Iterator[Finding]:
    """Yield where a gripper closed on nothing: for want of things, or noticed by the controller."""
    why = (
        ": no object of the scene is between its pads there"
        if run.has_objects or any(command.holds for command in run.commands)
        else ": the scene gives it nothing to grasp, so no load is in the figures; objects in a "
        "scenario (--scenario) would"
    )
    for empty_grasp in empty_grasps(run.commands, has_objects=run.has_objects):
        if not empty_grasp.is_fault:
            command = empty_grasp.command
            settled = command.end == "aborted" and retry_of(run, run.commands.index(command))
            no_fault = "; that its goal was aborted is no fault therefore" if settled else ""
            yield Finding(
                NOTHING_TO_GRASP,
                f"{closed_on_nothing(command)}{why}{no_fault}",
                command.issue_s,
                command.location,
                command.function,
                command.gripper,
            )


def _without_file(recording: Recording) -> Iterator[tuple[str, str, Location | None]]:
    """Yield which files the launch file loads that are not there: what they give is not in it."""
    for place, file in (recording.note(LAUNCH) or {"missing": ()})["missing"]:
        yield file, words_of_missing(place, file), None


def _assumed(robot: Robot, recording: Recording) -> Iterator[tuple[str, str]]:
    """Yield what of the robot is assumed: itself, its names, where it begins, its gripper."""
    if robot.doubt:
        yield robot.name, f"the robot is assumed: {robot.doubt}"
    if robot.name == GENERIC:
        yield robot.name, f"no robot is known: a generic arm was taken, {robot.chosen_by}"
    for finding in recording.findings:
        if finding.kind == "assumed_name":
            named = finding.message.split("'")
            yield named[1] if len(named) > 1 else "", finding.message
        if finding.kind in ("assumed_setting", "assumed_start"):
            yield robot.name, finding.message
    commanded = {name for command in recording.commands for name in command.elements}
    if ASSUMED_GRIPPER in commanded and has_assumed_gripper(robot):
        yield ASSUMED_GRIPPER, words_of_assumed_gripper(robot)


def _unconfirmed(
    entries: Sequence[Mapping[str, Any]], unused: Collection[str], controller: Controller
) -> Iterator[tuple[str, str, Location]]:
    root = controller.root.resolve()
    for fields in entries:
        file, line, column = fields["location"].values()
        entry = Unconfirmed(**{**fields, "location": Location(file, line, column)})
        if entry.what in unused:
            continue
        text = f": {entry.words}" if entry.words else ""
        place = Location(from_root(root, Path(file).resolve()), line)
        yield (
            entry.name,
            f"{entry.what} of the scenario is assumed{text}; delete its mark to confirm it",
            place,
        )


def _mission(
    ran: Ran, samples: Samples | None, contacts: RunContacts | None, visits: Sequence[Visit]
) -> tuple[tuple[SuccessCondition, ...], tuple[MissedCondition, ...]]:
    """Return what `success` of the scenario declares, and what of it the run did not bring about.

    A run that a limit or a deadlock ended shows nothing of the kind.
    Raises ScenarioError where a run that came to its end has none of the objects that are named.
    """
    if ran.settings.scenario is None or not (ran.end.is_good or ran.end.cause in _BY_ITSELF):
        return (), ()
    scenario = read_scenario(Path(ran.settings.scenario))
    if not scenario.success:
        return (), ()
    use, objects = ran.recording.note(GRAPH_USE) or {}, ran.recording.note(OBJECTS) or {}
    facts = mission_facts(
        ran.robot,
        ran.scene,
        scenario,
        ran.recording,
        ran.folder,
        end_s=ran.end.simulated_s or 0.0,
        samples=samples,
        holds=contacts.holds if contacts is not None else (),
        log=contacts.log if contacts is not None else None,
        bearing=objects.get("bearing", {}),
        visits=visits,
        counts=use.get("counts", {}),
    )
    if ran.end.is_good and samples is not None and not ran.has_faults:
        check_objects(scenario.success, facts.scene, facts.frames, facts.tracks)
    root = ran.controller.root.resolve()
    lacking = []
    results = missed(scenario.success, facts)
    for result in results:
        condition, place = result.condition, result.condition.location
        if place is not None:
            place = replace(place, file=from_root(root, Path(place.file).resolve()))
        lacking.append(MissedCondition(condition.label, result.words, place, condition.is_assumed))
    failed = [result.condition for result in results]
    declared = tuple(
        SuccessCondition(condition.words, condition not in failed) for condition in scenario.success
    )
    return declared, tuple(lacking)


def _unmet(recording: Recording, controller: Controller) -> Iterator[UnmetNeed]:
    note = recording.note(UNMET)
    for item in note["needs"] if note is not None else ():
        place = None if item["location"] is None else Location(*item["location"])
        yield UnmetNeed(
            item["name"],
            item["words"],
            place,
            function_of(controller, place),
            is_frame=item["kind"] == "frame",
        )


def _missed(ran: Ran, calls: Calls | None) -> Iterator[MissedCommand]:
    """Yield the calls of functions that ran which led to no command, though others like it did."""
    if calls is None:
        return
    recording, controller = ran.recording, ran.controller
    issued = (*recording.commands, *recording.refused)
    frames = [frame for command in issued for frame in command.stack]
    places = {place for frame in frames for place in frame.places}
    stops = (recording.note(STOPS) or {"sites": ()})["sites"]
    places |= {(file, (line, column)) for file, line, column in stops}
    commanding = Commanding(frozenset(places), frozenset(frame.function for frame in frames))
    begun = {(site.ref.file, str(site.ref.name)) for site in recording.functions_ran}
    for file in sorted({frame.function.file for frame in frames}):
        for call in missed_calls(controller.source_of(file), file, commanding, calls):
            place = Location(file, call.line)
            function = function_of(controller, place)
            # What a run that broke off did not get to says nothing of its own.
            if (file, function) in begun and (call.was_executed or ran.end.is_good):
                yield MissedCommand(function, call.written, place, call.was_executed)


def _commands(
    ran: Ran, samples: Samples | None, contacts: RunContacts | None
) -> Iterator[IssuedCommand]:
    robot, recording = ran.robot, ran.recording
    grippers = {gripper.name: gripper for gripper in robot.grippers}
    ends = {gripper.name: gripper_ends(robot, gripper) for gripper in robot.grippers}
    joints = {joint.name: joint for joint in robot.arm_joints}
    holds: Sequence[Hold] = contacts.holds if contacts is not None else ()
    place_of = {command.id: place for place, command in enumerate(recording.commands)}
    for number, command in enumerate(recording.commands):
        gripper = next((grippers[name] for name in command.elements if name in grippers), None)
        is_arms = any(name not in grippers for name in command.elements)
        innermost = command.stack[-1]
        line, column = innermost.site
        past_limit, past_words = _past_limit(joints, command)
        issued = IssuedCommand(
            kind=command.kind,
            function=innermost.function.name,
            location=Location(innermost.function.file, line, column or None),
            elements=command.elements,
            issue_s=command.issue_ns / 1e9,
            end_s=None if command.end_ns is None else command.end_ns / 1e9,
            end=command.end,
            way_done=command.way_done,
            replaced_by=place_of.get(command.replaced_by or 0),
            goal=command.goal,
            callers=tuple(frame.function.name for frame in command.stack),
            path=tuple((frame.function, frame.site) for frame in command.stack),
            past_limit=past_limit,
            past_words=past_words,
            called_from=None
            if len(command.stack) < 2
            else Location(command.stack[-2].function.file, command.stack[-2].site[0]),
        )
        if gripper is not None and not is_arms and samples is not None:
            at = _positions(samples, command.issue_ns)
            issued = replace(
                issued,
                gripper=gripper.name,
                grip=_grip(ends[gripper.name], gripper, at, command),
                holds=_holds(gripper, command, recording.commands[number + 1 :], holds, samples),
                posture=tuple(at[joint.name] for joint in robot.arm_joints),
            )
            if issued.grip == "closes" and not issued.holds:
                place = grasp_place(robot, gripper, samples, command.issue_ns, command.end_ns)
                issued = replace(issued, place=place)
        yield issued


def _past_limit(joints: Mapping[str, Joint], command: Command) -> tuple[str, str]:
    """Return the joint that a goal takes furthest past its limits, and words; empty for none."""
    past_limit, furthest = ("", ""), NEAR
    if len(command.goal) == len(command.elements):
        for name, goal in zip(command.elements, command.goal, strict=True):
            joint = joints.get(name)
            if joint is None or joint.type == "continuous":
                continue
            by = max(joint.lower - goal, goal - joint.upper)
            if by > furthest:
                furthest = by
                past_limit = (name, f"to {past_limits(joint, goal, NEAR)}")
    return past_limit


def _positions(samples: Samples, time_ns: int) -> Mapping[str, float]:
    if not samples.n_steps:
        return dict.fromkeys(samples.header.joints, 0.0)
    step = min(time_ns // samples.header.step_ns, samples.n_steps - 1)
    return dict(zip(samples.header.joints, samples.position[step].tolist(), strict=True))


def _grip(
    ends: GripperEnds, gripper: Gripper, at: Mapping[str, float], command: Command
) -> Grip | None:
    if not command.goal:
        return None
    change = ends.share(command.goal[0]) - ends.share(gripper.position(at))
    if abs(change) < _SAME_PLACE:
        return None
    return "opens" if change > 0.0 else "closes"


def _holds(
    gripper: Gripper,
    command: Command,
    later: Sequence[Command],
    holds: Sequence[Hold],
    samples: Samples,
) -> bool:
    """Return whether the gripper held something before the arm went on after its command."""
    step_ns = samples.header.step_ns
    end_ns = command.end_ns if command.end_ns is not None else command.issue_ns
    moved_ns = next((item.issue_ns for item in later if gripper.name not in item.elements), end_ns)
    until = (max(end_ns, moved_ns) + round(_AFTER_S * 1e9)) // step_ns
    # A run that ends with the command has hardly a step after it.
    last = min(end_ns // step_ns, samples.n_steps - 1 - round(_AT_END_S * 1e9) // step_ns)
    return any(
        hold.holder == gripper.name and hold.start <= until and hold.stop > last for hold in holds
    )
