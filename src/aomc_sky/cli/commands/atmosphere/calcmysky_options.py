"""The options that ``calcmysky``, the tool the description format comes from, has too."""

from __future__ import annotations

import argparse
import contextlib
import logging
import os
import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING

from aomc_sky.cli import options as cli_options

if TYPE_CHECKING:
    from aomc_sky.outputs.tables.atmosphere_saves import Saves

_SAVES = {
    "--save-irradiance": "irradiances order by order",
    "--save-scat-density2-from-ground": "source function of order 2 by way of the ground, with --method sos",
    "--save-scat-density": "source functions of orders 2 and up, with --method sos",
    "--save-delta-scattering": "radiance order by order; it is written in any case",
    "--save-accum-scattering": "radiance of all orders up to each",
    "--save-light-pollution": "light of a ground of 1 cd/m2, order by order, by backward paths",
}

_UNUSED = {
    "no_eds_tex": "--no-eds-tex has no effect: there is no texture of eclipsed double scattering to leave out",
    "save_delta_scattering": "--save-delta-scattering has no effect: radiance_by_order is written in any case",
}


def add_parser_group(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    group = parser.add_argument_group("as calcmysky has them")
    group.add_argument(
        "--radiance", action="store_true", help="write spectral radiances; this is what is written in any case"
    )
    group.add_argument(
        "--xyzw", action="store_true",
        help="write X, Y, Z and scotopic luminance too, in cd/m2, as calcmysky does without --radiance; needs the "
        "extra 'colour'",
    )  # fmt: skip
    group.add_argument(
        "--no-save-tex", action="store_true", help="read and check the description, print the plan, solve nothing"
    )
    group.add_argument("--no-eds-tex", action="store_true", help="accepted; there is no such texture here")
    group.add_argument(
        "--texture-save-precision", type=_significand_bits, metavar="BITS",
        help="atmosphere.nc in float32 with significands of 1 to 24 bits (default: float64)",
    )  # fmt: skip
    for option, text in _SAVES.items():
        group.add_argument(option, action="store_true", help=text)
    for option, text in (
        ("--opengl-info", "print processor, versions and environment"),
        ("--opengl-debug", "the same, and say which way is taken and why"),
        ("--opengl-debug-full", "the same with all details"),
    ):
        group.add_argument(option, action="store_true", help=f"{text}; OpenGL is not used")


def _significand_bits(text: str) -> int:
    value = cli_options.whole_number(text)
    if not 1 <= value <= 24:
        raise argparse.ArgumentTypeError(f"wanted 1 to 24 bits, got {text}")
    return value


def saves_of(arguments: argparse.Namespace) -> Saves:
    """What the options want in the table besides radiances."""
    from aomc_sky.outputs.tables.atmosphere_saves import Saves

    return Saves(
        irradiance=arguments.save_irradiance,
        source_from_ground=arguments.save_scat_density2_from_ground,
        source=arguments.save_scat_density,
        cumulative=arguments.save_accum_scattering,
        glow=arguments.save_light_pollution,
        xyzw=arguments.xyzw,
    )


def only_in_netcdf(arguments: argparse.Namespace) -> list[str]:
    """The options given that say something about atmosphere.nc alone."""
    named = [option for option in (*_SAVES, "--xyzw") if getattr(arguments, option[2:].replace("-", "_"))]
    return named + ["--texture-save-precision"] * (arguments.texture_save_precision is not None)


def notes_of(arguments: argparse.Namespace) -> list[str]:
    """What is to be said of options that were given and change nothing."""
    return [text for name, text in _UNUSED.items() if getattr(arguments, name)]


@contextlib.contextmanager
def diagnostics(arguments: argparse.Namespace) -> Iterator[None]:
    """Print the environment and let the package speak on standard error, where the options want it."""
    is_wordy = arguments.opengl_debug or arguments.opengl_debug_full
    if is_wordy or arguments.opengl_info:
        print(_environment(), file=sys.stderr)
    if not is_wordy:
        yield
        return
    handler, logger = logging.StreamHandler(sys.stderr), logging.getLogger("aomc_sky")
    before = logger.level
    logger.addHandler(handler)
    logger.setLevel(logging.DEBUG if arguments.opengl_debug_full else logging.INFO)
    try:
        yield
    finally:
        logger.setLevel(before)
        logger.removeHandler(handler)


def _environment() -> str:
    from aomc_sky.benchmark.timing import machine

    switches = [f"{name}={value}" for name, value in sorted(os.environ.items()) if name.startswith("NUMBA_")]
    return "\n".join([f"machine: {machine()}", f"numba: {' '.join(switches) or 'no switches set'}", "OpenGL: not used"])
