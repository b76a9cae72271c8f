"""aomc-sky verify --scene AMC_INP FILE: photons that another code made."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import aomc_sky as sky
from tests.support.fault_rows import command
from tests.support.mcpl import oracle
from tests.support.scenes import scene_with_circle
from tests.support.shared import INPUTS
from tests.support.verified import directions_of, uniform_in_zenith_angle

SCENE = INPUTS / "clear_day" / "amc.inp"
SMALL = INPUTS / "document_example" / "amc.inp"
FIRST = ("--waveband", 1)
DOWN = np.array([1, 1, -1], dtype=np.float32)
N = 60_000


@pytest.fixture(scope="module")
def scene():
    return sky.read_scene(SCENE, iterations=N)


@pytest.fixture(scope="module")
def photons(scene):
    """Independent photons of the first waveband, as another code would draw them."""
    return directions_of(scene.source(9, method="iid"))


@pytest.fixture
def verify(tmp_path, capsys):
    """Verify a file, an array in a file, or an MCPL file of a source: exit code, checks that failed, the report."""

    def call(given, *words, scene=SCENE):
        path = given
        if isinstance(given, sky.PhotonSource):
            sky.write_mcpl(given, path := tmp_path / "given.mcpl")
        elif not isinstance(given, Path):
            np.save(path := tmp_path / "theirs.npy", given)
        capsys.readouterr()
        code = command("verify", "--scene", scene, path, "--json", *words)
        report = json.loads(capsys.readouterr().out)
        return code, {check["name"] for check in report["checks"] if not check["passed"]}, report

    return call


def made_again(report):
    return [check["detail"] for check in report["checks"] if check["name"] == "photons made again"]


def weighted(rows, *weights):
    return np.column_stack([rows, np.resize(np.array(weights, dtype=rows.dtype), len(rows))])


ARRAYS = {
    # name: (what is done to independent photons, options, the check that fails)
    "float32": (lambda rows: rows.astype("<f4"), (), ""),
    "float64 of the other byte order": (lambda rows: rows.astype(">f8"), (), ""),
    "z downwards": (lambda rows: rows * DOWN, (), "photons come from above"),
    "z downwards in its frame": (lambda rows: rows * DOWN, ("--frame", "down"), ""),
    "a long vector": (lambda rows: np.concatenate([1.01 * rows[:1], rows[1:]]), (), "directions are unit vectors"),
    "no photon": (lambda rows: rows[:0], (), "photons"),  # nothing was tested
    "weights below zero": (lambda rows: weighted(rows, -1.0), (), "weights"),
    "weights of zero": (lambda rows: weighted(rows, 0.0), (), "weights"),
    "some weights below zero": (lambda rows: weighted(rows, 1.0, -1.0), (), "weights"),
}


@pytest.mark.parametrize("name", ARRAYS)
def test_independent_photons_in_an_array(verify, photons, name):
    change, words, wrong = ARRAYS[name]
    code, failed, report = verify(change(photons), *FIRST, *words)
    assert (code, failed) == ((1, {wrong}) if wrong else (0, set()))
    assert wrong or report["tests"] == 10
    assert name != "z downwards" or any("--frame" in check["detail"] for check in report["checks"])


def test_a_defect_fails_and_photons_that_are_too_even(verify, photons, scene):
    spoilt, even = uniform_in_zenith_angle(photons, 0.1), directions_of(scene.source(9))
    for given, is_even in ((spoilt, False), (even, True)):
        code, failed, report = verify(given, *FIRST)
        assert code == 1
        assert {"mu^2: chi-square, two-sided", "mu^2 x azimuth: chi-square, two-sided"} & failed
        assert any("--method stratified" in note for note in report["notes"]) == is_even
        pulls = [abs(cell["pull"]) for cell in report["worst"][0]["cells"][:2]]
        assert is_even or pulls[0] >= pulls[1] > 4
    code, _, report = verify(even, *FIRST, "--method", "stratified")
    assert (code, report["notes"]) == (0, [])


def test_weights_in_a_column_and_in_a_file(verify, photons, tmp_path):
    chance = 0.5 - 0.5 * photons[:, 2]
    kept = np.random.default_rng(1).random(len(photons)) < chance
    directions, weight = photons[kept], (1 / chance[kept]).astype(np.float32)
    np.save(tmp_path / "weights.npy", weight)
    assert verify(directions, *FIRST)[0] == 1
    assert verify(np.column_stack([directions, weight]), *FIRST)[0] == 0
    code, _, report = verify(directions, *FIRST, "--weights", tmp_path / "weights.npy")
    assert code == 0
    assert any("weights" in check["name"] for check in report["checks"])


def test_mcpl_knows_its_wavebands(verify, scene):
    source = scene.source(9, method="iid")
    code, _, report = verify(source)
    assert (code, {check["waveband"] for check in report["checks"]}) == (0, {1, 2, 3})
    code, _, report = verify(source, "--waveband", 2)
    assert code == 0
    assert any("120000 of 180000 photons belong to other wavebands" in note for note in report["notes"])


@pytest.mark.parametrize(("method", "precision"), [(None, "float32"), ("iid", "float64")])
def test_our_own_files_say_how_to_test_them(verify, method, precision, tmp_path):
    """Default files pass without an option: the header names a plan, and every photon is compared with it."""
    path = tmp_path / "ours.mcpl"
    source = sky.read_scene(SMALL, iterations=5000).source(2**63 + 5, method=method, precision=precision)
    sky.write_mcpl(source, path)
    code, _, report = verify(path, scene=SMALL)
    assert (code, made_again(report)) == (0, ["all 5000 photons agree with the plan"] * 3)
    assert f"one run of aomc-sky, seed {2**63 + 5}, and its plan is the plan of this scene" in report["notes"][0]
    assert verify(path, "--iterations", 5001, scene=SMALL)[0] == 0  # another plan: what the photons are is tested


COLUMNS = {
    "direction": ("direction", 1e-12), "energy": ("ekin", 1e-15), "position": ("position", 1e-9),
    "time": ("time", 1e-9), "user_flags": ("userflags", 1), "weight": ("weight", 1e-12),
    "polarisation": ("polarisation", 1e-9),
}  # fmt: skip
"""What one photon of a file differs by, in libmcpl's units."""


