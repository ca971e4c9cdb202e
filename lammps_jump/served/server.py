# SPDX-License-Identifier: GPL-2.0-or-later
"""The server: what it refuses, how an answer is sent, and files of pages, by their names alone.

What is served it asks of its pages. Files are styles and scripts of this folder and of the report.
"""

from __future__ import annotations

import hmac
import html
import io
import json
import logging
import re
import secrets
import socket
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Lock
from typing import Any, NamedTuple, Protocol
from urllib.parse import parse_qs

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from lammps_jump.analysis.report import page
from lammps_jump.errors import JumpError
from lammps_jump.files import MOST_TEXT, plain, read_file
from lammps_jump.foreign import foreign, reason

HOME = "127.0.0.1"
NAMES = re.compile(r"(?:127\.0\.0\.1|localhost)(?::\d{1,5})?")
"""Names of this machine in an address, with any port: a tunnel has one of its own, and a browser leaves out port 80."""
MOST_ASKED = 20_000_000
"""Bytes of a request: a case of 100,000 discs one by one."""
PATIENCE = 30.0
"""Seconds that a browser may take no bytes of an answer."""
HEAD_SECONDS, BODY_SECONDS = 10.0, 120.0
"""Seconds in which a connection has to show the token, and a request to be there."""
DRAIN_SECONDS = 2.0
"""Seconds in which a browser has to read the answer to a request that was not read."""
MOST_UNKNOWN = 32
"""Connections that have not shown the token; the oldest gives way to another."""
MOST_KNOWN = 32
"""Requests that are answered at once."""
AT_ONCE = 1 << 16
"""Bytes that a browser has to take within the patience."""
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; media-src blob:; "
    "connect-src 'self'; frame-src 'self'; frame-ancestors 'self'; base-uri 'none'; form-action 'none'"
)
"""Rights of a page: to run the scripts of this program, and to ask this server."""
FOREIGN = (
    "sandbox allow-scripts allow-downloads; default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data: blob:; media-src data: blob:; frame-ancestors 'self'; base-uri 'none'; form-action 'none'"
)
"""The same for a report, which may come from anywhere: it acts within itself, as a file that is opened does."""
LIVE = FOREIGN.replace("script-src 'unsafe-inline'", "worker-src blob:; script-src 'unsafe-inline' 'wasm-unsafe-eval'")
"""The same for a live page, which computes in a thread of its own; it names the hashes of its scripts itself."""
NOTHING = "default-src 'none'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
"""The same for a page that only leads to another."""
SAFE = {
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cache-Control": "no-store",
}


BROKEN = "this is a defect of lammps-jump; the terminal where it runs tells more"
"""Why a request has no answer."""
log = logging.getLogger(__name__)


class Reply(NamedTuple):
    """An answer: its bytes, what they are, what a page of them may do, and where else the answer is."""

    body: bytes
    kind: str = "application/json"
    status: int = 200
    policy: str = POLICY
    elsewhere: str = ""


class Pages(Protocol):
    """Pages that are served, by the part of the address after the token.

    Attributes
    ----------
    start : str
        The page that is to be opened first.
    """

    start: str

    def get(self, path: str, query: Mapping[str, str]) -> Reply | None:
        """An answer; None where there is no such page. Nothing is changed."""

    def post(self, path: str, asked: Mapping[str, Any]) -> Reply | None:
        """An answer to what is to be done; None where nothing is done there."""

    def alone(self, token: str) -> Reply | None:
        """Content at an address with a token of its own, which is good for nothing else."""


class RefusedRequest(Exception):
    """A request that gets no answer but a status and a reason."""

    def __init__(self, status: int, reason: str):
        super().__init__(reason)
        self.status = status


def answer(data: object, status: int = 200) -> Reply:
    """Plain data as an answer."""
    return Reply(json.dumps(plain(data), allow_nan=False).encode(), status=status)


def leading_to(address: str) -> str:
    """A page that leads a browser to an address at once."""
    shown = html.escape(address)
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>lammps-jump</title>'
        f'<meta name="referrer" content="no-referrer"><meta http-equiv="refresh" content="0; url={shown}"></head>'
        f'<body><p><a href="{shown}">lammps-jump</a></p></body></html>\n'
    )


