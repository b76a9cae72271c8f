"""A sky given as a table of values over patches and wavelengths, and the weights the AOMC 1.2.2 program gives them."""

from __future__ import annotations

import dataclasses
import enum
import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.component import MAX_SLOPE, Component, Law, cells_of_grid, slope_factor
from aomc_sky.directions import AzimuthConvention, one_angle
from aomc_sky.errors import InputWarning, SceneError, UsageError, floats, member_of, require_kind
from aomc_sky.formats.azimuth import AzimuthWord
from aomc_sky.formats.radiance_words import AngleUnitWord, Stated, WavelengthUnitWord
from aomc_sky.grid import PatchGrid
from aomc_sky.record import same_content, short_repr
from aomc_sky.skies.model import Share, broadcast, check_share, has_share, with_share
from aomc_sky.wavebands import midpoint_wavelength_index, nearest_wavelength_index
from aomc_sky.whole_number import as_index

_PI = np.float32(3.14159265)
_RING = np.float32(0.01745329)
_FIRST_AND_LAST_RING = np.float32(0.0261799)
_HORIZON = 90
_ROUNDED = 1e-6  # a degree of polarisation in float32 may be so much above 1
_LEAST_NM = 20.0  # smaller wavelengths are those of light in micrometres
_ROUNDED_NM = 1e-3  # metres in float32 are off by less
_FAR_NM = 5.0  # farther from a wavelength the light of the sky may be several percent off

# The program takes sine and cosine from its Fortran library, which is within 0.51 ulp but not correctly
# rounded. Whole degrees where it differs from the rounded float64 value, in units of the last place:
# measured with gfortran 12.2 and glibc 2.36; a test measures them again.
_SINE_ULP = {7: 1, 13: 1, 19: 1, 26: -1}
_COSINE_ULP = {49: 1, 74: 1}


WeightingWord = Literal["listed", "projected", "solid-angle", "aomc"]


class Weighting(enum.Enum):
    """The meaning of the listed values; it decides how many photons a patch gets.

    LISTED
        Masses: the value over the sum of the values.
    PROJECTED
        Radiances: mass = value x projected solid angle (photons that cross the sea surface).
    SOLID_ANGLE
        Radiances, without the cosine: mass = value x solid angle.
    AOMC
        The AOMC 1.2.2 program's float32 weights of whole-degree lattice points.

    Examples
    --------
    >>> scene = sky.read_scene("inputs/sparse_sky", weighting=sky.Weighting.PROJECTED.value)
    >>> scene.options["weighting"]
    'projected'
    """

    LISTED = "listed"
    PROJECTED = "projected"
    SOLID_ANGLE = "solid-angle"
    AOMC = "aomc"


