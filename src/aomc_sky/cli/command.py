"""The command ``aomc-sky``: hears Ctrl-C before the rest of the package is imported, which takes a moment."""

import os
import signal


def _end(number: int, frame: object) -> None:
    os.write(2, b"aomc-sky: interrupted\n")
    os._exit(130)  # nothing has begun


def main(argv: list[str] | None = None) -> int:
    """Carry a command out; see `aomc_sky.cli.main`."""
    is_ours = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if is_ours:
        signal.signal(signal.SIGINT, _end)
    from aomc_sky.cli import main as cli

    if is_ours:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    return cli.main(argv)
