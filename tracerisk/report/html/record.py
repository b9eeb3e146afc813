"""The record: what the figure was made from, to read and as data."""

from __future__ import annotations

from typing import Any

from tracerisk.common.record import Commit, Record, record_data
from tracerisk.report.html import figures
from tracerisk.report.html.page import rendered
from tracerisk.report.html.report_input import ReportInput
from tracerisk.report.html.section import Data, Section
from tracerisk.report.html.tables import Cell, Table, row_of, texts

RECORD = "record-data"
"""The id of the data within the page."""
_MOST_NAMED = 10  # files of the tree that differ from the commit


def record_section(report: ReportInput) -> Section | None:
    """Return what the figure was made from; `None` where nobody gathered it."""
    record = report.record
    if record is None:
        return None
    rows = tuple(
        row_of(file.role, file.path, Cell(file.sha256), file.state or figures.NOTHING)
        for file in record.files
    )
    columns = texts("role", "file", "SHA-256", "in git")
    table = Table("record-files", "Files that the figure was made from", columns, rows)
    html = rendered("record.html.j2", facts=_facts(record), table=table)
    return Section("record", "Record", html, data=(Data.of_json(RECORD, report_record(report)),))


def report_record(report: ReportInput) -> dict[str, Any]:
    """Return the record of a report as JSON has it, with what the report says in short."""
    assert report.record is not None, "it was gathered"
    assessment = report.assessment
    return {
        **record_data(report.record),
        "model": report.model.name,
        "failure_probability": assessment.mission.failure_probability,
        "band": report.band or None,
        "reading": assessment.mission.reading,
        "statement": assessment.statement,
        "verdict": list(report.verdict),
        "no_run": report.no_trace or None,
        "assumptions": [*report.assumptions, *assessment.assumptions],
    }


def _facts(record: Record) -> tuple[tuple[str, str], ...]:
    """Return what the record says beside its files, as names and texts."""
    robot = record.robot
    return (
        ("tracerisk", record.version),
        *(_commit_facts(record.commit) or (("commit", f"none: {record.no_commit}"),)),
        ("run", f"its inputs have the digest {record.fingerprint}" if record.fingerprint else ""),
        (
            "robot",
            "" if robot is None else "; ".join((f"{robot.name}, {robot.kind}", *robot.reasons)),
        ),
    )


def _commit_facts(commit: Commit | None) -> tuple[tuple[str, str], ...]:
    if commit is None:
        return ()
    tree = "no tracked file differs from the commit"
    if commit.changed:
        named = ", ".join(commit.changed[:_MOST_NAMED])
        more = len(commit.changed) - _MOST_NAMED
        tree = f"differs from the commit in {named}{f' and {more} more' if more > 0 else ''}"
    return ("commit", f"{commit.id}, committed {commit.committed}"), ("working tree", tree)
