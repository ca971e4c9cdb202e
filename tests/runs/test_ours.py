# SPDX-License-Identifier: GPL-2.0-or-later
"""Which folders are ours, and what is never overwritten: the user's files, hard-linked backups, other runs."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest
from made_up import INPUTS, call, files, without_analysis

import lammps_jump as lj
from lammps_jump.analysis.report.player import make_player
from lammps_jump.analysis.report.run import write_report
from lammps_jump.dump.exports import read_netcdf
from lammps_jump.dump.find import read_forces
from lammps_jump.engines.lammps.outputs import read_log
from lammps_jump.files import text_of
from lammps_jump.folders import MARKER_FILE, Marker, clear, read_marker, write_marker
from lammps_jump.runs import start
from lammps_jump.runs.folder import default_folder, is_analysed
from lammps_jump.runs.results import flow_of, packed

pytestmark = pytest.mark.usefixtures("blank_pictures")

SHORT = {"run.duration": 0.1, "run.output_interval": 0.02, "engine.name": "native", "analysis.jump": False}
SETS = [word for path, value in SHORT.items() for word in ("--set", f"{path}={value}")]


@pytest.fixture(scope="module")
def case():
    return lj.load_case(INPUTS / "quick_jump.yaml", SHORT)


@pytest.fixture(scope="module")
def finished(case, tmp_path_factory):
    return case.run(tmp_path_factory.mktemp("ours") / "run").folder


@pytest.fixture
def folder(finished, tmp_path):
    return Path(shutil.copytree(finished, tmp_path / "run"))


def names(folder: Path) -> set[str]:
    return {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}


# --- files of the user -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("options", [[], ["--force"]])
@pytest.mark.parametrize("command", ["build-and-run", "build"])
@pytest.mark.fault("folders")
def test_a_folder_of_the_user_is_refused_with_what_stands_there(monkeypatch, capsys, tmp_path, command, options):
    """`build-and-run case.yaml --out .` deleted or overwrote six files of the user, the case among them."""
    monkeypatch.chdir(tmp_path)
    shutil.copy(INPUTS / "quick_jump.yaml", "case.yaml")
    Path("figures").mkdir()
    for name in ("energy.csv", "report.html", "figures/front.png", "checkpoint-7.npz", "mine.txt", "force_sill.csv"):
        Path(name).write_text("of the user")
    before = files(Path.cwd())
    status, _, message = call(monkeypatch, capsys, command, "case.yaml", "--out", ".", *SETS, *options)
    assert status == 2 and "case.yaml" in message and "and 3 more" in message and "--out" in message
    assert files(Path.cwd()) == before


@pytest.mark.parametrize("name", ["dump.lammpstrj", "figures", ".analysis.new"])
@pytest.mark.fault("folders")
def test_links_to_other_places_are_refused(case, tmp_path, name):
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / name).symlink_to(tmp_path / "elsewhere")
    with pytest.raises(lj.SetupError, match=f"holds {name}"):
        case.run(tmp_path / "run")
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


def test_figures_that_became_a_link_are_not_followed(folder, tmp_path):
    shutil.move(folder / "figures", tmp_path / "elsewhere")
    (folder / "figures").symlink_to(tmp_path / "elsewhere")
    before = files(tmp_path / "elsewhere")
    with pytest.raises(lj.SetupError, match="is a link to another place"):
        start.reanalyse(folder)
    assert files(tmp_path / "elsewhere") == before


@pytest.mark.parametrize("what", ["link", "file"])
@pytest.mark.fault("folders")
def test_figures_are_drawn_into_no_place_of_the_user(monkeypatch, capsys, folder, tmp_path, what):
    """`figures DIR` wrote through the link, and over files of a folder that is not ours."""
    shutil.move(folder / "figures", tmp_path / "elsewhere")
    if what == "link":
        (folder / "figures").symlink_to(tmp_path / "elsewhere")
    else:
        (tmp_path / "elsewhere").rename(folder / "figures")
        (folder / MARKER_FILE).unlink()
    before = files(tmp_path)
    status, _, message = call(monkeypatch, capsys, "figures", folder)
    said = {"link": "is a link to another place, where nothing is written", "file": "depth_profile.png: stands there"}
    assert status == 2 and said[what] in message and files(tmp_path) == before


@pytest.mark.fault("folders")
def test_nothing_is_written_through_a_link(monkeypatch, capsys, folder, tmp_path):
    """The names are ours by the marker, which is data: the files behind them are the user's."""
    victim = tmp_path / "victim"
    victim.write_text("of the user")
    for name in ("profiles.csv", "profiles_mean.csv", ".profiles.csv.new", "animation.gif", ".animation.gif.new"):
        (folder / name).symlink_to(victim)
    monkeypatch.setattr("lammps_jump.analysis.draw.film.has_ffmpeg", lambda: False)
    assert call(monkeypatch, capsys, "export", folder, "--csv")[0] == 0
    assert call(monkeypatch, capsys, "animate", folder)[0] == 0
    assert victim.read_text() == "of the user"
    assert not [name for name in ("profiles.csv", "animation.gif") if (folder / name).is_symlink()]


