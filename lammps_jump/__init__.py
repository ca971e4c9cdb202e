# SPDX-License-Identifier: GPL-2.0-or-later
"""lammps-jump: free-surface flow with discs on LAMMPS, from a YAML case to a report.

``case = lammps_jump.load_case(file)`` reads a case, ``run = case.run(folder)`` runs and analyses it.
"""

import difflib

import lazy_loader

_lazy, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
_HABITS = {
    "load": "lammps_jump.open(path), or load_case(file)",
    "read": "lammps_jump.open(path), load_case(file) or read_dump(file)",
    "open_dump": "lammps_jump.open(file), or read_dump(file)",
    "open_dataset": "lammps_jump.open(path)",
    "Universe": "lammps_jump.open(path)",
    "simulate": "load_case(file).run(folder)",
    "Simulation": "load_case(file)",
    "list_cases": "`lammps-jump new` in a terminal, which lists the scenes",
    "plot": "lammps_jump.open(path).plot()",
}


def __getattr__(name):  # type: ignore[no-untyped-def]
    """A public name, loaded on first use; a name that other libraries have is answered with what to write."""
    try:
        return _lazy(name)
    except AttributeError as error:
        if name.startswith("_"):
            raise
        close = difflib.get_close_matches(name, __all__, n=1, cutoff=0.6)
        hint = f"write {_HABITS[name]}" if name in _HABITS else f"did you mean '{close[0]}'?" if close else ""
        hint = hint or "lammps_jump.open(path) and load_case(file) are where to begin; dir(lammps_jump) lists all"
        raise AttributeError(f"lammps_jump has no '{name}'; {hint}", name=name) from error
