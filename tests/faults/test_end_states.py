# SPDX-License-Identifier: GPL-2.0-or-later
"""States of discs that were handed on: each number is held against what it means before the core gets it."""

from __future__ import annotations

import random
import zipfile
from io import BytesIO

import numpy as np
import pytest
from fault_table import many
from features import BASE, FEATURES
from made_up import scene_of_feature

import lammps_jump as lj
from lammps_jump.dump.ended import read_ended, write_ended
from lammps_jump.engines.native.simulation import NativeSimulation
from lammps_jump.engines.native.state import ended_of, load_state, save_state
from lammps_jump.errors import CaseError, DumpError, ResumeError, RunError
from lammps_jump.files import END_FILE, checksum, read_arrays, write_arrays, write_json

pytestmark = pytest.mark.fault("values and mutants of states")
STEPS = 400
SLOPE, BED = "a rough bed without ends, `history`", "a rough bed, `history`"


def stepped(feature: str) -> NativeSimulation:
    """A small scene after some steps."""
    simulation = NativeSimulation(scene_of_feature(feature, "native"))
    simulation.run(STEPS)
    return simulation


@pytest.fixture(scope="module")
def states(tmp_path_factory):
    """Arrays of a sound state of a case with springs and a rough bed, and of one in a periodic channel."""
    place = tmp_path_factory.mktemp("states")
    for feature in (SLOPE, BED):
        write_ended(place / f"{feature}.npz", ended_of(stepped(feature)))
    return {feature: dict(read_arrays(place / f"{feature}.npz")) for feature in (SLOPE, BED)}


@pytest.mark.parametrize(
    "feature",
    [name if name in (SLOPE, BED, "a jet") else pytest.param(name, marks=pytest.mark.long) for name in FEATURES],
)
def test_what_the_engine_writes_is_taken(feature, tmp_path):
    """Every feature, with discs that came and left: the same state is read back."""
    simulation = stepped(feature)
    for steps in (0, 1, 300):
        simulation.run(steps)
        write_ended(tmp_path / "end.npz", found := ended_of(simulation))
        again = read_ended(tmp_path / "end.npz")
        assert again.key == found.key and again.exact.keys() == found.exact.keys()


def column(array: np.ndarray, name: str, value: object, at: int = 3) -> np.ndarray:
    """A copy with another value in a row of a column."""
    changed = array.copy()
    changed[name][at] = value
    return changed


def item(array: np.ndarray, at: int, value: object) -> np.ndarray:
    """A copy with another value at a place."""
    changed = array.copy()
    changed[at] = value
    return changed


