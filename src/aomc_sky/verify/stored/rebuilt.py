"""What a plan alone makes again, and what nobody can say without the scene."""

from __future__ import annotations

from aomc_sky.errors import OutputError
from aomc_sky.outputs.counts import COUNTS_FILES, counts_file
from aomc_sky.verify.report import Check
from aomc_sky.verify.stored.manifest import wanted_bands
from aomc_sky.verify.stored.parts import RunPart

WITHOUT_SCENE = (
    "that the plan is the one of a scene and of a seed that somebody chose",
    "the version, notes, names and hashes of the scene's files, and how they were read",
)
"""What a folder that was sealed anew may say as it likes; `verify RUN --scene amc.inp` compares the most of it."""

WITH_SCENE = ("that somebody chose this seed", "the version")
"""What is left when the scene's files are there."""

OF_THE_MACHINE = "times, speed and machine"


def counts_check(part: RunPart) -> Check:
    """Make the file of counts again, compare it byte for byte and name the first line that differs."""
    name, wanted = counts_file(part.source, wanted_bands(part))
    try:
        with part.folder.reading(name) as file:
            found = file.read(len(wanted) + 1)
    except OutputError:
        return Check(name="counts file", passed=False, detail=f"{name} is missing")
    if found == wanted:
        return Check(name="counts file", passed=True, detail=f"{name} is what the plan gives, byte for byte")
    if name != COUNTS_FILES[0]:
        return Check(name="counts file", passed=False, detail=f"{name} is not what the plan gives")
    lines = zip([*found.split(b"\n"), b""], [*wanted.split(b"\n"), b""], strict=False)
    line = next((k for k, (one, other) in enumerate(lines, 1) if one != other), 0)
    return Check(name="counts file", passed=False, detail=f"{name} is not what the plan gives, from line {line} on")
