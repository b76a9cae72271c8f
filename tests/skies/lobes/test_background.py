"""Background skies: three kinds of reference time, keys that fade into each other, spectra."""

import dataclasses

import numpy as np
import pytest

import aomc_sky
from aomc_sky.errors import SceneError, UsageError
from aomc_sky.skies.lobes import functions as lobes
from aomc_sky.skies.lobes.background import background_at
from aomc_sky.skies.lobes.file.data import ReferenceType
from aomc_sky.skies.lobes.light import read_background
from aomc_sky.skies.lobes.lobe import slerp
from tests.skies.lobes.animations import DAY, animation, background
from tests.support.shared import REFERENCE, csv_rows

SATURDAY_2024_06_01 = 1_717_200_000.0  # midnight UTC
ANGLES = (np.linspace(0.0, np.pi / 2, 7)[:, None], np.linspace(0.0, 6.0, 9))


def turn(degrees):
    half = np.deg2rad(degrees) / 2
    return np.array([np.cos(half), 0.0, np.sin(half), 0.0])


def glow(coefficients=(1.0, 3.0), **changes):
    """Two keys of a lobe a day apart, each with its shape, direction and curve."""
    shapes = {"kind": ("ggx", "ggx"), "param0": np.array([0.2, 0.6]), "param1": np.array([0.4, 0.4])}
    where = {"quaternion": np.stack([turn(0.0), turn(80.0)]), "curve_index": np.array([0, 1])}
    return animation([0.0, 1.0], coefficients, **(shapes | where | changes))


@pytest.mark.parametrize(
    ("reference", "unix_s", "days"),
    [
        (ReferenceType.DIURNAL, SATURDAY_2024_06_01 - 43200, 0.5),
        (ReferenceType.DIURNAL, -1.0, 86399 / DAY),
        (ReferenceType.HEBDOMADAL, SATURDAY_2024_06_01 + DAY, 0.0),
        (ReferenceType.HEBDOMADAL, 0.0, 4.0),
        (ReferenceType.ABSOLUTE, SATURDAY_2024_06_01 - DAY, -1.0),
    ],
)
def test_relative_times(reference, unix_s, days):
    assert animation([0.0], [1.0], reference, time_point_s=SATURDAY_2024_06_01).relative_days(unix_s) == days


def test_keys_fade_and_the_end_keys_hold():
    sky = background(animation([0.25, 0.5, 0.5, 0.75], [1.0, 3.0, 10.0, 20.0]))
    hours = np.array([0.0, 6.0, 9.0, 11.999999, 12.0, 15.0, 18.0, 23.0])
    assert sky.irradiance("a0", 3600 * hours, 400.0) == pytest.approx([1, 1, 2, 3, 10, 15, 20, 20], rel=1e-6)
    assert sky.irradiance("a0", 12 * 3600.0, 400.0) == 10.0  # of two keys at one time the later wins
    sky = background(animation([0.0, 1.0], [1.0, 1.0], curve_index=np.array([0, 1])), animation([0.0], [2.0]))
    times = np.array([0.0, 43200.0])[:, None]
    got = sky.irradiance("a0", times, np.array([400.0, 450.0, 700.0]))
    assert got == pytest.approx(np.array([[1.0, 1.5, 6.0], [4.5, 4.75, 7.0]]), rel=1e-15)
    both = sky.irradiance(None, times, 450.0)
    assert both == pytest.approx(sky.irradiance("a0", times, 450.0) + sky.irradiance("a1", times, 450.0), rel=1e-15)
    sky = background(animation([0.0], [1.0]))
    assert sky.irradiance("a0", 0.0, 400.0 * (1 - 9e-7)) == 1.0
    assert sky.irradiance("a0", 0.0, 700.0 * (1 + 9e-7)) == 6.0
    for wrong in (400.0 * (1 - 2e-6), 700.1, np.nan):
        with pytest.raises(SceneError, match="outside"):
            sky.irradiance("a0", 0.0, wrong)
    one = animation([0.0], [1.0])
    assert one.relative_days(SATURDAY_2024_06_01, utc_offset_h=2.0) == 2 / 24
    assert one.relative_days(SATURDAY_2024_06_01 - 7200, utc_offset_h=2.0) == 0.0
    sky = background(animation([0.0, 0.5], [0.0, 12.0]), utc_offset_h=-1.0)
    assert sky.irradiance("a0", 2 * 3600.0, 400.0) == pytest.approx(1.0, rel=1e-15)


def test_radiance_integrates_to_the_irradiance_above_the_horizon():
    tilted = np.array([[0.6, 0.3, -0.2, 0.7], [0.9, -0.4, 0.1, 0.0]])
    shapes = {"kind": ("hg", "ggx"), "param0": np.array([0.4, 0.9]), "param1": np.array([0.0, 0.7])}
    sky = background(animation([0.0, 1.0], [1.0, 3.0], **shapes, quaternion=tilted))
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


