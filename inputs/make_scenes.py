"""Write the scenes of this folder: `python inputs/make_scenes.py [FOLDER]`; plain numpy, no aomc_sky.

night.h5 of the scene night_sky is written by make_night.py, with aomc_sky's own writer.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

_LABELS = (
    "1)Iterations                                  :",
    "2)Light source from model(0) or file(1)       :",
    " a) direct azimuth angle(deg)                 :",
    " b) direct zenith angle(deg)                  :",
    "3)number of system constituents               :",
    "4)depth (M)                                   :",
    "5)side boundaries (M)                         :",
    "6)Number of depth recording layers            :",
    "  a) Thickness of each recording layer        :",
    "7)# of alpha intervals to bin (MAX=180)       :",
    "8)# of phi intervals to bin (MAX=180)         :",
    "           Interval type (ang = 1,cos = 0)    :",
    "9)X,Y,Z for absorption (yes=1,no=0)           :",
    "10)BOT.-output(yes=1,no=0)                    :",
    "11)SIDE-output(yes=1,no=0)                    :",
    "12)SPF from file? (yes=1,no=0)                :",
    "   a) Number of angles                        :",
    "13)# of concentration dependent layers        :",
    "14)Number of cells in X-Y direction(0=NOGRID) :",
    "      Cell size (in unit meters)              :",
    "      Output to Surfer format (yes=1,no=0)    :",
    "15)Light source: point[1],circle[2],rect.[3]  :",
    "    a)If circle, define diameter              :",
    "    b)If rectangle, define dX                 :",
    "    c)          and define dY                 :",
    "16)Bottom target: NO[0],YES[1]                :",
    "      define dX                               :",
    "      define dY                               :",
    "17)Normalize output to air(0) or water(1)     :",
    "18)Number of wavebands (minimum = 1)          :",
)


def amc(iterations: int, *, flag: int, n_wavebands: int, azimuth: int = 0, zenith: int = 0, footprint: int = 1) -> str:
    """Return the text of an amc.inp."""
    values = [iterations, flag, azimuth, zenith, 1, 100.0, 10000.0, 5, 1.0, 90, 10, 1, 0, 0, 0, 1, 55, 1, 0, 2.0, 0]
    values += [footprint, 3.0, 2.0, 8.0, 0, 1.0, 1.0, 0, n_wavebands]
    return "".join(f"{label} {value}\n" for label, value in zip(_LABELS, values, strict=True))


def lambbot(wavelengths: list[float]) -> str:
    """Return the text of a lambbot.inp with a dark bottom."""
    return f"{len(wavelengths)}\n" + "".join(f"{w:.1f} 0.05 0.0\n" for w in wavelengths)


def skydist(wavelengths: list[float], values: np.ndarray) -> str:
    """Return the text of a skydist.inp; values (n_wavelength, n_zenith, n_azimuth), zeros are left out."""
    n_wl, n_zenith, n_azimuth = values.shape
    texts = np.char.mod("%.5g", values)
    where = np.argwhere(values > 0)
    rows = "".join(f"{w + 1} {z + 1} {a} {texts[w, z, a]}\n" for w, z, a in where.tolist())
    return f"{len(where)} {n_zenith} {n_azimuth - 1} {n_wl}\n{' '.join(f'{w:g}' for w in wavelengths)}\n{rows}"


def centres(n_zenith: int, n_azimuth: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Zenith and azimuth of bin centres [rad] and projected solid angle of the bins [sr]."""
    edges = np.linspace(0, np.pi / 2, n_zenith + 1)
    area = np.diff(np.sin(edges) ** 2) / 2 * (2 * np.pi / n_azimuth)
    zenith = (edges[:-1] + edges[1:]) / 2
    azimuth = (np.arange(n_azimuth) + 0.5) * 2 * np.pi / n_azimuth
    return zenith[:, None], azimuth[None, :], area[:, None]


LISTED = """[sky]
weighting = "listed"  # the values of skydist.inp are shares of the light of a waveband, not radiances
"""


