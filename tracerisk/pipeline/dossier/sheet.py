"""The sheet of a dossier: the steps before one relies on its figure, to be filled in and signed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tracerisk.pipeline.dossier.guide import by_hand_words, warning_of
from tracerisk.report.explain.words import number

if TYPE_CHECKING:
    from tracerisk.report.html.report_input import ReportInput

STEPS = (
    "`tracerisk check FILE` ends with `0 to mend`.",
    "Take the five minutes for the report: verdict, replay, hardware data, what drives the figure, "
    "one number by hand, and the author's answers.",
    "Accept reasons of the verdict one by one, with words.",
    "Ask of each rate how old it is and from which use, of each redundant group how it is tested, "
    "and of each beta where it comes from.",
    "Retrace the largest contribution by hand: `calculation.md` of the dossier, or `--explain`.",
    "Solve the exported model with a second tool: the dossier has the commands for SCRAM.",
    'Obtain evidence for what "needed" means if a contribution is decisive, and declare the '
    "mission under `success:`.",
    "Compare exposures with a recording of the real robot.",
    "In CI, use `check`, `diff --max-increase`, `--no-new-accepts`, "
    "`overrides --max-drift`, and require the sandbox if code of strangers runs.",
    "Read the known anomalies.",
    "State error factors in the hardware description: the figure then shows the band in which it "
    "lies.",
    "Repeat all of this for each different robot, gripper, payload and speed, and keep the dossier "
    "of each.",
)
"""The steps of docs/safety.md, without its links."""


def sheet(report: ReportInput) -> str:
    """Return the sheet as Markdown."""
    figures = report.assessment.mission
    rows = (f"| {index} | {step} | | | |" for index, step in enumerate(STEPS, start=1))
    record = report.record
    by_hand = by_hand_words(report)
    by_hand = f" It rests on values set by hand: {by_hand}." if by_hand else ""
    commit = "" if record is None or record.commit is None else f" at commit {record.commit.id}"
    return "\n".join(
        (
            f"# Before you rely on the figure of {report.model.name}",
            "",
            *warning_of(report),
            f"{number(figures.failure_probability)} a mission ({figures.reading}){commit}."
            f'{by_hand} "Before you rely on it" in the safety manual (`tracerisk docs safety`) '
            "says what each "
            "step needs, and what follows if it is not done. This is a copy to fill in: of a "
            "dossier whose digests are to hold, keep the filled one beside the archive.",
            "",
            "| no. | step | done or why not | result, and where it is kept | by, on |",
            "|---|---|---|---|---|",
            *rows,
            "",
            "| SHA-256 of the archive | used for | not to be used for | name, date, signature |",
            "|---|---|---|---|",
            "| | | | |",
            "",
        )
    )
