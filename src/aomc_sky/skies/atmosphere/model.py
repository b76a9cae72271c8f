"""The clear sky of a physical atmosphere as a sky model, in absolute units, and its direct beam."""

from __future__ import annotations

import dataclasses
import math
import os
from collections.abc import Sequence
from dataclasses import InitVar, dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.component import Component, Law, cells_of_grid
from aomc_sky.directions import in_both_units, settle_angles
from aomc_sky.errors import SceneError, require_kind
from aomc_sky.grid import PatchGrid
from aomc_sky.progress import is_free, status_line
from aomc_sky.record import same_content
from aomc_sky.skies.atmosphere.description.medium import read_medium
from aomc_sky.skies.atmosphere.description.reader import read_atmo
from aomc_sky.skies.atmosphere.lights import Moon
from aomc_sky.skies.atmosphere.medium import Medium
from aomc_sky.skies.atmosphere.sky.method import NIGHT_DEG, SolverWord
from aomc_sky.skies.atmosphere.sky.solve import relative_errors, solve_sky
from aomc_sky.skies.atmosphere.sky.solved import SolvedSky, glow_means, patch_means
from aomc_sky.skies.direct_beam import DirectBeam
from aomc_sky.skies.model import Share, broadcast, check_share, polarised, sky_repr, with_share
from aomc_sky.skies.quadrature import centres_deg
from aomc_sky.wavebands import nearest_wavelength_index

if TYPE_CHECKING:
    from aomc_sky.skies.polarisation import RayleighPattern

DEFAULT_BINS = (45, 180)  #: Equal bins of zenith and azimuth, by default.

#: Tolerances of patch means; the second one with the edge of the earth's shadow in the sky.
_TOLERANCE, _TOLERANCE_TWILIGHT = 1e-5, 1e-3


