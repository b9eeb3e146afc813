"""The surroundings of a controller: files, imports, time and input as it finds them."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from tracerisk.common.sandbox.files.moved_files import MovedFiles
from tracerisk.common.sandbox.files.overlay import BOUND, Overlay
from tracerisk.common.text.bounded import file_bytes
from tracerisk.instrument.import_finder import controller_imports
from tracerisk.instrument.loader import Sources, prepared_controller
from tracerisk.instrument.recorder import Recorder
from tracerisk.pipeline.run.assembly.graph import ServedGraph
from tracerisk.pipeline.run.assembly.imports import Imports
from tracerisk.pipeline.run.assembly.watches import Watches
from tracerisk.pipeline.run.assembly.world import SimulatedWorld
from tracerisk.pipeline.run.scripted_input import Answers, scripted_input
from tracerisk.pipeline.trace.run_files import ASKED, RunRequest
from tracerisk.pipeline.workspace.entry_point import EntryPoint, find_entry_point
from tracerisk.pipeline.workspace.project import Project
from tracerisk.pipeline.workspace.workspace import Workspace
from tracerisk.ros.controller.asked_variables import asked_variables
from tracerisk.ros.controller.needs import asking_place
from tracerisk.ros.drafts.answers.known_answers import known_answers
from tracerisk.ros.graph.runtime import activate
from tracerisk.ros.imports.numpy_names import removed_numpy_names
from tracerisk.ros.imports.opencv_names import served_opencv_names
from tracerisk.ros.imports.pymoveit2_releases import served_older_releases
from tracerisk.ros.imports.python_names import removed_python_names
from tracerisk.ros.keyboard.scripted_keys import ScriptedKeys
from tracerisk.ros.robot.bring_up.answered_commands import answered_commands
from tracerisk.ros.time.patches import virtual_time

_MOST_DENIED = 50


@dataclass(frozen=True, slots=True)
class PreparedController:
    """A controller that is compiled, in its surroundings."""

    run: Callable[[], None]
    """Runs it once, as `__main__`."""
    entry: EntryPoint | None
    """The function that is called then; `None` where the script starts by itself."""
    overlay: Overlay | None
    """Where its writes go; `None` where it writes as it likes."""


@contextlib.contextmanager
def controller_surroundings(
    request: RunRequest,
    project: Project,
    world: SimulatedWorld,
    graph: ServedGraph,
    watches: Watches,
    imports: Imports,
) -> Iterator[PreparedController]:
    """Put the controller's surroundings in the place of the machine's, and compile it.

    Raises as `prepared_controller` does where it cannot be compiled.
    """
    script, recorder = Path(request.controller), world.recorder
    not_simulated = partial(recorder.finding, "not_simulated")
    entry = find_entry_point(script, file_bytes(script), project.root)
    with (
        _contained_files(request, recorder) as overlay,
        _moved_files(script, project, graph.workspace, recorder).active(),
        activate(graph.runtime),
        imports.stand_ins,
        imports.beside.active(),
        imports.installed.active(),
        imports.placeholders,
        imports.windows,
        imports.web,
        imports.screens,
        answered_commands(graph.runtime),
        removed_numpy_names(),
        removed_python_names(request.distro.name),
        served_opencv_names(),
        served_older_releases(),
        virtual_time(world.scheduler, seed=request.seed, note=not_simulated),
        scripted_input(_answers(request, world, graph, watches)),
        asked_variables(partial(recorder.note, ASKED)),
        prepared_controller(
            script,
            world.tracer,
            request.argv,
            root=project.root,
            entry=entry.function if entry else None,
            sources=Sources(request.replaced_bytes, request.instrumented),
        ) as run,
        controller_imports(imports.own),
    ):
        yield PreparedController(run, entry, overlay)


def _answers(
    request: RunRequest, world: SimulatedWorld, graph: ServedGraph, watches: Watches
) -> Answers:
    """Return what the controller reads on its standard input."""
    answers = Answers(
        (*request.answers, *world.scenario.answers),
        world.recorder,
        world.scheduler,
        request.controller,
        assume=lambda: known_answers(asking_place(), watches.values),
        progress=lambda: watches.run.last_command_ns,
        firsts_come_ns=graph.scenario.firsts_come_ns,
        is_moving=lambda: watches.run.is_commanding,
    )
    # Libraries that read keys by themselves.
    graph.runtime.clients[ScriptedKeys] = answers.keys
    return answers


def _moved_files(
    script: Path, project: Project, workspace: Workspace, recorder: Recorder
) -> MovedFiles:
    """Return where files are that the author names by another machine's paths, or from elsewhere.

    Those that are found are noted.
    """

    def note(path: str, here: str) -> None:
        place = os.path.relpath(here, root)
        recorder.finding(
            "file_elsewhere",
            f"{path} is not here: {place} of the workspace is taken for it",
            asking_place(),
            object_name=path,
        )

    root, top = project.root, project.top
    folders = {**workspace.installed, root.name: root, **workspace.packages}
    return MovedFiles(folders, top, note, (script.parent, root, top))


@contextlib.contextmanager
def _contained_files(request: RunRequest, recorder: Recorder) -> Iterator[Overlay | None]:
    """Redirect writes of a contained controller; report once what it is refused."""
    if request.written is None:
        yield None
        return
    reported: set[tuple[str, str]] = set()

    def denied(verb: str, what: str) -> None:
        if (verb, what) in reported or len(reported) >= _MOST_DENIED:
            return
        reported.add((verb, what))
        advice = "nothing leaves the process of a run"
        if verb == "read":
            advice = f'readable = ["{what}"] in [tool.tracerisk] allows it'
        elif verb == BOUND:
            advice = "the system allows it no network of its own, in which its parts could listen"
        recorder.finding(
            "denied", f"{what} was not {verb}: the run is contained; {advice}", object_name=what
        )

    def absent_home(home: str) -> None:
        recorder.finding(
            "file_elsewhere",
            f"{home} is not here: what is written below it goes into a folder of the run",
            asking_place(),
            object_name=home,
        )

    overlay = Overlay(request.written, request.writable, denied, absent_home)
    with overlay.active():
        yield overlay
