# SPDX-License-Identifier: GPL-2.0-or-later
"""The command `open`: what it shows to other users of the machine, and what it says at its end."""

import os
import re
import stat
import tempfile
import webbrowser
from pathlib import Path
from urllib.parse import unquote

import pytest
from made_up import INPUTS, call

import lammps_jump.served as served


@pytest.fixture
def case(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "case.yaml"
    path.write_text((INPUTS / "dam_break.yaml").read_text())
    return path


@pytest.fixture
def opened(monkeypatch):
    """The browser that is opened: addresses that it gets. The server ends at once."""
    addresses = []

    def end(self):
        raise KeyboardInterrupt

    monkeypatch.setattr(webbrowser, "open", addresses.append)
    monkeypatch.setattr(served.Server, "serve_forever", end)
    monkeypatch.setenv("DISPLAY", ":99")
    return addresses


@pytest.mark.parametrize("shared", [False, True], ids=["own folder", "folder of a group"])
def test_the_browser_is_led_by_a_file_of_this_user_alone(case, monkeypatch, capsys, opened, tmp_path, shared):
    """Other users see the command line of a browser, and what others may write in is no place for the file."""
    seen = []
    (tmp_path / "temporary").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))
    case.parent.chmod(0o775 if shared else 0o755)

    def look(address):
        path = Path(unquote(address.removeprefix("file://")))
        seen.append((path, stat.S_IMODE(path.stat().st_mode), path.read_text()))

    monkeypatch.setattr(webbrowser, "open", look)
    status, out, _ = call(monkeypatch, capsys, "open", case)
    ((path, mode, text),) = seen
    token = re.search(r"http://127\.0\.0\.1:\d+/([\w-]{40,})/", out)[1]
    assert status == 0 and mode == 0o600 and token not in text and token not in str(path)
    assert path.parent == (tmp_path / "temporary" if shared else tmp_path) and not path.exists()
    assert re.search(r'content="0; url=http://127\.0\.0\.1:\d+/[\w-]{40,}/"', text)


def test_where_no_file_can_be_made_the_address_is_printed(case, monkeypatch, capsys, opened):
    def refuse(*_):
        raise PermissionError(13, os.strerror(13))

    monkeypatch.setattr("lammps_jump.files.private_file", refuse)
    status, out, _ = call(monkeypatch, capsys, "open", case)
    assert status == 0 and out.startswith("http://127.0.0.1:") and opened == []


def test_no_file_without_a_display(case, monkeypatch, capsys, opened):
    monkeypatch.delenv("DISPLAY")
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    assert call(monkeypatch, capsys, "open", case)[0] == 0 and opened == []
