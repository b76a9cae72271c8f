"""`aomc_sky.plot`: anything that shines as a picture of the sky dome; tables, atmospheres and netCDF files too."""

from __future__ import annotations

import itertools
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.directions import AzimuthConvention, given_angle, to_enu_azimuth_deg
from aomc_sky.emission.photon_source import PhotonSource
from aomc_sky.errors import AomcSkyError, UsageError, floats, member_of, number, require_kind, shown_value
from aomc_sky.formats.aomc.amc import read_amc
from aomc_sky.formats.azimuth import AzimuthWord, given_convention
from aomc_sky.formats.hdf5_storage import require_size
from aomc_sky.formats.netcdf import open_netcdf
from aomc_sky.formats.text_file import refuse
from aomc_sky.grid import PatchGrid
from aomc_sky.outputs.picture import picture_path, save_picture
from aomc_sky.pictures.dome import ColourChoice, Normalize, NormWord, View, ViewWord
from aomc_sky.pictures.panels import ScaleWord, draw_into, figure_of
from aomc_sky.pictures.picture import PHOTONS, RADIANCE, Dome, Mark, Picture, Quantity, Symbol, spread
from aomc_sky.pictures.source import ShowWord, source_picture, sun_mark
from aomc_sky.skies.model import SkyModel
from aomc_sky.skies.tabulated import TabulatedSky
from aomc_sky.source.scene import Scene
from aomc_sky.wavebands import Wavebands

_FINE = (180, 720)
"""Patches of half a degree, in which a model is drawn."""

_WITHOUT_SUN = ("uniform", "overcast", "cardioidal")
"""Names of skies that have the same light wherever the sun is; a beam has a mark of its own."""

_LOBES = "aomc_sky.skies.lobes."
"""Modules whose skies are drawn as lobes; they are imported for such a sky alone."""


