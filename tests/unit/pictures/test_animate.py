"""Background skies over time: which times, what the frames share, the file."""

from __future__ import annotations

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.errors import UsageError
from aomc_sky.pictures.animate import frame_times_s, moving_picture, time_span_s, time_text
from aomc_sky.skies.lobes.animation import LobeAnimation, Reference

DAY = 86400.0


def animation(times, coefficient, reference=Reference.DIURNAL, origin=0.0, kind="hg"):
    n = len(times)
    return LobeAnimation(
        kind=(kind,) * n,
        param0=np.full(n, 0.5),
        param1=np.full(n, 0.5),
        coefficient=np.array(coefficient, dtype=float),
        quaternion=np.tile([1.0, 0.3, 0.1, 0.0], (n, 1)),
        curve=np.zeros(n, dtype=np.int64),
        time_days=np.array(times, dtype=float),
        reference=reference,
        reference_unix_s=origin,
    )


def background(*animations, offset=0.0):
    return sky.BackgroundSky(
        animations={f"a{k}": one for k, one in enumerate(animations)},
        wavelength_nm=np.array([400.0, 700.0]),
        curves=np.array([[1.0, 1.0]]),
        utc_offset_h=offset,
    )


STEADY = animation([0.0], [1.0])
DAILY = animation([0.0, 0.5], [0.0, 1.0])
WEEKLY = animation([0.0, 3.5], [0.0, 1.0], Reference.HEBDOMADAL)
ONCE = animation([0.25, 2.0], [0.0, 1.0], Reference.ABSOLUTE, 1.7e9)


@pytest.mark.parametrize(
    ("parts", "offset", "span"),
    [
        ((STEADY,), 0.0, (0.0, DAY)),
        ((DAILY, STEADY), 2.0, (-7200.0, DAY - 7200.0)),
        ((DAILY, WEEKLY), 0.0, (3 * DAY, 10 * DAY)),
        ((ONCE, DAILY), 0.0, (1.7e9 + 0.25 * DAY, 1.7e9 + 2 * DAY)),
    ],
)
def test_the_time_over_which_a_sky_changes(parts, offset, span):
    assert time_span_s(background(*parts, offset=offset)) == pytest.approx(span)


def test_times_of_frames_stop_before_the_sky_repeats_itself():
    assert frame_times_s(0.0, DAY, 4).tolist() == [0.0, 21600.0, 43200.0, 64800.0]
    for wrong in ((0.0, 0.0, 4), (0.0, 1.0, 1), (0.0, 1.0, 1001)):
        with pytest.raises(UsageError):
            frame_times_s(*wrong)


def test_frames_say_their_time():
    assert time_text(background(DAILY, offset=1.0), 9 * 3600.0) == "10:00 local time"
    assert time_text(background(WEEKLY), 3 * DAY) == "Sunday 00:00 local time"
    assert time_text(background(ONCE), 1.7e9) == "2023-11-14T22:13:20Z"


def test_each_frame_is_the_sky_at_its_time():
    one = background(DAILY)
    picture = moving_picture(one, 550.0, [0.0, 0.25 * DAY, 0.5 * DAY])
    none, half, full = (dome.values for dome in picture.domes)
    assert none.max() == 0.0
    np.testing.assert_allclose(half, full / 2, rtol=1e-12)
    area = picture.domes[0].grid.projected_solid_angle_sr
    assert float(full @ area) == pytest.approx(float(one.irradiance(None, 0.5 * DAY, 550.0, above="projected")))


def test_the_animation_has_its_frames_in_common_colours_and_one_size(tmp_path):
    image = pytest.importorskip("PIL.Image")
    pytest.importorskip("matplotlib")
    path = tmp_path / "sky.gif"
    times = sky.animate(background(DAILY), path, n_frames=4, size_px=300, frame_ms=200)
    assert times.tolist() == [0.0, 21600.0, 43200.0, 64800.0]
    with image.open(path) as moving:
        assert moving.n_frames == 4
        assert moving.info["loop"] == 0
        frames = []
        for k in range(4):
            moving.seek(k)
            assert moving.info["duration"] == 200
            frames.append(np.asarray(moving.convert("RGB")))
    assert {frame.shape for frame in frames} == {frames[0].shape}
    assert frames[0].shape[1] == 300
    assert all((frame[0, 0] == 255).all() for frame in frames)
    # the first frame is dark, the last two are equal apart from their time
    rows = slice(frames[0].shape[0] // 3, frames[0].shape[0] // 2)
    assert np.array_equal(frames[2][rows], frames[3][rows])
    assert not np.array_equal(frames[0][rows], frames[1][rows])


def test_equal_animations_are_equal_files(tmp_path):
    pytest.importorskip("matplotlib")
    for name in ("a.gif", "b.gif"):
        sky.animate(background(DAILY), tmp_path / name, n_frames=2, size_px=300)
    assert (tmp_path / "a.gif").read_bytes() == (tmp_path / "b.gif").read_bytes()
    assert len(list(tmp_path.iterdir())) == 2


@pytest.mark.parametrize(
    "options", [{"path": "a.png"}, {"frame_ms": 1}, {"size_px": 4000}, {"n_frames": 1}, {"stop_s": -1.0}]
)
def test_what_does_not_go_is_refused(options, tmp_path):
    pytest.importorskip("matplotlib")
    with pytest.raises(UsageError):
        sky.animate(background(DAILY), **{"path": tmp_path / "a.gif", "n_frames": 2, **options})


def test_a_sky_that_changes_is_no_still():
    pytest.importorskip("matplotlib")
    with pytest.raises(UsageError, match="animate"):
        sky.plot(background(DAILY))
    figure = sky.plot(sky.background_at(background(DAILY), 0.5 * DAY))
    assert any("by its mean" in text.get_text().replace("\n", " ") for text in figure.texts)