def written_again(folder, source, change, **header):
    library, ours, again = oracle(), folder / "ours.mcpl", folder / "again.mcpl"
    sky.write_mcpl(source, ours)
    particles = library.read(ours).copy()
    change(particles)
    library.write(again, replace(sky.files.read_mcpl(ours).header, **header), [particles])
    return again


@pytest.mark.parametrize("column", COLUMNS)
def test_each_column_of_a_file_is_compared(verify, column, tmp_path):
    """A file of ours that libmcpl wrote again agrees; with one value changed the report names its column and photon."""
    amc = scene_with_circle(tmp_path / "circle")
    source = sky.read_scene(amc, iterations=3000).source(4, precision="float64", weights=True)
    name, step = COLUMNS[column]

    def change(particles):
        values = particles[name]
        values[7, ...] += np.array(step if values.ndim == 1 else [0, step, 0]).astype(values.dtype)

    right = "all 3000 photons agree with the plan"
    wrong = f"1 of 3000 photons differ from the plan in {column}; the first is photon 7"
    for code, spoil, said in ((0, len, right), (1, change, wrong)):
        found, _, report = verify(written_again(tmp_path, source, spoil, has_polarisation=True), scene=amc)
        assert (found, made_again(report)) == (code, [said, right, right])
        note = next(note for note in report["notes"] if note.startswith("compared with the plan: "))
        assert set(note.removeprefix("compared with the plan: ").split(", ")) == set(COLUMNS)


