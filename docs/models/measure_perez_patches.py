"""Print what the size of the patches costs a Perez sky, the table of patches in perez.md.

python docs/models/measure_perez_patches.py. Trials per photon are the mean of the patches' upper bounds of f over
their means, weighted with their masses; the total variation is that of patches with constant radiance from f, by
8 x 8 points in each patch.
"""

from __future__ import annotations

import numpy as np

from aomc_sky.grid import PatchGrid
from aomc_sky.skies.perez.sky import PerezSky

SKIES = {
    "dark overcast": (1.0, 0.05, 45.0),
    "bright overcast": (1.03, 0.5, 30.0),
    "intermediate": (1.35, 0.31, 45.0),
    "turbid, low sun": (5.5, 0.14, 64.0),
    "narrow aureole": (6.8, 0.02, 40.0),
    "clear, low sun": (6.8, 0.05, 80.0),
}
GRIDS = ((45, 180), (18, 72), (9, 36))
POINTS = (np.arange(8) + 0.5) / 8


def sky_of(epsilon: float, delta: float, sun_deg: float, grid: PatchGrid) -> PerezSky:
    """A sky with the sun inside a patch in azimuth."""
    return PerezSky(
        sun_zenith_rad=float(np.deg2rad(sun_deg)),
        sun_azimuth_rad=float(np.deg2rad(25.0)),
        epsilon=epsilon,
        delta=delta,
        grid=grid,
    )


def trials(model: PerezSky, grid: PatchGrid) -> float:
    """Trials per photon of the rejection."""
    bounds = model.lower(np.array([500.0]))[0].bounds
    if bounds is None:
        raise SystemExit("the component of the sky has no bounds: it is not sampled by rejection")
    return float(np.sum(bounds[:, 0] * grid.projected_solid_angle_sr) / model.relative_integral)


def total_variation(model: PerezSky, grid: PatchGrid) -> float:
    """Distance of constant radiance inside the patches from the model."""
    near, growth, _ = grid.ring_sin2()
    zenith = np.arcsin(np.sqrt(near[:, None] + growth[:, None] * POINTS))[:, None, :, None]
    start, end = np.deg2rad(grid.azimuth_bounds_deg).T[:, :, None]
    azimuth = (start + (end - start) * POINTS)[None, :, None, :]
    value = model.radiance(zenith, azimuth, 500.0)
    mean = value.mean(axis=(2, 3))
    off = np.abs(value - mean[:, :, None, None]).mean(axis=(2, 3)).ravel()
    return float(np.sum(off * grid.projected_solid_angle_sr) / np.sum(mean.ravel() * grid.projected_solid_angle_sr) / 2)


def main() -> None:
    """Print the table."""
    names = [f"{90 / rings:g}°" for rings, _ in GRIDS]
    heads = [f"trials, {name}" for name in names] + [f"`uniform`, {name}" for name in names]
    print(f"| sky | ε, Δ, Z | {' | '.join(heads)} |")
    print(f"| {' | '.join(['---'] * (len(heads) + 2))} |")
    for label, inputs in SKIES.items():
        cells: list[list[str]] = [[], []]
        for n_zenith, n_azimuth in GRIDS:
            grid = PatchGrid.regular(n_zenith, n_azimuth)
            model = sky_of(*inputs, grid)
            cells[0].append(f"{trials(model, grid):.3f}")
            cells[1].append(f"{total_variation(model, grid):.3f}")
        given = f"{inputs[0]:g}, {inputs[1]:g}, {inputs[2]:g}°"
        print(f"| {label} | {given} | {' | '.join(cells[0] + cells[1])} |")


if __name__ == "__main__":
    main()
