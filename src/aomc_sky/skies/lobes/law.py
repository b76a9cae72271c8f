"""The laws HG, GGX and BECKMANN: one lobe times the cosine, as `CellLaw` asks for it."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from aomc_sky.component import CellLaw, Component
from aomc_sky.skies.lobes.envelope import lobe_of
from aomc_sky.skies.lobes.horizon import masses_of_lobe
from aomc_sky.skies.lobes.lobe import axis_deg
from aomc_sky.skies.lobes.patches import TiltedLobe, patch_shares
from aomc_sky.skies.lobes.tables import LobeTables

_N_SHARED = 10
_N_ENVELOPE = 8
_MAX_BINS = 2**16  # the number of a bin in its cell, and of a cell in its lobe, share one word of 32 bits


def _lobe(component: Component) -> TiltedLobe:
    kind, param0, param1, rotation = lobe_of(component)
    return TiltedLobe(kind=kind, param0=param0, param1=param1, rotation=rotation)


def _axis_deg(component: Component) -> tuple[float, float, float]:
    """Direction of the axis, and twice the angle that holds half of a lobe, of the narrower way where it has two."""
    kind, first, second, rotation = lobe_of(component)
    if kind == "hg":
        half = 2.0 * math.asin((1.0 - first) * math.sqrt(2.0 + first) / 2.0)
    else:
        half = math.atan(min(first, second) * (1.0 if kind == "ggx" else math.sqrt(math.log(2.0))))
    return *axis_deg(rotation), 2.0 * math.degrees(half)


def _radiance(component: Component) -> Callable[[float, np.ndarray, np.ndarray], np.ndarray]:
    lobe = _lobe(component)
    projected = masses_of_lobe(lobe.kind, lobe.param0, lobe.param1, lobe.rotation[2])[1]
    return partial(_radiance_at, lobe, 1.0 / projected)


def _radiance_at(
    lobe: TiltedLobe, per_irradiance: float, irradiance: float, zenith: np.ndarray, azimuth: np.ndarray
) -> np.ndarray:
    sine, (along_x, along_y, axis) = np.sin(zenith), lobe.rotation.T.tolist()
    x, y, z = sine * np.cos(azimuth), sine * np.sin(azimuth), np.cos(zenith)
    h = ((x - axis[0]) ** 2 + (y - axis[1]) ** 2 + (z - axis[2]) ** 2) / 4.0
    m_x, m_y = (x * a + y * b + z * c for a, b, c in (along_x, along_y))
    return lobe.density(lobe.kind, h, m_x, m_y) * (irradiance * per_irradiance)


def _refused(cell: np.ndarray, bounds: np.ndarray | None) -> tuple[str, str, str] | None:
    assert bounds is not None  # `tables` says so
    if len(cell) != 1:
        return "component_start", f"{len(cell)} cells", "one for a lobe"
    count = bounds[:, 3]
    total = int(min(count.sum(), 2.0 * _MAX_BINS)) if count.min() >= 1 and np.all(count == np.rint(count)) else 0
    is_power = 2 <= total <= _MAX_BINS and total.bit_count() == 1
    return None if is_power else ("bounds", "", f"a power of two of whole bins, 2 to {_MAX_BINS}")


LOBE = CellLaw(
    moments=lambda component: (component.cell[:, 0], component.cell[:, 2]),
    reaches_horizon=lambda cell: np.ones(len(cell), dtype=bool),
    shares=patch_shares,
    radiance=_radiance,
    width_rad=lambda component: _lobe(component).width,
    axis_deg=_axis_deg,
    leave_out="leave [[background]] out of sky.toml: the AOMC program knows no lobes",
    tables=lambda _, n_bound: ((_N_SHARED,), (n_bound, _N_ENVELOPE)),
    refused=_refused,
    hook="lobes",
    hook_tables=LobeTables.of,
)
