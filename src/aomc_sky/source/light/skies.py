"""Which sky? Each is an object of the protocol `Sky`, beside which the sun's beam is launched."""

from __future__ import annotations

import dataclasses
import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from aomc_sky.component import Component
from aomc_sky.directions import travel_from_sky
from aomc_sky.errors import InputWarning, ModelLimitWarning, SceneError, UsageError
from aomc_sky.formats.sky_toml.keys import value_problem
from aomc_sky.formats.sky_toml.sections import PerezSection, SkySection, SunSection
from aomc_sky.options import AMOUNTS, MODEL, WEATHER_FILES
from aomc_sky.plan.laws import law_of
from aomc_sky.skies.model import Share, sky_model
from aomc_sky.source.light.brightness import InBands, irradiances, refuse_kilowatts
from aomc_sky.source.light.place import Sun
from aomc_sky.source.light.said import Said, Speakers, callers_of, first, sun_said

if TYPE_CHECKING:
    from aomc_sky.grid import PatchGrid
    from aomc_sky.skies.perez.sky import PerezSky
    from aomc_sky.source.light.plugin import PluginSky

FIELD = "field"
"""The sky of a scene whose sky.toml has [sky] table, and of a field that is run alone."""
OF_MODEL = "the model "  #: How people read of a model of Python.
OF_IRRADIANCES = ("air_mass", "extraterrestrial_normal")  #: Only from irradiances to epsilon and Delta.


@dataclass(frozen=True, kw_only=True, slots=True)
class Lowered:
    """The components of a sky."""

    components: tuple[Component, ...]
    row_of_band: np.ndarray | None = None  #: (n_band,) the row that serves each waveband; None: each has its own
    notes: tuple[str, ...] = ()
    options: Mapping[str, Any] = field(default_factory=dict)  #: JSON values for a manifest
    #: (n_band,) wavelength of its table that serves each waveband, NaN where the table has none; None without a table
    table_wavelength_nm: np.ndarray | None = None
    missing_beam: str = ""  #: a note for a scene without a beam, unless that is meant


