"""The only decorators of the package's kernels: strict IEEE, no GIL, noalias, widest vectors, and a sound cache.

The cache is never stale nor damaged. numba's own looks only at the file of the cached function: edit a jitted helper in
another file and the cached caller keeps the old machine code. The stamp below is the text of all kernel files, so any
edit of any kernel recompiles all of them. Where no cache folder is writable the kernels compile anew in every process.
"""

from __future__ import annotations

import contextlib
import gc
import hashlib
import itertools
import operator
import pickle
import secrets
import sys
from collections.abc import Callable
from typing import Any, ClassVar

import llvmlite.binding as llvm
import numba
import numpy as np
from numba.core import compiler, config, ir, lowering, types
from numba.core.analysis import compute_cfg_from_blocks
from numba.core.bytecode import FunctionIdentity
from numba.core.caching import FunctionCache, IndexDataCacheFile
from numba.core.ccallback import CFunc
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler_lock import global_compiler_lock
from numba.core.compiler_machinery import FunctionPass, register_pass
from numba.core.dispatcher import _FunctionCompiler
from numba.core.imputils import impl_ret_borrowed
from numba.core.ir_utils import get_definition, guard
from numba.core.registry import CPUDispatcher, cpu_target
from numba.core.typed_passes import NativeLowering, NopythonTypeInference
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.core.untyped_passes import RewriteSemanticConstants
from numba.extending import lower_builtin, overload
from numba.np import linalg
from numba.np.arrayobj import populate_array

from aomc_sky.kernels import formula
from aomc_sky.kernels.arguments import Block, block_arguments
from aomc_sky.kernels.machine_code import Kind, kernel_stamp

if config.DISABLE_JIT and np.lib.NumpyVersion(np.__version__) < "2.0.0":
    # numpy 1 makes a float of an int and a uint64; compiled kernels, and numpy 2, do not. This changes the whole
    # process, in which somebody switched off the JIT to look for a fault.
    np._set_promotion_state("weak")  # type: ignore[attr-defined]


def _import_array_functions() -> None:
    """Load numba's array functions without scipy.linalg, which takes longer than all kernels of a table.

    They load it to see whether BLAS is there: it is, with scipy, and who multiplies matrices asks for it again.
    """
    found = linalg.ensure_blas
    linalg.ensure_blas = lambda: None
    try:
        from numba.np import arraymath

        arraymath.ensure_blas = found
    finally:
        linalg.ensure_blas = found


if not config.DISABLE_JIT and "numba.np.arraymath" not in sys.modules:
    _import_array_functions()

_WIDEST_VECTORS = '"prefer-vector-width"="512"'


class _WideLower(lowering.Lower):  # type: ignore[misc]
    """Lowers a function with the wish for vectors of 512 bits; a processor without them takes its own width.

    LLVM halves the width by itself on processors whose first wide units were slow; for these kernels
    the full one is 1.1 to 1.5 times as fast there, with the same bits.
    """

    def lower_normal_function(self, fndesc: Any) -> None:
        """Lower as numba does, then mark the function."""
        super().lower_normal_function(fndesc)
        set.add(self.function.attributes, _WIDEST_VECTORS)  # llvmlite's own `add` knows no attribute with a value


@register_pass(mutates_CFG=True, analysis_only=False)
class _WideLowering(NativeLowering):  # type: ignore[misc]
    _name = "wide_native_lowering"

    @property
    def lowering_class(self) -> type:
        return _WideLower


