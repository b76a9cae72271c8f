"""What a C or Fortran compiler wants to know: the folder of our headers, and the flags that link this Python in."""

from __future__ import annotations

import shlex
import sys
import sysconfig
from importlib.resources import files
from pathlib import Path

from aomc_sky.errors import AomcSkyError


def include_dir() -> Path:
    """Folder of aomc_sky.h, aomc_sky.f90 and aomc_sky_embed.c."""
    return Path(str(files("aomc_sky") / "include"))


def embed_flags() -> list[str]:
    """Flags that compile aomc_sky_embed.c and link a program with the Python that runs this.

    Returns
    -------
    list of str
        As ``python3-config --cflags --ldflags --embed`` gives them, but for this very interpreter, also from a
        virtual environment, and with the path of the latter, so that the program finds aomc-sky. They are
        meant for ``cc ... $(aomc-sky info --embed-flags)``: the shell looks at no quotes there.

    Raises
    ------
    AomcSkyError
        The headers of this Python, or its library, are not installed.
    """
    headers = Path(sysconfig.get_paths()["include"])
    if not (headers / "Python.h").exists():
        raise AomcSkyError(f"{headers}/Python.h is missing; install the headers of this Python (python3-dev on Debian)")
    macro = f'-DAOMC_SKY_PYTHON="{sys.executable}"'
    return [f"-I{include_dir()}", f"-I{headers}", macro, *_library(), *_words("LIBS"), *_words("SYSLIBS")]


def _words(name: str) -> list[str]:
    return shlex.split(sysconfig.get_config_var(name) or "")


def _library() -> list[str]:
    """The shared library where it is installed, else the static one with all that extensions look for in it."""
    version = sysconfig.get_config_var("LDVERSION") or sysconfig.get_config_var("py_version_short")
    main, fixed = (Path(sysconfig.get_config_var(name) or "") for name in ("LIBDIR", "LIBPL"))
    folders = [main, main / (sysconfig.get_config_var("MULTIARCH") or ""), fixed]
    for place in folders:
        if (place / f"libpython{version}.so").exists():
            return [f"-L{place}", f"-lpython{version}", f"-Wl,-rpath,{place}"]
    for place in folders:
        static = place / f"libpython{version}.a"
        if static.exists():
            return ["-no-pie", str(static), "-Wl,--export-dynamic", *_words("MODLIBS")]
    looked = ", ".join(str(place) for place in dict.fromkeys(folders))
    raise AomcSkyError(
        f"libpython{version} is in none of {looked}; install it (python3-dev on Debian), "
        "or build Python with --enable-shared"
    )
