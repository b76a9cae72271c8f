"""Row 45 of the matrix: run folders and shards that somebody prepared open, write and remove nothing outside.

Every case is judged by the commands themselves in this process: what they answer, which files of the folder beside
the prepared one they open (none), and whether that folder is the same afterwards, names, contents and times.
"""

from __future__ import annotations

import contextlib
import json
import re
import shutil
import signal
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from aomc_sky.errors import OutputError
from aomc_sky.outputs.folder.run_folder import RunFolder
from aomc_sky.outputs.photons.npy import NpyParts
from aomc_sky.source.photon_source import PhotonSource
from aomc_sky.source.plan.plan import Plan
from tests.support.crafted_folders import (
    ANY_MANIFEST,
    BAD_NAMES,
    ODD,
    RUN_MANIFEST,
    SHARD_MANIFEST,
    Change,
    bad_names,
    written,
)
from tests.support.fault_rows import command, row_id
from tests.support.limits import MOST_CPU_S
from tests.support.scenes import copy_scene
from tests.support.shards import make_shards, shard_words

EPW = Path(__file__).resolve().parents[1] / "data" / "weather" / "good" / "invented.epw"
CODES = ("E961", "E100", "E962", "E963", "E964")
RUN_FILES = ("plan.npz", "manifest.json", "counts.csv", "photons-0001.npy", "blocks-0002.npy")
OPENED: list[str] = []
"""Paths that this process opened since the list was emptied; the hook can never be taken away again."""


def _note(event: str, arguments: tuple) -> None:
    if event == "open" and isinstance(arguments[0], (str, bytes)):
        OPENED.append(arguments[0] if isinstance(arguments[0], str) else arguments[0].decode("utf-8", "replace"))


sys.addaudithook(_note)


@dataclass(frozen=True, kw_only=True)
class Place:
    """A folder to spoil and the one beside it that nobody may touch."""

    folder: Path
    outside: Path
    scene: Path
    before: dict = field(default_factory=dict)

    def settle(self) -> None:
        """Remember what stands outside."""
        self.before.update(self._found())

    def _found(self) -> dict:
        paths = sorted(self.outside.rglob("*"))
        return {p: (p.stat().st_mtime_ns, p.read_bytes()) for p in paths if p.is_file()} | {
            p: p.stat().st_mtime_ns for p in (self.outside, *paths) if p.is_dir()
        }

    def check(self) -> None:
        """Nothing outside was changed."""
        assert self._found() == self.before


@pytest.fixture(scope="module")
def good_run(tmp_path_factory) -> Path:
    scene = copy_scene("document_example", tmp_path_factory.mktemp("run")).parent
    assert command("run", scene, "--iterations", 300, "--out", scene / "out", "-q") == 0
    return scene / "out"


@pytest.fixture(scope="module")
def good_shards(tmp_path_factory) -> Path:
    return make_shards(tmp_path_factory.mktemp("shards"), "--iterations", 300)


def place_of(good: Path, tmp_path: Path) -> Place:
    """A copy of a good folder, with a victim at ``../outside/victim`` and ``../victim``."""
    outside = tmp_path / "outside"
    outside.mkdir()
    (outside / "victim").write_text("victim")
    (tmp_path / "deep").mkdir()
    for path in (tmp_path / "victim", tmp_path / "deep" / "victim"):
        path.symlink_to(outside / "victim")
    folder = Path(shutil.copytree(good, tmp_path / "deep" / "out"))
    return Place(folder=folder, outside=outside, scene=next(good.parent.rglob("amc.inp"), good).parent)


@contextlib.contextmanager
def no_wait() -> Iterator[None]:
    """A command that waits for a pipe, or reads without an end, fails."""

    def stop(*_: object) -> None:
        raise TimeoutError("the command waits")

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(10 * int(MOST_CPU_S))
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def answer(place: Place, capsys, *words: object) -> int:
    """Exit code of a command that kept to its folder."""
    OPENED.clear()
    with no_wait():
        code = command(*words)
    said = capsys.readouterr()
    err = said.err + "".join(f"error[{code}]" for code in re.findall(r'"code": "(E\d+)"', said.out))
    opened = [path for path in OPENED if str(place.outside) in path or "victim" in path]
    assert opened == []
    place.check()
    assert "Traceback" not in err
    assert code == 0 or any(f"error[{known}]" in err for known in CODES), err
    return code


LOOKS = {"verify": ("-q",), "info": ("--json",), "export": ("--to", "csv", "--out", "made", "-q")}
"""Commands that only look at a run folder."""


def looks(place: Place, capsys, names=tuple(LOOKS)) -> set[int]:
    """Codes of such commands."""
    made = {"made": place.folder.parent / "made"}
    return {answer(place, capsys, name, place.folder, *(made.get(w, w) for w in LOOKS[name])) for name in names}