STEADY = background(animation([0.0], [1.0]))


TWO = animation([0.0, 1.0], [1.0, 1.0])
UP = {"name": "x", "kind": "hg", "param0": 0.5, "param1": 0.0, "quaternion": turn(0.0)}
UP |= {"wavelength_nm": [500.0], "spectrum": [1.0]}
BAD_KEYS = [
    {"relative_time_days": np.array([0.5, 0.25])}, {"coefficient": np.array([1.0, -1.0])},
    {"quaternion": np.zeros((2, 4))}, {"param0": np.array([0.5, 1.0])}, {"param0": np.array([0.5])},
    {"relative_time_days": np.array([0.5, 1.5])}, {"relative_time_days": np.array([-0.5, 0.5])},
]  # fmt: skip
BAD_LOBES = [
    {"param0": 1.0}, {"quaternion": np.zeros(4)}, {"quaternion": np.ones(3)}, {"spectrum": [-1.0]},
    {"spectrum": [1.0, 2.0]}, {"wavelength_nm": [np.nan]}, {"wavelength_nm": [], "spectrum": []},
]  # fmt: skip


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        *((lambda bad=bad: background(dataclasses.replace(TWO, **bad)), SceneError, r"error\[E50") for bad in BAD_KEYS),
        *((lambda bad=bad: aomc_sky.lobes.WeightedLobe(**UP | bad), SceneError, None) for bad in BAD_LOBES),
        (lambda: background(animation([0.0], [1.0], curve_index=np.array([2]))), SceneError, "curve"),
        (lambda: background(animation([0.0], [1.0], lobe_type=np.uint8([9]))), SceneError, r"Type \[0\] is 9"),
        (lambda: dataclasses.replace(STEADY, wavelength_nm=-STEADY.wavelength_nm), SceneError, r"is -0\.\d+ um"),
        (lambda: dataclasses.replace(STEADY, wavelength_nm=STEADY.wavelength_nm[:1]), SceneError, "shape"),
        (lambda: dataclasses.replace(STEADY, curves=np.array(1.0)), SceneError, "shape"),
        (lambda: dataclasses.replace(STEADY, curves=STEADY.curves * np.inf), SceneError, "finite"),
        (lambda: background(animation([0.0], [1.0]), utc_offset_h=np.nan), SceneError, "offset"),
        (lambda: STEADY.irradiance("moon", 0.0, 500.0), UsageError, "a0"),
        (lambda: STEADY.irradiance(None, [0.0, 1.0, 2.0], [400.0, 500.0]), UsageError, "do not broadcast"),
        (lambda: STEADY.irradiance("a0", np.inf, 500.0), SceneError, "time"),
        (lambda: background_at(STEADY, 0.0, utc_offset_h=np.inf), SceneError, "finite"),
        (lambda: background_at(STEADY, 0.0).radiance(0.0, 0.0, 701.0), SceneError, "outside"),
        (lambda: aomc_sky.LobeSky(lobes=background_at(STEADY, 0.0).lobes * 2), SceneError, "differ"),
    ],
)
def test_bad_skies_are_refused(call, error, words):
    with pytest.raises(error, match=words):
        call()


def test_reference_times_row_by_row():
    pytest.importorskip("h5py")
    sky = read_background(REFERENCE / "lobes" / "background_sky_a.h5")
    table = csv_rows(REFERENCE / "lobes" / "background_sky_a_times.csv")
    assert len(table) == 425
    for row in table:
        one, time = sky.animations[row["animation"]], float(row["unix_time_s"])
        low, high, fraction = one.between(one.relative_days(time))
        assert (low, high) == (int(row["key_lo"]), int(row["key_hi"]))
        assert one.relative_days(time) == pytest.approx(float(row["relative_time_days"]), rel=6e-13, abs=1e-15)
        assert fraction == pytest.approx(float(row["fraction"]), rel=6e-13, abs=1e-15)
        got = sky.irradiance(row["animation"], time, 1000 * float(row["wavelength_um"])) / 10
        assert got == pytest.approx(float(row["irradiance"]), rel=6e-13, abs=0)