class Sky(Protocol):
    """A sky that does not say itself how bright the sun's beam is."""

    @property
    def name(self) -> str:
        """For a manifest."""

    @property
    def made_of(self) -> str:
        """For people: the reason why an input is not used."""

    @property
    def names(self) -> tuple[str, ...]:
        """Inputs of a caller of which it is made."""

    @property
    def needs_sun(self) -> bool:
        """Whether its law depends on the sun."""

    @property
    def has_sun(self) -> bool:
        """Whether Rayleigh's pattern can lie around a sun in it."""

    @property
    def is_whole(self) -> bool:
        """Whether it is a file that is all light unless a beam is asked for."""

    def irradiance(self, sun: Sun | None, wavelength_nm: np.ndarray) -> np.ndarray | None:
        """Of a sky in absolute units, (n_band,), else None. [W m-2 nm-1]"""

    def lower(self, sun: Sun | None, wavelength_nm: np.ndarray, light: InBands) -> Lowered:
        """Its components, with strengths in any unit; only the Perez sky looks at `light`."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Perez:
    """The all-weather sky, shaped by amounts or coefficients that someone says, else by the light."""

    shape: PerezSection | None  #: what someone says
    choices: Mapping[str, Any]  #: further arguments of `PerezSky`
    grid: PatchGrid | None = None
    name, made_of = "perez", "a perez sky"
    needs_sun = has_sun = True
    is_whole = False

    @property
    def names(self) -> tuple[str, ...]:
        """Of irradiances also how epsilon and Delta follow from them."""
        has_coefficients = self.shape is not None and self.shape.coefficients is not None
        is_of_irradiances = self.shape is None or self.shape.has_irradiances
        idle = {*(["limits"] if has_coefficients else []), *(() if is_of_irradiances else OF_IRRADIANCES)}
        return (*AMOUNTS, *WEATHER_FILES, "row", "coefficients", *(name for name in MODEL if name not in idle))

    def irradiance(self, sun: Sun | None, wavelength_nm: np.ndarray) -> None:
        """It is relative."""

    def lower(self, sun: Sun | None, wavelength_nm: np.ndarray, light: InBands) -> Lowered:
        """One row for all wavebands."""
        assert sun is not None, "it needs one"
        shape = self.shape or light.broadband or shape_of_shares(light, sun)
        refuse_kilowatts(shape, sun)
        sky, limited = perez_sky(self.choices, shape, sun, self.grid)
        shown = {name: getattr(sky, name) for name in (*MODEL, "dni", "dhi")}
        shown |= {**sky_options(sky), "from": str(shape), "limited": limited}
        numbers = (
            "" if shown["epsilon"] is None else f"epsilon {shown['epsilon']:.4g}, Delta {shown['delta']:.4g}, from "
        )
        if shape.epsilon is not None and not shape.words:
            numbers = ""  # the text of the amounts has them already
        return Lowered(
            components=tuple(sky.lower(550.0)),
            row_of_band=np.zeros(wavelength_nm.size, np.int64),
            notes=(f"Perez sky: {numbers}{shape}",),
            options={"perez": shown},
        )


def perez_of(speakers: Speakers, grid: PatchGrid | None = None) -> Perez:
    """The Perez sky of what speakers say; `light` shapes it where nobody does."""
    shape = first([one.perez if one.perez.has_set else None for one in speakers])
    model = {name: value for one in reversed(speakers) for name, value in one.perez.model.items()}
    choices = {name: row.words[0] for name, row in MODEL.items() if row.words} | model
    if shape is not None and not shape.has_irradiances:
        choices = {name: value for name, value in choices.items() if name not in OF_IRRADIANCES}
    return Perez(shape=shape, choices=choices, grid=grid)


def perez_sky(
    choices: Mapping[str, Any], shape: PerezSection, sun: Sun, grid: PatchGrid | None = None
) -> tuple[PerezSky, list[str]]:
    """The sky of strength 1, and the warnings of its model about limits; each is given once more."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", ModelLimitWarning)
        sky = sky_model("perez")(
            sun_zenith_rad=math.radians(sun.zenith_deg),
            sun_azimuth_rad=math.radians(sun.azimuth_deg),
            grid=grid,
            strength=1.0,
            polarisation=sun.polarisation,
            **{**choices, "extraterrestrial_normal": sun.extraterrestrial_normal},
            **_perez_arguments(shape, sun),
        )
    texts = list(dict.fromkeys(str(w.message) for w in caught if issubclass(w.category, ModelLimitWarning)))
    for text in texts:
        warnings.warn(text, ModelLimitWarning, stacklevel=3)
    return sky, texts


def sky_options(sky: PerezSky) -> dict[str, Any]:
    """Clearness, brightness and coefficients of a Perez sky, for a manifest."""
    return {
        "epsilon": None if sky.clearness is None else float(sky.clearness),
        "delta": None if sky.brightness is None else float(sky.brightness),
        "coefficients": [float(c) for c in sky.model_coefficients],
    }


def _perez_arguments(shape: PerezSection, sun: Sun) -> dict[str, Any]:
    """Arguments of `PerezSky`: coefficients, epsilon and delta, or dni and dhi."""
    from aomc_sky.skies.perez.irradiances import dhi_exceeds_ghi

    if shape.coefficients is not None:
        return {"coefficients": shape.coefficients}
    if shape.epsilon is not None:
        return {"epsilon": shape.epsilon, "delta": shape.delta}
    direct, diffuse = irradiances(shape, sun)
    if diffuse == 0:
        raise SceneError(
            f"{shape} leave no light for the sky, but bands have diffuse light",
            "give a positive diffuse irradiance, or direct fractions of 1",
        )
    if is_exceeded := dhi_exceeds_ghi(shape.ghi, shape.dni, shape.dhi):
        warnings.warn(is_exceeded, ModelLimitWarning, stacklevel=2)
    return {"dni": direct, "dhi": diffuse}