def plot(
    what: PhotonSource | Scene | SkyModel | ArrayLike,
    path: str | Path | None = None,
    *,
    show: ShowWord | None = None,
    bands: Sequence[int] | None = None,
    wavelength_nm: float = 550.0,
    grid: PatchGrid | None = None,
    sun_deg: Sequence[float] | None = None,
    sun_rad: Sequence[float] | None = None,
    azimuth_convention: AzimuthConvention | AzimuthWord = AzimuthConvention.ENU_FROM_EAST,
    title: str = "",
    label: str | None = None,
    seen_from: ViewWord = "above",
    limits: Sequence[float] | None = None,
    size_px: int = 960,
    scale: ScaleWord = "shared",
    cmap: Any = None,
    norm: NormWord | Normalize | None = None,
    caption: bool = True,
    ax: Any = None,
) -> Any:  # matplotlib.figure.Figure; the package is optional
    """Draw the sky dome of a source, a scene, a sky model or an array of patches.

    Parameters
    ----------
    what : PhotonSource, Scene, SkyModel or array_like
        A source or a scene: a dome for each waveband. A `LobeSky`: its means in patches of one degree. Another model:
        its radiance at the centres of half-degree patches.
        An array: one value for each patch, shape (n_patch,) zenith-major or (n_zenith, n_azimuth).
    path : str or Path, optional
        Where to write the picture; the suffix is the format. [.png, .svg, .pdf] By default it is not written.
    show : {"radiance", "counts", "dop", "aop"}, optional
        Of a source or a scene: radiance, photons per steradian, or the degree or the angle of linear polarisation. By
        default counts of a source, radiance of a scene.
    bands : sequence of int, optional
        Wavebands of a source or a scene; by default all, or 12 spread over them. [0-based]
    wavelength_nm : float
        Wavelength at which a model is drawn. [nm]
    grid : PatchGrid, optional
        The patches of an array; by default equal bins of its two dimensions.
    sun_deg, or sun_rad : (float, float), optional
        Zenith angle and azimuth of the sun. By default where `what` has it. [deg]
    azimuth_convention : AzimuthConvention or str
        From where the azimuth of `sun_deg` counts: by default from +x (east) towards +y. A compass azimuth is
        ``"clockwise from north"``.
    title : str
        Above the picture.
    label : str, optional
        Quantity and unit of an array or a model, beside the colour bar.
    seen_from : {"above", "below"}
        As a map with east to the right, or as an eye that looks up sees it.
    limits : (float, float), optional
        Values of the two ends of the colour bar.
    size_px : int
        Width of a PNG. [dots, 300 to 8000]
    scale : {"shared", "each"}
        One colour bar for all domes, or one for each, where some would be dark.
    cmap : str or matplotlib.colors.Colormap, optional
        Colours; by default viridis, for pulls RdBu_r.
    norm : {"log", "linear"} or matplotlib.colors.Normalize, optional
        How values become colours; by default logarithmic over at most four decades. Linear colours start at 0.
    caption : bool
        Whether sentences below say how to read the picture.
    ax : matplotlib.axes.Axes or a sequence of them, optional
        Draw into your own figure: an axes for each dome, without bar, key and caption. The bar of such a dome is
        ``figure.colorbar(ax.collections[-1], ax=ax)``; letters follow the font size of matplotlib.

    Returns
    -------
    matplotlib.figure.Figure
        The picture, or the figure of `ax`. North is up, the zenith in the centre, the horizon the rim; patches are
        exact, nothing is interpolated. What has no extent (beams) is marked and not in the colours.

    Raises
    ------
    UsageError
        An argument that is not allowed, or values that are not finite or below 0.
    SceneError
        A scene that has no light where it wants photons.
    OutputError
        The file cannot be written; what stood there before is unchanged.
    MissingExtraError
        matplotlib is not installed: ``pip install ".[plot]"``.

    Examples
    --------
    >>> figure = sky.plot(
    ...     sky.CIESky(type=12, sun_zenith_deg=40.0, sun_azimuth_deg=0.0),
    ...     "clear.png",
    ...     size_px=600,
    ... )
    >>> len(figure.axes)
    2
    """
    target = None if path is None else picture_path(path)
    convention = given_convention(azimuth_convention)
    if convention.is_from_sun:
        raise UsageError("azimuth_convention: the sun's own azimuth does not count from the sun", "write 'from north'")
    sun = None
    if sun_deg is not None or sun_rad is not None:
        angles = given_angle("sun_deg", sun_deg, sun_rad)
        if np.shape(angles) != (2,):
            name, given = ("sun_deg", sun_deg) if sun_rad is None else ("sun_rad", sun_rad)
            raise UsageError(f"{name} must be two numbers, zenith angle and azimuth, got {shown_value(given)}")
        zenith, azimuth = angles
        sun = sun_mark(float(zenith), float(to_enu_azimuth_deg(azimuth, convention)))
    if isinstance(what, Scene):
        show = show or "radiance"
        picture = picture_of_scene(what, what.source(0), show=show, bands=bands, sun=sun, title=title)
    elif isinstance(what, PhotonSource):
        picture = source_picture(what, show=show or "counts", bands=bands, sun=sun, title=title)
    elif show is not None or bands is not None:
        raise UsageError("show and bands are for a source or a scene")
    elif any(base.__module__.startswith(_LOBES) for base in type(what).__mro__):
        picture = _picture_of_lobes(what, wavelength_nm, title)
    else:
        picture = _picture_of_values(what, wavelength_nm, grid, sun, title, label)
    view, choice = member_of(View, seen_from, "seen_from"), ColourChoice(limits=limits, cmap=cmap, norm=norm)
    if ax is not None:
        if target is not None:
            raise UsageError("a figure with your own axes is yours to save: leave the path out")
        return draw_into(ax, picture, view=view, choice=choice, scale=scale)
    figure = figure_of(picture, size_px=size_px, view=view, choice=choice, scale=scale, has_caption=caption)
    if target is not None:
        save_picture(figure, target, dpi=figure.dpi)
    return figure


def sun_of_options(options: Any) -> Mark | None:
    """The sun in the options of a scene, or of its manifest, unless the sky has none."""
    sun = options.get("sun")
    return (
        None
        if not isinstance(sun, dict) or options.get("sky") in _WITHOUT_SUN
        else sun_mark(float(sun["zenith_deg"]), float(sun["azimuth_deg"]))
    )


