"""The only decorators of the package's kernels: strict IEEE, no GIL, arrays that do not overlap, and a sound cache.

All work with numba's public names alone. If numba also has the private names of `numba_private`, kernels are faster and
are cached on the disk. Otherwise each process compiles them anew, and the photons are the same.
"""

from __future__ import annotations

import logging
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

from aomc_sky.kernels import formula
from aomc_sky.system import interrupts_held

with interrupts_held():  # a first import that Ctrl-C cuts short would ruin numba for the life of the process
    import numba
    from numba import config, types
    from numba.core import cgutils
    from numba.extending import lower_builtin, overload, type_callable

if config.DISABLE_JIT and np.lib.NumpyVersion(np.__version__) < "2.0.0":
    # numpy 1 makes a float of an int and a uint64; compiled kernels, and numpy 2, do not. This changes the whole
    # process, in which somebody switched off the JIT to look for a fault.
    np._set_promotion_state("weak")  # type: ignore[attr-defined]

if logging.getLogger("numba").level == logging.NOTSET:
    logging.getLogger("numba").setLevel(logging.WARNING)  # else a host whose root logs DEBUG gets the bytecode of all

_PUBLIC = {"nogil": True, "error_model": "numpy"}


def _private_layer() -> Any:
    """The module of numba's private names, None without the JIT or where a trial of them fails."""
    if config.DISABLE_JIT:
        return None
    try:
        from aomc_sky.kernels import numba_private as layer

        options = {"pipeline_class": layer.KernelCompiler, **_PUBLIC, **layer.NO_WRAPPERS, **layer.NO_REFCOUNT}
        trial = numba.njit(forceinline=True, **options)(lambda x: x)
        trial.compile((types.int64,))
        layer.keep_code(trial, formula.select)
    except Exception as error:  # whatever another numba raises
        warnings.warn(
            f"numba {numba.__version__} differs from those that aomc-sky knows ({type(error).__name__}: {error}): the "
            "photons are the same, but each process compiles its kernels anew; numba 0.68 keeps them on the disk",
            RuntimeWarning,
            stacklevel=2,
        )
        return None
    return layer


with interrupts_held():  # numba takes up its rules of types when it compiles for the first time
    _private = _private_layer()
    if _private is None and not config.DISABLE_JIT:
        numba.njit((types.int64,))(lambda x: x)


def _options(*, is_inner: bool = False, is_no_refcount: bool = False, is_inlined: bool = False) -> dict[str, Any]:
    """Numba's options for a function."""
    if _private is None:
        return _PUBLIC
    own = {**(_private.NO_WRAPPERS if is_inner else {}), **(_private.NO_REFCOUNT if is_no_refcount else {})}
    return {"pipeline_class": _private.KernelCompiler, "forceinline": is_inlined, **_PUBLIC, **own}


#: For Python and for the jitted code of a user; cached with its caller.
shared = numba.njit(**_options())
#: `shared` for the loop of a user, which vectorises only if the function is inlined.
shared_inlined = numba.njit(**_options(is_inlined=True))
#: For kernels alone, and cached with them; a call from Python crashes. It promises that arrays do not overlap, and LLVM
#: keeps the promise when it inlines.
inner = numba.njit(**_options(is_inner=True))
#: `inner` for a long straight function in a loop, which vectorises only if the function is inlined.
inlined = numba.njit(**_options(is_inner=True, is_inlined=True))
#: `inner` that makes no array, so numba counts no references. In small functions of a loop that counting costs more
#: than the work, and it takes time to compile.
inner_no_refcount = numba.njit(**_options(is_inner=True, is_no_refcount=True))
#: `inlined` for such a function.
inlined_no_refcount = numba.njit(**_options(is_inner=True, is_no_refcount=True, is_inlined=True))
#: `inner_no_refcount` that numba inlines itself: only so can it return an array to a function without counting.
inline_always = numba.njit(inline="always", **_options(is_inner=True, is_no_refcount=True))


def _kept(compiled: Any, function: Callable[..., Any]) -> Any:
    if _private is not None:
        _private.keep_code(compiled, function)
    return compiled


def kernel(function: Callable[..., Any]) -> Any:
    """Compile a kernel that Python calls; it is kept on the disk."""
    return _kept(shared(function), function)


