"""All guards of the matrix of faults: each row has one or more, and each guard a test that fails without it."""

from __future__ import annotations

from pathlib import Path

from tests.support.guards import read_guards

GUARDS = tuple(read_guards(Path(__file__).with_suffix(".txt")))

if __name__ == "__main__":
    for guard in GUARDS:
        print(f"{guard.row:2d}  {guard.place}  {guard.test}{'  (goes on without an end)' if guard.hangs else ''}")
