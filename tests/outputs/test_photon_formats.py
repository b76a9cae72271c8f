"""One table of formats: names in a run folder, what --force removes, what verify reads, what commands offer."""

import pytest

from aomc_sky import read_scene, write_run
from aomc_sky.outputs.photon_formats import PHOTON_FORMATS, SOURCE, formats_of, photon_writer, run_formats
from aomc_sky.outputs.run_folder import is_run_file
from tests.support.fault_rows import command
from tests.support.shared import INPUTS

DOUBLES = {"photons-0001.f64", "photons-0002.f64", "photons-0003.f64"}


def write(out, seed, formats=("double",), wavebands=None, **options):
    scene = read_scene(INPUTS / "document_example", iterations=100, wavebands=wavebands)
    return write_run(scene, out, seed=seed, formats=formats, precision="float64", **options)


@pytest.mark.parametrize(
    ("new", "left"),
    [
        ({}, DOUBLES),
        ({"wavebands": [2]}, {"photons-0002.f64"}),
        ({"formats": ("mcpl",)}, {"photons.mcpl"}),
        ({"formats": ()}, set()),
    ],
    ids=["seed", "fewer wavebands", "another format", "no photons"],
)
def test_no_file_of_an_old_run_stays_or_passes(double, tmp_path, new, left):
    always = {"plan.npz", "counts.csv"}
    assert set(write(tmp_path, 1)["files"]) == {*always, *DOUBLES}
    assert command("verify", tmp_path, "-q") == 0
    old = {name: (tmp_path / name).read_bytes() for name in DOUBLES}
    assert set(write(tmp_path, 2, force=True, **new)["files"]) == {*always, *left}
    assert {path.name for path in tmp_path.iterdir()} == {*always, *left, "manifest.json"}
    assert command("verify", tmp_path, "-q") == 0
    for name in DOUBLES:  # whether the new run has a file of this name or not
        kept = (tmp_path / name).read_bytes() if name in left else None
        (tmp_path / name).write_bytes(old[name])
        assert command("verify", tmp_path, "-q") == 5, name
        (tmp_path / name).unlink() if kept is None else (tmp_path / name).write_bytes(kept)
    assert command("verify", tmp_path, "-q") == 0


@pytest.mark.parametrize("name", ["photons-0004.npy", "positions-0001.npy", "photons-0001.csv", "photons.mcpl"])
def test_a_photon_file_that_the_plan_does_not_make_fails(tmp_path, name, told):
    write(tmp_path, 1, ("npy",))
    (tmp_path / name).write_bytes(b"left")
    assert name in told("verify", tmp_path, code=1 if name in ("photons-0001.csv", "photons.mcpl") else 5).out


def test_every_file_of_a_format_is_known_by_its_name_and_to_one_format(double):
    source = read_scene(INPUTS / "document_example", iterations=10).source(seed=1)
    for name in PHOTON_FORMATS:
        for layout in photon_writer(name)(source).layouts((0,)):
            assert (formats_of([layout.name]), is_run_file(layout.name)) == ({layout.name: name}, True)
        for pattern in photon_writer(name).names:
            files = [pattern.format(band) for band in (1, 9999, 10_000)]
            assert formats_of(files) == dict.fromkeys(files, name)
    assert formats_of(["photons-0001.double", "double", "plan.npz", "counts.csv"]) == {}


def test_a_run_and_the_command_line_offer_a_new_format(double, tmp_path):
    assert run_formats() == ["npy", "mcpl", "raw", "double", SOURCE]
    words = ("run", INPUTS / "document_example", "--iterations", 10, "--out", tmp_path / "out", "-q")
    assert command(*words, "--format", "double") == 0
    assert {path.name for path in (tmp_path / "out").iterdir()} >= DOUBLES
