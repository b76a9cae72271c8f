"""Kernels call formulas that the tables of the files list: a walk over all of them finds one that was forgotten."""

import importlib
import types

import numba
import pytest

from aomc_sky.kernels import formula
from tests.support.shared import REPOSITORY

pytestmark = pytest.mark.skipif(numba.config.DISABLE_JIT, reason="about the JIT")

SOURCES = REPOSITORY / "src"
#: With forms for the compiler of their own, by `overloads` and `lowered` of `jit`.
WITH_FORMS = (
    *("word_of", "float_of", "nested", "kind_of", "select", "smaller", "larger", "view_as"),
    *("prefetch_to_read", "prefetch_to_write", "copy_group"),
)


def modules():
    for path in sorted(SOURCES.rglob("kernels/**/*.py")):
        name = ".".join(path.relative_to(SOURCES).with_suffix("").parts).removesuffix(".__init__")
        yield importlib.import_module(name)


def texts_of(text):
    """A formula, or the two of which a width decides."""
    return text.texts[:2] if hasattr(text, "texts") else (text,)


def called(text):
    """The plain functions of the package that a text names."""
    code = [text.__code__]
    for one in code:
        code += [constant for constant in one.co_consts if isinstance(constant, types.CodeType)]
    names = {name for one in code for name in one.co_names}
    named = {name: text.__globals__[name] for name in names & text.__globals__.keys()}
    cells = text.__closure__ or ()
    named |= dict(zip(text.__code__.co_freevars, (cell.cell_contents for cell in cells), strict=True))
    return {
        name: value
        for name, value in named.items()
        if isinstance(value, types.FunctionType) and value.__module__.startswith("aomc_sky.")
    }


def forgotten(listed):
    """What kernels and formulas call and no table lists, by the module and the name of the caller."""
    kernels = {value.py_func for module in modules() for value in vars(module).values() if hasattr(value, "py_func")}
    texts = {text for one in listed for text in texts_of(one)}
    return {
        (caller.__module__, caller.__name__, name)
        for caller in kernels | texts
        for name, value in called(caller).items()
        if value not in listed and name not in WITH_FORMS
    }


def test_what_kernels_call_is_listed():
    assert len([*modules()]) > 40
    assert forgotten(formula.listed()) == set()


def test_a_formula_that_its_table_leaves_out_is_found():
    from aomc_sky.kernels.arithmetic import elementary

    for name in ("arc", "sincos_narrow"):
        lost = getattr(elementary, name)
        assert {left for _, _, left in forgotten([one for one in formula.listed() if one is not lost])} == {name}
