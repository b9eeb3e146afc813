"""What a run showed, in a few lines to read and as plain data."""

from __future__ import annotations

import argparse
import contextlib
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tracerisk.adder.blocks.model_names import model_names
from tracerisk.cli.shared.output import note, place_data, scenario_advice, write_file
from tracerisk.common.function_ref import QualifiedName
from tracerisk.common.outcome.outcome import moved_line
from tracerisk.common.trace_log import write_log
from tracerisk.common.traced.elements import Element
from tracerisk.common.traced.findings import NOTES, Finding
from tracerisk.config import FailOn, controller_root, from_here
from tracerisk.errors import ExitCode, InputError, Location
from tracerisk.pipeline.trace.kept_verdict import kept_verdict
from tracerisk.trace import NOT_THERE, Trace

if TYPE_CHECKING:
    from tracerisk.adder.figures.computed import ComputedBlocks
    from tracerisk.adder.lock.lock import ControllerLock
    from tracerisk.adder.merge.owned import MovedUse
    from tracerisk.pipeline.annotate import Annotated

_SHOWN_S = 0.005  # less is printed as 0.00
_TOGETHER = {"encoder": "encoders", "torque": "torque sensors"}


def trace_as_typed(trace: Trace, controller: str | Path) -> Trace:
    """Return the trace of a controller, with files as a user would type them from here."""
    return trace.with_files(from_here(controller_root(Path(controller))))


def note_draft(trace: Trace, *, quiet: bool) -> None:
    """Warn on standard error that nobody has confirmed what a run depended on."""
    if trace.drafted:
        note(f"tracerisk: drafted: {trace.drafted}", quiet=quiet)


def note_moved(moved: Iterable[MovedUse], controller: Path | str, *, quiet: bool) -> None:
    """Warn on standard error of values set by hand for what their function does no more."""
    for one in moved:
        note(f"{controller}: moved: {one.message}; {one.remedy}", quiet=quiet)


def headline(trace: Trace) -> str:
    """Return one line: which controller, on what, how long, and how the run ended."""
    how = "measured" if trace.is_measured else "simulated"
    seconds = "" if trace.end.simulated_s is None else f", {trace.end.simulated_s:.1f} s {how}"
    where = f" ({trace.end.location})" if trace.end.location is not None else ""
    on = f" on {trace.robot}" if trace.robot else ""
    on += f" in scene {trace.scene}" if trace.scene else ""
    return f"{trace.controller or 'a robot'}{on}{seconds}: {trace.end.message}{where}"


def object_lines(trace: Trace) -> list[str]:
    """Return which objects moved, how many stand at their goal, and a line for each astray.

    The last line says how much of the mission that the scenario declares was brought about.
    """
    moved = moved_line(trace.outcome)
    lines = [*([moved] if moved else []), *_goal_lines(trace)]
    if trace.success:
        met = sum(condition.is_met for condition in trace.success)
        plural = "" if len(trace.success) == 1 else "s"
        lines.append(f"success: {met} of {len(trace.success)} condition{plural} met")
    return lines


def _goal_lines(trace: Trace) -> list[str]:
    with_goal = [object_offset for object_offset in trace.objects if object_offset.goal is not None]
    if not with_goal:
        return []
    at_goal = [object_offset for object_offset in with_goal if object_offset.stands_at_goal]
    if not at_goal:
        return [f"objects: none of {len(with_goal)} stands at its goal"]
    lines = [f"objects: {len(at_goal)} of {len(with_goal)} stand at their goal"]
    if at_goal:
        largest = max(object_offset.offset_m for object_offset in at_goal)
        lines[0] += f", at most {1000.0 * largest:.2f} mm off"
    lines += [
        f"  {object_offset.name}: {1000.0 * object_offset.offset_m:.1f} mm from "
        f"{object_offset.goal}" + ("" if object_offset.upright else ", not upright")
        for object_offset in with_goal
        if object_offset not in at_goal
    ]
    return lines


