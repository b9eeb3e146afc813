"""The language server: what an editor asks, and what it is sent without asking."""

from __future__ import annotations

import asyncio
import contextlib
import gc
import os
import signal
import sys
from collections.abc import AsyncIterator, Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any
from uuid import uuid4

from lsprotocol import types as lsp
from pygls.lsp.server import LanguageServer

from tracerisk.common.version import __version__
from tracerisk.editor.commands import register_commands
from tracerisk.editor.completion import Offer, offers
from tracerisk.editor.described_files import kind_of, yaml_offers
from tracerisk.editor.diagnostics import diagnostics_of
from tracerisk.editor.fixes import REFRESH, fixes
from tracerisk.editor.folding import foldings
from tracerisk.editor.hover import component_at, component_markdown, function_at, function_markdown
from tracerisk.editor.lenses import lenses
from tracerisk.editor.refreshing import Refreshes
from tracerisk.editor.session import (
    Analysis,
    Document,
    Session,
    analyse,
    controllers_with,
    solve_ahead,
)
from tracerisk.errors import TraceRiskError
from tracerisk.pipeline.check.remedies import MENDED_BY_REFRESH

_DELAY_S = 0.05
"""How long further changes are waited for before a check [s]."""
_IDLE_S = 0.3
"""How long after a check models are solved for what may be asked [s]."""
_SWITCH_S = 0.0005
"""How long a check in another thread may keep an answer waiting [s]; Python's own are 5 ms."""
_WATCHED = ("**/tracerisk.lock", "**/pyproject.toml", "**/tracerisk.evidence", "**/*.{yaml,yml}")


class RiskServer:
    """A server of one editor, with the texts that it has open; `connection` speaks with it."""

    def __init__(self) -> None:
        self.connection = LanguageServer(
            "tracerisk", __version__, text_document_sync_kind=lsp.TextDocumentSyncKind.Full
        )
        self.session = Session()
        self.refreshes = Refreshes()
        self.asks = False
        """Whether the editor asks for reasons itself: `asksForReasons` when it starts us."""
        self._waiting: set[str] = set()
        self._working: asyncio.Task[None] | None = None
        self._ahead: asyncio.Task[None] | None = None
        self._is_frozen = False
        self._shown: dict[Path, list[lsp.Diagnostic]] = {}

    def touch(self, uris: Iterable[str]) -> None:
        """Check documents again, soon."""
        self._waiting.update(uris)
        if self._ahead is not None:
            self._ahead.cancel()
        if self._working is None or self._working.done():
            self._working = asyncio.get_running_loop().create_task(self._work())

    async def _work(self) -> None:
        await asyncio.sleep(_DELAY_S)
        while self._waiting:
            uris, self._waiting = self._waiting, set()
            await self._check(uris)

    async def _check(self, uris: set[str]) -> None:
        session, loop = self.session, asyncio.get_running_loop()
        versions = {uri: item.version for uri, item in session.documents.items()}
        paths: dict[Path, None] = {}
        problems: dict[Path, Analysis] = {}
        for uri in sorted(uris):
            document = session.documents.get(uri)
            if document is None or not document.is_source or document.path is None:
                continue
            try:
                result = await loop.run_in_executor(
                    None, controllers_with, document, session.projects
                )
            except TraceRiskError as error:
                problems[document.path] = Analysis(document.path, error=error)
                continue
            session.remember(document, result)
            paths |= dict.fromkeys(result)
        opened = session.opened
        for path in paths:
            session.analyses[path.resolve()] = await loop.run_in_executor(
                None, analyse, path, opened, session.projects
            )
        session.analyses.update({path.resolve(): problem for path, problem in problems.items()})
        session.forget_closed()
        self._publish(uris, versions)
        self._ahead = loop.create_task(self._solve_ahead(tuple(paths), opened))
        self._freeze()
        capabilities = self.connection.client_capabilities.workspace
        if capabilities and capabilities.code_lens and capabilities.code_lens.refresh_support:
            self.connection.workspace_code_lens_refresh(None)

    def _freeze(self) -> None:
        """Keep what is loaded by the first check out of later garbage collections.

        To look through all of it takes as long as all requests together.
        """
        if not self._is_frozen:
            self._is_frozen = True
            gc.freeze()

    async def _solve_ahead(self, paths: Sequence[Path], opened: Mapping[Path, bytes]) -> None:
        """Solve the models of controllers while nobody types or asks."""
        await asyncio.sleep(_IDLE_S)
        for path in paths:
            await asyncio.get_running_loop().run_in_executor(
                None, solve_ahead, path, opened, self.session.projects
            )

    def _publish(self, asked: set[str], versions: Mapping[str, int | None]) -> None:
        """Send the diagnostics that are others than those that were sent last.

        `versions` are those of the texts that were checked.
        """
        session = self.session
        now = diagnostics_of(session)
        here = {
            document.path.resolve()
            for document in session.documents.values()
            if document.uri in asked and document.path is not None and document.is_source
        }
        for path in sorted({*now, *self._shown, *here}):
            result = now.get(path, [])
            if path in here or result != self._shown.get(path, []):
                uri = session.uri_of(path)
                self.connection.text_document_publish_diagnostics(
                    lsp.PublishDiagnosticsParams(uri, result, versions.get(uri))
                )
        self._shown = now

    def document(self, uri: str) -> Document | None:
        """Return a source that is open; `None` of any other text."""
        result = self.session.documents.get(uri)
        return result if result is not None and result.is_source else None

    def report(self, words: str, *, is_error: bool) -> None:
        """Show the user a line."""
        kind = lsp.MessageType.Error if is_error else lsp.MessageType.Info
        self.connection.window_show_message(lsp.ShowMessageParams(kind, words))

    async def apply(self, label: str, edit: lsp.WorkspaceEdit) -> bool:
        """Ask the editor to make an edit; return whether it did."""
        params = lsp.ApplyWorkspaceEditParams(edit, label=label)
        return bool((await self.connection.workspace_apply_edit_async(params)).applied)

    @contextlib.asynccontextmanager
    async def progress(self, title: str, cancel: Callable[[], None]) -> AsyncIterator[None]:
        """Show that something is under way, where the editor can; `cancel` ends it."""
        window = self.connection.client_capabilities.window
        if window is None or not window.work_done_progress:
            yield
            return
        shown, token = self.connection.work_done_progress, f"tracerisk-{uuid4()}"
        await shown.create_async(token)
        shown.tokens[token].add_done_callback(
            lambda tokens: cancel() if tokens.cancelled() else None
        )
        shown.begin(token, lsp.WorkDoneProgressBegin(title, cancellable=True))
        try:
            yield
        finally:
            shown.end(token, lsp.WorkDoneProgressEnd())
            del shown.tokens[token]


