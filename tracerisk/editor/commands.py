"""What an editor asks the server to do: refresh, set a value by hand, accept a reason."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

from tracerisk.common.verdict_codes import ACCEPTABLE
from tracerisk.editor.fixes import ACCEPT, PIN, REFRESH, SETTINGS, acceptance, pin
from tracerisk.editor.refreshing import POLICIES, Refreshed
from tracerisk.editor.session import path_of
from tracerisk.errors import one_of

if TYPE_CHECKING:
    from tracerisk.editor.server import RiskServer


def register_commands(server: RiskServer) -> None:
    """Give the server its commands; what an editor leaves out of their arguments is empty."""

    async def refreshed(*words: Any) -> bool:
        return await _refresh(server, *map(str, (*words, "", "")[:2]))

    async def pinned(*words: Any) -> bool:
        return await _pin(server, *(*words, "", "", "")[:3])

    async def accepted(*words: Any) -> bool:
        return await _accept(server, *map(str, (*words, "", "", "", "", "")[:5]))

    server.connection.command(REFRESH)(refreshed)
    server.connection.command(PIN)(pinned)
    server.connection.command(ACCEPT)(accepted)


async def _refresh(server: RiskServer, uri: str, policy: str) -> bool:
    """Refresh a controller, show the user how that ended, and return whether it ended well."""
    path = path_of(uri)
    if path is None or policy not in ("", *POLICIES):
        server.report(f"{REFRESH} takes the URI of a file, and {one_of(POLICIES)}", is_error=True)
        return False
    path = path.resolve()
    unsaved = [item.path.name for item in server.session.unsaved() if item.path is not None]
    if unsaved:
        message = f"{', '.join(unsaved)} is not saved; save, then refresh {path.name}"
        server.report(message, is_error=True)
        return False
    if server.refreshes.is_running(path):
        server.report(f"{path.name} is being refreshed already", is_error=True)
        return False
    async with server.progress(f"refreshing {path.name}", partial(server.refreshes.end, path)):
        done: Refreshed = await server.refreshes.run(path, path.parent, policy)
    server.report(done.words, is_error=not done.is_fine)
    for document in list(server.session.documents.values()):
        server.session.put(document.uri, document.version, document.text)
    server.touch(list(server.session.documents))
    return done.is_fine


async def _pin(server: RiskServer, uri: Any, line: Any, reason: Any) -> bool:
    """Set the value of a line by hand; return whether the editor did so."""
    document = server.document(str(uri))
    if document is None or not isinstance(line, int):
        server.report(f"{PIN} takes the URI of an open source, a line and a reason", is_error=True)
        return False
    edit = pin(server.session, document, line, str(reason))
    if edit is None:
        server.report(
            "there is no value of a risk block to set by hand on this line", is_error=True
        )
        return False
    return await server.apply("set a value by hand", edit)


async def _accept(
    server: RiskServer, uri: str, code: str, function: str, thing: str, words: str
) -> bool:
    """Accept a reason of a controller's verdict; return whether the editor did so."""
    path = path_of(uri)
    if path is None or code not in ACCEPTABLE or not words.strip():
        text = f"{ACCEPT} takes the URI of a controller, a code, function, object and words"
        server.report(f"{text}; {one_of(ACCEPTABLE, code)}", is_error=True)
        return False
    edit = acceptance(server.session, path, code, function, thing, words.strip())
    if edit is None:
        server.report(f"{path.parent} has no {SETTINGS} that another entry fits", is_error=True)
        return False
    return await server.apply(f"accept {code}", edit)
