"""The input of the sampler: components with their laws and arrays. It knows no sky, no file and no generator."""

from __future__ import annotations

import dataclasses
import enum
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.directions import sin_cos_deg
from aomc_sky.errors import SceneError, UsageError, floats, shown_value, unmasked
from aomc_sky.grid import PatchGrid
from aomc_sky.record import same_content


class Law(enum.IntEnum):
    """How photons lie inside one cell; the number is part of plan.npz and never changes.

    CELL_MU2
        Uniform in mu^2 and in azimuth: the flux through a horizontal surface of a radiance that is
        constant inside the cell. A cell of zero extent is a direction.
    CELL_MU
        Uniform in mu and in azimuth: constant radiance, counted per solid angle.
    BEAM
        One direction.
    DISC
        Uniform radiance over a disc on the sky that lies above the horizon, flux law.
    DISC_AT_HORIZON
        The same for a disc that the horizon cuts.
    PEREZ
        The flux of the Perez luminance inside the cell, exactly: `shared` and `bounds` say which.
    HG, GGX, BECKMANN
        The flux of one lobe of a background sky above the horizon, exactly: density of the lobe times cosine of the
        zenith angle. One cell; `shared` is the lobe, `bounds` the envelope of its sampler.
    CELL_SLOPED
        As CELL_MU2, with the density (1 + s (2 u - 1)) (1 + t (2 v - 1)) at the place (u, v) in the cell. From the near
        to the far edge, u counts in sin^2; v runs along the azimuth. The numbers s and t are in `slope`.

    Examples
    --------
    >>> [
    ...     component.law
    ...     for component in sky.read_scene("inputs/clear_day", iterations=1000).components
    ... ]
    [<Law.CELL_MU2: 0>]
    """

    CELL_MU2 = 0
    CELL_MU = 1
    BEAM = 2
    DISC = 3
    DISC_AT_HORIZON = 4
    PEREZ = 5
    HG = 6
    GGX = 7
    BECKMANN = 8
    CELL_SLOPED = 9


N_CELL_PARAMETERS = 6
MOST_WEIGHT = 1e38
"""Largest weight of photons: float32 has it, too."""

MAX_SLOPE = 1.0 - 2.0**-10
"""Steepest slope of `Law.CELL_SLOPED`: at 1 the edge of a cell is dark."""


def cells_of_grid(grid: PatchGrid, law: Law = Law.CELL_MU2) -> np.ndarray:
    """Parameters of the patches of a grid as cells of `Law.CELL_MU2`, `Law.PEREZ` (the same) or `Law.CELL_MU`.

    As `aomc_sky.kernels.cells.laws` lists them, shape (n_patch, 6): growth from the near to the far edge without
    cancellation, half the width in quarter turns, sine and cosine of the centre azimuth. Lines and points are allowed.
    """
    if law is not Law.CELL_MU:
        near, growth, far = grid.ring_sin2()
    else:
        near, growth = grid.ring_one_minus_mu()
        far = grid.ring_mu()[1]
    start, end = grid.azimuth_bounds_deg[:, 0], grid.azimuth_bounds_deg[:, 1]
    sine, cosine = sin_cos_deg((start + end) / 2)
    cell = np.empty((grid.n_zenith, grid.n_azimuth, N_CELL_PARAMETERS))
    cell[:, :, 0] = near[:, None]
    cell[:, :, 1] = growth[:, None]
    cell[:, :, 2] = far[:, None]
    cell[:, :, 3] = (end - start) / 180.0
    cell[:, :, 4] = sine
    cell[:, :, 5] = cosine
    return cell.reshape(-1, N_CELL_PARAMETERS)


