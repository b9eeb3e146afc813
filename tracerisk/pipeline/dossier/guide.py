"""The guide within a dossier: what is in it, and the commands that check its figure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from tracerisk.prm.hybrid.function_fault_tree import in_one_visit
from tracerisk.report.explain.words import number

if TYPE_CHECKING:
    from tracerisk.common.record import Record
    from tracerisk.prm.hybrid.mission_tree import MissionTree
    from tracerisk.report.html.report_input import ReportInput

TESTED_SCRAM = "0.16.2"
"""The version of SCRAM that tests solve dossiers with."""

_CONTENTS = (
    ("report.html", "the report, with its replay where the run was recorded"),
    ("record.json", "versions, commit, digests, robot, assumptions, verdict and outcome"),
    ("calculation.md", "every figure from the failure rate to the mission, with its steps"),
    ("assumptions.md", "what must hold, what stood out, and what was set by hand"),
    ("trace.json", "the run: visits, exposures, findings, verdict"),
    ("model/functions.xml", "Open-PSA: the fault tree of one visit of each function"),
    ("model/mission.xml", "Open-PSA: the mission as executed, as one fault tree"),
    ("model/model.json", "the whole model: the chain of functions and their fault trees"),
    ("files/", "sources with their risk blocks, lock, hardware description, other inputs"),
    ("SHA256SUMS", "the SHA-256 digest of each file"),
)


def guide(report: ReportInput, mission: MissionTree | None, names: Sequence[str]) -> str:
    """Return the guide as Markdown; `names` are the files of the dossier."""
    assert report.record is not None, "a dossier is of a report with its record"
    figures = report.assessment.mission
    rows = [
        f"| `{name}` | {what} |"
        for name, what in _CONTENTS
        if name in names or (name.endswith("/") and any(item.startswith(name) for item in names))
    ]
    verdict = report.verdict[0] if report.verdict else "not known"
    parts = [
        f"# Dossier of {report.model.name}\n",
        f"{report.assessment.statement}\n",
        "| | |",
        "|---|---|",
        f"| figure | {number(figures.failure_probability)} a mission ({figures.reading}) |",
        f"| verdict of the run | {verdict} |",
        f"| tracerisk | {report.record.version} |",
        f"| commit | {_commit(report.record)} |\n",
        "## What is in it\n",
        "\n".join(("| file | contents |", "|---|---|", *rows, "")),
        "## Check that nothing was changed\n",
        "```sh\nsha256sum --check SHA256SUMS\n```\n",
        _scram(report, mission),
        "## Recompute it by hand\n",
        "`calculation.md` goes from the rates of the hardware description to the mission. Its "
        "numbers have eight digits.\n",
        "## Make it again\n",
        _again(report.record),
    ]
    return "\n".join(parts)


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


def _again(record: Record) -> str:
    checkout = "" if record.commit is None else f"git checkout {record.commit.id}\n"
    source = next((file.path for file in record.files if file.role == "source"), "FILE")
    return (
        f"```sh\npip install 'tracerisk[sim]=={record.version}'\n{checkout}"
        f"tracerisk run {source}\ntracerisk report {source} --dossier dossier.zip\n```\n\n"
        "Give `run` again what `tracerisk.lock` has under `given`, if anything. The same files, "
        "commit, version and kind of processor give the same bytes.\n"
    )
