"""Background skies at one time: fading, turning, several skies, lobes made by hand."""

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.skies.lobes.animation import LobeAnimation, Reference
from aomc_sky.skies.lobes.background import Interpolation
from aomc_sky.skies.lobes.lobe import slerp

DAY = 86400.0
ANGLES = (np.linspace(0.0, np.pi / 2, 7)[:, None], np.linspace(0.0, 6.0, 9))


def turn(degrees, axis=(0.0, 1.0, 0.0)):
    half = np.deg2rad(degrees) / 2
    return np.array([np.cos(half), *(np.sin(half) * np.asarray(axis))])


def animation(**changes):
    given = {
        "kind": ("ggx", "ggx"),
        "param0": np.array([0.2, 0.6]),
        "param1": np.array([0.4, 0.4]),
        "coefficient": np.array([1.0, 3.0]),
        "quaternion": np.stack([turn(0.0), turn(80.0)]),
        "curve": np.array([0, 1]),
        "time_days": np.array([0.0, 1.0]),
        "reference": Reference.DIURNAL,
    }
    return LobeAnimation(**{**given, **changes})


def background(utc_offset_h=0.0, **animations):
    return sky.BackgroundSky(
        animations=animations,
        wavelength_nm=np.array([400.0, 500.0, 700.0]),
        curves=np.array([[1.0, 2.0, 6.0], [8.0, 8.0, 8.0]]),
        utc_offset_h=utc_offset_h,
    )


def test_keys_fade_into_each_other():
    night = background(glow=animation())
    now = sky.background_at(night, 0.25 * DAY)
    assert [lobe.name for lobe in now.lobes] == ["glow/0", "glow/1"]
    assert [lobe.param0 for lobe in now.lobes] == [0.2, 0.6]
    np.testing.assert_allclose(now.lobes[0].spectrum, [0.75, 1.5, 4.5], rtol=1e-15)
    np.testing.assert_allclose(now.lobes[1].spectrum, [6.0, 6.0, 6.0], rtol=1e-15)
    start, end = sky.background_at(night, 0.0), _end_key(night)
    expected = 0.75 * start.radiance(*ANGLES, 450.0) + 0.25 * end.radiance(*ANGLES, 450.0)
    np.testing.assert_allclose(now.radiance(*ANGLES, 450.0), expected, rtol=1e-14)


def _end_key(night):
    """The last key alone, from the laws."""
    one = night.animations["glow"]
    lobe = sky.WeightedLobe(
        name="end", kind=one.kind[1], param0=one.param0[1], param1=one.param1[1], quaternion=one.quaternion[1],
        wavelength_nm=night.wavelength_nm, spectrum=one.coefficient[1] * night.curves[one.curve[1]],
    )  # fmt: skip
    return sky.LobeSky(lobes=(lobe,))


@pytest.mark.parametrize("interpolation", ["crossfade", "slerp", Interpolation.SLERP])
def test_irradiance_is_the_same_for_both_interpolations(interpolation):
    night = background(glow=animation(), town=animation(kind=("hg", "beckmann")))
    for at in (0.0, 0.3 * DAY, 0.999 * DAY):
        now = sky.background_at(night, at, interpolation=interpolation)
        expected = night.irradiance(None, at, [400.0, 450.0, 700.0])
        np.testing.assert_allclose(now.irradiance([400.0, 450.0, 700.0]), expected, rtol=1e-14)


def test_keys_of_one_kind_turn_the_short_way():
    opposite = animation(quaternion=np.stack([turn(0.0), -7.0 * turn(80.0)]))
    (lobe,) = sky.background_at(background(glow=opposite), 0.25 * DAY, interpolation="slerp").lobes
    np.testing.assert_allclose(lobe.quaternion, turn(20.0), atol=2e-16)
    assert (lobe.name, lobe.kind) == ("glow", "ggx")
    assert lobe.param0 == pytest.approx(0.3, rel=1e-15)
    assert lobe.param1 == 0.4


def test_keys_of_two_kinds_fade_where_others_turn():
    night = background(glow=animation(kind=("hg", "ggx")))
    fading, turning = (sky.background_at(night, 0.5 * DAY, interpolation=how) for how in Interpolation)
    assert [lobe.kind for lobe in turning.lobes] == ["hg", "ggx"]
    np.testing.assert_array_equal(fading.radiance(*ANGLES, 500.0), turning.radiance(*ANGLES, 500.0))


