"""``aomc-sky merge``, which went with version 0.3."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from aomc_sky.errors import UsageError

if TYPE_CHECKING:
    from aomc_sky.cli.usage import Parser


def add_options(parser: Parser) -> None:
    """Whatever stands after the name of the sub-command."""
    parser.description = "Shards write in place: there is nothing to merge. Run the missing shards."
    parser.add_argument("words", nargs=argparse.REMAINDER, help=argparse.SUPPRESS)
    parser.set_defaults(handler=merge)


def merge(arguments: argparse.Namespace) -> int:
    """Say what to use instead."""
    raise UsageError("there is no merge: shards write in place; run the missing shards")
