"""The names that files of a run, of its shards and of a year of skies have: a file of any other name is not ours."""

from __future__ import annotations

import re

from aomc_sky.outputs.blocks import MAX_SHARDS, WHOLE_RUN, Shard

PLAN = "plan.npz"
MANIFEST = "manifest.json"
PART = ".part"
"""Stands in the names of files that several processes fill, and of those that say how far they are."""

YEAR_FILES = (MANIFEST, "counts.npy", "counts.npy.part", "index.csv", "index.csv.part", PLAN)
"""Files of a year of skies, in the order in which it is taken apart."""

BEGINNINGS = ("manifest.", "counts.", "index.", "photons-", "photons.", "positions-", "weights-", "blocks-", PLAN)
"""How the names of all these files begin."""

_WAVEBAND = "(?:[0-9]{4}|[1-9][0-9]{4,8})"
_COLUMNS = "(?:photons|positions|weights)"
_WHOLE = re.compile(
    rf"plan\.npz|manifest\.json|counts\.(?:csv|npz)|photons\.mcpl(?:\.gz)?|photons-{_WAVEBAND}\.(?:raw|csv)"
    rf"|blocks-{_WAVEBAND}\.npy|{_COLUMNS}-{_WAVEBAND}\.npy(?:\.part)?"
)
_PIECE = re.compile(
    rf"(?P<stem>manifest|(?:blocks|{_COLUMNS})-{_WAVEBAND})\.(?P<mark>k|part)(?P<index>[0-9]{{1,7}})"
    r"-of-(?P<count>[0-9]{1,7})(?P<end>\.json|\.npy)"
)
_TEMPORARY = re.compile(r"\.aomc-sky-.+\.[0-9a-f]{4,16}", re.DOTALL)
TEMPORARY = ".aomc-sky-"
"""How names of files under way begin; they end in a point and hexadecimal digits of chance."""


def shard_of_file(name: str) -> Shard | None:
    """The shard that a file is of, `WHOLE_RUN` for a file of the whole run; None for a file that is not ours."""
    if _WHOLE.fullmatch(name):
        return WHOLE_RUN
    match = _PIECE.fullmatch(name)
    if match is None or match["end"] != (".json" if match["stem"] == "manifest" else ".npy"):
        return None
    if match["mark"] == "part" and not match["stem"].startswith("blocks"):
        return None
    index, count = int(match["index"]), int(match["count"])
    if not 1 <= index <= count <= MAX_SHARDS:
        return None
    shard = Shard(index=index, count=count, mark=match["mark"])
    return shard if name == f"{match['stem']}{shard.suffix}{match['end']}" else None


def is_run_file(name: str) -> bool:
    """Whether a file of this name is one of a run or of a shard."""
    return shard_of_file(name) is not None


def is_our_file(name: str) -> bool:
    """Whether a file of this name is one of a run, of a shard or of a year of skies."""
    return name in YEAR_FILES or is_run_file(name)


def is_temporary_file(name: str) -> bool:
    """Whether a file of this name is one that some process had not finished."""
    return _TEMPORARY.fullmatch(name) is not None


def removal_order(name: str) -> tuple[int, str]:
    """Sorts the names of a run in the order in which it is taken apart: manifests first, the plan last."""
    return (0 if name.startswith("manifest.") else 2 if name == PLAN else 1), name
