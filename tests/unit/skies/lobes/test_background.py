"""Background skies: three kinds of reference time, keys that fade into each other, spectra."""

import csv

import numpy as np
import pytest

from aomc_sky.errors import SceneError, UsageError
from aomc_sky.skies.lobes import functions as lobes
from aomc_sky.skies.lobes.animation import LobeAnimation, Reference
from aomc_sky.skies.lobes.background import BackgroundSky, background_at
from aomc_sky.source.backgrounds.light import read_background
from tests.support.background import plain_file
from tests.support.shared import SHARED, needs_shared

UP = (1.0, 0.0, 0.0, 0.0)
DAY = 86400.0
SATURDAY_2024_06_01 = 1_717_200_000.0  # midnight UTC


def animation(times, coefficients, reference=Reference.DIURNAL, **changes):
    n = len(times)
    given = {
        "kind": ("hg",) * n,
        "param0": np.linspace(0.0, 0.5, n),
        "param1": np.zeros(n),
        "coefficient": np.array(coefficients, float),
        "quaternion": np.tile(UP, (n, 1)),
        "curve": np.zeros(n, np.int64),
        "time_days": np.array(times, float),
        "reference": reference,
        "reference_unix_s": SATURDAY_2024_06_01,
    }
    return LobeAnimation(**{**given, **changes})


def background(*animations, utc_offset_h=0.0):
    return BackgroundSky(
        animations={f"a{i}": one for i, one in enumerate(animations)},
        wavelength_nm=np.array([400.0, 500.0, 700.0]),
        curves=np.array([[1.0, 2.0, 6.0], [8.0, 8.0, 8.0]]),
        utc_offset_h=utc_offset_h,
    )


@pytest.mark.parametrize(
    ("reference", "unix_s", "days"),
    [
        (Reference.DIURNAL, SATURDAY_2024_06_01, 0.0),
        (Reference.DIURNAL, SATURDAY_2024_06_01 - 43200, 0.5),
        (Reference.DIURNAL, -1.0, 86399 / DAY),
        (Reference.HEBDOMADAL, SATURDAY_2024_06_01, 6.0),
        (Reference.HEBDOMADAL, SATURDAY_2024_06_01 + DAY, 0.0),
        (Reference.HEBDOMADAL, 0.0, 4.0),
        (Reference.ABSOLUTE, SATURDAY_2024_06_01 - DAY, -1.0),
    ],
)
def test_relative_times(reference, unix_s, days):
    assert animation([0.0], [1.0], reference).relative_days(unix_s) == days


def test_midnight_is_local_with_an_offset():
    one = animation([0.0], [1.0])
    assert one.relative_days(SATURDAY_2024_06_01, utc_offset_h=2.0) == 2 / 24
    assert one.relative_days(SATURDAY_2024_06_01 - 7200, utc_offset_h=2.0) == 0.0
    sky = background(animation([0.0, 0.5], [0.0, 12.0]), utc_offset_h=-1.0)
    assert sky.irradiance("a0", 2 * 3600.0, 400.0) == pytest.approx(1.0, rel=1e-15)


def test_keys_fade_into_each_other_and_the_end_keys_hold():
    sky = background(animation([0.25, 0.5, 0.5, 0.75], [1.0, 3.0, 10.0, 20.0]))
    hours = np.array([0.0, 6.0, 9.0, 11.999999, 12.0, 15.0, 18.0, 23.0])
    expected = [1, 1, 2, 3, 10, 15, 20, 20]
    assert sky.irradiance("a0", 3600 * hours, 400.0) == pytest.approx(expected, rel=1e-6)
    assert sky.irradiance("a0", 12 * 3600.0, 400.0) == 10.0  # of two keys at one time the later wins


def test_times_and_wavelengths_broadcast_and_animations_add():
    two = animation([0.0, 1.0], [1.0, 1.0], curve=np.array([0, 1]))
    sky = background(two, animation([0.0], [2.0]))
    times = np.array([0.0, 43200.0])[:, None]
    got = sky.irradiance("a0", times, np.array([400.0, 450.0, 700.0]))
    assert got == pytest.approx(np.array([[1.0, 1.5, 6.0], [4.5, 4.75, 7.0]]), rel=1e-15)
    both = sky.irradiance(None, times, 450.0)
    assert both == pytest.approx(sky.irradiance("a0", times, 450.0) + sky.irradiance("a1", times, 450.0), rel=1e-15)


