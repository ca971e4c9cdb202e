# SPDX-License-Identifier: GPL-2.0-or-later
"""The server of `open`: what it refuses, and that nothing but the case file that was opened is ever written."""

import base64
import json
import re
import socket
from functools import partial
from random import Random

import pytest
from fault_table import many
from serving import asked, send, serving

import lammps_jump.served as served
from lammps_jump.errors import CaseError
from lammps_jump.served import look, pages
from lammps_jump.served.server import MOST_UNKNOWN

CASE = """\
# A column before it falls.
name: small
discs: {diameter: 20 cm}   # of all
contact: {restitution: 0.5, impact_speed: 5}
domain: {x: [-1, 6], y: [-1, 4]}
walls:
  - {name: floor, kind: plane, axis: y, at: 0, side: above}
  - {name: sill, kind: block, x: [4, 4.5], y: [0, 0.5]}  # found by trial
initial: [{kind: column, x: [0, 1], y: [0, 1]}]
run: {duration: 0.2, output_interval: 0.1}
"""


@pytest.fixture
def case(tmp_path):
    path = tmp_path / "mine" / "case.yaml"
    path.parent.mkdir()
    path.write_text(CASE)
    (tmp_path / "secret.txt").write_text("secret")
    return path


@pytest.fixture
def server(case):
    with serving(case) as running:
        yield running


SAVE = {"text": "stolen", "key": "0"}
ATTACKS = {
    "no token": ("GET", "/", None, {}, 403),
    "wrong token": ("GET", "/wrong/", None, {}, 403),
    "token cut short": ("GET", "/{short}/", None, {}, 403),
    "token of other letters": ("GET", "/{upper}/", None, {}, 403),
    "token in the query": ("GET", "/?token={token}", None, {}, 403),
    "another name of this machine": ("GET", "/{token}/", None, {"Host": "evil.example:{port}"}, 421),
    "an address of the network": ("GET", "/{token}/", None, {"Host": "192.168.0.1:{port}"}, 421),
    "a name that begins like ours": ("GET", "/{token}/", None, {"Host": "localhost.evil.example:{port}"}, 421),
    "no host": ("GET", "/{token}/", None, {"Host": None}, 421),
    "a page of another origin": ("GET", "/{token}/file", None, {"Origin": "https://evil.example"}, 403),
    "a page without origin": ("GET", "/{token}/file", None, {"Origin": "null"}, 403),
    "a page on another port": ("GET", "/{token}/file", None, {"Origin": "http://127.0.0.1:1"}, 403),
    "a link on another site": ("GET", "/{token}/", None, {"Sec_Fetch_Site": "cross-site"}, 403),
    "path outside": ("GET", "/{token}/../secret.txt", None, {}, 404),
    "path outside, in code": ("GET", "/{token}/%2e%2e%2fsecret.txt", None, {}, 404),
    "path of the system": ("GET", "/{token}//etc/passwd", None, {}, 404),
    "file beside the case": ("GET", "/{token}/case.yaml", None, {}, 404),
    "source of the program": ("GET", "/{token}/server.py", None, {}, 404),
    "saving without origin": ("POST", "/{token}/save", SAVE, {"Origin": None}, 403),
    "saving from another page": ("POST", "/{token}/save", SAVE, {"Origin": "https://evil.example"}, 403),
    "saving by a form": ("POST", "/{token}/save", SAVE, {"Content_Type": "text/plain"}, 415),
    "saving by a link": ("GET", "/{token}/save?text=stolen", None, {}, 404),
    "saving without a key": ("POST", "/{token}/save", {"text": "stolen"}, {}, 400),
    "saving another file": ("POST", "/{token}/save", {**SAVE, "name": "../secret.txt", "path": "/etc/passwd"}, {}, 409),
    "no JSON": ("POST", "/{token}/look", b"{", {}, 400),
    "brackets without end": ("POST", "/{token}/look", 100_000 * b"[", {}, 400),
    "a list": ("POST", "/{token}/look", b"[]", {}, 400),
    "a drawing that is not coded": (
        "POST",
        "/{token}/drawing",
        {"text": "", "name": "a", "scale": "", "data": "?"},
        {},
        400,
    ),
    "a number for a text": ("POST", "/{token}/look", {"text": 1, "wide": 700}, {}, 400),
    "half of a letter": ("POST", "/{token}/look", {"text": "\ud800", "wide": 700}, {}, 400),
    "too much": ("POST", "/{token}/look", b"{}", {"Content_Length": "99999999999"}, 413),
    "much behind many zeros": ("POST", "/{token}/look", b"{}", {"Content_Length": "0000000000009999999999999"}, 413),
    "a length below zero": ("POST", "/{token}/look", b"{}", {"Content_Length": "-1"}, 413),
    "a length that is not told": ("POST", "/{token}/look", b"{}", {"Transfer_Encoding": "chunked"}, 415),
    "another method": ("DELETE", "/{token}/file", None, {}, 501),
    "writing by PUT": ("PUT", "/{token}/case.yaml", SAVE, {}, 501),
}