def slope_factor(
    slope: np.ndarray,
    grid: PatchGrid,
    sin2: tuple[np.ndarray, ...],
    patch: np.ndarray,
    sky_zenith_rad: np.ndarray,
    sky_azimuth_deg: np.ndarray,
) -> np.ndarray:
    """Radiance in a direction over the mean of its patch, for slopes (..., 2); `sin2` is `grid.ring_sin2()`."""
    ring, column = np.divmod(np.maximum(patch, 0), grid.n_azimuth)
    start, end = grid.azimuth_bounds_deg[column, 0], grid.azimuth_bounds_deg[column, 1]
    first = grid.azimuth_bounds_deg[0, 0]
    azimuth = first + np.mod(sky_azimuth_deg - first, 360.0)  # as in `PatchGrid.patch_of`: both round alike at an edge
    u = np.clip((np.sin(sky_zenith_rad) ** 2 - sin2[0][ring]) / sin2[1][ring], 0.0, 1.0)
    v = np.clip((azimuth - start) / (end - start), 0.0, 1.0)
    s, t = np.moveaxis(slope, -1, 0)
    return np.asarray((1.0 + s * (2.0 * u - 1.0)) * (1.0 + t * (2.0 * v - 1.0)))


def is_polarisation(stokes: np.ndarray) -> bool:
    """Whether all Q/I and U/I (..., 2) are those of light: finite, with a degree of at most 1 within rounding."""
    return bool(np.all(np.abs(stokes) <= 1.0 + 1e-9) and np.all(np.hypot(*np.moveaxis(stokes, -1, 0)) <= 1.0 + 1e-9))


