"""``python -m aomc_sky``."""

import sys

from aomc_sky.cli.main import main

sys.exit(main())
