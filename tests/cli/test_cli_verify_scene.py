"""aomc-sky verify --scene AMC_INP FILE: photons that another code made."""

import json
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.cli.main import main
from tests.support.mcpl import oracle
from tests.support.scenes import scene_with_circle
from tests.support.shared import INPUTS
from tests.support.verified import directions_of, uniform_in_zenith_angle

SCENE = INPUTS / "clear_day" / "amc.inp"
SMALL = INPUTS / "document_example" / "amc.inp"
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
    """Save an array, verify it, and return exit code and report."""

    def call(rows, *words, scene=SCENE):
        path = rows if isinstance(rows, Path) else tmp_path / "theirs.npy"
        if not isinstance(rows, Path):
            np.save(path, rows)
        capsys.readouterr()
        arguments = ["--scene", scene, path, "--json", *words]
        code = main(["verify", *map(str, arguments)])
        return code, json.loads(capsys.readouterr().out)

    return call


def failed(report):
    return {check["name"] for check in report["checks"] if not check["passed"]}


@pytest.mark.parametrize("dtype", ["<f4", ">f8"])
def test_independent_photons_pass(verify, photons, dtype):
    code, report = verify(photons.astype(dtype), "--waveband", 1)
    assert (code, failed(report)) == (0, set())
    assert report["tests"] == 10


def test_a_defect_fails(verify, photons):
    code, report = verify(uniform_in_zenith_angle(photons, 0.1), "--waveband", 1)
    assert code == 1
    assert "mu^2: chi-square, two-sided" in failed(report)
    cells = report["worst"][0]["cells"]
    assert abs(cells[0]["pull"]) >= abs(cells[1]["pull"]) > 4
    assert not any("--method stratified" in note for note in report["notes"])  # too uneven is not too even


def test_another_waveband_fails(verify, photons):
    assert verify(photons, "--waveband", 3)[0] == 1


def test_stratified_photons(verify, scene):
    even = directions_of(scene.source(9))
    code, report = verify(even, "--waveband", 1)
    assert code == 1  # too even for independent photons
    assert "mu^2 x azimuth: chi-square, two-sided" in failed(report)
    (note,) = (n for n in report["notes"] if "--method stratified" in n)
    assert "spread more evenly than independent photons can be" in note
    code, report = verify(even, "--waveband", 1, "--method", "stratified")
    assert (code, report["notes"]) == (0, [])


def test_a_frame_with_z_downwards(verify, photons):
    down = photons * np.array([1, 1, -1], dtype=photons.dtype)
    code, report = verify(down, "--waveband", 1)
    assert (code, failed(report)) == (1, {"photons come from above"})
    assert any("--frame" in check["detail"] for check in report["checks"])
    assert verify(down, "--waveband", 1, "--frame", "down")[0] == 0


def weighted(rows, *weights):
    return np.column_stack([rows, np.resize(np.array(weights, dtype=rows.dtype), len(rows))])


@pytest.mark.parametrize(
    ("spoil", "name"),
    [
        (lambda rows: np.concatenate([1.01 * rows[:1], rows[1:]]), "directions are unit vectors"),
        (lambda rows: rows[:0], "photons"),  # nothing was tested
        (lambda rows: weighted(rows, -1.0), "weights"),
        (lambda rows: weighted(rows, 0.0), "weights"),
        (lambda rows: weighted(rows, 1.0, -1.0), "weights"),
    ],
)
def test_photons_that_cannot_be(verify, photons, spoil, name):
    code, report = verify(spoil(photons), "--waveband", 1)
    assert (code, failed(report)) == (1, {name})


def test_weights_in_a_column_and_in_a_file(verify, photons, tmp_path):
    rng = np.random.default_rng(1)
    chance = 0.5 - 0.5 * photons[:, 2]
    kept = rng.random(len(photons)) < chance
    directions, weight = photons[kept], (1 / chance[kept]).astype(np.float32)
    np.save(tmp_path / "weights.npy", weight)
    assert verify(directions, "--waveband", 1)[0] == 1
    assert verify(np.column_stack([directions, weight]), "--waveband", 1)[0] == 0
    code, report = verify(directions, "--waveband", 1, "--weights", tmp_path / "weights.npy")
    assert code == 0
    assert any("weights" in check["name"] for check in report["checks"])