@dataclass(eq=False, frozen=True, kw_only=True, slots=True)
class TabulatedSky(Share):
    """Values over the patches of a grid, one set per wavelength.

    Parameters
    ----------
    wavelength_nm : array_like, float64, shape (n_table,)
        Wavelengths of the table, any order. [nm]
    values : array_like, float64, shape (n_table, n_patch) or (n_table, n_zenith, n_azimuth)
        Listed values, patches zenith-major. [0 to inf, relative]
    grid : PatchGrid
        The patches.
    weighting : Weighting, or {"listed", "projected", "solid-angle", "aomc"}
        What the values mean.
    midpoint_rule : bool
        Take the AOMC program's rule for a band's wavelength instead of the nearest one.
    slope : ndarray, float64, shape (n_table, n_patch, 2), optional
        How the radiance changes inside each patch, as in `Component`; without it the radiance there is constant. Only
        for `Weighting.PROJECTED`.
    values_q, values_u : ndarray, float64, shape of values, optional
        Stokes parameters Q and U of each patch in the unit of the values, its means in the meridian plane of the light:
        Q > 0 for an electric vector in this plane, U > 0 for one that is turned from it by 45 degrees,
        counter-clockwise as one looks up at it. Both or none; docs/conventions.md has the picture. [sqrt(Q^2 + U^2) at
        most the value]
    remarks : tuple of str
        Notes of a scene of this table.
    radiance_unit : float
        One unit of the values in W m-2 nm-1 sr-1, so that a scene of them has irradiances in W m-2 nm-1; 0 for relative
        values. Only for `Weighting.PROJECTED`.
    has_wavelength : bool
        False: the sky is the same at all wavelengths, and `wavelength_nm` holds one of them. Else a scene warns of
        wavebands outside the wavelengths.
    strength, irradiance_W_m2_nm : array_like, optional
        Share of the light in a scene of several models, as for `UniformSky`. [>= 0]

    Examples
    --------
    >>> grid = sky.PatchGrid(
    ...     zenith_bounds_deg=[[0.0, 45.0], [45.0, 90.0]], azimuth_bounds_deg=[[0.0, 360.0]]
    ... )
    >>> model = sky.TabulatedSky(
    ...     wavelength_nm=[550.0],
    ...     values=[[1.0, 3.0]],
    ...     grid=grid,
    ...     weighting=sky.Weighting.LISTED,
    ... )
    >>> sky.Scene(wavebands=[550.0], n_photons=1000, components=model).source().counts
    array([[250, 750]])
    """

    wavelength_nm: np.ndarray
    values: np.ndarray
    grid: PatchGrid
    weighting: Weighting = Weighting.LISTED
    midpoint_rule: bool = False
    slope: np.ndarray | None = None
    values_q: np.ndarray | None = None
    values_u: np.ndarray | None = None
    remarks: tuple[str, ...] = ()
    radiance_unit: float = 0.0
    has_wavelength: bool = True

    if TYPE_CHECKING:  # what may be given; the fields above are what it becomes

        def __init__(
            self,
            *,
            strength: ArrayLike | None = None,
            irradiance_W_m2_nm: ArrayLike | None = None,
            wavelength_nm: ArrayLike,
            values: ArrayLike,
            grid: PatchGrid,
            weighting: Weighting | WeightingWord = Weighting.LISTED,
            midpoint_rule: bool = False,
            slope: ArrayLike | None = None,
            values_q: ArrayLike | None = None,
            values_u: ArrayLike | None = None,
            remarks: tuple[str, ...] = (),
            radiance_unit: float = 0.0,
            has_wavelength: bool = True,
        ) -> None: ...

    __eq__ = same_content
    __repr__ = short_repr

    def __post_init__(self) -> None:
        check_share(self)
        require_kind(self.grid, PatchGrid, "grid=sky.PatchGrid.regular(45, 180)")
        object.__setattr__(self, "weighting", member_of(Weighting, self.weighting, "weighting"))
        if np.ma.is_masked(self.values):
            raise SceneError("the values of a sky are masked", "give them a radiance, 0 where no light comes from")
        wavelength = np.atleast_1d(floats("wavelength_nm", self.wavelength_nm))
        values = floats("values", self.values)
        if values.ndim == 1 or values.shape[0] != wavelength.size:
            raise ValueError(f"values need a first axis of {wavelength.size} wavelengths, got shape {values.shape}")
        shape = (self.grid.n_zenith, self.grid.n_azimuth)
        if values.ndim == 3 and values.shape[1:] != shape:
            raise SceneError(
                f"values of shape {values.shape} do not fit a grid of {shape[0]} rings and {shape[1]} columns: the "
                "axes are wavelength, zenith, azimuth" + ("; swap the last two" if values.shape[:0:-1] == shape else "")
            )
        values = values.reshape(wavelength.size, -1)
        if values.shape[1] != self.grid.n_patches:
            raise ValueError(f"values hold {values.shape[1]} patches, the grid has {self.grid.n_patches}")
        if not np.all(np.isfinite(values)) or np.any(values < 0) or not np.all(np.isfinite(wavelength)):
            raise SceneError("the values of a sky must be finite and not negative, its wavelengths finite")
        _, first, row = np.unique(wavelength, return_index=True, return_inverse=True)
        is_again = first[row] != np.arange(row.size)
        differing = wavelength[is_again][np.any(values[is_again] != values[first[row[is_again]]], axis=1)]
        if differing.size and not self.midpoint_rule:
            raise SceneError(
                f"the wavelength {differing[0]:g} nm stands in it twice with different values",
                "give each wavelength one row",
            )
        slope = None if self.slope is None else floats("slope", self.slope)
        if slope is not None and self.weighting is not Weighting.PROJECTED:
            raise ValueError("slope wants weighting PROJECTED; with another weighting, set slope to None")
        if self.radiance_unit and self.weighting is not Weighting.PROJECTED:
            raise ValueError("radiance_unit wants weighting PROJECTED; with another weighting, set it to 0")
        if slope is not None and (slope.shape != (*values.shape, 2) or not np.all(np.abs(slope) <= MAX_SLOPE)):
            raise ValueError(
                f"slope wants the shape {(*values.shape, 2)} and values from {-MAX_SLOPE:g} to {MAX_SLOPE:g}, got the "
                f"shape {slope.shape}"
            )
        if slope is not None and not np.all(self.grid.solid_angle_sr > 0):
            raise ValueError("slope wants patches with an extent; this grid has points")
        arrays = {"wavelength_nm": wavelength, "values": values, "slope": slope, **self._checked_stokes(values)}
        for name, array in arrays.items():
            if array is None:
                continue
            frozen = np.ascontiguousarray(array)
            frozen.flags.writeable = False
            object.__setattr__(self, name, frozen)

    def _checked_stokes(self, values: np.ndarray) -> dict[str, np.ndarray]:
        """Q and U in the shape of the values, if they are given; no degree is above 1."""
        if (self.values_q is None) != (self.values_u is None):
            raise UsageError("values_q and values_u belong together: give both, or none")
        if self.values_q is None:
            return {}
        given = {name: floats(name, getattr(self, name)) for name in ("values_q", "values_u")}
        for name, array in given.items():
            if array.size != values.size or len(array) != len(values):
                raise ValueError(f"{name} wants the shape of values, {np.shape(self.values)}, got {array.shape}")
            given[name] = array.reshape(values.shape)
        if not np.all(np.hypot(*given.values()) <= values * (1.0 + _ROUNDED)):
            raise SceneError("a patch has more polarised light, sqrt(Q^2 + U^2), than light; Q and U have its unit")
        return given

    @classmethod
    def from_xarray(
        cls,
        field: Any,
        *,
        variable: str | None = None,
        variable_q: str | None = None,
        variable_u: str | None = None,
        stokes_signs: tuple[float, float] | None = None,
        zenith: str | None = None,
        elevation: str | None = None,
        azimuth: str | None = None,
        wavelength: str | None = None,
        angle_unit: AngleUnitWord | None = None,
        azimuth_convention: AzimuthConvention | AzimuthWord | None = None,
        wavelength_unit: WavelengthUnitWord | None = None,
        radiance_unit: str | None = None,
        grid: PatchGrid | None = None,
        sun_zenith_deg: float | None = None,
        sun_azimuth_deg: float | None = None,
        sun_zenith_rad: float | None = None,
        sun_azimuth_rad: float | None = None,
    ) -> TabulatedSky:
        """Radiance with coordinates, as programs and instruments give it.

        Parameters
        ----------
        field : xarray.DataArray or xarray.Dataset
            Radiance over directions that light comes from, dimensions in any order. NaN is a gap, and so are fill
            values that the field declares and values outside ``valid_range``. Only a Dataset has the bounds of its
            patches. Its texts change nothing: `remarks` quote them.
        variable : str, optional
            The radiance of a Dataset, by default ``radiance``, or the only variable over the directions.
        variable_q, variable_u : str, optional
            Stokes parameters Q and U of a Dataset, by default ``radiance_q`` and ``radiance_u``, or a dimension
            ``stokes`` with I, Q and U, as sasktran2 has it. Photons then carry q and u. With `variable` alone, Q and U
            in variables beside it are not read.
        stokes_signs : tuple of two numbers, optional
            Factors of Q and U that bring them to the signs of docs/conventions.md, where those of other codes are
            listed. [1 or -1]
        zenith, elevation, azimuth, wavelength : str, optional
            Names of the coordinates, where they have other names than these. Both angles along the same dimensions are
            scattered directions, with wavelengths along a dimension of their own, or one for each point; negative
            zenith angles lie beyond the zenith, and directions of NaN are left out. Without azimuth the sky is the same
            all around.
        angle_unit : {"deg", "rad"}, optional
            Unit of both angles; by default that of the attribute ``units``, or of names such as ``zenith_deg``.
        azimuth_convention : AzimuthConvention or str, optional
            From where azimuth counts and which way: a member, or words such as "clockwise from north". By default the
            attribute ``azimuth_convention`` of the coordinate or of the file, or what CF says of it.
        wavelength_unit : {"nm", "um", "m", "angstrom"}, optional
            By default that of the attribute ``units``, or of names such as ``wavelength_nm``.
        radiance_unit : str, optional
            Such as "mW m-2 nm-1 sr-1", or "relative"; by default the attribute ``units`` of the radiance. With a unit
            irradiances are in W m-2 nm-1.
        grid : PatchGrid, optional
            Patches for scattered directions and fields with gaps; 90 x 180, or those of the field.
        sun_zenith_deg, sun_azimuth_deg, or sun_zenith_rad, sun_azimuth_rad : float, optional
            Where the sun is, by default ``sun_zenith_deg`` and ``sun_azimuth_deg`` of the field, whose azimuth counts
            as the others. Azimuths from the sun need it; scattered directions and gaps are interpolated around it; and
            light that is not where the sun is gets a warning.

        Returns
        -------
        TabulatedSky
            Weighting `Weighting.PROJECTED`. The bounds of a Dataset (CF attribute ``bounds`` of an angle) are the edges
            of patches, and the values their means. Otherwise patches end half-way between zenith angles and between
            azimuths, cut at 0 and 90 degrees, and the values are radiances in these directions. A monotone cubic
            (PCHIP) joins them, in azimuth around the turn and in zenith angle across the zenith; beyond the last zenith
            angle it goes on linearly, not below 0. Patches hold its means and slopes. Angles within 0.003 degrees of a
            multiple of 90 degrees are there. Scattered directions and gaps are interpolated as those of a
            `RadianceField`, with a warning above 5 % of light from beyond them; Q and U want a grid without gaps.
            `remarks` name gaps, errors and what was taken for granted.

        Raises
        ------
        SceneError
            A coordinate is missing, ambiguous, without a unit, or a value is negative.
        UsageError
            An argument is of no use.
        """
        from aomc_sky.skies.field import read_field
        from aomc_sky.skies.field_choice import choose

        stated = Stated(
            variable=variable,
            variable_q=variable_q,
            variable_u=variable_u,
            stokes_signs=stokes_signs,
            zenith=zenith,
            elevation=elevation,
            azimuth=azimuth,
            wavelength=wavelength,
            angle_unit=angle_unit,
            azimuth_convention=azimuth_convention,
            wavelength_unit=wavelength_unit,
            radiance_unit=radiance_unit,
        )
        sun = (
            one_angle("sun_zenith_deg", sun_zenith_deg, sun_zenith_rad),
            one_angle("sun_azimuth_deg", sun_azimuth_deg, sun_azimuth_rad),
        )
        chosen = choose(field, stated)
        if chosen.stokes is None and stokes_signs is not None:
            raise UsageError("stokes_signs are for a field of Q and U, and this one is read without")
        read, _ = read_field(chosen, stated, grid=grid, sun=sun)
        return cls(weighting=Weighting.PROJECTED, **read)

    def table_index(self, wavelength_nm: ArrayLike) -> np.ndarray:
        """Index of the table wavelength that serves each wavelength, shape (n_wl,)."""
        rule = midpoint_wavelength_index if self.midpoint_rule else nearest_wavelength_index
        return rule(wavelength_nm, self.wavelength_nm)

    def table_wavelength_nm(self, wavelength_nm: ArrayLike) -> np.ndarray:
        """Wavelength of the set that serves each wavelength, NaN if the sets have none, shape (n_wl,). [nm]"""
        return np.where(self.has_wavelength, self.wavelength_nm[self.table_index(wavelength_nm)], np.nan)

    def radiance(self, sky_zenith_rad: ArrayLike, sky_azimuth_rad: ArrayLike, wavelength_nm: ArrayLike) -> np.ndarray:
        """Relative radiance of directions, 0 outside all patches; constant in a patch without `slope`.

        The table's rule chooses the set for a wavelength; listed masses are divided by their projected solid angle.
        """
        zenith, azimuth, wavelength = broadcast(sky_zenith_rad, sky_azimuth_rad, wavelength_nm)
        azimuth_deg = np.rad2deg(azimuth)
        patch = self.grid.patch_of(np.rad2deg(zenith), azimuth_deg)
        row = self.table_index(wavelength.ravel()).reshape(wavelength.shape)
        value = self.values[row, np.maximum(patch, 0)]
        if self.slope is not None:
            slope = self.slope[row, np.maximum(patch, 0)]
            value = value * slope_factor(slope, self.grid, self.grid.ring_sin2(), patch, zenith, azimuth_deg)
        if self.weighting is Weighting.LISTED:
            area = self.grid.projected_solid_angle_sr[np.maximum(patch, 0)]
            value = np.divide(value, area, out=np.zeros_like(value), where=area > 0)
        return np.where(patch >= 0, value, 0.0)

    def notes(self, wavelength_nm: ArrayLike) -> tuple[str, ...]:
        """Notes of a scene of this table: `remarks`, and how far wavebands are from the wavelengths they take."""
        bands, known = np.atleast_1d(floats("wavelength_nm", wavelength_nm)), self.wavelength_nm
        taken = known[self.table_index(bands)]
        away = np.where((bands >= known.min()) & (bands <= known.max()), np.abs(bands - taken), 0.0)
        if not np.any(away > _FAR_NM):
            return self.remarks  # those outside are warned of
        k = int(away.argmax())
        note = (
            f"{np.sum(away > _FAR_NM)} of {bands.size} wavebands lie more than {_FAR_NM:g} nm from the wavelengths of "
            f"the table, which is not interpolated: {bands[k]:g} nm has the light of {taken[k]:g} nm"
        )
        return (*self.remarks, note)

    def mass(self, row: int) -> np.ndarray:
        """Masses of one set of the table under its weighting, shape (n_patch,), any scale."""
        values = self.values[as_index(row, "row")]
        if self.weighting is Weighting.LISTED:
            return values
        if self.weighting is Weighting.AOMC:
            shape = (self.grid.n_zenith, self.grid.n_azimuth)
            return aomc_weight(values.reshape(shape)).astype(np.float64).ravel()
        area = self.grid.projected_solid_angle_sr if self.weighting is Weighting.PROJECTED else self.grid.solid_angle_sr
        peak = float(values.max())
        scaled = np.ldexp(values, -int(np.frexp(peak)[1])) if peak > 0 else values  # 5e-324 x area would vanish
        return scaled * area

    def lower(self, wavelength_nm: ArrayLike) -> tuple[Component, ...]:
        """One component of patches, a row of masses per wavelength asked for.

        Law CELL_MU2, CELL_SLOPED with `slope`, or CELL_MU for solid-angle weighting. The strength is 1 per wavelength,
        0 where a set holds no light; with `radiance_unit` it is the irradiance in W m-2 nm-1. Listed and solid-angle
        masses carry the weights that turn photons into flux, mean 1.
        """
        rows = self.table_index(wavelength_nm)
        self.warn_of_distance(wavelength_nm, rows)
        return self.lower_rows_in_unit(rows)

    def lower_rows_in_unit(self, rows: np.ndarray) -> tuple[Component, ...]:
        """As `lower_rows`, with the irradiance of each where the unit is known."""
        components, light = self.lower_rows(rows), self.irradiance_of_rows(rows)
        if light is None:
            return components
        return tuple(dataclasses.replace(one, strength=light, irradiance_W_m2_nm=light) for one in components)

    def irradiance_of_rows(self, rows: np.ndarray) -> np.ndarray | None:
        """Irradiance of these sets where the unit of the radiances is known, and no share is given. [W m-2 nm-1]"""
        if not self.radiance_unit or has_share(self):
            return None
        return np.asarray(np.sum(self.values[rows] * self.grid.projected_solid_angle_sr, axis=1) * self.radiance_unit)

    def warn_of_distance(self, wavelength_nm: ArrayLike, rows: np.ndarray, path: str = "") -> None:
        """Warn of wavebands outside the table's wavelengths (E310); `rows` serve them, `path` is the table's file."""
        bands, known = np.atleast_1d(floats("wavelength_nm", wavelength_nm)), self.wavelength_nm
        outside = (bands < known.min() - _ROUNDED_NM) | (bands > known.max() + _ROUNDED_NM)
        if not outside.any() or not self.has_wavelength:
            return
        distance = np.where(outside, np.abs(bands - known[rows]), 0.0)
        k = int(distance.argmax())
        span = f"wavelengths {known.min():g} to {known.max():g}" if known.size > 1 else f"wavelength {known[0]:g}"
        hint = "; are they micrometres? they count as nm" if known.max() < _LEAST_NM else ""
        warnings.warn(
            f"{path}{': ' * bool(path)}warning[E310]: {int(outside.sum())} of {bands.size} wavebands lie outside the "
            f"sky's {span} nm; waveband {k + 1} at {bands[k]:g} nm takes "
            f"{known[rows[k]]:g} nm, {distance[k]:g} nm away{hint}",
            InputWarning,
            stacklevel=5,
        )

    def lower_rows(self, rows: np.ndarray) -> tuple[Component, ...]:
        """As `lower`, a row of masses for each of these sets of the table."""
        sets = np.atleast_1d(rows)
        if not sets.size:
            raise UsageError("a sky is wanted at no wavelength")
        mass = np.stack([self.mass(row) for row in sets])
        law = Law.CELL_MU2 if self.slope is None else Law.CELL_SLOPED
        law = Law.CELL_MU if self.weighting is Weighting.SOLID_ANGLE else law
        stokes = None
        if self.values_q is not None and self.values_u is not None:
            both, values = np.stack([self.values_q[rows], self.values_u[rows]], axis=-1), self.values[rows][..., None]
            stokes = np.divide(both, values, out=np.zeros_like(both), where=values > 0)
            stokes /= np.maximum(np.hypot(stokes[..., :1], stokes[..., 1:]), 1.0)
        component = Component(
            name="sky",
            law=law,
            strength=(mass.max(axis=1) > 0).astype(np.float64),
            mass=mass,
            cell=cells_of_grid(self.grid, law),
            grid=self.grid,
            weight=self._weights(mass),
            slope=None if self.slope is None else self.slope[rows],
            stokes=stokes,
        )
        return with_share(self, (component,))

    def _weights(self, mass: np.ndarray) -> np.ndarray | None:
        if self.weighting is Weighting.LISTED:
            unscaled = np.broadcast_to(self.grid.projected_solid_angle_sr, mass.shape)
        elif self.weighting is Weighting.SOLID_ANGLE:
            near, far = self.grid.ring_mu()
            mean_mu = np.repeat((near + far) / 2, self.grid.n_azimuth)
            unscaled = np.ones(mass.shape)
        else:
            return None
        flux = unscaled * (mean_mu if self.weighting is Weighting.SOLID_ANGLE else 1.0)
        peak = mass.max(axis=1, keepdims=True)
        share = np.divide(mass, peak, out=np.zeros_like(mass), where=peak > 0)
        total = share.sum(axis=1, keepdims=True)
        mean = np.divide((share * flux).sum(axis=1, keepdims=True), total, out=np.ones_like(total), where=total > 0)
        return np.divide(unscaled, mean, out=np.zeros(mass.shape), where=mean > 0)