def clear_day() -> dict[str, str]:
    """A smooth clear sky, sun at 35 degrees: bluer away from the sun, brighter around it and at the horizon."""
    wavelengths = [440.0, 550.0, 670.0]
    zenith, azimuth, area = centres(90, 360)
    sun = np.deg2rad(35.0)
    cos_gamma = np.cos(zenith) * np.cos(sun) + np.sin(zenith) * np.sin(sun) * np.cos(azimuth)
    gamma = np.arccos(np.clip(cos_gamma, -1, 1))
    skies = []
    for wavelength in wavelengths:
        blue = (440.0 / wavelength) ** 4
        air = 1 - np.exp(-0.25 * blue / (np.cos(zenith) + 0.05))
        skies.append(air * (blue * (1 + cos_gamma**2) + 9 * np.exp(-5 * gamma)) * area * 1e4)
    files = {"amc.inp": amc(1_000_000, flag=1, n_wavebands=3, zenith=35)}
    return files | {
        "lambbot.inp": lambbot(wavelengths),
        "skydist.inp": skydist(wavelengths, np.stack(skies)),
        "sky.toml": LISTED,
    }


def sparse_sky() -> dict[str, str]:
    """Twenty scattered patches per wavelength; one waveband lies midway between two wavelengths."""
    rng = np.random.default_rng(7)
    values = np.zeros((3, 30, 72))
    for sky in values:
        sky.ravel()[rng.choice(sky.size, 20, replace=False)] = np.round(10 ** rng.uniform(-2, 3, 20), 4)
    files = {"amc.inp": amc(200_000, flag=1, n_wavebands=4, footprint=3)}
    return files | {
        "lambbot.inp": lambbot([450.0, 500.0, 575.0, 640.0]),
        "skydist.inp": skydist([450.0, 550.0, 650.0], values),
        "sky.toml": LISTED,
    }


def overcast() -> dict[str, str]:
    """The CIE overcast sky, radiance (1 + 2 cos) / 3, as masses; light enters through a circle."""
    zenith, azimuth, area = centres(18, 72)
    values = (1 + 2 * np.cos(zenith)) / 3 * area * np.ones_like(azimuth) * 1e4
    files = {"amc.inp": amc(500_000, flag=1, n_wavebands=1, footprint=2)}
    return files | {"lambbot.inp": lambbot([550.0]), "skydist.inp": skydist([550.0], values[None]), "sky.toml": LISTED}


def document_example() -> dict[str, str]:
    """The example of the format's description: six patches, two wavelengths, three wavebands."""
    rows = ["1 1 0 10.5", "1 1 1 12.0", "1 2 1 20.0", "2 1 0 8.2", "2 1 1 9.5", "2 2 1 15.3"]
    sky = "6 2 2 2\n550.0 650.0\n" + "".join(f"{row}\n" for row in rows)
    files = {"amc.inp": amc(10_000, flag=1, n_wavebands=3)}
    return files | {"lambbot.inp": lambbot([555.0, 580.0, 640.0]), "skydist.inp": sky}


def sun_and_sky() -> dict[str, str]:
    """Light-source flag 0: a beam at 40 degrees and a diffuse sky, five wavebands, circular footprint."""
    fractions = [0.55, 0.65, 0.72, 0.78, 0.82]
    difcol = "5\n" + "".join(f"{f:.2f} {i:.2f}\n" for f, i in zip(fractions, [0.8, 0.95, 1.0, 0.98, 0.9], strict=True))
    files = {"amc.inp": amc(400_000, flag=0, n_wavebands=5, azimuth=30, zenith=40, footprint=2)}
    return files | {"lambbot.inp": lambbot([400.0, 475.0, 550.0, 625.0, 700.0]), "difcol.inp": difcol}


def perez_sky() -> dict[str, str]:
    """Light-source flag 0 under a measured weather: sky.toml has the irradiances and the exact sun."""
    fractions, intensity = [0.74, 0.80, 0.86, 0.90], [0.72, 0.94, 1.0, 0.88]
    difcol = "4\n" + "".join(f"{f:.2f} {i:.2f}\n" for f, i in zip(fractions, intensity, strict=True))
    toml = (
        "[perez]\n"
        "dni = 850.0             # direct normal irradiance, W m-2\n"
        "dhi = 95.0              # diffuse horizontal irradiance, W m-2\n"
        "\n"
        "[sun]\n"
        "zenith_deg = 32.4       # finer than amc.inp's whole degrees\n"
        "azimuth_deg = 121.25\n"
        "disc = true             # the beam has the extent of the solar disc\n"
    )
    files = {"amc.inp": amc(500_000, flag=0, n_wavebands=4, azimuth=121, zenith=32, footprint=3)}
    return files | {"lambbot.inp": lambbot([400.0, 450.0, 550.0, 650.0]), "difcol.inp": difcol, "sky.toml": toml}