@pytest.mark.fault("requests to a page")
@pytest.mark.parametrize("attack", ATTACKS)
def test_attacks_are_refused(server, case, attack):
    method, path, body, headers, wanted = ATTACKS[attack]
    names = {"token": server.token, "short": server.token[:-1], "upper": server.token.swapcase()}
    before = {one: one.read_bytes() for one in case.parents[1].rglob("*") if one.is_file()}
    status, told, data = send(server, method, path.format(**names), body, **headers)
    assert status == wanted, data
    hidden = [b"secret", server.token.encode(), *([b"column before"] if wanted != 409 else [])]
    assert not [one for one in hidden if one in data]
    assert {one: one.read_bytes() for one in case.parents[1].rglob("*") if one.is_file()} == before
    assert asked(server, "file")["text"] == CASE  # it serves on
    assert told["Content-Security-Policy"].startswith("default-src 'none'")


def test_it_listens_on_this_machine_alone(server):
    assert server.server_address[0] == "127.0.0.1" and len(server.token) >= 40
    assert server.address == f"http://127.0.0.1:{server.server_address[1]}/{server.token}/"
    with served.Server(server.pages) as other:
        assert other.token != server.token
    with pytest.raises(OSError, match="in use"):
        served.Server(server.pages, server.server_address[1])


def test_a_tunnel_may_have_another_port(server):
    for host in ("localhost:9000", "127.0.0.1:9000"):
        given = {"Host": host, "Origin": f"http://{host}"}
        assert send(server, "GET", f"/{server.token}/file", **given)[0] == 200
    assert send(server, "GET", f"/{server.token}/file", Host="localhost:9000", Origin="http://localhost:9001")[0] == 403


def test_a_page_may_run_nothing_but_our_own_scripts(server):
    status, told, body = send(server, "GET", f"/{server.token}/")
    assert status == 200 and told["Content-Type"].startswith("text/html")
    rules = dict(rule.strip().split(" ", 1) for rule in told["Content-Security-Policy"].split(";"))
    assert rules["default-src"] == "'none'" and rules["script-src"] == rules["connect-src"] == "'self'"
    assert told["Referrer-Policy"] == "no-referrer" and told["X-Content-Type-Options"] == "nosniff"
    for name in body.decode().split('"'):
        if name.endswith((".js", ".css")):
            assert send(server, "GET", f"/{server.token}/{name}")[0] == 200
    assert b"http" not in body and b"style=" not in body and b"onclick" not in body


def test_a_defect_of_the_program_is_told_and_logged(server, case, monkeypatch, caplog):
    """The line was cut, and the page said that the program had ended."""

    def broken(*_):
        raise ZeroDivisionError("a secret of the program")

    monkeypatch.setattr("lammps_jump.served.pages.number_of", broken)
    status, _, data = send(server, "POST", f"/{server.token}/look", {"text": CASE, "wide": 700})
    assert status == 500 and "defect of lammps-jump" in json.loads(data)["refused"]
    assert "ZeroDivisionError" in caplog.text and "in broken" in caplog.text and server.token not in caplog.text
    assert asked(server, "file")["text"] == CASE


