"""Options of a background sky: when it is looked at, and what of it."""

from __future__ import annotations

import argparse

from aomc_sky.cli.options import input_of


def moment(text: str) -> float:
    """A time with its zone, or seconds since 1970."""
    from aomc_sky.formats.sky_toml.rules import Time

    value: object = text
    if text.lstrip("+-").replace(".", "", 1).isdecimal():
        value = float(text)
    for fault in Time().faults(value):
        raise argparse.ArgumentTypeError(f"{fault.message}; {fault.advice}")
    return Time().read(value)


def add_background_options(group: argparse._ArgumentGroup) -> None:
    """Which animations of the files count, where midnight is, and what happens between two keys."""
    group.add_argument(
        "--animation", action="append", metavar="NAME", help="only this animation; repeatable (default: all)"
    )
    group.add_argument(
        "--utc-offset",
        type=input_of("background", "utc_offset"),
        default=0.0,
        metavar="HOURS",
        help="local time less UTC, for the midnight of repeating animations (default 0)",
    )
    group.add_argument(
        "--interpolation",
        choices=("crossfade", "slerp"),
        default="crossfade",
        help="between two keys both lobes fade (default), or one turns",
    )
