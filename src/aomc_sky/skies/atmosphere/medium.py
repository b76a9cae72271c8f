"""The air as its solvers see it: constituents by altitude, cross sections and phase functions by wavelength."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import InitVar, dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.directions import in_both_units, settle_angles
from aomc_sky.errors import SceneError, UsageError, floats, require_kind, unmasked
from aomc_sky.record import same_content, short_repr
from aomc_sky.skies.atmosphere.language.block import Block


@dataclass(eq=False, frozen=True, kw_only=True, slots=True)
class Constituent:
    """One kind of particle: how many there are at each altitude, and what each does to light.

    Parameters
    ----------
    name : str
        Unique inside an atmosphere.
    number_density : callable
        Altitudes (n,) float64 [m, 0 to the top] to particles per volume (n,) float64. [m-3, >= 0]
    kink_altitude_m : ndarray, float64, shape (n_kink,)
        Rising altitudes between the ground and the top where the density jumps or bends. [m]
    scattering_m2, absorption_m2 : ndarray, float64, shape (n_wl,)
        Cross sections; their sum is the extinction. [m2, >= 0]
    phase_function : callable or None
        Cosines of scattering angles (n,) float64 and a row of the wavelengths (int) to the phase function (n,)
        float64, of integral 1 over the sphere; 1 is straight on. None where nothing is scattered. [sr-1]

    Examples
    --------
    >>> haze = sky.atmosphere.Constituent(
    ...     name="haze",
    ...     number_density=lambda altitude_m: 1e8 * np.exp(-altitude_m / 1200.0),
    ...     kink_altitude_m=np.empty(0),
    ...     scattering_m2=np.array([1e-12]),
    ...     absorption_m2=np.array([1e-13]),
    ...     phase_function=lambda mu, row: sky.henyey_greenstein.pdf_sr(1 - mu, 0.7),
    ... )
    >>> print(haze.number_density(np.array([0.0, 1200.0])).round(-5))
    [1.00e+08 3.68e+07]
    """

    name: str
    number_density: Callable[[np.ndarray], np.ndarray]
    kink_altitude_m: np.ndarray
    scattering_m2: np.ndarray
    absorption_m2: np.ndarray
    phase_function: Callable[[np.ndarray, int], np.ndarray] | None = None

    __eq__ = same_content
    __repr__ = short_repr


@in_both_units
@dataclass(eq=False, frozen=True, kw_only=True, slots=True)
class Medium:
    """A spherical atmosphere over a Lambertian ground, lit by the sun.

    Parameters
    ----------
    earth_radius_m : float
        Radius of the ground. [m, > 0]
    top_m : float
        Altitude above which there is nothing. [m, > 0]
    wavelength_nm : ndarray, float64, shape (n_wl,)
        Wavelengths of every row below. [nm]
    constituents : tuple of Constituent
        All of them; order does not matter.
    ground_albedo : ndarray, float64, shape (n_wl,)
        Of the Lambertian ground. [0 to 1]
    toa_irradiance : ndarray, float64, shape (n_wl,)
        Of the sun above the atmosphere, on a plane normal to the beam. [W m-2 nm-1]
    sun_angular_radius_rad, or sun_angular_radius_deg : float
        Of the solar disc; 0 for a point. [rad]
    n_orders : int
        Most interactions of a photon with air and ground that count. [1 or more]
    least_line_points, least_angles : int
        Points along a line that order 1 has at least, and directions on the sphere that `sos` has at least;
        accuracy does not need them. [0 or more]
    texts : tuple of str
        Notes for a person, such as what the file says in words.

    Examples
    --------
    >>> vacuum = sky.atmosphere.Medium(
    ...     earth_radius_m=6.371e6,
    ...     top_m=1e5,
    ...     wavelength_nm=np.array([550.0]),
    ...     constituents=(),
    ...     n_orders=1,
    ...     ground_albedo=np.array([0.06]),
    ...     toa_irradiance=np.array([1.88]),
    ...     sun_angular_radius_deg=0.2665,
    ... )
    >>> vacuum.wavelength_nm
    array([550.])
    """

    earth_radius_m: float
    top_m: float
    wavelength_nm: np.ndarray
    constituents: tuple[Constituent, ...]
    ground_albedo: np.ndarray
    toa_irradiance: np.ndarray
    sun_angular_radius_rad: float = None  # type: ignore[assignment]
    n_orders: int
    least_line_points: int = 0
    least_angles: int = 0
    texts: tuple[str, ...] = field(default=(), compare=False)
    sun_angular_radius_deg: InitVar[float | None] = None

    __eq__ = same_content
    __repr__ = short_repr

    def __post_init__(self, sun_angular_radius_deg: float | None) -> None:
        settle_angles(self, sun_angular_radius_rad=sun_angular_radius_deg)
        for name in ("wavelength_nm", "ground_albedo", "toa_irradiance"):
            require_kind(getattr(self, name), np.ndarray, f"{name}=np.array(...)")
        for part in self.constituents:
            require_kind(part, Constituent, "constituents=(sky.atmosphere.Constituent(...),)")
        shape = self.wavelength_nm.shape
        rows = [self.ground_albedo, self.toa_irradiance]
        rows += [row for part in self.constituents for row in (part.scattering_m2, part.absorption_m2)]
        for row in rows:
            unmasked("a spectrum of an atmosphere", row)
        if len(shape) != 1 or any(row.shape != shape for row in rows):
            raise SceneError("an atmosphere has one value of every spectrum for each wavelength")
        if not (0.0 < self.earth_radius_m < np.inf and 0.0 < self.top_m < np.inf) or self.n_orders < 1:
            raise SceneError("an atmosphere needs a height and a ground radius above 0, and one order or more")
        if len({part.name for part in self.constituents}) != len(self.constituents):
            raise SceneError("two constituents of an atmosphere have the same name")


# two kinks nearer than this [m] are one to every solver, and one so near the ground or the top is none
_SAME_KINK_M = 1e-6
_N_ALTITUDES = 16384
_N_NEAR_GROUND = 1024
# samples: a layer that falls to a half within so many on both sides is thin beside every scale height
_THIN = 128
_MAX_LAYERS = 100


def scatterers(medium: Medium) -> list[int]:
    """Indices of the constituents that scatter at any wavelength, in their order."""
    parts = enumerate(medium.constituents)
    return [k for k, part in parts if part.phase_function is not None and np.any(part.scattering_m2 > 0)]


def phase_laws(medium: Medium) -> list[Callable[[np.ndarray, int], np.ndarray]]:
    """Phase functions of the scatterers, in their order."""
    laws = (medium.constituents[k].phase_function for k in scatterers(medium))
    return [law for law in laws if law is not None]


def unlit(medium: Medium) -> Medium:
    """The medium without a sun."""
    return dataclasses.replace(medium, toa_irradiance=np.zeros_like(medium.toa_irradiance))


def _is_unphysical(value: np.ndarray) -> np.ndarray:
    """Mask of values that are negative, infinite or NaN."""
    return ~((value >= 0.0) & (value < np.inf))


@dataclass(frozen=True, kw_only=True, slots=True)
class NumberDensity:
    """Particles per volume by altitude; calling it evaluates the block and checks the values. Pure."""

    block: Block
    given: Mapping[str, np.ndarray | float]
    top_m: float  #: Altitude above which there is nothing. [m]

    def __call__(self, altitude_m: np.ndarray) -> np.ndarray:
        """Density at altitudes, finite and not negative; one outside by rounding takes the end. [m-3]"""
        altitude_m = np.clip(np.asarray(altitude_m, dtype=np.float64), 0.0, self.top_m)
        value = self.block(altitude_m, self.given).reshape(altitude_m.shape)
        bad = _is_unphysical(value)
        if bad.any():
            first = int(np.flatnonzero(bad.ravel())[0])
            density = float(value.ravel()[first])
            advice = "write max(0.0, ...) around it" if density < 0.0 else "write what is finite there"
            message = f"a density is finite and not negative; it is {density:.6g}"
            raise self.block.refused_at(float(altitude_m.ravel()[first]), message, advice)
        return value

    def kinks(self) -> np.ndarray:
        """Find the altitudes where the density jumps or bends, and check it on all samples and beside all kinks. [m]

        The first number of the upper piece, rising, inside the atmosphere. Pieces thinner than ``top_m / 16384`` are
        found where a bend leads to them (``abs(altitude - h) < 2.0``). A thin smooth layer falls to a half within a
        128th of the atmosphere on both sides. It counts as three bends, its peak and its halves, so that no quadrature
        steps over it.
        """
        # a block that never ends, or fails everywhere, is reported for two altitudes at once
        self(np.array([0.0, self.top_m]))
        even = np.linspace(0.0, self.top_m, _N_ALTITUDES + 1)
        samples = np.union1d(even, np.geomspace(self.top_m * 1e-9, even[1], _N_NEAR_GROUND))
        try:
            bends = find_kinks(lambda altitude: self.block.trace(altitude, self.given), samples)
        except SceneError as error:
            raise self.block.refused_at(None, str(error)) from None
        layers = [even[layer] for layer in _thin_layers(self(even))]
        # one that a bend bounds is known already
        smooth = [one for one in layers if not ((bends >= one[0]) & (bends <= one[2])).any()]
        bends = np.unique(np.concatenate([bends, *smooth]))
        inside = bends[(bends > _SAME_KINK_M) & (bends < self.top_m - _SAME_KINK_M)]
        if inside.size:
            inside = inside[np.r_[True, np.diff(inside) > _SAME_KINK_M]]
        self(np.concatenate([samples, inside, np.nextafter(inside, 0.0)]))
        return inside


def _thin_layers(value: np.ndarray) -> list[list[int]]:
    """For each thin layer the indices where it has half of its peak, of its peak, and where it has half again."""
    peaks = 1 + np.flatnonzero((value[1:-1] > value[:-2]) & (value[1:-1] >= value[2:]))
    layers = []
    for peak in peaks[np.argsort(-value[peaks], kind="stable")][:_MAX_LAYERS].tolist():
        first = max(0, peak - _THIN)
        below = np.flatnonzero(value[first:peak] < 0.5 * value[peak])
        above = np.flatnonzero(value[peak + 1 : peak + 1 + _THIN] < 0.5 * value[peak])
        if below.size and above.size:
            layers.append([first + int(below[-1]), peak, peak + 1 + int(above[0])])
    return layers


Given = Mapping[str, np.ndarray | float]
_N_PANELS = 64
_N_COSINES = 4096
_TOLERANCE = 1e-12
_MAX_ERROR = 1e-6


@dataclass(frozen=True, kw_only=True, slots=True)
class PhaseBlock:
    """A phase function of some wavelengths, of integral 1 over the sphere; calling it evaluates the block. Pure."""

    block: Block  #: The code: four wavelengths at once
    given: Sequence[Given]  #: Values of the names that it reads, for each set of four wavelengths
    rows: Sequence[tuple[int, int]]  #: For each wavelength its set and its place in it
    norm: np.ndarray  #: (n_wl,) integral over the sphere of what the block gives, for each wavelength; it is divided by

    def __call__(self, mu: np.ndarray, row: int) -> np.ndarray:
        """Phase function at cosines of scattering angles (n,); one outside by rounding takes the end. [sr-1]"""
        mu = np.clip(np.asarray(mu, dtype=np.float64), -1.0, 1.0)
        group, component = self.rows[row]
        return (_checked_phase(self.block, mu, self.given[group])[component] / self.norm[row]).reshape(mu.shape)


def read_phase_block(block: Block, given: Sequence[Given], rows: Sequence[tuple[int, int]]) -> PhaseBlock:
    """Check a phase function at all cosines and find its integrals."""
    integrals = [sphere_integral(block, one) for one in given]
    norm = np.array([integrals[group][0][component] for group, component in rows])
    error = np.array([integrals[group][1][component] for group, component in rows])
    if not (norm > 0.0).all():
        message = "the phase function is zero everywhere, so it cannot be normalised"
        raise block.refused_at(None, message, "write one that scatters some light")
    if (error > _MAX_ERROR * norm).any():
        message = f"the integral of the phase function over the sphere does not converge to {_MAX_ERROR:g} of it"
        raise block.refused_at(None, message, "its peak may be too narrow for numbers of 64 bits")
    norm.flags.writeable = False
    return PhaseBlock(block=block, given=tuple(given), rows=tuple(rows), norm=norm)


def sphere_integral(block: Block, given: Given) -> tuple[np.ndarray, np.ndarray]:
    """Integrate a phase function over the sphere: for each component 2 pi times the integral over mu, and its error.

    The variable is t, 0 to 1, with ``1 - mu = 2 t^4``: a forward peak of width 1e-12 in 1 - mu takes a thousandth of
    the range. Accuracy: 1e-10, and 1e-16 over the width of the peak where that is more.
    """
    # a block that never ends, or fails everywhere, is reported for two cosines at once
    _checked_phase(block, np.array([1.0, -1.0]), given)
    samples = _mu_of(np.linspace(1.0, 0.0, _N_COSINES + 1))
    try:
        kinks = find_kinks(lambda mu: block.trace(mu, given), samples)
    except SceneError as error:
        raise block.refused_at(None, str(error)) from None
    _checked_phase(block, np.concatenate([samples, kinks]), given)
    bends = ((1.0 - kinks) / 2.0) ** 0.25
    edges = np.unique(np.concatenate([np.linspace(0.0, 1.0, _N_PANELS + 1), bends]))

    def integrand(t: np.ndarray) -> np.ndarray:
        return _checked_phase(block, _mu_of(t), given) * (16.0 * np.pi * t**3)

    return integrate(integrand, edges, tolerance=_TOLERANCE)


def _mu_of(t: np.ndarray) -> np.ndarray:
    return 1.0 - 2.0 * t**4


def _checked_phase(block: Block, mu: np.ndarray, given: Given) -> np.ndarray:
    value = block(mu, given)
    bad = _is_unphysical(value)
    if bad.any():
        component, lane = np.argwhere(bad)[0]
        message = f"a phase function is finite and not negative; component {component} is {value[component, lane]:.6g}"
        raise block.refused_at(float(mu.ravel()[lane]), message, "write what is 0 or more there")
    return value


MAX_KINKS = 1000
# of the range: what stops the halving beside zero, where floating-point numbers never end
_FINEST = 2.0**-60


def find_kinks(trace: Callable[[np.ndarray], np.ndarray], samples: np.ndarray) -> np.ndarray:
    """Find where the way through a function changes: the first number of each piece but the first one.

    Between neighbouring samples of different traces the interval is halved until its ends are neighbouring numbers. A
    third trace in between is followed to both of its ends. A piece between two samples of equal trace is not seen.
    """
    traces = trace(samples)
    change = np.flatnonzero(traces[:-1] != traces[1:])
    low, high, above = samples[change], samples[change + 1], traces[change + 1]
    below = traces[change]
    kinks: list[np.ndarray] = []
    finest = _FINEST * (samples[-1] - samples[0])
    while low.size:
        if low.size + sum(one.size for one in kinks) > MAX_KINKS:
            raise SceneError(f"there are more than {MAX_KINKS} jumps or bends, which no solver could resolve")
        middle = low + 0.5 * (high - low)
        ended = (middle <= low) | (middle >= high) | (high - low <= finest)
        kinks.append(high[ended])
        low, high, middle, below, above = (one[~ended] for one in (low, high, middle, below, above))
        between = trace(middle)
        left, right = between != below, between != above
        low, high = np.r_[low[left], middle[right]], np.r_[middle[left], high[right]]
        below, above = np.r_[below[left], between[right]], np.r_[between[left], above[right]]
    return np.unique(np.concatenate(kinks)) if kinks else np.empty(0)


_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(15)
_MAX_HALVINGS = 40
_MAX_NODES = 2**20


def integrate(
    function: Callable[[np.ndarray], np.ndarray], edges: np.ndarray, *, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """Integrate functions of one sign over the range of some edges, among which their jumps and bends belong.

    Every panel has 15 Gauss nodes. It is halved until that changes its share by at most `tolerance` of the whole, or
    until a million nodes are spent. Returns the integrals (n_function,) and their errors, the sums of the changes that
    the last halving of each panel made: far above the true error where the functions are smooth.
    """
    low, high = edges[:-1], edges[1:]
    whole = _panels(function, low, high)
    done, error = np.zeros(whole.shape[0]), np.zeros(whole.shape[0])
    n_nodes = low.size * _NODES.size
    for _ in range(_MAX_HALVINGS):
        middle = low + 0.5 * (high - low)
        left, right = _panels(function, low, middle), _panels(function, middle, high)
        n_nodes += 2 * low.size * _NODES.size
        change = np.abs(left + right - whole)
        total = np.abs(done + (left + right).sum(axis=1))
        settled = (change <= tolerance * total[:, None]).all(axis=0)
        if n_nodes > _MAX_NODES:
            settled[:] = True
        done += (left + right)[:, settled].sum(axis=1)
        error += change[:, settled].sum(axis=1)
        if settled.all():
            break
        left, right = left[:, ~settled], right[:, ~settled]
        low, middle, high = low[~settled], middle[~settled], high[~settled]
        low, high, whole = np.r_[low, middle], np.r_[middle, high], np.hstack([left, right])
    else:
        done, error = done + whole.sum(axis=1), error + np.abs(whole).sum(axis=1)
    return done, error


def _panels(function: Callable[[np.ndarray], np.ndarray], low: np.ndarray, high: np.ndarray) -> np.ndarray:
    half = 0.5 * (high - low)
    places = low[:, None] + half[:, None] * (1.0 + _NODES)
    values = function(places.ravel())
    return (values.reshape(values.shape[0], *places.shape) @ _WEIGHTS) * half


BOLTZMANN_J_K = 1.380649e-23
"""Boltzmann constant. [J K-1, exact in the SI since 2019]"""


def rayleigh_cross_section(
    refractive_index: ArrayLike,
    temperature_k: ArrayLike,
    pressure_pa: ArrayLike,
    *,
    wavelength_nm: ArrayLike = 1000.0,
    king_factor: ArrayLike = 1.0,
) -> Any:
    """Rayleigh scattering cross section of one molecule of an ideal gas.

    sigma = (8 pi^3 / 3) (n^2 - 1)^2 / lambda^4 (k T / p)^2 F. This is equation (120.4) of [landau1984] with h = sigma
    N, in the form that the description of an atmosphere asks for. F is the King factor of anisotropic molecules, 1 by
    default as there. Arguments broadcast.

    Parameters
    ----------
    refractive_index : array_like
        n of the gas at this wavelength, temperature and pressure. [1 to 2]
    temperature_k, pressure_pa : array_like
        At which n was measured. [K and Pa, > 0]
    wavelength_nm : array_like
        Wavelength in vacuum. [nm, > 0]
    king_factor : array_like
        (6 + 3 rho) / (6 - 7 rho) of the depolarisation factor rho. [1 or more; 1.049 for air at 550 nm]

    Returns
    -------
    ndarray or scalar, float64
        sigma. [m2]

    Raises
    ------
    UsageError
        An argument is outside its range, infinite or NaN.

    Notes
    -----
    Accuracy: 3e-15 relative for the given float64 numbers, also where n - 1 is tiny; n itself is commonly known
    to 1e-8, which is 4e-5 of n - 1 and so 7e-5 of sigma for air.

    Examples
    --------
    >>> print(
    ...     f"{sky.atmosphere.rayleigh_cross_section(1.000278, 288.15, 101325.0, wavelength_nm=550.0):.3e}"
    ... )
    4.307e-31
    """
    n = _in_range("the refractive index", refractive_index, 1.0, 2.0)
    temperature = _in_range("the temperature", temperature_k, np.nextafter(0.0, 1.0), 1e9)
    pressure = _in_range("the pressure", pressure_pa, np.nextafter(0.0, 1.0), 1e15)
    wavelength = _in_range("the wavelength", wavelength_nm, np.nextafter(0.0, 1.0), 1e12) * 1e-9
    king = _in_range("the King factor", king_factor, 1.0, 1e3)
    # n - 1 is exact in float64 for n below 2, n^2 - 1 would lose half of the digits
    per_density = (n - 1.0) * (n + 1.0) * (BOLTZMANN_J_K * temperature / pressure)
    with np.errstate(over="ignore", divide="ignore"):
        sigma = 8.0 * np.pi**3 / 3.0 * np.square(per_density / np.square(wavelength)) * king
    if not np.all(np.isfinite(sigma)):
        raise UsageError("the cross section overflows: the wavelength must be in nm, the pressure in Pa")
    return sigma


def _in_range(name: str, value: ArrayLike, low: float, high: float) -> Any:
    array = floats(name, value)
    if not np.all((array >= low) & (array <= high)):
        raise UsageError(f"{name} must lie between {low:g} and {high:g}")
    return array[()]