def test_a_ticket_leads_a_browser_here_once(server):
    """From a file, which is another site: to a page that leads on, and only while it has not."""
    used = []
    place = re.search(r"url=http://127\.0\.0\.1:\d+(/[\w-]+/)", server.ticket(lambda: used.append(1)))[1]
    for path in (f"{place}file", f"{place}run/0/state"):
        assert send(server, "GET", path, Sec_Fetch_Site="cross-site")[0] == 403
    assert send(server, "POST", place, {}, Sec_Fetch_Site="cross-site")[0] == 403 and not used
    status, told, body = send(server, "GET", place, Sec_Fetch_Site="cross-site")
    assert status == 200 and f'url=/{server.token}/"'.encode() in body and used == [1]
    assert told["Content-Security-Policy"].startswith("default-src 'none'") and told["Cache-Control"] == "no-store"
    assert send(server, "GET", place)[0] == 403 and used == [1]


def test_port_80_is_left_out_by_browsers(server):
    given = {"Host": "127.0.0.1", "Origin": "http://127.0.0.1"}
    assert send(server, "GET", f"/{server.token}/file", **given)[0] == 200
    for host in ("127.0.0.1:", "127.0.0.1:x", "127.0.0.1:80:80", "evil.example", "127.0.0.1.evil.example", "[::1]"):
        assert send(server, "GET", f"/{server.token}/file", Host=host, Origin=f"http://{host}")[0] == 421


def was_cut(line):
    """Wait for the end of a connection, which brings nothing."""
    try:
        return line.recv(10) == b""
    except ConnectionResetError:
        return True


@pytest.mark.fault("requests to a page")
def test_half_a_request_holds_nobody_up(server):
    """As many as one likes: the oldest that has not shown the token gives way."""
    lines = []
    for _ in range(3 * MOST_UNKNOWN):
        lines.append(socket.create_connection(server.server_address))
        lines[-1].sendall(b"GET / HTTP/1.1\r\nX: ")
    assert asked(server, "file")["text"] == CASE
    assert was_cut(lines[0]) and len(server._unknown) <= MOST_UNKNOWN
    for line in lines:
        line.close()


@pytest.mark.fault("requests to a page")
def test_too_many_requests_at_once_are_told_so(server, monkeypatch):
    monkeypatch.setattr("lammps_jump.served.server.MOST_KNOWN", 0)
    status, _, data = send(server, "GET", f"/{server.token}/file")
    assert status == 503 and "requests are answered at once; close other pages" in json.loads(data)["refused"]


@pytest.mark.fault("requests to a page")
def test_a_request_that_never_comes_whole_is_told_so(server, monkeypatch):
    monkeypatch.setattr("lammps_jump.served.server.BODY_SECONDS", 0.0)
    status, _, data = send(server, "POST", f"/{server.token}/look", b"{", Content_Length="9")
    assert status == 408 and "the request was not there within 0 s" in json.loads(data)["refused"]
    monkeypatch.setattr("lammps_jump.served.server.HEAD_SECONDS", 0.0)
    with socket.create_connection(server.server_address) as line:
        assert was_cut(line)


def test_errors_stand_at_their_lines(server):
    def error(old, new):
        found = asked(server, "look", {"text": CASE.replace(old, new), "wide": 700})
        return found["error"]["line"], found["error"]["text"]

    assert error("restitution: 0.5", "restitution: 7")[0] == 4
    line, text = error("kind: block", "kind: blok")
    assert line == 8 and "did you mean 'block'?" in text and "case.yaml" not in text
    assert error("[4, 4.5]", "[4, 4.5")[0] in (8, 9)
    assert error(CASE, "")[0] is None


def test_more_discs_than_a_page_draws_are_counted_alone(server):
    """A diameter that is half typed: the case is not laid out, and the page answers."""
    found = asked(server, "look", {"text": CASE.replace("20 cm", "0.0003"), "wide": 700})
    assert "11108889 discs at the start; this page draws up to 1000000" in found["error"]["text"]
    assert found["error"]["line"] is None


