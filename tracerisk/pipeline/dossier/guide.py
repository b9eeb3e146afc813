"""The guide within a dossier: what is in it, and the commands that check its figure."""

from __future__ import annotations

import math
import shlex
from collections.abc import Collection, Iterator, Sequence
from pathlib import PurePosixPath
from typing import TYPE_CHECKING

from tracerisk.adder.quantify.component_activity import mission_duration_s, visits_by_function
from tracerisk.common.verdict import BAD, VERDICTS, VerdictKind
from tracerisk.pipeline.freshness.run_inputs import UNSET
from tracerisk.prm.hybrid.function_fault_tree import in_one_visit
from tracerisk.report.explain.words import number
from tracerisk.report.tables import counted

if TYPE_CHECKING:
    from tracerisk.common.record import Record
    from tracerisk.pipeline.dossier.environment import Environment
    from tracerisk.prm.hybrid.mission_tree import MissionTree
    from tracerisk.report.html.report_input import ReportInput
    from tracerisk.trace import Trace

TESTED_SCRAM = "0.16.2"
"""The version of SCRAM that tests solve dossiers with."""

CONSTRAINTS = "constraints.txt"
"""The name of the file with the versions of the packages."""
FILES = "files"
"""The folder of the files that the figure was made from."""
_OUTSIDE = "outside"  # in place of `..` and the top of the file system

_CONTENTS = (
    ("report.html", "the report, with its replay where the run was recorded"),
    ("record.json", "versions, commit, digests, robot, assumptions, verdict and outcome"),
    ("calculation.md", "every figure from the failure rate to the mission, with its steps"),
    ("assumptions.md", "what must hold, what stood out, what was set by hand or accepted"),
    ("sheet.md", "the steps before you rely on the figure, to fill in and sign"),
    ("trace.json", "the run: visits, exposures, findings, verdict"),
    ("model/functions.xml", "Open-PSA: the fault tree of one visit of each function"),
    ("model/mission.xml", "Open-PSA: the mission as executed, as one fault tree"),
    ("model/model.json", "the whole model: the chain of functions and their fault trees"),
    (CONSTRAINTS, "the versions of the packages that it was made with, for pip"),
    ("files/", "sources with their risk blocks, lock, hardware description, other inputs"),
    ("SHA256SUMS", "the SHA-256 digest of each file"),
)
_CUT = "mission: "  # what an assumption begins with that says how long the mission is
_UNSEEN = 0.01  # of a mission: no visit lasts exactly as long
_FOUR_DIGITS = (
    "The blocks hold probabilities of four digits, and the mission is computed from these. More "
    "digits are printed only so that each step can be retraced: they are no precision."
)
_TO_AN_HOUR = (
    "the rate may stand for the figure only where missions follow each other without a break, each "
    "begins with all units working and lasts as long, rates are constant, and demands are as "
    'frequent: "From a mission to an hour" in the safety manual (`tracerisk docs safety`)'
)


def guide(
    report: ReportInput,
    mission: MissionTree | None,
    names: Sequence[str],
    environment: Environment,
) -> str:
    """Return the guide as Markdown; `names` are the files of the dossier."""
    assert report.record is not None, "a dossier is of a report with its record"
    rows = [
        f"| `{name}` | {what} |"
        for name, what in _CONTENTS
        if name in names or (name.endswith("/") and any(item.startswith(name) for item in names))
    ]
    parts = [
        f"# Dossier of {report.model.name}\n",
        *warning_of(report),
        f"{report.assessment.statement}\n",
        "| | |",
        "|---|---|",
        *(f"| {name} | {text} |" for name, text in _facts(report, environment)),
        "",
        f"{_FOUR_DIGITS}\n",
        "## What is in it\n",
        "\n".join(("| file | contents |", "|---|---|", *rows, "")),
        "## Check that nothing was damaged\n",
        "```sh\nsha256sum --check SHA256SUMS\n```\n",
        "Whoever changes a file can change `SHA256SUMS` too. The command that wrote the archive "
        "printed the SHA-256 digest of the archive itself: keep that elsewhere, or sign the "
        "archive.\n",
        _scram(report, mission),
        "## What was recomputed, and what was taken on trust\n",
        _trust(report),
        "## Recompute it by hand\n",
        "`calculation.md` goes from the rates of the hardware description to the mission. Its "
        "numbers have eight digits.\n",
        "## Make it again\n",
        _again(
            report.record,
            environment,
            "" if report.trace is None else report.trace.controller,
        ),
    ]
    return "\n".join(parts)


