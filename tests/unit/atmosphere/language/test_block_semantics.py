"""What GLSL means by a block: whole numbers, conversions, scopes, branches, loops, components, functions."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aomc_sky.atmosphere.language.block import MAX_STEPS
from aomc_sky.errors import InputFileError
from tests.support.blocks import GIVEN, at, density_block, phase_block, value_of


@pytest.mark.parametrize(
    ("expression", "wanted"),
    [
        ("1/2", 0.0),
        ("-7/2", -3.0),
        ("7/-2", -3.0),
        ("7%3", 1.0),
        ("1/2.", 0.5),
        ("1/2*4.", 0.0),
        ("4.*1/2", 2.0),
        ("-1/8*altitude", 0.0),
        ("-1/8.*altitude", -125.0),
        ("2147483647", 2147483647.0),
        (".5 + 1.", 1.5),
        ("1.5e3f", 1500.0),
        ("2 + 3 * 4 - 5", 9.0),
        ("(2 + 3) * -4", -20.0),
        ("- - 3", 3.0),
        ("8./4./2.", 1.0),
        ("2 < 3", 1.0),
        ("2 < 3 == true", 1.0),
        ("!(2 >= 3) && 1 != 2", 1.0),
        ("true || false && false", 1.0),
        ("true ^^ true", 0.0),
        ("1 == 1.0", 1.0),
        ("altitude > 5. ? 1 : 2.5", 1.0),
        ("altitude < 5. ? 1 : altitude < 2000. ? 2 : 3", 2.0),
        ("int(-2.9)", -2.0),
        ("int(2.9) / 2", 1.0),
        ("bool(0.25)", 1.0),
        ("vec3(1, 2, 3).z", 3.0),
        ("vec4(7).w", 7.0),
        ("vec4(vec2(1, 2), 3, 4).zyx.x", 3.0),
        ("vec2(vec4(1, 2, 3, 4)).y", 2.0),
        ("vec3(1, 2, 3)[1]", 2.0),
        ("vec3(1, 2, 3)[int(altitude) - 998]", 3.0),
        ("vec4(1, 2, 3, 4).bgr.r", 3.0),
        ("vec4(1, 2, 3, 4).q", 4.0),
        ("vec2(1, 2) == vec2(1, 2)", 1.0),
        ("vec2(1, 2) != vec2(1, 3)", 1.0),
        ("(vec2(1, 2) * 3 - vec2(1)).y", 5.0),
        ("(2 * vec2(1, 2) / vec2(4, 8)).y", 0.5),
        ("wavelengths[wlSetIndex]", 500.0),
        ("-earthCenter.z", 6.371e6),
        ("float(vec2(4, 5))", 4.0),
    ],
)
def test_expressions(expression: str, wanted: float) -> None:
    assert value_of(expression) == wanted


@pytest.mark.parametrize(
    ("expression", "wanted"),
    [
        ("sin(0.3)", math.sin(0.3)),
        ("cos(0.3)", math.cos(0.3)),
        ("tan(0.3)", math.tan(0.3)),
        ("asin(0.3)", math.asin(0.3)),
        ("acos(0.3)", math.acos(0.3)),
        ("atan(0.3)", math.atan(0.3)),
        ("atan(-1, -2)", math.atan2(-1, -2)),
        ("sinh(0.3)", math.sinh(0.3)),
        ("cosh(0.3)", math.cosh(0.3)),
        ("tanh(0.3)", math.tanh(0.3)),
        ("radians(90)", math.pi / 2),
        ("degrees(PI)", 180.0),
        ("exp(1)", math.e),
        ("exp2(0.5)", math.sqrt(2)),
        ("log(2)", math.log(2)),
        ("log2(8)", 3.0),
        ("sqrt(2)", math.sqrt(2)),
        ("inversesqrt(4)", 0.5),
        ("pow(2, 10)", 1024.0),
        ("pow(vec2(2, 3), vec2(3)).y", 27.0),
        ("floor(-1.5)", -2.0),
        ("ceil(-1.5)", -1.0),
        ("trunc(-1.5)", -1.0),
        ("fract(-1.25)", 0.75),
        ("mod(-1.25, 1)", 0.75),
        ("mod(vec2(5, 7), 4).y", 3.0),
        ("abs(-3)/2", 1.0),
        ("abs(-3.)/2", 1.5),
        ("sign(-3.5)", -1.0),
        ("sqr(3)/2", 4.0),
        ("sqr(1.5)", 2.25),
        ("min(1, 2)/2", 0.0),
        ("max(1, 2.5)", 2.5),
        ("max(vec2(1, 5), 3.).x", 3.0),
        ("clamp(5., 0., 1.)", 1.0),
        ("clamp(vec2(-1, 5), 0., 1.).x", 0.0),
        ("mix(1., 3., 0.25)", 1.5),
        ("mix(vec2(1), vec2(3), 0.25).x", 1.5),
        ("step(2., 2.)", 1.0),
        ("step(2., vec2(1, 3)).x", 0.0),
        ("smoothstep(0., 2., 0.5)", 0.15625),
        ("dot(vec3(1, 2, 3), vec3(4, 5, 6))", 32.0),
        ("length(vec2(3, 4))", 5.0),
        ("distance(vec2(1, 1), vec2(4, 5))", 5.0),
        ("normalize(vec2(3, 4)).x", 0.6),
    ],
)
def test_functions(expression: str, wanted: float) -> None:
    assert value_of(expression) == pytest.approx(wanted, rel=1e-15, abs=0)


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("float a = 1, b, c = 3; b = a + c; return b;", 4.0),
        ("const float a = 2; CONST int b = 3; return a * b;", 6.0),
        ("float a; a = 1; a += 2; a *= 3; a -= 1; a /= 2; return a;", 4.0),
        ("int i = 3; i++; ++i; i--; i %= 3; return i;", 1.0),
        ("float a = 1.; { float a = 2.; a = 5.; } return a;", 1.0),
        ("float a = 1.; { float b = a; float a = 7.; a += b; return a; }", 8.0),
        ("float km = 2.; return km;", 2.0),
        ("altitude *= 2.; return altitude;", 2000.0),
        ("vec4 v = vec4(0); v.x = 1.; v.zw = vec2(3, 4); v[1] = 2.; return v.x + 10*v.y + 100*v.z + 1000*v.w;", 4321.0),
        ("vec3 v; v.x = 1.; v.y = 2.; v.z = 3.; v.xy = v.yx; return v.x*v.z;", 6.0),
        ("vec3 v; v.yx = vec2(5, 6); return v.x;", 6.0),
        ("vec2 v = vec2(1); v[int(altitude)/1000] += 4; return v.y;", 5.0),
        ("vec2 v = vec2(1, 2); v *= 3; v.y -= 1; return v.y;", 5.0),
        ("float s = 0.; for(int i = 0; i < 10; i++) s += float(i); return s;", 45.0),
        ("float s = 0.; for(int i = 0; i < 10; i++) { if(i == 3) continue; if(i > 5) break; s += i; } return s;", 12.0),
        ("float s = 0.; while(s < 7.5) s += 1.; return s;", 8.0),
        ("int n = 0; for(;;) { n += 1; if(n == 20) break; } return n;", 20.0),
        ("for(int i = 0; i < 10; ++i) if(i * i > 30) return i; return -1;", 6.0),
        ("float s=0.; for(int i=0;i<3;i++) for(int j=0;j<=i;j++) { if(j==1) break; s += 1.; } return s;", 3.0),
        ("/* a */ return 1. /* b \n */ + 2.; // c", 3.0),
        (";;; return 1.;;", 1.0),
        ("if(altitude > 5e3) ; else return 2.; return 3.;", 2.0),
        ("return 1.;\r\n", 1.0),
    ],
)
def test_statements(text: str, wanted: float) -> None:
    assert at(text, 1000.0) == [wanted]


def test_each_altitude_follows_its_own_branch() -> None:
    text = """
        float d = 0.;
        if(altitude < 10.) d = log(10. - altitude);          // no value from 10 m on
        else if(altitude < 20.) { int n = int(altitude); d = 100/(n - 9); }   // division by 0 at 9 m
        else for(int i = 0; float(i) < altitude; i += 10) { if(i > 30) break; d += float(i); }
        return d;"""
    wanted = [math.log(10), 0.0, 100.0, 11.0, 10.0, 60.0, 60.0]
    assert at(text, 0.0, 9.0, 10.0, 18.0, 20.0, 35.0, 90.0)[:4] == pytest.approx(wanted[:4], rel=1e-15)
    assert at(text, 20.0, 35.0, 90.0) == wanted[4:]


def test_lanes_that_are_not_taken_make_no_error() -> None:
    assert at("return altitude > 0. ? 1/int(altitude) : 5;", 0.0, 2.0) == [5.0, 0.0]
    assert at("return altitude > 0. && log(altitude) > 0. ? 1. : 0.;", 0.0, 9.0) == [0.0, 1.0]
    assert at("return altitude <= 0. || log(altitude) > 0. ? 1. : 0.;", 0.0, 9.0) == [1.0, 1.0]
    assert at("if(altitude == 0.) return 7.; return sqrt(altitude - 1.);", 0.0, 5.0) == [7.0, 2.0]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("return 5/int(altitude);", "a whole number is divided by 0, altitude 0 m"),
        ("return 5%int(altitude);", "a whole number is divided by 0"),
        ("return (-5)%3;", "% has no defined result for a negative number"),
        ("float x; return x;", "x has no value yet"),
        ("float x; if(altitude > 5.) x = 1.; return x;", "x has no value yet, altitude 0 m"),
        ("vec2 v; v.x = 1.; return v.y;", "v has no value yet"),
        ("vec2 v; v.x += 1.; return v.x;", "v has no value yet"),
        ("vec2 v; v.x = 1.; return length(v);", "v has no value yet"),
        ("int i = 2147483647; i += 1; return i;", "beyond 2147483647"),
        ("return 65536*65536;", "beyond 2147483647"),
        ("return int(3e9);", "does not fit into a whole number"),
        ("return int(0./altitude);", "does not fit into a whole number"),
        ("return pow(-1., 2.);", "pow of a negative number"),
        ("return pow(altitude, 0.);", "pow of 0 needs a positive exponent"),
        ("return sqrt(-1.);", "sqrt has no value for a negative number"),
        ("return log(altitude);", "log has no value for 0 and below"),
        ("return log2(-1.);", "log2 has no value"),
        ("return inversesqrt(altitude);", "inversesqrt has no value"),
        ("return asin(1.5);", "asin has no value beyond -1 and 1"),
        ("return atan(0., altitude);", "atan of 0 and 0"),
        ("return mod(1., altitude);", "mod by 0"),
        ("return clamp(1., 3., 2.);", "the lower limit of clamp is above the upper one"),
        ("return smoothstep(1., 1., 2.);", "the first edge of smoothstep is not below the second"),
        ("return normalize(vec2(altitude)).x;", "normalize has no value for length 0"),
        ("return wavelengths[int(altitude) - 1];", "the index is not between 0 and 3"),
        ("vec4 v = wavelengths; v[int(altitude) + 4] = 1.; return v.x;", "the index is not between 0 and 3"),
    ],
)
def test_what_glsl_leaves_open_is_refused_with_its_altitude(text: str, message: str) -> None:
    block = density_block(text)
    with pytest.raises(InputFileError) as caught:
        block(np.array([0.0, 10.0]), GIVEN)
    assert message in str(caught.value)
    assert caught.value.problems[0].code == "E403"


def test_only_the_altitude_at_fault_is_named() -> None:
    block = density_block("float x;\nif(altitude != 50.) x = 1.;\nreturn x;")
    assert block(np.array([0.0, 49.0, 51.0]), GIVEN).tolist() == [1.0, 1.0, 1.0]
    with pytest.raises(InputFileError, match=r"a\.atmo:12:8: error\[E403\]: number density: .*altitude 50 m"):
        block(np.array([0.0, 49.0, 50.0, 51.0]), GIVEN)


@pytest.mark.parametrize("text", ["while(true) {} return 1.;", "for(;;) altitude += 1.; return 1.;"])
def test_a_loop_without_end_meets_the_limit_of_steps(text: str) -> None:
    with pytest.raises(InputFileError, match=f"more than {MAX_STEPS} steps"):
        at(text, 0.0)


def test_a_vector_of_one_lane_and_one_of_many_join() -> None:
    text = "vec4 v = vec4(1); v.y = dotViewSun; if(dotViewSun > 0.) v.zw = vec2(dotViewSun, 9); return v;"
    found = phase_block(text)(np.array([-1.0, 0.5]), GIVEN)
    assert found.tolist() == [[1.0, 1.0], [-1.0, 0.5], [1.0, 0.5], [1.0, 9.0]]


def test_a_second_run_gives_the_same_bits_and_leaves_what_was_given() -> None:
    block = phase_block("vec4 w = wavelengths; w *= dotViewSun; w.x = 0.; return exp(w/700);")
    mu = np.linspace(-1.0, 1.0, 7)
    before = mu.copy(), GIVEN["wavelengths"].copy()
    assert np.array_equal(block(mu, GIVEN), block(mu, GIVEN))
    assert np.array_equal(mu, before[0])
    assert np.array_equal(GIVEN["wavelengths"], before[1])
