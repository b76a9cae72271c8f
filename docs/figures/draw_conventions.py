"""Draw the figures of conventions.md: a sky direction and its travel, the azimuths, the patches of a grid.

Run from anywhere: python docs/figures/draw_conventions.py [FOLDER]; the SVG files go to FOLDER, by default beside this
file, the same bytes every time, and with each its twin for dark mode. Needs matplotlib. The numbers come from
`aomc_sky.directions` and `PatchGrid`.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Arc

import aomc_sky as sky

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "extensions"))

from dark_pictures import dark_path, darkened  # noqa: E402 - a folder of the site

BLUE, ORANGE, GREEN, GREY = "#0072b2", "#d55e00", "#009e73", "#555555"


def arrow(axes: Axes, start: tuple[float, float], end: tuple[float, float], colour: str) -> None:
    """Draw a straight arrow in data coordinates."""
    axes.annotate(
        "", end, start, arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 2, "shrinkA": 0, "shrinkB": 0}
    )


def bare(axes: Axes, x: tuple[float, float], y: tuple[float, float]) -> None:
    """Take the frame away and keep circles round."""
    axes.set(xlim=x, ylim=y, aspect="equal")
    axes.axis("off")


def draw_travel(axes: Axes) -> None:
    """Light from zenith angle 40 degrees and azimuth 0, in the vertical plane through x and z."""
    zenith = np.deg2rad(40.0)
    ux, uy, uz = -np.sin(zenith), 0.0, -np.cos(zenith)
    bare(axes, (-1.25, 1.75), (-1.25, 1.35))
    axes.fill_between([-1.2, 1.6], 0, -1.2, color=BLUE, alpha=0.12, lw=0)
    axes.plot([-1.2, 1.6], [0, 0], color=BLUE, lw=1)
    arrow(axes, (0, 0), (0, 1.2), GREY)
    arrow(axes, (0, 0), (1.45, 0), GREY)
    axes.text(0.04, 1.22, "z, up", color=GREY)
    axes.text(1.3, -0.16, "x, east", color=GREY)
    axes.plot([0, -1.05 * ux], [0, -1.05 * uz], color=ORANGE, lw=2, ls="--")
    axes.text(-1.08 * ux, -1.08 * uz, "sky direction: where the light comes from\nθ = 40°, φ = 0°", color=ORANGE)
    arrow(axes, (0, 0), (ux, uz), GREEN)
    axes.text(ux - 0.5, uz - 0.4, f"travel of the photon\n({ux:.3f}, {uy:.0f}, {uz:.3f})", color=GREEN)
    axes.add_patch(Arc((0, 0), 0.9, 0.9, theta1=50, theta2=90, color=ORANGE))
    axes.text(0.12, 0.48, "θ", color=ORANGE)
    axes.text(-1.18, -0.12, "sea", color=BLUE)


def draw_azimuth(axes: Axes) -> None:
    """Azimuths of this package seen from above, and the two others that are met, on the rim outside."""
    bare(axes, (-1.75, 1.75), (-1.6, 1.6))
    turn = np.linspace(0, 2 * np.pi, 361)
    axes.plot(np.cos(turn), np.sin(turn), color=GREY, lw=1)
    conventions = (
        (sky.directions.AzimuthConvention.ENU_FROM_EAST, 0.8, GREEN),
        (sky.directions.AzimuthConvention.NORTH_CLOCKWISE, 1.16, BLUE),
        (sky.directions.AzimuthConvention.WEST_OF_SOUTH, 1.42, ORANGE),
    )
    for convention, radius, colour in conventions:
        for azimuth in (0, 90, 180, 270):
            enu = np.deg2rad(sky.directions.to_enu_azimuth_deg(float(azimuth), convention))
            x, y = radius * np.cos(enu), radius * np.sin(enu)
            axes.text(x, y, f"{azimuth}°", color=colour, ha="center", va="center")
    for x, y in ((0.42, 0), (0, 0.42)):
        arrow(axes, (0, 0), (x, y), GREY)
    axes.text(0.3, -0.14, "+x, east", color=GREY)
    axes.text(-0.04, 0.36, "+y, north", color=GREY, ha="right")
    axes.add_patch(Arc((0, 0), 1.2, 1.2, theta1=8, theta2=60, color=GREEN))
    arrow(axes, (0.33, 0.50), (0.27, 0.536), GREEN)
    axes.text(0, -0.48, "seen from above:\ngreen, this package", color=GREEN, ha="center")
    axes.text(-1.7, 1.5, "NORTH_CLOCKWISE", color=BLUE)
    axes.text(-1.7, -1.58, "WEST_OF_SOUTH", color=ORANGE)


def draw_patches(axes: Axes) -> None:
    """A grid of 3 rings and 8 columns, seen from above, with the index pairs of skydist.inp in its patches."""
    n_zenith, n_azimuth = 3, 8
    grid = sky.PatchGrid.regular(n_zenith, n_azimuth)
    bare(axes, (-1.35, 1.35), (-1.25, 1.3))
    turn = np.linspace(0, 2 * np.pi, 361)
    for k in range(1, n_zenith + 1):
        axes.plot(k / n_zenith * np.cos(turn), k / n_zenith * np.sin(turn), color=GREY, lw=1)
    for k in range(n_azimuth):
        azimuth = 2 * np.pi * k / n_azimuth
        axes.plot([0, np.cos(azimuth)], [0, np.sin(azimuth)], color=GREY, lw=0.8)
        middle = azimuth + np.pi / n_azimuth
        for ring in range(n_zenith):
            radius = (ring + 0.55) / n_zenith
            patch = ring * n_azimuth + k
            label = f"{ring + 1},{k}\n" + (f"({patch})" if ring else "")
            x, y = radius * np.cos(middle), radius * np.sin(middle)
            axes.text(x, y, label.strip(), ha="center", va="center", fontsize=8 if ring else 6)
    axes.text(1.03, 0, "φ = 0, east", color=GREEN, va="center", rotation=90)
    axes.text(0, 1.06, "north", color=GREEN, ha="center")
    axes.text(0, -1.2, f"zenith,azimuth index as in skydist.inp; (patch) of {grid.n_patches}", ha="center", color=GREY)


def draw_polarisation(axes: Axes) -> None:
    """The axes of the Stokes vector in the meridian plane, and the electric vectors of four lights as one sees them."""
    zenith = np.deg2rad(40.0)
    sky_x, sky_z = np.sin(zenith), np.cos(zenith)
    bare(axes, (-1.3, 4.6), (-1.0, 2.3))
    axes.fill_between([-1.2, 1.9], 0, -0.9, color=BLUE, alpha=0.12, lw=0)
    axes.plot([-1.2, 1.9], [0, 0], color=BLUE, lw=1)
    arrow(axes, (0, 0), (0, 1.7), GREY)
    axes.text(0.04, 1.75, "z, up", color=GREY)
    arrow(axes, (2.1 * sky_x, 2.1 * sky_z), (0.2 * sky_x, 0.2 * sky_z), GREEN)
    axes.text(0.62, 1.75, "light from the sky, k", color=GREEN)
    middle = (1.2 * sky_x, 1.2 * sky_z)
    arrow(axes, middle, (middle[0] + 0.75 * sky_z, middle[1] - 0.75 * sky_x), ORANGE)
    axes.text(middle[0] + 0.5, middle[1] - 0.72, "l", color=ORANGE, fontsize=12)
    axes.plot(*middle, "o", ms=11, mfc="white", mec=ORANGE, mew=1.6)
    axes.plot(*middle, "o", ms=4, color=ORANGE)
    axes.text(middle[0] + 0.14, middle[1] + 0.02, "r, out of the page", color=ORANGE)
    axes.text(-1.2, -0.6, "meridian plane: that of the\nvertical and the ray; l x r = k", color=GREY)
    lights = (("Q/I = 1", 90.0), ("Q/I = -1", 0.0), ("U/I = 1", 135.0), ("U/I = -1", 45.0))
    for k, (name, angle) in enumerate(lights):
        x, y = 2.75 + 1.25 * (k % 2), 1.25 - 1.35 * (k // 2)
        turn = np.linspace(0, 2 * np.pi, 181)
        axes.plot(x + 0.45 * np.cos(turn), y + 0.45 * np.sin(turn), color=GREY, lw=0.8)
        axes.plot([x, x], [y - 0.45, y + 0.45], color=GREY, lw=0.6, ls=":")
        across, up = 0.4 * np.cos(np.deg2rad(angle)), 0.4 * np.sin(np.deg2rad(angle))
        axes.annotate(
            "", (x + across, y + up), (x - across, y - up), arrowprops={"arrowstyle": "<|-|>", "color": ORANGE, "lw": 2}
        )
        axes.text(x, y - 0.66, name, ha="center")
    axes.text(3.37, 1.95, "electric vector, as one looks up at the light", color=GREY, ha="center")


FIGURES = {
    "directions": draw_travel,
    "azimuths": draw_azimuth,
    "patches": draw_patches,
    "polarisation": draw_polarisation,
}


def main(folder: Path) -> None:
    """Write every figure."""
    plt.rcParams.update({"svg.hashsalt": "aomc-sky", "svg.fonttype": "path", "font.size": 9})
    for name, draw in FIGURES.items():
        size = (7.0, 4.0) if name == "polarisation" else (5.2, 4.2)
        figure, axes = plt.subplots(figsize=size, layout="constrained")
        draw(axes)
        path = folder / f"convention_{name}.svg"
        figure.savefig(path, metadata={"Date": None})
        figure.savefig(path.with_suffix(".png")) if "--png" in sys.argv else None
        with darkened(figure):
            figure.savefig(dark_path(path), metadata={"Date": None})
        plt.close(figure)


if __name__ == "__main__":
    folders = [name for name in sys.argv[1:] if not name.startswith("--")]
    main(Path(folders[0]) if folders else HERE)
