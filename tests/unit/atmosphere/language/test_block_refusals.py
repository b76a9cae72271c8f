"""What is not in the language is refused at its place, with what to write; several problems together."""

from __future__ import annotations

import pytest

from aomc_sky.errors import MAX_PROBLEMS_SHOWN, InputFileError
from tests.support.blocks import density_block, phase_block


def problems_of(text: str) -> tuple[str, ...]:
    with pytest.raises(InputFileError) as caught:
        density_block(text)
    assert all(problem.code == "E403" for problem in caught.value.problems)
    assert all(problem.field == "number density" for problem in caught.value.problems)
    assert caught.value.exit_code == 3
    return tuple(f"{one.line}:{one.column}: {one.message} | {one.advice}" for one in caught.value.problems)


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        # not in the language
        ("#include <x>\nreturn 1.;", "10:1: a code block has no lines for a preprocessor"),
        ('return "a";', '10:8: " has no meaning in a code block'),
        ("return `1`;", "10:8: ` has no meaning in a code block"),
        ("return 1. \\ 2.;", "10:11: \\ has no meaning in a code block"),
        ("return 1 @ 2;", "10:10: the character '@' has no meaning"),
        ("return 2.0 \xd7 altitude;", "10:12: the character '\\xd7' has no meaning"),
        ("/* open", "10:1: this comment has no end | close it with */"),
        ("struct A { float x; }; return 1.;", "10:1: struct is not part of this language"),
        ("float a[3]; return 1.;", "10:7: there are no arrays here"),
        ("float[3] a; return 1.;", "10:6: there are no arrays here"),
        ("float f(float x) { return x; } return 1.;", "10:7: a block has no functions of its own"),
        (
            "return 1.; } float g() { return 2.;",
            "10:12: this } closes nothing that was opened in the block | remove it",
        ),
        ("double a = 1.; return a;", "10:1: double is not part of this language"),
        ("return 1.0lf;", "10:8: 1.0lf has type double"),
        ("do { } while(true); return 1.;", "10:1: do is not part of this language"),
        ("switch(1) { } return 1.;", "10:1: switch is not part of this language"),
        ("precision highp float; return 1.;", "10:1: precision is not part of this language"),
        ("mat3 m; return 1.;", "10:1: mat3 has no meaning here"),
        ("ivec2 v; return 1.;", "10:1: ivec2 has no meaning here"),
        ("return float(1 << 3);", "10:16: the operator << on bits is not known here"),
        ("return float(5 & 3);", "10:16: the operator & on bits is not known here | write && if that is meant"),
        ("int i = 5; i <<= 2; return i;", "10:14: <<= works on bits"),
        ("float a; float b = a = 1.; return b;", "10:22: an assignment is no value here"),
        ("int i = 1; return i++;", "10:20: an assignment is no value here"),
        ("int i = 1; return --i;", "10:19: an assignment is no value here"),
        ("float a = (1., 2.); return a;", "10:14: two values stand between one pair of brackets"),
        ("float __a = 1.; return 1.;", "10:7: the name __a is reserved in GLSL"),
        ("return gl_FragCoord.x;", "10:8: the name gl_FragCoord is reserved in GLSL"),
        # numbers
        ("return 10km;", "10:8: 10km is not a number | write 10*km, if that is meant"),
        ("return 1f;", "10:8: 1f is not a number | write 1.0"),
        ("return 1.2.3;", "10:8: 1.2.3 is not a number"),
        ("return 1e;", "10:8: 1e is not a number"),
        ("return float(0x10);", "10:14: 0x10 is a hexadecimal number"),
        ("return float(010);", "10:14: 010 begins with 0, which GLSL reads as octal"),
        ("return float(5u);", "10:14: 5u is not a number"),
        ("return 3000000000;", "10:8: the whole number 3000000000 is beyond 2147483647"),
        ("return 1e400;", "10:8: 1e400 is too large for a number of double precision"),
        ("return 1e-400;", "10:8: 1e-400 is too small for a number of double precision"),
        # shape of statements
        ("float a = 1.\nreturn a;", "10:13: ; is missing at the end of the statement; found return | write ;"),
        ("return exp(1.;", "10:14: ) is missing behind the arguments of exp"),
        ("return (1.;", "10:11: ) is missing behind the value in brackets"),
        ("return 1. +;", "10:12: a value is missing; found ;"),
        ("return;", "10:7: return has no value"),
        ("return altitude > 1. ? 2.;", "10:26: : is missing between the two values of ?:"),
        ("if altitude > 1. return 2.;", "10:3: ( is missing behind if"),
        ("if(altitude > 1.) { return 2.;", "10:19: this { is not closed in the block"),
        ("else return 1.;", "10:1: else stands behind no if"),
        ("altitude; return 1.;", "10:1: this statement does nothing"),
        ("break; return 1.;", "10:1: break stands in no loop"),
        ("flot x = 1.; return 1.;", "10:1: a type is not known | the types are bool, int, float, vec2, vec3, vec4"),
        ("float; return 1.;", "10:6: a name is missing behind the type"),
        ("const x = 1.; return 1.;", "10:7: a type is missing"),
        ("", "10:1: the block can end without a value; it gives a float | write return and a value at its end"),
        ("if(altitude < 1.) return 1.;", "10:29: the block can end without a value"),
        ("if(altitude < 1.) return 1.; else if(altitude < 2.) return 2.;", "10:63: the block can end without"),
        ("while(true) return 1.;", "10:23: the block can end without a value"),
        # types
        ("return vec4(1);", "10:8: the value that is returned is a vec4, not a float | take a component of it: .x"),
        ("return true;", "10:8: the value that is returned is a bool, not a float | write float(...) around it"),
        ("int i = 1.; return i;", "10:9: the value of i is a float, not an int | write int(...) around it"),
        ("vec2 v = vec3(1); return 1.;", "10:10: the value of v is a vec3, not a vec2 | a vec2 has 2 components"),
        ("vec2 v = 1.; return 1.;", "10:10: the value of v is a float, not a vec2 | write vec2(...) around it"),
        ("if(1) return 1.; return 2.;", "10:4: the condition is an int, not a bool | write a comparison"),
        ("return 1 ? 2. : 3.;", "10:8: the condition is an int, not a bool"),
        ("return true ? 2. : vec2(1).xy;", "10:8: the values of ?: have different types: float, vec2"),
        ("return 1. + (altitude < 5.);", "10:8: + does not join float and bool | write cond ? a : b"),
        ("return (vec2(1) + vec3(1)).x;", "10:9: + does not join vec2 and vec3"),
        ("return 5. % 2.;", "10:8: % takes two ints, not float and float | write mod(x, y)"),
        ("return 1. < altitude < 5. ? 1. : 0.;", "10:8: < compares two numbers, not bool and float | join two"),
        ("return vec2(1) < vec2(2) ? 1. : 0.;", "10:8: < compares two numbers, not vec2 and vec2"),
        ("return true == 1 ? 1. : 0.;", "10:8: == compares two values of one type, not bool and int"),
        ("return 1 && true ? 1. : 0.;", "10:8: && takes bools, not an int"),
        ("return -true ? 1. : 0.;", "10:8: - takes a number, not a bool"),
        ("return !1. ? 1. : 0.;", "10:8: ! takes a bool, not a float"),
        ("int i = 1; i += 0.5; return i;", "10:12: += gives a float, and the variable is an int"),
        ("float x = 1.; x *= vec2(1); return x;", "10:15: *= gives a vec2, and the variable is a float"),
        # functions
        (
            "return pow(wavelengths, 1.5).x;",
            "10:8: pow does not take vec4, float: its values have one type | write vec4",
        ),
        ("return exp(true);", "10:8: exp does not take bool"),
        ("return exp();", "10:8: exp takes 1 argument, not 0"),
        ("return atan(1., 2., 3.);", "10:8: atan takes 1 or 2 arguments, not 3"),
        ("return expp(1.);", "10:8: there is no function expp | is exp meant?"),
        ("return vec2(1, 2, 3).x;", "10:8: the last value has no place among the components of vec2"),
        ("return vec4(1, 2).x;", "10:8: vec4 has 4 components, 2 are given"),
        ("return float(1, 2);", "10:8: float() takes one value, not 2"),
        ("return float();", "10:8: float() has no value between its brackets"),
        # names
        ("return altitud;", "10:8: the name altitud is not known | is altitude meant?"),
        ("return exp;", "10:8: the name exp is not known | exp is a function: write exp(...)"),
        ("float x = x; return x;", "10:11: the name x is not known"),
        ("{ float x = 1.; } return x;", "10:26: the name x is not known"),
        ("for(int i = 0; i < 3; i++) ; return i;", "10:37: the name i is not known"),
        ("float x = 1.; float x = 2.; return x;", "10:21: x is declared twice"),
        ("float altitude = 1.; return altitude;", "10:7: altitude is the block's argument"),
        ("const float a = 1.; a = 2.; return a;", "10:21: a is const and cannot be changed"),
        ("const float a; return 1.;", "10:13: a is const and has no value"),
        ("wavelengths.x = 2.; return 1.;", "10:1: wavelengths is given to the block and cannot be changed"),
        ("PI = 3.; return PI;", "10:1: PI is given to the block and cannot be changed"),
        ("1. = 2.; return 1.;", "10:1: only a variable or its components take a value"),
        # components
        ("return altitude.x;", "10:17: a float has no components"),
        ("return wavelengths.xg;", "10:20: .xg names no components of a vec4"),
        ("return vec2(1).z;", "10:16: .z names no components of a vec2 | one to four letters of xy, rg, st"),
        ("return wavelengths.xyzwx.x;", "10:20: .xyzwx names no components"),
        ("return wavelengths.length();", "10:26: "),
        ("return wavelengths[4];", "10:20: a vec4 has no component 4 | they are counted from 0 to 3"),
        ("return wavelengths[1.];", "10:20: an index is a float, not an int"),
        ("return altitude[0];", "10:8: a float has no components"),
        ("vec2 v = vec2(1); v.xx = vec2(2); return 1.;", "10:19: a component is named twice on the left of ="),
    ],
)
def test_one_problem(text: str, wanted: str) -> None:
    found = problems_of(text)
    assert len(found) == 1, found
    assert found[0].startswith(wanted), found[0]


