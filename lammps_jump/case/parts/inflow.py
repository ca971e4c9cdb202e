# SPDX-License-Identifier: GPL-2.0-or-later
"""Where discs come from while a case runs: rows of a jet, steady or against time, or a pour."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Any, Literal

from pydantic import Field
from pydantic.functional_validators import model_validator

from lammps_jump import units
from lammps_jump.physics.hydrograph import Hydrograph
from lammps_jump.physics.inlet import LEAST_GAP
from lammps_jump.scene.walls import Coordinate, Extent

from .base import LENGTH, SPEED, Moment, Strict, Whole

Row = tuple[Moment, Annotated[units.Metre, Field(ge=0, le=1e6)], Annotated[units.MetrePerSecond, Field(**SPEED)]]
"""A row of the inflow against time: t (s), depth (m; 0: no disc enters), mean speed (m/s)."""
MOST_TIMES = 1000
"""Rows of an inflow against time."""


class RowsInflow(Strict):
    """A jet of discs in rows (thesis 4.1-4.2); row i at (i + 1/2) d_max above `y`."""

    kind: Literal["rows"]
    x: Coordinate = 0.0
    y: Coordinate = 0.0
    depth: units.Metre | None = Field(default=None, **LENGTH)
    mean_speed: units.MetrePerSecond | None = Field(default=None, **SPEED)
    discharge: units.MetrePerSecondMetre | None = Field(
        default=None, ge=1e-12, le=1e12, description="in place of mean_speed: mean_speed * depth, m^2/s"
    )
    table: tuple[Row, ...] | None = Field(
        default=None,
        min_length=1,
        max_length=MOST_TIMES,
        description="rows [t, depth, mean_speed] in place of depth, mean_speed and discharge: straight lines between, "
        "constant before the first and after the last; depth 0: no disc enters",
    )
    profile: Literal["power_law", "uniform"] = "power_law"
    schedule: Literal["exact", "thesis"] = Field(
        default="exact", description="exact: rows carry the discharge asked for; thesis: touching rows fill the depth"
    )
    spacing: units.Plain = Field(
        default=LEAST_GAP, ge=1, le=5, description="least distance between discs of a row, in largest diameters"
    )
    back: Literal["wall", "open"] = Field(default="wall", description="wall: discs cannot flow back through the inlet")

    @model_validator(mode="before")
    @classmethod
    def _fields_of_0_1_0(cls, data: Any) -> Any:
        """Leave out fields that earlier cases name: the default schedule carries the exact discharge."""
        if isinstance(data, dict):
            return {key: value for key, value in data.items() if key not in ("turns", "exact_discharge")}
        return data

    @model_validator(mode="after")
    def _speed_given_once(self) -> RowsInflow:
        if self.table is not None:
            self._check_table(self.table)
            return self
        if self.depth is None:
            raise ValueError("needs depth (m), or table: rows [t, depth, mean_speed] of an inflow against time")
        if (self.mean_speed is None) == (self.discharge is None):
            raise ValueError(
                "needs mean_speed (m/s) or discharge (m^2/s), one of the two; null takes the other away, for example "
                "--set inflow.mean_speed=null"
            )
        speed = self.over(0.0, 0.0)[1]
        if not SPEED["ge"] <= speed <= SPEED["le"]:
            raise ValueError(
                f"discharge {self.discharge:zg} m^2/s over the depth is {speed:z.3g} m/s; allowed is "
                f"{SPEED['ge']:zg} to {SPEED['le']:zg} m/s"
            )
        return self

    def _check_table(self, rows: tuple[Row, ...]) -> None:
        for name in ("depth", "mean_speed", "discharge"):
            if getattr(self, name) is not None:
                raise ValueError(
                    f"table and {name} are both given; keep one: null takes the other away, for example "
                    f"--set inflow.{name}=null"
                )
        if self.schedule == "thesis":
            raise ValueError("schedule: 'thesis' has no table; allowed is exact where table is given")
        for (before, *_), (after, *_) in pairwise(rows):
            if after <= before:
                raise ValueError(f"table: t {after:zg} s follows {before:zg} s; times must grow")
        if not any(depth for _, depth, _ in rows):
            raise ValueError("table: every depth is 0, so that no disc enters; give one above 0, or drop the inflow")

    @property
    def hydrograph(self) -> Hydrograph:
        """Depth and mean speed against time; one row where they do not change."""
        if self.table is not None:
            times, depths, speeds = zip(*self.table, strict=True)
            return Hydrograph(times, depths, speeds)
        depth = self.depth or 0.0
        speed = self.mean_speed if self.discharge is None else self.discharge / depth
        return Hydrograph((0.0,), (depth,), (speed or 0.0,))

    def over(self, begin: float, end: float) -> tuple[float, float]:
        """Mean depth (m) and mean speed (m/s: discharge over depth) from one time to another, s."""
        graph = self.hydrograph
        if self.table is None:
            return graph.depths[0], graph.speeds[0]
        depth, discharge = graph.means(begin, end)
        return depth, discharge / depth if depth else float(graph.speed(end))


class PourInflow(Strict):
    """Discs dropped at random places of a rectangle, for filling."""

    kind: Literal["pour"]
    x: Extent
    y: Extent
    count: Whole = Field(gt=0, le=20_000_000)
    volume_fraction: units.Plain = Field(default=0.4, gt=0, le=0.7)
    speed_down: units.MetrePerSecond = Field(default=0.0, ge=0, le=1e6)


InflowField = Annotated[RowsInflow | PourInflow, Field(discriminator="kind")]
