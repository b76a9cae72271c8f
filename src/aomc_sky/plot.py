"""The sky dome as a picture: zenith angle as radius, the azimuth convention named, the sun marked."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.errors import UsageError
from aomc_sky.extras import optional_module
from aomc_sky.grid import PatchGrid
from aomc_sky.outputs.picture import picture_path, save_picture
from aomc_sky.skies.model import SkyModel

_LOG_FROM_RANGE = 10.0
"""Ratio of the largest to the smallest value above which colours are logarithmic."""
_MOST_DECADES = 4.0
_CAPTION = "radius: zenith angle; azimuth from +x (east) towards +y (north), drawn as on a map"
_N_ZENITH, _N_AZIMUTH = 180, 720
_LABEL_SIDES = (67.5, 247.5)


def plot_sky(
    sky: SkyModel | ArrayLike,
    path: str | Path,
    *,
    grid: PatchGrid | None = None,
    wavelength_nm: float = 550.0,
    sun_deg: Sequence[float] | None = None,
    title: str = "",
    unit: str | None = None,
    dpi: int = 150,
) -> None:
    """Draw a sky dome.

    Parameters
    ----------
    sky : SkyModel or array_like, shape (n_patch,) or (n_zenith, n_azimuth)
        A model, drawn by its radiance in half degrees, or one value per patch of `grid`, zenith-major.
    path : str or Path
        The picture; its suffix is the format. [.png, .svg, .pdf]
    grid : PatchGrid, optional
        The patches of an array; by default equal bins of its two dimensions.
    wavelength_nm : float
        Wavelength at which a model is drawn. [nm]
    sun_deg : (float, float), optional
        Zenith angle and azimuth of the sun, from +x towards +y. By default where the model has its sun.
    title : str
        Written above the dome.
    unit : str, optional
        Quantity and unit beside the colour bar. By default the model's radiance, absolute where it knows it.
    dpi : int
        Dots per inch of a PNG.

    Raises
    ------
    UsageError
        A suffix that is no picture, an array that does not fit its grid, or values that are not finite.
    OutputError
        The file cannot be written; what stood there before is unchanged.
    MissingExtraError
        matplotlib is not installed.

    Notes
    -----
    The dome is drawn as on a map, north up and east to the right, so that azimuth grows counterclockwise
    from the right, as in a figure of x and y. Colours are logarithmic where the values span more than a
    factor of 10, and show at most four decades below the brightest value.
    """
    target = picture_path(path)
    zenith_edges, azimuth_edges, values = _values(sky, grid, wavelength_nm)
    figure = _dome(zenith_edges, azimuth_edges, values, unit or _unit_of(sky), title)
    sun = _sun_of(sky) if sun_deg is None else (float(sun_deg[0]), float(sun_deg[1]))
    if sun is not None:
        # the labels of the radius go to the side without the sun
        figure.axes[0].set_rlabel_position(_LABEL_SIDES[int(np.cos(np.deg2rad(sun[1] - _LABEL_SIDES[0])) > 0)])
        _mark_sun(figure.axes[0], *sun)
    save_picture(figure, target, dpi=dpi)


def _values(sky: Any, grid: PatchGrid | None, wavelength_nm: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Edges of rings [deg] and columns [rad], and the values between them, (n_zenith, n_azimuth)."""
    if isinstance(sky, SkyModel):
        fine = PatchGrid.regular(_N_ZENITH, _N_AZIMUTH)
        zenith = np.deg2rad(fine.zenith_bounds_deg.mean(axis=1))
        azimuth = np.deg2rad(fine.azimuth_bounds_deg.mean(axis=1))
        values = np.asarray(sky.radiance(zenith[:, None], azimuth[None, :], wavelength_nm), dtype=np.float64)
        grid = fine
    else:
        values = np.asarray(sky, dtype=np.float64)
        if grid is None:
            if values.ndim != 2:
                raise UsageError(f"an array without a grid needs the shape (n_zenith, n_azimuth), got {values.shape}")
            grid = PatchGrid.regular(*values.shape)
        if values.size != grid.n_patches:
            raise UsageError(f"{values.size} values do not fit a grid of {grid.n_patches} patches")
    values = np.broadcast_to(values, (grid.n_zenith, grid.n_azimuth)) if values.ndim == 0 else values
    values = values.reshape(grid.n_zenith, grid.n_azimuth)
    if not np.all(np.isfinite(values)):
        raise UsageError("only finite values can be drawn")
    edges = np.append(grid.zenith_bounds_deg[:, 0], grid.zenith_bounds_deg[-1, 1])
    return edges, grid.azimuth_edges_rad, values


