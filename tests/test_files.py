# SPDX-License-Identifier: GPL-2.0-or-later
"""A file of the user that is changed: what stays of it, and what other programs write at the same moment."""

import errno
import os
import stat

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lammps_jump import files, system
from lammps_jump.files import change_text, with_ends_of

OTHERS = "other programs that write the same file"
BEFORE, AFTER = "name: a\nrun: 1\n", "name: a\nwalls: 2\nrun: 1\n"


@pytest.fixture
def case(tmp_path):
    path = tmp_path / "mine" / "case.yaml"
    path.parent.mkdir()
    path.write_text(BEFORE)
    return path


def alone(path):
    """Nothing else is left in the folder of a file."""
    return [one.name for one in path.parent.iterdir()] == [path.name]


def attributes(path):
    found = path.stat()
    return (
        stat.S_IMODE(found.st_mode),
        found.st_uid,
        found.st_gid,
        {n: os.getxattr(path, n) for n in os.listxattr(path)},
    )


def no_room(code):
    def make(*_, **__):
        raise OSError(code, os.strerror(code))

    return make


WAYS = {
    "a new file in its place": lambda patch: None,
    "no exchange here": lambda patch: patch.setattr(system.ctypes, "CDLL", lambda *_, **__: object()),
    "no file can be made beside it": lambda patch: patch.setattr(files, "_make", no_room(errno.EACCES)),
    "it is a mount of its own": lambda patch: patch.setattr(files, "_exchange", no_room(errno.EBUSY)),
    "the owner cannot be kept": lambda patch: patch.setattr(files, "_give_attributes", no_room(errno.EPERM)),
}


@pytest.mark.parametrize("mode", [0o600, 0o644, 0o664, 0o755])
@pytest.mark.parametrize("way", WAYS)
def test_mode_owner_and_attributes_stay(case, monkeypatch, way, mode):
    case.chmod(mode)
    if os.geteuid() == 0:
        os.chown(case, 4321, 4322)
    try:
        os.setxattr(case, "user.origin", b"survey")
    except OSError as error:
        assert error.errno == errno.ENOTSUP
    before = attributes(case)
    WAYS[way](monkeypatch)
    assert change_text(case, BEFORE, AFTER) == AFTER == case.read_text()
    assert attributes(case) == before and alone(case)


@pytest.mark.parametrize("hard", [False, True])
def test_the_longest_name_leaves_no_room_for_a_file_beside_it(case, tmp_path, hard):
    longest = case.rename(case.with_name("n" * 255))
    if hard:
        os.link(longest, tmp_path / "other")
    assert change_text(longest, BEFORE, AFTER) == AFTER == longest.read_text() and alone(longest)


def test_hard_links_stay(case, tmp_path):
    os.link(case, tmp_path / "other")
    assert change_text(case, BEFORE, AFTER) == AFTER
    assert case.samefile(tmp_path / "other") and (tmp_path / "other").read_text() == AFTER and alone(case)


@pytest.mark.parametrize("mode", [0o444, 0o400, 0o555])
def test_a_file_that_is_read_only_stays(case, mode):
    case.chmod(mode)
    with pytest.raises(PermissionError, match="read-only"):
        change_text(case, BEFORE, AFTER)
    assert case.read_text() == BEFORE and alone(case)


def test_a_link_or_pipe_that_stands_there_by_now_is_left(case, tmp_path):
    case.rename(tmp_path / "real")
    case.symlink_to(tmp_path / "real")
    with pytest.raises(OSError, match="symbolic links"):
        change_text(case, BEFORE, AFTER)
    case.unlink()
    os.mkfifo(case)
    with pytest.raises(OSError, match="no regular file"):
        change_text(case, BEFORE, AFTER)
    assert (tmp_path / "real").read_text() == BEFORE


def append(path):
    with path.open("a") as file:
        file.write("# mine\n")


def replace(path):
    path.with_name("new").write_text("# mine\n")
    path.with_name("new").rename(path)


MEANWHILE = {"lines are added": append, "all of it is written": lambda p: p.write_text("# mine\n"), "replaced": replace}


@pytest.mark.fault(OTHERS)
@pytest.mark.parametrize("hard", [False, True])
@pytest.mark.parametrize("other", MEANWHILE)
@pytest.mark.parametrize("moment", ["_make", "_exchange", "lent"])
def test_what_is_written_just_before_stays(case, tmp_path, monkeypatch, moment, other, hard):
    """Another program writes at one moment or another; its text stands there, and ours is not called written."""
    if hard:
        os.link(case, tmp_path / "other")
    real, acts = getattr(files, moment), [MEANWHILE[other]]

    def interrupted(*given, **options):
        if acts:
            acts.pop()(case)
        return real(*given, **options)

    monkeypatch.setattr(files, moment, interrupted)
    found = change_text(case, BEFORE, AFTER)
    if hard and moment == "_exchange":  # it is written in its place
        assert found == AFTER and acts
        return
    assert found is None and not acts
    assert case.read_text() == (BEFORE if other == "lines are added" else "") + "# mine\n" and alone(case)


