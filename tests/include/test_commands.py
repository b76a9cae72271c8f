"""The source file at the command line and in Python: run, export, info, verify, and the folder of a run."""

import json

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.cli.commands.info import include_dir
from aomc_sky.cli.main import main
from tests.support.fault_rows import command
from tests.support.host_programs import run as run_program
from tests.support.scenes import manifest_of
from tests.support.shared import INPUTS, REPOSITORY
from tests.support.source_files import needs_gcc, section_names

SCENE = str(INPUTS / "clear_day" / "amc.inp")
RUN = ["run", SCENE, "--iterations", "1e10", "--format", "source"]


@pytest.fixture
def run(tmp_path):
    assert main([*RUN, "--out", str(tmp_path / "day"), "-q"]) == 0
    return tmp_path / "day"


def compiled(folder, text):
    """The folder, in which `show` is the program of this C text."""
    (folder / "show.c").write_text('#include "aomc_sky.h"\n' + text)
    run_program(["gcc", f"-I{include_dir()}", "-o", "show", "show.c", "-lm"], folder)
    return folder


def test_a_run_writes_the_source_and_is_kept(run, told):
    assert {path.name for path in run.iterdir()} == {"source.sky", "plan.npz", "counts.csv", "manifest.json"}
    manifest = manifest_of(run)
    assert manifest["options"]["formats"] == ["source"]
    assert manifest["files"]["source.sky"] == {"bytes": (run / "source.sky").stat().st_size}
    source = sky.PhotonSource(sky.Plan.load(run / "plan.npz"))
    assert (run / "source.sky").read_bytes() == source.to_bytes()
    assert (run / "source.sky").stat().st_size <= 3 * 1.3e6
    words = [*RUN, "--out", str(run)]
    whole = (run / "source.sky").read_bytes()
    assert "again)" in told(*words).out
    (run / "source.sky").write_bytes(whole[:-64])
    assert main([*words, "-q"]) == 0
    assert (run / "source.sky").read_bytes() == whole
    assert command(*words[:3], "1e4", "--format", "npy", "--format", "source", "--out", run.parent / "both", "-q") == 0
    assert main(["verify", str(run.parent / "both"), "-q"]) == 0


def test_verify_compares_its_bytes(run, told):
    assert "source.sky agrees with the plan, byte for byte" in told("verify", run).out
    data = bytearray((run / "source.sky").read_bytes())
    data[5000] ^= 1
    (run / "source.sky").write_bytes(data)
    assert "source.sky differs from the plan" in told("verify", run, code=1).out
    (run / "source.sky").unlink()
    assert "source.sky is missing" in told("verify", run, code=1).out
    (run / "source.sky").write_bytes(data)
    for words in ([], ["--scene", SCENE]):
        assert "give the folder of its run" in told("verify", run / "source.sky", *words, code=2).err


def test_export(run, told):
    target = run.parent / "copy.sky"
    words = ["export", str(run), "--to", "source", "--out", str(target)]
    assert main(words) == 0
    assert target.read_bytes() == (run / "source.sky").read_bytes()
    assert "exist already" in told(*words).out
    target.write_bytes(b"something else")
    assert main(words) == 5
    assert main([*words, "--force"]) == 0
    assert target.read_bytes() == (run / "source.sky").read_bytes()
    assert main([*words[:4], "--waveband", "1"]) == 2
    assert main(words[:4]) == 0
    assert (run.parent / "day.sky").exists()


def test_info_shows_the_head_and_refuses_damage(run, told):
    assert "550  10000000000" in told("info", run / "source.sky").out
    shown = json.loads(told("info", run / "source.sky", "--json").out)
    assert shown["plan_sha256"] == sky.Plan.load(run / "plan.npz").sha256
    assert [band["irradiance_W_m2_nm"] for band in shown["bands"]] == [None] * 3
    data = (run / "source.sky").read_bytes()
    for damaged in (data[:100], data[:-64], b"AOMC-SKY", data[:700] + b"x" + data[701:]):
        (run / "bad.sky").write_bytes(damaged)
        assert "E971" in told("info", run / "bad.sky", code=3).err
    assert main(["info", str(run / "none.sky")]) == 3