NAMES = [f"name-{k:02d}" for k in range(len(BAD_NAMES))]
RUN_CHANGES, SHARD_CHANGES = [*NAMES, *ANY_MANIFEST, *RUN_MANIFEST], [*NAMES, *ANY_MANIFEST, *SHARD_MANIFEST]


def change_of(name: str, place: Place, own: dict[str, Change]) -> Change:
    return dict(bad_names(place.outside / "victim")).get(name) or own[name]


def some(changes: list[str], kind: str) -> list[object]:
    """Every fourth change; the others when slow."""
    return [
        pytest.param(name, id=row_id(45, f"{kind}-{name}"), marks=() if k % 4 == 0 else pytest.mark.slow)
        for k, name in enumerate(changes)
    ]


def with_manifest(good: Path, tmp_path: Path, name: str, *, shard: int = 0) -> tuple[Place, bytes]:
    """A run, or shards, whose manifest is changed, or that of one shard; and the manifest."""
    place, file = place_of(good, tmp_path), f"manifest.k{shard}-of-3.json" if shard else "manifest.json"
    change = change_of(name, place, {**ANY_MANIFEST, **(SHARD_MANIFEST if shard else RUN_MANIFEST)})
    data = written(json.loads((place.folder / file).read_bytes()), change)
    (place.folder / file).write_bytes(data)
    place.settle()
    return place, data


def in_turn(changes: list[str], kind: str, ways: tuple[str, ...], few: list[str] | None = None) -> list[object]:
    """Changes, or a few of them, with one of the ways in turn; all with all of them when slow."""
    by_default = [
        pytest.param(name, ways[k % len(ways) :][:1], id=row_id(45, f"{kind}-{name}"))
        for k, name in enumerate(few or changes)
    ]
    mark = {"marks": pytest.mark.slow}
    return by_default + [pytest.param(n, ways, id=row_id(45, f"{kind}-{n}-by-all-commands"), **mark) for n in changes]


@pytest.mark.parametrize(("name", "ways"), in_turn(RUN_CHANGES, "manifest", tuple(LOOKS)))
def test_a_crafted_manifest(name, ways, good_run, tmp_path, capsys):
    """Commands that look refuse it; ``run`` refuses one with a right hash of itself, and mends any other."""
    place, data = with_manifest(good_run, tmp_path, name)
    kept = {path.name: path.read_bytes() for path in place.folder.iterdir()}
    assert looks(place, capsys, ways) == {3}
    code = answer(place, capsys, "run", place.scene, "--iterations", 300, "--out", place.folder, "-q")
    assert code == (3 if is_sealed(data) else 0)
    if code:
        assert {path.name: path.read_bytes() for path in place.folder.iterdir()} == kept


@pytest.mark.parametrize("name", some(RUN_CHANGES, "replaced"))
def test_a_crafted_manifest_is_replaced(name, good_run, tmp_path, capsys):
    place, _ = with_manifest(good_run, tmp_path, name)
    words = ["run", place.scene, "--iterations", 300, "--out", place.folder, "-q", "--force"]
    assert answer(place, capsys, *words) == 0
    assert answer(place, capsys, "verify", place.folder, "-q") == 0


@pytest.mark.parametrize("forge", ["run", "shard"])
@pytest.mark.parametrize("elsewhere", ["../../victim", "/etc/hostname", "photons-0001.npy/../../../victim"])
@pytest.mark.parametrize("fault", [pytest.param(0, id=row_id(45, "unsealed-names-elsewhere"))])
def test_names_elsewhere_are_refused_without_a_right_hash_too(
    fault, forge, elsewhere, good_run, good_shards, tmp_path, capsys
):
    """No damage makes such a name, so a manifest with one is refused as it stands, and nothing is made anew."""
    place = place_of(good_shards if forge == "shard" else good_run, tmp_path)
    path = place.folder / ("manifest.k1-of-3.json" if forge == "shard" else "manifest.json")
    manifest = json.loads(path.read_bytes())
    manifest["files"][elsewhere] = manifest["files"][min(manifest["files"])]
    path.write_bytes(json.dumps(manifest).encode())
    place.settle()
    kept = {file.name: file.read_bytes() for file in place.folder.iterdir()}
    words = shard_words(place.scene, place.folder, 1) if forge == "shard" else ["run", place.scene]
    assert answer(place, capsys, *words, "--iterations", 300, "--out", place.folder, "-q") == 3
    assert {file.name: file.read_bytes() for file in place.folder.iterdir()} == kept


def is_sealed(data: bytes) -> bool:
    """Whether it can be read and holds the right hash of itself, by plain json."""
    from aomc_sky.outputs.manifest import hash_matches

    try:
        manifest = json.loads(data.decode("utf-8"), parse_constant=lambda _: 1 / 0)
    except (ValueError, RecursionError, ZeroDivisionError):
        return False
    text = data.decode("utf-8", "replace")
    twice = text.count('"files"') > 1 or text.count('"plan.npz"') > 1 or "1e999" in text or "[" * 33 in text
    return isinstance(manifest, dict) and hash_matches(manifest) and not twice


