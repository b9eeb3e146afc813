"""The public Python API: the work of the verbs as functions, without printing.

Each takes paths and settings, and returns frozen data; nothing is written unless the function is
named so. `docs/python.md` shows them at work. Those of `verbs.py` the package offers too; here are
the campaigns of runs besides. All that a function needs is imported when it is called.
"""

from __future__ import annotations

from tracerisk.common.campaign import DEFAULT_CAMPAIGN
from tracerisk.common.campaign import CampaignOptions as CampaignOptions
from tracerisk.errors import InputError, Location
from tracerisk.pipeline.scenarios.run_failed import RunFailedError as RunFailedError
from tracerisk.verbs import annotate as annotate
from tracerisk.verbs import assess as assess
from tracerisk.verbs import build as build
from tracerisk.verbs import check as check
from tracerisk.verbs import diff as diff
from tracerisk.verbs import load_controller as load_controller
from tracerisk.verbs import load_hardware as load_hardware
from tracerisk.verbs import load_settings as load_settings
from tracerisk.verbs import overrides as overrides
from tracerisk.verbs import refresh as refresh
from tracerisk.verbs import solve as solve
from tracerisk.verbs import strip as strip
from tracerisk.verbs import trace_controller as trace_controller
from tracerisk.verbs import write_blocks as write_blocks

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from pathlib import Path
    from typing import Any

    from tracerisk.common.evidence.cells import Evidence
    from tracerisk.config import Settings
    from tracerisk.pipeline.evidence.sweep import SweepPoint
    from tracerisk.pipeline.run.ended_run import Progress
    from tracerisk.pipeline.run.fault_run import FaultRun
    from tracerisk.pipeline.workspace.controller import Controller
    from tracerisk.report.mutants import MutantRuns
    from tracerisk.trace import Trace
    from tracerisk.twin.robots.robot import Robot


def load_robot(controller: Controller, settings: Settings) -> Robot:
    """Return the robot that a controller drives; `Robot.chosen_by` says why it is this one.

    Raises RobotError when it is unknown, or several fit.
    """
    from tracerisk.pipeline.robot.choice import driven_robot

    return driven_robot(controller, settings)


def gather_evidence(
    path: str | Path,
    settings: Mapping[str, Any] | None = None,
    options: CampaignOptions = DEFAULT_CAMPAIGN,
    *,
    cells: int | None = None,
    until: float | None = None,
) -> Evidence:
    """Fail each unit of the robot at drawn instants, and write what became of the mission.

    `cells` is how many are drawn; `until` goes on until the 90 % interval of the mission's factor
    is no wider. The file is `tracerisk.evidence` in the controller's root; what it holds already
    is not tried again, unless the options say otherwise.
    Raises ControllerFailedError where the run without a failure came to a bad end.
    """
    from pathlib import Path

    from tracerisk.common.dependencies import require_simulator
    from tracerisk.pipeline.evidence.campaign import gather

    require_simulator("trying failures")
    return gather(Path(path), settings, options, cells=cells, until=until)


def sweep(
    path: str | Path,
    over: Sequence[str] | Mapping[str, Sequence[Any]],
    settings: Mapping[str, Any] | None = None,
    options: CampaignOptions = DEFAULT_CAMPAIGN,
) -> tuple[SweepPoint, ...]:
    """Run a controller at every combination of values, and return the figure of each.

    `over` names what to vary with its values: a setting, `param:/NAME` or `scenario:PATH`, as a
    mapping or as texts NAME=VALUE,VALUE. Nothing but the cache is written.
    Raises InputError for what cannot be varied.
    """
    from collections.abc import Mapping
    from pathlib import Path

    from tracerisk.common.dependencies import require_simulator
    from tracerisk.pipeline.evidence.sweep import Factor, parse_factor, sweep

    require_simulator("sweeping over runs")
    if isinstance(over, Mapping):
        factors = [Factor(name, tuple(values)) for name, values in over.items()]
    else:
        factors = [parse_factor(text) for text in over]
    return sweep(Path(path), factors, settings, options)


