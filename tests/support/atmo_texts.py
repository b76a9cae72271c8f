"""Descriptions as text: flat layers under a huge radius, and the atmosphere of the spherical reference tables."""

from tests.support.atmospheres import OZONE_M2

RAYLEIGH = "return vec4(3/(16*PI)*(1 + sqr(dotViewSun)));"
PEAK = """CONST float g = 0.76;
CONST float k = 3/(8*PI)*(1-g*g)/(2+g*g);
return vec4(0.904*(k*(1+sqr(dotViewSun))/pow(1+g*g-2*g*dotViewSun, 1.5) + 1/(600*(1-dotViewSun)+0.05)));"""
OZONE = """float h = altitude/km;
float scale = 370*dobsonUnit;
if(h < 8.)
    return scale*(7.2402403521159135e-6 - 1.206527437798165e-7*h);
else if(h < 21.5)
    return scale*(-2.0590185333577628e-5 + 3.3581504669318765e-6*h);
else if(h < 39.)
    return scale*(1.0542813563268143e-4 - 2.50316678731273e-6*h);
return scale*0.04298160111157969*exp(-0.2208669270720561*h);"""


def henyey_greenstein(g):
    return f"CONST float g = {g!r};\nreturn vec4((1 - g*g)/(4*PI*pow(1 + g*g - 2*g*dotViewSun, 1.5)));"


def scatterer(name, density, phase, section, angstrom, albedo=""):
    """A section; `albedo` is the spectrum of the single-scattering albedo."""
    line = f"single scattering albedo: {albedo}\n" if albedo else ""
    return (
        f'Scatterer "{name}":\n{{\nnumber density:\n```\n{density}\n```\nphase function:\n```\n{phase}\n```\n'
        f"cross section at 1 um: {section}\nangstrom exponent: {angstrom:g}\n{line}}}\n"
    )


def absorber(name, density, section):
    return f'Absorber "{name}":\n{{\nnumber density:\n```\n{density}\n```\ncross section: {section}\n}}\n'


def head(*, height, radius, wavelengths, albedo, n):
    """What comes before the species, under a sun of 1 W m-2 nm-1."""
    return (
        f"version: 6\natmosphere height: {height}\nEarth radius: {radius}\nEarth-Sun distance: 1 AU\n"
        f"scattering orders: 1000\nwavelengths: {wavelengths}\nsolar irradiance at TOA: {', '.join(['1'] * n)}\n"
        f"ground albedo: {albedo}\n"
    )


def reference_air(case, wavelength_nm, albedo):
    """Case `rayleigh`, `mol_ozone` or `full` of the spherical tables, at one wavelength."""
    text = head(
        height="120 km", radius="6371 km", wavelengths=f"min={wavelength_nm}nm,max={wavelength_nm + 3}nm,count=4", n=4,
        albedo=", ".join([repr(albedo)] * 4),
    )  # fmt: skip
    text += scatterer("air", "return 3.08458e25*exp(-altitude/(8*km));", RAYLEIGH, "0.04022 fm^2", 4)
    if case == "full":
        text += scatterer("aerosol", "return 1.03333e8*exp(-altitude/(1.2*km));", PEAK, "0.042968 um^2", 0)
    if case != "rayleigh":
        text += absorber("ozone", OZONE, ", ".join([repr(OZONE_M2[wavelength_nm])] * 4))
    return text
