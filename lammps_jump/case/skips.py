"""What a scene does not need, and why: left out of script and kernels, listed by `check`."""

from __future__ import annotations

from lammps_jump.scene.walls import Wall

from .fields import Case


def reachable(wall: Wall, domain, d: float) -> bool:
    """Whether any centre inside the domain can touch the wall."""
    return any(
        all(low - d / 2 < end and high + d / 2 > start for (low, high), (start, end) in zip(face.extent, domain))
        for face in wall.faces()
    )


def skipped(case: Case, walls, kept, probes) -> tuple[str, ...]:
    """What the engines leave out because the scene does not need it."""
    texts = []
    if case.contact.friction == 0:
        texts.append("friction terms: friction is 0")
    if case.contact.restitution == 1:
        texts.append("dashpots: restitution is 1")
    if not case.contact.rotation:
        texts.append("spin: contact.rotation is false, discs do not turn")
    elif case.contact.friction == 0:
        texts.append("spin: without friction nothing turns a disc")
    if case.gravity == 0:
        texts.append("gravity: it is 0")
    texts += [f"wall '{wall.name}': nothing inside the domain can reach it" for wall in walls if wall not in kept]
    if not walls:
        texts.append("walls: there are none")
    if case.inflow is None:
        texts.append("inlet: no inflow")
    if not case.outflow:
        texts.append("outlet: no outflow")
    texts.append("z constraint: nothing pushes out of the plane")
    texts.append("tangential springs: the laws here have no history")
    columns = "z, vz, radius, mass, type, forces" + (
        "" if case.contact.rotation and case.contact.friction else ", spin"
    )
    texts.append(f"dump columns {columns}: no analysis reads them")
    if not probes:
        texts.append("wall forces: no probe asks for them")
    if case.run.dump_format == "text" and not case.analysis.fields:
        texts.append("stress fields: analysis.fields is false")
    return tuple(texts)