def without_pair(stored: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The list without its first pair."""
    start = stored["exact_list_start"].copy()
    start[1 + np.flatnonzero(np.diff(start))[0] :] -= 1
    return {"exact_list_start": start, "exact_list_discs": stored["exact_list_discs"][1:]}


def without_images(stored: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The list without pairs across the seam of a channel."""
    n, start = len(stored["exact_discs"]), stored["exact_list_start"]
    cut = {f"exact_list_{name}": stored[f"exact_list_{name}"][:n] for name in ("owner", "shift")}
    return {**cut, "exact_list_start": start[: n + 1], "exact_list_discs": stored["exact_list_discs"][: start[n]]}


def swapped(array: np.ndarray) -> np.ndarray:
    changed = array.copy()
    changed[[0, 1]] = changed[[1, 0]]
    return changed


OF = [
    (0, np.nan),
    (0, np.inf),
    (1, 0.0),
    (1, -5.0),
    (1, np.nan),
    (1, 1e300),
    (2, 0.5),
    (2, 1e300),
    (3, np.nan),
    (3, 1.0),
]
DISCS = [
    ("id", 0), ("id", -1), ("id", 1), ("id", 1 << 50), ("id", -(1 << 63)), ("x", np.nan), ("y", np.inf), ("x", 1e12),
    ("vx", np.nan), ("vy", -1e300), ("spin", np.inf), ("half_vx", 1e300), ("half_spin", -np.inf), ("diameter", 0.0),
    ("diameter", -0.1), ("diameter", np.nan), ("diameter", 1e300), ("diameter", 1e-30), ("diameter", 10.0),
]  # fmt: skip
CONTACTS = [
    ("disc", 0), ("disc", 1 << 62), ("disc", -3), ("partner", 0), ("partner", -100), ("partner", 1 << 62),
    ("foot", np.nan), ("spring", np.inf), ("roll", 1e300),
]  # fmt: skip
KEPT = [("order", -1), ("order", 0), ("order", 1 << 40), ("x0", np.nan), ("x0", 5.0), ("fx", np.inf), ("fy", np.nan)]
WRONG = {
    **{
        f"of[{at}] = {value}": (BED, lambda s, at=at, value=value: {"of": item(s["of"], at, value)})
        for at, value in OF
    },
    **{
        f"{name}: {field} = {value}": (
            BED,
            lambda s, name=name, field=field, value=value: {name: column(s[name], field, value)},
        )
        for name, edits in (("discs", DISCS), ("contacts", CONTACTS), ("exact_discs", KEPT))
        for field, value in edits
    },
    "neighbours beyond all": (BED, lambda s: {"exact_list_discs": np.full_like(s["exact_list_discs"], 2**31 - 1)}),
    "neighbours below 0": (BED, lambda s: {"exact_list_discs": item(s["exact_list_discs"], 5, -1)}),
    "no neighbours": (BED, lambda s: {"exact_list_start": 0 * s["exact_list_start"],
                      "exact_list_discs": s["exact_list_discs"][:0]}),
    "two rows": (BED, lambda s: {"exact_list_start": s["exact_list_start"][:2],
                 "exact_list_discs": s["exact_list_discs"][:1]}),
    "no row": (BED, lambda s: {"exact_list_start": s["exact_list_start"][:0]}),
    "a row that ends before it begins": (BED, lambda s: {"exact_list_start": item(s["exact_list_start"], 4, -7)}),
    "rows to far": (BED, lambda s: {"exact_list_start": item(s["exact_list_start"], -1, 1 << 60)}),
    "a pair that is missing": (BED, without_pair),
    "a pair twice": (BED, lambda s: {"exact_list_discs": item(s["exact_list_discs"], 1, s["exact_list_discs"][0])}),
    "a disc beside itself": (BED, lambda s: {"exact_list_discs": item(s["exact_list_discs"], 0, 0)}),
    "neighbours as floats": (BED, lambda s: {"exact_list_discs": s["exact_list_discs"].astype(float)}),
    "neighbours in a square": (BED, lambda s: {"exact_list_discs": s["exact_list_discs"].reshape(1, -1)}),
    "an order alone": (BED, lambda s: {"exact_discs": s["exact_discs"][["order", "x0", "y0"]].copy()}),
    "forces as text": (BED, lambda s: {"exact_discs": s["exact_discs"].astype([
        (name, "U9" if name == "fx" else s["exact_discs"].dtype[name]) for name in s["exact_discs"].dtype.names])}),
    "a skin of nothing": (BED, lambda s: {"exact_skin": np.array(0.0)}),
    "a skin that is none": (BED, lambda s: {"exact_skin": np.array(np.nan)}),
    "a wide skin": (BED, lambda s: {"exact_skin": 100 * s["exact_skin"]}),
    "two skins": (BED, lambda s: {"exact_skin": np.array([0.03, 0.03])}),
    "a channel that is none": (BED, lambda s: {"exact_period": np.array(1.2)}),
    "fixed discs in a row": (BED, lambda s: {"exact_fixed": s["exact_fixed"].ravel()}),
    "fixed discs without end": (BED, lambda s: {"exact_fixed": item(s["exact_fixed"], 0, np.nan)}),
    "more fixed discs": (BED, lambda s: {"exact_fixed": np.tile(s["exact_fixed"], (2, 1))}),
    "wide fixed discs": (BED, lambda s: {"exact_fixed_diameters": 5 * s["exact_fixed_diameters"]}),
    "an array that nobody knows": (BED, lambda s: {"exact_more": s["exact_skin"]}),
    "chains without names": (BED, lambda s: {"chains": np.arange(3)}),
    "one chain": (BED, lambda s: {"chains": np.array("box")}),
    "an end of its own": (BED, lambda s: {"which": np.array("x\nshell touch PWNED")}),
    "discs as floats": (BED, lambda s: {"discs": s["discs"]["x"]}),
    "discs twice": (BED, lambda s: {"discs": np.concatenate([s["discs"], s["discs"]])}),
    "discs out of order": (BED, lambda s: {"discs": swapped(s["discs"])}),
    "contacts as floats": (BED, lambda s: {"contacts": s["contacts"]["foot"]}),
    "a contact with itself": (BED, lambda s: {"contacts": column(s["contacts"], "partner", s["contacts"]["disc"][3])}),
    "images of no disc": (SLOPE, lambda s: {"exact_list_owner": item(s["exact_list_owner"], -1, 1 << 30)}),
    "images elsewhere": (SLOPE, lambda s: {"exact_list_shift": item(s["exact_list_shift"], -1, 3.3)}),
    "discs that are shifted": (SLOPE, lambda s: {"exact_list_shift": item(s["exact_list_shift"], 0, 1.2)}),
    "no images": (SLOPE, without_images),
    "another channel": (SLOPE, lambda s: {"exact_period": 0.9 * s["exact_period"]}),
    "no channel": (SLOPE, lambda s: {"exact_period": np.array(0.0)}),
}  # fmt: skip
"""By what it is: the case, and arrays that take the place of those of a sound state."""


def test_a_number_that_no_run_has_is_refused(states, tmp_path, tried):
    path = tmp_path / "end.npz"
    edits = [(what, states[feature], change(states[feature])) for what, (feature, change) in WRONG.items()]
    sound = states[BED]
    edits += [(f"without {name}", {key: sound[key] for key in sound if key != name}, {}) for name in sound]
    edits = [one for one in edits if not one[0].startswith("without exact_list_o")]
    for what, stored, change in edits:
        print(what)
        write_arrays(path, **{**stored, **change})
        with pytest.raises(DumpError, match="holds no state of discs") as caught:
            read_ended(path)
        assert "\n" not in str(caught.value) and len(str(caught.value)) < 500, what
    tried(len(edits))


def packed(name: str = "of.npy", data: bytes = b"", **more: int) -> bytes:
    """A zip file of one entry whose head says more than it should."""
    file = BytesIO()
    with zipfile.ZipFile(file, "w") as out:
        out.writestr(name, data)
    told = bytearray(file.getvalue())
    for signature, places in ((b"PK\3\4", {"version": 4, "flags": 6}), (b"PK\1\2", {"version": 6, "flags": 8})):
        for word, value in more.items():
            at = told.index(signature) + places[word]
            told[at : at + 2] = value.to_bytes(2, "little")
    return bytes(told)


def npy(head: str) -> bytes:
    text = (head + "\n").encode()
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text


def many_members(count: int) -> bytes:
    file = BytesIO()
    with zipfile.ZipFile(file, "w") as out:
        for number in range(count):
            out.writestr(f"a{number}.npy", b"")
    return file.getvalue()


HEAD = "{{'descr': {kind}, 'fortran_order': False, 'shape': {shape}, }}"
ZIPS = {
    "encrypted": packed(flags=1),
    "of a version to come": packed(version=99),
    "many members": many_members(2_000),
    "a shape beyond all memory": packed(data=npy(HEAD.format(kind="'<f8'", shape=(10**22,)))),
    "a shape of 80 GB": packed(data=npy(HEAD.format(kind="'<f8'", shape=(10**10,)))),
    "a shape below nothing": packed(data=npy(HEAD.format(kind="'<f8'", shape=(-1, -1)))),
    "a shape of nothing": packed(data=npy(HEAD.format(kind="'<U0'", shape=(10**22,)))),
    "objects": packed(data=npy(HEAD.format(kind="'|O'", shape=(1,))) + b"cos\nsystem\n"),
    "a head that is code": packed(data=npy("__import__('os').system('touch PWNED')")),
    "a head without an end": packed(data=npy("((" * 4000)),
    "an array twice": b"",
    "no zip": b"PK",
    "nothing": b"",
    "an end alone": b"PK\5\6" + 18 * b"\0",
}


def test_oddities_of_zip_are_one_sentence(states, tmp_path, monkeypatch, tried):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "end.npz"
    with zipfile.ZipFile(file := BytesIO(), "w") as out, pytest.warns(UserWarning, match="Duplicate"):
        out.writestr("of.npy", b"")
        out.writestr("of.npy", b"")
    np.savez_compressed(compressed := BytesIO(), **states[BED])
    for data in ({**ZIPS, "an array twice": file.getvalue()} | {"compressed": compressed.getvalue()}).values():
        path.write_bytes(data)
        with pytest.raises(DumpError, match="holds no state of discs") as caught:
            read_ended(path)
        assert "\n" not in str(caught.value) and len(str(caught.value)) < 500
    assert not (tmp_path / "PWNED").exists()
    tried(len(ZIPS) + 1)


def mutant(stored: dict[str, np.ndarray], dice: random.Random) -> dict[str, np.ndarray]:
    """Arrays with values, lengths, kinds or places changed at random."""
    changed = dict(stored)
    values = [0, -1, 1, 2**31 - 1, -(2**31), 2**62, 0.5, 1e300, -1e300, float("nan"), float("inf"), 7, 1e-300]
    for _ in range(dice.choice((1, 1, 1, 2, 4))):
        name = dice.choice([*changed, "exact_list_start", "exact_list_discs", "list_discs", "near_faces", "near_discs"])
        array = changed.get(name, np.zeros(0))
        kind = dice.randrange(6)
        if kind == 0:
            changed.pop(name, None)
        elif kind == 1 and array.ndim:
            changed[name] = array[: dice.randrange(len(array) + 1)]
        elif kind == 2 and array.ndim and len(array):
            changed[name] = np.concatenate([array, array[: dice.randrange(len(array)) + 1]])
        elif kind == 3 and array.dtype.names is None and array.dtype.kind in "if":
            changed[name] = array.astype(dice.choice([np.int8, np.int32, np.int64, np.float32, np.float64]))
        elif array.size and array.dtype.kind != "U":
            array = array.copy()
            flat = array.reshape(-1)
            target = flat[dice.choice(array.dtype.names)] if array.dtype.names else flat
            with np.errstate(all="ignore"):
                target[dice.randrange(len(flat))] = np.array(dice.choice(values)).astype(target.dtype)
            changed[name] = array
    return changed


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_mutants_of_end_states_are_taken_or_refused(states, tmp_path, monkeypatch, tried):
    """Their checksums fit. A run that begins from one makes steps: a wrong index would end the test."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "case.yaml").write_text("name: run\n")
    path, times, refused = tmp_path / "run" / END_FILE, many(30, 1000), 0
    for seed in range(times):
        print(f"seed {seed}")
        dice = random.Random(seed)
        feature = dice.choice(list(states))
        write_arrays(path, **mutant(states[feature], dice))
        stored = {"status": "complete", "outputs": {END_FILE: checksum(path)}}
        write_json(tmp_path / "run" / "summary.json", stored)
        fields = {**BASE, **FEATURES[feature], "engine": {"name": "native"}}
        try:
            case = lj.load_case({**fields, "initial": [{"kind": "run", "folder": "run"}]})
            NativeSimulation(case.scene()).run(3)
        except (CaseError, RunError) as error:
            assert "\n" not in str(error) and len(str(error)) < 700
            refused += 1
    assert 0.5 * times < refused < times
    tried(times)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize(
    "feature", [BED, *(pytest.param(one, marks=pytest.mark.long) for one in (SLOPE, "a lid, `history`"))]
)
def test_mutants_of_saved_states_are_taken_or_refused(feature, tmp_path, tried):
    """Checkpoints whose checksums somebody made to fit: what is taken goes on for some steps."""
    save_state(simulation := stepped(feature), path := tmp_path / "state.npz")
    stored, times, refused = dict(read_arrays(path)), many(20, 400), 0
    for seed in range(times):
        print(f"seed {seed}")
        write_arrays(path, **mutant(stored, random.Random(f"{feature} {seed}")))
        try:
            load_state(simulation.scene, path).run(3)
        except (ResumeError, RunError) as error:
            assert "\n" not in str(error) and len(str(error)) < 600
            refused += 1
    assert 0.3 * times < refused < times
    tried(times)