@pytest.mark.fault(OTHERS)
def test_what_is_written_in_the_moment_of_the_exchange_stays(case, monkeypatch):
    """A program has opened the old file, and writes after the new one has taken its place; another adds to that."""
    real, times = files._exchange, []

    def exchange(first, second):
        with case.open("a") as late:
            done = real(first, second)
            if not times:
                times.append(1)
                late.write("# late\n")
                append(case)
        return done

    monkeypatch.setattr(files, "_exchange", exchange)
    assert change_text(case, BEFORE, AFTER) is None
    assert case.read_text() == BEFORE + "# late\n# mine\n" and alone(case)


@pytest.mark.fault(OTHERS)
def test_two_texts_of_others_at_once_are_both_kept(case, monkeypatch):
    real, acts = files._exchange, [lambda: append(case), lambda: case.write_text("# whole\n")]

    def exchange(first, second):
        acts.pop(0)()
        return real(first, second)

    monkeypatch.setattr(files, "_exchange", exchange)
    with pytest.raises(OSError, match=r"the text of one of them is in .*\.new"):
        change_text(case, BEFORE, AFTER)
    assert sorted(one.read_text() for one in case.parent.iterdir()) == ["# whole\n", BEFORE + "# mine\n"]


@pytest.mark.fault(OTHERS)
def test_a_file_that_a_program_holds_open_is_written_in_its_place(case):
    with case.open("a") as held:
        assert change_text(case, BEFORE, AFTER) == AFTER
        held.write("# held\n")
    assert case.read_text() == AFTER + "# held\n" and alone(case)


@pytest.mark.fault(OTHERS)
def test_a_program_that_keeps_writing_is_waited_for_and_left(case, monkeypatch):
    monkeypatch.setattr(files, "WRITER_PATIENCE", 0.0)
    real, held = files._exchange, []

    def exchange(first, second):
        held.append(case.open("a"))
        return real(first, second)

    monkeypatch.setattr(files, "_exchange", exchange)
    with pytest.raises(OSError, match="other programs write it at once"):
        change_text(case, BEFORE, AFTER)
    for one in held:
        one.close()
    assert case.read_text() == BEFORE


@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EIO])
def test_a_disk_that_is_full_leaves_the_text_before(case, tmp_path, monkeypatch, code):
    os.link(case, tmp_path / "other")
    real, calls = os.pwrite, []

    def pwrite(place, data, at):
        calls.append(at)
        if len(calls) == 2:
            raise OSError(code, os.strerror(code))
        return real(place, data[:5], at)

    monkeypatch.setattr(os, "pwrite", pwrite)
    with pytest.raises(OSError, match=os.strerror(code)):
        change_text(case, BEFORE, AFTER)
    assert case.read_text() == BEFORE and alone(case)


@pytest.mark.parametrize(
    ("before", "after", "wanted"),
    [
        ("a\r\nb\r\n", "a\nx\nb\n", "a\r\nx\r\nb\r\n"),
        ("a\nb\r\nc\r\nd\n", "a\nb\nc\nd\n", "a\nb\r\nc\r\nd\n"),
        ("a\nb\r\nc\r\nd\n", "a\nb\nnew\nc\nd\n", "a\nb\r\nnew\r\nc\r\nd\n"),
        ("a\nb\r\nc\n", "new\na\nb\nc\nend\n", "new\na\nb\r\nc\nend\n"),
        ("a\rb\r", "a\nb\nc\n", "a\rb\rc\r"),
        ("a\r\nb", "a\nb\nc\n", "a\r\nb\r\nc\r\n"),
        ("a\n", "", ""),
        ("", "a\nb", "a\nb"),
        ("a", "b\nc\n", "b\nc\n"),
    ],
)
def test_ends_of_lines_stay_line_by_line(before, after, wanted):
    assert with_ends_of(before, after) == wanted


@given(st.lists(st.tuples(st.sampled_from("abc"), st.sampled_from(["\n", "\r\n", "\r"]))), st.integers(0, 9))
def test_a_line_that_is_added_changes_no_other(lines, place):
    before = "".join(map("".join, lines)).replace("\r\n\n", "\r\n")
    assert with_ends_of(before, files.END_OF_LINE.sub("\n", before)) == before
    parts = files.END_OF_LINE.sub("\n", before).split("\n")
    place = min(place, len(parts) - 1)
    added = with_ends_of(before, "\n".join([*parts[:place], "new", *parts[place:]]))
    left = files.END_OF_LINE.split(added)
    assert left[:place] + left[place + 1 :] == parts
    ends = files.END_OF_LINE.findall(added)
    assert sorted(ends[:place] + ends[place + 1 :]) == sorted(files.END_OF_LINE.findall(before))
