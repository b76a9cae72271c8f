"""The files of a run against its manifest: there, of the right length, of the right SHA-256."""

from __future__ import annotations

from aomc_sky.verify.report import Check
from aomc_sky.verify.stored.parts import RunPart
from aomc_sky.verify.threads import in_order

NAME = "files"


def file_checks(part: RunPart, threads: int = 0) -> tuple[list[Check], set[str]]:
    """Compare every file with its entry in the manifest, `threads` files at a time, 0 for one per CPU.

    One line for all files that are whole and one for each that is not, whose names come back besides.
    """
    entries = sorted(part.manifest["files"].items())
    damage = dict(in_order(lambda item: (item[0], _damage(part, *item)), entries, threads))
    whole = [name for name, what in damage.items() if not what]
    checks = [Check(name=NAME, passed=False, detail=f"{name}: {what}") for name, what in damage.items() if what]
    if whole:
        n_bytes = sum(entry["bytes"] for name, entry in entries if not damage[name])
        of_shard = f" of shard {part.shard}" if part.shard.is_named else ""
        detail = f"{len(whole)} files{of_shard}, {n_bytes} bytes: length and SHA-256 agree"
        checks.insert(0, Check(name=NAME, passed=True, detail=detail))
    return checks, {name for name, what in damage.items() if what}


def _damage(part: RunPart, name: str, entry: dict[str, object]) -> str:
    """What is wrong with a file, nothing if it is whole."""
    size, wanted = part.folder.size_of(name), int(str(entry["bytes"]))
    if size is None:
        return "missing"
    if size != wanted:
        how = "truncated" if size < wanted else "too long"
        return f"{how}: {size} bytes, the manifest says {wanted}"
    if part.folder.sha256_of(name) != entry["sha256"]:
        return "another SHA-256 than the manifest says"
    return ""