def test_a_look_that_takes_too_long_is_left(server, monkeypatch):
    monkeypatch.setattr("lammps_jump.served.pages.LOOK_SECONDS", 0.0)
    status, _, data = send(server, "POST", f"/{server.token}/look", {"text": CASE, "wide": 700})
    assert status == 422 and "this took longer than 0 s and was left; `lammps-jump check" in json.loads(data)["refused"]


def test_what_a_text_means(server, case):
    found = asked(server, "look", {"text": CASE, "wide": 700})
    assert found["name"] == "small" and found["drawing"].startswith("<svg ")
    assert "time" in [title for title, _ in found["derived"]]
    assert abs(found["view"]["scale"] * (found["view"]["x"][1] - found["view"]["x"][0]) - (700 - 46 - 12)) < 1
    assert case.read_text() == CASE and [one.name for one in case.parent.iterdir()] == ["case.yaml"]


def test_saving_takes_the_place_of_the_text_that_was_shown_alone(server, case):
    case.chmod(0o640)
    first = asked(server, "file")
    saved = asked(server, "save", {"text": CASE + "# one\n", "key": first["key"]})
    assert case.read_text() == CASE + "# one\n" and case.stat().st_mode & 0o777 == 0o640
    assert asked(server, f"file?key={saved['key']}")["text"] is None
    case.write_text(CASE + "# by another program\n")
    status, _, data = send(server, "POST", f"/{server.token}/save", {"text": CASE + "# two\n", "key": saved["key"]})
    assert status == 409 and json.loads(data)["text"] == CASE + "# by another program\n"
    assert case.read_text() == CASE + "# by another program\n"
    again = asked(server, "save", {"text": CASE + "# two\n", "key": json.loads(data)["key"]})  # as one has decided
    assert case.read_text() == CASE + "# two\n" and again["key"]
    assert [one.name for one in case.parent.iterdir()] == ["case.yaml"]


DRAWN = {
    "bed.csv": b"chainage [m],level [m]\n2,3\n3,2.5\n5,2.4\n",
    "pier.svg": b'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9"><path id="pier" d="M0 0 200 100"/></svg>',
    "photo.svg": b"\x89PNG",
    "notes.docx": b"PK",
}


def drop(server, name, text=CASE, scale=""):
    """Status and answer for a drawing that a page sends."""
    sent = {"text": text, "name": name, "data": base64.b64encode(DRAWN[name]).decode(), "scale": scale}
    status, _, data = send(server, "POST", f"/{server.token}/drawing", sent)
    return status, json.loads(data)


def test_a_drawing_becomes_walls_of_the_text(server, case):
    status, found = drop(server, "bed.csv")
    assert status == 200, found
    rows = found["text"].splitlines()
    kept = [row for row in rows if row in CASE.splitlines()]
    assert kept == CASE.splitlines() and len(rows) > len(kept)  # comments and all
    assert "name: bed" in found["text"] and any(one.startswith("bed: ") for one in found["added"])
    assert found["command"] == f"lammps-jump import bed.csv --into {case}"
    looked = asked(server, "look", {"text": found["text"], "wide": 700})
    assert looked.get("name") == "small", looked
    assert case.read_text() == CASE and [one.name for one in case.parent.iterdir()] == ["case.yaml"]


def test_a_drawing_without_a_unit_is_asked_for_it(server):
    status, found = drop(server, "pier.svg")
    assert status == 422 and found["scale"] is True
    assert "In metres it is 200 m wide" in found["refused"] and "in millimetres 0.2 m" in found["refused"]
    status, found = drop(server, "pier.svg", scale="furlong parsec")
    assert status == 422 and found["scale"] is True and "--scale furlong parsec" in found["refused"]
    status, found = drop(server, "pier.svg", scale=" cm ")
    assert status == 200 and "2, " in found["text"] and "--scale cm --into" in found["command"]


def test_what_is_no_drawing_is_refused_in_a_sentence(server, case, monkeypatch):
    for name, text, told in [
        ("photo.svg", CASE, "photo.svg"),
        ("notes.docx", CASE, "drawings that are read end in .dxf"),
        ("bed.csv", CASE.replace("kind: block", "kind: blok"), "did you mean 'block'?"),
        ("bed.csv", CASE.replace("floor", "bed"), "there is a wall 'bed' already"),
    ]:
        status, found = drop(server, name, text)
        assert status == 422 and told in found["refused"] and "scale" not in found
    monkeypatch.setattr(look, "MOST_DRAWN", 10)
    with pytest.raises(CaseError, match=r"the page takes up to 1e-05 MB, and `lammps-jump import bed.csv --into"):
        look.with_drawing(CASE, case, look.DroppedFile("bed.csv", DRAWN["bed.csv"], None))