@dataclass(eq=False, frozen=True, kw_only=True, slots=True)
class Component:
    """One part of the light: a law, its cells, and how much light each cell holds per wavelength.

    Parameters
    ----------
    name : str
        Unique inside a scene; appears in counts.csv and the manifest.
    law : Law
        How photons lie inside a cell.
    strength : ndarray, float64, shape (n_wl,)
        Relative irradiance of the component. [0 to inf]
    mass : ndarray, float64, shape (n_wl, n_cell) or (1, n_cell)
        Share of each cell, any positive scale per row; one row serves all wavelengths. [0 to inf]
    cell : ndarray, float64, shape (n_cell, 6)
        Parameters of the law for each cell; see `aomc_sky.kernels.cells.laws`.
    grid : PatchGrid or None
        The patches that the cells are, in the same order; None for a beam or a disc.
    weight : ndarray, float64, shape of mass, or None
        Weight of a photon of the cell where the launch law is not the flux law; for `Law.CELL_MU`
        the photon's cosine multiplies it. None where every weight is 1.
    shared : ndarray, float64, shape (11,) or (10,), or None
        `Law.PEREZ`: coefficients a to e; the sun's zenith angle and azimuth in quarter turns, the
        sine of the first; the unit vector to the sun. Lobes: the matrix M of `aomc_sky.skies.lobes.envelope` row by
        row, and g.
    bounds : ndarray, float64, shape (n_cell, 4) or (n, 8), or None
        `Law.PEREZ`, of each cell: the tilts k_u, k_v in the last two columns, multiples of 2^-11 up to 0.2 in
        size, by which the position (u, v) moves to u + k_u u (1 - u), v + k_v v (1 - v) before the rejection; in the
        first two an upper and a lower bound of the luminance there x (1 + k_u (1 - 2u)) (1 + k_v (1 - 2v)).
        Lobes: the envelope, see `aomc_sky.skies.lobes.envelope`.
    slope : ndarray, float64, shape (n_wl, n_cell, 2) or (1, n_cell, 2), or None
        `Law.CELL_SLOPED`: how the light changes inside each cell, see there. [-1 to 1, `MAX_SLOPE` at most]
    stokes : ndarray, float64, shape (n_wl, n_cell, 2) or (1, n_cell, 2), or None
        Q/I and U/I of the light of each cell, its mean weighted by flux, in the meridian plane of the photon; see
        docs/conventions.md. None where the light is not polarised. [-1 to 1, the degree at most 1]
    irradiance_W_m2_nm : ndarray, float64, shape (n_wl,), or None
        Irradiance of the horizontal plane where it is known in absolute units. [W m-2 nm-1, 0 to inf]
    below_horizon : float
        Share of the component's light, as its source gives it, that lies below the horizon and sends no photons.
        [0 to 1]

    Examples
    --------
    >>> (beam,) = sky.DirectBeam(sun_zenith_deg=30.0).lower(np.array([550.0]))
    >>> beam.name, beam.law, beam.mass.shape
    ('direct', <Law.BEAM: 2>, (1, 1))
    """

    name: str
    law: Law
    strength: np.ndarray
    mass: np.ndarray
    cell: np.ndarray
    grid: PatchGrid | None = None
    weight: np.ndarray | None = None
    shared: np.ndarray | None = None
    bounds: np.ndarray | None = None
    slope: np.ndarray | None = None
    stokes: np.ndarray | None = None
    irradiance_W_m2_nm: np.ndarray | None = None  # noqa: N815
    below_horizon: float = 0.0

    __eq__ = same_content

    def __repr__(self) -> str:
        rows = "" if self.strength.size == 1 else f", {self.strength.size} rows"
        return f"<Component {self.name!r}: {self.law.name}, {self.n_cells} cell{'s' * (self.n_cells != 1)}{rows}>"

    def __post_init__(self) -> None:
        if self.law not in tuple(Law):
            raise UsageError(f"{shown_value(self.law)} is not a valid Law", "write sky.component.Law.CELL_MU2")
        object.__setattr__(self, "law", Law(self.law))
        names = ("strength", "mass", "cell", "weight", "shared", "bounds", "slope", "stokes", "irradiance_W_m2_nm")
        for name, value in zip(names, unmasked("a component", [getattr(self, name) for name in names]), strict=True):
            if value is not None:
                array = np.ascontiguousarray(floats(name, value))
                array.flags.writeable = False
                object.__setattr__(self, name, array)
        n_wl, n_cell = self.mass.shape
        fits = n_wl in (1, self.strength.size) and (self.weight is None or self.weight.shape == self.mass.shape)
        if self.strength.ndim != 1 or not fits or self.cell.shape != (n_cell, N_CELL_PARAMETERS):
            raise ValueError(
                f"component {self.name!r}: strength {self.strength.shape} and cell {self.cell.shape} "
                f"do not fit mass {self.mass.shape}; expected (n_wl,), (n_wl or 1, n_cell) and "
                f"(n_cell, {N_CELL_PARAMETERS})"
            )
        for name in ("slope", "stokes"):
            value = getattr(self, name)
            if value is not None and (value.ndim != 3 or value.shape[1:] != (n_cell, 2) or len(value) not in (1, n_wl)):
                raise ValueError(
                    f"component {self.name!r}: {name} {value.shape}; expected (n_wl or 1, n_cell, 2) as in mass"
                )
        if self.stokes is not None and not is_polarisation(self.stokes):
            raise ValueError(f"component {self.name!r}: stokes wants Q/I and U/I of a degree from 0 to 1")
        if (self.slope is None) == (self.law is Law.CELL_SLOPED) or (
            self.slope is not None and not np.all(np.abs(self.slope) <= MAX_SLOPE)
        ):
            raise ValueError(f"component {self.name!r}: law CELL_SLOPED, and no other, has slopes up to {MAX_SLOPE}")
        if (self.shared is None) != (self.bounds is None):
            raise ValueError(f"component {self.name!r}: a law needs both shared and bounds, or neither")
        for name in ("strength", "mass"):
            value = getattr(self, name)
            if not np.all(np.isfinite(value)) or np.any(value < 0):
                raise SceneError(f"component {self.name!r}: {name} must be finite and not negative")
        if self.weight is not None and not np.all((self.weight >= 0) & (self.weight <= MOST_WEIGHT)):
            raise SceneError(f"component {self.name!r}: weight must be from 0 to {MOST_WEIGHT:g}")

    @property
    def n_cells(self) -> int:
        """Number of cells."""
        return int(self.mass.shape[1])

    def mass_of(self, row: int) -> np.ndarray:
        """Masses of one wavelength, shape (n_cell,), any scale."""
        return self.mass[row if len(self.mass) > 1 else 0]

    def weight_of(self, row: int) -> np.ndarray | None:
        """Photon weights per cell of one wavelength, shape (n_cell,), or None where all are 1."""
        return None if self.weight is None else self.weight[row if len(self.weight) > 1 else 0]

    def of_row(self, row: int) -> Component:
        """The component of one wavelength, with one row of everything."""
        names = ("strength", "mass", "weight", "slope", "stokes", "irradiance_W_m2_nm")
        arrays = {name: getattr(self, name) for name in names}
        own = {k: v if v is None or len(v) == 1 else v[row : row + 1] for k, v in arrays.items()}
        return dataclasses.replace(self, **own)


