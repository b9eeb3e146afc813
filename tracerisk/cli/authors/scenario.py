"""`tracerisk scenario`: what a controller needs of its world, and a scenario that gives it."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tracerisk import api
from tracerisk.cli.shared import options as shared
from tracerisk.cli.shared.output import note, print_json, show
from tracerisk.cli.shared.progress import progress_bar
from tracerisk.cli.shared.run_report import failure_code, print_failure, trace_as_typed
from tracerisk.cli.shared.values import positive
from tracerisk.cli.shared.verdict import verdict_json
from tracerisk.common.text.bounded import MOST_WRITTEN, file_bytes
from tracerisk.common.text.plain_data import picked
from tracerisk.common.traced.findings import NOTHING_TO_GRASP, Finding
from tracerisk.config import from_here
from tracerisk.errors import ControllerFailedError, ExitCode, InputError, Location
from tracerisk.pipeline.workspace.needs_in_source import asked_in_source

if TYPE_CHECKING:
    from tracerisk.pipeline.scenarios.entries import ScenarioDraft
    from tracerisk.pipeline.workspace.controller import Controller
    from tracerisk.ros.controller.needs import Missed, Need

_LINES = 3
_SEARCH_S = 60.0
_ENDING = ".scenario.yaml"
_PLACE = re.compile(r"at \((-?[\d.]+), (-?[\d.]+), (-?[\d.]+)\) m")
"""Where a gripper closed on nothing, in the words of the finding."""
_ALLOWED = re.compile(r"allows (-?[\d.]+) to (-?[\d.]+) m")
"""Which widths a grasp takes, in the words of why it was aborted."""
_WIDTH_M = 0.04  # of a drafted thing, where nothing says more [m]
_TOP_M = 0.02  # how far a drafted thing reaches above the middle between the pads [m]


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument(
        "--write",
        action="store_true",
        help="write a scenario with which it runs: FILE without .py and with .scenario.yaml",
    )
    parser.add_argument(
        "-o", "--output", metavar="OUT.yaml", help="where --write writes; what is there is kept"
    )
    parser.add_argument(
        "--no-run",
        dest="is_run",
        action="store_false",
        help="list what the source asks for alone",
    )
    parser.add_argument(
        "--search-limit",
        dest="search_limit_s",
        metavar="S",
        type=positive,
        default=_SEARCH_S,
        help="computing time of its runs after which the search ends with the best so far (60 s)",
    )
    shared.add_run_options(parser)
    shared.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the verb and return its exit code."""
    controller = api.load_controller(options.controller)
    settings = api.load_settings(controller, shared.run_settings(options))
    if not options.is_run:
        if options.write or options.output is not None:
            raise InputError("--no-run writes nothing: leave out --write and --output")
        asked = asked_in_source(controller)
        if options.json:
            print_json("scenario", source=[_data(missed.need, missed.location) for missed in asked])
        else:
            _print_asked(asked, "in the source", from_here(controller.root))
        return 0
    output = _output(options, controller)
    base = Path(settings.scenario) if settings.scenario is not None else None
    if base is None and options.write and output.exists():
        base = output
    if base is not None and options.write and output.exists() and not output.samefile(base):
        raise InputError(
            f"is there already and would be lost; name it with --scenario, or another with -o "
            f"(the scenario is {base})",
            Location(str(output)),
        )
    draft, asked = _drafted(options, controller, settings, base)
    if options.write:
        write_scenario(output, draft.text)
    code = _exit_code(draft)
    if options.json:
        _print_json(options, output, draft, asked, code)
        return code
    _print_draft(options, output, draft, asked, from_here(controller.root))
    if draft.error is not None:
        raise draft.error
    if draft.trace is None:
        note("No run with it has come to its end: what it shows is not known.")
    elif code:
        note("With it the run still shows no risk:", quiet=options.quiet)
        if not draft.trace.is_usable:
            return print_failure(trace_as_typed(draft.trace, controller.path))
        raise ControllerFailedError("nothing was commanded", draft.trace.end.location)
    return code


def _exit_code(draft: ScenarioDraft) -> int:
    trace = draft.trace
    if draft.error is not None:
        return int(draft.error.exit_code)
    if trace is not None and trace.is_usable:
        return 0 if trace.functions else int(ExitCode.CONTROLLER_FAILED)
    return int(ExitCode.CONTROLLER_FAILED if trace is None else failure_code(trace))


def write_scenario(output: Path, text: str) -> None:
    """Write the scenario, unless the file holds just that."""
    try:
        is_same = file_bytes(output, MOST_WRITTEN) == text.encode()
    except OSError:
        is_same = False
    if not is_same:
        try:
            output.write_bytes(text.encode())
        except OSError as error:
            message = f"cannot be written: {error.strerror}"
            raise InputError(message, Location(str(output))) from error


def _output(options: argparse.Namespace, controller: Controller) -> Path:
    if options.output is not None and not options.write:
        raise InputError("--output says where --write writes; give both, or neither")
    if options.output is not None:
        return Path(options.output)
    return scenario_file(controller)


def scenario_file(controller: Controller) -> Path:
    """Return the file of a controller's scenario, where no other is named."""
    return controller.path.with_name(controller.path.stem + _ENDING)


def _drafted(
    options: argparse.Namespace, controller: Controller, settings: Any, base: Path | None
) -> tuple[ScenarioDraft, tuple[Missed, ...]]:
    from tracerisk.pipeline.scenarios.rounds import draft_scenario

    with progress_bar(quiet=options.quiet) as progress:
        draft = draft_scenario(
            controller, settings, base, progress=progress, own_s=options.search_limit_s
        )
    drafts = (*draft.given, *draft.missing)
    asked = tuple(
        missed
        for missed in asked_in_source(controller)
        if not any(_is_same(missed, other.need, other.location) for other in drafts)
    )
    return draft, asked


