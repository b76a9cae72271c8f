"""Row 48 of the matrix: outputs named so that they would mix with, or replace, what is not ours."""

import shutil
from importlib.util import find_spec
from pathlib import Path

import pytest

from aomc_sky.outputs.run_folder import check_target, is_ours
from tests.support.fault_rows import command, row
from tests.support.shared import INPUTS

needs_matplotlib = pytest.mark.skipif(find_spec("matplotlib") is None, reason="draws pictures")
PEREZ = ("perez", "--dni", "850", "--dhi", "95", "--sun-zenith", "40", "--bins", "4", "8", "-q")


def files_of(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


def ways_to(scene):
    """The folder of the scene under several names, and where the command stands."""
    (scene.parent / "link").symlink_to(scene)
    return {
        "absolute": (str(scene), scene.parent),
        "dot": (".", scene),
        "relative": (f"./{scene.name}/../{scene.name}/", scene.parent),
        "link": (str(scene.parent / "link"), scene.parent),
        "empty": ("", scene),
    }


@row(48, "absolute", "dot", "relative", "link", "empty")
def test_the_folder_of_the_scene_is_no_run_folder(fault, scene, monkeypatch, told):
    before = files_of(scene)
    out, where = ways_to(scene)[fault]
    monkeypatch.chdir(where)
    for more in ((), ("--force",), ("--shard", "1/2")):
        assert "aomc-sky-out" in told("run", scene, "--iterations", 100, "-q", "--out", out, *more, code=2).err
        assert files_of(scene) == before


FOREIGN = ("counts.csv", "photons-0001.npy", "manifest.json", "weights-0002.npy", "plan.npz", "counts.npz")


@row(48, *(f"foreign-{name}" for name in FOREIGN), "plan-lost")
def test_files_of_others_under_our_names_stay(fault, scene, tmp_path, told):
    """A run that has lost its plan is one of others, too."""
    out = tmp_path / "out"
    words = ["run", scene, "--iterations", 100, "-q", "--out", out]
    if fault == "plan-lost":
        told(*words)
        (out / "plan.npz").unlink()
    else:
        out.mkdir()
        (out / fault.removeprefix("foreign-")).write_bytes(b"mine, and not yours")
    (out / "notes.txt").write_text("mine")
    before = files_of(out)
    for more in ((), ("--force",)):
        code = 5 if fault == "foreign-plan.npz" and not more else 2
        assert "--out" in told(*words, *more, code=code).err
        assert files_of(out) == before


OWN = {
    "skydist": (*PEREZ, "--write-skydist", "mine.txt"),
    "svg": ("plot", INPUTS / "document_example", "-q", "--out", "mine.svg"),
    "pdf": ("plot", INPUTS / "document_example", "-q", "--out", "mine.pdf"),
    "of-a-scene": ("plot", INPUTS / "document_example", "-q", "--out", "mine.png"),
    "skydist-of-the-program": (*PEREZ, "--write-skydist", "skydist.inp"),
}


@needs_matplotlib
@row(48, *(f"target-{name}" for name in OWN))
def test_a_file_of_others_is_replaced_by_force_alone(fault, tmp_path, monkeypatch, told):
    """What the command then wrote is its own, and the next one replaces it without a word."""
    monkeypatch.chdir(tmp_path)
    words = OWN[fault.removeprefix("target-")]
    target = Path(words[-1])
    target.write_bytes(b"\x89PNG\r\n\x1a\nmine")
    if fault.endswith("program"):
        shutil.copy(INPUTS / "document_example" / "skydist.inp", target)
    before = target.read_bytes()
    err = told(*words, code=5).err
    assert "--force" in err
    assert f"new-{target}" in err
    assert target.read_bytes() == before
    assert command(*words, "--force") == 0
    assert is_ours(target)
    first = target.read_bytes()
    assert command(*words) == 0
    assert target.read_bytes() == first


@row(48, "the-file-that-is-read")
def test_a_file_that_the_command_reads_is_no_target(fault, tmp_path):
    from aomc_sky.errors import UsageError

    (tmp_path / "city.h5").write_text("data")
    (tmp_path / "link.nc").symlink_to("city.h5")
    with pytest.raises(UsageError, match="never replaced"):
        check_target(tmp_path / "link.nc", "--netcdf", force=True, inputs=[tmp_path / "city.h5"])


@row(48, "atmosphere")
def test_the_tables_of_an_atmosphere_replace_nothing_of_others(fault, tmp_path, capsys):
    model = Path(shutil.copy(INPUTS / "atmosphere" / "molecules_only.atmo", tmp_path / "params.atmo"))
    before = model.read_bytes()
    words = ("atmosphere", model, "--out-dir", tmp_path, "--no-netcdf", "-q")
    assert command(*words, "--force") == 2
    assert model.read_bytes() == before
    other = tmp_path / "tables"
    other.mkdir()
    (other / "report.json").write_text('{"mine": 1}')
    assert command("atmosphere", model, "--out-dir", other, "--no-netcdf", "-q") == 5
    assert (other / "report.json").read_text() == '{"mine": 1}'


@row(48, "names-that-only-look-like-ours")
def test_force_removes_what_a_run_made_and_nothing_else(fault, scene, tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    mine = ("photons-of-my-cat.jpg", "counts.xlsx", "blocks-of-flats.npy", "weights-.npy", ".aomc-sky-mine")
    words = ["run", scene, "--iterations", 100, "-q", "--out", out]
    assert command(*words) == 0
    for name in mine:
        (out / name).write_text(name)
    assert command(*words, "--seed", 1) == 5
    assert command(*words, "--seed", 1, "--force") == 0
    assert {name: (out / name).read_text() for name in mine} == {name: name for name in mine}
    assert command("verify", out, "-q") == 0
