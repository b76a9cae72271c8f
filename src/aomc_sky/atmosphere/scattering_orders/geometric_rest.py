"""What the orders of scattering after the last one worked out would add."""

from __future__ import annotations

import numpy as np

_MODE_FLOOR = 1e-8  # a mode ends when what it would still add is this small a share of mode 0's sum
_REST_TOLERANCE = 1e-6
_SLOWEST = 0.95


class GeometricRest:
    """Watches how each mode shrinks from order to order, and says what all later orders would add.

    A mode of size s and ratio r to the order before leaves r / (1 - r) times itself. The ratio's own change d, the
    larger one of the last two steps, goes on as a geometric series of ratio q: an error of s d / (1 - q) / (1 - r)^2.
    """

    def __init__(self, n_modes: int) -> None:
        self._size = np.full(n_modes, np.nan)
        self._ratio = np.full(n_modes, np.nan)
        self._drift = np.full(n_modes, np.inf)
        self.gain = np.zeros(n_modes)
        self.error = np.inf
        self.n_active = n_modes

    def watch(self, moments: np.ndarray, total: np.ndarray, *, is_listed: bool) -> None:
        """Take in the moments of one more order, and the sum up to it; a listed order keeps what counts in itself."""
        n = moments.shape[1]
        size, scale = _mode_sizes(moments), max(float(_mode_sizes(total[:, :1])[0]), np.finfo(float).tiny)
        ratio = size / np.maximum(self._size[:n], np.finfo(float).tiny)
        short = np.maximum(1.0 - ratio, 1e-3)
        drift = np.abs(ratio - self._ratio[:n])
        self.gain = ratio / short
        worst = np.maximum(drift, self._drift[:n])
        slow = np.divide(drift, self._drift[:n], out=np.zeros(n), where=self._drift[:n] > 0.0)
        ahead = worst / (1.0 - np.minimum(slow, _SLOWEST))
        lit = size > 0.0
        self.error = float(np.max(size[lit] * ahead[lit] / short[lit] ** 2, initial=0.0) / scale)
        self._size, self._ratio, self._drift = size, ratio, np.where(np.isfinite(drift), drift, np.inf)
        floor = _MODE_FLOOR * min(scale, 100.0 * size[0]) if is_listed else _MODE_FLOOR * scale
        dead = size * self.gain <= floor  # false where the ratio is not known yet
        dead[0] = False
        self.n_active = int(np.max(np.nonzero(~dead)[0])) + 1

    @property
    def is_settled(self) -> bool:
        """Whether the rest is a geometric series to the tolerance."""
        return self.error <= _REST_TOLERANCE


def _mode_sizes(moments: np.ndarray) -> np.ndarray:
    return np.sqrt(np.einsum("pmlk,pmlk->m", moments, moments))
