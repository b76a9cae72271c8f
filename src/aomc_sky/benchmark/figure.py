"""Error against time, one line per method: small multiples, skies from top to bottom, quantities from left to right."""

from __future__ import annotations

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
_LAST = tuple(SHOWN)[-1]


def plot_bench(
    results: BenchResults, path: str | Path, *, dpi: int = 150, peers: Mapping[str, tuple[str, Style]] = PEER_STYLES
) -> None:
    """Draw error against time as PNG, SVG or PDF; of the contenders in the speed runs those in `peers` are drawn."""
    target = picture_path(path)
    figure_module = optional_module("matplotlib.figure", extra="plot")
    optional_module("matplotlib.backends.backend_agg", extra="plot")
    skies = [name for name in SKIES if any(row.sky == name for row in results.rows)]
    size = (2.55 * len(SHOWN) + 1.6, 2.1 * len(skies) + 1.1)
    figure = figure_module.Figure(figsize=size, layout="constrained")
    axes = figure.subplots(len(skies), len(SHOWN), squeeze=False, sharex=True, sharey="col")
    for panels, sky in zip(axes, skies, strict=True):
        lines = _series(results, sky, peers)
        for panel, quantity in zip(panels, SHOWN, strict=True):
            _draw(panel, lines, quantity)
        panels[0].set_ylabel(bench_sky(sky).title.replace(", ", ",\n"), fontsize=8)
    for panel, title in zip(axes[0], SHOWN.values(), strict=True):
        panel.set_title(title, fontsize=9)
    for panels, sky in zip(axes, skies, strict=True):  # after all lines, for columns share their axis of errors
        _name_lines(panels[-1], _series(results, sky, peers))
    figure.supxlabel("time of one run, plan and photons, one thread [s]", fontsize=9)
    figure.supylabel("relative error", fontsize=9)
    save_picture(figure, target, dpi=dpi)


@dataclass(frozen=True, kw_only=True, slots=True)
class _Series:
    """One line of every panel of a sky: a name, how it looks, times, and errors by quantity."""

    name: str
    style: Style
    seconds: np.ndarray
    error: dict[str, np.ndarray]

    def plot_on(self, panel: Any, x: Any, y: Any, **options: Any) -> None:
        """Draw points in the style of the line."""
        colour, line, marker = self.style
        panel.plot(
            x, y, color=colour, linestyle=line, marker=marker, linewidth=1.4, markersize=3.6, clip_on=False, **options
        )


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


def _draw(panel: Any, lines: list[_Series], quantity: str) -> None:
    """The lines of one sky and quantity over the two errors whose time is given."""
    ticker = optional_module("matplotlib.ticker", extra="plot")
    for line in reversed(lines):
        line.plot_on(panel, line.seconds, line.error[quantity])
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


def _name_lines(panel: Any, lines: list[_Series]) -> None:
    """Names beside the last panel of a sky, in the order of the lines' ends there."""
    low, high = np.log10(panel.get_ylim())
    ends = [float(np.log10(line.error[_LAST][-1])) for line in lines]
    least = min(0.13, 0.95 / max(len(lines), 1)) * (high - low)
    order = np.argsort(np.nan_to_num(ends, nan=low))
    heights = _apart([ends[k] for k in order], least, low)
    over = max(0.0, max(heights, default=low) - high)
    for k, height in zip(order, (height - over for height in heights), strict=True):
        share = (height - low) / (high - low)
        lines[k].plot_on(panel, [1.03, 1.13], [share, share], transform=panel.transAxes)
        panel.annotate(lines[k].name, (1.16, share), xycoords="axes fraction", va="center", fontsize=7.5)


def _apart(ends: list[float], least: float, low: float) -> list[float]:
    """The same heights, in order, pushed up until neighbours are `least` apart."""
    found: list[float] = []
    for end in ends:
        height = low if np.isnan(end) else end
        found.append(max(height, found[-1] + least) if found else height)
    return found
