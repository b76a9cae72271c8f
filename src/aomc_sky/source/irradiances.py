"""Beam and sky on a horizontal plane at many times: a day or a year of `weather_scene`, without photons."""

from __future__ import annotations

import contextlib
import dataclasses
import datetime
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from aomc_sky.errors import InputWarning, SceneError, UsageError, floats, require_one_of
from aomc_sky.extras import optional_module
from aomc_sky.options import say
from aomc_sky.record import same_content, short_repr
from aomc_sky.skies.perez.irradiances import LEAST_SUM, OFFSET
from aomc_sky.source.light.join import split_of
from aomc_sky.source.light.said import said_by_caller
from aomc_sky.source.light.skies import Model, Sky, with_sun_of
from aomc_sky.source.light.sun_position import times_utc
from aomc_sky.source.light.weather import Moment, moments_of_times
from aomc_sky.source.scene import warn_of_too_much_light
from aomc_sky.source.weather_scene import sky_of
from aomc_sky.wavebands import Wavebands, as_wavebands

if TYPE_CHECKING:
    from aomc_sky.source.light.spectral_split import ClearSky

SplitWord = Literal["spectrl2"]
"""How beam and sky share each waveband, where that gives irradiances."""
_MEASURED = ("ghi", "dni", "dhi")


@dataclass(eq=False, frozen=True, kw_only=True, slots=True)
class Irradiances:
    """Irradiances of a horizontal plane at many times.

    ``beam, diffuse = irradiances`` unpacks both.

    Examples
    --------
    >>> times = ["2026-06-21T09:00Z", "2026-06-21T12:00Z"]
    >>> day = sky.irradiances(times, 54.18, 7.89, wavebands=[443.0, 555.0])
    >>> print(day.total_W_m2_nm.round(2))
    [[1.14 1.2 ]
     [1.33 1.4 ]]
    """

    time: np.ndarray  #: (n_time,) datetime64[s] in UTC
    wavelength_nm: np.ndarray  #: (n_band,) [nm]
    sun_zenith_deg: np.ndarray  #: (n_time,) as it is seen, with refraction [deg, 0 to 180]
    direct_W_m2_nm: np.ndarray  # noqa: N815  #: (n_time, n_band) of the sun's beam [W m-2 nm-1]
    diffuse_W_m2_nm: np.ndarray  # noqa: N815  #: (n_time, n_band) of the sky [W m-2 nm-1]

    __eq__ = same_content
    __repr__ = short_repr

    def __post_init__(self) -> None:
        for field in dataclasses.fields(self):
            getattr(self, field.name).flags.writeable = False

    @property
    def total_W_m2_nm(self) -> np.ndarray:  # noqa: N802 - the unit is written so
        """Beam and sky together, (n_time, n_band). [W m-2 nm-1]"""
        return self.direct_W_m2_nm + self.diffuse_W_m2_nm

    def __iter__(self) -> Iterator[np.ndarray]:
        return iter((self.direct_W_m2_nm, self.diffuse_W_m2_nm))

    def to_xarray(self) -> Any:  # xarray.Dataset; the package is optional
        """Return the irradiances as a dataset.

        Returns
        -------
        xarray.Dataset
            `direct`, `diffuse` and `total` over (time, wavelength), `sun_zenith` over time; times are UTC.

        Raises
        ------
        MissingExtraError
            xarray is not installed: ``pip install ".[netcdf]"``.
        """
        xr = optional_module("xarray", extra="netcdf")
        unit, axes = {"units": "W m-2 nm-1"}, ("time", "wavelength")
        values = {"direct": self.direct_W_m2_nm, "diffuse": self.diffuse_W_m2_nm, "total": self.total_W_m2_nm}
        variables: dict[str, Any] = {name: (axes, one.copy(), unit) for name, one in values.items()}
        variables["sun_zenith"] = ("time", self.sun_zenith_deg.copy(), {"units": "degree"})
        coordinates = {
            "time": self.time.astype("datetime64[ns]"),
            "wavelength": ("wavelength", self.wavelength_nm.copy(), {"units": "nm"}),
        }
        return xr.Dataset(variables, coordinates)


