# SPDX-License-Identifier: GPL-2.0-or-later
"""Words that people write for fields and kinds of a case: of other programs and of books."""

from __future__ import annotations

from typing import NamedTuple

STEP = "the step follows from the stiffness: give its share of the largest stable one; `check` prints it in s"
MEANT = (
    ("contact.friction", "mu cof coulomb friction_coefficient", ""),
    ("contact.from_material", "E young e_modulus elastic_modulus youngs_modulus young_modulus modulus material",
     "{young: 5 MPa, poisson: 0.3}, in place of stiffness and largest_overlap"),
    ("contact.impact_speed", "v0 speed velocity max_speed vmax reference_speed", ""),
    ("contact.largest_overlap", "n overlap max_overlap penetration penetration_fraction", ""),
    ("contact.restitution", "e cor en e_n damping restitution_coefficient bounce", "0.2 keeps a fifth of the speed"),
    ("contact.rolling", "rolling_friction mu_r rolling_resistance", "{friction: 0.1}, with friction_law: history"),
    ("contact.rotation", "spin rotate", ""),
    ("contact.stiffness", "k kn k_n spring", ""),
    ("discs", "particles particle grains grain disks disk spheres balls atoms", ""),
    ("discs.density", "rho mass_density", ""),
    ("discs.diameter", "radius r size d", "twice the radius"),
    ("discs.sizes", "polydispersity distribution psd", "{kind: uniform, spread: 0.2}"),
    ("domain", "box region simulation_box limits bounds", "{x: [0, 10], y: [0, 5]}"),
    ("domain.periodic", "boundary pbc", ""),
    ("gravity", "g acceleration", ""),
    ("inflow", "inlet source jet inflows", ""),
    ("inflow.depth", "height thickness h y1", ""),
    ("inflow.discharge", "q flow flow_rate rate flux", ""),
    ("inflow.mean_speed", "speed velocity v u va vx", ""),
    ("inflow.table", "rows points times series hydrograph", ""),
    ("initial", "start initial_conditions water fluid column reservoir columns", "a list with a kind: column in it"),
    ("initial.positions", "points coordinates xy", "[[x, y], …]"),
    ("initial.velocity", "speed v u", ""),
    ("outflow", "outlet sink drain outlets", "[{x_beyond: 20}, {y_below: -1}]"),
    ("outflow.x_beyond", "x x_above x_max xmax right", ""),
    ("outflow.x_before", "x_below x_min xmin left", ""),
    ("outflow.y_below", "y y_before y_min ymin bottom", ""),
    ("outflow.y_above", "y_beyond y_max ymax top", ""),
    ("probes", "sensors monitors measure", "{forces: [name of a wall], gauges: [x]}"),
    ("probes.forces", "walls force wall", ""),
    ("probes.gauges", "x points wave_gauges depth depths", ""),
    ("run", "simulation settings time solver", ""),
    ("run.duration", "time end t_end tend t_max tmax end_time total_time length until", ""),
    ("run.output_interval", "output interval dt_out output_step dump_interval save_interval frame_interval "
     "every write_interval", ""),
    ("run.seed", "random random_seed", ""),
    ("run.time_step_fraction", "dt timestep time_step step delta_t cfl steps n_steps", STEP),
    ("engine.ranks", "cores processes np mpi procs processors cpus", "of MPI; engine.threads are those of one process"),
    ("slope", "tilt angle inclination theta incline", ""),
    ("walls", "geometry boundaries wall boundary bed structures obstacles", ""),
    ("walls.angle", "rotation tilt theta", ""),
    ("walls.at", "position offset x y", ""),
    ("walls.axis", "normal direction", ""),
    ("walls.motion", "movement velocity moving speed", "{kind: translate, velocity: [1, 0]}"),
    ("walls.motion.angle", "angular_amplitude", ""),
    ("walls.motion.from", "start begin t0 start_time", ""),
    ("walls.motion.period", "frequency freq omega f", "one over the frequency"),
    ("walls.motion.points", "rows table times data values positions path", ""),
    ("walls.motion.rate", "omega speed velocity angular_velocity rpm", ""),
    ("walls.motion.until", "end stop t1 end_time", ""),
    ("walls.motion.velocity", "speed v u vx", ""),
    ("walls.points", "vertices coordinates nodes xy path", "[[x, y], …]"),
    ("walls.centre", "middle position origin", ""),
    ("walls.from", "start begin x y", ""),
    ("walls.to", "end stop", ""),
    ("analysis.window", "time interval average averaging from", ""),
    ("analysis.bin_width", "bins bin dx", ""),
)  # fmt: skip
"""Synonyms of fields, with a hint where the meaning differs."""
KINDS = {
    "rectangle rect solid obstacle sill step structure": "block",
    "floor ground bottom side flat infinite": "plane",
    "container tank": "box",
    "segment polyline curve spline bed wall lines polygonal_chain": "line",
    "triangle": "polygon",
    "disc disk arc drum cylinder": "circle",
    "fixed rough_bed bumpy particles": "rough",
    "linear move moving slide velocity constant": "translate",
    "rotation turn spin angular": "rotate",
    "sine sinus sinusoidal harmonic periodic vibration shake wave": "oscillate",
    "points file series list tabulated": "table",
    "lid piston mass force free": "load",
    "tailgate gate weir tailwater control controller regulate": "hold",
    "jet inlet row uniform rows_of_discs": "rows",
    "rain drop fall hopper fill": "pour",
    "block rectangle dam reservoir water fluid": "column",
    "grid array square": "lattice",
    "positions points discs": "list",
    "random range flat_distribution": "uniform",
    "two binary bimodal": "bidisperse",
    "custom table": "list",
}
"""Words for kinds."""


class Meaning(NamedTuple):
    """A field that a word may mean: its group, its name there, and what its value is."""

    group: str
    name: str
    said: str

    @property
    def path(self) -> str:
        """Dotted name of the field."""
        return f"{self.group}.{self.name}".lstrip(".")

    def told(self, said: str) -> Meaning:
        """The same with what its value is, where the word needs no answer of its own."""
        return self if self.said else self._replace(said=said)

    def __str__(self) -> str:
        """The field and its value, for a message."""
        return f"{self.path} ({self.said})" if self.said else self.path


def meanings(word: str) -> list[Meaning]:
    """Fields that a word may mean."""
    asked = word.lower().replace("-", "_") if len(word) > 1 else word
    found = ((path, said) for path, words, said in MEANT if asked in words.split() or asked == path.rpartition(".")[2])
    return [Meaning(*path.rpartition(".")[::2], said) for path, said in found]


def kinds(word: str) -> list[str]:
    """Kinds that a word may mean."""
    return [kind for words, kind in KINDS.items() if word.lower().replace("-", "_") in words.split()]
