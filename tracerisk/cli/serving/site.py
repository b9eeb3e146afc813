"""The pages about one repository: what each path shows, made of the files as they are now."""

from __future__ import annotations

import contextlib
import hashlib
import json
import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, quote, unquote

from tracerisk.adder.lock.lock import LOCK_NAME
from tracerisk.cli.reporting.overview import is_report, overview_row, reports_in
from tracerisk.cli.reporting.report_input import evidence_shown, report_input, run_shown
from tracerisk.cli.serving.model_changes import Answer, Choices, answer, choices_of, read_change
from tracerisk.cli.serving.sections import links_section, live_section, what_if_section
from tracerisk.cli.shared.verdict import verdict_lines
from tracerisk.cli.shared.watching import State, state_of
from tracerisk.common.evidence import EVIDENCE_NAME
from tracerisk.common.hardware.formats import load_hardware
from tracerisk.common.hardware.model import Hardware
from tracerisk.common.text.bounded import file_bytes
from tracerisk.errors import InputError, Location, TraceRiskError
from tracerisk.pipeline.check.cached_run import KeptRun, kept_run
from tracerisk.pipeline.freshness.known_controllers import lock_folders
from tracerisk.pipeline.pictures.run_section import kept_replay
from tracerisk.pipeline.review.history import history
from tracerisk.pipeline.review.overview import KnownController, overview
from tracerisk.report.html.model.components import importance_section
from tracerisk.report.html.model.functions import functions_section
from tracerisk.report.html.notes import assumptions_section, findings_section
from tracerisk.report.html.page import page, policy_of, rendered
from tracerisk.report.html.report import render_report
from tracerisk.report.html.report_input import ReportInput
from tracerisk.report.html.repository.history import history_section
from tracerisk.report.html.repository.overview import overview_lead, overview_section, report_links
from tracerisk.report.html.section import Section
from tracerisk.report.html.summary import lead

HTML, JSON = "text/html; charset=utf-8", "application/json"
_MOST_BYTES = 64 * 1024**2
_FILE_POLICY = (
    "sandbox allow-scripts; default-src 'none'; script-src 'unsafe-inline'; "
    "style-src 'unsafe-inline'; img-src data:"
)
"""Of a file in the repository: it can ask this server for nothing, whoever wrote it."""


@dataclass(frozen=True, slots=True)
class Reply:
    """A response to a request."""

    status: int
    """The HTTP status code."""
    kind: str
    """The value of its `Content-Type`."""
    body: bytes
    """The content."""
    policy: str = "default-src 'none'"
    """The value of its `Content-Security-Policy`."""