def _is_same(asked: Missed, need: Need, place: Location | None) -> bool:
    """Return whether what a source asks for is what a run has asked for, by name or place."""
    if asked.need.kind != need.kind:
        return False
    if not asked.need.name.startswith("("):
        return _plain(asked.need.name) == _plain(need.name)
    # A name that is put together: the call goes over a few lines at most.
    if place is None or asked.location is None or place.file != asked.location.file:
        return False
    return abs((place.line or 0) - (asked.location.line or 0)) <= _LINES


def _plain(name: str) -> str:
    """Return the last part of a name, by which what a source writes is known in a run."""
    return name.strip("/~' ").rpartition("/")[2]


def _print_draft(
    options: argparse.Namespace,
    output: Path,
    draft: ScenarioDraft,
    asked: tuple[Missed, ...],
    file_of: Callable[[str], str],
) -> None:
    """Print a draft; `file_of` names a file of the controller as a user would type it."""
    if draft.cut:
        note(f"tracerisk: {draft.cut}: this is the best scenario so far")
    rows = [(item.need.words, item.location, item.words) for item in draft.given]
    if draft.arguments is not None:
        text = f"arguments {' '.join(draft.arguments.words)}"
        rows.insert(0, (text, None, draft.arguments.remark))
    if rows:
        show("Asked for, and given by the scenario as assumed:")
    for text, place, words in rows:
        show(f"  {text}{_at(place, file_of)}: {words}")
    if draft.missing:
        show("Asked for, and given by no scenario:")
    for item in draft.missing:
        show(f"  {item.need.words}{_at(item.location, file_of)}: {item.words}")
    _print_asked(asked, "in the source beside, and had in the run or not reached", file_of)
    grasps = list(_grasps(draft, file_of))
    if grasps:
        show("Closed on nothing; an entry of `objects` each, with your own size and mass:", *grasps)
    if not rows and not draft.missing and not asked and not grasps:
        show("It asks its world for nothing.")
    if options.write:
        note(
            f"written: {output}; delete the mark `# assumed` of what is so in your cell, then "
            f"`tracerisk run {options.controller} --scenario {output}`",
            quiet=options.quiet,
        )
    elif draft.text and (rows or draft.missing or asked):
        note(f"--write would write:\n\n{draft.text}", quiet=options.quiet)
    if draft.trace is not None and draft.trace.verdict is not None and draft.trace.is_usable:
        note(f"with it: {draft.trace.verdict.kind}", quiet=options.quiet)


def _grasps(draft: ScenarioDraft, file_of: Callable[[str], str]) -> Iterator[str]:
    """Yield where a gripper closed for want of things, with an object that stands there."""
    for finding in () if draft.trace is None else draft.trace.findings:
        place = _PLACE.search(finding.message)
        if finding.kind != NOTHING_TO_GRASP or place is None:
            continue
        x, y, z = map(float, place.groups())
        yield f"  {finding.object}{_at(finding.location, file_of)}: {place[0]}"
        if z > 0.0:
            # It stands on the floor, and its top is a little above the middle between the pads.
            height = z + _TOP_M
            width = grasp_width_m(draft.trace.findings, finding) if draft.trace else _WIDTH_M
            box, xyz = (
                f"[{width:.3g}, {width:.3g}, {height:.3f}]",
                f"[{x:.3f}, {y:.3f}, {height / 2:.4g}]",
            )
            yield f"    - {{name: part, box: {box}, xyz: {xyz}, mass: 0.1}}  # assumed: its size"
        else:
            yield "    below the floor: the poses may be of another point than in your cell"


def grasp_width_m(findings: Sequence[Finding], grasp: Finding) -> float:
    """Return a width that a grasp on nothing would take: what its goal allows, if that is said."""
    allowed = (
        _ALLOWED.search(finding.message)
        for finding in findings
        if finding.location == grasp.location
    )
    least, most = next((map(float, found.groups()) for found in allowed if found), (0.0, 0.0))
    return (least + most) / 2 or _WIDTH_M


def _print_asked(asked: tuple[Missed, ...], where: str, file_of: Callable[[str], str]) -> None:
    if asked:
        show(f"Asked for {where}:")
    for missed in asked:
        show(f"  {missed.need.words}{_at(missed.location, file_of)}")


def _at(place: Location | None, file_of: Callable[[str], str]) -> str:
    return "" if place is None else f", {file_of(place.file)}:{place.line}"


def _print_json(
    options: argparse.Namespace,
    output: Path,
    draft: ScenarioDraft,
    asked: tuple[Missed, ...],
    code: int,
) -> None:
    def drafted(each: Any) -> dict[str, Any]:
        return {**_data(each.need, each.location), "value": each.value, "words": each.words}

    trace = draft.trace
    end = None if trace is None else {"cause": trace.end.cause, "message": trace.end.message}
    verdict = None if trace is None else trace.verdict
    print_json(
        "scenario",
        exit_code=code,
        **verdict_json(verdict),
        error=None if draft.error is None else draft.error.message,
        end=end,
        robot=None if trace is None else trace.robot,
        arguments=None if draft.arguments is None else list(draft.arguments.words),
        given=[drafted(each) for each in draft.given],
        missing=[drafted(each) for each in draft.missing],
        cut=draft.cut or None,
        source=[_data(each.need, each.location) for each in asked],
        written=str(output) if options.write else None,
        scenario=draft.text,
    )


def _data(need: Need, place: Location | None) -> dict[str, Any]:
    file, line = (None, None) if place is None else (place.file, place.line)
    return {**picked(need, "kind", "name"), "type": need.type_name, "file": file, "line": line}