def language_server() -> RiskServer:
    """Return the server with all that it answers; `connection.start_io` runs it."""
    server = RiskServer()
    for name, answer in _ANSWERS.items():
        server.connection.feature(name, _OPTIONS.get(name))(partial(answer, server))
    register_commands(server)
    return server


def _initialize(server: RiskServer, params: lsp.InitializeParams) -> None:
    given = params.initialization_options
    server.asks = isinstance(given, dict) and given.get("asksForReasons") is True


def _initialized(server: RiskServer, _: lsp.InitializedParams) -> None:
    connection = server.connection
    encoding = connection.workspace.position_encoding
    server.session.encoding = getattr(encoding, "value", encoding) or "utf-16"
    able = connection.client_capabilities.workspace
    watching = None if able is None else able.did_change_watched_files
    if watching is not None and watching.dynamic_registration:
        watchers = [lsp.FileSystemWatcher(pattern) for pattern in _WATCHED]
        options = lsp.DidChangeWatchedFilesRegistrationOptions(watchers)
        name = lsp.WORKSPACE_DID_CHANGE_WATCHED_FILES
        files = lsp.Registration("tracerisk-files", name, options)
        connection.client_register_capability(lsp.RegistrationParams([files]))


def _opened(server: RiskServer, params: lsp.DidOpenTextDocumentParams) -> None:
    text = params.text_document
    server.session.put(text.uri, text.version, text.text)
    server.touch([text.uri])


def _changed(server: RiskServer, params: lsp.DidChangeTextDocumentParams) -> None:
    uri = params.text_document.uri
    # Each change is the whole text: that is what we asked for.
    server.session.put(uri, params.text_document.version, params.content_changes[-1].text)
    server.touch([uri])


def _saved(server: RiskServer, params: lsp.DidSaveTextDocumentParams) -> None:
    session = server.session
    document = session.documents.get(params.text_document.uri)
    if document is not None:
        # What is on disk is another now: how its bytes are made is found out again.
        session.put(document.uri, document.version, document.text)
    server.touch(list(session.documents))


def _closed(server: RiskServer, params: lsp.DidCloseTextDocumentParams) -> None:
    server.session.close(params.text_document.uri)
    server.touch([params.text_document.uri, *server.session.documents])


def _moved(server: RiskServer, _: lsp.DidChangeWatchedFilesParams) -> None:
    server.touch(list(server.session.documents))


def _hover(server: RiskServer, params: lsp.HoverParams) -> lsp.Hover | None:
    document = server.document(params.text_document.uri)
    if document is None:
        return None
    session, lines, line = server.session, document.lines, params.position.line + 1
    outline = session.outline(document)
    text = lines.text(line - 1)
    function = function_at(outline, line, text, lines.index(params.position))
    if function is None:
        return None
    figures, files = session.parts(document)
    block = outline.block_at(line)
    entry = None if block is None else component_at(block, line)
    if block is not None and entry is not None:
        hover_text = component_markdown(figures, files, block, entry)
    else:
        hover_text = function_markdown(figures, files, function)
    if not hover_text:
        return None
    return lsp.Hover(lsp.MarkupContent(lsp.MarkupKind.Markdown, hover_text), lines.whole(line - 1))