def test_weights_of_a_table_of_radiances(verify, tmp_path):
    """Photons uniform in solid angle, their weights carrying the cosine: launched law and flux law in one file."""
    words = ("--weighting", "solid-angle", "--iterations", N)
    scene = sky.read_scene(SCENE, iterations=N, weighting="solid-angle")
    batch = scene.source(4, method="iid", weights=True).photons(0)
    rows = np.column_stack([batch.directions, batch.weight])
    assert verify(rows, "--waveband", 1, *words)[0] == 0
    assert verify(rows[:, :3].copy(), "--waveband", 1, *words)[0] == 0
    assert verify(rows, "--waveband", 1, "--weighting", "projected")[0] == 0
    assert verify(rows[:, :3].copy(), "--waveband", 1, "--weighting", "projected")[0] == 1


def test_mcpl_knows_its_wavebands(verify, scene, tmp_path, capsys):
    path = tmp_path / "theirs.mcpl"
    sky.write_mcpl(scene.source(9, method="iid"), path)
    code, report = verify(path)
    assert code == 0
    assert {check["waveband"] for check in report["checks"]} == {1, 2, 3}
    code, report = verify(path, "--waveband", 2)
    assert code == 0
    assert any("120000 of 180000 photons belong to other wavebands" in note for note in report["notes"])


@pytest.mark.parametrize(("method", "precision"), [(None, "float32"), ("iid", "float64")])
def test_our_own_files_say_how_to_test_them(verify, method, precision, tmp_path):
    """Default files pass without an option: the header names a plan, and every photon is compared with it."""
    path = tmp_path / "ours.mcpl"
    source = sky.read_scene(SMALL, iterations=5000).source(2**63 + 5, method=method, precision=precision)
    sky.write_mcpl(source, path)
    code, report = verify(path, scene=SMALL)
    assert code == 0
    assert f"one run of aomc-sky, seed {2**63 + 5}, and its plan is the plan of this scene" in report["notes"][0]
    made = [check for check in report["checks"] if check["name"] == "photons made again"]
    assert [check["detail"] for check in made] == ["all 5000 photons agree with the plan"] * 3
    assert (
        verify(path, "--iterations", 5001, scene=SMALL)[0] == 0
    )  # another plan: stratified photons, or independent ones
    file = sky.read_mcpl(path)
    data, at = bytearray(path.read_bytes()), file.data_start + 6000 * file.header.record.itemsize
    part = slice(at + (12 if precision == "float32" else 24), at + (16 if precision == "float32" else 32))
    real = np.dtype(precision)
    data[part] = (
        np.frombuffer(bytes(data[part]), real) + real.type(1e-3 if precision == "float32" else 1e-12)
    ).tobytes()
    path.write_bytes(data)
    code, report = verify(path, scene=SMALL)
    assert (code, failed(report)) == (1, {"photons made again"})
    wrong = [check["detail"] for check in report["checks"] if not check["passed"]]
    assert wrong == ["1 of 5000 photons differ from the plan in direction; the first is photon 1000"]


COLUMNS = {
    "direction": ("direction", 1e-12), "energy": ("ekin", 1e-15), "position": ("position", 1e-9),
    "time": ("time", 1e-9), "user_flags": ("userflags", 1), "weight": ("weight", 1e-12),
    "polarisation": ("polarisation", 1e-9),
}  # fmt: skip
"""What one photon of a file differs by, in libmcpl's units."""


@pytest.mark.parametrize("column", COLUMNS)
def test_each_column_of_a_file_is_compared(verify, column, tmp_path):
    """A file of ours that libmcpl wrote again agrees; with one value changed the report names its column and photon."""
    library, amc = oracle(), scene_with_circle(tmp_path / "circle")
    source = sky.read_scene(amc, iterations=3000).source(4, precision="float64", weights=True)
    sky.write_mcpl(source, tmp_path / "ours.mcpl")
    header = replace(sky.read_mcpl(tmp_path / "ours.mcpl").header, has_polarisation=True)
    particles = library.read(tmp_path / "ours.mcpl").copy()
    name, change = COLUMNS[column]
    for is_changed in (False, True):
        if is_changed:
            values = particles[name]
            values[7, ...] += np.array(change if values.ndim == 1 else [0, change, 0]).astype(values.dtype)
        library.write(tmp_path / "again.mcpl", header, [particles])
        code, report = verify(tmp_path / "again.mcpl", scene=amc)
        note = next(note for note in report["notes"] if note.startswith("compared with the plan: "))
        assert set(note.removeprefix("compared with the plan: ").split(", ")) == set(COLUMNS)
        made = [check["detail"] for check in report["checks"] if check["name"] == "photons made again"]
        wrong = f"1 of 3000 photons differ from the plan in {column}; the first is photon 7"
        right = "all 3000 photons agree with the plan"
        assert (code, made) == ((1, [wrong, right, right]) if is_changed else (0, [right] * 3))


