"""Skies whose light is known, measured as instruments measure them: the irradiance, its error, and what is said of it.

    python bench/measured_skies.py [--seeds 3] [--without-sun]

Skies: Perez of clearness 1.1, 2 and 8, Harrison-Coombes, overcast, molecules alone (`AtmosphereSky`); suns at zenith
angles of 30, 50 and 72 degrees.
Layouts: the almucantar of AERONET (Holben et al. 1998, table 3), alone and with the principal plane; drifting by 0.2,
1.5 and 3 degrees from its first to its last direction; a hybrid scan, whose zenith angle grows with the azimuth; the
145 directions of Tregenza; 300 random ones up to 86 degrees. Radiances have 0, 1 or 5 % of noise. Printed are, for each
layout and noise over all skies, suns and seeds: the irradiance over the true one; the error of the note over the root
mean square of the relative error of the map, weighted by light; how many were warned of; and the largest radiance more
than 10 degrees from the sun over the brightest one measured there.
"""

from __future__ import annotations

import argparse
import warnings
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import aomc_sky as sky

SUNS_DEG = (30.0, 50.0, 72.0)
NOISES = (0.0, 0.01, 0.05)
ALMUCANTAR = [2, 2.5, 3, 3.5, 4, 4.5, 5, 6, 8, 10, 12, 14, 16, 18, 20, 25, 30, 35, 40, 45, 50, 60, 70, 80, 90, 100, 110]
ALMUCANTAR += [120, 130, 140, 160, 180]
PLANE = [-6, -5, -4.5, -4, -3.5, -3, -2.5, -2, *ALMUCANTAR[:-2]]
"""Angles from the sun, in azimuth along the almucantar, in the principal plane above it and below (-). [deg]"""
NEAR_SUN_DEG = 10.0
NM = 600.0  # one of the wavelengths of the molecules
MOLECULES = Path(__file__).parents[1] / "inputs" / "atmosphere" / "molecules_only.atmo"

Directions = tuple[np.ndarray, np.ndarray]
"""Zenith angles, negative beyond the zenith, and azimuths from the sun. [deg]"""


def almucantar(sun_deg: float, drift_deg: float = 0.0) -> Directions:
    azimuth = np.array([*ALMUCANTAR, *(-angle for angle in ALMUCANTAR)], float)
    return sun_deg + drift_deg * np.linspace(0.0, 1.0, azimuth.size), azimuth


def principal_plane(sun_deg: float) -> Directions:
    zenith = np.array([sun_deg - angle for angle in PLANE if -87 < sun_deg - angle < 87], float)
    return zenith, np.zeros(zenith.size)


def both(sun_deg: float) -> Directions:
    zenith, azimuth = (
        np.concatenate(parts) for parts in zip(almucantar(sun_deg), principal_plane(sun_deg), strict=True)
    )
    return zenith, azimuth


def hybrid(sun_deg: float) -> Directions:
    azimuth = np.array(ALMUCANTAR, float)
    zenith = np.maximum(np.minimum(sun_deg + 0.5 * np.maximum(azimuth - 20, 0), 75.0), sun_deg)
    return np.concatenate([zenith, zenith]), np.concatenate([azimuth, -azimuth])


def tregenza(_: float = 0.0) -> Directions:
    rings = zip((6, 18, 30, 42, 54, 66, 78, 90), (30, 30, 24, 24, 18, 12, 6, 1), strict=True)
    points = [(90 - altitude, 360 * k / n) for altitude, n in rings for k in range(n)]
    zenith, azimuth = np.array(points, float).T
    return zenith, azimuth


def irregular(n: int = 300, seed: int = 0, limit_deg: float = 86.0) -> Directions:
    rng = np.random.default_rng(seed)
    return np.rad2deg(np.arccos(rng.uniform(np.cos(np.deg2rad(limit_deg)), 1, n))), rng.uniform(0, 360, n)


LAYOUTS: dict[str, Callable[[float], Directions]] = {
    "almucantar": almucantar,
    "almucantar and principal plane": both,
    "almucantar drifting by 0.2": lambda sun_deg: almucantar(sun_deg, 0.2),
    "drifting by 1.5": lambda sun_deg: almucantar(sun_deg, 1.5),
    "drifting by 3": lambda sun_deg: almucantar(sun_deg, 3.0),
    "hybrid": hybrid,
    "Tregenza, 145": tregenza,
    "300 random": lambda _: irregular(),
}


