"""Row 54: what killed writers leave goes with the next call, no file of others is written through a second name."""

import contextlib
import os
import subprocess
import sys

import pytest

import aomc_sky as sky
from aomc_sky import system
from aomc_sky.system import appearing, prepare_target
from tests.support.fault_rows import command, row
from tests.support.processes import UNFINISHED

WRITER = """
import sys, time
from pathlib import Path
from aomc_sky import system
from aomc_sky.system import appearing
with appearing(Path(sys.argv[1])) as file:
    file.write(b"x" * 1000)
    file.flush()
    print("under way", flush=True)
    time.sleep(100)
"""


@contextlib.contextmanager
def writing(target):
    """A process that is about to write a file, and does not end before the block."""
    with subprocess.Popen([sys.executable, "-c", WRITER, str(target)], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "under way\n"
        try:
            yield process
        finally:
            process.kill()


def unfinished(folder):
    return sorted(path.name for path in folder.iterdir() if UNFINISHED.fullmatch(path.name))


@row(54, "export-mcpl", "export-netcdf", "write_mcpl")
def test_what_a_killed_writer_left_goes_with_the_next_call(fault, small_run, tmp_path):
    """And what another process still writes stays, as do files of other names."""
    name = "photons.mcpl" if "mcpl" in fault else "sky.nc"
    if name == "sky.nc":
        pytest.importorskip("h5netcdf")
    target = tmp_path / name
    for path in (target, tmp_path / "other.mcpl"):
        with writing(path):
            pass
    with writing(target):
        assert len(unfinished(tmp_path)) == 3
        if fault.startswith("export"):
            to = "mcpl" if "mcpl" in fault else "netcdf"
            assert command("export", small_run, "--to", to, "--out", target, "-q") == 0
        else:
            source = sky.Scene(wavebands=[550.0], n_photons=100, components="uniform").source()
            sky.write_mcpl(source, target)
        left = unfinished(tmp_path)
        assert len(left) == 2
        assert [sum(name in one for one in left) for name in (target.name, "other.mcpl")] == [1, 1]
        assert target.stat().st_size > 1000


@row(54, "taken-for-a-leftover")
def test_a_file_that_is_taken_for_a_leftover_is_begun_again(fault, tmp_path, monkeypatch):
    """Another process looks for leftovers between the two calls that make a file and lock it."""
    lock, target, n = system._lock, tmp_path / "whole.bin", []

    def late(handle):
        n.append(handle)
        if len(n) == 1:
            prepare_target(target)
        return lock(handle)

    monkeypatch.setattr(system, "_lock", late)
    with appearing(target) as file:
        file.write(b"whole")
    assert len(n) == 3  # the first file, as a leftover, the second file
    assert target.read_bytes() == b"whole"
    assert len(list(tmp_path.iterdir())) == 1


@row(54, "an-error-on-the-way")
def test_a_file_appears_whole_or_not_at_all(fault, tmp_path):
    target = tmp_path / "whole.bin"
    with pytest.raises(TypeError), appearing(target) as file:
        file.write(b"half" + None)
    assert list(tmp_path.iterdir()) == []
    with appearing(target) as file:
        file.write(b"whole")
        assert len(unfinished(tmp_path)) == 1
        assert not target.exists()
        prepare_target(target)  # of this process, under way
        assert len(unfinished(tmp_path)) == 1
    assert target.read_bytes() == b"whole"
    assert len(list(tmp_path.iterdir())) == 1


@row(54, "pipe", "link", "link-to-nothing")
def test_an_export_replaces_no_pipe_and_no_link(fault, small_run, tmp_path, told):
    target = tmp_path / "photons.mcpl"
    if fault == "pipe":
        os.mkfifo(target)
    else:
        target.symlink_to("victim")
    if fault == "link":
        (tmp_path / "victim").write_text("of another program")
    before = os.lstat(target)[:7]  # what follows are times; to read a link changes one
    words = ("export", small_run, "--to", "mcpl", "--out", target, "-q")
    assert f"{target} is a " in told(*words, code=5 if fault == "link" else 2).err
    assert os.lstat(target)[:7] == before
    if fault == "pipe":
        source = sky.Scene(wavebands=[550.0], n_photons=100, components="uniform").source()
        with pytest.raises(sky.errors.OutputError, match="this is a device or a pipe"):
            sky.write_mcpl(source, target)
        with pytest.raises(sky.errors.OutputError, match="no file can have this name"):
            sky.write_mcpl(source, tmp_path / "a\0b")
        assert os.lstat(target)[:7] == before


@row(54, "hard-link-photons-0001.npy.part", "hard-link-.aomc-sky.lock")
def test_no_file_with_a_second_name_is_written(fault, small_run, tmp_path, told):
    """A file of a run that is another name of a file elsewhere: it keeps its bytes, and the command says why."""
    out, victim = tmp_path / "out", tmp_path / "victim"
    amc = small_run.parent / "amc.inp"
    words = ("run", amc, "--iterations", "140000", "--waveband", "1", "-q", "--out", out)
    assert command(*words, "--shard", "1/2") == 0
    name = fault.removeprefix("hard-link-")
    victim.write_bytes((out / name).read_bytes() if (out / name).exists() else b"of another program")
    before = victim.read_bytes()
    (out / name).unlink(missing_ok=True)
    os.link(victim, out / name)
    said = told(*words, "--shard", "2/2", code=6).err
    assert f"{name}: this is a hard link to another file" in said
    assert victim.read_bytes() == before
