# SPDX-License-Identifier: GPL-2.0-or-later
"""The library of the core: found or built at its first use, loaded once, and its functions bound to Python."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.ctypeslib import ndpointer

from lammps_jump.compiling import Product, library_path
from lammps_jump.errors import SetupError

from .columns import require_columns

VERSION = 8
"""Of the interface, as in ``api.h``."""

CORE = Product(
    "jumpcore",
    "the core",
    Path(__file__).resolve().parent,
    export="jump_core_version",
    levels=("x86-64-v3", "x86-64", "armv8-a"),  # a quarter faster with AVX
    carried_flags=("-static-libstdc++", "-static-libgcc"),  # older systems lack a recent C++ library
)

INTEGER, REAL = ctypes.c_int64, ctypes.c_double
REALS, INTEGERS, SHORTS, BYTES = (ndpointer(kind, flags="C_CONTIGUOUS") for kind in ("f8", "i8", "i4", "u1"))
"""Kinds of arguments: numbers, and contiguous arrays of float64, int64, int32 and uint8; others raise a TypeError."""


class Struct(ctypes.Structure):
    """A struct of the interface; a child has the name of that in C++ and its fields in the same order."""

    @classmethod
    def check(cls, library: ctypes.CDLL) -> None:
        """SetupError where Python and C++ do not agree on the size, or on the names of fields that C++ tells."""
        there = getattr(library, f"{cls.__name__}_size")()
        if there != ctypes.sizeof(cls):
            raise SetupError(f"{cls.__name__} has {there} bytes in the core, {ctypes.sizeof(cls)} in Python")
        tell = getattr(library, f"{cls.__name__}_fields", None)
        if tell is not None:
            tell.restype = ctypes.c_char_p
            names = tell().decode().split()
            if names != [name for name, *_ in cls._fields_]:
                raise SetupError(f"{cls.__name__} has other fields in the core than in Python: {', '.join(names)}")
        for _, kind, *_ in cls._fields_:
            kind = getattr(kind, "_type_", kind)  # what a pointer leads to
            if isinstance(kind, type) and issubclass(kind, Struct):
                kind.check(library)


@lru_cache(maxsize=1)
def _loaded() -> tuple[ctypes.CDLL | None, str]:
    """The library, or None and why."""
    try:
        library = ctypes.CDLL(str(library_path(CORE)))
        version = library.jump_core_version()
        if version != VERSION:
            return None, f"the core has version {version} of its interface, and {VERSION} is needed"
        library.jump_columns.restype = ctypes.c_char_p
        require_columns(library.jump_columns().decode())
    except (SetupError, OSError, AttributeError) as error:
        return None, str(error)
    return library, ""


def core() -> ctypes.CDLL | None:
    """The library; None where it is neither carried by the package nor can be built here."""
    return _loaded()[0]


def why_absent() -> str:
    """Why there is no core, in one sentence; empty where there is."""
    return _loaded()[1]


def require_core(what: str) -> ctypes.CDLL:
    """The library.

    Raises
    ------
    SetupError
        There is none: `what` needs it.
    """
    library, reason = _loaded()
    if library is None:
        raise SetupError(f"{what} needs a C++ compiler, or a wheel of lammps-jump that carries the core: {reason}")
    return library


def copied(place: int | None, kind: type, count: int) -> np.ndarray:
    """A copy of so many numbers of a kind from an address of the core, shape (count,)."""
    if not place or not count:
        return np.empty(0, kind)
    return np.frombuffer(ctypes.string_at(place, count * np.dtype(kind).itemsize), kind).copy()


def function(name: str, *kinds: Any, result: Any = None) -> Callable[..., Any]:
    """A function of the core with the kinds of its arguments; it needs the core where it is first called.

    Parameters
    ----------
    name : str
    kinds : ctypes types
        `INTEGER`, `REAL`, `REALS` and so on.
    result : ctypes type, optional
    """

    @lru_cache(maxsize=1)
    def bound() -> Callable[..., Any]:
        bound_function = require_core(name)[name]  # each call makes an object of its own
        bound_function.argtypes, bound_function.restype = kinds, result
        for kind in kinds:
            struct = getattr(kind, "_type_", None)
            if isinstance(struct, type) and issubclass(struct, Struct):
                struct.check(require_core(name))
        return bound_function

    return lambda *arguments: bound()(*arguments)


def entry(name: str, result: Any = None, **kinds: Any) -> Callable[..., Any]:
    """A function of the core that takes one struct, called with the fields of that struct by their names.

    Parameters
    ----------
    name : str
    result : ctypes type, optional
    **kinds : ctypes types
        Fields of ``<name>_input`` in their order: as the arguments of `function`.

    Raises
    ------
    SetupError
        At the first call, where the fields of the core are others.
    TypeError
        A field is missing or unknown, or an array is not of the kind of its field.
    """
    arrays = {key for key, kind in kinds.items() if hasattr(kind, "_dtype_")}
    fields = [(key, ctypes.c_void_p if key in arrays else kind) for key, kind in kinds.items()]
    struct = type(f"{name}_input", (Struct,), {"_fields_": fields})
    call = function(name, ctypes.POINTER(struct), result=result)

    def called(**given: Any) -> Any:
        if given.keys() != kinds.keys():
            raise TypeError(f"{name} takes {', '.join(kinds)}; not the same as {', '.join(given)}")
        for key in arrays:
            kinds[key].from_param(given[key])
        return call(ctypes.byref(struct(*(given[key].ctypes.data if key in arrays else given[key] for key in kinds))))

    return called
