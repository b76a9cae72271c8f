"""The area of the sea surface that photons enter."""

from __future__ import annotations

import enum
from dataclasses import dataclass


class FootprintShape(enum.Enum):
    """Point, circle or rectangle, centred on the origin."""

    POINT = "point"
    CIRCLE = "circle"
    RECTANGLE = "rectangle"


@dataclass(frozen=True, kw_only=True, slots=True)
class Footprint:
    """Shape and size of the entry area.

    Parameters
    ----------
    shape : FootprintShape
        Which shape.
    size_x_m, size_y_m : float
        Diameter of a circle (both), sides of a rectangle, 0 for a point. [m]
    """

    shape: FootprintShape = FootprintShape.POINT
    size_x_m: float = 0.0
    size_y_m: float = 0.0
