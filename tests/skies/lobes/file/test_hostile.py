"""Background-sky files that somebody broke or made to do harm: an error each, soon, and no other file is opened."""

import operator
import os
import zlib

import numpy as np
import pytest

from aomc_sky.errors import InputFileError, InputWarning
from aomc_sky.skies.lobes.file.file import read_background_file
from tests.support.background import plain_file
from tests.support.limits import answers_within_limits

h5py = pytest.importorskip("h5py")
SECRET = 123.0
READERS = """
from aomc_sky.skies.lobes.file.file import read_background_file
readers = (read_background_file,)
"""


def refused(path):
    with pytest.raises(InputFileError) as error:
        read_background_file(path)
    return [p.code for p in error.value.problems]


def changed(tmp_path, change, **options):
    """A good file, then changed through the open file; beside it a file with numbers that must not be read."""
    with h5py.File(tmp_path / "secret.h5", "w") as file:
        file["curves"] = np.full((2, 3), SECRET, "f4")
    return plain_file(tmp_path / "x.h5", change=change, **options)


def replaced(name, value):
    def change(file):
        del file[name]
        file[name] = value

    return change


def created(name, *shape, **options):
    def change(file):
        del file[name]
        file.create_dataset(name, *shape, **options)

    return change


@pytest.mark.parametrize("name", ["SpectralSamples", "LobeAnims/a/Lobes", "LobeAnims/a", "Info/Name"])
def test_links_and_second_names_are_refused(name, tmp_path):
    external, soft = h5py.ExternalLink("secret.h5", "/curves"), h5py.SoftLink("/SpectralCurves")
    for target in (external, soft):
        assert "E502" in refused(changed(tmp_path, replaced(name, target)))
    two_names = changed(tmp_path, lambda file: operator.setitem(file, "LobeAnims/b", file["LobeAnims/a"]))
    assert refused(two_names) == ["E502"]


def test_texts_and_numbers_of_another_kind(tmp_path):
    for odd in ("one", np.array([1, 1]), 1.5):
        assert refused(changed(tmp_path, replaced("Info/FormatVersion", odd))) == ["E505"]
    assert len(read_background_file(changed(tmp_path, replaced("Info/Name", ["a" * 10**6]))).info.name) == 65_536

    def change(file):
        del file["Info/Author"], file["Info/FileType"]
        file.create_group("Info/Author")
        file["Info/FileType"] = "7"

    with pytest.warns(InputWarning, match=r"warning\[E505\]: /Info/Author: expected one text; '' is used") as caught:
        file = read_background_file(changed(tmp_path, change))
    assert len(caught) == 1
    assert file.info.file_type == 7
    for odd in ("seven", [1, 2], 0.5, np.nan):
        with pytest.warns(InputWarning, match=r"/Info/FileType: expected one whole number; 5 is used"):
            assert read_background_file(changed(tmp_path, replaced("Info/FileType", odd))).info.file_type == 5


LISTS = np.empty(2, object)
LISTS[:] = [np.arange(3.0)] * 2
INFORMING = {
    # name: (what /Info/Author is, what is read, whether that is reported)
    "a scalar": ({"data": "Ada"}, "Ada", False),
    "no text at all": ({"data": h5py.Empty("S5")}, "", False),
    "numbers": ({"data": np.array([[0.5, 2], [3, 4]])}, "0.5, 2, 3, 4", False),
    "records": ({"data": np.zeros(2, [("a", "f4"), ("b", "i4")])}, "", True),
    "lists": ({"data": LISTS, "dtype": h5py.vlen_dtype("f4")}, "", True),
    "a million numbers": ({"data": np.zeros(10**6, "i1")}, "", True),
    "a long text of a fixed length": ({"data": np.array([b"a"], "S100000")}, "", True),
    "a thousand long texts": ({"data": ["a" * 1000] * 1000}, ", ".join(["a" * 1000] * 66)[:65_666], False),
}
#: More than HDF5 keeps in an attribute.
LARGE = ("a million numbers", "a long text of a fixed length", "a thousand long texts")