def _as_the_library(values: np.ndarray, index: np.ndarray, ulp: dict[int, int]) -> np.ndarray:
    words = values.astype(np.float32).view(np.int32)
    words += np.array([ulp.get(int(z), 0) for z in index], dtype=np.int32)
    return words.view(np.float32)


def sine_and_cosine(index: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sine and cosine of whole degrees as the program has them, float32, of its own angle index * 3.14159265 / 180.

    Degrees 1 to 90 agree with gfortran's library to the bit.
    """
    angle = ((index.astype(np.float32) * _PI) / np.float32(180)).astype(np.float64)
    return _as_the_library(np.sin(angle), index, _SINE_ULP), _as_the_library(np.cos(angle), index, _COSINE_ULP)


def aomc_weight(radiance: np.ndarray) -> np.ndarray:
    """Weight of each entry of a table, row k at zenith index k + 1: L sin z cos z and constants, z whole degrees.

    The program's float32 products in its order, ((((L sin) c1) c2) cos), c1 half as large again for rings 1 and 89. At
    90 degrees its cosine is -4e-8: its weights there round to no photon and vanish in its 32-bit sum, so they are 0.
    Beyond, where the cosine is negative, entries must be 0.
    """
    index = np.arange(1, radiance.shape[0] + 1)
    sine, cosine = sine_and_cosine(index)
    cosine = np.where(index == _HORIZON, np.float32(0), cosine)
    first = np.where((index == 1) | (index == 89), _FIRST_AND_LAST_RING, _RING)[:, None]
    with np.errstate(over="ignore", invalid="ignore"):  # a value beyond float32 is infinite, as in the program
        return (((radiance.astype(np.float32) * sine[:, None]) * first) * _RING) * cosine[:, None]
