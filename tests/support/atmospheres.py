"""Atmospheres built by hand from formulas, without a file and its reader.

`molecules_only`, `mol_ozone` and `full` are those of the reference tables (their README); `plane_parallel` is so
thin beside its ground's radius that no table can tell it from flat layers; `exponential` and `uniform` take any size.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from aomc_sky.skies.atmosphere.medium import Constituent, Medium

EARTH_RADIUS_M = 6.371e6
TOP_M = 120e3
NO_KINK = np.empty(0)
OZONE_KINKS_M = np.array([8e3, 21.5e3, 39e3])
OZONE_M2 = {400: 1.1e-26, 450: 1.8e-26, 500: 1.8e-25, 550: 3.3e-25, 600: 4.9e-25, 700: 1.6e-25}
OZONE_SAMPLE_M2 = {400: 1.1e-26, 500: 1.8e-25, 600: 4.5e-25, 700: 1.6e-25}
PEAK_NORM = 0.99947938
THICKNESS_M = 100.0


def rayleigh_phase(mu, row):
    return 3 / (16 * np.pi) * (1 + mu * mu)


def isotropic_phase(mu, row):
    return np.full_like(mu, 1 / (4 * np.pi))


def henyey_greenstein_phase(g):
    """Henyey and Greenstein's law, its peak without cancellation."""
    return lambda mu, row: (1 - g * g) / (4 * np.pi) / ((1 - g) ** 2 + 2 * g * (1 - mu)) ** 1.5


def peaked_phase(mu, row):
    """The aerosol of `full`, of integral 1, with a sharp forward peak."""
    return sample_aerosol_phase(mu, row) / PEAK_NORM


def sample_aerosol_phase(mu, row):
    """`peaked_phase` as the sample description has it, of integral PEAK_NORM."""
    g = 0.76
    k = 3 / (8 * np.pi) * (1 - g * g) / (2 + g * g)
    return 0.904 * (k * (1 + mu * mu) / (1 + g * g - 2 * g * mu) ** 1.5 + 1 / (600 * (1 - mu) + 0.05))


def exponential_profile(at_ground, scale_height_m):
    """Density that falls by e in one scale height."""
    return lambda altitude_m: at_ground * np.exp(-altitude_m / scale_height_m)


def ozone_profile(altitude_m):
    """Four pieces, bent at 8, 21.5 and 39 km."""
    h = altitude_m / 1000.0
    pieces = [
        7.2402403521159135e-6 - 1.206527437798165e-7 * h,
        -2.0590185333577628e-5 + 3.3581504669318765e-6 * h,
        1.0542813563268143e-4 - 2.50316678731273e-6 * h,
        0.04298160111157969 * np.exp(-0.2208669270720561 * h),
    ]
    return 370 * 2.687e20 * np.select([h < 8, h < 21.5, h < 39], pieces[:3], pieces[3])


def _part(name, density, scattering, absorption=None, phase=None, kinks_m=NO_KINK):
    return Constituent(
        name=name,
        number_density=density,
        kink_altitude_m=kinks_m,
        scattering_m2=scattering,
        absorption_m2=np.zeros_like(scattering) if absorption is None else absorption,
        phase_function=phase,
    )


def molecules(wavelength_nm, phase=rayleigh_phase):
    scattering = 0.04022e-30 / (wavelength_nm / 1000.0) ** 4
    return _part("molecules", exponential_profile(3.08458e25, 8000.0), scattering, phase=phase)


def aerosol(wavelength_nm, phase=peaked_phase):
    scattering = np.full_like(wavelength_nm, 0.042968e-12)
    return _part("aerosol", exponential_profile(1.03333e8, 1200.0), scattering, phase=phase)


def ozone(wavelength_nm, cross_section_m2=None):
    """The ozone of the reference tables; cross sections as given there unless told."""
    given = [OZONE_M2[round(w)] for w in wavelength_nm] if cross_section_m2 is None else cross_section_m2
    absorption = np.broadcast_to(np.asarray(given, dtype=np.float64), wavelength_nm.shape).copy()
    return _part("ozone", ozone_profile, np.zeros_like(absorption), absorption, kinks_m=OZONE_KINKS_M)


def medium_of(
    constituents,
    wavelength_nm,
    *,
    albedo=0.0,
    earth_radius_m=EARTH_RADIUS_M,
    top_m=TOP_M,
    sun_angular_radius_rad=0.0,
    n_orders=40,
):
    """A medium under a sun of irradiance 1 at every wavelength."""
    wavelengths = _nm(wavelength_nm)
    return Medium(
        earth_radius_m=earth_radius_m,
        top_m=top_m,
        wavelength_nm=wavelengths,
        constituents=tuple(constituents),
        ground_albedo=np.broadcast_to(np.asarray(albedo, dtype=np.float64), wavelengths.shape).copy(),
        toa_irradiance=np.ones_like(wavelengths),
        sun_angular_radius_rad=sun_angular_radius_rad,
        n_orders=n_orders,
    )


def _nm(wavelength_nm):
    return np.atleast_1d(np.asarray(wavelength_nm, dtype=np.float64))


def molecules_only(wavelength_nm, albedo=0.0):
    return medium_of([molecules(_nm(wavelength_nm))], wavelength_nm, albedo=albedo)