def no_refcount(function: Callable[..., Any]) -> Any:
    """`kernel` that makes no array; see `inner_no_refcount`."""
    return _kept(numba.njit(**_options(is_no_refcount=True))(function), function)


def is_off() -> bool:
    """Whether somebody has switched numba's compiler off: kernels are Python then."""
    return bool(config.DISABLE_JIT)


def overloads(function: Callable[..., Any], *, is_inlined: bool = False) -> Any:
    """Numba's `overload` for forms that only kernels use."""
    options = _options(is_inner=True, is_no_refcount=True, is_inlined=is_inlined)
    return overload(function, jit_options=options, strict=False)


def c_function(function: Callable[..., Any], signature: Any) -> Any:
    """Compile a function that C calls by its address; it needs no GIL, and is kept on the disk like a kernel."""
    if _private is None:
        return numba.cfunc(signature, error_model="numpy")(function)
    layer, both = _private, (signature.args, signature.return_type)
    compiled = layer.CFunc(function, both, {}, {"error_model": "numpy"}, pipeline_class=layer.KernelCompiler)
    _kept(compiled, function).compile()
    return compiled


def _compile_formula(text: Callable[..., Any], is_inlined: bool) -> None:
    """Let kernels call a formula: its text, or that of two texts which has the width of an argument."""

    def chosen(*arguments: Any) -> Any:
        if not hasattr(text, "texts"):
            return text
        short, long, of = text.texts
        return short if getattr(arguments[of], "dtype", arguments[of]).bitwidth == 32 else long

    overloads(text, is_inlined=is_inlined)(chosen)


def lowered(function: Callable[..., Any], result: Callable[..., Any], *kinds: Any) -> Callable[..., Any]:
    """Decorate the LLVM code of a function of arrays for kernels; `result` gives the type that it returns."""
    type_callable(function)(lambda context: result)
    return lower_builtin(function, *kinds)  # type: ignore[no-any-return]


@lowered(formula.word_of, lambda x: types.int64, types.float64)
@lowered(formula.float_of, lambda word: types.float64, types.int64)
def _same_bits(context: Any, builder: Any, signature: Any, values: Any) -> Any:
    return builder.bitcast(values[0], context.get_value_type(signature.return_type))


@lowered(formula.nested, lambda coefficients, t: t, types.BaseTuple, types.Float)
def _nested(context: Any, builder: Any, signature: Any, values: Any) -> Any:
    value = builder.extract_value(values[0], 0)
    for k in range(1, len(signature.args[0])):
        value = builder.fadd(builder.fmul(value, values[1]), builder.extract_value(values[0], k))
    return value


def array_at(context: Any, builder: Any, kind: Any, address: Any, size: Any) -> Any:
    """LLVM code for an array of one dimension without counted references."""
    array = context.make_array(kind)(context, builder)
    width = context.get_constant(types.intp, kind.dtype.bitwidth // 8)
    array.data = builder.bitcast(address, array.data.type)
    array.nitems, array.itemsize = size, width
    array.shape, array.strides = cgutils.pack_array(builder, [size]), cgutils.pack_array(builder, [width])
    array.meminfo, array.parent = (cgutils.get_null_value(x.type) for x in (array.meminfo, array.parent))
    return array._getvalue()


def view_as(words: Any, like: Any) -> Any:
    """The memory of a contiguous array as numbers of the type of `like`, in which the array has a whole number."""
    return words.view(like.dtype)


@lowered(view_as, lambda words, like: types.Array(like, 1, "C"), types.Array, types.Number)
def _view_as(context: Any, builder: Any, signature: Any, values: Any) -> Any:
    array = context.make_array(signature.args[0])(context, builder, values[0])
    old, new = (array.nitems.type(kind.dtype.bitwidth) for kind in (signature.args[0], signature.return_type))
    size = builder.udiv(builder.mul(array.nitems, old), new)
    return array_at(context, builder, signature.return_type, array.data, size)


formula.compile_formulas(_compile_formula)
overloads(formula.kind_of)(lambda x: lambda x: type(x))  # noqa: PLW0108
overloads(formula.select)(lambda condition, a, b: lambda condition, a, b: a if condition else b)
overloads(formula.smaller)(lambda a, b: lambda a, b: a if a < b else b)
overloads(formula.larger)(lambda a, b: lambda a, b: a if a > b else b)