def test_end_wavelengths_hold_within_the_rounding_of_float32():
    sky = background(animation([0.0], [1.0]))
    assert sky.irradiance("a0", 0.0, 400.0 * (1 - 9e-7)) == 1.0
    assert sky.irradiance("a0", 0.0, 700.0 * (1 + 9e-7)) == 6.0
    for wrong in (400.0 * (1 - 2e-6), 700.1, np.nan):
        with pytest.raises(SceneError, match="outside"):
            sky.irradiance("a0", 0.0, wrong)


def test_above_the_horizon():
    sky = background(animation([0.0], [4.0]))
    assert sky.irradiance("a0", 0.0, 400.0, above="horizon") == pytest.approx(2.0, rel=1e-14)
    assert sky.irradiance("a0", 0.0, 400.0, above="projected") == pytest.approx(1.0, rel=1e-14)
    with pytest.raises(UsageError, match="above"):
        sky.irradiance("a0", 0.0, 400.0, above="sea")


def test_radiance_integrates_to_the_irradiance_above_the_horizon():
    tilted = np.array([[0.6, 0.3, -0.2, 0.7], [0.9, -0.4, 0.1, 0.0]])
    one = animation(
        [0.0, 1.0], [1.0, 3.0], kind=("hg", "ggx"), param0=np.array([0.4, 0.9]), param1=np.array([0.0, 0.7]),
        quaternion=tilted,
    )  # fmt: skip
    sky = background(one)
    mu, weight = np.polynomial.legendre.leggauss(400)
    mu, weight = (mu + 1) / 2, weight / 2
    phi = (np.arange(400) + 0.5) * 2 * np.pi / 400
    radiance = background_at(sky, 0.3 * DAY).radiance(np.arccos(mu)[:, None], phi, 450.0)
    plain = 2 * np.pi * np.sum(weight * radiance.mean(axis=1))
    projected = 2 * np.pi * np.sum(weight * mu * radiance.mean(axis=1))
    assert plain == pytest.approx(sky.irradiance("a0", 0.3 * DAY, 450.0, above="horizon"), rel=1e-4)
    assert projected == pytest.approx(sky.irradiance("a0", 0.3 * DAY, 450.0, above="projected"), rel=1e-4)
    tail = lobes.pdf("hg", 0.4, 0.0, lobes.to_local(tilted[0], [0.0, 0.0, 1.0])) * 0.7
    tail += 3 * 0.3 * lobes.pdf("ggx", 0.9, 0.7, lobes.to_local(tilted[1], [0.0, 0.0, 1.0]))
    assert background_at(sky, 0.3 * DAY).radiance(0.0, 0.0, 400.0) == pytest.approx(tail, rel=1e-13)


@pytest.mark.parametrize(
    "changes",
    [
        {"time_days": np.array([0.5, 0.25])},
        {"time_days": np.array([0.5, np.nan])},
        {"coefficient": np.array([1.0, -1.0])},
        {"coefficient": np.array([1.0, np.inf])},
        {"quaternion": np.zeros((2, 4))},
        {"param0": np.array([0.5, 1.0])},
        {"param0": np.array([0.5])},
    ],
)
def test_bad_animations_are_refused(changes):
    with pytest.raises(SceneError):
        animation([0.0, 1.0], [1.0, 1.0], **changes)


def test_bad_skies_are_refused():
    with pytest.raises(SceneError, match="curve"):
        background(animation([0.0], [1.0], curve=np.array([2])))
    with pytest.raises(SceneError, match="offset"):
        background(animation([0.0], [1.0]), utc_offset_h=np.nan)
    sky = background(animation([0.0], [1.0]))
    with pytest.raises(UsageError, match="a0"):
        sky.irradiance("moon", 0.0, 500.0)
    with pytest.raises(SceneError, match="time"):
        sky.irradiance("a0", np.inf, 500.0)


@pytest.fixture
def reference():
    """The reference file as a sky, and the rows of a table beside it."""
    pytest.importorskip("h5py")

    def rows(name):
        with (SHARED / "lobes" / name).open() as lines:
            return list(csv.DictReader(lines))

    return read_background(SHARED / "lobes" / "background_sky_a.h5"), rows


