"""Do the numbers that go with the photons beat with their directions? The worst mode of both, on many grids.

    python bench/number_modes.py [--grids perez disc] [--photons 300 1000] [--work 1e6]

A mode is exp(2 pi i (a u + b v + c azimuth + d n1 + e n2 + f n3)), with whole numbers whose sizes add up to 5 or less,
and a number in it: 1711 of them. The place in the cell is (u, v), before a rejection. Printed is the variance of a
mode's mean over seeds, of N photons, relative to independent numbers, for the worst mode. A mean over few seeds
scatters: the worst of 1711 modes of independent numbers, measured alike, stands beside it. A grid of N photons gets
`work` / N seeds, 4 to 400. The bound is `BOUND` times the latter.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import product

import numpy as np

import aomc_sky as sky

LARGEST = 5
PHOTONS, WORK = (300, 1000, 10_000, 100_000, 1_000_000), 1e6
BOUND = 2.0
_PART = 20_000


def _in_three(largest: int) -> np.ndarray:
    several = product(range(-largest, largest + 1), repeat=3)
    return np.array([h for h in several if sum(map(abs, h)) <= largest])


DIRECTIONS = _in_three(LARGEST)
NUMBERS = np.array([h for h in DIRECTIONS.tolist() if h > [0, 0, 0]])
"""Coefficients of the direction and of the numbers; of h and -h one."""
COUNTED = np.abs(DIRECTIONS).sum(axis=1)[:, None] + np.abs(NUMBERS).sum(axis=1) <= LARGEST


def _waves(points: np.ndarray, modes: np.ndarray) -> np.ndarray:
    """The modes (m, 3) of points (n, 3), complex (m, n)."""
    wave = np.ones((len(modes), len(points)), complex)
    for column, coefficients in zip(points.T, modes.T, strict=True):
        powers = np.exp(2j * np.pi * column) ** np.arange(-LARGEST, LARGEST + 1)[:, None]
        wave *= powers[coefficients + LARGEST]
    return wave


def powers(direction: np.ndarray, numbers: np.ndarray) -> np.ndarray:
    """|sum|^2 / n of all modes of points (n, 3) and (n, 3): 1 on average if the numbers are independent."""
    total = np.zeros(COUNTED.shape, complex)
    for lo in range(0, len(direction), _PART):
        part = slice(lo, lo + _PART)
        total += _waves(direction[part], DIRECTIONS) @ _waves(numbers[part], NUMBERS).T
    return np.where(COUNTED, np.abs(total) ** 2 / len(direction), 0.0)


def photons(components: object, n: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """The coordinates u, v and azimuth [turns] of all photons of a seed, and their numbers; (n, 3) each."""
    scene = sky.Scene(wavebands=[550.0], n_photons=n, components=components)
    source = scene.source(seed=seed, precision="float64", order="patch")
    batch, emitter = source.photons(numbers=3), source._emitter
    words, ring = emitter._stream(0), emitter._rings.ring_of_cell[batch.patch]
    u, v = words.shifts[:, None] + np.arange(n, dtype=np.uint64) * words.steps[:, None]
    turns = np.arctan2(batch.uy, batch.ux) / (2.0 * np.pi)
    place = np.column_stack([u, v + words.ring_offsets[ring]]) * 2.0**-64
    return np.column_stack([place, turns]), batch.numbers


def worst_mode(make: Callable[[], object], n: int, seeds: int) -> tuple[float, list[int], float]:
    """The largest variance of a mode relative to independent numbers, the mode, and the same of independent numbers."""
    ours, theirs = np.zeros(COUNTED.shape), np.zeros(COUNTED.shape)
    components = make()
    for seed in range(1, seeds + 1):
        direction, numbers = photons(components, n, seed)
        ours += powers(direction, numbers) / seeds
        theirs += powers(direction, np.random.default_rng(seed).random(numbers.shape)) / seeds
    at = np.unravel_index(ours.argmax(), ours.shape)
    return float(ours.max()), [*DIRECTIONS[at[0]].tolist(), *NUMBERS[at[1]].tolist()], float(theirs.max())


def table(values: np.ndarray, zenith_edges_deg: np.ndarray | None = None) -> sky.TabulatedSky:
    """A sky of radiances (n_zenith, n_azimuth)."""
    grid = sky.PatchGrid.regular(*values.shape)
    if zenith_edges_deg is not None:
        rings = np.column_stack([zenith_edges_deg[:-1], zenith_edges_deg[1:]])
        grid = sky.PatchGrid(zenith_bounds_deg=rings, azimuth_bounds_deg=grid.azimuth_bounds_deg)
    return sky.TabulatedSky(wavelength_nm=[550.0], values=values[None], grid=grid, has_wavelength=False)


def equal_patches(n_zenith: int, n_azimuth: int) -> sky.TabulatedSky:
    """A table whose patches all have the same light, so that rings have equal numbers of photons."""
    edges = np.rad2deg(np.arcsin(np.sqrt(np.linspace(0.0, 1.0, n_zenith + 1))))
    return table(np.ones((n_zenith, n_azimuth)), edges)


def _lobes() -> sky.LobeSky:
    half = np.sqrt(0.5)
    tilts = [1.0, 0.0, 0.0, 0.0], [half, half, 0.0, 0.0], [0.5, 0.5, 0.5, 0.5]
    return sky.LobeSky(
        lobes=tuple(
            sky.lobes.WeightedLobe(
                name=f"lobe {k}",
                kind="hg",
                param0=g,
                param1=0.0,
                quaternion=np.array(tilt),
                wavelength_nm=np.array([550.0]),
                spectrum=np.array([1e-8]),
            )
            for k, (g, tilt) in enumerate(zip((0.8, 0.3, 0.0), tilts, strict=True))
        )
    )


GRIDS: dict[str, Callable[[], object]] = {
    "perez": lambda: sky.PerezSky(sun_zenith_deg=47, sun_azimuth_deg=20, epsilon=3, delta=0.2),
    "table": lambda: table(np.random.default_rng(11).lognormal(0, 1, (18, 24))),
    "equal patches": lambda: equal_patches(90, 64),
    "lobes": _lobes,
    "disc": lambda: [sky.DirectBeam(sun_zenith_deg=40, sun_azimuth_deg=10, radius_deg=0.27)],
    "uniform": sky.UniformSky,
}


def rows(grids: Iterable[str], several: Sequence[int], work: float) -> Iterator[str]:
    """The table as lines of Markdown."""
    yield "| grid | photons | seeds | worst mode: u, v, azimuth, n1, n2, n3 | its variance | of independent | bound |"
    yield "| --- | ---: | ---: | --- | ---: | ---: | ---: |"
    for name in grids:
        for n in several:
            seeds = int(np.clip(work / n, 4, 400))
            value, mode, chance = worst_mode(GRIDS[name], n, seeds)
            yield f"| {name} | {n} | {seeds} | {mode} | {value:.2f} | {chance:.2f} | {BOUND * chance:.2f} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--grids", nargs="+", choices=GRIDS, default=list(GRIDS))
    parser.add_argument("--photons", type=int, nargs="+", default=PHOTONS)
    parser.add_argument("--work", type=float, default=WORK)
    options = parser.parse_args()
    for line in rows(options.grids, options.photons, options.work):
        print(line, flush=True)


if __name__ == "__main__":
    main()
