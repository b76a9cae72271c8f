"""Draw the two pictures of the README: a sky with its photons, and error against time; on white and on dark paper.

Run from anywhere: python docs/figures/draw_readme.py [FOLDER]; the PNG files go to FOLDER, by default beside this
script. The sky and its photons come from `aomc_sky` itself, the errors and times from performance.csv beside
this script, which `bench/report.py` measures.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

import numpy as np
from matplotlib import rc_context, rcParams
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, LogLocator, NullLocator

import aomc_sky as sky

HERE = Path(__file__).resolve().parent
N_SHOWN, DPI = 4000, 200
PALE = "#8a8a8a"
INK = ("text.color", "axes.labelcolor", "axes.edgecolor", "xtick.color", "ytick.color")
WHITE = dict.fromkeys(INK, "#222222")
BLACK = dict.fromkeys(INK, "#d0d4da") | {"figure.facecolor": "#14181e", "axes.facecolor": "#14181e"}
"""Ink and paper of the pictures; the dark ones have the paper of the site's dark mode."""

LINES = {
    "default": ("default", "#0072B2", "o"),
    "iid": ("independent photons", "#777777", "s"),
    "aomc": ("AOMC's rounding", "#D55E00", "X"),
}
"""Method in the file to label, colour of Okabe and Ito, marker."""


def draw_sky(*, paper: str, points: str) -> Figure:
    """The radiance of the first command of the README, and the first photons of its sky as points on a disc."""
    scene = sky.weather_scene(
        time="2026-06-21T10:00Z",
        latitude_deg=54.18,
        longitude_deg=7.89,
        wavebands=[550.0],
        n_photons=20 * N_SHOWN,
        sky="harrison-coombes",
        spectrum="spectrl2",
        clear_sky={"aerosol": "maritime"},
    )
    figure = Figure(figsize=(7.2, 3.05))
    left, right = figure.add_axes((0.0, 0.0, 0.42, 0.91)), figure.add_axes((0.57, 0.0, 0.42, 0.91))
    sky.plot(scene, ax=left)
    bar = figure.colorbar(left.collections[-1], cax=figure.add_axes((0.435, 0.17, 0.014, 0.6)))
    bar.set_ticks(ticks := [0.03, 0.05, 0.1, 0.2, 0.5], labels=[f"{tick:g}" for tick in ticks])
    bar.ax.yaxis.set_minor_locator(NullLocator())
    bar.ax.tick_params(labelsize=8)
    bar.set_label("radiance [W m$^{-2}$ sr$^{-1}$ nm$^{-1}$]", fontsize=8)
    sky.plot(np.ones((9, 36)), ax=right, cmap=ListedColormap([paper]))
    photons = scene.source(seed=1).photons()
    ux, uy, uz = np.array([photons.ux, photons.uy, photons.uz])[:, photons.patch > 0][:, :N_SHOWN]  # patch 0: the beam
    zenith, azimuth = np.degrees(np.arccos(-uz)), np.arctan2(-uy, -ux)  # a photon travels away from where it comes from
    right.plot(zenith * np.cos(azimuth), zenith * np.sin(azimuth), ".", color=points, markersize=2.0, mew=0)
    for axes in (left, right):
        for drawn in (*axes.lines, *axes.texts):
            if drawn.get_color() in ("black", "#555555"):
                drawn.set_color(rcParams["text.color"])
    left.set_title("radiance at 550 nm, and the beam", fontsize=10)
    right.set_title(f"first {N_SHOWN:,} photons of this sky".replace(",", " "), fontsize=10)
    return figure


def draw_error(table: Path) -> Figure:
    """Error of the mean cosine against the time of a run, a line for each method, named where it ends."""
    with table.open() as file:
        rows = [row for row in csv.DictReader(file) if row["sky"] == "clear-uniform" and row["method"] in LINES]
    figure = Figure(figsize=(5.6, 3.2), layout="constrained")
    axes = figure.add_subplot()
    for method, (name, colour, marker) in LINES.items():
        own = sorted((row for row in rows if row["method"] == method), key=lambda row: int(row["n_photons"]))
        time_ms = [1e3 * (float(row["plan_s"]) + float(row["emit_s"])) for row in own]
        error = [float(row["error_planar"]) for row in own]
        axes.plot(time_ms, error, marker=marker, color=colour, markersize=5, linewidth=1.8)
        axes.annotate(name, (time_ms[-1], error[-1]), (8, 0), textcoords="offset points", va="center", color=colour)
        if method == "default":
            _name_points(axes, time_ms, error, [int(row["n_photons"]) for row in own])
    axes.set(xscale="log", yscale="log", xlabel="processor time of one run, plan and photons [ms]")
    axes.set_title("relative error of the mean cosine, a clear sky", fontsize=10, loc="left")
    axes.set(xlim=(1.0, 300.0), ylim=(8e-9, 2.0))
    axes.xaxis.set_major_locator(FixedLocator([1, 2, 5, 10, 20, 50, 100]))
    axes.xaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_major_locator(LogLocator(base=100.0))
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_minor_locator(NullLocator())
    axes.grid(axis="y", color=PALE, alpha=0.25, linewidth=0.7)
    axes.tick_params(labelsize=8, color=PALE)
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color(PALE)
    return figure


def _name_points(axes: Axes, time_ms: list[float], error: list[float], photons: list[int]) -> None:
    for x, y, n in zip(time_ms, error, photons, strict=True):
        text = f"$10^{{{len(str(n)) - 1}}}$" + (" photons" if n == photons[0] else "")
        axes.annotate(text, (x, y), (-5, -4), textcoords="offset points", ha="right", va="top", fontsize=7, color=PALE)


def main() -> None:
    """Write the pictures."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else HERE
    papers = {"": (WHITE, "#ececec", "#440154"), "_dark": (BLACK, "#2a3038", "#fde725")}
    for suffix, (style, paper, points) in papers.items():
        with rc_context(style):
            pictures = {
                "readme_sky": draw_sky(paper=paper, points=points),
                "readme_error": draw_error(HERE / "performance.csv"),
            }
            for name, figure in pictures.items():
                FigureCanvasAgg(figure)
                figure.savefig(folder / f"{name}{suffix}.png", dpi=DPI, metadata={"Software": "aomc-sky"})


if __name__ == "__main__":
    main()
