"""The samplers of this package that are compared: names, and the options of `Scene.source` that they are."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from aomc_sky.errors import UsageError
from aomc_sky.source.options import refuse_withdrawn


@dataclass(frozen=True, kw_only=True, slots=True)
class BenchMethod:
    """One way to sample a sky."""

    #: Name on the command line and in files.
    name: str
    #: For a person.
    title: str
    #: Keyword arguments of `Scene.source`.
    options: Mapping[str, str] = field(default_factory=dict)
    #: It knows patches alone: a continuous sky is given to it as masses of 90 x 360 patches.
    needs_table: bool = False
    #: False: every seed gives the same photons, so one replicate is enough.
    is_random: bool = True
    #: Another method that emits the same photons in another order, so that its errors are known.
    same_photons_as: str = ""


_ALL = (
    BenchMethod(name="default", title="systematic + R2, shuffled"),
    BenchMethod(
        name="patch-order",
        title="systematic + R2, patch order",
        options={"order": "patch"},
        same_photons_as="default",
    ),
    BenchMethod(name="iid", title="independent photons", options={"method": "iid"}),
    BenchMethod(name="largest-remainder", title="largest remainder + R2", options={"allocation": "largest-remainder"}),
    BenchMethod(
        name="aomc",
        title="AOMC's rounding, patch centres",
        options={"allocation": "aomc", "placement": "centre"},
        needs_table=True,
        is_random=False,
    ),
)

METHODS = {method.name: method for method in _ALL}
"""By name, in the order of the tables."""


def chosen_methods(names: list[str] | None) -> list[BenchMethod]:
    """The methods of these names, all by default; an unknown name is a UsageError."""
    for name in names or ():
        refuse_withdrawn(name)
    unknown = [name for name in names or () if name not in METHODS]
    if unknown:
        raise UsageError(f"there is no method {unknown[0]!r}; methods are {', '.join(METHODS)}")
    return [METHODS[name] for name in METHODS if not names or name in names]
