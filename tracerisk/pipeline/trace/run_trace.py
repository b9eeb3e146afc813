"""Make a trace of a recording: whose activity is whose, for how long and how hard."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.common.hardware.shipped import fitting_words, hardware_of, is_shipped
from tracerisk.common.traced.elements import Exposure
from tracerisk.common.traced.findings import Finding
from tracerisk.common.verdict import Coverage
from tracerisk.config import Settings
from tracerisk.errors import Location, UnsafeRewriteError
from tracerisk.instrument.commands import traced_commands
from tracerisk.instrument.marks.call_log import Site
from tracerisk.instrument.motion_calls import MOTION_CALLS, calls_at, motion_names
from tracerisk.instrument.ownership import Attribution, attribute
from tracerisk.instrument.recording import Recording
from tracerisk.instrument.source.call_graph import CallGraph, call_graph
from tracerisk.instrument.source.function_definitions import MODULE
from tracerisk.instrument.source.hidden_calls import hidden_calls
from tracerisk.instrument.source.motion_reach import motion_reaching, uncovered
from tracerisk.instrument.source.python_source import is_python_2, parsed
from tracerisk.instrument.source.surroundings import asked
from tracerisk.pipeline.trace.compiled.coverage import c_coverage
from tracerisk.pipeline.trace.compiled.includes import included_files
from tracerisk.pipeline.trace.contacts import collisions, with_contacts
from tracerisk.pipeline.trace.outcome.run_outcome import run_outcome
from tracerisk.pipeline.trace.recorded_run import Ran
from tracerisk.pipeline.trace.run_files import (
    ASKED,
    CYCLE,
    DISTRO,
    ELSEWHERE,
    ENTRY,
    GIVEN,
    LAUNCH,
    MISSION_END,
    OBJECTS,
)
from tracerisk.pipeline.trace.run_verdict import placed_findings, run_verdict
from tracerisk.pipeline.trace.sensors import RunActivity, elements_of, with_sensors
from tracerisk.pipeline.workspace.controller import from_root, function_of
from tracerisk.pipeline.workspace.libraries import Libraries
from tracerisk.pipeline.workspace.like_commands import like_commands
from tracerisk.ros.scenario.objects import simulated_scene
from tracerisk.trace import Cycle, ObjectOffset, Trace, Visit
from tracerisk.twin.physics.declared_log import read_declared
from tracerisk.twin.recording.activity import ElementActivity, element_activity
from tracerisk.twin.recording.contacts import RunContacts
from tracerisk.twin.recording.exposure import ElementExposures
from tracerisk.twin.recording.packed_run import packed_run
from tracerisk.twin.recording.samples import Samples, has_samples, read_samples, until

if TYPE_CHECKING:
    from tracerisk.pipeline.workspace.controller import Controller


def make_trace(ran: Ran, *, beside: Recording | None = None, is_replayed: bool = False) -> Trace:
    """Return the trace of a run.

    One that is to be judged `beside` another run says when and where, contacts and verdict, and
    neither how long and how hard elements were used nor what never ran, in a third of the time;
    its functions are distinguished as in that run. One that `is_replayed` holds what a replay
    shows.
    """
    controller, robot, settings, recording = ran.controller, ran.robot, ran.settings, ran.recording
    end_ns = round((ran.end.simulated_s or 0.0) * 1e9)
    attribution = attribute(
        recording,
        states=settings.states,
        helpers=settings.helpers,
        end_ns=end_ns,
        beside=beside,
    )
    elements = elements_of(robot, settings)
    mission_end = recording.note(MISSION_END)
    active: Mapping[str, Exposure] = {}
    visits: tuple[Visit, ...] = ()
    samples: Samples | None = None
    contacts: RunContacts | None = None
    replay: bytes | None = None
    if has_samples(ran.folder):
        samples = read_samples(ran.folder)
        if mission_end is not None:
            # After it the controller only idled.
            samples = until(samples, mission_end["ns"])
        # A judgement asks of activity what a gripper grasps, and no more.
        grippers = [] if beside is None else [gripper.name for gripper in robot.grippers]
        activity = element_activity(samples, robot, only=grippers)
        measured = activity if beside is None else {}
        active, visits = exposures_of(attribution, measured, samples)
        seen = RunActivity(elements, attribution, activity, samples)
        if beside is None:
            active, visits = with_sensors(seen, recording, active, visits)
        active, visits, contacts = with_contacts(seen, ran.folder, robot, active, visits)
        if is_replayed and (shown := until(samples, end_ns)).n_steps:
            scene = simulated_scene(ran.scene, settings.scenario)
            declared = read_declared(ran.folder)
            replay = packed_run(shown, robot, scene, declared, activity)
    coverage = Coverage(0, 0)
    if beside is None and not controller.is_python:
        coverage = c_coverage(recording)
    elif beside is None:
        libraries = Libraries(controller.path, controller.project, settings.states)
        coverage = _coverage(controller, recording, libraries)
    collided = collisions(robot, attribution, visits)
    in_time = _in_time((*recording.findings, *attribution.findings, *collided))
    findings = placed_findings(in_time, controller)
    verdict, more, success = run_verdict(ran, findings, coverage, samples, contacts, visits)
    return Trace(
        controller=controller.file,
        robot=robot.name,
        scene=_with_objects(_shown_scene(ran.scene, controller.root), recording),
        end=ran.end,
        elements=elements,
        functions=attribution.functions,
        visits=visits,
        active=active,
        uncovered=coverage.never_ran,
        findings=_in_time((*findings, *more)),
        objects=_objects(recording),
        success=success,
        assumptions=_assumptions(ran),
        cycle=_cycle(recording, attribution, settings),
        files=tuple(file for file in _files(controller, recording) if file != controller.file),
        inputs=_inputs(controller, recording),
        verdict=verdict,
        outcome=run_outcome(ran, samples, contacts) if samples is not None else None,
        commands=traced_commands(recording.commands, recording.refused),
        replay=replay,
    )


def _cycle(recording: Recording, attribution: Attribution, settings: Settings) -> Cycle | None:
    """Return what a run repeated; None where its visits do not show the cycle."""
    note = recording.note(CYCLE)
    if note is None:
        return None
    visits = attribution.visits
    first = sum(1 for visit in visits if visit.start_ns < note["start_ns"])
    length, rest = divmod(len(visits) - first, note["seen"])
    owners = [visit.function for visit in visits[first:]]
    if not length or rest or owners != owners[:length] * note["seen"]:
        return None
    return Cycle(first, length, settings.mission_cycles)


def exposures_of(
    attribution: Attribution, activity: Mapping[str, ElementActivity], samples: Samples
) -> tuple[dict[str, Exposure], tuple[Visit, ...]]:
    """Return the exposure of each element over the run, and the visits with that in each."""
    n_steps, step_ns = samples.n_steps, samples.header.step_ns
    current = attribution.current(n_steps, step_ns)
    steps_of = np.bincount(current[current >= 0], minlength=len(attribution.visits))
    everywhere = np.ones(n_steps, dtype=np.bool_)
    active: dict[str, Exposure] = {}
    of_elements: dict[str, tuple[Exposure, ...]] = {}
    for name, of_element in activity.items():
        exposures = ElementExposures(of_element, samples.step_s)
        active[name] = exposures.over(everywhere)
        owner = attribution.assign(name, n_steps, step_ns)
        of_elements[name] = exposures.of_owners(owner, len(steps_of))
    visits = tuple(
        Visit(
            function=visit.function,
            start_s=visit.start_ns / 1e9,
            duration_s=float(steps_of[index]) * samples.step_s,
            outcome=visit.outcome,
            exposures={
                name: of_element[index]
                for name, of_element in of_elements.items()
                if of_element[index] != Exposure()
            },
        )
        for index, visit in enumerate(attribution.visits)
    )
    return active, visits


def _files(controller: Controller, recording: Recording) -> tuple[str, ...]:
    """Return the files of the controller that ran, sorted."""
    return tuple(sorted({site.ref.file for site in recording.functions_ran} | {controller.file}))


def _coverage(controller: Controller, recording: Recording, libraries: Libraries) -> Coverage:
    """Return which of the functions that can command hardware ran; a library's do not count."""
    sites: dict[str, set[Site]] = {}
    for command in recording.commands:
        innermost = command.stack[-1]
        sites.setdefault(innermost.function.file, set()).add(innermost.site)
    graphs, motion = [], set(MOTION_CALLS)
    files = _files(controller, recording)
    own = {file for file in files if not libraries.holds(controller.root / file)}
    for file in files:
        source = controller.source_of(file)
        with contextlib.suppress(UnsafeRewriteError):
            graphs.append(call_graph(source, file))
        motion |= calls_at(source, sites.get(file, ()))
    graph = CallGraph.joined(graphs)
    if not recording.commands:
        # The run has shown no call that commands: names that drivers' functions have must do.
        called = {name for calls in graph.calls.values() for name in calls.others}
        motion |= like_commands(called, [controller.source_of(file) for file in files])
    ran = {site.ref for site in recording.functions_ran}
    hidden = {ref for file in own for ref in _hidden(controller, file, motion)}
    missed = uncovered(graph, motion, ran, hidden)
    never_ran = tuple(item for item in missed if item.ref.file in own)
    # What the run has seen to command counts, however it came to.
    seen = {frame.function for command in recording.commands for frame in command.stack[:-1]}
    issuers = {command.stack[-1].function for command in recording.commands}
    reaching = {function_site.ref for function_site in motion_reaching(graph, motion)} | seen
    able = {ref for ref in reaching if ref.name != MODULE and ref.file in own} | issuers
    able |= {item.ref for item in never_ran}
    return Coverage(len(able) - len(never_ran), len(able), never_ran)