@register_pass(mutates_CFG=False, analysis_only=False)
class _NoneKnown(FunctionPass):  # type: ignore[misc]
    """Tells numba that an argument of another type `is None` never: it then leaves out what only None would need.

    Without this numba types and compiles the branch, and LLVM drops it.
    """

    _name = "none_known"

    def __init__(self) -> None:
        super().__init__()

    def run_pass(self, state: Any) -> bool:
        """Replace the comparisons by what they give; the branches go with numba's own pruning."""
        ir_of = state.func_ir
        for block in ir_of.blocks.values():
            for assign in block.find_insts(ir.Assign):
                compared = assign.value
                if not (isinstance(compared, ir.Expr) and compared.op == "binop"):
                    continue
                if compared.fn in (operator.is_, operator.is_not) and self._is_none_and_never(state, compared):
                    known = ir.Const(compared.fn is operator.is_not, assign.loc)
                    ir_of._definitions[assign.target.name] = [known]
                    assign.value = known
        return True

    @staticmethod
    def _is_none_and_never(state: Any, compared: Any) -> bool:
        argument, none = (guard(get_definition, state.func_ir, side) for side in (compared.lhs, compared.rhs))
        if not isinstance(argument, ir.Arg) or getattr(none, "value", compared) is not None:
            return False
        return not isinstance(state.args[argument.index], types.NoneType | types.Omitted | types.Optional)


class _KnownOperators:
    """numba's typing context, which looks for the form of an operator that fits some types only once.

    By itself it tries some twenty forms of + or [] at every place where one stands, and all places twice.
    """

    _operators = frozenset(f for f in vars(operator).values() if callable(f))
    _kinds = types.Number, types.Boolean, types.Array, types.BaseTuple, types.SliceType
    _known: ClassVar[dict[Any, Any]] = {}

    def __init__(self, context: Any) -> None:
        self._context = context

    def __getattr__(self, name: str) -> Any:
        return getattr(self._context, name)

    def resolve_function_type(self, function: Any, arguments: Any, keywords: Any) -> Any:
        """The signature of a call; None where there is none."""
        is_operator = isinstance(function, types.Function) and function.typing_key in self._operators
        if keywords or not (is_operator and all(isinstance(kind, self._kinds) for kind in arguments)):
            return self._context.resolve_function_type(function, arguments, keywords)
        call = (function, *arguments)
        if self._known.get(call) is None:
            self._known[call] = self._context.resolve_function_type(function, arguments, keywords)
        return self._known[call]


@register_pass(mutates_CFG=True, analysis_only=False)
class _TypeInference(NopythonTypeInference):  # type: ignore[misc]
    _name = "type_inference_of_kernels"

    def run_pass(self, state: Any) -> bool:
        """Infer types with a memory for operators."""
        context = state.typingctx
        state.typingctx = _KnownOperators(context)
        try:
            return bool(super().run_pass(state))
        finally:
            state.typingctx = context


_UNUSED = {
    "WithLifting",
    "InlineClosureLikes",
    "RewriteDynamicRaises",
    "MakeFunctionToJitFunction",
    "FindLiterallyCalls",
    "LiteralUnroll",
    "LiteralPropagationSubPipelinePass",
    "InlineOverloads",
    "NopythonRewrites",
    "NoPythonSupportedFeatureValidation",
    "DumpParforDiagnostics",
}
"""Steps of numba for what no kernel has: with, a function inside it, a message made at run time, literally(), sums of
whole arrays. Each would look through the whole function, and numba after it, to find nothing."""


class KernelCompiler(compiler.CompilerBase):  # type: ignore[misc]
    """numba's own pipeline with the widest vectors and the promise that array arguments do not overlap.

    Without the promise a loop that gathers from a table and stores to an output does not vectorise.
    Callers keep it: outputs are distinct arrays, checked where they come from a user.
    """

    lowering = _WideLowering

    def define_pipelines(self) -> list[Any]:
        """Return numba's default pipeline with the noalias flag, our lowering, and without what kernels do not need."""
        self.state.flags.noalias = True
        pipeline = compiler.DefaultPassBuilder.define_nopython_pipeline(self.state)
        own = {NativeLowering: self.lowering, NopythonTypeInference: _TypeInference}
        pipeline.passes = [(own.get(step, step), why) for step, why in pipeline.passes if step.__name__ not in _UNUSED]
        pipeline.add_pass_after(_NoneKnown, RewriteSemanticConstants)
        pipeline.finalize()
        return [pipeline]

    def compile_extra(self, function: Any) -> Any:
        """Compile with the garbage collector at rest: it finds next to nothing, and takes a tenth of the time.

        The name in machine code gets a number that no process gives twice. numba counts from 1 in each process and
        links by name: of two variants of one text, compiled in two processes and cached, one would call the other's.
        """
        FunctionIdentity._unique_ids = itertools.count(secrets.randbits(62))
        was_on = gc.isenabled()
        gc.disable()
        try:
            return super().compile_extra(function)
        finally:
            if was_on:
                gc.enable()


