"""Kernels that Python calls by the address of their machine code: kept on the disk, it needs no numba.

Importing numba and loading a kernel from numba's cache takes 0.35 s, linking machine code by llvmlite alone 0.04. What
is kept stands under the hash of all that it follows from: the text of all kernels, the versions of numba, llvmlite and
Python, the processor, numba's settings, and the types of the arguments. Anything else is compiled anew.

The arguments of a kernel stand behind two addresses, those that differ from call to call and those that do not. Each
is a *block* of 64-bit words. Behind a head of two words that say whose it is, a number takes one word, an array two
(where it lies, its length), one that is not contiguous three (its stride), a tuple the words of its parts; None and
True take none, because they are types to the compiler.
"""

from __future__ import annotations

import ctypes
import hashlib
import importlib.util
import os
import struct
import sys
import threading
from collections.abc import Callable, Iterable
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from aomc_sky.cache import Cache, DamagedEntryError
from aomc_sky.system import cache_folder

HEAD_WORDS = 2

Kind = str | tuple[Any, ...] | None
"""Type of an argument: numpy's name of a number's type, with ``[]`` behind it for a contiguous array and ``[:]`` for
another one; None; those of a tuple's parts."""

_Kinds = tuple[tuple[Kind, ...], tuple[Kind, ...]]
_Function = Callable[[Any, Any, bytes, bytes], int]
_FUNCTION = ctypes.CFUNCTYPE(ctypes.c_int32, *(2 * [ctypes.c_void_p]), *(2 * [ctypes.c_char_p]))

_RESULT, _ERROR = ctypes.create_string_buffer(8), ctypes.create_string_buffer(8)
"""Where a function would write: a result, but that is None, and an error, but kernels raise none."""

_PLACES = ("NUMBA_CACHE_DIR", "NUMBA_NUM_THREADS", "NUMBA_THREADING_LAYER")
"""Settings of numba that machine code does not depend on."""

_linked: list[Any] = []
"""Machine code lives as long as what was linked."""

_lock = threading.RLock()


def kinds_of(arguments: Iterable[object]) -> tuple[Kind, ...]:
    """Types of arguments."""
    return tuple([_kind(argument) for argument in arguments])


def _kind(argument: Any) -> Kind:
    if isinstance(argument, np.ndarray) and argument.ndim == 1:
        return str(argument.dtype.str) + ("[]" if argument.flags.c_contiguous else "[:]")
    if argument is None:
        return None
    if argument is True:
        return "True"
    if isinstance(argument, tuple):
        return kinds_of(argument)
    if isinstance(argument, np.generic):
        return str(argument.dtype.str)
    raise TypeError(f"a {type(argument).__name__} cannot stand in a block")


def words_of(arguments: Iterable[object]) -> list[int]:
    """The words of a block for arguments, without its head; their arrays must outlive it."""
    words: list[int] = []
    for argument in arguments:
        if argument is None or argument is True:
            continue
        if isinstance(argument, tuple):
            words += words_of(argument)
        elif isinstance(argument, np.ndarray):
            if argument.ndim != 1:
                raise TypeError("arrays behind an address have one dimension")
            words += [_address_of(argument), argument.size]
            if not argument.flags.c_contiguous:
                words.append(argument.strides[0] % 2**64)
        elif isinstance(argument, np.generic):
            words.append(int(argument if argument.dtype.kind == "u" else argument.view(f"u{argument.itemsize}")))
        else:
            raise TypeError(f"a {type(argument).__name__} cannot stand in a block")
    return words


_byte_of = ctypes.c_char.from_buffer


def _address_of(array: np.ndarray) -> int:
    try:
        return ctypes.addressof(_byte_of(array))  # a third of the time of `array.ctypes.data`
    except (TypeError, ValueError, BufferError):  # read-only, empty, not contiguous
        return int(array.ctypes.data)


def _block(arguments: tuple[object, ...]) -> bytes:
    words = words_of(arguments)
    return struct.pack(f"={HEAD_WORDS * 8}x{len(words)}Q", *words)


