"""What an editor has open: its texts by version, and what is known of them.

Each version is read once. Where one is half typed, what the last whole one held stays, at the
lines that it has now.
"""

from __future__ import annotations

import io
import sys
import tokenize
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from urllib.parse import unquote, urlsplit

from tracerisk.adder.lock.lock import lock_key
from tracerisk.common.evidence.advice import Advice, advice_of
from tracerisk.common.text.bounded import file_bytes
from tracerisk.common.verdict import Verdict
from tracerisk.editor.figures import ControllerFigures, figures_of
from tracerisk.editor.lines import Lines
from tracerisk.editor.outline import Outline, outline_of
from tracerisk.errors import TraceRiskError
from tracerisk.instrument.source.language import is_c
from tracerisk.pipeline.check.check import check_controller, check_loaded
from tracerisk.pipeline.check.finding import CheckFinding
from tracerisk.pipeline.freshness.known_controllers import controllers_of, is_gone
from tracerisk.pipeline.freshness.used_evidence import evidence_of_last_run
from tracerisk.pipeline.workspace.controller import Controller, load_controller
from tracerisk.pipeline.workspace.project import Projects

_MARK = b"\xef\xbb\xbf"
_SAVED_AS = ("utf-8", "latin-1", "cp1252")


@dataclass(frozen=True, slots=True, eq=False)
class Document:
    """One version of a text that is open, with the bytes that saving it would write."""

    uri: str
    """The URI by which the editor names it."""
    path: Path | None
    """`None` where the text is no file."""
    version: int | None
    """The editor's number of the version; `None` where it gives none."""
    text: str
    """The text of this version."""
    lines: Lines
    """The text by lines, with the columns of the editor's encoding."""
    source: bytes
    """The bytes that saving it would write."""

    @property
    def is_source(self) -> bool:
        """Whether it may hold risk blocks: a source by its ending, or by what it holds."""
        if self.path is None:
            return False
        is_named = self.path.suffix in (".py", ".pyw") or is_c(self.path.name)
        return is_named or (not self.path.suffix and self.source[:64].startswith(b"#!"))


@dataclass(frozen=True, slots=True)
class Analysis:
    """The result of a check of a controller with its unsaved texts."""

    path: Path
    """The script of the controller."""
    findings: tuple[CheckFinding, ...] = ()
    """The findings of the check."""
    error: TraceRiskError | None = None
    """Why the check could not be made; `None` where it was."""
    verdict: Verdict | None = None
    """The verdict of the last run; `None` where none is kept."""
    advice: tuple[Advice, ...] = ()
    """The places where a check would show failures that evidence found undetected."""


class Session:
    """The texts that are open, and the controllers that they belong to."""

    def __init__(self) -> None:
        self.documents: dict[str, Document] = {}
        self.encoding = "utf-16"
        """The encoding of the editor's columns."""
        self._whole: dict[str, tuple[bytes, Outline]] = {}
        self._controllers: dict[str, tuple[Path, ...]] = {}
        self.analyses: dict[Path, Analysis] = {}
        self.projects = Projects()

    def put(self, uri: str, version: int | None, text: str) -> Document:
        """Take a version of a text, and return it."""
        path = path_of(uri)
        document = Document(
            uri,
            path,
            version,
            text,
            Lines(text, self.encoding),
            _encoded(text, path),
        )
        self.documents[uri] = document
        return document

    def close(self, uri: str) -> None:
        """Forget a text that is no longer open."""
        for kept in (self.documents, self._whole, self._controllers):
            kept.pop(uri, None)

    @property
    def opened(self) -> Mapping[Path, bytes]:
        """The bytes of each file that is open."""
        return {
            document.path.resolve(): document.source
            for document in self.documents.values()
            if document.path is not None
        }

    def unsaved(self) -> list[Document]:
        """Return the sources that are open and hold something else on disk."""
        return [
            document
            for document in self.documents.values()
            if document.is_source and not _is_saved(document)
        ]

    def uri_of(self, path: Path) -> str:
        """Return by which name the editor knows a file."""
        here = path.resolve()
        for document in self.documents.values():
            if document.path is not None and document.path.resolve() == here:
                return document.uri
        return here.as_uri()

    def lines_of(self, path: Path) -> Lines:
        """Return the lines of a file, as the editor has them; one that is gone has none."""
        document = self.documents.get(self.uri_of(path))
        if document is not None:
            return document.lines
        try:
            text = file_bytes(path).decode("utf-8", "replace")
        except OSError:
            text = ""
        return Lines(text, self.encoding)

    def outline(self, document: Document) -> Outline:
        """Return the outline of a document: of one half typed what can be read of it."""
        result = outline_of(document.source, str(document.path))
        if result.is_code_read:
            self._whole[document.uri] = (document.source, result)
            return result
        whole = self._whole.get(document.uri)
        if whole is None:
            return result
        return whole[1].at_lines_of(whole[0], document.source, result.problems)

    def controllers(self, document: Document) -> tuple[Path, ...]:
        """Return the controllers that a document belongs to, as they were found last.

        Raises InputError for a lock that cannot be read.
        """
        if document.uri not in self._controllers:
            self._controllers[document.uri] = controllers_with(document, self.projects)
        return self._controllers[document.uri]

    def remember(self, document: Document, controllers: tuple[Path, ...]) -> None:
        """Keep the controllers that a document was found to belong to."""
        self._controllers[document.uri] = controllers

    def is_known(self, document: Document) -> bool:
        """Return whether a document belongs to a controller, or holds blocks of its own."""
        return document.is_source and bool(self._controllers.get(document.uri))

    def is_stale(self, path: Path, mended: frozenset[str]) -> bool:
        """Return whether a controller was found to have what a refresh may mend."""
        analysis = self.analyses.get(path.resolve())
        return analysis is not None and any(finding.kind in mended for finding in analysis.findings)

    def forget_closed(self) -> None:
        """Drop what is known of controllers of which no file is open any more."""
        open_ones = {
            path.resolve() for uri in self.documents for path in self._controllers.get(uri, ())
        }
        here = set(self.opened)
        self.analyses = {
            path: analysis for path, analysis in self.analyses.items() if path in open_ones | here
        }

    def parts(self, document: Document) -> tuple[Sequence[ControllerFigures], Sequence[str]]:
        """Return the figures of each controller of a document, and its name in each of them.

        A controller that cannot be read is left out: its diagnostics say why.
        """
        figures, files = [], []
        opened = self.opened
        if not document.is_source or document.path is None:
            return (), ()
        try:
            paths = self.controllers(document)
        except TraceRiskError:
            return (), ()
        for path in paths:
            try:
                controller = controller_with(path, opened, self.projects)
                controller_figures = figures_of(controller, partial(self._outline, controller))
                name = lock_key(document.path, controller.root)
            except TraceRiskError:
                continue
            figures.append(controller_figures)
            files.append(name)
        return figures, files

    def _outline(self, controller: Controller, file: str) -> Outline:
        path = controller.path_of(file)
        document = self.documents.get(self.uri_of(path))
        if document is not None:
            return self.outline(document)
        return _outline(controller, file)


