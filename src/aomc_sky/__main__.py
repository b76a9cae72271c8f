"""``python -m aomc_sky``."""

import sys

from aomc_sky.cli.command import main

if __name__ == "__main__":  # processes that are started for `--engine dask` import this file under another name
    sys.exit(main())