def irradiances(
    times: ArrayLike | Sequence[str | datetime.datetime],
    latitude_deg: float,
    longitude_deg: float,
    *,
    wavebands: Wavebands | Sequence[float] | np.ndarray,
    altitude_m: float = 0.0,
    ghi: ArrayLike | None = None,
    dni: ArrayLike | None = None,
    dhi: ArrayLike | None = None,
    epsilon: ArrayLike | None = None,
    delta: ArrayLike | None = None,
    spectrum: SplitWord | None = "spectrl2",
    extraterrestrial_normal: float | None = None,
    diffuse_only: bool = False,
    sky: Any = None,
    sky_options: Mapping[str, Any] | None = None,
    clear_sky: ClearSky | Mapping[str, Any] | None = None,
) -> Irradiances:
    """Compute beam and sky of a place at many times, as the scenes of `weather_scene` have them, without photons.

    Where the sun is below the horizon both are 0. They are 0, too, where all measured irradiances are 0.

    Parameters
    ----------
    times : array_like of datetime64, or sequence of str or datetime, shape (n_time,)
        Texts in ISO 8601 with their zone, datetimes with their zone, or datetime64 in UTC. An index of pandas needs a
        zone. Needs the extra ``weather``.
    latitude_deg, longitude_deg : float
        The place, north and east positive. [deg, -90 to 90 and -180 to 180]
    wavebands : Wavebands, or array_like of float64, shape (n_band,)
        The wavebands, or their wavelengths. [nm]
    altitude_m : float
        Height of the place above the sea. [m, -500 to 9000]
    ghi, dni, dhi : array_like, shape (n_time,) or one for all, optional
        Any two irradiances of the whole spectrum. Without them the sky is cloudless. [W m-2]
    epsilon, delta : array_like, shape (n_time,) or one for all, optional
        Clearness and brightness of the sky in their place. [1 or more; 0 or more]
    spectrum : str, optional
        "spectrl2", as in `weather_scene`. None is for a sky in W m-2 nm-1 alone, without a beam. "flat" gives shares
        and no irradiances.
    extraterrestrial_normal : float, optional
        As in `weather_scene`. [W m-2, by default 1361.1]
    diffuse_only : bool
        Leave out the beam.
    sky, sky_options : optional
        As in `weather_scene`. Only a sky in W m-2 nm-1 changes the irradiances.
    clear_sky : ClearSky or mapping, optional
        The air of a cloudless sky. The numbers of a mapping may be arrays, one for each time.

    Returns
    -------
    Irradiances
        `time`, `wavelength_nm`, and (n_time, n_band) `direct_W_m2_nm`, `diffuse_W_m2_nm` and `total_W_m2_nm`;
        `to_xarray()` gives them their labels.

    Raises
    ------
    UsageError, SceneError
        As in `weather_scene`; the message begins with the time.

    Warns
    -----
    InputWarning, ModelLimitWarning
        As in `weather_scene`, each kind once, with its first time. An irradiance above 50 W m-2 while the sun is below
        the horizon: the times may be in another zone.

    Notes
    -----
    Cost: 1 ms for a time under a cloudless sky, 6 ms with measured irradiances.

    Examples
    --------
    >>> times = ["2026-06-21T04:00Z", "2026-06-21T12:00Z", "2026-06-21T23:00Z"]
    >>> day = sky.irradiances(
    ...     times, 54.18, 7.89, wavebands=[555.0], ghi=[90, 780, 0], dhi=[70, 140, 0]
    ... )
    >>> print(day.diffuse_W_m2_nm[:, 0].round(3))
    [0.109 0.278 0.   ]
    """
    if spectrum is not None:
        require_one_of(get_args(SplitWord), spectrum, "spectrum")
    moment = np.atleast_1d(times_utc(times))
    if moment.ndim != 1:
        raise UsageError(f"times are one after the other, of shape (n_time,); got the shape {moment.shape}")
    place = {"latitude_deg": latitude_deg, "longitude_deg": longitude_deg, "altitude_m": altitude_m}
    names = tuple(name for name, value in place.items() if name != "altitude_m" or value)
    moments = moments_of_times(moment, **place, names=("time", *names))
    bands, n = as_wavebands(wavebands), moment.size
    given = {"ghi": ghi, "dni": dni, "dhi": dhi, "epsilon": epsilon, "delta": delta}
    amounts = {name: _by_time(name, value, n) for name, value in given.items() if value is not None}
    air = _air_by_time(clear_sky, n)
    fixed = {"spectrum": spectrum, "extraterrestrial_normal": extraterrestrial_normal}
    direct, diffuse = np.zeros((2, n, bands.n_bands))
    is_up = np.array([one.sun_zenith_deg < 90 for one in moments], dtype=bool)
    _warn_of_light_at_night(moments, is_up, amounts)
    model: Sky | None = None
    found_warnings = _Warnings()
    for k in np.flatnonzero(is_up & ~_is_dark(amounts, n)).tolist():
        at = f"at {moments[k].source['time']}"
        with found_warnings.at(at):
            try:
                (caller,) = said_by_caller(
                    perez={**fixed, **{name: float(values[k]) for name, values in amounts.items()}},
                    clear_sky=air if not isinstance(air, Mapping) else {name: one[k] for name, one in air.items()},
                    diffuse_only=diffuse_only,
                )
                one = dataclasses.replace(
                    caller, sun=moments[k].sun, moment=moments[k], altitude_m=float(altitude_m) or None
                )
                model = sky_of(sky, sky_options or {}, (one,)) if model is None else model
                light = split_of(with_sun_of(model, (one,)) if isinstance(model, Model) else (one,), model, bands).kept
            except (SceneError, UsageError) as error:
                raise type(error)(f"{at}: {error}") from None
        if light.direct is None and light.diffuse is None:
            raise UsageError(
                "these inputs give the shares of beam and sky, and no irradiances in W m-2 nm-1",
                say("write {spectrum:spectrl2}"),
            )
        direct[k] = 0.0 if light.direct is None else light.direct
        diffuse[k] = 0.0 if light.diffuse is None else light.diffuse
    found_warnings.give()
    if n:
        warn_of_too_much_light(bands.wavelength_nm, (direct + diffuse).max(axis=0))
    return Irradiances(
        time=moment.copy(),
        wavelength_nm=bands.wavelength_nm.copy(),
        sun_zenith_deg=np.array([one.sun_zenith_deg for one in moments], dtype=np.float64),
        direct_W_m2_nm=direct,
        diffuse_W_m2_nm=diffuse,
    )


