"""Error against time, one line per method: small multiples, skies from top to bottom, quantities from left to right."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from aomc_sky.benchmark.accuracy import Row
from aomc_sky.benchmark.methods import METHODS
from aomc_sky.benchmark.run import BenchResults
from aomc_sky.benchmark.skies import SKIES, bench_sky
from aomc_sky.extras import optional_module
from aomc_sky.outputs.picture import picture_path, save_picture

SHOWN = {
    "planar": "planar irradiance",
    "cone": "cone of 5°",
    "histogram": "288 refracted bins",
    "ring": "horizon ring",
    "scalar": "scalar irradiance (median)",
}
"""Quantities in the order of the columns."""

STYLES = {
    "default": ("#0072B2", "-", "o"),
    "patch-order": ("#56B4E9", "--", "o"),
    "sobol": ("#009E73", "-", "^"),
    "iid": ("#555555", "-", "s"),
    "largest-remainder": ("#E69F00", "-", "D"),
    "aomc": ("#D55E00", ":", "X"),
}
"""Colour of Okabe and Ito, line and marker: any of the three tells the methods apart."""


def plot_bench(results: BenchResults, path: str | Path, *, dpi: int = 150) -> None:
    """Draw error against time.

    Parameters
    ----------
    results : BenchResults
        A run.
    path : str or Path
        The picture. [.png, .svg, .pdf]
    dpi : int
        Dots per inch of a PNG.

    Raises
    ------
    UsageError
        A suffix that is no picture.
    OutputError
        The file cannot be written.
    MissingExtraError
        matplotlib is not installed.
    """
    target = picture_path(path)
    figure_module = optional_module("matplotlib.figure", extra="plot")
    optional_module("matplotlib.backends.backend_agg", extra="plot")
    skies = [name for name in SKIES if any(row.sky == name for row in results.rows)]
    size = (2.55 * len(SHOWN) + 1.6, 2.1 * len(skies) + 1.1)
    figure = figure_module.Figure(figsize=size, layout="constrained")
    axes = figure.subplots(len(skies), len(SHOWN), squeeze=False, sharex=True, sharey="col")
    for line, sky in zip(axes, skies, strict=True):
        for panel, quantity in zip(line, SHOWN, strict=True):
            _draw(panel, [row for row in results.rows if row.sky == sky], quantity)
        line[0].set_ylabel(_broken(bench_sky(sky).title), fontsize=8)
    for panel, title in zip(axes[0], SHOWN.values(), strict=True):
        panel.set_title(title, fontsize=9)
    _name_lines(axes, skies, results)
    figure.supxlabel("time of one run, plan and photons, one thread [s]", fontsize=9)
    figure.supylabel("relative error", fontsize=9)
    save_picture(figure, target, dpi=dpi)


def _draw(panel: Any, rows: list[Row], quantity: str) -> None:
    """The lines of one sky and quantity, and a triangle of slope -1/2 behind them."""
    ticker = optional_module("matplotlib.ticker", extra="plot")
    for method in reversed(METHODS):
        own = sorted((row for row in rows if row.method == method), key=lambda row: row.n_photons)
        error = np.array([row.error[quantity] for row in own])
        if error.size == 0:
            continue
        colour, line, marker = STYLES[method]
        seconds = np.array([row.seconds for row in own])
        panel.plot(seconds, np.where(error > 0, error, np.nan), color=colour, linestyle=line, marker=marker)
    for artist in panel.lines:
        artist.set(linewidth=1.4, markersize=3.6)
    panel.set_xscale("log")
    panel.set_yscale("log")
    for axis in (panel.xaxis, panel.yaxis):
        axis.set_major_locator(ticker.LogLocator(numticks=20))
        axis.set_minor_locator(ticker.NullLocator())
    for level, text in ((1e-2, "1 %"), (1e-4, "0.01 %")):
        panel.axhline(level, color="#bbbbbb", linewidth=0.8, zorder=0)
        panel.annotate(
            text, (1.0, level), xycoords=("axes fraction", "data"), ha="right", va="bottom", fontsize=6, color="#777777"
        )
    panel.tick_params(labelsize=7)
    panel.spines[["top", "right"]].set_visible(False)


def _broken(title: str) -> str:
    """A title over two lines where it has a comma."""
    return title.replace(", ", ",\n")


def _name_lines(axes: Any, skies: list[str], results: BenchResults) -> None:
    """Names of the methods beside the last point of their lines, in the last panel of every sky."""
    for line, sky in zip(axes, skies, strict=True):
        ends = []
        for method in METHODS:
            own = [row for row in results.rows if (row.sky, row.method) == (sky, method)]
            if own:
                last = max(own, key=lambda row: row.n_photons)
                ends.append((np.log10(max(last.error["scalar"], 1e-12)), method))
        if not ends:
            continue
        panel = line[-1]
        low, high = np.log10(panel.get_ylim())
        places = _apart(sorted(ends), 0.13 * (high - low))
        for place, method in places:
            share = (place - low) / (high - low)
            colour, style, marker = STYLES[method]
            panel.plot(
                [1.03, 1.13],
                [share, share],
                transform=panel.transAxes,
                clip_on=False,
                color=colour,
                linestyle=style,
                marker=marker,
                markersize=3.6,
                linewidth=1.4,
            )
            panel.annotate(method, (1.16, share), xycoords="axes fraction", va="center", fontsize=7.5)


def _apart(ends: list[tuple[float, str]], least: float) -> list[tuple[float, str]]:
    """The same places, in order, pushed up until neighbours are `least` apart."""
    found: list[tuple[float, str]] = []
    for place, name in ends:
        found.append((max(place, found[-1][0] + least) if found else place, name))
    return found
