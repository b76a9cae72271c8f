"""Background skies over time: which times, and the sky at each."""

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.errors import UsageError
from aomc_sky.pictures.backgrounds import frame_times_s, moving_picture, time_span_s, time_text
from aomc_sky.skies.lobes.file.data import ReferenceType
from tests.skies.lobes.animations import DAY, animation, background

STEADY = animation([0.0], [1.0])
DAILY = animation([0.0, 0.5], [0.0, 1.0])
WEEKLY = animation([0.0, 3.5], [0.0, 1.0], ReferenceType.HEBDOMADAL)
ONCE = animation([0.25, 2.0], [0.0, 1.0], ReferenceType.ABSOLUTE, time_point_s=1.7e9)


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
    assert time_span_s(background(*parts, utc_offset_h=offset)) == pytest.approx(span)


def test_frames_say_their_time_and_stop_before_the_sky_repeats_itself():
    assert frame_times_s(0.0, DAY, 4).tolist() == [0.0, 21600.0, 43200.0, 64800.0]
    for wrong in ((0.0, 1.0, 1), (0.0, 1.0, 13)):
        with pytest.raises(UsageError):
            frame_times_s(*wrong)
    assert time_text(background(DAILY, utc_offset_h=1.0), 9 * 3600.0) == "10:00 local time"
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


def test_a_sky_that_changes_is_no_still():
    pytest.importorskip("matplotlib")
    with pytest.raises(UsageError, match="background_at"):
        sky.plot(background(DAILY))
    figure = sky.plot(sky.background_at(background(DAILY), 0.5 * DAY))
    assert any("by its mean" in text.get_text().replace("\n", " ") for text in figure.texts)
