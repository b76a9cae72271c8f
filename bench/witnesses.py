"""Skies whose sun is known, read as they are and wrongly: which warnings of `aomc_sky.skies.witnesses` come.

    python bench/witnesses.py [--skies 245] [--seed 1]

Skies: Perez of clearness 1 to 8, the fifteen of the CIE, overcast, Harrison-Coombes, molecules alone, and broken cloud:
3 to 20 smooth clouds that make a Perez sky 0.3 to 2.5 times as bright. Suns have zenith angles of 20 to 80 degrees and
any azimuth. Radiances have 5 % of noise, and a tenth is missing. A sky is even where its brightest 2 % are below 1.5
times its median. Wrong are: azimuth conventions that move the sun by more than 40 degrees, times the sine of its zenith
angle; elevations as zenith angles; the signs of Q and U. These are Rayleigh's pattern of a degree of 0.2 to 0.8, plus
2 to 8 % of light along the meridian plane, which makes neutral points, and 2 % of noise, on the two grids alone.
"""

from __future__ import annotations

import argparse
import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from typing import Any

import numpy as np
from measured_skies import MOLECULES, almucantar, both, irregular, tregenza

import aomc_sky as sky
from aomc_sky.directions import AzimuthConvention, to_enu_azimuth_deg, travel_from_sky
from aomc_sky.skies.witnesses import warn_of_light

MOVED_DEG, CONTRAST, NEAR_45_DEG = 40.0, 1.5, 8.0
CONVENTIONS = tuple(AzimuthConvention)


def grid(n: int, _: float, __: int) -> tuple[np.ndarray, np.ndarray]:
    zenith, azimuth = np.meshgrid((np.arange(n) + 0.5) * 90 / n, (np.arange(2 * n) + 0.5) * 180 / n, indexing="ij")
    return zenith.ravel(), azimuth.ravel()


GRIDS: dict[str, Callable[[float, int], Any]] = {"grid 18 x 36": partial(grid, 18), "grid 45 x 90": partial(grid, 45)}
LAYOUTS: dict[str, Callable[[float, int], Any]] = GRIDS | {
    "Tregenza, 145": lambda _, __: tregenza(),
    "150 random": lambda _, seed: irregular(150, seed),
    "60 random": lambda _, seed: irregular(60, seed, 80.0),
    "almucantar": lambda sun, _: almucantar(sun),
    "almucantar and principal plane": lambda sun, _: both(sun),
}


def perez(low: float, high: float, sun: dict[str, float], rng: np.random.Generator) -> Any:
    return sky.PerezSky(**sun, epsilon=rng.uniform(low, high), delta=rng.uniform(0.05, 0.35)).radiance


def molecules(sun: dict[str, float], rng: np.random.Generator) -> Any:
    nm = float(rng.uniform(400, 800))
    air = sky.AtmosphereSky.from_file(MOLECULES, wavelength_nm=nm, **sun)
    return lambda zenith, azimuth, _: air.radiance(zenith, azimuth, nm)


def broken(sun: dict[str, float], rng: np.random.Generator) -> Any:
    n, clear = int(rng.integers(3, 21)), perez(1.5, 6, sun, rng)
    clouds = travel_from_sky(np.rad2deg(np.arccos(rng.uniform(0, 1, n))), rng.uniform(0, 360, n))
    width, height = np.deg2rad(rng.uniform(5, 20, n)), rng.uniform(-0.7, 1.5, n)

    def light(zenith: np.ndarray, azimuth: np.ndarray, nm: float) -> np.ndarray:
        apart = np.arccos(np.clip(travel_from_sky(*np.rad2deg([zenith, azimuth])) @ clouds.T, -1, 1))
        factor = np.prod(1 + height * np.exp(-((apart / width) ** 2)), axis=-1)
        return np.asarray(clear(zenith, azimuth, nm) * np.clip(factor, 0.3, 2.5))

    return light