#: Median sky brightness of each bin of clearness in 15 900 hours (Z < 85 degrees) of four public weather files.
MEDIAN_DELTA = (0.18, 0.30, 0.31, 0.29, 0.25, 0.18, 0.14, 0.09)


def shape_of_shares(light: InBands, sun: Sun) -> PerezSection:
    """Sky clearness of the photons' mean direct fraction f, and the median brightness of its bin.

    epsilon = 1 + [f / ((1 - f) cos Z)] / (1 + 1.041 Z^3), Delta of `MEDIAN_DELTA`; at least one band with light has a
    direct fraction below 1. Always warns: wavebands are not the whole spectrum.
    """
    from aomc_sky.skies.perez.functions import epsilon_bin, sky_clearness

    fractions, weight = light.direct_fraction, np.ones(light.direct_fraction.size)
    if light.intensity is not None and np.any(light.intensity > 0):
        weight = light.intensity / light.intensity.max()  # sums of huge ones stay finite
    mean, diffuse = (float(np.sum(weight * part) / np.sum(weight)) for part in (fractions, 1.0 - fractions))
    epsilon = float(sky_clearness(mean / sun.cosine, diffuse, math.radians(sun.zenith_deg)))
    warnings.warn(
        f"{light.who}: the sky's clearness is computed from the direct fraction; from bands within 400 to 700 nm it is "
        "too low, often by a bin; give dni and dhi in sky.toml or as options",
        InputWarning,
        stacklevel=2,
    )
    words = f"the mean direct fraction {mean:.4g} and the median brightness of that clearness"
    delta = MEDIAN_DELTA[int(epsilon_bin(epsilon))]
    return PerezSection(epsilon=epsilon, delta=delta, origin=light.who, words=words)


@dataclass(frozen=True, kw_only=True, slots=True)
class Uniform:
    """The same radiance everywhere."""

    per_solid_angle: bool = False
    name, made_of, names = "uniform", "a uniform sky", ("weighting",)
    needs_sun = has_sun = is_whole = False

    def irradiance(self, sun: Sun | None, wavelength_nm: np.ndarray) -> None:
        """It is relative."""

    def lower(self, sun: Sun | None, wavelength_nm: np.ndarray, light: InBands) -> Lowered:
        """One row for all wavebands."""
        model = sky_model("uniform")(per_solid_angle=self.per_solid_angle)
        return Lowered(components=tuple(model.lower([550.0])), row_of_band=np.zeros(wavelength_nm.size, np.int64))


@dataclass(frozen=True, kw_only=True, slots=True)
class Named:
    """A sky by its name, whose radiance may depend on the wavelength."""

    plugin: PluginSky
    names, is_whole = (), False
    _made: dict[Any, tuple[Any, tuple[Component, ...]]] = field(default_factory=dict, repr=False, compare=False)

    @property
    def name(self) -> str:
        """Its name."""
        return self.plugin.make.plugin.name

    @property
    def made_of(self) -> str:
        """Its name."""
        return f"{'an' if self.name[0] in 'aeio' else 'a'} {self.name} sky"

    @property
    def needs_sun(self) -> bool:
        """Whether it takes the angles."""
        return self.plugin.make.takes("sun_zenith_rad")

    @property
    def has_sun(self) -> bool:
        """Without the angles it is the same under any sun."""
        return self.needs_sun

    def irradiance(self, sun: Sun | None, wavelength_nm: np.ndarray) -> np.ndarray | None:
        """Of its components; skies of ours have the radiance of a law, which is relative."""
        if self.plugin.make.plugin.is_ours:
            return None
        return irradiance_of(self._components(sun, wavelength_nm)[1])

    def lower(self, sun: Sun | None, wavelength_nm: np.ndarray, light: InBands) -> Lowered:
        """A row for each waveband."""
        plugin = self.plugin
        model, components = self._components(sun, wavelength_nm)
        if not plugin.make.plugin.is_ours:
            components = patterned(model, components, sun, wavelength_nm, f"the sky model {plugin}")
        notes = (plugin.text, *plugin.notes(model, wavelength_nm))
        return Lowered(components=components, notes=notes, options={"plugin": plugin.record})

    def _components(self, sun: Sun | None, wavelength_nm: np.ndarray) -> tuple[Any, tuple[Component, ...]]:
        """The model under this sun, and its components, made once."""
        key = (None if sun is None else sun.rad, wavelength_nm.tobytes())
        if key not in self._made:
            angles, pattern = ((0.0, 0.0), None) if sun is None else (sun.rad, sun.polarisation)
            model = self.plugin.model(*angles, pattern)
            self._made[key] = model, self.plugin.lower(model, wavelength_nm)
        return self._made[key]


