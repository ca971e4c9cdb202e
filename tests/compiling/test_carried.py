# SPDX-License-Identifier: GPL-2.0-or-later
"""Libraries that the package carries for machines without a compiler: which one fits, and what happens where none does.

The built plugin of this machine stands for a carried one; its record is written here.
"""

import hashlib
import json
import shutil

import pytest

from lammps_jump.compiling import availability as availability_of
from lammps_jump.compiling import build, carried, library_path
from lammps_jump.compiling.cache import RECORD, cache_folder
from lammps_jump.core import CORE
from lammps_jump.engines.plugin import PLUGIN, availability, plugin_path
from lammps_jump.errors import SetupError


@pytest.fixture
def carry(plugin, tmp_path, monkeypatch):
    """A function that puts a library for some levels into the package; changes of its record by name."""
    monkeypatch.setenv("LAMMPS_JUMP_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("CXX", "no-such-compiler")
    for module in (build, carried):
        monkeypatch.setattr(module, "carried_folder", lambda _: tmp_path / "carried")
    monkeypatch.setattr(carried, "processor_flags", lambda: carried.LEVELS["x86-64-v4"])

    def put(*levels, code=None, **changes):
        for level in levels:
            library = tmp_path / "carried" / level / PLUGIN.library
            library.parent.mkdir(parents=True)
            if code is None:
                shutil.copyfile(plugin, library)
            else:
                library.write_bytes(code)
            record = {**carried.needs(PLUGIN), "sha256": hashlib.sha256(library.read_bytes()).hexdigest(), **changes}
            library.with_name(RECORD).write_text(json.dumps(record))

    return put


@pytest.mark.lammps
def test_a_carried_library_is_tried_once_and_kept_without_a_compiler(carry, plugin, monkeypatch):
    carry("x86-64-v3", "x86-64-v4")
    assert "built for x86-64-v4: will be tried" in availability().reason
    path = plugin_path()
    assert path.read_bytes() == plugin.read_bytes() and path.is_relative_to(cache_folder())
    monkeypatch.setattr(build, "check_loads", pytest.fail)
    assert plugin_path() == path == availability().path


def test_a_carried_core_serves_without_a_compiler(compiled_core, tmp_path, monkeypatch):
    code = library_path(CORE).read_bytes()
    place = tmp_path / "carried" / "x86-64" / CORE.library
    place.parent.mkdir(parents=True)
    place.write_bytes(code)
    record = {**carried.needs(CORE), "sha256": hashlib.sha256(code).hexdigest()}
    assert set(record) == {"system", "machine", "sources", "sha256"}  # it depends on no wheel
    place.with_name(RECORD).write_text(json.dumps(record))
    for module in (build, carried):
        monkeypatch.setattr(module, "carried_folder", lambda _: tmp_path / "carried")
    monkeypatch.setenv("LAMMPS_JUMP_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("CXX", "no-such-compiler")
    path = library_path(CORE)
    assert path.read_bytes() == code and path.is_relative_to(cache_folder())
    assert availability_of(CORE).path == path


@pytest.mark.lammps
def test_the_level_is_that_of_the_processor(carry, monkeypatch):
    carry("x86-64-v3", "x86-64-v4")
    monkeypatch.setattr(carried, "processor_flags", lambda: carried.LEVELS["x86-64-v3"])
    assert carried.fitting(PLUGIN)[0].level == "x86-64-v3"
    monkeypatch.setattr(carried, "processor_flags", lambda: frozenset({"sse2"}))
    assert carried.fitting(PLUGIN)[0] is None
    with pytest.raises(SetupError, match="no-such-compiler is not found"):
        plugin_path()
    assert "need a processor of level x86-64-v3" in availability().reason


@pytest.mark.lammps
@pytest.mark.parametrize("name", ["lammps", "mpich", "system", "machine", "sources"])
def test_a_library_for_other_versions_is_not_taken(carry, name):
    carry("x86-64-v4", **{name: "2019.1"})
    assert carried.fitting(PLUGIN)[0] is None
    assert f"built for another {name} 2019.1" in availability().reason


@pytest.mark.lammps
@pytest.mark.fault("surroundings")
@pytest.mark.parametrize("damage", ["library", "record", "no record"])
def test_a_damaged_carried_library_is_not_taken(carry, damage, tmp_path):
    carry("x86-64-v4")
    library = tmp_path / "carried" / "x86-64-v4" / PLUGIN.library
    if damage == "library":
        library.write_bytes(library.read_bytes()[:-1])
    elif damage == "record":
        library.with_name(RECORD).write_text("[1, 2")
    else:
        library.with_name(RECORD).unlink()
    assert "is damaged; reinstall lammps-jump" in availability().reason


@pytest.mark.lammps
@pytest.mark.fault("surroundings")
def test_a_library_that_does_not_load_is_tried_once(carry, monkeypatch):
    carry("x86-64-v4", code=b"\x7fELF lammpsplugin_init, for another system")
    with pytest.raises(SetupError, match="no-such-compiler is not found"):
        plugin_path()
    monkeypatch.setattr(build, "check_loads", pytest.fail)
    status = availability()
    assert not status.available and "does not load here" in status.reason
    with pytest.raises(SetupError, match="no-such-compiler is not found"):
        plugin_path()


@pytest.mark.lammps
def test_what_others_may_change_is_not_loaded(carry):
    carry("x86-64-v4")
    plugin_path().chmod(0o777)
    assert "others may change it" in availability().reason
    with pytest.raises(SetupError, match="no-such-compiler is not found"):
        plugin_path()