@in_both_units
@dataclass(eq=False, frozen=True, kw_only=True, slots=True)
class AtmosphereSky(Share):
    """Diffuse light of a clear atmosphere at sea level.

    The medium is solved once, when the model is made. The integrals along the rays are smooth in the direction and kept
    as series; phase functions, which may be sharp, are evaluated in every direction.

    Parameters
    ----------
    medium : Medium
        The atmosphere at its wavelengths.
    sun_zenith_deg, or sun_zenith_rad : float
        Zenith angle of the sun. [deg, 0 to 180]
    sun_azimuth_deg, or sun_azimuth_rad : float
        Azimuth of the sun, from +x towards +y; by default 0. [deg]
    method : {"auto", "order1", "sos", "mc"}
        As `aomc_sky.skies.atmosphere.sky.solve.solve` has it.
    n_orders : int, optional
        Most interactions that count; None is what the medium says. [1 or more]
    grid : PatchGrid, optional
        Patches whose means the sampler gets, by default 45 x 180 equal bins of the hemisphere.
    disc : bool
        Whether the direct beam has the extent of the solar disc; that of an eclipse has it whole, with less light.
    moon : Moon, optional
        Hides part of the sun, from every point of air and ground.
    ground_radiance : ndarray, float64, shape (n_wl,), optional
        Light that the ground gives off by itself; in deep night it is the only light. [W m-2 sr-1 nm-1]
    n_paths : int, optional
        Backward paths of each direction and wavelength where the solution has some; by default as many as
        `aomc_sky.skies.atmosphere.sky.solve.solve_sky` says. [8 to 2^32 - 1]
    seed : int
        Of the random numbers of the paths; 0 by default. Skies of several seeds show the error. [0 to 2^64 - 1]
    polarisation : RayleighPattern, optional
        Linear polarisation of the light of the sun, which the scalar solver does not have; without it photons carry
        none. That of a glowing ground has none.
    strength, irradiance_W_m2_nm : array_like, optional
        Instead of its own irradiance, as for `UniformSky`. [>= 0]

    Notes
    -----
    Accuracy: radiances of order 1 follow their solver to 2e-8 for a sun above 10 degrees; patch means are good to
    `patch_change`, 1e-5, 1e-3 in twilight.
    The solver's own error is `patch_error`.

    Examples
    --------
    >>> clear = sky.read_scene("inputs/atmosphere_sky", iterations=1000)
    >>> [component.name for component in clear.components]
    ['direct', 'atmosphere']
    """

    medium: Medium
    sun_zenith_deg: float = None  # type: ignore[assignment]
    sun_azimuth_deg: float = None  # type: ignore[assignment]
    sun_zenith_rad: InitVar[float | None] = None
    sun_azimuth_rad: InitVar[float | None] = None
    method: SolverWord = "auto"
    n_orders: int | None = None
    grid: PatchGrid = field(default_factory=lambda: PatchGrid.regular(*DEFAULT_BINS))
    disc: bool = True
    moon: Moon | None = None
    ground_radiance: np.ndarray | None = None
    n_paths: int | None = None
    seed: int = 0
    polarisation: RayleighPattern | None = None
    solved: SolvedSky = field(init=False, repr=False, compare=False)
    patch_mean: np.ndarray = field(init=False, repr=False, compare=False)
    patch_change: float = field(init=False, repr=False, compare=False)

    __eq__ = same_content
    __repr__ = sky_repr

    def __post_init__(self, sun_zenith_rad: float | None, sun_azimuth_rad: float | None) -> None:
        check_share(self)
        require_kind(self.medium, Medium, "medium=sky.atmosphere.read_atmo('air.atmo')")
        require_kind(self.grid, PatchGrid, "grid=sky.PatchGrid.regular(45, 180)")
        settle_angles(self, sun_zenith_deg=sun_zenith_rad)
        settle_angles(self, default=0.0, sun_azimuth_deg=sun_azimuth_rad)
        if not np.isfinite(self.sun_azimuth_deg):
            raise SceneError(f"the sun's azimuth must be finite, got {self.sun_azimuth_deg}")
        is_night = self.sun_zenith_deg > NIGHT_DEG + 1e-9
        if is_night and self.polarisation is not None and self.ground_radiance is not None:
            raise SceneError(
                f"the sun is {self.sun_zenith_deg - 90.0:.4g} degrees below the horizon and the ground alone gives the "
                "light, but Rayleigh's pattern is that of the sun's light",
                "leave polarisation out",
            )
        tolerance = _TOLERANCE if self.sun_zenith_deg <= 90.0 else _TOLERANCE_TWILIGHT
        with status_line("solving the atmosphere", enabled=is_free()):
            solved = solve_sky(
                self.medium,
                sun_zenith_rad=math.radians(self.sun_zenith_deg),
                method=self.method,
                n_orders=self.n_orders,
                moon=self.moon,
                ground_radiance=self.ground_radiance,
                n_paths=self.n_paths,
                seed=self.seed,
            )
            mean, change = patch_means(solved, self.grid, math.radians(self.sun_azimuth_deg), tolerance=tolerance)
        mean.flags.writeable = False
        for name, value in (("solved", solved), ("patch_mean", mean), ("patch_change", change)):
            object.__setattr__(self, name, value)

    @classmethod
    def from_file(
        cls,
        path: str | os.PathLike[str],
        *,
        wavelength_nm: ArrayLike,
        allow_paths: Sequence[str | os.PathLike[str]] = (),
        **options: Any,
    ) -> AtmosphereSky:
        """The sky of an atmosphere description.

        Parameters
        ----------
        path : str or path
            The description, a .atmo file.
        wavelength_nm : array_like, shape (n_wl,)
            Wavelengths to solve, between those of the description by interpolation. [nm]
        allow_paths : sequence of str or path
            Folders below which tables of the description may lie, besides its own.
        options
            The other arguments of `AtmosphereSky`: `sun_zenith_deg` and so on.

        Raises
        ------
        InputFileError
            Everything that is wrong with the description and its files.
        """
        description = read_atmo(os.fspath(path), allow_paths=[os.fspath(one) for one in allow_paths])
        medium, _ = read_medium(description, wavelength_nm)
        return cls(medium=medium, **options)

    @property
    def n_listed(self) -> int:
        """Orders that are kept one by one; the last one holds all later ones too."""
        return self.solved.n_listed

    @property
    def patch_error(self) -> np.ndarray:
        """Estimated error of the radiance of each patch, shape (n_wl, n_patch). [W m-2 sr-1 nm-1]"""
        order_one, later_orders = relative_errors(self.solved)
        later_error = later_orders * self.patch_mean[:, 1:].sum(axis=1)
        if self.solved.node_error is not None:
            zenith, azimuth = np.deg2rad(centres_deg(self.grid)).reshape(2, -1)
            later_error = self.solved.path_error(zenith, azimuth - math.radians(self.sun_azimuth_deg))
        sun_error = np.hypot((order_one + self.patch_change) * self.patch_mean.sum(axis=1), later_error)
        if self.solved.glow is None:
            return sun_error
        return np.hypot(sun_error, self.solved.glow_error * self._glow_means())

    def _glow_means(self) -> np.ndarray:
        """The part of `patch_mean` that a glowing ground gives, all orders together, shape (n_wl, n_patch)."""
        assert self.solved.glow is not None
        return np.repeat(glow_means(self.solved.glow, self.grid).sum(axis=1), self.grid.n_azimuth, axis=1)

    @property
    def diffuse_irradiance(self) -> np.ndarray:
        """Irradiance of the sky on the horizontal ground: that of the patches, shape (n_wl,). [W m-2 nm-1]"""
        return self.patch_mean.sum(axis=1) @ self.grid.projected_solid_angle_sr

    @property
    def direct_irradiance(self) -> np.ndarray:
        """Irradiance of the direct beam on the horizontal ground, shape (n_wl,). [W m-2 nm-1]"""
        return self.solved.direct_irradiance

    def radiance(self, sky_zenith_rad: ArrayLike, sky_azimuth_rad: ArrayLike, wavelength_nm: ArrayLike) -> np.ndarray:
        """Radiance of the sky without the direct beam, of the nearest wavelength that is solved. [W m-2 sr-1 nm-1]"""
        zenith, azimuth, wavelength = broadcast(sky_zenith_rad, sky_azimuth_rad, wavelength_nm)
        azimuth = azimuth - math.radians(self.sun_azimuth_deg)
        rows = nearest_wavelength_index(wavelength.ravel(), self.medium.wavelength_nm)
        radiance = np.zeros(zenith.size)
        for row in np.unique(rows):
            here = rows == row
            radiance[here] = self.solved.at(zenith.ravel()[here], azimuth.ravel()[here])[row]
        return radiance.reshape(zenith.shape)

    def notes(self, wavelength_nm: ArrayLike) -> tuple[str, ...]:
        """What the description of the medium says in words."""
        return tuple(f"atmosphere: {text}" for text in self.medium.texts)

    def lower(self, wavelength_nm: ArrayLike) -> tuple[Component, ...]:
        """One component of patches whose masses are irradiances; a wavelength gets the nearest one that is solved.

        Law CELL_MU2, strength in W m-2 nm-1. The irradiance of the photons is that of the patches exactly.
        """
        rows = nearest_wavelength_index(wavelength_nm, self.medium.wavelength_nm)
        mass = self.patch_mean.sum(axis=1)[rows] * self.grid.projected_solid_angle_sr
        component = Component(
            name="atmosphere",
            law=Law.CELL_MU2,
            strength=mass.sum(axis=1),
            mass=mass,
            cell=cells_of_grid(self.grid),
            grid=self.grid,
            irradiance_W_m2_nm=mass.sum(axis=1),
        )
        components = polarised(self, (component,), wavelength_nm)
        if self.polarisation is not None and self.solved.glow is not None:
            whole = self.patch_mean.sum(axis=1)[rows]
            ground_share = np.divide(self._glow_means()[rows], whole, out=np.ones_like(whole), where=whole > 0)
            sun_share = (1.0 - ground_share)[..., None]
            components = tuple(dataclasses.replace(one, stokes=one.stokes * sun_share) for one in components)
        return with_share(self, components)

    def beam(self, wavelength_nm: ArrayLike) -> tuple[Component, ...]:
        """The direct beam in W m-2 nm-1 at the nearest wavelengths that are solved; nothing where the sun is down.

        A disc of uniform radiance with the radius of the medium's sun, or one direction where that is 0.
        """
        rows = nearest_wavelength_index(wavelength_nm, self.medium.wavelength_nm)
        strength = self.direct_irradiance[rows]
        if not np.any(strength > 0):
            return ()
        radius = math.degrees(self.medium.sun_angular_radius_rad) if self.disc else 0.0
        light = DirectBeam(
            sun_zenith_deg=self.sun_zenith_deg,
            sun_azimuth_deg=self.sun_azimuth_deg,
            radius_deg=radius,
            irradiance_W_m2_nm=strength,
        )
        return light.lower(wavelength_nm)