@dataclass(frozen=True, kw_only=True, slots=True)
class CellLaw:
    """What a law needs: entries are in `plan/laws.py`. A fact that the law does not have is None or an empty text.

    The formula of `directions` is also in `direction_of` of the kernels and `direction` of aomc_sky.h.
    """

    #: Mean of mu and of 1 / mu over each cell of a component, (n_cell,) each; of its first row.
    moments: Callable[[Component], tuple[np.ndarray, np.ndarray]]
    #: Which cells (n_cell, 6) send photons down to the horizon, so that the mean of 1 / mu^2 is infinite.
    reaches_horizon: Callable[[np.ndarray], np.ndarray] = lambda cell: cell[:, 2] <= 0
    #: Function of the zenith angle in which the photons of a ring are counted, and spread evenly without `flux`. [deg]
    coordinate: Callable[[np.ndarray], np.ndarray] = lambda zenith_deg: np.sin(np.deg2rad(zenith_deg)) ** 2
    #: Flux (n_ring, n_column) through rings and columns, where photons are uneven inside cells; of the first row of a
    #: component. [ends (n, 2) in deg]
    flux: Callable[[Component, np.ndarray, np.ndarray], np.ndarray] | None = None
    #: Share of the flux in each patch of a whole hemisphere, where one cell without centre covers the sky.
    shares: Callable[[Component, PatchGrid], np.ndarray] | None = None
    #: Gives a function for a component: the radiance at (irradiance on a horizontal plane, zenith angle, azimuth)
    #: [rad], where the law is not constant in patches. The function can be pickled.
    radiance: Callable[[Component], Callable[[float, np.ndarray, np.ndarray], np.ndarray]] | None = None
    #: Smallest angle over which the light of such a cell changes. [rad]
    width_rad: Callable[[Component], float] = lambda component: math.inf
    #: Zenith angle and azimuth of its axis, and the angle about it that holds half of the light. [deg]
    axis_deg: Callable[[Component], tuple[float, float, float]] | None = None
    #: Zenith angle and azimuth of the sun of a sky, (2,). [deg]
    sun_deg: Callable[[Component], np.ndarray] | None = None
    #: Zenith angle and radius of light that comes from one direction, radius 0, or from a disc; from the six parameters
    #: of its cell. [rad]
    beam: Callable[[list[float]], tuple[float, float]] | None = None
    needs_patches: bool = False  #: Whether a component must have a grid.
    has_slopes: bool = False  #: Whether it has `Component.slope`.
    instead: str = ""  #: What further components can be, where a scene can have one component of the law.
    leave_out: str = ""  #: How to take the component out of a scene, for a program that does not know its law.
    #: Shapes of `Component.shared` and `bounds`, from the numbers of cells and of rows of `bounds`.
    tables: Callable[[int, int], tuple[tuple[int, ...], tuple[int, ...]]] | None = None
    #: The member of a plan that no kernel may read by, what was found there, and what is allowed; from the cells
    #: (n_cell, 6) and `bounds`.
    refused: Callable[[np.ndarray, np.ndarray | None], tuple[str, str, str] | None] = lambda cell, bounds: None

    #: Travel directions in plain numpy, from the six parameters of each photon's cell, u, v, key, rank and band.
    directions: Callable[..., Any] | None = None
    #: The law whose directions they are instead, where slopes come before them or a rejection after them.
    starts_as: Law | None = None
    #: Hook that the emission calls: "perez", "lobes" or none.
    hook: Literal["", "perez", "lobes"] = ""
    #: Makes the tables of the hook from the components of a plan: an object with `for_slots(slots)`.
    hook_tables: Callable[[Sequence[Component]], Any] | None = None

    @property
    def is_beam(self) -> bool:
        """Whether the light comes from one direction or from a disc."""
        return self.beam is not None

    @property
    def covers_sky(self) -> bool:
        """Whether its one cell covers the whole sky."""
        return self.shares is not None


def scaled(components: Iterable[Component], factor: ArrayLike) -> list[Component]:
    """Components with their strengths times a factor, one or one for each wavelength."""
    return [dataclasses.replace(c, strength=c.strength * factor) for c in components]