class _Part(JITCodeLibrary):  # type: ignore[misc]
    """The code of a function that only kernels call: optimised in theirs alone, and without machine code of its own.

    numba would link into it what it calls, and optimise all that once more for every caller.
    """

    def finalize(self) -> None:
        """Leave the rest to the kernels."""
        if hasattr(self, "_reload_init"):  # numba 0.60 has none
            self._reload_init.update(*(library._reload_init for library in self._linking_libraries))
        self._finalized = True

    def _get_module_for_linking(self) -> Any:
        """The code with that of all parts it calls, for a kernel."""
        if self._shared_module is None:
            whole, seen, left = self._own_module().clone(), {self}, list(self._linking_libraries)
            while left:
                library = left.pop()
                if library not in seen:
                    seen.add(library)
                    is_part = isinstance(library, _Part)
                    code = library._own_module() if is_part else library._get_module_for_linking()
                    whole.link_in(code, preserve=True)
                    left += library._linking_libraries if is_part else ()
            self._shared_module = whole
        return self._shared_module

    def _own_module(self) -> Any:
        """Its own code; a kernel may get it from many, and takes it once."""
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage == llvm.Linkage.external:
                function.linkage = "linkonce_odr"
        return self._final_module


class _PartLower(_WideLower):
    def lower_normal_function(self, fndesc: Any) -> None:
        """Lower, and let a loop that writes be a function of its own: LLVM keeps the promise of no overlap there."""
        super().lower_normal_function(fndesc)
        blocks = self.func_ir.blocks
        writes = any(True for block in blocks.values() for _ in block.find_insts((ir.SetItem, ir.StaticSetItem)))
        if writes and compute_cfg_from_blocks(blocks).loops() and "alwaysinline" not in self.function.attributes:
            self.function.attributes.add("noinline")


@register_pass(mutates_CFG=True, analysis_only=False)
class _PartLowering(_WideLowering):
    _name = "part_native_lowering"

    @property
    def lowering_class(self) -> type:
        return _PartLower

    def run_pass(self, state: Any) -> bool:
        """Lower into a library without machine code, and make it known to callers."""
        state.library = _Part(state.targetctx.codegen(), state.func_id.func_qualname)
        super().run_pass(state)
        result = state["cr"]
        entry: Any = [].append  # numba finds the code by a C function of its own, which nobody calls
        state.targetctx.insert_user_function(entry, result.fndesc, [state.library])
        state.reload_init.extend(getattr(state.library, "_reload_init", ()))  # numba 0.60 has none
        state["cr"] = result._replace(cfunc=entry)
        return True


class _PartCompiler(KernelCompiler):
    """Compiles what only kernels call: no wrapper for Python or C, and no machine code of its own."""

    lowering = _PartLowering

    def define_pipelines(self) -> list[Any]:
        """Return the kernels' pipeline with the flags of a part."""
        flags = self.state.flags
        flags.no_cpython_wrapper = flags.no_cfunc_wrapper = flags.no_compile = True
        return super().define_pipelines()


class _ByAddress(_FunctionCompiler):  # type: ignore[misc]
    def _customize_flags(self, flags: Any) -> Any:
        """Leave out what Python and C would call: it needs numba at run time, and the function itself nothing."""
        flags.no_cpython_wrapper = flags.no_cfunc_wrapper = flags.no_compile = True
        return flags


