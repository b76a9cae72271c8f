"""Units of spectral radiance: the factor that a person computes by hand, or none."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from aomc_sky.formats.radiance_unit import radiance_factor

UNITS = {
    "W m-2 nm-1 sr-1": 1.0, "W/(m^2 nm sr)": 1.0, "W/m²/sr/nm": 1.0, "W m**-2 sr**-1 nm**-1": 1.0,
    "mW m-2 nm-1 sr-1": 1e-3, "mW m⁻² nm⁻¹ sr⁻¹": 1e-3, "uW cm-2 nm-1 sr-1": 1e-2, "µW/cm2/sr/nm": 1e-2,
    "W m-2 um-1 sr-1": 1e-3, "W_m2_nm_sr": 1.0, "kW per m2 per sr per nm": 1e3, "W m-2 m-1 sr-1": 1e-9,
    "10^-3 W m-2 nm-1 sr-1": 1e-3, "1e-3 W m-2 nm-1 sr-1": 1e-3, "0.01 W m-2 nm-1 sr-1": 0.01,
    "10 W m-2 um-1 sr-1": 0.01, "W m-2 sr-1 per 10 nm": 0.1, "100*W/m2/nm/sr": 100.0, "mW/(cm^2 um sr)": 0.01,
    "W·m⁻²·sr⁻¹·nm⁻¹": 1.0, "10⁻³ W m⁻² nm⁻¹ sr⁻¹": 1e-3, "W / m^2 / sr / 10 nm": 0.1, "2.5 mW/(m2 nm sr)": 2.5e-3,
    "nm-1 sr-1 W m-2": 1.0, "nW cm-2 sr-1 nm-1": 1e-5, "Wm-2 sr-1 nm-1": 1.0, "uWcm-2 nm-1 sr-1": 0.01,
    "W m^-2 angstrom^-1 sr^-1": 10.0, "W/(m2*nm*sr)": 1.0, " W m-2 nm-1 sr-1 ": 1.0,
    "relative": 0.0, "Relative": 0.0, "sr-1": 0.0, "1": 0.0,
    "": None, "W m-2 nm-1": None, "W m-2 sr-1": None, "cd m-2": None, "umol m-2 s-1": None, "W m-2 nm-1 sr-1 s": None,
    "W W m-2 nm-1 sr-1": None, "mW/(m2 sr cm-1)": None, "0 W m-2 nm-1 sr-1": None, "MW m-2 nm-1 sr-1": None,
    "mW/(m2 nm sr": None, "mW/m2 nm) sr": None, "W m-2 sr-1 Hz-1": None, "W m-2 nm-1 sr-1 (10)": None, "2.5": None,
    "photons s-1 m-2 nm-1 sr-1": None, "1e400 W m-2 nm-1 sr-1": None, "W/m2/nm/": None, "W/m2 nm sr": None,
    "1e-3 1e-3": None, "W m-2 nm-2 sr-1": None, "W m-1 nm-1 sr-1": None, "-1 W m-2 nm-1 sr-1": None,
    "W m-2 nm-1 sr-1 / 1000": None, "10 W m-2 nm-1 sr-1 per 10 nm": None, "10^999 W m-2 nm-1 sr-1": None,
    "hundredths of W m-2 nm-1 sr-1": None, "log10(W m-2 nm-1 sr-1)": None, "mW m-2 nm-1 sr-1 x 1000": None,
    "W m-2 100nm-1 sr-1": None, "W m-2 nm-1 1000 sr-1": None,
    "counts": None, "%": None, "arbitrary units": None, "W " * 60: None,
}  # fmt: skip


@pytest.mark.parametrize("unit", UNITS)
def test_units(unit):
    """Exact: the value of the decimal factor in float64."""
    assert radiance_factor(unit) == UNITS[unit]


@given(st.text(alphabet="W mkµn/-^*()0123e.srm_per", max_size=40))
def test_any_text_is_a_positive_factor_or_none(unit):
    factor = radiance_factor(unit)
    assert factor is None or factor >= 0.0


@given(
    power=st.sampled_from([("W", 1.0), ("mW", 1e-3), ("uW", 1e-6), ("kW", 1e3)]),
    area=st.sampled_from([("m", 1.0), ("cm", 1e4), ("mm", 1e6)]),
    length=st.sampled_from([("nm", 1.0), ("um", 1e-3), ("angstrom", 10.0)]),
    number=st.sampled_from([("", 1.0), ("10^-3 ", 1e-3), ("0.01 ", 0.01), ("100*", 100.0)]),
    order=st.permutations(range(3)),
    is_slashed=st.booleans(),
)
def test_spellings_of_one_unit(power, area, length, number, order, is_slashed):
    parts = [f"{area[0]}2", length[0], "sr"] if is_slashed else [f"{area[0]}-2", f"{length[0]}-1", "sr-1"]
    parts = [parts[k] for k in order]
    text = "/".join([power[0], *parts]) if is_slashed else " ".join([power[0], *parts])
    expected = number[1] * power[1] * area[1] * length[1]
    assert radiance_factor(number[0] + text) == pytest.approx(expected, rel=1e-14)