def test_a_case_of_several_starts_tells_why_it_has_no_button(server, case):
    case.write_text(CASE.replace("run: {", "run: {members: 3, "))
    found = asked(server, "file")
    assert found["run"]["why"].startswith("run.members") and found["run"]["command"].startswith(
        "lammps-jump build-and-run"
    )
    status, _, data = send(server, "POST", f"/{server.token}/run", {"key": found["key"]})
    assert status == 422 and "run.members" in json.loads(data)["refused"]


def test_ends_of_lines_stay_as_they_are(tmp_path):
    path = tmp_path / "case.yaml"
    path.write_bytes(CASE.replace("\n", "\r\n").encode())
    with serving(path) as server:
        found = asked(server, "file")
        assert found["text"] == CASE
        asked(server, "save", {"text": CASE + "# end\n", "key": found["key"]})
    assert path.read_bytes() == (CASE + "# end\n").replace("\n", "\r\n").encode()


@pytest.mark.fault("other programs that write the same file")
def test_what_is_written_in_the_moment_of_saving_is_not_taken_for_the_page_s(server, case, monkeypatch):
    """The page gets the key of its own text: what another program adds right behind it is seen at the next save."""
    real = pages.change_text

    def interrupted(path, before, after):
        done = real(path, before, after)
        with path.open("a") as file:
            file.write("# by another program\n")
        return done

    monkeypatch.setattr(pages, "change_text", interrupted)
    key = asked(server, "file")["key"]
    saved = asked(server, "save", {"text": CASE + "# one\n", "key": key})
    status, _, data = send(server, "POST", f"/{server.token}/save", {"text": CASE + "# two\n", "key": saved["key"]})
    assert status == 409 and json.loads(data)["text"] == CASE + "# one\n# by another program\n"


def test_a_link_is_followed_once(tmp_path):
    real = tmp_path / "real" / "case.yaml"
    real.parent.mkdir()
    real.write_text(CASE)
    (tmp_path / "shown.yaml").symlink_to(real)
    with serving(tmp_path / "shown.yaml") as server:
        key = asked(server, "file")["key"]
        (tmp_path / "shown.yaml").unlink()
        (tmp_path / "shown.yaml").symlink_to("/etc/hostname")
        key = asked(server, "save", {"text": CASE + "# one\n", "key": key})["key"]
        assert real.read_text() == CASE + "# one\n"
        real.rename(tmp_path / "moved")
        real.symlink_to(tmp_path / "moved")
        status, _, data = send(server, "POST", f"/{server.token}/save", {"text": CASE, "key": key})
        assert status == 422 and "cannot be written" in json.loads(data)["refused"]
    assert (tmp_path / "moved").read_text() == CASE + "# one\n"


def test_a_file_that_is_gone_or_locked_is_spoken_of(server, case):
    key = asked(server, "file")["key"]
    case.unlink()
    status, _, data = send(server, "POST", f"/{server.token}/save", {"text": CASE, "key": key})
    assert status == 422 and "no such case file" in json.loads(data)["refused"]
    assert not case.exists()
    case.write_text(CASE)
    case.chmod(0o444)
    status, _, data = send(server, "POST", f"/{server.token}/save", {"text": CASE + "# one\n", "key": key})
    assert status == 422 and "it is read-only" in json.loads(data)["refused"] and case.read_text() == CASE


def test_no_page_of_what_is_no_case(tmp_path):
    with pytest.raises(CaseError, match="no such case file"):
        served.pages_of(tmp_path / "absent.yaml")
    (tmp_path / "a.yaml").symlink_to("/dev/zero")
    with pytest.raises(CaseError, match="cannot be read"):
        served.pages_of(tmp_path / "a.yaml")
    (tmp_path / "circle.yaml").symlink_to("circle.yaml")
    with pytest.raises(CaseError, match="cannot be read"):
        served.pages_of(tmp_path / "circle.yaml")


