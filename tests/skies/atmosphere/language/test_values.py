"""What GLSL means by a block; and blocks of published shapes against plain Python, altitude by altitude."""

import math

import numpy as np
import pytest

from aomc_sky.errors import InputFileError
from tests.support.blocks import GIVEN, WAVELENGTHS, at, density_block, phase_block, value_of


@pytest.mark.parametrize(
    ("expression", "wanted"),
    [
        ("-7/2", -3.0), ("1/2.", 0.5), ("-1/8.*altitude", -125.0), (".5 + 1.", 1.5), ("1.5e3f", 1500.0),
        ("2 + 3 * 4 - 5", 9.0), ("8./4./2.", 1.0), ("2 < 3 == true", 1.0), ("true || false && false", 1.0),
        ("1 == 1.0", 1.0), ("altitude < 5. ? 1 : altitude < 2000. ? 2 : 3", 2.0), ("int(-2.9)", -2.0),
        ("int(2.9) / 2", 1.0), ("bool(0.25)", 1.0), ("vec3(1, 2, 3).z", 3.0), ("vec4(vec2(1, 2), 3, 4).zyx.x", 3.0),
        ("vec2(vec4(1, 2, 3, 4)).y", 2.0), ("vec3(1, 2, 3)[1]", 2.0), ("vec4(1, 2, 3, 4).bgr.r", 3.0),
        ("vec4(1, 2, 3, 4).q", 4.0), ("vec2(1, 2) == vec2(1, 2)", 1.0), ("(vec2(1, 2) * 3 - vec2(1)).y", 5.0),
        ("(2 * vec2(1, 2) / vec2(4, 8)).y", 0.5), ("wlSetIndex*2/3", 0.0), ("-earthCenter.z", 6.371e6),
        ("float(vec2(4, 5))", 4.0),
    ],
)  # fmt: skip
def test_expressions(expression, wanted):
    assert value_of(expression) == wanted


PLAIN_LAWS = (math.sin, math.cos, math.tan, math.asin, math.acos, math.atan, math.sinh, math.cosh, math.tanh)


@pytest.mark.parametrize(
    ("expression", "wanted"),
    [
        *((f"{law.__name__}(0.3)", law(0.3)) for law in PLAIN_LAWS), ("atan(-1, -2)", math.atan2(-1, -2)),
        ("radians(90)", math.pi / 2), ("degrees(PI)", 180.0), ("exp(1)", math.e), ("exp2(0.5)", math.sqrt(2)),
        ("log(2)", math.log(2)), ("log2(8)", 3.0), ("inversesqrt(4)", 0.5), ("pow(7.3, -99.5)", math.pow(7.3, -99.5)),
        ("pow(vec2(2, 3), vec2(3)).y", 27.0), ("ceil(-1.5)", -1.0), ("trunc(-1.5)", -1.0), ("fract(-1.25)", 0.75),
        ("mod(-1.25, 1)", 0.75), ("abs(-3)/2", 1.0), ("sign(-3.5)", -1.0), ("sqr(3)/2", 4.0),
        ("max(vec2(1, 5), 3.).x", 3.0), ("1. / min(0., -0.)", np.inf),
        ("1. / max(-0., 0.)", -np.inf),  # GLSL takes the first of two equal numbers
        ("clamp(5., 0., 1.)", 1.0), ("mix(1., 3., 0.25)", 1.5), ("step(2., 2.)", 1.0), ("step(2., vec2(1, 3)).x", 0.0),
        ("smoothstep(0., 2., 0.5)", 0.15625), ("dot(vec3(1, 2, 3), vec3(4, 5, 6))", 32.0), ("length(vec2(3, 4))", 5.0),
        ("distance(vec2(1, 1), vec2(4, 5))", 5.0), ("normalize(vec2(3, 4)).x", 0.6),
    ],
)  # fmt: skip
def test_functions(expression, wanted):
    assert value_of(expression) == pytest.approx(wanted, rel=1e-15, abs=0)


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("float a = 1, b, c = 3; b = a + c; return b;", 4.0),
        ("const float a = 2; CONST int b = 3; return a * b;", 6.0),
        ("float a; a = 1; a += 2; a *= 3; a -= 1; a /= 2; return a;", 4.0),
        ("float a = 1.; { float b = a; float a = 7.; a += b; return a; }", 8.0),
        ("float km = 2.; return km;", 2.0),
        ("altitude *= 2.; return altitude;", 2000.0),
        ("vec4 v = vec4(0); v.x = 1.; v.zw = vec2(3, 4); v[1] = 2.; return v.x + 10*v.y + 100*v.z + 1000*v.w;", 4321.0),
        ("vec3 v; v.x = 1.; v.y = 2.; v.z = 3.; v.xy = v.yx; return v.x*v.z;", 6.0),
        ("vec2 v = vec2(1, 2); v *= 3; v.y -= 1; return v.y;", 5.0),
        ("/* a */ return 1. /* b \n */ + 2.; // c", 3.0),
        ("if(altitude > 5e3) ; else return 2.; return 3.;", 2.0),
        ("return 1.;\r\n", 1.0),
    ],
)
def test_statements(text, wanted):
    assert at(text, 1000.0) == [wanted]


