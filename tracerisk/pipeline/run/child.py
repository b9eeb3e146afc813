"""The process in which a controller runs: the twin, the stand-ins, the tracer and its end.

Started by `tracerisk.pipeline` with the name of a file, the request; what it finds it
writes into the folder of the recording at once, so that a sudden death loses nothing seen.
"""

from __future__ import annotations

import faulthandler
import gc
import os
import resource
import signal
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TextIO

from tracerisk.common.sandbox.limited_process import lower_limit, mark_start
from tracerisk.errors import ExitCode, TraceRiskError
from tracerisk.instrument.recorder import Recorder
from tracerisk.pipeline.launch.bringup_parameters import ParametersAround
from tracerisk.pipeline.launch_files.records import NOTHING_LAUNCHED
from tracerisk.pipeline.run.assembly.graph import ServedGraph, build_graph
from tracerisk.pipeline.run.assembly.imports import build_imports
from tracerisk.pipeline.run.assembly.surroundings import controller_surroundings
from tracerisk.pipeline.run.assembly.watches import build_watches, note_run_over
from tracerisk.pipeline.run.assembly.world import build_world, wall_clock
from tracerisk.pipeline.run.branching.points import BranchPoints
from tracerisk.pipeline.run.child_output import tell_wait
from tracerisk.pipeline.run.controller_end import ControllerEnd
from tracerisk.pipeline.run.preparation import prepare
from tracerisk.pipeline.trace.run_files import (
    AROUND,
    ENTRY,
    EVENTS,
    GRAPH_USE,
    STACKS,
    STARTED,
    RunRequest,
    WallTime,
)
from tracerisk.pipeline.workspace.entry_point import EntryPoint
from tracerisk.pipeline.workspace.project import Project
from tracerisk.ros.robot.trajectories.robot_spaces import words_of_several_arms
from tracerisk.twin.recording.samples import SampleWriter

__all__ = ["main", "prepare"]
_MB = 1024 * 1024


def main() -> int:
    """Run the request named on the command line; the exit code says how the run ended."""
    request = RunRequest.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    lower_limit(resource.RLIMIT_AS, request.memory_limit_mb * _MB)
    folder = Path(request.folder)
    with (folder / STACKS).open("w") as stacks:
        # The parent asks where an endless loop stands before it ends the process.
        faulthandler.register(signal.SIGUSR1, file=stacks, all_threads=True)
        return recorded(request, partial(_run, stacks))


def recorded(request: RunRequest, run: Callable[[RunRequest, SampleWriter, Recorder], None]) -> int:
    """Carry out a run that leaves a recording; return the code with which its process ends."""
    folder = Path(request.folder)
    # What is imported by now stays; what a controller makes is collected as ever.
    gc.freeze()
    gc.enable()
    with (folder / EVENTS).open("wb", buffering=0) as stream, SampleWriter(folder) as samples:
        # The world that the run builds gives the recorder its clock.
        recorder = Recorder(stream, clock=lambda: 0)
        try:
            run(request, samples, recorder)
        except TraceRiskError as error:
            # Nothing has run: the source, the robot or the scene is at fault.
            _refuse(recorder, error)
            return int(error.exit_code)
    return 0


def _run(stacks: TextIO, request: RunRequest, samples: SampleWriter, recorder: Recorder) -> None:
    """Build what a run is made of, and let the controller run in it to its end."""
    project = Project(Path(request.root))
    world = build_world(request, samples, recorder)
    graph = build_graph(request, project, world)
    watches = build_watches(request, project, world, graph)
    imports = build_imports(request, project, world, graph, watches)
    scheduler = world.scheduler
    end = ControllerEnd(
        recorder,
        world.twin,
        project.root,
        request.memory_limit_mb,
        lambda cause: note_run_over(cause, request, world, graph, watches),
        watches.needs.judge,
        imports.missing,
        scheduler.outlast,
        on_missing=watches.needs.modules_missing,
    )
    scheduler.on_silence = partial(tell_wait, stacks)
    scheduler.on_stuck, scheduler.on_abort = end.kill, end.abort
    with controller_surroundings(request, project, world, graph, watches, imports) as controller:
        _begin(request, project, graph, recorder, controller.entry)

        def run() -> None:
            graph.companions.start()
            controller.run()

        points = BranchPoints(
            *(request, world.twin, samples, end, controller.overlay, watches.fate),
            programs=scheduler.programs,
        )
        graph.reads.watch()
        mark_start()
        points.begin()
        began = wall_clock()
        end.run(lambda: scheduler.run_main(run))
        recorder.note(GRAPH_USE, counts=dict(sorted(graph.runtime.graph.counts.items())))
        if words := words_of_several_arms(graph.runtime):
            recorder.finding("one_robot", words)
        for name, place in imports.missing.went_without(imports.stand_ins.in_vain):
            words = f"{name} is not here, and the program went on without: what it would do by it"
            recorder.finding("unprovided", f"{words} is in no figure", place, object_name=name)
        world.twin.close()
        WallTime(wall_clock() - began, world.metered.seconds).write(points.folder)
        points.finish()


def _begin(
    request: RunRequest,
    project: Project,
    graph: ServedGraph,
    recorder: Recorder,
    entry: EntryPoint | None,
) -> None:
    """Give the process the paths, parameters and variables that the controller begins with."""
    # Behind what is installed: a build puts no file before another package's.
    sys.path += [str(folder) for folder in graph.workspace.import_paths]

    # The controller's own modules leave no `__pycache__` in its folder.
    sys.dont_write_bytecode = True
    recorder.note(STARTED)
    if graph.ros != 2 and request.reads_around:
        graph.runtime.graph.parameters.fall_back_on(
            ParametersAround(
                Path(request.controller),
                project.root,
                graph.workspace,
                lambda name, files: recorder.note(
                    AROUND, name=name, files=[str(file) for file in files]
                ),
            )
        )
    os.environ.update(
        {"ROS_DISTRO": request.distro.name, "ROS_VERSION": "2" if graph.ros == 2 else "1"}
    )
    os.environ.update((request.launch or NOTHING_LAUNCHED).environment)
    if entry is not None:
        recorder.note(ENTRY, function=entry.function, named_in=entry.named_in)


def _refuse(recorder: Recorder, error: TraceRiskError) -> None:
    """Note why a run could not begin."""
    place = error.location
    recorder.note(
        "failed",
        error=type(error).__name__,
        message=error.message,
        location=None if place is None else [place.file, place.line, place.column],
    )


if __name__ == "__main__":
    try:
        code = main()
    except TraceRiskError as problem:
        print(problem, file=sys.stderr)  # noqa: T201 - it has no other mouth
        code = int(problem.exit_code)
    except MemoryError:
        code = int(ExitCode.CONTROLLER_FAILED)
    sys.stdout.flush()
    sys.exit(code)
