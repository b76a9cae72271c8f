"""Error against time, one line per method: three panels to begin with, and small multiples, a row for each sky."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from aomc_sky.benchmark.accuracy import Row
from aomc_sky.benchmark.run import PEER_SKY, BenchResults
from aomc_sky.benchmark.samplers import CHOICE, METHODS
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
    "iid": ("#555555", "-", "s"),
    "largest-remainder": ("#E69F00", "-", "D"),
    "aomc": ("#D55E00", ":", "X"),
}
"""Colour of Okabe and Ito, line and marker; line and marker alone separate the methods too."""

Style = tuple[str, str, str]
PEER_STYLES: dict[str, tuple[str, Style]] = {CHOICE: ("numpy choice", ("#999999", "-", "v"))}
"""By contender: name and style. What one writes first stands for all peers; `bench/report.py` adds the best one."""
PEERS_FROM = 10**5
"""Photons from which on a peer's rate, not its set-up, makes its time."""


def plot_bench(
    results: BenchResults, path: str | Path, *, dpi: int = 150, peers: Mapping[str, tuple[str, Style]] = PEER_STYLES
) -> None:
    """Draw error against time as PNG, SVG or PDF: a row for each sky, a column for each quantity, one key above.

    Of the contenders in the speed runs those in `peers` are drawn.
    """
    skies = [name for name in SKIES if any(row.sky == name for row in results.rows)]
    figure = _figure(2.0 * len(SHOWN) + 0.9, 1.55 * len(skies) + 1.3)
    axes = figure.subplots(len(skies), len(SHOWN), squeeze=False, sharex=True, sharey=True)
    key: dict[str, Any] = {}
    for panels, sky in zip(axes, skies, strict=True):
        lines = _series(results, sky, peers)
        for panel, quantity in zip(panels, SHOWN, strict=True):
            key |= _draw(panel, lines, quantity)
        panels[0].set_ylabel(textwrap.fill(bench_sky(sky).title, 20), fontsize=8)
    for panel, title in zip(axes[0], SHOWN.values(), strict=True):
        panel.set_title(title, fontsize=9)
    names = [line.name for line in _series(results, PEER_SKY if PEER_SKY in skies else skies[0], peers)]
    style = {"loc": "outside upper center", "ncols": len(names), "frameon": False, "fontsize": 8.5}
    figure.legend([key[name] for name in names], names, **style)
    figure.supxlabel(_TIME, fontsize=9)
    figure.supylabel("relative error", fontsize=9)
    save_picture(figure, picture_path(path), dpi=dpi)


def plot_first(
    results: BenchResults, path: str | Path, *, dpi: int = 150, peers: Mapping[str, tuple[str, Style]] = PEER_STYLES
) -> None:
    """Draw three quantities of the sky that peers sample, too, the few lines that matter, named where they end."""
    sky = PEER_SKY if any(row.sky == PEER_SKY for row in results.rows) else results.rows[0].sky
    lines = [line for line in _series(results, sky, peers) if line.name not in _NOT_FIRST]
    figure = _figure(3.3 * len(_FIRST), 3.3)
    for panel, quantity in zip(figure.subplots(1, len(_FIRST), sharey=True), _FIRST, strict=True):
        _draw(panel, lines, quantity)
        panel.set_title(SHOWN[quantity], fontsize=10, loc="left")
        low, high = panel.get_xlim()
        panel.set_xlim(low, high * (high / low) ** 0.4)  # names stand to the right of the lines
    for panel, quantity in zip(figure.axes, _FIRST, strict=True):
        _name_lines(panel, lines, quantity)
    figure.axes[0].set_ylabel("relative error", fontsize=9)
    figure.supxlabel(_TIME, fontsize=9)
    save_picture(figure, picture_path(path), dpi=dpi)


_TIME = "time of one run, plan and photons, one thread [s]"
_FIRST = ("planar", "cone", "histogram")
_NOT_FIRST = ("patch-order", "largest-remainder", "Mitsuba 3")