def test_a_block_tells_all_its_problems_in_their_order() -> None:
    text = """float a = 1. * true;
vec2 b = a;
if(a) b = 2.;
while(a < 3) { a = unknown; break; }
return b + c;"""
    assert [one.split(" ")[0] for one in problems_of(text)] == [
        "10:11:",
        "11:10:",
        "12:4:",
        "12:11:",
        "13:20:",
        "14:12:",
    ]


def test_a_statement_that_cannot_be_read_does_not_hide_the_next() -> None:
    found = problems_of("float f(float x) { return x; }\nfloat a[2];\nstruct B { int i; };\ndouble c = 1.;\nreturn 1.;")
    assert [one.split(" ")[0] for one in found] == ["10:7:", "11:7:", "12:1:", "13:1:"]


def test_characters_are_told_before_statements() -> None:
    assert [one.split(" ")[0] for one in problems_of("flot @ = 1.;\n#define x\nreturn 010;")] == [
        "10:6:",
        "11:1:",
        "12:8:",
    ]


def test_a_thousand_problems_end_at_once() -> None:
    assert len(problems_of("x = 1;" * 1000)) == MAX_PROBLEMS_SHOWN + 1


def test_the_caret_stands_below_the_name() -> None:
    with pytest.raises(InputFileError) as caught:
        density_block("float h = altitude/km;\n  return exp(-hh);")
    assert str(caught.value) == (
        "a.atmo:11:15: error[E403]: number density: the name hh is not known\n"
        "   11 |   return exp(-hh);\n"
        "      |               ^^ is h meant?"
    )


def test_a_phase_function_gives_four_values() -> None:
    with pytest.raises(InputFileError, match=r"is a float, not a vec4\n.*\n.*write vec4\(\.\.\.\) around it"):
        phase_block("return 1.;")
    with pytest.raises(InputFileError, match="the name altitude is not known"):
        phase_block("return vec4(altitude);")


def test_nothing_of_a_block_reaches_python() -> None:
    for text in (
        "__import__('os').system('true')",
        "().__class__",
        "open('x')",
        "exec(1)",
        "lambda: 1",
        "[0 for x in y]",
    ):
        assert problems_of(f"return {text};")