def picture_of_scene(
    scene: Scene,
    source: PhotonSource,
    *,
    show: ShowWord = "radiance",
    bands: Sequence[int] | None = None,
    sun: Mark | None = None,
    title: str = "",
) -> Picture:
    """The source of a scene; where the sky is a table, the sun of its amc.inp is marked, for no light comes from it."""
    sun = sun or sun_of_options(scene.options)
    if sun is None and scene.options.get("sky") == "table" and "amc" in scene.input_files:
        with warnings.catch_warnings(action="ignore"):  # the scene's reader gave them
            config = read_amc(scene.input_files["amc"], lenient=bool(scene.options.get("lenient")))
        zenith, azimuth = float(config.direct_zenith_deg), float(config.direct_azimuth_deg)
        if zenith or azimuth:  # zeros in amc.inp mean that there is no sun, for example under an overcast sky
            sun = Mark(zenith_deg=zenith, azimuth_deg=azimuth, symbol=Symbol.SUN_OF_AMC)
    return source_picture(source, show=show, bands=bands, sun=sun, title=title)


def _picture_of_lobes(what: Any, wavelength_nm: float, title: str) -> Picture:
    from aomc_sky.pictures.backgrounds import lobe_picture
    from aomc_sky.skies.lobes.background import BackgroundSky

    if isinstance(what, BackgroundSky):
        raise UsageError("a background sky changes with time: plot background_at(sky, time)")
    return lobe_picture([("", what)], wavelength_nm, title=title)


def _picture_of_values(
    what: Any,
    wavelength_nm: float,
    grid: PatchGrid | None,
    sun: Mark | None,
    title: str,
    label: str | None,
) -> Picture:
    notes: tuple[str, ...] = ()
    if isinstance(what, SkyModel):
        grid, nm = PatchGrid.regular(*_FINE), number("wavelength_nm", wavelength_nm)
        zenith, azimuth = (np.deg2rad(b.mean(axis=1)) for b in (grid.zenith_bounds_deg, grid.azimuth_bounds_deg))
        values = np.asarray(what.radiance(zenith[:, None], azimuth[None, :], nm), dtype=np.float64)
        values = np.broadcast_to(values, (grid.n_zenith, grid.n_azimuth))
        label, sun = label or _unit_of(what), sun or _sun_of(what)
        notes = ("Radiance of the model at the centres of patches of half a degree.",)
    else:
        values = floats("an array to draw", what)
        if grid is None and values.ndim != 2:
            raise UsageError(f"an array without a grid needs the shape (n_zenith, n_azimuth), got {values.shape}")
        grid = PatchGrid.regular(*values.shape) if grid is None else grid
        require_kind(grid, PatchGrid, "grid=sky.PatchGrid.regular(45, 180)")
    if not np.all(np.isfinite(values)) or np.any(values < 0):
        raise UsageError("only values that are finite and not negative can be drawn")
    marks = () if sun is None else (sun,)
    dome = Dome(grid=grid, values=values, marks=marks)
    return Picture(domes=(dome,), quantity=Quantity(label=label or "value of the patch"), title=title, notes=notes)


def _unit_of(sky: Any) -> str:
    if getattr(sky, "is_absolute", False):
        return RADIANCE.label
    is_absolute = getattr(sky, "dhi", None) is not None
    return "radiance [W m$^{-2}$ sr$^{-1}$]" if is_absolute else "relative radiance"


def _sun_of(sky: Any) -> Mark | None:
    if getattr(sky, "sun_deg", None) is not None:
        return sun_mark(*sky.sun_deg)
    zenith = getattr(sky, "sun_zenith_rad", None)
    return None if zenith is None else sun_mark(float(np.rad2deg(zenith)), float(np.rad2deg(sky.sun_azimuth_rad)))


_ADVICE = "pictures are drawn of what `aomc-sky export --to netcdf` and `atmosphere` write"


