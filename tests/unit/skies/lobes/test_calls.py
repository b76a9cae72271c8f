"""The public calls of lobes and background skies as they are promised: names, positions, shapes, units."""

import inspect

import numpy as np
import pytest

import aomc_sky as sky
from tests.support.background import plain_file

SHAPES = {"hg": (np.array([0.0, 0.5, 0.9]), 0.0), "ggx": (np.array([0.1, 0.5, 2.0]), 0.7), "beckmann": (0.3, 0.2)}
TURNS = np.array([[1.0, 0, 0, 0], [0.6, 0.3, -0.2, 0.7], [-7.0, 0, 3.0, 0], [0.0, 1.0, 1e-9, 0]])


def parameters(function):
    """Names of the parameters: those by position, and those by name alone with their defaults."""
    given = inspect.signature(function).parameters.values()
    by_name = {p.name: p.default for p in given if p.kind is p.KEYWORD_ONLY}
    return [p.name for p in given if p.kind is p.POSITIONAL_OR_KEYWORD], by_name


def test_names_and_positions():
    assert parameters(sky.lobes.pdf) == (["kind", "param0", "param1", "m"], {})
    above = (["kind", "param0", "param1", "quaternion"], {"weighting": "plain"})
    assert parameters(sky.lobes.mass_above_horizon) == above
    names, by_name = parameters(sky.BackgroundSky.irradiance)
    assert names == ["self", "animation", "unix_time_s", "wavelength_nm"]
    assert by_name["above"] == "sphere"
    assert parameters(sky.rayleigh.sample_mu) == (["xi", "gamma"], {})
    for function in (sky.rayleigh.pdf_mu, sky.rayleigh.cdf_mu):
        assert parameters(function) == (["mu", "gamma"], {})
    for function in (sky.henyey_greenstein.sample_mu, sky.henyey_greenstein.sample_mu_sin):
        assert parameters(function) == (["xi", "g"], {})
    assert parameters(sky.henyey_greenstein.pdf_sr) == (["one_minus_mu", "g"], {})


@pytest.mark.parametrize("kind", SHAPES)
def test_densities_over_arrays_are_those_of_single_calls(kind):
    first, second = (np.broadcast_to(p, 3) for p in SHAPES[kind])
    m = np.random.default_rng(1).normal(size=(5, 4, 1, 3)) * 10.0 ** np.arange(-2, 3)[:, None, None, None]
    field = sky.lobes.pdf(kind, first, second, m)
    assert field.shape == (5, 4, 3)
    assert field.dtype == np.float64
    for i, j, k in ((0, 0, 0), (4, 3, 2), (2, 1, 1)):
        assert field[i, j, k] == sky.lobes.pdf(kind, first[k], second[k], m[i, j, 0].tolist())
    unit = m / np.linalg.norm(m, axis=-1, keepdims=True)
    np.testing.assert_allclose(sky.lobes.pdf(kind, first, second, unit), field, rtol=1e-12)


@pytest.mark.parametrize("weighting", ["plain", "projected"])
@pytest.mark.parametrize("kind", SHAPES)
def test_masses_over_arrays_are_those_of_single_calls(kind, weighting):
    first, second = (np.broadcast_to(p, 3) for p in SHAPES[kind])
    turns = TURNS[:, None]
    table = sky.lobes.mass_above_horizon(kind, first, second, turns, weighting=weighting)
    assert table.shape == (4, 3)
    assert np.all((table >= 0) & (table <= 1))
    for i in range(4):
        for k in range(3):
            one = sky.lobes.mass_above_horizon(kind, first[k], second[k], TURNS[i].tolist(), weighting=weighting)
            assert one == table[i, k]


@pytest.fixture(scope="module")
def night(tmp_path_factory):
    """A diurnal animation with keys at 0, 6 and 24 h, written by h5py alone, in micrometres and W cm-2 um-1."""
    pytest.importorskip("h5py")
    return sky.read_background(plain_file(tmp_path_factory.mktemp("night") / "night.h5"))


def test_irradiance_in_our_units(night):
    assert isinstance(night, sky.BackgroundSky)
    small = float(np.float32(1e-9))
    assert night.irradiance("a", 0.0, 500.0) == pytest.approx(10 * 0.25 * float(np.float32(4e-9)), rel=1e-15)
    assert night.irradiance("a", 6 * 3600.0, 500.0) == pytest.approx(10 * small, rel=1e-15)
    assert night.irradiance("a", 86400.0 + 3 * 3600.0, 625.0) == pytest.approx(
        10 * 0.5 * (0.25 * 0.5 + float(np.float32(2e-9))), rel=1e-15
    )
    last = night.irradiance("a", 86400.0 - 1e-6, 750.0)
    assert last == pytest.approx(0.0, abs=1e-9)


def test_irradiance_over_times_and_wavelengths(night):
    times, nm = np.arange(-3.0, 4.0)[:, None] * 5000.0, np.linspace(500, 750, 11)
    table = night.irradiance("a", times, nm)
    assert table.shape == (7, 11)
    for i, k in ((0, 0), (3, 5), (6, 10), (1, 7)):
        assert table[i, k] == night.irradiance("a", float(times[i, 0]), float(nm[k]))
    assert night.irradiance("a", times[:, 0], 600.0).shape == (7,)
    assert night.irradiance("a", 100.0, nm).shape == (11,)
    assert night.irradiance("a", 100, 600).shape == ()
    np.testing.assert_array_equal(night.irradiance(None, times, nm), table)
    now = sky.background_at(night, float(times[5, 0]))
    np.testing.assert_allclose(now.irradiance(nm), table[5], rtol=1e-14)