KINDS: dict[str, Callable[[dict[str, float], np.random.Generator], Any]] = {
    "clear (Perez)": partial(perez, 4, 8),
    "hazy (Perez)": partial(perez, 1.5, 4),
    "overcast": lambda sun, rng: sky.OvercastSky().radiance if rng.random() < 0.5 else perez(1, 1.06, sun, rng),
    "CIE 1 to 15": lambda sun, rng: sky.CIESky(type=int(rng.integers(1, 16)), **sun).radiance,
    "Harrison-Coombes": lambda sun, rng: sky.HarrisonCoombesSky(**sun, cloud_cover=rng.uniform(0, 0.8)).radiance,
    "molecules": molecules,
    "broken cloud": broken,
}
Sky = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Radiances, zenith angles and azimuths. [deg]"""


def warned(light: Sky, sun: tuple[float, float], stated: AzimuthConvention, **stokes: np.ndarray) -> str:
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        warn_of_light(*light, sun_deg=sun, convention=stated, **stokes)
    return " ".join(str(one.message) for one in found)


def of_angles(
    light: Sky, sun: tuple[float, float], rng: np.random.Generator, layout: str
) -> Iterator[tuple[str, bool]]:
    """What a sky adds to the columns of the first table: whether a warning came."""
    radiance, zenith, azimuth = light
    true = CONVENTIONS[rng.integers(12)]
    offset, turn = true.value[:2]
    at_0 = offset + sun[1] * true.is_from_sun
    brightest = np.sort(radiance)[-max(3, int(np.ceil(0.02 * radiance.size)))]
    even = " (even sky)" if brightest < CONTRAST * np.median(radiance) else ""
    yield f"false alarms{even}", bool(warned(light, sun, true))
    for one in CONVENTIONS:
        wrong, moved = (to_enu_azimuth_deg(turn * (angle - at_0), one, sun[1]) for angle in (azimuth, sun[1]))
        if abs((moved - sun[1] + 180) % 360 - 180) * np.sin(np.deg2rad(sun[0])) > MOVED_DEG:
            yield f"wrong azimuths{even}", "--azimuth-conv" in warned((radiance, zenith, wrong), sun, one)
    if layout != "almucantar" and not even:
        place = "near 45" if abs(sun[0] - 45) < NEAR_45_DEG else "above" if sun[0] > 45 else "below"
        yield f"elevations, sun {place}", "elevation=" in warned((radiance, 90 - zenith, azimuth), sun, true)


def of_signs(light: Sky, sun: tuple[float, float], rng: np.random.Generator, _: str) -> Iterator[tuple[str, bool]]:
    """What a sky adds to the columns of the second table: whether these signs, and no others, are warned of."""
    sun_rad = dict(zip(("sun_zenith_rad", "sun_azimuth_rad"), np.deg2rad(sun), strict=True))
    pattern = sky.RayleighPattern(max_degree=rng.uniform(0.2, 0.8)).stokes(*np.deg2rad(light[1:]), **sun_rad)
    noise = 0.02 * rng.normal(size=(2, light[0].size))
    q, u = (pattern[0] + rng.uniform(0.02, 0.08) + noise[0]) * light[0], (pattern[1] + noise[1]) * light[0]
    for name, signs in {"": (1, 1), "Q": (-1, 1), "U": (1, -1), "Q and U": (-1, -1)}.items():
        found = warned(light, sun, CONVENTIONS[0], values_q=signs[0] * q, values_u=signs[1] * u)
        yield name or "false alarms", found.startswith(f"{name}: ") if name else "--stokes-signs" in found


def table(of: Callable[..., Iterable[tuple[str, bool]]], n: int, seed: int, layouts: Iterable[str]) -> None:
    """Print how often each of the columns came true, of how many, by kind of sky and by layout, which take turns."""
    true, all_of, columns = Counter[tuple[str, str]](), Counter[tuple[str, str]](), dict[str, None]()
    for k in range(n):
        rng, kind = np.random.default_rng([seed, k]), list(KINDS)[k % len(KINDS)]
        layout = list(layouts)[k // len(KINDS) % len(list(layouts))]
        sun = float(rng.uniform(20, 80)), float(rng.uniform(0, 360))
        angles = np.stack(LAYOUTS[layout](sun[0], int(rng.integers(1 << 30))))
        angles = angles[:, rng.random(angles.shape[1]) > 0.1]
        zenith, azimuth = np.abs(angles[0]), angles[1] + 180.0 * (angles[0] < 0) + sun[1] * ("almucantar" in layout)
        with warnings.catch_warnings(action="ignore"):  # of the limits of models
            radiance = KINDS[kind]({"sun_zenith_deg": sun[0], "sun_azimuth_deg": sun[1]}, rng)
        noisy = radiance(*np.deg2rad([zenith, azimuth]), 550.0) * np.clip(
            1 + 0.05 * rng.normal(size=zenith.size), 0.5, 2
        )
        for name, is_true in of((noisy, zenith, azimuth), sun, rng, layout):
            columns[name] = None
            all_of.update((part, name) for part in (kind, layout, "all"))
            true.update((part, name) for part in (kind, layout, "all") if is_true)
    print(f"\n| skies | {' | '.join(sorted(columns))} |\n|{' --- |' * (len(columns) + 1)}")
    for part in (*KINDS, *layouts, "all"):
        print(f"| {part} | {' | '.join(f'{true[part, one]} of {all_of[part, one]}' for one in sorted(columns))} |")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--skies", type=int, default=245)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    table(of_angles, options.skies, options.seed, LAYOUTS)
    table(of_signs, options.skies, options.seed, GRIDS)


if __name__ == "__main__":
    main()