DAMAGES = {
    "one energy": lambda particles: particles["ekin"].__setitem__(7, 1.001 * particles["ekin"][7]),
    "one kind": lambda particles: particles["pdgcode"].__setitem__(7, 2112),
    "energies of a waveband": lambda particles: particles["ekin"].__setitem__(slice(3000), 3e-6),
}


@pytest.mark.parametrize("damage", DAMAGES)
@pytest.mark.parametrize("words", [(), ("--waveband", 1)])
def test_photons_that_left_their_waveband_are_missed(verify, damage, words, tmp_path):
    """The head names the plan of the scene; a photon of another energy or kind is none of its waveband."""
    library = oracle()
    sky.write_mcpl(sky.read_scene(SMALL, iterations=3000).source(4), tmp_path / "ours.mcpl")
    header = replace(sky.read_mcpl(tmp_path / "ours.mcpl").header, pdg_code=0)
    particles = library.read(tmp_path / "ours.mcpl").copy()
    DAMAGES[damage](particles)
    library.write(tmp_path / "again.mcpl", header, [particles])
    code, report = verify(tmp_path / "again.mcpl", *words, scene=SMALL)
    assert (code, "numbers of photons" in failed(report)) == (1, True)
    assert "its plan is the plan of this scene" in str(report["notes"])


def test_optical_photons_are_photons(verify, tmp_path):
    """PDG code -22, Geant4's; another particle is none, and is said."""
    source = sky.read_scene(SMALL, iterations=5000).source(4)
    for code in (22, -22, np.int64(-22)):
        sky.write_mcpl(source, tmp_path / "ours.mcpl", pdg_code=code)
        assert sky.read_mcpl(tmp_path / "ours.mcpl").header.pdg_code == code
        assert verify(tmp_path / "ours.mcpl", scene=SMALL)[0] == 0
    for code in (2112, 0, 22.5, "22"):
        with pytest.raises(sky.UsageError, match="pdg_code must be 22"):
            sky.write_mcpl(source, tmp_path / "ours.mcpl", pdg_code=code)


@pytest.mark.parametrize("name", ["perez_sky", "sun_and_sky"])
def test_the_numbers_of_photons_come_from_the_file(name, tmp_path, told, capsys):
    """Wavebands that differ in number, and a run of other iterations than amc.inp says: compared photon by photon."""
    files, path = INPUTS / name, tmp_path / "ours.mcpl"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", sky.InputWarning)
        source = sky.read_scene(files, iterations=700).source(4)
    sky.write_mcpl(source, path)
    assert len({source.n_photons(band) for band in range(source.n_bands)}) > 1
    for words in ([], ["--waveband", "2"]):
        assert main(["verify", "--scene", str(files), str(path), *words]) == 0
        assert "its plan is the plan of this scene: every photon is compared with it" in capsys.readouterr().out
    assert "its plan is not the plan of this scene" in told("verify", "--scene", files, path, "--iterations", "701").out


@pytest.mark.parametrize(
    ("methods", "words"),
    [
        ((None, None), "2 runs of aomc-sky: photons are tested as stratified ones"),
        (("iid", "iid"), "2 runs of aomc-sky: photons are tested as independent ones"),
        ((None, "iid"), "2 runs of aomc-sky: photons may be spread evenly or not"),
    ],
)
def test_merged_files_of_ours(verify, methods, words, scene, tmp_path):
    paths = [tmp_path / f"{k}.mcpl" for k in range(2)]
    for seed, (method, path) in enumerate(zip(methods, paths, strict=True)):
        sky.write_mcpl(scene.source(seed, method=method), path)
    oracle().tool("--merge", tmp_path / "all.mcpl", *paths)
    code, report = verify(tmp_path / "all.mcpl")
    assert (code, failed(report)) == (0, set())
    assert words in report["notes"][0]


