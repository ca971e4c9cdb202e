# SPDX-License-Identifier: GPL-2.0-or-later
"""Builds a product with the system's compiler, once, and keeps it in the cache.

A library that the package carries (`carried.py`) and that fits this machine is copied there in place of a build.

Units are compiled as many at once as there are cores. Each object is an entry of the cache by itself, named by a hash
of everything that its code depends on: the files of this project that it includes, versions of the other headers,
compiler, flags and processor. So only what changed is compiled again, and a cache on a shared home folder never hands
one machine the code of another.
"""

from __future__ import annotations

import hashlib
import json
import tempfile
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from lammps_jump.errors import SetupError
from lammps_jump.files import read_file, read_json, write_text
from lammps_jump.system import libraries_version, native_flags, plugin_flags

from .cache import MOST_BYTES, Made, cache_folder, checksum, forget_old, is_whole, kept, record_of, require_own, write
from .carried import Carried, carried_folder, check_loads, fitting, needs
from .compiler import ADVICE, Platform, processor, require_compiler, run_compiler
from .product import FLAGS, Product, add, is_code, made_for

Tell = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class Status:
    """Availability of a product on this machine.

    Attributes
    ----------
    available : bool
        It is built, or can be.
    reason : str
        One sentence: where it is, that it will be built, or what is missing and what to install.
    path : Path, or None
        The built library, None while there is none.
    """

    available: bool
    reason: str
    path: Path | None = None


@dataclass(frozen=True, slots=True)
class _Recipe:
    """Recipe of a product on this machine.

    Attributes
    ----------
    product : Product
    compiler : tuple of str
        The command.
    version : str
        The compiler's own words.
    flags : tuple of str
    headers : tuple of str
        Options that name the folders of headers.
    objects : dict
        Hash of each unit's object, by the names of its files.
    library : Path
    """

    product: Product
    compiler: tuple[str, ...]
    version: str
    flags: tuple[str, ...]
    headers: tuple[str, ...]
    objects: dict[tuple[str, ...], str]
    library: Path


def _recipe(product: Product, platform: Platform | None = None, level: str = "") -> _Recipe:
    """Recipe of the product for this very processor, or for a level of a platform.

    Raises
    ------
    SetupError
        Naming what is missing and what to install, or why the place in the cache cannot be used.
    """
    units = product.units()
    compiler, version = require_compiler(product.title, platform.compiler if platform else None)
    flags = (*FLAGS, *((platform.levels[level],) if platform else native_flags()))
    headers: list[str] = []
    for wheel in product.wheels:
        if wheel.headers is None:
            raise SetupError(f"{product.title} cannot be built: {wheel.missing} not there; {product.advice}")
        headers += ["-isystem", str(wheel.headers)]
    here = json.dumps([version, compiler[1:], flags, headers, product.versions()])
    objects = {}
    for unit in units:
        digest = hashlib.sha256()
        add(digest, here.encode(), b"" if platform else processor().encode(), " ".join(unit).encode())
        for name, text in product.included(unit).items():
            add(digest, name.encode(), text)
        objects[unit] = digest.hexdigest()[:20]
    whole = checksum(json.dumps([product.name, *objects.values()]).encode())[:20]
    folders = [word for folder in (product.folder, *product.also) for word in ("-iquote", str(folder))]
    return _Recipe(product, compiler, version, flags, (*folders, *headers), objects, _place(product, whole))


def _place(product: Product, name: str) -> Path:
    """Place of a library in the cache; SetupError where it cannot be used from there."""
    library = cache_folder() / name / product.library
    if wrong := set(str(library)) & set(product.forbidden):
        raise SetupError(
            f"{library}: LAMMPS cannot load a plugin from a path with {' '.join(map(repr, sorted(wrong)))}; name "
            "another folder in the variable LAMMPS_JUMP_CACHE"
        )
    require_own(library, record_of(library))
    return library


def _run(recipe: _Recipe, arguments: Sequence[str], product: Path, is_made: Callable[[bytes], bool]) -> Made:
    """Run the compiler; what it made, with its record."""
    command = [*recipe.compiler, *recipe.flags, *arguments, "-o", str(product)]
    code = run_compiler(command, product, recipe.product.title, recipe.version)
    if not is_made(code):
        name = recipe.version.splitlines()[0]
        raise SetupError(
            f"{recipe.product.title} could not be built: {name} made something that is no {product.name}; {ADVICE}"
        )
    flags = [word for word in recipe.flags if word.startswith(("-f", "-m", "-O"))]
    return code, {"flags": flags, "compiler": recipe.version.splitlines()[0]}


def _compile(recipe: _Recipe, unit: tuple[str, ...]) -> Made:
    """Compile a unit: a file that includes its files."""
    with tempfile.TemporaryDirectory(prefix="lammps-jump-") as work:
        source, product = Path(work) / "unit.cpp", Path(work) / "unit.o"
        write_text(source, "".join(f'#include "{name}"\n' for name in unit))
        return _run(recipe, [*recipe.headers, "-c", str(source)], product, is_code)


