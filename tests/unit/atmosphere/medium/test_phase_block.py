"""Phase functions from code blocks: integrals over the sphere against closed forms and 30 digits."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

from aomc_sky.atmosphere.language.block import Block
from aomc_sky.atmosphere.medium import PhaseBlock, read_phase_block, sphere_integral
from aomc_sky.errors import InputFileError
from tests.support.atmospheres import PEAK_NORM, rayleigh_phase, sample_aerosol_phase
from tests.support.blocks import GIVEN, phase_block
from tests.unit.atmosphere.language.test_block_shapes import COLOURED, CORNETTE, PEAKED, RAYLEIGH

ROWS = ((0, 0), (0, 3))


def hg(g: float) -> str:
    return f"const float g = {g!r}; return vec4((1-g*g)/(4*PI*pow(1+g*g-2*g*dotViewSun, 1.5)));"


def norm_of(text: str) -> np.ndarray:
    return sphere_integral(phase_block(text), GIVEN).value


def read(text: str) -> PhaseBlock:
    return read_phase_block(phase_block(text), [GIVEN], ROWS)


def test_the_aerosol_of_the_reference_has_its_integral() -> None:
    with mpmath.workdps(30):
        g = mpmath.mpf("0.76")
        k = 3 / (8 * mpmath.pi) * (1 - g * g) / (2 + g * g)
        law = lambda c: k * (1 + c * c) / (1 + g * g - 2 * g * c) ** 1.5 + 1 / (600 * (1 - c) + mpmath.mpf("0.05"))  # noqa: E731
        edges = [-1, 0, 0.9, 0.99, 0.999, 0.9999, 0.99999, 1]
        exact = float(2 * mpmath.pi * mpmath.mpf("0.904") * mpmath.quad(law, edges))
    found = norm_of(PEAKED)
    np.testing.assert_allclose(found, exact, rtol=1e-12)
    np.testing.assert_allclose(found, PEAK_NORM, rtol=1e-8)


@pytest.mark.parametrize("text", [RAYLEIGH, CORNETTE, COLOURED])
def test_laws_of_integral_one(text: str) -> None:
    np.testing.assert_allclose(norm_of(text), 1.0, rtol=1e-13)


@pytest.mark.parametrize(
    ("g", "error"), [(0.0, 1e-14), (0.9, 1e-13), (0.99, 1e-12), (0.999, 1e-9), (0.9999, 1e-7), (-0.9, 1e-13)]
)
def test_sharp_peaks_are_resolved(g: float, error: float) -> None:
    # the error is that of mu itself, 1e-16 over the width of the peak
    np.testing.assert_allclose(norm_of(hg(g)), 1.0, rtol=error)


def test_jumps_and_bends_do_not_spoil_the_integral() -> None:
    found = norm_of(
        "return vec4(dotViewSun > 0.3 ? 1. : 0., abs(dotViewSun - 0.1), dotViewSun < -0.999 ? 1. : 0., 1.);"
    )
    wanted = 2 * np.pi * np.array([0.7, (1.1**2 + 0.9**2) / 2, 0.001, 2.0])
    np.testing.assert_allclose(found, wanted, rtol=1e-12)


def test_each_wavelength_has_its_own_norm() -> None:
    phase = read("return wavelengths/700*vec4(1 + dotViewSun)/(4*PI);")
    np.testing.assert_allclose(phase.norm, [4 / 7, 1.0], rtol=1e-13)
    mu = np.linspace(-1, 1, 5)
    np.testing.assert_allclose(phase(mu, 0), (1 + mu) / (4 * np.pi), rtol=1e-13)


def test_values_are_those_of_the_block_over_its_norm() -> None:
    mu = np.cos(np.linspace(0, np.pi, 91))
    np.testing.assert_allclose(read(RAYLEIGH)(mu, 1), rayleigh_phase(mu, 0), rtol=1e-14)
    np.testing.assert_allclose(read(PEAKED)(mu, 1), sample_aerosol_phase(mu, 0) / PEAK_NORM, rtol=1e-8)


def test_rounding_beyond_the_ends_is_taken_for_the_ends() -> None:
    phase = read("return vec4(2 + sqrt(1 - sqr(dotViewSun)));")
    assert phase(np.array([1.0 + 4e-16, -1.0 - 4e-16]), 0).tolist() == phase(np.array([1.0, -1.0]), 0).tolist()
    assert phase(np.zeros((2, 3)), 0).shape == (2, 3)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("return vec4(dotViewSun);", "component 0 is -1, dotViewSun -1"),
        ("return vec4(1, 1, dotViewSun, 1);", "component 2 is -1, dotViewSun -1"),
        ("return vec4(1/(1 - dotViewSun));", "component 0 is inf, dotViewSun 1"),
        ("return vec4(0);", "the phase function is zero everywhere"),
        ("return vec4(floor(dotViewSun*1e6) + 2e6);", "more than 1000 jumps or bends"),
        ("while(true) {} return vec4(1);", "more than 20000 steps"),
        ("return vec4(0.5 - sqr(dotViewSun));", "component 0 is -0.5"),
        ("return vec4(1 + sin(dotViewSun*1e9));", "does not settle"),
    ],
)
def test_a_phase_function_that_is_none_is_refused(text: str, message: str) -> None:
    with pytest.raises(InputFileError) as caught:
        read(text)
    assert message in str(caught.value)


def test_a_fixed_rule_of_few_nodes_would_not_do() -> None:
    # the planted defect: 64 Gauss nodes in mu miss a hundredth of the reference aerosol
    block: Block = phase_block(PEAKED)
    mu, weight = np.polynomial.legendre.leggauss(64)
    assert abs(2 * np.pi * block(mu, GIVEN)[0] @ weight - PEAK_NORM) > 5e-3