@pytest.mark.parametrize(
    ("name", "place"),
    [*((name, "datasets") for name in INFORMING), *((name, "attributes") for name in INFORMING if name not in LARGE)],
)
def test_what_only_informs_is_no_reason_to_refuse_a_file(name, place, tmp_path, recwarn):
    member, text, is_reported = INFORMING[name]

    def change(file):
        if place == "datasets":
            created("Info/Author", **member)(file)
        else:
            file.attrs.create("Author", **member)

    file = read_background_file(changed(tmp_path, change, info=place))
    assert len(file.animations) == 1
    assert file.info.author[:65_000] == text[:65_000]
    assert file.info.name == "sky"
    warned = [str(w.message) for w in recwarn if "Author" in str(w.message)]
    assert len(warned) == is_reported
    assert all("warning[E505]" in message for message in warned)


def test_limits_hold_for_what_only_informs(tmp_path):
    def bomb(file):
        del file["Info/Author"]
        data = file.create_dataset("Info/Author", (6,), "S4", chunks=(6,), compression="gzip")
        data.id.write_direct_chunk((0,), zlib.compress(bytes(2**26)))

    sparse = created("Info/Author", shape=(10**12,), dtype="S16", chunks=(10**6,))
    elsewhere = created("Info/Author", shape=(2,), dtype="S4", external=[("secret.h5", 0, 8)])
    assert refused(changed(tmp_path, sparse)) == ["E503"]
    assert refused(changed(tmp_path, bomb)) == ["E503"]
    assert refused(changed(tmp_path, elsewhere)) == ["E502"]


def test_what_is_no_file_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe.h5")
    assert refused(tmp_path / "pipe.h5") == refused("/dev/zero") == refused(tmp_path) == ["E500"]
    with open(tmp_path / "large.h5", "wb") as file:
        file.truncate(2**40)
    assert refused(tmp_path / "large.h5") == ["E503"]

    def change(file):
        group = file["LobeAnims/a"]
        for k in range(3000):
            file["LobeAnims"][f"b{k}"] = h5py.SoftLink("/x" if k % 2 else "/")
            group[f"copy{k}"] = group["Lobes"]

    assert set(refused(changed(tmp_path, change))) == {"E502"}


STORAGES = (
    {},
    {"libver": "latest"},
    {"chunks": True, "compression": "gzip", "shuffle": True, "fletcher32": True},
    {"libver": "latest", "chunks": True, "compression": "gzip", "maxshape": None},
)


def flipped(data, generator):
    """Three bytes changed, among those that are not zero or stand beside such: the rest is mostly unused.

    Not in the heap of texts: with a length of 0 there the HDF5 library (2.0) never ends.
    """
    array = np.frombuffer(data, np.uint8).copy()
    is_used = (array != 0) | (np.roll(array, 1) != 0)
    heap = data.index(b"GCOL")
    is_used[heap : heap + int.from_bytes(data[heap + 8 : heap + 16], "little")] = False
    places = generator.choice(np.flatnonzero(is_used), 3)
    array[places] = generator.choice([0, 1, 127, 255, *generator.integers(0, 256, 4)], 3)
    return array.tobytes()


def damaged_files(folder, n, seed):
    """Files with changed bytes; the library writes the time into them, so they are others every time."""
    generator = np.random.default_rng(seed)
    paths = []
    for k in range(n):
        if k < len(STORAGES):
            plain_file(folder / f"good{k}.h5", **STORAGES[k])
        path = folder / f"{k}.h5"
        path.write_bytes(flipped((folder / f"good{k % len(STORAGES)}.h5").read_bytes(), generator))
        paths.append(str(path))
    return paths


def test_changed_bytes_are_an_error_or_harmless(tmp_path):
    changed = {path: answers_within_limits(READERS, path)[0] for path in damaged_files(tmp_path, 24, 1)}
    assert set(changed.values()) <= {"read", *(f"E50{k}" for k in range(1, 10))}
    assert set(changed.values()) != {"read"}
    for k in range(len(STORAGES)):
        assert answers_within_limits(READERS, tmp_path / f"good{k}.h5") == ["read"]
