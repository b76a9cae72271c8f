"""A sky given by a function of direction and wavelength, and what is taken for a sky model."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.component import Component, Law, cells_of_grid
from aomc_sky.errors import AomcSkyError, SceneError, floats, require_kind, shown_value
from aomc_sky.grid import PatchGrid
from aomc_sky.skies.model import Share, broadcast, check_share, sky_model, with_share
from aomc_sky.skies.patch_integrals import SURE_SPOT, TOLERANCE, PatchIntegrals, integrate_patches
from aomc_sky.skies.quadrature import centres_deg

_MAX_PATCHES = 4_000_000
_NOTED = 1e-4  #: Total variation above which notes speak of it.
_MOST_STEPS = 12


@dataclass(frozen=True, slots=True)
class FunctionSky(Share):
    """Photons of any radiance L, through a horizontal surface: the mass of a patch is its integral of L cos.

    Inside a patch photons follow L cos linearly in sin^2 of the zenith angle and in azimuth, with the means of both
    that it has there. `variation` says what that leaves out.

    Parameters
    ----------
    function : callable
        ``function(sky_zenith_rad, sky_azimuth_rad, wavelength_nm)``: float64 arrays of one shape, angles
        0 to pi/2 and 0 to 2 pi, azimuth from +x towards +y, and one wavelength. Returns the radiance, finite and
        not negative, of the shape of the angles, or one number for all of them. [any unit]
    grid : PatchGrid, optional
        Patches for sampling; 90 x 360 by default.
    name : str
        Name of the component.
    strength, irradiance_W_m2_nm : array_like, optional
        Share of the light in a scene of several models, as for `UniformSky`. [>= 0]

    Raises
    ------
    SceneError
        When it is evaluated: the function gives NaN, infinite, negative or masked values or other shapes, takes no
        arrays, or raises TypeError or ValueError itself.

    Notes
    -----
    Accuracy: for smooth functions the bias of means over photons falls as the fourth power of the patches' width, 1e-9
    and less on the default grid, and the total variation as the second. Masses by adaptive quadrature, the error of all
    together 1e-10 of their sum for a smooth function, and for one that jumps along meridians and parallels around
    regions wider than a sure spot, 4e-6 where two jumps almost meet; `quadrature_error` has the estimate. A spot of
    light narrower than `sure_spot_deg`, 0.19 of a patch, can be missed: give it finer patches or a `DirectBeam`. Cost:
    140 values for each patch and wavelength where the function is smooth, 0.4 s for 32 400 patches.

    Examples
    --------
    >>> model = sky.FunctionSky(
    ...     lambda zenith_rad, azimuth_rad, wavelength_nm: 1 + 2 * np.cos(zenith_rad) ** 2
    ... )
    >>> scene = sky.Scene(wavebands=[550.0], n_photons=1000, components=model)
    >>> print(f"{scene.source().exact_moments(0).mean_mu:.6f}")  # 11/15
    0.733333
    """

    function: Callable[[np.ndarray, np.ndarray, float], ArrayLike]
    _: KW_ONLY
    grid: PatchGrid | None = None
    name: str = "function"
    _integrals: dict[float, PatchIntegrals] = field(init=False, repr=False, compare=False, default_factory=dict)

    def __post_init__(self) -> None:
        check_share(self)
        if not callable(self.function):
            raise SceneError(
                f"a function sky needs a function of zenith, azimuth and wavelength, got {self.function!r}"
            )
        if self.grid is not None:
            require_kind(self.grid, PatchGrid, "grid=sky.PatchGrid.regular(45, 180)")
        areas = self.patches.projected_solid_angle_sr
        if not np.all(areas > 0):
            raise SceneError("the grid holds points or lines; a function sky needs patches with an extent")

    @property
    def patches(self) -> PatchGrid:
        """The patches for sampling."""
        return PatchGrid.regular(90, 360) if self.grid is None else self.grid

    def radiance(self, sky_zenith_rad: ArrayLike, sky_azimuth_rad: ArrayLike, wavelength_nm: ArrayLike) -> np.ndarray:
        """Radiance of sky elements in the function's unit, checked; arguments as for all models, any turn."""
        zenith, azimuth, wavelength = broadcast(sky_zenith_rad, sky_azimuth_rad, wavelength_nm)
        value = np.empty(zenith.shape)
        for nm in np.unique(wavelength):
            chosen = wavelength == nm
            value[chosen] = self._values(zenith[chosen], np.mod(azimuth[chosen], 2 * np.pi), float(nm))
        return value

    def irradiance(self, wavelength_nm: ArrayLike) -> np.ndarray:
        """Integral of L cos over the patches at each wavelength, at most the largest float: (n_wl,). [radiance x sr]"""
        nm = _wavelengths(wavelength_nm)
        with np.errstate(over="ignore"):
            sums = np.ldexp([math.fsum(self._of(one).mass) for one in nm], [self._exponent(one) for one in nm])
        return np.minimum(sums, np.finfo(np.float64).max)

    def variation(self, wavelength_nm: ArrayLike) -> np.ndarray:
        """Total variation between the photons and those of the function itself, shape (n_wl,).

        The largest difference between the two of the share of photons in any part of the sky, itself known to about
        3 %. [0 to 1]
        """
        return np.array([self._of(nm).variation for nm in _wavelengths(wavelength_nm)])

    def quadrature_error(self, wavelength_nm: ArrayLike) -> np.ndarray:
        """Estimated error of all masses together as a share of their sum, shape (n_wl,).

        It is too small where the function jumps along other lines than meridians and parallels: of 200 discs, 0.2 to
        0.5 degrees wide, the light was right to 0.9 %.
        """
        return np.array([self._of(nm).error for nm in _wavelengths(wavelength_nm)])

    def lower(self, wavelength_nm: ArrayLike) -> tuple[Component, ...]:
        """One component of law CELL_SLOPED, a row of masses for each wavelength; its strength is the irradiance."""
        wavelengths = _wavelengths(wavelength_nm)
        grid = self.patches
        component = Component(
            name=self.name,
            law=Law.CELL_SLOPED,
            strength=self.irradiance(wavelengths),
            mass=np.stack([self._of(nm).mass for nm in wavelengths]),
            slope=np.stack([self._of(nm).slope for nm in wavelengths]),
            cell=cells_of_grid(grid),
            grid=grid,
        )
        return with_share(self, (component,))

    def notes(self, wavelength_nm: ArrayLike) -> tuple[str, ...]:
        """Notes of a scene of this sky: the smallest sure spot, and how far the law is from the function."""
        if not np.size(wavelength_nm):
            return ()
        variation, error = self.variation(wavelength_nm).max(), self.quadrature_error(wavelength_nm).max()
        grid = self.patches
        text = f"sky {self.name!r}: a spot of light less than {self.sure_spot_deg:.2g} degrees wide may be missed"
        if variation >= _NOTED:
            text += (
                f"; light that is linear in {grid.n_zenith} x {grid.n_azimuth} patches moves {100 * variation:.2g} % "
                "of the photons (total variation), FunctionSky.refined finds a finer grid"
            )
        if error > TOLERANCE:
            text += f"; the estimated error of the masses is {error:.1g} of their sum, and more at jumps"
        return (text,)

    @property
    def sure_spot_deg(self) -> float:
        """Width of the smallest disc of light that cannot lie between the points of the quadrature. [deg]"""
        grid = self.patches
        rings, columns = (np.diff(ends, axis=1)[:, 0] for ends in (grid.zenith_bounds_deg, grid.azimuth_bounds_deg))
        widest = columns.max() * np.sin(np.deg2rad(grid.zenith_bounds_deg[:, 1].max()))
        return SURE_SPOT * float(max(rings.max(), widest))

    def refined(self, tolerance: float, *, wavelength_nm: ArrayLike = (400.0, 550.0, 700.0)) -> FunctionSky:
        """Return this sky on an even grid, as coarse as it may be, whose `variation` is at most `tolerance`.

        It is not coarser than a grid that was given, or where a coarse one does not see all light.

        SceneError: it takes more than 4 million patches.

        Parameters
        ----------
        tolerance : float
            Wished total variation. [above 0, below 1]
        wavelength_nm : array_like
            Wavelengths at which it must hold. [nm]
        """
        if not 0 < tolerance < 1:
            raise SceneError(f"tolerance is a share of the photons between 0 and 1, got {tolerance!r}")
        sky, aim, own = self, float(tolerance), (self.patches.n_zenith, self.patches.n_azimuth)
        light, least = self.irradiance(wavelength_nm), (1, 1) if self.grid is None else own
        for _ in range(_MOST_STEPS):
            grid, parts = sky.patches, [sky._of(nm) for nm in _wavelengths(wavelength_nm)]
            variation = max(part.variation for part in parts)
            if not np.allclose(sky.irradiance(wavelength_nm), light, rtol=tolerance, atol=0.0):
                least = own
            elif sky is not self:
                if variation <= tolerance:
                    return sky
                aim *= 0.95 * tolerance / variation
            rings, columns = _coarsest(
                aim,
                grid.n_zenith**2 * max(part.ring_variation for part in parts),
                grid.n_azimuth**2 * max(part.column_variation for part in parts),
            )
            shape = max(rings, least[0]), max(columns, least[1])
            if shape[0] * shape[1] > _MAX_PATCHES:
                break
            sky = replace(self, grid=PatchGrid.regular(*shape))
        raise SceneError(
            f"sky {self.name!r}: patches that move at most {100 * tolerance:g} % of the photons would be more than "
            f"{_MAX_PATCHES // 10**6} million; wish for a larger tolerance, or give bright points a DirectBeam"
        )

    def _of(self, wavelength_nm: float) -> PatchIntegrals:
        """Integrals over the patches at one wavelength, computed once."""
        key = float(wavelength_nm)
        if key not in self._integrals:
            down = -self._exponent(key)
            self._integrals[key] = integrate_patches(lambda z, a: np.ldexp(self._values(z, a, key), down), self.patches)
        return self._integrals[key]

    def _exponent(self, wavelength_nm: float) -> int:
        """Power of two by which the radiance is divided, so that no sum overflows or vanishes; 0 as a rule."""
        zenith, azimuth = np.deg2rad(centres_deg(self.patches))
        peak = float(self._values(zenith, np.mod(azimuth, 2 * np.pi), float(wavelength_nm)).max())
        return 0 if peak == 0 or 1e-200 < peak < 1e200 else math.frexp(peak)[1]

    def _values(self, zenith: np.ndarray, azimuth: np.ndarray, wavelength_nm: float) -> np.ndarray:
        """Checked values of the function, of the shape of the angles."""
        try:
            values = np.asanyarray(self.function(zenith, azimuth, wavelength_nm))
        except (TypeError, ValueError) as error:
            reason = f"{type(error).__name__}: {' '.join(str(error).split())}"
            raise SceneError(
                f"the function of sky {self.name!r} failed ({reason}); it takes three arguments: sky_zenith_rad, "
                "sky_azimuth_rad, wavelength_nm, the angles as arrays",
                "write it with numpy: np.cos instead of math.cos, np.where instead of if",
            ) from error
        if np.ma.is_masked(values):
            raise SceneError(
                f"the function of sky {self.name!r} gives masked values", "give them a radiance, 0 where no light comes"
            )
        if values.dtype.kind not in "biuf":
            raise SceneError(f"the function of sky {self.name!r} gives {values.dtype} instead of real numbers")
        if values.shape not in ((), zenith.shape):
            raise SceneError(
                f"the function of sky {self.name!r} gives an array of shape {values.shape} for directions of shape "
                f"{zenith.shape}",
                "give one radiance for each direction, or a single number",
            )
        values = np.broadcast_to(np.asarray(values, dtype=np.float64), zenith.shape)
        is_bad = ~(np.isfinite(values) & (values >= 0))
        if is_bad.any():
            first = np.unravel_index(np.argmax(is_bad), values.shape)
            raise SceneError(
                f"the function of sky {self.name!r} gives {values[first]:g} at zenith angle "
                f"{np.rad2deg(zenith[first]):.6g} degrees, azimuth {np.rad2deg(azimuth[first]):.6g} degrees, "
                f"{wavelength_nm:g} nm; a radiance is finite and not negative"
            )
        return values


