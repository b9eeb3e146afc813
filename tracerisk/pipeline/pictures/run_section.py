"""The section of a report that shows a run: its timeline, and its replay where it was recorded."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from tracerisk.common.hardware.binding import bind
from tracerisk.pipeline.trace.run_files import ROBOT, RunRequest
from tracerisk.report.html.run.replay import RecordedRun, make_replay
from tracerisk.ros.scenario.file.scenario_reader import read_scenario
from tracerisk.ros.scenario.objects import with_objects
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.robots.file import read_dumped_robot

if TYPE_CHECKING:
    from tracerisk.common.hardware.model import Hardware
    from tracerisk.report.html.section import Section
    from tracerisk.trace import Trace
    from tracerisk.twin.faults.fault import Fault


def run_section(
    trace: Trace,
    hardware: Hardware,
    run: RecordedRun | None = None,
    faults: Sequence[Fault] = (),
) -> Section | None:
    """Return the section of a run; `None` for one of which no visit has a time.

    `run` is what was recorded of it; without it there is no replay. `faults` are marked on it.
    Raises HardwareError where the hardware description does not fit the trace.
    """
    from tracerisk.report.html.run.timeline import timeline_section

    if not trace.end.simulated_s or all(visit.duration_s is None for visit in trace.visits):
        return None
    components = {
        bound_component.component.name: bound_component.elements
        for bound_component in bind(hardware, trace.elements)
    }
    replay = None if run is None else make_replay(run, trace.end.simulated_s)
    return timeline_section(trace, components, replay=replay, faults=faults)


def recorded_run(recording: Path) -> RecordedRun | None:
    """Return what was simulated, from the folder that keeps it; `None` where nothing was.

    What is returned needs the folder no longer.
    Raises LogError where the recording is damaged.
    """
    from tracerisk.twin.physics.declared_log import read_declared
    from tracerisk.twin.recording.samples import has_samples, read_samples

    if not has_samples(recording):
        return None
    request = RunRequest.loads((recording / "request.json").read_text(encoding="utf-8"))
    robot = read_dumped_robot(recording / ROBOT)
    scene = load_scene(request.scene)
    if request.scenario is not None:
        scene = with_objects(scene, read_scenario(Path(request.scenario)).objects)
    return RecordedRun(read_samples(recording), robot, scene, read_declared(recording))
