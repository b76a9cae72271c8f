"""Error against time, one line per method: a row for each sky, a column for each quantity."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from aomc_sky.extras import optional_module
from aomc_sky.outputs.picture import picture_path, save_picture
from bench.accuracy import Row
from bench.peers import MITSUBA
from bench.samplers import CHOICE, METHODS, SpeedRun
from bench.skies import PEER_SKY, SKIES, bench_sky

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
PEERS: dict[str, tuple[str, Style]] = {
    CHOICE: ("numpy choice", ("#999999", "-", "v")),
    MITSUBA: ("Mitsuba 3", ("#999999", "--", "P")),
}
"""Two peers that stand for all, with name and style: what one writes first, and the best one."""
PEERS_FROM = 10**5
"""Photons from which on a peer's rate, not its set-up, makes its time."""


def plot(rows: Sequence[Row], speed: SpeedRun | None, path: str | Path) -> None:
    """Draw error against time as PNG, SVG or PDF: a row for each sky, a column for each quantity, one key above."""
    skies = [name for name in SKIES if any(row.sky == name for row in rows)]
    figure = _figure(2.0 * len(SHOWN) + 0.9, 1.55 * len(skies) + 1.3)
    axes = figure.subplots(len(skies), len(SHOWN), squeeze=False, sharex=True, sharey=True)
    key: dict[str, Any] = {}
    for panels, sky in zip(axes, skies, strict=True):
        lines = _series(rows, speed, sky)
        for panel, quantity in zip(panels, SHOWN, strict=True):
            key |= _draw(panel, lines, quantity)
        panels[0].set_ylabel(textwrap.fill(bench_sky(sky).title, 20), fontsize=8)
    for panel, title in zip(axes[0], SHOWN.values(), strict=True):
        panel.set_title(title, fontsize=9)
    names = [line.name for line in _series(rows, speed, PEER_SKY if PEER_SKY in skies else skies[0])]
    style = {"loc": "outside upper center", "ncols": len(names), "frameon": False, "fontsize": 8.5}
    figure.legend([key[name] for name in names], names, **style)
    figure.supxlabel(_TIME, fontsize=9)
    figure.supylabel("relative error", fontsize=9)
    save_picture(figure, picture_path(path), dpi=100)


_TIME = "time of one run, plan and photons, one thread [s]"


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


def _series(rows: Sequence[Row], speed: SpeedRun | None, sky: str) -> list[_Series]:
    """Lines of one sky: its methods, and beside its table the peers at their rate with the error of `iid`."""
    found = []
    for method in METHODS:
        own = sorted((row for row in rows if (row.sky, row.method) == (sky, method)), key=lambda row: row.n_photons)
        if own:
            found.append(_line(method, STYLES[method], own, [row.seconds for row in own]))
    own = [row for row in rows if (row.sky, row.method) == (sky, "iid") and row.n_photons >= PEERS_FROM]
    if speed is not None and sky == PEER_SKY and own:
        for name, (short, style) in PEERS.items():
            if name in speed.times:
                times = [1e-9 * speed.ns_per_photon(name) * row.n_photons for row in own]
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