def test_drawn_numbers_with_even_places_and_a_part_of_a_file(verify, scene, tmp_path):
    """What is neither iid nor stratified, and a part of a stratified file: only too uneven ones fail."""
    sky.write_mcpl(scene.source(1, allocation="multinomial"), tmp_path / "drawn.mcpl")
    code, report = verify(tmp_path / "drawn.mcpl", "--iterations", 7)
    assert (code, failed(report)) == (0, set())
    assert "its plan is not the plan of this scene: photons may be spread evenly" in report["notes"][0]
    sky.write_mcpl(scene.source(1), tmp_path / "whole.mcpl")
    oracle().tool("--extract", "-l50000", tmp_path / "whole.mcpl", tmp_path / "part.mcpl")
    assert verify(tmp_path / "part.mcpl", "--method", "iid")[0] == 1  # five sixths of them are still too even
    code, report = verify(tmp_path / "part.mcpl")
    assert (code, failed(report)) == (0, set())
    assert "but not which part of them is in the file: photons may be spread evenly or not" in "".join(report["notes"])


def test_our_weights_are_not_too_even(verify, tmp_path):
    words = ("--weighting", "solid-angle")
    source = sky.read_scene(SCENE, iterations=N, weighting="solid-angle").source(4, weights=True)
    sky.write_mcpl(source, tmp_path / "weights.mcpl")
    code, report = verify(tmp_path / "weights.mcpl", *words, "--iterations", 7)
    assert (code, failed(report)) == (0, set())
    assert any("weights" in check["name"] for check in report["checks"])


def test_copies_of_photons_are_found(verify, photons):
    spoilt = photons.copy()
    spoilt[1000:1300] = photons[:300]
    code, report = verify(spoilt, "--waveband", 1)
    assert (code, failed(report)) == (1, {"photons that repeat another"})
    (check,) = (check for check in report["checks"] if not check["passed"])
    assert check["found"] == pytest.approx(300 / len(photons))
    assert check["detail"].startswith("300 pairs are equal")


def test_the_programs_lattice(verify):
    scene = INPUTS / "document_example" / "amc.inp"
    source = sky.read_scene(scene, compat="aomc", iterations=N).source(0)
    down = directions_of(source) * np.array([1, 1, -1], dtype=np.float32)
    words = ("--compat", "aomc", "--frame", "down", "--method", "stratified", "--waveband", 1)
    assert verify(down, *words, scene=scene)[0] == 0
    beside = sky.directions.sky_from_travel(down, sky.directions.Frame.DOWN)
    turned = sky.directions.travel_from_sky(
        np.rad2deg(beside[0]), np.rad2deg(beside[1]) + 3.0, sky.directions.Frame.DOWN
    )
    assert verify(turned, *words, scene=scene)[0] == 1


def test_photons_from_dark_zones(verify):
    scene = INPUTS / "sparse_sky" / "amc.inp"
    source = sky.read_scene(scene, iterations=5000).source(1, method="iid")
    directions = directions_of(source)
    band = ["--waveband", "1"] if source.n_bands > 1 else []
    assert verify(directions, *band, scene=scene)[0] == 0
    rng = np.random.default_rng(0)
    spoilt = uniform_in_zenith_angle(directions, 0.002, int(rng.integers(100)))
    code, report = verify(spoilt, *band, scene=scene)
    assert code == 1
    assert "no photon from dark zones" in failed(report)


@pytest.mark.parametrize(
    ("words", "what"),
    [
        (f"--scene {SCENE}", "name the waveband of the photons with --waveband"),
        (f"--scene {SCENE} --waveband 9", "waveband 9 is not in this scene"),
        (f"--scene {SCENE} --waveband 1 --waveband 2", "give one --waveband"),
        (f"--scene {SCENE} --waveband 1 --resample 0.5", "--resample"),
        (f"--scene {SCENE} --waveband 1 --resample 0", "--resample"),
        ("", "--scene AMC_INP"),
    ],
)
def test_usage_errors(tmp_path, told, photons, words, what):
    np.save(tmp_path / "x.npy", photons[:100])
    assert what in told("verify", tmp_path / "x.npy", *words.split(), code=2).err


@pytest.mark.parametrize("words", [("--iterations", "7"), ("--compat", "aomc"), ("--sun-zenith", "30"), ("--no-disc",)])
def test_options_of_a_scene_are_not_dropped_for_a_run(tmp_path, told, words):
    assert f"{words[0].replace('--no-', '--')} says how a scene is read" in told("verify", tmp_path, *words, code=2).err
