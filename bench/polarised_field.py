"""A polarised clear sky of sasktran2, the table of the tests in tests/data/polarised/rayleigh.csv.

Run `python bench/polarised_field.py > tests/data/polarised/rayleigh.csv`. Molecules have the optical depth 0.5 without
depolarisation over a black ground, and the cosine of the zenith angle of the sun is 0.2: a case of Natraj, Li and Yung
(2009). It needs sasktran2 (2026.10), which the package never imports. sasktran2 has no downward light of plane layers,
so the layer is 1 / 200 000 of the radius of a sphere; thinner ones lose digits. Against the published rows I is within
2e-4, Q/I and U/I are within 1e-4.

Light that molecules scatter has three Fourier modes in the azimuth from the sun: I and Q in cosines, U in sines. The
file has them for each zenith angle, with the signs of sasktran2. Radiances are over the solar irradiance, times pi.
"""

from __future__ import annotations

import numpy as np
import sasktran2 as sk

TAU, MU0 = 0.5, 0.2
RADIUS_M, HEIGHT_M = 6.371e6, 31.855
N_LEVELS, N_STREAMS = 161, 40
_NEAR_ZENITH_DEG = 0.01
TABULATED_MU = (0.1, 0.2, 0.52, 0.84, 1.0)
AZIMUTHS_DEG = np.array([0.0, 60.0, 90.0, 120.0, 180.0])


def zenith_angles_deg() -> np.ndarray:
    """Every 2 degrees to 88, with those of the published tables in the place of the nearest."""
    angles = np.arange(0.0, 89.0, 2.0)
    for angle in np.rad2deg(np.arccos(TABULATED_MU)):
        angles[np.abs(angles - angle).argmin()] = angle
    return angles


def radiances(rays: list[tuple[float, float]]) -> np.ndarray:
    """I, Q, U of rays (cosine of the zenith angle, azimuth from the sun in rad), shape (n, 3)."""
    config = sk.Config()
    config.num_stokes, config.stokes_basis = 3, sk.StokesBasis.Standard
    config.num_streams = config.num_singlescatter_moments = N_STREAMS
    config.num_forced_azimuth = 3
    config.multiple_scatter_source = sk.MultipleScatterSource.DiscreteOrdinates
    altitude = np.linspace(0.0, HEIGHT_M, N_LEVELS)
    how = sk.InterpolationMethod.LinearInterpolation, sk.GeometryType.Spherical
    geometry, viewing = sk.Geometry1D(MU0, 0.0, RADIUS_M, altitude, *how), sk.ViewingGeometry()
    for mu, azimuth in rays:
        viewing.add_ray(sk.SolarAnglesObserverLocation(MU0, azimuth, mu, 0.0))
    air = sk.Atmosphere(geometry, config, numwavel=1, calculate_derivatives=False)
    air.storage.total_extinction[:] = TAU / HEIGHT_M
    air.storage.ssa[:] = 1.0 - 1e-9
    air.leg_coeff.a1[0], air.leg_coeff.a1[2] = 1.0, 0.5
    air.leg_coeff.a2[2], air.leg_coeff.b1[2] = 3.0, np.sqrt(1.5)
    air.surface.albedo[:] = 0.0
    return np.pi * sk.Engine(config, geometry, viewing).calculate_radiance(air)["radiance"].values.reshape(-1, 3)


def main() -> None:
    """Print the table."""
    zenith, turn = zenith_angles_deg(), np.deg2rad(AZIMUTHS_DEG)
    near = np.maximum(zenith, _NEAR_ZENITH_DEG)  # in the zenith itself the azimuth of the frame is lost
    rays = [(float(np.cos(np.deg2rad(z))), float(a)) for z in near for a in turn]
    found = radiances(rays).reshape(zenith.size, turn.size, 3)
    even, odd = np.cos(np.outer(turn, range(3))), np.sin(np.outer(turn, (1, 2)))
    columns = [np.linalg.lstsq(even, found[:, :, k].T, rcond=None)[0] for k in (0, 1)]
    columns.append(np.linalg.lstsq(odd, found[:, :, 2].T, rcond=None)[0])
    print("zenith_deg,I0,I1,I2,Q0,Q1,Q2,U1,U2")
    for angle, row in zip(zenith, np.concatenate(columns).T, strict=True):
        print(f"{angle:.10g}," + ",".join(f"{value:.7f}" for value in row + 0.0))


if __name__ == "__main__":
    main()