def _object(recipe: _Recipe, unit: tuple[str, ...], force: bool) -> Path:
    """The object of a unit, in the cache."""
    path = cache_folder() / "objects" / recipe.objects[unit] / "unit.o"
    return kept(path, is_code, partial(_compile, recipe, unit), force)


def _build(recipe: _Recipe, force: bool, tell: Tell, linking: Sequence[str] = ()) -> Made:
    """Compile what is not compiled yet, and link."""
    product, units = recipe.product, list(recipe.objects)
    files = sum(len(unit) for unit in units)
    tell(f"{product.title}: compiling {files} files in {len(units)} parts, kept in {cache_folder()}")
    objects = _at_once(partial(_object, recipe, force=force), units)
    with tempfile.TemporaryDirectory(prefix="lammps-jump-") as work:
        made = Path(work) / product.library
        code, record = _run(recipe, ["-shared", *map(str, objects), *linking], made, product.is_made)
    forget_old(objects)
    tell(f"{product.title}: compiled")
    return code, {**record, **needs(product)}


def _carried(product: Product) -> tuple[Carried | None, Path | None, str]:
    """The library of the package that fits, its place in the cache, and, without one, the reason."""
    carried, reason = fitting(product)
    if carried is None:
        return None, None, reason
    # whether it loads depends on the system's libraries
    name = checksum(json.dumps([carried.record["sha256"], libraries_version()]).encode())[:20]
    library = _place(product, f"{carried.level}-{name}")
    with suppress(OSError, ValueError, KeyError, TypeError):
        return None, None, str(read_json(record_of(library))["fails"])
    return carried, library, ""


def _copy(product: Product, carried: Carried, library: Path) -> Made:
    """Try a carried library; SetupError, kept in the record, where it does not load."""
    try:
        check_loads(product, carried.library)
    except SetupError as error:
        write(library, (b"", {"fails": str(error)}))
        raise
    return read_file(carried.library, MOST_BYTES), carried.record


def library_path(product: Product, *, force: bool = False, tell: Tell = lambda text: None) -> Path:
    """Path of the library: that which the package carries if it fits, else built once and kept.

    Parameters
    ----------
    product : Product
    force : bool
        Build here, even where the cache or the package has it.
    tell : callable
        Hears a sentence when a build begins and when it ends.

    Raises
    ------
    SetupError
        No compiler, no headers, no writable cache, or a failed build; says what to install.
    """
    if not force:
        with suppress(SetupError):  # one that does not load or cannot be kept: built here, or that says why not
            carried, library, _ = _carried(product)
            if carried is not None and library is not None:
                return kept(library, product.is_made, partial(_copy, product, carried, library))
    recipe = _recipe(product)
    linking = plugin_flags() if product.wheels else ()
    return kept(recipe.library, product.is_made, partial(_build, recipe, force, tell, linking), force)


def build_all(products: Sequence[Product], *, force: bool = False, tell: Tell = lambda text: None) -> list[Path | str]:
    """`library_path` of several products, built at once; for each its path, or why there is none."""

    def path(product: Product) -> Path | str:
        try:
            return library_path(product, force=force, tell=tell)
        except SetupError as error:
            return str(error)

    return _at_once(path, products)


def _at_once(work: Callable[[Any], Any], items: Sequence[Any]) -> list[Any]:
    """The work on each item, in threads of their own."""
    from concurrent.futures import ThreadPoolExecutor  # not needed to find what is built

    with ThreadPoolExecutor(len(items)) as pool:
        return list(pool.map(work, items))


def build_for(product: Product, platform: Platform, level: str) -> Path:
    """Build the library that the package carries for a level of a platform; returns its path.

    Raises
    ------
    SetupError
        As `library_path`; the compiler made something for another system.
    """
    recipe = _recipe(product, platform, level)
    library = carried_folder(product) / level / product.library
    library.parent.mkdir(parents=True)
    code, record = _build(recipe, False, lambda text: None, () if platform.zig else product.carried_flags)
    if made_for(code) != (platform.system, platform.machine):
        raise SetupError(f"{recipe.version.splitlines()[0]} made code for {made_for(code)}, not for {platform.tag}")
    write(library, (code, {**record, **needs(product, platform)}))
    return library


def availability(product: Product) -> Status:
    """Availability of the library here; looks, builds nothing."""
    try:
        carried, library, without = _carried(product)
    except SetupError as error:
        carried, library, without = None, None, str(error)
    if carried is not None and library is not None:
        path = library if is_whole(library, product.is_made) else None
        where = f"kept in {library}" if path else "will be tried and kept on first use"
        return Status(True, f"carried by the package, built for {carried.level}: {where}", path)
    try:
        recipe = _recipe(product)
    except SetupError as error:
        return Status(False, f"{error} ({without})")
    if is_whole(recipe.library, product.is_made):
        return Status(True, f"built here, as {without}: {recipe.library}", recipe.library)
    compiler = recipe.version.splitlines()[0]
    reason = f"not built yet; will be built with {compiler} on first use, or by `lammps-jump kernels build` ({without})"
    return Status(True, reason)