class _PartDispatcher(CPUDispatcher):  # type: ignore[misc]
    """Hands a part to the kernels that call it; called from Python, it compiles a form of its own for that."""

    def add_overload(self, cres: Any) -> None:
        """Keep compiled code for kernels alone."""
        self.overloads[tuple(cres.signature.args)] = cres

    def _compile_for_args(self, *args: Any, **kws: Any) -> Any:
        if "_outside" not in self.__dict__:
            self._outside = numba.jit(pipeline_class=KernelCompiler, **self.targetoptions)(self.py_func)
        return self._outside._compile_for_args(*args, **kws)

    @global_compiler_lock  # type: ignore[untyped-decorator]
    def machine_code(self, first: tuple[Kind, ...], last: tuple[Kind, ...]) -> tuple[str, bytes, int, Any]:
        """Compile it for arguments behind two addresses, the first ones and the last ones; see `kernels.machine_code`.

        Returned are the function's name, its code, where it stands in this process, and what it lives as long as. As
        numba's functions do, it takes before its arguments where its result and an error would be written.
        """

        def call(first, last):  # type: ignore[no-untyped-def]
            self(*(block_arguments(first) + block_arguments(last)))

        compiler = _ByAddress(call, cpu_target, self.targetoptions, {}, KernelCompiler)
        compiled = compiler.compile((Block(first), Block(last)), None)
        library, name = compiled.library, compiled.fndesc.llvm_func_name
        library.finalize()
        return name, library._get_compiled_object(), library.get_pointer_to_function(name), compiled


def _part(function: Callable[..., Any], **options: Any) -> Any:
    if config.DISABLE_JIT:
        return function
    options = {"nopython": True, "nogil": True, "error_model": "numpy", **options}
    return _PartDispatcher(py_func=function, targetoptions=options, pipeline_class=_PartCompiler)


class _CheckedFile(IndexDataCacheFile):  # type: ignore[misc]
    """The files of a kernel's cache, in which what is damaged or of other kernels is as good as missing.

    numba ends with an error where an index or its code cannot be unpickled, and runs code that has changed on the
    disk. And it writes an index before its code: killed in between, with older code under the name, it would run that.
    """

    def _load_index(self) -> Any:
        try:
            return super()._load_index()
        except Exception:  # pickle raises any error for damaged bytes
            return {}

    def save(self, key: Any, data: Any) -> None:
        """Store code with its key: two processes that save at once give their code one name, and one keeps it."""
        super().save(key, (key, data))

    def load(self, key: Any) -> Any:
        """The code of a key, None where there is none or another's."""
        entry = super().load(key)
        return entry[1] if entry is not None and entry[0] == key else None

    def _save_data(self, name: str, data: Any) -> None:
        code = self._dump(data)
        super()._save_data(name, (self._source_stamp, hashlib.sha256(code).digest(), code))

    def _load_data(self, name: str) -> Any:
        try:
            stamp, digest, code = super()._load_data(name)
        except Exception as error:
            raise OSError(f"{name} is damaged") from error
        if stamp != self._source_stamp or digest != hashlib.sha256(code).digest():
            raise OSError(f"{name} is damaged, or of other kernels")
        return pickle.loads(code)


class _StampedCache(FunctionCache):  # type: ignore[misc]
    def __init__(self, py_func: Callable[..., Any]) -> None:
        super().__init__(py_func)
        self._cache_file = _CheckedFile(
            cache_path=self._cache_path,
            filename_base=self._impl.filename_base,
            source_stamp=(self._impl.locator.get_source_stamp(), kernel_stamp()),
        )

    def save_overload(self, sig: Any, data: Any) -> None:
        """Store compiled code; on a disk that is full or has become read-only it is compiled again next time."""
        with contextlib.suppress(OSError):
            super().save_overload(sig, data)


def _enable_cache(dispatcher: Any, function: Callable[..., Any]) -> None:
    # The attribute is numba's private name; a test pins its behaviour. RuntimeError: no cache
    # folder is writable. AttributeError, TypeError: another numba, so the cache stays off.
    try:
        dispatcher._cache = _StampedCache(function)
    except (RuntimeError, AttributeError, TypeError, OSError):
        return