def finding_line(finding: Finding) -> str:
    """Return a finding as one line."""
    place = "" if finding.location is None else f"{finding.location}: "
    time = "" if finding.time_s is None else f" (at {finding.time_s:.2f} s)"
    if finding.recovered_s is not None:
        time = f" (at {finding.time_s:.2f} s, a retry at {finding.recovered_s:.2f} s succeeded)"
    return f"{place}{finding.message}{time}"


def finding_lines(trace: Trace) -> list[str]:
    """Return the findings of a run, and the functions of which it shows nothing."""
    lines = [finding_line(finding) for finding in trace.findings]
    lines += [
        f"{uncovered.ref.file}:{uncovered.line}: {uncovered.ref.name} can move the arm and never "
        "ran: no risk data"
        for uncovered in trace.uncovered
    ]
    return lines


def finding_exit(trace: Trace, fail_on: FailOn | None) -> ExitCode:
    """Return 1 where the run has findings on which it is to fail, and say how many."""
    counted = [
        finding
        for finding in trace.findings
        if finding.recovered_s is None
        and (finding.kind == fail_on or (fail_on == "finding" and finding.kind not in NOTES))
    ]
    if not counted:
        return ExitCode.FINE
    text = "1 finding" if len(counted) == 1 else f"{len(counted)} findings"
    note(f"tracerisk: {text}, and --fail-on {fail_on}")
    return ExitCode.WOULD_CHANGE


def trace_lines(trace: Trace) -> list[str]:
    """Return what the trace holds of each relevant function, a line each."""
    lines = []
    names = model_names([function.ref for function in trace.functions])
    sensors = {element.name: element for element in trace.elements if element.kind == "sensor"}
    for function in trace.functions:
        visits = [visit for visit in trace.visits if visit.function == function.ref]
        seconds: dict[str, float] = {}
        read: dict[str, float] = {}
        for visit in visits:
            for name, exposure in visit.exposures.items():
                if exposure is None:
                    continue
                if name in sensors:
                    read[name] = read.get(name, 0.0) + exposure.reading_s
                else:
                    seconds[name] = seconds.get(name, 0.0) + exposure.active_s
        active = ", ".join(
            (
                *(f"{name} {total:.2f} s" for name, total in seconds.items() if total),
                *(f"{name} read {total:.2f} s" for name, total in _by_kind(read, sensors)),
            )
        )
        is_script = function.ref.file == trace.controller
        # Function names of another source than a run's have no line.
        line = f"line {function.line}, " if function.line else ""
        where = f"{'' if is_script else f'{function.ref.file}, '}{line}"
        count = f"{len(visits)} visit{'s' if len(visits) != 1 else ''}"
        lines.append(
            f"  {function.call_sequence} {names[function.ref]} ({where}{count}): "
            f"{active or 'nothing active'}"
        )
    return lines or ["  no function commanded hardware"]


def _by_kind(
    read: Mapping[str, float], sensors: Mapping[str, Element]
) -> Iterable[tuple[str, float]]:
    """Return for how long sensors were read, those in joints together: the longest of a kind."""
    values: dict[str, float] = {}
    for name, seconds in read.items():
        kind = sensors[name].sensor
        shown = _TOGETHER.get(kind or "", name)
        values[shown] = max(values.get(shown, 0.0), seconds)
    return [(name, seconds) for name, seconds in values.items() if seconds >= _SHOWN_S]


def print_failure(trace: Trace) -> int:
    """Return how a run ended badly and what it had shown so far; return the exit code."""
    place = "" if trace.end.location is None else f"{trace.end.location}: "
    note(f"tracerisk: {place}{trace.end.message} [{trace.end.code}]")
    for line in trace.assumptions:
        if NOT_THERE in line:
            note(line)
    if trace.verdict is not None:
        note(f"verdict: {trace.verdict.kind}")
    seconds = 0.0 if trace.end.simulated_s is None else trace.end.simulated_s
    note(f"The trace so far, {seconds:.1f} s simulated:")
    for line in [*trace_lines(trace), *(f"  {line}" for line in finding_lines(trace))]:
        note(line)
    note("No source was changed.")
    if trace.end.scenario:
        note(scenario_advice(trace.end.scenario))
    return int(failure_code(trace))


