"""Row 45 of the matrix: run folders that somebody prepared open, write and remove nothing outside."""

import json
import os
import shutil
import signal
import sys
from pathlib import Path

import pytest

from tests.support.fault_rows import command, row, row_id
from tests.support.limits import MOST_CPU_S
from tests.support.scenes import run_bytes

RUN_FILES = ("plan.npz", "manifest.json", "counts.csv", "photons-0001.npy")
OPENED: list[str] = []
"""Paths that this process opened since the list was emptied; the hook can never be taken away again."""


def _note(event, arguments):
    if event == "open" and isinstance(arguments[0], (str, bytes)):
        OPENED.append(arguments[0] if isinstance(arguments[0], str) else arguments[0].decode("utf-8", "replace"))


sys.addaudithook(_note)


@pytest.fixture
def folder(small_run, tmp_path):
    """A copy of a good folder, with a victim at ``../outside/victim``; a command that waits for a pipe fails."""
    (tmp_path / "outside").mkdir()
    (tmp_path / "outside" / "victim").write_text("victim")
    before = victim(tmp_path)

    def stop(*_):
        raise TimeoutError("the command waits")

    handler = signal.signal(signal.SIGALRM, stop)
    signal.alarm(10 * int(MOST_CPU_S))
    OPENED.clear()
    try:
        yield Path(shutil.copytree(small_run, tmp_path / "out"))
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, handler)
    assert [path for path in OPENED if "outside" in path] == []
    assert victim(tmp_path) == before


def victim(folder):
    path = folder / "outside" / "victim"
    return path.read_text(), path.stat().st_mtime_ns, path.stat().st_nlink, sorted(os.listdir(path.parent))


def codes(folder, capsys):
    """Exit codes of all commands that take a run folder; none ends in a traceback."""
    out = folder.parent
    words = {
        "info": (folder, "--json"),
        "verify": (folder, "-q"),
        "export": (folder, "--to", "csv", "--out", out / "made", "-q"),
        "plot": (folder, "--size", 300, "--out", out / "made.png", "-q"),
    }
    found = {name: command(name, *more) for name, more in words.items()}
    said = capsys.readouterr()
    assert "Traceback" not in said.out + said.err
    return found


NAMES = ("../outside/victim", "{outside}/victim", "photons-0001.npy/../../outside/victim", "link", "/etc/hostname")


@pytest.mark.parametrize("name", [pytest.param(n, id=row_id(45, f"name-{k}")) for k, n in enumerate(NAMES)])
def test_a_manifest_that_names_other_files(name, folder, capsys):
    named = name.format(outside=folder.parent / "outside")
    (folder / "link").symlink_to("../outside/victim")
    manifest = json.loads((folder / "manifest.json").read_text())
    manifest["files"] = {named: {"bytes": 6}} | manifest["files"]
    manifest["inputs"]["amc"]["name"] = named
    manifest["run"] = {"scene": named}
    (folder / "manifest.json").write_text(json.dumps(manifest))
    found = codes(folder, capsys)
    assert found["verify"] == 1
    assert command("run", folder, "--out", folder, "-q") != 0  # a run folder is no scene
    scene = folder.parent / "scene"
    assert command("export", folder, "--to", "aomc", "--out", scene, "-q") == 0
    assert not (scene / "amc.inp").exists()


@pytest.mark.parametrize("odd", ["link", "folder", "fifo", "hard link"])
@pytest.mark.parametrize("name", [pytest.param(n, id=row_id(45, f"odd-{n}")) for n in RUN_FILES])
def test_what_is_no_file_of_a_run(name, odd, small_run, folder, capsys):
    """A link to a file that has the right bytes is none either."""
    path = folder / name
    same = path.rename(folder.parent / "same")
    if odd == "link":
        path.symlink_to(same)
    elif odd == "folder":
        path.mkdir()
    elif odd == "fifo":
        os.mkfifo(path)
    else:
        path.write_bytes(b"of another name")
        os.link(path, folder.parent / "second name")
    found = codes(folder, capsys)
    assert found["verify"] in (1, 3, 5), found
    again = command("run", small_run.parent, "--iterations", 1000, "--out", folder, "-q")
    if name == "plan.npz":
        assert again in (2, 5)
    elif odd == "folder":
        assert again == 6
    else:
        assert again == 0
        assert run_bytes(folder) == run_bytes(small_run)
    if odd == "hard link":
        assert (folder.parent / "second name").read_bytes() == b"of another name"


@row(45, "part-photons-0001.npy.part")
def test_a_shard_writes_through_no_link(fault, small_run, folder, told):
    for path in folder.iterdir():
        if path.name != "plan.npz":
            path.unlink()
    (folder / fault.removeprefix("part-")).symlink_to("../outside/victim")
    words = ("run", small_run.parent, "--iterations", 1000, "--out", folder, "-q", "--shard", "1/1")
    assert fault.removeprefix("part-") in told(*words, code=6).err


@row(45, "a-link-to-the-run-folder")
def test_a_run_folder_behind_a_link_is_the_users_own_way(fault, small_run, tmp_path):
    (tmp_path / "way").symlink_to(small_run)
    assert command("verify", tmp_path / "way", "-q") == 0