def kernel(function: Callable[..., Any]) -> Any:
    """Compile a kernel that Python calls: nogil, noalias, strict IEEE, cached on disk."""
    dispatcher = numba.njit(nogil=True, error_model="numpy", pipeline_class=KernelCompiler)(function)
    if not config.DISABLE_JIT:
        _enable_cache(dispatcher, function)
    return dispatcher


def shared(function: Callable[..., Any]) -> Any:
    """Compile a function for Python and for the jitted code of a user; it is cached with what calls it."""
    return numba.njit(nogil=True, error_model="numpy", pipeline_class=KernelCompiler)(function)


def inner(function: Callable[..., Any]) -> Any:
    """Compile a function that only kernels call; it is cached with them.

    It has its own noalias promise, which LLVM keeps when it inlines.
    """
    return _part(function)


def inlined(function: Callable[..., Any]) -> Any:
    """`inner` for a long straight function that stands in a loop, which vectorises only if it is inlined."""
    return _part(function, forceinline=True)


def reader(function: Callable[..., Any]) -> Any:
    """`kernel` that makes no array: it reads and fills those it is given, and numba counts no references.

    Counting costs more than the work where small functions pass arrays on at every step of a loop.
    """
    dispatcher = numba.njit(nogil=True, error_model="numpy", pipeline_class=KernelCompiler, _nrt=False)(function)
    if not config.DISABLE_JIT:
        _enable_cache(dispatcher, function)
    return dispatcher


def inner_reader(function: Callable[..., Any]) -> Any:
    """`inner` for a `reader`; counting takes time to compile, too, so this is the rule."""
    return _part(function, _nrt=False)


def inlined_reader(function: Callable[..., Any]) -> Any:
    """`inlined` for a `reader`."""
    return _part(function, forceinline=True, _nrt=False)


def seen_as(words: Any, like: Any) -> Any:
    """The memory of a contiguous array as numbers of the type of `like`, in which the array has a whole number."""
    return words.view(like.dtype)


def spliced(function: Callable[..., Any]) -> Any:
    """`inner` for a short function that is handed arrays for every photon: its lines stand in for the call.

    Handing an array to a compiled function counts a reference up and down, which costs more than such a function.
    """
    return _part(function, inline="always")


def overloads(function: Callable[..., Any]) -> Any:
    """Numba's `overload` for forms that stand in kernels alone."""
    return overload(function, jit_options={"pipeline_class": _PartCompiler})


def c_function(function: Callable[..., Any], signature: Any) -> Any:
    """Compile a function that C calls by its address; it needs no GIL, and is cached on disk like a kernel."""
    compiled = CFunc(function, signature, {}, {"error_model": "numpy"}, pipeline_class=KernelCompiler)
    _enable_cache(compiled, function)
    compiled.compile()
    return compiled


_formulas: list[Any] = []
"""Compiled forms of formulas; numba itself holds them by weak references alone."""


def _formula_part(text: Callable[..., Any], is_inlined: bool) -> Any:
    _formulas.append(_part(text, _nrt=False, forceinline=is_inlined))
    return types.Dispatcher(_formulas[-1])


def _compile_formula(text: Callable[..., Any], is_inlined: bool) -> None:
    """Let kernels call a formula: its text, or that of two texts which has the width of an argument."""
    if not hasattr(text, "texts"):
        infer_global(text, _formula_part(text, is_inlined))
        return
    short, long, of = text.texts
    short, long = _formula_part(short, is_inlined), _formula_part(long, is_inlined)

    class _ByWidth(AbstractTemplate):  # type: ignore[misc]
        key = text

        def generic(self, arguments: Any, keywords: Any) -> Any:
            """The signature of the text for these arguments."""
            self._part = short if getattr(arguments[of], "dtype", arguments[of]).bitwidth == 32 else long
            return self._part.get_call_type(self.context, arguments, keywords)

        def get_impl_key(self, sig: Any) -> Any:
            """What numba finds the compiled text by."""
            return self._part.get_impl_key(sig)

    infer_global(text, types.Function(_ByWidth))