class Kernel:
    """A kernel by the name of its module in `kernels` and its own."""

    def __init__(self, module: str, name: str) -> None:
        self.module, self.__name__ = module, name
        self._functions: dict[_Kinds, _Function] = {}
        self._not_kept: set[_Kinds] = set()

    @property
    def text(self) -> Any:
        """The kernel as it stands in its module."""
        return getattr(import_module(f"aomc_sky.kernels.{self.module}"), self.__name__)

    def bound(self, *last: object) -> Bound:
        """It with its last arguments."""
        return Bound(self, last)

    def is_kept(self, kinds: _Kinds) -> bool:
        """Whether there is machine code for these types of the first arguments and the last ones; it is linked."""
        if kinds in self._functions:
            return True
        if kinds not in self._not_kept and not self._from_disk(kinds):
            self._not_kept.add(kinds)  # who asks for every batch looks once
        return kinds in self._functions

    def function(self, kinds: _Kinds) -> _Function:
        """The function of two addresses for these types; what nobody has kept is compiled."""
        if not self.is_kept(kinds):
            with _lock:
                if kinds not in self._functions:
                    self._compile(kinds)
        return self._functions[kinds]

    def _from_disk(self, kinds: _Kinds) -> bool:
        kept = _cache()
        if kept is None:
            return False
        with _lock:
            try:
                content = kept.read(self._key(kinds))
                if content is None:
                    return False
                symbol, _, code = content.partition(b"\n")
                self._functions[kinds] = _FUNCTION(_link(symbol.decode(), code))
            except (DamagedEntryError, RuntimeError):  # llvmlite: the code needs what this process has not
                return False
        return True

    def _compile(self, kinds: _Kinds) -> None:
        symbol, code, address, owner = self.text.machine_code(*kinds)
        _linked.append(owner)
        self._functions[kinds] = _FUNCTION(address)
        kept = _cache()
        if kept is not None:
            kept.write(self._key(kinds), symbol.encode() + b"\n" + code)

    def _key(self, kinds: _Kinds) -> str:
        return hashlib.sha256(repr((self.module, self.__name__, kinds, _circumstances())).encode()).hexdigest()


class Bound:
    """A kernel with its last arguments: called with the first ones, it returns nothing."""

    def __init__(self, kernel: Kernel, last: tuple[object, ...]) -> None:
        self.kernel, self._last = kernel, last
        self._kinds, self._block = kinds_of(last), _block(last)

    def __call__(self, *first: object) -> None:
        """Call it with numbers of numpy, arrays of one dimension, tuples of them, and None."""
        if compiler_is_off():
            self.kernel.text(*first, *self._last)
        else:
            self.kernel.function((kinds_of(first), self._kinds))(_RESULT, _ERROR, _block(first), self._block)

    def is_kept(self, *first: object) -> bool:
        """Whether it can be called without a compiler, for arguments of these types."""
        return compiler_is_off() or self.kernel.is_kept((kinds_of(first), self._kinds))

    def for_types_of(self, *first: object) -> Callable[..., None]:
        """A function that does not look at the types of its arguments: uint64 numbers, and contiguous arrays to write.

        Called with few photons at a time, it would take longer to look than to make them.
        """
        if compiler_is_off():
            return self
        function = self.kernel.function((kinds_of(first), self._kinds))
        pack = struct.Struct(f"={HEAD_WORDS * 8}x{len(words_of(first))}Q").pack

        def call(*arguments: Any) -> None:
            words: list[int] = []
            for argument in arguments:
                if type(argument) is np.ndarray:
                    words += _address_of(argument), argument.size
                else:
                    words.append(argument)
            function(_RESULT, _ERROR, pack(*words), self._block)  # `self` holds the arrays of the block

        return call


def compiler_is_off() -> bool:
    """Whether somebody has switched numba's compiler off: kernels are Python then."""
    config = getattr(sys.modules.get("numba"), "config", None)
    if config is not None:
        return bool(config.DISABLE_JIT)
    return os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0")


@cache
def kernel_stamp() -> str:
    """Hash of the text of all kernels: a file of another room may stand in the code of any."""
    digest = hashlib.sha256()
    for path in sorted(Path(__file__).parent.rglob("*.py")):
        digest.update(path.name.encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()


@cache
def _circumstances() -> tuple[object, ...]:
    """All that machine code follows from but the kernel and its types."""
    import llvmlite
    import llvmlite.binding as llvm

    numba = importlib.util.find_spec("numba")
    assert numba is not None
    assert numba.origin is not None
    version = Path(numba.origin).with_name("_version.py").read_bytes()
    settings = sorted((n, v) for n, v in os.environ.items() if n.startswith("NUMBA_") and n not in _PLACES)
    file = Path(".numba_config.yaml")
    processor = llvm.get_process_triple(), llvm.get_host_cpu_name(), sorted(llvm.get_host_cpu_features().items())
    return (
        *(kernel_stamp(), version, llvmlite.__version__, sys.version, processor, settings),
        file.read_bytes() if file.is_file() else b"",
    )


@cache
def _cache() -> Cache | None:
    """Where machine code is kept: where numba's cache was sent to, else where results of this user are."""
    named = os.environ.get("NUMBA_CACHE_DIR", "")
    folder = Path(named) if named else cache_folder(os.environ)
    return None if folder is None else Cache(folder=folder / "aomc-sky" / "kernels")


def _link(symbol: str, code: bytes) -> int:
    """Address of a function of machine code; RuntimeError where the code needs what this process has not."""
    import llvmlite.binding as llvm

    library = llvm.JITLibraryBuilder().add_object_img(code).add_current_process().export_symbol(symbol)
    linked = library.link(_linker(), f"kernel {len(_linked)}")
    _linked.append(linked)
    return int(linked[symbol])


@cache
def _linker() -> Any:
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    machine = llvm.Target.from_default_triple().create_target_machine(
        cpu=llvm.get_host_cpu_name(), features=llvm.get_host_cpu_features().flatten()
    )
    return llvm.create_lljit_compiler(machine, suppress_errors=True)
