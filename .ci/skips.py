"""What a leg of the gate has skipped: `judge` prints it, and ends with 1 where skips.toml does not permit it."""

import re
import sys
import tomllib
from collections import Counter
from pathlib import Path

PERMITTED = tomllib.loads(Path(__file__).with_name("skips.toml").read_text())["permitted"]


def noted(path):
    """Tests, or files of tests, that are skipped, and the reason of each: tests/conftest.py writes them."""
    return dict(line.split("\t") for line in Path(path).read_text().splitlines())


def permitted(leg, reason, missing):
    """The entry of the list that permits a skip in this leg, or none; the gate cannot have the `missing` commands."""
    for entry in PERMITTED:
        found = re.fullmatch(entry["reason"], reason)
        if found and leg in entry["legs"]:
            commands = found.groupdict().get("commands")
            if commands is None or set(re.split(" and | or ", commands)) & set(missing):
                return entry
    return None


def judge(leg, path, missing):
    """Print a line for each reason in each file; whether all are permitted."""
    by_file = Counter((test.partition("::")[0], reason) for test, reason in noted(path).items())
    n_refused = 0
    for (file, reason), n in sorted(by_file.items()):
        entry = permitted(leg, reason, missing)
        n_refused += n * (entry is None)
        print(f"skipped {n:4d}  {file}: {reason} [{entry['runs'] if entry else 'NOT PERMITTED'}]")
    print(f"{leg}: {by_file.total()} skipped, {n_refused} of them not permitted by .ci/skips.toml")
    return n_refused == 0


def again(path, files):
    """What was skipped, as words for pytest: a file once, and none of its tests apart."""
    words = [*noted(path), *files]
    whole = {word for word in words if "::" not in word}
    return list(dict.fromkeys(word for word in words if word in whole or word.partition("::")[0] not in whole))


if __name__ == "__main__":
    command, *given = sys.argv[1:]
    if command == "again":
        print(*again(given[0], given[1:]), sep="\n")
    elif not judge(given[0], given[1], given[2:]):
        sys.exit(1)