class Server(ThreadingHTTPServer):
    """Serves pages on the loopback address.

    Parameters
    ----------
    pages : Pages
    port : int
        0: any that is free.

    Raises
    ------
    OSError
        The port is taken.
    """

    daemon_threads = True
    request_queue_size = 128

    def __init__(self, pages: Pages, port: int = 0):
        self.pages, self.token = pages, secrets.token_urlsafe(32)
        self._lock = Lock()
        self._ticket: tuple[str, Callable[[], None]] | None = None
        self._unknown: dict[socket.socket, None] = {}
        self._known: set[socket.socket] = set()
        super().__init__((HOME, port), Handler)

    @property
    def address(self) -> str:
        """Address for a browser."""
        return f"http://{HOME}:{self.server_address[1]}/{self.token}/{self.pages.start}"

    def ticket(self, used: Callable[[], None]) -> str:
        """A page of its own that leads a browser to the pages, once; then `used` is called.

        The command line of a browser shows what it opens to all users of the machine: it opens a file with this page.
        """
        self._ticket = secrets.token_urlsafe(32), used
        return leading_to(f"http://{HOME}:{self.server_address[1]}/{self._ticket[0]}/")

    def redeem(self, token: str) -> Reply | None:
        """Page that a ticket leads to: another one of this server, which leads on; None for no ticket."""
        with self._lock:
            if self._ticket is None or not hmac.compare_digest(self._ticket[0].encode(), token.encode()):
                return None
            used, self._ticket = self._ticket[1], None
        used()
        return Reply(
            leading_to(f"/{self.token}/{self.pages.start}").encode(), "text/html; charset=utf-8", policy=NOTHING
        )

    def process_request(self, request: Any, client_address: Any) -> None:
        """Answer a connection in a thread of its own; the oldest of too many that have not shown the token is cut."""
        with self._lock:
            self._unknown[request] = None
            late = next(iter(self._unknown)) if len(self._unknown) > MOST_UNKNOWN else None
            if late is not None:
                del self._unknown[late]
        if late is not None:
            with suppress(OSError):  # its thread wakes, and closes it
                late.shutdown(socket.SHUT_RDWR)
        super().process_request(request, client_address)

    def shutdown_request(self, request: Any) -> None:
        """Close a connection."""
        with self._lock:
            self._unknown.pop(request, None)
            self._known.discard(request)
        super().shutdown_request(request)

    def know(self, request: socket.socket) -> None:
        """A connection has shown the token.

        Raises
        ------
        Refused
            Too many others are answered now.
        """
        with self._lock:
            self._unknown.pop(request, None)
            if len(self._known) >= MOST_KNOWN:
                raise RefusedRequest(
                    503, f"{MOST_KNOWN} requests are answered at once; close other pages, or wait a moment"
                )
            self._known.add(request)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Stay silent about a browser that has gone; `Handler` tells all else."""


class _Until(io.RawIOBase):
    """Bytes that a connection sends, up to a moment."""

    def __init__(self, line: socket.socket):
        self.line, self.end = line, time.monotonic() + HEAD_SECONDS

    def readable(self) -> bool:
        """It is for reading."""
        return True

    def readinto(self, buffer: Any) -> int:
        """As of a file; TimeoutError where the moment has come."""
        self.line.settimeout(max(self.end - time.monotonic(), 1e-3))
        return self.line.recv_into(buffer)


class Handler(BaseHTTPRequestHandler):
    """One connection."""

    server: Server
    protocol_version = "HTTP/1.1"
    server_version, sys_version = "lammps-jump", ""

    def setup(self) -> None:
        """Read the connection for a while alone, whatever comes of it how slowly."""
        super().setup()
        self.rfile.close()
        self._until = _Until(self.connection)
        self.rfile = io.BufferedReader(self._until)

    def do_GET(self) -> None:
        """Answer a request."""
        self._answer(self._get)

    def do_POST(self) -> None:
        """Carry out a request."""
        self._answer(self._post)

    def send_error(self, code: int, message: str | None = None, explain: str | None = None) -> None:
        """Refuse what is no request of a page, by the same rules as all else."""
        self.close_connection = True
        with suppress(OSError):
            self._send(answer({"refused": "this is no request of a page"}, code))

    def log_message(self, format: str, *args: Any) -> None:
        """Nothing: the terminal is for what a person has to know."""

    def _answer(self, make: Any) -> None:
        self.close_connection = True  # what is sent after a request is not read, and no line outlives the server
        try:
            reply = self._reply(make)
            if reply is None:
                raise RefusedRequest(404, "there is no such page")
        except RefusedRequest as refused:
            reply = answer({"refused": str(refused)}, refused.status)
        except JumpError as error:
            reply = answer({"refused": str(error)}, 422)
        except Exception as error:  # a defect of this program: it is reported, and the next request is answered
            log.exception(f"error: {self.command} {self.path.partition('?')[0].rpartition('/')[2]}")
            reply = answer({"refused": f"{BROKEN} ({type(error).__name__}: {reason(error)})"}, 500)
        with suppress(OSError):  # the browser has gone
            self._send(reply)

    def _reply(self, make: Any) -> Reply | None:
        """The answer to a request that shows the token of the pages, or one that is good for a single answer."""
        token, path, query = self._asked()
        if make == self._get and not path and (reply := self.server.redeem(token)) is not None:
            return reply
        if self.headers.get("Sec-Fetch-Site", "same-origin") not in ("same-origin", "none"):
            raise RefusedRequest(403, "another page asks")
        if hmac.compare_digest(token.encode(), self.server.token.encode()):
            self.server.know(self.connection)
            self._until.end = time.monotonic() + BODY_SECONDS
            return make(path, query)
        reply = self.server.pages.alone(token) if make == self._get and not path else None
        if reply is None:
            raise RefusedRequest(403, "open the address that lammps-jump printed; its random part is missing or wrong")
        self.server.know(self.connection)
        return reply

    def _send(self, reply: Reply) -> None:
        self.connection.settimeout(PATIENCE)
        self.send_response(reply.status)
        headers = {"Content-Type": reply.kind, "Content-Length": str(len(reply.body)), **SAFE}
        headers |= {"Location": reply.elsewhere} if reply.elsewhere else {}
        for name, value in {**headers, "Content-Security-Policy": reply.policy, "Connection": "close"}.items():
            self.send_header(name, value)
        self.end_headers()
        body = memoryview(reply.body)
        for start in range(0, len(body), AT_ONCE):  # the patience is that of a piece, however slow the line
            self.wfile.write(body[start : start + AT_ONCE])
        self._drain()

    def _drain(self) -> None:
        """Read what is left of a request that was refused: to close before that would cut off the answer, too."""
        self.connection.shutdown(socket.SHUT_WR)
        self._until.end = time.monotonic() + DRAIN_SECONDS
        left = MOST_ASKED
        while left > 0 and (got := len(self.rfile.read1(AT_ONCE))):
            left -= got

    def _asked(self) -> tuple[str, str, Mapping[str, str]]:
        """Token, path after it, and query.

        Raises
        ------
        Refused
            Another host, another page that asks.
        """
        hosts = self.headers.get_all("Host") or []
        if len(hosts) != 1 or not NAMES.fullmatch(hosts[0]):
            raise RefusedRequest(421, "this server is for this machine alone")
        sent = self.headers.get_all("Origin") or []
        if len(sent) > 1 or (sent and sent[0] != f"http://{hosts[0]}"):
            raise RefusedRequest(403, "another page asks")
        path, _, query = self.path.partition("?")
        root, token, rest = (*path.split("/", 2), "", "")[:3]
        try:
            given = parse_qs(query[:200], max_num_fields=8)
        except ValueError:
            raise RefusedRequest(400, "too many fields") from None
        return "" if root else token, rest, {name: values[-1] for name, values in given.items()}

    def _get(self, path: str, query: Mapping[str, str]) -> Reply | None:
        return self.server.pages.get(path, query)

    def _post(self, path: str, query: Mapping[str, str]) -> Reply | None:
        if not self.headers.get("Origin"):
            raise RefusedRequest(403, "the browser does not tell which page asks")
        if self.headers.get_content_type() != "application/json" or self.headers.get("Transfer-Encoding"):
            raise RefusedRequest(415, "only JSON of a known length is taken")
        length = self.headers.get("Content-Length", "")
        if not (length.isascii() and length.isdigit() and len(length) < 20 and int(length) <= MOST_ASKED):
            raise RefusedRequest(413, f"at most {MOST_ASKED // 1_000_000} MB are taken")
        try:
            body = self.rfile.read(int(length))
        except TimeoutError:
            raise RefusedRequest(408, f"the request was not there within {BODY_SECONDS:.0f} s; try again") from None
        with foreign(partial(RefusedRequest, 400), "this is no JSON"):
            content = json.loads(body)
        if not isinstance(content, dict):
            raise RefusedRequest(400, "a JSON object is expected")
        return self.server.pages.post(path, content)


KINDS = {
    ".html": "text/html; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
}
HERE, REPORT = Path(__file__).parent, Path(page.__file__).parent
ASSETS = {
    **{
        name: HERE / name
        for name in (
            "open.css",
            "ask.js",
            "case.js",
            "text.js",
            "places.js",
            "drop.js",
            "flow.js",
            "live.js",
            "run.js",
            "study.js",
            "axes.js",
        )
    },
    **{name: REPORT / name for name in ("page.css", *page.SCRIPTS)},
}
"""Nothing else is read for an address."""


def asset(name: str) -> Reply | None:
    """A file of `ASSETS`; None for another name."""
    path = ASSETS.get(name)
    return None if path is None else page_of(path)


def page_of(path: Path) -> Reply:
    """A file of this program."""
    return Reply(read_file(path, MOST_TEXT), KINDS[path.suffix])


def run_page() -> Reply:
    """The page of a run: the player of the report, empty."""
    loader = FileSystemLoader([HERE, REPORT])
    template = Environment(loader=loader, autoescape=True, undefined=StrictUndefined).get_template("run.html.j2")
    return Reply(template.render().encode(), KINDS[".html"])
