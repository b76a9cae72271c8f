"""Private names of numba that speed the kernels up: one pipeline and one cache. `jit` also works without them.

numba's own cache looks only at the file of the cached function. After an edit of a helper in another file it would run
old code. It also writes an index before the code of that index: a process killed in between leaves other code under the
name. Here each signature therefore has one file, which is replaced as a whole. A hash seals it: of the text of all
kernels, of the signature and the processor, and of the code.
"""

from __future__ import annotations

import contextlib
import hashlib
import itertools
import os
import pickle
import secrets
from collections.abc import Callable
from pathlib import Path
from typing import Any

from aomc_sky.system import interrupts_held

import llvmlite
import numba
from numba.core.bytecode import FunctionIdentity
from numba.core.caching import FunctionCache
from numba.core.ccallback import CFunc as CFunc
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.serialize import dumps
from numba.np import linalg

NO_WRAPPERS = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
"""Options of what only kernels call."""

NO_REFCOUNT = {"_nrt": False}
"""Option of what makes no array: it counts no references."""


def _import_array_functions() -> None:
    """Load numba's array functions without scipy.linalg, which takes as long as numba itself.

    They load it only to see whether BLAS is there. scipy has it, and a product of matrices asks again.
    """
    ensure_blas, linalg.ensure_blas = linalg.ensure_blas, lambda: None
    try:
        from numba.np import arraymath

        arraymath.ensure_blas = ensure_blas
    finally:
        linalg.ensure_blas = ensure_blas


_import_array_functions()

_PACKAGE = Path(__file__).parents[1]
_SEAL_BYTES = 32


class KernelCompiler(CompilerBase):
    """numba's own pipeline with the promise that array arguments do not overlap.

    Without the promise a loop that reads from a table and writes to an output does not vectorise. Outputs are distinct
    arrays, and those of a user are checked.
    """

    def define_pipelines(self) -> list[Any]:
        """Return numba's default pipeline, with the flag set."""
        self.state.flags.noalias = True
        return [DefaultPassBuilder.define_nopython_pipeline(self.state)]

    def compile_extra(self, function: Any) -> Any:
        """Compile under a number that no process gives twice.

        numba counts from 1 in each process and links by name: of two closures of one text, compiled in two processes
        and cached, one would call the other's code. Ctrl-C waits: llvmlite notes after each call of LLVM who owns the
        code, and an interrupt in between makes both free it.
        """
        FunctionIdentity._unique_ids = itertools.count(secrets.randbits(62))
        with interrupts_held():
            return super().compile_extra(function)


def text_stamp() -> str:
    """Hash of the path and the text of every file below a folder named `kernels`, and of the compiler's versions."""
    digest = hashlib.sha256(f"{numba.__version__} {llvmlite.__version__}".encode())
    for folder, folders, names in os.walk(_PACKAGE):
        folders.sort()
        inside = Path(folder).relative_to(_PACKAGE)
        for name in sorted(names) if "kernels" in inside.parts else ():
            if name.endswith(".py"):
                digest.update(f"\0{inside / name}\0".encode())
                digest.update(Path(folder, name).read_bytes())
    return digest.hexdigest()


AS_IMPORTED = text_stamp()
"""Of the kernels of this process, unless their files have changed since."""


class _CodeFiles:
    """The code of one kernel, a file for each signature and processor; a file that is damaged counts as missing."""

    def __init__(self, folder: str, name: str) -> None:
        self._folder, self._name = Path(folder), name

    def _path(self, key: Any) -> Path:
        return self._folder / f"{self._name}.{hashlib.sha256(repr(key).encode()).hexdigest()[:32]}.nbc"

    @staticmethod
    def _seal(key: Any, code: bytes) -> bytes:
        return hashlib.sha256(repr((AS_IMPORTED, key)).encode() + code).digest()

    def load(self, key: Any) -> Any:
        """The data of a key, or None."""
        try:
            content = self._path(key).read_bytes()
        except OSError:
            return None
        code = content[_SEAL_BYTES:]
        return pickle.loads(code) if content[:_SEAL_BYTES] == self._seal(key, code) else None

    def save(self, key: Any, data: Any) -> None:
        """Save under a key; another process sees the whole file or none."""
        path, code = self._path(key), dumps(data)
        unfinished = path.with_name(f"{path.name}.{secrets.token_hex(8)}")
        try:
            unfinished.write_bytes(self._seal(key, code) + code)
            os.replace(unfinished, path)
        finally:
            unfinished.unlink(missing_ok=True)


class StampedCache(FunctionCache):
    """numba's cache of a function, in numba's folder, for these kernels alone.

    After a change of a kernel's file it is not used any more, because a module imported later may have the new text.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)
        self._cache_file = _CodeFiles(self._cache_path, self._impl.filename_base)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Compiled code for a signature, or None."""
        with interrupts_held():  # as in `KernelCompiler.compile_extra`
            return super().load_overload(sig, target_context) if text_stamp() == AS_IMPORTED else None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Store compiled code; where the disk is full or read-only it is compiled again next time."""
        if text_stamp() == AS_IMPORTED:
            with contextlib.suppress(OSError):
                super().save_overload(sig, data)


def keep_code(compiled: Any, function: Callable[..., Any]) -> None:
    """Let a dispatcher or a C function use the cache; without a folder to write to it goes on without."""
    if not hasattr(compiled, "_cache"):
        raise AttributeError("numba's functions have no attribute _cache")
    with contextlib.suppress(RuntimeError, OSError):  # RuntimeError: numba finds no folder
        compiled._cache = StampedCache(function)