def table_picture(sky: TabulatedSky, *, bands: Sequence[int] | None = None, title: str = "") -> Picture:
    """The sets of a sky file, each as if a waveband took it: radiance over irradiance, all or 12 spread over them."""
    chosen = spread(range(sky.wavelength_nm.size)) if bands is None else list(bands)
    wavelengths = sky.wavelength_nm
    rows = TabulatedSky(
        wavelength_nm=np.arange(float(wavelengths.size)), values=sky.values, grid=sky.grid, weighting=sky.weighting
    ).lower(np.arange(float(wavelengths.size)))
    scene = Scene(wavebands=Wavebands(wavelength_nm=wavelengths), n_photons=np.zeros(wavelengths.size), components=rows)
    return source_picture(scene.source(0), bands=chosen, title=title)


def netcdf_picture(path: str | Path, *, panels: Sequence[int] | None = None, title: str = "") -> tuple[Picture, int]:
    """Domes of a netCDF file that this package wrote, and how many it holds or were chosen.

    Counts of a run become photons per steradian; radiances of an atmosphere stay. By default all domes are
    drawn, or 12 spread over them. Without xarray and h5netcdf a MissingExtraError names the extra.
    """
    with open_netcdf(path) as (dataset, allowed):
        try:
            return _netcdf_picture(dataset, allowed, panels, title)
        except AomcSkyError:
            raise
        except Exception as error:  # KeyError, ValueError, and those of xarray
            raise refuse(path, f"this is not a table of patches ({error})", advice=_ADVICE) from error


def _netcdf_picture(dataset: Any, allowed_bytes: int, panels: Sequence[int] | None, title: str) -> tuple[Picture, int]:
    name = "counts" if "counts" in dataset else "radiance"
    table = dataset[name]
    if table.dims[-2:] != ("zenith", "azimuth"):
        raise KeyError(f"{name} over zenith and azimuth")
    for one in (table, dataset["zenith_bounds"], dataset["azimuth_bounds"]):
        require_size(8 * one.size, allowed_bytes, allowed_bytes, "a table")
    grid = PatchGrid(
        zenith_bounds_deg=dataset["zenith_bounds"].values, azimuth_bounds_deg=dataset["azimuth_bounds"].values
    )
    indices = list(itertools.product(*(range(n) for n in table.shape[:-2])))
    chosen = spread(range(len(indices))) if panels is None else list(panels)
    for panel in chosen:
        if not 0 <= panel < len(indices):
            raise UsageError(f"there is no dome {panel + 1} in this file; it holds {len(indices)}")
    domes = tuple(_netcdf_dome(dataset, table, grid, indices[panel]) for panel in chosen)
    quantity = RADIANCE if name == "radiance" else PHOTONS
    n_panels = len(indices) if panels is None else len(chosen)
    return Picture(domes=domes, quantity=quantity, title=title), n_panels


def _netcdf_dome(dataset: Any, table: Any, grid: PatchGrid, index: tuple[int, ...]) -> Dome:
    values = np.asarray(table.values[index], dtype=np.float64).ravel()
    if table.name == "counts":
        values = np.divide(values, grid.solid_angle_sr, out=np.zeros_like(values), where=grid.solid_angle_sr > 0)
    at = dict(zip(table.dims[:-2], index, strict=True))
    words = [_TITLES[name](dataset, index) for name, index in at.items() if name in _TITLES]
    return Dome(grid=grid, values=values, title=", ".join(words), marks=_netcdf_sun(dataset, at))


_TITLES: dict[str, Callable[[Any, int], str]] = {
    "waveband": lambda dataset, k: f"waveband {k + 1}, {float(dataset['wavelength'][k]):g} nm",
    "wavelength": lambda dataset, k: f"{float(dataset['wavelength'][k]):.6g} nm",
    "sun_zenith": lambda dataset, k: f"sun {float(dataset['sun_zenith'][k]):g}° from the zenith",
}
"""What an index along a dimension is called above a dome."""


def _netcdf_sun(dataset: Any, at: dict[str, int]) -> tuple[Mark, ...]:
    if "sun_zenith" not in at:
        return ()
    return (sun_mark(float(dataset["sun_zenith"][at["sun_zenith"]]), float(dataset.attrs["sun_azimuth_deg"])),)