def _by_time(name: str, value: ArrayLike, n: int) -> np.ndarray:
    """One number for each time."""
    array = floats(name, value)
    if array.shape not in ((), (n,)):
        raise UsageError(f"{name} is one number, or one for each of {n} times; got the shape {array.shape}")
    return np.broadcast_to(array, n)


def _air_by_time(clear_sky: Any, n: int) -> Any:
    """The air; the values of a mapping as one for each time."""
    if not isinstance(clear_sky, Mapping):
        return clear_sky
    many = {k: v for k, v in clear_sky.items() if not isinstance(v, (str, bytes, Mapping)) and np.ndim(v) > 0}
    return {name: _by_time(name, one, n).tolist() if name in many else [one] * n for name, one in clear_sky.items()}


def _is_dark(amounts: Mapping[str, np.ndarray], n: int) -> np.ndarray:
    """Whether instruments show no light, (n,)."""
    measured = [amounts[name] for name in _MEASURED if name in amounts]
    if len(measured) < 2:
        return np.zeros(n, bool)
    return np.all([(one >= -OFFSET) & (one <= 0) for one in measured], axis=0)


def _warn_of_light_at_night(moments: Sequence[Moment], is_up: np.ndarray, amounts: Mapping[str, np.ndarray]) -> None:
    """Warn of measured light below the horizon: mostly times of another zone."""
    for name in (one for one in _MEASURED if one in amounts):
        lit = np.flatnonzero(~is_up & (amounts[name] > LEAST_SUM))
        if lit.size:
            first, below = moments[lit[0]], moments[lit[0]].sun_zenith_deg - 90
            warnings.warn(
                f"at {first.source['time']}{_and_more(lit.size)} the sun is {below:.1f} degrees below the horizon, but "
                f"{name} is {amounts[name][lit[0]]:g} W m-2; 0 is given: see that latitude is north, longitude east, "
                "and the times in UTC or in the zone that they name",
                InputWarning,
                stacklevel=3,
            )
            return


def _and_more(count: int) -> str:
    return f" and at {count - 1} more times" if count > 2 else " and once more" if count == 2 else ""


class _Warnings:
    """Warnings of many times, of which each kind is given once."""

    def __init__(self) -> None:
        self.found: dict[tuple[str, int], list[tuple[str, warnings.WarningMessage]]] = {}

    @contextlib.contextmanager
    def at(self, when: str) -> Iterator[None]:
        """What is warned of inside is of this time."""
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            yield
        for one in caught:
            self.found.setdefault((one.filename, one.lineno), []).append((when, one))

    def give(self) -> None:
        """Give the first of each kind, with its time and how many more there are."""
        for same in self.found.values():
            when, first = same[0]
            warnings.warn(f"{when}{_and_more(len(same))}: {first.message}", first.category, stacklevel=3)
