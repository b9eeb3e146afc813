"""Quick fixes: refresh, keep or put back an edit, set a value by hand, accept a reason."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

from lsprotocol import types as lsp

from tracerisk.adder.lock.lock import WrittenBlock, lock_key
from tracerisk.common.settings.settings_file import loads_toml
from tracerisk.common.verdict import Reason, Verdict
from tracerisk.common.verdict_codes import ACCEPTABLE
from tracerisk.config import controller_root
from tracerisk.editor.diagnostics import finding_diagnostic
from tracerisk.editor.pins import CompactValue, ValueLine, pinning, value_at, written_value
from tracerisk.editor.session import Analysis, Document, Session
from tracerisk.errors import TraceRiskError
from tracerisk.pipeline.check.finding import CheckFinding
from tracerisk.pipeline.check.remedies import MENDED_BY_REFRESH

SETTINGS = "pyproject.toml"
REFRESH = "tracerisk.refresh"
"""Runs `tracerisk refresh`: the URI of a controller, and what becomes of edits."""
PIN = "tracerisk.pin"
"""Sets a value by hand: the URI of a source, the line from 0, the reason."""
ACCEPT = "tracerisk.accept"
"""Accepts a reason of a verdict: the URI of a controller, code, function, object, words."""
ASKED_PIN = "tracerisk.pinWithReason"
ASKED_ACCEPT = "tracerisk.acceptWithReason"
"""Commands of an editor that asks for the words, and then calls the two above."""


def fixes(
    session: Session, document: Document, shown: lsp.Range, *, asks: bool
) -> Iterator[lsp.CodeAction]:
    """Yield what can be done about a part of a source.

    `asks`: the editor has the commands that ask for a reason.
    """
    assert document.path is not None
    first, last = shown.start.line, shown.end.line
    here = document.path.resolve()
    for analysis in session.analyses.values():
        of_controller = []
        for finding in analysis.findings:
            line = (finding.location.line or 1) - 1
            if first <= line <= last and Path(finding.location.file).resolve() == here:
                of_controller.append(finding)
                yield from _of_finding(session, document, analysis, finding, asks=asks)
        yield from _refreshes(session, document, analysis, of_controller)
    yield from _pin(session, document, first, asks=asks)


def _refreshes(
    session: Session, document: Document, analysis: Analysis, found: list[CheckFinding]
) -> Iterator[lsp.CodeAction]:
    mended = [check_finding for check_finding in found if check_finding.kind in MENDED_BY_REFRESH]
    if not mended:
        return
    uri, name = session.uri_of(analysis.path), analysis.path.name
    diagnostics = [
        finding_diagnostic(check_finding, analysis.path, document.lines) for check_finding in mended
    ]
    is_edited = any(check_finding.kind in ("edited", "undecided") for check_finding in mended)
    if not is_edited:
        yield _command(
            f"Refresh the risk blocks of {name}", diagnostics, REFRESH, [uri], preferred=True
        )
        return
    if any(check_finding.kind == "edited" for check_finding in mended):
        title = f"Keep all edits of {name} as set by hand, and refresh"
        yield _command(title, diagnostics, REFRESH, [uri, "accept-edits"])
    title = f"Discard all edits of {name}, and refresh"
    yield _command(title, diagnostics, REFRESH, [uri, "discard-edits"])


def _of_finding(
    session: Session, document: Document, analysis: Analysis, finding: CheckFinding, *, asks: bool
) -> Iterator[lsp.CodeAction]:
    diagnostics = [finding_diagnostic(finding, analysis.path, document.lines)]
    if finding.kind in ("edited", "undecided"):
        line = (finding.location.line or 1) - 1
        key = finding.subject.rpartition(".")[2]
        value = _value_at(session, document, line, key)
        written = written_of(session, document, line, key)
        if value is not None and written is not None and value.key != "next":
            title = f"Put {value.key} back to {written}"
            edit = _workspace_edit(document, value.with_value(written))
            yield lsp.CodeAction(title, lsp.CodeActionKind.QuickFix, diagnostics, edit=edit)
    reason = reason_of(analysis.verdict, finding.message, finding.subject)
    if finding.kind in ("faulted", "partial") and reason is not None:
        given = [session.uri_of(analysis.path), *reason.key]
        title = f"Accept {reason.code} in {settings_of(controller_root(analysis.path)).name}"
        if asks:
            yield _command(f"{title}, with a reason", diagnostics, ASKED_ACCEPT, list(given))
            return
        edit = acceptance(session, analysis.path, *reason.key, "")
        if edit is not None:
            yield lsp.CodeAction(title, lsp.CodeActionKind.QuickFix, diagnostics, edit=edit)


def _pin(
    session: Session, document: Document, line: int, *, asks: bool
) -> Iterator[lsp.CodeAction]:
    edits = pin_edits(session, document, line, "")
    if not edits:
        return
    value = _value_at(session, document, line)
    assert value is not None
    title = f"Set {value.key} by hand, with a reason"
    if value.is_pinned:
        title = f"Give a reason for {value.key}"
    kind = lsp.CodeActionKind.QuickFix
    if asks:
        command = lsp.Command(title, ASKED_PIN, arguments=[document.uri, line])
        yield lsp.CodeAction(title, kind, command=command)
    else:
        yield lsp.CodeAction(title, kind, edit=_workspace_edit(document, edits))


def pin_edits(session: Session, document: Document, line: int, reason: str) -> dict[int, str]:
    """Return the lines, from 0, with which the value of a line is set by hand; maybe none."""
    block = session.outline(document).block_at(line + 1)
    if block is None:
        return {}
    texts = document.lines.texts
    return pinning(texts, block, line, written_of(session, document, line), reason)


def pin(session: Session, document: Document, line: int, reason: str) -> lsp.WorkspaceEdit | None:
    """Return the edit that sets the value of a line by hand; `None` where there is no value."""
    edits = pin_edits(session, document, line, reason)
    return _workspace_edit(document, edits) if edits else None


def _value_at(
    session: Session, document: Document, line: int, key: str = ""
) -> ValueLine | CompactValue | None:
    block = session.outline(document).block_at(line + 1)
    return value_at(document.lines.texts, block, line, key)


def written_of(session: Session, document: Document, line: int, key: str = "") -> str | None:
    """Return what the lock says was written for a value on a line of a source, from 0.

    `key` says which value of a line of the compact form is meant.
    """
    block = session.outline(document).block_at(line + 1)
    value = _value_at(session, document, line, key)
    if block is None or value is None or document.path is None:
        return None
    try:
        project = session.projects.of(document.path)
        key, lock = lock_key(document.path, project.root), project.lock
    except TraceRiskError:
        return None
    for entry in lock.controllers.values():
        base: WrittenBlock | None = entry.blocks.get(key, {}).get(block.function)
        written = written_value(block, base, value.key, line)
        if written is not None:
            return written
    return None


def acceptance(
    session: Session, controller: Path, code: str, function: str, thing: str, words: str
) -> lsp.WorkspaceEdit | None:
    """Return the edit of the settings that accepts a reason; `None` where there can be none."""
    path = settings_of(controller_root(controller))
    if not path.is_file():
        return None
    lines = session.lines_of(path)
    added = accepting("\n".join(lines.texts), code, function, thing, words)
    if added is None:
        return None
    end = lines.position(len(lines.texts) - 1, len(lines.texts[-1]))
    return lsp.WorkspaceEdit({session.uri_of(path): [lsp.TextEdit(lsp.Range(end, end), added)]})


def _workspace_edit(document: Document, edits: dict[int, str]) -> lsp.WorkspaceEdit:
    lines = document.lines
    changes = [
        lsp.TextEdit(lines.span(line, 0, len(lines.text(line))), text)
        for line, text in sorted(edits.items())
    ]
    return lsp.WorkspaceEdit({document.uri: changes})


def _command(
    title: str,
    diagnostics: list[lsp.Diagnostic],
    name: str,
    arguments: list[str],
    *,
    preferred: bool = False,
) -> lsp.CodeAction:
    command = lsp.Command(title, name, arguments=arguments)
    kind = lsp.CodeActionKind.QuickFix
    return lsp.CodeAction(title, kind, diagnostics, is_preferred=preferred or None, command=command)


def reason_of(verdict: Verdict | None, message: str, function: str) -> Reason | None:
    """Return the reason of a verdict that a finding reports, if it may be accepted."""
    for open_reason in () if verdict is None else verdict.open_reasons:
        if (
            open_reason.code in ACCEPTABLE
            and open_reason.function == function
            and message.startswith(open_reason.words)
        ):
            return open_reason
    return None


def accepting(text: str, code: str, function: str, thing: str, words: str) -> str | None:
    """Return what is to stand behind the settings so that a reason is accepted.

    `None` where their `accept` is written in a way that nothing can be put behind.
    """
    given = {"code": code, "function": function, "object": thing, "words": words}
    # A JSON string is a basic string of TOML.
    lines = [
        f"{key} = {json.dumps(value)}" for key, value in given.items() if value or key == "words"
    ]
    gap = "" if not text or text.endswith("\n\n") else "\n" if text.endswith("\n") else "\n\n"
    added = gap + "\n".join(["[[tool.tracerisk.accept]]", *lines]) + "\n"
    try:
        loads_toml((text + added).replace("\r\n", "\n"))
    except ValueError:
        return None
    return added


def settings_of(root: Path) -> Path:
    """Return the settings of a controller's root."""
    return root.resolve() / SETTINGS
