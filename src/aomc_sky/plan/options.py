"""How a scene is sampled: the choices of one run, from the scene's preset and the caller, and its footprint."""

from __future__ import annotations

import enum
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, TypedDict

from numpy.typing import ArrayLike

from aomc_sky.errors import SceneError, UsageError, member_of, require_switch
from aomc_sky.plan.allocation import AllocationMethod, AllocationWord
from aomc_sky.whole_number import as_index_within

MAX_REPLICATES = 4096
"""An error bar of so many replicates is itself known to 1.1 %."""

MethodWord = Literal["stratified", "iid"]
PlacementWord = Literal["r2", "philox", "centre"]
OrderWord = Literal["shuffled", "patch"]
PrecisionWord = Literal["float32", "float64"]
ShapeWord = Literal["point", "circle", "rectangle"]


class Method(enum.Enum):
    """Dependence of photons on each other: stratified counts and points, or independent draws.

    Names are part of the keys of random streams. "sobol" was a method of early builds, so no other one may take it.
    """

    STRATIFIED = "stratified"
    IID = "iid"


class Placement(enum.Enum):
    """Position of a photon in its cell: the R2 sequence by rank, Philox, or the centre."""

    R2 = "r2"
    PHILOX = "philox"
    CENTRE = "centre"


class Order(enum.Enum):
    """Photons of a band in a keyed random order, or patch by patch."""

    SHUFFLED = "shuffled"
    PATCH = "patch"


class Precision(enum.Enum):
    """Precision of the emitted directions, positions and weights."""

    FLOAT32 = "float32"
    FLOAT64 = "float64"


@dataclass(frozen=True, kw_only=True, slots=True)
class SamplingOptions:
    """The choices that change photons, besides scene and seed.

    `replicates` independent randomisations share the photons of a band, for error bars.
    """

    method: Method = Method.STRATIFIED
    allocation: AllocationMethod = AllocationMethod.SYSTEMATIC
    placement: Placement = Placement.R2
    order: Order = Order.SHUFFLED
    precision: Precision = Precision.FLOAT32
    weights: bool = False
    replicates: int = 1


class Sampling(TypedDict, total=False):
    """Arguments of `Scene.source`, for functions that pass them on."""

    allocation: AllocationMethod | AllocationWord | None
    method: MethodWord | None
    placement: PlacementWord | None
    order: OrderWord | None
    precision: PrecisionWord
    weights: bool
    replicates: int
    bias: Mapping[str, float] | None
    importance: Mapping[str, ArrayLike | Callable[..., ArrayLike]] | None
    max_memory_bytes: int | None


_IID: dict[str, enum.Enum] = {"allocation": AllocationMethod.MULTINOMIAL, "placement": Placement.PHILOX}
"""Choices that follow from the method iid."""


def method_of(allocation: object, placement: object) -> Method:
    """The method of a choice of counts and places."""
    independent = allocation is AllocationMethod.MULTINOMIAL and placement is Placement.PHILOX
    return Method.IID if independent else Method.STRATIFIED


def resolve_options(
    preset: SamplingOptions,
    *,
    preset_name: str | None,
    allocation: object = None,
    method: object = None,
    placement: object = None,
    order: object = None,
    precision: object = "float32",
    weights: bool = False,
    replicates: object = 1,
) -> SamplingOptions:
    """The options of a run, from the caller or else the preset; a UsageError where they contradict each other."""
    choices = ("allocation", AllocationMethod, allocation), ("placement", Placement, placement), ("order", Order, order)
    chosen: dict[str, enum.Enum] = {
        name: member_of(kind, value, name) for name, kind, value in choices if value is not None
    }
    if method is not None and member_of(Method, method, "method") is Method.IID:
        for name, value in _IID.items():
            if chosen.setdefault(name, value) is not value:
                found = chosen[name].value
                raise UsageError(f"method 'iid' means {name} {value.value!r}, which contradicts {found!r}")
    if preset_name is not None:
        for name, value in chosen.items():
            if value is not getattr(preset, name):
                expected = getattr(preset, name).value
                raise UsageError(f"{preset_name} means {name} {expected!r}, which contradicts {value.value!r}")
    require_switch(weights, "weights")
    n_replicates = as_index_within(replicates, "replicates", 1, MAX_REPLICATES)
    if n_replicates > 1 and chosen.get("allocation", preset.allocation) is AllocationMethod.AOMC:
        raise UsageError("allocation 'aomc' has no randomness, so replicates cannot show its error")
    allocation, placement = chosen.get("allocation", preset.allocation), chosen.get("placement", preset.placement)
    return SamplingOptions(
        method=method_of(allocation, placement),
        allocation=allocation,  # type: ignore[arg-type]
        placement=placement,  # type: ignore[arg-type]
        order=chosen.get("order", preset.order),  # type: ignore[arg-type]
        precision=member_of(Precision, precision, "precision"),
        weights=bool(weights),
        replicates=n_replicates,
    )


class FootprintShape(enum.Enum):
    """Area of the surface that photons enter: a point, a circle or a rectangle, centred on the origin.

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

    if TYPE_CHECKING:  # what may be given; the fields above are what it becomes

        def __init__(
            self,
            *,
            shape: FootprintShape | ShapeWord = FootprintShape.POINT,
            size_x_m: float = 0.0,
            size_y_m: float = 0.0,
        ) -> None: ...

    def __post_init__(self) -> None:
        object.__setattr__(self, "shape", member_of(FootprintShape, self.shape, "shape"))
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