@dataclass(frozen=True, kw_only=True, slots=True)
class Model:
    """A model or a function of Python, or a measured sky."""

    model: Any
    made_of: str
    name: str
    is_whole: bool = False
    names: tuple[str, ...] = ()
    options: Mapping[str, Any] = field(default_factory=dict)  #: what a manifest has of it
    needs_sun = False
    _made: dict[bytes, tuple[Component, ...]] = field(default_factory=dict, repr=False, compare=False)

    @property
    def has_sun(self) -> bool:
        """Two of our models are the same under any sun."""
        return not (isinstance(self.model, Share) and self.name in ("UniformSky", "OvercastSky"))

    @property
    def sun(self) -> SunSection:
        """Where its own sun is, if it has one above the horizon."""
        angles = [getattr(self.model, name, None) for name in ("sun_zenith_rad", "sun_azimuth_rad")]
        zenith, azimuth = getattr(self.model, "sun_deg", None) or [
            None if angle is None else math.degrees(angle) for angle in angles
        ]
        if zenith is None or azimuth is None or not zenith < 90:
            return SunSection()
        return SunSection(zenith_deg=zenith, azimuth_deg=azimuth, origin=self.made_of)

    def _components(self, wavelength_nm: np.ndarray) -> tuple[Component, ...]:
        """Its components, made once for the same wavelengths."""
        key = wavelength_nm.tobytes()
        if key not in self._made:
            made = tuple(_every_row(one, wavelength_nm.size) for one in self.model.lower(wavelength_nm))
            if any(law_of(one.law).is_beam for one in made):
                raise UsageError(f"{self.name} is a beam and no diffuse sky", "put it into Scene(components=[...])")
            self._made[key] = made
        return self._made[key]

    def irradiance(self, sun: Sun | None, wavelength_nm: np.ndarray) -> np.ndarray | None:
        """Of its components."""
        return irradiance_of(self._components(wavelength_nm))

    def lower(self, sun: Sun | None, wavelength_nm: np.ndarray, light: InBands) -> Lowered:
        """A row for each waveband."""
        components = patterned(self.model, self._components(wavelength_nm), sun, wavelength_nm, self.made_of)
        notes = tuple(self.model.notes(wavelength_nm)) if hasattr(self.model, "notes") else ()
        has_table, has_word = hasattr(self.model, "table_wavelength_nm"), hasattr(self.model, "missing_beam")
        return Lowered(
            components=components,
            notes=notes,
            options=self.options,
            table_wavelength_nm=self.model.table_wavelength_nm(wavelength_nm) if has_table else None,
            missing_beam=self.model.missing_beam() if has_word else "",
        )


_APART_DEG = 0.5  #: Two suns whose discs do not touch are two suns.


