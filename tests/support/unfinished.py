"""Names of files that a process is writing, or that one left when it was killed."""

import re

UNFINISHED = re.compile(r"\.aomc-sky-.+\.[0-9a-f]{8}", re.DOTALL)
