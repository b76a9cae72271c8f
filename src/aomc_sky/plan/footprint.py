"""The area of the surface that photons enter."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass

from aomc_sky.errors import SceneError


class FootprintShape(enum.Enum):
    """Point, circle or rectangle, centred on the origin.

    Examples
    --------
    >>> sky.Footprint.rectangle(2.0, 1.0).shape
    <FootprintShape.RECTANGLE: 'rectangle'>
    """

    POINT = "point"
    CIRCLE = "circle"
    RECTANGLE = "rectangle"


@dataclass(frozen=True, kw_only=True, slots=True)
class Footprint:
    """Shape and size of the entry area.

    Parameters
    ----------
    shape : FootprintShape, or {"point", "circle", "rectangle"}
        Which shape. `Footprint.circle` and `Footprint.rectangle` are shorter.
    size_x_m, size_y_m : float
        Diameter of a circle (both), sides of a rectangle, 0 for a point. [m]

    Examples
    --------
    >>> scene = sky.Scene(
    ...     wavebands=[550.0],
    ...     n_photons=1000,
    ...     components="uniform",
    ...     footprint=sky.Footprint.circle(10.0),
    ... )
    >>> photons = scene.source().photons()
    >>> bool(np.hypot(photons.x, photons.y).max() < 5.0)
    True
    """

    shape: FootprintShape = FootprintShape.POINT
    size_x_m: float = 0.0
    size_y_m: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "shape", FootprintShape(self.shape))
        sizes = (self.size_x_m, self.size_y_m)
        if not all(math.isfinite(size) and size >= 0 for size in sizes):
            raise SceneError(f"the sizes of a footprint must be finite and not negative, got {sizes}")
        if self.shape is FootprintShape.CIRCLE and self.size_x_m != self.size_y_m:
            raise SceneError(f"a circle has one diameter, got {sizes}")

    @classmethod
    def circle(cls, diameter_m: float) -> Footprint:
        """A circle around the origin."""
        return cls(shape=FootprintShape.CIRCLE, size_x_m=diameter_m, size_y_m=diameter_m)

    @classmethod
    def rectangle(cls, size_x_m: float, size_y_m: float) -> Footprint:
        """A rectangle around the origin, its sides along x and y."""
        return cls(shape=FootprintShape.RECTANGLE, size_x_m=size_x_m, size_y_m=size_y_m)