@needs_shared
def test_reference_times_row_by_row(reference):
    sky, rows = reference
    table = rows("background_sky_a_times.csv")
    assert len(table) == 425
    for row in table:
        one, time = sky.animations[row["animation"]], float(row["unix_time_s"])
        low, high, fraction = one.between(one.relative_days(time))
        assert (low, high) == (int(row["key_lo"]), int(row["key_hi"]))
        assert one.relative_days(time) == pytest.approx(float(row["relative_time_days"]), rel=6e-13, abs=1e-15)
        assert fraction == pytest.approx(float(row["fraction"]), rel=6e-13, abs=1e-15)
        got = sky.irradiance(row["animation"], time, 1000 * float(row["wavelength_um"])) / 10
        assert got == pytest.approx(float(row["irradiance"]), rel=6e-13, abs=0)


@needs_shared
@pytest.mark.parametrize("interpolation", ["crossfade", "slerp"])
def test_reference_times_of_the_whole_sky(reference, interpolation):
    """All animations at once, as lobes: their irradiances add up to the rows of the table."""
    sky, rows = reference
    total: dict[tuple[float, float], float] = {}
    for row in rows("background_sky_a_times.csv"):
        at = (float(row["unix_time_s"]), 1000 * float(row["wavelength_um"]))
        total[at] = total.get(at, 0.0) + 10 * float(row["irradiance"])
    for time in {time for time, _ in total}:
        now = background_at(sky, time, interpolation=interpolation)
        for wavelength in (nm for when, nm in total if when == time):
            assert now.irradiance(wavelength) == pytest.approx(total[time, wavelength], rel=1e-12)


@needs_shared
def test_reference_lobes_row_by_row(reference):
    sky, rows = reference
    table = rows("background_sky_a_lobes.csv")
    assert len(table) == sum(len(one.kind) for one in sky.animations.values())
    for row in table:
        one, key = sky.animations[row["animation"]], int(row["key"])
        shape = (one.kind[key], one.param0[key], one.param1[key], one.quaternion[key])
        axis = lobes.to_world(one.quaternion[key], [0.0, 0.0, 1.0])
        np.testing.assert_allclose(axis, [float(row[f"axis_{c}"]) for c in "xyz"], rtol=1e-12, atol=3e-16)
        zenith = np.rad2deg(np.arctan2(np.hypot(axis[0], axis[1]), axis[2]))
        assert zenith == pytest.approx(float(row["axis_zenith_deg"]), abs=6e-7)
        if row["axis_azimuth_from_north_deg"]:
            azimuth = np.rad2deg(np.arctan2(axis[0], axis[1])) % 360
            assert azimuth == pytest.approx(float(row["axis_azimuth_from_north_deg"]), abs=6e-7)
        assert lobes.mass_above_horizon(*shape) == pytest.approx(float(row["mass_above_horizon"]), rel=1e-12)
        projected = lobes.mass_above_horizon(*shape, weighting="projected")
        assert projected == pytest.approx(float(row["cosine_weighted_mass_above_horizon"]), rel=1e-9)
        light = one.coefficient[key] * sky.curves[one.curve[key]]
        steps = np.diff(sky.wavelength_nm) * (light[1:] + light[:-1]) / 2
        assert steps.sum() / 1e4 == pytest.approx(float(row["irradiance_integral_trapezoid"]), rel=1e-12)


@pytest.fixture(scope="module")
def night(tmp_path_factory):
    """A diurnal animation with keys at 0, 6 and 24 h, written by h5py alone, in micrometres and W cm-2 um-1."""
    pytest.importorskip("h5py")
    return read_background(plain_file(tmp_path_factory.mktemp("night") / "night.h5"))


def test_irradiance_in_our_units(night):
    assert isinstance(night, BackgroundSky)
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
    now = background_at(night, float(times[5, 0]))
    np.testing.assert_allclose(now.irradiance(nm), table[5], rtol=1e-14)


@pytest.mark.parametrize(("time", "offset"), [("noon", 0.0), (None, 0.0), (0.0, "east")])
def test_a_time_that_is_no_number(time, offset):
    with pytest.raises(UsageError, match="real numbers"):
        animation([0.0], [1.0]).relative_days(time, utc_offset_h=offset)


def test_times_and_wavelengths_that_do_not_broadcast():
    with pytest.raises(UsageError, match="do not broadcast"):
        background(animation([0.0], [1.0])).irradiance(None, [0.0, 1.0, 2.0], [400.0, 500.0])
