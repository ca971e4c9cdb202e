# SPDX-License-Identifier: GPL-2.0-or-later
"""What the numbers of a report mean, by the key of their quantity.

The page of all numbers, docs/reference/numbers.md, is made from these too.
"""

# ruff: noqa: RUF001  (Greek letters, minus signs and dashes are meant for readers)

DEFINITIONS = {
    "inflow": """\
asked       Va y₁, or the mean of the inflow's table over the window; in whole steps: what the rows carry where no disc
            is refused
delivered   area of the discs that entered in the window over the time of their turns; discs are counted by their ids
refused     turns of the whole record at which the place of the disc was occupied
depth, speed, momentum   means of the window from one to six depths behind the inlet, weight 1 − cos 2πs
Froude      u/√(g s) of these, and Bélanger's depth of this stream, in the laboratory
""",
    "jump": """\
front       where a sharp step between the mean depths would hold the same mass; c is its velocity
toe, end    where the mean profile in the front's frame, smoothed over 0.25 s₂, has made 5 % and 95 % of its rise
length      from toe to end on the free surface; thesis: 9.75 s₁ (Fr₁ − 1)^1.01, USBR: curve of EM 25
s           mass depth, N m/(ρ L); h depth of the free surface; u mean velocity by mass
comparison  mass depth of the tail water (else behind the end) against Bélanger's for the delivered inflow (else the
            stream before the toe), in the front's frame; deviation: their ratio less one
1, 2        beside the jump: a stretch of five depths s₁ that ends five depths before the toe; one of 1.5 depths s₂ that
            begins 0.25 depths behind the end
Fr          (u − c)/√(g s); Bélanger: s₂/s₁ = (√(1 + 8 Fr₁²) − 1)/2
head        s + (u − c)²/2g; loss of head: the energy between two stations that move with the front, carried by
            discs and handed on by contacts, in less out less stored;  momentum function: ρ (s (u − c)² + g s²/2)
β           ∑ m (u − c)² over the same with the mean velocity
thrust      contact force through a vertical plane over ρ, hydrostatic pressure in it; flux: ∑ m u²/(ρ L)
packing     area of the discs over that below the surface;  bulk density: ρ s/h
density     ratio of the bulk densities, downstream over upstream
roller      where the mean velocity of the surface discs is below the front's own
parts       of the momentum balance: each over the downstream momentum function, 1 less 2
errors      standard errors within this run, from eight pieces of the window; "at least": one run cannot tell it
tail water  from 1.2 y₂ behind the front to 0.5 y₂ before the sill
""",
    "stations": """\
carried     m [((u − c)² + v²)/2 + g y] of each disc that crosses a station; c is the velocity of the stations
contacts    F · [(v_i + v_j)/2 − c] of each contact that a station cuts;  walls: −c times their force along x
stored      change of kinetic and gravitational energy between the stations
lost        what dashpots and friction take: every contact between the stations, those that a station cuts by half
left over   elastic energy stored and carried away, and the error of its integration
frames      the same from the frames, where nothing rubs; elastic energy is in carried and stored there
""",
    "grade": """\
head        z + p + k of the discs in a bin, means of the window by mass: height of the centre of mass; half of the
            depth that is connected to the bed (hydrostatic pressure); ∑ m u |v|²/2 over g ∑ m u (kinetic energy);
            where discs strike the bed, pressure is more than hydrostatic, and the line dips
lost        difference of the heads of two stations whose discharges are within 10 %; friction, impacts and the jump
stations    analysis.stations (--stations), else the gauges, else the ends of the stream; each is the bin that holds it
error       standard error within this run, from eight pieces of the window
""",
    "front": """\
bulk front    right edge of the last disc in x before the first gap of two diameters between neighbours' centres;
              without a back wall of the discs from the column's left edge on
99 % front    right edge that 99 % of the discs do not pass
column        top of the discs within one diameter of the back wall, up to the first vertical gap of two diameters
speed         straight line through the bulk front, from a tenth of the free path to the first obstacle
errors        none: one run cannot tell; repeat it from other starts
""",
    "water": """\
Ritter        front of water in an endless reservoir, a + 2 √(g H) t, until its wave meets the back wall
T, Z, n²      n t √(g/a), front/a, H/a of the column of base a and height H at the start
dZ/dT         slope of the bulk front over T, from Martin & Moyce's table beside it where that has the same n²
""",
    "force": """\
peak          largest mean over 0.05 s, of the component with the larger impulse; per metre of width; in the window
              where discs flow in, after t = 0 elsewhere; start-up: the largest before the window
error         standard error within this run: scatter of the maxima of blocks of 0.5 s; only with an inlet
component     Fx or Fy, whichever has the larger integral of its size; none where nothing touched the structure
resultant     √(Fx² + Fy²) of the means over 0.05 s, largest; direction: its angle to the x axis, anticlockwise
sign          a contact pulls for a moment at the end of an impact, because its dashpot acts until the discs part: short
              windows may show a small force of the other sign
impulse       ∫ F dt after t = 0
moment        about the foot of upright faces at the bed, anticlockwise positive
identity      change of all discs' momentum against the impulse of walls, weight and discs that came and went
wave          place where the mean velocity falls through half of its largest value upstream; bore: of a wall instead
hydrostatic   on the wetted face, largest: ρg(s² − a²)/2 for the mass depth s in front, a of it above the face
oncoming      largest ρsu² + ρgs²/2 two bins in front
""",
    "waves": """\
height        crest less trough of the mean wave: the depth at the gauge, averaged over the whole periods of the paddle
              at the end of the window at equal times within the period
piston        S 2 (cosh 2kh − 1)/(sinh 2kh + 2kh), small waves of water; S whole stroke, ω² = g k tanh kh
depth         of the free surface at the gauge, mean of the same periods
gauges        mean: depth over the window; lowest, largest: of all frames
""",
    "runup": """\
obstacle      where the bed rises by three diameters or more from where the discs are; its crest is the first top
highest       bed under the end of the tongue, before the first gap of two diameters along the slope; before an upright
              face the top of the discs that stand there without such a gap
still water   median of the highest edges of strips two diameters wide, before walls move; without such walls that
              of the water before the foot of the obstacle at the start
over          discs that were before the crest at the start and were last seen beyond it, their mass over ρ
""",
    "drum": """\
angle         straight line through the top edges of the highest discs of strips one diameter wide, middle half of the
              drum; mean of the window; above 0 where the surface rises with the wall that lifts the discs
scatter       standard deviation of the angle from frame to frame;  Froude number: ω²R/g
""",
    "hopper": """\
gap           narrow place between standing walls that discs pass, from their tracks; of gaps behind each other the
              narrowest; width D, and the way of the discs to the direction −y, counter-clockwise
discharge     slope of the mass that has passed against time, over the window;  change: second half over first
window        from flow on to flow off: from the first to the last time with half of the usual discharge, which half of
              the mass passes faster; a window that the case asks for cuts it
Beverloo      W/(ρ √g (D − 1.4 d)^1.5), ρ and d of a disc, for one gap from 6 d on in a floor: by the law of Beverloo,
              Leniger & van de Velde (1961) in two dimensions the same for every gap and height of fill
""",
    "tailgate": """\
height        y of the crest; mean since it settled, ± from the swings within this run
settled       from then on the height, averaged over a response, stays within half a diameter of the mean of the last
              quarter; and what is held is off by 2 % of the depth, or (y1 + y2)/8 along x, at most
held          mass depth over ten diameters around the place, or x where the mass depth first comes to (y1 + y2)/2, y2
              after Bélanger; mean of the last quarter
""",
    "layers": """\
layer         discs count with the share of their area in it, contacts with that of the line between the centres
packing       π d²/4 of the discs over the area of the layer
temperature   half of the mean square of the velocities about the mean of the layer, the shear taken off, m²/s²
stress        σ = (∑ F l + ∑ m v′ v′)/area, contacts and fluctuations; τ = −σ_xy: the upper layer drags the lower
I, μ          γ̇ √(m/P) = γ̇ d √(ρ/P) and |τ|/P, with P = σ_yy
""",
    "heap": """\
surface       free surface in bins one diameter wide, last frame; height: the largest depth over the bed
angle         straight line through the bins from 80 % down to 20 % of the height, to the horizontal; ± is half of the
              95 % interval, from their scatter about the line; a flank that leans on a wall is none
run-out       L − L₀; L₀ base of the column at the start, half of it where it falls to both sides (the mean is given)
fronts        bulk: before the first gap of two diameters between neighbours in x; 99 %: what 1 % of the discs pass
discs, rods, sand   published, for the same a = H₀/L₀; they are of other grains: friction and sizes differ
""",
    "rest": """\
rest          from the first frame on after which, up to the end: median speed below 0.01 √(g d), highest edge within
              0.05 d, number of discs as it is; at least for 20 √(d/g), with all gates open
sinking       fall of the highest edge over the last 20 √(d/g)
""",
    "depth": """\
by mass       Σ d² of the discs over the length: as deep as the same discs would stand in squares
surface       free surface over the bed; both are means of the window, where that is two diameters or more
over          touching discs have 0.8 to 1.2; a dump beyond 1.5 is refused: its discs overlap
""",
    "state": """\
speed         median of the discs of the last frame that holds some;  along: mean velocity along x, by mass
room          length and height that 98 % of the discs take;  rest: as in the section on rest
""",
    "energy": """\
kinetic, spin, potential (−m g·r), elastic (k δ²/2) energy of all discs, per metre of width
drift         straight-line change over the record, over the energy at the start
deviation     largest |E − E₀|/|E₀|, exact for this run; it judges the engine only where nothing dissipates
""",
}