@pytest.mark.fault("folders")
def test_a_report_shows_pictures_of_its_folder_alone(folder, tmp_path):
    """A link in a received folder put a private file of its reader into the report."""
    holiday = (folder / "figures" / "snapshots.png").read_bytes()
    (tmp_path / "private").write_bytes(holiday)
    for name in ("figures/holiday.png", "animation.mp4"):
        (folder / name).symlink_to(tmp_path / "private")
    (folder / "figures" / "mine.png").write_bytes(holiday)
    (folder / "figures" / "secret.png").write_text("-----BEGIN PRIVATE KEY-----")
    (folder / "animation.gif").write_text("password")
    os.mkfifo(folder / "figures" / "a_pipe.png")
    (tmp_path / "stage").mkdir()
    seen = lj.open_run(folder).report(tmp_path / "page.html"), write_report(tmp_path / "stage", {}, run_folder=folder)
    for page in (path.read_text() for path in seen):
        assert "<figcaption>mine" in page
        for text in ("holiday", "The flow", "secret", "a_pipe", "data:video/mp4", "data:image/gif"):
            assert text not in page, text
    os.replace(folder / "figures", tmp_path / "elsewhere")
    (folder / "figures").symlink_to(tmp_path / "elsewhere")
    page = lj.open_run(folder).report(tmp_path / "page.html").read_text()
    assert "data:image/png" not in page and "data:image/webp" not in page


@pytest.mark.parametrize("name", ["forces.csv", "log.lammps", "jump_track.csv", "profiles.nc"])
@pytest.mark.fault("folders")
def test_pipes_in_a_folder_are_not_waited_for(folder, name):
    (folder / name).unlink(missing_ok=True)
    os.mkfifo(folder / name)
    with pytest.raises(lj.JumpError, match="no regular file"):
        READERS[name](folder / name)
    if name == "forces.csv":
        with pytest.raises(lj.JumpError, match=r"forces\.csv is gone.*no regular file"):
            start.reanalyse(folder)


def track(path: Path) -> None:
    """The table of the jump is left out of a page where it cannot be read."""
    run = lj.open_run(path.parent)
    player = make_player(packed(flow_of(run.case), path.parent), path.parent)
    assert player is not None and set(player.header["sequent"]) == {None}
    text_of(path)


READERS = {"forces.csv": read_forces, "log.lammps": read_log, "jump_track.csv": track, "profiles.nc": read_netcdf}


@pytest.mark.fault("folders")
def test_a_pipe_among_the_results_is_not_waited_for(case, folder):
    (folder / "profiles.nc").unlink()
    os.mkfifo(folder / "profiles.nc")
    assert not is_analysed(case, folder, lj.open_run(folder).summary)


@pytest.mark.fault("folders")
def test_other_files_of_the_user_stay_beside_a_run(case, tmp_path, monkeypatch):
    without_analysis(monkeypatch)
    (tmp_path / "mine.txt").write_text("of the user")
    case.run(tmp_path)
    case.run(tmp_path, force=True)
    assert (tmp_path / "mine.txt").read_text() == "of the user" and (tmp_path / "report.html").exists()


def test_only_known_names_of_a_marker_are_believed(tmp_path):
    folder = tmp_path / "run"
    mine = [tmp_path / "victim.txt", folder / "notes.txt", folder / "a" / "force_x.csv"]
    (folder / "a").mkdir(parents=True)
    for path in mine:
        path.write_text("of the user")
    write_marker(folder, Marker("run", ("../victim.txt", "notes.txt", "*", "a/force_x.csv", "force_../a.csv"), {}))
    assert read_marker(folder).files == ()
    clear(folder, ["../victim.txt", "notes.txt", "*", "a/force_x.csv"])
    assert all(path.exists() for path in mine)


@pytest.mark.parametrize("text", ["", "[]", '{"files": 3, "kind": "run", "about": {}}', "[" * 100_000])
@pytest.mark.fault("values in JSON files")
def test_a_marker_that_is_none_is_refused(monkeypatch, capsys, folder, text):
    (folder / MARKER_FILE).write_text(text)
    before = files(folder)
    for command in (["run", folder, "--force"], ["analyze", folder], ["run", folder, "--resume"]):
        status, _, message = call(monkeypatch, capsys, *command)
        assert status == 2 and "is no marker" in message
    assert files(folder) == before


