"""`tracerisk check`: whether blocks can be trusted as they stand; it never simulates."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from tracerisk.cli.shared import options as shared
from tracerisk.cli.shared.output import (
    note,
    note_unread_hardware,
    note_without_controllers,
    print_json,
    show,
)
from tracerisk.cli.shared.values import probability
from tracerisk.common.verdict import GAPS, verdict_line
from tracerisk.config import controller_root, from_here
from tracerisk.errors import ExitCode, TraceRiskError
from tracerisk.instrument.source.language import is_c
from tracerisk.pipeline.check.check import check_controllers
from tracerisk.pipeline.check.finding import Checked, finding_data
from tracerisk.pipeline.check.remedies import as_typed
from tracerisk.pipeline.check.run import ACCEPTED_BY, OF_VERDICT, CoverageLimits
from tracerisk.pipeline.freshness.known_controllers import all_controllers, controllers_of
from tracerisk.pipeline.workspace.project import Projects

if TYPE_CHECKING:
    import argparse

    from tracerisk.common.verdict import Verdict
    from tracerisk.pipeline.check.finding import CheckFinding


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument(
        "files",
        metavar="FILE",
        nargs="*",
        help="controller, or a file that one uses (default: all of the locks here and below)",
    )
    parser.add_argument(
        "--min-coverage",
        metavar="F",
        type=probability,
        help="exit 1 if less than this fraction of the functions that can command hardware ran",
    )
    parser.add_argument(
        "--base",
        metavar="REV",
        help="exit 1 if fewer of those functions ran than by the lock of this revision of git",
    )
    parser.add_argument(
        "--watch", action="store_true", help="check again whenever a file changes that it reads"
    )
    shared.add_ci_reports(parser)
    words = "print with each reason of a verdict the entry that accepts it"
    shared.add_json(parser, verbose=words)


def run(options: argparse.Namespace) -> int:
    """Run the verb and return its exit code."""
    projects = Projects()
    return _watch(options, projects) if options.watch else _check(options, projects)


def _watch(options: argparse.Namespace, projects: Projects) -> NoReturn:
    """Check again and again; ends by an interrupt."""
    from tracerisk.cli.shared.watching import Watch, watch
    from tracerisk.pipeline.freshness.watched_files import checked_files

    files = checked_files(_paths(options, projects), projects)

    def update(_: Watch) -> Iterable[Path]:
        _check(options, projects)
        return {*files, *checked_files(_paths(options, projects), projects)}

    watch(files, update, quiet=options.quiet)


def _paths(options: argparse.Namespace, projects: Projects) -> Sequence[Path]:
    """Return the controllers to check; raise InputError where none is known.

    Where no file is named, those are among them whose blocks no run wrote.
    """
    if options.files:
        return controllers_of(options.files, projects)
    return all_controllers(projects, with_unknown=True)


def _check(options: argparse.Namespace, projects: Projects) -> int:
    """Check the controllers, print what was found, and return the exit code."""
    paths = _paths(options, projects)
    if options.files:
        note_without_controllers(options, projects)
    limits = [CoverageLimits(options.min_coverage, base) for base in _bases(paths, options.base)]
    check_findings = check_controllers(paths, projects, limits)
    checked = [item for item in check_findings if isinstance(item, Checked)]
    errors = [item for item in check_findings if isinstance(item, TraceRiskError)]
    findings = [finding for check_finding in checked for finding in check_finding.findings]
    if any(given is not None for given in (options.sarif, options.code_quality, options.metrics)):
        from tracerisk.cli.authors.check_reports import write_reports

        write_reports(options, paths, check_findings, projects)
    code = max(
        (*(finding.exit_code for finding in findings), *(error.exit_code for error in errors)),
        default=ExitCode.FINE,
    )
    if errors:
        code = errors[0].exit_code
    if options.json:
        from tracerisk.cli.shared.verdict import verdict_json

        print_json(
            "check",
            exit_code=int(code),
            fresh=[
                str(check_finding.path) for check_finding in checked if not check_finding.findings
            ],
            findings=[finding_data(check_finding) for check_finding in findings],
            errors=[str(error) for error in errors],
            verdicts=[
                {
                    "controller": str(check_finding.path),
                    **verdict_json(check_finding.verdict),
                    "notes": list(check_finding.notes),
                }
                for check_finding in checked
            ],
        )
        return int(code)
    for check_finding in checked:
        if not options.quiet:
            show(f"{check_finding.path}: {_verdict_of(check_finding)}")
    for check_finding in checked:
        show(*_lines(check_finding, is_brief=not options.verbose))
    show(*(error.with_code for error in errors))
    for line in _notes(checked, is_brief=not options.verbose):
        note(line, quiet=options.quiet)
    note_unread_hardware(paths, projects, quiet=options.quiet)
    bad = len(errors) + sum(1 for check_finding in checked if check_finding.findings)
    count = f"{len(paths)} controller{'' if len(paths) == 1 else 's'}"
    note(f"{count} checked, {bad} to mend", quiet=options.quiet)
    return int(code)


def _bases(paths: Sequence[Path], revision: str | None) -> list[Verdict | None]:
    """Return the verdict that the lock of a revision keeps of each controller."""
    if revision is None:
        return [None] * len(paths)
    from tracerisk.pipeline.review.run_verdicts import base_verdicts

    return list(base_verdicts(list(paths), revision))


def _verdict_of(checked: Checked) -> str:
    """Return the verdict in words, and whether the run that it is of is not that of now."""
    verdict = _with_files(checked)
    is_stale = any(finding.kind == "stale" for finding in checked.findings)
    behind = " (of the run behind the blocks, which is stale)" if is_stale and verdict else ""
    return f"{verdict_line(verdict)}{behind}"


def _lines(checked: Checked, *, is_brief: bool) -> Iterator[str]:
    """Yield the findings of a controller, a line each.

    Of reasons that are all mended in one way, a brief list says once how.
    """
    kinds = OF_VERDICT.values()
    of_verdict = [finding for finding in checked.findings if finding.kind in kinds]
    ways = Counter(_way(finding) for finding in of_verdict)
    for finding in checked.findings:
        is_shared = finding in of_verdict and ways[_way(finding)] > 1
        yield str(finding._replace(remedy="") if is_brief and is_shared else finding)
    entries = f"; `tracerisk check -v {as_typed(checked.path)}` prints what accepts each"
    for (way, is_acceptable), count in ways.items() if is_brief else ():
        if count > 1:
            yield f"{checked.path}: for each of these {count}: {way}{entries * is_acceptable}"


def _way(finding: CheckFinding) -> tuple[str, bool]:
    """Return how the reason behind a finding is mended, and whether an entry may accept it."""
    way, accepts, _ = finding.remedy.partition(ACCEPTED_BY)
    return way, bool(accepts)


def _with_files(checked: Checked) -> Verdict | None:
    """Return a verdict with files as a user would type them from here."""
    verdict = checked.verdict
    if verdict is None or not verdict.reasons:
        return verdict
    return verdict.with_files(from_here(controller_root(checked.path)))


def _notes(checked: Sequence[Checked], *, is_brief: bool) -> Iterator[str]:
    """Yield what a user should know of verdicts that pass, and of what figures rest on."""
    for check_finding in checked:
        yield from (f"{check_finding.path}: {words}" for words in check_finding.notes)
        if is_c(check_finding.path.name):
            continue
        if check_finding.verdict is None and {"unknown", "gone", "stale"}.isdisjoint(
            f.kind for f in check_finding.findings
        ):
            yield (
                f"{check_finding.path}: its lock is of a tracerisk without verdicts; "
                f"`tracerisk refresh {check_finding.path}` gives it one"
            )
        elif (verdict := _with_files(check_finding)) is not None:
            for one in verdict.reasons:
                if one.accepted:
                    yield f"{check_finding.path}: accepted: {one}: {one.accepted}"
                elif one.code in GAPS and not is_brief:
                    accepts = f"in [tool.tracerisk] accept = [{one.accept_entry}]"
                    yield f"{check_finding.path}: passes, though {one.verdict}: {one}; {accepts}"
            for entry in verdict.unused_acceptances:
                yield f"{check_finding.path}: accepted, and did not occur; remove it: {entry}"
