"""One lobe before the horizon in the frame of its sampler: shares of the lobe and an azimuth become a direction.

A direction of a lobe has two coordinates, each uniform: the share b of the lobe that is farther from the axis, and the
azimuth psi in the stretched plane, counted from where the horizon is farthest or the zenith nearest. With a = 1 - b::

    hg        p = (1-g)^2 a (1 + g b), q = (1+g)^2 b (1 - g + g b);   R = 2 sqrt(p q), Z = q - p
    ggx       R = sqrt(a), Z = sqrt(b)
    beckmann  R = sqrt(-log b), Z = 1

and the direction is M (R cos psi, R sin psi, Z), normalised. The last row of M is (k, 0, n_z), so the cosine of the
zenith angle is (n_z Z + k R cos psi) / sqrt(Z^2 + R^2 r^2), r(psi) being the stretch in that direction.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aomc_sky.component import Component, Law
from aomc_sky.phase import henyey_greenstein
from aomc_sky.skies.lobes.laws import checked
from aomc_sky.skies.lobes.quaternion import rotation_matrix

LAWS = {"hg": Law.HG, "ggx": Law.GGX, "beckmann": Law.BECKMANN}
_KINDS = {law: kind for kind, law in LAWS.items()}
_RELATIVE_SLACK = 1e-9
_SLACK = 4e-15
_FAR = 1e100


@dataclass(frozen=True, kw_only=True, slots=True)
class LobeFrame:
    """A lobe turned to the horizon."""

    kind: str
    asymmetry: float  #: g of "hg", else 0. [0 <= g < 1]
    stretch: tuple[float, float]  #: Roughness along local x and y; 1 for "hg". [> 0]
    matrix: np.ndarray  #: M of the module's text, shape (3, 3).
    turn: float  #: Azimuth in the stretched plane where psi is 0. [quarter turns]

    @classmethod
    def of(cls, kind: str, param0: float, param1: float, quaternion: np.ndarray) -> LobeFrame:
        """The frame of a lobe; parameters and errors as for `laws.pdf` and `rotation_matrix`."""
        first, second = (float(x) for x in checked(kind, param0, param1))
        stretch = (1.0, 1.0) if kind == "hg" else (first, second)
        matrix = rotation_matrix(quaternion) * np.array([*stretch, 1.0])
        along_x, along_y, up = matrix[2]
        k = float(np.hypot(along_x, along_y))
        c, s = (along_x / k, along_y / k) if k > 0.0 else (1.0, 0.0)
        turned = np.stack([matrix[:, 0] * c + matrix[:, 1] * s, matrix[:, 1] * c - matrix[:, 0] * s, matrix[:, 2]], 1)
        turned[2] = k, 0.0, up
        asymmetry = first if kind == "hg" else 0.0
        turn = float(np.arctan2(s, c)) * (2 / np.pi)
        return cls(kind=kind, asymmetry=asymmetry, stretch=stretch, matrix=turned, turn=turn)

    def largest_share(self) -> float:
        """No direction with a larger b is above the horizon; 1 where the axis is. [0 to 1]"""
        k, _, up = self.matrix[2]
        if up >= 0.0:
            return 1.0
        if k == 0.0:
            return 1.0 if self.kind == "hg" else 0.0
        slope = -up / k
        if self.kind == "hg":
            share = float(henyey_greenstein.cdf(up * up / (1.0 + k), self.asymmetry))
        elif self.kind == "ggx":
            share = 1.0 / (1.0 + slope * slope)
        else:
            share = float(np.exp(-min(slope * slope, 1e4)))
        return min(share * (1.0 + _RELATIVE_SLACK), 1.0)

    def height(self, a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """R and Z."""
        if self.kind == "hg":
            g = self.asymmetry
            p, q = (1.0 - g) ** 2 * a * (1.0 + g * b), (1.0 + g) ** 2 * b * (1.0 - g + g * b)
            return 2.0 * np.sqrt(p * q), q - p
        if self.kind == "ggx":
            return np.sqrt(a), np.sqrt(b)
        with np.errstate(divide="ignore"):
            radius = np.sqrt(-np.where(a < 0.25, np.log1p(-np.minimum(a, 0.5)), np.log(b)))
        return radius, np.ones_like(radius)

    def stretch_at(self, psi: np.ndarray) -> np.ndarray:
        """The stretch r at azimuths in quarter turns."""
        phi = (psi + self.turn) * (np.pi / 2)
        return np.hypot(self.stretch[0] * np.cos(phi), self.stretch[1] * np.sin(phi))

    def cosine(self, a: np.ndarray, b: np.ndarray, psi: np.ndarray) -> np.ndarray:
        """Cosine of the zenith angle, 0 below the horizon."""
        radius, z = self.height(a, b)
        k, _, up = self.matrix[2]
        value = up * z + k * radius * np.cos(psi * (np.pi / 2))
        return np.maximum(value, 0.0) / np.hypot(z, radius * self.stretch_at(psi))

    def upper_bound(self, a: np.ndarray, b: np.ndarray, psi: np.ndarray) -> np.ndarray:
        """Upper bound of `cosine` over cells; arguments hold both ends, shape (2, n): a falls, b and psi rise.

        With the largest cosine c of psi and the smallest r in the cell, the numerator n_z Z + k R c over the root is an
        upper bound where it is positive; as a function of tan t = R r / Z it is N cos(t - t0), whose maximum between
        two ends is known. Rounding is covered by a margin of 1e-9 of itself.
        """
        least = self._least_stretch(psi)
        cosines = np.cos(psi * (np.pi / 2))
        largest = np.where((psi[0] <= 0.0) & (psi[1] >= 0.0), 1.0, cosines.max(axis=0))
        k, _, up = self.matrix[2]
        radius, z = self.height(a, b)
        radius = np.minimum(radius, _FAR)
        length = np.hypot(z, radius * least)
        above, beside = up * z / length, k * largest * radius / length
        slack = _SLACK * (np.abs(above) + np.abs(beside)).max(axis=0)
        side = k * largest / least
        angle, peak = np.arctan2(radius * least, z), np.arctan2(side, up)
        is_inside = (angle.min(axis=0) <= peak) & (peak <= angle.max(axis=0))
        value = np.where(is_inside, np.hypot(up, side), (above + beside).max(axis=0)) + slack
        return np.maximum(value, 0.0) * (1.0 + _RELATIVE_SLACK)

    def _least_stretch(self, psi: np.ndarray) -> np.ndarray:
        """Lower bound of r over azimuths: between whole quarter turns it is monotonic."""
        low, high = np.ceil(psi[0] + self.turn - 1e-12), np.floor(psi[1] + self.turn + 1e-12)
        least = self.stretch_at(psi).min(axis=0)
        for quarter in (low, high):
            extreme = np.where(np.mod(quarter, 2.0) == 0.0, *self.stretch)
            least = np.where(low <= high, np.minimum(least, extreme), least)
        return least * (1.0 - _RELATIVE_SLACK)


def lobe_of(component: Component) -> tuple[str, float, float, np.ndarray]:
    """Kind, both parameters and rotation (local to world) of the lobe that a component holds: `LobeFrame.of` backwards.

    Its matrix is R diag(stretch, 1) times a turn about the axis, so the stretches are the singular values of its first
    two columns.
    """
    assert component.shared is not None  # a lobe always has them
    matrix, asymmetry = component.shared[:9].reshape(3, 3), float(component.shared[9])
    kind = _KINDS[component.law]
    left, stretch, _ = np.linalg.svd(matrix[:, :2], full_matrices=False)
    axis = matrix[:, 2]
    rotation = np.stack([left[:, 0], np.cross(axis, left[:, 0]), axis], axis=1)
    if kind == "hg":
        return kind, asymmetry, 0.0, rotation
    return kind, float(stretch[0]), float(stretch[1]), rotation
