"""photons.mcpl is byte for byte what libmcpl writes for the same photons and the same head."""

from dataclasses import replace

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.emission.photons import PhotonBatch
from aomc_sky.errors import OutputError, SceneError, UsageError
from aomc_sky.formats.mcpl.header import runs_of, statistic
from aomc_sky.outputs.photons import mcpl
from aomc_sky.outputs.photons.mcpl import McplWriter, write_mcpl
from tests.support.backend import photons_by
from tests.support.mcpl import PARTICLE, oracle, parsed, written_by_libmcpl
from tests.support.processes import in_environment
from tests.support.sampled import table_of
from tests.support.shared import INPUTS
from tests.support.stokes import DEFECTS, frame_of

N = 1500
PLACES = {"point": sky.Footprint(), "circle": sky.Footprint.circle(3.0), "rectangle": sky.Footprint.rectangle(1.0, 1e4)}


def files_scene(name):
    return sky.read_scene(INPUTS / name, iterations=N)


def scene(*parts, wavelengths=(350.0, 500.0, 700.0), **more):
    return sky.Scene(wavebands=wavelengths, **{"n_photons": N, "components": parts or (sky.UniformSky(),), **more})


def batch_of(directions, band=0, nm=500.0, **more):
    ux, uy, uz = (np.ascontiguousarray(column) for column in directions.T)
    more = {"patch": np.zeros(len(ux), np.int32), "band": band, "start": 0, "wavelength_nm": nm, **more}
    return PhotonBatch(ux=ux, uy=uy, uz=uz, **more)


SCENES = {
    "table": lambda: files_scene("document_example"),
    "many_cells": lambda: files_scene("clear_day"),
    "perez": lambda: files_scene("perez_sky"),
    "beam_only": lambda: files_scene("beam_only"),
    "beam_at_zenith": lambda: scene(sky.DirectBeam(sun_zenith_deg=0.0)),
    "beam_at_horizon": lambda: scene(sky.DirectBeam(sun_zenith_deg=89.9999999, sun_azimuth_deg=45)),
    **{place: lambda place=place: scene(footprint=PLACES[place]) for place in PLACES},
    "one_band": lambda: scene(wavelengths=(555.25,)),
    "a_band_without_photons": lambda: scene(n_photons=[5, 0, 7]),
    "no_photons": lambda: scene(n_photons=0),
    "450_bands": lambda: scene(wavelengths=np.linspace(300, 900, 450), n_photons=20),
}


@pytest.mark.parametrize("name", SCENES)
def test_the_file_is_libmcpls_own(name, tmp_path):
    """In both precisions by turns."""
    precision = ("float32", "float64")[list(SCENES).index(name) % 2]
    source = SCENES[name]().source(seed=5, precision=precision)
    write_mcpl(source, tmp_path / "ours.mcpl")
    ours = (tmp_path / "ours.mcpl").read_bytes()
    assert ours == written_by_libmcpl(oracle(), source, tmp_path / "theirs.mcpl")
    assert len(ours) == McplWriter(source).layouts(tuple(range(source.n_bands)))[0].size
    write_mcpl(source, tmp_path / "again.mcpl", threads=3)
    assert ours == (tmp_path / "again.mcpl").read_bytes()


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_weights_stand_in_every_record_where_they_differ(precision, tmp_path):
    table = table_of(np.random.default_rng(2).uniform(size=(6, 8)), weighting="solid-angle")
    source = scene(table, wavelengths=[500.0]).source(seed=5, precision=precision, weights=True)
    write_mcpl(source, tmp_path / "ours.mcpl")
    assert (tmp_path / "ours.mcpl").read_bytes() == written_by_libmcpl(oracle(), source, tmp_path / "theirs.mcpl")
    file = sky.files.read_mcpl(tmp_path / "ours.mcpl")
    assert file.header.weight == 0.0
    assert np.array_equal(file.particles().weight, source.photons(0).weight.astype(np.float64))
    assert file.particles().weight.std() > 0.1