def failure_code(trace: Trace) -> ExitCode:
    """Return the exit code of a badly ended run: an import that fails is bad input."""
    missing = trace.end.cause == "not_importable"
    return ExitCode.BAD_INPUT if missing else ExitCode.CONTROLLER_FAILED


def failure_of(trace: Trace) -> dict[str, Any] | None:
    """Return the error that a badly ended run amounts to, as data; `None` after a good end."""
    if trace.end.is_good:
        return None
    return {
        "kind": ("SourceError" if trace.end.cause == "not_importable" else "ControllerFailedError"),
        "code": trace.end.code,
        "message": trace.end.message,
        **place_data(trace.end.location),
        "scenario": trace.end.scenario or None,
    }


def write_outputs(options: argparse.Namespace, computed: ComputedBlocks) -> None:
    """Write the log where one was asked for."""
    if options.log is not None:
        names = computed.names
        log = {QualifiedName(names[ref]): item for ref, item in computed.observed.items()}
        write_file(options.log, write_log(log))


def other_steps(annotated: Annotated) -> Iterator[str]:
    """Yield which functions are steps now and were not in the run before, of the same code."""
    controller, change = annotated.controller, annotated.change
    before = controller.project.lock.controllers.get(controller.file)
    if before is None or change is None:
        return
    now = change.lock.controllers[controller.file]
    if before.inputs.get("sources") != now.inputs.get("sources"):
        return
    (steps_then, unreached_then), (steps_now, unreached_now) = map(_steps, (before, now))
    # What was not reached in one of the runs may well be a step of the other.
    came = sorted(steps_now - steps_then - unreached_then)
    went = sorted(steps_then - steps_now - unreached_now)
    if came or went:
        are = f"{', '.join(came)} now counts by itself" if came else ""
        are_not = f"what {', '.join(went)} does now counts for its callers" if went else ""
        yield (
            f"{' and '.join(filter(None, (are, are_not)))}, though the code is as it was: which "
            "functions are steps, and which only help these, follows from the calls that ran; "
            "`states` and `helpers` in [tool.tracerisk] settle it"
        )


def _steps(entry: ControllerLock) -> tuple[set[str], set[str]]:
    """Return the names of the functions with blocks, and of those that a run did not reach."""
    verdict = kept_verdict(entry)
    unreached = () if verdict is None else verdict.coverage.never_ran
    steps = {name for blocks in entry.blocks.values() for name in blocks}
    return steps, {str(one.ref.name) for one in unreached}


def blocks_line(path: str, count: int, *, keeps_files: bool, is_changed: bool) -> str:
    """Return one line on what became of a source's blocks."""
    outcome = "unchanged"
    if is_changed:
        outcome = "would change" if keeps_files else "changed"
    return f"{path}: {count} risk block{'' if count == 1 else 's'}, {outcome}"


@contextlib.contextmanager
def recording_folder(
    options: argparse.Namespace, *, is_wanted: bool = False
) -> Iterator[Path | None]:
    """Give the folder in which the recording stays for as long as it is needed, `None` for none.

    It is needed where options ask for it, or it `is_wanted` for something else.
    """
    record = options.record
    if record is not None:
        from tracerisk.pipeline.recordings.writing.write import check_rate, load_writer

        check_rate(options.record_rate)
        if not Path(record).absolute().parent.is_dir():
            raise InputError("its folder does not exist; make it first", Location(record))
        load_writer()
    if options.keep is not None:
        yield Path(options.keep)
    elif record is None and not is_wanted:
        yield None
    else:
        with tempfile.TemporaryDirectory(prefix="tracerisk-") as folder:
            yield Path(folder)


def write_record(options: argparse.Namespace, keep: Path | None, trace: Trace) -> None:
    """Write the run that `keep` holds as an MCAP file, where one was asked for."""
    if options.record is None or keep is None:
        return
    from tracerisk.pipeline.recordings.writing.write import write_recording

    write_recording(keep, trace, Path(options.record), rate_hz=options.record_rate)