def _trust(report: ReportInput) -> str:
    """Return what the command that made the dossier found out itself, and what it could not."""
    assert report.record is not None, "a dossier is of a report with its record"
    has_run = report.trace is not None and report.hardware is not None
    of_no_run = ""
    if not report.record.fingerprint:
        of_no_run = "**on trust**: no lock says of which run they are"
    rows = [
        ("the figure", "recomputed from the risk blocks in `files/`"),
        (
            "the risk blocks",
            "recomputed from `trace.json` and the hardware description"
            if has_run
            else of_no_run
            or "**on trust**: the run behind them is not here; they were only compared with "
            "`tracerisk.lock`",
        ),
        (
            "sources, settings and other inputs",
            of_no_run
            or "compared with their digests in `tracerisk.lock`, which say which inputs the run "
            "had",
        ),
    ]
    if has_run:
        rows.append(
            (
                "the run, `trace.json`",
                of_no_run
                or "compared with `tracerisk.lock`: robot, scene, end, verdict, and by function "
                "visits, durations and times in use",
            )
        )
    if outside_visits_s(report):
        rows.append(("the duration of the mission T", _outside_words(report)))
    elif has_run and report.record.fingerprint:
        rows.append(
            (
                "the duration of the mission T",
                "compared with `tracerisk.lock`: no longer than the visits there last together",
            )
        )
    rows += [
        (
            "that the run is one of these inputs",
            "**on trust**: nothing is signed. Whoever changes blocks, lock and run together, and "
            "their digests, is not noticed here; the commands under *Make it again* run the "
            "sources and notice it",
        ),
        (
            "rates, pins and accepted reasons",
            "**on trust**: they are their authors' statements, listed in `assumptions.md`",
        ),
    ]
    lines = ("| what | how it was established |", "|---|---|")
    return "\n".join((*lines, *(f"| {what} | {how} |" for what, how in rows), ""))


def warning_of(report: ReportInput) -> list[str]:
    """Return what speaks against the use of the figure, as paragraphs of Markdown."""
    parts = []
    if not all(verdict is not None and not verdict.is_bad for verdict in report.verdicts.values()):
        parts += [
            "**Do not use the figures of this dossier**: the run did not carry out the mission, or "
            "nobody knows whether it did.\n",
            "".join(f"- {line}\n" for line in report.verdict),
        ]
    elif went_wrong := accepted_reasons(report, kinds=BAD):
        parts += [
            "**Do not use the figures of this dossier** unless each of these acceptances is right: "
            "the run went wrong, and words alone make it another verdict.\n",
            "".join(f"- {line}\n" for line in went_wrong),
        ]
    if report.unpassed:
        parts += [
            "**`tracerisk check FILE` does not pass here** (step 1 of `sheet.md`):\n",
            "".join(f"- {line}\n" for line in report.unpassed),
        ]
    return parts


def accepted_reasons(
    report: ReportInput, *, kinds: Collection[VerdictKind] = VERDICTS
) -> list[str]:
    """Return the accepted reasons that would make a verdict of these kinds, with their words."""
    return [
        f"{reason.verdict}: {reason}; accepted with the words: {reason.accepted}"
        for verdict in report.verdicts.values()
        for reason in (() if verdict is None else verdict.reasons)
        if reason.accepted and reason.verdict in kinds
    ]