class Site:
    """The current folder as pages; each question is answered by the files as they are then."""

    def __init__(self) -> None:
        self._root = Path.cwd()
        # What follows is read and recomputed by one request at a time.
        self._one_at_a_time = threading.Lock()
        self._seen: State = {}
        self._known: tuple[KnownController, ...] = ()
        self._folders: set[Path] = set()
        self._error: TraceRiskError | None = None
        # By controller, for what is asked at each move of a slider; until a file changes.
        self._choices: dict[str, Choices] = {}

    def reply(self, path: str, query: str) -> Reply:
        """Return the answer to a path of a URL and its query; it writes nothing."""
        kind, _, name = unquote(path).removeprefix("/").partition("/")
        asked: Mapping[str, Callable[[str, str], Reply]] = {
            "": self._overview,
            "controller": self._controller,
            "report": self._report,
            "history": self._history,
            "what-if": self._what_if,
            "state": self._state,
            "files": self._file,
        }
        if kind not in asked or (kind in ("", "state")) != (not name):
            return _page(
                "There is no such page", "The links of this page lead to all there are.", 404
            )
        try:
            if kind == "what-if":
                return self._what_if(name, query)
            with self._one_at_a_time:
                return asked[kind](name, query)
        except _UnknownNameError as error:
            return _page("There is no such controller", error.message, 404)
        except TraceRiskError as error:
            if kind == "what-if":
                return _json({"error": error.message}, 400)
            return _page("This cannot be shown now", str(error), 422)

    def _overview(self, _: str, __: str) -> Reply:
        if set(lock_folders(Path())) != self._folders:
            self._seen = {}
        known = self._read()
        reports = reports_in(Path(), known)
        links = report_links([known_controller.name for known_controller in known], reports)
        rows = [
            overview_row(
                known_controller,
                link=f"/controller/{quote(known_controller.name)}",
                report=f"/files/{quote(links[known_controller.name])}"
                if known_controller.name in links
                else "",
            )
            for known_controller in known
        ]
        title = self._root.name
        return _shown(f"Risk of {title}", overview_lead(title, rows), [overview_section(rows)])

    def _controller(self, name: str, _: str) -> Reply:
        known = self._named(name)
        if known.model is None or known.assessment is None:
            return _page(known.name, known.error, 422)
        kept = _kept(known)
        choices = self._choices[name] = choices_of(known, _hardware(kept))
        report = ReportInput(
            assessment=known.assessment,
            model=known.model,
            verdicts={known.name: known.verdict},
            verdict=_verdict_lines(known),
        )
        evidence: tuple[Section, ...] = ()
        if kept is not None:
            evidence = evidence_shown(kept.controller, kept.settings, kept.fingerprint)
        sections = [
            links_section(known.name, f"/report/{quote(name)}", f"/history/{quote(name)}"),
            what_if_section(choices, f"/what-if/{quote(name)}"),
            functions_section(report),
            importance_section(report),
            *evidence,
            findings_section(report),
            assumptions_section(report),
        ]
        return _shown(f"Risk of {known.name}", lead(report), sections)

    def _report(self, name: str, _: str) -> Reply:
        known = self._named(name)
        if known.model is None or known.assessment is None:
            return _page(known.name, known.error, 422)
        kept = _kept(known)
        if kept is None:
            run: Any = "No run is known of these sources."
        elif kept.trace is None:
            run = f"{kept.reason} `tracerisk refresh FILE` brings it up to date."
        else:
            run = run_shown(kept.trace, kept.settings, kept, kept_replay(kept))
        shown = report_input(
            known.assessment,
            known.model,
            known.sources,
            run=run,
            verdicts={known.name: known.verdict},
            verdict=_verdict_lines(known),
            more=(live_section(),),
        )
        return _html(render_report(shown))

    def _history(self, name: str, _: str) -> Reply:
        known = self._named(name)
        html = rendered("heading.html.j2", name=known.name, sentence=f"How {known.name} went")
        return _shown(
            f"History of {known.name}", html, [history_section(known.name, history(known.path))]
        )

    def _what_if(self, name: str, query: str) -> Reply:
        with self._one_at_a_time:
            known = self._named(name)
            choices = self._choices.get(name) or choices_of(known, _hardware(_kept(known)))
            self._choices[name] = choices
        # The rest touches nothing that others do: no page waits until it is solved.
        change = read_change(_values(query), choices)
        files = " ".join(known.sources)
        return _json(_answer_data(answer(known, choices, change, files)))

    def _state(self, _: str, __: str) -> Reply:
        with contextlib.suppress(TraceRiskError):
            self._read()
        seen = sorted((str(path), repr(look)) for path, look in self._seen.items())
        return _json({"state": hashlib.sha256(json.dumps(seen).encode()).hexdigest()})

    def _file(self, name: str, _: str) -> Reply:
        """Return a report that stands in the repository, and no other file."""
        parts = name.split("/")
        refused = _page(
            "There is no such report", "Reports of this repository are shown, no other file.", 404
        )
        if "\0" in name or any(part.startswith(".") or not part for part in parts):
            return refused
        path = (self._root / name).resolve()
        if not path.is_relative_to(self._root) or path.suffix != ".html" or not is_report(path):
            return refused
        if path.stat().st_size > _MOST_BYTES:
            raise InputError(f"is larger than {_MOST_BYTES} bytes", Location(name))
        return Reply(200, HTML, file_bytes(path, _MOST_BYTES), _FILE_POLICY)

    def _read(self) -> tuple[KnownController, ...]:
        """Return what is known of the controllers, read anew where a file has changed."""
        if not self._seen or state_of(tuple(self._seen)) != self._seen:
            self._folders = set(lock_folders(Path()))
            folders = sorted(self._folders) or [Path()]
            before = state_of(tuple(self._files(folders, self._known)))
            self._error = None
            self._choices.clear()
            try:
                self._known = overview(Path())
            except TraceRiskError as error:
                self._error = error
            # What changed while it was read differs from what was seen before, and is read again.
            files = self._files(folders, self._known)
            self._seen = {**state_of(tuple(files)), **before}
        if self._error is not None:
            raise self._error
        return self._known

    def _files(self, folders: Sequence[Path], known: Sequence[KnownController]) -> list[Path]:
        names = (LOCK_NAME, "pyproject.toml", EVIDENCE_NAME)
        paths = [folder / name for folder in folders for name in names]
        paths += [Path(".git", "logs", "HEAD")]
        for known_controller in known:
            paths += [known_controller.path, *map(Path, known_controller.sources)]
        return list(dict.fromkeys(paths))

    def _named(self, name: str) -> KnownController:
        known = {known_controller.name: known_controller for known_controller in self._read()}
        if name not in known:
            raise _UnknownNameError("No lock of this repository knows it.")
        return known[name]


