"""The light of a cloudless sky: SPCTRL2 (`--spectrum spectrl2`) beside multiple scattering by PythonicDISORT.

    python bench/clear_sky.py [differences | irradiance | literals | gregg-carder | sun]

Two plane layers: molecules above 2 km; below it molecules with all aerosol. The molecules have the optical depth of
Bodhaine et al. (1999) and depolarisation 0.029. Water 1.4 cm, ozone 0.3 cm, albedo of the ground 0.06. The sun's
spectrum and what gases absorb are those of SPCTRL2, so that scattering alone is compared. DISORT scatters by the phase
function of Henyey and Greenstein. The aerosols, their optical depth being that at 500 nm:

    rural     that of SPCTRL2: exponent 1.14, single scattering albedo 0.945 at 400 nm, variation 0.095, g = 0.65
    maritime  exponent 0.3, single scattering albedo 0.98 at all wavelengths, g = 0.75

`differences` prints SPCTRL2 over DISORT less 1 in per cent, direct / diffuse / both, on a horizontal plane: for both
aerosols, and for the rural one of SPCTRL2 where the air is maritime in truth. The path of the beam is 1 / cos Z in
plane layers and the air mass of Kasten and Young in SPCTRL2: at 80° the round earth is in the difference of the direct
light. 32 streams change 0.01 %, 48 layers 0.5 %. Light is not polarised.

`irradiance` prints both in W m-2 nm-1 for 12 suns, at the mean distance of the sun; `literals` the values of DISORT
that tests/source/light/test_clear_sky.py holds.

`gregg-carder` prints SPCTRL2 over the model of Gregg and Carder (1990), by which HydroLight finds the light of a
cloudless sky, less 1 in per cent. It has no light that the ground sends up and the sky sends back, no correction of
ultraviolet and violet light, and an aerosol of its own: for the exponent 0.3 (their air mass type 1, 80 % humidity)
g = 0.7775 and single scattering albedo 0.9928.

`sun` prints SPCTRL2's sun over that of ASTM G173-03 less 1 in per cent. SPCTRL2 has a value every 10 nm (every 20 nm
near 555 and 670 nm), read at the wavelength by linear interpolation; ASTM G173 has one every 0.5 or 1 nm, here its
means over 5, 10 and 20 nm.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pvlib  # type: ignore[import-untyped]
from PythonicDISORT.pydisort import pydisort  # type: ignore[import-untyped]

NM = np.array([412.0, 443.0, 490.0, 555.0, 670.0])
TURBIDITIES, SUNS_DEG = (0.0, 0.05, 0.1, 0.3), (0.0, 30.0, 50.0, 70.0, 80.0)  #: Optical depths at 500 nm.
CLASSES = {"0° to 50°": (0.0, 30.0, 50.0), "70°": (70.0,), "80°": (80.0,)}
ALBEDO, N_STREAMS = 0.06, 16
BELOW = 0.22  #: Share of the molecules below 2 km.
SECOND_MOMENT = 0.0957  #: Of the molecules' phase function: (1 - y) / (10 (1 + 2 y)), y = 0.029 / (2 - 0.029).
DAY = 93  #: Near the mean distance of the sun, to which all irradiances are brought.
DAY_FACTOR = float(pvlib.irradiance.get_extra_radiation(DAY, solar_constant=1.0, method="spencer"))
WIDTHS_NM = (5.0, 10.0, 20.0)


class Aerosol(NamedTuple):
    """Typed here once more, so that a slip in the package shows."""

    exponent: float
    albedo_400nm: float
    variation: float
    asymmetry: float

    def depth(self, um: np.ndarray, turbidity: float) -> np.ndarray:
        """Optical depth."""
        return turbidity * (um / 0.5) ** -self.exponent

    def albedo(self, um: np.ndarray) -> np.ndarray:
        """Of single scattering."""
        return self.albedo_400nm * np.exp(-self.variation * np.log(um / 0.4) ** 2)


RURAL, MARITIME = Aerosol(1.14, 0.945, 0.095, 0.65), Aerosol(0.3, 0.98, 0.0, 0.75)
OF_GREGG_CARDER = Aerosol(0.3, (0.972 - 0.0032) * math.exp(3.06e-4 * 80.0), 0.0, 0.82 - 0.14167 * 0.3)
AEROSOLS = {"rural": RURAL, "maritime": MARITIME}


def molecules(um: np.ndarray) -> np.ndarray:
    """Optical depth by Bodhaine et al. (1999), eq. (30): sea level, 45 degrees of latitude."""
    above, below = 1.0455996 - 341.29061 / um**2 - 0.90230850 * um**2, 1.0 + 0.0027059889 / um**2 - 85.968563 * um**2
    return 0.0021520 * above / below


def molecules_of_spctrl2(um: np.ndarray) -> np.ndarray:
    return 1.01325 / 1.013 / (um**4 * (115.6406 - 1.3366 / um**2))


def air_mass(sun_zenith_deg: float) -> float:
    return float(pvlib.atmosphere.get_relative_airmass(sun_zenith_deg))


def by_spctrl2(aerosol: Aerosol, turbidity: float, sun_zenith_deg: float) -> tuple[np.ndarray, np.ndarray]:
    """Direct and diffuse horizontal irradiance, and the sun's normal one times the transmittance of all gases."""
    zenith, mass = np.array([sun_zenith_deg]), air_mass(sun_zenith_deg)
    found = pvlib.spectrum.spectrl2(
        apparent_zenith=zenith, aoi=zenith, surface_tilt=0.0, ground_albedo=ALBEDO, surface_pressure=101_325.0,
        relative_airmass=mass, precipitable_water=1.4, ozone=0.3, aerosol_turbidity_500nm=turbidity, dayofyear=DAY,
        alpha=aerosol.exponent, scattering_albedo_400nm=aerosol.albedo_400nm,
        wavelength_variation_factor=aerosol.variation, aerosol_asymmetry_factor=aerosol.asymmetry,
    )  # fmt: skip
    nm, outside, beam = np.ravel(found["wavelength"]), found["dni_extra"][:, 0], found["dni"][:, 0]
    um = nm / 1000.0
    gases = beam * np.exp(mass * (molecules_of_spctrl2(um) + aerosol.depth(um, turbidity)))
    light = np.array([beam * math.cos(math.radians(sun_zenith_deg)), found["dhi"][:, 0], gases])
    light = np.interp(NM, nm, outside / DAY_FACTOR) * np.array([np.interp(NM, nm, one) for one in light / outside])
    return light[:2], light[2]


