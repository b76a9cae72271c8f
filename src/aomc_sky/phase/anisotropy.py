"""Three numbers for one property of a molecule: anisotropy gamma, depolarisation factor rho, King factor F.

gamma = rho / (2 - rho), rho = 2 gamma / (1 + gamma), F = (6 + 3 rho) / (6 - 7 rho) = 3 (1 + 2 gamma) / (3 - 4 gamma).
rho is the depolarisation factor for natural light [bucholtz1995].
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.errors import UsageError
from aomc_sky.phase.vectorised import checked, evaluate, precision_of


def gamma_from_rho(rho: ArrayLike) -> Any:
    """Anisotropy gamma of the phase function from the depolarisation factor rho. [both 0 to 1]

    Raises
    ------
    UsageError
        rho is outside 0 to 1 or NaN.
    """
    kind = precision_of(rho)
    return evaluate(lambda x: (x / (2.0 - x),), kind, checked("rho", rho, kind, 0.0, 1.0))[0]


def rho_from_gamma(gamma: ArrayLike) -> Any:
    """Depolarisation factor rho for natural light from gamma. [both 0 to 1]

    Raises
    ------
    UsageError
        gamma is outside 0 to 1 or NaN.
    """
    kind = precision_of(gamma)
    return evaluate(lambda x: ((x + x) / (1.0 + x),), kind, checked("gamma", gamma, kind, 0.0, 1.0))[0]


def king_factor(gamma: ArrayLike) -> Any:
    """King factor F of the scattering cross section. [1 at gamma 0, without bound towards gamma 3/4]

    Raises
    ------
    UsageError
        gamma is not in [0, 3/4): a symmetric polarisability has no larger one.
    """
    kind = precision_of(gamma)
    g = checked("gamma", gamma, kind, 0.0, 0.75)
    if np.any(g == 0.75):
        raise UsageError("the King factor has a pole at gamma = 3/4; give a smaller gamma")
    return evaluate(lambda x: ((3.0 + 6.0 * x) / (3.0 - 4.0 * x),), kind, g)[0]


def gamma_from_king_factor(king: ArrayLike) -> Any:
    """Anisotropy gamma from the King factor, 3 (F - 1) / (4 F + 6). [F at least 1]

    Raises
    ------
    UsageError
        F is below 1, infinite or NaN.
    """
    kind = precision_of(king)
    F = checked("the King factor", king, kind, 1.0, float(np.finfo(kind).max))
    return evaluate(lambda x: (0.75 * ((x - 1.0) / (x + 1.5)),), kind, F)[0]