def test_each_altitude_follows_its_own_branch():
    text = """
        float d = 0.;
        if(altitude < 10.) d = log(10. - altitude);          // no value from 10 m on
        else if(altitude < 20.) { int n = int(altitude); d = 100/(n - 9); }   // division by 0 at 9 m
        else { d = 3.*altitude; if(altitude >= 50.) d = 60.; }
        return d;"""
    wanted = [math.log(10), 0.0, 100.0, 11.0, 60.0, 105.0, 60.0]
    assert at(text, 0.0, 9.0, 10.0, 18.0, 20.0, 35.0, 90.0)[:4] == pytest.approx(wanted[:4], rel=1e-15)
    assert at(text, 20.0, 35.0, 90.0) == wanted[4:]
    assert at("return altitude > 0. ? 1/int(altitude) : 5;", 0.0, 2.0) == [5.0, 0.0]
    assert at("return altitude > 0. && log(altitude) > 0. ? 1. : 0.;", 0.0, 9.0) == [0.0, 1.0]
    assert at("return altitude <= 0. || log(altitude) > 0. ? 1. : 0.;", 0.0, 9.0) == [1.0, 1.0]
    assert at("if(altitude == 0.) return 7.; return sqrt(altitude - 1.);", 0.0, 5.0) == [7.0, 2.0]
    block = density_block("float x;\nif(altitude != 50.) x = 1.;\nreturn x;")
    assert block(np.array([0.0, 49.0, 51.0]), GIVEN).tolist() == [1.0, 1.0, 1.0]
    with pytest.raises(InputFileError, match=r"a\.atmo:12:8: error\[E403\]: number density: .*altitude 50 m"):
        block(np.array([0.0, 49.0, 50.0, 51.0]), GIVEN)


def test_lanes_join_and_a_second_run_gives_the_same_bits():
    text = "vec4 v = vec4(1); v.y = dotViewSun; if(dotViewSun > 0.) v.zw = vec2(dotViewSun, 9); return v;"
    assert phase_block(text)(np.array([-1.0, 0.5]), GIVEN).tolist() == [[1.0, 1.0], [-1.0, 0.5], [1.0, 0.5], [1.0, 9.0]]
    block = phase_block("vec4 w = wavelengths; w *= dotViewSun; w.x = 0.; return exp(w/700);")
    mu = np.linspace(-1.0, 1.0, 7)
    assert np.array_equal(block(mu, GIVEN), block(mu, GIVEN))
    assert np.array_equal(mu, np.linspace(-1.0, 1.0, 7))
    assert GIVEN["wavelengths"].tolist() == [400.0, 500.0, 600.0, 700.0]


MOLECULES = """
    CONST float rayleighScaleHeight=8*km;
    return 3.08458e25*exp(-1/rayleighScaleHeight * altitude);
"""
AEROSOL = """
    const float scaleHeight = 1.2*km; // mixed layer and above
    if(altitude < 2.*km)
        return 1.03333e8*exp(-altitude/scaleHeight);
    return 1.03333e8*exp(-2.*km/scaleHeight)*exp(-(altitude-2*km)/(2.4*km));
"""
OZONE = """
    CONST float totalColumn=370*dobsonUnit;
    CONST float altInKm=altitude/km;
    float density;
    if(altitude<8*km)
        density=7.2402403521159135e-6 - 1.206527437798165e-7*altInKm;
    else if(altitude<21.5*km)
        density=-2.0590185333577628e-5 + 3.3581504669318765e-6*altInKm;
    else if(altitude<39*km)
        density=1.0542813563268143e-4 - 2.50316678731273e-6*altInKm;
    else
        density=0.04298160111157969*exp(-0.2208669270720561*altInKm);
    density*=totalColumn;
    return density;
"""
RAYLEIGH = "return vec4(3./(16*PI)*(1+sqr(dotViewSun)));"
CORNETTE = """
    CONST float g=0.76;
    CONST float g2=g*g;
    CONST float k=3/(8*PI)*(1-g2)/(2+g2);
    return vec4(k*(1+sqr(dotViewSun))/pow(1+g2-2*g*dotViewSun, 1.5));
"""
PEAKED = """
    CONST float g=0.76;
    CONST float k=3/(8*PI)*(1-g*g)/(2+g*g);
    float value = k*(1+dotViewSun*dotViewSun)/pow(1+g*g-2*g*dotViewSun,1.5);
    value += 1/(600*(1-dotViewSun)+0.05);
    value *= 0.904;
    return vec4(value);
"""
COLOURED = """
    CONST vec4 g = 0.6 + 0.2*exp(-0.00002*sqr(wavelengths-300)); // à la carte
    CONST vec4 g2 = g*g;
    return vec4((1-g2)/(4*PI*pow(vec4(1+g2-2*g*dotViewSun), vec4(1.5))));
"""


@pytest.mark.parametrize("text", [OZONE, AEROSOL])
def test_values_do_not_depend_on_their_neighbours(text):
    block = density_block(text)
    long = np.linspace(0.0, 120e3, 9001)
    assert block(long, GIVEN)[::50].tolist() == [block(one, GIVEN).item() for one in long[::50, None]]


def test_a_phase_function_with_colours_is_that_of_plain_python():
    cosines = np.cos(np.linspace(0.0, np.pi, 181))
    found = phase_block(COLOURED)(cosines, GIVEN)
    for row, wavelength in enumerate(WAVELENGTHS):
        g = 0.6 + 0.2 * math.exp(-0.00002 * ((wavelength - 300) * (wavelength - 300)))
        wanted = [(1 - g * g) / (4 * math.pi * math.pow(1 + g * g - 2 * g * c, 1.5)) for c in cosines]
        np.testing.assert_allclose(found[row], wanted, rtol=1e-15, atol=0)
