"""The Perez sky as a sky model: limits, warnings, radiance, patch masses."""

from __future__ import annotations

import math
import warnings
from dataclasses import InitVar, dataclass, field
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.component import Component, Law, cells_of_grid
from aomc_sky.directions import in_both_units, settle_angles, sin_cos_deg
from aomc_sky.errors import ModelLimitWarning, SceneError, UsageError, floats, number, require_kind, require_one_of
from aomc_sky.formats.sky_toml.keys import GHI_ALONE
from aomc_sky.grid import PatchGrid
from aomc_sky.options import MODEL
from aomc_sky.skies.model import Share, check_share, polarised, sky_repr, with_share
from aomc_sky.skies.perez import functions as perez
from aomc_sky.skies.perez.bounds import patch_bounds
from aomc_sky.skies.perez.coefficients import AirMassWord, LimitsWord, beam_ratio
from aomc_sky.skies.perez.irradiances import (
    EXTRATERRESTRIAL_NORMAL,
    closed_irradiances,
    dhi_exceeds_ghi,
    kilowatts,
    single_irradiance,
)
from aomc_sky.skies.perez.patches import patch_integrals
from aomc_sky.skies.quadrature import quarter_turns

if TYPE_CHECKING:
    from aomc_sky.skies.polarisation import RayleighPattern

WithinWord = Literal["exact", "uniform"]
_N_MU, _N_AZIMUTH, _N_GAMMA = 200, 181, 2001
_LARGEST = 1e200
_STEEPEST = -200.0  # d of a narrower aureole: integrals lose their stated digits, and most trials of a photon fail
_HALF_PI = np.pi / 2