def beam_only() -> dict[str, str]:
    """Light-source flag 0, all light direct: no sky is ever modelled."""
    files = {"amc.inp": amc(100_000, flag=0, n_wavebands=2, azimuth=90, zenith=30)}
    return files | {"lambbot.inp": lambbot([500.0, 600.0]), "difcol.inp": "2\n1.0 1.0\n1.0 0.5\n"}


def night_sky() -> dict[str, str]:
    """A moonless night: the lobes of night.h5 are the only source; make_night.py writes that file."""
    toml = (
        "[sky]\n"
        'model = "none"          # no sun, no daylight: the backgrounds are the only source\n'
        "\n"
        "[[background]]\n"
        'file = "night.h5"       # starlight, airglow and a city, W m-2 nm-1\n'
        "time = 2026-02-14T21:30:00Z\n"
        "utc_offset = 1          # local time less UTC [h]: 22:30, when the city is being dimmed\n"
    )
    files = {"amc.inp": amc(200_000, flag=0, n_wavebands=5)}
    return files | {"lambbot.inp": lambbot([440.0, 490.0, 550.0, 590.0, 630.0]), "sky.toml": toml}


_CLEAR_ATMO = """\
version: 6
# Clear air over the sea: molecules, sea salt in the lowest kilometre or two, 300 Dobson units of ozone.

atmosphere height: 100 km
Earth radius: 6371 km
Earth-Sun distance: 1 AU
scattering orders: 12

wavelengths: min=410nm,max=680nm,count=4
solar irradiance at TOA: SUN  # means over 20 nm of atmosphere/spectra/sun_astm_g173.csv
ground albedo: 0.06, 0.05, 0.045, 0.04

Scatterer "air":
{
    number density:
    ```
        return 2.547e25 * exp(-altitude / (8.435*km));
    ```
    phase function:
    ```
        return vec4(3/(16*PI) * (1 + sqr(dotViewSun)));
    ```
    cross section at 1 um: 0.03914 fm^2
    angstrom exponent: 4.095
}

Scatterer "sea_salt":
{
    number density:
    ```
        return 6.0e8 * exp(-altitude / (1.2*km));
    ```
    # Henyey and Greenstein, mean cosine 0.75
    phase function:
    ```
        CONST float g = 0.75;
        return vec4((1 - g*g) / (4*PI * pow(1 + g*g - 2*g*dotViewSun, 1.5)));
    ```
    cross section at 1 um: 0.1194 um^2
    angstrom exponent: 0.3
}

Absorber "ozone":
{
    number density:
    ```
        CONST float width = 5*km;
        return 300*dobsonUnit / (width*sqrt(2*PI)) * exp(-0.5*sqr((altitude - 23*km) / width));
    ```
    cross section: 2e-27, 1.2e-25, 4.5e-25, 1.35e-25
}
"""


def under_sun(description: str, *wavelengths: float) -> str:
    """A description with the measured irradiance of the sun at its wavelengths, means over 20 nm, in place of SUN."""
    table = np.loadtxt(Path(__file__).parent / "atmosphere" / "spectra" / "sun_astm_g173.csv", delimiter=",")
    means = [table[np.abs(table[:, 0] - nm) < 10.0, 1].mean() for nm in wavelengths]
    return description.replace("SUN", ", ".join(f"{mean:.4g}" for mean in means))


def atmosphere_sky() -> dict[str, str]:
    """Sun and sky of a physical atmosphere: clear.atmo says how much light there is and from where."""
    toml = (
        "[atmosphere]\n"
        'file = "clear.atmo"     # molecules, aerosol and ozone; absolute light, so no difcol.inp\n'
        "\n"
        "[sun]\n"
        "zenith_deg = 41.5\n"
    )
    files = {"amc.inp": amc(300_000, flag=0, n_wavebands=4, azimuth=65, zenith=42, footprint=3)}
    return files | {
        "lambbot.inp": lambbot([412.0, 510.0, 590.0, 670.0]),
        "sky.toml": toml,
        "clear.atmo": under_sun(_CLEAR_ATMO, 410, 500, 590, 680),
    }


