"""The table of options: the command line, its help, its page, sky.toml and checks of arguments are made from it.

A row is an option of commands, a key of sky.toml, an argument of Python, or several of these.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from enum import Enum, auto
from functools import partial
from typing import Any

MAX_SEED = 2**64 - 1


class Kind(Enum):
    """What the value of a row is. `cli/values.py` reads each from a word, `sky_toml/keys.py` from a value of TOML."""

    FLAG = auto()  # given or not
    SWITCH = auto()  # true or false: --name and --no-name
    WORD = auto()  # one of `words`
    NUMBER = auto()
    COUNT = auto()  # a whole number
    TEXT = auto()
    FORMAT = auto()  # a word of a registry
    SKY = auto()  # the name of a sky
    SKY_OPTION = auto()  # KEY=VALUE
    COLUMN = auto()  # ROLE=NAME
    INDEX = auto()  # DIM=INDEX, or a table of them
    SIGNS = auto()  # of Q and U
    AZIMUTHS = auto()  # words of a convention
    RADIANCE_UNIT = auto()
    WAVELENGTH = auto()
    WAVELENGTHS = auto()
    SUNS = auto()  # zenith angles
    LATITUDE = auto()
    LONGITUDE = auto()
    MOMENT = auto()  # a time with its zone, or seconds since 1970
    PHOTONS = auto()
    MEMORY = auto()
    SPECTRUM = auto()  # irradiances, one for each waveband
    NAMES = auto()  # a text, or several
    SHARES = auto()  # of components: NAME=SHARE, or a table of them


@dataclass(frozen=True, slots=True)
class Option:
    """One row of the table."""

    name: str  #: In this table; a row of one command has its name and a dot before its own
    text: str  #: Help; empty: not shown there
    value: str = ""  #: What stands for the value in help
    words: tuple[str, ...] = ()  #: Values of a choice
    kind: Kind = Kind.TEXT
    unit: str = ""
    low: float = -math.inf
    high: float = math.inf
    default: Any = None  #: Of the command line
    usual: str = ""  #: The default in words, where None stands for it
    option: str = ""  #: On the command line, by default made from the name
    short: str = ""  #: Another option that means the same
    section: str = ""  #: Of sky.toml
    key: str = ""  #: There, by default the name
    keyword: str = ""  #: Argument of `weather_scene`, by default the name
    repeats: bool = False
    is_needed: bool = False

    flag: str = field(init=False)  #: The option, --name
    attribute: str = field(init=False)  #: Where the parser keeps the value
    meaning: str = field(init=False)  #: Text, unit, range and default in one line

    def __post_init__(self) -> None:
        flag = self.option or f"--{self.own_name.replace('_', '-')}"
        object.__setattr__(self, "flag", flag)
        object.__setattr__(self, "attribute", flag[2:].replace("-", "_"))
        bounds = ", ".join(filter(None, (self.unit, self.range)))
        usual = self.usual or ("" if self.default is None or self.default is False else _shown(self.default))
        notes = ", ".join(filter(None, ("repeatable" * self.repeats, usual and f"default {usual}")))
        meaning = f"{self.text}{f' [{bounds}]' if bounds else ''}{f' ({notes})' if notes else ''}"
        object.__setattr__(self, "meaning", meaning if self.text else "")

    @property
    def own_name(self) -> str:
        """The name without the command."""
        return self.name.rpartition(".")[2]

    @property
    def range(self) -> str:
        """The allowed numbers, for a person; empty without limits."""
        if (self.low, self.high) == (-math.inf, math.inf):
            return ""
        return f"{_bound(self.low)} or more" if self.high == math.inf else f"{_bound(self.low)} to {_bound(self.high)}"


def _bound(value: float) -> str:
    return "2^64-1" if value == MAX_SEED else f"{value:g}".replace("e+0", "e").replace("e+", "e")


def _shown(value: Any) -> str:
    if isinstance(value, tuple):
        return " ".join(map(_shown, value))
    return f"{value:g}" if isinstance(value, float) else "1e6" if value == 10**6 else str(value)


def _table(*rows: Option) -> dict[str, Option]:
    return {row.name: row for row in rows}


# The light: keys of sky.toml, and arguments of Python.

_perez = partial(Option, section="perez")
_watts = partial(_perez, value="W", kind=Kind.NUMBER, unit="W m-2")
_number = partial(Option, kind=Kind.NUMBER)
_word = partial(Option, kind=Kind.WORD)
_flag = partial(Option, kind=Kind.FLAG, default=False)

_BRIGHT = (
    _watts("dni", "direct normal irradiance; two of --dni, --dhi, --ghi", low=0, high=10_000),
    _watts("dhi", "diffuse horizontal irradiance", low=0, high=10_000),
    _watts("ghi", "global horizontal irradiance", low=0, high=10_000),
    _perez("epsilon", "sky clearness, with --delta", "E", kind=Kind.NUMBER, low=1),
    _perez("delta", "sky brightness", "D", kind=Kind.NUMBER, low=0),
)
AMOUNTS = tuple(row.name for row in _BRIGHT)
"""Inputs that say how bright sun and sky are."""

MODEL = _table(
    _perez("limits", "limits of clearness and brightness: published practice, or none (paper)", kind=Kind.WORD,
           words=("radiance", "paper")),
    _perez("within", "law of the Perez sky inside a patch: its own (exact), or constant", kind=Kind.WORD,
           words=("exact", "uniform")),
    _perez("air_mass", "formula of the air mass in Delta", kind=Kind.WORD,
           words=("kasten-young-1989", "kasten-1966")),
    _watts("extraterrestrial_normal", "extraterrestrial normal irradiance at the sun's mean distance; with a date, "
           "times the factor of the distance", option="--extraterrestrial", low=1, high=1e6, usual="1361.1"),
)  # fmt: skip
"""Further arguments of `PerezSky`; the first word of a choice is its default."""

PEREZ = _table(
    *_BRIGHT,
    _perez("coefficients", "of the sky, eq. (1)", "a b c d e", kind=Kind.NUMBER, low=-1000, high=1000),
    _perez("spectrum", "how beam and sky share each waveband: all alike (flat), or by clear-sky spectra, which are the "
           "light where no irradiances are given (spectrl2)", kind=Kind.WORD, words=("flat", "spectrl2")),
    *MODEL.values(),
)  # fmt: skip
"""Keys of [perez]; the coefficients are its keys a to e."""

_angle = partial(_number, value="DEG", unit="deg")
_sun = partial(_angle, section="sun")
SUN = _table(
    _sun("zenith_deg", "zenith angle of the sun, below 90 without an atmosphere", option="--sun-zenith",
         keyword="sun_zenith_deg", low=0, high=180),
    _sun("azimuth_deg", "azimuth of the sun, from +x (east) to +y (north)", option="--sun-azimuth",
         keyword="sun_azimuth_deg", low=-360, high=360),
    Option("disc", "the beam has the extent of the solar disc", kind=Kind.SWITCH, section="sun", keyword="sun_disc"),
)  # fmt: skip
"""Keys of [sun]."""

_atmosphere = partial(Option, section="atmosphere")
_moon = partial(_angle, section="atmosphere")
LIGHTS = _table(
    _moon("moon_zenith_deg", "zenith angle of the Moon before the sun", option="--moon-zenith", low=0, high=180),
    _moon("moon_zenith_offset_deg", "that minus the sun's zenith angle", option="--moon-zenith-offset", low=-180,
          high=180),
    _moon("moon_azimuth_deg", "azimuth of the Moon", option="--moon-azimuth", low=-360, high=360, usual="the sun's"),
    _moon("moon_azimuth_offset_deg", "that minus the sun's azimuth", option="--moon-azimuth-offset", low=-360,
          high=360),
    _atmosphere("moon_distance_km", "of the Moon's centre", "KM", kind=Kind.NUMBER, option="--moon-distance",
                unit="km", low=2000, high=1e12, usual="the description's"),
    _atmosphere("ground_luminance_cd_m2", "of a ground that glows", "CD", kind=Kind.NUMBER,
                option="--ground-luminance", unit="cd m-2", low=0, high=1e6, usual="0"),
)  # fmt: skip
"""Keys of [atmosphere] for the Moon and the glow of the ground."""

_air = partial(Option, section="clear_sky", keyword="clear_sky")
CLEAR_SKY = _table(
    _air("aod_500nm", "optical depth of the aerosol at 500 nm", "AOD", kind=Kind.NUMBER, option="--aod", low=0, high=5,
         usual="0.1"),
    _air("aerosol", "the aerosol of the land (rural), or of the sea (maritime)", kind=Kind.WORD,
         words=("rural", "maritime"), usual="rural"),
    _air("water_cm", "precipitable water", "CM", kind=Kind.NUMBER, unit="cm", low=0, high=20, usual="1.4"),
    _air("ozone_cm", "column of ozone", "ATM", kind=Kind.NUMBER, unit="atm cm", low=0, high=2, usual="0.3"),
    _air("pressure_hPa", "pressure at the surface", "HPA", kind=Kind.NUMBER, option="--pressure-hpa", unit="hPa",
         low=100, high=1200, usual="that of the altitude"),
)  # fmt: skip
"""Keys of [clear_sky]: the air of a cloudless sky, for --spectrum spectrl2 without irradiances."""

MOMENT = _table(
    Option("time", "date and time with Z or an offset", "ISO8601"),
    Option("latitude_deg", "north positive, also as 43.4N", "DEG", kind=Kind.LATITUDE,
           option="--latitude", unit="deg"),
    Option("longitude_deg", "east positive, also as 7.9E", "DEG", kind=Kind.LONGITUDE,
           option="--longitude", unit="deg"),
    _number("altitude_m", "height above the sea, of the refraction and of the pressure of a cloudless sky", "M",
            option="--altitude", unit="m", low=-500, high=9000, usual="0"),
    Option("row", "the hour of the file to take, from 1", "N", kind=Kind.COUNT),
    Option("weather", "an EPW, TMY2 or TMY3 file of hours, which its head tells apart", "FILE"),
    Option("epw", "", "FILE"),
    Option("tmy2", "", "FILE"),
    Option("tmy3", "", "FILE"),
)  # fmt: skip
"""When and where, or an hour of a weather file."""
WEATHER_FILES = ("weather", "epw", "tmy2", "tmy3")
"""Inputs that name a weather file."""

READING = _table(
    _word("bins", "meaning of the indices of skydist.inp", words=("equal", "degrees"),
          usual="what the file declares, else equal"),
    _word("weighting", "meaning of the values of skydist.inp: masses (listed) or radiances times solid angle; or the "
          "launch law of a sky", words=("listed", "projected", "solid-angle", "aomc"), section="sky",
          usual="what the file declares, else listed"),
    _word("azimuth_bins", "n: azimuth indices run from 1 to n; n+1: from 0", words=("n+1", "n"), default="n+1"),
)  # fmt: skip
"""How a sky is read."""

_sky = partial(Option, section="sky")
_OF_SKY = (
    _sky("sky", "diffuse sky; NAME: overcast, cardioidal, cie, harrison-coombes or another (`aomc-sky info --skies`); "
         "none: the backgrounds of sky.toml alone", "perez|uniform|none|NAME", kind=Kind.SKY, key="model",
         usual="perez, or skydist.inp with flag 1"),
    Option("sky_options", "an option of a named sky, as in [sky] of sky.toml", "KEY=VALUE", kind=Kind.SKY_OPTION,
           option="--sky-option", repeats=True),
    _flag("diffuse_only", "the sky without the sun's beam"),
    _sky("polarisation", "Rayleigh's pattern on the light of the sky: its largest degree of linear polarisation; 0.75 "
         "is that of a clean sky", "DEGREE", kind=Kind.NUMBER, low=0, high=1, usual="photons carry none"),
)  # fmt: skip

INPUTS = PEREZ | SUN | LIGHTS | CLEAR_SKY | MOMENT | READING | _table(*_OF_SKY)
"""All inputs of the light of a scene, by name."""

FIELD = _table(
    _sky("azimuth_convention", "from where its azimuths count and which way: clockwise or counterclockwise, from "
         "north, east, south, west, the sun or the antisun, as 'clockwise from north'", "WORDS", kind=Kind.AZIMUTHS),
    _sky("angle_unit", "of its angles", kind=Kind.WORD, words=("deg", "rad")),
    _sky("wavelength_unit", "of its wavelengths", kind=Kind.WORD, words=("nm", "um", "m", "angstrom")),
    _sky("radiance_unit", "of its radiances, such as 'mW m-2 nm-1 sr-1', or relative", "UNIT",
         kind=Kind.RADIANCE_UNIT),
    _sky("decimal", "sign of the decimals of a table", kind=Kind.WORD, words=("point", "comma")),
    Option("coordinate", "a column or coordinate of another name: zenith, elevation, azimuth or wavelength, as "
           "zenith=vza", "ROLE=NAME", kind=Kind.COLUMN, repeats=True),
    _sky("variable", "the radiance, where it has another name; alone, without Q and U beside it", "NAME"),
    _sky("variable_q", "the Stokes parameter Q, where its name is not radiance_q; with --variable-u", "NAME"),
    _sky("variable_u", "the same of U", "NAME"),
    _sky("stokes_signs", "1 or -1 for each: factors that bring them to our signs (docs/conventions.md)", "Q U",
         kind=Kind.SIGNS),
    _sky("isel", "the index to take of a further dimension, from 0", "DIM=INDEX", kind=Kind.INDEX, repeats=True),
)  # fmt: skip
"""What a measured sky or a field does not state itself."""

_background = partial(Option, section="background")
LOBES = _table(
    _background("animation", "only this animation", "NAME", kind=Kind.NAMES, repeats=True, usual="all"),
    _background("utc_offset", "local time less UTC, for the midnight of repeating animations", "HOURS",
                kind=Kind.NUMBER, unit="h", low=-24, high=24, default=0.0),
    _background("interpolation", "between two keys both lobes fade, or one turns", kind=Kind.WORD,
                words=("crossfade", "slerp"), default="crossfade"),
)  # fmt: skip
"""What is taken of a background sky."""

_key = partial(Option, option="-")
_KEYS = (
    _key("sky.table", "the path of a netCDF file or a table of text", section="sky"),
    *(_key(f"sky.{role}", "the name of a column or a coordinate", section="sky")
      for role in ("zenith", "elevation", "azimuth", "wavelength")),
    _key("sky.diffuse_irradiance", "of the sky on a horizontal plane", kind=Kind.SPECTRUM, section="sky"),
    _key("sky.direct_irradiance", "of the beam on a horizontal plane", kind=Kind.SPECTRUM, section="sky"),
    _key("background.file", "the path of a background-sky file", section="background"),
    _key("background.time", "the time", kind=Kind.MOMENT, section="background"),
    _key("atmosphere.file", "the path of an atmosphere description", section="atmosphere"),
    _key("atmosphere.zenith_bins", "equal bins of its patches", kind=Kind.COUNT, low=1, high=3600,
         section="atmosphere"),
    _key("atmosphere.azimuth_bins", "the same of azimuth", kind=Kind.COUNT, low=1, high=3600, section="atmosphere"),
)  # fmt: skip
"""Keys of sky.toml that are no options."""

# Of commands alone.

_wavelengths = partial(Option, value="NM...", kind=Kind.WAVELENGTHS, short="--wavelength")
_bins = partial(Option, value="NZ NA", kind=Kind.COUNT, low=1, high=3600)
_waveband = partial(Option, value="I", kind=Kind.COUNT, repeats=True)
_seed = partial(Option, value="INT", kind=Kind.COUNT, low=0, high=MAX_SEED)
_OF_COMMANDS = (
    # files that are read
    Option("iterations", "photons per waveband instead of line 1 of amc.inp, also as 1e6", "N", kind=Kind.PHOTONS),
    _word("compat", "everything as the AOMC 1.2.2 program does it", words=("aomc",)),
    _flag("lenient", "use Fortran's value if a person would read another one"),
    _flag("fail_on_warnings", "warnings are errors", option="--strict"),
    Option("allow_path", "folder below which files named in sky.toml or in an .atmo file may lie, besides its own",
           "DIR", repeats=True),
    Option("max_memory", "refuse a sky file, plan or run that takes more, e.g. 4G", "SIZE", kind=Kind.MEMORY,
           usual="2G, threads not counted"),
    _wavelengths("wavelengths", "with blanks or commas, or as 400:700:10; a path stands before them"),
    # how photons are drawn
    _seed("seed", "of all random numbers", default=0),
    _word("allocation", "how photons are distributed over the patches",
          words=("systematic", "largest-remainder", "multinomial", "aomc"), usual="systematic"),
    _word("method", "how the photons of a band depend on each other", words=("stratified", "iid"), usual="stratified"),
    _word("placement", "where a photon lies in its cell", words=("r2", "philox", "centre"), usual="r2"),
    _word("order", "order of the photons of a band", words=("shuffled", "patch"), usual="shuffled"),
    _word("precision", "of directions", words=("float32", "float64"), default="float32"),
    _flag("weights", "carry weights where the launch law is not the flux law"),
    Option("replicates", "divide the photons of a band into R independent runs, and print standard errors", "R",
           kind=Kind.COUNT, default=1),
    Option("bias", "share of the photons of a component, which then have weights; the others share the rest by their "
           "light", "NAME=SHARE", kind=Kind.SHARES, section="photons", repeats=True),
    _waveband("waveband", "only this band, from 1"),
    # what is written and printed
    Option("out", "run folder; - with --format raw", "DIR", usual="aomc-sky-out beside the scene"),
    Option("format", "photon files; source: source.sky, for codes in C or Fortran; none: counts and plan only",
           kind=Kind.FORMAT, repeats=True, usual="npy"),
    Option("shard", "only part k of K, from 1, written in place; the last one ends the run", "k/K"),
    Option("threads", "threads", "N", kind=Kind.COUNT, low=1, high=1024, usual="all CPUs"),
    _word("engine", "who makes the photons: this process, or a Dask cluster", words=("local", "dask"),
          default="local"),
    Option("scheduler", "of a Dask scheduler, tcp://host:8786", "ADDRESS", usual="a cluster of processes here"),
    _flag("dry_run", "print what would be modelled; write nothing"),
    _flag("force", "replace another run in the folder"),
    _flag("json", "one JSON object on standard output"),
    _flag("quiet", "print warnings and errors only", short="-q"),
    _flag("verbose", "print how the files were read, and all notes", short="-v"),
    # info
    _flag("include_dir", "print the folder of aomc_sky.h, aomc_sky.c and aomc_sky.f90"),
    _flag("skies", "list the sky models of other packages (--sky NAME)"),
    _flag("csv", "of a run: irradiances above the water of each waveband, by component, as CSV"),
    _wavelengths("info.wavelengths", "with blanks or commas; of a measured sky, its wavebands",
                 usual="those of the spectra"),
    # plot
    Option("plot.out", "the picture as .png, .svg or .pdf", "FILE", usual="PATH.png beside PATH"),
    _flag("plot.force", "replace a file that aomc-sky did not write"),
    Option("size", "width in dots", "PX", kind=Kind.COUNT, low=300, high=8000, default=960),
    _word("seen_from", "above: as a map, east to the right; below: as one looks up, east to the left",
          words=("above", "below"), default="above"),
    _number("range", "ends of the colour bar", "LOW HIGH", usual="the values, at most four decades"),
    _word("scale", "shared: one colour bar for all domes; each: a bar for each dome, where some would be dark",
          words=("shared", "each"), default="shared"),
    Option("cmap", "colour map of matplotlib", "NAME", usual="viridis, of pulls RdBu_r"),
    _word("norm", "of the colours", words=("log", "linear"), usual="log, of pulls linear"),
    Option("title", "above the picture", "TEXT", usual="what PATH is"),
    _flag("no_caption", "leave out the sentences below, as for a paper"),
    _word("show", "of a scene or a run: radiance, or photons per steradian", words=("radiance", "counts"),
          usual="radiance of a scene, counts of a run"),
    _word("quantity", "of a run whose light is polarised: its degree or angle of linear polarisation",
          words=("dop", "aop")),
    _flag("pull", "of a run: photons less what is expected, over the standard deviation of independent photons"),
    _waveband("plot.waveband", "only this band, or this table of a file, from 1", usual="all, 12 spread over more"),
    _seed("plot.seed", "of the counts of a scene", default=0),
    _wavelengths("plot.wavelengths", "of a background sky, with blanks or commas", usual="near 550"),
    Option("frames", "how many they are, from the first key to the last, or over a day or a week", "N",
           kind=Kind.COUNT, low=2, high=12, usual="12"),
    # export
    Option("to", "the format; see docs/export.md", kind=Kind.FORMAT, is_needed=True),
    Option("export.out", "folder, or a file of mcpl (.mcpl), netcdf (.nc), source (.sky) or envmap (.npy, .hdr, "
           ".exr)", "PATH", usual="beside RUN: RUN.mcpl, RUN.nc, RUN.sky, or RUN-FORMAT for a folder"),
    _waveband("export.waveband", "only this band, from 1; netcdf and source always hold all"),
    Option("export.scene", "amc.inp of the run's scene, for aomc: its files are copied beside the sky", "AMC_INP"),
    _flag("export.force", "replace what is there"),
    # verify
    _flag("verify.quiet", "print what failed, and nothing else", short="-q"),
    _flag("verify.verbose", "a line for every check of every waveband", short="-v"),
    _waveband("verify.waveband", "only the photons of this band, from 1"),
    _number("resample", "part of the photons that is made again, in blocks drawn at random, at least one block of each "
            "band; 0: none", "FRACTION", low=0, high=1, usual="1"),
    _flag("statistics", "test the directions of a run against its sky, too"),
    _number("level", "chance that correct photons fail any of the tests", "P", low=1e-100, high=0.5, default=1e-6),
    _seed("verify.seed", "of the choice of blocks with --resample, and of the random choice that thins photons",
          usual="drawn at random and printed, and 0"),
    Option("verify.scene", "amc.inp (or measured sky) of the scene that they should come from; of a run folder, the "
           "scene that its plan is compared with, read as `aomc-sky run` read it", "AMC_INP"),
    _wavelengths("verify.wavelengths", "of a measured sky: the wavebands, as `aomc-sky run` had them, with blanks or "
                 "commas"),
    _word("verify.method", "how they depend on each other: independent draws (iid), or spread more evenly than chance",
          words=("iid", "stratified"), usual="what the head of an MCPL file of ours says, and iid of others"),
    _word("frame", "which way z grows in their directions; AOMC's is down", words=("up", "down"), usual="up"),
    Option("verify.weights", "their weights, a .npy file of shape (n,)", "FILE"),
    # perez
    _bins("perez.bins", "equal bins", default=(45, 180)),
    Option("write_skydist", "radiances as a skydist.inp", "FILE"),
    Option("perez.wavelength", "wavelength of the table in skydist.inp, and of photons", "NM", kind=Kind.WAVELENGTH,
           default=550.0),
    Option("plot", "the sky dome as .png, .svg or .pdf (needs the extra 'plot')", "FILE"),
    Option("perez.out", "run folder with the photons of the sky", "DIR"),
    Option("perez.iterations", "photons", "N", kind=Kind.PHOTONS, default=10**6),
    _flag("perez.force", "replace files that another program wrote, and another run in the folder"),
    Option("perez.wavelengths", "with --out: wavebands in place of the one of --wavelength, with blanks or commas",
           "NM...", kind=Kind.WAVELENGTHS),
    _flag("perez.diffuse_only", "with --out: photons of the sky without those of the sun's beam"),
    _flag("with_beam", "with --out: beam and sky, as without it; an error where the beam is not known"),
    _flag("perez.verbose", "with --out: print how photons are drawn", short="-v"),
    # atmosphere
    Option("atmosphere.zenith_deg", "zenith angle of the sun: a number, several with commas, START:END:STEP, or all: "
           "as many from 0 to 90 as the description's scattering texture has", "DEG", kind=Kind.SUNS,
           option="--sun-zenith", default=(40.0,)),
    _angle("atmosphere.azimuth_deg", "azimuth of the sun from +x towards +y", option="--sun-azimuth", default=0.0),
    _wavelengths("atmosphere.wavelengths", "wavelengths with blanks or commas, between those of the description",
                 usual="all"),
    _word("atmosphere.method", "sos: successive orders of scattering, with a warning for a sun lower than 10 degrees; "
          "order1: light scattered once; mc: backward paths through shells, for any sun; auto: mc where sos is not "
          "accurate", words=("sos", "order1", "mc", "auto"), default="sos", section="atmosphere"),
    Option("orders", "most interactions that count", "N", kind=Kind.COUNT, low=1, high=400, section="atmosphere",
           usual="the description's"),
    Option("paths", "backward paths of mc and of a glowing ground in each direction and at each wavelength; four times "
           "as many halve the error", "N", kind=Kind.COUNT, low=8, high=1_000_000_000, section="atmosphere",
           usual="4096, or 16384 where these are not enough, and 32768 of the ground"),
    _seed("atmosphere.seed", "of the random numbers of the paths; several seeds show the error", default=0,
          section="atmosphere"),
    _bins("atmosphere.bins", "equal bins of zenith and azimuth",
          usual="those of the description's scattering texture, or 45 180"),
    Option("atmosphere.out", "the sky as one netCDF file, which [sky] table of sky.toml reads", "FILE"),
    Option("out_dir", "folder of the tables; made if it does not exist", "DIR"),
    _flag("atmosphere.force", "replace files there that aomc-sky did not write"),
    _flag("no_netcdf", "leave atmosphere.nc out"),
    _flag("no_save_tex", "read and check the description, print the plan, solve nothing"),
    Option("texture_save_precision", "atmosphere.nc in float32 with significands of so many bits", "BITS",
           kind=Kind.COUNT, low=1, high=24, usual="float64"),
    _flag("save_irradiance", "irradiances order by order"),
    _flag("save_scat_density2_from_ground", "source function of order 2 from light of the ground, with --method sos"),
    _flag("save_scat_density", "source functions of orders 2 and up, with --method sos"),
    _flag("save_accum_scattering", "radiance of all orders up to each"),
    _flag("save_light_pollution", "light of a ground of 1 cd/m2, order by order, by backward paths"),
)  # fmt: skip

_ALL = (*_KEYS, *INPUTS.values(), *FIELD.values(), *LOBES.values(), *_OF_COMMANDS)
OPTIONS = _table(*_ALL)
"""All rows by name."""
assert len(OPTIONS) == len(_ALL), "two rows have one name"

_SECTIONS = ("perez", "sun", "clear_sky", "sky", "photons", "background", "atmosphere")
SECTIONS: dict[str, dict[str, Option]] = {
    section: {row.key or row.own_name: row for row in _ALL if row.section == section} for section in _SECTIONS
}
"""Sections of sky.toml: keys, and their rows."""


SURE_NM = 2800.0
"""Longer wavelengths without a unit may be angstroms."""


def in_nm(wavelength: float, shown: str) -> str:
    """What to write for a wavelength that is in micrometres or metres, as a person gave it; else empty."""
    is_small, is_tiny = 0.1 <= wavelength < 20.0, 0.0 < wavelength < 1e-4
    if not is_small and not is_tiny:
        return ""
    unit, factor = ("micrometres", 1000) if is_small else ("metres", 1e9)
    return f"wavelengths are in nm, got {shown} ({unit}?); write {factor * wavelength:g}"


_NAMED = re.compile(r"\{(\w+)(?::([^{}]*))?\}")


def say(text: str) -> str:
    """A text with inputs by both names: "{dhi}" is "--dhi (dhi=)", "{spectrum:flat}" has the value in both."""
    return _NAMED.sub(lambda found: _named(found[1], found[2] or "") if found[1] in INPUTS else found[0], text)


def listed(names: Iterable[str]) -> str:
    """Inputs by both names, as a list for people; "disc:False" has a value."""
    *others, last = dict.fromkeys(say(f"{{{name}}}") for name in names)
    return f"{', '.join(others)} and {last}" if others else last


_OBJECTS = ("coefficients", "polarisation")
"""Inputs whose values are no text in Python."""


def _named(name: str, value: str) -> str:
    """An input by both names, with a value."""
    row = INPUTS[name]
    option, shown = f"{row.flag} {value}".rstrip(), value
    if row.kind in (Kind.SWITCH, Kind.FLAG):
        option = f"--no-{row.flag[2:]}" if value == "False" else row.flag
        shown = value or "True"
    elif value and (row.words or name == "sky"):
        shown = f'"{value}"'
    return f"{option} ({row.keyword or name}={'' if name in _OBJECTS else shown})"
