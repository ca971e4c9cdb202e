# SPDX-License-Identifier: GPL-2.0-or-later
"""The library of the core: loaded once, with the interface that Python knows, or absent with the reason."""

import ctypes

import numpy as np
import pytest

from lammps_jump.core import CORE, core, library, require_core, why_absent
from lammps_jump.errors import SetupError


@pytest.fixture
def not_loaded(monkeypatch):
    """As before the first use."""
    library._loaded.cache_clear()
    yield monkeypatch
    library._loaded.cache_clear()


@pytest.fixture
def no_core(not_loaded, tmp_path):
    """A machine without a compiler, and without a library."""
    not_loaded.setenv("CXX", "no-such-compiler")
    not_loaded.setenv("LAMMPS_JUMP_CACHE", str(tmp_path))
    return not_loaded


def test_without_a_compiler_there_is_no_core_and_a_sentence_says_why(no_core):
    assert core() is None and "no-such-compiler is not found" in why_absent()
    with pytest.raises(SetupError, match=r"^the native engine needs a C\+\+ compiler, or a wheel of lammps-jump"):
        require_core("the native engine")


def test_the_core_has_the_interface_that_python_knows(compiled_core):
    assert core()._name == compiled_core._name and why_absent() == ""
    assert library.function("jump_core_version", result=library.INTEGER)() == library.VERSION


def test_another_version_of_the_interface_is_not_taken(compiled_core, not_loaded):
    not_loaded.setattr(library, "VERSION", library.VERSION + 1)
    assert core() is None and "version" in why_absent()


def test_a_struct_of_another_size_is_refused():
    class jump_made_up(library.Struct):
        _fields_ = (("a", ctypes.c_int64), ("b", ctypes.c_double))

    class Library:
        def __init__(self, size):
            self.jump_made_up_size = lambda: size

    jump_made_up.check(Library(16))
    with pytest.raises(SetupError, match="jump_made_up has 24 bytes in the core, 16 in Python"):
        jump_made_up.check(Library(24))


def test_arrays_of_another_kind_are_refused():
    for kind, right in ((library.REALS, "f8"), (library.INTEGERS, "i8"), (library.SHORTS, "i4"), (library.BYTES, "u1")):
        kind.from_param(np.zeros(4, right))
        with pytest.raises(TypeError):
            kind.from_param(np.zeros(4, "f4"))
        with pytest.raises(TypeError):
            kind.from_param(np.zeros(4, right)[::2])


def test_its_sources_include_nothing_of_lammps_or_python():
    for path in (*CORE.folder.rglob("*.cpp"), *CORE.folder.rglob("*.h")):
        text = path.read_text()
        assert "lammps.h" not in text and "Python.h" not in text and "mpi.h" not in text, path.name


def test_an_entry_takes_the_fields_of_its_struct_alone(compiled_core):
    fields = {"n": library.INTEGER, "x": library.REALS, "y": library.REALS, "radius": library.REALS}
    fields |= {"joined": library.BYTES, "low": library.REAL, "spacing": library.REAL, "lines": library.INTEGER}
    x, top = np.array([0.5, 1.5]), np.empty(2, np.int64)
    given = {"n": 2, "x": x, "y": 0 * x, "radius": 0.5 + 0 * x, "joined": np.ones(2, np.uint8)}
    given |= {"low": 0.0, "spacing": 1.0, "lines": 2, "top": top}
    top_discs = library.entry("jump_top_discs", **fields, top=library.INTEGERS)
    top_discs(**given)
    assert top.tolist() == [0, 1]
    with pytest.raises(TypeError, match="jump_top_discs takes n, x, y"):
        top_discs(**{**given, "more": 1})
    with pytest.raises(TypeError):
        top_discs(**{**given, "top": top.astype(np.int32)})
    renamed = library.entry("jump_top_discs", **fields, bottom=library.INTEGERS)
    with pytest.raises(SetupError, match="jump_top_discs_input has other fields in the core"):
        renamed(**{key: value for key, value in given.items() if key != "top"}, bottom=top)