DAMAGES = {
    "one energy": lambda particles: particles["ekin"].__setitem__(7, 1.001 * particles["ekin"][7]),
    "one kind": lambda particles: particles["pdgcode"].__setitem__(7, 2112),
    "energies of a waveband": lambda particles: particles["ekin"].__setitem__(slice(3000), 3e-6),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_photons_that_left_their_waveband_are_missed(verify, damage, tmp_path):
    """The head names the plan of the scene; a photon of another energy or kind is none of its waveband."""
    source = sky.read_scene(SMALL, iterations=3000).source(4)
    path = written_again(tmp_path, source, DAMAGES[damage], pdg_code=0)
    for words in ((), FIRST):
        code, failed, report = verify(path, *words, scene=SMALL)
        assert (code, "numbers of photons" in failed) == (1, True)
        assert "its plan is the plan of this scene" in str(report["notes"])


def test_optical_photons_are_photons(verify, tmp_path):
    """PDG code -22, Geant4's; another particle is none, and is said."""
    source = sky.read_scene(SMALL, iterations=5000).source(4)
    for code in (22, -22, np.int64(-22)):
        sky.write_mcpl(source, tmp_path / "ours.mcpl", pdg_code=code)
        assert sky.files.read_mcpl(tmp_path / "ours.mcpl").header.pdg_code == code
        assert verify(tmp_path / "ours.mcpl", scene=SMALL)[0] == 0
    for code in (2112, 0, 22.5, "22"):
        with pytest.raises(sky.UsageError, match="pdg_code"):
            sky.write_mcpl(source, tmp_path / "ours.mcpl", pdg_code=code)


@pytest.mark.filterwarnings("ignore::aomc_sky.InputWarning")
def test_the_numbers_of_photons_come_from_the_file(tmp_path, told):
    """Wavebands that differ in number, and a run of other iterations than amc.inp says: compared photon by photon."""
    files, path = INPUTS / "sun_and_sky", tmp_path / "ours.mcpl"
    source = sky.read_scene(files, iterations=700).source(4)
    sky.write_mcpl(source, path)
    assert len({source.n_photons(band) for band in range(source.n_bands)}) > 1
    same = "is the plan of this scene: every photon is compared with it"
    for words, said in (((), same), (("--waveband", 2), same), (("--iterations", 701), "is not the plan of this")):
        assert f"its plan {said}" in told("verify", "--scene", files, path, *words).out


@pytest.mark.parametrize(
    ("methods", "words"),
    [((None, None), "as stratified ones"), (("iid", "iid"), "as independent ones"), ((None, "iid"), "evenly or not")],
)
def test_merged_files_of_ours(verify, methods, words, scene, tmp_path):
    paths = [tmp_path / f"{k}.mcpl" for k in range(2)]
    for seed, (method, path) in enumerate(zip(methods, paths, strict=True)):
        sky.write_mcpl(scene.source(seed, method=method), path)
    oracle().tool("--merge", tmp_path / "all.mcpl", *paths)
    code, failed, report = verify(tmp_path / "all.mcpl")
    assert (code, failed) == (0, set())
    assert "2 runs of aomc-sky: photons " in report["notes"][0]
    assert words in report["notes"][0]


def test_drawn_numbers_weights_and_a_part_of_a_file(verify, scene, tmp_path):
    """What is neither iid nor stratified, and a part of a stratified file: only too uneven ones fail."""
    weighted = sky.read_scene(SCENE, iterations=N, weighting="solid-angle").source(4, weights=True)
    for source, words, judged in (
        (scene.source(1, allocation="multinomial"), (), "may be spread evenly"),
        (weighted, ("--weighting", "solid-angle"), "are tested as stratified ones"),
    ):
        code, failed, report = verify(source, "--iterations", 7, *words)
        assert (code, failed) == (0, set())
        assert f"its plan is not the plan of this scene: photons {judged}" in report["notes"][0]
    assert any("weights" in check["name"] for check in report["checks"])
    sky.write_mcpl(scene.source(1), tmp_path / "whole.mcpl")
    oracle().tool("--extract", "-l50000", tmp_path / "whole.mcpl", tmp_path / "part.mcpl")
    assert verify(tmp_path / "part.mcpl", "--method", "iid")[0] == 1  # five sixths of them are still too even
    code, failed, report = verify(tmp_path / "part.mcpl")
    assert (code, failed) == (0, set())
    assert "but not which part of them is in the file: photons may be spread evenly or not" in "".join(report["notes"])


def test_the_programs_lattice(verify):
    source = sky.read_scene(SMALL, compat="aomc", iterations=N).source(0)
    down = directions_of(source) * DOWN
    words = ("--compat", "aomc", "--frame", "down", "--method", "stratified", *FIRST)
    assert verify(down, *words, scene=SMALL)[0] == 0
    frame = sky.directions.Frame.DOWN
    zenith, azimuth = np.rad2deg(sky.directions.sky_from_travel(down, frame))
    assert verify(sky.directions.travel_from_sky(zenith, azimuth + 3.0, frame), *words, scene=SMALL)[0] == 1


def test_photons_from_dark_zones(verify):
    scene = INPUTS / "sparse_sky" / "amc.inp"
    directions = directions_of(sky.read_scene(scene, iterations=5000).source(1, method="iid"))
    assert verify(directions, *FIRST, scene=scene)[0] == 0
    code, failed, _ = verify(uniform_in_zenith_angle(directions, 0.002, 85), *FIRST, scene=scene)
    assert code == 1
    assert "no photon from dark zones" in failed