def lowered(function: Callable[..., Any], typed: Callable[..., Any], *kinds: Any) -> Callable[..., Any]:
    """Decorate the code that a kernel has in the place of a function for arrays; `typed` is its result's type."""

    class _Typed(AbstractTemplate):  # type: ignore[misc]
        key = function

        def generic(self, arguments: Any, keywords: Any) -> Any:
            """The signature for these arguments."""
            own = tuple(map(types.unliteral, arguments))
            return signature(typed(*own), *own)

    infer_global(function, types.Function(_Typed))
    return lower_builtin(function, *kinds)  # type: ignore[no-any-return]


if not config.DISABLE_JIT:
    formula.compile_formulas(_compile_formula)

    @lowered(formula.kind_of, types.NumberClass, types.Number)
    def _kind_of(context: Any, builder: Any, typed: Any, values: Any) -> Any:
        return context.get_dummy_value()

    @lowered(formula.select, lambda condition, a, b: a, types.Boolean, types.Number, types.Number)
    def _select(context: Any, builder: Any, typed: Any, values: Any) -> Any:
        return builder.select(*values)

    def _chosen(builder: Any, typed: Any, values: Any, order: str) -> Any:
        a, b = values
        if isinstance(typed.args[0], types.Float):
            first = builder.fcmp_ordered(order, a, b)
        else:
            compare = builder.icmp_signed if typed.args[0].signed else builder.icmp_unsigned
            first = compare(order, a, b)
        return builder.select(first, a, b)

    @lowered(formula.smaller, lambda a, b: a, types.Number, types.Number)
    def _smaller(context: Any, builder: Any, typed: Any, values: Any) -> Any:
        return _chosen(builder, typed, values, "<")

    @lowered(formula.larger, lambda a, b: a, types.Number, types.Number)
    def _larger(context: Any, builder: Any, typed: Any, values: Any) -> Any:
        return _chosen(builder, typed, values, ">")

    @lowered(formula.nested, lambda coefficients, t: t, types.BaseTuple, types.Float)
    def _nested(context: Any, builder: Any, typed: Any, values: Any) -> Any:
        coefficients, t = values
        value = builder.extract_value(coefficients, 0)
        for k in range(1, len(typed.args[0])):
            value = builder.fadd(builder.fmul(value, t), builder.extract_value(coefficients, k))
        return value

    @lowered(seen_as, lambda words, like: types.Array(like, 1, "C"), types.Array, types.Number)
    def _seen_as(context: Any, builder: Any, typed: Any, values: Any) -> Any:
        words = context.make_array(typed.args[0])(context, builder, values[0])
        seen = context.make_array(typed.return_type)(context, builder)
        old, new = (
            context.get_abi_sizeof(context.get_data_type(kind.dtype)) for kind in (typed.args[0], typed.return_type)
        )
        size = builder.udiv(builder.mul(words.nitems, words.nitems.type(old)), words.nitems.type(new))
        populate_array(
            seen,
            data=builder.bitcast(words.data, seen.data.type),
            shape=[size],
            strides=[size.type(new)],
            itemsize=size.type(new),
            meminfo=words.meminfo,
            parent=words.parent,
        )
        return impl_ret_borrowed(context, builder, typed.return_type, seen._getvalue())

    @lowered(formula.word_of, lambda x: types.int64, types.float64)
    def _word_of(context: Any, builder: Any, typed: Any, values: Any) -> Any:
        return builder.bitcast(values[0], context.get_value_type(types.int64))

    @lowered(formula.float_of, lambda word: types.float64, types.int64)
    def _float_of(context: Any, builder: Any, typed: Any, values: Any) -> Any:
        return builder.bitcast(values[0], context.get_value_type(types.float64))