WORDS = (
    *("", "file", "look", "save", "run", "drawing", "run/0/", "run/0/state", "run/0/frames", "run/0/report", "ask.js"),
    *(
        "run/0/stop",
        "run/0/go-on",
        "state",
        "..",
        "%2e%2e",
        "//",
        "\x00",
        "\u0416",
        "?first=0",
        "?" + 300 * "&",
        9000 * "a",
    ),
)
VALUES = (
    *(None, True, -1, 0, 1e400, float("nan"), 10**400, "", CASE, "\x00", "\ud800", 5000 * "["),
    *([], {}, [[]], "A===", "aGk="),
)
"""What stands in the fields of a request."""
ANSWERS = {200, 303, 400, 403, 404, 409, 413, 414, 415, 421, 422, 501}
FIELDS = ("text", "wide", "page", "key", "name", "scale", "data", "first")
HEADERS = {
    "Host": ("127.0.0.1:{port}", "localhost:{port}", "127.0.0.1", "evil.example", "", None),
    "Origin": ("http://127.0.0.1:{port}", "null", "http://evil.example", None),
    "Content_Type": ("application/json", "text/plain", "application/json; charset=utf-16", None),
    "Content_Length": ("{length}", "0", "5", "-1", "1e3", "\u0663", "00000000000000000000000000001", None),
    "Sec_Fetch_Site": ("same-origin", "cross-site", None),
    "Transfer_Encoding": (None, None, "chunked"),
}


def made_request(random, server):
    """A request of parts that are right or wrong."""
    token = random.choice([server.token] * 8 + ["", server.token[:-1], server.token + "/", server.token.upper()])
    method = random.choice(["GET", "POST", "GET", "POST", "PUT", "HEAD", "OPTIONS", "get", "GET /x"])
    fields = {name: random.choice(VALUES) for name in random.sample(FIELDS, random.randint(0, len(FIELDS)))}
    body = json.dumps(fields).encode() if random.random() < 0.9 else random.randbytes(random.randint(0, 99))
    if "NaN" in body.decode(errors="replace") and random.random() < 0.5:
        body = body[: len(body) // 2]
    given = {name: random.choice(values) for name, values in HEADERS.items()}
    port = server.server_address[1]
    lines = [f"{method} /{token}/{random.choice(WORDS)}{random.choice(WORDS)} HTTP/1.1"]
    lines += [
        f"{name.replace('_', '-')}: {value.format(port=port, length=len(body))}"
        for name, value in given.items()
        if value is not None
    ]
    return "\r\n".join([*lines, "", ""]).encode("utf-8", "surrogatepass") + (body if method != "GET" else b"")


@pytest.mark.fault("requests to a page")
def test_requests_of_any_kind_are_answered_and_nothing_is_written(server, case, tried, monkeypatch, capfd):
    """What is sent is cut off there, so that half a body ends; no answer is without a status, and none is a defect."""
    monkeypatch.setattr("lammps_jump.served.children.Bounded.run", lambda self, work: work.call())
    monkeypatch.setattr("lammps_jump.served.children.Children.start", lambda *_: pytest.fail("a run begins"))
    random, number, before = Random(7), many(150, 3000), {one: one.read_bytes() for one in case.parent.iterdir()}
    for _ in range(number):
        sent = made_request(random, server)
        with socket.create_connection(server.server_address, timeout=600) as line:
            line.sendall(sent)
            line.shutdown(socket.SHUT_WR)
            reply = b"".join(iter(partial(line.recv, 1 << 16), b""))
        status = reply.partition(b"\r\n")[0].split(b" ")[1:2]
        assert status and int(status[0]) in ANSWERS, sent
        assert b"Content-Security-Policy: default-src 'none'" in reply, sent
        assert server.token.encode() not in reply
    assert {one: one.read_bytes() for one in case.parent.iterdir()} == before and asked(server, "file")["text"] == CASE
    assert "Traceback" not in capfd.readouterr().err
    tried(number)