def test_keys_fade_into_each_other_in_shape_and_direction():
    night = background(glow=glow())
    now = background_at(night, 0.25 * DAY)
    assert [lobe.name for lobe in now.lobes] == ["glow/0", "glow/1"]
    assert [lobe.param0 for lobe in now.lobes] == [0.2, 0.6]
    np.testing.assert_allclose(now.lobes[0].spectrum, [0.75, 1.5, 4.5], rtol=1e-15)
    np.testing.assert_allclose(now.lobes[1].spectrum, [6.0, 6.0, 6.0], rtol=1e-15)
    # the last key alone, from the law
    end = aomc_sky.lobes.WeightedLobe(
        name="end", kind="ggx", param0=0.6, param1=0.4, quaternion=turn(80.0),
        wavelength_nm=night.wavelength_nm, spectrum=3.0 * night.curves[1],
    )  # fmt: skip
    ends = background_at(night, 0.0), aomc_sky.LobeSky(lobes=(end,))
    expected = sum(share * key.radiance(*ANGLES, 450.0) for share, key in zip((0.75, 0.25), ends, strict=True))
    np.testing.assert_allclose(now.radiance(*ANGLES, 450.0), expected, rtol=1e-14)


@pytest.mark.parametrize("interpolation", ["crossfade", "slerp"])
def test_irradiance_is_the_same_for_both_interpolations(interpolation):
    night = background(glow=glow(), town=glow(kind=("hg", "beckmann")))
    for at in (0.0, 0.3 * DAY, 0.999 * DAY):
        now = background_at(night, at, interpolation=interpolation)
        expected = night.irradiance(None, at, [400.0, 450.0, 700.0])
        np.testing.assert_allclose(now.irradiance([400.0, 450.0, 700.0]), expected, rtol=1e-14)


def test_keys_turn_the_short_way_or_fade():
    opposite = glow(quaternion=np.stack([turn(0.0), -7.0 * turn(80.0)]))
    (lobe,) = background_at(background(glow=opposite), 0.25 * DAY, interpolation="slerp").lobes
    np.testing.assert_allclose(lobe.quaternion, turn(20.0), atol=2e-16)
    assert (lobe.name, lobe.kind) == ("glow", "ggx")
    assert lobe.param0 == pytest.approx(0.3, rel=1e-15)
    assert lobe.param1 == 0.4
    night = background(glow=glow(kind=("hg", "ggx")))
    fading, turning = (background_at(night, 0.5 * DAY, interpolation=how) for how in ("crossfade", "slerp"))
    assert [lobe.kind for lobe in turning.lobes] == ["hg", "ggx"]
    np.testing.assert_array_equal(fading.radiance(*ANGLES, 500.0), turning.radiance(*ANGLES, 500.0))
    still = glow(param0=np.array([0.2, 0.2]), quaternion=np.stack([turn(5.0)] * 2))
    (lobe,) = background_at(background(glow=still), 0.5 * DAY).lobes
    np.testing.assert_allclose(lobe.spectrum, [12.5, 13.0, 15.0], rtol=1e-15)
    np.testing.assert_array_equal(lobe.quaternion, turn(5.0))


def test_dark_lobes_are_left_out_and_skies_add():
    night = background(glow=glow([0.0, 1.0]))
    assert [lobe.name for lobe in background_at(night, 0.5 * DAY).lobes] == ["glow/1"]
    black = background_at(night, 0.0)
    assert black.lobes == ()
    np.testing.assert_array_equal(black.radiance(*ANGLES, 500.0), np.zeros((7, 9)))
    one, two = background(glow=glow()), background(glow=glow([5.0, 0.0]))
    both = background_at([one, two], 0.5 * DAY)
    assert [lobe.name for lobe in both.lobes] == ["1/glow/0", "1/glow/1", "2/glow/0"]
    apart = sum(background_at(each, 0.5 * DAY).radiance(*ANGLES, 600.0) for each in (one, two))
    np.testing.assert_allclose(both.radiance(*ANGLES, 600.0), apart, rtol=1e-15)


@pytest.mark.parametrize("angle", [0.0, 1e-16, 1e-9, 1e-5, 1.0, 179.999999, 180.0])
def test_slerp_keeps_its_digits(angle):
    for share in (0.0, 1e-9, 0.3, 0.5, 1.0):
        got = slerp(3.0 * turn(0.0), turn(angle), share)
        got = got / np.linalg.norm(got)
        np.testing.assert_allclose(got, turn(share * angle), rtol=1e-15 * 4, atol=1e-300)


def test_components_carry_the_light_of_a_horizontal_plane():
    night = background(glow=glow(), town=glow([2.0, 0.5], kind=("hg", "beckmann")))
    wavelength = np.array([400.0, 450.0, 700.0])
    components = background_at(night, 0.3 * DAY).lower(wavelength)
    assert [one.name for one in components] == ["glow:0", "glow:1", "town:0", "town:1"]
    expected = night.irradiance(None, 0.3 * DAY, wavelength, above="projected")
    np.testing.assert_allclose(sum(one.strength for one in components), expected, rtol=1e-12)
    assert aomc_sky.LobeSky(lobes=()).lower(wavelength) == ()