def _code_lens(server: RiskServer, params: lsp.CodeLensParams) -> list[lsp.CodeLens]:
    document = server.document(params.text_document.uri)
    if document is None:
        return []
    session = server.session
    figures, files = session.parts(document)
    stale = [session.is_stale(figure.controller.path, MENDED_BY_REFRESH) for figure in figures]
    shown = []
    for lens in lenses(session.outline(document), figures, files, stale):
        # One without a command of its own is a text.
        command = lsp.Command(lens.text, "")
        if lens.refreshes is not None:
            uri = session.uri_of(lens.refreshes.controller.path)
            command = lsp.Command(lens.text, REFRESH, arguments=[uri])
        shown.append(lsp.CodeLens(document.lines.whole(lens.line - 1), command))
    return shown


def _folding(server: RiskServer, params: lsp.FoldingRangeParams) -> list[lsp.FoldingRange]:
    document = server.document(params.text_document.uri)
    if document is None:
        return []
    return list(foldings(server.session.outline(document), document.lines.texts))


async def _shut_down(server: RiskServer, _: None) -> None:
    await server.refreshes.ended()


def _code_action(server: RiskServer, params: lsp.CodeActionParams) -> list[lsp.CodeAction]:
    document = server.document(params.text_document.uri)
    only = params.context.only
    wanted = only is None or any(
        lsp.CodeActionKind.QuickFix.value.startswith(item) for item in only
    )
    if document is None or not wanted:
        return []
    return list(fixes(server.session, document, params.range, asks=server.asks))


def _completion(server: RiskServer, params: lsp.CompletionParams) -> lsp.CompletionList:
    document = server.session.documents.get(params.text_document.uri)
    if document is None or document.path is None:
        return lsp.CompletionList(False, [])
    lines, line = document.lines, params.position.line
    before = lines.text(line)[: lines.index(params.position)]
    result: Iterable[Offer] = ()
    if document.path.suffix in (".yaml", ".yml"):
        kind = kind_of(lines.texts)
        result = () if kind is None else yaml_offers(kind, lines.texts, line, before)
    elif document.is_source:
        session = server.session
        above = [
            function for function in session.outline(document).functions if function[1] <= line + 1
        ]
        functions = [name for name, _ in reversed(above)]
        figures, _ = session.parts(document)
        file = document.path.name
        result = offers(lines.texts, line, before, figures, file=file, functions=functions)
    items = [
        _item(offer, lines.span(line, len(before) - len(offer.typed), len(before)), number)
        for number, offer in enumerate(result)
    ]
    return lsp.CompletionList(False, items)


def _item(offer: Offer, replaced: lsp.Range, number: int) -> lsp.CompletionItem:
    return lsp.CompletionItem(
        offer.text.splitlines()[0].rstrip(),
        kind=_ITEM_KINDS[offer.kind],
        detail=offer.about.split("; ")[0] or None,
        documentation=offer.about or None,
        sort_text=f"{number:04}",
        filter_text=offer.text,
        text_edit=lsp.TextEdit(replaced, offer.text),
    )


_ITEM_KINDS = {
    "section": lsp.CompletionItemKind.Struct,
    "key": lsp.CompletionItemKind.Field,
    "value": lsp.CompletionItemKind.Value,
    "name": lsp.CompletionItemKind.Reference,
}


_ANSWERS: Mapping[str, Callable[..., Any]] = {
    lsp.INITIALIZE: _initialize,
    lsp.INITIALIZED: _initialized,
    lsp.TEXT_DOCUMENT_DID_OPEN: _opened,
    lsp.TEXT_DOCUMENT_DID_CHANGE: _changed,
    lsp.TEXT_DOCUMENT_DID_SAVE: _saved,
    lsp.TEXT_DOCUMENT_DID_CLOSE: _closed,
    lsp.WORKSPACE_DID_CHANGE_WATCHED_FILES: _moved,
    lsp.SHUTDOWN: _shut_down,
    lsp.TEXT_DOCUMENT_HOVER: _hover,
    lsp.TEXT_DOCUMENT_COMPLETION: _completion,
    lsp.TEXT_DOCUMENT_CODE_LENS: _code_lens,
    lsp.TEXT_DOCUMENT_CODE_ACTION: _code_action,
    lsp.TEXT_DOCUMENT_FOLDING_RANGE: _folding,
}

_OPTIONS: Mapping[str, Any] = {
    lsp.TEXT_DOCUMENT_COMPLETION: lsp.CompletionOptions(trigger_characters=["@", "|", "=", " "]),
    lsp.TEXT_DOCUMENT_CODE_ACTION: lsp.CodeActionOptions([lsp.CodeActionKind.QuickFix]),
}


def serve() -> int:
    """Serve one editor over standard input and output, until it ends; return the exit code."""
    server = language_server()
    sys.setswitchinterval(_SWITCH_S)

    def end(number: int, _: Any) -> None:
        # A thread waits for the next byte of the editor: an orderly end would not come.
        server.refreshes.end()
        os._exit(128 + number)

    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, end)
    # What is printed by mistake must not come between the messages.
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    with contextlib.suppress(BrokenPipeError):
        server.connection.start_io(sys.stdin.buffer, answers)
    server.refreshes.end()
    return 0