@pytest.mark.parametrize("odd", ODD, ids=lambda odd: odd.name)
@pytest.mark.parametrize("name", [pytest.param(n, id=row_id(45, f"odd-{n}")) for n in RUN_FILES])
def test_what_is_no_file_of_a_run(name, odd, good_run, tmp_path, capsys):
    """Links, pipes and folders under names of ours are refused by every command, forced or not."""
    place = place_of(good_run, tmp_path)
    odd.make(place.folder / name, place.outside)
    place.settle()
    assert looks(place, capsys) == {3}
    for more in ((), ("--force",), ("--shard", "1/3"), ("--shard", "1/3", "--force")):
        words = ["run", place.scene, "--iterations", 300, "--out", place.folder, "-q", *more]
        assert answer(place, capsys, *words) == 3, more
    assert answer(place, capsys, "merge", place.folder, "--remove-shards") == 3


SHARD_WAYS = ("verify", "merge", "merge --remove-shards")
SHARD_FEW = [*[*NAMES, *ANY_MANIFEST][::3], *SHARD_MANIFEST]
"""What runs have in common with shards is read by the same rules: the tests above have all of it."""


@pytest.mark.parametrize(("name", "ways"), in_turn(SHARD_CHANGES, "shard", SHARD_WAYS, SHARD_FEW))
def test_a_crafted_manifest_of_a_shard(name, ways, good_shards, tmp_path, capsys):
    place, data = with_manifest(good_shards, tmp_path, name, shard=1)
    kept = {path.name: path.read_bytes() for path in place.folder.iterdir()}
    is_forged = is_sealed(data) and name not in ("index-2", "count-4")  # these two a person may have copied there
    refused = 3 if is_forged else 1  # damage is named as that of any other shard
    for way in ways:
        name, *options = way.split()
        wanted = 3 if name == "verify" else refused
        assert answer(place, capsys, name, place.folder, "-q", *options) == wanted, way
    assert {path.name: path.read_bytes() for path in place.folder.iterdir()} == kept
    words = [*shard_words(place.scene, place.folder, 1), "--iterations", 300]
    assert answer(place, capsys, *words) == (3 if is_forged else 0)


@pytest.mark.parametrize("name", some(SHARD_CHANGES, "shard-replaced"))
def test_a_crafted_manifest_of_a_shard_is_replaced(name, good_shards, tmp_path, capsys):
    place, _ = with_manifest(good_shards, tmp_path, name, shard=1)
    assert answer(place, capsys, *shard_words(place.scene, place.folder, 1), "--iterations", 300, "--force") == 0
    assert answer(place, capsys, "merge", place.folder, "-q", "--remove-shards") == 0
    assert answer(place, capsys, "verify", place.folder, "-q") == 0


@pytest.mark.parametrize("odd", ODD, ids=lambda odd: odd.name)
@pytest.mark.parametrize(
    "name",
    [pytest.param(n, id=row_id(45, f"odd-{n}")) for n in ("manifest.k1-of-3.json", "photons-0001.k2-of-3.npy")],
)
def test_what_is_no_file_of_a_shard(name, odd, good_shards, tmp_path, capsys):
    place = place_of(good_shards, tmp_path)
    odd.make(place.folder / name, place.outside)
    place.settle()
    assert answer(place, capsys, "verify", place.folder, "-q") == 3
    assert answer(place, capsys, "merge", place.folder, "-q", "--remove-shards") == 3
    words = [*shard_words(place.scene, place.folder, 1), "--iterations", 300]
    assert answer(place, capsys, *words) == 3
    assert answer(place, capsys, *words, "--force") == 3


@pytest.mark.parametrize("name", [pytest.param(n, id=row_id(45, f"hard-link-{n}")) for n in ("part", "lock")])
def test_a_file_that_is_changed_in_its_place_has_one_name(name, good_run, tmp_path, capsys):
    """A hard link under the name of such a file would carry the change outside; no look at the link could tell."""
    place = place_of(good_run, tmp_path)
    folder, source = RunFolder(place.folder), PhotonSource.from_plan(Plan.load(place.folder / "plan.npz"))
    parts = NpyParts(source)
    if name == "part":
        layout = parts.layouts((0,))[0]
        (place.outside / "victim").write_bytes(layout.head.ljust(layout.size, b"v"))
        (place.folder / "photons-0001.npy.part").hardlink_to(place.outside / "victim")
        place.settle()
        with pytest.raises(OutputError, match="hard link"), parts.filling(folder, 0) as put:
            put(0, [memoryview(bytes(12))])
        parts.reserve(folder, 0)
        with parts.filling(folder, 0) as put:
            put(0, [memoryview(bytes(12))])
    else:
        (place.folder / ".aomc-sky.lock").hardlink_to(place.outside / "victim")
        place.settle()
        assert command("run", place.scene, "--iterations", 300, "--out", place.folder, "-q") == 6
        assert "it is no regular file, or it has a second name (a hard link)" in capsys.readouterr().err
    place.check()