def hard_directions(dtype):
    """Axes, planes and diagonals, signed zeros, subnormals, and neighbours of all: where the packing decides."""
    ends = [0.0, -0.0, 1.0, -1.0]
    axes = [(a, b, c) for a in ends for b in ends for c in ends if abs(a) + abs(b) + abs(c) == 1]
    h, t = np.sqrt(0.5), np.sqrt(1 / 3)
    diagonals = [(x * h, y * h, 0.0) for x in (1, -1) for y in (1, -1)]
    diagonals += [(0.0, x * h, y * h) for x in (1, -1) for y in (1, -1)] + [(x * h, -0.0, h) for x in (1, -1)]
    diagonals += [(x * t, y * t, z * t) for x in (1, -1) for y in (1, -1) for z in (1, -1)]
    tiny = np.finfo(dtype).smallest_subnormal
    near = [(1.0, 0.0, s * k * tiny) for s in (1, -1) for k in (1, 2, 3, 2**20)]
    near += [(0.0, -1.0, s * np.finfo(dtype).tiny * k) for s in (1, -1) for k in (0.25, 1, 4)]
    near += [(0.6, 0.8, s * 10.0**-k) for s in (1, -1) for k in range(3, 40)]
    base = np.array(axes + diagonals + near, dtype)
    steps = [base]
    for column in range(3):
        for towards in (np.inf, -np.inf):
            moved = base.copy()
            moved[:, column] = np.nextafter(moved[:, column], dtype(towards))
            steps.append(moved)
    random = np.random.default_rng(1).normal(size=(4000, 3))
    random /= np.sqrt((random**2).sum(axis=1, keepdims=True))
    return np.concatenate([*steps, random.astype(dtype)])


@pytest.mark.parametrize("is_compiled", [True, False])
@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_directions_that_the_packing_must_decide_on(precision, is_compiled, tmp_path):
    directions = hard_directions(np.dtype(precision).type)
    n = len(directions)
    batch = batch_of(directions, patch=np.arange(n, dtype=np.int32))
    writer = McplWriter(scene(wavelengths=[500.0]).source(precision=precision))
    particles = np.zeros(n, PARTICLE)
    particles["direction"] = directions
    particles["ekin"] = mcpl.MEV_NM / 500.0
    particles["userflags"] = (1 << 20) + np.arange(n)
    header = parsed(writer.layouts((0,))[0].head)
    oracle().write(tmp_path / "theirs.mcpl", header, [particles])
    theirs = (tmp_path / "theirs.mcpl").read_bytes()
    with photons_by(kernels=is_compiled):
        ours = bytes(writer.chunks(batch)[0])
    assert ours == theirs[len(writer.layouts((0,))[0].head) :]


@pytest.mark.parametrize(("dtype", "error"), [(np.float32, 6e-7), (np.float64, 1.4e-15)])
def test_directions_come_back_within_the_error_of_the_page(dtype, error, tmp_path):
    """Of vectors whose length is off by as much as a photon's may be: docs/formats/mcpl.md."""
    off = {np.float32: 2.7e-7, np.float64: 5.4e-16}[dtype]
    worst, units = 0.0, hard_directions(np.float64)
    units /= np.linalg.norm(units, axis=1, keepdims=True)
    for stretch in (-off, 0.0, off):
        directions = (units * (1 + stretch)).astype(dtype)
        writer = McplWriter(scene(n_photons=[len(directions), 0, 0]).source(precision=dtype.__name__))
        chunk = bytes(writer.chunks(batch_of(directions))[0])
        (tmp_path / "x.mcpl").write_bytes(writer.layouts((0,))[0].head + chunk)
        back = sky.files.read_mcpl(tmp_path / "x.mcpl").particles().direction
        assert (np.abs((back**2).sum(axis=1) - 1) < 1e-15).all()
        worst = max(worst, np.abs(back - directions.astype(np.float64)).max())
    assert 0.5 * error < worst < error


def test_flags_are_0_beyond_what_they_can_hold():
    writer = McplWriter(scene(wavelengths=[500.0] * 4200).source())
    down, cell = np.array([[0, 0, -1]] * 4, np.float32), np.array([0, 2**20 - 1, 2**20, 2**31 - 1], np.int32)
    flags = {}
    for band in (0, 4094, 4095, 4199):
        chunk = np.frombuffer(writer.chunks(batch_of(down, band=band, patch=cell))[0], writer._record)
        flags[band] = chunk["user_flags"].tolist()
    assert flags[0] == [2**20, 2**21 - 1, 0, 0]
    assert flags[4094] == [4095 << 20, 2**32 - 1, 0, 0]
    assert flags[4095] == flags[4199] == [0, 0, 0, 0]
    assert b"0 where the cell is 2^20 or more, or the waveband 4096 or more" in writer.layouts((0,))[0].head
    assert b"0 where" not in McplWriter(scene().source()).layouts((0,))[0].head