def test_write_source_is_atomic_and_says_what_is_wrong(tmp_path):
    source = sky.Scene(wavebands=[550.0], n_photons=100, components="uniform").source(seed=1)
    for words, error, says in (
        (("day.sky", source), sky.UsageError, "expected a PhotonSource"),
        ((source, ""), sky.UsageError, "name of a file"),
        ((source, tmp_path / "nowhere" / "x.sky"), sky.errors.OutputError, None),
    ):
        with pytest.raises(error, match=says):
            sky.write_source(*words)
    sky.write_source(source, tmp_path / "x.sky")
    assert [path.name for path in tmp_path.iterdir()] == ["x.sky"]


def test_equal_plans_give_equal_bytes_and_bands_share_tables():
    def made(n_bands):
        grid = sky.PatchGrid.regular(90, 360)
        mass = np.random.default_rng(1).random((1, grid.n_patches))
        cell = sky.component.cells_of_grid(grid)
        one = sky.component.Component(
            name="t", law=sky.component.Law.CELL_MU2, strength=np.ones(1), mass=mass, cell=cell, grid=grid
        )
        wavebands = np.linspace(400, 700, n_bands).tolist()
        return sky.Scene(wavebands=wavebands, n_photons=10**6, components=(one,)).source(seed=1)

    assert made(2).to_bytes() == made(2).to_bytes()
    one, two = len(made(1).to_bytes()), len(made(2).to_bytes())
    assert one <= 1.3e6
    assert two - one <= one - 8 * 32_400 + 4096  # the places of cells are there once


@needs_gcc
def test_irradiance_of_a_band_in_absolute_units(tmp_path):
    pytest.importorskip("pvlib")
    light = {"sun_zenith_deg": 32, "ghi": 780, "dhi": 140, "spectrum": "spectrl2"}
    scene = sky.weather_scene(wavebands=[443, 555], n_photons=10_000, **light)
    source = scene.source(seed=1)
    sky.write_source(source, tmp_path / "day.sky")
    text = (
        "int main(void) { aomc_sky_file f; aomc_sky_source s; int k;\n"
        'if (aomc_sky_load("day.sky", &f)) return 1;\n'
        'for (k = 0; k < f.n_bands; k++) { aomc_sky_band(&f, k, &s); printf("%.17g %.17g ", s.wavelength_nm, '
        "s.irradiance_W_m2_nm); }\nputs(f.plan_sha256); aomc_sky_unload(&f); return 0; }\n"
    )
    said = run_program(["./show"], compiled(tmp_path, text)).split()
    expected = [x for k in (0, 1) for x in (scene.wavebands.wavelength_nm[k], sum(source.irradiance(k).values()))]
    assert np.allclose(np.array(said[:4], float), expected, rtol=1e-15)
    assert said[4] == source.plan.sha256


def test_the_layout_page_names_every_section():
    page = (REPOSITORY / "docs" / "formats" / "source.md").read_text()
    table = page[page.index("| kind |") :]
    assert [name for name in section_names() if name not in table] == []


@needs_gcc
def test_stokes_vectors_of_patches(tmp_path):
    """An optional section: `source.stokes` by the patch of a photon; NULL where nothing is polarised."""
    grid, rng = sky.PatchGrid.regular(4, 6), np.random.default_rng(8)
    values = rng.lognormal(0, 1, (1, 24))
    light = {"values": values, "values_q": 0.3 * values, "values_u": -0.5 * values}
    table = sky.TabulatedSky(wavelength_nm=[550.0], grid=grid, strength=0.5, **light)
    beam = sky.DirectBeam(sun_zenith_deg=30.0, strength=0.5)
    text = (
        "int main(int n, char **names) { aomc_sky_file f; aomc_sky_source s; int64_t i;\n"
        "(void)n; if (aomc_sky_load(names[1], &f) || aomc_sky_band(&f, 0, &s)) return 1;\n"
        'if (!s.stokes) return puts("none"), 0;\n'
        "for (i = 0; i < s.n; i++) { const float *q = s.stokes + 2 * aomc_sky_at(&s, i).patch;\n"
        'printf("%.9g %.9g\\n", q[0], q[1]); } return 0; }\n'
    )
    folder = compiled(tmp_path, text)
    for components in ((beam, table), (beam, sky.UniformSky(strength=0.5))):
        source = sky.Scene(wavebands=[550.0], n_photons=500, components=components).source(seed=2)
        sky.write_source(source, tmp_path / "day.sky")
        said = run_program(["./show", "day.sky"], folder)
        if table not in components:
            assert said == "none\n"
        else:
            found = np.array(said.split(), np.float32).reshape(-1, 2)
            batch = source.photons()
            np.testing.assert_array_equal(found, np.column_stack([batch.q, batch.u]))
            assert len(np.unique(found)) == 3