def by_disort(aerosol: Aerosol, turbidity: float, sun_zenith_deg: float) -> np.ndarray:
    """Direct and diffuse horizontal irradiance for a beam of 1."""
    um, orders = NM / 1000.0, np.arange(N_STREAMS + 1)
    rayleigh = np.where(orders == 0, 1.0, np.where(orders == 2, SECOND_MOMENT, 0.0))
    light = []
    for molecule_depth, depth, single in zip(
        molecules(um), aerosol.depth(um, turbidity), aerosol.albedo(um), strict=True
    ):
        layers = molecule_depth * np.array([1 - BELOW, BELOW]) + np.array([0.0, depth])
        scattering = layers - np.array([0.0, (1 - single) * depth])
        share = np.array([0.0, single * depth / scattering[1]])[:, None]
        legendre = share * aerosol.asymmetry**orders + (1 - share) * rayleigh
        total = np.cumsum(layers)
        _, _, flux_down, *_ = pydisort(
            total, np.minimum(scattering / layers, 1 - 1e-6), N_STREAMS, legendre,
            math.cos(math.radians(sun_zenith_deg)), 1.0, 0.0, only_flux=True, f_arr=legendre[:, -1],
            BDRF_Fourier_modes=[ALBEDO],  # not over pi: only so does the ground send ALBEDO of its light up
        )  # fmt: skip
        light.append(flux_down(total[-1])[::-1])
    return np.array(light).T


def by_gregg_carder(aerosol: Aerosol, turbidity: float, sun_zenith_deg: float) -> np.ndarray:
    """Direct and diffuse horizontal irradiance for a normal one of 1, which gases have passed."""
    um, mass, cosine = NM / 1000.0, air_mass(sun_zenith_deg), math.cos(math.radians(sun_zenith_deg))
    rayleigh, depth = np.exp(-mass * molecules_of_spctrl2(um)), aerosol.depth(um, turbidity)
    scattered, absorbed = aerosol.albedo(um) * depth, (1.0 - aerosol.albedo(um)) * depth
    log = math.log(1.0 - aerosol.asymmetry)
    one, two = log * (1.459 + log * (0.1595 + log * 0.4129)), log * (0.0783 + log * (-0.3824 - log * 0.5874))
    forward = 1.0 - 0.5 * math.exp((one + two * cosine) * cosine)
    diffuse = 0.5 * (1.0 - rayleigh**0.95) + forward * rayleigh**1.5 * (1.0 - np.exp(-mass * scattered))
    return cosine * np.array([rayleigh * np.exp(-mass * depth), np.exp(-mass * absorbed) * diffuse])


def with_sum(light: np.ndarray) -> np.ndarray:
    return np.vstack([light, light.sum(axis=0)])


def exact(aerosol: Aerosol, turbidity: float, sun_deg: float) -> np.ndarray:
    """Direct, diffuse and global irradiance by DISORT, with the sun and the gases of SPCTRL2. [W m-2 nm-1]"""
    _, gases = by_spctrl2(aerosol, turbidity, sun_deg)
    return with_sum(by_disort(aerosol, turbidity, sun_deg) * gases)


def ours(aerosol: Aerosol, turbidity: float, sun_deg: float) -> np.ndarray:
    return with_sum(by_spctrl2(aerosol, turbidity, sun_deg)[0])


