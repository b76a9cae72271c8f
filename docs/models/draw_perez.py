"""Draw the figures of perez.md: Figs. 1 to 5, 12 and 13 of Perez, Seals and Michalsky (1993) from our functions.

Run from anywhere: python docs/models/draw_perez.py [FOLDER]; the PNG files go to FOLDER, by default to figures/ beside
this file. Needs matplotlib.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from aomc_sky.skies.perez import functions as perez

HERE = Path(__file__).resolve().parent
SUN_ZENITH = np.deg2rad(45.0)
LINES = (("#0072b2", "-"), ("#d55e00", "--"), ("#009e73", "-."), ("#555555", ":"))
CIE_CLEAR = {"a": -1.0, "b": -0.32, "c": 10.0, "d": -3.0, "e": 0.45}


def across_sky() -> np.ndarray:
    """Zenith angles along the sun's vertical circle, negative away from the sun, which is one of them. [deg]"""
    return np.linspace(-90.0, 90.0, 721)


def profile(coefficients: np.ndarray) -> np.ndarray:
    """Eq. (1) along the sun's vertical circle."""
    angle = across_sky()
    azimuth = np.where(angle < 0, np.pi, 0.0)
    return perez.relative_radiance(np.deg2rad(np.abs(angle)), azimuth, SUN_ZENITH, coefficients)


def over_zenith(coefficients: np.ndarray) -> np.ndarray:
    """The profile over the luminance overhead."""
    return profile(coefficients) / perez.relative_radiance(0.0, 0.0, SUN_ZENITH, coefficients)


def over_mean(coefficients: np.ndarray) -> np.ndarray:
    """The profile over that of an even sky of equal diffuse illuminance, pi L / Evd of eq. (3)."""
    return np.pi * profile(coefficients) / perez.horizontal_integral(coefficients, SUN_ZENITH)


def five(**values: float) -> np.ndarray:
    """Coefficients by name, 0 where not given."""
    return np.array([values.get(name, 0.0) for name in "abcde"])


def luminance_of_sky(epsilon: float, delta: float) -> np.ndarray:
    """Coefficients of eqs. (6) to (8) at the sun of the figures."""
    return perez.coefficients(epsilon, delta, SUN_ZENITH, limits="paper")


def dress(axes: Axes, y_label: str, *, sun: bool) -> None:
    """Labels, limits, and the sun's place."""
    axes.set_xlim(-90, 90)
    axes.set_xticks(range(-90, 91, 30))
    axes.set_ylabel(y_label)
    axes.grid(color="0.9", linewidth=0.6)
    if sun:
        axes.set_xlabel("zenith angle in the plane of the sun, positive towards the sun [°]")
        axes.axvline(np.rad2deg(SUN_ZENITH), color="0.6", linewidth=0.8)
        axes.annotate(" sun", (np.rad2deg(SUN_ZENITH), 0.02), xycoords=("data", "axes fraction"), color="0.4")
    else:
        axes.set_xlabel("zenith angle of the sky element [°]")
    axes.legend(frameon=False)


def draw(folder: Path, name: str, curves: dict[str, np.ndarray], y_label: str, *, sun: bool, log: bool = False) -> None:
    """One figure: curves over the zenith angle."""
    figure, axes = plt.subplots(figsize=(5.6, 3.4), layout="constrained")
    for (label, values), (colour, style) in zip(curves.items(), LINES, strict=False):
        label = label.replace("-", "\N{MINUS SIGN}")
        axes.plot(across_sky(), values, color=colour, linestyle=style, linewidth=1.4, label=label)
    if log:
        axes.set_yscale("log")
        axes.set_yticks([0.5, 1, 2, 5, 10], labels=["0.5", "1", "2", "5", "10"])
        axes.minorticks_off()
    else:
        axes.set_ylim(bottom=0)
    dress(axes, y_label, sun=sun)
    figure.savefig(folder / name, dpi=150, metadata={"Software": None})
    plt.close(figure)


def draw_coefficients(folder: Path) -> None:
    """Figs. 1 to 5: one coefficient at a time."""
    zenith = "luminance / luminance overhead"
    relative = "relative luminance, eq. (1)"
    a_curves = {f"a = {a:g}": over_zenith(five(a=a, b=-0.7)) for a in (0.75, -0.75, -1.5)}
    draw(folder, "perez_figure_01.png", a_curves, zenith, sun=False)
    b_curves = {f"b = {b:g}": over_zenith(five(a=-1.0, b=b)) for b in (-0.2, -0.7)}
    draw(folder, "perez_figure_02.png", b_curves, zenith, sun=False)
    c_curves = {f"c = {c:g}": profile(five(b=-1.0, c=c, d=-3.0)) for c in (4.0, 10.0)}
    draw(folder, "perez_figure_03.png", c_curves, relative, sun=True)
    d_curves = {f"d = {d:g}": profile(five(b=-1.0, c=4.0, d=d)) for d in (-2.0, -6.0)}
    draw(folder, "perez_figure_04.png", d_curves, relative, sun=True)
    e_curves = {f"e = {e:g}": profile(five(**{**CIE_CLEAR, "e": e})) for e in (0.0, 1.0)}
    draw(folder, "perez_figure_05.png", e_curves, relative, sun=True)


def draw_skies(folder: Path) -> None:
    """Figs. 12 and 13: whole skies, normalised by eq. (3)."""
    mean = "luminance / that of an even sky"
    overcast = {
        "bright overcast, Δ = 0.5": over_mean(luminance_of_sky(1.0, 0.5)),
        "dark overcast, Δ = 0.05": over_mean(luminance_of_sky(1.0, 0.05)),
        "CIE overcast (1 + 2 cos ξ)/3": (1 + 2 * np.cos(np.deg2rad(across_sky()))) * 3 / 7,
    }
    draw(folder, "perez_figure_12.png", overcast, mean, sun=True)
    skies = {
        "bright overcast, bin 1, Δ = 0.5": luminance_of_sky(1.0, 0.5),
        "intermediate, bin 3, Δ = 0.31": luminance_of_sky(1.35, 0.31),
        "turbid, bin 6, Δ = 0.18": luminance_of_sky(3.5, 0.18),
        "very clear, bin 8, Δ = 0.09": luminance_of_sky(8.0, 0.09),
    }
    draw(folder, "perez_figure_13.png", {k: over_mean(v) for k, v in skies.items()}, mean, sun=True, log=True)


def main() -> None:
    """Draw all figures into the folder given, or into figures/."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else HERE / "figures"
    folder.mkdir(parents=True, exist_ok=True)
    draw_coefficients(folder)
    draw_skies(folder)


if __name__ == "__main__":
    main()