def mutate(
    path: str | Path,
    settings: Mapping[str, Any] | None = None,
    options: CampaignOptions = DEFAULT_CAMPAIGN,
    *,
    most: int | None = None,
) -> MutantRuns:
    """Change a controller at one place at a time, run each, and return what is noticed.

    At most `most` changes are tried, 60 by default, drawn by the seed of the settings. Nothing but
    the cache is written: files are changed in memory. Raises ControllerFailedError where the run
    without a change came to a bad end, and InputError where there is nothing to change.
    """
    from pathlib import Path

    from tracerisk.common.dependencies import require_simulator
    from tracerisk.pipeline.mutation.campaign import MOST, mutate

    require_simulator("running changes of a controller")
    return mutate(Path(path), settings, options, most=MOST if most is None else most)


def evidence(path: str | Path) -> Evidence:
    """Return the evidence that is kept of a controller, whether it is stale or not.

    Raises InputError where there is none.
    """
    from tracerisk.common.evidence import EVIDENCE_NAME
    from tracerisk.common.evidence.file import read_evidence

    controller = load_controller(path)
    kept = controller.root / EVIDENCE_NAME
    found = read_evidence(kept).get(controller.file)
    if found is None:
        raise InputError(
            f"holds no evidence of {controller.file}; `tracerisk evidence {path}` gathers it",
            Location(str(kept)),
        )
    return found


def evidence_replays(
    path: str | Path,
    found: Evidence,
    folder: str | Path,
    settings: Mapping[str, Any] | None = None,
    *,
    progress: Callable[[int, int, float], None] | None = None,
) -> int:
    """Write a page with the replay of each failure that matters; return how many.

    They are the worst of each component, mode and function that ended the mission; `index.html`
    leads to them. `progress` as in `gather_evidence`. Raises as that, and InputError where the
    folder is a file.
    """
    from pathlib import Path

    from tracerisk.common.dependencies import require_simulator
    from tracerisk.pipeline.pictures.evidence_replays import write_replays

    require_simulator("replaying failures")
    return write_replays(Path(path), found, Path(folder), settings, progress=progress)


def run_with_faults(
    path: str | Path,
    faults: Sequence[str],
    settings: Mapping[str, Any] | None = None,
    *,
    keep: Path | None = None,
    progress: Progress | None = None,
    on_nominal: Callable[[Trace], None] | None = None,
) -> FaultRun:
    """Run a controller on the twin, and once more with `faults`, each as UNIT:MODE@SECONDS.

    `keep` is a folder for the recording of the run with the faults. `on_nominal` takes the
    trace of the run without, as soon as it is over. Writes nothing but `keep`: no blocks, no
    lock, no trace.
    Raises InputError for a fault that is none or that the robot cannot have, RunFailedError when
    the run without a fault came to a bad end, and ControllerFailedError when it commanded nothing.
    """
    from tracerisk.common.dependencies import require_simulator
    from tracerisk.twin.faults.fault import parse_fault

    parsed = [parse_fault(each) for each in faults]
    if not parsed:
        raise InputError("no fault is given; expected UNIT:MODE@SECONDS")
    controller = load_controller(path)
    loaded = load_settings(controller, settings)
    require_simulator("running a controller")
    from tracerisk.pipeline.run.ended_run import RunOptions
    from tracerisk.pipeline.run.fault_run import nominal_run, run_with_faults
    from tracerisk.pipeline.scenarios.trace_controller import nothing_commanded

    nominal = nominal_run(controller, loaded, RunOptions(progress=progress))
    if not nominal.trace.is_usable:
        raise RunFailedError(nominal.trace)
    if not nominal.trace.functions:
        raise nothing_commanded(nominal.trace, controller)
    if on_nominal is not None:
        on_nominal(nominal.trace)
    return run_with_faults(controller, loaded, nominal, parsed, RunOptions(keep, progress))