def skies(sun_deg: float) -> dict[str, Any]:
    sun = {"sun_zenith_deg": sun_deg, "sun_azimuth_deg": 0.0}
    return {
        **{
            f"clearness {epsilon:g}": sky.PerezSky(**sun, epsilon=epsilon, delta=delta)
            for epsilon, delta in ((1.1, 0.2), (2.0, 0.25), (8.0, 0.12))
        },
        "Harrison-Coombes": sky.HarrisonCoombesSky(**sun),
        "overcast": sky.OvercastSky(),
        "molecules": _molecules(sun_deg),
    }


@cache
def _molecules(sun_deg: float) -> sky.AtmosphereSky:
    return sky.AtmosphereSky.from_file(MOLECULES, wavelength_nm=NM, sun_zenith_deg=sun_deg, sun_azimuth_deg=0.0)


_X, _W = np.polynomial.legendre.leggauss(60)
ZENITH, AZIMUTH = ((_X + 1) * np.pi / 4)[:, None], np.arange(240) * np.pi / 120
WEIGHT = (_W * np.sin(2 * (_X + 1) * np.pi / 4))[:, None] * np.ones(240)
"""Directions of a map of the sky [rad], and their shares of the irradiance of a uniform one."""


class Outcome(NamedTuple):
    """A measured sky beside the true one."""

    irradiance: float  #: Over the true one.
    note: float  #: Error that is told.
    map: float  #: Root mean square of the relative error of the radiance, weighted by light.
    peak: float  #: Largest radiance over the brightest one measured, both more than 10 degrees from the sun.
    warned: bool


def outcome(model: Any, directions: Directions, sun_deg: float, values: np.ndarray, *, with_sun: bool) -> Outcome:
    """Measure a sky with these radiances."""
    zenith, azimuth = directions
    sun = {"sun_zenith_deg": sun_deg, "sun_azimuth_deg": 0.0} if with_sun else {}
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        measured = sky.RadianceField.from_points(zenith, azimuth, values, **sun)
        measured.lower(NM)
    light = measured.radiance(ZENITH, AZIMUTH, NM)
    true = model.radiance(ZENITH, AZIMUTH, NM) * np.ones(WEIGHT.shape)
    total = float((true * WEIGHT).sum())
    far, seen = _is_far(ZENITH, AZIMUTH, sun_deg), _is_far(*_above(directions), sun_deg)
    return Outcome(
        irradiance=float((light * WEIGHT).sum()) / total,
        note=measured.interpolant(0).error,
        map=float(np.sqrt(((light / true - 1) ** 2 * true * WEIGHT).sum() / total)),
        peak=float(light[far].max() / values[seen].max()),
        warned=any(issubclass(one.category, sky.InputWarning) for one in warned),
    )


def _above(directions: Directions) -> Directions:
    zenith, azimuth = directions
    return np.abs(np.deg2rad(zenith)), np.deg2rad(azimuth + 180.0 * (zenith < 0))


def _is_far(zenith: np.ndarray, azimuth: np.ndarray, sun_deg: float) -> np.ndarray:
    sun = np.deg2rad(sun_deg)
    cosine = np.cos(zenith) * np.cos(sun) + np.sin(zenith) * np.sin(sun) * np.cos(azimuth)
    return np.asarray(cosine < np.cos(np.deg2rad(NEAR_SUN_DEG)))


def outcomes(layout: str, noise: float, n_seeds: int, *, with_sun: bool = True) -> Iterator[Outcome]:
    """Those of all skies and suns."""
    for sun_deg in SUNS_DEG:
        directions = LAYOUTS[layout](sun_deg)
        for model in skies(sun_deg).values():
            true = model.radiance(*_above(directions), NM) * np.ones(directions[0].size)
            for seed in range(n_seeds if noise else 1):
                values = true * (1 + noise * np.random.default_rng(seed).normal(size=true.size))
                yield outcome(model, directions, sun_deg, values, with_sun=with_sun)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--without-sun", action="store_true")
    options = parser.parse_args()
    print("| layout | noise | irradiance over the true one | error of the note over that of the map | warned | peak |")
    print("| --- | --- | --- | --- | --- | --- |")
    for layout in LAYOUTS:
        for noise in NOISES:
            found = list(outcomes(layout, noise, options.seeds, with_sun=not options.without_sun))
            ratio = [one.note / one.map for one in found]
            light = [one.irradiance for one in found]
            print(
                f"| {layout} | {100 * noise:g} % | {min(light):.3g} to {max(light):.3g} | "
                f"{min(ratio):.2g} to {max(ratio):.2g} | {sum(one.warned for one in found)} of {len(found)} | "
                f"{max(one.peak for one in found):.2g} |"
            )


if __name__ == "__main__":
    main()
