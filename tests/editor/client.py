"""An editor for tests: a real client of the language server, which runs as a process of its own."""

import asyncio
import contextlib
import os
import threading
from functools import partial
from pathlib import Path
from typing import Any

from lsprotocol import types as lsp
from pygls.lsp.client import LanguageClient
from pygls.protocol import default_converter

from tests.conftest import program

LONGEST_S = 60.0


def _converter() -> Any:
    """A converter that knows a code action which has a command from a command alone."""
    converter = default_converter()

    def structure(value: Any, _: Any) -> Any:
        kind = lsp.Command if isinstance(value.get("command"), str) else lsp.CodeAction
        return converter.structure(value, kind)

    converter.register_structure_hook(lsp.Command | lsp.CodeAction, structure)
    return converter


class Editor:
    """A client with its server; each call waits for the answer."""

    def __init__(
        self,
        folder: Path,
        capabilities: lsp.ClientCapabilities | None = None,
        options: dict[str, Any] | None = None,
    ) -> None:
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()
        self._published: dict[str, list[lsp.PublishDiagnosticsParams]] = {}
        self._news = asyncio.Event()
        self.messages: list[str] = []
        self.edits: list[lsp.WorkspaceEdit] = []
        self.registered: list[lsp.Registration] = []
        self.progress: list[Any] = []
        self.progress_tokens: list[Any] = []
        self.refreshed_lenses = 0
        self.versions: dict[str, int] = {}
        self.options = options
        self.capabilities = capabilities or lsp.ClientCapabilities()
        self.client = LanguageClient("tests", "1", converter_factory=_converter)
        self.started = self._wait(self._start(folder))

    async def _start(self, folder: Path) -> lsp.InitializeResult:
        client = self.client
        client.feature(lsp.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS)(partial(self._take))
        client.feature(lsp.WINDOW_SHOW_MESSAGE)(partial(self._message))
        client.feature(lsp.WORKSPACE_APPLY_EDIT)(partial(self._edit))
        client.feature(lsp.CLIENT_REGISTER_CAPABILITY)(partial(self._register))
        client.feature(lsp.WORKSPACE_CODE_LENS_REFRESH)(partial(self._lenses))
        client.feature(lsp.WINDOW_WORK_DONE_PROGRESS_CREATE)(
            lambda params: self.progress_tokens.append(params.token)
        )
        client.feature(lsp.PROGRESS)(lambda params: self.progress.append(params.value))
        await client.start_io(*program(os.environ, verb="lsp"), "lsp", "--stdio")
        self.process = client._server
        started = await client.initialize_async(
            lsp.InitializeParams(
                capabilities=self.capabilities,
                root_uri=folder.as_uri(),
                initialization_options=self.options,
            )
        )
        client.initialized(lsp.InitializedParams())
        return started

    def _take(self, params: lsp.PublishDiagnosticsParams) -> None:
        self._published.setdefault(params.uri, []).append(params)
        self._report()

    def _message(self, params: lsp.ShowMessageParams) -> None:
        self.messages.append(params.message)
        self._report()

    def _edit(self, params: lsp.ApplyWorkspaceEditParams) -> lsp.ApplyWorkspaceEditResult:
        self.edits.append(params.edit)
        return lsp.ApplyWorkspaceEditResult(applied=True)

    def _register(self, params: lsp.RegistrationParams) -> None:
        self.registered += params.registrations

    def _lenses(self, _: None) -> None:
        self.refreshed_lenses += 1

    def _report(self) -> None:
        self._news.set()

    def _wait(self, coroutine: Any) -> Any:
        return asyncio.run_coroutine_threadsafe(coroutine, self._loop).result(LONGEST_S)

    def open(self, path: Path, text: str | None = None, language: str = "python") -> None:
        shown = path.read_bytes().decode() if text is None else text
        self.versions[path.as_uri()] = 1
        item = lsp.TextDocumentItem(path.as_uri(), language, 1, shown)
        self.client.text_document_did_open(lsp.DidOpenTextDocumentParams(item))

    def change(self, path: Path, text: str) -> None:
        uri = path.as_uri()
        self.versions[uri] += 1
        self.client.text_document_did_change(
            lsp.DidChangeTextDocumentParams(
                lsp.VersionedTextDocumentIdentifier(self.versions[uri], uri),
                [lsp.TextDocumentContentChangeWholeDocument(text)],
            )
        )

    def save(self, path: Path) -> None:
        self.client.text_document_did_save(
            lsp.DidSaveTextDocumentParams(lsp.TextDocumentIdentifier(path.as_uri()))
        )

    def close(self, path: Path) -> None:
        self.client.text_document_did_close(
            lsp.DidCloseTextDocumentParams(lsp.TextDocumentIdentifier(path.as_uri()))
        )

    def diagnostics(self, path: Path, *, seen: int | None = None) -> list[lsp.Diagnostic]:
        """What the server says of the version that is open; of the next word after `seen`."""
        uri = path.as_uri()

        async def published() -> list[lsp.Diagnostic]:
            while True:
                reported = self._published.get(uri, [])
                if seen is not None and len(reported) > seen:
                    return list(reported[-1].diagnostics)
                if seen is None and reported and reported[-1].version == self.versions.get(uri):
                    return list(reported[-1].diagnostics)
                self._news.clear()
                await self._news.wait()

        return self._wait(asyncio.wait_for(published(), LONGEST_S))

    def reported(self, path: Path) -> int:
        """How often diagnostics of a file came."""
        return len(self._published.get(path.as_uri(), []))

    def ask(self, request: str, params: Any) -> Any:
        return self._wait(getattr(self.client, f"{request}_async")(params))

    def hover(self, path: Path, line: int, character: int = 0) -> str | None:
        """What stands beside a place, both from 0 on."""
        found = self.ask(
            "text_document_hover",
            lsp.HoverParams(
                lsp.TextDocumentIdentifier(path.as_uri()), lsp.Position(line, character)
            ),
        )
        return None if found is None else found.contents.value

    def lenses(self, path: Path) -> list[tuple[int, str]]:
        found = self.ask(
            "text_document_code_lens", lsp.CodeLensParams(lsp.TextDocumentIdentifier(path.as_uri()))
        )
        return [(each.range.start.line, each.command.title) for each in found]

    def foldings(self, path: Path) -> list[tuple[int, int]]:
        found = self.ask(
            "text_document_folding_range",
            lsp.FoldingRangeParams(lsp.TextDocumentIdentifier(path.as_uri())),
        )
        return [(each.start_line, each.end_line) for each in found]

    def command(self, name: str, *arguments: Any) -> Any:
        return self.ask(
            "workspace_execute_command", lsp.ExecuteCommandParams(name, list(arguments))
        )

    def end(self) -> int | None:
        """Shut the server down as an editor does; return its exit code."""

        async def stop() -> int | None:
            with contextlib.suppress(Exception):
                await self.client.shutdown_async(None)
                self.client.exit(None)
            process = self.process
            code = None
            with contextlib.suppress(asyncio.TimeoutError):
                code = await asyncio.wait_for(process.wait(), 10)
            await self.client.stop()
            return code

        code = self._wait(stop())
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(10)
        return code
