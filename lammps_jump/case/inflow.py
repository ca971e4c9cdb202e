# SPDX-License-Identifier: GPL-2.0-or-later
"""Inflow of discs while a case runs: rows of a jet, steady or against time, or a pour."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Any, Literal

from pydantic import Field
from pydantic.functional_validators import model_validator

from lammps_jump import units
from lammps_jump.physics.inlet import LEAST_GAP, Hydrograph

from .base import LEAST_SPEED, MOST_SPEED, Speed, Strict, Whole

Row = tuple[units.Moment, Annotated[units.Metre, Field(ge=0, le=1e6)], Speed]
"""A row of the inflow against time: t (s), depth (m; 0: no disc enters), mean speed (m/s)."""
MOST_TIMES = 1000
"""Rows of an inflow against time."""


class RowsInflow(Strict):
    """A jet of discs in rows (thesis 4.1-4.2); row i at (i + 1/2) d_max above `y`."""

    kind: Literal["rows"]
    x: units.Coordinate = Field(default=0.0, description="where the rows stand")
    y: units.Coordinate = Field(default=0.0, description="height of the bed there")
    depth: units.Length | None = Field(default=None, title="depth of the inflow", description="of the jet")
    mean_speed: Speed | None = Field(default=None, title="speed of the inflow", description="of the jet")
    discharge: Annotated[units.MetrePerSecondMetre, Field(ge=1e-12, le=1e12)] | None = Field(
        default=None, title="discharge", description="mean speed times depth, in place of `mean_speed`"
    )
    table: tuple[Row, ...] | None = Field(
        default=None,
        min_length=1,
        max_length=MOST_TIMES,
        description="rows [t, depth, mean speed] in place of depth and speed; an inflow against time, in straight "
        "lines between the rows, constant before the first and after the last; depth 0: no disc enters",
    )
    profile: Literal["power_law", "uniform"] = Field(
        default="power_law", description="of the velocity: 1/7 power law of the thesis, or uniform"
    )
    schedule: Literal["exact", "thesis"] = Field(
        default="exact",
        description="`exact`: the rows carry mean speed · depth. `thesis`: touching rows fill the depth, 1.02 "
        "diameters from disc to disc, and carry 3 to 6 % less",
    )
    spacing: units.Plain = Field(
        default=LEAST_GAP, ge=1, le=5, description="least distance of discs in a row, in largest diameters"
    )
    back: Literal["wall", "open"] = Field(default="wall", description="`wall`: no disc leaves upstream")

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
        if not LEAST_SPEED <= speed <= MOST_SPEED:
            raise ValueError(
                f"discharge {self.discharge:zg} m^2/s over the depth is {speed:z.3g} m/s; allowed is "
                f"{LEAST_SPEED:zg} to {MOST_SPEED:zg} m/s"
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
    x: units.Extent = Field(description="from and to")
    y: units.Rise = Field(description="from and to")
    count: Whole = Field(gt=0, le=20_000_000, description="discs poured")
    volume_fraction: units.Plain = Field(
        default=0.4, gt=0, le=0.7, description="share of the space that is filled at once"
    )
    speed_down: units.MetrePerSecond = Field(default=0.0, ge=0, le=1e6, description="of the discs when they enter")


InflowField = Annotated[RowsInflow | PourInflow, Field(discriminator="kind")]