def _hidden(controller: Controller, file: str, motion: Collection[str]) -> Iterator[FunctionRef]:
    """Yield the functions of a file that may command by a name that nobody can read."""
    tree = parsed(controller.source_of(file)) if controller.is_python else None
    for call in () if tree is None else hidden_calls(tree, motion_names(motion)):
        if name := function_of(controller, Location(file, call.lineno)):
            yield FunctionRef(file, QualifiedName(name))


def _in_time(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    return tuple(sorted(findings, key=lambda finding: finding.time_s or 0.0))


def _objects(recording: Recording) -> tuple[ObjectOffset, ...]:
    note = recording.note(OBJECTS)
    return () if note is None else tuple(ObjectOffset(**item) for item in note["found"])


def _shown_scene(scene: str, root: Path) -> str:
    """Return how a scene is called: a file by its path from the controller's root."""
    path = Path(scene)
    return from_root(root.resolve(), path) if path.is_absolute() else scene


def _with_objects(scene: str, recording: Recording) -> str:
    """Return how a scene is called, with what a scenario put into it."""
    note = recording.note(GIVEN)
    count = len(note["bodies"]) if note is not None else 0
    if not count:
        return scene
    return f"{scene} with {count} object{'' if count == 1 else 's'} of the scenario"


def _inputs(controller: Controller, recording: Recording) -> tuple[str, ...]:
    """Return the files that a run depended on besides its sources.

    For a module with a placeholder they are where the real one would be found first.
    """
    given = recording.note(GIVEN) or {}
    names = [name for name in given.get("modules", ()) if name.isidentifier()]
    real = (file for name in names for file in (f"{name}.py", f"{name}/__init__.py"))
    folder, root = controller.path.resolve().parent, controller.root.resolve()
    built: tuple[str, ...] = ()
    if not controller.is_python:
        built = (*recording.sources, *included_files(recording.sources, root))
    files = [*built, *(from_root(root, folder / file) for file in real)]
    return (*_launched(recording)["inputs"], *files)


def _launched(recording: Recording) -> Mapping[str, Any]:
    return recording.note(LAUNCH) or {"notes": (), "inputs": ()}


def _started_by(recording: Recording) -> list[str]:
    """Return what an installed controller would have that the bare script has not."""
    lines = list(_launched(recording)["notes"])
    entry = recording.note(ENTRY)
    if entry is not None:
        named = f"named in {entry['named_in']}" if entry["named_in"] else "which nothing calls"
        lines.append(f"start: {entry['function']}() of the script, {named}, was called")
    lines += [
        f"import: {note.data['module']} was taken from {note.data['folder']}, "
        "which is not on the import path"
        for note in recording.notes
        if note.kind == ELSEWHERE
    ]
    return lines


def _converted(controller: Controller, recording: Recording) -> list[str]:
    """Return which files were converted from Python 2, and in what their run differs from it."""
    if not controller.is_python:
        return []
    files = _files(controller, recording)
    names = [file for file in files if is_python_2(controller.source_of(file))]
    if not names:
        return []
    return [
        f"source: {', '.join(names)} {'is' if len(names) == 1 else 'are'} Python 2, converted in "
        "memory for the run and unchanged but for blocks; byte strings are texts there, and "
        "dictionaries keep their order"
    ]


def _asked(ran: Ran) -> Iterator[str]:
    """Yield what the controller asked of its surroundings that a run has other than the robot."""
    controller, recording = ran.controller, ran.recording
    if not controller.is_python:
        return
    yield from asked({f: controller.source_of(f) for f in _files(controller, recording)})
    variables: dict[str, str] = {}
    for note in recording.notes:
        name, file = str(note.data.get("name")), str(note.data.get("file"))
        if note.kind == ASKED and name not in ran.settings.env:
            place = from_root(controller.root.resolve(), Path(file).resolve())
            variables.setdefault(name, f"{place}:{note.data.get('line')}")
    for name, place in sorted(variables.items()):
        yield (
            f"environment: {place} asked for the variable {name}, which a run does not have: where "
            f"it is set, the program may do something else; env = [{json.dumps(name)}] in "
            "[tool.tracerisk] passes it on"
        )


def _assumptions(ran: Ran) -> tuple[str, ...]:
    robot, settings, recording, end = ran.robot, ran.settings, ran.recording, ran.end
    lines = []
    if settings.robot is None:
        lines.append(f"robot: {robot.name}, {robot.chosen_by}")
        if robot.weighed:
            lines.append(f"robot: {robot.weighed}")
    if settings.scene is None:
        lines.append(f"scene: {ran.scene}, the default of the robot")
    distro = recording.note(DISTRO)
    if distro is not None:
        lines.append(distro["line"])
    lines += _started_by(recording)
    lines += _converted(ran.controller, recording)
    lines += _asked(ran)
    if robot.approximate:
        lines.append(f"robot: the figures of {robot.name} are approximate: some are assumed")
    lines += [f"robot: {sentence}" for sentence in robot.assumed_figures]
    if robot.masses is not None:
        lines.append(f"robot: {robot.masses.sentence}")
    if settings.hardware is None and not is_shipped(robot.name):
        lines.append(
            f"hardware: all figures are assumed, none are shipped for {robot.name}; give --hardware"
        )
    elif settings.hardware is None:
        lines += fitting_words(hardware_of(robot.name), elements_of(robot, settings))
    answers = [note.data["answer"] for note in recording.notes if note.kind == "input"]
    if answers:
        scripted = sum(1 for answer in answers if answer)
        lines.append(
            f"input: {scripted} questions got scripted answers, {len(answers) - scripted} got Enter"
        )
    if end.cause == "cycles":
        lines.append(
            f"mission: {settings.mission_cycles} cycles (mission_cycles), declared, not observed: "
            "the controller's loop has no end of its own"
        )
    if end.cause == "idle":
        lines.append("mission: over where the controller's loop had nothing more to command")
    if end.cause == "duration":
        lines.append(
            f"mission: cut after {end.simulated_s:g} s of simulated time (--duration); the "
            "controller did not end by itself"
        )
    return tuple(lines)
