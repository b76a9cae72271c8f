"""Patches of the sky: bounds, solid angles, projected solid angles, and what index means what."""

from __future__ import annotations

from dataclasses import InitVar, dataclass

import numpy as np

from aomc_sky.directions import EDGE_DEG, given_angle, in_both_units, sin_cos_deg
from aomc_sky.errors import SceneError, UsageError, floats, shown_value
from aomc_sky.record import same_content
from aomc_sky.whole_number import as_index

MAX_PATCHES = 2**27
"""As many as a sky file may have."""


@in_both_units
@dataclass(eq=False, frozen=True, kw_only=True, slots=True)
class PatchGrid:
    """A product of zenith rings and azimuth columns, patches zenith-major.

    Parameters
    ----------
    zenith_bounds_deg, or zenith_bounds_rad : ndarray, float64, shape (n_zenith, 2)
        Near and far edge of each ring, 0 overhead; they rise and do not overlap. [deg, 0 to 90]
    azimuth_bounds_deg, or azimuth_bounds_rad : ndarray, float64, shape (n_azimuth, 2)
        Start and end of each column; they rise within a turn and do not overlap. The first may start below 0. [deg]
    azimuth_first_index : int
        File index of the first column: 0 as the format says, 1 for `--azimuth-bins n`.

    Notes
    -----
    Bounds are kept in degrees, so that the whole degrees of a file stay exact; everything that
    leaves the grid is in radians, cosines or steradians. A ring or column of zero extent is a lattice
    line, which is how the AOMC program reads a table.

    Examples
    --------
    >>> grid = sky.PatchGrid(
    ...     zenith_bounds_deg=[[0.0, 45.0], [45.0, 90.0]], azimuth_bounds_deg=[[0.0, 360.0]]
    ... )
    >>> print((grid.projected_solid_angle_sr / np.pi).round(6))
    [0.5 0.5]
    """

    zenith_bounds_deg: np.ndarray = None  # type: ignore[assignment]
    azimuth_bounds_deg: np.ndarray = None  # type: ignore[assignment]
    azimuth_first_index: int = 0
    zenith_bounds_rad: InitVar[np.ndarray | None] = None
    azimuth_bounds_rad: InitVar[np.ndarray | None] = None

    def __post_init__(self, zenith_bounds_rad: np.ndarray | None, azimuth_bounds_rad: np.ndarray | None) -> None:
        for name, twin in (("zenith_bounds_deg", zenith_bounds_rad), ("azimuth_bounds_deg", azimuth_bounds_rad)):
            object.__setattr__(self, name, given_angle(name, getattr(self, name), twin))
        for name in ("zenith_bounds_deg", "azimuth_bounds_deg"):
            bounds = np.array(floats(name, getattr(self, name)))
            if bounds.ndim != 2 or bounds.shape[1] != 2 or bounds.shape[0] == 0:
                raise SceneError(f"{name} must have shape (n, 2) with n >= 1, got {bounds.shape}")
            if not np.all(np.isfinite(bounds)) or np.any(bounds[:, 1] < bounds[:, 0]):
                raise SceneError(f"{name} must be finite with every start <= end")
            has_extent = bool(np.any(bounds[:, 1] > bounds[:, 0]))  # points of a lattice may be anywhere
            if has_extent and np.any(bounds[1:, 0] < bounds[:-1, 1] - EDGE_DEG):
                k = int(np.argmax(bounds[1:, 0] < bounds[:-1, 1] - EDGE_DEG))
                one, other = (f"{low:g} to {high:g}" for low, high in bounds[k : k + 2])
                raise SceneError(f"{name} must rise and not overlap, got {one} before {other}")
            if has_extent and bounds[-1, 1] - bounds[0, 0] > 360.0 + EDGE_DEG:
                raise SceneError(f"{name} must not pass a whole turn, got {bounds[0, 0]:g} to {bounds[-1, 1]:g}")
            bounds.flags.writeable = False
            object.__setattr__(self, name, bounds)
        if self.zenith_bounds_deg.min() < 0 or self.zenith_bounds_deg.max() > 90:
            raise SceneError("zenith bounds must lie within 0 to 90 degrees")

    __eq__ = same_content

    def __repr__(self) -> str:
        spans = [
            f"{bounds.shape[0]} of {what} {bounds.min():g} to {bounds.max():g} degrees"
            for what, bounds in (("zenith", self.zenith_bounds_deg), ("azimuth", self.azimuth_bounds_deg))
        ]
        return f"PatchGrid({', '.join(spans)})"

    @classmethod
    def regular(cls, n_zenith: int, n_azimuth: int, *, azimuth_first_index: int = 0) -> PatchGrid:
        """Equal bins of the upper hemisphere, from overhead to the horizon.

        Parameters
        ----------
        n_zenith, n_azimuth : int
            Number of rings and of columns. [1 or more]
        azimuth_first_index : int
            File index of the first column.

        Returns
        -------
        PatchGrid
            Rings of 90/n_zenith degrees, columns of 360/n_azimuth degrees from azimuth 0.
        """
        n_zenith, n_azimuth = as_index(n_zenith, "n_zenith"), as_index(n_azimuth, "n_azimuth")
        if n_zenith < 1 or n_azimuth < 1:
            raise SceneError(f"a grid needs at least one ring and one column, got {n_zenith} x {n_azimuth}")
        if n_zenith * n_azimuth > MAX_PATCHES:
            raise SceneError(f"a grid has at most 2^27 = {MAX_PATCHES} patches, got {n_zenith} x {n_azimuth}")
        zenith = np.arange(n_zenith + 1) * 90.0 / n_zenith
        azimuth = np.arange(n_azimuth + 1) * 360.0 / n_azimuth
        return cls(
            zenith_bounds_deg=np.column_stack([zenith[:-1], zenith[1:]]),
            azimuth_bounds_deg=np.column_stack([azimuth[:-1], azimuth[1:]]),
            azimuth_first_index=as_index(azimuth_first_index, "azimuth_first_index"),
        )

    @classmethod
    def whole_degrees(cls) -> PatchGrid:
        """Cells around whole degrees: zenith 1 to 89, azimuth 0 to 359, covering the hemisphere.

        Returns
        -------
        PatchGrid
            Rings [z - 1/2, z + 1/2], except [0, 1.5] for 1 and [88.5, 90] for 89; columns
            [a - 1/2, a + 1/2].
        """
        z = np.arange(1.0, 90.0)
        zenith = np.column_stack([z - 0.5, z + 0.5])
        zenith[0, 0], zenith[-1, 1] = 0.0, 90.0
        a = np.arange(360.0)
        return cls(zenith_bounds_deg=zenith, azimuth_bounds_deg=np.column_stack([a - 0.5, a + 0.5]))

    @classmethod
    def lattice(cls, n_zenith: int, n_azimuth: int) -> PatchGrid:
        """Whole-degree points as the AOMC program takes them: zenith 1.., azimuth 0.., no extent.

        Zenith indices beyond 90 degrees stay at the horizon; they never carry mass.

        Parameters
        ----------
        n_zenith, n_azimuth : int
            Number of zenith indices (from 1) and of azimuth indices (from 0).

        Returns
        -------
        PatchGrid
            Points, not areas: every solid angle is 0.
        """
        z = np.minimum(np.arange(1.0, as_index(n_zenith, "n_zenith") + 1.0), 90.0)
        a = np.arange(float(as_index(n_azimuth, "n_azimuth")))
        return cls(zenith_bounds_deg=np.column_stack([z, z]), azimuth_bounds_deg=np.column_stack([a, a]))

    @property
    def n_zenith(self) -> int:
        """Number of zenith rings."""
        return int(self.zenith_bounds_deg.shape[0])

    @property
    def n_azimuth(self) -> int:
        """Number of azimuth columns."""
        return int(self.azimuth_bounds_deg.shape[0])

    @property
    def n_patches(self) -> int:
        """Number of patches, rings times columns."""
        return self.n_zenith * self.n_azimuth

    @property
    def mu_edges(self) -> np.ndarray:
        """Cosine of the ring edges from overhead to the horizon, shape (n_zenith + 1,)."""
        edges = np.append(self.zenith_bounds_deg[:, 0], self.zenith_bounds_deg[-1, 1])
        return sin_cos_deg(edges)[1]

    @property
    def azimuth_edges_rad(self) -> np.ndarray:
        """Column edges, shape (n_azimuth + 1,). [rad]"""
        return np.deg2rad(np.append(self.azimuth_bounds_deg[:, 0], self.azimuth_bounds_deg[-1, 1]))

    def ring_mu(self) -> tuple[np.ndarray, np.ndarray]:
        """Cosines of the near and the far edge of each ring, each of shape (n_zenith,)."""
        near, far = sin_cos_deg(self.zenith_bounds_deg.T)[1]
        return near, far

    def ring_sin2(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """sin^2 at the near edge, its growth to the far edge, cos^2 at the far edge; each (n_zenith,).

        The growth is sin(far - near) sin(far + near): no cancellation at zenith or horizon.
        """
        near, far = self.zenith_bounds_deg.T
        sine, cosine = sin_cos_deg([near, far - near, far + near, far])
        return sine[0] ** 2, sine[1] * sine[2], cosine[3] ** 2

    def ring_one_minus_mu(self) -> tuple[np.ndarray, np.ndarray]:
        """1 - mu at the near edge and its growth to the far edge, without cancellation; each (n_zenith,)."""
        near, far = self.zenith_bounds_deg.T
        sine = sin_cos_deg([near / 2, (far + near) / 2, (far - near) / 2])[0]
        return 2.0 * sine[0] ** 2, 2.0 * sine[1] * sine[2]

    @property
    def solid_angle_sr(self) -> np.ndarray:
        """Solid angle of each patch, zenith-major, shape (n_patch,). [sr]"""
        return np.outer(self.ring_one_minus_mu()[1], self._width_rad()).ravel()

    @property
    def projected_solid_angle_sr(self) -> np.ndarray:
        """Cosine-weighted solid angle of each patch, zenith-major, shape (n_patch,). [sr]"""
        return np.outer(self.ring_sin2()[1] / 2.0, self._width_rad()).ravel()

    def _width_rad(self) -> np.ndarray:
        return np.deg2rad(self.azimuth_bounds_deg[:, 1] - self.azimuth_bounds_deg[:, 0])

    def index_of(self, patch: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """File indices of patches: zenith 1-based, azimuth from `azimuth_first_index`.

        Parameters
        ----------
        patch : ndarray, int
            Patch numbers. [0 to n_patches - 1]

        Returns
        -------
        zenith_index_1based, azimuth_index : ndarray, int64
            As they stand in skydist.inp.
        """
        given = np.asarray(patch)
        if given.dtype.kind not in "iu" and given.size:
            raise UsageError(f"patch must be whole numbers, got {shown_value(patch)}")
        if given.size and not (given.min() >= 0 and given.max() < self.n_patches):
            raise IndexError(f"patches run from 0 to {self.n_patches - 1}, got {given.min()} to {given.max()}")
        ring, column = np.divmod(given.astype(np.int64), self.n_azimuth)
        return ring + 1, column + self.azimuth_first_index

    def patch_of(self, sky_zenith_deg: np.ndarray, sky_azimuth_deg: np.ndarray) -> np.ndarray:
        """Patch that each sky direction lies in, -1 outside all patches.

        Parameters
        ----------
        sky_zenith_deg, sky_azimuth_deg : ndarray, one shape
            Sky directions. [deg, 0 to 90 and any turn]

        Returns
        -------
        ndarray, int64
            Edges belong to the patch that starts there, the horizon to the last ring.
        """
        zenith = floats("sky_zenith_deg", sky_zenith_deg)
        ring = np.searchsorted(self.zenith_bounds_deg[:, 0], zenith, side="right") - 1
        inside = (ring >= 0) & (zenith <= self.zenith_bounds_deg[np.maximum(ring, 0), 1])
        first = self.azimuth_bounds_deg[0, 0]
        azimuth = first + np.mod(floats("sky_azimuth_deg", sky_azimuth_deg) - first, 360.0)
        column = np.searchsorted(self.azimuth_bounds_deg[:, 0], azimuth, side="right") - 1
        inside &= azimuth <= self.azimuth_bounds_deg[column, 1]
        return np.where(inside, ring * self.n_azimuth + column, -1)
