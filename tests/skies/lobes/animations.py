"""Animations and background skies made by hand."""

import numpy as np

from aomc_sky.skies.lobes.background import BackgroundSky
from aomc_sky.skies.lobes.file.data import KINDS, Animation, ReferenceType

DAY = 86400.0


def animation(times, coefficients, reference=ReferenceType.DIURNAL, **changes):
    """Keys at these times [days]: lobes of Henyey and Greenstein that point up, of the first curve."""
    n = len(times)
    kinds = changes.pop("kind", ("hg",) * n)
    given = {
        "lobe_type": np.array([KINDS[kind] for kind in kinds], np.uint8),
        "param0": np.linspace(0.0, 0.5, n),
        "param1": np.zeros(n),
        "coefficient": np.array(coefficients, float),
        "quaternion": np.tile((1.0, 0.0, 0.0, 0.0), (n, 1)),
        "curve_index": np.zeros(n, np.int64),
        "relative_time_days": np.array(times, float),
        "reference": reference,
        "time_point_s": 0.0,
    }
    return Animation(**{**given, **changes})


def background(*animations, utc_offset_h=0.0, **named):
    """A sky of two curves, the second of them even."""
    return BackgroundSky(
        animations={f"a{i}": one for i, one in enumerate(animations)} | named,
        wavelength_nm=np.array([400.0, 500.0, 700.0]),
        curves=np.array([[1.0, 2.0, 6.0], [8.0, 8.0, 8.0]]),
        utc_offset_h=utc_offset_h,
    )