def test_the_energy_constant_is_that_of_the_si():
    from fractions import Fraction

    planck, light, charge = Fraction("6.62607015e-34"), 299_792_458, Fraction("1.602176634e-19")
    assert float(planck * light / charge * 10**9 / 10**6) == mcpl.MEV_NM


@pytest.mark.parametrize("n", [0, 1, 999_999, 10**15 - 1, 10**15, 10**15 + 1, 2**53 + 2, 2**60, 2**62])
def test_the_statistic_is_written_as_libmcpl_does(n, tmp_path):
    library = oracle()
    header = parsed(McplWriter(scene().source()).layouts((0,))[0].head)
    comment = f"stat:sum:aomc_sky_photons:{statistic(n):>24}"
    library.write(tmp_path / "s.mcpl", replace(header, comments=(comment,)), [])
    assert comment.encode() in (tmp_path / "s.mcpl").read_bytes()


def test_nothing_of_the_machine_is_in_the_head(tmp_path):
    source = scene().source(seed=12)
    comments = parsed(McplWriter(source).layouts((0, 1, 2))[0].head).comments
    assert any(sky.__version__ in c for c in comments)
    runs = runs_of(parsed(McplWriter(source).layouts((0, 1, 2))[0].head))
    assert (runs.seed, runs.plan, runs.is_plan(source.plan.sha256)) == (12, source.plan.sha256[:12], True)
    assert any("3: 700.0" in c for c in comments)
    assert not any("/" in c.replace("aomc-sky/4", "").replace("h c / wavelength", "") for c in comments)


@pytest.mark.parametrize("wavelength", [0.0, 1e-50])
def test_a_wavelength_without_a_photon_energy_is_refused(wavelength):
    with pytest.raises(SceneError, match="waveband 2 has the wavelength"):
        McplWriter(scene(wavelengths=sky.Wavebands([500.0, wavelength])).source())


def test_write_mcpl_leaves_nothing_half_written(tmp_path):
    source = scene().source()
    (tmp_path / "folder.mcpl").mkdir()
    for name in ("absent/x.mcpl", "folder.mcpl"):
        with pytest.raises(OutputError):
            write_mcpl(source, tmp_path / name)
    with pytest.raises(UsageError, match="threads"):
        write_mcpl(source, tmp_path / "x.mcpl", threads=-1)
    assert [p.name for p in tmp_path.iterdir()] == ["folder.mcpl"]


def test_write_mcpl_keeps_memory_flat(tmp_path):
    program = """
import sys
import aomc_sky as sky
source = sky.Scene(wavebands=[500.0], n_photons=3_000_000, components="uniform").source()
sky.write_mcpl(source, sys.argv[1], threads=2)
status = dict(line.split(':', 1) for line in open('/proc/self/status'))
print(int(status['VmHWM'].split()[0]) / 1024)
assert "numba" not in sys.modules
"""
    peak = float(in_environment(program, tmp_path / "x.mcpl"))
    assert (tmp_path / "x.mcpl").stat().st_size > 96_000_000
    assert peak < 150  # [MB]; Python and numpy alone are 50, the photons would be 96


def polarised(n=100_000, **more):
    sun = {"sun_zenith_deg": 60.0, "sun_azimuth_deg": 30.0}
    sphere = sky.PerezSky(epsilon=6.0, delta=0.1, strength=0.8, polarisation=sky.RayleighPattern(), **sun)
    return scene(sky.DirectBeam(strength=0.2, **sun), sphere, wavelengths=(450.0, 550.0), n_photons=n, **more)


def stokes_of_axes(axes, direction):
    l_axis, r_axis = frame_of(direction)
    along, across = (axes * l_axis).sum(axis=1), (axes * r_axis).sum(axis=1)
    return np.stack([along**2 - across**2, 2 * along * across])