def _coarsest(tolerance: float, rings: float, columns: float) -> tuple[int, int]:
    """The fewest patches (n_zenith, n_azimuth) with rings / n_zenith^2 + columns / n_azimuth^2 <= tolerance."""
    n_azimuth = max(1, math.ceil(math.sqrt(2 * columns / tolerance)))
    n_zenith = max(1, math.ceil(math.sqrt(rings / (tolerance - columns / n_azimuth**2))))
    if n_zenith == 1 and rings < tolerance:
        n_azimuth = max(1, math.ceil(math.sqrt(columns / (tolerance - rings))))
    return n_zenith, n_azimuth


def _wavelengths(wavelength_nm: ArrayLike) -> np.ndarray:
    return np.atleast_1d(floats("wavelength_nm", wavelength_nm)).ravel()


def as_sky_model(given: Any) -> Any:
    """A model that can be lowered: itself, or a `FunctionSky` of what has a radiance alone or is a function."""
    if isinstance(given, str):
        model = sky_model(given)
        try:
            return model()
        except (TypeError, AomcSkyError):
            advice = ", or weather_scene(...) for sun and sky" if given == "perez" else ""
            raise SceneError(
                f"the sky {given!r} cannot be made of its name alone: write components={model.__name__}(...){advice}"
            ) from None
    if isinstance(given, type):
        raise SceneError(f"a scene takes a sky, not its class: write {given.__name__}(...)")
    if hasattr(given, "lower"):
        return given
    function = getattr(given, "radiance", given)
    if not callable(function):
        is_field = hasattr(given, "dims") and hasattr(given, "coords")  # of xarray, whose repr has many lines
        shown = "; write TabulatedSky.from_xarray(...)" if is_field else f": {shown_value(given)}"
        raise SceneError(
            "a scene is made of sky models, Components and functions of zenith, azimuth and wavelength; got "
            f"{type(given).__name__}{shown}"
        )
    chosen = {name: getattr(given, name, None) for name in ("name", "grid", "strength", "irradiance_W_m2_nm")}
    is_function = function is given  # whose attributes are its own affair
    return FunctionSky(function, **({} if is_function else {k: v for k, v in chosen.items() if v is not None}))
