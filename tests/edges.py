# SPDX-License-Identifier: GPL-2.0-or-later
"""Which module of the program uses which: what it imports, and what it loads on first use through a late-bound name.

A folder loads a file when one of its names is first used; the names stand in the ``__init__.pyi``. So ``runs.results``
is an edge to that file, and ``from lammps_jump.engines import RunResult`` is one to ``engines/result.py``. A package
that is passed on whole is an edge to all that it lists. The name of a module in a string counts too.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

DOTTED = re.compile(r"lammps_jump(\.\w+)+")


def module_of(file: str) -> str:
    """Dotted name under which a file is imported."""
    parts = list(Path(file).with_suffix("").parts)
    parts = ["lammps_jump", *parts] if parts[0] == "analysis" else parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def base_of(file: str, node: ast.ImportFrom) -> str:
    """The module after ``from``, in full."""
    if not node.level:
        return node.module or ""
    parts = module_of(file).split(".")
    parts = parts if Path(file).stem == "__init__" else parts[:-1]
    return ".".join([*parts[: len(parts) - node.level + 1], *([node.module] if node.module else [])])


class Program:
    """The files of a program and the names that its packages load late.

    Parameters
    ----------
    trees : mapping of str to ast.Module
        Syntax tree of every file, by its path.
    stubs : mapping of str to ast.Module
        That of every ``__init__.pyi``.
    """

    def __init__(self, trees: Mapping[str, ast.Module], stubs: Mapping[str, ast.Module]):
        self.trees = trees
        self.modules = {module_of(file) for file in trees}
        self.late = {module_of(file): self._names(file, tree) for file, tree in stubs.items()}

    def _names(self, file: str, tree: ast.Module) -> dict[str, str]:
        """Module in which each name that a file imports lies."""
        found = {}
        for node in (node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)):
            base = base_of(file, node)
            for alias in node.names:
                whole = f"{base}.{alias.name}"
                found[alias.asname or alias.name] = whole if whole in self.modules else base
        return found

    def home(self, module: str, name: str) -> str:
        """Module that a name of a module leads to: a module of a package, the one that its stub names, else itself."""
        whole = f"{module}.{name}"
        if whole in self.modules:
            return whole
        found = self.late.get(module, {}).get(name, module)
        return found if found == module or found in self.modules - self.late.keys() else self.home(found, name)

    def edges(self, file: str) -> set[str]:
        """Modules that a file uses, itself left out."""
        nodes = list(ast.walk(self.trees[file]))
        found: set[str] = set(self._strings(file, nodes))
        aliases: dict[str, str] = {}  # name in this file -> package or module
        for node in nodes:
            for name, module in self._imported(file, node):
                found.add(module)
                if name:
                    aliases[name] = module
        found |= set(self._used(nodes, aliases))
        return found - {module_of(file)}

    def _imported(self, file: str, node: ast.AST) -> Iterator[tuple[str, str]]:
        """Name in the file (empty if it is no module) and module of an import."""
        if isinstance(node, ast.Import):
            for alias in node.names:
                if alias.name.split(".")[0] == "lammps_jump":
                    yield alias.asname or "lammps_jump", alias.name if alias.asname else "lammps_jump"
                    yield "", alias.name
        elif isinstance(node, ast.ImportFrom) and base_of(file, node).split(".")[0] == "lammps_jump":
            base = base_of(file, node)
            for alias in node.names:
                home = self.home(base, alias.name)
                yield (alias.asname or alias.name) if home.endswith(f".{alias.name}") else "", home

    def _used(self, nodes: Sequence[ast.AST], aliases: Mapping[str, str]) -> Iterator[str]:
        """Modules that names of packages lead to, ``runs.results.analyse`` step by step."""
        part_of_more = {id(node.value) for node in nodes if isinstance(node, ast.Attribute)}
        for node in nodes:
            if id(node) in part_of_more or not isinstance(node, ast.Attribute | ast.Name):
                continue
            names: list[str] = []
            while isinstance(node, ast.Attribute):
                names.insert(0, node.attr)
                node = node.value
            if not isinstance(node, ast.Name) or node.id not in aliases or isinstance(node.ctx, ast.Store):
                continue
            module = aliases[node.id]
            for name in names:
                module = self.home(module, name)
            yield module
            if module in self.late and (not names or module == aliases[node.id]):  # handed on whole
                yield from self.late[module].values()

    def _strings(self, file: str, nodes: Sequence[ast.AST]) -> Iterator[str]:
        """Modules whose names stand in strings, with their dots; in a call of ``import_module`` relative ones too."""
        for node in nodes:
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and DOTTED.fullmatch(node.value):
                yield node.value
            if isinstance(node, ast.Call) and "import_module" in (
                getattr(node.func, "attr", ""),
                getattr(node.func, "id", ""),
            ):
                package = module_of(file).rpartition(".")[0]
                for part in ast.walk(node):
                    if isinstance(part, ast.Constant) and str(part.value).startswith("."):
                        yield package + part.value