def with_sun_of(model: Model, speakers: Speakers) -> Speakers:
    """The speakers, and after the caller the sun of the model that he gives; another sun of his is an error."""
    own, callers = model.sun, callers_of(speakers)
    if own.is_empty:
        return speakers
    said = sun_said(callers)
    if said.angles_deg != (None, None):
        other = said.over(own)
        suns = [(one.zenith_deg or 0.0, one.azimuth_deg or 0.0) for one in (own, other)]
        if float(travel_from_sky(*suns[0]) @ travel_from_sky(*suns[1])) < math.cos(math.radians(_APART_DEG)):
            at = ["a zenith angle of {:.4g} and an azimuth of {:.4g} degrees".format(*one) for one in suns]
            raise UsageError(
                f"where is the sun? {model.made_of} has it at {at[0]}, {said.origin} at {at[1]}",
                "leave one of both out, or give the sky that sun",
            )
    return (*callers, Said(sun=own, is_file=True), *speakers[len(callers) :])


def model_of(given: Any, *, has_pattern: bool = False) -> Model:
    """The model or function that a caller gives as the sky."""
    from aomc_sky.skies.function_sky import as_sky_model

    model = as_sky_model(given)
    if has_pattern and hasattr(model, "sun_zenith_rad"):
        raise UsageError(f"polarisation: this sky has a sun of its own: write {type(model).__name__}(polarisation=...)")
    if hasattr(model, "beam"):
        raise UsageError(
            f"{type(model).__name__} has a beam of its own: Scene(components=[*model.beam(nm), *model.lower(nm)])"
        )
    name = str(getattr(model, "name", type(model).__name__))
    return Model(model=model, name=name, made_of=f"{OF_MODEL}{name!r}")


def irradiance_of(components: Sequence[Component]) -> np.ndarray | None:
    """Irradiance of components of which all know it, else None. [W m-2 nm-1]"""
    known = [c.irradiance_W_m2_nm for c in components if c.irradiance_W_m2_nm is not None]
    return np.sum(known, axis=0) if known and len(known) == len(components) else None


def patterned(
    model: Any, components: Sequence[Component], sun: Sun | None, wavelength_nm: np.ndarray, name: str
) -> tuple[Component, ...]:
    """Components of a model with the pattern of polarisation that is asked for, around the sun of the scene."""
    if sun is None or sun.polarisation is None:
        return tuple(components)
    if any(one.stokes is not None for one in components):
        raise UsageError(f"polarisation: {name} is polarised already", "leave its Q and U out, or Rayleigh's pattern")
    if not hasattr(model, "radiance") or all(one.grid is None for one in components):
        raise UsageError(f"polarisation: {name} has no radiance or no patches, as Rayleigh's pattern needs them")
    return sun.polarisation.polarised(components, model.radiance, wavelength_nm, sun.rad)


def _every_row(component: Component, n_rows: int) -> Component:
    """A component with one row serves all."""
    if component.strength.size == n_rows:
        return component
    if component.strength.size != 1:
        raise SceneError(f"component {component.name!r} has {component.strength.size} rows for {n_rows} wavelengths")
    own = component.irradiance_W_m2_nm
    every = None if own is None else np.repeat(own, n_rows)
    return dataclasses.replace(component, strength=np.repeat(component.strength, n_rows), irradiance_W_m2_nm=every)


def require_sky_name(name: str) -> None:
    """Raise for a name that no sky has."""
    if problem := value_problem("sky", "model", name):
        raise UsageError(f"sky: {problem.message}", problem.advice, field="sky")


def named_sky(name: str, options: Mapping[str, Any]) -> Sky | None:
    """The sky of this name, if it is one that needs no files; but for that of Perez."""
    from aomc_sky.formats.sky_models import installed_skies

    if name in installed_skies().plugins:
        from aomc_sky.source.light.plugin import choose_plugin

        return Named(plugin=choose_plugin(name, SkySection(), options, ""))
    if name != "uniform":
        return None
    if options:
        raise UsageError("the sky model 'uniform' has no options")
    return Uniform()
