"""Atmospheres built by hand from formulas, without a file and its reader.

`molecules_only`, `mol_ozone` and `full` are those of the reference tables (their README); `plane_parallel` is so
thin beside its ground's radius that no table can tell it from flat layers; `exponential` and `uniform` take any size.
"""

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
    wavelengths = np.atleast_1d(np.asarray(wavelength_nm, dtype=np.float64))
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


def molecules_only(wavelength_nm, albedo=0.0):
    w = np.atleast_1d(np.asarray(wavelength_nm, dtype=np.float64))
    return medium_of([molecules(w)], w, albedo=albedo)


def mol_ozone(wavelength_nm, albedo=0.0, ozone_m2=None):
    w = np.atleast_1d(np.asarray(wavelength_nm, dtype=np.float64))
    return medium_of([molecules(w), ozone(w, ozone_m2)], w, albedo=albedo)


def full(wavelength_nm, albedo=0.0, ozone_m2=None):
    """Case `full` of the reference tables: molecules, peaked aerosol, ozone."""
    w = np.atleast_1d(np.asarray(wavelength_nm, dtype=np.float64))
    return medium_of([molecules(w), aerosol(w), ozone(w, ozone_m2)], w, albedo=albedo)


def sample(wavelength_nm, albedo=0.0):
    """`full` as in calcmysky_sample.csv: its ozone, and an aerosol of integral PEAK_NORM."""
    w = np.atleast_1d(np.asarray(wavelength_nm, dtype=np.float64))
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


def _slab(name, low_m, high_m, taus, phase):
    """Between two altitudes, uniform: scattering and absorption optical depth."""
    scattering, absorption = (np.array([tau]) for tau in taus)
    density = lambda h: ((h >= low_m) & (h < high_m)) / (high_m - low_m)  # noqa: E731
    return _part(name, density, scattering, absorption, phase if taus[0] > 0 else None, np.array([low_m, high_m]))


def plane_parallel(layers_from_top, albedo=0.0):
    """Uniform layers of 100 m over a ground of radius 1e14 m: flat to 1e-8 for cosines above 0.02."""
    parts = []
    n = len(layers_from_top)
    for k, layer in enumerate(layers_from_top):
        low, high = 100.0 * (n - 1 - k), 100.0 * (n - k)
        phase = henyey_greenstein_phase(layer.g)
        hg = (layer.tau_hg * layer.omega_hg, layer.tau_hg * (1 - layer.omega_hg))
        parts.append(_slab(f"rayleigh{k}", low, high, (layer.tau_rayleigh, 0.0), rayleigh_phase))
        parts.append(_slab(f"hg{k}", low, high, hg, phase))
        parts.append(_slab(f"absorber{k}", low, high, (0.0, layer.tau_absorber), None))
    kept = [part for part in parts if part.scattering_m2[0] + part.absorption_m2[0] > 0]
    return medium_of(kept, 550.0, albedo=albedo, earth_radius_m=1e14, top_m=100.0 * n)


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