def test_keys_that_differ_in_light_alone_are_one_lobe():
    still = animation(param0=np.array([0.2, 0.2]), quaternion=np.stack([turn(5.0)] * 2))
    (lobe,) = sky.background_at(background(glow=still), 0.5 * DAY).lobes
    np.testing.assert_allclose(lobe.spectrum, [12.5, 13.0, 15.0], rtol=1e-15)
    np.testing.assert_array_equal(lobe.quaternion, turn(5.0))


def test_lobes_without_light_are_left_out():
    night = background(glow=animation(coefficient=np.array([0.0, 1.0])))
    assert [lobe.name for lobe in sky.background_at(night, 0.5 * DAY).lobes] == ["glow/1"]
    black = sky.background_at(night, 0.0)
    assert black.lobes == ()
    np.testing.assert_array_equal(black.radiance(*ANGLES, 500.0), np.zeros((7, 9)))


def test_several_skies_add():
    one, two = background(glow=animation()), background(glow=animation(coefficient=np.array([5.0, 0.0])))
    both = sky.background_at([one, two], 0.5 * DAY)
    assert [lobe.name for lobe in both.lobes] == ["1/glow/0", "1/glow/1", "2/glow/0"]
    apart = sum(sky.background_at(each, 0.5 * DAY).radiance(*ANGLES, 600.0) for each in (one, two))
    np.testing.assert_allclose(both.radiance(*ANGLES, 600.0), apart, rtol=1e-15)


def test_midnight_moves_with_the_offset():
    here, east = background(glow=animation()), background(utc_offset_h=6.0, glow=animation())
    given = sky.background_at(here, 0.0, utc_offset_h=6.0)
    of_the_sky = sky.background_at(east, 0.0)
    np.testing.assert_array_equal(given.lobes[1].spectrum, of_the_sky.lobes[1].spectrum)
    np.testing.assert_array_equal(given.lobes[1].spectrum, [6.0, 6.0, 6.0])
    assert len(sky.background_at(east, 0.0, utc_offset_h=0.0).lobes) == 1


def test_what_is_refused():
    night = background(glow=animation())
    with pytest.raises(sky.UsageError, match="'crossfade', 'slerp'"):
        sky.background_at(night, 0.0, interpolation="nlerp")
    for at, offset in ((np.nan, None), (0.0, np.inf)):
        with pytest.raises(sky.SceneError, match="finite"):
            sky.background_at(night, at, utc_offset_h=offset)
    now = sky.background_at(night, 0.5 * DAY)
    with pytest.raises(sky.SceneError, match="outside"):
        now.radiance(0.0, 0.0, 701.0)
    with pytest.raises(sky.SceneError, match="differ"):
        sky.LobeSky(lobes=(*now.lobes, *now.lobes))
    good = {"name": "x", "kind": "hg", "param0": 0.5, "param1": 0.0, "quaternion": turn(0.0)}
    good |= {"wavelength_nm": [500.0], "spectrum": [1.0]}
    sky.WeightedLobe(**good)
    for change in (
        {"param0": 1.0}, {"quaternion": np.zeros(4)}, {"quaternion": np.ones(3)}, {"spectrum": [-1.0]},
        {"spectrum": [1.0, 2.0]}, {"wavelength_nm": [np.nan]}, {"wavelength_nm": [], "spectrum": []},
    ):  # fmt: skip
        with pytest.raises(sky.SceneError):
            sky.WeightedLobe(**{**good, **change})


@pytest.mark.parametrize("angle", [0.0, 1e-16, 1e-9, 1e-5, 1.0, 179.999999, 180.0])
def test_slerp_keeps_its_digits(angle):
    for share in (0.0, 1e-9, 0.3, 0.5, 1.0):
        got = slerp(3.0 * turn(0.0), turn(angle), share)
        got = got / np.linalg.norm(got)
        np.testing.assert_allclose(got, turn(share * angle), rtol=1e-15 * 4, atol=1e-300)


def test_components_carry_the_light_of_a_horizontal_plane():
    night = background(glow=animation(), town=animation(kind=("hg", "beckmann"), coefficient=np.array([2.0, 0.5])))
    wavelength = np.array([400.0, 450.0, 700.0])
    components = sky.background_at(night, 0.3 * DAY).lower(wavelength)
    assert [one.name for one in components] == ["glow:0", "glow:1", "town:0", "town:1"]
    expected = night.irradiance(None, 0.3 * DAY, wavelength, above="projected")
    np.testing.assert_allclose(sum(one.strength for one in components), expected, rtol=1e-12)
    assert sky.LobeSky(lobes=()).lower(wavelength) == ()
