"""The server of the pages: to this machine alone, to read alone.

A page of another site that is open in the same browser can make it send requests here. So what
does not name this server as its host is refused (a name that was bound to this machine), and so
is what another site's page asks for.
"""

from __future__ import annotations

import sys
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from socketserver import TCPServer
from urllib.parse import urlsplit

from tracerisk.cli.serving.site import Reply, Site, refused
from tracerisk.errors import InputError

HOST = "127.0.0.1"
_IDLE_S = 10.0
"""How long a connection may say nothing [s]."""
_LONGEST = 8192
"""The longest target of a request [bytes]."""


_FOREIGN = "Pages of other sites get nothing from here."


class Server(ThreadingHTTPServer):
    """The server of one repository's pages."""

    daemon_threads = True

    def __init__(self, site: Site, port: int) -> None:
        self.site = site
        try:
            super().__init__((HOST, port), _Handler)
        except (OSError, OverflowError) as error:
            raise InputError(
                f"port {port} of {HOST} cannot be had: {error}; give another one with --port, or 0 "
                "for any that is free"
            ) from error

    def server_bind(self) -> None:
        """Bind without asking a name server who we are."""
        TCPServer.server_bind(self)
        self.server_name, self.server_port = HOST, self.server_address[1]

    @property
    def url(self) -> str:
        """The address of the first page."""
        return f"http://{HOST}:{self.server_port}/"

    def handle_error(self, request: object, client_address: object) -> None:
        """Print nothing of a browser that left before it had its answer."""
        if not isinstance(sys.exc_info()[1], ConnectionError | TimeoutError):
            super().handle_error(request, client_address)  # type: ignore[arg-type]


class _Handler(BaseHTTPRequestHandler):
    server: Server
    server_version = "tracerisk"
    sys_version = ""
    timeout = _IDLE_S

    def do_GET(self) -> None:
        self._send(self._refusal() or self._reply(), with_body=True)

    def do_HEAD(self) -> None:
        self._send(self._refusal() or self._reply(), with_body=False)

    def parse_request(self) -> bool:
        """Read the head of a request; refuse here whatever is not to be read."""
        if not super().parse_request():
            return False
        if self.command in ("GET", "HEAD"):
            return True
        text = "Nothing can be changed here: only GET is answered."
        self._send(refused(HTTPStatus.METHOD_NOT_ALLOWED, "Read only", text), with_body=True)
        return False

    def _reply(self) -> Reply:
        parts = urlsplit(self.path)
        return self.server.site.reply(parts.path, parts.query)

    def _refusal(self) -> Reply | None:
        """Return why a request is not answered; `None` for one that is."""
        if not self.path.startswith("/") or len(self.path) > _LONGEST:
            return refused(HTTPStatus.BAD_REQUEST, "Not a page", "The target is no path of a page.")
        names = {f"{host}:{self.server.server_port}" for host in (HOST, "localhost")}
        if self.headers.get_all("Host", []) not in [[name] for name in names]:
            message = f"This server answers to {self.server.url} and to no other name."
            return refused(HTTPStatus.MISDIRECTED_REQUEST, "Another host", message)
        origins = self.headers.get_all("Origin", [])
        if origins and origins not in [[f"http://{name}"] for name in names]:
            return refused(HTTPStatus.FORBIDDEN, "Another site", _FOREIGN)
        site = self.headers.get("Sec-Fetch-Site", "none")
        mode = self.headers.get("Sec-Fetch-Mode", "navigate")
        # Whoever follows a link of another site sees the page; the other site does not.
        if site not in ("none", "same-origin") and mode != "navigate":
            return refused(HTTPStatus.FORBIDDEN, "Another site", _FOREIGN)
        return None

    def _send(self, reply: Reply, *, with_body: bool) -> None:
        self.send_response(reply.status)
        for name, value in (
            ("Content-Type", reply.kind),
            ("Content-Length", str(len(reply.body))),
            ("Content-Security-Policy", reply.policy),
            ("Cross-Origin-Opener-Policy", "same-origin"),
            ("Cross-Origin-Resource-Policy", "same-origin"),
            ("X-Content-Type-Options", "nosniff"),
            ("X-Frame-Options", "DENY"),
            ("Referrer-Policy", "no-referrer"),
            ("Cache-Control", "no-store"),
            ("Connection", "close"),
        ):
            self.send_header(name, value)
        if reply.status == HTTPStatus.METHOD_NOT_ALLOWED:
            self.send_header("Allow", "GET, HEAD")
        self.end_headers()
        if with_body:
            self.wfile.write(reply.body)

    def log_message(self, format: str, *args: object) -> None:  # noqa: A002 - as it is there
        """Print nothing: what was asked is of no interest."""