def _facts(report: ReportInput, environment: Environment) -> Iterator[tuple[str, str]]:
    """Yield what stands at the head of the guide, as names and texts."""
    assert report.record is not None, "a dossier is of a report with its record"
    figures = report.assessment.mission
    risk = figures.failure_probability
    yield "figure", f"{number(risk)} a mission ({figures.reading})"
    if report.band:
        yield "band", report.band
    elif report.trace is not None:
        yield "band", "none: no figure behind it has an error factor"
    duration_s = None if report.trace is None else mission_duration_s(report.trace)
    if duration_s:
        outside = _outside_words(report)
        yield "duration of the mission T", f"{number(duration_s)} s{', ' * bool(outside)}{outside}"
        # What no visit shows would only make the rate smaller.
        duration_s -= outside_visits_s(report)
        other = other_visits(report)
        if other:
            yield "mean rate", f"none: {other}, so T is not the duration of the figure's mission"
        elif risk < 1.0:
            rate = -math.log1p(-risk) / (duration_s / 3600.0)
            visited = f" with the {number(duration_s)} s of the visits as T" if outside else ""
            text = f"{rate:.4g} per hour = -ln(1 - figure) / (T / 3600){visited}; {_TO_AN_HOUR}"
            yield "mean rate", text
    yield "verdict of the run", "; ".join(report.verdict) or "not known"
    if report.trace is not None:
        yield from _judged(report.trace)
    accepted = accepted_reasons(report)
    if accepted:
        yield "accepted", f"{counted(len(accepted), 'reason')}: `assumptions.md`"
    by_hand = by_hand_words(report)
    if by_hand:
        yield "set by hand", f"{by_hand}: `assumptions.md`"
    if report.no_trace:
        yield "run", f"not in this dossier: {report.no_trace}"
    if report.record.variables:
        named = (
            f"`{name}` ({'not set' if digest == UNSET else f'set, {digest[:12]}'})"
            for name, digest in report.record.variables.items()
        )
        listed = ", ".join(named)
        what = "the first digits of the SHA-256 digest of NAME=VALUE, without a line end"
        yield "environment variables", f"{listed}: {what}"
    origin = environment.installed_from
    yield "tracerisk", report.record.version + (f", installed from {origin}" if origin else "")
    yield "made with", environment.words
    yield "commit", _commit(report.record)


def _judged(trace: Trace) -> Iterator[tuple[str, str]]:
    """Yield how a run ended, and by what it was judged whether it carried out its mission."""
    cut = [text.removeprefix(_CUT) for text in trace.assumptions if text.startswith(_CUT)]
    yield "how the run ended", "; ".join((trace.end.message, *cut))
    met = [condition.words for condition in trace.success if condition.is_met]
    if trace.success:
        asked = f"{len(met)} of {counted(len(trace.success), 'condition')} of `success` met"
        yield "mission by `success`", f"{asked}: {', '.join(met)}"
    elif trace.verdict is not None:
        yield (
            "mission by `success`",
            "**nothing declares it**: the verdict says that no step went wrong, and not that the "
            "run brought about what the mission is for",
        )


def outside_visits_s(report: ReportInput) -> float:
    """Return how much longer the run lasted than its visits, which the lock has, together [s].

    None where no run is known, and where the difference is small.
    """
    trace = report.trace
    length_s = None if trace is None or trace.cycle is not None else trace.end.simulated_s
    if trace is None or length_s is None:
        return 0.0
    rest_s = length_s - math.fsum(visit.duration_s or 0.0 for visit in trace.visits)
    return rest_s if rest_s > _UNSEEN * length_s else 0.0


def _outside_words(report: ReportInput) -> str:
    rest_s = outside_visits_s(report)
    if not rest_s:
        return ""
    return (
        f"**on trust** for {number(rest_s)} s of it: so much longer is the run than all visits in "
        "`tracerisk.lock` together"
    )


def other_visits(report: ReportInput) -> str:
    """Return a function that the figure's mission visits more or less often than the run, in words.

    `next` set by hand makes another mission of the same run. A failure may cut a
    mission short, so as much is no difference.
    """
    if report.trace is None:
        return ""
    counts = {
        str(ref.name): visits.total for ref, visits in visits_by_function(report.trace).items()
    }
    most = _UNSEEN + report.assessment.mission.failure_probability
    for function in report.assessment.states:
        run, expected = counts.get(function.name), function.expected_visits
        if run is not None and abs(expected - run) > most * run:
            return (
                f"the figure is of a mission that visits {function.name} {number(expected)} times, "
                f"and the run visited it {counted(run, 'time')}"
            )
    return ""