def _unit_of(sky: Any) -> str:
    if not isinstance(sky, SkyModel):
        return "value of the patch"
    is_absolute = getattr(sky, "dhi", None) is not None
    return "radiance [W m$^{-2}$ sr$^{-1}$]" if is_absolute else "relative radiance"


def _sun_of(sky: Any) -> tuple[float, float] | None:
    zenith = getattr(sky, "sun_zenith_rad", None)
    return None if zenith is None else (float(np.rad2deg(zenith)), float(np.rad2deg(sky.sun_azimuth_rad)))


def _norm(values: np.ndarray) -> Any:
    """Colours: logarithmic where the dynamic range is large."""
    colors = optional_module("matplotlib.colors", extra="plot")
    largest = float(values.max())
    positive = values[values > 0]
    if positive.size == 0 or largest <= 0:
        return colors.Normalize(0.0, max(largest, 1.0))
    smallest = float(positive.min())
    if largest / smallest <= _LOG_FROM_RANGE and positive.size == values.size:
        return colors.Normalize(smallest if smallest < largest else 0.0, largest)
    return colors.LogNorm(max(smallest, largest / 10**_MOST_DECADES) * (1 - 1e-12), largest)


def _dome(zenith_edges: np.ndarray, azimuth_edges: np.ndarray, values: np.ndarray, unit: str, title: str) -> Any:
    """A figure with the dome and its colour bar."""
    figure_module = optional_module("matplotlib.figure", extra="plot")
    optional_module("matplotlib.backends.backend_agg", extra="plot")
    figure = figure_module.Figure(figsize=(6.6, 5.4), layout="constrained")
    axes = figure.add_subplot(projection="polar")
    norm = _norm(values)
    shown = np.maximum(values, norm.vmin) if type(norm).__name__ == "LogNorm" else values
    mesh = axes.pcolormesh(azimuth_edges, zenith_edges, shown, norm=norm, cmap="viridis", rasterized=True)
    axes.set_ylim(0, 90)
    axes.set_yticks([30, 60], ["30°", "60°"], color="white", fontsize=8, path_effects=_outline())
    axes.set_xticks(np.deg2rad([0, 45, 90, 135, 180, 225, 270, 315]))
    axes.set_xticklabels(["0°\nE, +x", "45°", "90° N, +y", "135°", "180°\nW", "225°", "270° S", "315°"])
    axes.tick_params(axis="x", pad=6)
    axes.grid(color="white", alpha=0.35, linewidth=0.6)
    bar = figure.colorbar(mesh, ax=axes, shrink=0.8, pad=0.12, label=unit)
    if type(norm).__name__ == "LogNorm":
        _plain_log_ticks(bar)
    if title:
        axes.set_title(title, fontsize=11, pad=12)
    figure.supxlabel(_CAPTION, fontsize=8)
    return figure


def _plain_log_ticks(bar: Any) -> None:
    """Ticks at 1, 2 and 5 of each decade, written as plain numbers."""
    ticker = optional_module("matplotlib.ticker", extra="plot")
    bar.ax.yaxis.set_major_locator(ticker.LogLocator(subs=(1.0, 2.0, 5.0), numticks=20))
    bar.ax.yaxis.set_major_formatter(ticker.FormatStrFormatter("%g"))
    bar.ax.yaxis.set_minor_formatter(ticker.NullFormatter())


def _mark_sun(axes: Any, zenith_deg: float, azimuth_deg: float) -> None:
    place = (np.deg2rad(azimuth_deg), min(zenith_deg, 90.0))
    axes.plot(*place, marker="o", markersize=9, markerfacecolor="none", markeredgecolor="black", markeredgewidth=2.2)
    axes.plot(*place, marker="o", markersize=9, markerfacecolor="none", markeredgecolor="white", markeredgewidth=1.0)
    style = {"color": "white", "fontsize": 9, "fontweight": "bold", "path_effects": _outline()}
    axes.annotate("sun", place, xytext=(8, 6), textcoords="offset points", **style)


def _outline() -> list[Any]:
    """A dark rim, so that white letters can be read on any colour."""
    return [optional_module("matplotlib.patheffects", extra="plot").withStroke(linewidth=2, foreground="black")]
