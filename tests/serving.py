# SPDX-License-Identifier: GPL-2.0-or-later
"""A server of `open` in a thread, and what it answers."""

from __future__ import annotations

import http.client
import json
import threading
from contextlib import contextmanager

import lammps_jump.served as served


@contextmanager
def serving(path):
    """A server of a file or folder, in a thread; it and what it started have ended after the block."""
    with served.Server(served.pages_of(path)) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.01,))
        thread.start()
        try:
            yield server
        finally:
            server.shutdown()
            thread.join()
            server.pages.close()


def send(server, method, path, body=None, **headers):
    """Status, headers and body of what the server answers; a header that is None is not sent."""
    port = server.server_address[1]
    given = {"Host": f"127.0.0.1:{port}"}
    if body is not None:
        given |= {"Origin": f"http://127.0.0.1:{port}", "Content-Type": "application/json"}
        body = body if isinstance(body, bytes) else json.dumps(body).encode()
        given["Content-Length"] = str(len(body))
    given |= {name.replace("_", "-"): value for name, value in headers.items()}
    line = http.client.HTTPConnection("127.0.0.1", port, timeout=600)
    line.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
    for name, value in given.items():
        if value is not None:
            line.putheader(name, value.format(port=port))
    line.endheaders(body)
    reply = line.getresponse()
    found = reply.status, dict(reply.getheaders()), reply.read()
    line.close()
    return found


def asked(server, path, body=None):
    """Data of an answer that is not refused."""
    status, told, data = send(server, "GET" if body is None else "POST", f"/{server.token}/{path}", body)
    assert status == 200, data
    return json.loads(data) if told["Content-Type"] == "application/json" else data