def _figure(width_in: float, height_in: float) -> Any:
    figure = optional_module("matplotlib.figure", extra="plot").Figure((width_in, height_in), layout="constrained")
    optional_module("matplotlib.backends.backend_agg", extra="plot")
    return figure


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class _Series:
    """One line of every panel of a sky: a name, how it looks, times, and errors by quantity."""

    name: str
    style: Style
    seconds: np.ndarray
    error: dict[str, np.ndarray]

    def plot_on(self, panel: Any, x: Any, y: Any) -> Any:
        """Draw points in the style of the line."""
        colour, line, marker = self.style
        style = {"color": colour, "linestyle": line, "marker": marker, "linewidth": 1.4, "markersize": 3.6}
        return panel.plot(x, y, clip_on=False, **style)[0]


def _series(results: BenchResults, sky: str, peer_styles: Mapping[str, tuple[str, Style]]) -> list[_Series]:
    """Lines of one sky: its methods, and beside its table the peers at their rate with the error of `iid`."""
    found = []
    for method in METHODS:
        own = sorted(
            (row for row in results.rows if (row.sky, row.method) == (sky, method)), key=lambda row: row.n_photons
        )
        if own:
            found.append(_line(method, STYLES[method], own, [row.seconds for row in own]))
    peers = results.speed[-1:] if sky == PEER_SKY else ()
    own = [row for row in results.rows if (row.sky, row.method) == (sky, "iid") and row.n_photons >= PEERS_FROM]
    for run in peers:
        for name, (short, style) in peer_styles.items():
            if name in run.times and own:
                times = [1e-9 * run.ns_per_photon(name) * row.n_photons for row in own]
                found.append(_line(short, style, own, times))
    return found


def _line(name: str, style: Style, rows: list[Row], seconds: list[float]) -> _Series:
    """A line through rows; an error of exactly 0 has no place on a logarithmic axis."""
    error = {quantity: np.array([row.error[quantity] for row in rows]) for quantity in SHOWN}
    shown = {quantity: np.where(values > 0, values, np.nan) for quantity, values in error.items()}
    return _Series(name=name, style=style, seconds=np.array(seconds), error=shown)


def _draw(panel: Any, lines: list[_Series], quantity: str) -> dict[str, Any]:
    """The lines of one sky and quantity over the two errors whose time is given; by name."""
    ticker = optional_module("matplotlib.ticker", extra="plot")
    drawn = {line.name: line.plot_on(panel, line.seconds, line.error[quantity]) for line in reversed(lines)}
    panel.set_xscale("log")
    panel.set_yscale("log")
    panel.xaxis.set_major_locator(ticker.LogLocator(numticks=20))
    panel.yaxis.set_major_locator(ticker.LogLocator(base=100.0, numticks=20))
    for axis in (panel.xaxis, panel.yaxis):
        axis.set_minor_locator(ticker.NullLocator())
    for level, text in ((1e-2, "1 %"), (1e-4, "0.01 %")):
        panel.axhline(level, color="#cccccc", linewidth=0.8, zorder=0)
        style = {"ha": "right", "va": "bottom", "fontsize": 6, "color": "#777777"}
        panel.annotate(text, (1.0, level), xycoords=("axes fraction", "data"), **style)
    panel.tick_params(labelsize=7)
    panel.spines[["top", "right"]].set_visible(False)
    return drawn


def _name_lines(panel: Any, lines: list[_Series], quantity: str) -> None:
    """Names in the colours of their lines: right of where ours end, and above the middle of a peer's."""
    effects = optional_module("matplotlib.patheffects", extra="plot")
    style: dict[str, Any] = {"fontsize": 8, "textcoords": "offset points", "zorder": 5}
    style["path_effects"] = [effects.withStroke(linewidth=2.5, foreground="white")]
    low, high = np.log10(panel.get_ylim())
    height = np.inf
    for line in sorted(lines, key=lambda one: -float(one.error[quantity][-1])):
        seconds, error, colour = line.seconds, line.error[quantity], line.style[0]
        if line.name not in STYLES:
            middle = len(error) // 2
            panel.annotate(line.name, (seconds[middle], error[middle]), (3, 4), color=colour, **style)
        elif np.isfinite(error[-1]):
            height = min(float(np.log10(error[-1])), height - 0.06 * (high - low))
            name = _LONG.get(line.name, line.name)
            panel.annotate(name, (seconds[-1], 10**height), (6, -5), va="center", color=colour, **style)


_LONG = {"iid": "independent photons", "aomc": "AOMC's rounding"}
