"""Arguments of the lobes that are no numbers or do not fit together get an error that says so."""

from __future__ import annotations

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.errors import SceneError, UsageError
from aomc_sky.skies.lobes import functions as lobes
from aomc_sky.skies.lobes.animation import LobeAnimation, Reference

UP = (1.0, 0.0, 0.0, 0.0)
GRID = sky.PatchGrid.regular(3, 4)
BACKGROUND = sky.BackgroundSky(animations={}, wavelength_nm=np.array([400.0, 500.0]), curves=np.ones((1, 2)))

CALLS = [
    (lambda: lobes.pdf("ggx", "a", 1.0, (0, 0, 1)), "real numbers"),
    (lambda: lobes.pdf("ggx", 0.1, 1.0, "abc"), "real numbers"),
    (lambda: lobes.pdf("ggx", 0.1, None, (0, 0, 1)), "real numbers"),
    (lambda: lobes.pdf("ggx", [[1.0], [1.0, 2.0]], 1.0, (0, 0, 1)), "real numbers"),
    (lambda: lobes.pdf("ggx", [0.1, 0.2, 0.3], 1.0, [(0, 0, 1)] * 2), "do not broadcast"),
    (lambda: lobes.sample("ggx", 0.1, 0.1, "x", 0.1), "real numbers"),
    (lambda: lobes.sample("hg", 0.1, 0.0, [0.1, 0.2], [0.1, 0.2, 0.3]), "do not broadcast"),
    (lambda: lobes.mass_above_horizon("ggx", 0.1, 0.1, "abcd"), "real numbers"),
    (lambda: lobes.mass_above_horizon("ggx", 0.1, 0.1, (1, 0, 0, 1j)), "real numbers"),
    (lambda: lobes.mass_above_horizon("ggx", [0.1, 0.2, 0.3], 0.1, [UP, UP]), "do not broadcast"),
    (lambda: lobes.patch_mass("ggx", [0.1, 0.2], 0.1, UP, GRID), "one lobe"),
    (lambda: lobes.patch_mass("ggx", 0.1, 0.1, [UP], GRID), "one lobe"),
    (lambda: lobes.to_world(UP, (1.0, 2.0)), "three components"),
    (lambda: lobes.to_local([UP, UP], [(1, 2, 3)] * 3), "do not broadcast"),
    (lambda: BACKGROUND.irradiance(None, [0.0, 1.0, 2.0], [400.0, 500.0]), "do not broadcast"),
]


@pytest.mark.parametrize("call", [c for c, _ in CALLS])
def test_wrong_arguments_are_refused(call):
    message = next(m for c, m in CALLS if c is call)
    with pytest.raises((UsageError, SceneError), match=message):
        call()


@pytest.mark.parametrize(("time", "offset"), [("noon", 0.0), (None, 0.0), (0.0, "east")])
def test_a_time_that_is_no_number(time, offset):
    keys = np.zeros(1)
    animation = LobeAnimation(
        kind=("hg",),
        param0=keys,
        param1=keys,
        coefficient=keys,
        quaternion=np.array([UP]),
        curve=keys.astype(int),
        time_days=keys,
        reference=Reference.DIURNAL,
    )
    with pytest.raises(UsageError, match="real numbers"):
        animation.relative_days(time, utc_offset_h=offset)
