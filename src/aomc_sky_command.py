"""The command ``aomc-sky``. Ctrl-C is heard before the package is imported, which takes a twentieth of a second."""

import os
import signal
import sys
from typing import Any


def _end(number: int, frame: Any) -> None:
    os.write(2, b"aomc-sky: interrupted\n")
    os._exit(130)  # nothing has begun


_IS_OURS = signal.getsignal(signal.SIGINT) is signal.default_int_handler
if _IS_OURS:
    signal.signal(signal.SIGINT, _end)


def main() -> int:
    """Carry a command out; see `aomc_sky.cli.main`."""
    from aomc_sky.cli import main as cli

    if _IS_OURS:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    return cli.main()


if __name__ == "__main__":
    sys.exit(main())