@in_both_units
@dataclass(frozen=True, kw_only=True, slots=True)
class PerezSky(Share):
    """All-weather sky of Perez, Seals and Michalsky (1993), broadband.

    Give exactly one of (epsilon, delta), two of dni, dhi and ghi, or the coefficients. The luminance is f of eq. (1)
    with b <- min(b, 0), and 0 where f is negative; both are reported with a `ModelLimitWarning`.

    Parameters
    ----------
    sun_zenith_rad, or sun_zenith_deg : float
        Zenith angle of the sun. [rad, 0 to below pi/2]
    sun_azimuth_rad, or sun_azimuth_deg : float
        Azimuth of the sun, from +x towards +y like the grid; by default 0. [rad]
    epsilon, delta : float, optional
        Sky clearness and brightness, eqs. (4) and (5).
    dni, dhi : float, optional
        Direct normal and diffuse horizontal irradiance; the radiance is then absolute. [W m-2]
        With dhi = 0 the sky has no diffuse part: no radiance and no component.
    ghi : float, optional
        Global horizontal irradiance instead of one of them, ghi = dhi + dni cos Z; the attributes dni and dhi then
        have both. Beside both it is only checked, to 8 % (15 % beyond Z = 75 degrees). [W m-2]
    coefficients : array_like, shape (5,), optional
        a, b, c, d, e of eq. (1). [d >= -200]
    limits : {"radiance", "paper"}
        See `aomc_sky.perez.limited`.
    strict : bool
        Raise a `SceneError` where otherwise a warning reports what was limited.
    extraterrestrial_normal : float
        Irradiance on a plane that faces the sun outside the atmosphere. [W m-2]
    air_mass : {"kasten-young-1989", "kasten-1966"}
        Formula of the air mass in Delta.
    grid : PatchGrid, optional
        Patches for sampling; 45 x 180 by default.
    within : {"exact", "uniform"}
        Whether photons follow f inside a patch, or lie uniformly in mu^2 and azimuth.
    polarisation : RayleighPattern, optional
        Linear polarisation of the light; without it photons carry none.
    strength, irradiance_W_m2_nm : array_like, optional
        Share of the light in a scene of several models, as for `UniformSky`. [>= 0]

    Raises
    ------
    SceneError
        The sun is not above the horizon, an input is outside its range, irradiances contradict each other or what
        the sun gives outside the atmosphere, or no part of the sky shines.
    UsageError
        Not exactly one set of inputs is given, or a choice is unknown.

    Examples
    --------
    >>> model = sky.PerezSky(
    ...     sun_zenith_deg=40.0, sun_azimuth_deg=180.0, dni=850.0, dhi=95.0
    ... )
    >>> print(f"{model.clearness:.2f}")
    7.61
    >>> scene = sky.Scene(wavebands=[550.0], n_photons=1000, components=model)
    >>> scene.source().total
    1000
    """

    sun_zenith_rad: float = None  # type: ignore[assignment]
    sun_azimuth_rad: float = None  # type: ignore[assignment]
    epsilon: float | None = None
    delta: float | None = None
    dni: float | None = None
    dhi: float | None = None
    ghi: float | None = None
    coefficients: ArrayLike | None = None
    limits: LimitsWord = "radiance"
    strict: bool = False
    extraterrestrial_normal: float = EXTRATERRESTRIAL_NORMAL
    air_mass: AirMassWord = "kasten-young-1989"
    grid: PatchGrid | None = None
    within: WithinWord = "exact"
    polarisation: RayleighPattern | None = None
    sun_zenith_deg: InitVar[float | None] = None
    sun_azimuth_deg: InitVar[float | None] = None
    _input: tuple[float, float] | None = field(init=False, repr=False, compare=False, default=None)
    _used: np.ndarray = field(init=False, repr=False, compare=False)
    _integral: float = field(init=False, repr=False, compare=False, default=math.nan)

    __repr__ = sky_repr

    def __post_init__(self, sun_zenith_deg: float | None, sun_azimuth_deg: float | None) -> None:
        check_share(self)
        settle_angles(self, sun_zenith_rad=sun_zenith_deg)
        settle_angles(self, default=0.0, sun_azimuth_rad=sun_azimuth_deg)
        if not 0 <= self.sun_zenith_rad < _HALF_PI or not math.isfinite(self.sun_azimuth_rad):
            raise SceneError(
                f"the sun must be above the horizon, at a zenith angle from 0 to below pi/2 rad; got "
                f"{self.sun_zenith_rad:g} and the azimuth {self.sun_azimuth_rad:g}"
            )
        require_one_of(MODEL["within"].words, self.within, "within")
        require_one_of(MODEL["air_mass"].words, self.air_mass, "air_mass")
        if self.grid is not None:
            require_kind(self.grid, PatchGrid, "grid=sky.PatchGrid.regular(45, 180)")
        self._close_irradiances()
        values = self._given_coefficients() if self.coefficients is not None else self._modelled_coefficients()
        if values[2] != 0 and values[3] < _STEEPEST:
            raise SceneError(
                f"the coefficient d must be {_STEEPEST:g} or more, got {values[3]:g} ({self._inputs()}): an aureole "
                "that narrow is not the sky's",
                "write c = 0 and add a beam, or limits 'radiance' for epsilon and Delta",
            )
        if values[1] > 0:
            self._warn(f"b = {values[1]:.4g} makes the horizon infinitely bright or dark and was set to 0")
            values[1] = 0.0
        values.flags.writeable = False
        object.__setattr__(self, "_used", values)
        if self.dhi is not None and self.dhi <= 0:
            self._warn("dhi is 0, so the sky has no diffuse part")
            return
        share = _share_below_zero(values, self.sun_zenith_rad)
        may_be_black = share > 0 or self.coefficients is not None  # such as a = -1 with b = 0
        if may_be_black and (share >= 1 or self.relative_integral <= 0):
            check = "dhi or Delta" if self.coefficients is None else "a to e"
            raise SceneError(
                f"the model's luminance is nowhere positive ({self._inputs()}): this sky is too dark for this sun",
                f"check {check}",
            )
        if share > 0:
            self._warn(f"the luminance is negative over {100 * share:.2g} % of the sky and counts as 0 there")

    def _inputs(self) -> str:
        if self._input is None:
            return "its irradiances" if self.coefficients is None else f"coefficients {self.coefficients}"
        return f"epsilon {self._input[0]:g}, Delta {self._input[1]:g}, limits {self.limits!r}"

    def _warn(self, text: str) -> None:
        message = f"Perez sky, {self._inputs()}: {text}"
        if self.strict:
            raise SceneError(f"{message} (an error because strict is set)")
        warnings.warn(message, ModelLimitWarning, stacklevel=4)

    def _close_irradiances(self) -> None:
        """Compute the one of ghi, dni and dhi that is missing; refuse irradiances that no sun can give."""
        for name in ("ghi", "dni", "dhi"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, single_irradiance(name, getattr(self, name)))
        if sum(value is not None for value in (self.ghi, self.dni, self.dhi)) < 2:
            return
        is_exceeded = dhi_exceeds_ghi(self.ghi, self.dni, self.dhi)
        closed = closed_irradiances(
            ghi=self.ghi,
            dni=self.dni,
            dhi=self.dhi,
            sun_zenith_deg=float(np.rad2deg(self.sun_zenith_rad)),
            extraterrestrial_normal=self.extraterrestrial_normal,
        )
        for name, value in zip(("dni", "dhi"), closed, strict=True):
            if getattr(self, name) is None:
                object.__setattr__(self, name, value)
        if is_exceeded:
            self._warn(is_exceeded)

    def _given_coefficients(self) -> np.ndarray:
        others = (self.epsilon, self.delta, self.dni, self.dhi, self.ghi)
        values = np.array(floats("coefficients", self.coefficients))
        if any(value is not None for value in others):
            raise UsageError("give one of (epsilon, delta), two of dni, dhi and ghi, or coefficients, not several")
        if values.shape != (5,):
            raise SceneError(f"coefficients must be the five numbers a, b, c, d, e, got shape {values.shape}")
        a, _, c, d, e = np.abs(values)
        with np.errstate(over="ignore", invalid="ignore"):
            largest = (1 + a) * (1 + c * np.exp(np.maximum(values[3], 0) * np.pi) + e)
        if not (np.all(np.isfinite(values)) and largest < _LARGEST and d < _LARGEST):
            raise SceneError(f"coefficients must be finite and give a finite luminance, got {values}")
        object.__setattr__(self, "coefficients", tuple(values.tolist()))  # compares and hashes
        return values

    def _modelled_coefficients(self) -> np.ndarray:
        by_weather = self.dni is not None and self.dhi is not None and self.epsilon is None and self.delta is None
        by_sky = self.epsilon is not None and self.delta is not None and self.dni is self.dhi is self.ghi is None
        if self.ghi is not None and not (by_weather or by_sky) and self.dni is self.dhi is self.epsilon is None:
            raise UsageError("ghi alone does not say how much of it is the beam", GHI_ALONE)
        if not (by_weather or by_sky):
            raise UsageError("give exactly one of (epsilon, delta), two of dni, dhi and ghi, or coefficients")
        if by_weather:
            assert self.dni is not None
            assert self.dhi is not None
            given = (self.dni if self.ghi is None else self.ghi, self.dhi)  # the third one was computed
            if text := kilowatts(given, math.degrees(self.sun_zenith_rad)):
                self._warn(text)
            epsilon = float(perez.sky_clearness(self.dni, self.dhi, self.sun_zenith_rad))
            delta = float(
                perez.sky_brightness(
                    self.dhi,
                    self.sun_zenith_rad,
                    extraterrestrial_normal=self.extraterrestrial_normal,
                    air_mass=self.air_mass,
                )
            )
        else:
            assert self.epsilon is not None
            assert self.delta is not None
            epsilon, delta = number("epsilon", self.epsilon), number("delta", self.delta)
        if not (epsilon >= 0 and math.isfinite(delta)):
            raise SceneError(f"epsilon must be 1 or more and Delta finite, got {epsilon:g} and {delta:g}")
        object.__setattr__(self, "_input", (epsilon, delta))
        used_epsilon, used_delta = (float(v) for v in perez.limited(epsilon, delta, limits=self.limits))
        if used_delta != delta and not (by_weather and delta == 0):
            self._warn(f"Delta was limited to {used_delta:g}")
        if epsilon < 1:
            self._warn("epsilon below 1 counts as 1")
        return perez.coefficients(used_epsilon, used_delta, self.sun_zenith_rad, limits="paper")

    @property
    def clearness(self) -> float | None:
        """Sky clearness epsilon before any limit, None where coefficients were given."""
        return None if self._input is None else self._input[0]

    @property
    def brightness(self) -> float | None:
        """Sky brightness Delta before any limit, None where coefficients were given."""
        return None if self._input is None else self._input[1]

    @property
    def model_coefficients(self) -> np.ndarray:
        """a, b, c, d, e as used, after all limits, shape (5,)."""
        return self._used

    @property
    def is_dark(self) -> bool:
        """Whether dhi is 0, so that nothing shines but the sun."""
        return self.dhi is not None and self.dhi <= 0

    @property
    def beam_share(self) -> float | None:
        """Share of the sun's beam in the light on a horizontal plane, or None with coefficients alone. [0 to 1]"""
        if self.epsilon is not None:
            beam = max(beam_ratio(self.epsilon, self.sun_zenith_rad), 0.0) * math.cos(self.sun_zenith_rad)
            return beam / (beam + 1.0)
        if self.dni is None or self.dhi is None:
            return None
        beam, diffuse = max(self.dni, 0.0) * math.cos(self.sun_zenith_rad), max(self.dhi, 0.0)
        return beam / (beam + diffuse) if beam > 0 else 0.0

    def missing_beam(self) -> str:
        """Sentence for a scene of this sky without a beam, with what to write; empty where no beam is known of."""
        share = self.beam_share
        if not share:
            return ""
        zenith, azimuth = np.rad2deg([self.sun_zenith_rad, self.sun_azimuth_rad])
        advice = (
            f"give this sky strength={1 - share:.4g} and add "
            f"sky.DirectBeam(sun_zenith_deg={zenith:.6g}, sun_azimuth_deg={azimuth:.6g}, strength={share:.4g})"
        )
        return f"the direct beam of the sun, {float(f'{100 * share:.2g}'):g} % of the light, is missing; {advice}"

    @property
    def patches(self) -> PatchGrid:
        """The patches for sampling."""
        return PatchGrid.regular(45, 180) if self.grid is None else self.grid

    @property
    def relative_integral(self) -> float:
        """Integral of max(f, 0) cos xi over the hemisphere. [sr]"""
        if math.isnan(self._integral):
            object.__setattr__(self, "_integral", self._integrals(PatchGrid.regular(6, 12))[1])
        return self._integral

    def radiance(self, sky_zenith_rad: ArrayLike, sky_azimuth_rad: ArrayLike, wavelength_nm: ArrayLike) -> np.ndarray:
        """Radiance of a sky element, the same at all wavelengths; 0 below the horizon.

        In W m-2 sr-1 where dhi is known, so that the sky's irradiance is dhi; else relative, f itself.
        """
        zenith = floats("sky_zenith_rad", sky_zenith_rad)
        azimuth = floats("sky_azimuth_rad", sky_azimuth_rad) - self.sun_azimuth_rad
        shape = np.broadcast_shapes(zenith.shape, azimuth.shape, floats("wavelength_nm", wavelength_nm).shape)
        if self.is_dark:
            return np.zeros(shape)
        if np.any(np.isinf(zenith)):
            raise SceneError("the zenith angle of a sky element must be finite")
        is_up = ~((zenith < 0) | (zenith > _HALF_PI))  # NaN stays NaN
        value = perez.relative_radiance(np.where(is_up, zenith, 0.0), azimuth, self.sun_zenith_rad, self._used)
        scale = 1.0 if self.dhi is None else self.dhi / self.relative_integral
        return np.broadcast_to(np.where(is_up, np.maximum(value, 0.0) * scale, 0.0), shape).copy()

    def patch_mass(self, grid: PatchGrid) -> np.ndarray:
        """Share of the photons through a horizontal surface that comes from each patch, shape (n_patch,).

        The integral of max(f, 0) cos xi over the patch, divided by that over the hemisphere: masses of a grid of the
        whole hemisphere sum to 1. SceneError: the grid has points or lines, or dhi is 0. Accuracy: 1e-10 of the patch,
        1e-8 if it is wider than 10 degrees, and 1e-15 of the sky.
        Cost: 20 ms for 45 x 180 patches, 60 ms for 90 x 360, two to four times that where the luminance is negative
        somewhere.
        """
        require_kind(grid, PatchGrid, "sky.PatchGrid.regular(45, 180)")
        if self.is_dark:
            raise SceneError("dhi is 0, so the sky has no diffuse part to share over patches")
        if not all(np.any(bounds[:, 0] < bounds[:, 1]) for bounds in (grid.zenith_bounds_deg, grid.azimuth_bounds_deg)):
            raise SceneError("the grid has points or lines; the Perez sky needs patches with an area")
        mass, total = self._integrals(grid)
        rings, columns = grid.zenith_bounds_deg, grid.azimuth_bounds_deg
        ends = (rings[0, 0], rings[-1, 1] - 90.0, columns[-1, 1] - columns[0, 0] - 360.0)
        steps = (rings[1:, 0] - rings[:-1, 1], columns[1:, 0] - columns[:-1, 1], np.array(ends))
        is_whole_sky = np.abs(np.concatenate(steps)).max() <= 1e-9  # without gaps
        return mass / (total if is_whole_sky else self.relative_integral)

    def lower(self, wavelength_nm: ArrayLike) -> tuple[Component, ...]:
        """One component named "perez", one row of masses for all wavelengths, of strength 1; none where dhi is 0."""
        if self.is_dark:
            return ()
        grid, is_exact = self.patches, self.within == "exact"
        component = Component(
            name="perez",
            law=Law.PEREZ if is_exact else Law.CELL_MU2,
            strength=np.ones(np.size(wavelength_nm)),
            mass=self.patch_mass(grid)[None, :],
            cell=cells_of_grid(grid),
            grid=grid,
            shared=self._numbers() if is_exact else None,
            bounds=patch_bounds(*quarter_turns(grid), self._numbers()).reshape(-1, 4) if is_exact else None,
        )
        return with_share(self, polarised(self, (component,), wavelength_nm))

    def _numbers(self) -> np.ndarray:
        """The sky as the kernels read it: see `Component.shared`."""
        sun_deg, azimuth_deg = np.rad2deg(self.sun_zenith_rad), np.rad2deg(self.sun_azimuth_rad)
        (sine, east), (cosine, north) = sin_cos_deg(np.array([sun_deg, azimuth_deg]))
        angles = (sun_deg / 90.0, np.mod(azimuth_deg, 360.0) / 90.0, sine)
        return np.array([*self._used, *angles, sine * north, sine * east, cosine])

    def _integrals(self, grid: PatchGrid) -> tuple[np.ndarray, float]:
        """Integral of max(f, 0) cos xi over each patch, shape (n_patch,), and their sum. [sr]"""
        mass = patch_integrals(*quarter_turns(grid), self._numbers())
        rings = np.cumsum(mass, axis=1)[:, -1]  # numpy's own sum may differ between processors
        return mass.ravel(), math.fsum(rings.tolist())


def _share_below_zero(coefficients: np.ndarray, sun_zenith_rad: float) -> float:
    """Share of the hemisphere's solid angle where f of eq. (1) is negative, b <= 0.

    Exactly 0 where neither factor can be negative; else counted on 36 000 directions.
    """
    a, b, c, d, e = coefficients.tolist()
    is_lit = 1 + a * math.exp(b) >= 0
    if is_lit and c >= 0 and e > -1:
        return 0.0
    gamma = np.linspace(0, np.pi, _N_GAMMA)
    second = 1 + c * np.exp(np.clip(d * gamma, -700, 700)) + e * np.cos(gamma) ** 2
    if is_lit and second.min() >= 0:
        return 0.0
    mu = (np.arange(_N_MU) + 0.5) / _N_MU
    azimuth = (np.arange(_N_AZIMUTH) + 0.5) * (np.pi / _N_AZIMUTH)
    value = perez.relative_radiance(np.arccos(mu)[:, None], azimuth, sun_zenith_rad, coefficients)
    return max(float(np.mean(value < 0)), 1e-5)