Table = Callable[
    [float, float], np.ndarray
]  #: Per cent of an optical depth and a sun: three rows, a column for each NM.


def print_table(off: Table, turbidities: tuple[float, ...] = TURBIDITIES) -> None:
    print("| aerosol | sun | 412 | 443 | 490 | 555 | 670 |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    ends: dict[str, list[np.ndarray]] = {name: [] for name in CLASSES}
    for turbidity in turbidities:
        for name, suns_deg in CLASSES.items():
            for sun_deg in suns_deg:
                found = off(turbidity, sun_deg)
                cells = (" / ".join(f"{one:+.1f}" for one in band) for band in found.T)
                print(f"| {turbidity:g} | {sun_deg:g}° | {' | '.join(cells)} |")
                ends[name].append(found)
    for name, rows in ends.items():
        ranges = (f"{row.min():+.1f} to {row.max():+.1f}" for row in np.hstack(rows))
        print(f"{name}: direct / diffuse / both {' / '.join(ranges)} %.")


def print_differences() -> None:
    cases = [(f"{name}, against {name} air", one, one) for name, one in AEROSOLS.items()]
    for title, model, air in [*cases, ("rural, against maritime air", RURAL, MARITIME)]:

        def off(depth: float, sun: float, model: Aerosol = model, air: Aerosol = air) -> np.ndarray:
            return 100 * (ours(model, depth, sun) / exact(air, depth, sun) - 1)

        print(f"\nSPCTRL2 {title}\n")
        print_table(off)


def print_irradiance(turbidity: float = 0.1) -> None:
    for name, aerosol in AEROSOLS.items():
        print(f"\n{name}, {turbidity:g} at 500 nm\n")
        print("| sun | 443, SPCTRL2 | DISORT | 555, SPCTRL2 | DISORT |")
        print("| --- | --- | --- | --- | --- |")
        for sun_deg in np.linspace(0.0, 82.5, 12).tolist():
            pair = [one(aerosol, turbidity, sun_deg)[2] for one in (ours, exact)]
            print(f"| {sun_deg:g}° | " + " | ".join(f"{one[band]:.4f}" for band in (1, 3) for one in pair) + " |")


def print_literals() -> None:
    for name, aerosol in AEROSOLS.items():
        for turbidity in (0.05, 0.1, 0.3):
            for sun_deg in SUNS_DEG[1:]:
                direct, diffuse, _ = exact(aerosol, turbidity, sun_deg)
                values = ", ".join(f"{one:.4g}" for one in [*direct, *diffuse])
                print(f'    ("{name}", {turbidity:g}, {sun_deg:g}): [{values}],')


def print_gregg_carder() -> None:
    def off(model: Aerosol) -> Table:
        def per_cent(turbidity: float, sun_deg: float) -> np.ndarray:
            _, gases = by_spctrl2(MARITIME, turbidity, sun_deg)
            theirs = with_sum(by_gregg_carder(OF_GREGG_CARDER, turbidity, sun_deg) * gases)
            return 100 * (ours(model, turbidity, sun_deg) / theirs - 1)

        return per_cent

    for name, model in AEROSOLS.items():
        print(f"\nSPCTRL2 {name}, over Gregg and Carder with the exponent 0.3\n")
        print_table(off(model), (0.05, 0.1, 0.3))


def print_sun() -> None:
    zenith = np.array([30.0])
    found = pvlib.spectrum.spectrl2(
        apparent_zenith=zenith, aoi=zenith, surface_tilt=0.0, ground_albedo=ALBEDO, surface_pressure=101_325.0,
        relative_airmass=1.15, precipitable_water=1.4, ozone=0.3, aerosol_turbidity_500nm=0.1, dayofyear=DAY,
    )  # fmt: skip
    mine = np.interp(NM, np.ravel(found["wavelength"]), found["dni_extra"][:, 0] / DAY_FACTOR)
    other = pvlib.spectrum.get_reference_spectra()["extraterrestrial"]
    print(f"| mean of ASTM G173 over | {' | '.join(f'{one:g} nm' for one in NM)} |")
    print("| --- | --- | --- | --- | --- | --- |")
    for width in WIDTHS_NM:
        steps = np.linspace(-0.5, 0.5, 2001) * width
        means = [np.interp(one + steps, other.index, other).mean() for one in NM]
        print(f"| {width:g} nm | {' | '.join(f'{100 * one:+.1f}' for one in mine / means - 1)} |")


TABLES = {
    "differences": print_differences,
    "irradiance": print_irradiance,
    "literals": print_literals,
    "gregg-carder": print_gregg_carder,
    "sun": print_sun,
}

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="SPCTRL2 beside PythonicDISORT and others")
    parser.add_argument("table", nargs="?", choices=TABLES, default="differences", help="default: differences")
    TABLES[parser.parse_args().table]()