@pytest.mark.parametrize(("precision", "rounding"), [("float32", 4e-7), ("float64", 2e-15)])
@pytest.mark.parametrize("pdg_code", [22, -22])
def test_axes_of_polarised_light(precision, rounding, pdg_code, tmp_path):
    """Unit vectors across the ray, whose mean has the Stokes vector of the light: within 5 standard errors."""
    source = polarised().source(seed=3, precision=precision)
    write_mcpl(source, tmp_path / "x.mcpl", pdg_code=pdg_code)
    particles = oracle().read(tmp_path / "x.mcpl")[100_000:]
    axes, direction = particles["polarisation"], particles["direction"]
    assert np.abs((axes**2).sum(axis=1) - 1).max() < rounding
    assert np.abs((axes * direction).sum(axis=1)).max() < rounding
    batch = source.photons(1)
    expected = np.stack([batch.q, batch.u]).astype(float)
    found = stokes_of_axes(axes, direction)
    np.testing.assert_allclose(np.hypot(*found), 1.0, atol=1e-6)

    def errors(expected):
        """Of q and u, and of their products with the light's own, so that signs show: in standard errors."""
        parts = [(found[k] - expected[k]) * w for k in (0, 1) for w in (1.0, expected[0], expected[1])]
        return max(abs(part.mean()) / part.std() * np.sqrt(part.size) for part in parts)

    assert errors(expected) < 5
    for defect in DEFECTS.values():
        assert errors(np.stack(defect(*expected))) > 30
    is_beam = batch.patch == 0
    assert np.abs(found[:, is_beam].mean(axis=1)).max() < 5 / np.sqrt(is_beam.sum())


def test_axes_depend_on_the_photon_alone(tmp_path):
    """Batches and replicates do not matter; seeds and methods do; photons are those of the light without them."""
    source = polarised(n=3000, footprint=PLACES["circle"]).source(seed=3, replicates=3)
    writer, batch = McplWriter(source), source.photons(1)
    whole = writer.others(batch)["polarisation"]
    np.testing.assert_array_equal(writer.others(batch[1234:2345])["polarisation"], whole[1234:2345])
    other = [polarised(n=3000).source(**how) for how in ({"seed": 4}, {"seed": 3, "method": "iid"})]
    for one in other:
        again = McplWriter(one).others(replace(batch, x=None, y=None))["polarisation"]
        assert 0.3 < np.mean(again[:, 0] != whole[:, 0]) < 0.7
    plain = replace(batch, q=None, u=None)
    with_axes, without = np.frombuffer(writer.chunks(batch)[0], writer._record), writer.others(plain)
    assert not without["polarisation"].any()
    assert with_axes["polarisation"].any(axis=1).all()


def test_axes_straight_down_and_at_the_horizon():
    """No direction gives a NaN; a vertical ray has the azimuth 0."""
    source = polarised(n=10).source()
    z = np.zeros(4, np.float32)
    rows = np.array([[0.0, 0.0, -1.0], [-0.0, 0.0, -1.0], [1e-45, 0.0, -1.0], [1.0, 0.0, -0.0]], np.float32)
    batch = batch_of(rows, nm=450.0, q=z, u=z)
    for q, u in ((0.0, 0.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (-0.0, -0.0), (1e-38, -1e-38)):
        light = replace(batch, q=z + np.float32(q), u=z + np.float32(u))
        axes = McplWriter(source).others(light)["polarisation"]
        assert np.isfinite(axes).all()
        np.testing.assert_allclose((axes**2).sum(axis=1), 1.0, rtol=1e-6)
        if abs(q) == 1:  # along x, or across it, for all rays that go straight down
            np.testing.assert_allclose(np.abs(axes[:2]), [[q == 1, q == -1, 0]] * 2, atol=1e-7)
        if abs(u) == 1:  # the l axis of a ray from azimuth 0 is x, the r axis -y
            np.testing.assert_allclose(axes[0, 0] * axes[0, 1], -u / 2, rtol=1e-6)


def test_the_head_speaks_of_axes_where_there_are_any():
    head = McplWriter(polarised().source()).layouts((0, 1))[0].head
    assert parsed(head).has_polarisation
    assert b"one axis of the electric vector" in head
    plain = McplWriter(scene().source()).layouts((0, 1, 2))[0].head
    assert not parsed(plain).has_polarisation
    assert b"polarisation" not in plain
