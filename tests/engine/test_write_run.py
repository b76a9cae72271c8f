"""A run folder from Python: the bytes of the command, and what it refuses."""

import pytest

import aomc_sky as sky
from aomc_sky.cli.main import main
from tests.support.shared import INPUTS


def overcast(zenith, azimuth, wavelength_nm):
    return 1.5 - zenith / 2


def files_of(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.name != "manifest.json"}


def test_the_files_are_those_of_the_command(tmp_path):
    scene = sky.read_scene(INPUTS / "perez_sky", iterations=3000)
    manifest = sky.write_run(scene, tmp_path / "a", seed=7, method="iid", formats=["npy", "mcpl"], threads=1)
    words = ["--iterations", "3000", "--seed", "7", "--method", "iid", "--format", "npy", "--format", "mcpl", "-q"]
    assert main(["run", str(INPUTS / "perez_sky"), *words, "--out", str(tmp_path / "b")]) == 0
    assert files_of(tmp_path / "a") == files_of(tmp_path / "b")
    assert manifest["seed"] == 7


def test_a_scene_of_no_file_is_a_run_that_verify_passes(tmp_path):
    scene = sky.Scene(wavebands=[440, 550], n_photons=20_000, components=overcast)
    first = sky.write_run(scene, tmp_path / "mine", formats="npy")
    assert sky.write_run(scene, tmp_path / "mine") == first  # finished before
    assert main(["verify", str(tmp_path / "mine")]) == 0
    with pytest.raises(sky.AomcSkyError, match="holds another run"):
        sky.write_run(scene, tmp_path / "mine", seed=1)
    replaced = sky.write_run(scene, tmp_path / "mine", seed=1, force=True, formats=())
    assert replaced["files"].keys() == {"plan.npz", "counts.csv"}


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"formats": ["npz"]}, "formats are npy, mcpl, raw, source, got 'npz'"),
        ({"threads": -1}, "threads must be a whole number"),
        ({"out": ""}, "out is empty"),
        ({"out": INPUTS / "perez_sky"}, "is the folder of the scene itself"),
    ],
)
def test_what_is_refused(tmp_path, options, message):
    scene = sky.read_scene(INPUTS / "perez_sky", iterations=10)
    with pytest.raises(sky.UsageError, match=message):
        sky.write_run(scene, **({"out": tmp_path / "x"} | options))
    assert not (tmp_path / "x").exists()