def _is_saved(document: Document) -> bool:
    assert document.path is not None
    try:
        return file_bytes(document.path) == document.source
    except OSError:
        return False


def path_of(uri: str) -> Path | None:
    """Return the path of a file by its URI; `None` of what is no file."""
    parts = urlsplit(uri)
    if parts.scheme != "file" or not parts.path:
        return None
    path = unquote(parts.path)
    if sys.platform == "win32":
        # A host means a folder that it shares; `/c:/cell` is on a drive.
        path = f"//{parts.netloc}{path}" if parts.netloc else path[path[2:3] == ":" :]
    return Path(path)


def _encoded(text: str, path: Path | None) -> bytes:
    """Return a text as it is saved: in the encoding of its file."""
    kept = b""
    if path is not None:
        try:
            kept = file_bytes(path)
        except OSError:
            kept = b""
    source = text.encode("utf-8", "surrogatepass")
    if kept.startswith(_MARK) and not source.startswith(_MARK):
        source = _MARK + source
    if source == kept:
        return source
    for encoding in (_declared(source), *_SAVED_AS):
        try:
            saved = text.encode(encoding)
        except (LookupError, UnicodeEncodeError):
            continue
        if saved == kept:
            return saved
    try:
        return source if source.startswith(_MARK) else text.encode(_declared(source))
    except (LookupError, UnicodeEncodeError):
        return source


def _declared(source: bytes) -> str:
    """Return the encoding that a Python source declares."""
    try:
        return tokenize.detect_encoding(io.BytesIO(source).readline)[0]
    except SyntaxError:
        return "utf-8"


def controllers_with(document: Document, projects: Projects) -> tuple[Path, ...]:
    """Return the controllers that a document belongs to, itself where it has blocks alone.

    Raises InputError for a lock that cannot be read.
    """
    path = document.path
    if path is None or not document.is_source:
        return ()
    is_known = path.is_file() or is_gone(path, projects)
    controllers = controllers_of([path], projects) if is_known else ()
    if not controllers and b"RiskAnnotation" in document.source:
        return (path,)
    return controllers


def controller_with(path: Path, opened: Mapping[Path, bytes], projects: Projects) -> Controller:
    """Return the controller at `path` with the bytes of the files that are open.

    Raises InputError when it cannot be read.
    """
    here = path.resolve()
    project = projects.of(path)
    base = project.root
    others = {
        item.relative_to(base).as_posix(): source
        for item, source in opened.items()
        if item.is_relative_to(base)
    }
    file = here.relative_to(base).as_posix()
    source = others.pop(file, None)
    if source is None:
        source = load_controller(path, project).source
    return Controller(path, project, file, source, others)


def analyse(path: Path, opened: Mapping[Path, bytes], projects: Projects) -> Analysis:
    """Check a controller with the texts that are open."""
    try:
        if is_gone(path, projects):
            return Analysis(path, check_controller(path, projects).findings)
        controller = controller_with(path, opened, projects)
        checked = check_loaded(controller)
        # Of other sources than those of the evidence, its lines are not these.
        is_fresh = all(finding.kind not in ("stale", "unknown") for finding in checked.findings)
        advice = _advice(controller) if is_fresh else ()
        return Analysis(path, checked.findings, verdict=checked.verdict, advice=advice)
    except TraceRiskError as error:
        return Analysis(path, error=error)


def _advice(controller: Controller) -> tuple[Advice, ...]:
    """Return where a check would show undetected failures, by evidence of the last run."""
    evidence = evidence_of_last_run(controller)
    if evidence is None:
        return ()
    return tuple(
        replace(advice, location=replace(place, file=str(controller.path_of(place.file))))
        for advice in advice_of(evidence.cells)
        for place in (advice.location,)
    )


def solve_ahead(path: Path, opened: Mapping[Path, bytes], projects: Projects) -> None:
    """Solve the model of a controller, which is kept: it is there when it is asked for."""
    with suppress(TraceRiskError):
        controller = controller_with(path, opened, projects)
        _ = figures_of(controller, partial(_outline, controller)).importances


def _outline(controller: Controller, file: str) -> Outline:
    return outline_of(controller.source_of(file), str(controller.path_of(file)))
