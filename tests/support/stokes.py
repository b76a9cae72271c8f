"""Stokes vectors from first principles: electric fields as vectors in space, without any angle of a meridian plane."""

import numpy as np


def travel_of(zenith, azimuth):
    """Unit vectors (..., 3) along which light from sky directions travels."""
    sine = np.sin(zenith)
    return -np.stack(np.broadcast_arrays(sine * np.cos(azimuth), sine * np.sin(azimuth), np.cos(zenith)), axis=-1)


def frame_of(travel):
    """Axes (l, r): l in the plane of the vertical and the ray, r = k x l, so that l x r is the travel direction k."""
    up = np.array([0.0, 0.0, 1.0])
    l_axis = np.cross(np.cross(travel, up), travel)
    l_axis /= np.linalg.norm(l_axis, axis=-1, keepdims=True)
    return l_axis, np.cross(travel, l_axis)


def stokes_of(coherence, travel):
    """q and u of light of the coherence tensors (..., 3, 3): means of E_i E_j."""
    l_axis, r_axis = frame_of(travel)
    of = lambda a, b: np.einsum("...i,...ij,...j->...", a, coherence, b)  # noqa: E731
    total = of(l_axis, l_axis) + of(r_axis, r_axis)
    return (of(l_axis, l_axis) - of(r_axis, r_axis)) / total, 2.0 * of(l_axis, r_axis) / total


def scattered_once(travel, sun):
    """q and u of unpolarised sunlight that dipoles scattered once: E is that of the sun across the ray."""
    incident = travel_of(np.array(sun[0]), np.array(sun[1]))
    sun_projection = np.eye(3) - np.outer(incident, incident)
    across = np.eye(3) - travel[..., :, None] * travel[..., None, :]
    return stokes_of(across @ sun_projection @ across, travel)


DEFECTS = {
    "Q and U exchanged": lambda q, u: (u, q),
    "frame turned by 90 degrees": lambda q, u: (-q, -u),
    "sign of U": lambda q, u: (q, -u),
}
"""What no test of a Stokes vector may let pass. The azimuth that is mirrored is the fourth one."""