class _UnknownNameError(InputError):
    """A name that no lock knows."""


def refused(status: int, title: str, words: str) -> Reply:
    """Return the page that says why a request is not answered."""
    return _page(title, words, status)


def _kept(known: KnownController) -> KeptRun | None:
    try:
        return kept_run(known.path)
    except TraceRiskError:
        # Whoever reads its blocks reports what is wrong; a C file has no cached run.
        return None


def _hardware(kept: KeptRun | None) -> Hardware | None:
    if kept is None or kept.trace is None:
        return None
    try:
        return load_hardware(kept.settings, kept.trace.robot)
    except TraceRiskError:
        return None


def _verdict_lines(known: KnownController) -> tuple[str, ...]:
    return tuple(verdict_lines(known.verdict))


def _values(query: str) -> dict[str, list[str]]:
    try:
        return parse_qs(
            query, keep_blank_values=True, strict_parsing=bool(query), max_num_fields=200
        )
    except ValueError as error:
        raise InputError(f"the query cannot be read: {error}") from error


def _answer_data(found: Answer) -> dict[str, Any]:
    before, after = found.before.mission, found.after.mission
    ratio = None
    if before.failure_probability:
        ratio = after.failure_probability / before.failure_probability
    return {
        "assumptions": list(found.assumptions),
        "command": found.command,
        "components": [
            {"name": component.name, "share": component.fussell_vesely}
            for component in found.after.components
        ],
        "before": before.failure_probability,
        "after": after.failure_probability,
        "ratio": ratio,
        "functions": [
            {"name": state.name, "ends": state.absorption_probability}
            for state in found.after.states
        ],
    }


def _shown(title: str, head: Any, sections: Sequence[Section]) -> Reply:
    return _html(page(title, head, [*sections, live_section()], connects=True))


def _html(text: str, status: int = 200) -> Reply:
    policy = f"{policy_of(text)}; frame-ancestors 'none'"
    return Reply(status, HTML, text.encode("utf-8"), policy)


def _page(title: str, words: str, status: int) -> Reply:
    html = rendered("heading.html.j2", name="", sentence=title)
    body = rendered("list.html.j2", lines=(), lead="", empty=words)
    text = page(title, html, [Section("reason", "Why", body), live_section()], connects=True)
    return _html(text, status)


def _json(value: Any, status: int = 200) -> Reply:
    return Reply(status, JSON, json.dumps(value, sort_keys=True).encode("ascii"))