_NIGHT_ATMO = """\
version: 6
# Air and a little sea salt over dark water, for suns that have set or are hidden, and for a coast with towns.

atmosphere height: 100 km
Earth radius: 6371 km
Earth-Sun distance: 1 AU
Earth-Moon distance: 365000 km
scattering orders: 16

wavelengths: min=450nm,max=650nm,count=2
solar irradiance at TOA: SUN  # means over 20 nm of atmosphere/spectra/sun_astm_g173.csv
ground albedo: 0.05, 0.04
light pollution relative radiance: 1.09201e-5, 1.5668e-5  # white lamps, 1 cd/m2

Scatterer "air":
{
    number density:
    ```
        return 2.547e25 * exp(-altitude / (8.435*km));
    ```
    phase function:
    ```
        return vec4(3/(16*PI) * (1 + sqr(dotViewSun)));
    ```
    cross section at 1 um: 0.03914 fm^2
    angstrom exponent: 4.095
}

Scatterer "sea_salt":
{
    number density:
    ```
        return 3.0e8 * exp(-altitude / (1.2*km));
    ```
    # Henyey and Greenstein, mean cosine 0.75
    phase function:
    ```
        CONST float g = 0.75;
        return vec4((1 - g*g) / (4*PI * pow(1 + g*g - 2*g*dotViewSun, 1.5)));
    ```
    cross section at 1 um: 0.1194 um^2
    angstrom exponent: 0.3
}

Absorber "ozone":
{
    number density:
    ```
        CONST float width = 5*km;
        return 300*dobsonUnit / (width*sqrt(2*PI)) * exp(-0.5*sqr((altitude - 23*km) / width));
    ```
    cross section: 1.7e-26, 2.4e-25
}
"""


def _under_night_atmo(toml: str, *, zenith: int, bands: tuple[float, ...] = (450.0, 650.0)) -> dict[str, str]:
    """A scene under `_NIGHT_ATMO`."""
    head = '[atmosphere]\nfile = "air.atmo"\n'
    files = {"amc.inp": amc(100_000, flag=0, n_wavebands=len(bands), azimuth=90, zenith=zenith)}
    return files | {
        "lambbot.inp": lambbot(list(bands)),
        "sky.toml": head + toml,
        "air.atmo": under_sun(_NIGHT_ATMO, 450, 650),
    }


def twilight() -> dict[str, str]:
    """The sun 3 degrees below the horizon: only air above the earth's shadow is lit."""
    return _under_night_atmo("\n[sun]\nzenith_deg = 93         # 3 degrees below the horizon\n", zenith=89)


def eclipse() -> dict[str, str]:
    """A deep partial eclipse: the Moon stands beside the sun, so the sky has no plane of symmetry."""
    toml = (
        "moon_zenith_offset_deg = 0.04   # the Moon's centre is lower than the sun's\n"
        "moon_azimuth_offset_deg = 0.05  # and to its left\n"
        "\n"
        "[sun]\n"
        "zenith_deg = 55\n"
    )
    return _under_night_atmo(toml, zenith=55, bands=(450.0,))


def light_polluted() -> dict[str, str]:
    """Deep night over a coast with towns: the glow of the ground, scattered back, is the only light."""
    toml = (
        "ground_luminance_cd_m2 = 0.2    # the mean of town and country\n"
        "\n"
        "[sun]\n"
        "zenith_deg = 130                # deep below the horizon: no light of it\n"
    )
    return _under_night_atmo(toml, zenith=0)


SCENES = (
    document_example,
    clear_day,
    sparse_sky,
    overcast,
    sun_and_sky,
    perez_sky,
    atmosphere_sky,
    beam_only,
    night_sky,
    twilight,
    eclipse,
    light_polluted,
)


def main(folder: Path) -> None:
    """Write all scenes below a folder."""
    for scene in SCENES:
        target = folder / scene.__name__
        target.mkdir(parents=True, exist_ok=True)
        for name, text in scene().items():
            (target / name).write_bytes(text.encode("ascii"))


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