@pytest.mark.fault("folders")
def test_analysis_of_a_dump_overwrites_nothing(monkeypatch, capsys, folder, tmp_path):
    dump, out = folder / "dump.lammpstrj", tmp_path / "out"
    out.mkdir()
    (out / "profiles.nc").write_text("of the user")
    for place, said in ((out, "holds profiles.nc"), (folder, "holds a run")):
        before = files(tmp_path)
        status, _, message = call(monkeypatch, capsys, "analyze", dump, "--out", place)
        assert status == 2 and said in message and files(tmp_path) == before
    other = tmp_path / "other"
    for _ in range(2):  # again is no harm
        assert call(monkeypatch, capsys, "analyze", dump, "--out", other)[0] == 0
    assert {"summary.json", "profiles.nc", MARKER_FILE} <= names(other)
    shutil.copy(dump, tmp_path / "dump.of_another")
    before = files(other)
    status, _, message = call(monkeypatch, capsys, "analyze", tmp_path / "dump.of_another", "--out", other)
    assert status == 2 and f"holds the analysis of {dump}" in message and files(other) == before
    status, _, message = call(monkeypatch, capsys, "build-and-run", INPUTS / "quick_jump.yaml", "--out", other, *SETS)
    assert status == 2 and "holds the analysis of a dump" in message and files(other) == before


@pytest.mark.fault("folders")
def test_a_film_overwrites_nothing(monkeypatch, capsys, folder, tmp_path):
    film = tmp_path / "film.gif"
    film.write_text("of the user")
    status, _, message = call(monkeypatch, capsys, "animate", folder, "--out", film)
    assert status == 2 and "stands there already" in message and film.read_text() == "of the user"
    film.unlink()
    assert call(monkeypatch, capsys, "animate", folder, "--out", film)[0] == 0 and film.stat().st_size > 1000
    for _ in range(2):  # that of a run folder is ours
        assert call(monkeypatch, capsys, "animate", folder)[0] == 0
    assert not [name for name in names(tmp_path) if name.endswith((".new", ".lock"))]


@pytest.mark.fault("folders")
def test_exports_overwrite_nothing(monkeypatch, capsys, folder, tmp_path):
    out = tmp_path / "tables"
    out.mkdir()
    (out / "profiles.csv").write_text("of the user")
    status, _, message = call(monkeypatch, capsys, "export", folder, "--csv", "--out", out)
    assert status == 2 and "profiles.csv" in message and (out / "profiles.csv").read_text() == "of the user"
    for _ in range(2):
        assert call(monkeypatch, capsys, "export", folder, "--csv")[0] == 0


def test_a_run_folder_without_marker_is_only_read(monkeypatch, capsys, folder):
    (folder / MARKER_FILE).unlink()
    before = files(folder)
    status, _, message = call(monkeypatch, capsys, "analyze", folder)
    assert status == 2 and MARKER_FILE in message and "--out OTHER" in message
    assert call(monkeypatch, capsys, "run", folder, "--force")[0] == 2
    with pytest.raises(lj.SetupError, match="stands there already"):
        lj.open_run(folder).report()
    assert lj.open_run(folder).status == "complete" and files(folder) == before


def linked(folder: Path, backup: Path) -> dict[str, bytes]:
    """A backup as of ``cp -al``; its files."""
    shutil.copytree(folder, backup, copy_function=os.link)
    return files(backup)


@pytest.mark.fault("folders")
def test_hard_linked_backups_stay_as_they_are(case, folder, tmp_path, monkeypatch):
    """The next analyze or resume wrote into them."""
    before = linked(folder, tmp_path / "one")
    start.reanalyse(folder, ["analysis.bin_width=2"])
    assert files(tmp_path / "one") == before
    without_analysis(monkeypatch)
    long = case.replace({"run.duration": 50})
    with pytest.raises(lj.RunInterrupted):
        long.run(tmp_path / "long", should_stop=lambda: True)
    before = linked(tmp_path / "long", tmp_path / "two")
    with pytest.raises(lj.RunInterrupted):
        long.run(tmp_path / "long", resume=True, should_stop=lambda: True)
    assert files(tmp_path / "two") == before
    before = linked(tmp_path / "long", tmp_path / "three")
    case.run(tmp_path / "long", force=True)
    assert files(tmp_path / "three") == before


# --- runs of the user ------------------------------------------------------------------------------------------------