def by_hand_words(report: ReportInput) -> str:
    """Return how many values users set in the blocks; empty where all are computed."""
    if not report.pins:
        return ""
    bare = sum(not pin.reason for pin in report.pins)
    return f"{counted(len(report.pins), 'value')}, {bare or 'none'} without a reason"


def _commit(record: Record) -> str:
    if record.commit is None:
        return f"none: {record.no_commit}"
    words = f"{record.commit.id}, committed {record.commit.committed}"
    if record.commit.changed:
        words += f", with changes in {', '.join(record.commit.changed)}"
    return words


def _scram(report: ReportInput, mission: MissionTree | None) -> str:
    """Return how SCRAM solves the models, and what it must print."""
    functions = [
        f"| {state.name} | {_top(first.tree.probability(first.probabilities).p)} |"
        for state in report.model.states
        if state.tree.events
        for first in (in_one_visit(state),)
    ]
    parts = [
        "## Solve the models with SCRAM\n",
        f"SCRAM ({TESTED_SCRAM} was tried; `apt-get install scram`) is a risk engine of other "
        "authors. It prints six digits.\n",
        "```sh\nscram --probability 1 model/functions.xml | grep -o "
        '\'sum-of-products name=[^>]* probability="[^"]*"\'\n```\n',
        "\n".join(
            ("| function | fails in one visit |", "|---|---|", *functions, ""),
        ),
    ]
    if mission is None:
        parts.append("The mission is no static fault tree: see `calculation.md`, part 3.\n")
        return "\n".join(parts)
    parts += [
        "```sh\nscram --probability 1 model/mission.xml | grep -o "
        '\'sum-of-products name=[^>]* probability="[^"]*"\'\n```\n',
        f"It must print {_top(mission.probability)}: the mission as executed. The report gives "
        f"{number(report.assessment.mission.failure_probability)} "
        f"({report.assessment.mission.reading}); `calculation.md` says where a difference comes "
        "from.\n",
    ]
    return "\n".join(parts)


def _top(value: float) -> str:
    return f"{value:.6g}"


def _again(record: Record, environment: Environment, controller: str) -> str:
    """Return the commands that give the figure again, files that the commit lacks included.

    `controller` is the path of the one that ran; empty where that is not known.
    """
    wanted, why = environment.wanted(record.version)
    lines = [f"pip install --constraint DOSSIER/{CONSTRAINTS} '{wanted}'"]
    if record.commit is not None:
        lines.append(f"git checkout {record.commit.id}")
    copied = [file for file in record.files if file.state not in ("as committed", "with tracerisk")]
    for file in copied:
        folder = PurePosixPath(file.path).parent
        lines += [f"mkdir -p {shlex.quote(str(folder))}"] if str(folder) != "." else []
        packed = shlex.quote(f"DOSSIER/{packed_name(file.path)}")
        lines.append(f"cp {packed} {shlex.quote(file.path)}")
    sources = [file.path for file in record.files if file.role == "source"]
    source = shlex.quote(controller if controller in sources else next(iter(sources), "FILE"))
    lines += [f"tracerisk run {source}", f"tracerisk report {source} --dossier dossier.zip"]
    commands = "\n".join(lines)
    if copied:
        why += "What the commit lacks or has otherwise: these files are copied from here first. "
    if record.variables:
        names = ", ".join(f"`{name}`" for name in record.variables)
        why += f"Set the environment variables {names} as they were: see the digests above. "
    return (
        "In the folder of the controller's project, with `DOSSIER` for the folder of this file:\n\n"
        f"```sh\n{commands}\n```\n\n{why}Give `run` again what `tracerisk.lock` has under "
        "`given`, if anything. The same files, commit, versions and kind of processor give the "
        "same bytes.\n"
    )


def packed_name(path: str) -> str:
    """Return the name in the archive of a file, which stays within the archive's folder."""
    parts = PurePosixPath(path).parts
    return "/".join((FILES, *(_OUTSIDE if part in ("..", "/") else part for part in parts)))