def mol_ozone(wavelength_nm, albedo=0.0, ozone_m2=None):
    w = _nm(wavelength_nm)
    return medium_of([molecules(w), ozone(w, ozone_m2)], w, albedo=albedo)


def full(wavelength_nm, albedo=0.0, ozone_m2=None):
    """Case `full` of the reference tables: molecules, peaked aerosol, ozone."""
    w = _nm(wavelength_nm)
    return medium_of([molecules(w), aerosol(w), ozone(w, ozone_m2)], w, albedo=albedo)


def sample(wavelength_nm, albedo=0.0):
    """`full` as in calcmysky_sample.csv: its ozone, and an aerosol of integral PEAK_NORM."""
    w = _nm(wavelength_nm)
    ozone_m2 = [OZONE_SAMPLE_M2[round(x)] for x in w]
    return medium_of([molecules(w), aerosol(w, sample_aerosol_phase), ozone(w, ozone_m2)], w, albedo=albedo)


@dataclass(frozen=True, kw_only=True, slots=True)
class Layer:
    """One flat layer: three optical depths that add; `omega_hg` is the scattered share of the second alone."""

    tau_rayleigh: float = 0.0
    tau_hg: float = 0.0
    g: float = 0.0
    omega_hg: float = 1.0
    tau_absorber: float = 0.0


@dataclass(frozen=True, kw_only=True, slots=True)
class Layers:
    optical_depth: np.ndarray  #: (n_layer,) extinction of each layer from the top. [>= 0]
    #: (n_kind, n_layer) single-scattering albedo that each kind of particle adds. [0 to 1; sum over the kinds <= 1]
    scattering: np.ndarray
    #: n_kind of them: cosines of scattering angles (n,) to the phase function (n,), of integral 1 over the sphere.
    #: [sr-1]
    phases: tuple[Callable[[np.ndarray], np.ndarray], ...]


def flat_medium(layers, albedo, n_orders=40):
    """The layers over a ground of radius 1e14 m: flat to 1e-8 for cosines above 0.02."""
    n = len(layers.optical_depth)
    edges = THICKNESS_M * np.arange(1.0, n)

    def density(depth):
        per_m = np.asarray(depth)[::-1] / THICKNESS_M
        return lambda h: per_m[np.clip(np.searchsorted(edges, h, side="right"), 0, n - 1)]

    shares = [*layers.scattering, 1.0 - np.sum(layers.scattering, axis=0)]
    laws = [*((lambda mu, row, law=law: law(mu)) for law in layers.phases), None]
    cross_section = {True: np.ones(1), False: np.zeros(1)}
    parts = [
        _part(
            f"kind {k}", density(layers.optical_depth * share), cross_section[law is not None],
            cross_section[law is None], law, edges,
        )
        for k, (share, law) in enumerate(zip(shares, laws, strict=True))
        if np.any(share > 1e-12)
    ]  # fmt: skip
    return medium_of(parts, 550.0, albedo=albedo, earth_radius_m=1e14, top_m=n * THICKNESS_M, n_orders=n_orders)


def plane_parallel(layers_from_top, albedo=0.0):
    """A stack of `Layer`, the topmost first."""
    rows = [[one.tau_rayleigh, one.tau_hg, one.omega_hg, one.tau_absorber] for one in layers_from_top]
    rayleigh, hg, omega, absorber = np.array(rows, dtype=np.float64).T
    tau = rayleigh + hg + absorber
    laws = [henyey_greenstein_phase(one.g) for one in layers_from_top]
    phases = [lambda mu: rayleigh_phase(mu, 0), *(lambda mu, law=law: law(mu, 0) for law in laws)]
    scattering = np.vstack([rayleigh / tau, np.diag(hg * omega / tau)])
    return flat_medium(Layers(optical_depth=tau, scattering=scattering, phases=tuple(phases)), albedo)


def _one_gas(density, tau, omega, phase, **medium):
    scattering, absorption = np.array([tau * omega]), np.array([tau * (1.0 - omega)])
    return medium_of([_part("gas", density, scattering, absorption, phase if omega > 0 else None)], 550.0, **medium)


def exponential(
    tau,
    *,
    scale_height_m=8000.0,
    omega=1.0,
    albedo=0.0,
    earth_radius_m=EARTH_RADIUS_M,
    top_m=TOP_M,
    phase=rayleigh_phase,
):
    """One constituent that thins exponentially, of vertical optical depth `tau` in all and scattered share `omega`."""
    column = -scale_height_m * np.expm1(-top_m / scale_height_m)
    density = exponential_profile(1.0 / column, scale_height_m)
    return _one_gas(density, tau, omega, phase, albedo=albedo, earth_radius_m=earth_radius_m, top_m=top_m)


def uniform(tau, *, omega=1.0, albedo=0.0, earth_radius_m=EARTH_RADIUS_M, top_m=TOP_M, phase=rayleigh_phase):
    """One constituent of the same density at all altitudes: slant optical depths are `tau` times path over height."""
    density = lambda h: np.full_like(h, 1.0 / top_m)  # noqa: E731
    return _one_gas(density, tau, omega, phase, albedo=albedo, earth_radius_m=earth_radius_m, top_m=top_m)


def empty(*, albedo=0.0):
    return medium_of([], 550.0, albedo=albedo)