def test_variants_of_a_case_have_folders_of_their_own(tmp_path, monkeypatch):
    """A copied template overwrote the template's run, and a second --set the first."""
    monkeypatch.chdir(tmp_path)
    without_analysis(monkeypatch)
    shutil.copy(INPUTS / "quick_jump.yaml", "mine.yaml")

    def folder(*changes, **more):
        return default_folder(lj.load_case("mine.yaml", list(changes) or more.get("changes")))

    assert str(folder()) == "runs/mine"
    assert str(folder("contact.friction=0.1")) == "runs/mine,contact.friction=0.1"
    both = ["run.duration=2", "contact.friction = 0.1"]
    assert str(folder(*both)) == str(folder(*both[::-1])) == "runs/mine,contact.friction=0.1,run.duration=2"
    assert folder("walls.sill.y=[-10, 3]") == folder(changes={"walls.sill.y": [-10, 3]})
    many = [f"contact.friction={value}" for value in ("0.1", "0.1" + 100 * "0", "0.2" + 100 * "0")]
    assert len({folder(text) for text in many}) == 3 and all(len(folder(text).name) <= 100 for text in many)
    assert folder("description=a/../b").parent == Path("runs") and "/" not in folder("description=a/../b").name
    assert str(default_folder(lj.load_case({**lj.load_case("mine.yaml").core, "name": "x"}))) == "runs/x"
    case = lj.load_case("mine.yaml", SHORT).replace({"run.seed": 5})
    assert (
        case.run().folder.name
        == "mine,analysis.jump=false,engine.name=native,run.duration=0.1,run.output_interval=0.02,run.seed=5"
    )


@pytest.mark.fault("folders")
def test_another_run_is_refused_with_what_differs(case, folder):
    before = files(folder)
    for changes, said in (
        ({"contact.friction": 0.1}, "contact.friction is 0.0 there, 0.1 here"),
        ({"walls.sill.y": [-10, 3]}, "walls.1.y"),
        ({"engine.name": "lammps", "engine.kernel": "stock"}, "engine.name is native there, lammps here"),
    ):
        with pytest.raises(lj.SetupError, match="holds another run") as caught:
            case.replace(changes).run(folder)
        assert said in str(caught.value) and "--out" in str(caught.value) and "--force" in str(caught.value)
        with pytest.raises(lj.SetupError, match="holds a run"):
            start.build(case.replace(changes), folder)
    assert files(folder) == before
    assert case.replace({"contact.friction": 0.1}).run(folder, force=True).case.fields.contact.friction == 0.1


def test_another_version_is_another_run(case, folder, monkeypatch):
    monkeypatch.setattr("lammps_jump.engines.choice.__version__", "9.9")
    with pytest.raises(lj.SetupError, match=r"lammps_jump is .* there, 9\.9 here"):
        case.run(folder)


def test_a_changed_window_or_description_is_analysed_and_not_run_again(case, folder):
    dump, stored = folder / "dump.lammpstrj", lj.open_run(folder).summary
    stamp = dump.stat().st_mtime_ns
    changed = case.replace({"analysis.window": [0.05, 0.1], "description": "another"})
    run = changed.run(folder)
    assert run.summary["profiles"]["window"] == [0.05, 0.1] and run.summary["description"] == "another"
    assert run.summary["key"] == stored["key"] and run.summary["analysed"]["key"] != stored["analysed"]["key"]
    assert run.case.fields.analysis.window == (0.05, 0.1) and dump.stat().st_mtime_ns == stamp
    before = files(folder)
    changed.run(folder)
    assert files(folder) == before  # nothing to do


def test_an_edited_case_without_its_hashes_is_refused_with_the_field(monkeypatch, capsys, folder):
    """The diameter was changed in case.yaml: analyze gave other numbers and status 0."""
    path = folder / "case.yaml"
    path.write_text(path.read_text().partition("\n")[2].replace("diameter: 0.15", "diameter: 0.16"))
    before = files(folder)
    for command in (["analyze", folder], ["run", folder], ["run", folder, "--resume"]):
        status, _, message = call(monkeypatch, capsys, *command)
        assert status == 2 and "discs.diameter is 0.15 there, 0.16 here" in message
    assert files(folder) == before


def test_a_finished_run_is_not_run_again_by_its_folder(monkeypatch, capsys, folder):
    before = files(folder)
    status, output, _ = call(monkeypatch, capsys, "run", folder)
    assert status == 0 and "nothing to do" in output and files(folder) == before
    assert call(monkeypatch, capsys, "run", folder, "--force", "-q")[0] == 0 and files(folder) != before
